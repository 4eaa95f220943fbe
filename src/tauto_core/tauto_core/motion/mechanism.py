"""What `spans` must know of a mechanism: functions that each type of `system` overloads.

`state` holds X and Y of each plane in twofold numbers, as in turning; `mode` is the sign of θ̇, d,
and that of the last impulse, s; `at` what the ship does at an instant: (β, β̇, β̈) of the apparent
vertical, (τ, τ̇, τ̈) of its tilt in the case, τ = β − α_c, and the apparent gravity.
"""

from __future__ import annotations

from typing import Any

from tauto_core.motion.compiled import compiled, inlined
from tauto_core.motion.lanes import fma
from tauto_core.motion.outside import lanes_channel
from tauto_core.motion.wells import horner, term

ANGLE, RATE, BEND, TENSION, MARGIN, TORQUE, COORDINATE, SPEED, ACCELERATION = range(9)
"""What `instant` returns: θ, θ̇, θ̈; the thread's tension, or what has its sign; what is positive
within the range of the mechanism; the thread's torque on the wheel over I; and the coordinate of
the phase with its first two derivatives."""


def at_nodes(system: Any, place: Any, work: Any) -> None:
    """Fill the rows from OUTSIDE on with what the ship does at the nodes of a step.

    `place`: forcing, piece k, where the step begins in it and its length, both in x.
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


@compiled
def polynomial_at(coefficients: Any, k: int, x: float, per_s: float) -> tuple[float, float, float]:
    """Return a channel and its first two time derivatives."""
    value, first, second = horner(coefficients, k, x)
    return value, first * per_s, second * per_s * per_s


@compiled
def outside_at(forcing: Any, k: int, x: float) -> Any:
    """Return what the ship does at x in piece k: `at`."""
    length, vertical, tilt, gravity = forcing
    per_s = 1.0 / length[k]
    g_eff = polynomial_at(gravity, k, x, per_s)[0]
    return polynomial_at(vertical, k, x, per_s), polynomial_at(tilt, k, x, per_s), g_eff


@inlined
def outside_nodes(forcing: Any, k: int, x: Any) -> Any:
    """Return the same for lanes of x: β, β̇, β̈, τ, τ̇, τ̈ and the apparent gravity."""
    length, vertical, tilt, gravity = forcing
    per_s = 1.0 / length[k]
    line, line_rate, line_bend = lanes_channel(vertical, k, x)
    lean, lean_rate, lean_bend = lanes_channel(tilt, k, x)
    g_eff = lanes_channel(gravity, k, x)[0]
    square = per_s * per_s
    moved = line, line_rate * per_s, line_bend * square
    return moved, (lean, lean_rate * per_s, lean_bend * square), g_eff


@inlined
def resistance(system: Any, mode: Any, rate: Any) -> Any:
    """Return the torques of drag and recoil, reversed, over I: c₁ θ̇ + c₂ d θ̇² + R s."""
    d, s = mode
    return rate * fma(system.quadratic * d, rate, system.viscous) + term(system.recoil, s)
