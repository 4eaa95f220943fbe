"""The exact solution of ż = (iω − δ) z + f: one step per span, of any length.

In the rotating frame, Y = e^{−iωt} z, variation of constants turns a span of length h into one sum
and one factor (methods.1):

    Y(t + h) = e^{−δh} (Y(t) + e^{−iωt} b),    b = ∫₀^h e^{(δ − iω)s} f(t + s) ds.

With f = a u + c u̇ and a polynomial u over the span, b is the product of constant rows with the
numbers that determine u (`responses`). ωt is reduced exactly from the whole nanoseconds of t. Only
the rounding of the sums grows with the number of spans, and the sum is compensated.

The wheel in a linear well (`forced_harmonic`) and both modes of a suspended case (`AxleModes`)
obey this equation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal, localcontext
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.curves.numerics import gauss_rule
from tauto_core.kernels import compiled, entry, inlined
from tauto_core.motion.forcing import PHASE_DIGITS, PI, Polynomials
from tauto_core.motion.lanes import SIZE, fma, row_of, splat, store
from tauto_core.samples import FloatArray, IntArray

# -----------------------------------------------------------------------------
# Cosine and sine of angles that are whole numbers of 2⁻⁶⁴ turns.
#
# Whole turns are the overflow of the 64 bits: an angle is as exact after a century as at the
# start. Every angle takes the same operations in the same order, alone or in lanes, hence the bits
# do not depend on the number of lanes.

RADIANS_PER_UNIT = 2.0 * math.pi / 2.0**64
SIGNED_INVERSE_FACTORIALS = tuple((-1) ** (k // 2) / math.factorial(k) for k in range(18))
"""Coefficients of x^k in the Taylor series of cosine, k even, and of sine, k odd."""

HALF_WORD, LOW_HALF = np.uint64(32), np.uint64(2**32 - 1)


@compiled
def turns_at(time_ns: int, high: np.uint64, low: np.uint64) -> np.uint64:
    """Return the angle of a uniform rotation, less than three units too small [2⁻⁶⁴ turns].

    `time_ns` ≥ 0 counts from the angle zero [ns]. `high` and `low` are the first and the next 64
    binary digits of the fraction of the turns per nanosecond.
    """
    time = np.uint64(time_ns)
    a, b, c, d = time >> HALF_WORD, time & LOW_HALF, low >> HALF_WORD, low & LOW_HALF
    # time · high plus, from halves of 32 bits, the upper 64 bits of time · low. Each of the three
    # truncated products, b · d included, may lose a unit
    return time * high + (a * c + (a * d >> HALF_WORD) + (b * c >> HALF_WORD))


@compiled
def cosine_sine(turns: NDArray[np.uint64], cosine: FloatArray, sine: FloatArray) -> None:
    """Fill in cosine and sine of angles [2⁻⁶⁴ turns], reduced exactly to quarters ± an eighth."""
    eighth, bits = np.uint64(2**61), np.uint64(62)
    remainder = np.empty(len(turns))
    for i in range(len(turns)):
        quarters = (turns[i] + eighth) >> bits
        remainder[i] = np.int64(turns[i] - (quarters << bits)) * RADIANS_PER_UNIT
    rows = len(turns) // SIZE
    for i in range(rows):
        c, s = short_cosine_sine(row_of(remainder, i))
        store(cosine, i, c)
        store(sine, i, s)
    for i in range(SIZE * rows, len(turns)):
        cosine[i], sine[i] = short_cosine_sine(remainder[i])
    for i in range(len(turns)):
        quarters = np.int64((turns[i] + eighth) >> bits) & 3
        c, s = cosine[i], sine[i]
        # select numbers instead of branching, since the quarter is unpredictable
        odd = (quarters & 1) != 0
        sign = 1.0 - (quarters & 2)
        cosine[i], sine[i] = sign * (-s if odd else c), sign * (c if odd else s)


@inlined
def short_cosine_sine(x: Any) -> Any:
    """Return cosine and sine of an angle x, or lanes of angles, |x| ≤ π/4 [rad].

    The Taylor series up to x^16 and x^17 are exact to rounding: the next terms are below 3e-18 and
    2e-19. Unlike the library's functions they serve several angles at once.
    """
    f, z = SIGNED_INVERSE_FACTORIALS, x * x
    odd, even = f[17] * z + f[15], f[16] * z + f[14]
    odd, even = odd * z + f[13], even * z + f[12]
    odd, even = odd * z + f[11], even * z + f[10]
    odd, even = odd * z + f[9], even * z + f[8]
    odd, even = odd * z + f[7], even * z + f[6]
    odd, even = odd * z + f[5], even * z + f[4]
    odd, even = odd * z + f[3], even * z + f[2]
    return 1.0 + z * even, x + x * (z * odd)


# -----------------------------------------------------------------------------
# Constant rows for spans of a linear oscillator that a polynomial u drives.
#
# The span's integral b (methods.1) and u, u̇, ü at its end are linear in the numbers that
# determine u: its coefficients, or the samples that it interpolates. One product of a row with
# these numbers gives b, u, u̇ and ü, without fitting a polynomial.

B_RE, B_IM, U, U_RATE, U_BEND = range(5)
"""Columns of a product: real and imaginary part of b, then u, u̇ and ü at the end of the span."""

TURN = 0.35
"""Longest part of a span that is integrated at once, as |iω − δ| times its length [rad].

