"""The pendulum on a cylindrical axle against golden numbers, DOP853, energy and closed forms."""

import math

import numpy as np
import pytest
from golden_numbers import entries, numbers
from scipy.integrate import solve_ivp

from tauto_core.machines.axle_pendulum import (
    AxlePendulum,
    AxleState,
    SupportMotion,
    UnsteadyAxleError,
    axle_on,
    plane_period,
    small_motion,
)
from tauto_core.motion.axle import forces

TIGHT = 1e-13
BY_ODE = 2e-12
"""DOP853 at its tightest over a second or so, against 20 digits."""


def close(actual, expected, rtol=TIGHT, atol=1e-300):
    np.testing.assert_allclose(actual, expected, rtol=rtol, atol=atol)


def body_of(given):
    curvature = given['one_over_e'] if 'one_over_e' in given else 1.0 / given['e']
    return AxlePendulum(curvature, given['c'], given['k'], given['G'])


def simulate(body, start, time_s, support=lambda _: SupportMotion()):
    def slope(t, y):
        now = forces(body, AxleState(*y), support(t))
        return [y[2], y[3], float(now.arc_acceleration), float(now.tilt_acceleration)]

    found = solve_ivp(slope, (0.0, time_s), start, method='DOP853', rtol=3e-14, atol=1e-15)
    return found.y[:, -1]


@pytest.mark.parametrize('entry', entries('C32'))
def test_golden_motion_from_equilibrium(entry):
    given, expected = numbers(entry)
    body = body_of(given)
    start = AxleState(0.0, 0.0, given['n'] - given['c'] * given['nu'], given['nu'])
    found = small_motion(body, start, given['t'])
    close(found.arc, expected['s_arc'])
    close(found.tilt, expected['phi'])
    close(found.arc * body.curvature, expected['theta'])
    close(found.arc_rate * body.curvature, expected['thetadot'])
    close(found.tilt_rate, expected['phidot'])


@pytest.mark.parametrize('entry', entries('C10'))
def test_golden_large_angles(entry):
    """With 1/e = 1e-9 the golden value of θ is s/e, as accurate as s from the solver."""
    given, expected = numbers(entry)
    body = body_of(given)
    y = simulate(body, [given['theta0'] * given['e'], given['phi0'], 0.0, 0.0], given['t'])
    # the small s of a hanging body carries the error of a large swing
    s_size = max(given['theta0'] * given['e'], 0.1)
    close(y[0], expected['s_arc'], 0.0, 1e-12 * s_size)
    close(y[0] / given['e'], expected['theta'], 0.0, 1e-12 * s_size / given['e'])
    close(y[1], expected['phi'], BY_ODE)
    close(y[2] / given['e'], expected['thetadot'], 0.0, 2e-11 * s_size / given['e'])
    close(y[3], expected['phidot'], 0.0, 2e-11)
    end = AxleState(
        expected['s_arc'], expected['phi'], expected['thetadot'] * given['e'], expected['phidot']
    )
    close(forces(body, end).contact, expected['contact_force_over_M'])


def turned_about(turn, rate, bend, depth, aside=0.0, lateral=0.0):
    """Return the motion of a support that turns about an axis from which C is at these places."""
    x = depth * math.cos(turn) - aside * math.sin(turn)
    y = depth * math.sin(turn) + aside * math.cos(turn)
    down, across = -bend * y - rate * rate * x, bend * x - rate * rate * y
    return SupportMotion(turn, rate, bend, down, lateral + across)


@pytest.mark.parametrize('entry', entries('C-moving'))
def test_golden_moving_support(entry):
    given, expected = numbers(entry)
    assert given['rho'] == '0.1*sin(1.3 t)'
    assert given['a_lateral'] == '0.4*cos(2.1 t)'

    def support(t):
        sine, cosine = math.sin(1.3 * t), math.cos(1.3 * t)
        lateral = 0.4 * math.cos(2.1 * t)
        turning = 0.1 * sine, 0.13 * cosine, -0.169 * sine
        return turned_about(*turning, given['X0'], given['Y0'], lateral)

    y = simulate(body_of(given), [given['s0'], given['phi0'], 0.0, 0.0], given['t'], support)
    close(y, [expected[key] for key in ('s', 'phi', 'sdot', 'phidot')], 0.0, BY_ODE)


