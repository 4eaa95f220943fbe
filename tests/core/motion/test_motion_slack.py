"""A thread that goes slack and tautens again: against DOP853, the energy lost, and restarts."""

import math
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from motion_cases import moved, on_land, rolling, run, sampled, scene_of, waves, weight_of
from slack_reference import Ideal, Lever, Swinging, TrueShip
from test_motion_heat import warmed
from thread_references import HELD

from tauto_core.clockwork import TrochleaStage
from tauto_core.curves import Table, TableLever
from tauto_core.kernels import entry
from tauto_core.machines import HangingMachine, LeverMachine, Machine, compile_machine
from tauto_core.machines.drags import Drag
from tauto_core.motion import make_collocation, make_propagator
from tauto_core.motion.free_end import FreeEndCollocation
from tauto_core.motion.real_threads import RealThreads, TautLever, _within
from tauto_core.samples import JOINT_STATES, PHASE, READING, SLACK, join, take
from tauto_core.scene.errors import PropagationError
from tauto_core.ship import ShipMotion

VERTICAL = weight_of(0.05, 0.02, release_angle=1.0)
HOLE = {
    **VERTICAL,
    'cam': {'kind': 'hole', 'lever_rate': 0.02},
    'thread': {'kind': 'hole', 'distance': 0.2},
}
SPRUNG = {**VERTICAL, 'power': {'kind': 'weight_and_spring', 'mass': 0.05, 'stiffness': 5.0}}
CHEEK = {**VERTICAL, 'cam': {'kind': 'circular_arc', 'root_depth': 0.02, 'radius': 0.06}}
LEVER: dict[str, Any] = {
    **VERTICAL,
    'cam': {'kind': 'involute', 'base_radius': 0.01},
    'thread': {'kind': 'lever', 'arm': 0.1, 'weight_arm': 0.15, 'length': 0.3},
}
TAILED = {
    **LEVER,
    'thread': {**LEVER['thread'], 'tail': {'mass': 0.02, 'distance': 0.12}, 'inertia': 3e-4},
}
HANGING = {**VERTICAL, 'thread': {'kind': 'hanging', 'length': 0.3}}


def falling(amplitude: float, phase: float = 1.6) -> dict[str, Any]:
    """A ship that falls faster than its cargo: z̈ = −4.11 amplitude cos(2.03 t + phase)."""
    return rolling((0.05, 7.0), heave=waves((amplitude, 3.1, phase)), height=3.0)


CASES = {
    'vertical, drag, escapement': (VERTICAL, 2.5, HELD),
    'vertical, weight and spring': (SPRUNG, 4.0, {}),
    'cheek': (CHEEK, 2.6, {}),
    'hole': (HOLE, 2.5, {}),
    'lever, drag, escapement': (LEVER, 2.5, HELD),
    'lever with a tail': (TAILED, 2.5, {}),
    'swinging, drag, escapement': (HANGING, 2.5, HELD),
}


@pytest.mark.parametrize('name', sorted(CASES))
def test_a_slack_thread_agrees_with_dop853(name):
    """To 1e-9 rad, since errors before the tautening grow after it.

    For the swinging thread to 1e-7: its force bends within a step, as z̃ replaces z.
    """
    trochlea, amplitude, more = CASES[name]
    scene = scene_of(trochlea=trochlea, ship=falling(amplitude), duration=3.2, **more)
    machine, forcing = compile_machine(scene), sampled(scene)
    kinds: dict[type, Any] = {LeverMachine: Lever, HangingMachine: Swinging}
    reference = kinds.get(type(machine), Ideal)(machine)
    engine = make_collocation(machine)
    found, exact = moved(engine, forcing), reference.run(forcing)
    tautened = engine.tautened()
    assert len(tautened) == len(reference.slacks) > 0
    near = 1e-7 if isinstance(reference, Swinging) else 1e-9
    np.testing.assert_allclose([each.time_s for each in tautened], reference.slacks, atol=near)
    np.testing.assert_allclose(found.angle, exact[:, 0], rtol=0, atol=near)
    np.testing.assert_allclose(found.rate, exact[:, 1], rtol=0, atol=10.0 * near)
    lost = [each.lost_joule for each in tautened]
    np.testing.assert_allclose(lost, reference.lost, rtol=100.0 * near, atol=1e-12)
    assert min(each.slack_s for each in tautened) > 0.0


