"""The order of every quadrature: the rule of its panels, against closed forms and mpmath.

Gauss's rule of n nodes has order 2n in the width of a panel. For a function that is analytic
beyond its ends it is spectral in n: twice the nodes give about twice the digits, down to rounding.
That holds only because each substitution removes a root or a turning point; if one is left, the
order is that of the root, and these tests fail.
"""

import importlib
import math

import mpmath
import numpy as np
import pytest

from tauto_core.curves import Cycloid, FluidTautochrone, Involute, numerics
from tauto_core.curves.cams import lever_corrected
from tauto_core.curves.cams import synthesised as synthesis
from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
from tauto_core.curves.fluid import Mirrored
from tauto_core.curves.lever_geometry import LeverGeometry
from tauto_core.machines import LeverMachine, Machine, axle_pendulum, fluid_pendulum, trochlea
from tauto_core.machines.axle_pendulum import AxlePendulum
from tauto_core.machines.fluid_pendulum import duration_excess
from tauto_core.machines.threads import lever

outline = importlib.import_module('tauto_core.curves.fluid')

ROUNDING = 2e-14
"""Rounding error of sums of about sixty terms, and of the terms."""


def spectral(errors):
    """Whether errors at n, 2n, 4n … nodes gain four tenths as many digits at each doubling."""
    last = errors[0]
    for error in errors[1:]:
        if error > max(last**1.4, ROUNDING):
            return False
        last = max(error, ROUNDING)
    return errors[0] > 100 * ROUNDING and errors[-1] <= ROUNDING


def fixed(nodes):
    """Return an `integrate` of one panel of Gauss's rule, with nothing halved."""
    roots, weights = np.polynomial.legendre.leggauss(nodes)

    def integrate(function, lower, upper):
        half = 0.5 * (upper - lower)[:, None]
        values = function(lower[:, None] + half * (1.0 + roots))
        return (half * values) @ weights

    return integrate


NODES = 24
LEFT_OUT = math.factorial(NODES) ** 4 / ((2 * NODES + 1) * math.factorial(2 * NODES) ** 2)
"""∫ x⁴⁸ over an interval of length 1, less the rule's sum."""


def test_a_panel_is_of_order_48():
    """∫ cos x over widths w about 0: the rule errs by w⁴⁸ LEFT_OUT/48!, by the width.

    What follows has the same sign and takes e^{−w²/792}: the derivative's mean over the kernel.
    """
    width = np.array([44.0, 45.0, 46.0, 48.0, 50.0])
    exact = 2.0 * np.sin(0.5 * width)
    errors = (exact - numerics.gauss_sums(np.cos, -0.5 * width, width)) / width
    expected = LEFT_OUT / math.factorial(48) * width**48 * np.exp(-(width**2) / 792.0)
    np.testing.assert_allclose(errors, expected, rtol=0.1)
    assert np.all(errors > 1e-12)
    order = np.diff(np.log(errors)) / np.diff(np.log(width))
    np.testing.assert_allclose(order, 48.0 - width[1:] ** 2 / 396.0, atol=1.0)


INERTIA, MASS, GRAVITY = 4e-4, 0.05, 9.81
TORQUE, TURNED = MASS * GRAVITY * 0.15, MASS * 0.15**2


def machine_of(cam):
    return Machine(INERTIA, MASS, MASS, 0.0, 0.0, GRAVITY, cam, True, None, None, 1.0)


def synthesised():
    """ϑ at nine tenths of the arc, of the weight's own cam: closed form of the cycloid."""
    frequency = math.pi
    rate = INERTIA * frequency**2 / (MASS * GRAVITY)
    train = synthesis.PowerTrain(
        pull=lambda y: np.full_like(y, MASS * GRAVITY),
        place=lambda v: v / (MASS * GRAVITY),
        mass=lambda y: np.full_like(y, MASS),
    )
    made = synthesis.synthesise(INERTIA, frequency, train)
    chi = math.asin(0.9)
    arc = 0.9 * GRAVITY * math.sqrt(MASS) / frequency**2
    exact = 0.5 * math.sqrt(INERTIA / MASS) * (chi + math.sin(chi) * math.cos(chi)) / rate
    return lambda: float(made.angle(np.array([arc]))[0]), exact


def heavy_lever():
    """θ = ∫ √(W cos²β − 2Jω² sin β) … dτ by mpmath."""
    cam = CorrectedLeverGeometry(INERTIA, 3.0, TORQUE, TURNED, 0.1, 0.3)

    def rate(tau):
        sine, cosine = 2 * tau**2 / (1 + tau**4), (1 - tau**4) / (1 + tau**4)
        left = TORQUE * cosine**2 - 18 * TURNED * sine
        return 2 * mpmath.sqrt(left / (INERTIA * (1 + tau**4))) / 3

    with mpmath.workdps(30):
        exact = float(mpmath.quad(rate, [0, 0.3, 0.6]))
    return lambda: float(cam.theta(np.array([0.6]))[0]), exact


def weight_on_the_involute():
    """T/T₀ = (2/π) E(−ε), ε = m b²A²/I."""
    machine, amplitude = machine_of(Involute(0.02)), 12.0
    epsilon = MASS * 0.02**2 * amplitude**2 / INERTIA
    exact = float(mpmath.ellipe(-epsilon)) * 2.0 / math.pi * machine.small_period
    return lambda: machine.period(amplitude), exact


SULLY = LeverMachine(
    INERTIA, MASS, 0.15, 0.0, LeverGeometry(0.02, 0.1, 0.3), GRAVITY, None, None, 1.0
)