@pytest.mark.parametrize('entry', entries('C38-plane-large'))
def test_golden_large_swings_on_a_plane(entry):
    """The least contact force is that of a grid, to three digits. Half a swing ends at −A."""
    given, expected = numbers(entry)
    body = AxlePendulum(0.0, given['c'], given['k'], given['G'])
    period = plane_period(body, given['A'])
    close(period, expected['T_s'])
    grid = np.linspace(-given['A'], given['A'], 401)
    fallen = given['c'] * np.clip(np.cos(grid) - math.cos(given['A']), 0, None)
    mass = given['k'] ** 2 + (given['c'] * np.sin(grid)) ** 2
    speed = np.sqrt(2 * given['G'] * fallen / mass)
    state = AxleState(0.0, grid, -given['c'] * np.cos(grid) * speed, speed)
    close(np.min(forces(body, state).contact) / given['G'], expected['min_contact_over_MG'], 1e-3)
    start = [0.1, given['A'], 0.0, 0.0]
    end = simulate(body, start, 0.5 * period)
    close(end[1], -given['A'], 1e-11)
    centre = end[0] + given['c'] * math.sin(end[1])
    close(centre, start[0] + given['c'] * math.sin(start[1]), 1e-12)


BODIES = {
    'hollow': AxlePendulum(10.0, 0.3, 0.15, 9.81),
    'wide': AxlePendulum(0.01, 0.3, 0.15, 9.81),
    'plane': AxlePendulum(0.0, 0.3, 0.15, 9.81),
    'convex': AxlePendulum(-2.0, 0.3, 0.15, 9.81),
    'top-heavy': AxlePendulum(0.8, -0.3, 0.4, 9.81),
}


def test_plane_drifts_and_a_convex_support_throws_the_body_off():
    """§38: the centre of gravity keeps its speed. §46: the unstable mode is a sinh."""
    plane, times = BODIES['plane'], np.array([0.0, 1.0, 1000.0])
    pushed = small_motion(plane, AxleState(0.0, 0.01, 0.2, 0.0), times)
    close(pushed.arc + 0.3 * pushed.tilt, 0.003 + 0.2 * times, 1e-14)
    convex = BODIES['convex']
    rate = convex.growth_rate
    shape = convex.modes.tilt_per_arc[1]
    falling = small_motion(convex, AxleState(1e-9, 1e-9 * shape, 0.0, 0.0), 2.0)
    close(falling.arc, 1e-9 * math.cosh(2.0 * rate), 1e-6)
    assert falling.arc > 1e-5


def test_what_falls_says_how_fast_and_what_would_swing():
    for name in ('hollow', 'wide', 'plane'):
        BODIES[name].require_swing()
        assert BODIES[name].growth_rate == 0.0
    with pytest.raises(UnsteadyAxleError, match=r'h′ = .*hollow of larger radius'):
        BODIES['convex'].require_swing()
    with pytest.raises(UnsteadyAxleError, match=r'0\.3 m below the axle'):
        BODIES['top-heavy'].require_swing()
    assert axle_on(0.02, 0.005) == pytest.approx(1 / 0.015, rel=1e-15)
    assert axle_on(math.inf, 0.005) == 0.0
    assert axle_on(-0.5, 0.1) == pytest.approx(-1 / 0.6, rel=1e-15)
    with pytest.raises(UnsteadyAxleError, match='Widen the hollow'):
        axle_on(0.005, 0.005)
    with pytest.raises(UnsteadyAxleError, match='other than 0'):
        AxlePendulum(1.0, 0.0, 0.1, 9.81)
    with pytest.raises(UnsteadyAxleError, match='swings below'):
        plane_period(BODIES['plane'], math.pi)
