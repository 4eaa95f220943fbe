"""Lanes against NumPy, bit for bit, and against exact fractions where NumPy rounds twice."""

from __future__ import annotations

import operator
from fractions import Fraction

import numpy as np
import pytest

from tauto_core.motion.compiled import entry
from tauto_core.motion.lanes import (
    SIZE,
    fma,
    lane,
    larger,
    largest,
    least,
    load,
    negative,
    ones,
    pointer,
    splat,
    store,
    total,
    with_lane,
)

OPERATORS = {
    'add': operator.add,
    'sub': operator.sub,
    'mul': operator.mul,
    'div': operator.truediv,
}


@entry
def operate(rows, x, n, out):
    """Every operator of rows 0 and 1 with each other, the float x and the integer n."""
    a, b = load(rows, 0), load(rows, 1)
    store(out, 0, a + b)
    store(out, 1, a + x)
    store(out, 2, x + a)
    store(out, 3, a + n)
    store(out, 4, n + a)
    store(out, 5, a - b)
    store(out, 6, a - x)
    store(out, 7, x - a)
    store(out, 8, a - n)
    store(out, 9, n - a)
    store(out, 10, a * b)
    store(out, 11, a * x)
    store(out, 12, x * a)
    store(out, 13, a * n)
    store(out, 14, n * a)
    store(out, 15, a / b)
    store(out, 16, a / x)
    store(out, 17, x / a)
    store(out, 18, a / n)
    store(out, 19, n / a)
    store(out, 20, -a)


@entry
def rearrange(rows, x, i, out, numbers):
    """All that is no operator; `numbers` takes what is one float."""
    a, b, c = load(rows, 0), load(rows, 1), load(rows, 2)
    store(out, i, c)
    store(out, 8, splat(x))
    store(out, 9, with_lane(a, i, x))
    store(out, 10, larger(a, b))
    store(out, 11, fma(a, b, c))
    store(out, 12, fma(x, b, c))
    store(out, 13, fma(a, x, c))
    store(out, 14, fma(a, b, x))
    numbers[0] = lane(a, i)
    numbers[1] = largest(a)
    numbers[2] = least(a)
    numbers[3] = total(a)
    numbers[4] = fma(numbers[5], numbers[6], numbers[7])


@entry
def tell(rows, numbers, counts):
    """What is told of lanes in whole numbers, and pointers in place of arrays."""
    place = pointer(rows)
    counts[0] = negative(load(place, 0))
    counts[1] = ones(counts[0])
    numbers[0] = place[9]
    store(place, 1, load(pointer(place), 0) + 1.0)


def same_bits(found, wanted):
    """NaNs have no bits of their own: which one comes out is the machine's choice."""
    found, wanted = np.asarray(found, np.float64), np.asarray(wanted, np.float64)
    nan = np.isnan(wanted)
    np.testing.assert_array_equal(np.isnan(found), nan)
    np.testing.assert_array_equal(found[~nan].view(np.int64), wanted[~nan].view(np.int64))


def numbers_of_all_sizes(seed, shape):
    random = np.random.default_rng(seed)
    return random.standard_normal(shape) * 10.0 ** random.integers(-120, 120, shape)


SPECIAL = np.array(
    [
        [0.0, -0.0, np.inf, -np.inf, np.nan, 5e-324, -2.2e-308, 1.7e308],
        [-0.0, 0.0, np.inf, np.inf, 1.0, 3.0, 2.2e-308, 1.7e308],
    ]
)


@pytest.mark.parametrize(
    ('rows', 'x', 'n'),
    [
        *((numbers_of_all_sizes(seed, (2, SIZE)), 10.0**seed / 3, seed - 4) for seed in range(4)),
        (SPECIAL, -0.0, 3),
        (SPECIAL, np.inf, 2**53 + 1),
    ],
)
def test_operators_give_the_bits_of_numpy(rows, x, n):
    out = np.full((21, SIZE), 7.0)
    operate(rows, x, n, out)
    a, b = rows
    with np.errstate(all='ignore'):
        wanted = [
            do(*pair)
            for do in OPERATORS.values()
            for pair in ((a, b), (a, x), (x, a), (a, float(n)), (float(n), a))
        ]
    for found, exact in zip(out, [*wanted, -a], strict=True):
        same_bits(found, exact)