def period_of_a_lever():
    """No closed form: ten times the nodes, and the golden period of 50 digits besides."""
    integrate = fixed(320)
    edges = np.array([0.0, 0.5 * math.pi, math.pi])
    halves = integrate(lambda w: SULLY.swing(1.5, w)[1], edges[:-1], edges[1:])
    return lambda: SULLY.period(1.5), 2.0 * float(np.sum(halves))


def descent_of_a_globe():
    """(π/2) √(f/g) from anywhere, the cusp itself included."""
    curve = FluidTautochrone(0.4, 0.9, 1.0)
    exact = 0.5 * math.pi * math.sqrt(curve.pendulum_length / GRAVITY)
    return lambda: fluid_pendulum.descent_time(curve, GRAVITY, curve.descent_cusp), exact


def swing_on_a_plane():
    """T = 4 ∫ √((k² + c² sin²φ)/(2gc (cos φ − cos A))) dφ by mpmath, its root's end and all."""
    body, amplitude = AxlePendulum(0.0, 0.3, 0.15, GRAVITY), 1.0

    def slowness(phi):
        fall = 2 * GRAVITY * 0.3 * (mpmath.cos(phi) - mpmath.cos(amplitude))
        return mpmath.sqrt((0.15**2 + 0.3**2 * mpmath.sin(phi) ** 2) / fall)

    with mpmath.workdps(40):
        exact = 4 * float(mpmath.quad(slowness, [0, mpmath.mpf(amplitude)]))
    return lambda: axle_pendulum.plane_period(body, amplitude), exact


@pytest.mark.parametrize(
    ('module', 'case'),
    [
        (synthesis, synthesised),
        (lever_corrected, heavy_lever),
        (trochlea, weight_on_the_involute),
        (lever, period_of_a_lever),
        (fluid_pendulum, descent_of_a_globe),
        (axle_pendulum, swing_on_a_plane),
    ],
)
def test_a_panel_converges_spectrally(module, case, monkeypatch):
    """One panel has 2 to 64 nodes; the adaptive panels are accurate to rounding."""
    value, exact = case()
    assert value() == pytest.approx(exact, rel=ROUNDING)
    errors = []
    for nodes in (2, 4, 8, 16, 32, 64):
        with monkeypatch.context() as patched:
            patched.setattr(module, 'integrate', fixed(nodes))
            errors.append(abs(value() / exact - 1.0))
    assert spectral(errors), errors


def test_a_root_left_in_is_not_spectral():
    """∫ √(1 − x²) dx, whose ends are of order 3: the test above can fail."""
    errors = []
    for nodes in (2, 4, 8, 16, 32, 64):
        found = fixed(nodes)(lambda x: np.sqrt(1 - x * x), np.zeros(1), np.ones(1))[0]
        errors.append(abs(found * 4.0 / math.pi - 1.0))
    assert not spectral(errors)
    assert errors[-2] / errors[-1] == pytest.approx(8.0, rel=0.1)


KAPPA = 0.8


def test_the_cosine_series_of_a_half_swing_is_spectral():
    """Backward on Euler's curve, where the duration is an elliptic integral."""
    curve, start = FluidTautochrone(KAPPA, 1.0, 1.0), 1.5
    end = fluid_pendulum.far_end(Mirrored(curve), start)
    exact = 1.0 + float(duration_excess(KAPPA, start))
    errors = []
    for nodes in (2, 4, 8, 16, 32, 64):
        grid = fluid_pendulum.Grid(nodes, 4)
        series = fluid_pendulum.cosines(Mirrored(curve), np.array([start]), np.array([end]), grid)
        errors.append(abs(series[0, 0] / exact - 1.0))
    assert spectral(errors), errors


def test_the_speed_within_a_half_swing_is_spectral(monkeypatch):
    """∫ e^{2κ(s−σ)} p dσ over one panel where five are asked for, κS = 16."""
    curve, start = FluidTautochrone(KAPPA, 1.0, 1e8), 20.0
    end = np.array([fluid_pendulum.far_end(Mirrored(curve), start)])
    exact = 1e4 * (1.0 + float(duration_excess(KAPPA, start)))
    errors = []
    for nodes in (4, 8, 16, 32, 64):
        rule = np.polynomial.legendre.leggauss(nodes)
        with monkeypatch.context() as patched:
            patched.setattr(numerics, 'gauss_rule', lambda rule=rule: rule)
            grid = fluid_pendulum.Grid(256, 1)
            series = fluid_pendulum.cosines(Mirrored(curve), np.array([start]), end, grid)
            errors.append(abs(series[0, 0] / exact - 1.0))
    assert spectral(errors), errors


@pytest.mark.parametrize('share', [0.5, 0.999])
def test_the_outline_of_a_curve_is_spectral(share, monkeypatch):
    """Of a cycloid ∫ √(1 − (s/f)²) ds is known; the substitution takes its cusp's root out."""
    curve = Cycloid(0.0, 1.0, 1.0)
    exact = 0.5 * (share * math.sqrt(1.0 - share * share) + math.asin(share))
    errors = []
    for nodes in (2, 4, 8, 16):
        rule = np.polynomial.legendre.leggauss(nodes)
        with monkeypatch.context() as patched:
            patched.setattr(numerics, 'gauss_rule', lambda rule=rule: rule)
            errors.append(abs(float(outline.abscissa(curve, share)) / exact - 1.0))
    assert spectral(errors), errors