def test_a_weight_falls_by_the_whole_force_near_weightlessness():
    """To the error of sampling at 200 Hz.

    Without the transverse part the wheel errs by 0.08 rad in 4 s.
    """
    ship = {**falling(TrueShip.amplitude), 'rate': 200.0}
    scene = scene_of(trochlea=HANGING, ship=ship, duration=4.0)
    machine, forcing = compile_machine(scene), sampled(scene)
    reference = Swinging(machine)
    reference.ship = TrueShip
    engine = make_collocation(machine)
    found, exact = moved(engine, forcing), reference.run(forcing)
    assert len(engine.tautened()) == len(reference.slacks) > 0
    np.testing.assert_allclose(found.angle, exact[:, 0], rtol=0, atol=1e-5)


def test_a_thread_about_to_let_go_is_counted_once():
    """DOP853 with the true force tautens it at these times. Slacks of 10 µs do not count."""
    thread = {'kind': 'hanging', 'length': 2.397, 'damping_ratio': 0.139}
    trochlea = weight_of(2.014, 0.001613, thread=thread, inertia=8.21e-4, release_angle=-1.585)
    heave = waves((0.7521, 1.5183, 3.2058))
    ship = rolling((0.0877, 2.837, 0.8757), heave=heave, height=1.0, rate=100.0)
    scene = scene_of(trochlea=trochlea, ship=ship, duration=6.5)
    engine, forcing = make_collocation(compile_machine(scene)), sampled(scene)
    moved(engine, forcing)
    times = [each.time_s for each in engine.tautened()]
    np.testing.assert_allclose(times, [1.277, 2.796, 4.308, 5.819], rtol=0, atol=2e-3)


def steep() -> Table:
    """t = 0.1 ϑ − 0.055 ϑ³ + 0.0078 ϑ⁵ in four pieces."""
    law = np.polynomial.Polynomial([0.0, 0.1, 0.0, -0.055, 0.0, 0.0078])
    knots = np.arange(5) * 0.55
    taylor = [[law.deriv(j)(k) / math.factorial(j) for j in range(6)] for k in knots[:-1]]
    return Table('law', TableLever(knots, np.array(taylor), law.integ()(knots[:-1])))


STEEP = steep()
"""A steeply falling lever arm: a heavy weight overtakes its thread on land."""


def test_energy_is_lost_as_the_thread_tautens_and_never_gained():
    """On land the energy falls by the reported losses only."""
    rng, slacks = np.random.default_rng(30), 0
    for _ in range(4):
        machine = Machine(
            inertia=10.0 ** rng.uniform(-5.0, -4.2),
            carried_mass=1.0,
            pulling_mass=1.0,
            force=0.0,
            stiffness=0.0,
            gravity=9.80665,
            cam=STEEP,
            follows_apparent_vertical=True,
            drag=None,
            escapement=None,
            release_angle=rng.uniform(2.0, 2.19) * rng.choice([-1.0, 1.0]),
        )
        engine, forcing = make_collocation(machine), on_land(200, 0.01)
        motion, tautened = moved(engine, forcing), engine.tautened()
        slacks += len(tautened)
        assert all(each.lost_joule > 0.0 for each in tautened)
        angle, rate, times = motion.angle, motion.rate, 0.01 * np.arange(1, 201)
        energy = machine.potential(angle) + 0.5 * machine.mass(angle) * rate * rate
        lost = np.array([each.lost_joule for each in tautened])
        before = np.searchsorted([each.time_s for each in tautened], times)
        left = machine.potential(machine.release_angle) - np.append(0.0, np.cumsum(lost))[before]
        taut = motion.torque != 0.0
        np.testing.assert_allclose(energy[taut], left[taut], rtol=0, atol=1e-10)
    assert slacks > 20


def test_a_massless_weight_lets_the_wheel_go_and_nothing_is_lost():
    massless = {**VERTICAL, 'power': {'kind': 'weight', 'mass': 0.2, 'massless': True}}
    ship = {**falling(3.0, -math.pi), 'components': [], 'rate': 100.0}
    scene = scene_of(trochlea=massless, ship=ship, duration=6.0, log={'interval': 0.01})
    wheel, said = (run(scene)[topic] for topic in (JOINT_STATES, SLACK))
    ends = (said.stamp_ns - scene.starts_at_ns) * 1e-9
    w = math.tau / 3.1
    weightless = math.acos(scene.g / (3.0 * w * w)) / w
    np.testing.assert_allclose(said.position[:, 1], 2.0 * weightless, atol=1e-9)
    np.testing.assert_allclose(ends, 1.55 + weightless + 3.1 * np.arange(len(ends)), atol=2e-9)
    assert np.all(said.position[:, 2] == 0.0)
    times = (wheel.stamp_ns - scene.starts_at_ns) * 1e-9
    free = (times > ends[0] - 2.0 * weightless) & (times < ends[0])
    assert np.ptp(wheel.velocity[free, 0]) < 1e-12
    assert np.all(wheel.effort[free, 0] == 0.0)


