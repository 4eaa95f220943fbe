"""The counts of the dial: turns at upward passages of ϑ, beats at passages of θ (reading.md)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from motion_cases import (
    TOO_SMALL_TO_MATTER,
    WEIGHT,
    arc,
    impulse,
    moved,
    phases,
    rolling,
    sampled,
    scene_of,
    waves,
    weight_of,
)
from reference_propagator import Reference

from tauto_core.api import sail
from tauto_core.clockwork import TrochleaStage
from tauto_core.machines import compile_machine
from tauto_core.motion import make_propagator
from tauto_core.samples import JOINT_STATES, PHASE, READING, ImuSamples
from tauto_core.ship import ShipMotion

ROLLING = rolling((0.1, 9.0, 0.3), (0.05, 5.3, 1.1))
SHIP = {**ROLLING, 'heave': waves((0.4, 7.7, 0.4)), 'height': 3.0}
SEA = {
    'kind': 'sea',
    'sea': {'spectrum': 'jonswap', 'significant_wave_height': 3.0, 'peak_period': 9.0},
    'roll': {'natural_period': 11.0, 'damping_ratio': 0.1, 'slope_coefficient': 0.8},
    'heave': True,
}
HANGING = {**WEIGHT, 'thread': {'kind': 'hanging', 'length': 0.8}}
SYMMETRIC: dict[str, dict[str, Any]] = {
    'forced harmonic': {},
    'general engine': {'drag': TOO_SMALL_TO_MATTER},
    'weight': {'trochlea': WEIGHT},
    'cheek before Euler, clock': {
        'trochlea': {**WEIGHT, 'cam': arc(0.02, 0.01)},
        'drag': {'viscous': 1e-5},
        'escapement': impulse(1e-6),
    },
    'swinging thread': {'trochlea': HANGING},
}


def mirrored(imu: ImuSamples) -> ImuSamples:
    """Port for starboard."""
    return replace(
        imu,
        orientation=imu.orientation * np.array([-1.0, 1.0, -1.0, 1.0]),
        angular_velocity=imu.angular_velocity * np.array([-1.0, 1.0, -1.0]),
        linear_acceleration=imu.linear_acceleration * np.array([1.0, -1.0, 1.0]),
    )


@pytest.mark.parametrize(
    ('name', 'ship', 'amplitude'),
    [*((name, SHIP, 1.0) for name in SYMMETRIC), ('weight', SEA, 0.02)],
)
def test_mirror_images_read_alike(name, ship, amplitude):
    sections = dict(SYMMETRIC[name])
    trochlea = sections.pop('trochlea', {})
    found = []
    for release, port in ((amplitude, False), (-amplitude, True)):
        scene = scene_of(
            ship=ship,
            duration=30.0,
            log={'interval': 1.0},
            trochlea={**trochlea, 'release_angle': release},
            **sections,
        )
        motion = ShipMotion(scene)
        imu = motion.produce(motion.total)
        found.append(TrochleaStage(scene).feed({'ship/imu': mirrored(imu) if port else imu}))
    one, other = found
    swing, image = one[JOINT_STATES].position[:, 0], other[JOINT_STATES].position[:, 0]
    # what differs is the rounding of angles that differ by a half turn
    np.testing.assert_allclose(image, -swing, rtol=0, atol=1e-11)
    np.testing.assert_array_equal(one[PHASE].position[:, 3], other[PHASE].position[:, 3])
    phase, mirror = one[PHASE].position[:, 0], other[PHASE].position[:, 0]
    np.testing.assert_allclose(mirror, phase, rtol=0, atol=1e-8)
    dial = one[READING].time_ref_ns - other[READING].time_ref_ns
    assert np.max(np.abs(dial)) <= 100


CASES: dict[str, dict[str, Any]] = {
    'forced harmonic': {'ship': ROLLING},
    'general engine': {'ship': ROLLING, 'drag': TOO_SMALL_TO_MATTER},
    'weight': {'ship': SHIP, 'trochlea': WEIGHT},
}


@pytest.mark.parametrize('name', CASES)
@pytest.mark.parametrize('amplitude', [-0.1, -2e-3, 1e-4])
def test_turns_and_beats_are_those_of_an_independent_integration(name, amplitude):
    """From swings that outweigh the roll to ones that it outweighs a hundredfold."""
    trochlea = {**CASES[name].get('trochlea', {}), 'release_angle': amplitude}
    changed = {'log': {'interval': 1.0}, 'trochlea': trochlea, 'duration': 30.0}
    scene = scene_of(**{**CASES[name], **changed})
    machine = compile_machine(scene)
    forcing = sampled(scene, machine, 8)
    engines = make_propagator(machine, still=False), Reference(machine)
    found, exact = (moved(engine, forcing) for engine in engines)
    np.testing.assert_array_equal(found.beats, exact.beats)
    turned, wanted = (motion.half_turns + motion.fraction for motion in (found, exact))
    # the smallest swing is 1e-4 rad, known to 1e-11: phase within 1e-6 rad or so
    np.testing.assert_allclose(turned, wanted, rtol=0, atol=1e-5)


@pytest.mark.parametrize('drag', [{}, {'drag': TOO_SMALL_TO_MATTER}], ids=['exact', 'stepped'])
def test_a_wheel_started_by_the_roll_begins_at_phase_zero(drag):
    runs = []
    for phase in (0.3, 0.3 + math.pi):
        ship = rolling((0.1, 9.0, phase))
        runs.append(phases(scene_of(trochlea={'release_angle': 0.0}, ship=ship, **drag)))
    one, mirrored = runs
    np.testing.assert_allclose(one[:, 0], mirrored[:, 0], rtol=0, atol=1e-9)
    assert 0.0 < one[1, 0] < 0.5


@pytest.mark.parametrize('phase', [0.3, 0.3 + math.pi])
def test_a_wheel_on_a_swinging_thread_leaves_zero_without_a_beat(phase):
    thread = {'kind': 'hanging', 'length': 1.0}
    scene = scene_of(
        trochlea=weight_of(0.2, 0.01, thread=thread, release_angle=0.0),
        ship=rolling((0.1, 9.0, phase)),
        duration=1.0,
    )
    assert phases(scene)[1, 3] == 0.0


@pytest.mark.parametrize('phase', [0.3, 0.3 + math.pi])
def test_a_wheel_in_a_hung_case_leaves_zero_without_a_beat(phase):
    """The case begins to swing with the fifth power of time: rounding moves it first."""
    suspension = {
        'kind': 'axle',
        'support_radius': 0.15,
        'axle_radius': 0.05,
        'depth': 0.3,
        'gyration_radius': 0.15,
    }
    scene = scene_of(
        trochlea={**WEIGHT, 'release_angle': 0.0},
        ship={**SHIP, 'components': waves((0.1, 9.0, phase))},
        suspension=suspension,
        log={'interval': 0.05},
        duration=4.0,
    )
    voyage = sail(scene)
    angle = voyage.angle_rad[voyage.time_s > 0.0]
    passed = np.count_nonzero(np.diff(np.sign(angle)))
    assert 0 < passed == voyage.samples[PHASE].position[-1, 3]
