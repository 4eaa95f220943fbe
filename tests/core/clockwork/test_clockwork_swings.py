"""The amplitude of the wheel and the time at which the clock stopped, from the topics alone."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core.clockwork import SwingTally, TrochleaStage
from tauto_core.machines import LeverMachine, Machine, compile_machine
from tauto_core.machines.compiling import amplitude_of, recoil_energy, swing_energy
from tauto_core.results import groups
from tauto_core.samples import JOINT_STATES, PHASE, JointSamples, join, scalars, take
from tauto_core.scene import Scene, load_scene
from tauto_core.ship import ShipMotion
from tauto_core.voyage import sail
from tauto_core.wording import span

IDEAL = load_scene('ideal').trochlea.model_dump()
MACHINE = compile_machine(load_scene('ideal'))
OMEGA, STIFFNESS = MACHINE.frequency, MACHINE.inertia * MACHINE.frequency**2


HEAVY = {
    'inertia': 1e-5,
    'cam': {'kind': 'involute', 'base_radius': 0.01},
    'thread': {'kind': 'vertical'},
    'power': {'kind': 'weight', 'mass': 1.0},
}
"""A heavy weight on a light wheel: at 3 rad its period is six small-swing periods."""

INVOLUTE = {
    'cam': {'kind': 'involute', 'base_radius': 0.005},
    'thread': {'kind': 'vertical'},
    'power': {'kind': 'weight', 'mass': 0.322},
}
ROLL = {'kind': 'components', 'components': [{'amplitude': 0.1, 'period': 5.0, 'phase': 0.4}]}


def scene_of(**changes: Any) -> Scene:
    return load_scene('ideal', **changes)


def moved(scene: Scene) -> tuple[JointSamples, JointSamples]:
    """Return wheel and phase of a whole run."""
    ship, stage = ShipMotion(scene), TrochleaStage(scene)
    said = [stage.feed({'ship/imu': ship.produce(ship.total)}), stage.finish()]
    wheel, phase = (
        join([each[topic] for each in said if each]) for topic in (JOINT_STATES, PHASE)
    )
    assert isinstance(wheel, JointSamples)
    assert isinstance(phase, JointSamples)
    return wheel, phase


def verdicts(scene: Scene, every: int) -> Iterator[tuple[Any, Any]]:
    """Yield `stopped_s` and `stopped_why` at every third instant of a thinned log."""
    wheel, phase = (take(each, slice(None, None, every)) for each in moved(scene))
    tally = SwingTally(scene)
    for k in range(0, len(wheel.stamp_ns), 3):
        part = slice(k, k + 3)
        tally.feed({JOINT_STATES: take(wheel, part), PHASE: take(phase, part)})
        found = tally.result()
        yield found['stopped_s'], found['stopped_why']


def test_friction_stops_a_clock_and_the_summary_says_when():
    """Each half swing loses 2 s = 2 c₀/k. The wheel stays if it turns within s of the middle."""
    slip, half = 0.03, math.pi / OMEGA
    scene = scene_of(drag={'coulomb': slip * STIFFNESS}, duration=60.0, log={'interval': 0.05})
    last = math.ceil((1.0 - slip) / (2.0 * slip))
    rests_at = abs(1.0 - 2.0 * slip * last)
    report = sail(scene).result
    assert (last - 2) * half <= report['trochlea']['stopped_s'] <= (last - 1) * half + 0.05
    assert report['trochlea']['amplitude_rad'] == pytest.approx(rests_at, abs=1e-9)
    assert report['answer'].startswith(
        f'The clock stopped after {span(report["trochlea"]["stopped_s"])}:'
    )


@pytest.mark.parametrize(
    ('name', 'keys'),
    [
        ('globe_in_oil', {'regulator.friction': 0.02}),
        ('ideal', {'drag': {'coulomb': 0.02 * STIFFNESS}}),
    ],
)
def test_of_a_clock_that_stopped_for_good_no_rate_is_stated(name, keys):
    """A globe in a tenacious fluid (B 35) comes to rest as a wheel in rough pivots does."""
    report = sail(load_scene(name, duration=120.0, **{'log.interval': 0.5}, **keys)).result
    assert report['answer'].startswith('The clock stopped after')
    assert 0.0 < report['trochlea']['stopped_s'] < 60.0
    assert report['trochlea']['stopped_why'] in (
        'from then on the body did not pass the middle',
        'its swing had died away',
    )
    assert report['clock']['rate_s_per_day'] is None
    assert report['drift'] == {}
    assert report['longitude']['projection'] == []
    assert report['longitude']['not_projected'] == 'the clock stopped'
    assert not any(unit == 's/day' for _, rows in groups(report) for *_, unit in rows)


ROLLED = {
    'regulator.release_tilt': 0.0,
    'ship.heave': None,
    'ship.height': 0.0,
    'ship.components': [{'amplitude': 0.15, 'period': 30.0, 'phase': 0.5 * math.pi}],
}


@pytest.mark.parametrize(
    ('name', 'duration', 'keys'),
    [('globe_in_oil', 30.0, {}), ('axle_at_sea', 30.0, {}), ('axle_at_sea', 600.0, ROLLED)],
)
def test_a_body_in_place_of_a_wheel_that_swings_has_not_stopped(name, duration, keys):
    """A ship that rolls farther than the body swings carries it past the middle twice a roll."""
    found = sail(load_scene(name, duration=duration, **keys)).result
    assert found['trochlea']['stopped_s'] is None


def test_a_body_at_rest_in_a_viscous_fluid_has_stopped():
    """½ (W/g) ω² s² falls below k_B T by exp(−λt), from 0.4 m. The other loss hastens it."""
    loss, duration = 0.5, 300.0
    keys = {'regulator.curve': 'cycloid', 'regulator.viscous': loss}
    scene = load_scene('globe_in_oil', duration=duration, **keys)
    weight = (7800.0 - 900.0) * math.pi / 6.0 * 0.05**3
    begins = 0.5 * weight * (math.pi * 0.4) ** 2
    dies_s = math.log(begins / (1.380649e-23 * 293.0)) / loss
    found = sail(scene).result['trochlea']
    assert dies_s - 10.0 < found['stopped_s'] < dies_s + 1.0
    assert found['stopped_why'] == 'its swing had died away'
    shorter = sail(scene.model_copy(update={'duration': dies_s - 10.0})).result['trochlea']
    assert shorter['stopped_s'] is None


def test_a_swing_that_no_longer_reaches_the_impulse_has_stopped():
    """Until then the energy rises at every impulse, and never after it."""
    scene = scene_of(
        drag={'coulomb': 1e-4},
        escapement={'kind': 'impulse', 'energy': 5e-5, 'angle': 0.6},
        duration=120.0,
        log={'interval': 0.05},
    )
    wheel, phase = moved(scene)
    machine = compile_machine(scene)
    energy = swing_energy(machine, wheel.position[:, 0], wheel.velocity[:, 0])
    last_impulse = float(np.flatnonzero(np.diff(energy) > 1e-9)[-1] + 1) * 0.05
    tally = SwingTally(scene)
    tally.feed({JOINT_STATES: wheel, PHASE: phase})
    stopped = tally.result()['stopped_s']
    assert stopped is not None
    # from the impulse to the turning point and back to 0.6 rad, with an energy that still suffices
    assert last_impulse - 0.05 <= stopped <= last_impulse + math.pi / OMEGA
    # beats go on
    assert phase.position[-1, 3] > phase.position[round(stopped / 0.05), 3] + 10
    in_parts = SwingTally(scene)
    for topic, samples in ((PHASE, phase), (JOINT_STATES, wheel)):
        for k in range(0, len(samples.stamp_ns), 77):
            in_parts.feed({topic: take(samples, slice(k, k + 77))})
    assert in_parts.result() == tally.result()


@pytest.mark.parametrize(
    'name', ['cheek_before_euler', 'portsmouth_jamaica', 'sully_lever_at_sea', 'ideal']
)
def test_energy_and_amplitude_belong_together(name):
    machine = compile_machine(load_scene(name))
    assert isinstance(machine, Machine | LeverMachine)
    amplitude = 0.8
    at_rest = swing_energy(machine, np.array([amplitude]), np.zeros(1))
    assert amplitude_of(machine, float(at_rest[0])) == pytest.approx(amplitude, rel=1e-12)
    mass = machine.mass(0.0) if isinstance(machine, Machine) else machine.mass_at(0.0)
    rate = np.sqrt(2.0 * at_rest / mass)
    moving = swing_energy(machine, np.zeros(1), rate)
    assert amplitude_of(machine, float(moving[0])) == pytest.approx(amplitude, rel=1e-12)


@pytest.mark.parametrize('angle', [0.3, 0.0, -0.3])
def test_the_amplitude_of_a_clock_with_recoil_is_where_it_turns(angle):
    """V + ½ M θ̇² + R s θ is kept on half a swing of harmonic arcs about −R/k."""
    amplitude, recoil = 0.9, 0.1 * STIFFNESS
    rest = {'kind': 'impulse', 'energy': 1e-3, 'angle': angle, 'rest': {'recoil': recoil}}
    machine = compile_machine(scene_of(escapement=rest, drag={'viscous': 1e-6}))
    reach = amplitude + 0.1
    first, last = -math.acos((angle + 0.1) / reach), math.acos((0.1 - angle) / reach)
    phase = np.linspace(first, last, 50)[1:-1]
    theta, rate = reach * np.cos(phase) - 0.1, -reach * OMEGA * np.sin(phase)
    theta, rate = np.append(theta, -theta), np.append(rate, -rate)
    energy = swing_energy(machine, theta, rate) + recoil_energy(machine, theta, rate)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-13)
    assert amplitude_of(machine, float(np.mean(energy))) == pytest.approx(amplitude, rel=1e-13)


def test_the_amplitude_is_that_of_the_last_swings():
    scene, swings = scene_of(), 300
    stamps = scene.starts_at_ns + np.arange(swings) * 10**9
    sizes = np.where(np.arange(swings) < 200, 0.2, 0.7)
    turned = np.arange(swings) * 1.7
    wheel = replace(
        scalars(stamps, ('wheel',), (sizes * np.cos(turned))[:, None]),
        velocity=(-OMEGA * sizes * np.sin(turned))[:, None],
    )
    tally = SwingTally(scene)
    tally.feed({JOINT_STATES: wheel})
    assert tally.result()['amplitude_rad'] == pytest.approx(0.7, rel=1e-12)


@settings(max_examples=6, deadline=None)
@given(log_k=st.floats(-2.0, 2.5), release=st.floats(0.3, 62.0), every=st.sampled_from([1, 7, 41]))
def test_a_swing_of_any_width_goes_on_wherever_its_run_ends(log_k, release, every):
    """k = b A √(m/I) says how much of the inertia is the weight's: the period grows with it."""
    mass = HEAVY['inertia'] * (10.0**log_k / (HEAVY['cam']['base_radius'] * release)) ** 2
    heavy = HEAVY | {'power': {'kind': 'weight', 'mass': mass}, 'release_angle': release}
    period_s = compile_machine(scene_of(trochlea=heavy)).period(release)
    interval_s = max(round(period_s / 23.0, 9), 1e-9)
    scene = scene_of(
        trochlea=heavy,
        log={'interval': interval_s},
        drift={'observation_interval': interval_s},
        duration=round(90 * interval_s, 9),
    )
    assert set(verdicts(scene, every)) == {(None, None)}


