"""The standard error of a mean rate: by closed forms, over many clocks, in chunks of any size."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from tauto_core.navigation import RateError, RateScatter
from tauto_core.samples import SECONDS_PER_DAY, FloatArray, TimeSamples, same

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
    """Return the standard errors of clocks that gain `rates` s/s each second; without unknown."""
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
    return rates, 1e-3 * float(np.sqrt(variance)) * SECONDS_PER_DAY


def rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def test_the_error_is_the_same_to_the_last_bit_in_chunks_of_any_size() -> None:
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


@pytest.mark.parametrize('memory_s', [0.01, 10.0, 50.0])
def test_it_is_the_scatter_of_mean_rates_however_neighbours_are_correlated(
    memory_s: float,
) -> None:
    """Memories of none, a hundredth and a twentieth of the run. 200 clocks with some four degrees
    of freedom each give the root mean square to 3 %; the mean over the memories, where the run
    hardly tells them apart, makes it larger by a fifth at most.
    """
    rates, true = remembering(200, memory_s)
    sigmas = stated(rates)
    assert len(sigmas) >= 140
    assert 0.95 * true < rms(sigmas) < 1.3 * true


def test_a_memory_of_a_fifth_of_the_run_is_mostly_refused_and_else_believed_within_two() -> None:
    rates, true = remembering(200, 0.2 * LENGTH_S)
    sigmas = stated(rates)
    assert len(sigmas) < 60
    assert 0.5 * true < rms(sigmas) < 2.0 * true


def test_a_rate_that_wanders_for_longer_than_the_run_is_not_projected() -> None:
    rates, _ = remembering(200, 3.0 * LENGTH_S)
    assert len(stated(rates)) < 20
    drifting = found(readings(np.arange(LENGTH_S + 1) + 1e-9 * np.arange(LENGTH_S + 1.0) ** 2))
    assert drifting.standard_error_s_per_day is None
    assert drifting.why_unknown.startswith('cannot be projected from so short a run: ')
    assert drifting.why_unknown.endswith('Sail longer')


def test_jitter_of_the_readings_counts_at_both_ends_and_not_in_every_part() -> None:
    """The mean of the run has √2 of the jitter over its length; independent parts would have had
    3.2 times as much. The slowest cosines have √2 times as much.
    """
    jitter = 1e-3 * np.random.default_rng(1727).standard_normal((200, LENGTH_S + 1))
    sigmas = stated(np.zeros((200, LENGTH_S)), jitter)
    true = 2.0**0.5 * 1e-3 / LENGTH_S * SECONDS_PER_DAY
    assert len(sigmas) == 200
    assert true < rms(sigmas) < 1.6 * true


def test_a_start_that_has_died_away_counts_by_what_it_does_to_the_mean() -> None:
    time = np.arange(LENGTH_S) + 0.5
    (sigma,) = stated(1e-3 * np.exp(-time / 20.0)[None])
    bias = 1e-3 * 20.0 / LENGTH_S * SECONDS_PER_DAY
    assert bias < sigma < 2.0 * bias
