"""The regressors of the motion: closed forms, chunks, sensors, gaps, and the drift stage."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core.navigation import DriftStage, LongitudeStage, drift_warnings, estimate_names
from tauto_core.navigation.covariates import (
    HELD_S,
    MEAN_S,
    RecordedIntegrals,
    Regressors,
    integral_names,
)
from tauto_core.navigation.longitude import fix_samples
from tauto_core.samples import (
    CORRECTED,
    ESTIMATE,
    LONGITUDE_FIX,
    OBSERVATION,
    READING,
    SHIP_FIX,
    SHIP_IMU,
    TimeSamples,
    join,
    same,
    take,
)
from tauto_core.scene import parse_scene
from tauto_core.ship import ShipMotion
from tauto_core.ship.imu import imu_from_roll
from tauto_core.ship.source import Observations

S = 1_000_000_000
G = 9.80665
BOTH = """
  covariates: [heave, roll]
  coefficients: {heave: {value: 1.0, sigma: 0.05}, roll: {value: 0.0, sigma: 0.02}}"""
SCENE = """
duration: {duration}
starts_at: 100.0
trochlea:
  inertia: 4.0e-4
  cam: {{kind: involute, base_radius: 0.010}}
  thread: {{kind: vertical}}
  power: {{kind: weight, mass: 0.2, massless: true}}
  release_angle: 1.0
ship:
  kind: components
  components: [{{amplitude: 0.1, period: 8.0, phase: -1.5707963267948966}}]
  heave: [{{amplitude: 1.0, period: 10.0}}]
  height: 0.0
  rate: {rate}
drift:
  observation_interval: 7.0
  gate: 1.0e9{covariates}
"""


def scene_of(duration=60.0, rate=20.0, covariates=BOTH):
    return parse_scene(SCENE.format(duration=duration, rate=rate, covariates=covariates), 'test')


def motion_of(scene):
    return ShipMotion(scene).produce(10**7)


def integrals(scene, imu, at_s, *, live=False):
    found = Regressors(scene, live=live)
    found.feed({SHIP_IMU: imu})
    return found.at(np.rint(np.asarray(at_s) * S).astype(np.int64))


def exact(t):
    """Integrals of the scene's motion, of the heave without the high-pass."""
    a, heave, roll = (2 * np.pi / 10.0) ** 2 / G, 2 * np.pi / 10.0, 2 * np.pi / 8.0
    return np.column_stack(
        (
            -0.125 * a * a * (0.5 * t + np.sin(2 * heave * t) / (4 * heave)),
            0.01 * (0.5 * t - np.sin(2 * roll * t) / (4 * roll)),
        )
    )


def test_integrals_are_those_of_the_motion():
    scene = scene_of(duration=1200.0)
    t = np.array([0.0, 40.0, 401.3, 803.71, 1200.0])
    found = integrals(scene, motion_of(scene), 100.0 + t)
    # The high-pass takes 1/(Ωτ)² of the square of a wave, 2.8e-5; the trapezoid misses (2Ωh)²/12,
    # 1e-3, of what swings twice with the wave, whole waves nothing.
    np.testing.assert_allclose(found[:, 0], exact(t)[:, 0], rtol=4e-5, atol=1e-6)
    np.testing.assert_allclose(found[:, 1], exact(t)[:, 1], rtol=1e-12, atol=3e-6)


def test_the_error_of_sampling_falls_with_the_square_of_the_step():
    at = np.array([33.0])
    errors = []
    for rate in (2.0, 4.0, 8.0):
        scene = scene_of(duration=40.0, rate=rate)
        errors.append(abs(integrals(scene, motion_of(scene), 100.0 + at) - exact(at))[0, 1])
    np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 2.0, atol=0.1)


@settings(max_examples=12, deadline=None)
@given(st.lists(st.integers(0, 2000), max_size=8), st.booleans(), st.integers(0, 8))
def test_batches_and_resuming_do_not_matter(cuts, live, resumed):
    scene = scene_of(duration=90.0)
    imu = motion_of(scene)
    if live:  # uneven stamps
        uneven = imu.stamp_ns + np.random.default_rng(1).integers(0, 9_000_000, len(imu.stamp_ns))
        imu = take(imu, slice(None))
        imu.stamp_ns[:] = uneven
    at = np.array([100.01, 123.456, 161.0, 189.9])
    whole = integrals(scene, imu, at, live=live)
    pieces = Regressors(scene, live=live)
    edges = [0, *sorted(min(cut, len(imu.stamp_ns)) for cut in cuts), len(imu.stamp_ns)]
    said = []
    stamps = np.rint(at * S).astype(np.int64)
    for k, (a, b) in enumerate(pairwise(edges)):
        pieces.feed({SHIP_IMU: take(imu, slice(a, b))})
        reached = np.searchsorted(stamps, pieces.reached_ns, 'right')
        said.append(pieces.at(stamps[:reached]))
        stamps = stamps[reached:]
        if k == resumed:
            other = Regressors(scene, live=live)
            other.restore(pieces.state())
            pieces = other
    np.testing.assert_array_equal(np.concatenate(said), whole)
    assert not any(pieces.health().values())


