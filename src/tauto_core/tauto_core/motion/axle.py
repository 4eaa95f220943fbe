"""The suspended case at any angles, as a system of two rotating planes: those of its modes.

    N/M = ((g + z̈) cos θ − ÿ sin θ + e θ̇² + c φ̇² cos δ)/(1 + (c/k)² sin²δ),    δ = φ − θ
    φ̈ = −(N/M) c sin δ/k²,    e θ̈ = −(g + z̈) sin θ − ÿ cos θ − c φ̈ cos δ + c φ̇² sin δ

(theory C and E3.) X = q and Y = q̇/ω of the modes, θ = c (q + q′) and φ = Bq + B′q′: the
disturbance of the planes consists of terms of the third order in the swing, and of the motion of
the bearing. Of what the driver knows, ÿ is in the place of the neutral line, g + z̈ in that of the
gravity, N/M in that of the thread's tension.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol, TypeAlias

from tauto_core.kernels import inlined
from tauto_core.motion.lanes import Lanes, fma, larger, load, store
from tauto_core.motion.lever_arm import Number
from tauto_core.motion.outside import GRAVITY, LINE, Outside, Place, column, nodes_of
from tauto_core.motion.rotation import sine_versine
from tauto_core.motion.system import Beyond, Instant, Mode, Plane, System, first_below
from tauto_core.motion.work import Omega, Work
from tauto_core.samples import FloatArray

PLANES = 2
NODES = 'sway', 'lift', 'contact', 'theta', 'delta'
"""Rows of ÿ, g + z̈, N/M, θ and δ at the nodes."""

OVER = 3.0
"""Tilt of the contact, or of the case from it, at which the case counts as turned over [rad]."""

ERROR_OF_LAST = 1.0
"""Error of a step per square of its last coefficient, at most."""

Pair: TypeAlias = tuple[Number, Number]


class Nodes(Protocol):
    """The rows NODES."""

    sway: FloatArray
    lift: FloatArray
    contact: FloatArray
    theta: FloatArray
    delta: FloatArray


class _Numbers(NamedTuple):
    """What the equations hold: e, c, k, and B and B′ of the modes."""

    e: float
    c: float
    k: float
    tilt: float
    tilt_prime: float


class SuspendedCase(_Numbers, System):
    """The case as `system.System`: θ in the place of the wheel's angle, φ of the coordinate."""

    @property
    def pace(self) -> float:
        """One: no events crowd."""
        return 1.0

    def at_nodes(self, place: Place, work: Work) -> None:
        """Fill ÿ and g + z̈."""
        x, nodes = nodes_of(place, work), work.nodes
        store(nodes.sway, 0, column(LINE, place.terms, x, work))
        store(nodes.lift, 0, column(GRAVITY, place.terms, x, work))

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill what disturbs the planes, contact force and angles; d1 stays zero."""
        e, c, k, tilt, tilt_prime = self
        q, other = load(work.x, 0), load(work.x, 1)
        nodes: Nodes = work.nodes
        rate, other_rate = load(work.y, 0), load(work.y, 1)
        theta, delta = c * (q + other), fma(other, tilt_prime - c, (tilt - c) * q)
        rates = _angles(self, omega[0] * rate, omega[1] * other_rate)
        sway, lift = load(nodes.sway), load(nodes.lift)
        contact, sine, cosine, across, along = _pressed(self, theta, delta, rates, sway, lift)
        # what waits for the contact force comes last, and is short
        free = fma(across, c * (rates[1] * rates[1]), -fma(lift, sine, sway * cosine))
        bend = contact * (across * (-c / (k * k)))
        turned = fma(along * -c, bend, free)
        per = 1.0 / (c * (tilt - tilt_prime))
        first, second = per / omega[0], per / omega[1]
        less, more = fma(bend, c * first, omega[0] * q), fma(bend, -c * second, omega[1] * other)
        store(work.d2, 0, fma(turned, -tilt_prime * first / e, less))
        store(work.d2, 1, fma(turned, tilt * second / e, more))
        store(nodes.contact, 0, contact)
        store(nodes.theta, 0, theta)
        store(nodes.delta, 0, delta)

    def beyond(self, mode: Mode, omega: Omega, work: Work) -> Beyond:
        """Return whether the case turns over, or its axle lifts off."""
        nodes: Nodes = work.nodes
        margin = OVER - larger(load(nodes.theta), load(nodes.delta))
        edge, slack = first_below(margin, work), first_below(load(nodes.contact), work)
        return Beyond(edge, slack, edge > 1.0, OVER)

    def coordinates(self, work: Work) -> Lanes:
        """Return φ at the nodes."""
        return load(work.nodes.theta) + load(work.nodes.delta)

    def coordinate(self, planes: tuple[Plane, ...]) -> float:
        """Return φ."""
        return _angles(self, planes[0].x, planes[1].x)[1]

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Outside) -> Instant:
        """Return the case at an instant, without θ̈ and φ̈, for which nobody asks."""
        theta, phi = _angles(self, planes[0].x, planes[1].x)
        rates = _angles(self, omega[0] * planes[0].y, omega[1] * planes[1].y)
        contact = _pressed(self, theta, phi - theta, rates, at.line.value, at.gravity)[0]
        margin = OVER - max(abs(theta), abs(phi - theta))
        return Instant(theta, rates[0], 0.0, contact, margin, 0.0, phi, rates[1], 0.0)


@inlined
def _angles(system: SuspendedCase, q: Number, other: Number) -> Pair:
    """Return θ and φ, or their rates, from those of the modes."""
    return system.c * (q + other), system.tilt * q + system.tilt_prime * other


@inlined
def _pressed(
    system: SuspendedCase, theta: Number, delta: Number, rates: Pair, sway: Number, lift: Number
) -> tuple[Number, Number, Number, Number, Number]:
    """Return N/M and sin, cos of θ and of δ."""
    e, c, k = system.e, system.c, system.k
    sine, versine = sine_versine(theta)
    across, less = sine_versine(delta)
    cosine, along = 1.0 - versine, 1.0 - less
    wide = (c / k) * across
    turning_rates = fma(c * (rates[1] * rates[1]), along, e * (rates[0] * rates[0]))
    pressed = fma(lift, cosine, fma(-sway, sine, turning_rates))
    return pressed / fma(wide, wide, 1.0), sine, cosine, across, along
