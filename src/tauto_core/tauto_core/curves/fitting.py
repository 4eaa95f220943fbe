"""An analytic lever arm as polynomials to rounding, the form that kernels evaluate.

Chebyshev interpolation on pieces, each as long as one degree can represent to rounding. Towards a
singularity just beyond the range the pieces shorten in proportion to its distance. The first piece
is a polynomial in ϑ², so that t keeps its relative accuracy down to rest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np
from numpy.polynomial import chebyshev

from tauto_core.curves.levers import SmoothLever
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import TautoError

Law: TypeAlias = Callable[[FloatArray], FloatArray]

TERMS = 12
"""Terms of the first piece, in ϑ²; the others have twice as many, in ϑ."""

RESOLVED = 4e-16
"""Largest size of the last coefficients over the first."""

SHORTEST = 2.0**-48
_EPSILON = 2.0**-52
_CHECKED = (np.arange(32) + 0.5) / 32


class FitError(TautoError):
    """A lever arm that no polynomials represent, since it is not smooth."""


def smooth_lever(arm: Law, lift: Law, edge: float) -> SmoothLever:
    """Return an odd analytic lever arm t(ϑ), h = ∫ t dϑ on 0 ≤ ϑ ≤ edge, as polynomials.

    Args:
        arm: function that gives t of angles [m], to rounding.
        lift: function that gives h of angles [m], to rounding.
        edge: the range [rad], > 0 and finite.

    Raises:
        FitError: pieces of 2⁻⁴⁸ of the range do not resolve the lever arm.
    """
    first, even = _middle(arm, edge)
    knots, rows = [0.0, first], [_odd(even, first)]
    for right, row in _pieces(arm, first, edge):
        knots.append(right)
        rows.append(row)
    powers = np.arange(TERMS)
    middle = np.array([even, even * (2 * powers + 1), even / (2 * powers + 2)])
    starts = np.array(knots)
    lifts = np.concatenate([[0.0], lift(starts[1:-1])])
    return SmoothLever(starts, np.array(rows), lifts, middle)


def _middle(arm: Law, edge: float) -> tuple[float, FloatArray]:
    """Return the first knot and the coefficients of t/ϑ in u = (ϑ/knot)² up to it."""
    width = edge
    while width > SHORTEST * edge:
        knot = width

        def ratio(u: FloatArray, knot: float = knot) -> FloatArray:
            angle = knot * np.sqrt(u)
            return arm(angle) / angle

        found = _interpolated(ratio, TERMS)
        if found is not None:
            return knot, found
        width *= 0.8
    raise _rough(0.0)


def _pieces(arm: Law, first: float, edge: float) -> Iterator[tuple[float, FloatArray]]:
    """Yield right end and coefficients in ϑ − left end of the pieces beyond the first."""
    left, width = first, first
    while left < edge:
        width = min(1.5 * width, edge - left)
        while True:
            # the last piece ends exactly at the edge
            right = edge if width >= (1.0 - 1e-9) * (edge - left) else left + width
            span = right - left

            def piece(x: FloatArray, left: float = left, span: float = span) -> FloatArray:
                return arm(np.minimum(left + span * x, edge))

            found = _interpolated(piece, 2 * TERMS, 4.0 * _EPSILON * right / span)
            if found is not None:
                break
            width *= 0.8
            if width < SHORTEST * edge:
                raise _rough(left)
        yield right, found / span ** np.arange(2 * TERMS)
        left = right


def _odd(even: FloatArray, knot: float) -> FloatArray:
    """Return the coefficients of ϑ^j of ϑ Σ even_j (ϑ/knot)^2j."""
    row = np.zeros(2 * TERMS)
    row[1::2] = even / knot ** (2 * np.arange(TERMS))
    return row


def _interpolated(function: Law, terms: int, blur: float = 0.0) -> FloatArray | None:
    """Return the coefficients of x^j of a function on 0 ≤ x ≤ 1; None if they do not resolve it.

    Args:
        function: the function, accurate to rounding of its value, and of x by the blur.
        terms: number of terms.
        blur: rounding of x, which shows where the function is steep.
    """
    nodes = 0.5 * (chebyshev.chebpts1(terms) + 1.0)
    values = function(nodes)
    series = chebyshev.chebfit(2.0 * nodes - 1.0, values, terms - 1)
    noise = blur * float(np.ptp(values))
    if not np.max(np.abs(series[-2:])) <= RESOLVED * np.max(np.abs(series)) + noise:
        return None
    row = _monomials(np.asarray(series, np.float64))
    wanted = function(_CHECKED)
    wrong = np.abs(np.polynomial.polynomial.polyval(_CHECKED, row) - wanted)
    return row if np.all(wrong <= 8.0 * (RESOLVED * np.abs(wanted) + noise)) else None


def _monomials(series: FloatArray) -> FloatArray:
    """Return the coefficients of x^j of Σ series_k T_k(2x − 1), by Clenshaw's recurrence.

    `Chebyshev.convert` does the same with one object for each coefficient, at twenty times the
    cost.
    """
    last, before = np.zeros((2, len(series)))
    for coefficient in series[:0:-1]:
        last, before = _plus_shifted(coefficient, -before, 2.0 * last), last
    return _plus_shifted(series[0], -before, last)


def _plus_shifted(constant: float, row: FloatArray, other: FloatArray) -> FloatArray:
    """Return the coefficients of a constant + Σ row_j x^j + (2x − 1) Σ other_j x^j."""
    shifted = -other
    shifted[1:] += 2.0 * other[:-1]
    row[0] += constant
    return row + shifted


def _rough(angle: float) -> FitError:
    return FitError(
        f'the lever arm near {angle!r} rad is not smooth enough for polynomials of degree '
        f'{2 * TERMS - 1}: use a smaller range, or tabulate the cam'
    )
