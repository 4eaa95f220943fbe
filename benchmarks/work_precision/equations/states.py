"""What the peers' equations share: one first-order form for the wheel, its start and end.

The case's equations are in `case_kernels`; its state is (theta, phi, theta', phi'). For the wheel,
x = psi - gamma is the angle that the cam feels, eps = m b^2/I, and u = p/I is the momentum of the
machine over the wheel's inertia (theory E2):

    x' = (u - gamma')/(1 + eps x^2)
    u' = x (eps x'^2 - b (P + m g_eff)/I) - (c/I) theta',      theta' = x' + gamma' - rho'

No gamma'' is needed. The lean is eta = gamma - rho = atan2(A, B), A = z0 rho'' - g sin rho,
B = g cos rho - z0 rho'^2 (specific force in the ship's axes, E1), and g_eff^2 = A^2 + B^2.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.work_precision.peer import MissingPeerError
from benchmarks.work_precision.problems import CaseProblem, Numbers, Problem, Sea


def library(peer: str, module: str, package: str) -> Any:
    """Return a peer's module.

    Raises:
        MissingPeerError: it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise MissingPeerError(peer, package) from error


@dataclass(frozen=True)
class Vertical:
    """Thread and ship at an instant: lean eta, eta' [rad, rad/s], g_eff [m/s2], rho, rho'."""

    lean: Any
    lean_rate: Any
    gravity: Any
    roll: Any
    roll_rate: Any


def angular_frequency(sea: Sea, kind: type = np.float64) -> Any:
    """Return 2 pi/period of the components [rad/s] to the precision of `kind`, shape (n,)."""
    pi = np.arccos(np.asarray(-1.0, dtype=kind))
    return 2 * pi / np.asarray(sea.period, dtype=kind)


def vertical(numbers: Numbers, time_s: float, kind: type = np.float64) -> Vertical:
    """Return the direction of the thread at a time from the start [s].

    Args:
        kind: float type of the arithmetic, np.float64 or np.longdouble.
    """
    gravity = kind(numbers.gravity)
    zero = kind(0.0)
    sea = numbers.sea
    if sea is None:
        return Vertical(zero, zero, gravity, zero, zero)
    amplitude: Any = np.asarray(sea.amplitude, dtype=kind)
    omega = angular_frequency(sea, kind)
    angle = omega * kind(time_s) + np.asarray(sea.phase, dtype=kind)
    cosine, sine = amplitude * np.cos(angle), amplitude * np.sin(angle)
    roll, rate = np.sum(cosine), -np.sum(omega * sine)
    second, third = -np.sum(omega**2 * cosine), np.sum(omega**3 * sine)
    height = kind(sea.height)
    across = height * second - gravity * np.sin(roll)
    along = gravity * np.cos(roll) - height * rate * rate
    across_rate = height * third - gravity * np.cos(roll) * rate
    along_rate = -rate * (gravity * np.sin(roll) + 2 * height * second)
    square = across * across + along * along
    follows = kind(1.0 if numbers.follows_vertical else 0.0)
    return Vertical(
        follows * np.arctan2(across, along),
        follows * (across_rate * along - across * along_rate) / square,
        np.sqrt(square),
        roll,
        rate,
    )


def mass_ratio(numbers: Numbers, kind: type = np.float64) -> Any:
    """Return eps = m b^2/I."""
    return kind(numbers.mass) * kind(numbers.lever_rate) ** 2 / kind(numbers.inertia)


def start(numbers: Numbers, kind: type = np.float64) -> tuple[Any, Any]:
    """Return x [rad] and u [rad/s] of the wheel released at rest in its case."""
    at = vertical(numbers, 0.0, kind)
    x = kind(numbers.release_angle) - at.lean
    u = -(1 + mass_ratio(numbers, kind) * x * x) * at.lean_rate + at.lean_rate + at.roll_rate
    return x, u


def wheel(
    numbers: Numbers, time_s: float, x: Any, u: Any, kind: type = np.float64
) -> tuple[Any, Any]:
    """Return theta [rad] and theta' [rad/s] of the wheel in its case."""
    at = vertical(numbers, time_s, kind)
    speed = (u - at.lean_rate - at.roll_rate) / (1 + mass_ratio(numbers, kind) * x * x)
    return x + at.lean, speed + at.lean_rate


def start_of(problem: Problem) -> tuple[float, ...]:
    """Return the state at the start: x and u, or the case's theta, phi and their rates."""
    if isinstance(problem, CaseProblem):
        return problem.numbers.release_angle, problem.numbers.release_angle, 0.0, 0.0
    x, u = start(problem.numbers)
    return float(x), float(u)


def end_of(problem: Problem, time_s: float, state: Any) -> tuple[float, float]:
    """Return the angle [rad] and rate [rad/s] that are compared: theta of the wheel or phi."""
    if isinstance(problem, CaseProblem):
        return float(state[1]), float(state[3])
    angle, rate = wheel(problem.numbers, time_s, state[0], state[1])
    return float(angle), float(rate)