def folded(values):
    """The order of `total`: the upper half onto the lower, down to one."""
    while len(values) > 1:
        values = values[: len(values) // 2] + values[len(values) // 2 :]
    return values[0]


@pytest.mark.parametrize('i', range(SIZE))
def test_what_moves_lanes_moves_the_right_ones(i):
    rows = numbers_of_all_sizes(i, (3, SIZE))
    out, numbers = np.full((15, SIZE), 7.0), np.zeros(8)
    x = -1.0 / 3.0
    rearrange(rows, x, i, out, numbers)
    a, b, c = rows
    same_bits(out[i], c)
    untouched = np.arange(SIZE) != i
    same_bits(out[:SIZE][untouched], np.full((SIZE - 1, SIZE), 7.0))
    same_bits(out[8], np.full(SIZE, x))
    same_bits(out[9], np.where(np.arange(SIZE) == i, x, a))
    same_bits(out[10], np.maximum(np.abs(a), np.abs(b)))
    same_bits(numbers[:4], [a[i], np.max(np.abs(a)), np.min(a), folded(a)])


def test_the_order_of_the_sum_is_the_documented_one():
    """Any other order of these eight gives another number."""
    rows = np.zeros((3, SIZE))
    rows[0] = [1e16, 1.0, 1.0, 1e-16, -1e16, 1.0, 1.0, -1.0]
    numbers = np.zeros(8)
    rearrange(rows, 0.0, 0, np.zeros((15, SIZE)), numbers)
    a = rows[0]
    pairs = ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7]))
    assert numbers[3] == pairs
    assert pairs not in (np.add.reduce(a), sum(a[::-1].tolist()))


def rounded(a, b, c):
    """a·b + c, rounded once: the quotient of two integers is rounded correctly in Python."""
    return float(Fraction(a) * Fraction(b) + Fraction(c))


def fused_rows(case):
    random = np.random.default_rng(11)
    a, b = random.standard_normal((2, SIZE))
    if case == 'cancelling':
        return np.array([a, b, -a * b])
    if case == 'tiny':  # the products and what is left of them are subnormal
        return np.array([a * 1e-160, b * 1e-155, a * 1e-314])
    return np.array([a, b, random.standard_normal(SIZE) * 10.0 ** np.arange(-20, 20, 5)])


@pytest.mark.parametrize('case', ['cancelling', 'tiny', 'apart'])
def test_fma_rounds_once(case):
    rows = fused_rows(case)
    x = float(rows[0, 3]) * 1.1
    out, numbers = np.zeros((15, SIZE)), np.zeros(8)
    numbers[5:] = rows[:, 5]
    rearrange(rows, x, 0, out, numbers)
    a, b, c = rows.tolist()
    xs = [x] * SIZE
    same_bits(out[11], list(map(rounded, a, b, c)))
    same_bits(out[12], list(map(rounded, xs, b, c)))
    same_bits(out[13], list(map(rounded, a, xs, c)))
    same_bits(out[14], list(map(rounded, a, b, xs)))
    same_bits(numbers[4], rounded(a[5], b[5], c[5]))
    if case == 'cancelling':
        assert np.count_nonzero(out[11]) > SIZE // 2


@pytest.mark.parametrize('row', [*SPECIAL, np.array([-1.0, 2.0, -3.0, -4.0, 5.0, 6.0, 7.0, -8.0])])
def test_bits_tell_which_lanes_are_negative(row):
    """Neither −0.0 nor what is no number is; the first lane has the lowest bit."""
    rows, numbers, counts = np.array([row, row + 100.0]), np.zeros(1), np.zeros(2, np.int64)
    before = rows[1, 1]
    tell(rows, numbers, counts)
    below = row < 0.0
    assert counts[0] == sum(1 << i for i in range(SIZE) if below[i])
    assert counts[1] == np.count_nonzero(below)
    same_bits(numbers[0], before)
    same_bits(rows[1], row + 1.0)
