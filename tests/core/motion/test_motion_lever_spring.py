"""A force, a spring or a table of forces on the lever, and levers at an inclination, by DOP853.

L = ½I(θ̇ + α̇)² + ½J(β̇ + α̇)² − V in a case that turns by α. A distant massless pull F in the case
has V = ∫ F dH, H = AD (sin β − sin β₀), and a weight V = m g AD sin(β + α).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from motion_cases import involute, moved, on_land, rolling, scene_of, waves
from scipy.integrate import solve_ivp
from test_motion_heat import warmed
from thread_references import LeverReference

from tauto_core import sail
from tauto_core.ensembles.budget import _heavier, _larger_cheek
from tauto_core.machines import LeverMachine, compile_machine
from tauto_core.motion.real_threads import RealThreads
from tauto_core.plots.machine import draw_machine
from tauto_core.scene.errors import SceneError

TURNED = 3e-4
TIED = {'kind': 'lever', 'arm': 0.1, 'weight_arm': 0.15, 'length': 0.3, 'inertia': TURNED}
ARC = {'kind': 'lever', 'arc': 0.1, 'weight_arm': 0.15, 'length': 0.3, 'inertia': TURNED}
HANGING = {'kind': 'hanging', 'length': 0.3}
PORT = {'fulcrum': 'port'}
UP, DOWN = {'inclination': 0.4}, {'inclination': -0.5}
CONSTANT = {'kind': 'force', 'force': 0.5}
SPRING = {'kind': 'spring', 'force': 0.5, 'stiffness': 6.0}
# F = 0.5 + 4H + 30H² + 200H³, which a quintic spline through its points has exactly
CUBIC = {
    'kind': 'force_table',
    'points': [
        [h, 0.5 + h * (4.0 + h * (30.0 + 200.0 * h))] for h in np.linspace(0.0, 0.12, 7).tolist()
    ],
}
WEIGHT = {'kind': 'weight', 'mass': 0.05}
BOTH = {'kind': 'weight_and_spring', 'mass': 0.05, 'stiffness': 3.0}
OWN_CAM = {'cam': {'kind': 'lever_corrected', 'period': 1.0}}
TAIL = {'tail': {'mass': 0.01, 'distance': 0.05}}
ROLL, PERIOD, PHASE = 0.15, 8.2, 1.0
SEA = rolling((ROLL, PERIOD, PHASE), height=0.0)
HEAVING = SEA | {'heave': waves((0.6, 10.2, 0.7)), 'height': 2.5}
"""The same roll. The rest does not act on massless pulls."""
EXACT = {'solver': {'tolerance': 1e-13}}
GRAVITY = 9.80665

TORQUES: dict[str, Callable[[float, float, float], float]] = {
    # of β, H and α; as dV/dβ over AD
    'force': lambda beta, drawn, alpha: 0.5 * math.cos(beta),
    'spring': lambda beta, drawn, alpha: (0.5 + 6.0 * drawn) * math.cos(beta),
    'force_table': lambda beta, drawn, alpha: (
        (0.5 + drawn * (4.0 + drawn * (30.0 + 200.0 * drawn))) * math.cos(beta)
    ),
    'weight': lambda beta, drawn, alpha: 0.05 * GRAVITY * math.cos(beta + alpha),
}


def inclined(machine: LeverMachine, thread: dict[str, Any]) -> LeverReference:
    side, start = -1.0 if 'fulcrum' in thread else 1.0, thread.get('inclination', 0.0)
    return LeverReference(machine, side, arc='arc' in thread, inclination=start)


def scene(thread: dict[str, Any], power: dict[str, Any], **more: Any) -> Any:
    wheel = {'cam': involute(0.02), 'release_angle': 1.2}
    return scene_of(trochlea={**wheel, 'power': power, 'thread': thread}, **more)


def reference(
    machine: LeverMachine, thread: dict[str, Any], kind: str, *, rolls: bool, drag: float = 0.0
) -> Callable[[float, np.ndarray], list[float]]:
    geometry, omega = inclined(machine, thread), math.tau / PERIOD
    turned = TURNED + (0.05 * 0.15**2 if kind == 'weight' else 0.0)

    def motion(time: float, y: np.ndarray) -> list[float]:
        alpha = ROLL * math.cos(omega * time + PHASE) if rolls else 0.0
        bend = -(omega**2) * alpha
        beta, first, second = geometry.geometry(float(y[0]))
        drawn = 0.15 * (math.sin(geometry.side * beta) - math.sin(geometry.inclination))
        mass = machine.inertia + turned * first * first
        pushed = (machine.inertia + turned * first) * bend + turned * first * second * y[1] ** 2
        pushed += geometry.side * 0.15 * TORQUES[kind](beta, drawn, alpha) * first + drag * y[1]
        return [y[1], -pushed / mass]

    return motion


CASES = [
    pytest.param(TIED, CONSTANT, id='force, tied'),
    pytest.param(ARC, CONSTANT, id='force, arc'),
    pytest.param(ARC | PORT, CONSTANT, id='force, arc, to port'),
    pytest.param(TIED, SPRING, id='spring, tied'),
    pytest.param(ARC | PORT, SPRING, id='spring, arc, to port'),
    pytest.param(ARC, CUBIC, id='table, arc'),
    pytest.param(TIED | UP, WEIGHT, id='weight, tied, inclined up'),
    pytest.param(TIED | DOWN | PORT, WEIGHT, id='weight, tied, inclined down, to port'),
    pytest.param(ARC | DOWN, WEIGHT, id='weight, arc, inclined down'),
    pytest.param(TIED | UP, SPRING, id='spring, tied, inclined up'),
]


@pytest.mark.parametrize(('thread', 'power'), CASES)
def test_its_period_agrees_with_dop853(thread: dict[str, Any], power: dict[str, Any]) -> None:
    """After a period the wheel is at rest, to 1e-11 of the period. Small swings agree with ω."""
    machine = compile_machine(scene(thread, power))
    assert isinstance(machine, LeverMachine)
    motion = reference(machine, thread, power['kind'], rolls=False)
    for amplitude in (1.2, -0.7):
        period = machine.period(amplitude)
        end = solve_ivp(
            motion, (0.0, period), [amplitude, 0.0], 'DOP853', rtol=1e-13, atol=1e-15
        ).y[:, -1]
        late = float(end[1]) / motion(period, end)[1]
        assert abs(late) < 1e-11 * period
    assert machine.period(1e-4) == pytest.approx(machine.small_period, rel=1e-7)


@pytest.mark.parametrize(
    ('thread', 'power'),
    [(TIED, CONSTANT), (ARC | PORT, SPRING), (ARC, CUBIC), (TIED | DOWN | PORT, WEIGHT)],
)
def test_it_sails_as_dop853_does(thread: dict[str, Any], power: dict[str, Any]) -> None:
    """Over three swings with drag, in a case that rolls."""
    ship = SEA if power is WEIGHT else HEAVING
    sections = EXACT | {'log': {'interval': 0.3}, 'drag': {'viscous': 1e-5}, 'ship': ship}
    sailed = scene(thread, power, duration=3.6, **sections)
    machine = compile_machine(sailed)
    assert isinstance(machine, LeverMachine)
    motion = reference(machine, thread, power['kind'], rolls=True, drag=1e-5)
    found = sail(sailed).samples['trochlea/joint_states']
    times = 0.3 * np.arange(1, 13)
    wanted = solve_ivp(motion, (0.0, 3.6), [1.2, 0.0], 'DOP853', times, rtol=1e-13, atol=1e-14)
    assert np.ptp(found.position[:, 0]) > 1.0
    close = 1e-11 if power is CONSTANT else 2e-11
    np.testing.assert_allclose(found.position[-12:, 0], wanted.y[0], rtol=0, atol=close)
    np.testing.assert_allclose(found.velocity[-12:, 0], wanted.y[1], rtol=0, atol=10.0 * close)


def test_joints_of_a_measured_force_take_a_series() -> None:
    """Boyle's air in a cylinder, through twelve points, against DOP853 of the closed form.

    Between its points the spline differs from the law by up to a millionth of a radian.
    """
    points = [[h, 0.5 / (1.0 - h / 0.3)] for h in np.linspace(0.0, 0.15, 12).tolist()]
    power = {'kind': 'force_table', 'points': points}
    air = scene(ARC, power, duration=6.0, log={'interval': 6.0}, **EXACT)
    machine = compile_machine(air)
    assert isinstance(machine, LeverMachine)
    geometry = inclined(machine, ARC)

    def motion(time: float, y: np.ndarray) -> list[float]:
        beta, first, second = geometry.geometry(float(y[0]))
        force = 0.5 / (1.0 - 0.15 * math.sin(beta) / 0.3)
        pushed = TURNED * first * second * y[1] ** 2 + 0.15 * force * math.cos(beta) * first
        return [y[1], -pushed / (machine.inertia + TURNED * first * first)]

    wanted = solve_ivp(motion, (0.0, 6.0), [1.2, 0.0], 'DOP853', rtol=1e-13, atol=1e-14)
    found = sail(air).samples['trochlea/joint_states']
    assert found.position[-1, 0] == pytest.approx(wanted.y[0, -1], abs=1e-6)


def test_the_range_ends_where_the_points_do() -> None:
    short = {'kind': 'force_table', 'points': [[0.002 * k, 0.5 + k] for k in range(6)]}
    words = r'give trochlea\.power\.points up to a larger draw'
    with pytest.raises(SceneError, match=words) as caught:
        compile_machine(scene(ARC, short))
    assert caught.value.key == 'trochlea.release_angle'


def test_it_is_drawn_as_it_rests() -> None:
    """Spring or arrow are at the lever's end, AD from the fulcrum, at the inclination."""
    parts = {part.name: part for part in draw_machine(scene(TIED | UP, SPRING)).parts}
    lever = parts['lever']
    across, up = lever.x[-1] - lever.x[0], lever.y[-1] - lever.y[0]
    assert math.atan2(up, across) == pytest.approx(0.4)
    assert math.hypot(across, up) == pytest.approx(150.0)
    assert float(np.median(parts['spring'].x)) == pytest.approx(lever.x[-1], abs=2.0)
    thread = parts['thread']
    # the thread ends at B, two thirds along the lever
    assert thread.y[-1] == pytest.approx(lever.y[0] + 100.0 * math.sin(0.4))
    pulled = {part.name: part for part in draw_machine(scene(ARC, CONSTANT)).parts}
    assert 'weight' not in pulled
    assert float(np.median(pulled['pull'].x)) == pytest.approx(50.0)


