"""What a clock counts: upward passages of ϑ, each a turn of the phase, and passages of θ, beats.

The felt angle ϑ and the wheel's angle θ in its case differ by the tilt of the neutral line in the
case (theory E2). Both pass zero once each half swing where the swing is large beside that tilt
(`Clear`): then the signs at the nodes of a step are enough. Elsewhere an angle may reach zero and
turn back between two nodes, and is followed on the polynomials of the step.

An angle of exactly zero counts as positive. `ints[BEATS]` of the engines holds the passages of θ
less `ahead`, so that nothing needs θ while the swing is large.
"""

from __future__ import annotations

from typing import Any

from tauto_core.kernels import compiled
from tauto_core.motion.lanes import lane, load, negative, ones, width
from tauto_core.motion.turning import FRACTIONS

APART = 0.1
"""Part of the step that nodes must lie before an event to be counted: where it is, is not known
better yet, and what would be counted at a node behind it would not have happened."""

HALVINGS = 40


def angles_at(watch: Any, xi: float) -> Any:
    """Return ϑ or its coordinate, θ, and their rates (ϑ, ϑ̇, θ, θ̇) at a fraction of the step.

    The driver overloads this for its type of `watch`.
    """
    raise TypeError('angles_at runs in compiled code only')


@compiled
def ahead(felt: float, rate: float, angle: float) -> int:
    """Return by how many passages θ is ahead of ϑ: 0 on the same side of zero, else 1 or −1.

    Args:
        felt: ϑ or its coordinate.
        rate: of ϑ.
        angle: θ.
    """
    if (felt < 0.0) == (angle < 0.0):
        return 0
    return 1 if (felt < 0.0) == (rate > 0.0) else -1


@compiled
def _returns(watch: Any, of_wheel: bool, a: float, b: float, length_s: float) -> bool:
    """Return whether an angle passes zero and comes back between two fractions of a step.

    It is on the same side at both, moves towards zero at the first and away at the second.

    Args:
        length_s: of the whole step [s].
    """
    start = angles_at(watch, a)
    below = start[2 if of_wheel else 0] < 0.0
    for _ in range(HALVINGS):
        middle = 0.5 * (a + b)
        felt, felt_rate, angle, angle_rate = angles_at(watch, middle)
        value, rate = (angle, angle_rate) if of_wheel else (felt, felt_rate)
        if (value < 0.0) != below:
            return True
        # no steeper on the way to where it turns back than it is here
        if abs(value) > abs(rate) * (b - a) * length_s:
            return False
        if (rate < 0.0) != below:
            a = middle
        else:
            b = middle
    return False


@compiled
def passages(
    watch: Any, length_s: float, before: float, stop: float, work: Any
) -> tuple[int, int, bool, bool]:
    """Return what passes zero within a step, followed on its polynomials.

    Args:
        length_s: of the step [s].
        before: fraction before which nodes are looked at.
        stop: fraction at which the motion over this step ends; beyond 1: at its end. On which
            side of zero that is is for `settle`: an event is carried to its place more exactly.

    Returns upward passages of ϑ, passages of θ less how many θ was ahead at the beginning, and
    whether ϑ and θ were below zero at the last node looked at.
    """
    x0, rate0, angle0, v0 = angles_at(watch, 0.0)
    below, behind = x0 < 0.0, angle0 < 0.0
    # a wheel at rest in the middle leaves it, and does not pass it
    leaving = angle0 == 0.0 and v0 == 0.0
    turns, beats = 0, ahead(x0, rate0, angle0)
    last, fractions = 0.0, load(work, FRACTIONS)
    for i in range(width(work) + 1):
        ends = i == width(work)
        xi = min(stop, 1.0) if ends else lane(fractions, min(i, width(work) - 1))
        if not ends and xi >= before:
            continue
        x1, rate1, angle1, v1 = angles_at(watch, xi)
        if (x1 < 0.0) != below:
            turns += 1 if below and not ends else 0
        elif (rate0 < 0.0) != below and (rate1 < 0.0) == below:
            turns += 1 if _returns(watch, False, last, xi, length_s) else 0
        if (angle1 < 0.0) != behind:
            beats += 0 if ends or leaving else 1
        elif (v0 < 0.0) != behind and (v1 < 0.0) == behind and not leaving:
            beats += 2 if _returns(watch, True, last, xi, length_s) else 0
        if not ends:
            below, behind, leaving = x1 < 0.0, angle1 < 0.0, False
        rate0, v0, last = rate1, v1, xi
    return turns, beats, below, behind


@compiled
def signs_at_nodes(row: int, below: bool, before: float, work: Any) -> tuple[int, int, bool, bool]:
    """Return as `passages` what a row of the nodes passes, where the swing is large.

    Args:
        row: of ϑ or its coordinate.
        below: whether it was below zero at the beginning of the step.
        before: fraction before which nodes are looked at.
    """
    seen, less = negative(load(work, FRACTIONS) - before), negative(load(work, row))
    crossed = (less ^ (less << 1 | (1 if below else 0))) & seen
    many = ones(seen)
    if many > 0:
        below = less >> (many - 1) & 1 == 1
    return ones(crossed & ~less), ones(crossed), below, below


@compiled
def settle(large: bool, found: Any, felt: float, rate: float, angle: float) -> tuple[int, int]:
    """Return turns and beats to add at the end of a step.

    Args:
        large: whether the swing is large, so that θ is not looked at.
        found: what `passages` or `signs_at_nodes` found.
        felt: ϑ or its coordinate at the end.
        rate: of ϑ, after what happens there.
        angle: θ.
    """
    turns, beats, below, behind = found
    now = felt < 0.0
    turns += 1 if below and not now else 0
    if large:
        return turns, beats + (1 if below != now else 0)
    return turns, beats + (1 if behind != (angle < 0.0) else 0) - ahead(felt, rate, angle)