def test_bias_and_noise_of_an_accelerometer_add_what_is_said():
    """A constant bias b adds b²τ/(16 g²) once, noise of variance σ² a constant rate σ²/(8 g²)."""
    scene, n = scene_of(), 20 * 4000
    stamps, none = 100 * S + 50_000_000 * np.arange(n), np.zeros(n)
    at = np.array([2100.0, 4099.0])
    biased = imu_from_roll(stamps, none, none, none, np.full(n, G + 0.1))
    found = integrals(scene, biased, at)[:, 0]
    np.testing.assert_allclose(found, -(0.1**2) * MEAN_S / (16 * G * G), rtol=2e-3)
    noise = 0.05 * np.random.default_rng(1).normal(size=n)
    noisy = imu_from_roll(stamps, none, none, none, G + noise)
    rate = np.diff(integrals(scene, noisy, at)[:, 0])[0] / 1999.0
    # 2000 s hold 40,000 samples: the variance is known to 0.7 %
    assert rate == pytest.approx(-(0.05**2) / (8 * G * G), rel=0.03)
    assert 86400.0 * abs(rate) < 0.3


def test_over_a_gap_the_integrals_grow_as_usual():
    scene = scene_of(duration=3000.0)
    imu = motion_of(scene)
    t = (imu.stamp_ns - imu.stamp_ns[0]) / S
    gap = take(imu, (t < 2000.0) | (t > 2200.0))
    live = Regressors(scene, live=True)
    live.feed({SHIP_IMU: gap})
    assert live.health()['motion_gaps'] == 1
    ends = live.at(np.array([2099 * S, 2301 * S]))
    whole = integrals(scene, imu, [2099.0, 2301.0])
    # the usual growth is a mean over ten minutes or so, in which waves differ by a tenth
    np.testing.assert_allclose(np.diff(ends, axis=0), np.diff(whole, axis=0), rtol=0.1)


def times(stamps_s, errors_s=0.0):
    stamps = np.asarray(np.array(stamps_s) * S, np.int64)
    errors = np.asarray(np.broadcast_to(errors_s, stamps.shape) * S, np.int64)
    return TimeSamples(stamps, '', stamps + errors, same('dial', len(stamps)))


def topics_of(scene):
    at = scene.starts_at + np.arange(scene.log_count)
    reading = times(at, 0.003 * (at - scene.starts_at) + 0.01 * np.sin(at))
    seen = Observations(scene).between(0, 10**18)
    return {READING: reading, OBSERVATION: seen, SHIP_IMU: motion_of(scene)}


def run(stage, feeds):
    said = [stage.feed(batches) for batches in feeds]
    said.append(stage.finish())
    return {
        topic: join([batches[topic] for batches in said if topic in batches])
        for topic in stage.outputs
    }


@st.composite
def feeds(draw, topics):
    queues = {}
    for topic, samples in topics.items():
        cuts = draw(st.lists(st.integers(0, len(samples.stamp_ns)), max_size=6))
        edges = [0, *sorted(cuts), len(samples.stamp_ns)]
        queues[topic] = [take(samples, slice(a, b)) for a, b in pairwise(edges)]
    order = draw(st.permutations([topic for topic, parts in queues.items() for _ in parts]))
    return [{topic: queues[topic].pop(0)} for topic in order]


STAGED = scene_of()
TOPICS = topics_of(STAGED)


@settings(max_examples=20, deadline=None)
@given(st.data())
def test_the_stage_says_the_same_in_any_order_of_arrival_and_after_resuming(data):
    whole = run(DriftStage(STAGED), [TOPICS])
    assert len(whole[ESTIMATE].stamp_ns) == STAGED.log_count
    pieces = data.draw(feeds(TOPICS))
    cut = data.draw(st.integers(0, len(pieces)))
    first, second = DriftStage(STAGED), DriftStage(STAGED)
    said = [first.feed(piece) for piece in pieces[:cut]]
    second.restore(first.state())
    said += [second.feed(piece) for piece in pieces[cut:]]
    said.append(second.finish())
    for topic in DriftStage.outputs:
        found = join([each[topic] for each in said if topic in each])
        np.testing.assert_array_equal(found.stamp_ns, whole[topic].stamp_ns)
    found = join([each[ESTIMATE] for each in said if ESTIMATE in each])
    np.testing.assert_array_equal(found.position, whole[ESTIMATE].position)
    assert not any(second.health().values())


