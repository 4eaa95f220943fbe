"""Compiled choice and fit of the pieces of ship motion. Import on first use only.

All fits use Newton's form, from divided differences. Slowly varying data have small differences,
so their conversion to powers of x cancels little, however many samples a piece spans. Sums have a
fixed order, so the bits do not depend on the batch.
"""

import numpy as np
from numpy.typing import NDArray

from tauto_core.kernels import compiled, entry
from tauto_core.motion.lanes import SIZE, row_of, splat, store, with_lane
from tauto_core.samples import FloatArray, IntArray
from tauto_core.ship.kernels import LANES


@entry
def choose_pieces(
    times: IntArray,
    offset: int,
    begin: int,
    stride: int,
    margin: int,
    before_one: int,
    of_one: int,
    log_ns: int,
    end_ns: int,
    bridged_ns: int,
    longest_ns: int,
    early: bool,
    final: bool,
) -> tuple[IntArray, IntArray, NDArray[np.bool_], int, bool]:
    """Return the usable pieces: first and last sample, and which are regular.

    Also the number of steps bridged, and whether a gap follows that is too long.

    A regular piece begins at a multiple of `stride` and spans `stride` samples, with an evenly
    spaced window that has a margin on either side. Otherwise, and if a logged instant or the end
    is inside a piece of several samples, pieces span one sample. With `early` the first pieces
    also span `stride` samples, with windows as wide from the first sample on, but do not count as
    regular. A piece that may still become long waits, so the choice does not depend on when
    samples come.

    Times are in ns. `offset` is the index of the first sample from the start of the run, `begin`
    the place of the first piece among the samples. Pieces begin before `end_ns`. A piece that
    spans one sample has a window of `of_one`, `before_one` of them before it. Longer gaps than
    `bridged_ns` count as bridged, longer ones than `longest_ns` are not interpolated.
    """
    have = len(times)
    begins = np.empty(max(have - begin, 0), np.int64)
    ends = np.empty_like(begins)
    regular = np.empty(len(begins), np.bool_)
    count, bridged, k = 0, 0, begin
    ahead = -(offset + begin) % stride  # samples to the next multiple
    next_log = -1
    scanned, even_from = 1, 0
    if _all_even(times):
        scanned = have - 1
    while k + 1 < have and times[k] < end_ns:
        step = times[k + 1] - times[k]
        if step > longest_ns:
            return begins[:count], ends[:count], regular[:count], bridged, True
        if next_log <= times[k]:
            next_log = (times[k] // log_ns + 1) * log_ns
        even, centred = False, k >= margin
        if ahead == 0 and (centred or (early and stride > 1)):
            from_first = max(k - margin, 0)
            reach = from_first + stride + 2 * margin
            while scanned < min(reach, have - 1):
                if times[scanned + 1] - times[scanned] != times[scanned] - times[scanned - 1]:
                    even_from = scanned
                scanned += 1
            stop = times[k] + stride * step
            even = even_from <= from_first and stop <= end_ns
            even = even and (stride == 1 or stop <= next_log)
            if even and reach >= have:
                if not final:
                    break
                even = False
        is_whole = max(k + offset - before_one, 0) - offset + of_one <= have
        if not (even or is_whole or final):
            break
        span = stride if even else 1
        begins[count], ends[count], regular[count] = k, k + span, even and centred
        count += 1
        k += span
        ahead = (ahead if ahead > 0 else stride) - span
        if step > bridged_ns:
            bridged += span
    return begins[:count], ends[:count], regular[:count], bridged, False


@compiled
def _all_even(times: IntArray) -> bool:
    if len(times) < 2:
        return True
    step, uneven = times[1] - times[0], 0
    for i in range(len(times) - 1):
        uneven |= (times[i + 1] - times[i]) ^ step
    return uneven == 0


@entry
def fit_values(
    basis: FloatArray,
    size: int,
    values: FloatArray,
    begins: IntArray,
    rows: IntArray,
    result: FloatArray,
) -> None:
    """Fill rows of the result with the polynomials through evenly spaced values.

    `basis` has powers of x (rows) of Newton's basis over the factorials (columns), w′ ≥ w = `size`
    even, zero beyond w. `begins` has the first sample of each row's window of w.
    """
    newton, powers = np.empty((len(basis), SIZE)), np.empty((len(basis), SIZE))
    for start in range(0, len(rows), SIZE):
        _take(values, begins, start, newton, size)
        # two levels of differences in one pass
        for k in range(1, size, 2):
            previous = row_of(newton, k)
            difference = previous - row_of(newton, k - 1)
            store(newton, k, difference)
            for i in range(k + 1, size):
                now = row_of(newton, i)
                old_difference, difference = difference, now - previous
                store(newton, i, difference - old_difference)
                previous = now
        _to_powers(basis, size, newton, powers, start, rows, result)


@entry
def fit_hermite(
    basis: FloatArray,
    size: int,
    values: FloatArray,
    rates: FloatArray,
    step_s: FloatArray,
    begins: IntArray,
    rows: IntArray,
    result: FloatArray,
) -> None:
    """Fill rows of the result with the polynomials through evenly spaced values and rates [1/s].

    Each sample is two equal nodes, and divided differences from the first and from the second are
    kept apart. Arguments as for `fit_values`, with `size` twice the number of samples in a window
    and `step_s` the time between samples of each row.
    """
    points = size // 2
    ones, twos = np.empty((points, SIZE)), np.empty((points, SIZE))
    newton, powers = np.empty((len(basis), SIZE)), np.empty((len(basis), SIZE))
    steps = np.empty((1, SIZE))
    for start in range(0, len(rows), SIZE):
        _take(values, begins, start, twos, points)
        _take(rates, begins, start, ones, points)
        for r in range(SIZE):
            steps[0, r] = step_s[min(start + r, len(rows) - 1)]
        step, previous = row_of(steps, 0), row_of(twos, 0)
        store(newton, 0, previous)
        for i in range(points):
            store(ones, i, row_of(ones, i) * step)
        for i in range(points - 1):
            now = row_of(twos, i + 1)
            store(twos, i, now - previous)
            previous = now
        for k in range(1, size):
            store(newton, k, row_of(ones, 0))
            per_one, per_two = 1.0 / ((k + 1) // 2), 1.0 / ((k + 2) // 2)
            count = points - (k + 2) // 2
            for i in range(count):
                a, b = row_of(ones, i), row_of(twos, i)
                store(ones, i, (b - a) * per_one)
                store(twos, i, (row_of(ones, i + 1) - b) * per_two)
            if k % 2 == 0:
                store(ones, count, (row_of(twos, count) - row_of(ones, count)) * per_one)
        _to_powers(basis, size, newton, powers, start, rows, result)


@compiled
def _take(values: FloatArray, at: IntArray, start: int, lanes: FloatArray, points: int) -> None:
    """Fill lane r with the window from sample at[start + r] on, spare lanes with the last one.

    The loop over the lanes is unrolled, since at run time it would become slow gathers and
    scatters.
    """
    begins: tuple[int, ...] = ()
    for r in LANES:
        begins = (*begins, at[min(start + r, len(at) - 1)])
    for i in range(points):
        x = splat(values[begins[0] + i])
        for r in LANES:
            x = with_lane(x, r, values[begins[r] + i])
        store(lanes, i, x)


@compiled
def _to_powers(
    basis: FloatArray,
    size: int,
    newton: FloatArray,
    powers: FloatArray,
    start: int,
    rows: IntArray,
    result: FloatArray,
) -> None:
    """Convert Newton's coefficients, the rows of `newton`, to powers of x, small terms first.

    Each lane is one polynomial. `powers` holds intermediate results. A pass takes four terms,
    after the remainder.
    """
    fours = size // 4 * 4
    for j in range(0, size, 2):
        i = j + 1
        low, high = splat(0.0), splat(0.0)
        for k in range(max(fours, j), size):
            n = row_of(newton, k)
            low, high = low + basis[j, k] * n, high + basis[i, k] * n
        for block in range((fours - j + 3) // 4):
            k = fours - 4 - 4 * block
            b0, b1, b2, b3 = basis[j, k], basis[j, k + 1], basis[j, k + 2], basis[j, k + 3]
            c0, c1, c2, c3 = basis[i, k], basis[i, k + 1], basis[i, k + 2], basis[i, k + 3]
            n0, n1 = row_of(newton, k), row_of(newton, k + 1)
            n2, n3 = row_of(newton, k + 2), row_of(newton, k + 3)
            low = low + ((b3 * n3 + b2 * n2) + (b1 * n1 + b0 * n0))
            high = high + ((c3 * n3 + c2 * n2) + (c1 * n1 + c0 * n0))
        store(powers, j, low)
        store(powers, i, high)
    for r in range(min(SIZE, len(rows) - start)):
        row = rows[start + r]
        for j in range(size):
            result[row, j] = powers[j, r]


@entry
def fit_windows(
    times: IntArray,
    values: FloatArray,
    rates: FloatArray | None,
    pieces: tuple[IntArray, IntArray],
    begins: IntArray,
    points: int,
    rows: IntArray,
    result: FloatArray,
) -> None:
    """Fill rows of the result with the polynomials through windows of samples at any times.

    `times` are in ns, rates in 1/s or `None`. `pieces` has the samples at which each piece begins
    and ends, `begins` the first of its window of `points`. Columns beyond the conditions become
    zero.
    """
    twice = 1 if rates is None else 2
    size = twice * points
    nodes, newton = np.empty(size), np.empty(size)
    for n in range(len(rows)):
        begin, length = times[pieces[0][n]], times[pieces[1][n]] - times[pieces[0][n]]
        for i in range(size):
            sample = begins[n] + i // twice
            nodes[i] = (times[sample] - begin) / length
            newton[i] = values[sample]
        for k in range(1, size):
            for i in range(size - 1, k - 1, -1):
                if rates is not None and k == 1 and i % 2 == 1:
                    newton[i] = rates[begins[n] + i // 2] * (length * 1e-9)
                else:
                    newton[i] = (newton[i] - newton[i - 1]) / (nodes[i] - nodes[i - k])
        row = result[rows[n]]
        row[:] = 0.0
        for k in range(size - 1, -1, -1):
            for j in range(size - 1 - k, 0, -1):
                row[j] = row[j - 1] - nodes[k] * row[j]
            row[0] = newton[k] - nodes[k] * row[0]
