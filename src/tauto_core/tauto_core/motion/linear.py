"""The exact solution of ż = (iω − δ) z + f: one step for each span, however many swings it takes.

In the rotating frame, Y = e^{−iωt} z, a span of length h is one addition and one factor:

    Y(t + h) = e^{−δh} (Y(t) + e^{−iωt} b),    b = ∫₀^h e^{(δ − iω)s} f(t + s) ds.

f = p u + q u̇ of a polynomial u over the span, so that b is a constant row times what gives the
polynomial: its coefficients or, where samples lie evenly, the samples themselves, and nothing is
fitted. ωt is reduced exactly from the time: only the rounding of their sum grows with the number
of spans. Source: variation of constants.

The wheel (`forced_harmonic`) and the modes of a suspended case (`axle_modes`) obey it.
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from tauto_core.kernels import compiled, entry, inlined
from tauto_core.motion.exact_turns import cosine_sine, turns_at
from tauto_core.motion.lanes import fma, load, splat, store
from tauto_core.motion.phase import DIGITS, PI
from tauto_core.motion.responses import Responses
from tauto_core.samples import FloatArray, IntArray

STATE = [('re', 'f8'), ('im', 'f8'), ('lost_re', 'f8'), ('lost_im', 'f8')]


class Swing(Protocol):
    """The running state in kernels, a record: Y, and the rounding error of its sum (Kahan)."""

    re: float
    im: float
    lost_re: float
    lost_im: float


class Oscillator(NamedTuple):
    """The homogeneous equation.

    Attributes:
        omega: ω [rad/s].
        delta: δ [1/s], ≥ 0.
        turns: ω in turns a nanosecond: its first 64 binary digits.
        fine: the next 64.
    """

    omega: float
    delta: float
    turns: np.uint64
    fine: np.uint64


class Given(NamedTuple):
    """The numbers that determine the polynomial u over n spans.

    Attributes:
        values: u at samples that lie evenly in regular windows, (m,).
        rates: u̇ at the same [1/s], (m,).
        first: place in these at which a span's window begins, ≥ 0; −1 less the row of `fitted`
            where it has no regular window, (n,).
        fitted: coefficients of x^j, (k, w′), w′ ≤ w.
    """

    values: FloatArray
    rates: FloatArray
    first: IntArray
    fitted: FloatArray


class Spans(NamedTuple):
    """n spans one after the other.

    Attributes:
        begin_ns: time at which the first begins [ns].
        end_ns: times at which they end [ns], (n,).
        shape: which of the shapes of `responses` each has, (n,).
        responses: what all spans of a shape have in common.
        given: the numbers that determine u; None if u = 0.
    """

    begin_ns: int
    end_ns: IntArray
    shape: IntArray
    responses: Responses
    given: Given | None


class Path(NamedTuple):
    """The motion over n spans.

    Attributes:
        y: real and imaginary part of Y at the beginning and at the end of each span, (2, n + 1).
        frame: cos ωt and sin ωt there, (2, n + 1).
        span: for each span the real and imaginary part of b, then u, u̇, ü at its end, (n, 8).
    """

    y: FloatArray
    frame: FloatArray
    span: FloatArray

    def z(self, which: IntArray | slice) -> tuple[FloatArray, FloatArray]:
        """Return the real and imaginary part of z at the ends of some spans."""
        (re, im), (c, s) = self.y[:, 1:][:, which], self.frame[:, 1:][:, which]
        return c * re - s * im, c * im + s * re


def oscillator(exact_omega: Decimal, delta: float = 0.0) -> Oscillator:
    """Return the oscillator of an ω in many digits [rad/s] and δ [1/s]."""
    with localcontext() as context:
        context.prec = DIGITS
        units = int(exact_omega / (2 * PI * 10**9) * 2**128)
    turns, fine = np.uint64(units >> 64), np.uint64(units % 2**64)
    return Oscillator(float(exact_omega), delta, turns, fine)


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
    """Fill in the path: b and frame of each span by itself, then their sum over the spans."""
    _fill_frames(of, spans.begin_ns, spans.end_ns, path.frame)
    k, n = 0, len(spans.end_ns)
    while k < n:
        if k + 4 <= n and _are_alike(spans, k):
            _apply_four(spans, k, path.span)
            k += 4
        else:
            store(path.span, k, applied(spans, spans.shape[k], k))
            k += 1
    _add(spans, state, path)


@compiled
def _fill_frames(of: Oscillator, begin_ns: int, end_ns: IntArray, frame: FloatArray) -> None:
    turns = np.empty(len(end_ns) + 1, np.uint64)
    turns[0] = turns_at(begin_ns, of.turns, of.fine)
    for k in range(len(end_ns)):
        turns[k + 1] = turns_at(end_ns[k], of.turns, of.fine)
    cosine_sine(turns, frame[0], frame[1])


@compiled
def applied(spans: Spans, place: int, k: int) -> Any:
    """Return the product of a shape's or a part's rows with span k, as lanes; see `Path.span`."""
    if spans.given is None:
        return splat(0.0)
    values, rates, first, fitted = spans.given
    rows, width, begin = spans.responses.rows, spans.responses.rows.shape[1], first[k]
    row, points = place * width, width // 2
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
    """Return whether four spans from the k-th on have one shape and samples in regular windows."""
    if spans.given is None:
        return False
    shape, first = spans.shape, spans.given.first
    same = shape[k] == shape[k + 1] == shape[k + 2] == shape[k + 3]
    return same and min(first[k], first[k + 1], first[k + 2], first[k + 3]) >= 0


@inlined
def _apply_four(spans: Spans, k: int, out: FloatArray) -> None:
    """Do for four spans what `applied` does: a row is read once, and no sum waits for another."""
    if spans.given is None:
        return
    values, rates, first, _ = spans.given
    rows, points = spans.responses.rows, spans.responses.rows.shape[1] // 2
    row, a, b, c, d = (
        2 * points * spans.shape[k],
        first[k],
        first[k + 1],
        first[k + 2],
        first[k + 3],
    )
    a1, b1, c1, d1 = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    a2, b2, c2, d2 = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for i in range(points):
        one, two = load(rows, row + i), load(rows, row + points + i)
        a1, a2 = fma(one, values[a + i], a1), fma(two, rates[a + i], a2)
        b1, b2 = fma(one, values[b + i], b1), fma(two, rates[b + i], b2)
        c1, c2 = fma(one, values[c + i], c1), fma(two, rates[c + i], c2)
        d1, d2 = fma(one, values[d + i], d1), fma(two, rates[d + i], d2)
    store(out, k, a1 + a2)
    store(out, k + 1, b1 + b2)
    store(out, k + 2, c1 + c2)
    store(out, k + 3, d1 + d2)


@compiled
def _add(spans: Spans, state: Swing, path: Path) -> None:
    """Fill in Y; the sum is compensated (Kahan)."""
    y, frame, decay = path.y, path.frame, spans.responses.decay
    re, im, lost_re, lost_im = state.re, state.im, state.lost_re, state.lost_im
    y[0, 0], y[1, 0] = re, im
    for k in range(len(spans.end_ns)):
        add_re, add_im = turned_back(frame[0, k], frame[1, k], path.span[k, 0], path.span[k, 1])
        add_re, add_im = add_re - lost_re, add_im - lost_im
        new_re, new_im = re + add_re, im + add_im
        lost_re, lost_im = (new_re - re) - add_re, (new_im - im) - add_im
        re, im = decay[spans.shape[k]] * new_re, decay[spans.shape[k]] * new_im
        y[0, k + 1], y[1, k + 1] = re, im
    state.re, state.im, state.lost_re, state.lost_im = re, im, lost_re, lost_im


@compiled
def turned_back(c: float, s: float, re: float, im: float) -> tuple[float, float]:
    """Return e^{−iωt} b from cos ωt, sin ωt and b."""
    return c * re + s * im, c * im - s * re
