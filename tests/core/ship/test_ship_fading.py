"""Seas that fade into one another, against the definition differentiated in 40 digits."""

from itertools import pairwise, product

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core.ship.waves import SUM_BLOCK, Fades, Harmonics, SampledFades, SampledHarmonics

S = 1_000_000_000
STEP_NS = 50_000_000
HOUR_NS = 3600 * S


def some(seed: int, n: int = 12, mean: float = 0.0) -> Harmonics:
    random = np.random.default_rng(seed)
    return Harmonics(
        random.uniform(0.01, 0.1, n), random.uniform(3.0, 20.0, n), random.uniform(-7, 7, n), mean
    )


SUMS = (some(1), some(2), None, some(3))


def passage(*at_s: float, sums: tuple[int, ...] = (0, 1, 2, 3)) -> Fades:
    return Fades(tuple(round(S * t) for t in at_s), sums[: len(at_s)], lambda k: SUMS[k])


def direct(harmonics: Harmonics | None, t: mpmath.mpf) -> mpmath.mpf:
    if harmonics is None:
        return mpmath.mpf(0)
    rows = zip(harmonics.amplitude, harmonics.period, harmonics.phase, strict=True)
    return mpmath.mpf(harmonics.mean) + sum(
        mpmath.mpf(float(a))
        * mpmath.cos(2 * mpmath.pi * t / mpmath.mpf(float(T)) + mpmath.mpf(float(eps)))
        for a, T, eps in rows
    )


def faded(fades: Fades, t: mpmath.mpf) -> mpmath.mpf:
    """The definition, with the step as the integral of its derivative ∝ u³(1 − u)³."""
    at = [mpmath.mpf(each) / S for each in fades.at_ns]
    if t <= at[0] or len(at) == 1:
        return direct(fades.of(fades.sums[0]), t)
    if t >= at[-1]:
        return direct(fades.of(fades.sums[-1]), t)
    k = next(k for k in range(len(at) - 1) if t < at[k + 1])
    one, other = fades.sums[k], fades.sums[k + 1]
    if one == other:
        return direct(fades.of(one), t)
    u = (t - at[k]) / (at[k + 1] - at[k])
    s = mpmath.betainc(4, 4, 0, u, regularized=True)
    angle = mpmath.pi / 2 * s
    return mpmath.cos(angle) * direct(fades.of(one), t) + mpmath.sin(angle) * direct(
        fades.of(other), t
    )


@pytest.mark.parametrize('begins_s', [0.0, 5_000_000.0])
@pytest.mark.parametrize('length_s', [600.0, 21_600.0])
def test_value_rate_and_acceleration_are_those_of_the_definition(begins_s, length_s):
    """A sea that fades into another, that into a calm, and out of the calm again.

    Each sum is off by at most 1.2e-13 rad of phase after 100 days (`waves`), and by rounding.
    """
    fades = passage(*(begins_s + length_s * k for k in range(4)))
    sampled = SampledFades(fades, STEP_NS)
    limits = [
        1.2 * sum(np.sum(h.amplitude * h.angular_frequency**n) for h in SUMS if h) * 1.2e-13
        for n in range(3)
    ]
    for part in (0.0, 0.07, 0.31, 0.5, 0.77, 0.98, 1.3, 1.6, 2.01, 2.5, 2.9, 3.2):
        k = round((begins_s + length_s * part) * S / STEP_NS)
        got = [float(x[0]) for x in sampled.between(k, k + 1, 0, 1, 2)]
        with mpmath.workdps(40):
            t = mpmath.mpf(k * STEP_NS) / S
            wanted = [float(mpmath.diff(lambda x: faded(fades, x), t, n)) for n in range(3)]
        assert np.all(np.abs(np.subtract(got, wanted)) < limits), (part, got, wanted)


