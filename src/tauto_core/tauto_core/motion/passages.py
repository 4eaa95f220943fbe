"""The passages of zero that a clock counts: upward ones of ϑ as turns, all of θ as beats.

ϑ, the angle the cam feels, or the coordinate that stands for it, and θ, the wheel's angle in its
case, differ by the tilt of the neutral line in the case (E2 in machine_at_sea.md). Where the swing
is large beside that tilt, clear of it, both pass zero once each half swing, and the signs of ϑ at
the nodes of a step are enough. Elsewhere an angle may reach zero and turn back between two nodes,
and is followed on the polynomials of the step.

An angle of exactly zero counts as positive. `state.beats` holds the passages of θ less those by
which θ is `ahead` of ϑ, so that θ is not needed while the swing is clear of the tilt.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

from tauto_core.kernels import compiled
from tauto_core.motion.gauss_step import (
    Mode,
    Work,
    fill_integrals,
)
from tauto_core.motion.lanes import (
    Lanes,
    fma,
    lane,
    largest,
    negative,
    ones,
    row_of,
    splat,
    width,
    with_lane,
)
from tauto_core.motion.system import (
    ForcingPieces,
    SteppedRun,
    StepPlace,
    StepWatch,
    mode_of,
    outside_at,
    planes_of,
    set_piece,
)
from tauto_core.samples import FloatArray

APART = 0.1
"""Fraction of the step by which a node must precede an event to be looked at.

