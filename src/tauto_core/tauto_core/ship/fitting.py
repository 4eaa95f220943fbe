"""Compiled choice and fit of the pieces of ship motion; import on first use only (numba).

All fits are Newton's form, from divided differences: data that vary slowly leave small
differences, so that nothing large cancels when they are turned into powers of x, however many
samples a piece spans. Sums have a fixed order: the bits do not depend on the batch.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tauto_core.samples import FloatArray, IntArray

BLOCK = 256
"""Samples whose differences are taken at one go; they stay in the fastest cache."""


@njit(cache=True, nogil=True)
def choose_pieces(
    times: IntArray,
    offset: int,
    begin: int,
    stride: int,
    window: tuple[int, int],
    log_ns: int,
    end_ns: int,
    limits: tuple[int, int],
    early: bool,
    final: bool,
) -> tuple[IntArray, IntArray, NDArray[np.bool_], int, bool]:
    """Return the pieces that can be used: first and last sample, and which are regular.

    A regular piece spans `stride` samples from a multiple of it on; its window is evenly spaced,
    with as many samples more on either side. Where that fails, or a logged instant or the end
    falls inside a piece of several samples, single pieces take its place. Where `early` allows it,
    the first pieces span `stride` samples, too: their windows are as wide but begin at the first
    sample, and they are not regular. A piece that may yet become long waits; so what is chosen
    does not depend on when samples come.

    Args:
        times: of the samples at hand [ns], strictly increasing, shape (m,).
        offset: index of the first of them, counted from the start of the run.
        begin: place in `times` from which on pieces are wanted.
        stride: samples that a regular piece spans, >= 1.
        window: samples before a piece in a centred window; samples in the window of one that
            spans one sample.
        log_ns: time between logged instants [ns].
        end_ns: no piece begins at or after this time [ns].
        limits: longest distance of samples that is not counted as bridged; longest that is
            interpolated [ns].
        early: whether long pieces may begin before a centred window can.
        final: no more samples will come.

    Returns:
        Also the number of steps bridged, and whether a longer gap comes next.
    """
    have, before = len(times), window[0]
    first = np.empty(max(have - begin, 0), np.int64)
    last = np.empty_like(first)
    regular = np.empty(len(first), np.bool_)
    count, bridged, k = 0, 0, begin
    ahead = -(offset + begin) % stride  # samples to the next multiple
    next_log = -1
    scanned, even_from = 1, 0
    if _all_even(times):
        scanned = have - 1
    while k + 1 < have and times[k] < end_ns:
        step = times[k + 1] - times[k]
        if step > limits[1]:
            return first[:count], last[:count], regular[:count], bridged, True
        if next_log <= times[k]:
            next_log = (times[k] // log_ns + 1) * log_ns
        even, centred = False, k >= before
        if ahead == 0 and (centred or (early and stride > 1)):
            from_first = max(k - before, 0)
            reach = from_first + stride + 2 * before
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
        whole = max(k + offset - before, 0) - offset + window[1] <= have
        if not (even or whole or final):
            break
        span = stride if even else 1
        first[count], last[count], regular[count] = k, k + span, even and centred
        count += 1
        k += span
        ahead = (ahead if ahead > 0 else stride) - span
        if step > limits[0]:
            bridged += span
    return first[:count], last[:count], regular[:count], bridged, False


@njit(cache=True, nogil=True)
def _all_even(times: IntArray) -> bool:
    even = True
    for i in range(len(times) - 1):
        even &= times[i + 1] - times[i] == times[1] - times[0]
    return even


@njit(cache=True, nogil=True)
def fit_values(
    basis: FloatArray,
    size: int,
    values: FloatArray,
    first: IntArray,
    rows: IntArray,
    result: FloatArray,
) -> None:
    """Fill rows with the polynomials through evenly spaced values.

    Args:
        basis: powers of x of Newton's basis over the factorials, shape (w', w'), w' ≥ w a
            multiple of four, zero beyond w.
        size: w.
        values: the channel, shape (m,).
        first: first sample of each row's window of w, rising, shape (n,).
        rows: row of the result for each of them, shape (n,).
        result: output, shape (rows, >= w); what lies beyond w becomes zero.
    """
    work = np.empty(BLOCK + size)
    newton = np.zeros((len(basis), BLOCK))
    done = 0
    while done < len(first):
        base = first[done]
        count = 1
        while done + count < len(first) and first[done + count] - base < BLOCK:
            count += 1
        places = first[done : done + count] - base
        length = places[count - 1] + size
        work[:length] = values[base : base + length]
        for k in range(size):
            _pick(work, places, newton[k])
            for i in range(length - 1 - k):
                work[i] = work[i + 1] - work[i]
        _to_powers(basis, newton, count, rows[done : done + count], result)
        done += count


@njit(cache=True, nogil=True)
def fit_hermite(
    basis: FloatArray,
    size: int,
    values: FloatArray,
    rates: FloatArray,
    step_s: FloatArray,
    first: IntArray,
    rows: IntArray,
    result: FloatArray,
) -> None:
    """Fill rows with the polynomials through evenly spaced values and rates.

    Each sample counts twice. Differences of level k that begin with the first of its two are
    kept apart from those that begin with the second.

    Args:
        basis: powers of x of Newton's basis, shape (w', w'), w' ≥ 2 w a multiple of four, zero
            beyond 2 w.
        size: 2 w.
        values: the channel, shape (m,).
        rates: its time derivative [1/s], shape (m,).
        step_s: time between samples in each row's window [s], shape (n,).
        first: first sample of each row's window of w, rising, shape (n,).
        rows: row of the result for each of them, shape (n,).
        result: output, shape (rows, >= 2 w); what lies beyond becomes zero.
    """
    points = size // 2
    ones, twos = np.empty(BLOCK + points), np.empty(BLOCK + points)
    newton = np.zeros((len(basis), BLOCK))
    done = 0
    while done < len(first):
        base, step = first[done], step_s[done]
        count = 1
        while (
            done + count < len(first)
            and first[done + count] - base < BLOCK
            and step_s[done + count] == step
        ):
            count += 1
        places = first[done : done + count] - base
        length = places[count - 1] + points
        ones[:length] = values[base : base + length]
        twos[:length] = ones[:length]
        slopes = rates[base : base + length]
        for k in range(size):
            _pick(ones, places, newton[k])
            if k == 0:
                for i in range(length - 1):
                    twos[i] = twos[i + 1] - twos[i]
                for i in range(length):
                    ones[i] = slopes[i] * step
                continue
            per_one, per_two = 1.0 / ((k + 1) // 2), 1.0 / ((k + 2) // 2)
            for i in range(length - (k + 2) // 2):
                one = (twos[i] - ones[i]) * per_one
                twos[i] = (ones[i + 1] - twos[i]) * per_two
                ones[i] = one
            if k % 2 == 0:
                i = length - 1 - k // 2
                ones[i] = (twos[i] - ones[i]) * per_one
        _to_powers(basis, newton, count, rows[done : done + count], result)
        done += count


@njit(cache=True, nogil=True)
def take_windows(
    values: FloatArray,
    rates: FloatArray,
    length_s: FloatArray,
    first: IntArray,
    rows: IntArray,
    result: FloatArray,
) -> None:
    """Fill rows with windows of samples: values, then rates times a length.

    Args:
        values: the channel, shape (m,).
        rates: its time derivative [1/s], shape (m,).
        length_s: of each row's piece [s], shape (n,).
        first: first sample of each row's window, shape (n,).
        rows: row of the result for each of them, shape (n,).
        result: output, shape (rows, twice the samples in a window).
    """
    points = result.shape[1] // 2
    for n in range(len(rows)):
        row, begin, length = result[rows[n]], first[n], length_s[n]
        for i in range(points):
            row[i], row[points + i] = values[begin + i], rates[begin + i] * length


@njit(cache=True, nogil=True)
def _pick(values: FloatArray, places: IntArray, picked: FloatArray) -> None:
    """Fill with the values at some places; the way out keeps slow gather instructions away."""
    for r in range(len(places)):
        if places[r] < 0:
            break
        picked[r] = values[places[r]]


@njit(cache=True, nogil=True)
def _to_powers(
    basis: FloatArray, newton: FloatArray, count: int, rows: IntArray, result: FloatArray
) -> None:
    """Turn Newton's coefficients, (w, count), into those of the powers of x; small terms first.

    w is a multiple of four: what was added to make it so is zero, here and there.
    """
    size = len(basis)
    powers = np.empty((size, count))
    for j in range(0, size, 2):
        left, right = powers[j], powers[j + 1]
        for r in range(count):
            left[r], right[r] = 0.0, 0.0
        for k in range(size - 4, j - 4, -4):
            b0, b1, b2, b3 = basis[k, j], basis[k + 1, j], basis[k + 2, j], basis[k + 3, j]
            i = j + 1
            c0, c1, c2, c3 = basis[k, i], basis[k + 1, i], basis[k + 2, i], basis[k + 3, i]
            n0, n1, n2, n3 = newton[k], newton[k + 1], newton[k + 2], newton[k + 3]
            for r in range(count):
                left[r] += (b3 * n3[r] + b2 * n2[r]) + (b1 * n1[r] + b0 * n0[r])
                right[r] += (c3 * n3[r] + c2 * n2[r]) + (c1 * n1[r] + c0 * n0[r])
    for j in range(result.shape[1]):
        power = powers[j]
        for r in range(count):
            result[rows[r], j] = power[r]


@njit(cache=True, nogil=True, error_model='numpy')
def fit_windows(
    times: IntArray,
    values: FloatArray,
    rates: FloatArray | None,
    pieces: tuple[IntArray, IntArray],
    first: IntArray,
    points: int,
    rows: IntArray,
    result: FloatArray,
) -> None:
    """Fill rows with the polynomials through windows of samples at any times.

    Args:
        times: of the samples [ns], strictly increasing, shape (m,).
        values: the channel, shape (m,).
        rates: its time derivative [1/s], shape (m,), or None.
        pieces: samples at which each piece begins and ends, shapes (n,).
        first: first sample of each piece's window, shape (n,).
        points: samples in a window.
        rows: row of the result for each piece, shape (n,).
        result: output, shape (rows, >= points, with rates >= 2 points); zero beyond.
    """
    twice = 1 if rates is None else 2
    size = twice * points
    nodes, newton = np.empty(size), np.empty(size)
    for n in range(len(rows)):
        begin, length = times[pieces[0][n]], times[pieces[1][n]] - times[pieces[0][n]]
        for i in range(size):
            sample = first[n] + i // twice
            nodes[i] = (times[sample] - begin) / length
            newton[i] = values[sample]
        for k in range(1, size):
            for i in range(size - 1, k - 1, -1):
                if rates is not None and k == 1 and i % 2 == 1:
                    newton[i] = rates[first[n] + i // 2] * (length * 1e-9)
                else:
                    newton[i] = (newton[i] - newton[i - 1]) / (nodes[i] - nodes[i - k])
        row = result[rows[n]]
        row[:] = 0.0
        for k in range(size - 1, -1, -1):
            for j in range(size - 1 - k, 0, -1):
                row[j] = row[j - 1] - nodes[k] * row[j]
            row[0] = newton[k] - nodes[k] * row[0]
