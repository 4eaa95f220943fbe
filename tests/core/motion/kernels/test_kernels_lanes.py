"""Lanes against NumPy, bit for bit, and against exact fractions where NumPy rounds twice."""

from __future__ import annotations

import operator
from fractions import Fraction

import numpy as np
import pytest

from tauto_core.kernels import entry
from tauto_core.motion.lanes import (
    SIZE,
    WIDE_SIZE,
    combined,
    combined_both,
    filled,
    fma,
    folded_both,
    lane,
    larger,
    largest,
    lowest,
    negative,
    ones,
    row_of,
    splat,
    square_root,
    store,
    total,
    width,
    with_lane,
)

OPERATORS = {
    'add': operator.add,
    'sub': operator.sub,
    'mul': operator.mul,
    'div': operator.truediv,
}


@entry
def operate(record, x, n):
    """Every operator of rows 0 and 1 with each other, the float x and the integer n."""
    rows, out = record.rows, record.out
    a, b = row_of(rows, 0), row_of(rows, 1)
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
def rearrange(record, x, i, numbers):
    """Everything but operators. Floats go to `numbers`."""
    rows, out = record.rows, record.out
    a, b, c = row_of(rows, 0), row_of(rows, 1), row_of(rows, 2)
    store(out, i, c)
    store(out, 16, filled(a, x))
    store(out, 17, with_lane(a, i, x))
    store(out, 18, larger(a, b))
    store(out, 19, fma(a, b, c))
    store(out, 20, fma(x, b, c))
    store(out, 21, fma(a, x, c))
    store(out, 22, fma(a, b, x))
    store(out, 23, square_root(filled(rows, x)))
    store(out, 24, combined(rows, 0, a))
    both = combined_both(rows, 0, b, a)
    store(out, 25, both[0])
    store(out, 26, both[1])
    numbers[0] = lane(a, i)
    numbers[1] = largest(a)
    numbers[2] = lowest(a)
    numbers[3] = total(a)
    numbers[4] = fma(numbers[5], numbers[6], numbers[7])


@entry
def fold(record):
    """Rows of a matrix, then two of weights, then room for two more."""
    rows, out = record.rows, record.out
    many = width(rows) // 2 + 1
    both = folded_both(rows, 0, many + 2, row_of(rows, many), row_of(rows, many + 1))
    store(out, 0, both[0])
    store(out, 1, both[1])


@entry
def tell(record, numbers, counts):
    """Functions of lanes with integer results."""
    rows = record.rows
    counts[0] = negative(row_of(rows, 0))
    counts[1] = ones(counts[0])
    counts[2] = width(rows)
    numbers[0] = rows[width(rows) + 1]
    store(rows, 1, row_of(rows, 0) + 1.0)


@entry
def fill_eight(x, out):
    store(out, 0, splat(x))
    store(out, 1, row_of(out) + 1.0)


def record_of(rows, count):
    """A record of rows and of so many rows of output."""
    shapes = [('rows', 'f8', rows.shape), ('out', 'f8', (count, rows.shape[1]))]
    record = np.zeros((), shapes)
    record['rows'], record['out'] = rows, 7.0
    return record


WIDTHS = pytest.mark.parametrize('n', [SIZE, WIDE_SIZE])


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


@WIDTHS
@pytest.mark.parametrize(
    ('rows', 'x', 'whole'),
    [
        *((numbers_of_all_sizes(k, (2, WIDE_SIZE)), 10.0**k / 3, k - 4) for k in range(4)),
        (np.tile(SPECIAL, 2), -0.0, 3),
        (np.tile(SPECIAL, 2), np.inf, 2**53 + 1),
    ],
)
def test_operators_give_the_bits_of_numpy(rows, x, whole, n):
    rows = np.ascontiguousarray(rows[:, :n])
    record = record_of(rows, 21)
    operate(record, x, whole)
    a, b = rows
    with np.errstate(all='ignore'):
        wanted = [
            do(*pair)
            for do in OPERATORS.values()
            for pair in ((a, b), (a, x), (x, a), (a, float(whole)), (float(whole), a))
        ]
    for found, exact in zip(record['out'], [*wanted, -a], strict=True):
        same_bits(found, exact)


