"""The case in gimbals: a pendulum on pivots that are fixed in the ship and rub against her.

With φ the tilt of the case, ρ the roll of the ship, and all torques over the case's moment of
inertia about its pivots, M (k² + l²),

    φ̈ = −p ((g + z̈) sin φ + ÿ cos φ) − 2ζω_c (φ̇ − ρ̇) − f sgn (φ̇ − ρ̇),    p = l/(k² + l²)

(G5.1 in suspension.md). In the ship the case has the angle φ − ρ, as a wheel has θ in its case, so
that the driver finds the turning points of that angle, where the friction f turns round, and moves
the case with the ship while friction holds it. The neutral line is the vertical: τ = −ρ.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.events import ride_held
from tauto_core.motion.gauss_step import (
    Mode,
    Omega,
    Work,
    sine_versine,
)
from tauto_core.motion.lanes import SIZE, Numeric, fma, larger, row_of, store, width
from tauto_core.motion.stepping import state_type
from tauto_core.motion.suspended_case import (
    OVER,
    BearingMotion,
    CaseMotion,
    SteppedSwing,
)
from tauto_core.motion.system import (
    APPARENT_GRAVITY,
    DRIVE,
    NOWHERE,
    TILT_RATE,
    Beyond,
    Instant,
    Outside,
    Plane,
    RunningState,
    SteppedRun,
    StepPlace,
    System,
    column_at,
    first_below,
    nodes_of,
)
from tauto_core.motion.wells import term
from tauto_core.samples import FloatArray

GIMBALS_NODES = 'sway', 'lift', 'roll_rate'
"""Rows of ÿ, g + z̈ and ρ̇ at the nodes."""


class GimbalsNodes(Protocol):
    """The rows GIMBALS_NODES; the last one is set where the pivots rub."""

    sway: FloatArray
    lift: FloatArray
    roll_rate: FloatArray


class GimbalsLaw(NamedTuple):
    """The torques on a case in gimbals, over its moment of inertia.

    Attributes:
        pull: p = l/(k² + l²) [1/m].
        damping: 2ζω_c [1/s], or None.
        friction: f [rad/s2], or None.
    """

    pull: float
    damping: float | None
    friction: float | None


@inlined
def gimbals_bend(
    law: GimbalsLaw,
    phi: Numeric,
    sliding: Numeric,
    direction: float,
    sway: Numeric,
    lift: Numeric,
) -> Numeric:
    """Return φ̈ of a tilt φ, from φ̇ − ρ̇ (`sliding`) and its sign, ÿ and g + z̈."""
    sine, versine = sine_versine(phi)
    turned = law.pull * fma(lift, sine, sway * (1.0 - versine))
    return -(turned + term(law.damping, sliding) + term(law.friction, direction))


class _GimbalsNumbers(NamedTuple):
    """The torques on the case, and ω_c of its small swings [rad/s]."""

    law: GimbalsLaw
    omega: float


class GimbalsCase(_GimbalsNumbers, System):
    """The case as `system.System`, in one plane: X = φ, ω_cY = φ̇."""

    @property
    def pace(self) -> float:
        """Frequency of small swings [rad/s]."""
        return self.omega

    @property
    def turns_abruptly(self) -> bool:
        """Whether friction turns round with the sliding."""
        return self.law.friction is not None

    @property
    def sticks(self) -> bool:
        """Whether friction may hold the case in the ship."""
        return self.law.friction is not None

    @property
    def has_weight(self) -> bool:
        """Return False: no thread can go slack."""
        return False

    def at_nodes(self, place: StepPlace, work: Work) -> None:
        """Fill ÿ, g + z̈ and ρ̇."""
        x, nodes = nodes_of(place, work), work.nodes
        store(nodes.sway, 0, column_at(DRIVE, place.terms, x, work))
        store(nodes.lift, 0, column_at(APPARENT_GRAVITY, place.terms, x, work))
        store(nodes.roll_rate, 0, -column_at(TILT_RATE, place.terms, x, work))

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the disturbance of the plane; d1 stays zero."""
        nodes: GimbalsNodes = work.nodes
        phi, rate = row_of(work.x), omega[0] * row_of(work.y)
        sliding = rate - row_of(nodes.roll_rate)
        sway, lift = row_of(nodes.sway), row_of(nodes.lift)
        bend = gimbals_bend(self.law, phi, sliding, mode.direction, sway, lift)
        # Ẏ = −ωX + d₂, so d₂ = φ̈/ω + ωX
        store(work.d2, 0, fma(bend, 1.0 / omega[0], omega[0] * phi))

    def beyond(self, mode: Mode, omega: Omega, work: Work) -> Beyond:
        """Return whether the case turns over."""
        x = row_of(work.x)
        edge = first_below(OVER - larger(x, x), work)
        return Beyond(edge, NOWHERE, edge > 1.0, OVER)

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Outside) -> Instant:
        """Return the case at an instant; its angle is that in the ship, φ − ρ."""
        phi, rate = planes[0].x, omega[0] * planes[0].y
        sliding = rate + at.tilt.rate
        bend = gimbals_bend(self.law, phi, sliding, mode.direction, at.drive.value, at.gravity)
        return Instant(
            angle=phi + at.tilt.value,
            rate=sliding,
            bend=bend + at.tilt.bend,
            tension=1.0,
            margin=OVER - abs(phi),
            torque=0.0,
            coordinate=phi,
            speed=rate,
            acceleration=bend,
        )

    def drift(self, mode: Mode, omega: Omega, at: Outside, now: Instant) -> tuple[Plane, ...]:
        """Return φ̇ and φ̈."""
        return (Plane(now.speed, now.acceleration),)

    def set_off(self, omega: Omega, angle: float, at: Outside, state: RunningState) -> None:
        """Put the case at φ − ρ = angle, at rest in the ship: held, or about to slide."""
        self.rest_at(omega, angle, at, state)
        needed = holding(self.law, angle, at)
        state.held = abs(needed) <= term(self.law.friction, 1.0)
        if state.held:
            state.held_angle = angle
        elif needed != 0.0:
            # without the friction that would hold it, the case slides the other way
            state.direction = -1 if needed > 0.0 else 1

    def ride_along(self, run: SteppedRun, place: StepPlace) -> float:
        """Move the held case with the ship; return the fraction at which it breaks loose, or 1."""
        return ride_held(self, run, place, 2 * width(run.work.fractions))

    def breaks_loose(self, mode: Mode, angle: float, at: Outside) -> bool:
        """Return whether the case needs more friction than there is to rest at φ − ρ = angle."""
        return abs(holding(self.law, angle, at)) > term(self.law.friction, 1.0)

    def rest_at(self, omega: Omega, angle: float, at: Outside, state: RunningState) -> None:
        """Put the case at rest in the ship at φ − ρ = angle."""
        plane = state.planes[0]
        plane.x, plane.x_rest = angle - at.tilt.value, 0.0
        plane.y, plane.y_rest = -at.tilt.rate / omega[0], 0.0


