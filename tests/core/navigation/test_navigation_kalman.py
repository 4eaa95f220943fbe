"""The clock filter: its formulas, which observations it uses, and the honesty of its sigmas."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from benchmarks.whole_run import filtered_drift
from tauto_core.clockwork import TrochleaStage
from tauto_core.navigation import (
    ESTIMATE_NAMES,
    ClockModel,
    DriftStage,
    Estimate,
    Known,
    clock_model,
    filter_phases,
    predict,
    prior,
)
from tauto_core.navigation.covariates import expected_walk_per_s
from tauto_core.navigation.drift import REMEMBERED, Track
from tauto_core.navigation.kalman import REFUSED, REOPENED, USED, Coefficient
from tauto_core.samples import ESTIMATE, OBSERVATION, READING, TimeSamples
from tauto_core.scene import load_scene
from tauto_core.ship import Observations, ShipMotion

DAY = 86_400.0


def run(start, times, phases, model):
    """States after each observation, by the filter, at whole nanoseconds from the start."""
    return filter_phases(Known(0, start), times, phases, model).states


def whole_ns(times):
    return np.rint(np.asarray(times) * 1e9).astype(np.int64).tolist()


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.0, 1e7), st.floats(-1e4, 1e4)), min_size=1, max_size=30),
    st.sampled_from([2, 3]),
    st.floats(1e-6, 10.0),
)
def test_covariance_stays_positive(steps, states, sigma):
    model = ClockModel(sigma, 10.0 / DAY, states)
    elapsed, phases = zip(*steps, strict=True)
    known = run(prior(model), whole_ns(np.cumsum(elapsed)), phases, model)
    assert (known.xx > 0).all()
    assert (known.yy > 0).all()
    assert (known.xy**2 <= known.xx * known.yy * (1 + 1e-9)).all()


# -----------------------------------------------------------------------------
# The gate, the reopened state, and bits that do not depend on batches of observations.

DAY_S = 86_400.0
DAY_NS = 86_400_000_000_000


def model_of(states=2, gate=5.0, patience_days=3.0):
    return ClockModel(0.5, 10.0 / DAY_S, states, 1e-7, 1e-17, gate, patience_days * DAY_S)


def days(count):
    return [DAY_NS * (k + 1) for k in range(count)]


def start_of(model):
    return Known(0, prior(model))


@settings(max_examples=20, deadline=None)
@given(
    st.lists(st.tuples(st.integers(1, 5 * DAY_NS), st.floats(-500.0, 500.0)), max_size=40),
    st.integers(0, 40),
    st.sampled_from([2, 3]),
)
def test_one_at_a_time_and_many_at_once_give_the_same_bits(steps, cut, states):
    model = model_of(states)
    stamps = np.cumsum([step for step, _ in steps], dtype=np.int64).tolist()
    phases = [phase for _, phase in steps]
    whole = filter_phases(start_of(model), stamps, phases, model)
    known = start_of(model)
    fates: list[Any] = []
    for stamp, phase in zip(stamps, phases, strict=True):
        one = filter_phases(known, [stamp], [phase], model)
        known, fates = one.after(1), fates + one.fate.tolist()
    assert known == whole.after(len(steps))
    assert fates == whole.fate.tolist()
    cut = min(cut, len(steps))
    early = filter_phases(start_of(model), stamps[:cut], phases[:cut], model)
    assert whole.after(cut) == early.after(cut)


@pytest.mark.parametrize(('place', 'believed'), [(1, 2), (2, 2), (3, 0), (4, 0)])
@pytest.mark.parametrize('blunder_s', [20.0, 60.0, -600.0])
def test_an_early_blunder_is_not_believed_for_long(place, believed, blunder_s):
    """With the default prior: from the second observation after it on, sigmas are true again."""
    model = ClockModel(0.5, 1000.0 / DAY_S, 2, 1e-9, 1e-19, 5.0, 3.0 * DAY_S)
    for seed in range(10):
        phases = -48.0 * np.arange(1, 9) + np.random.default_rng(seed).normal(0.0, 0.5, 8)
        phases[place - 1] += blunder_s
        for count in [n for n in range(1, 9) if not place <= n < place + believed]:
            known = filter_phases(start_of(model), days(count), phases[:count], model).after(count)
            end = predict(known.estimate, (count * DAY_NS - known.stamp_ns) / 1e9, model)
            assert abs(end.x + 48.0 * count) < 5.0 * math.sqrt(end.xx)
            assert abs(end.y * DAY_S + 48.0) < 5.0 * math.sqrt(end.yy) * DAY_S


def test_the_gate_lies_at_so_many_sigmas_of_the_innovation():
    model = model_of(gate=4.0)
    rated = filter_phases(start_of(model), days(5), [0.0] * 5, model).after(5)
    sigma = math.sqrt(predict(rated.estimate, DAY_S, model).xx + 0.25)
    for factor, fate in ((3.999, USED), (4.001, REFUSED), (-3.999, USED), (-4.001, REFUSED)):
        way = filter_phases(rated, [6 * DAY_NS], [factor * sigma], model)
        assert way.fate.tolist() == [fate]


@pytest.mark.parametrize('states', [2, 3])
@pytest.mark.parametrize(
    ('offset', 'rate'), [(600.0, 0.0), (0.0, -64.0), (-120.0, 30.0)], ids=['jump', 'rate', 'both']
)
def test_a_clock_that_has_changed_is_followed_again(states, offset, rate):
    model = model_of(states)
    rng = np.random.default_rng(6)
    count, change = 40, 15
    day = np.arange(1, count + 1)
    late = np.maximum(day - change, 0)
    truth = 2.0 * day + (day > change) * offset + rate * late
    way = filter_phases(start_of(model), days(count), (truth + rng.normal(0, 0.5, count)), model)
    # two are taken for blunders, the third reopens. If jump and rate offset each other the
    # next disagrees again, is refused once, and the one after it is believed
    refused, reopened = (np.flatnonzero(way.fate == fate) - change for fate in (REFUSED, REOPENED))
    assert (refused.tolist(), reopened.tolist()) in (([0, 1], [2]), ([0, 1, 3], [2, 4]))
    end = way.after(count).estimate
    assert abs(end.x - truth[-1]) < 4.0 * math.sqrt(end.xx) < 1.5
    assert abs(end.y * DAY_S - 2.0 - rate) < 4.0 * math.sqrt(end.yy) * DAY_S < 0.8


def test_trust_is_earned_by_three_observations():
    """The first is believed, then one outlier in a row is refused, from the fourth on two."""
    model = model_of()
    for good, refused in ((0, 0), (1, 1), (2, 1), (3, 2)):
        phases = [0.0] * good + [900.0, 900.0, 900.0]
        way = filter_phases(start_of(model), days(len(phases)), phases, model)
        assert way.fate[: good + refused + 1].tolist() == [
            *[USED] * good,
            *[REFUSED] * refused,
            REOPENED,
        ]
    # and after a reopening again
    for good, fate in ((1, REOPENED), (2, REFUSED)):
        phases = [*[900.0] * (good + 1), -900.0, -900.0]
        way = filter_phases(start_of(model), [0, *days(good + 2)], phases, model)
        assert way.fate.tolist() == [REOPENED, *[USED] * good, REFUSED, fate]


@pytest.mark.parametrize('every_s', [1, 86_400])
@pytest.mark.parametrize(('place', 'blunder_s'), [(0, 900.0), (1, -86_400.0), (8, 900.0)])
def test_no_observer_is_believed_alone_at_any_pace(every_s, place, blunder_s):
    """A blunder, two that differ, and three that differ leave no trace. Three that agree do."""
    model = replace(model_of(), patience_s=math.inf)
    stamps, good = [every_s * 10**9 * (k + 1) for k in range(16)], [0.1, -0.2, 0.3, 0.0] * 4
    for blunders in ([1.0], [1.0, -1.0], [1.0, 0.5, -2.0]):
        after = place + len(blunders)
        phases = [*good[:place], *(each * blunder_s for each in blunders), *good[after:]]
        way = filter_phases(start_of(model), stamps, phases, model)
        assert np.flatnonzero(way.fate == REFUSED).tolist() == list(range(place, after))
        kept = stamps[:place] + stamps[after:], good[:place] + good[after:]
        rest = filter_phases(start_of(model), *kept, model)
        assert way.after(16) == rest.after(16 - len(blunders))
    changed = [*good[:place], *(each + blunder_s for each in good[place:])]
    way = filter_phases(start_of(model), stamps, changed, model)
    assert way.fate[place : place + 4].tolist() == [REFUSED, REFUSED, REOPENED, USED]
    end = way.after(16).estimate
    assert abs(end.x - blunder_s) < 4.0 * math.sqrt(end.xx) < 3.0


def test_after_a_long_silence_the_observation_is_believed():
    model = model_of(patience_days=3.0)
    port = filter_phases(start_of(model), days(14), [0.0] * 14, model)
    for wait, fate in ((3, REFUSED), (4, REOPENED), (67, REOPENED)):
        later = filter_phases(port.after(14), [(14 + wait) * DAY_NS], [500.0], model)
        assert later.fate.tolist() == [fate]
    # a jump of 500 s or a rate that changed by 500 s in 67 days: half of each
    estimate = later.after(1).estimate
    assert estimate.x == pytest.approx(500.0, abs=0.1)
    assert math.sqrt(estimate.xx) == pytest.approx(0.5, rel=1e-3)
    assert estimate.y * DAY_S == pytest.approx(0.5 * 500.0 / 67.0, rel=0.05)
    assert math.sqrt(estimate.yy) * DAY_S == pytest.approx(500.0 / 67.0 / math.sqrt(2.0), rel=0.05)


@settings(max_examples=20, deadline=None)
@given(st.data())
def test_late_observations_end_in_the_state_of_their_order(data):
    count, size = data.draw(st.integers(1, 30)), data.draw(st.integers(0, 2))
    rng = np.random.default_rng(count)
    known = tuple(Coefficient(name, 1.0, 0.2) for name in ('heave', 'roll')[:size])
    model = replace(model_of(data.draw(st.sampled_from([2, 3]))), coefficients=known)
    grown = list(map(tuple, np.cumsum(rng.uniform(0.0, 9.0, (count, size)), axis=0).tolist()))
    start = Known(0, prior(model), integrals_s=(0.0,) * size)
    phases = (rng.normal(0.0, 0.5, count) + 200.0 * (rng.random(count) < 0.2)).tolist()
    stamps, sigmas = days(count), rng.choice([0.5, 60.0], count).tolist()
    order = data.draw(st.permutations(range(count)))
    track = Track(start, model)
    for k in order:
        track.use([stamps[k]], [phases[k]], [sigmas[k]], [grown[k]])
    whole = filter_phases(start, stamps, phases, model, sigmas, grown)
    assert track.last == whole.after(count)
    assert track.count(REFUSED) == np.count_nonzero(whole.fate == REFUSED)
    assert track.count(REOPENED) == np.count_nonzero(whole.fate == REOPENED)


@pytest.mark.parametrize('chunk', [1, 100, 1000])
def test_a_long_track_forgets_without_changing_its_state(chunk):
    model, count = model_of(), 1000
    rng = np.random.default_rng(8)
    phases = (rng.normal(0.0, 0.5, count) + 200.0 * (rng.random(count) < 0.1)).tolist()
    stamps = days(count)
    track = Track(start_of(model), model)
    for first in range(0, count, chunk):
        track.use(stamps[first : first + chunk], phases[first : first + chunk])
    whole = filter_phases(start_of(model), stamps, phases, model)
    assert track.last == whole.after(count)
    assert track.count(REFUSED) == np.count_nonzero(whole.fate == REFUSED) > 50
    assert len(track.state()['seen']) < 2 * REMEMBERED
    assert track.oldest_ns <= stamps[-REMEMBERED]
    # one that is late by as many as are remembered is still put in its place
    late = stamps[-REMEMBERED] + 1
    track.use([late], [0.0])
    place = stamps.index(stamps[-REMEMBERED]) + 1
    mixed = filter_phases(
        start_of(model),
        [*stamps[:place], late, *stamps[place:]],
        [*phases[:place], 0.0, *phases[place:]],
        model,
    )
    assert track.last == mixed.after(count + 1)
    resumed = Track(start_of(model), model)
    resumed.restore(track.state())
    for each in (track, resumed):
        each.use([stamps[-1] + DAY_NS], [1.0])
    assert resumed.state() == track.state()


# -----------------------------------------------------------------------------
# Clocks with the noise of a scene, through the stages: errors agree with their sigmas.

DAYS, RUNS = 20, 40


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


def innovations_squared(way, model):
    """The sum of ν²/s, with each ν from the step of x by its gain, x_xx/s."""
    before = Estimate(*(column[:-1] for column in way.states))
    ahead = predict(before, np.diff(way.stamp_ns) / 1e9, model)
    return np.sum(((way.states.x[1:] - ahead.x) / ahead.xx) ** 2 * (ahead.xx + 0.25))


def test_innovations_and_errors_are_as_large_as_the_filter_says(ensemble):
    nis, errors = 0.0, np.zeros(2)
    for scene, reading, observation in ensemble:
        model = clock_model(scene)
        assert model.white_fm_s == 0.3**2 / DAY
        assert model.random_walk_fm_per_s == (0.5 / DAY) ** 2 / DAY
        way = filtered_drift(reading, observation, model)
        nis += innovations_squared(way, model)
        said = DriftStage(scene).feed({READING: reading, OBSERVATION: observation})[ESTIMATE]
        assert said.name == ESTIMATE_NAMES
        x = (reading.time_ref_ns - reading.stamp_ns) / 1e9
        estimate = said.position
        for k, place in enumerate((DAYS // 2, DAYS)):
            errors[k] += ((estimate[place, 0] - x[place]) / estimate[place, 1]) ** 2
    assert within(nis, RUNS * (DAYS + 1))
    for total in errors:
        assert within(total, RUNS)


def errors_squared(scene, reading, observation):
    """Offset and rate at the end against the dial and its mean rate: eT P^-1 e."""
    model = clock_model(scene)
    way = filtered_drift(reading, observation, model)
    elapsed = (reading.stamp_ns[-1] - way.stamp_ns[-1]) / 1e9
    now = predict(Estimate(*(float(column[-1]) for column in way.states)), elapsed, model)
    x = (reading.time_ref_ns - reading.stamp_ns) / 1e9
    rate = (x[-1] - x[0]) / ((reading.stamp_ns[-1] - reading.stamp_ns[0]) / 1e9)
    wrong = np.array([now.x - x[-1], now.y - rate])
    # a walking rate departs from its mean
    walked = expected_walk_per_s(scene) * (reading.stamp_ns[-1] - reading.stamp_ns[0]) / 3e9
    return wrong @ np.linalg.solve([[now.xx, now.xy], [now.xy, now.yy + walked]], wrong)


@pytest.mark.parametrize('name', ['measured', 'buoy_44004_supply'])
def test_shipped_scenes_are_as_wrong_as_the_navigator_says(name):
    """The clock once, its observations many times. Benchmarks vary the waves, too."""
    runs, scene = 400, load_scene(name)
    ship, clock = ShipMotion(scene), TrochleaStage(scene)
    reading = clock.feed({'ship/imu': ship.produce(10**6)})[READING]
    assert len(reading.stamp_ns) == scene.log_count
    seen = [
        Observations(scene.model_copy(update={'seed': seed})).between(0, 10**18)
        for seed in range(runs)
    ]
    # the prior reduces the sum of `measured` by 2 %, 20 % would be too much
    assert within(sum(errors_squared(scene, reading, each) for each in seen), 2 * runs)


def test_a_swinging_thread_is_as_wrong_as_the_navigator_says():
    """The waves of each seed too, since they make the rate walk. Benchmarks take 200 seeds."""
    runs, name = 15, 'hanging_thread_at_sea'
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


@pytest.mark.parametrize('coefficients', [(), (Coefficient('heave', 1.0, 0.1),)])
def test_a_rate_that_wanders_under_way_is_still_in_port(coefficients):
    """A step over the departure is one to it and one from it, with more noise in the second."""
    port = ClockModel(0.5, 1e-3, coefficients=coefficients)
    sailing = replace(port, under_way_per_s=3e-12, sails_ns=40 * DAY_NS)
    rougher = replace(port, random_walk_fm_per_s=port.random_walk_fm_per_s + 3e-12)
    before, after, size = 5.0 * DAY_S, 20.0 * DAY_S, len(coefficients)
    once = predict(prior(port), before + after, sailing, (46.0,) * size, after)
    left = predict(prior(port), before, port, (17.0,) * size)
    np.testing.assert_allclose(once, predict(left, after, rougher, (29.0,) * size), rtol=1e-12)
    # in the filter the time under way follows from the stamps
    rows = [(17.0,) * size, (46.0,) * size]
    stamps, phases = [35 * DAY_NS, 50 * DAY_NS], [0.0, 3.0]
    start = Known(30 * DAY_NS, prior(port), integrals_s=(0.0,) * size)
    found = filter_phases(start, stamps, phases, sailing, None, rows).after(2)
    last = filter_phases(start, stamps[:1], phases[:1], port, None, rows[:1]).after(1)
    left = predict(last.estimate, before, port, (0.0,) * size)
    sails = Known(40 * DAY_NS, left, integrals_s=rows[0])
    wanted = filter_phases(sails, stamps[1:], phases[1:], rougher, None, rows[1:]).after(1)
    np.testing.assert_allclose(found.estimate, wanted.estimate, rtol=1e-9, atol=1e-18)
