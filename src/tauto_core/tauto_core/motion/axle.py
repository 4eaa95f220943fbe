"""The suspended case at any angles, as a system of two rotating planes: those of its modes.

With θ the tilt of the contact's normal, φ that of the case and δ = φ − θ, (C.2) and (C.3) become
in a bearing that moves (theory E3)

    N/M = ((g + z̈) cos θ − ÿ sin θ + e θ̇² + c φ̇² cos δ)/(1 + (c/k)² sin²δ),
    φ̈ = −(N/M) c sin δ/k²,    e θ̈ = −(g + z̈) sin θ − ÿ cos θ − c φ̈ cos δ + c φ̇² sin δ.

θ = c (q + q′) and φ = Bq + B′q′ (`machines.modes`); X and Y are q and q̇/ω of each mode. What
disturbs the planes is then of the third order in the swing, or the motion of the bearing.

The driver's names are those of a wheel. Here its line is ÿ, its gravity g + z̈, the angle θ, the
coordinate φ, and the tension N/M.
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
"""|θ| or |δ| at which the case counts as turned over [rad]."""

ERROR_OF_LAST = 1.0
"""Error of a step over the square of its last Legendre coefficient, at most (`step_size`)."""

Pair: TypeAlias = tuple[Number, Number]
"""θ and φ, or their rates."""


class Nodes(Protocol):
    """The rows NODES."""

    sway: FloatArray
    lift: FloatArray
    contact: FloatArray
    theta: FloatArray
    delta: FloatArray


class _Numbers(NamedTuple):
    """The constants of the equations [m]: e, c, k, and B and B′ of the modes."""

    e: float
    c: float
    k: float
    B: float
    B_prime: float


class SuspendedCase(_Numbers, System):
    """The case as `system.System`."""

    @property
    def pace(self) -> float:
        """One, since there are no events that the driver would measure in swings."""
        return 1.0

    def at_nodes(self, place: Place, work: Work) -> None:
        """Fill ÿ and g + z̈."""
        x, nodes = nodes_of(place, work), work.nodes
        store(nodes.sway, 0, column(LINE, place.terms, x, work))
        store(nodes.lift, 0, column(GRAVITY, place.terms, x, work))

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill what disturbs the planes, and N/M, θ and δ; d1 stays zero.

        The accelerations of the modes are q̈ = (c φ̈ − B′θ̈)/D and q̈′ = (B θ̈ − c φ̈)/D, with
        D = c (B − B′).
        """
        e, c, k, B, B_prime = self
        q, other = load(work.x, 0), load(work.x, 1)
        nodes: Nodes = work.nodes
        rate, other_rate = load(work.y, 0), load(work.y, 1)
        theta, delta = c * (q + other), fma(other, B_prime - c, (B - c) * q)
        rates = _angles(self, omega[0] * rate, omega[1] * other_rate)
        sway, lift = load(nodes.sway), load(nodes.lift)
        contact, sin_theta, cos_theta, sin_delta, cos_delta = _contact(
            self, theta, delta, rates, sway, lift
        )
        # the division in the contact force takes longest, so that little waits for it
        free = fma(sin_delta, c * (rates[1] * rates[1]), -fma(lift, sin_theta, sway * cos_theta))
        phi_bend = contact * (sin_delta * (-c / (k * k)))
        e_theta_bend = fma(cos_delta * -c, phi_bend, free)
        per = 1.0 / (c * (B - B_prime))
        first, second = per / omega[0], per / omega[1]
        slow = fma(phi_bend, c * first, omega[0] * q)
        fast = fma(phi_bend, -c * second, omega[1] * other)
        store(work.d2, 0, fma(e_theta_bend, -B_prime * first / e, slow))
        store(work.d2, 1, fma(e_theta_bend, B * second / e, fast))
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
        contact = _contact(self, theta, phi - theta, rates, at.line.value, at.gravity)[0]
        margin = OVER - max(abs(theta), abs(phi - theta))
        return Instant(
            angle=theta,
            rate=rates[0],
            bend=0.0,
            tension=contact,
            margin=margin,
            torque=0.0,
            coordinate=phi,
            speed=rates[1],
            acceleration=0.0,
        )


@inlined
def _angles(system: SuspendedCase, q: Number, other: Number) -> Pair:
    """Return θ and φ of q and q′, or the rates of these of their rates."""
    return system.c * (q + other), system.B * q + system.B_prime * other


@inlined
def _contact(
    system: SuspendedCase, theta: Number, delta: Number, rates: Pair, sway: Number, lift: Number
) -> tuple[Number, Number, Number, Number, Number]:
    """Return N/M, sin θ, cos θ, sin δ and cos δ."""
    e, c, k = system.e, system.c, system.k
    sin_theta, versine_theta = sine_versine(theta)
    sin_delta, versine_delta = sine_versine(delta)
    cos_theta, cos_delta = 1.0 - versine_theta, 1.0 - versine_delta
    eccentric = (c / k) * sin_delta
    centripetal = fma(c * (rates[1] * rates[1]), cos_delta, e * (rates[0] * rates[0]))
    pressing = fma(lift, cos_theta, fma(-sway, sin_theta, centripetal))
    contact = pressing / fma(eccentric, eccentric, 1.0)
    return contact, sin_theta, cos_theta, sin_delta, cos_delta
