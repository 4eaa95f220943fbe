"""Periods against golden numbers, elliptic integrals and 32 digits of mpmath, up to the edge.

The 32 digits integrate T = 4 ∫ √(M/(2(V(A) − V(ϑ)))) dϑ in x, ϑ = A (1 − x²), with lever arm and
lift written out, against the cancellation in V(A) − V(ϑ) near the turning point. Nodes and weights
are doubles: the reference is accurate to about 3e-16, and the tolerance is the stated 1e-14.
"""

import math
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from golden_numbers import entries, numbers
from mpmath import mpf
from numpy.polynomial import Polynomial

from tauto_core.curves import CircularArc, Hole, Involute, Table, TableLever
from tauto_core.curves.numerics import integrate
from tauto_core.machines import Machine, QuadratureError, SlackThreadError, rate_s_per_day
from tauto_core.scene.errors import CamRangeError


def machine(
    cam, inertia=4e-4, *, force=0.0, mass=0.0, stiffness=0.0, massless=False, gravity=9.81
):
    carried = 0.0 if massless else mass
    return Machine(inertia, carried, mass, force, stiffness, gravity, cam, False, None, None, 0.1)


def spline_cam(coefficients, top, pieces=4):
    """The odd polynomial Σ c_j ϑ^j as a table of several pieces."""
    law, knots = Polynomial(coefficients), np.linspace(0.0, top, pieces + 1)
    taylor = [[law.deriv(j)(k) / math.factorial(j) for j in range(6)] for k in knots[:-1]]
    return Table('law', TableLever(knots, np.array(taylor), law.integ()(knots[:-1])))


@pytest.mark.parametrize('entry', entries('A20-weight-inertia'))
def test_weight_with_inertia(entry):
    given, expected = numbers(entry)
    inertia = given['disc_radius'] ** 2 / 2
    regulator = machine(Involute(given['r']), inertia, mass=given['P_over_Q'], gravity=given['g'])
    period = regulator.period(given['A'])
    # golden holds 1e-13 relative, and absolute for the excess, a difference
    assert regulator.small_period == pytest.approx(expected['T0_s'], rel=1e-14, abs=0.0)
    assert period == pytest.approx(expected['T_s'], rel=1e-14, abs=0.0)
    ratio = period / regulator.small_period
    assert ratio - 1 == pytest.approx(expected['excess'], abs=1e-14 * ratio)
    assert ratio == pytest.approx(expected['T_over_T0'], rel=1e-14)
    loss = -rate_s_per_day(period, regulator.small_period)
    # a difference, as the excess
    assert loss == pytest.approx(expected['loss_s_per_day'], abs=86400 * 1e-14)


WELLS = {
    'arc, force': machine(CircularArc(0.02, 0.01), force=2.0),
    'arc, weight': machine(CircularArc(0.02, 0.01), mass=0.2),
    'arc, spring': machine(CircularArc(0.02, 0.01), force=2.0, stiffness=50.0),
    'table, weight': machine(spline_cam([0.0, 0.01, 0.0, 0.001, 0.0, -1e-4], 2.0), mass=0.4),
    'hole, spring and mass': Machine(
        4e-4, 0.3, 0.1, 1.0, 20.0, 9.81, Hole(0.01, 0.08), False, None, None, 0.1
    ),
}


@pytest.mark.parametrize('well', WELLS.values(), ids=WELLS.keys())
def test_small_swings_tend_to_the_small_period(well):
    # the kinked cheek departs by R A/d, the others by A²
    assert well.period(1e-9) == pytest.approx(well.small_period, rel=2e-9)
    assert well.period(0.0) == well.small_period
    assert well.period(-1.0) == well.period(1.0)