def test_a_force_never_lets_go():
    """Force and spring have no mass, and draw as fast as the thread gives."""
    powers: list[dict[str, object]] = [{'kind': 'force'}, {'kind': 'spring', 'stiffness': 5}]
    for power in powers:
        power |= {'force': 0.5}
        scene = scene_of(trochlea={**VERTICAL, 'power': power}, ship=falling(3.0), duration=6.0)
        assert SLACK not in run(scene)


HEAVE = waves((0.16, 0.83, 0.3), (0.4, 1.31, 2.0))
RIPPLES = rolling((0.05, 7.0), heave=HEAVE, height=3.0, rate=50.0)


def test_friction_holds_a_free_wheel_until_the_thread_tautens():
    """Coulomb's friction stops the free wheel, and the tautening thread moves it."""
    sections = {'drag': {'coulomb': 1e-3}, 'log': {'interval': 0.02}}
    scene = scene_of(trochlea=VERTICAL, ship=RIPPLES, duration=20.0, **sections)
    said = run(scene)
    wheel, slack = said[JOINT_STATES], said[SLACK]
    times, rate = (wheel.stamp_ns - scene.starts_at_ns) * 1e-9, wheel.velocity[:, 0]
    ends, kept = (slack.stamp_ns - scene.starts_at_ns) * 1e-9, 0
    for end, (_, slack_s, lost) in zip(ends.tolist(), slack.position.tolist(), strict=True):
        within = (times > end - slack_s) & (times < end)
        still = np.flatnonzero(rate[within] == 0.0)
        assert np.all(wheel.effort[within, 0] == 0.0)
        assert lost >= 0.0
        if len(still):
            assert still.tolist() == list(range(int(still[0]), np.count_nonzero(within)))
            assert rate[times > end][0] != 0.0
            kept += 1
    assert kept > 0


CLOCK = {**HELD, 'drag': {'viscous': 2e-5}}
FALLING = {**falling(2.5), 'rate': 50.0}
STAGES = {
    'vertical, free ends': (VERTICAL, RIPPLES, 20.0, {**CLOCK, 'solver': {'tolerance': 1e-6}}),
    'vertical, friction': (VERTICAL, RIPPLES, 20.0, {'drag': {'coulomb': 1e-3}}),
    'lever': (LEVER, FALLING, 4.0, CLOCK),
    'swinging': (HANGING, FALLING, 4.0, CLOCK),
}


@pytest.mark.parametrize('name', STAGES)
def test_chunks_and_restarts_give_the_same_bits(name):
    trochlea, sea, duration, clock = STAGES[name]
    log = {'interval': 0.04}
    scene = scene_of(trochlea=trochlea, ship=sea, duration=duration, log=log, **clock)
    whole = run(scene)
    assert len(whole[SLACK].stamp_ns) > 0
    ship, stage, parts, first = ShipMotion(scene), TrochleaStage(scene), [], 0
    imu = ship.produce(ship.total)
    for n in [1, 7, 13, 100, 3] + [41] * 100:
        parts.append(stage.feed({'ship/imu': take(imu, slice(first, first + n))}))
        first += n
        if first >= ship.total:
            break
        saved = pickle.loads(pickle.dumps(stage.state()))
        stage = TrochleaStage(scene)
        stage.restore(saved)
    for topic in (JOINT_STATES, PHASE, SLACK, READING):
        joined = join([part[topic] for part in parts if topic in part])
        for field in ('stamp_ns', 'position', 'velocity', 'effort', 'time_ref_ns'):
            if hasattr(joined, field):
                np.testing.assert_array_equal(getattr(joined, field), getattr(whole[topic], field))
    beats = whole[PHASE].position[:, 3]
    passed = np.count_nonzero(np.diff(np.signbit(whole[JOINT_STATES].position[:, 0])))
    assert beats[-1] >= passed


def test_a_lever_to_port_is_the_mirror_image():
    def motion(side: float) -> Any:
        thread = {'kind': 'lever', 'arc': 0.1, 'weight_arm': 0.15, 'length': 0.3}
        thread |= {} if side > 0.0 else {'fulcrum': 'port'}
        roll = waves((0.05, 7.0, 0.0 if side > 0.0 else math.pi))
        scene = scene_of(
            trochlea={**LEVER, 'thread': thread, 'release_angle': side},
            ship={**falling(2.6), 'components': roll},
            duration=4.0,
        )
        engine, forcing = make_collocation(compile_machine(scene)), sampled(scene)
        return moved(engine, forcing).angle, engine.tautened()

    (here, lost), (there, lost_there) = motion(1.0), motion(-1.0)
    assert len(lost) == len(lost_there) > 0
    np.testing.assert_allclose(here, -there, rtol=0, atol=1e-12)
    assert lost[0].lost_joule == pytest.approx(lost_there[0].lost_joule, rel=1e-12)


