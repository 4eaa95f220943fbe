"""The exact steps of a harmonic well in compiled code."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from tauto_core.motion.compiled import compiled, entry
from tauto_core.samples import FloatArray, IntArray

OK, EDGE = 0, 1

Y, LOST, ANGLE, RATE, FLOATS = 0, 2, 4, 5, 6
TURNS, BEATS, SIGN, INTS = 0, 1, 2, 3

BEYOND_PROBES = 1.5
"""The line's tilt within a span is at most so many times the largest at its probes: what was
sampled finely enough to be interpolated rises no higher between samples."""

NEARLY = 1.0 - 1e-12


class Shapes(NamedTuple):
    """What spans of some shapes (length of the piece, begin, end) have in common.

    Rows, or columns, of w numbers take the coefficients of α_c to a number; w = 0 on a platform at
    rest. n is how many shapes there are, m the most parts one is divided into.

    Attributes:
        parts: how many parts each has, (n,).
        whole: columns to the real and imaginary part of b over the span, then to α_c and α̇_c/ω₀
            here and there in it, the end the last, (n, w, 2 + 2p).
        part: rows to the two parts of b over each part, (n, m, 2, w).
        end: to α_c and α̇_c at the end of each part, (n, m, 2, w).
        time: length of the span [s], (n,).
    """

    parts: IntArray
    whole: FloatArray
    part: FloatArray
    end: FloatArray
    time: FloatArray


@compiled
def _applied(row: Any, coefficients: Any, k: int) -> float:
    """Return row · coefficients of piece k, four sums side by side for speed."""
    a = b = c = d = 0.0
    width = len(row)
    whole = width - width % 4
    for j in range(0, whole, 4):
        a += row[j] * coefficients[k, j]
        b += row[j + 1] * coefficients[k, j + 1]
        c += row[j + 2] * coefficients[k, j + 2]
        d += row[j + 3] * coefficients[k, j + 3]
    for j in range(whole, width):
        a += row[j] * coefficients[k, j]
    return (a + b) + (c + d)


@compiled
def _add(c: float, s: float, re: float, im: float, decay: float, floats: Any) -> None:
    """Set Y to e^{−δh} (Y + e^{−iωt} b), the addition compensated (Kahan)."""
    add_re, add_im = c * re + s * im - floats[LOST], c * im - s * re - floats[LOST + 1]
    new_re, new_im = floats[Y] + add_re, floats[Y + 1] + add_im
    floats[LOST] = (new_re - floats[Y]) - add_re
    floats[LOST + 1] = (new_im - floats[Y + 1]) - add_im
    floats[Y], floats[Y + 1] = decay * new_re, decay * new_im


@compiled
def _pair(rows: Any, shape: int, j: int, neutral: Any, k: int) -> tuple[float, float]:
    """Return what two rows of a table make of the coefficients; zeros on a platform at rest."""
    if neutral is None:
        return 0.0, 0.0
    return _applied(rows[shape, j, 0], neutral, k), _applied(rows[shape, j, 1], neutral, k)


@compiled
def _place(c: float, s: float, rates: Any, line: tuple[float, float], floats: Any) -> None:
    """Set θ and θ̇ from Y at an instant whose frame is c, s, and the line's tilt and rate."""
    omega, delta, _ = rates
    psi = (c * floats[Y + 1] + s * floats[Y]) / omega
    floats[ANGLE] = psi - line[0]
    floats[RATE] = c * floats[Y] - s * floats[Y + 1] - delta * psi - line[1]


@compiled
def _cross(angle: float, rate: float, floats: Any, ints: Any) -> None:
    """Count what a short step from (angle, rate) has passed: turns of (θ, −θ̇), zeros of θ."""
    x0, y0, x1, y1 = angle, 0.0 - rate, floats[ANGLE], 0.0 - floats[RATE]
    if (y0 < 0.0) != (y1 < 0.0) and x0 + (x1 - x0) * (y0 / (y0 - y1)) < 0.0:
        ints[TURNS] += 1 if y1 < 0.0 else -1
    if x1 != 0.0:
        sign = 1 if x1 > 0.0 else -1
        if ints[SIGN] == -sign:
            ints[BEATS] += 1
        ints[SIGN] = sign


@compiled
def _wind(turned: float, before: float, omega0: float, floats: Any, ints: Any) -> None:
    """Count what a span has passed in which the swing outweighs the roll.

    (θ, −θ̇/ω₀) has turned by `turned` but for less than half a turn, from the angle `before`. It
    passes θ = 0 one way only, since θ' is θ̇.
    """
    after = math.atan2(0.0 - floats[RATE] / omega0, floats[ANGLE])
    turns = round((turned - (after - before)) / math.tau)
    ints[TURNS] += int(turns)
    after += math.tau * turns
    ints[BEATS] += int(math.floor(after / math.pi - 0.5) - math.floor(before / math.pi - 0.5))
    ints[SIGN] = 1 if floats[ANGLE] > 0.0 else -1


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
def _overview(shape: int, k: int, shapes: Any, neutral: Any, seen: Any) -> None:
    """Fill `seen` with what the columns of `whole` make of the coefficients, side by side."""
    seen[:] = 0.0
    if neutral is None:
        return
    for j in range(shapes.whole.shape[1]):
        coefficient = neutral[k, j]
        for i in range(len(seen)):
            seen[i] += shapes.whole[shape, j, i] * coefficient


