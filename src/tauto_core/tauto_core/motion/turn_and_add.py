"""The exact steps of a harmonic well in compiled code."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from tauto_core.kernels import compiled, entry
from tauto_core.motion.lanes import fma, lane, load, splat
from tauto_core.motion.rotation import COSINE, SINE
from tauto_core.samples import FloatArray, IntArray

Given: TypeAlias = tuple[FloatArray, FloatArray, IntArray, FloatArray]
"""What makes α_c over spans: values and rates of samples, where in them each span's window begins,
and coefficients of x^j, to whose row r a beginning of −1 − r points instead."""

OK, EDGE = 0, 1

Y, LOST, ANGLE, RATE, FLOATS = 0, 2, 4, 5, 6
TURNS, BEATS, INTS = 0, 1, 2

BEYOND_SAMPLES = 1.5
"""The line's tilt within a span is at most so many times the largest at its window's samples:
what was sampled finely enough to be interpolated rises no higher between them."""

NEARLY = 1.0 - 1e-12

PER_HALF_TURN = 1.0 / math.pi
RADIANS_PER_UNIT = 2.0 * math.pi / 2.0**64
HALVINGS = 40
HALF = np.uint64(32)
LOW_HALF = np.uint64(2**32 - 1)
EIGHTH, TOP = np.uint64(2**61), np.uint64(62)
ZERO, ONE, TWO = np.uint64(0), np.uint64(1), np.uint64(2)


class Shapes(NamedTuple):
    """What spans of some shapes (length of the piece, begin, end, basis) have in common.

    n is how many shapes there are. Rows of w numbers take what makes α_c over a span, see `Given`,
    to one number; w = 0 on a platform at rest. Rows of parts lie one shape behind the other.

    Attributes:
        per_slope: what takes the rates of samples, or dα_c/dx of coefficients, to α̇_c/ω₀, (n,).
        time: length of the span [s], (n,).
        half_turns: ω·time/π, (n,).
        decay: e^{−δ·time}, (n,).
        whole: columns to the real and imaginary part of b over the span and to α_c and α̇_c at
            its end, side by side in rows of lanes, (n, w, 8).
        parts: how many parts each has, (n,).
        first: where its parts begin, (n,).
        part: rows to the two parts of b over each part, (m, 2, w).
        end: to α_c and α̇_c at the end of each part, (m, 2, w).
    """

    per_slope: FloatArray
    time: FloatArray
    half_turns: FloatArray
    decay: FloatArray
    whole: FloatArray
    parts: IntArray
    first: IntArray
    part: FloatArray
    end: FloatArray


@compiled
def _frame(time_ns: int, turning: Any) -> tuple[float, float]:
    """Return cos ωt and sin ωt; t·ω is reduced in 2⁻⁶⁴ turns, as exactly as these tell.

    Of what is left, at most half a right angle, Taylor's series to x^17 and x^18 are exact to
    rounding.
    """
    t, (high, low) = np.uint64(time_ns), turning
    a, b, c, d = t >> HALF, t & LOW_HALF, low >> HALF, low & LOW_HALF
    # the upper half of t·low, what the finer digits of ω carry over, two units off at most
    upper = a * c + (a * d >> HALF) + (b * c >> HALF)
    units = t * high + upper
    quarters = (units + EIGHTH) >> TOP
    angle = np.int64(units - (quarters << TOP)) * RADIANS_PER_UNIT
    square = angle * angle
    sine, short = SINE[8], COSINE[8]
    for n in range(7, 0, -1):
        sine, short = fma(sine, square, SINE[n]), fma(short, square, COSINE[n])
    # the series' first terms last, so that only they round
    sine = fma(angle * square, sine, angle)
    cosine = 1.0 - square * fma(short, square, COSINE[0])
    odd = quarters & ONE != ZERO
    across, along = (cosine, -sine) if odd else (sine, cosine)
    back = quarters & TWO != ZERO
    return (-along, -across) if back else (along, across)


@compiled
def _applied(row: Any, given: Any, k: int) -> float:
    """Return row · given of span k, four sums side by side for speed."""
    a = b = c = d = 0.0
    width = len(row)
    whole = width - width % 4
    for j in range(0, whole, 4):
        a += row[j] * given[k, j]
        b += row[j + 1] * given[k, j + 1]
        c += row[j + 2] * given[k, j + 2]
        d += row[j + 3] * given[k, j + 3]
    for j in range(whole, width):
        a += row[j] * given[k, j]
    return (a + b) + (c + d)


@compiled
def _pair(rows: Any, place: int, given: Any, k: int) -> tuple[float, float]:
    """Return what two rows of a table make of what is given; zeros on a platform at rest."""
    if given is None:
        return 0.0, 0.0
    return _applied(rows[place, 0], given, k), _applied(rows[place, 1], given, k)


@compiled
def _overall(shapes: Any, n: int, given: Any, k: int) -> tuple[float, float, float, float]:
    """Return b over the whole of span k, and the line's tilt and rate at its end."""
    if given is None:
        return 0.0, 0.0, 0.0, 0.0
    values, rates, first, fitted = given
    whole, width, begin = shapes.whole, shapes.whole.shape[1], first[k]
    place, points = n * width, width // 2
    one, two = splat(0.0), splat(0.0)
    if begin >= 0:
        for i in range(points):
            one = fma(load(whole, place + i), values[begin + i], one)
            two = fma(load(whole, place + points + i), rates[begin + i], two)
    else:
        for j in range(width):
            one = fma(load(whole, place + j), fitted[-1 - begin, j], one)
    both = one + two
    return lane(both, 0), lane(both, 1), lane(both, 2), lane(both, 3)