def test_up_to_the_edge():
    """The period is continuous at the edge of the cam, and refused beyond it."""
    for well in WELLS.values():
        edge = well.cam.range_rad
        near, at = well.period(edge - 1e-9), well.period(edge)
        assert at == pytest.approx(near, rel=1e-8)
        assert at != near
        with pytest.raises(CamRangeError, match='range'):
            well.period(edge + 1e-9)
    with pytest.raises(CamRangeError, match='nan'):
        machine(Involute(0.01), force=1.0).period(math.nan)


def bent_cam():
    """A lever arm of two straight pieces: the smoothness between knots is all that is asked."""
    rows = np.zeros((2, 6))
    rows[0, 1], rows[1, :2] = 0.01, (0.01, 0.02)
    return Table('bent', TableLever(np.array([0.0, 1.0, 2.0]), rows, np.array([0.0, 0.005])))


def test_period_across_a_joint():
    """Two harmonic pieces, joined at 1 rad with the speed ω₂√2."""
    regulator = machine(bent_cam(), force=2.0)
    inner, outer = (math.sqrt(2.0 * rate / 4e-4) for rate in (0.01, 0.02))
    quarter = math.acos(1 / 3) / outer + math.atan(inner / (outer * math.sqrt(2))) / inner
    assert regulator.period(2.0) == pytest.approx(4 * quarter, rel=1e-14)
    assert regulator.period(1.0) == pytest.approx(regulator.small_period, rel=1e-14)


def test_slack_thread():
    """A lever arm that falls steeply lets a heavy weight overtake its thread."""
    cam = spline_cam([0.0, 0.1, 0.0, -0.055, 0.0, 0.0078], 2.2)
    assert machine(cam, 1e-5, mass=1.0, massless=True).period(2.2) > 0.0
    assert machine(cam, 1e-5, mass=1.0).period(0.5) > 0.0
    with pytest.raises(SlackThreadError, match='slack at an angle'):
        machine(cam, 1e-5, mass=1.0).period(2.2)


PROMISED = 1e-14
NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)


def period_in_digits(well, arm, lift, amplitude, cuts=()):
    """Return T of a well [s], of a lever arm t and lift h as functions of mpf."""
    with mpmath.workdps(32):
        inertia, mass, stiffness = mpf(well.inertia), mpf(well.carried_mass), mpf(well.stiffness)
        pull = mpf(well.force) + mpf(well.pulling_mass) * mpf(well.gravity)
        top = mpf(amplitude)

        highest = lift(top)

        def integrand(x):
            angle = top * (1 - x * x)
            height = lift(angle)
            left = (highest - height) * (pull + stiffness * (highest + height) / 2)
            return x * mpmath.sqrt((inertia + mass * arm(angle) ** 2) / (2 * left))

        inner = [mpmath.sqrt(1 - mpf(cut) / top) for cut in cuts if cut < top]
        # towards ϑ = 0 the well may change within a millionth of the swing
        grades = [1 - mpf(2) ** -k for k in (1, 4, 8, 12, 16, 20, 24)]
        edges = sorted({mpf(0), mpf(1), *inner, *grades})
        total = mpf(0)
        for a, b in pairwise(edges):
            values = [integrand(a + (b - a) * (1 + mpf(x)) / 2) for x in NODES]
            total += (b - a) / 2 * mpmath.fdot(values, map(mpf, WEIGHTS))
        return 8 * top * total


def off(period, exact):
    """Return the relative error of a period."""
    return abs(float((mpf(period) - exact) / exact))


POWERS = {
    'force': {'force': 2.0},
    'weight': {'mass': 0.2},
    'weight and spring': {'mass': 0.2, 'stiffness': 50.0},
    'bare spring': {'force': 1e-3, 'stiffness': 1e4},
}


