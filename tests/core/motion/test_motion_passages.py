"""The counts of the dial: turns at upward passages of ϑ, beats at passages of θ (reading.md).

The references count signs on a grid far finer than the distance of two passages.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from motion_cases import FORCE, INERTIA, LEVER_RATE, OMEGA, TOO_SMALL_TO_MATTER, phases, scene_of
from scipy.integrate import solve_ivp

from tauto_core.api import sail
from tauto_core.clockwork import TrochleaStage
from tauto_core.motion.forcing import polar
from tauto_core.samples import JOINT_STATES, PHASE, READING, ImuSamples
from tauto_core.ship import ShipMotion

ROLL = [
    {'amplitude': 0.1, 'period': 9.0, 'phase': 0.3},
    {'amplitude': 0.05, 'period': 5.3, 'phase': 1.1},
]
HEAVE = [{'amplitude': 0.4, 'period': 7.7, 'phase': 0.4}]
SHIP = {'kind': 'components', 'components': ROLL, 'heave': HEAVE, 'height': 3.0}
ROLLING = {'kind': 'components', 'components': ROLL}
SEA = {
    'kind': 'sea',
    'sea': {'spectrum': 'jonswap', 'significant_wave_height': 3.0, 'peak_period': 9.0},
    'roll': {'natural_period': 11.0, 'damping_ratio': 0.1, 'slope_coefficient': 0.8},
    'heave': True,
}
WEIGHT = {
    'inertia': 8e-3,
    'cam': {'kind': 'involute', 'base_radius': 0.012},
    'thread': {'kind': 'vertical'},
    'power': {'kind': 'weight', 'mass': 0.15},
}
ARC = {**WEIGHT, 'cam': {'kind': 'circular_arc', 'radius': 0.02, 'root_depth': 0.01}}
HANGING = {**WEIGHT, 'thread': {'kind': 'hanging', 'length': 0.8}}
ESCAPEMENT = {'kind': 'impulse', 'energy': 1e-6, 'angle': 0.0}
SYMMETRIC: dict[str, dict[str, Any]] = {
    'forced harmonic': {},
    'general engine': {'drag': TOO_SMALL_TO_MATTER},
    'weight': {'trochlea': WEIGHT},
    'cheek before Euler, clock': {
        'trochlea': ARC,
        'drag': {'viscous': 1e-5},
        'escapement': ESCAPEMENT,
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


def counted(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return upward passages and all passages of zero up to each sample."""
    below = values < 0.0
    up, all_ = below[:-1] & ~below[1:], below[:-1] != below[1:]
    return np.concatenate([[0], np.cumsum(up)]), np.concatenate([[0], np.cumsum(all_)])


FINE = 500
"""Points of the reference's grid in a second."""
SECONDS = 30


def waves(series: list[dict[str, float]], t: Any, order: int) -> Any:
    """A sum of cosines, or a time derivative of it."""
    return sum(
        c['amplitude']
        * (math.tau / c['period']) ** order
        * np.cos(math.tau * t / c['period'] + c['phase'] + 0.5 * math.pi * order)
        for c in series
    )


def apparent_vertical(t: Any) -> tuple[Any, Any, Any]:
    """β, β̇ and g_eff at the clock, 3 m above the roll axis (ship.md)."""
    roll, rate, bend, jerk = (waves(ROLL, t, k) for k in range(4))
    c, s = np.cos(roll), np.sin(roll)
    y, up = 3.0 * (rate**2 * s - bend * c), 9.80665 + waves(HEAVE, t, 2)
    up = up - 3.0 * (bend * s + rate**2 * c)
    y_rate = -3.0 * (jerk * c - 3.0 * bend * rate * s - rate**3 * c)
    up_rate = waves(HEAVE, t, 3) - 3.0 * (jerk * s + 3.0 * bend * rate * c - rate**3 * s)
    square = y * y + up * up
    return np.arctan2(-y, up), (y * up_rate - y_rate * up) / square, np.sqrt(square)


def swing_at_sea(follows: bool, amplitude: float) -> tuple[np.ndarray, ...]:
    """Return ϑ, ϑ̇ and θ on the grid, by DOP853 from ϑ and the momentum (machine_at_sea.md).

    A weight's thread `follows` the apparent vertical, another one the case.
    """
    inertia, mass, arm = (8e-3, 0.15, 0.012) if follows else (INERTIA, 0.0, LEVER_RATE)

    def outside(t: Any) -> tuple[Any, Any, Any]:
        if follows:
            vertical, rate, gravity = apparent_vertical(t)
            return vertical, rate, mass * gravity
        return waves(ROLL, t, 0), waves(ROLL, t, 1), FORCE

    def rate_of(felt: Any, momentum: Any, line_rate: Any) -> Any:
        return (momentum - inertia * line_rate) / (inertia + mass * (arm * felt) ** 2)

    def slopes(t: float, y: np.ndarray) -> list[float]:
        _, line_rate, pull = outside(t)
        rate = rate_of(y[0], y[1], line_rate)
        return [rate, mass * arm * arm * y[0] * rate * rate - pull * arm * y[0]]

    line, line_rate, _ = outside(0.0)
    felt = amplitude + waves(ROLL, 0.0, 0) - line
    rate = waves(ROLL, 0.0, 1) - line_rate
    momentum = (inertia + mass * (arm * felt) ** 2) * rate + inertia * line_rate
    found = solve_ivp(
        slopes,
        (0.0, SECONDS),
        [felt, momentum],
        'DOP853',
        rtol=1e-12,
        atol=1e-12 * abs(amplitude) * np.array([1.0, inertia]),
        dense_output=True,
        max_step=0.2,
    )
    t = np.arange(SECONDS * FINE + 1) / FINE
    assert found.sol is not None
    felt, momentum = found.sol(t)
    line, line_rate, _ = outside(t)
    return felt, rate_of(felt, momentum, line_rate), felt + line - waves(ROLL, t, 0)


