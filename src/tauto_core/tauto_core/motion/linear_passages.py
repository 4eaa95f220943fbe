"""The passages of a wheel in a linear well: turns (zero, upwards), beats (zero), the cam's edge.

θ = Im z/ω − u, θ̇ = Re z − δ Im z/ω − u̇, with u the roll of the case (theory E2). While the swing
outweighs roll and forcing, (θ, −θ̇/ω₀) keeps within 45° of the swing, and what it passes follows
from how far it has turned, over any number of spans. Elsewhere spans are followed part by part.
An angle of exactly zero counts as positive.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tauto_core.kernels import compiled, entry, inlined
from tauto_core.motion.lanes import SIZE, lane, larger, largest, load, splat
from tauto_core.motion.linear import (
    STATE,
    Given,
    Oscillator,
    Path,
    Spans,
    Swing,
    applied,
    turned_back,
)
from tauto_core.samples import FloatArray, IntArray

WHEEL = [*STATE, ('angle', 'f8'), ('rate', 'f8'), ('turns', 'i8'), ('beats', 'i8')]


class Wheel(Swing, Protocol):
    """The running state, a record: Y, θ, θ̇, and the numbers of turns and of beats."""

    angle: float
    rate: float
    turns: int
    beats: int


Pair: TypeAlias = tuple[float, float]

OK, EDGE = 0, 1

BEYOND_SAMPLES = 1.5
"""Bound of u within a span, as a multiple of the largest sample of its window: a motion that is
sampled finely enough to be interpolated rises no higher between samples.
"""

NEARLY = 1.0 - 1e-12
PER_HALF_TURN = 1.0 / math.pi
HALVINGS = 40


class Well(NamedTuple):
    """The oscillator of z, and the limit of its swing.

    Attributes:
        of: the oscillator.
        omega0: √(ω² + δ²) [rad/s].
        edge: edge of the cam [rad], or infinity.
    """

    of: Oscillator
    omega0: float
    edge: float


class Place(NamedTuple):
    """θ [rad] and θ̇ [rad/s] at an instant."""

    angle: float
    rate: float

    def heading(self, omega0: float) -> float:
        """Return the angle of (θ, −θ̇/ω₀) within a turn, in half turns from −½ on."""
        turned = math.atan2(0.0 - self.rate, omega0 * self.angle) * PER_HALF_TURN
        return turned + 2.0 if turned < 0.0 and self.angle < 0.0 else turned


@entry
def count_passages(
    well: Well, spans: Spans, path: Path, logged: NDArray[np.bool_], wheel: Wheel, counts: IntArray
) -> tuple[int, int, float]:
    """Count passages over spans; set θ, θ̇ and the counters to those at the end.

    Args:
        well: well of the wheel.
        spans: as propagated.
        path: the motion over them.
        logged: whether a span's end is logged, (n,).
        wheel: a record with the fields of `WHEEL`; θ and θ̇ at the beginning.
        counts: output: turns and beats at the logged ends, (logged, 2).

    Returns a code (OK, EDGE), the span and the fraction of it.
    """
    y, n, written, bound = path.y, len(logged), 0, _largest(well.omega0, spans.given)
    # a run of calm spans, over which the swing turns by less than 75° in its frame
    begun, place = 0, Place(wheel.angle, wheel.rate)
    for k in range(n):
        calm = _is_calm(well, spans, path, k, bound)
        if not calm and begun < k:
            after = _at_end(well, path, k - 1)
            _wind(well, spans, begun, k - 1, place, after, wheel)
            begun, place = k, after
        along = y[0, begun] * y[0, k + 1] + y[1, begun] * y[1, k + 1]
        far = not 2.0 * along * along >= _square(y, begun) * _square(y, k + 1)
        if not calm or far or along < 0.0 or logged[k] or k + 1 == n:
            after = _at_end(well, path, k)
            if calm:
                _wind(well, spans, begun, k, place, after, wheel)
            else:
                at = _follow(well, spans, path, k, place, after, wheel)
                if at <= 1.0:
                    return EDGE, k, at
            begun, place = k + 1, after
        if logged[k]:
            counts[written, 0], counts[written, 1] = wheel.turns, wheel.beats
            written += 1
    wheel.angle, wheel.rate = place.angle, place.rate
    return OK, 0, 0.0


@compiled
def _square(y: FloatArray, k: int) -> float:
    return y[0, k] * y[0, k] + y[1, k] * y[1, k]


@compiled
def _placed(of: Oscillator, y: Pair, frame: Pair, line: Pair) -> Place:
    """Return θ and θ̇ from Y, its frame, and u and u̇."""
    psi = (frame[0] * y[1] + frame[1] * y[0]) / of.omega
    rate = frame[0] * y[0] - frame[1] * y[1] - of.delta * psi - line[1]
    return Place(psi - line[0], rate)


@compiled
def _at_end(well: Well, path: Path, k: int) -> Place:
    y, frame, span = path.y, path.frame, path.span
    ends = (y[0, k + 1], y[1, k + 1]), (frame[0, k + 1], frame[1, k + 1])
    return _placed(well.of, ends[0], ends[1], (span[k, 2], span[k, 3]))


@compiled
def _is_calm(well: Well, spans: Spans, path: Path, k: int, bound: float) -> bool:
    """Return whether over a span the swing outweighs roll and forcing, and no edge is near.

    Args:
        bound: bound of the size of (u, u̇/ω₀) over all spans that are given by samples.
    """
    re, im, before = path.span[k, 0], path.span[k, 1], _square(path.y, k)
    if well.of.delta > 0.1 * well.omega0 or not re * re + im * im < 0.25 * before:
        return False
    by_samples = spans.given is not None and spans.given.first[k] >= 0
    if by_samples and _outweighs(well, before, _square(path.y, k + 1), bound):
        return True
    return _outweighs(well, before, _square(path.y, k + 1), _reach(well.omega0, spans, k))


@inlined
def _outweighs(well: Well, before: float, after: float, reach: float) -> bool:
    """Return whether swings of |Y|² outweigh a roll of some reach, and stay within the edge."""
    squared, room = well.of.omega * well.of.omega, well.edge - reach
    if not reach * reach * squared <= 0.49 * min(before, after):
        return False
    return room > 0.0 and 2.25 * max(before, after) < room * room * squared


@compiled
def _largest(omega0: float, given: Given | None) -> float:
    """Return a bound of the size of (u, u̇/ω₀) over all spans that are given by samples."""
    if given is None:
        return 0.0
    values, rates = given.values, given.rates
    value, rate, whole = splat(0.0), splat(0.0), len(values) // SIZE
    for i in range(whole):
        value, rate = larger(value, load(values, i)), larger(rate, load(rates, i))
    most, fastest = largest(value), largest(rate)
    for i in range(whole * SIZE, len(values)):
        most, fastest = max(most, abs(values[i])), max(fastest, abs(rates[i]))
    return BEYOND_SAMPLES * math.hypot(most, fastest / omega0)


@compiled
def _reach(omega0: float, spans: Spans, k: int) -> float:
    """Return a bound of the size of (u, u̇/ω₀) over a span."""
    if spans.given is None:
        return 0.0
    values, rates, first, fitted = spans.given
    per_slope, begin = spans.responses.per_slope[spans.shape[k]] / omega0, first[k]
    if begin < 0:
        value = slope = 0.0
        for j in range(fitted.shape[1]):
            number = abs(fitted[-1 - begin, j])
            value += number
            slope += j * number
        return math.hypot(value, per_slope * slope)
    largest = 0.0
    for i in range(begin, begin + spans.responses.rows.shape[1] // 2):
        value, slope = values[i], per_slope * rates[i]
        largest = max(largest, value * value + slope * slope)
    return BEYOND_SAMPLES * math.sqrt(largest)


@compiled
def _wind(
    well: Well, spans: Spans, first: int, last: int, before: Place, after: Place, wheel: Wheel
) -> None:
    """Count the passages of calm spans.

    (θ, −θ̇/ω₀) has turned by ωt but for less than half a turn, and it passes θ = 0 one way only,
    since θ' is θ̇.
    """
    begin_ns = spans.end_ns[first - 1] if first > 0 else spans.begin_ns
    turned = well.of.omega * PER_HALF_TURN * 1e-9 * (spans.end_ns[last] - begin_ns)
    more = after.heading(well.omega0) - before.heading(well.omega0)
    turns = round(0.5 * (turned - more))
    wheel.turns += turns
    wheel.beats += 2 * turns + (1 if after.angle < 0.0 else 0) - (1 if before.angle < 0.0 else 0)


@compiled
def _follow(
    well: Well, spans: Spans, path: Path, k: int, before: Place, after: Place, wheel: Wheel
) -> float:
    """Count the passages of a span part by part; return its fraction at the cam's edge, or 2."""
    of, shape, (y, frame, _) = well.of, spans.shape[k], path
    parts, first = spans.responses.parts[shape], spans.responses.first[shape]
    step = spans.responses.time_s[shape] / parts
    decay, now = math.exp(-of.delta * step), before
    re, im, c, s = y[0, k], y[1, k], frame[0, k], frame[1, k]
    for j in range(parts):
        then = now
        if j + 1 < parts:
            part = applied(spans, first + j, k)
            add = turned_back(c, s, lane(part, 0), lane(part, 1))
            re, im = decay * (re + add[0]), decay * (im + add[1])
            turned = of.omega * (j + 1) * step
            cosine, sine = math.cos(turned), math.sin(turned)
            c = frame[0, k] * cosine - frame[1, k] * sine
            s = frame[1, k] * cosine + frame[0, k] * sine
            now = _placed(of, (re, im), (c, s), (lane(part, 2), lane(part, 3)))
        else:
            now = after
        if math.hypot(now.angle, now.rate / well.omega0) > well.edge * NEARLY:
            at = _first_beyond(well, step, then, now)
            if at <= 1.0:
                return (j + at) / parts
        _cross(well, step, then, now, wheel)
    return 2.0