def test_heat_weakens_its_spring() -> None:
    """The small period grows as 1/√(force). Wheel, cam and lever grow alike."""
    steel = compile_machine(scene(ARC, CONSTANT | {'material': 'steel'}))
    assert isinstance(steel, LeverMachine)
    hot = steel.at_celsius(40.0)
    softer = 20.0 * -2.285e-4
    assert hot.small_period / steel.small_period == pytest.approx(
        1.0 / math.sqrt(1.0 + softer), rel=1e-9
    )
    warm = warmed(on_land(200, 0.02, 10), 0.2, np.full(21, 40.0))
    found = [
        moved(RealThreads(replace(each, heat=replace(each.heat, varies=True))), forcing).angle
        for each, forcing in ((steel, warm), (hot, on_land(200, 0.02, 10)))
    ]
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-11)


def test_a_budget_changes_its_force() -> None:
    machine = compile_machine(scene(ARC, CONSTANT))
    assert isinstance(machine, LeverMachine)
    heavier = _heavier(machine, 1e-4)
    assert isinstance(heavier, LeverMachine)
    assert heavier == replace(machine, force=0.5 + 1e-4 * machine.gravity)
    larger = _larger_cheek(machine, 1e-5)
    assert isinstance(larger, LeverMachine)
    assert larger.force == machine.force
    more = larger.weight_torque / machine.weight_torque - 1.0
    assert more == pytest.approx(1e-5 / 0.02, rel=0.1)


