"""What `spans` must know of a mechanism: functions that each type of `system` overloads.

`state` holds X and Y of each plane in twofold numbers, as in turning; `mode` is the sign of θ̇, d,
and that of the last impulse, s; `at` what the ship does at an instant: (β, β̇, β̈) of the apparent
vertical, (τ, τ̇, τ̈) of its tilt in the case, τ = β − α_c, and the apparent gravity.
"""

from __future__ import annotations

from typing import Any

from tauto_core.kernels import inlined
from tauto_core.motion.lanes import fma
from tauto_core.motion.wells import term

ANGLE, RATE, BEND, TENSION, MARGIN, TORQUE, COORDINATE, SPEED, ACCELERATION = range(9)
"""What `instant` returns: θ, θ̇, θ̈; the thread's tension, or what has its sign; what is positive
within the range of the mechanism; the thread's torque on the wheel over I; and the coordinate of
the phase with its first two derivatives."""


def at_nodes(system: Any, place: Any, work: Any) -> None:
    """Fill the rows from OUTSIDE on with what the ship does at the nodes of a step.

    `place` as in outside.
    """
    raise TypeError('at_nodes runs in compiled code only')


def instant(system: Any, mode: Any, omega: Any, state: Any, at: Any) -> Any:
    """Return the nine numbers named above."""
    raise TypeError('instant runs in compiled code only')


def wheel_angle(system: Any, state: Any, at: Any) -> float:
    """Return ANGLE alone."""
    raise TypeError('wheel_angle runs in compiled code only')


def margins(system: Any, mode: Any, omega: Any, work: Any) -> Any:
    """Return TENSION and MARGIN at the nodes of the step last collocated, as lanes."""
    raise TypeError('margins runs in compiled code only')


def strike(system: Any, mode: Any, omega: Any, at: Any, state: Any) -> None:
    """Let the escapement's impulse change the state."""
    raise TypeError('strike runs in compiled code only')


@inlined
def resistance(system: Any, mode: Any, rate: Any) -> Any:
    """Return the torques of drag and recoil, reversed, over I: c₁ θ̇ + c₂ d θ̇² + R s."""
    d, s = mode
    return rate * fma(system.quadratic * d, rate, system.viscous) + term(system.recoil, s)
