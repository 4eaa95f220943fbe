"""How steps are laid out over a span: so that the next event lies just inside the last of them.

A stretch reaches to the end of the span, or a little beyond the place where the next event is
expected, and is divided into equal steps. An expected event need not happen: the next stretch is
laid out from wherever this one ends. Near its end an event costs a short step, which leads back
to it, and not a second long one.
"""

from __future__ import annotations

import math

from tauto_core.kernels import compiled

BEYOND = 0.05
"""Phase by which a stretch ends after the expected event [rad]."""

CROWDED = 1e-3
"""Phase since the last event below which events count as crowded [rad]."""

SPARE = 0.05
"""Share of a step by which steps may be longer than the longest, if that saves one."""


@compiled
def phase_to(way: float, x: float, y: float, reach: float) -> float:
    """Return the phase until way·x next rises to `reach`, for x = A sin φ, y = A cos φ.

    It lies in (0, 2π]; infinite if A is at most |reach|.

    Args:
        way: 1 or −1.
        x: displacement now.
        y: rate now, divided by the frequency.
        reach: value of way·x to be reached.
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
    """Return the time since a value fell below zero, with an error of the fourth order.

    Args:
        late: the value divided by its rate of change [s], the estimate of first order.
        bend: the rate of change of that rate, divided by it [1/s].
        omega: frequency with which the value swings [rad/s], for its third derivative.
    """
    turned = bend * late
    return late * (1.0 + 0.5 * turned * (1.0 + turned) + (omega * late) ** 2 / 6.0)


@compiled
def lay_out(
    left: float, per_s: float, longest_s: float, ahead_s: float, level: int
) -> tuple[float, int]:
    """Return the length of the next stretch, in the unit of `left`, and the number of its steps.

    Args:
        left: the rest of the span.
        per_s: length of a second in the unit of `left`.
        longest_s: longest step [s].
        ahead_s: time to the next event [s]; infinite where none is expected.
        level: number of times that steps are halved.
    """
    stretch = min(left, ahead_s * per_s)
    steps = math.ceil(stretch / (per_s * longest_s) - SPARE)
    # Equal steps: the energy of a swing drifts where the length of steps goes with its phase.
    return stretch, max(1, steps) << level
