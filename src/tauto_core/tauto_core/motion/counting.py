"""What a clock counts: turns of the regulator's phase, and passages of the wheel through zero.

Seen at the nodes of each step and at its end, so that a step may be as long as half a swing and
more. `floats` and `ints` as in events.
"""

from __future__ import annotations

from typing import Any

from tauto_core.kernels import compiled
from tauto_core.motion.events import (
    BEATS,
    LAST_TILT,
    LAST_X,
    LAST_Y,
    STATE,
    THETA_SIGN,
    TURNS,
)
from tauto_core.motion.lanes import lane, load, negative, ones
from tauto_core.motion.outside import X_ROW, Y_ROW
from tauto_core.motion.turning import FRACTIONS

APART = 0.1
"""Part of the step that nodes must lie before an event to be counted: where it is, is not known
better yet, and what would be counted at a node behind it would not have happened."""


@compiled
def count_nodes(before: float, tilt: float, floats: Any, ints: Any, work: Any) -> None:
    """Count by the nodes of the step last collocated, as far as they come before a fraction.

    θ is told by its sign only; the tilt in the case is taken to change steadily over the step.

    Args:
        before: fraction of the step.
        tilt: of the neutral line in the case at the end of the step [rad].
    """
    fractions = load(work, FRACTIONS)
    x, y = load(work, X_ROW), load(work, Y_ROW)
    seen = negative(fractions - before)
    many = ones(seen)
    if many == 0:
        return
    # each bit with the one before it: the first with what was last
    ahead, left = negative(-y), negative(x)
    last = 1 if floats[LAST_Y] > 0.0 else 0
    crossed = (ahead ^ (ahead << 1 | last)) & left & seen
    ints[TURNS] += ones(crossed & ahead) - ones(crossed & ~ahead)
    floats[LAST_X], floats[LAST_Y] = lane(x, many - 1), lane(y, many - 1)
    leaning = floats[LAST_TILT] + fractions * (tilt - floats[LAST_TILT])
    behind = negative(x + leaning)
    sign = ints[THETA_SIGN]
    was = behind & 1 if sign == 0 else (1 if sign < 0 else 0)
    ints[BEATS] += ones((behind ^ (behind << 1 | was)) & seen)
    ints[THETA_SIGN] = -1 if behind >> (many - 1) & 1 else 1


@compiled
def count(angle: float, tilt: float, floats: Any, ints: Any) -> None:
    """Count what happened since the last node seen, or the end of the step before.

    Args:
        angle: θ now, 0: unknown on which side [rad].
        tilt: of the neutral line in the case now [rad].
    """
    x0, y0, x1, y1 = floats[LAST_X], -floats[LAST_Y], floats[STATE], -floats[STATE + 2]
    if (y0 < 0.0) != (y1 < 0.0) and x0 + (x1 - x0) * y0 / (y0 - y1) < 0.0:
        ints[TURNS] += 1 if y1 < 0.0 else -1
    floats[LAST_X], floats[LAST_Y], floats[LAST_TILT] = x1, -y1, tilt
    if angle != 0.0:
        sign = 1 if angle > 0.0 else -1
        if ints[THETA_SIGN] == -sign:
            ints[BEATS] += 1
        ints[THETA_SIGN] = sign
