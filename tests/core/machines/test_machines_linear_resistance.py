"""A body in a fluid with Newton's resistance ∝ v: closed forms (E13, 35), DOP853, refusals."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tauto_core import isochronism, sail
from tauto_core.curves.fluid import Cycloid, FluidTautochrone
from tauto_core.machines import compile_machine
from tauto_core.machines.half_swings import BothWays
from tauto_core.scene import load_scene
from tauto_core.scene.errors import DescentError, SceneError

G, KAPPA, GAMMA, LAMBDA = 9.80665, 0.75, 0.9, 0.7
OMEGA = math.sqrt(G)
"""Of f = 1 m."""
CURVES: dict[str, Any] = {
    'cycloid': (Cycloid(KAPPA, GAMMA, 1.0), 0.0),
    'cycloid, friction': (Cycloid(KAPPA, GAMMA, 1.0), 0.02),
    'euler': (FluidTautochrone(KAPPA, GAMMA, 1.0), 0.0),
    'euler, friction': (FluidTautochrone(KAPPA, GAMMA, 1.0, 0.03), 0.03),
}


def damped(start: float, time: Any, viscous: float = LAMBDA) -> tuple[Any, Any]:
    """Place and speed of the damped harmonic swing from rest."""
    slow = math.sqrt(OMEGA**2 - 0.25 * viscous**2)
    share, fall = 0.5 * viscous / slow, np.exp(-0.5 * viscous * time)
    place = start * fall * (np.cos(slow * time) + share * np.sin(slow * time))
    return place, -start * fall * OMEGA**2 / slow * np.sin(slow * time)


@pytest.mark.parametrize('viscous', [1e-6, 0.7, 4.0])
@pytest.mark.parametrize('start', [0.4, -0.3, 1e-12])
def test_in_a_vacuum_it_is_the_damped_harmonic_swing(start: float, viscous: float) -> None:
    ways = BothWays(Cycloid(0.0, 1.0, 1.0), G, 0.0, start, viscous)
    half = math.pi / math.sqrt(OMEGA**2 - 0.25 * viscous**2)
    course = ways.course(start)
    assert course.duration == pytest.approx(half, rel=2e-14)
    assert course.end == pytest.approx(-start * math.exp(-0.5 * viscous * half), rel=1e-13)
    time = np.linspace(0.0, half, 23)
    place, rate = ways.place(np.full(23, start), time)
    wanted = damped(start, time, viscous)
    np.testing.assert_allclose(place, wanted[0], rtol=0, atol=5e-15 * abs(start))
    np.testing.assert_allclose(rate, wanted[1], rtol=0, atol=3e-14 * abs(start))


@pytest.mark.parametrize('start', [1e-6, 0.1, 0.4, 0.6])
def test_on_eulers_curve_half_swings_are_still_equal(start: float) -> None:
    curve = FluidTautochrone(KAPPA, GAMMA, 1.0)
    ways = BothWays(curve, G, 0.0, start, LAMBDA)
    half = math.pi / math.sqrt(OMEGA**2 - 0.25 * LAMBDA**2)
    assert ways.course(start).duration == pytest.approx(half, rel=1e-14)
    # to A alike, for any arc, but the way back is not equal
    slow = math.pi / half
    fall = (math.pi - math.atan2(slow, 0.5 * LAMBDA)) / slow
    assert ways.fall_time(start) == pytest.approx(fall, rel=1e-14)
    if start > 0.05:
        assert ways.course(ways.course(start).end).duration > half * 1.001


@pytest.mark.parametrize('start', [0.45, -0.25])
@pytest.mark.parametrize('name', CURVES)
def test_half_swings_are_those_of_dop853(name: str, start: float) -> None:
    """From rest over the duration: there the body is at the end, at rest, and on the way."""
    curve, friction = CURVES[name]
    ways = BothWays(curve, G, friction, start, LAMBDA)
    course, way = ways.course(start), -math.copysign(1.0, start)

    def motion(_: float, y: np.ndarray) -> list[float]:
        pull = curve.gamma * G * (float(curve.slope(y[0])) + way * friction)
        return [y[1], -pull - LAMBDA * y[1] - way * curve.kappa * y[1] ** 2]

    times = course.duration * np.array([0.1, 0.45, 0.8, 1.0])
    run = solve_ivp(
        motion, (0.0, course.duration), [start, 0.0], 'DOP853', times, rtol=3e-14, atol=1e-16,
        max_step=0.01,
    )  # fmt: skip
    place, rate = ways.place(np.full(4, start), times)
    np.testing.assert_allclose(place, run.y[0], rtol=0, atol=1e-13)
    np.testing.assert_allclose(rate, run.y[1], rtol=0, atol=3e-13)
    assert course.end == pytest.approx(run.y[0, -1], abs=1e-13)


def test_it_never_stops_and_underflows_without_harm() -> None:
    """∝ v takes a share of each swing: 1e-308 m is passed after some five hours."""
    keys = {'duration': 30_000.0, 'log.interval': 60.0, 'regulator.viscous': 0.1}
    voyage = sail(load_scene('globe_in_oil', **keys))
    joints = voyage.samples['trochlea/joint_states']
    assert np.all(np.isfinite(joints.position))
    assert abs(joints.position[-1, 0]) < 1e-300
    assert np.all(np.isfinite(voyage.samples['trochlea/phase'].position))


def test_periods_are_told_by_amplitude() -> None:
    found = isochronism('globe_in_oil', amplitudes=[0.05, 0.4], **{'regulator.viscous': 0.3})
    slow = math.sqrt(math.pi**2 - 0.25 * 0.3**2)
    np.testing.assert_allclose(found.half_swing_s, math.pi / slow, rtol=1e-6)
    assert found.nominal_period_s == pytest.approx(2.0 * math.pi / slow, rel=1e-5)


@pytest.mark.parametrize(
    ('regulator', 'key', 'words'),
    [
        ({'viscous': 6.4}, 'regulator.viscous', 'Give less than 6.28319 1/s'),
        ({'viscous': 0.1, 'curve': 'symmetric'}, 'regulator.viscous', 'a jump of curvature'),
        ({'viscous': 0.1, 'ascent_length': 0.8}, 'regulator.viscous', 'a jump of curvature'),
        ({'viscous': -0.1}, 'regulator.viscous', 'must be at least 0'),
        ({'viscous': 6.28}, 'regulator.release_arc', 'Release the body nearer'),
    ],
)
def test_what_has_no_swing_is_refused(regulator: dict[str, Any], key: str, words: str) -> None:
    keys = {f'regulator.{name}': value for name, value in regulator.items()}
    with pytest.raises(SceneError, match=words) as caught:
        compile_machine(load_scene('globe_in_oil', **keys))
    assert caught.value.key == key


def test_a_body_that_only_creeps_has_no_half_swing() -> None:
    with pytest.raises(DescentError, match='creeps back'):
        BothWays(Cycloid(0.0, 1.0, 1.0), G, 0.0, 0.1, 2.1 * OMEGA)