@compiled
def _calm(rates: Any, edge: float, seen: Any, floats: Any) -> bool:
    """Return whether over a span the swing outweighs roll and forcing, and no edge is near.

    Then (θ, −θ̇/ω₀) keeps within 45° of the swing, and forcing turns the swing by less than 30°.
    """
    omega, delta, omega0 = rates
    size = math.hypot(floats[Y], floats[Y + 1]) / omega
    if delta > 0.1 * omega0 or not math.hypot(seen[0], seen[1]) < 0.5 * omega * size:
        return False
    reach = 0.0
    for p in range(2, len(seen), 2):
        reach = max(reach, seen[p] * seen[p] + seen[p + 1] * seen[p + 1])
    reach = BEYOND_PROBES * math.sqrt(reach)
    return reach <= 0.7 * size and 1.5 * size + reach < edge


@compiled
def _in_parts(
    shape: int, k: int, rates: Any, edge: float, shapes: Any, frame: Any, neutral: Any, state: Any
) -> float:
    """Advance over a span part by part; return the fraction at which the edge is passed, or 2."""
    floats, ints = state
    omega, delta, omega0 = rates
    parts = shapes.parts[shape]
    step = shapes.time[shape] / parts
    decay = math.exp(-delta * step)
    c, s = frame[k, 0], frame[k, 1]
    for j in range(parts):
        re, im = _pair(shapes.part, shape, j, neutral, k)
        _add(c, s, re, im, decay, floats)
        if j + 1 < parts:
            turned = omega * (j + 1) * step
            cosine, sine = math.cos(turned), math.sin(turned)
            c = frame[k, 0] * cosine - frame[k, 1] * sine
            s = frame[k, 1] * cosine + frame[k, 0] * sine
        else:
            c, s = frame[k + 1, 0], frame[k + 1, 1]
        angle, rate = floats[ANGLE], floats[RATE]
        _place(c, s, rates, _pair(shapes.end, shape, j, neutral, k), floats)
        if math.hypot(floats[ANGLE], floats[RATE] / omega0) > edge * NEARLY:
            at = _first_beyond(angle, rate, floats[ANGLE], floats[RATE], step, edge)
            if at <= 1.0:
                return (j + at) / parts
        _cross(angle, rate, floats, ints)
    return 2.0


@entry
def turn_and_add(
    rates: Any,
    edge: float,
    shape: Any,
    shapes: Any,
    frame: Any,
    neutral: Any,
    logged: Any,
    floats: Any,
    ints: Any,
    seen: Any,
    rows: Any,
) -> tuple[int, int, float]:
    """Advance Y_{n+1} = e^{−δh} (Y_n + e^{−iωt_n} b_n) over all spans; fill a row for each logged.

    Where the swing outweighs roll and forcing, a span is one step, however long, and what it has
    passed is known from how far it turns. Elsewhere it is taken in parts.

    Args:
        rates: ω, δ, ω₀.
        edge: of the cam [rad], or infinity.
        shape: of each span, (n,).
        shapes: `Shapes`.
        frame: cos ωt, sin ωt at the beginnings of the spans and at the end, (n + 1, 2).
        neutral: coefficients of α_c, (n, w), or None.
        logged: whether a span's end is logged, (n,).
        floats, ints: the state.
        seen: memory for a column of `whole` each.
        rows: output: θ, θ̇, turns, beats.

    Returns a code (OK, EDGE), the span and the fraction of it.
    """
    omega, delta, omega0 = rates
    written = 0
    for k in range(len(shape)):
        n = shape[k]
        _overview(n, k, shapes, neutral, seen)
        if _calm(rates, edge, seen, floats):
            before = math.atan2(0.0 - floats[RATE] / omega0, floats[ANGLE])
            time = shapes.time[n]
            _add(frame[k, 0], frame[k, 1], seen[0], seen[1], math.exp(-delta * time), floats)
            line = seen[-2], omega0 * seen[-1]
            _place(frame[k + 1, 0], frame[k + 1, 1], rates, line, floats)
            _wind(omega * time, before, omega0, floats, ints)
        else:
            at = _in_parts(n, k, rates, edge, shapes, frame, neutral, (floats, ints))
            if at <= 1.0:
                return EDGE, k, at
        if logged[k]:
            row = rows[written]
            row[0], row[1] = floats[ANGLE], floats[RATE]
            row[2], row[3] = ints[TURNS], ints[BEATS]
            written += 1
    return OK, 0, 0.0