CASES: dict[str, tuple[bool, dict[str, Any]]] = {
    'forced harmonic': (False, {'ship': ROLLING}),
    'general engine': (False, {'ship': ROLLING, 'drag': TOO_SMALL_TO_MATTER}),
    'weight': (True, {'ship': SHIP, 'trochlea': WEIGHT}),
}


@pytest.mark.parametrize('name', CASES)
@pytest.mark.parametrize('amplitude', [-0.1, -2e-3, 1e-4])
def test_turns_and_beats_are_those_of_an_independent_integration(name, amplitude):
    """From swings that outweigh the roll tenfold to ones that it outweighs a hundredfold."""
    follows, sections = CASES[name]
    trochlea = {**sections.get('trochlea', {}), 'release_angle': amplitude}
    changed = {'log': {'interval': 1.0}, 'trochlea': trochlea, 'duration': float(SECONDS)}
    scene = scene_of(**{**sections, **changed})
    motion = ShipMotion(scene)
    batches = TrochleaStage(scene).feed({'ship/imu': motion.produce(motion.total)})
    felt, rate, angle = swing_at_sea(follows, amplitude)
    up, _ = counted(felt)
    _, beats = counted(angle)
    omega = math.sqrt(0.15 * 9.80665 * 0.012 / 8e-3) if follows else OMEGA
    arc = felt
    if follows:
        k = math.sqrt(0.15 / 8e-3) * 0.012
        arc = 0.5 * (felt * np.sqrt(1.0 + (k * felt) ** 2) + np.arcsinh(k * felt) / k)
        rate = rate * np.sqrt(1.0 + (k * felt) ** 2)
    turned = math.tau * up + polar(arc, rate, rate, omega)
    phase = batches[PHASE].position
    logged = slice(None, None, FINE)
    np.testing.assert_array_equal(phase[:, 3], beats[logged])
    # the smallest swing is 1e-4 rad, known to 1e-11: phase within 1e-6 rad or so
    np.testing.assert_allclose(phase[:, 0], (turned - turned[0])[logged], rtol=0, atol=1e-4)


@pytest.mark.parametrize('drag', [{}, {'drag': TOO_SMALL_TO_MATTER}], ids=['exact', 'stepped'])
def test_a_wheel_started_by_the_roll_begins_at_phase_zero(drag):
    runs = []
    for phase in (0.3, 0.3 + math.pi):
        roll = [{'amplitude': 0.1, 'period': 9.0, 'phase': phase}]
        ship = {'kind': 'components', 'components': roll}
        runs.append(phases(scene_of(trochlea={'release_angle': 0.0}, ship=ship, **drag)))
    one, mirrored = runs
    np.testing.assert_allclose(one[:, 0], mirrored[:, 0], rtol=0, atol=1e-9)
    assert 0.0 < one[1, 0] < 0.5


@pytest.mark.parametrize('phase', [0.3, 0.3 + math.pi])
def test_a_wheel_on_a_swinging_thread_leaves_zero_without_a_beat(phase):
    trochlea = {
        'cam': {'kind': 'involute', 'base_radius': 0.01},
        'thread': {'kind': 'hanging', 'length': 1.0},
        'power': {'kind': 'weight', 'mass': 0.2},
        'release_angle': 0.0,
    }
    roll = [{'amplitude': 0.1, 'period': 9.0, 'phase': phase}]
    ship = {'kind': 'components', 'components': roll}
    assert phases(scene_of(trochlea=trochlea, ship=ship, duration=1.0))[1, 3] == 0.0


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
        ship={**SHIP, 'components': [{'amplitude': 0.1, 'period': 9.0, 'phase': phase}]},
        suspension=suspension,
        log={'interval': 0.05},
        duration=4.0,
    )
    voyage = sail(scene)
    angle = voyage.angle_rad[voyage.time_s > 0.0]
    passed = np.count_nonzero(np.diff(np.sign(angle)))
    assert 0 < passed == voyage.samples[PHASE].position[-1, 3]
