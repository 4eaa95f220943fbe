"""Curves through points, a cubic between neighbours: the spline's or Akima's.

`scipy.interpolate` has both, but importing it takes longer than sailing a scene for ten minutes; a
test holds that the values are the same.
"""

from __future__ import annotations

import numpy as np

from tauto_core.samples import FloatArray


def spline(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    """Return the values of the cubic spline through points, not-a-knot at both ends.

    Its slopes s make the second derivative continuous: with h_i = x_i+1 − x_i and d_i the slope of
    the chord over it, h_i s_i−1 + 2 (h_i−1 + h_i) s_i + h_i−1 s_i+1 = 3 (h_i d_i−1 + h_i−1 d_i);
    the third derivative is continuous at the second point and at the last but one. (C. de Boor, A
    Practical Guide to Splines, 1978, chapter IV.)

    Args:
        x: strictly increasing, shape (n,), n >= 4.
        y: values there, (n,).
        at: between the first x and the last, (m,).
    """
    h, n = np.diff(x), len(x)
    chord = np.diff(y) / h
    # Below the first row and above the last there is nothing: zeros, which the solver multiplies.
    below, diagonal, above, right = np.zeros((4, n))
    below[1:-1], diagonal[1:-1], above[1:-1] = h[1:], 2.0 * (h[:-1] + h[1:]), h[:-1]
    right[1:-1] = 3.0 * (h[1:] * chord[:-1] + h[:-1] * chord[1:])
    first, last = x[2] - x[0], x[-1] - x[-3]
    diagonal[0], above[0] = h[1], first
    right[0] = ((h[0] + 2.0 * first) * h[1] * chord[0] + h[0] ** 2 * chord[1]) / first
    below[-1], diagonal[-1] = last, h[-2]
    right[-1] = (h[-1] ** 2 * chord[-2] + (2.0 * last + h[-1]) * h[-2] * chord[-1]) / last
    return _hermite(x, y, _tridiagonal(below, diagonal, above, right), at)


def akima(x: FloatArray, y: FloatArray, at: FloatArray) -> FloatArray:
    """Return the values of Akima's curve through points (J. ACM 17, 1970, 589).

    With m_i the slopes of the chords, the slope at a point between the chords m₂ and m₃ is
    (w₂ m₂ + w₃ m₃)/(w₂ + w₃), w₂ = |m₄ − m₃| and w₃ = |m₂ − m₁|, or their mean where both are
    zero. Beyond the ends the slopes go on linearly.

    Args:
        x: strictly increasing, shape (n,), n >= 2; two points are joined by a straight line.
        y: values there, (n,).
        at: between the first x and the last, (m,).
    """
    m = np.pad(np.diff(y) / np.diff(x), 2, mode='edge')
    for i, one, two in ((1, 2, 3), (0, 1, 2), (-2, -3, -4), (-1, -2, -3)):
        m[i] = 2.0 * m[one] - m[two]
    change = np.abs(np.diff(m))
    before, after = change[:-2], change[2:]
    both = before + after
    slopes = 0.5 * (m[3:] + m[:-3])
    apart = both > 1e-9 * np.max(both)
    share = before[apart] / both[apart]
    slopes[apart] = m[1:-2][apart] + share * (m[2:-1][apart] - m[1:-2][apart])
    return _hermite(x, y, slopes, at)


def _hermite(x: FloatArray, y: FloatArray, slopes: FloatArray, at: FloatArray) -> FloatArray:
    """Return the cubics with given values and slopes at the points."""
    h = np.diff(x)
    chord = np.diff(y) / h
    bend = (slopes[:-1] + slopes[1:] - 2.0 * chord) / h
    i = np.clip(np.searchsorted(x, at, 'right') - 1, 0, len(x) - 2)
    u = at - x[i]
    square = u * u
    value = y[i] + slopes[i] * u + ((chord - slopes[:-1]) / h - bend)[i] * square
    return np.asarray(value + (bend / h)[i] * (square * u))


def _tridiagonal(
    below: FloatArray, diagonal: FloatArray, above: FloatArray, right: FloatArray
) -> FloatArray:
    """Solve a tridiagonal system without pivots, which the spline's does not need.

    Row i is below_i s_i−1 + diagonal_i s_i + above_i s_i+1 = right_i.
    """
    rows = zip(*(each.tolist() for each in (below, diagonal, above, right)), strict=True)
    _, pivot, beyond, value = next(rows)
    pivots, aboves, values = [pivot], [beyond], [value]
    for low, middle, high, wanted in rows:
        factor = low / pivot
        pivot, value = middle - factor * beyond, wanted - factor * value
        beyond = high
        pivots.append(pivot)
        aboves.append(high)
        values.append(value)
    found = [0.0]
    for pivot, beyond, value in zip(*map(reversed, (pivots, aboves, values)), strict=True):
        found.append((value - beyond * found[-1]) / pivot)
    return np.array(found[:0:-1])
