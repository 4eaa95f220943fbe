"""Sums of harmonics against 40-digit arithmetic, and their independence of the split."""

from itertools import pairwise

import mpmath
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core.ship.waves import SUM_BLOCK, Harmonics, SampledHarmonics

STEP_NS = 50_000_000


def many(n: int = 40) -> Harmonics:
    random = np.random.default_rng(8)
    return Harmonics(
        random.uniform(0.01, 0.1, n),
        random.uniform(3.0, 20.0, n),
        random.uniform(-7.0, 7.0, n),
        0.25,
    )


def exact(harmonics: Harmonics, k: int, step_ns: int) -> list[float]:
    """Return value and derivatives at k step in 40 digits."""
    with mpmath.workdps(40):
        t = mpmath.mpf(k * step_ns) / 10**9
        sums = [mpmath.mpf(harmonics.mean), mpmath.mpf(0), mpmath.mpf(0)]
        for a, period, eps in zip(
            harmonics.amplitude, harmonics.period, harmonics.phase, strict=True
        ):
            w = 2 * mpmath.pi / mpmath.mpf(float(period))
            angle = w * t + mpmath.mpf(float(eps))
            sums[0] += float(a) * mpmath.cos(angle)
            sums[1] -= float(a) * w * mpmath.sin(angle)
            sums[2] -= float(a) * w * w * mpmath.cos(angle)
        return [float(x) for x in sums]


def test_value_and_derivatives_after_100_days():
    """675 000 blocks of at most 2^-65 turns each: 1.2e-13 rad at worst."""
    harmonics = many()
    sampled = SampledHarmonics(harmonics, STEP_NS)
    w = harmonics.angular_frequency
    limits = [1.2e-13 * float(np.sum(harmonics.amplitude * w**n)) for n in range(3)]
    for first in (0, 100 * 86_400 * 20 - 7):
        got = sampled.between(first, first + SUM_BLOCK, 0, 1, 2)
        for k in range(first, first + SUM_BLOCK, 37):
            for x, wanted, limit in zip(got, exact(harmonics, k, STEP_NS), limits, strict=True):
                assert abs(x[k - first] - wanted) < limit


def test_an_awkward_step_keeps_its_phase():
    harmonics = Harmonics(np.array([1.0]), np.array([0.7]), np.array([0.1]))
    k = 10**9
    (value,) = SampledHarmonics(harmonics, 8_388_608).between(k, k + 1, 0)
    assert abs(value[0] - exact(harmonics, k, 8_388_608)[0]) < 1e-12


def test_phases_all_round_the_circle_are_right_to_rounding():
    """Phases at the bounds of the octants are included. Products and sums of numbers up to 1
    leave two units in the last place.
    """
    for eps in np.linspace(-np.pi, np.pi, 33):
        harmonics = Harmonics(np.ones(1), np.array([10.0]), np.array([eps]))
        (value,) = SampledHarmonics(harmonics, STEP_NS).between(0, SUM_BLOCK, 0)
        for k in (0, SUM_BLOCK // 2 - 1, SUM_BLOCK // 2, SUM_BLOCK - 1):
            assert abs(value[k] - exact(harmonics, k, STEP_NS)[0]) < 4.5e-16


def test_each_order_alone_has_the_bits_of_all_together():
    together = SampledHarmonics(many(), STEP_NS).between(700, 1900, 0, 1, 2)
    for orders in ((0,), (2,), (0, 1), (0, 2)):
        alone = SampledHarmonics(many(), STEP_NS).between(700, 1900, *orders)
        for order, x in zip(orders, alone, strict=True):
            np.testing.assert_array_equal(x, together[order])


def test_no_components_leave_the_mean():
    none = np.empty(0)
    value, rate = SampledHarmonics(Harmonics(none, none, none, 0.5), STEP_NS).between(3, 5, 0, 1)
    assert value.tolist() == [0.5, 0.5]
    assert rate.tolist() == [0.0, 0.0]


@settings(max_examples=40, deadline=None)
@given(
    first=st.integers(0, 10**9),
    lengths=st.lists(st.integers(1, 3 * SUM_BLOCK), min_size=1, max_size=6),
)
def test_bits_do_not_depend_on_the_split(first, lengths):
    ends = np.cumsum([first, *lengths]).tolist()
    whole = SampledHarmonics(many(5), STEP_NS).between(ends[0], ends[-1], 0, 2)
    for backward in (False, True):
        sampled = SampledHarmonics(many(5), STEP_NS)
        ranges = sorted(pairwise(ends), reverse=backward)
        parts = dict(zip(ranges, (sampled.between(*each, 0, 2) for each in ranges), strict=True))
        for order, x in enumerate(whole):
            joined = np.concatenate([parts[each][order] for each in sorted(ranges)])
            np.testing.assert_array_equal(joined, x)
