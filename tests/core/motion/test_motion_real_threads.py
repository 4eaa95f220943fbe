"""Sully's lever and the swinging thread: the engine against DOP853, exact solutions and itself."""

import math
from dataclasses import replace

import numpy as np
import pytest
from motion_cases import (
    LEVER,
    LEVER_WHEEL,
    LONG_THREAD,
    SEA,
    STIFF,
    assert_same_swing,
    impulse,
    moved,
    on_land,
    run,
    sampled,
    scene_of,
    waves,
)
from thread_references import HELD, hanging_energy, reference_of, swing

from tauto_core.machines import LeverMachine, compile_machine
from tauto_core.motion.closed_forms import UnevenWell
from tauto_core.motion.real_threads import RealThreads
from tauto_core.scene.errors import PropagationError, SceneError

ARC = {'kind': 'lever', 'arc': 0.1, 'weight_arm': 0.15, 'length': 0.3, 'inertia': 2e-4}
ARC = {**ARC, 'tail': {'mass': 0.03, 'distance': 0.08}}
HANGING = {**LEVER_WHEEL, 'thread': {'kind': 'hanging', 'length': 0.3}, 'release_angle': 1.2}
DAMPED = {**HANGING, 'thread': {'kind': 'hanging', 'length': 0.3, 'damping_ratio': 0.3}}
LONG_DAMPED = {**LONG_THREAD, 'thread': {'kind': 'hanging', 'length': 1.5, 'damping_ratio': 1.5}}
SPRUNG = {'kind': 'weight_and_spring', 'mass': 0.05, 'stiffness': 40.0}
RECOILING = {**HELD, 'escapement': impulse(1e-5, 0.2, recoil=4e-4)}

CASES = {
    'lever, drag, escapement': (LEVER, HELD),
    'lever, drag, recoil': (LEVER, RECOILING),
    'long thread': (LONG_THREAD, {}),
    'long thread, damped, drag, escapement': (LONG_DAMPED, HELD),
    'long thread, drag, recoil': (LONG_THREAD, RECOILING),
    'short thread, spring, damped': ({**DAMPED, 'power': SPRUNG}, {}),
    'long thread, spring, drag, escapement': ({**LONG_THREAD, 'power': STIFF}, HELD),
}


@pytest.mark.parametrize('name', CASES)
def test_at_sea_against_dop853_on_the_same_samples(name):
    """Seven swings. DOP853 at 1e-13 leaves a few 1e-14 rad per swing and event."""
    trochlea, more = CASES[name]
    scene = scene_of(trochlea=trochlea, ship=SEA, duration=7.2, log={'interval': 0.3}, **more)
    machine = compile_machine(scene)
    forcing = sampled(scene)
    found, exact = moved(RealThreads(machine), forcing), swing(reference_of(machine), forcing)
    np.testing.assert_allclose(found.angle, exact[:, 0], rtol=0, atol=2e-11)
    np.testing.assert_allclose(found.rate, exact[:, 1], rtol=0, atol=2e-10)
    assert found.half_turns[-1] > 8
    assert np.ptp(found.angle) > 1.0


@pytest.mark.parametrize('trochlea', [LEVER, LONG_THREAD], ids=['lever', 'long thread'])
@pytest.mark.parametrize('amplitude', [-0.1, 1e-3])
def test_beats_are_counted_whatever_the_swing(trochlea, amplitude):
    """Signs of DOP853's angle every 20 ms. The sea makes far larger swings than the smallest."""
    scene = scene_of(
        trochlea={**trochlea, 'release_angle': amplitude},
        ship={**SEA, 'rate': 50.0},
        duration=12.0,
        log={'interval': 0.02},
    )
    machine = compile_machine(scene)
    lever = isinstance(machine, LeverMachine)
    forcing = sampled(scene, stride=1)
    found = moved(RealThreads(machine), forcing)
    angle = swing(reference_of(machine), forcing)[:, 0]
    below = np.concatenate([[amplitude < 0.0], angle < 0.0])
    beats = np.cumsum(below[1:] != below[:-1])
    np.testing.assert_array_equal(found.beats, beats)
    if lever:
        # the coordinate of its phase has the sign of θ
        up = np.cumsum(below[:-1] & ~below[1:])
        phase = math.pi * (found.half_turns + found.fraction) + (math.pi if below[0] else 0.0)
        np.testing.assert_array_equal(np.floor(phase / math.tau + 0.25), up)