@compiled
def holding(law: GimbalsLaw, angle: float, at: Outside) -> float:
    """Return the friction, over the moment of inertia, that holds φ = angle + ρ.

    There φ̈ = ρ̈, and the damping does nothing.
    """
    phi = angle - at.tilt.value
    turned = law.pull * (at.gravity * math.sin(phi) + at.drive.value * math.cos(phi))
    return turned - at.tilt.bend


class GimbalsSwing(SteppedSwing):
    """Propagator of a case in gimbals, at any angle.

    Args:
        pull: p = l/(k² + l²) [1/m], > 0.
        gravity: g at the start, which sets the rotating frame [m/s2].
        damping: 2ζω_c [1/s], ≥ 0.
        friction: f [rad/s2], ≥ 0.
        tolerance: of a step, relative to the state.
    """

    def __init__(
        self,
        pull: float,
        gravity: float,
        *,
        damping: float = 0.0,
        friction: float = 0.0,
        tolerance: float | None = None,
    ) -> None:
        self._law = GimbalsLaw(pull, damping or None, friction or None)
        omega = math.sqrt(pull * gravity)
        super().__init__(GimbalsCase(self._law, omega), (omega,), GIMBALS_NODES, SIZE, tolerance)

    def release(
        self, sway: float, lift: float, roll: float = 0.0, roll_rate: float = 0.0
    ) -> float:
        """Start at rest along the apparent vertical, while the ship may roll."""
        tilt = math.atan2(-sway, lift)
        state = self._state = np.zeros((), state_type(1))
        state['planes']['x'] = tilt
        state['side'] = state['pallet'] = 1
        state['direction'] = -1 if roll_rate > 0.0 else 1
        if self._law.friction and roll_rate == 0.0:
            state['held'], state['held_angle'] = True, tilt - roll
        return tilt

    def bend_at_rest(self, roll_rate: float) -> float:
        """Return φ̈ of a case that hangs at rest in a ship with ρ̇ [rad/s2]."""
        damping, friction = self._law.damping or 0.0, self._law.friction or 0.0
        return damping * roll_rate + friction * float(np.sign(roll_rate))

    def advance(self, bearing: BearingMotion) -> CaseMotion:
        """Return the motion at the ends of the parts.

        Raises a PropagationError if the case turns over, or no step converges.
        """
        rows, (sway, lift) = self._rows(bearing), bearing.at_ends()
        names = 'coordinate', 'speed', 'acceleration'
        phi, rate, bend = map(np.ascontiguousarray, map(rows.__getitem__, names))
        return CaseMotion(phi, phi, rate, rate, sway, lift, bend)
