"""Half swings over branches that differ, against DOP853, closed forms and what Euler says."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tauto_core.curves.branches import (
    CircularDescent,
    JoinedCurve,
    ThroughPoints,
    joined_companion,
)
from tauto_core.curves.fluid import Cycloid, FluidTautochrone, SymmetricCurve
from tauto_core.machines import FluidPendulum, compile_machine
from tauto_core.machines.fluid_pendulum import (
    composed_length,
    duration_excess,
    end_arc,
    reverse_half_swing,
)
from tauto_core.machines.half_swings import BothWays
from tauto_core.scene import load_scene
from tauto_core.scene.errors import DescentError

G = 9.80665
KAPPA, GAMMA = 0.75, 0.9
LEVEL = np.linspace(0.125, 1.0, 8)
POINTS = np.stack([LEVEL, 0.5 * LEVEL**2 + 0.1 * LEVEL**3], axis=1)
GIVEN: dict[str, Any] = {
    'cycloid': Cycloid(KAPPA, GAMMA, 1.0),
    'circle': CircularDescent(KAPPA, GAMMA, 1.0 / GAMMA),
    'points': ThroughPoints(KAPPA, GAMMA, POINTS),
}


def integrated(curve: Any, start: float, friction: float = 0.0) -> tuple[float, float]:
    """Return duration [s] and end [m] of a half swing by DOP853, restarted at A."""
    way = -1.0 if float(curve.slope(start)) > 0.0 else 1.0

    def law(_: float, y: np.ndarray) -> list[float]:
        pull = float(curve.slope(y[0])) + way * friction
        return [y[1], -curve.gamma * G * pull - way * curve.kappa * y[1] ** 2]

    def rest(t: float, y: np.ndarray) -> float:
        return float(y[1]) if t > 0.01 else way

    def at_lowest(_: float, y: np.ndarray) -> float:
        return float(y[0])

    for event in (rest, at_lowest):
        event.terminal = True
    begin, state = 0.0, [start, 0.0]
    for events in ([at_lowest], [rest]):
        run = solve_ivp(
            law, (begin, 9.0), state, 'DOP853', rtol=3e-14, atol=1e-16, events=events,
            max_step=0.01,
        )  # fmt: skip
        begin, state = float(run.t_events[0][0]), [way * 1e-300, float(run.y_events[0][0][1])]
    return begin, float(run.y_events[0][0][0])


def assert_integrated(curve: Any, start: float, friction: float = 0.0) -> float:
    """Compare a half swing with DOP853, and return its duration."""
    course = BothWays(curve, G, friction, start).course(start)
    assert (course.duration, course.end) == pytest.approx(
        integrated(curve, start, friction), rel=1e-11
    )
    return course.duration


@pytest.mark.parametrize('side', ['descent', 'ascent'])
@pytest.mark.parametrize('name', GIVEN)
def test_half_swings_over_a_branch_and_its_companion_are_equal(name: str, side: Any) -> None:
    """π√(L/g) from starts up to the end of the companion, and from one of them by DOP853."""
    curve = joined_companion(GIVEN[name], side, 1.0)
    half = math.pi * math.sqrt(1.0 / G)
    for share in (0.02, 0.7, 0.999):
        start = share * curve.descent_cusp
        course = BothWays(curve, G, 0.0, start).course(start)
        assert course.duration == pytest.approx(half, rel=5e-15)
    if (name, side) == ('circle', 'descent'):
        assert_integrated(curve, 0.7 * curve.descent_cusp)


def test_two_lengths_compose_as_euler_says() -> None:
    """§21, and the way back by DOP853."""
    f, h = 1.0, 0.64
    joined = JoinedCurve(
        FluidTautochrone(KAPPA, GAMMA, f), FluidTautochrone(KAPPA, GAMMA, h), composed_length(f, h)
    )
    half = math.pi * math.sqrt(joined.pendulum_length / G)
    assert joined.pendulum_length == pytest.approx(0.81)
    for start in (0.01, 0.2, 0.4, -0.3):
        duration = assert_integrated(joined, start)
        if start > 0.0:
            assert duration == pytest.approx(half, rel=5e-15)


@pytest.mark.parametrize('start', [0.1, 0.5, 1.0])
def test_on_eulers_curve_they_are_his_closed_forms(start: float) -> None:
    """The way back, an elliptic integral, and the place on it."""
    curve, omega = FluidTautochrone(KAPPA, GAMMA, 5.0), math.sqrt(G / 5.0)
    ways = BothWays(curve, G, 0.0, -start)
    course = ways.course(-start)
    expected = 1.0 + float(duration_excess(KAPPA, start))
    assert course.duration * omega / math.pi == pytest.approx(expected, rel=3e-15)
    assert course.end == pytest.approx(float(end_arc(KAPPA, start)), rel=3e-15)
    times = np.linspace(0.0, course.duration, 31)
    arc, rate = ways.place(np.full(31, -start), times)
    wanted = reverse_half_swing(KAPPA, omega, np.full(31, start), times)
    np.testing.assert_allclose(arc, wanted[0], atol=5e-15 * start)
    np.testing.assert_allclose(rate, wanted[1], atol=2e-14 * start)


@pytest.mark.parametrize('reduced', [0.1, 1.0, 2.5])
def test_a_half_swing_on_a_cycloid_ends_where_the_energy_does(reduced: float) -> None:
    """With X = 2κS₁: e^X (X − 1) = −(1 + 2κS) e^{−2κS}."""
    course = BothWays(Cycloid(reduced, 1.0, 1.0), 1.0, 0.0, 1.0).course(1.0)
    x = -2.0 * reduced * course.end
    left = (1.0 + 2.0 * reduced) * math.exp(-2.0 * reduced)
    assert math.exp(x) * (x - 1.0) == pytest.approx(-left, abs=3e-15)


@pytest.mark.parametrize(
    ('make', 'expected'),
    [
        (Cycloid, [6.330e-5, 1.318e-3, 4.371e-3, 1.308e-2]),
        (FluidTautochrone, [7.757e-5, 1.499e-3, 4.560e-3, 1.167e-2]),
        (SymmetricCurve, [-1.7e-8, -7.5e-6, -8.3e-5, -7.3e-4]),
    ],
)
def test_swings_to_and_fro_are_those_of_the_table(make: Any, expected: list[float]) -> None:
    """The table was integrated by another program, to the digits compared."""
    found = []
    for start in (0.02, 0.1, 0.2, 0.4):
        ways = BothWays(make(1.0, 1.0, 1.0), 1.0, 0.0, start)
        there = ways.course(start)
        found.append((there.duration + ways.course(there.end).duration) / math.tau - 1.0)
    np.testing.assert_allclose(found, expected, rtol=3e-2 if make is SymmetricCurve else 5e-4)


@pytest.mark.parametrize('curve', [FluidTautochrone(0.4, 0.9, 1.0, 0.02), Cycloid(0.4, 0.9, 1.0)])
@pytest.mark.parametrize('start', [0.4, 0.1, -0.3])
def test_constant_friction_is_that_of_the_integrated_motion(curve: Any, start: float) -> None:
    """§35: on his curve the half swing forward keeps its time, but not elsewhere."""
    duration = assert_integrated(curve, start, 0.02)
    if isinstance(curve, FluidTautochrone) and start > 0.0:
        assert duration == pytest.approx(math.pi * math.sqrt(1.0 / G), rel=3e-15)


@pytest.mark.parametrize('friction', [0.01, 0.03])
def test_any_friction_with_its_rounded_zero(friction: float) -> None:
    """A force of one rounding at the zero would have a root in r, of which no series converges."""
    machine = compile_machine(load_scene('globe_in_oil'))
    assert isinstance(machine, FluidPendulum)
    assert_integrated(machine.curve, 0.3, friction)


def test_a_start_that_would_leave_the_other_branch_is_refused() -> None:
    """A short ascent after a long descent: the body comes over its cusp."""
    joined = JoinedCurve(FluidTautochrone(0.1, 0.9, 1.0), FluidTautochrone(0.1, 0.9, 0.1), 1.0)
    with pytest.raises(DescentError, match='beyond the end of the other branch'):
        BothWays(joined, G, 0.0, 0.8)
