"""A force given by points, compared with the closed forms of air, a chord and a spring."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tauto_core import sail
from tauto_core.curves import SpringCorrected
from tauto_core.curves.cam import ForceLaw
from tauto_core.ensembles.budget import _larger_cheek
from tauto_core.machines import Machine, compile_machine
from tauto_core.scene import Scene, SceneError, load_scene

INERTIA = 4e-4
AREA, OUTSIDE = 1e-4, 101325.0
"""Area of a piston [m2] and the pressure outside [Pa]."""
END = 0.02


def condensed(lift: Any) -> Any:
    """Air pressed together: 8 cm of it at rest, 3.2 N above the outside, p V = const."""
    at_rest = OUTSIDE + 3.2 / AREA
    return AREA * (at_rest * 0.08 / (0.08 - lift) - OUTSIDE)


def rarefied(lift: Any) -> Any:
    """Air drawn thin: 3 cm of it at rest, at half of the pressure outside."""
    return AREA * OUTSIDE * (1.0 - 0.5 * 0.03 / (0.03 + lift))


def chord(lift: Any) -> Any:
    """A chord of 2 × 0.1 m with a tension of 10 N and 500 N/m, drawn aside by 3 cm at rest."""
    aside, half = 0.03 + lift, 0.1
    slope = np.hypot(half, aside)
    tension = 10.0 + 500.0 * (slope - np.hypot(half, 0.03))
    return 2.0 * tension * aside / slope


LAWS = {'condensed': condensed, 'rarefied': rarefied, 'chord': chord}


def points(law: Any, count: int = 21, end: float = END) -> list[list[float]]:
    return [[float(lift), float(law(lift))] for lift in np.linspace(0.0, end, count)]


def table(law: Any, count: int = 21, end: float = END) -> dict[str, Any]:
    return {'kind': 'force_table', 'points': points(law, count, end)}


INVOLUTE = {'kind': 'involute', 'base_radius': 0.005}
OWN = {'kind': 'force_table_corrected', 'period': 1.0}
SPRING = {'kind': 'spring', 'force': 3.2, 'stiffness': 50.0}
AS_TABLE = table(lambda lift: 3.2 + 50.0 * lift, 7, 0.03)


def scene(
    power: dict[str, Any], cam: dict[str, Any] = INVOLUTE, release: float = 1.0, **more: Any
) -> Scene:
    trochlea = {
        'inertia': INERTIA,
        'cam': cam,
        'thread': more.pop('thread', {'kind': 'vertical'}),
        'power': power,
        'release_angle': release,
        **more.pop('trochlea', {}),
    }
    return load_scene('ideal', trochlea=trochlea, **more)


def machine(*of: Any, **more: Any) -> Machine:
    found = compile_machine(scene(*of, **more))
    assert isinstance(found, Machine)
    return found


def period(law: Any, arm: Any, amplitude: float, end_s: float = 2.0) -> float:
    """The period on land by DOP853, from the closed form of a force and a lever arm of ϑ."""

    def motion(_t: float, y: np.ndarray) -> list[float]:
        size = abs(float(y[0]))
        lift, lever = arm(size)
        return [y[1], -math.copysign(law(lift) * lever / INERTIA, y[0])]

    def crossing(_t: float, y: np.ndarray) -> float:
        return float(y[0])

    found = solve_ivp(
        motion, (0.0, end_s), [amplitude, 0.0], 'DOP853', rtol=1e-13, atol=1e-15, events=crossing
    )
    first, second = found.t_events[0][:2]
    return float(2.0 * (second - first))


def test_its_laws_derivatives_are_those_of_the_lever_arm() -> None:
    cam, angle, step = machine(table(chord)).cam, np.linspace(0.2, 2.7, 9), 1e-4
    for law, rate in ((cam.lever_arm, cam.lever_rate), (cam.lever_rate, cam.lever_curvature)):
        slope = (law(angle + step) - law(angle - step)) / (2.0 * step)
        np.testing.assert_allclose(rate(angle), slope, rtol=1e-6)
    np.testing.assert_allclose(cam.angle_of_lift(cam.lift(angle)), angle, rtol=1e-14)


def test_a_spring_given_by_points_is_the_spring() -> None:
    given, spring = machine(AS_TABLE), machine(SPRING)
    for amplitude in (1e-3, 1.0, 3.0):
        assert given.period(amplitude) == pytest.approx(spring.period(amplitude), rel=1e-14)
    made = machine(AS_TABLE, OWN)
    rate = INERTIA * math.tau**2 / 3.2
    angle = np.linspace(0.0, 3.0, 31)
    wanted = SpringCorrected(rate, 50.0 / 3.2)
    for name in ('lever_arm', 'lever_rate', 'lever_curvature', 'radius_of_curvature', 'lift'):
        found = getattr(made.cam.cam, name)(angle)
        np.testing.assert_allclose(found, getattr(wanted, name)(angle), rtol=1e-12, atol=1e-17)
    x, y = made.cam.cam.contact(angle)
    np.testing.assert_allclose([x, y], wanted.contact(angle), rtol=1e-11, atol=1e-17)


@pytest.mark.parametrize(
    ('name', 'within'), [('condensed', 5e-11), ('rarefied', 2e-9), ('chord', 1e-11)]
)
def test_the_period_on_the_involute_is_that_of_the_closed_form(name: str, within: float) -> None:
    """Air and chord themselves, by DOP853. Each is far from isochronous."""
    law, found = LAWS[name], machine(table(LAWS[name]))

    def arm(angle: float) -> tuple[float, float]:
        return 0.0025 * angle * angle, 0.005 * angle

    for amplitude in (0.7, 2.5):
        wanted = period(law, arm, amplitude)
        assert found.period(amplitude) == pytest.approx(wanted, rel=within)
    assert abs(found.period(2.5) / found.period(0.7) - 1.0) > 0.03


@pytest.mark.parametrize(
    ('name', 'within'), [('condensed', 5e-11), ('rarefied', 5e-9), ('chord', 1e-11)]
)
def test_its_own_cam_makes_the_true_force_isochronous(name: str, within: float) -> None:
    """Air and chord themselves on the lever arm of the cam, as near as the spline is to them."""
    thread = {'kind': 'hole', 'distance': 0.05} if name == 'condensed' else {'kind': 'vertical'}
    law, found = LAWS[name], machine(table(LAWS[name]), OWN, 0.5, thread=thread)
    assert found.is_linear
    cam = found.cam.cam

    def arm(angle: float) -> tuple[float, float]:
        return float(cam.lift(angle)), float(cam.lever_arm(angle))

    assert period(law, arm, 0.9 * found.range_rad) == pytest.approx(1.0, rel=within)


def test_it_sails_as_dop853_does() -> None:
    """θ̈ = −F(h) t/I − ρ̈ at sea, with F by Horner's scheme of the spline, over two swings."""
    roll = {'amplitude': 0.1, 'period': 9.0, 'phase': 0.4}
    ship = {'kind': 'components', 'components': [roll]}
    keys = {'duration': 2.0, 'log.interval': 1.0, 'solver.tolerance': 1e-13}
    given = scene(table(condensed), release=2.0, ship=ship, **keys)
    law, omega = ForceLaw(tuple(map(tuple, points(condensed)))), math.tau / 9.0

    def motion(time: float, y: np.ndarray) -> list[float]:
        force = float(law.force(0.0025 * y[0] ** 2)) * 0.005 * y[0] / INERTIA
        return [y[1], -force + 0.1 * omega**2 * math.cos(omega * time + 0.4)]

    found = sail(given).samples['trochlea/joint_states']
    wanted = solve_ivp(motion, (0.0, 2.0), [2.0, 0.0], 'DOP853', rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(found.position[-1, 0], wanted.y[0, -1], atol=1e-12)
    np.testing.assert_allclose(found.velocity[-1, 0], wanted.y[1, -1], atol=5e-12)


SIX = points(condensed, 6)


@pytest.mark.parametrize(
    ('change', 'key', 'words'),
    [
        ({0: [0.001, 3.2]}, 'trochlea.power.points[0]', 'is not the lift at rest'),
        ({2: SIX[4]}, 'trochlea.power.points[3]', 'is not above the lift before it'),
        ({3: [SIX[3][0], 0.0]}, 'trochlea.power.points[3]', 'must be above 0 N'),
        ({3: [SIX[3][0], -1.0]}, 'trochlea.power.points[3]', 'must be above 0 N'),
        ({3: [SIX[3][0], 0.001], 4: [SIX[4][0], 0.001]}, 'trochlea.power.points', 'spline'),
    ],
)
def test_points_that_are_no_force_are_refused(change, key, words):
    given = [change.get(at, pair) for at, pair in enumerate(SIX)]
    with pytest.raises(SceneError, match=words) as caught:
        scene({'kind': 'force_table', 'points': given})
    assert caught.value.key == key
    assert caught.value.remedy.endswith('.')


@pytest.mark.parametrize(
    ('cam', 'trochlea', 'key'),
    [
        ({'kind': 'synthesised', 'period': 1.0, 'range': 2.0}, {}, 'trochlea.cam.kind'),
        ({'kind': 'circular_arc', 'root_depth': 0.01, 'radius': 0.02}, {}, 'trochlea.cam.kind'),
        ({'kind': 'spring_corrected', 'period': 1.0}, {}, 'trochlea.power.kind'),
        (INVOLUTE, {'material': 'brass'}, 'trochlea.material'),
        (INVOLUTE, {'thread': {'kind': 'hanging', 'length': 0.3}}, 'trochlea.power.kind'),
    ],
)
def test_what_does_not_go_with_it_is_refused(cam, trochlea, key):
    with pytest.raises(SceneError) as caught:
        scene(table(condensed), cam, trochlea=trochlea)
    assert caught.value.key == key


def test_its_own_cam_needs_it() -> None:
    with pytest.raises(SceneError, match='For a spring use cam kind spring_corrected'):
        scene(SPRING, OWN)


def test_a_force_that_rises_too_fast_makes_a_hollow_cheek() -> None:
    """F'(0) b > F(0)/3, at a period below 2π √(3 I F'(0))/F(0)."""
    steep = table(lambda lift: 3.2 + 400.0 * lift, 7)
    with pytest.raises(SceneError, match=r'would be hollow from 0 to .*Use a longer period'):
        machine(steep, OWN)
    slowest = math.tau * math.sqrt(INERTIA * 3.0 * 400.0) / 3.2
    machine(steep, {**OWN, 'period': 1.001 * slowest})


@pytest.mark.parametrize('cam', [INVOLUTE, OWN], ids=['involute', 'own'])
def test_a_table_too_short_for_the_release_is_refused(cam: dict[str, Any]) -> None:
    with pytest.raises(SceneError, match=r'give trochlea\.power\.points up to a') as caught:
        sail(scene(table(condensed, 21, 0.005), cam, 2.0))
    assert caught.value.key == 'trochlea.release_angle'


def test_a_larger_cheek_is_the_machine_with_it() -> None:
    """As in a budget: the involute of a base radius larger by a thousandth."""
    given, part = machine(table(condensed)), 1.001
    at = min(1.0, 0.999 * given.range_rad)
    larger = _larger_cheek(given, 0.001 * 0.005 * at)
    assert isinstance(larger, Machine)
    wanted = machine(table(condensed), {'kind': 'involute', 'base_radius': part * 0.005})
    for amplitude in (0.5, 2.0):
        assert larger.period(amplitude) == pytest.approx(wanted.period(amplitude), rel=1e-13)
    assert larger.range_rad == pytest.approx(wanted.range_rad, rel=1e-13)
