"""Action–angle and forced harmonic against golden periods, energy and the exact roll."""

import json
import math
from pathlib import Path

import mpmath
import numpy as np
import pytest
from motion_cases import (
    INERTIA,
    LEVER,
    OMEGA,
    TOO_SMALL_TO_MATTER,
    arc,
    rolling,
    run,
    scene_of,
    spans_to,
    weight_of,
)

from tauto_core.clockwork import TrochleaStage
from tauto_core.machines import compile_machine
from tauto_core.motion import make_propagator, propagator_name
from tauto_core.samples import JOINT_STATES, PHASE
from tauto_core.scene.errors import PropagationError
from tauto_core.ship import ShipMotion

GOLDEN = json.loads((Path(__file__).parents[1] / 'golden.json').read_text())['entries']
WEIGHTS = [e for e in GOLDEN if e['id'].startswith('A20-weight-inertia')]
OWN_OF_WEIGHT = {
    'cam': {'kind': 'weight_corrected', 'period': 2.0},
    'power': {'kind': 'weight', 'mass': 0.05},
    'thread': {'kind': 'hole', 'distance': 0.2},
}
OWN_OF_SPRING = {
    'cam': {'kind': 'spring_corrected', 'period': 1.0},
    'power': {'kind': 'spring', 'force': 2.0, 'stiffness': 50.0},
    'thread': {'kind': 'hole', 'distance': 0.05},
}
HANGING = {'kind': 'hanging', 'length': 0.3}
WEIGHT = weight_of(0.2, 0.01)
MASSLESS = {**WEIGHT, 'power': {**WEIGHT['power'], 'massless': True}}


@pytest.mark.parametrize('entry', WEIGHTS, ids=lambda e: e['id'])
def test_golden_periods_after_a_million_swings(entry):
    """Released at A, the wheel is back after N = 10⁶ periods of golden.json.

    Near the top the rate shows the error, θ̇ ≈ −θ̈ N δT. A relative error of 1e-14 in T is 6e-8 rad
    of phase, and rounding the time to a nanosecond adds ω·0.5 ns.
    """
    p = {k: float(v['value']) for k, v in entry['params'].items()}
    disc = 1.0
    mass = disc * p['P_over_Q']
    scene = scene_of(
        gravity=p['g'],
        trochlea=weight_of(
            mass, p['r'], inertia=0.5 * disc * p['disc_radius'] ** 2, release_angle=p['A']
        ),
    )
    machine = compile_machine(scene)
    engine = make_propagator(machine, still=True)
    assert engine.name == 'action_angle'
    period = mpmath.mpf(entry['expected']['T_s'])
    time_ns = int(mpmath.nint(10**6 * period * 10**9))
    end = engine.advance(spans_to([time_ns]))
    assert round(float(end.half_turns[0] + end.fraction[0])) == 2 * 10**6
    acceleration = machine.gravity * mass * p['r'] * p['A'] / float(machine.mass(p['A']))
    late = time_ns * 1e-9 - float(10**6 * period)
    phase_error = (end.rate[0] / acceleration + late) * machine.frequency
    assert abs(phase_error) < 1e-7


@pytest.mark.parametrize('amplitude', [1e-9, 0.3, 3.0, math.pi * (1 - 1e-9)])
def test_action_angle_keeps_the_energy_up_to_the_edge(amplitude):
    thread = {'kind': 'vertical'}
    cheek = {'cam': arc(0.02, 0.01), 'thread': thread, 'release_angle': amplitude}
    machine = compile_machine(scene_of(trochlea=cheek))
    engine = make_propagator(machine, still=True)
    assert engine.name == 'action_angle'
    times = np.cumsum(np.random.default_rng(2).integers(1, 10**12, 200))
    motion = engine.advance(spans_to(times))
    energy = 0.5 * machine.mass(motion.angle) * motion.rate**2 + machine.potential(motion.angle)
    top = float(machine.potential(amplitude))
    np.testing.assert_allclose(energy, top, rtol=1e-12)
    assert np.all((motion.fraction >= 0.0) & (motion.fraction < 1.0))