@compiled
def _gather(given: Any, k: int, row: Any) -> Any:
    """Return what makes α_c over span k as one row, (1, w); None on a platform at rest."""
    if given is None:
        return None
    values, rates, first, fitted = given
    begin, points = first[k], row.shape[1] // 2
    for j in range(row.shape[1]):
        if begin < 0:
            row[0, j] = fitted[-1 - begin, j]
        elif j < points:
            row[0, j] = values[begin + j]
        else:
            row[0, j] = rates[begin + j - points]
    return row


@compiled
def _add(c: float, s: float, re: float, im: float, decay: float, floats: Any) -> None:
    """Set Y to e^{−δh} (Y + e^{−iωt} b), the addition compensated (Kahan)."""
    add_re, add_im = c * re + s * im - floats[LOST], c * im - s * re - floats[LOST + 1]
    new_re, new_im = floats[Y] + add_re, floats[Y + 1] + add_im
    floats[LOST] = (new_re - floats[Y]) - add_re
    floats[LOST + 1] = (new_im - floats[Y + 1]) - add_im
    floats[Y], floats[Y + 1] = decay * new_re, decay * new_im


@compiled
def _place(c: float, s: float, rates: Any, line: tuple[float, float], floats: Any) -> None:
    """Set θ and θ̇ from Y at an instant whose frame is c, s, and the line's tilt and rate."""
    omega, delta, _ = rates
    psi = (c * floats[Y + 1] + s * floats[Y]) / omega
    floats[ANGLE] = psi - line[0]
    floats[RATE] = c * floats[Y] - s * floats[Y + 1] - delta * psi - line[1]


@compiled
def _swung(rates: Any, s: float, angle: float, rate: float) -> tuple[float, float]:
    """Return θ and θ̇ after a time of free swing in a case that keeps its tilt's rate."""
    omega, delta, omega0 = rates
    cosine, sine, decay = math.cos(omega * s), math.sin(omega * s), math.exp(-delta * s)
    there = angle * cosine + (rate + delta * angle) / omega * sine
    turned = rate * cosine - (delta * rate + omega0 * omega0 * angle) / omega * sine
    return decay * there, decay * turned


@compiled
def _returns(rates: Any, step: float, angle: float, rate: float, floats: Any) -> bool:
    """Return whether θ passes zero and comes back within a short step from (angle, rate).

    It is on the same side at both ends, moves towards zero at the first and away at the second.
    What the case's acceleration adds to the free swing is the cubic that both ends give: over
    TURN it is off by 4e-5 of that acceleration over ω₀², times the square of the waves' frequency
    over that of the swing.
    """
    free, free_rate = _swung(rates, step, angle, rate)
    add, add_rate = floats[ANGLE] - free, (floats[RATE] - free_rate) * step
    square, cube = 3.0 * add - add_rate, add_rate - 2.0 * add
    a, b = 0.0, 1.0
    for _ in range(HALVINGS):
        x = 0.5 * (a + b)
        free, free_rate = _swung(rates, x * step, angle, rate)
        value = free + x * x * (square + x * cube)
        slope = free_rate * step + x * (2.0 * square + 3.0 * x * cube)
        if (value < 0.0) != (angle < 0.0):
            return True
        if (slope < 0.0) != (angle < 0.0):
            a = x
        else:
            b = x
    return False


