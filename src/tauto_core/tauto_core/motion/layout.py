"""How steps are laid out over a span, so that the next event lies just inside the last of them.

A stretch reaches to the end of the span, or a little beyond where the next event is expected, and
is divided into equal steps. An expected event need not happen: the next stretch is laid out from
wherever the last one ended.
"""

from __future__ import annotations

import math

from tauto_core.kernels import compiled

BEYOND = 0.05
"""Phase by which a stretch ends after the expected event [rad]."""

CROWDED = 1e-3
"""Phase since the last event below which events count as crowded [rad]."""

SPARE = 0.05
"""Share of a step by which a stretch may exceed its end, if that saves a step."""


@compiled
def phase_to(way: float, x: float, y: float, reach: float) -> float:
    """Return the phase that an oscillation turns through until way·x rises to `reach`.

    It lies in (0, 2π], for x = A sin φ, y = A cos φ; infinite if the swing is smaller.
    """
    size = math.sqrt(x * x + y * y)
    if not abs(reach) < size:
        return math.inf
    ahead = math.asin(reach / size) - math.atan2(way * x, way * y)
    while ahead <= 0.0:
        ahead += math.tau
    return ahead


@compiled
def back_to(late: float, bend: float, omega: float) -> float:
    """Return the time since a value fell below zero, to the third order.

    Args:
        late: the value over its rate of change [s].
        bend: that rate's own rate of change, over it [1/s].
        omega: frequency with which it swings [rad/s].
    """
    turned = bend * late
    return late * (1.0 + 0.5 * turned * (1.0 + turned) + (omega * late) ** 2 / 6.0)


@compiled
def lay_out(
    left: float, per_s: float, longest_s: float, ahead_s: float, level: int
) -> tuple[float, int]:
    """Return the length of the next stretch, and its steps.

    Args:
        left: the rest of the span.
        per_s: length of a second in the unit of `left`.
        longest_s: longest step [s].
        ahead_s: time to the next event [s]; infinite where none is expected.
        level: number of times that steps are halved.
    """
    whole = min(left, ahead_s * per_s)
    steps = math.ceil(whole / (per_s * longest_s) - SPARE)
    # equal steps keep the energy; ones that change with the phase do not
    return whole, max(1, steps) << level