def test_the_variance_goes_from_one_to_the_other_without_a_dip():
    """The mean square over the quarters of a turn of both phases is exactly that of the
    ensemble.
    """
    a, b, length_s = 0.3, 0.7, 1200.0
    quarters = np.arange(4) * np.pi / 2.0

    def squares(alpha: float, beta: float) -> np.ndarray:
        waves = [
            Harmonics(np.array([size]), np.array([period]), np.array([phase]))
            for size, period, phase in ((a, 9.1, alpha), (b, 6.3, beta))
        ]
        fades = Fades((0, round(length_s * S)), (0, 1), waves.__getitem__)
        (value,) = SampledFades(fades, STEP_NS).between(0, round(length_s * S) // STEP_NS, 0)
        return value**2

    mean = np.mean([squares(*each) for each in product(quarters, quarters)], axis=0)
    u = np.arange(len(mean)) / len(mean)
    angle = (
        0.5
        * np.pi
        * np.array([float(mpmath.betainc(4, 4, 0, x, regularized=True)) for x in u[::997]])
    )
    wanted = 0.5 * (a * a * np.cos(angle) ** 2 + b * b * np.sin(angle) ** 2)
    np.testing.assert_allclose(mean[::997], wanted, rtol=2e-14)
    assert mean.min() > 0.5 * a * a * (1.0 - 1e-14)
    assert mean.max() < 0.5 * b * b * (1.0 + 1e-14)


def test_where_one_sea_is_alone_it_has_the_bits_of_that_sea():
    """It is alone before the first state, between two states of the same sea, and after the
    last.
    """
    fades = Fades((HOUR_NS, 2 * HOUR_NS, 3 * HOUR_NS), (0, 0, 1), lambda k: SUMS[k])
    for orders in ((0, 1, 2), (0, 1), (2,)):
        sampled = SampledFades(fades, STEP_NS)
        for number, hour in ((0, 0.3), (0, 1.4), (1, 3.2)):
            k = round(hour * HOUR_NS / STEP_NS)
            alone = SampledHarmonics(SUMS[number], STEP_NS).between(k, k + 3 * SUM_BLOCK, *orders)
            for x, wanted in zip(
                sampled.between(k, k + 3 * SUM_BLOCK, *orders), alone, strict=True
            ):
                np.testing.assert_array_equal(x, wanted)


def test_a_calm_is_still_and_asks_for_no_sum():
    asked = []

    def of(number: int) -> Harmonics | None:
        asked.append(number)
        return SUMS[number]

    fades = Fades((0, HOUR_NS, 2 * HOUR_NS, 3 * HOUR_NS), (2, 2, 0, 0), of)
    sampled = SampledFades(fades, STEP_NS)
    assert not np.any(sampled.between(0, HOUR_NS // STEP_NS, 0, 1, 2))
    assert asked == [2]
    assert np.any(sampled.between(HOUR_NS // STEP_NS, HOUR_NS // STEP_NS + 9000, 0)[0])
    assert set(asked) == {0, 2}


@settings(max_examples=25, deadline=None)
@given(cuts=st.lists(st.integers(1, 95_000), max_size=8), backward=st.booleans())
def test_bits_do_not_depend_on_the_split(cuts, backward):
    fades = passage(-300.0, 1000.025, 1800.0, 4000.0)
    ends = sorted({0, 96_000, *cuts})
    whole = SampledFades(fades, STEP_NS).between(0, 96_000, 0, 2)
    sampled = SampledFades(fades, STEP_NS)
    ranges = sorted(pairwise(ends), reverse=backward)
    parts = dict(zip(ranges, (sampled.between(*each, 0, 2) for each in ranges), strict=True))
    for order, x in enumerate(whole):
        joined = np.concatenate([parts[each][order] for each in sorted(ranges)])
        np.testing.assert_array_equal(joined, x)


def test_each_order_alone_has_the_bits_of_all_together():
    fades = passage(0.0, 700.0, 1400.0)
    together = SampledFades(fades, STEP_NS).between(100, 30_000, 0, 1, 2)
    for orders in ((0,), (2,), (0, 1), (0, 2)):
        alone = SampledFades(fades, STEP_NS).between(100, 30_000, *orders)
        for order, x in zip(orders, alone, strict=True):
            np.testing.assert_array_equal(x, together[order])
