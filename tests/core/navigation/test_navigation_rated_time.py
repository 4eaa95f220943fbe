"""Since when the estimated rate has been one and the same, where the dial changes its rate."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tauto_core.navigation import DriftStage, RatedTime
from tauto_core.results import Summary
from tauto_core.samples import (
    ESTIMATE,
    NS_PER_S,
    OBSERVATION,
    READING,
    SECONDS_PER_DAY,
    TimeSamples,
    same,
)
from tauto_core.scene import load_scene
from tauto_core.voyage import sail

DAY_NS = int(SECONDS_PER_DAY) * NS_PER_S


def _voyage(observed_days: list[int]) -> dict[str, Any]:
    """Return three days at 0 s/day and then at -40, over sixty days, observed without error."""
    scene = load_scene('measured', drift={'observation_interval': 86_400.0})
    stamps = np.arange(0, 60 * DAY_NS + 1, DAY_NS // 4, dtype=np.int64)
    error_s = -40.0 * np.maximum(stamps / DAY_NS - 3.0, 0.0)
    dial = stamps + np.rint(error_s * NS_PER_S).astype(np.int64)
    at = np.array(observed_days, np.int64) * DAY_NS
    batches = {
        READING: TimeSamples(stamps, '', dial, same('', len(stamps))),
        OBSERVATION: TimeSamples(at, '', at, same('', len(at))),
    }
    stage = DriftStage(scene, expect_schedule=False)
    said = {**stage.feed(batches)}
    assert stage.health()['estimates_reopened'] == (len(observed_days) > 4)
    summary = Summary(scene)
    summary.feed({**batches, **said})
    times = RatedTime()
    times.observe(batches[OBSERVATION])
    times.read(batches[READING])
    times.estimate(said[ESTIMATE])
    return {'start': times.start(), 'drift': summary.drift()}


@pytest.mark.parametrize(
    ('observed_days', 'start_day'),
    [([0, 1, 2, 3], None), ([0, 1, 2, 3, 30], 3), ([0, 1, 2, 3, 30, 59], 30)],
    ids=['never reopened', 'not measured since', 'measured since'],
)
def test_the_rate_is_one_since_the_state_was_reopened(observed_days, start_day) -> None:
    found = _voyage(observed_days)['start']
    assert (found and found[0] // DAY_NS) == start_day
    if start_day is not None:
        assert found[1] - found[0] == -40 * NS_PER_S * (start_day - 3)


def test_a_changed_rate_is_held_against_that_of_the_time_since() -> None:
    # observed without error: the estimate is -40 s/day, and the mean since the start is -38
    drift = _voyage([0, 1, 2, 3, 30, 59])['drift']
    assert drift['rate_s_per_day'] == pytest.approx(-40.0, abs=0.1)
    assert abs(drift['rate_error_sigmas']) < 1.0
    assert drift['rate_compared_s_per_day'] == pytest.approx(-40.0, rel=1e-9)
    assert drift['rate_compared_from_s'] == 30 * SECONDS_PER_DAY


def test_the_rate_of_a_dial_that_walks_at_random_is_as_wrong_as_it_says() -> None:
    """The mean square over 60 seeds; that of independent errors is within 0.55 of 1 (3 sigma)."""
    sections = {
        'duration': 20 * SECONDS_PER_DAY,
        'log': {'interval': 21_600.0},
        'clock': {'random_walk_fm': 3.0},
        'drift': {'observation_interval': SECONDS_PER_DAY},
    }
    squares = [
        sail(load_scene('ideal', seed=seed, **sections)).result['drift']['rate_error_sigmas'] ** 2
        for seed in range(60)
    ]
    assert 0.3 < np.mean(squares) < 1.55


def test_a_walk_that_is_expected_only_is_not_simulated_and_widens_the_estimate() -> None:
    sections = {'duration': SECONDS_PER_DAY, 'log': {'interval': 3600.0}}
    known = load_scene('ideal', **sections, drift={'observation_interval': 3600.0})
    assumed = {'observation_interval': 3600.0, 'random_walk_fm': 3.0}
    found = sail(load_scene('ideal', **sections, drift=assumed)).result
    before = sail(known).result
    assert found['clock'] == before['clock']
    assert found['drift']['rate_sigma_s_per_day'] > 2.0 * before['drift']['rate_sigma_s_per_day']
    # the sigma of the error has the departure of the rate from its mean too, 3 s/day sqrt(1/3)
    wrong = found['drift']['rate_s_per_day'] - found['clock']['rate_s_per_day']
    sigma = np.hypot(found['drift']['rate_sigma_s_per_day'], np.sqrt(3.0))
    assert found['drift']['rate_error_sigmas'] == pytest.approx(wrong / sigma, rel=1e-3)