@pytest.mark.parametrize(
    ('thread', 'power', 'more', 'key', 'words'),
    [
        (ARC, SPRING, {'slack': 'fall'}, 'trochlea.slack', 'slack motion has no spring'),
        (ARC, SPRING, {'material': 'brass'}, 'trochlea.material', 'does not grow'),
        (ARC, SPRING, OWN_CAM, 'trochlea.cam.kind', 'a weight or a constant force'),
        (ARC | UP, WEIGHT, OWN_CAM, 'trochlea.thread.inclination', 'level at rest'),
        (ARC | {'inclination': 1.3}, WEIGHT, {}, 'trochlea.thread.inclination', 'at most 1.2'),
        (ARC | {'inertia': 0.0}, CONSTANT, {}, 'trochlea.thread.inertia', 'then only the lever'),
        (ARC | TAIL, CONSTANT, {}, 'trochlea.thread.tail.mass', 'gravity does not act'),
        (HANGING, CONSTANT, {}, 'trochlea.power.kind', 'carries a weight'),
        (ARC, BOTH, {}, 'trochlea.power.kind', 'weight and spring together'),
    ],
)
def test_incompatible_sections_are_refused(
    thread: dict[str, Any], power: dict[str, Any], more: dict[str, Any], key: str, words: str
) -> None:
    trochlea = {'cam': involute(0.02), 'power': power, 'thread': thread, **more}
    with pytest.raises(SceneError, match=words) as caught:
        compile_machine(scene_of(trochlea=trochlea))
    assert caught.value.key == key
