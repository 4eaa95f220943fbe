"""Closed forms for choosing a regulator (Euler 1727, XIX–XXI, XXIX).

A regulator with a linear lever arm b·ϑ swings like a simple pendulum of length L = I g/(P b).
"""

from __future__ import annotations

import math


def disc_inertia(weight: float, radius: float, gravity: float) -> float:
    """Return I = Q a²/(2g) of a homogeneous disc [kg m2].

    Args:
        weight: Q of the disc [N].
        radius: a of the disc [m].
        gravity: g [m/s2], > 0.
    """
    return weight * radius * radius / (2.0 * gravity)


def equivalent_pendulum_length(
    inertia: float, pull: float, lever_rate: float, gravity: float
) -> float:
    """Return L = I g/(P b) of the isochronous simple pendulum [m].

    For a disc of weight Q and radius a, and an involute of base radius r, Q a²/(2 P r) (§XXI),
    which is Q r/(2P) where the base circle is the disc (§XIX).

    Args:
        inertia: I of the wheel [kg m2].
        pull: P in the thread [N], > 0.
        lever_rate: b, the base radius of an involute [m/rad], > 0.
        gravity: g [m/s2].
    """
    return inertia * gravity / (pull * lever_rate)


def lever_rate_for(inertia: float, pull: float, length: float, gravity: float) -> float:
    """Return b = I g/(P L) [m/rad]: the base radius that gives a pendulum length (§XX).

    Args:
        inertia: I of the wheel [kg m2].
        pull: P in the thread [N], > 0.
        length: L of the isochronous simple pendulum [m], > 0.
        gravity: g [m/s2].
    """
    return inertia * gravity / (pull * length)


def base_radius_of_disc(weight: float, pull: float, length: float) -> float:
    """Return r = 2 P L/Q [m], where the base circle is the disc itself (§XX).

    Args:
        weight: Q of the disc [N], > 0.
        pull: P in the thread [N].
        length: L of the isochronous simple pendulum [m].
    """
    return 2.0 * pull * length / weight


def half_period(length: float, gravity: float) -> float:
    """Return π √(L/g) [s]: one oscillation in the papers' sense, half a period.

    Args:
        length: L of the simple pendulum [m].
        gravity: g [m/s2], > 0.
    """
    return math.pi * math.sqrt(length / gravity)
