"""The standard error of a mean rate: by hand, over many clocks, and in chunks of any size."""

from __future__ import annotations

import numpy as np
import pytest

from tauto_core.navigation import RateScatter
from tauto_core.samples import SECONDS_PER_DAY, TimeSamples, same

SECOND = 1_000_000_000


def readings(dial_s: np.ndarray, first_s: int = 0) -> TimeSamples:
    """Return readings a second apart, whatever the dial shows."""
    stamps = (first_s + np.arange(len(dial_s), dtype=np.int64)) * SECOND
    dial_ns = np.round(dial_s * 1e9).astype(np.int64)
    return TimeSamples(stamps, '', dial_ns, same('dial', len(stamps)))


def scatter(samples: TimeSamples, chunk: int, length_s: int) -> float | None:
    found = RateScatter(int(samples.stamp_ns[0]), length_s * SECOND)
    for k in range(0, len(samples.stamp_ns), chunk):
        part = slice(k, k + chunk)
        stamps, dial = samples.stamp_ns[part], samples.time_ref_ns[part]
        found.feed(TimeSamples(stamps, '', dial, samples.source[part]))
    return found.standard_error_s_per_day()


def test_parts_that_gain_and_lose_alternately() -> None:
    """Ten parts of 10 s, ±1 ms each: s = √(10/9) · 8.64 s/day, over √10."""
    dial = np.arange(101) + np.interp(np.arange(101), np.arange(0, 101, 10), [0, 1e-3] * 5 + [0])
    expected = (10.0 / 9.0) ** 0.5 * 1e-4 * SECONDS_PER_DAY / 10.0**0.5
    for chunk in (1, 7, 10, 101):
        assert scatter(readings(dial, first_s=5), chunk, 100) == pytest.approx(expected)


def test_a_constant_rate_is_known_exactly() -> None:
    found = scatter(readings(np.arange(101) * 1.001), 101, 100)
    assert found == pytest.approx(0.0, abs=1e-6)


def test_a_run_cut_short_counts_whole_parts_and_two_are_too_few() -> None:
    dial = np.arange(101) + 1e-3 * np.sin(np.arange(101))
    assert scatter(readings(dial[:35]), 35, 100) is not None
    assert scatter(readings(dial[:29]), 29, 100) is None
    assert scatter(readings(dial[:1]), 1, 100) is None


def test_it_is_as_large_as_the_mean_rates_of_many_clocks_scatter() -> None:
    """White frequency noise: 400 clocks give a variance to √(2/400) = 7 %; within 3 sigmas."""
    draw = np.random.default_rng(1714)
    steps = 1.0 + 1e-3 * draw.standard_normal((400, 200))
    dials = np.concatenate([np.zeros((400, 1)), np.cumsum(steps, axis=1)], axis=1)
    rates = (dials[:, -1] / 200.0 - 1.0) * SECONDS_PER_DAY
    claimed = [scatter(readings(dial), 201, 200) for dial in dials]
    assert all(each is not None for each in claimed)
    squares = np.mean([each**2 for each in claimed if each is not None])
    assert squares == pytest.approx(np.mean(rates**2), rel=0.21)
