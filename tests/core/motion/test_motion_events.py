"""Drag, escapement and the limits of a thread, against closed forms of a harmonic machine.

Tolerances are a few hundred roundings of the amplitude, from about a hundred swings.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from motion_cases import (
    FORCE,
    INERTIA,
    LEVER_RATE,
    OMEGA,
    TOO_SMALL_TO_MATTER,
    angles,
    arc,
    impulse,
    phases,
    rolling,
    run,
    scene_of,
    waves,
    weight_of,
)
from scipy.optimize import brentq

from tauto_core.clockwork import TrochleaStage
from tauto_core.samples import JOINT_STATES, PHASE
from tauto_core.scene.errors import PropagationError
from tauto_core.scene.loader import Solver
from tauto_core.ship import ShipMotion

STIFFNESS, G = FORCE * LEVER_RATE, 9.80665


def test_viscous_drag_is_the_damped_oscillator():
    drag = {'viscous': 2e-5}
    times, angle, rate = angles(scene_of(drag=drag))
    decay = drag['viscous'] / (2 * INERTIA)
    w = math.sqrt(OMEGA**2 - decay**2)
    exact = np.exp(-decay * times) * (np.cos(w * times) + decay / w * np.sin(w * times))
    np.testing.assert_allclose(angle, exact, rtol=0, atol=2e-13)
    slope = -np.exp(-decay * times) * OMEGA**2 / w * np.sin(w * times)
    np.testing.assert_allclose(rate, slope, rtol=0, atol=1e-11)


def test_overdamped_wheel_creeps_home():
    drag = TOO_SMALL_TO_MATTER | {'viscous': 0.05}
    times, angle, _ = angles(scene_of(drag=drag, duration=20.0))
    decay = drag['viscous'] / (2 * INERTIA)
    w = math.sqrt(decay**2 - OMEGA**2)
    slow, fast = -(OMEGA**2) / (decay + w), -(decay + w)
    exact = (slow * np.exp(fast * times) - fast * np.exp(slow * times)) / (slow - fast)
    np.testing.assert_allclose(angle, exact, rtol=0, atol=1e-12)


def test_coulomb_friction_shortens_swings_alike_then_holds():
    friction = 0.03 * STIFFNESS
    shift = friction / STIFFNESS
    times, angle, rate = angles(scene_of(drag={'coulomb': friction}))
    half = math.pi / OMEGA
    swing = np.floor(times / half).astype(int)
    last = next(n for n in range(100) if 1.0 - 2 * n * shift <= shift)
    n = np.minimum(swing, last)
    amplitude = 1.0 - 2 * n * shift
    moving = (-1.0) ** n * ((amplitude - shift) * np.cos(OMEGA * (times - n * half)) + shift)
    exact = np.where(swing < last, moving, (-1.0) ** last * amplitude)
    np.testing.assert_allclose(angle, exact, rtol=0, atol=1e-12)
    assert np.all(rate[swing > last] == 0.0)
    stuck_short_of_zero = 1.0 - 2 * last * shift < 0.0
    assert phases(scene_of(drag={'coulomb': friction}))[-1, 3] == last - stuck_short_of_zero


def test_quadratic_drag_shortens_swings_by_the_first_integral():
    c = 5e-6
    kappa = 2 * c / INERTIA
    drag = TOO_SMALL_TO_MATTER | {'quadratic': c}
    times, angle, rate = angles(scene_of(drag=drag, log={'interval': 0.001}, duration=20.0))
    amplitude, found = 1.0, []
    sign = np.sign(rate)
    for k in np.flatnonzero((sign[1:] != sign[:-1]) & (sign[:-1] != 0.0)):
        # within 1 ms of the turning point θ is a parabola to 1e-11
        a = np.polyfit(times[k - 1 : k + 3] - times[k], angle[k - 1 : k + 3], 3)
        found.append(np.max(np.abs(np.polyval(a, np.linspace(-0.001, 0.002, 3001)))))
    for measured in found:
        # θ'' + ω²θ = ∓(κ/2) θ'²: (1 − κB) e^(κB) = (1 + κA) e^(−κA) from A to the next B
        def excess(b, a=amplitude):
            left = (1 + kappa * a) * math.exp(-kappa * a)
            return (1 - kappa * b) * math.exp(kappa * b) - left

        amplitude = brentq(excess, 0.1 * amplitude, amplitude, xtol=1e-15)
        assert measured == pytest.approx(amplitude, abs=2e-9)
    assert len(found) > 40


def swings_with_impulses(energy, where, count):
    """(from, start, A, sign) of harmonic arcs θ = sign·A cos ω(t − start), piece by piece."""
    arcs, start, amplitude, sign = [], 0.0, 1.0, 1.0
    for _ in range(count):
        before = math.acos(-where / amplitude)
        arcs.append((start, start, amplitude, sign))
        hit = start + before / OMEGA
        gained = 2 * energy / INERTIA / OMEGA**2
        larger = math.sqrt(amplitude**2 + gained)
        shifted = hit - math.acos(-where / larger) / OMEGA
        arcs.append((hit, shifted, larger, sign))
        start, amplitude, sign = shifted + math.pi / OMEGA, larger, -sign
    return np.array(arcs)


@pytest.mark.parametrize(
    ('energy', 'where', 'duration', 'interval', 'atol'),
    [
        *((2e-5, where, 100.0, 0.05, 1e-11) for where in (0.0, 0.2, -0.3)),
        # 20 ms before a turning point, where a time is known to 1e-15/0.02 only
        (2e-5, 0.99, 20.0, 0.5, 1e-10),
        # 0.2 µs, 20 µs and 2 ms after the release, where a rounding of the angle is one of
        # 1e-16/√(2·short) rad of phase
        *(
            (2e-5, short - 1.0, 20.0, 0.05, 1e-11 + 1e-15 / math.sqrt(2.0 * short))
            for short in (1e-12, 1e-8, 1e-4)
        ),
        # 16,000 beats between two logs, each timed to a rounding of 7200 s
        (1e-7, 0.0, 7200.0, 7200.0, 1e-8),
    ],
)
def test_impulses_add_their_energy_once_a_beat_at_their_angle(
    energy, where, duration, interval, atol
):
    escapement = impulse(energy, where)
    scene = scene_of(escapement=escapement, duration=duration, log={'interval': interval})
    times, angle, rate = angles(scene)
    arcs = swings_with_impulses(energy, where, round(duration * OMEGA / math.pi) + 20)
    _, start, amplitude, sign = arcs[np.searchsorted(arcs[:, 0], times, 'right') - 1].T
    exact = sign * amplitude * np.cos(OMEGA * (times - start))
    slope = -sign * amplitude * OMEGA * np.sin(OMEGA * (times - start))
    np.testing.assert_allclose(angle, exact, rtol=0, atol=atol)
    np.testing.assert_allclose(rate, slope, rtol=0, atol=10.0 * atol)


@pytest.mark.parametrize('tolerance', [1e-3, 1e-9])
@pytest.mark.parametrize('angle', [0.0, 0.3])
def test_beats_and_turns_do_not_depend_on_how_long_the_steps_are(tolerance, angle):
    """At 1e-3 steps go from impulse to impulse. Logged often, and only at the end."""
    energy = 1e-6
    sections = {'escapement': impulse(energy, angle), 'solver': {'tolerance': tolerance}}
    often, rare = (
        phases(scene_of(duration=120.0, log={'interval': interval}, **sections))
        for interval in (0.5, 120.0)
    )
    arcs = swings_with_impulses(energy, angle, 300)
    times = np.arange(0.0, 120.25, 0.5)
    row = np.searchsorted(arcs[:, 0], times, 'right') - 1
    turned = OMEGA * (times - arcs[row, 1])
    # except near an arrival
    sure = np.abs(np.cos(turned)) > 1e-2
    beats = row // 2 + (turned > 0.5 * math.pi)
    np.testing.assert_array_equal(often[sure, 3], beats[sure])
    assert rare[-1, 3] == often[-1, 3]
    assert rare[-1, 0] == pytest.approx(often[-1, 0], abs=1e-4 if tolerance > 1e-6 else 1e-7)


def test_a_wheel_that_nothing_moves_stays_where_it_is():
    scene = scene_of(
        trochlea=weight_of(0.2, 0.01, release_angle=0.0),
        drag={'viscous': 1e-6},
        escapement=impulse(1e-5, 0.1),
        ship=rolling((0.0, 9.0)),
    )
    _, angle, rate = angles(scene)
    assert np.all(angle == 0.0)
    assert np.all(rate == 0.0)


def test_noise_in_the_force_loses_no_turns():
    """Pieces through noisy forces do not join smoothly, but the phase still follows the beats.

    A beat of θ is half a turn of the phase, except for the last one and for passages that the
    noise doubles: one here.
    """
    ship = rolling((0.2, 7.0, 0.4))
    scene = scene_of(trochlea=weight_of(0.2, 0.01), ship=ship, duration=600.0)
    ship = ShipMotion(scene)
    imu = ship.produce(ship.total)
    noise = 0.2 * np.random.default_rng(1).standard_normal(imu.linear_acceleration.shape)
    noisy = replace(imu, linear_acceleration=imu.linear_acceleration + noise)
    phase = TrochleaStage(scene).feed({'ship/imu': noisy})[PHASE].position
    # 50 ms of a swing of 0.89 s are 0.35 rad, and a lost turn is 6.28
    assert np.max(np.abs(np.diff(phase[:, 0]))) < 1.0
    assert abs(phase[-1, 0] / math.pi - phase[-1, 3]) < 2.0


def test_long_steps_pass_over_no_kink_after_a_turning_point():
    cheek = {'cam': arc(1e-3, LEVER_RATE), 'thread': {'kind': 'vertical'}, 'release_angle': 0.4}
    scene = scene_of(
        trochlea=cheek,
        drag={'viscous': 1e-6},
        escapement=impulse(1e-6, 0.35),
        log={'interval': 2.0},
        duration=200.0,
    )
    # a third of a swing long, from before the turning point to beyond the middle
    coarse = angles(scene.model_copy(update={'solver': Solver(tolerance=1e-5)}))[1]
    fine = angles(scene.model_copy(update={'solver': Solver(tolerance=1e-12)}))[1]
    # 450 impulses, each timed to 1e-10 of the step, or 1e-5 if a kink is detected a step late
    np.testing.assert_allclose(coarse, fine, rtol=0, atol=1e-8)


@pytest.mark.parametrize('mass', [1.4190675485932571, 1.0941742837052104])
def test_two_turning_points_within_a_step_are_not_missed(mass):
    """One turns back at 17.1 s for 0.03 s, one at 15.84 s for 0.9 ms, and is then held."""
    drag = {
        'viscous': 8.788523398430294e-07,
        'quadratic': 5.400905586176452e-05,
        'coulomb': 5.421185028924329e-05,
    }
    scene = scene_of(
        trochlea=weight_of(mass, 0.01, release_angle=9.442460478089428e-06),
        drag=drag,
        ship=rolling(
            (0.15337679494556075, 14.858798127060915), (0.1231910558421026, 3.0), height=0.0
        ),
        log={'interval': 0.25},
        escapement=impulse(7.735415541375855e-07, 0.2815720873667271),
        duration=20.0,
    )
    coarse = angles(scene.model_copy(update={'solver': Solver(tolerance=1e-12)}))[1]
    fine = angles(scene.model_copy(update={'solver': Solver(tolerance=1e-15)}))[1]
    # 1e-3 rad if the two turning points are missed
    np.testing.assert_allclose(coarse, fine, rtol=0, atol=1e-9)


def test_a_swing_that_misses_the_angle_gets_no_impulse():
    scene = scene_of(escapement=impulse(1e-5, 1.1), duration=30.0)
    times, angle, _ = angles(scene)
    np.testing.assert_allclose(angle, np.cos(OMEGA * times), rtol=0, atol=1e-13)


def test_a_strong_escapement_runs_to_the_edge_of_the_cam():
    energy = 2.05e-3
    scene = scene_of(escapement=impulse(energy), duration=300.0)
    edge = 0.08 / LEVER_RATE
    gained = 2 * energy / INERTIA / OMEGA**2
    beat = math.ceil((edge**2 - 1.0) / gained)
    amplitude = math.sqrt(1.0 + beat * gained)
    last = (beat - 0.5) * math.pi / OMEGA + math.asin(edge / amplitude) / OMEGA
    with pytest.raises(PropagationError, match=r'edge of the cam at ±8 rad') as caught:
        run(scene)
    assert caught.value.time_s == pytest.approx(last, abs=1e-9)


def test_a_thread_goes_slack_in_a_freely_falling_ship():
    """A massless weight: the pull is m (g + z̈), zero when the ship falls freely."""
    amplitude, period = 12.0, 6.0
    power = {'kind': 'weight', 'mass': 0.2, 'massless': True}
    massless = weight_of(0.2, LEVER_RATE, power=power, slack='stop')
    w = 2 * math.pi / period
    # z̈ = −a w² cos(wt + phase): at phase 0 the ship falls fastest at the start
    assert amplitude * w * w > G
    falls = (math.pi - math.acos(G / (amplitude * w * w))) / w
    for phase, time_s in ((0.0, 0.0), (-math.pi, falls)):
        heave = waves((amplitude, period, phase))
        ship = {'kind': 'components', 'heave': heave, 'height': 0.0}
        with pytest.raises(PropagationError, match='slack') as caught:
            run(scene_of(trochlea=massless, ship=ship))
        assert caught.value.time_s == pytest.approx(time_s, abs=1e-9)


def test_one_lost_sample_is_bridged_and_counted():
    scene = scene_of(ship=rolling((0.1, 9.0)))
    ship, stage = ShipMotion(scene), TrochleaStage(scene)
    stage.feed({'ship/imu': ship.produce(100)})
    ship.produce(1)
    said = stage.feed({'ship/imu': ship.produce(ship.total)})
    assert stage.health()['bridged_gaps'] == 1
    whole = run(scene)[JOINT_STATES]
    # a window of doubled steps: the Hermite remainder grows from 3e-17 to about 1e-14 rad
    np.testing.assert_allclose(
        said[JOINT_STATES].position[-100:], whole.position[-100:], rtol=0, atol=1e-12
    )