@compiled
def _cross(well: Well, step: float, then: Place, now: Place, wheel: Wheel) -> None:
    """Count the passages of θ in a part; leaving zero from rest does not count."""
    below, after = then.angle < 0.0, now.angle < 0.0
    if below != after:
        wheel.turns += 1 if below else 0
        wheel.beats += 0 if then.angle == 0.0 and then.rate == 0.0 else 1
        return
    back = (then.rate < 0.0) != below and (now.rate < 0.0) == below
    if back and _returns(well, step, then, now):
        wheel.turns += 1
        wheel.beats += 2


@compiled
def _returns(well: Well, step: float, then: Place, now: Place) -> bool:
    """Return whether θ passes zero and comes back within a part.

    It is on the same side at both ends, moves towards zero at the first and away at the second.
    """
    a, b, below = 0.0, 1.0, then.angle < 0.0
    for _ in range(HALVINGS):
        middle = 0.5 * (a + b)
        place = _within(well, step, then, now, middle)
        if (place.angle < 0.0) != below:
            return True
        a, b = (middle, b) if (place.rate < 0.0) != below else (a, middle)
    return False


@compiled
def _first_beyond(well: Well, step: float, then: Place, now: Place) -> float:
    """Return the fraction of a part at which |θ| first exceeds the edge; 2 if it does not."""
    for i in range(1, 65):
        if abs(_within(well, step, then, now, i / 64.0).angle) > well.edge:
            a, b = (i - 1) / 64.0, i / 64.0
            for _ in range(HALVINGS):
                middle = 0.5 * (a + b)
                beyond = abs(_within(well, step, then, now, middle).angle) > well.edge
                a, b = (a, middle) if beyond else (middle, b)
            return b
    return 2.0


