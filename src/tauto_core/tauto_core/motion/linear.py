"""The exact solution of ż = (iω − δ) z + f: one step for each span, however many swings it takes.

In the rotating frame, Y = e^{−iωt} z, variation of constants makes of a span of length h one sum
and one factor (P.1 in docs/theory/propagators.md):

    Y(t + h) = e^{−δh} (Y(t) + e^{−iωt} b),    b = ∫₀^h e^{(δ − iω)s} f(t + s) ds.

f = a u + c u̇ of a polynomial u over the span, so that b is the product of constant rows with the
numbers that determine u (`responses`). ωt is reduced exactly from the whole nanoseconds of t, so
that only the rounding of the sums grows with the number of spans, and that sum is compensated.

The wheel in a linear well (`forced_harmonic`) and both modes of a suspended case (`axle_modes`)
obey this equation.
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from tauto_core.kernels import compiled, entry, inlined
from tauto_core.motion.exact_turns import cosine_sine, turns_at
from tauto_core.motion.forcing import Polynomials
from tauto_core.motion.lanes import fma, load, splat, store
from tauto_core.motion.phase import DIGITS, PI
from tauto_core.motion.responses import B_IM, B_RE, Responses
from tauto_core.samples import FloatArray, IntArray

FOUR = 0, 1, 2, 3
STATE = [('re', 'f8'), ('im', 'f8'), ('lost_re', 'f8'), ('lost_im', 'f8')]


class Swing(Protocol):
    """The running state in kernels, a record of `STATE`: Y, and what its last sum rounded off."""

    re: float
    im: float
    lost_re: float
    lost_im: float


class Oscillator(NamedTuple):
    """The homogeneous equation.

    Attributes:
        omega: ω [rad/s].
        delta: δ [1/s], ≥ 0.
        turns_per_ns: ω/2π [turns/ns], the first 64 binary digits of the fraction.
        turns_per_ns_low: the next 64.
    """

    omega: float
    delta: float
    turns_per_ns: np.uint64
    turns_per_ns_low: np.uint64


class Spans(NamedTuple):
    """n spans one after the other.

    Attributes:
        begin_ns: time at which the first begins [ns].
        end_ns: times at which they end [ns], (n,).
        shape: index of each one's shape in `responses`, (n,).
        responses: what all spans of a shape have in common.
        u: the polynomials; None if u = 0.
    """

    begin_ns: int
    end_ns: IntArray
    shape: IntArray
    responses: Responses
    u: Polynomials | None


class Path(NamedTuple):
    """The motion over n spans.

    Attributes:
        y: real and imaginary part of Y at the beginning and at the end of each span, (2, n + 1).
        frame: cos ωt and sin ωt there, (2, n + 1).
        span: of each span b, and u, u̇, ü at its end, in the columns of `responses`, (n, 8).
    """

    y: FloatArray
    frame: FloatArray
    span: FloatArray

    def z(self, which: IntArray | slice) -> tuple[FloatArray, FloatArray]:
        """Return the real and imaginary part of z at the ends of some spans."""
        (re, im), (c, s) = self.y[:, 1:][:, which], self.frame[:, 1:][:, which]
        return c * re - s * im, c * im + s * re


def oscillator(exact_omega: Decimal, delta: float = 0.0) -> Oscillator:
    """Return the oscillator of ω in `DIGITS` decimal digits [rad/s] and δ [1/s]."""
    with localcontext() as context:
        context.prec = DIGITS
        units = int(exact_omega / (2 * PI * 10**9) * 2**128)
    high, low = np.uint64(units >> 64), np.uint64(units % 2**64)
    return Oscillator(float(exact_omega), delta, high, low)


def propagate(of: Oscillator, spans: Spans, state: NDArray[np.void]) -> Path:
    """Return the motion over spans, and advance the state.

    Args:
        of: the oscillator.
        spans: at least one.
        state: a record with the fields of `STATE`; Y belongs to `spans.begin_ns`.
    """
    n = len(spans.end_ns)
    path = Path(np.empty((2, n + 1)), np.empty((2, n + 1)), np.empty((n, 8)))
    _propagate(of, spans, state, path)
    return path


@entry
def _propagate(of: Oscillator, spans: Spans, state: Swing, path: Path) -> None:
    """Fill in the path: b and the frame of each span by itself, then Y from span to span."""
    _fill_frames(of, spans.begin_ns, spans.end_ns, path.frame)
    k, n = 0, len(spans.end_ns)
    while k < n:
        if k + 4 <= n and _are_alike(spans, k):
            _four_products(spans, k, path.span)
            k += 4
        else:
            store(path.span, k, product(spans, spans.shape[k], k))
            k += 1
    _sum_up(spans, state, path)


@compiled
def _fill_frames(of: Oscillator, begin_ns: int, end_ns: IntArray, frame: FloatArray) -> None:
    """Fill in cos ωt and sin ωt."""
    high, low = of.turns_per_ns, of.turns_per_ns_low
    turns = np.empty(len(end_ns) + 1, np.uint64)
    turns[0] = turns_at(begin_ns, high, low)
    for k in range(len(end_ns)):
        turns[k + 1] = turns_at(end_ns[k], high, low)
    cosine_sine(turns, frame[0], frame[1])


@compiled
def product(spans: Spans, which: int, k: int) -> Any:
    """Return b, u, u̇, ü of span k, or of a part of it, as lanes in the columns of `responses`.

    Args:
        spans: the spans.
        which: index in `Responses.rows` of the shape of the span, or of the part.
        k: index of the span, whose numbers are multiplied.
    """
    if spans.u is None:
        return splat(0.0)
    values, rates, first, fitted = spans.u
    rows, width, begin = spans.responses.rows, spans.responses.rows.shape[1], first[k]
    row, points = which * width, width // 2
    # two sums, of which neither waits for the other
    one, two = splat(0.0), splat(0.0)
    if begin >= 0:
        for i in range(points):
            one = fma(load(rows, row + i), values[begin + i], one)
            two = fma(load(rows, row + points + i), rates[begin + i], two)
    else:
        for j in range(fitted.shape[1]):
            one = fma(load(rows, row + j), fitted[-1 - begin, j], one)
    return one + two


@inlined
def _are_alike(spans: Spans, k: int) -> bool:
    """Return whether four spans from the k-th on have one shape and are determined by samples."""
    if spans.u is None:
        return False
    shape, first = spans.shape, spans.u.first
    same = shape[k] == shape[k + 1] == shape[k + 2] == shape[k + 3]
    return same and min(first[k], first[k + 1], first[k + 2], first[k + 3]) >= 0


@inlined
def _four_products(spans: Spans, k: int, out: FloatArray) -> None:
    """Store the products of four spans of one shape, to the same bits as `product`.

    Each row is read once for all four, and of the eight sums none waits for another: that saves
    6 % of benchmark problem d.
    """
    if spans.u is None:
        return
    values, rates, first, _ = spans.u
    rows, points = spans.responses.rows, spans.responses.rows.shape[1] // 2
    row, zero = 2 * points * spans.shape[k], splat(0.0)
    begins = first[k], first[k + 1], first[k + 2], first[k + 3]
    of_values = of_rates = zero, zero, zero, zero
    for i in range(points):
        by_value, by_rate = load(rows, row + i), load(rows, row + points + i)
        more_values: tuple[Any, ...] = ()
        more_rates: tuple[Any, ...] = ()
        for j in FOUR:
            more_values = (*more_values, fma(by_value, values[begins[j] + i], of_values[j]))
            more_rates = (*more_rates, fma(by_rate, rates[begins[j] + i], of_rates[j]))
        of_values, of_rates = more_values, more_rates
    for j in FOUR:
        store(out, k + j, of_values[j] + of_rates[j])


@compiled
def _sum_up(spans: Spans, state: Swing, path: Path) -> None:
    """Fill in Y; the sum is compensated (W. Kahan, Comm. ACM 8 (1965) 40)."""
    y, frame, decay = path.y, path.frame, spans.responses.decay
    re, im, lost_re, lost_im = state.re, state.im, state.lost_re, state.lost_im
    y[0, 0], y[1, 0] = re, im
    for k in range(len(spans.end_ns)):
        b_re, b_im = path.span[k, B_RE], path.span[k, B_IM]
        add_re, add_im = into_frame(frame[0, k], frame[1, k], b_re, b_im)
        add_re, add_im = add_re - lost_re, add_im - lost_im
        new_re, new_im = re + add_re, im + add_im
        lost_re, lost_im = (new_re - re) - add_re, (new_im - im) - add_im
        re, im = decay[spans.shape[k]] * new_re, decay[spans.shape[k]] * new_im
        y[0, k + 1], y[1, k + 1] = re, im
    state.re, state.im, state.lost_re, state.lost_im = re, im, lost_re, lost_im


@compiled
def into_frame(c: float, s: float, re: float, im: float) -> tuple[float, float]:
    """Return e^{−iωt} b, what b is in the rotating frame, from cos ωt, sin ωt and b."""
    return c * re + s * im, c * im - s * re
