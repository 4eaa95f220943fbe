"""The gate, the reopened state, and bits that do not depend on batches of observations."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core.navigation import ClockModel, Known, filter_phases, predict, prior, update
from tauto_core.navigation.drift import REMEMBERED, Track
from tauto_core.navigation.kalman import REFUSED, REOPENED, USED

DAY_S = 86_400.0
DAY = 86_400_000_000_000


def model_of(states=2, gate=5.0, patience_days=3.0):
    ageing = 1e-29 if states == 3 else 0.0
    return ClockModel(0.5, 10.0 / DAY_S, states, 1e-7, 1e-17, ageing, gate, patience_days * DAY_S)


def days(count):
    return [DAY * (k + 1) for k in range(count)]


def start_of(model):
    return Known(0, prior(model))


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.tuples(st.integers(1, 5 * DAY), st.floats(-500.0, 500.0)), max_size=40),
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


@pytest.mark.parametrize('states', [2, 3])
def test_the_loop_is_predict_and_update_bit_for_bit(states):
    model = model_of(states, gate=None)
    rng = np.random.default_rng(5)
    stamps = np.cumsum(rng.integers(1, 3 * DAY, 50)).tolist()
    phases = rng.normal(0.0, 2.0, 50).tolist()
    way = filter_phases(start_of(model), stamps, phases, model)
    now, since = prior(model), 0
    for k, (stamp, phase) in enumerate(zip(stamps, phases, strict=True)):
        ahead = predict(now, (stamp - since) / 1e9, model)
        assert tuple(column[k] for column in way.expected(model)) == tuple(ahead)
        now, since = update(ahead, phase, 0.25), stamp
        assert tuple(column[k + 1] for column in way.states) == tuple(now)


def test_an_outlier_is_refused_and_changes_nothing():
    model = model_of()
    stamps, good = days(10), [4.0 * (k + 1) for k in range(10)]
    wrong = [*good[:6], good[6] + 60.0, *good[7:]]
    way = filter_phases(start_of(model), stamps, wrong, model)
    assert way.fate.tolist() == [USED] * 6 + [REFUSED] + [USED] * 3
    without = filter_phases(start_of(model), stamps[:6] + stamps[7:], good[:6] + good[7:], model)
    assert way.after(10) == without.after(9)


@pytest.mark.parametrize(('place', 'believed'), [(1, 2), (2, 2), (3, 0), (4, 0)])
@pytest.mark.parametrize('blunder_s', [20.0, 60.0, -600.0])
def test_a_blunder_among_the_first_observations_is_not_believed_for_long(
    place, believed, blunder_s
):
    """With the default prior: from the second observation after it on, sigmas are true again."""
    model = ClockModel(0.5, 1000.0 / DAY_S, 2, 1e-9, 1e-19, 0.0, 5.0, 3.0 * DAY_S)
    for seed in range(10):
        phases = -48.0 * np.arange(1, 9) + np.random.default_rng(seed).normal(0.0, 0.5, 8)
        phases[place - 1] += blunder_s
        for count in [n for n in range(1, 9) if not place <= n < place + believed]:
            known = filter_phases(start_of(model), days(count), phases[:count], model).after(count)
            end = predict(known.estimate, (count * DAY - known.stamp_ns) / 1e9, model)
            assert abs(end.x + 48.0 * count) < 5.0 * math.sqrt(end.xx)
            assert abs(end.y * DAY_S + 48.0) < 5.0 * math.sqrt(end.yy) * DAY_S


def test_the_gate_lies_at_so_many_sigmas_of_the_innovation():
    model = model_of(gate=4.0)
    rated = filter_phases(start_of(model), days(5), [0.0] * 5, model).after(5)
    sigma = math.sqrt(predict(rated.estimate, DAY_S, model).xx + 0.25)
    for factor, fate in ((3.999, USED), (4.001, REFUSED), (-3.999, USED), (-4.001, REFUSED)):
        way = filter_phases(rated, [6 * DAY], [factor * sigma], model)
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
    # two are taken for blunders, the third reopens; where jump and rate had offset each other the
    # next disagrees again, is refused once, and the one after it is believed
    refused, reopened = (np.flatnonzero(way.fate == fate) - change for fate in (REFUSED, REOPENED))
    assert (refused.tolist(), reopened.tolist()) in (([0, 1], [2]), ([0, 1, 3], [2, 4]))
    end = way.after(count).estimate
    assert abs(end.x - truth[-1]) < 4.0 * math.sqrt(end.xx) < 1.5
    assert abs(end.y * DAY_S - 2.0 - rate) < 4.0 * math.sqrt(end.yy) * DAY_S < 0.8


def test_a_prior_that_is_far_off_does_not_lock_the_filter_out():
    model = model_of()
    phases = [-64.0 * (k + 1) for k in range(14)]
    way = filter_phases(start_of(model), days(14), phases, model)
    assert way.fate.tolist() == [REOPENED] + [USED] * 13
    assert way.after(14).estimate.y * DAY_S == pytest.approx(-64.0, abs=0.05)


@pytest.mark.parametrize('blunder', [0, 1, 2])
def test_a_blunder_before_the_clock_is_rated_is_got_over(blunder):
    model = model_of()
    stamps = [0, *days(14)]
    phases = [2.0 * k + (100.0 if k == blunder else 0.0) for k in range(15)]
    way = filter_phases(start_of(model), stamps, phases, model)
    assert way.fate[blunder] == (REFUSED if blunder else REOPENED)
    end = way.after(15).estimate
    assert end.x == pytest.approx(28.0, abs=0.5)
    assert end.y * DAY_S == pytest.approx(2.0, abs=0.5)


def test_trust_is_earned_by_three_observations():
    """The first is believed; then one outlier in a row is refused, from the fourth on two."""
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


def test_after_a_long_silence_the_observation_is_believed():
    model = model_of(patience_days=3.0)
    port = filter_phases(start_of(model), days(14), [0.0] * 14, model)
    for wait, fate in ((3, REFUSED), (4, REOPENED), (67, REOPENED)):
        later = filter_phases(port.after(14), [(14 + wait) * DAY], [500.0], model)
        assert later.fate.tolist() == [fate]
    # a jump of 500 s or a rate that changed by 500 s in 67 days: half of each
    estimate = later.after(1).estimate
    assert estimate.x == pytest.approx(500.0, abs=0.1)
    assert math.sqrt(estimate.xx) == pytest.approx(0.5, rel=1e-3)
    assert estimate.y * DAY_S == pytest.approx(0.5 * 500.0 / 67.0, rel=0.05)
    assert math.sqrt(estimate.yy) * DAY_S == pytest.approx(500.0 / 67.0 / math.sqrt(2.0), rel=0.05)


def test_what_was_expected_of_a_reopened_state_is_given_back():
    model = model_of()
    for stamps in (days(4), [0, *days(3)]):
        way = filter_phases(start_of(model), stamps, [300.0, 0.0, 0.0, 0.0], model)
        assert way.fate[0] == REOPENED
        expected = way.expected(model)
        again = update(type(expected)(*(float(column[0]) for column in expected)), 300.0, 0.25)
        assert again == way.after(1).estimate


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_late_observations_end_in_the_state_of_their_order(data):
    model = model_of(data.draw(st.sampled_from([2, 3])))
    count = data.draw(st.integers(1, 30))
    rng = np.random.default_rng(count)
    phases = (rng.normal(0.0, 0.5, count) + 200.0 * (rng.random(count) < 0.2)).tolist()
    stamps = days(count)
    order = data.draw(st.permutations(range(count)))
    track = Track(start_of(model), model)
    for k in order:
        track.use([stamps[k]], [phases[k]])
    whole = filter_phases(start_of(model), stamps, phases, model)
    assert track.last == whole.after(count)
    assert track.count(REFUSED) == np.count_nonzero(whole.fate == REFUSED)
    assert track.count(REOPENED) == np.count_nonzero(whole.fate == REOPENED)


@pytest.mark.parametrize('chunk', [1, 7, 100, 1000])
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
        each.use([stamps[-1] + DAY], [1.0])
    assert resumed.state() == track.state()


def test_observations_count_by_the_sigma_of_each():
    """Port and lunar distances against weighted least squares of a line with the prior."""
    model = ClockModel(0.5, 100.0 / DAY_S, 2, 1e-30, 1e-40)
    rng = np.random.default_rng(5)
    stamps, sources = days(30), ['port' if k % 4 == 0 else 'lunar' for k in range(30)]
    sigmas = [model.sigma_of(source) for source in sources]
    assert set(sigmas) == {0.5, 60.0}
    phases = 40.0 / DAY_S * np.array(stamps) / 1e9 + rng.normal(0.0, sigmas)
    found = filter_phases(start_of(model), stamps, phases.tolist(), model, sigmas).after(30)
    first = prior(model)
    rows = np.column_stack((np.ones(30), np.array(stamps) / 1e9))
    weights = 1.0 / np.array(sigmas) ** 2
    precision = np.diag([1.0 / first.xx, 1.0 / first.yy]) + rows.T @ (weights[:, None] * rows)
    offset, rate = np.linalg.solve(precision, rows.T @ (weights * phases))
    covariance = np.linalg.inv(precision)
    # the offset is told at the last observation; 1e-9 of it is the rounding of thirty updates
    assert found.estimate.x == pytest.approx(offset + rate * stamps[-1] / 1e9, rel=1e-8)
    assert found.estimate.y == pytest.approx(rate, rel=1e-8)
    assert found.estimate.yy == pytest.approx(covariance[1, 1], rel=1e-6)


def test_a_late_observation_keeps_its_sigma():
    model = model_of()
    stamps, phases, sigmas = days(5), [1.0, 2.0, 3.0, 4.0, 5.0], [0.5, 60.0, 0.5, 60.0, 0.5]
    whole = Track(start_of(model), model)
    whole.use(stamps, phases, sigmas)
    late = Track(start_of(model), model)
    late.use(stamps[:3] + stamps[4:], phases[:3] + phases[4:], sigmas[:3] + sigmas[4:])
    late.use([stamps[3]], [phases[3]], [sigmas[3]])
    assert late.last == whole.last
