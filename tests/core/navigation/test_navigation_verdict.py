"""The verdict on a voyage: the scatter of the rate, its projection, and the time it is rated."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from tauto_core.machines import compile_machine
from tauto_core.navigation import (
    ClockModel,
    DriftStage,
    RatedTime,
    RateError,
    RateScatter,
    has_settled,
    projection,
)
from tauto_core.results import Summary
from tauto_core.samples import OBSERVATION, READING, FloatArray, TimeSamples, same
from tauto_core.scene import load_scene
from tauto_core.scene.times import DAY_S, NS_PER_S
from tauto_core.voyage import sail

QUIET = ClockModel(0.5, 1e-4, white_fm_s=0.0, random_walk_fm_per_s=0.0)
KNOWN = {'rate_s_per_day': 0.75, 'rate_sigma_s_per_day': 0.5}


def sure(scatter: float) -> RateError:
    """Return a standard error that a run of no length has given."""
    return RateError(scatter, 0.0)


def test_a_second_a_day_is_a_quarter_of_a_mile_a_day() -> None:
    """The sun passes 15 arc minutes in a minute: 1 s/day for 42 days are 42 s, 10.5 miles."""
    found = projection(1.0, sure(0.25), KNOWN, QUIET, 0.0)
    six_weeks, jamaica = found['projection']
    assert found['not_projected'] is None
    assert (six_weeks['days'], jamaica['days']) == (42.0, 81.0)
    assert six_weeks['raw_error_nmi'] == pytest.approx(-10.5)
    assert six_weeks['error_nmi'] == pytest.approx(-0.25 * 10.5)
    assert six_weeks['raw_sigma_nmi'] == pytest.approx(0.25 * 10.5)
    # the estimate errs by 0.5 s/day from a mean rate that errs by 0.25
    assert six_weeks['sigma_nmi'] == pytest.approx(math.hypot(0.5, 0.25) * 10.5)
    assert jamaica['raw_error_nmi'] == pytest.approx(-81.0 / 4.0)
    at_sixty = projection(1.0, sure(0.25), KNOWN, QUIET, -60.0)['projection'][0]
    assert at_sixty['raw_error_nmi'] == pytest.approx(-10.5 / 2.0)
    # a run as long as the voyage: the rates of both scatter alike, and their difference by √2
    as_long = projection(1.0, RateError(0.25, 42.0 * DAY_S), KNOWN, QUIET, 0.0)['projection'][0]
    assert as_long['raw_sigma_nmi'] == pytest.approx(2.0**0.5 * 0.25 * 10.5)


def test_a_clock_that_is_known_exactly_still_gathers_noise() -> None:
    """White noise of the frequency: the phase walks by √(q₁ T), here 0.1 s √42. A random walk of
    the dial's rate by q₂ gives √(q₂ T³/3), and as much again if the mean rate belongs to a run
    as long as the voyage.
    """
    noisy = ClockModel(0.5, 1e-4, white_fm_s=0.1**2 / 86_400.0, random_walk_fm_per_s=0.0)
    known = {'rate_s_per_day': 0.0, 'rate_sigma_s_per_day': 0.0}
    found = projection(0.0, sure(0.0), known, noisy, 0.0)['projection'][0]
    assert found['sigma_nmi'] == pytest.approx(0.25 * 0.1 * 42.0**0.5)
    assert found['raw_sigma_nmi'] == 0.0
    walk = (0.1 / 86_400.0) ** 2 / 86_400.0
    for length_s, times in ((0.0, 1.0), (42.0 * 86_400.0, 2.0)):
        run = RateError(0.0, length_s)
        found = projection(0.0, run, known, noisy, 0.0, walk)['projection'][0]
        expected = 0.25 * 0.1 * (times * 42.0**3 / 3.0) ** 0.5
        assert found['raw_sigma_nmi'] == pytest.approx(expected)


@pytest.mark.parametrize(
    ('rate', 'scatter', 'said'),
    [
        (1_028.0, 1.0, None),
        (1_029.0, 1.0, 'the dial cannot be projected: after 42 days it is wrong by 43,218 s'),
        (-1_029.0, 1.0, 'the dial cannot be projected: after 42 days it is wrong by 43,218 s'),
        (0.0, 1_028.0, None),
        (0.0, 1_029.0, 'the dial cannot be projected from so short a run: after 42 days its ± is'),
    ],
)
def test_no_projection_goes_beyond_half_a_turn(rate: float, scatter: float, said: str) -> None:
    """Half a day, 43,200 s, in 42 days are 1028.6 s/day, wherever on the globe."""
    for latitude in (0.0, 60.0):
        found = projection(rate, sure(scatter), KNOWN, QUIET, latitude)
        first = found['projection'][0]
        assert (first['raw_error_nmi'] is None) == (said is not None)
        assert (first['raw_sigma_nmi'] is None) == (said is not None)
        assert found['projection'][1]['raw_error_nmi'] is None  # 81 days, wrong by more
        assert (said or 'after 81 days') in found['not_projected']


def test_only_the_corrected_clock_of_a_wrong_dial_is_projected() -> None:
    rated = {'rate_s_per_day': -2_511.0, 'rate_sigma_s_per_day': 0.5}
    found = projection(-2_511.0, sure(0.0), rated, QUIET, 0.0)
    assert [row['raw_error_nmi'] for row in found['projection']] == [None, None]
    assert found['projection'][0]['sigma_nmi'] == pytest.approx(0.5 * 10.5)
    assert 'corrected' not in found['not_projected']


def test_without_a_standard_error_the_reason_is_given() -> None:
    unknown = RateError(None, 3_600.0, 'cannot be projected: the swing dies away')
    assert projection(1.0, unknown, KNOWN, QUIET, 0.0) == {
        'projection': [],
        'not_projected': 'cannot be projected: the swing dies away',
    }


def why(name: str, length_s: float = 3_600.0, sigma: float | None = 1.0, **changed: Any) -> str:
    scene = load_scene(name).model_copy(update=changed)
    error = has_settled(scene, compile_machine(scene), RateError(sigma, length_s))
    assert (error.standard_error_s_per_day is None) == bool(error.why_unknown or sigma is None)
    return error.why_unknown


@pytest.mark.parametrize(
    ('scene', 'reason'),
    [
        ('involute_weight_at_sea', 'nothing damps the wheel, on whose amplitude the rate depends'),
        ('hanging_thread_at_sea', 'nothing holds the swing of the thread'),
        ('clock_own_cam_weight', 'nothing damps the swing of the case, on which the rate depends'),
        ('second_cam_at_sea', ''),
        ('clock_second_cam_force', ''),
        ('sully_lever_at_sea', ''),
        ('portsmouth_jamaica', ''),
        ('ideal', ''),
        ('globe_in_oil', ''),
    ],
)
def test_an_undamped_swing_has_no_known_mean_rate(scene: str, reason: str) -> None:
    """Over 30 seeds the rates of the first three scatter by 5 to 13 times what runs show. An
    isochronous wheel does not depend on its start, and a held one forgets in a minute.
    """
    assert why(scene).startswith(f'cannot be projected: {reason}' if reason else '')
    assert bool(why(scene, sigma=None)) == bool(reason)


def test_the_reason_depends_on_ship_error_and_driving() -> None:
    """A tenth of the amplitude is 82 s/day on the involute."""
    assert not why('involute_weight_at_sea', ship=load_scene('ideal').ship)
    assert why('involute_weight_at_sea', sigma=81.0)
    assert not why('involute_weight_at_sea', sigma=83.0)
    assert 'the swing dies away' in why('sully_lever_at_sea', escapement=None)


def test_a_held_swing_is_forgotten_in_ten_time_constants() -> None:
    """2 J/c is 80 s for the amplitude, J/c 40 s for the energy."""
    assert why('sully_lever_at_sea', 399.0) == (
        'cannot be projected from so short a run: its rate depends on the amplitude, which takes '
        '6.7 minutes to settle. Sail longer'
    )
    assert not why('sully_lever_at_sea', 401.0)


def test_a_voyage_without_projection_has_no_standard_error() -> None:
    report = sail(load_scene('involute_weight_at_sea', duration=600.0)).result
    assert report['longitude']['projection'] == []
    assert 'nothing damps the wheel' in report['longitude']['not_projected']
    assert report['clock']['rate_standard_error_s_per_day'] is None


# -----------------------------------------------------------------------------
# The standard error of a mean rate: by closed forms, over many clocks, in chunks of any size.

SECOND = 1_000_000_000
LENGTH_S = 1024


def readings(dial_s: FloatArray, first_s: int = 0) -> TimeSamples:
    """Return readings a second apart, whatever the dial shows."""
    stamps = (first_s + np.arange(len(dial_s), dtype=np.int64)) * SECOND
    dial_ns = np.round(dial_s * 1e9).astype(np.int64)
    return TimeSamples(stamps, '', dial_ns, same('dial', len(stamps)))


def found(samples: TimeSamples, chunk: int = LENGTH_S + 1, length_s: int = LENGTH_S) -> RateError:
    scatter = RateScatter(int(samples.stamp_ns[0]), length_s * SECOND)
    for k in range(0, len(samples.stamp_ns), chunk):
        part = slice(k, k + chunk)
        stamps, dial = samples.stamp_ns[part], samples.time_ref_ns[part]
        scatter.feed(TimeSamples(stamps, '', dial, samples.source[part]))
    return scatter.rate_error()


def stated(rates: FloatArray, jitter_s: FloatArray | float = 0.0) -> FloatArray:
    """Return the standard errors of clocks that gain `rates` s/s, without unknown ones."""
    dials = np.concatenate([np.zeros((len(rates), 1)), np.cumsum(1.0 + rates, axis=1)], axis=1)
    sigmas = [found(readings(dial)).standard_error_s_per_day for dial in dials + jitter_s]
    return np.array([sigma for sigma in sigmas if sigma is not None])


def remembering(clocks: int, memory_s: float) -> tuple[FloatArray, float]:
    """Return rates of variance 1e-6 that forget e-fold in a time, and the sigma of their mean.

    For r_k = a r_{k−1} + noise the mean of N has σ²/N² (N + 2 Σ (N − k) aᵏ), k = 1 … N − 1.
    """
    a = np.exp(-1.0 / memory_s)
    noise = np.random.default_rng(1726).standard_normal((clocks, LENGTH_S))
    noise[:, 1:] *= np.sqrt(1.0 - a * a)
    later = np.arange(1, LENGTH_S)
    variance = (LENGTH_S + 2.0 * np.sum((LENGTH_S - later) * a**later)) / LENGTH_S**2
    rates: FloatArray = 1e-3 * lfilter([1.0], [1.0, -a], noise)
    return rates, 1e-3 * float(np.sqrt(variance)) * DAY_S


def rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def test_chunks_do_not_change_the_bits_of_the_error() -> None:
    rates, _ = remembering(1, 5.0)
    whole = readings(np.cumsum(1.0 + rates[0]), first_s=5)
    assert len({found(whole, chunk) for chunk in (1, 7, 100, 1024)}) == 1


def test_a_constant_rate_is_known_exactly() -> None:
    """But for the rounding of both ends to a nanosecond: 1e-9 s in 1024 s are 8e-8 s/day."""
    sigma = found(readings(np.arange(LENGTH_S + 1) * 1.001)).standard_error_s_per_day
    assert sigma == pytest.approx(0.0, abs=1e-7)


def test_a_run_cut_short_counts_and_32_readings_are_too_few() -> None:
    dial = np.arange(LENGTH_S + 1) + 1e-3 * np.sin(np.arange(LENGTH_S + 1))
    assert found(readings(dial[:33])).standard_error_s_per_day is not None
    for too_few in (32, 1):
        short = found(readings(dial[:too_few]))
        assert short.standard_error_s_per_day is None
        assert f'it is logged {too_few} times' in short.why_unknown
    rarely = found(readings(dial), length_s=20_000)
    assert rarely.standard_error_s_per_day is not None
    assert rarely.length_s == pytest.approx(LENGTH_S, abs=20.0)


@pytest.mark.parametrize(
    ('memory_s', 'told', 'low', 'high'),
    [
        *((memory_s, (140, 200), 0.95, 1.3) for memory_s in (0.01, 10.0, 50.0)),
        (0.2 * LENGTH_S, (10, 60), 0.5, 2.0),  # mostly refused
    ],
)
def test_the_error_is_the_scatter_of_correlated_rates(
    memory_s: float, told: tuple[int, int], low: float, high: float
) -> None:
    """No memory, a hundredth and a twentieth of the run. 200 clocks with some four degrees
    of freedom each give the root mean square to 3 %. The mean over the memories, which the run
    hardly distinguishes, makes it larger by a fifth at most.
    """
    rates, true = remembering(200, memory_s)
    sigmas = stated(rates)
    assert told[0] <= len(sigmas) <= told[1]
    assert low * true < rms(sigmas) < high * true


def test_memory_longer_than_the_run_is_refused() -> None:
    rates, _ = remembering(200, 3.0 * LENGTH_S)
    assert len(stated(rates)) < 20
    drifting = found(readings(np.arange(LENGTH_S + 1) + 1e-9 * np.arange(LENGTH_S + 1.0) ** 2))
    assert drifting.standard_error_s_per_day is None
    assert drifting.why_unknown.startswith('cannot be projected from so short a run: ')
    assert drifting.why_unknown.endswith('Sail longer')


def test_jitter_of_readings_counts_at_both_ends_only() -> None:
    """The mean of the run has √2 of the jitter over its length. Independent parts would have had
    3.2 times as much. The slowest cosines have √2 times as much.
    """
    jitter = 1e-3 * np.random.default_rng(1727).standard_normal((200, LENGTH_S + 1))
    sigmas = stated(np.zeros((200, LENGTH_S)), jitter)
    true = 2.0**0.5 * 1e-3 / LENGTH_S * DAY_S
    assert len(sigmas) == 200
    assert true < rms(sigmas) < 1.6 * true


def test_a_transient_counts_by_its_bias_of_the_mean() -> None:
    time = np.arange(LENGTH_S) + 0.5
    (sigma,) = stated(1e-3 * np.exp(-time / 20.0)[None])
    bias = 1e-3 * 20.0 / LENGTH_S * DAY_S
    assert bias < sigma < 2.0 * bias


# -----------------------------------------------------------------------------
# Since when the estimated rate has been the same, after the dial has changed its rate.

DAY_NS = int(DAY_S) * NS_PER_S


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
    times.feed({**batches, **said})
    return {'start': times.start(), 'drift': summary.drift()}


@pytest.mark.parametrize(
    ('observed_days', 'start_day'),
    [([0, 1, 2, 3], None), ([0, 1, 2, 3, 30, 31, 32], 31), ([0, 1, 2, 3, 30, 31, 32, 59], 32)],
    ids=['never reopened', 'not measured since', 'measured since'],
)
def test_the_rate_is_one_since_the_state_was_reopened(observed_days, start_day) -> None:
    # the third that agrees with the two before it reopens the state, at the second
    found = _voyage(observed_days)['start']
    assert (found and found[0] // DAY_NS) == start_day
    if start_day is not None:
        assert found[1] - found[0] == -40 * NS_PER_S * (start_day - 3)


def test_a_changed_rate_is_held_against_that_of_the_time_since() -> None:
    # observed without error: the estimate is -40 s/day, and the mean since the start is -38
    drift = _voyage([0, 1, 2, 3, 30, 31, 32, 59])['drift']
    assert drift['rate_s_per_day'] == pytest.approx(-40.0, abs=0.1)
    assert abs(drift['rate_error_sigmas']) < 1.0
    assert drift['rate_compared_s_per_day'] == pytest.approx(-40.0, rel=1e-9)
    assert drift['rate_compared_from_s'] == 32 * DAY_S


def test_the_error_of_a_walking_rate_has_its_sigma() -> None:
    """The mean square over 30 seeds. For independent errors it is within 0.78 of 1 (3 sigma)."""
    sections = {
        'duration': 20 * DAY_S,
        'log': {'interval': 21_600.0},
        'clock': {'random_walk_fm': 3.0},
        'drift': {'observation_interval': DAY_S},
    }
    squares = [
        sail(load_scene('ideal', seed=seed, **sections)).result['drift']['rate_error_sigmas'] ** 2
        for seed in range(30)
    ]
    assert 0.22 < np.mean(squares) < 1.78


def test_an_expected_walk_only_widens_the_estimate() -> None:
    sections = {'duration': DAY_S, 'log': {'interval': 3600.0}}
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