@pytest.mark.parametrize('thread', [LEVER['thread'], {**ARC, 'fulcrum': 'port'}])
def test_two_hundred_swings_of_the_lever_on_land_two_ways(thread):
    """Steps against action and angle, to their rounding."""
    machine = compile_machine(scene_of(trochlea={**LEVER, 'thread': thread}))
    spans = on_land(1000, 0.2)
    steps, well = RealThreads(machine), UnevenWell(machine)
    for do in ('release', 'advance'):
        found, exact = (getattr(engine, do)(spans) for engine in (steps, well))
        assert_same_swing(found, exact, 1e-11)
        for name in ('rate', 'fraction', 'phase_rate', 'torque'):
            columns = [getattr(each, name) for each in (found, exact)]
            close = 1e-13 if name == 'torque' else 1e-11
            np.testing.assert_allclose(*columns, rtol=0, atol=close, err_msg=name)
    assert exact.half_turns[-1] > 300


@pytest.mark.parametrize('trochlea', [LONG_THREAD, {**HANGING, 'power': SPRUNG}])
def test_energy_is_kept_on_land(trochlea):
    """Over a thousand swings, 12 000 steps at the default tolerance lose less than 1e-12."""
    machine = compile_machine(scene_of(trochlea=trochlea))
    engine = RealThreads(machine)
    spans = on_land(5_000, 0.2, every=1_000)

    def energy():
        system, omega, planes = engine._model.system, engine._model.omega, engine._state['planes']
        places, rates = planes['x'], np.array(omega) * planes['y']
        state = [
            np.dot(row, each) for each in (places, rates) for row in (system.wheel, system.thread)
        ]
        return hanging_energy(machine, *state)

    engine.release(spans)
    start = energy()
    assert start == pytest.approx(
        hanging_energy(machine, machine.release_angle, 0.0, 0.0, 0.0), rel=1e-14
    )
    engine.advance(spans)
    assert energy() == pytest.approx(start, rel=1e-12)


def test_slack_threads_and_ends_of_the_geometry_are_errors():
    # heave 40 cos(Ωt): z̈ = −15.8 m/s² at the start; or −40 sin Ωt, weightless soon after half
    weightless = (math.pi + math.asin(9.80665 / (40.0 * (math.pi / 5.0) ** 2))) / (math.pi / 5)
    for phase, time_s in ((0.0, 0.0), (math.pi / 2, weightless)):
        ship = {'kind': 'components', 'heave': waves((40.0, 10.0, phase)), 'height': 3.0}
        for trochlea in (LEVER, LONG_THREAD):
            scene = scene_of(trochlea={**trochlea, 'slack': 'stop'}, ship=ship, duration=20.0)
            with pytest.raises(PropagationError, match='thread went slack') as caught:
                run(scene)
            assert caught.value.time_s == pytest.approx(time_s, abs=0.5)
    strong = {'escapement': {'kind': 'impulse', 'energy': 0.02}}
    with pytest.raises(PropagationError, match='range of the lever') as caught:
        run(scene_of(trochlea=LEVER, duration=20.0, **strong))
    assert 0.0 < caught.value.time_s < 20.0
    thread = {'kind': 'hanging', 'length': 0.02}
    with pytest.raises(PropagationError, match='wound up'):
        run(scene_of(trochlea={**LEVER_WHEEL, 'thread': thread}, duration=20.0, **strong))


def test_a_release_that_the_tilt_puts_beyond_is_refused():
    thread = {'kind': 'hanging', 'length': 0.011}
    ship = {'kind': 'components', 'components': [{'amplitude': 0.2, 'period': 8.0}]}
    scene = scene_of(trochlea={**LEVER_WHEEL, 'thread': thread, 'release_angle': 1.0}, ship=ship)
    machine = compile_machine(scene)
    spans = sampled(scene)
    with pytest.raises(PropagationError, match=r'beyond ±1\.04355'):
        RealThreads(machine).release(
            replace(spans, tilt=np.full_like(spans.tilt, -0.1), neutral=0.0 * spans.neutral)
        )


def test_a_wheel_too_light_and_an_impossible_damping_are_refused():
    with pytest.raises(PropagationError, match='Use a heavier wheel'):
        RealThreads(compile_machine(scene_of(trochlea={**LEVER, 'inertia': 1e-8})))
    with pytest.raises(SceneError, match=r'trochlea\.thread\.damping_ratio = 3\.0'):
        scene_of(trochlea={**HANGING, 'thread': {**HANGING['thread'], 'damping_ratio': 3.0}})