@pytest.mark.parametrize('share', [0.3, 1.0])
@pytest.mark.parametrize('power', POWERS.values(), ids=POWERS.keys())
@pytest.mark.parametrize('radius_depth', [(0.02, 1e-4), (1e-3, 0.05)])
def test_circular_arc(radius_depth, power, share):
    """The lever arm of the third arc falls to a twenty-fifth of its largest value at the edge."""
    cam = CircularArc(*radius_depth)
    well, amplitude = machine(cam, **power), share * cam.range_rad
    radius, depth = map(mpf, radius_depth)

    def arm(angle):
        return depth * mpmath.sin(angle) + radius * (1 - mpmath.cos(angle))

    def lift(angle):
        return depth * (1 - mpmath.cos(angle)) + radius * (angle - mpmath.sin(angle))

    exact = period_in_digits(well, arm, lift, amplitude)
    assert off(well.period(amplitude), exact) < PROMISED


@pytest.mark.parametrize('share', [1e-9, 0.3, 1.0])
@pytest.mark.parametrize('stiffness', [50.0, 1e7])
def test_stiff_spring_on_a_linear_arm(stiffness, share):
    """Duffing's oscillator, T = 4 K(m)/√(α + βA²), nearly a pure quartic at the edge."""
    cam = Hole(0.01, 0.08)
    well, amplitude = machine(cam, force=1e-3, stiffness=stiffness), share * cam.range_rad
    with mpmath.workdps(32):
        alpha = mpf(1e-3) * mpf(0.01) / mpf(4e-4)
        beta = mpf(stiffness) * (mpf(0.01) * mpf(amplitude)) ** 2 / (2 * mpf(4e-4))
        modulus = beta / (2 * (alpha + beta))
        exact = 4 * mpmath.ellipk(modulus) / mpmath.sqrt(alpha + beta)
    assert off(well.period(amplitude), exact) < PROMISED


# lever arms Σ c_j ϑ^j: bending, falling to a tenth of its highest, nearly flat in the middle
LAWS = {
    'bending': ([0.0, 0.01, 0.0, 0.001, 0.0, -1e-4], 2.0),
    'falling': ([0.0, 0.1, 0.0, -0.055, 0.0, 0.0078], 2.2),
    'flat': ([0.0, 1e-5, 0.0, 0.01], 3.0),
}


@pytest.mark.parametrize('share', [0.6, 1.0])
@pytest.mark.parametrize('power', ['weight', 'bare spring'])
@pytest.mark.parametrize('law', LAWS.values(), ids=LAWS.keys())
def test_table(law, power, share):
    coefficients, edge = law
    powers = POWERS[power] if power != 'weight' else {'mass': 1e-3}
    well, amplitude = machine(spline_cam(*law), **powers), share * edge
    arms = list(map(mpf, coefficients))

    def arm(angle):
        return sum(c * angle**k for k, c in enumerate(arms))

    def lift(angle):
        return sum(c * angle ** (k + 1) / (k + 1) for k, c in enumerate(arms))

    cuts = well.cam.law.knots[1:-1].tolist()
    exact = period_in_digits(well, arm, lift, amplitude, cuts=cuts)
    assert off(well.period(amplitude), exact) < PROMISED


def test_integrals_of_thin_layers():
    """∫ 1/(δ² + x²) from 0 to 1 is atan(1/δ)/δ, whatever integrals are computed with it."""
    for delta in (1e-3, 1e-6, 1e-9):

        def layer(x, width=delta):
            return 1 / (width * width + x * x)

        alone = integrate(layer, np.zeros(1), np.ones(1))
        np.testing.assert_allclose(alone, math.atan(1 / delta) / delta, rtol=2e-15)
        three = integrate(layer, np.array([0.5, 0.0, 0.2]), np.ones(3))
        assert three[1] == alone[0]


@pytest.mark.parametrize(
    'rough',
    [
        lambda x: 1 / np.abs(x - 1 / 3),
        lambda x: np.full_like(x, np.nan),
        lambda x: np.sin(1e9 * x * x),
    ],
    ids=['pole', 'nan', 'noise'],
)
def test_integrals_that_do_not_settle_are_refused(rough):
    with pytest.raises(QuadratureError, match='does not settle'):
        integrate(rough, np.array([0.0, 0.0]), np.array([1.0, 0.5]))