@pytest.mark.parametrize('trochlea', [VERTICAL, LEVER, HANGING])
def test_a_machine_at_35_degrees_goes_slack_as_one_made_so(trochlea):
    """The forcing stays at 35 degrees. Brass grows, and oil thins."""
    scene = scene_of(
        trochlea={**trochlea, 'material': 'brass'},
        ship=falling(2.5),
        duration=4.0,
        drag={'viscous': 2e-5, 'oil': 'olive'},
        air={'kind': 'constant', 'celsius': 35.0},
    )
    cold = compile_machine(scene)
    cold = replace(cold, heat=replace(cold.heat, varies=True))
    spans, log_s = sampled(scene), scene.log_interval_ns * 1e-9
    count = math.ceil(4.0 / log_s)
    found = []
    for machine in (cold, cold.at_celsius(35.0)):
        forcing = warmed(spans, log_s, np.full(count + 1, 35.0)) if machine is cold else spans
        engine = make_collocation(machine)
        found.append((moved(engine, forcing).angle, engine.tautened()))
    (hot, lost), (same, lost_same) = found
    assert cold.at_celsius(35.0).inertia > 1.0005 * cold.inertia
    np.testing.assert_allclose(hot, same, rtol=0, atol=1e-11)
    assert len(lost) == len(lost_same) > 0
    assert lost[0].lost_joule == pytest.approx(lost_same[0].lost_joule, rel=1e-10)


def test_free_end_steps_go_on_after_a_slack_thread():
    """They agree with steps of the default tolerance until the sea magnifies the difference."""
    scene = scene_of(trochlea=VERTICAL, ship=falling(2.5), duration=8.0, **HELD)
    machine = replace(compile_machine(scene), drag=Drag(viscous=1e-5))
    forcing = sampled(scene)
    free, exact = make_propagator(machine, still=False, sweeps=3), make_collocation(machine)
    assert isinstance(free, FreeEndCollocation)
    found, wanted = moved(free, forcing), moved(exact, forcing)
    np.testing.assert_allclose(found.angle, wanted.angle, atol=1e-7)
    assert len(free.tautened()) == len(exact.tautened()) > 0


def test_a_machine_that_stops_ends_where_the_thread_lets_go():
    scene = scene_of(trochlea=VERTICAL, ship=falling(2.5), duration=8.0)
    said = run(scene)[SLACK]
    stops = scene_of(trochlea={**VERTICAL, 'slack': 'stop'}, ship=falling(2.5), duration=8.0)
    assert compile_machine(stops) == replace(compile_machine(scene), stops_when_slack=True)
    with pytest.raises(PropagationError, match='went slack') as caught:
        run(stops)
    went_s = (take(said, slice(0, 1)).stamp_ns[0] - scene.starts_at_ns) * 1e-9
    assert caught.value.time_s == pytest.approx(went_s - said.position[0, 1], abs=1e-9)


@entry
def margin_of(lever: Any, held: TautLever, height: float) -> float:
    return _within(lever, held, height)


def test_the_margin_of_a_slack_lever_ends_with_its_arc():
    """The margin falls to 0 at both ends, and a quarter turn above or below where it is held."""
    lever, _ = RealThreads(compile_machine(scene_of(trochlea=LEVER)))._model
    middle, half, root = lever.shape.full.middle, lever.shape.full.half_width, lever.root_j
    assert middle != 0.0

    def margin(s: float, over: float) -> float:
        return margin_of(lever, TautLever(s, 0.0, 0.0, 0.0, 0.2), root * (0.2 + over))

    assert margin(middle, 0.0) == 1.0
    for side in (1.0, -1.0):
        assert margin(middle + side * half, 0.0) == pytest.approx(0.0, abs=1e-15)
        assert margin(middle + side * 1.01 * half, 0.0) == pytest.approx(-0.0201, rel=1e-9)
        assert margin(middle, side * 1.5) == pytest.approx(0.5 * np.pi - 1.5, rel=1e-12)
        assert margin(middle, side * 1.6) < 0.0


def test_the_stage_counts_the_slacks_of_its_thread():
    scene = scene_of(trochlea=VERTICAL, ship=falling(2.5), duration=8.0)
    stage, ship = TrochleaStage(scene), ShipMotion(scene)
    assert 'slacks' not in stage.health()
    said = stage.feed({'ship/imu': ship.produce(ship.total)})[SLACK]
    assert said.position[:, 0].tolist() == list(range(1, stage.health()['slacks'] + 1))