@pytest.mark.parametrize(
    ('sections', 'still', 'name'),
    [
        ({}, True, 'harmonic'),
        ({}, False, 'forced_harmonic'),
        ({'drag': {'viscous': 1e-6}}, True, 'forced_harmonic'),
        ({'drag': {'viscous': 1e-6}}, False, 'forced_harmonic'),
        ({'drag': {'viscous': 0.05}}, True, 'collocation'),
        ({'drag': {'coulomb': 1e-6}}, False, 'collocation'),
        ({'escapement': {'energy': 1e-6}}, True, 'collocation'),
        ({'trochlea': WEIGHT}, True, 'action_angle'),
        ({'trochlea': WEIGHT}, False, 'collocation'),
        ({'trochlea': MASSLESS}, True, 'harmonic'),
        ({'trochlea': MASSLESS}, False, 'collocation'),
        ({'trochlea': {'power': {**OWN_OF_SPRING['power'], 'force': 3.0}}}, True, 'action_angle'),
        ({'trochlea': OWN_OF_WEIGHT}, True, 'harmonic'),
        ({'trochlea': OWN_OF_WEIGHT}, False, 'collocation'),
        ({'trochlea': OWN_OF_WEIGHT, 'drag': {'viscous': 1e-6}}, True, 'collocation'),
        ({'trochlea': OWN_OF_WEIGHT, 'escapement': {'energy': 1e-6}}, True, 'collocation'),
        ({'trochlea': OWN_OF_SPRING, 'drag': {'viscous': 1e-6}}, True, 'forced_harmonic'),
        ({'trochlea': OWN_OF_SPRING, 'drag': {'viscous': 1e-6}}, False, 'forced_harmonic'),
        ({'trochlea': OWN_OF_SPRING, 'drag': {'viscous': 1.0}}, True, 'collocation'),
        ({'trochlea': LEVER}, True, 'action_angle'),
        ({'trochlea': LEVER}, False, 'collocation'),
        ({'trochlea': LEVER, 'escapement': {'energy': 1e-4}}, True, 'collocation'),
        ({'trochlea': {**LEVER, 'thread': HANGING}}, True, 'collocation'),
    ],
)
def test_the_cheapest_propagator_that_is_exact_is_chosen(sections, still, name):
    assert propagator_name(compile_machine(scene_of(**sections)), still=still) == name


ROLL = [(0.15, 8.2, 1.0), (0.04, 6.3, -0.5), (0.02, 3.1, 2.0)]


def exact_wheel(t, viscous):
    """θ under Σ a cos(Ωt + ε) of roll: the forced response and the free swing that starts it."""
    delta = viscous / (2 * INERTIA)
    w = np.sqrt(OMEGA**2 - delta**2)
    omegas = np.array([2 * np.pi / period for _, period, _ in ROLL])
    roll = np.array([a * np.exp(1j * phase) for a, _, phase in ROLL])
    # θ'' + 2δθ' + ω₀²θ = −ρ''
    gain = roll * omegas**2 / (OMEGA**2 - omegas**2 + 2j * delta * omegas)
    theta0 = 1.0 - np.sum(gain).real
    rate0 = -np.sum(1j * omegas * gain).real
    free = theta0 * np.cos(w * t) + (rate0 + delta * theta0) / w * np.sin(w * t)
    forced = np.sum(gain * np.exp(1j * np.outer(t, omegas)), axis=1).real
    return np.exp(-delta * t) * free + forced


@pytest.mark.parametrize(('viscous', 'days'), [(0.0, 1), (1e-9, 0.25)])
def test_a_day_of_the_second_cam_at_sea_against_the_exact_roll(viscous, days):
    """With the error of sampling at 20 Hz. 1e-9 s/day would be 7e-9 rad after a day."""
    scene = scene_of(
        ship=rolling(*ROLL, height=0.0),
        duration=86_400.0 * days,
        log={'interval': 3600.0},
        drag={'viscous': viscous} if viscous else None,
    )
    ship, stage = ShipMotion(scene), TrochleaStage(scene)
    angle, beats = [], []
    while True:
        batch = ship.produce(1 << 18)
        if not len(batch.stamp_ns):
            break
        said = stage.feed({'ship/imu': batch})
        if said:
            angle.append(said[JOINT_STATES].position[:, 0])
            beats.append(said[PHASE].position[:, 3])
    times = np.arange(scene.log_count) * 3600.0
    exact = exact_wheel(times, viscous)
    np.testing.assert_allclose(np.concatenate(angle), exact, rtol=0, atol=2e-9)
    assert abs(np.concatenate(beats)[-1] - OMEGA * times[-1] / np.pi) <= 1.0


def test_coarse_samples_are_enough_where_nothing_is_fitted():
    """Under four samples in the shortest wave. The error left is the one-sided first piece's."""
    found = run(
        scene_of(ship=rolling(*ROLL, height=0.0, rate=1.25), duration=800.0, log={'interval': 3.2})
    )
    angle = found[JOINT_STATES].position[:, 0]
    exact = exact_wheel(3.2 * np.arange(len(angle)), 0.0)
    # a window with one sample more on either side, not three, leaves 2e-6
    np.testing.assert_allclose(angle, exact, rtol=0, atol=2e-7)


def test_forced_harmonic_stops_at_the_edge_of_the_cam():
    """Roll at resonance: θ grows until the cam ends, when the general engine finds it."""
    ship = rolling((0.2, 2 * math.pi / OMEGA, 0.4), height=0.0)
    cam = {
        'cam': {'kind': 'hole', 'lever_rate': 0.01},
        'thread': {'kind': 'hole', 'distance': 0.02},
    }
    times = []
    for drag in (None, TOO_SMALL_TO_MATTER):
        with pytest.raises(PropagationError, match='edge of the cam at ±2 rad') as caught:
            run(scene_of(trochlea=cam, ship=ship, drag=drag))
        times.append(caught.value.time_s)
    # within a part of 50 ms the case's part of θ is a cubic: 4e-5 · 0.2 rad off, at 14 rad/s
    assert times[0] == pytest.approx(times[1], abs=6e-7)