@compiled
def _cross(rates: Any, step: float, angle: float, rate: float, floats: Any, ints: Any) -> None:
    """Count what θ passes in a short step from (angle, rate): zero upwards, and zero.

    An angle of exactly zero counts as positive; a wheel that rests there leaves it uncounted.
    """
    below, now = angle < 0.0, floats[ANGLE] < 0.0
    if below != now:
        ints[TURNS] += 1 if below else 0
        ints[BEATS] += 0 if angle == 0.0 and rate == 0.0 else 1
        return
    back = (rate < 0.0) != below and (floats[RATE] < 0.0) == below
    if back and _returns(rates, step, angle, rate, floats):
        ints[TURNS] += 1
        ints[BEATS] += 2


@compiled
def _heading(omega0: float, floats: Any) -> float:
    """Return the angle of (θ, −θ̇/ω₀) within a turn, in half turns from −½ on."""
    turned = math.atan2(0.0 - floats[RATE], omega0 * floats[ANGLE]) * PER_HALF_TURN
    return turned + 2.0 if turned < 0.0 and floats[ANGLE] < 0.0 else turned


@compiled
def _wind(turned: float, before: float, after: float, below: bool, floats: Any, ints: Any) -> None:
    """Count what a span has passed in which the swing outweighs the roll; angles in half turns.

    (θ, −θ̇/ω₀) has turned by `turned` but for less than half a turn, from the angle `before` to
    `after`. It passes θ = 0 one way only, since θ' is θ̇.

    Args:
        below: whether θ was below zero at the beginning.
    """
    turns = round(0.5 * (turned - (after - before)))
    ints[TURNS] += turns
    ints[BEATS] += 2 * turns + (1 if floats[ANGLE] < 0.0 else 0) - (1 if below else 0)


@compiled
def _first_beyond(
    a: float, rate: float, angle: float, last_rate: float, step: float, edge: float
) -> float:
    """Return the fraction of a step at which |θ| first exceeds the edge; 2: it does not.

    Between the ends θ is the cubic through both angles and rates, off by less than 1e-3 of the
    swing over the longest part.
    """
    c = rate * step
    b, d = angle - a - c, last_rate * step - c
    square, cube = 3.0 * b - d, d - 2.0 * b
    inside = 0.0
    for i in range(1, 65):
        x = i / 64.0
        if abs(a + x * (c + x * (square + x * cube))) <= edge:
            inside = x
            continue
        beyond = x
        for _ in range(50):
            x = 0.5 * (inside + beyond)
            within = abs(a + x * (c + x * (square + x * cube))) <= edge
            inside, beyond = (x, beyond) if within else (inside, x)
        return beyond
    return 2.0