def folded(values):
    """The order of `total`: the upper half onto the lower, down to one."""
    while len(values) > 1:
        values = values[: len(values) // 2] + values[len(values) // 2 :]
    return values[0]


@pytest.mark.parametrize(
    ('i', 'n'), [(0, SIZE), (3, SIZE), (7, SIZE), (0, WIDE_SIZE), (9, WIDE_SIZE), (15, WIDE_SIZE)]
)
def test_what_moves_lanes_moves_the_right_ones(i, n):
    rows = numbers_of_all_sizes(i, (n, n))
    record, numbers, x = record_of(rows, 27), np.zeros(8), 1.0 / 3.0
    rearrange(record, x, i, numbers)
    out = record['out']
    a, b, c = rows[:3]
    same_bits(out[i], c)
    untouched = np.arange(16) != i
    same_bits(out[:16][untouched], np.full((15, n), 7.0))
    same_bits(out[16], np.full(n, x))
    same_bits(out[17], np.where(np.arange(n) == i, x, a))
    same_bits(out[18], np.maximum(np.abs(a), np.abs(b)))
    same_bits(out[23], np.full(n, np.sqrt(x)))
    same_bits(numbers[:4], [a[i], np.max(np.abs(a)), np.min(a), folded(a)])


@WIDTHS
def test_rows_are_combined_in_four_sums(n):
    """Term j goes to sum j mod 4, rounded once. Sums 0 and 1, and 2 and 3, are added first."""
    rows = np.random.default_rng(n).standard_normal((n, n))
    record = record_of(rows, 27)
    rearrange(record, 0.5, 0, np.zeros(8))
    out = record['out']

    def combination(weights, lane):
        sums = [0.0] * 4
        for j in range(n):
            sums[j % 4] = rounded(float(weights[j]), float(rows[j, lane]), sums[j % 4])
        return (sums[0] + sums[1]) + (sums[2] + sums[3])

    with_a, with_b = ([combination(rows[k], i) for i in range(n)] for k in (0, 1))
    same_bits(out[24], with_a)
    same_bits(out[25], with_b)
    same_bits(out[26], with_a)


@WIDTHS
def test_folded_rows_are_combined_as_if_unfolded(n):
    """Against the whole matrix in rational numbers. Each of n terms is rounded about twice."""
    h = n // 2
    rows = np.random.default_rng(n).standard_normal((h + 5, n))
    rows[h, h:] = rows[h, :h]
    given, record = [[Fraction(x) for x in row] for row in rows], record_of(rows, 2)
    fold(record)
    whole = {}
    for j in range(h):
        p, q, shared = given[j][:h], given[j][h:], given[h][j]
        for row, sign in ((j, 1), (n - 1 - j, -1)):
            for i in range(h):
                whole[row, i] = shared + p[i] + sign * q[i]
                whole[row, n - 1 - i] = shared - p[i] + sign * q[i]
    for weights, found in zip(given[h + 1 : h + 3], record['out'], strict=True):
        for i in range(n):
            terms = [weights[j] * whole[j, i] for j in range(n)]
            size = sum(abs(weight) for weight in weights) * max(map(abs, rows.flat))
            assert abs(Fraction(found[i]) - sum(terms)) < 2.0**-52 * n * float(size)


def rounded(a, b, c):
    """a·b + c, rounded once: the quotient of two integers is rounded correctly in Python."""
    return float(Fraction(a) * Fraction(b) + Fraction(c))


def fused_rows(case, n):
    random = np.random.default_rng(11)
    rows = np.zeros((n, n))
    a, b = random.standard_normal((2, n))
    if case == 'cancelling':
        rows[:3] = a, b, -a * b
    elif case == 'tiny':  # the products and what is left of them are subnormal
        rows[:3] = a * 1e-160, b * 1e-155, a * 1e-314
    else:
        rows[:3] = a, b, random.standard_normal(n) * 10.0 ** np.linspace(-20, 15, n)
    return rows


@WIDTHS
@pytest.mark.parametrize('case', ['cancelling', 'tiny', 'apart'])
def test_fma_rounds_once(case, n):
    rows = fused_rows(case, n)
    x = float(rows[0, 3]) * 1.1
    record, numbers = record_of(rows, 27), np.zeros(8)
    numbers[5:] = rows[:3, 5]
    rearrange(record, x, 0, numbers)
    out = record['out']
    a, b, c = rows[:3].tolist()
    xs = [x] * n
    same_bits(out[19], list(map(rounded, a, b, c)))
    same_bits(out[20], list(map(rounded, xs, b, c)))
    same_bits(out[21], list(map(rounded, a, xs, c)))
    same_bits(out[22], list(map(rounded, a, b, xs)))
    same_bits(numbers[4], rounded(a[5], b[5], c[5]))
    if case == 'cancelling':
        assert np.count_nonzero(out[19]) > n // 2


@WIDTHS
@pytest.mark.parametrize('row', [*SPECIAL, np.array([-1.0, 2.0, -3.0, -4.0, 5.0, 6.0, 7.0, -8.0])])
def test_bits_tell_which_lanes_are_negative(row, n):
    """−0.0 and NaN are not negative. Lane 0 has the lowest bit."""
    row = np.concatenate([row, -row])[:n]
    record, numbers = record_of(np.array([row, row + 100.0]), 1), np.zeros(1)
    counts, before = np.zeros(3, np.int64), record['rows'][1, 1]
    tell(record, numbers, counts)
    below = row < 0.0
    assert counts[0] == sum(1 << i for i in range(n) if below[i])
    assert counts[1] == np.count_nonzero(below)
    assert counts[2] == n
    same_bits(numbers[0], before)
    same_bits(record['rows'][1], row + 1.0)


def test_a_row_can_be_filled_and_loaded_again():
    out = np.zeros((2, SIZE))
    fill_eight(0.25, out)
    same_bits(out, np.repeat([[0.25], [1.25]], SIZE, axis=1))
