"""Clocks with the noise of a scene, through the stages: errors agree with their sigmas."""

import numpy as np
import pytest
from scipy.stats import chi2

from tauto_core.clockwork import TrochleaStage
from tauto_core.navigation import ESTIMATE_NAMES, DriftStage, clock_model, prior
from tauto_core.navigation.covariates import expected_walk_per_s
from tauto_core.navigation.hindsight import filtered_drift
from tauto_core.navigation.kalman import Estimate, predict
from tauto_core.samples import ESTIMATE, OBSERVATION, READING, TimeSamples
from tauto_core.scene import load_scene
from tauto_core.ship import Observations, ShipMotion

DAY = 86_400.0
DAYS, RUNS = 20, 70


def noisy(seed, states):
    return load_scene(
        'ideal',
        duration=DAYS * DAY,
        seed=seed,
        clock={'white_fm': 0.3, 'random_walk_fm': 0.5},
        log={'interval': DAY},
        drift={'observation_interval': DAY, 'states': states, 'gate': 1e9},
    )


def voyage(seed, states):
    """Scene, readings of a clock drawn from the prior, and observations of one seed."""
    scene = noisy(seed, states)
    said = TrochleaStage(scene).feed({'ship/imu': ShipMotion(scene).produce(10**6)})[READING]
    spread = prior(clock_model(scene))
    sigmas = np.sqrt([spread.xx, spread.yy, spread.dd])
    offset, rate, ageing = sigmas * np.random.default_rng(seed + 10**6).normal(size=3)
    t = (said.stamp_ns - said.stamp_ns[0]) / 1e9
    drift = np.rint(1e9 * (offset + rate * t + 0.5 * ageing * t * t)).astype(np.int64)
    reading = TimeSamples(said.stamp_ns, '', said.time_ref_ns + drift, said.source)
    return scene, reading, Observations(scene).between(0, 10**18)


@pytest.fixture(scope='module', params=[2, 3])
def ensemble(request):
    return [voyage(seed, request.param) for seed in range(RUNS)]


def within(total, freedom):
    # two-sided at 1e-4: a seeded ensemble, so it passes always or never
    low, high = chi2.ppf(np.array([5e-5, 1 - 5e-5]), freedom)
    return low < total < high


def test_innovations_and_errors_are_as_large_as_the_filter_says(ensemble):
    nis, errors = 0.0, np.zeros(2)
    for scene, reading, observation in ensemble:
        model = clock_model(scene)
        assert model.white_fm_s == 0.3**2 / DAY
        assert model.random_walk_fm_per_s == (0.5 / DAY) ** 2 / DAY
        way = filtered_drift(reading, observation, model)
        ahead = way.expected(model)
        nis += np.sum((way.phase_s - ahead.x) ** 2 / (ahead.xx + 0.25))
        said = DriftStage(scene).feed({READING: reading, OBSERVATION: observation})[ESTIMATE]
        assert said.name == ESTIMATE_NAMES
        x = (reading.time_ref_ns - reading.stamp_ns) / 1e9
        estimate = said.position
        for k, place in enumerate((DAYS // 2, DAYS)):
            errors[k] += ((estimate[place, 0] - x[place]) / estimate[place, 1]) ** 2
    assert within(nis, RUNS * (DAYS + 1))
    for total in errors:
        assert within(total, RUNS)


def test_a_filter_that_knows_nothing_of_the_noise_is_found_out(ensemble):
    nis = 0.0
    for scene, reading, observation in ensemble[:20]:
        deaf = clock_model(scene.model_copy(update={'clock': type(scene.clock)()}))
        way = filtered_drift(reading, observation, deaf)
        ahead = way.expected(deaf)
        nis += np.sum((way.phase_s - ahead.x) ** 2 / (ahead.xx + 0.25))
    assert nis > chi2.ppf(1 - 1e-9, 20 * (DAYS + 1))


def errors_squared(scene, reading, observation):
    """Offset and rate at the end against the dial and its mean rate: eT P^-1 e."""
    model = clock_model(scene)
    way = filtered_drift(reading, observation, model)
    elapsed = (reading.stamp_ns[-1] - way.stamp_ns[-1]) / 1e9
    now = predict(Estimate(*(float(column[-1]) for column in way.states)), elapsed, model)
    x = (reading.time_ref_ns - reading.stamp_ns) / 1e9
    rate = (x[-1] - x[0]) / ((reading.stamp_ns[-1] - reading.stamp_ns[0]) / 1e9)
    wrong = np.array([now.x - x[-1], now.y - rate])
    # the rate at the end departs from its mean where it walks
    walked = expected_walk_per_s(scene) * (reading.stamp_ns[-1] - reading.stamp_ns[0]) / 3e9
    return wrong @ np.linalg.solve([[now.xx, now.xy], [now.xy, now.yy + walked]], wrong)


@pytest.mark.parametrize('name', ['measured', 'involute_weight_at_sea', 'buoy_44004_supply'])
def test_shipped_scenes_are_as_wrong_as_the_navigator_says(name):
    """The clock once, its observations many times; the waves too: benchmarks/."""
    runs, scene = 1000, load_scene(name)
    ship, clock = ShipMotion(scene), TrochleaStage(scene)
    reading = clock.feed({'ship/imu': ship.produce(10**6)})[READING]
    assert len(reading.stamp_ns) == scene.log_count
    seen = [
        Observations(scene.model_copy(update={'seed': seed})).between(0, 10**18)
        for seed in range(runs)
    ]
    # what is assumed beforehand takes 2 % off the sum of `measured`; 12 % would be found out
    assert within(sum(errors_squared(scene, reading, each) for each in seen), 2 * runs)


def test_a_swinging_thread_is_as_wrong_as_the_navigator_says():
    """The waves of each seed too, since they make the rate walk; 200 seeds: benchmarks/."""
    runs, name = 40, 'hanging_thread_at_sea'
    clock = TrochleaStage(load_scene(name))
    fresh, found, before = clock.state(), 0.0, 0.0
    for seed in range(runs):
        scene = load_scene(name, seed=seed)
        clock.restore(fresh)
        reading = clock.feed({'ship/imu': ShipMotion(scene).produce(10**6)})[READING]
        seen = Observations(scene).between(0, 10**18)
        found += errors_squared(scene, reading, seen)
        still = scene.drift.model_copy(update={'random_walk_fm': None})
        before += errors_squared(scene.model_copy(update={'drift': still}), reading, seen)
    assert within(found, 2 * runs)
    # a good clock's noise is not this clock's
    assert before > 10.0 * chi2.ppf(1 - 1e-9, 2 * runs)
