"""The equation of motion of a wheel with one degree of freedom, term by term, in compiled code.

The coordinate is q = ϑ, the angle the cam feels [rad]; the momentum per unit of inertia is
w = q̇ + γ̇ + μt²q̇ [rad/s]. In Hamilton's form (theory E2) no second derivative of the ship's
motion is needed:

    q̇ = (w − γ̇) / (1 + μt²)                                                 μ = m/I
    ẇ = −pull · t + μ t t′ q̇² − (c₁θ̇ + c₂ d θ̇² + c₀ d + R s)/I               θ̇ = q̇ + τ̇

with t(q) the lever arm [m], t′ = dt/dq, pull = F/I, γ the neutral line, τ = γ − α_c its tilt in
the case, θ = q + τ, d the sign of θ̇ and s that of the last impulse, both constant between events.

A heavy weight on a linear lever arm has a `shape` (`arc_length`): there the coordinate is the arc
s of the well and the momentum p = ṡ + γ̇n, n = dϑ/ds. Below, x and w are the coordinate and the
momentum of either kind. As in `system` and `outside`, `rate` is θ̇, `speed` q̇ and `line` γ.

Absent terms are `None`, and are not in the compiled code.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

from tauto_core.curves.levers import Lever
from tauto_core.kernels import compiled, inlined
from tauto_core.machines.escapement import Ebb
from tauto_core.motion.arc_length import ArcShape
from tauto_core.motion.lever_arm import Number, lever_arm
from tauto_core.motion.on_arc import angle_along, arc_of
from tauto_core.motion.outside import Outside
from tauto_core.motion.system import Mode


class Impulse(NamedTuple):
    """The escapement's impulse.

    Attributes:
        energy: twice its energy over I [rad2/s2].
        ebb: how the energy falls from impulse to impulse; None: it is constant.
    """

    energy: float
    ebb: Ebb | None


class PerInertia(NamedTuple):
    """What acts on the wheel, divided by its moment of inertia I; None where absent.

    Attributes:
        carried: μ = m/I of the mass that moves with the thread [1/m2].
        force: constant part of the pull F/I [1/(m s2)].
        stiffness: κ/I of the spring, to be multiplied by the lift [1/(m2 s2)].
        weight: m/I of the mass that draws, to be multiplied by the apparent gravity [1/m2].
        viscous, quadratic, coulomb: c₁/I [1/s], c₂/I [1/rad] and c₀/I [rad/s2] of the drag.
        impulse: the escapement's impulse.
        recoil: R/I [rad/s2].
    """

    carried: float | None
    force: float | None
    stiffness: float | None
    weight: float | None
    viscous: float | None
    quadratic: float | None
    coulomb: float | None
    impulse: Impulse | None
    recoil: float | None


class Well(Protocol):
    """A wheel in its potential well."""

    @property
    def per_inertia(self) -> PerInertia:
        """What acts on it."""

    @property
    def lever(self) -> Lever:
        """Law of the lever arm."""

    @property
    def shape(self) -> ArcShape | None:
        """The functions of the arc, or None where the angle is the coordinate."""


@inlined
def term(coefficient: float | None, value: Number) -> Number:
    """Return coefficient · value; an absent term is −0.0, the sum's neutral element."""
    return -0.0 if coefficient is None else coefficient * value


@inlined
def pull_of(per_inertia: PerInertia, lift: Number, gravity: Number) -> Number:
    """Return the pull on the thread over I, F/I, by the lift and the apparent gravity."""
    pull = term(per_inertia.force, 1.0) + term(per_inertia.stiffness, lift)
    return pull + term(per_inertia.weight, gravity)


@inlined
def resistance(per_inertia: PerInertia, rate: Number, mode: Mode) -> Number:
    """Return the torque of drag and recoil against the motion over I, by θ̇."""
    d = mode.direction
    drag = term(per_inertia.viscous, rate) + term(per_inertia.quadratic, d * (rate * rate))
    return drag + term(per_inertia.coulomb, d) + term(per_inertia.recoil, mode.pallet)


@inlined
def mass_of(mu: float | None, t: Number) -> Number:
    """Return M/I = 1 + μ t²."""
    return 1.0 + term(mu, t * t)


@inlined
def speed_of(mu: float | None, t: Number, w: Number, line_rate: Number) -> Number:
    """Return q̇ from the momentum w."""
    return w - line_rate if mu is None else (w - line_rate) / (1.0 + mu * (t * t))


@inlined
def ride(mu: float | None, t: Number, t_prime: Number, speed: Number) -> Number:
    """Return μ t t′ q̇²: the mass that moves with the thread, on a lever arm that changes."""
    return term(mu, t * t_prime * (speed * speed))


@inlined
def angle_at(well: Well, x: float) -> float:
    """Return ϑ at the coordinate x."""
    return x if well.shape is None else angle_along(well.shape, x)


@inlined
def angle_and_speed(
    well: Well, x: float, w: float, line_rate: float, side: float
) -> tuple[float, float]:
    """Return ϑ and ϑ̇ from coordinate and momentum."""
    if well.shape is None:
        t = lever_arm(well.lever, side, x).t
        return x, speed_of(well.per_inertia.carried, t, w, line_rate)
    k = well.shape.k
    q = angle_along(well.shape, x)
    n = 1.0 / math.sqrt(1.0 + (k * q) * (k * q))
    return q, n * (w - line_rate * n)


@inlined
def coordinate_and_momentum(
    well: Well, q: float, speed: float, line_rate: float, side: float
) -> tuple[float, float]:
    """Return coordinate and momentum from ϑ and ϑ̇: the inverse of `angle_and_speed`."""
    if well.shape is None:
        t = lever_arm(well.lever, side, q).t
        return q, speed * mass_of(well.per_inertia.carried, t) + line_rate
    k = well.shape.k
    per_n = math.sqrt(1.0 + (k * q) * (k * q))
    return arc_of(q, k), speed * per_n + line_rate / per_n


@compiled
def holding_torque(well: Well, mode: Mode, angle: float, at: Outside) -> float:
    """Return the torque over I that keeps the wheel at θ = angle in the moving case.

    There ϑ̇ = −τ̇ and ϑ̈ = −τ̈: with ψ̈ = α̈ = γ̈ − τ̈ of the wheel and the acceleration
    t′τ̇² − tτ̈ of the mass on the thread, the torque is ψ̈ + μt(t′τ̇² − tτ̈) + pull · t + R s/I.
    """
    per_inertia, tilt = well.per_inertia, at.tilt
    t, t_prime, lift = lever_arm(well.lever, mode.side, angle - tilt.value)
    carried = term(per_inertia.carried, t * (t_prime * tilt.rate * tilt.rate - t * tilt.bend))
    pulled = carried + pull_of(per_inertia, lift, at.gravity) * t
    return at.line.bend - tilt.bend + pulled + term(per_inertia.recoil, mode.pallet)


@compiled
def kick(
    impulse: Impulse, mu: float | None, t: float, rate: float, direction: float, given: int
) -> float:
    """Return what an impulse adds to θ̇, and as much to ϑ̇: ½(I + mt²)θ̇² grows by its energy.

    Args:
        impulse: of the escapement.
        mu: μ = m/I.
        t: lever arm.
        rate: θ̇ before it.
        direction: sign of θ̇ after it.
        given: impulses before this one.
    """
    strength = 1.0 if impulse.ebb is None else impulse.ebb.strength(given)
    energy = impulse.energy * strength
    return direction * math.sqrt(rate * rate + energy / mass_of(mu, t)) - rate