@compiled
def _within(well: Well, step: float, then: Place, now: Place, x: float) -> Place:
    """Return θ and θ̇ at a fraction of a part.

    The contribution of the case's acceleration to the free swing is taken as the cubic through
    both ends. Over a part its error is 4e-5 of that acceleration over ω₀², times the square of the
    waves' frequency over that of the swing.
    """
    end, free = _swung(well, step, then), _swung(well, x * step, then)
    add, add_rate = now.angle - end.angle, (now.rate - end.rate) * step
    square, cube = 3.0 * add - add_rate, add_rate - 2.0 * add
    slope = x * (2.0 * square + 3.0 * x * cube)
    return Place(free.angle + x * x * (square + x * cube), free.rate + slope / step)


@compiled
def _swung(well: Well, s: float, then: Place) -> Place:
    """Return θ and θ̇ after a time of free swing in a case that keeps its roll's rate."""
    omega, delta, angle, rate = well.of.omega, well.of.delta, then.angle, then.rate
    cosine, sine, decay = math.cos(omega * s), math.sin(omega * s), math.exp(-delta * s)
    there = angle * cosine + (rate + delta * angle) / omega * sine
    turned = rate * cosine - (delta * rate + well.omega0 * well.omega0 * angle) / omega * sine
    return Place(decay * there, decay * turned)