@compiled
def _reach(n: int, shapes: Any, given: Any, k: int) -> float:
    """Return a bound of the size of (α_c, α̇_c/ω₀) over a span."""
    if given is None:
        return 0.0
    values, rates, first, fitted = given
    per_slope, width, begin = shapes.per_slope[n], shapes.whole.shape[1], first[k]
    if begin < 0:
        value = slope = 0.0
        for j in range(width):
            number = abs(fitted[-1 - begin, j])
            value += number
            slope += j * number
        return math.hypot(value, per_slope * slope)
    largest = 0.0
    for i in range(begin, begin + width // 2):
        value, slope = values[i], per_slope * rates[i]
        largest = max(largest, value * value + slope * slope)
    return BEYOND_SAMPLES * math.sqrt(largest)


@compiled
def _calm(rates: Any, edge: float, b: tuple[float, float], reach: float, floats: Any) -> bool:
    """Return whether over a span the swing outweighs roll and forcing, and no edge is near.

    Then (θ, −θ̇/ω₀) keeps within 45° of the swing, and forcing turns the swing by less than 30°.
    """
    omega, delta, omega0 = rates
    square = floats[Y] * floats[Y] + floats[Y + 1] * floats[Y + 1]
    if delta > 0.1 * omega0 or not b[0] * b[0] + b[1] * b[1] < 0.25 * square:
        return False
    size = math.sqrt(square) / omega
    return reach <= 0.7 * size and 1.5 * size + reach < edge


@compiled
def _in_parts(
    n: int, rates: Any, edge: float, shapes: Any, frames: Any, row: Any, state: Any
) -> float:
    """Advance over a span part by part; return the fraction at which the edge is passed, or 2."""
    floats, ints = state
    omega, delta, omega0 = rates
    begin, end = frames
    parts, first = shapes.parts[n], shapes.first[n]
    step = shapes.time[n] / parts
    decay = math.exp(-delta * step)
    c, s = begin
    for j in range(parts):
        re, im = _pair(shapes.part, first + j, row, 0)
        _add(c, s, re, im, decay, floats)
        if j + 1 < parts:
            turned = omega * (j + 1) * step
            cosine, sine = math.cos(turned), math.sin(turned)
            c, s = begin[0] * cosine - begin[1] * sine, begin[1] * cosine + begin[0] * sine
        else:
            c, s = end
        angle, rate = floats[ANGLE], floats[RATE]
        _place(c, s, rates, _pair(shapes.end, first + j, row, 0), floats)
        if math.hypot(floats[ANGLE], floats[RATE] / omega0) > edge * NEARLY:
            at = _first_beyond(angle, rate, floats[ANGLE], floats[RATE], step, edge)
            if at <= 1.0:
                return (j + at) / parts
        _cross(rates, step, angle, rate, floats, ints)
    return 2.0


@entry
def turn_and_add(
    rates: Any,
    edge: float,
    turning: Any,
    shapes: Any,
    shape: Any,
    begin_ns: int,
    end_ns: Any,
    given: Any,
    window: Any,
    logged: Any,
    floats: Any,
    ints: Any,
    rows: Any,
) -> tuple[int, int, float]:
    """Advance Y_{n+1} = e^{−δh} (Y_n + e^{−iωt_n} b_n) over all spans; fill a row for each logged.

    Where the swing outweighs roll and forcing, a span is one step, however long, and what it has
    passed is known from how far it turns. Elsewhere it is taken in parts.

    Args:
        rates: ω, δ, ω₀.
        edge: of the cam [rad], or infinity.
        turning: ω in turns a nanosecond: its first 64 binary digits, and the next.
        shapes: `Shapes`.
        shape: of each span, (n,).
        begin_ns: time at which the first span begins, from the start of the run [ns].
        end_ns: times at which they end [ns], (n,).
        given: `Given`, or None.
        window: room for what makes α_c over one span, (1, w).
        logged: whether a span's end is logged, (n,).
        floats, ints: the state.
        rows: output: θ, θ̇, turns, beats.

    Returns a code (OK, EDGE), the span and the fraction of it.
    """
    omega0 = rates[2]
    written = 0
    end, before = _frame(begin_ns, turning), _heading(omega0, floats)
    for k in range(len(shape)):
        n = shape[k]
        begin, end = end, _frame(end_ns[k], turning)
        re, im, tilt, rate = _overall(shapes, n, given, k)
        if _calm(rates, edge, (re, im), _reach(n, shapes, given, k), floats):
            below = floats[ANGLE] < 0.0
            _add(begin[0], begin[1], re, im, shapes.decay[n], floats)
            _place(end[0], end[1], rates, (tilt, rate), floats)
            after = _heading(omega0, floats)
            _wind(shapes.half_turns[n], before, after, below, floats, ints)
        else:
            row = _gather(given, k, window)
            at = _in_parts(n, rates, edge, shapes, (begin, end), row, (floats, ints))
            if at <= 1.0:
                return EDGE, k, at
            after = _heading(omega0, floats)
        before = after
        if logged[k]:
            out = rows[written]
            out[0], out[1] = floats[ANGLE], floats[RATE]
            out[2], out[3] = ints[TURNS], ints[BEATS]
            written += 1
    return OK, 0, 0.0
