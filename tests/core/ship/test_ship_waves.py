"""Sums of harmonics and seas that fade into one another, against 40-digit arithmetic."""

from collections.abc import Callable
from functools import partial
from itertools import pairwise

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
FADING = Fades(
    tuple(round(S * t) for t in (-300.0, 1000.025, 1800.0, 4000.0)), (0, 1, 2, 3), SUMS.__getitem__
)
SAMPLED: tuple[Callable[[], SampledHarmonics | SampledFades], ...] = (
    lambda: SampledHarmonics(some(8, 5, 0.25), STEP_NS),
    lambda: SampledFades(FADING, STEP_NS),
)


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
    at = [mpmath.mpf(instant) / S for instant in fades.at_ns]
    if t <= at[0]:
        return direct(fades.of(fades.sums[0]), t)
    if t >= at[-1]:
        return direct(fades.of(fades.sums[-1]), t)
    k = next(k for k in range(len(at) - 1) if t < at[k + 1])
    u = (t - at[k]) / (at[k + 1] - at[k])
    angle = mpmath.pi / 2 * mpmath.betainc(4, 4, 0, u, regularized=True)
    old, new = (direct(fades.of(number), t) for number in fades.sums[k : k + 2])
    return mpmath.cos(angle) * old + mpmath.sin(angle) * new


def exact(motion: Callable[[mpmath.mpf], mpmath.mpf], k: int, orders: int = 3) -> list[float]:
    """Return value and derivatives at sample k in 40 digits."""
    with mpmath.workdps(40):
        t = mpmath.mpf(k * STEP_NS) / S
        return [float(mpmath.diff(motion, t, n)) for n in range(orders)]


def test_value_and_derivatives_after_100_days():
    """675 000 blocks of at most 2^-65 turns each: 1.2e-13 rad at worst."""
    harmonics = some(8, 40, 0.25)
    sampled = SampledHarmonics(harmonics, STEP_NS)
    w = harmonics.angular_frequency
    limits = [1.2e-13 * float(np.sum(harmonics.amplitude * w**n)) for n in range(3)]
    for first in (0, 100 * 86_400 * 20 - 7):
        got = sampled.between(first, first + SUM_BLOCK, 0, 1, 2)
        for k in range(first, first + SUM_BLOCK, 101):
            wanted = exact(partial(direct, harmonics), k)
            assert np.all(np.abs([x[k - first] for x in got] - np.array(wanted)) < limits)


def test_an_awkward_step_keeps_its_phase():
    harmonics = Harmonics(np.array([1.0]), np.array([0.7]), np.array([0.1]))
    k, step_ns = 10**9, 8_388_608
    (value,) = SampledHarmonics(harmonics, step_ns).between(k, k + 1, 0)
    with mpmath.workdps(40):
        assert abs(value[0] - direct(harmonics, mpmath.mpf(k * step_ns) / S)) < 1e-12


def test_phases_all_round_the_circle_are_right_to_rounding():
    """At the bounds of the octants too. Two units in the last place, from products and sums."""
    for eps in np.linspace(-np.pi, np.pi, 17):
        harmonics = Harmonics(np.ones(1), np.array([10.0]), np.array([eps]))
        (value,) = SampledHarmonics(harmonics, STEP_NS).between(0, SUM_BLOCK, 0)
        for k in (0, SUM_BLOCK // 2 - 1, SUM_BLOCK // 2, SUM_BLOCK - 1):
            [wanted] = exact(partial(direct, harmonics), k, 1)
            assert abs(value[k] - wanted) < 4.5e-16


def test_no_components_leave_the_mean():
    none = np.empty(0)
    value, rate = SampledHarmonics(Harmonics(none, none, none, 0.5), STEP_NS).between(3, 5, 0, 1)
    assert value.tolist() == [0.5, 0.5]
    assert rate.tolist() == [0.0, 0.0]


@pytest.mark.parametrize('made', SAMPLED, ids=('sum', 'fades'))
def test_each_order_alone_has_the_bits_of_all_together(made):
    together = made().between(700, 30_000, 0, 1, 2)
    for orders in ((0,), (2,), (0, 1), (0, 2)):
        for order, x in zip(orders, made().between(700, 30_000, *orders), strict=True):
            np.testing.assert_array_equal(x, together[order])


@pytest.mark.parametrize('made', SAMPLED, ids=('sum', 'fades'))
@settings(max_examples=6, deadline=None)
@given(
    first=st.integers(0, 10**9),
    cuts=st.lists(st.integers(1, 95_000), max_size=8),
    backward=st.booleans(),
)
def test_bits_do_not_depend_on_the_split(made, first, cuts, backward):
    begin = first if made is SAMPLED[0] else 0
    ends = sorted({begin, begin + 96_000, *(begin + cut for cut in cuts)})
    whole, sampled = made().between(ends[0], ends[-1], 0, 2), made()
    ranges = sorted(pairwise(ends), reverse=backward)
    parts = dict(zip(ranges, (sampled.between(*span, 0, 2) for span in ranges), strict=True))
    for order, x in enumerate(whole):
        joined = np.concatenate([parts[span][order] for span in sorted(ranges)])
        np.testing.assert_array_equal(joined, x)


@pytest.mark.parametrize('begins_s', [0.0, 5_000_000.0])
def test_value_rate_and_acceleration_are_those_of_the_definition(begins_s):
    """Two seas and a calm. A sum is off by 1.2e-13 rad at most after 100 days, and by rounding."""
    length_s = 600.0
    at_ns = tuple(round(S * (begins_s + length_s * k)) for k in range(4))
    fades = Fades(at_ns, (0, 1, 2, 3), SUMS.__getitem__)
    sampled = SampledFades(fades, STEP_NS)
    limits = [
        1.2 * sum(np.sum(h.amplitude * h.angular_frequency**n) for h in SUMS if h) * 1.2e-13
        for n in range(3)
    ]
    for part in (0.0, 0.07, 0.5, 0.98, 1.6, 2.01, 2.9, 3.2):
        k = round((begins_s + length_s * part) * S / STEP_NS)
        got = [float(x[0]) for x in sampled.between(k, k + 1, 0, 1, 2)]
        wanted = exact(partial(faded, fades), k)
        assert np.all(np.abs(np.subtract(got, wanted)) < limits), (part, got, wanted)


def test_where_one_sea_is_alone_it_has_the_bits_of_that_sea():
    """Before the first state, between two states of the same sea, and after the last."""
    fades = Fades((HOUR_NS, 2 * HOUR_NS, 3 * HOUR_NS), (0, 0, 1), SUMS.__getitem__)
    for orders in ((0, 1, 2), (0, 1), (2,)):
        sampled = SampledFades(fades, STEP_NS)
        for number, hour in ((0, 0.3), (0, 1.4), (1, 3.2)):
            k = round(hour * HOUR_NS / STEP_NS)
            span = k, k + 3 * SUM_BLOCK
            alone = SampledHarmonics(SUMS[number], STEP_NS).between(*span, *orders)
            for x, wanted in zip(sampled.between(*span, *orders), alone, strict=True):
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