A Gauss–Legendre rule of 24 points then integrates the exponential to rounding. In these parts
`forced_harmonic` also counts the passages of a wheel that may pass zero twice.
"""

_ROOTS, _WEIGHTS = gauss_rule()


class LinearLaw(NamedTuple):
    """ż = (iω − δ) z + a u + c u̇.

    Attributes:
        omega: ω [rad/s].
        delta: δ [1/s].
        per_value: a, the drive per u.
        per_rate: c, the drive per u̇.
    """

    omega: float
    delta: float
    per_value: float
    per_rate: float


class SpanShape(NamedTuple):
    """The common properties of spans that share rows.

    Attributes:
        length_s: length of the piece of forcing [s].
        begin: beginning of the span in its piece, in x from 0 to 1.
        end: end of the span in its piece.
        sampled: whether samples determine u. Otherwise its coefficients do.
    """

    length_s: float
    begin: float
    end: float
    sampled: bool = False

    @property
    def time_s(self) -> float:
        """Length of the span [s]."""
        return (self.end - self.begin) * self.length_s


class Responses(NamedTuple):
    """The constants that spans of n shapes share.

    w numbers determine u. Row j of a span or part holds the factors of number j in b, u, u̇ and ü,
    in the columns `B_RE` to `U_BEND`, and three zeros up to the width of lanes.

    Attributes:
        rows: rows of the spans, then of all parts, (n + Σ parts, w, 8).
        parts: number of equal parts, at most `TURN` long, of each shape, (n,).
        first_part: index in `rows` of the first part of each shape, (n,).
        time_s: length of the span [s], (n,).
        decay: e^{−δ·time}, (n,).
        per_slope: factor from the rates of samples, or du/dx, to u̇, (n,).
    """

    rows: FloatArray
    parts: IntArray
    first_part: IntArray
    time_s: FloatArray
    decay: FloatArray
    per_slope: FloatArray


def unique_rows(*columns: NDArray[Any]) -> tuple[IntArray, list[tuple[float, ...]]]:
    """Return each row's index among the distinct rows, (n,), and the distinct rows.

    Most rows of a forcing equal the middle one. Only the others are sorted.
    """
    usual = [column[len(column) // 2] for column in columns]
    unlike = np.zeros(len(columns[0]), np.bool_)
    for column, common in zip(columns, usual, strict=True):
        unlike |= column != common
    kind, kinds = np.zeros(len(unlike), np.int64), [tuple(value.item() for value in usual)]
    if unlike.any():
        unlike_rows = np.stack([column[unlike] for column in columns], axis=1)
        distinct, which = np.unique(unlike_rows, axis=0, return_inverse=True)
        kinds += map(tuple, distinct.tolist())
        kind[unlike] = 1 + which.reshape(-1)
    return kind, kinds


def responses(
    law: LinearLaw, shapes: Sequence[SpanShape], nodes: tuple[float, ...], width: int
) -> Responses:
    """Return the constants that spans of some shapes share.

    `nodes` are x of the samples, with rates, that u interpolates. `width` is w, the number of
    numbers that determine u: twice the number of nodes, or of coefficients, and 0 for u = 0.
    """
    row_sets = [_rows(law, shape, nodes if shape.sampled else None, width) for shape in shapes]
    parts = np.array([len(rows) - 1 for rows in row_sets])
    time_s = np.array([shape.time_s for shape in shapes])
    return Responses(
        rows=np.concatenate([rows[:1] for rows in row_sets] + [rows[1:] for rows in row_sets]),
        parts=parts,
        first_part=len(row_sets) + np.cumsum(parts) - parts,
        time_s=time_s,
        decay=np.exp(-law.delta * time_s),
        per_slope=np.array([1.0 if shape.sampled else 1.0 / shape.length_s for shape in shapes]),
    )


@lru_cache(maxsize=1024)
def _rows(
    law: LinearLaw, shape: SpanShape, nodes: tuple[float, ...] | None, width: int
) -> FloatArray:
    """Return the rows of a span, then the rows of its parts, (1 + parts, w, 8).

    Samples at `nodes` determine u, or coefficients without nodes.
    """
    length_s, begin = shape.length_s, shape.begin
    parts = max(math.ceil(math.hypot(law.omega, law.delta) * shape.time_s / TURN), 1)
    rows = np.zeros((1 + parts, width, SIZE))
    if not width:
        return rows
    edges = begin + (shape.end - begin) * np.arange(parts + 1) / parts
    edges[-1] = shape.end
    long = np.diff(edges)[:, None]
    x = edges[:-1, None] + 0.5 * long * (_ROOTS + 1.0)
    pull = law.delta - 1j * law.omega
    weight = 0.5 * _WEIGHTS * long * length_s * np.exp(pull * (x - edges[:-1, None]) * length_s)
    u, slope, _ = _basis(x, length_s, nodes, width)
    b = np.einsum('mi,mij->mj', weight, law.per_value * u + law.per_rate * slope)
    rows[1:, :, B_RE], rows[1:, :, B_IM] = b.real, b.imag
    rows[1:, :, U : U_BEND + 1] = np.moveaxis(_basis(edges[1:], length_s, nodes, width), 0, -1)
    # b of a part counts from the part's beginning, b of the span from the span's
    integral = (np.exp(pull * (edges[:-1] - begin) * length_s)[:, None] * b).sum(axis=0)
    rows[0] = rows[-1]
    rows[0, :, B_RE], rows[0, :, B_IM] = integral.real, integral.imag
    return rows


def _basis(
    x: FloatArray, length_s: float, nodes: tuple[float, ...] | None, width: int
) -> FloatArray:
    """Return the factors of the numbers that determine u in u, u̇ and ü at x, (3, …, width)."""
    if nodes is None:
        # x^j and its first two derivatives in x
        rows = np.zeros((3, *x.shape, width))
        rows[0] = x[..., None] ** np.arange(width)
        for n in (1, 2):
            rows[n, ..., 1:] = np.arange(1, width) * rows[n - 1, ..., :-1]
    else:
        rows = _cardinals(x, np.array(nodes))
        rows[..., len(nodes) :] *= length_s
    per_time = (1.0 / length_s) ** np.arange(3)
    return rows * per_time.reshape(3, *(1,) * (rows.ndim - 1))


def _cardinals(x: FloatArray, nodes: FloatArray) -> FloatArray:
    """Return the basis of Hermite interpolation and its first two derivatives in x.

    For the value at a node z the basis function is (1 − 2 l'(z) (x − z)) l², for the slope (x − z)
    l², with l the Lagrange polynomial that is one at z. Each function is computed as its Taylor
    polynomial of degree 2 about x, which contains the derivatives. The values' functions come
    first, then the slopes', (3, …, 2 · nodes).
    """
    identity = np.eye(len(nodes))
    gaps = nodes[:, None] - nodes + identity
    lagrange = _linear(np.ones((*x.shape, len(nodes))), np.zeros(len(nodes)))
    for j, node in enumerate(nodes):
        # a factor of every polynomial except this node's
        value = (x[..., None] - node) / gaps[:, j]
        value[..., j] = 1.0
        lagrange = _product(lagrange, _linear(value, (1.0 - identity[j]) / gaps[:, j]))
    square = _product(lagrange, lagrange)
    slope = _product(_linear(x[..., None] - nodes, np.ones(len(nodes))), square)
    value = square - 2.0 * ((1.0 - identity) / gaps).sum(axis=1) * slope
    taylor = np.concatenate([value, slope], axis=-1)
    taylor[2] *= 2.0
    return taylor


def _linear(value: FloatArray, slope: FloatArray) -> FloatArray:
    """Return the Taylor polynomials of linear functions, (3, …)."""
    return np.stack([value, np.broadcast_to(slope, value.shape), np.zeros_like(value)])


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the product of two Taylor polynomials of degree 2."""
    return np.stack(
        [a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[0] * b[2] + a[1] * b[1] + a[2] * b[0]]
    )


FOUR = 0, 1, 2, 3
STATE = [('re', 'f8'), ('im', 'f8'), ('lost_re', 'f8'), ('lost_im', 'f8')]
"""The running state in kernels: Y, and the rounding of its last sum."""


class Oscillator(NamedTuple):
    """The homogeneous equation.

    Attributes:
        omega: ω [rad/s].
        delta: δ [1/s], ≥ 0.
        turns_per_ns: ω/2π [turns/ns], the first 64 binary digits of the fraction.
        turns_per_ns_low: the next 64 digits.
    """

    omega: float
    delta: float
    turns_per_ns: np.uint64
    turns_per_ns_low: np.uint64


class DrivenSpans(NamedTuple):
    """n consecutive spans.

    Attributes:
        begin_ns: beginning of the first span [ns].
        end_ns: ends of the spans [ns], (n,).
        shape: index of each span's shape in `responses`, (n,).
        responses: the rows that all spans of a shape share.
        u: the polynomials, or `None` if u = 0.
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
        frame: cos ωt and sin ωt at these times, (2, n + 1).
        span: b of each span, and u, u̇, ü at its end, in the columns of `responses`, (n, 8).
    """

    y: FloatArray
    frame: FloatArray
    span: FloatArray

    def z(self, which: IntArray | slice) -> tuple[FloatArray, FloatArray]:
        """Return the real and imaginary part of z at the ends of some spans."""
        (re, im), (c, s) = self.y[:, 1:][:, which], self.frame[:, 1:][:, which]
        return c * re - s * im, c * im + s * re


def oscillator(exact_omega: Decimal, delta: float = 0.0) -> Oscillator:
    """Return the oscillator of ω in `PHASE_DIGITS` decimal digits [rad/s] and δ [1/s]."""
    with localcontext() as context:
        context.prec = PHASE_DIGITS
        units = int(exact_omega / (2 * PI * 10**9) * 2**128)
    high, low = np.uint64(units >> 64), np.uint64(units % 2**64)
    return Oscillator(float(exact_omega), delta, high, low)


def propagate(of: Oscillator, spans: DrivenSpans, state: NDArray[np.void]) -> Path:
    """Return the motion over one or more spans, and advance the state.

    The state is a record of `STATE` with Y at `spans.begin_ns`.
    """
    n = len(spans.end_ns)
    path = Path(np.empty((2, n + 1)), np.empty((2, n + 1)), np.empty((n, 8)))
    _propagate(of, spans, state, path)
    return path


@entry
def _propagate(of: Oscillator, spans: DrivenSpans, state: Any, path: Path) -> None:
    """Fill in the path: b and frame of each span separately, then Y from span to span."""
    k, n = 0, len(spans.end_ns)
    turns = np.empty(n + 1, np.uint64)
    turns[0] = turns_at(spans.begin_ns, of.turns_per_ns, of.turns_per_ns_low)
    for i in range(n):
        turns[i + 1] = turns_at(spans.end_ns[i], of.turns_per_ns, of.turns_per_ns_low)
    cosine_sine(turns, path.frame[0], path.frame[1])
    while k < n:
        if k + 4 <= n and _are_alike(spans, k):
            _four_products(spans, k, path.span)
            k += 4
        else:
            store(path.span, k, span_product(spans, spans.shape[k], k))
            k += 1
    _sum_up(spans, state, path)


@compiled
def span_product(spans: DrivenSpans, which: int, k: int) -> Any:
    """Return b, u, u̇, ü of span k, or of a part, as lanes in the columns of `responses`.

    `which` is the row index in `Responses.rows` of the shape of the span, or of the part.
    """
    if spans.u is None:
        return splat(0.0)
    values, rates, sample, fitted = spans.u
    rows, width, begin = spans.responses.rows, spans.responses.rows.shape[1], sample[k]
    row, points = which * width, width // 2
    # two independent sums
    by_values, by_rates = splat(0.0), splat(0.0)
    if begin >= 0:
        for i in range(points):
            by_values = fma(row_of(rows, row + i), values[begin + i], by_values)
            by_rates = fma(row_of(rows, row + points + i), rates[begin + i], by_rates)
    else:
        for j in range(fitted.shape[1]):
            by_values = fma(row_of(rows, row + j), fitted[-1 - begin, j], by_values)
    return by_values + by_rates


@inlined
def _are_alike(spans: DrivenSpans, k: int) -> bool:
    """Return whether samples determine four spans of one shape from the k-th on."""
    if spans.u is None:
        return False
    shape, sample = spans.shape, spans.u.sample
    alike = shape[k] == shape[k + 1] == shape[k + 2] == shape[k + 3]
    return alike and min(sample[k], sample[k + 1], sample[k + 2], sample[k + 3]) >= 0


@inlined
def _four_products(spans: DrivenSpans, k: int, out: FloatArray) -> None:
    """Store the products of four spans of one shape, with the bits of `span_product`.

    Each row is read once for all four, and the eight sums are independent. This saves 6 % of
    benchmark problem d.
    """
    if spans.u is None:
        return
    values, rates, sample, _ = spans.u
    rows, points = spans.responses.rows, spans.responses.rows.shape[1] // 2
    row, zero = 2 * points * spans.shape[k], splat(0.0)
    begins = sample[k], sample[k + 1], sample[k + 2], sample[k + 3]
    of_values = of_rates = zero, zero, zero, zero
    for i in range(points):
        by_value, by_rate = row_of(rows, row + i), row_of(rows, row + points + i)
        more_values: tuple[Any, ...] = ()
        more_rates: tuple[Any, ...] = ()
        for j in FOUR:
            more_values = (*more_values, fma(by_value, values[begins[j] + i], of_values[j]))
            more_rates = (*more_rates, fma(by_rate, rates[begins[j] + i], of_rates[j]))
        of_values, of_rates = more_values, more_rates
    for j in FOUR:
        store(out, k + j, of_values[j] + of_rates[j])


@compiled
def _sum_up(spans: DrivenSpans, state: Any, path: Path) -> None:
    """Fill in Y by compensated summation (W. Kahan, Comm. ACM 8 (1965) 40)."""
    y, frame, decay = path.y, path.frame, spans.responses.decay
    now = state.re, state.im, state.lost_re, state.lost_im
    y[0, 0], y[1, 0] = now[0], now[1]
    for k in range(len(spans.end_ns)):
        b_re, b_im = path.span[k, B_RE], path.span[k, B_IM]
        now = add_up(now, frame[0, k], frame[1, k], b_re, b_im)
        by = decay[spans.shape[k]]
        now = by * now[0], by * now[1], now[2], now[3]
        y[0, k + 1], y[1, k + 1] = now[0], now[1]
    state.re, state.im, state.lost_re, state.lost_im = now


@inlined
def add_up(
    y: tuple[float, float, float, float], c: float, s: float, b_re: float, b_im: float
) -> tuple[float, float, float, float]:
    """Return Y, with the rounding error of its last sum, after a span that begins with c and s."""
    add_re, add_im = into_frame(c, s, b_re, b_im)
    add_re, add_im = add_re - y[2], add_im - y[3]
    re, im = y[0] + add_re, y[1] + add_im
    return re, im, (re - y[0]) - add_re, (im - y[1]) - add_im


@compiled
def into_frame(c: float, s: float, re: float, im: float) -> tuple[float, float]:
    """Return e^{−iωt} b, which is b in the rotating frame, from cos ωt, sin ωt and b."""
    return c * re + s * im, c * im - s * re
