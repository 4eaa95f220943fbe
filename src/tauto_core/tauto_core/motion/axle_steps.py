"""A step of a body on an axle in compiled code: Gauss–Legendre collocation, to rounding.

The law is that of `axle_pendulum.forces`, for plain numbers.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from tauto_core.kernels import compiled, entry
from tauto_core.samples import FloatArray

ARC_BEND, TILT_BEND, ARC, TILT, ARC_RATE, TILT_RATE, PRESSED, ALONG = range(8)
"""Rows of a step: s̈, φ̈, s, φ, ṡ, φ̇, N/M and F/M at its nodes."""

TURN, TURN_RATE, TURN_BEND, DOWN, LATERAL = range(5)
"""Rows of the support's motion: ρ, ρ̇, ρ̈, and the acceleration of its axis."""


class AxleLaw(NamedTuple):
    """The body and how it touches its support, as `AxlePendulum` and `AxleContact` have them.

    Attributes:
        curvature: 1/e [1/m].
        depth: c [m].
        gyration_radius: k [m].
        gravity: g [m/s2].
        radius: b₀ of the axle [m].
        friction: force along the support over the contact force, signed, where it slides.
        rolls: whether it rolls.
    """

    curvature: float
    depth: float
    gyration_radius: float
    gravity: float
    radius: float
    friction: float
    rolls: bool


class AxleInstant(NamedTuple):
    """State of the body and motion of its support at an instant; its axis is at s = 0, ρ = 0."""

    arc: float
    tilt: float
    arc_rate: float
    tilt_rate: float
    turn: float
    turn_rate: float
    turn_bend: float
    down: float
    lateral: float


class Pushed(NamedTuple):
    """s̈, φ̈, N/M and F/M."""

    arc_bend: float
    tilt_bend: float
    pressed: float
    along: float


@compiled
def pushed(law: AxleLaw, at: AxleInstant) -> Pushed:
    """Return accelerations and forces at an instant (equations: `axle_pendulum.forces`)."""
    sigma = law.curvature * at.arc
    theta, half = at.turn + sigma, 0.5 * sigma
    # the axle's centre in fixed axes, from its place at s = 0: its arc of curvature 1/e by the
    # chord, so that a plane (curvature 0) needs no other formula
    chord = at.arc * (math.sin(half) / half if half != 0.0 else 1.0)
    x, y = -chord * math.sin(half), chord * math.cos(half)
    sine_rho, cosine_rho = math.sin(at.turn), math.cos(at.turn)
    down, lateral = x * cosine_rho - y * sine_rho, x * sine_rho + y * cosine_rho
    square = at.turn_rate * at.turn_rate
    # the acceleration of that point of the turning support
    a = at.down - at.turn_bend * lateral - square * down
    b = at.lateral + at.turn_bend * down - square * lateral
    sine_theta, cosine_theta = math.sin(theta), math.cos(theta)
    c, k = law.depth, law.gyration_radius
    sine, cosine = math.sin(at.tilt - theta), math.cos(at.tilt - theta)
    swung = at.tilt_rate * at.tilt_rate
    pressing = law.gravity * cosine_theta - (a * cosine_theta + b * sine_theta)
    pressing = pressing + 2.0 * at.turn_rate * at.arc_rate
    pressing = pressing + law.curvature * at.arc_rate * at.arc_rate + c * cosine * swung
    pull = law.gravity * sine_theta + b * cosine_theta - a * sine_theta
    lever = law.radius - c * cosine
    if law.rolls:
        # no slip, s̈ = −b₀(φ̈ − ρ̈), and F eliminated from (C.5)
        spun = c * sine * swung - pull
        inertia = k * k + (c * sine) * (c * sine) + lever * lever
        turned = lever * (law.radius * at.turn_bend - spun) - c * sine * pressing
        bend = turned / inertia
        slip = -law.radius * (bend - at.turn_bend)
        return Pushed(slip, bend, pressing + c * sine * bend, slip - spun + c * cosine * bend)
    # sliding: F = ±μN enters φ̈ and, by c φ̈ sin δ, the contact force as well
    across, rubbing = c * sine / k, law.friction * lever / k
    contact = pressing / (1.0 + across * (across - rubbing))
    bend = contact * (rubbing - across) / k
    rubbed = law.friction * contact
    return Pushed(c * (sine * swung - cosine * bend) - pull + rubbed, bend, contact, rubbed)


@entry
def collocate_axle(
    law: AxleLaw,
    begin: FloatArray,
    size: float,
    support: FloatArray,
    inner: FloatArray,
    settled: float,
    most: int,
    rows: FloatArray,
) -> int:
    """Fill the rows of a step from a state; return the sweeps it took, or 0: it does not settle.

    The support's axis is where the axle's centre is at s = 0 and ρ = 0.

    Args:
        law: the body and its contact.
        begin: s, φ, ṡ, φ̇ at the beginning, (4,).
        size: length of the step [s].
        support: its motion at the nodes, rows TURN to LATERAL, (5, n + 1).
        inner: a_ij, from values at the nodes to integrals up to them, (n, n).
        settled: largest last change, over the largest acceleration, at which it ends.
        most: most sweeps.
        rows: rows ARC_BEND to ALONG, (8, n), filled.
    """
    n = inner.shape[0]
    last = math.inf
    for sweep in range(1, most + 1):
        arc_size = tilt_size = 1e-300
        arc_moved = tilt_moved = 0.0
        for i in range(n):
            if sweep == 1:
                rows[ARC_RATE, i], rows[TILT_RATE, i] = begin[2], begin[3]
            else:
                arc = tilt = 0.0
                for j in range(n):
                    arc += inner[i, j] * rows[ARC_BEND, j]
                    tilt += inner[i, j] * rows[TILT_BEND, j]
                rows[ARC_RATE, i] = begin[2] + size * arc
                rows[TILT_RATE, i] = begin[3] + size * tilt
        for i in range(n):
            arc = tilt = 0.0
            for j in range(n):
                arc += inner[i, j] * rows[ARC_RATE, j]
                tilt += inner[i, j] * rows[TILT_RATE, j]
            rows[ARC, i] = begin[0] + size * arc
            rows[TILT, i] = begin[1] + size * tilt
        for i in range(n):
            found = pushed(
                law,
                AxleInstant(
                    rows[ARC, i],
                    rows[TILT, i],
                    rows[ARC_RATE, i],
                    rows[TILT_RATE, i],
                    support[TURN, i],
                    support[TURN_RATE, i],
                    support[TURN_BEND, i],
                    support[DOWN, i],
                    support[LATERAL, i],
                ),
            )
            if not math.isfinite(found.arc_bend + found.tilt_bend):
                return 0
            arc_moved = max(arc_moved, abs(found.arc_bend - rows[ARC_BEND, i]))
            tilt_moved = max(tilt_moved, abs(found.tilt_bend - rows[TILT_BEND, i]))
            arc_size = max(arc_size, abs(found.arc_bend))
            tilt_size = max(tilt_size, abs(found.tilt_bend))
            rows[ARC_BEND, i], rows[TILT_BEND, i] = found.arc_bend, found.tilt_bend
            rows[PRESSED, i], rows[ALONG, i] = found.pressed, found.along
        moved = max(arc_moved / arc_size, tilt_moved / tilt_size)
        # or rounding keeps the changes from falling further
        if sweep > 1 and (moved <= settled or (moved < 1e-13 and moved >= last)):
            return sweep
        last = moved
    return 0