def test_what_is_said_has_names_and_the_integrals_from_which_it_can_be_told_again():
    whole = run(DriftStage(STAGED), [TOPICS])
    estimate = whole[ESTIMATE]
    assert estimate.name == estimate_names(('heave', 'roll'))
    assert estimate.name[-2:] == ('heave_integral_s', 'roll_integral_s')
    assert 'roll_coefficient_sigma' in estimate.name
    recorded = RecordedIntegrals(estimate, ('heave', 'roll'))
    again = DriftStage(STAGED, expect_schedule=False, motion=recorded)
    assert SHIP_IMU not in again.inputs
    told = run(again, [{READING: TOPICS[READING], OBSERVATION: TOPICS[OBSERVATION]}])
    np.testing.assert_array_equal(told[ESTIMATE].position, estimate.position)


def test_without_covariates_nothing_of_it_is_there():
    scene = scene_of(covariates='')
    stage = DriftStage(scene)
    assert stage.inputs == (READING, OBSERVATION)
    assert 'motion' not in stage.state()
    assert not any(name.startswith('motion') for name in stage.health())
    said = run(stage, [topics_of(scene)])
    assert said[ESTIMATE].name == estimate_names(())


def test_readings_wait_for_the_motion_but_not_for_ever():
    reading = times(100.0 + np.arange(31))
    held = DriftStage(STAGED, expect_schedule=False)
    said = held.feed({READING: reading})
    assert int(said[ESTIMATE].stamp_ns[-1]) == (130 - round(HELD_S)) * S
    assert held.health()['motion_unknown'] == 21
    rest = held.feed({SHIP_IMU: TOPICS[SHIP_IMU]})
    assert len(rest[ESTIMATE].stamp_ns) == 10
    [words] = drift_warnings(held.health(), STAGED)
    assert 'did not reach 21 readings' in words
    # where the scene's own ship drives, the motion is waited for
    own = DriftStage(STAGED)
    assert own.feed({READING: reading, OBSERVATION: TOPICS[OBSERVATION]}) == {}
    assert CORRECTED in own.feed({SHIP_IMU: TOPICS[SHIP_IMU]})


def test_the_longitude_is_as_uncertain_as_the_coefficients_make_it():
    """Known k_j and those of a sigma differ in the east variance by Σ (σ_j ΔX_j)² alone.

    Nothing is observed after the start, where the X are 0, so that the k are not correlated with
    the rest; a second of the clock is 463.8 m along the equator.
    """
    latitude, sigmas = 50.0, (3.0, 2.0)

    def variances(part):
        heave, roll = (part * sigma for sigma in sigmas)
        scene = scene_of(
            covariates=f"""
  covariates: [heave, roll]
  coefficients: {{heave: {{value: 0.5, sigma: {heave}}}, roll: {{value: 0.5, sigma: {roll}}}}}"""
        )
        seen = take(TOPICS[OBSERVATION], slice(0, 1))
        assert seen.stamp_ns[0] == scene.starts_at_ns
        said = run(DriftStage(scene, expect_schedule=False), [TOPICS | {OBSERVATION: seen}])
        stamps, none = TOPICS[READING].stamp_ns, np.zeros(scene.log_count)
        fixes = fix_samples(stamps, none + latitude, none, np.ones((len(stamps), 3)))
        told = LongitudeStage(scene).feed({READING: TOPICS[READING], SHIP_FIX: fixes, **said})
        return said[ESTIMATE], told[LONGITUDE_FIX].position_covariance[:, 0]

    estimate, uncertain = variances(1.0)
    _, known = variances(1e-9)
    names = integral_names(('heave', 'roll'))
    grown = [estimate.position[:, estimate.name.index(name)] for name in names]
    metres = 2.0 * np.pi * 6_378_137.0 / 86_400.0 * np.cos(np.radians(latitude))
    wanted = metres**2 * (sigmas[0] ** 2 * grown[0] ** 2 + sigmas[1] ** 2 * grown[1] ** 2)
    assert wanted[-1] > 0.01 * known[-1]
    np.testing.assert_allclose(uncertain - known, wanted, rtol=1e-9, atol=1e-12 * known.max())