The place of the event is known roughly when nodes are looked at, and what would pass zero after
the event does not happen.
"""

EIGHT = 0, 1, 2, 3, 4, 5, 6, 7
BOUND_PER_LARGEST = 1.5
"""Bound of a polynomial over its piece, as a multiple of its largest value at eight even points: a
motion that is sampled finely enough to be interpolated rises no higher between them.
"""

CLEAR = 2.0
"""Factor by which the square of the swing must exceed the bound at which it is just clear."""

AT_REST = 1e-11
"""Angle [rad] and rate [rad/s] below which a wheel is at rest at zero but for rounding, which the
interpolated rate of a hung case may have.
"""

TURNING_HALVINGS = 40
"""Most bisections in the search for a turning point between two nodes."""


class CountedAngles(NamedTuple):
    """The quantities that are counted, at an instant: ϑ or its coordinate, θ, and their rates."""

    felt: float
    felt_rate: float
    angle: float
    rate: float


class WatchedAngles(Protocol):
    """An object with angles within a step: a NamedTuple with this method."""

    def angles(self, xi: float) -> CountedAngles:
        """Return the angles at a fraction of the step."""


class WatchAngles(NamedTuple):
    """The angles of a system that swings."""

    step: StepWatch

    def angles(self, xi: float) -> CountedAngles:
        """Return the angles at a fraction of the step."""
        now = self.step.instant(xi)
        return CountedAngles(now.coordinate, now.speed, now.angle, now.rate)


class WatchRide(NamedTuple):
    """The angles while friction holds the wheel at θ = angle: ϑ = θ − τ."""

    angle: float
    place: StepPlace
    work: Work

    def angles(self, xi: float) -> CountedAngles:
        """Return the angles at a fraction of the step."""
        place = self.place
        tilt = outside_at(place.terms, place.begin + xi * place.size, self.work).tilt
        return CountedAngles(self.angle - tilt.value, -tilt.rate, self.angle, 0.0)


class Found(NamedTuple):
    """The passages of zero up to the last node looked at; `count_step` adds one after it.

    Attributes:
        turns: upward passages of ϑ.
        beats: passages of θ, plus those by which θ was ahead at the beginning.
        below, behind: whether ϑ and θ were below zero at the last node looked at.
    """

    turns: int
    beats: int
    below: bool
    behind: bool


@compiled
def ahead(felt: float, rate: float, angle: float) -> int:
    """Return by how many passages of zero θ is ahead of ϑ (`felt`, with its rate).

    0 if both are on the same side of zero. Otherwise 1 if ϑ moves towards the side of θ, which has
    then passed already, and −1 if ϑ comes from there.
    """
    if (felt < 0.0) == (angle < 0.0):
        return 0
    return 1 if (felt < 0.0) == (rate > 0.0) else -1


@compiled
def _returns(watch: WatchedAngles, of_wheel: bool, a: float, b: float, length_s: float) -> bool:
    """Return whether an angle passes zero and comes back between two fractions a, b of a step.

    It is θ `of_wheel`, else ϑ, on the same side at both, and moves towards zero at a and away from
    it at b. Its turning point is bracketed by the sign of the rate until the angle has changed its
    side, or is too far from zero to reach it.
    """
    start = watch.angles(a)
    below = (start.angle if of_wheel else start.felt) < 0.0
    for _ in range(TURNING_HALVINGS):
        middle = 0.5 * (a + b)
        now = watch.angles(middle)
        value = now.angle if of_wheel else now.felt
        rate = now.rate if of_wheel else now.felt_rate
        if (value < 0.0) != below:
            return True
        # on the way to its turning point it is nowhere steeper than here
        if abs(value) > abs(rate) * (b - a) * length_s:
            return False
        if (rate < 0.0) != below:
            a = middle
        else:
            b = middle
    return False


@compiled
def passages(
    watch: WatchedAngles, length_s: float, before: float, stop: float, work: Work
) -> Found:
    """Return the passages of zero within a step, followed on its polynomials.

    Nodes before the fraction `before` are looked at. The motion over this step ends at the
    fraction `stop`; beyond 1: at its end. A change of side there is counted by `count_step`, when
    the place of the event is known exactly.
    """
    old = watch.angles(0.0)
    below, behind = old.felt < 0.0, old.angle < 0.0
    # a wheel at rest in the middle leaves it, and does not pass it
    leaving = abs(old.angle) < AT_REST and abs(old.rate) < AT_REST
    turns, beats = 0, ahead(old.felt, old.felt_rate, old.angle)
    last, fractions = 0.0, row_of(work.fractions)
    for i in range(width(fractions) + 1):
        ends = i == width(fractions)
        xi = min(stop, 1.0) if ends else lane(fractions, min(i, width(fractions) - 1))
        if not ends and xi >= before:
            continue
        now = watch.angles(xi)
        if (now.felt < 0.0) != below:
            turns += 1 if below and not ends else 0
        elif (old.felt_rate < 0.0) != below and (now.felt_rate < 0.0) == below:
            turns += 1 if _returns(watch, False, last, xi, length_s) else 0
        if (now.angle < 0.0) != behind:
            beats += 0 if ends or leaving else 1
        elif (old.rate < 0.0) != behind and (now.rate < 0.0) == behind and not leaving:
            beats += 2 if _returns(watch, True, last, xi, length_s) else 0  # there and back
        if not ends:
            below, behind = now.felt < 0.0, now.angle < 0.0
            leaving = leaving and abs(now.angle) < AT_REST
        old, last = now, xi
    return Found(turns, beats, below, behind)


@compiled
def signs_at_nodes(coordinates: Lanes, below: bool, before: float, work: Work) -> Found:
    """Return the passages of zero within a step by the signs at its nodes, for a clear swing.

    There the swing is clear of the tilt, so that `passages` would find the same. `below` says
    whether the coordinate was below zero at the beginning of the step.
    """
    # bit i is node i; shifted by one, `less` has the sign at the node before
    seen, less = negative(row_of(work.fractions) - before), negative(coordinates)
    crossed = (less ^ (less << 1 | (1 if below else 0))) & seen
    count_seen = ones(seen)
    if count_seen > 0:
        below = less >> (count_seen - 1) & 1 == 1
    return Found(ones(crossed & ~less), ones(crossed), below, below)


@compiled
def bounds_of(
    channel: FloatArray | None, k: int, per: float, less: FloatArray | None = None
) -> tuple[float, float]:
    """Return bounds of |f| and of `per`·|df/dx| over piece k of a channel f; 0 if it is absent.

    Where another channel is to be taken off, f is the difference.

    The sum of the coefficients' magnitudes would be a bound without a guess, but is a hundred
    times too large in a piece about as long as a wave.
    """
    if channel is None:
        return 0.0, 0.0
    x = splat(0.0)
    for i in EIGHT:  # both ends and six places between: a row of lanes costs as much as one
        x = with_lane(x, i, i / 7.0)
    value, slope = splat(0.0), splat(0.0)
    own, count = channel.shape[1], channel.shape[1]
    if less is not None:
        count = max(own, less.shape[1])
    for j in range(count - 1, -1, -1):
        coefficient = channel[k, j] if j < own else 0.0
        if less is not None and j < less.shape[1]:
            coefficient -= less[k, j]
        slope = fma(slope, x, value)
        value = fma(value, x, coefficient)
    return BOUND_PER_LARGEST * largest(value), BOUND_PER_LARGEST * per * largest(slope)


@compiled
def in_step(
    clear: bool,
    before: float,
    stop: float,
    run: SteppedRun,
    mode: Mode,
    pieces: ForcingPieces,
    k: int,
    place: StepPlace,
) -> Found:
    """Return the passages of zero within the step last collocated.

    `clear` says whether the swing is clear of the tilt; `before` and `stop` are as in `passages`.
    """
    work = run.work
    if clear:
        below = run.system.coordinate(planes_of(run.omega, run.state.planes)) < 0.0
        return signs_at_nodes(run.system.coordinates(work), below, before, work)
    set_piece(pieces, k, True, work)
    fill_integrals(run.omega, work)
    watch = WatchAngles(StepWatch(run, mode, place))
    return passages(watch, place.size * place.length, before, stop, work)


@compiled
def count_step(clear: bool, found: Found, run: SteppedRun, terms: int, x: float) -> None:
    """Add the passages of a step that ends at x to the state there, after any event.

    Where the swing is clear of the tilt, θ need not be followed.
    """
    state, system = run.state, run.system
    planes = planes_of(run.omega, state.planes)
    if clear:
        now = system.coordinate(planes) < 0.0
        state.turns += found.turns + (1 if found.below and not now else 0)
        state.beats += found.beats + (1 if found.below != now else 0)
    else:
        at = outside_at(terms, x, run.work)
        end = system.instant(mode_of(state), run.omega, planes, at)
        now = end.coordinate < 0.0
        state.turns += found.turns + (1 if found.below and not now else 0)
        state.beats += found.beats + (1 if found.behind != (end.angle < 0.0) else 0)
        state.beats -= ahead(end.coordinate, end.speed, end.angle)