GOING = {
    'wide': {'trochlea': IDEAL | {'release_angle': 57.0, **INVOLUTE}},
    'struck hard': {
        'trochlea': HEAVY | {'release_angle': 3.0},
        'drag': {'viscous': 1e-7},
        'escapement': {'kind': 'impulse', 'energy': 5.0},
    },
    'recoil': {
        'escapement': {'energy': 1e-3, 'angle': 0.3, 'rest': {'recoil': 0.1 * STIFFNESS}},
        'drag': {'viscous': 1e-5},
    },
    'wide at sea': {'trochlea': HEAVY | {'release_angle': 3.0}, 'ship': ROLL},
    'hanging_thread_at_sea': {},
    'sully_lever_at_sea': {},
}


@pytest.mark.parametrize('name', GOING)
def test_a_clock_that_goes_has_not_stopped_wherever_its_run_ends(name):
    shipped = name if name.endswith('_at_sea') else 'ideal'
    scene = load_scene(shipped, duration=8.0, log={'interval': 0.05}, **GOING[name])
    assert set(verdicts(scene, 23)) == {(None, None)}


MIDDLE, AWAY = 'did not pass the middle', 'had died away'
STOPPED = {
    'held by friction': ({'drag': {'coulomb': 0.03 * STIFFNESS}}, MIDDLE),
    'held where it was released': ({'drag': {'coulomb': 2.0 * STIFFNESS}}, MIDDLE),
    'overdamped': ({'drag': {'viscous': 1.0}}, MIDDLE),
    'wide and overdamped': (GOING['wide'] | {'drag': {'viscous': 1.0}}, MIDDLE),
    'quality factor 2': ({'drag': {'viscous': 0.5 * IDEAL['inertia'] * OMEGA}}, AWAY),
    'impulse out of reach': (
        {'drag': {'viscous': 1e-4}, 'escapement': {'energy': 1e-9, 'angle': 0.6}},
        'too small to reach the impulse, at 0.600 rad',
    ),
}


@pytest.mark.parametrize('name', STOPPED)
def test_a_clock_that_stopped_is_found_wherever_its_run_ends(name):
    """Once found it stays found, with the same time."""
    changes, why = STOPPED[name]
    scene = scene_of(**changes, duration=40.0, log={'interval': 0.05})
    found = list(verdicts(scene, 5))
    first = next(k for k, (stopped_s, _) in enumerate(found) if stopped_s is not None)
    assert len(set(found[first:])) == 1
    assert why in found[-1][1]
