"""Half swings by quadrature, and the elliptic functions of the closed forms."""

import math

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tauto_core.curves import Cycloid, FluidTautochrone, SymmetricCurve
from tauto_core.curves.fluid import Mirrored
from tauto_core.machines import QuadratureError
from tauto_core.machines.fluid_pendulum import (
    duration_excess,
    end_arc,
    far_end,
    grid_for,
    half_swing,
    jacobi_amplitude,
    place,
    quarter_period,
    reverse_half_swing,
)
from tauto_core.scene.errors import DescentError


def to_and_fro(curve, start):
    """Excess of a swing to the other side and back from there, by the small swing's period."""
    there = half_swing(curve, 1.0, start)
    back = half_swing(Mirrored(curve), 1.0, there.arc)
    return (there.duration + back.duration) / math.tau - 1.0


@pytest.mark.parametrize(
    ('make', 'expected'),
    [
        (Cycloid, [6.330e-5, 1.318e-3, 4.371e-3, 1.308e-2]),
        (FluidTautochrone, [7.757e-5, 1.499e-3, 4.560e-3, 1.167e-2]),
        (SymmetricCurve, [-1.7e-8, -7.5e-6, -8.3e-5, -7.3e-4]),
    ],
)
def test_swings_to_and_fro_are_those_of_the_table(make, expected):
    """The table was integrated by another program, to the digits compared."""
    curve = make(1.0, 1.0, 1.0)
    found = [to_and_fro(curve, start) for start in (0.02, 0.1, 0.2, 0.4)]
    np.testing.assert_allclose(found, expected, rtol=3e-2 if make is SymmetricCurve else 5e-4)


@pytest.mark.parametrize('start', [1e-9, 0.1, 1.0, 4.0])
def test_quadrature_and_closed_form_agree_on_the_way_back(start):
    curve, omega = FluidTautochrone(1.0, 0.9, 5.0), math.sqrt(1.0 / 5.0)
    found = half_swing(Mirrored(curve), 1.0, start)
    ratio = found.duration * omega / math.pi
    assert ratio == pytest.approx(1.0 + float(duration_excess(1.0, start)), rel=2e-15)
    assert found.arc == pytest.approx(float(end_arc(1.0, start)), rel=2e-15)
    times = np.linspace(0.0, found.duration, 101)
    grid = grid_for(Mirrored(curve), start, found.arc)
    arc, rate = place(
        Mirrored(curve), 1.0, np.full(101, start), np.full(101, found.arc), times, grid
    )
    expected = reverse_half_swing(1.0, omega, np.full(101, start), times)
    np.testing.assert_allclose(arc, -expected[0], atol=2e-15 * start)
    np.testing.assert_allclose(rate, -expected[1], atol=5e-15 * start)


@pytest.mark.parametrize('make', [Cycloid, SymmetricCurve])
def test_half_swings_are_those_of_the_integrated_motion(make):
    curve, start = make(1.5, 0.9, 1.0), 0.6

    def law(_, y):
        return [y[1], -0.9 * float(curve.slope(y[0])) + 1.5 * y[1] ** 2]

    found = half_swing(curve, 1.0, start)
    times = np.linspace(0.0, found.duration, 31)
    expected = solve_ivp(
        law, (0.0, times[-1]), [start, 0.0], 'DOP853', times, rtol=1e-13, atol=1e-16
    ).y
    grid = grid_for(curve, start, found.arc)
    arc, rate = place(curve, 1.0, np.full(31, start), np.full(31, found.arc), times, grid)
    np.testing.assert_allclose(arc, expected[0], atol=1e-12)
    np.testing.assert_allclose(rate, expected[1], atol=1e-12)


@pytest.mark.parametrize('reduced', [5.0, 20.0, 60.0])
def test_a_descent_at_the_speed_of_balance(reduced):
    """On a cycloid, with X = 2κS₁: e^X (X − 1) = −(1 + 2κS) e^{−2κS}. The time is by DOP853."""
    curve = Cycloid(reduced, 1.0, 1.0)
    found = half_swing(curve, 1.0, 1.0)
    x = 2.0 * reduced * found.arc
    left = (1.0 + 2.0 * reduced) * math.exp(-2.0 * reduced)
    # the derivative of the left side at its end, X = 1, is e
    assert math.exp(x) * (x - 1.0) == pytest.approx(-left, abs=1e-14)

    def law(_, y):
        return [y[1], -y[0] + reduced * y[1] ** 2]

    def rest(_, y):
        return y[1]

    rest.terminal, rest.direction = True, 1.0
    run = solve_ivp(law, (0.0, 50.0), [1.0, 0.0], 'DOP853', events=rest, rtol=1e-12, atol=1e-15)
    assert found.duration == pytest.approx(run.t[-1], rel=1e-10)


def test_what_a_half_swing_cannot_do_is_refused():
    curve = FluidTautochrone(0.5, 1.0, 1.0)
    with pytest.raises(DescentError, match=r'start = 1\.5 m: .* 1\.38'):
        far_end(Mirrored(curve), 1.5)
    with pytest.raises(DescentError, match='start = nan'):
        half_swing(curve, 1.0, math.nan)
    with pytest.raises(QuadratureError, match='resists too strongly'):
        half_swing(Cycloid(1e5, 1.0, 1.0), 1.0, 0.9)


@pytest.mark.parametrize('complement', [1.0, 1.0 - 1e-12, 0.5, 1e-3, 1e-9, 1e-15])
def test_elliptic_functions_keep_their_digits_up_to_the_edge(complement):
    """The error is relative. Towards K cos φ is small, and a rounding of φ is multiplied by tan
    φ.
    """
    with mpmath.workdps(40):
        m = 1 - mpmath.mpf(complement)
        whole = mpmath.ellipk(m)
        assert float(quarter_period(np.array([complement]))[0] / whole) == pytest.approx(
            1, abs=5e-16
        )
        for part in (0.01, 0.2, 0.5, 0.9):
            u = part * float(whole)
            phi = float(jacobi_amplitude(np.array([u]), np.array([complement]))[0])
            assert math.sin(phi) == pytest.approx(float(mpmath.ellipfun('sn', u, m=m)), rel=1e-15)
            loose = 1e-15 + 4e-16 * math.tan(phi)
            assert math.cos(phi) == pytest.approx(float(mpmath.ellipfun('cn', u, m=m)), rel=loose)
