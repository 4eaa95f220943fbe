"""Sully's machine: the thread pulls a lever that carries the weight.

The thread is tied to a point of the lever, as Euler reports it (1727, V), or wraps an arc of the
lever, as Sully built it (Académie 1724).

One degree of freedom. With the lever's angle β(θ) of `lever_geometry`, β₀ at rest, the weight m at
the distance AD from the fulcrum, a tail weight m′ at AE beyond it and J = m AD² + m′AE² + J_lever,

    M(θ) = I + J (dβ/dθ)²,    V(θ) = (m AD − m′AE) g (sin β − sin β₀).

A force F without mass may pull the end of the lever from far off. With the draw H = AD (sin β −
sin β₀) it has V = ∫ F dH, from 0 to H, and J = J_lever.

On the involute it is not isochronous. The well is not even: the two turning points differ.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, Strict

from tauto_core.curves.cam import LEAST_POINTS, ForceLaw, Pull, possible_lever
from tauto_core.curves.lever_geometry import LeverLinkage, LeverSetting, MirroredLever
from tauto_core.curves.numerics import integrate
from tauto_core.machines.heat import NO_HEAT, Heat
from tauto_core.machines.parts import DragKind, EscapementKind, PowerKind, wrong
from tauto_core.machines.trochlea import Parts, ThreadKind
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import ABSENT, CamRangeError, Problem
from tauto_core.scene.sections import NonNegative, Positive, Section


@dataclass(frozen=True)
class LeverMachine:
    """Sully's lever machine as numbers.

    Attributes:
        inertia: I of the wheel about its axle [kg m2], > 0.
        mass: m of the weight [kg], 0 if a force pulls the lever.
        weight_arm: AD, from the fulcrum to the weight or to the force [m], > 0.
        lever_inertia: moment of inertia of the balanced lever itself about its fulcrum [kg m2],
            ≥ 0.
        geometry: cam, thread and lever.
        gravity, drag, escapement, release_angle, stops_when_slack: as in `Machine`.
        tail: mass [kg] and distance from the fulcrum [m] of the weight on the lever's tail.
        heat: changes with temperature and age. Wheel, cam, lever and thread grow alike.
        force: P, a pull without mass at the lever at rest, from far off along the case's vertical
            [N], 0 for a weight.
        law: dependence of that pull on the draw, unless it is constant. It is scaled to P at
            rest.
    """

    inertia: float
    mass: float
    weight_arm: float
    lever_inertia: float
    geometry: LeverLinkage
    gravity: float
    drag: DragKind | None
    escapement: EscapementKind | None
    release_angle: float
    tail: tuple[float, float] = (0.0, 0.0)
    heat: Heat = NO_HEAT
    stops_when_slack: bool = False
    force: float = 0.0
    law: ForceLaw | None = None

    limited_by = 'the range of the thread,'

    @property
    def follows_apparent_vertical(self) -> bool:
        """Whether the direction of the apparent vertical acts on it, through a weight."""
        return self.mass > 0.0

    feels_gravity = follows_apparent_vertical
    """Whether the strength of the apparent gravity acts on it, through a weight."""

    def at_celsius(self, celsius: float, time_s: float = 0.0) -> LeverMachine:
        """Return the machine with its parameters at this temperature [°C] and time [s].

        The result has constant parameters. Its geometry is the same, since β(θ) depends only on
        ratios of lengths. A compensation scales the masses but not J.
        """
        factors = self.heat.factors(np.asarray(celsius), np.asarray(time_s))
        grown = math.sqrt(float(factors.inertia))
        # A compensation scales the pull by the masses but must not change J: the lever takes the
        # moment of inertia that the scaled masses lose.
        share = float(factors.weight) / grown
        of_weights = self.turned_inertia - self.lever_inertia
        return replace(
            self,
            inertia=self.inertia * grown * grown,
            mass=share * self.mass,
            weight_arm=grown * self.weight_arm,
            lever_inertia=grown * grown * (self.lever_inertia + (1.0 - share) * of_weights),
            drag=None if self.drag is None else self.drag.thinned(float(factors.viscous)),
            tail=(share * self.tail[0], grown * self.tail[1]),
            heat=Heat(celsius),
            force=float(factors.force) / grown * self.force,
        )

    @property
    def turned_inertia(self) -> float:
        """J, moment of inertia of weight and lever about the fulcrum [kg m2]."""
        mass, distance = self.tail
        return self.mass * self.weight_arm**2 + self.lever_inertia + mass * distance**2

    @property
    def moment(self) -> float:
        """m AD − m′AE of the weights, or P AD/g of a force [kg m]."""
        moment = self.mass * self.weight_arm - self.tail[0] * self.tail[1]
        return moment + self.force * self.weight_arm / self.gravity

    @property
    def weight_torque(self) -> float:
        """Torque about the fulcrum with a level lever: (m AD − m′AE) g on land, or P AD [N m]."""
        mass, distance = self.tail
        torque = self.mass * self.gravity * self.weight_arm - mass * self.gravity * distance
        return torque + self.force * self.weight_arm

    @property
    def frequency(self) -> float:
        """Small-amplitude ω on land, √(m g (AD/AB) r (1 + r/l₀)/I) [rad/s].

        On an arc AD is multiplied by cos β₀.
        """
        shape = self.geometry
        stiffness = shape.base_radius / shape.arm * (shape.depth / shape.length)
        if shape.inclination:
            start = np.array([shape.inclination])
            stiffness *= float((np.cos(start) / shape.pull_cosine(start, np.zeros(1)))[0])
        return math.sqrt(self.weight_torque * stiffness / self.inertia)

    @property
    def small_period(self) -> float:
        """Small-amplitude period on land, 2π/ω [s]."""
        return math.tau / self.frequency

    @cached_property
    def edges(self) -> tuple[float, float]:
        """Least and largest τ, limited by the geometry or by the points of the force."""
        low, high = self.geometry.edges
        if self.law is not None:
            longest = np.array(self.law.longest / self.weight_arm)
            if longest < self._risen(np.array(max(-low, high))):
                end = float(self._tau_of_risen(longest))
                return max(low, -end), min(high, end)
        return low, high

    @cached_property
    def sides(self) -> tuple[float, float]:
        """Least and largest θ that geometry and force allow [rad]."""
        low, high = self.geometry.theta(np.array(self.edges)).tolist()
        return low, high

    @property
    def range_rad(self) -> float:
        """Largest |θ| that geometry and force allow on both sides [rad]."""
        return min(-self.sides[0], self.sides[1])

    def sensed_angle(self, angle: float, tilt: float) -> float:
        """Return the angle that `range_rad` bounds: θ, since the lever turns with the case."""
        return angle

    @property
    def widening(self) -> str:
        """The change that widens the range, as the end of a sentence."""
        drawn = '' if self.law is None else ', or give trochlea.power.points up to a larger draw'
        return f'{drawn}{self.geometry.widening}'

    def beta(self, angle: ArrayLike) -> FloatArray:
        """Return β of the lever [rad]."""
        return self.geometry.pose(self._tau(angle)).beta

    def ratio(self, angle: ArrayLike) -> FloatArray:
        """Return dβ/dθ."""
        return self.geometry.slopes(self._tau(angle))[0]

    def mass_at(self, angle: ArrayLike) -> FloatArray:
        """Return M(θ) [kg m2]."""
        ratio = self.ratio(angle)
        return self.inertia + self.turned_inertia * ratio * ratio

    def potential(self, angle: ArrayLike) -> FloatArray:
        """Return V(θ) on land, V(0) = 0 [J]."""
        return self.weight_torque * self._energy(self._risen(self._tau(angle)))

    def pushed(self, tau: FloatArray) -> FloatArray:
        """Return dV/dβ, the torque about the fulcrum on land [N m]."""
        cosine = np.cos(self.geometry.pose(tau).beta)
        return np.asarray(self.weight_torque * cosine * self.strength(tau))

    def strength(self, tau: FloatArray) -> FloatArray:
        """Return the pull over the pull at rest: 1, or F(H)/F(0)."""
        if self.law is None:
            return np.ones_like(tau)
        drawn = self.weight_arm * self._risen(tau)
        return self.law.force(np.minimum(drawn, self.law.longest)) / self.law.at_rest

    def _risen(self, tau: FloatArray) -> FloatArray:
        """Return H/AD = sin β − sin β₀."""
        angle, start = np.arctan(tau * tau), self.geometry.inclination
        versine = 2.0 * np.sin(angle) ** 2
        return np.asarray(math.cos(start) * np.sin(2.0 * angle) - math.sin(start) * versine)

    def _tau_of_risen(self, risen: FloatArray) -> FloatArray:
        """Return |τ| of H/AD, to rounding."""
        start = self.geometry.inclination
        cosine, sine = math.cos(start), math.sin(start)
        # cos² β, as a product that keeps its digits near a dead point of a level lever
        square = (cosine - risen) * (cosine + risen) - 2.0 * sine * risen
        return np.asarray(np.sqrt(risen / (cosine + np.sqrt(np.maximum(square, 0.0)))))

    def _energy(self, risen: FloatArray) -> FloatArray:
        """Return V over the torque at rest with a level lever, of H/AD."""
        if self.law is None:
            return risen
        drawn = np.minimum(self.weight_arm * risen, self.law.longest)
        return np.asarray(self.law.energy(drawn) / (self.weight_arm * self.law.at_rest))

    def _risen_of_energy(self, energy: FloatArray) -> FloatArray:
        """Return H/AD of `_energy`."""
        if self.law is None:
            return energy
        drawn = self.law.lift_of_energy(energy * (self.weight_arm * self.law.at_rest))
        return np.asarray(drawn / self.weight_arm)

    def arc(self, angle: ArrayLike) -> FloatArray:
        """Return s(θ) = ∫√M dθ from 0 [√kg m], with the sign of θ.

        The integral over τ, of √(I θ_τ² + J β_τ²), has no singularity at a dead point.
        """
        tau = np.atleast_1d(self._tau(angle))
        return integrate(self.arc_slope, np.zeros(tau.size), tau.ravel()).reshape(np.shape(angle))

    def arc_slope(self, tau: FloatArray) -> FloatArray:
        """Return ds/dτ [√kg m]."""
        theta, beta = self.geometry.rates(tau)
        return np.hypot(math.sqrt(self.inertia) * theta, math.sqrt(self.turned_inertia) * beta)

    def swing(self, amplitude: float, w: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return τ and dt/dW along a swing released at rest at A ≠ 0, for any W in [0, π].

        V = V(A) cos²W: W goes from 0 to π once through the swing. With Y = ±√V, of the sign of θ,
        dt/dW = √(M/2)/(dY/dθ). 2 Y/τ and dV/(τ dθ) do not vanish at rest.
        """
        shape, cosine = self.geometry, np.cos(w)
        top = float(self._energy(self._risen(self._tau(amplitude))))
        energy = top * cosine * cosine
        risen = self._risen_of_energy(energy)
        side = math.copysign(1.0, amplitude) * np.where(cosine < 0.0, -1.0, 1.0)
        tau = side * self._tau_of_risen(risen)
        _, beta, delta, _ = shape.pose(tau)
        slope, _ = shape.slopes(tau)
        mass = self.inertia + self.turned_inertia * slope * slope
        pushed = self.pushed(tau)
        # V/τ²: the torque at rest times the mean of `strength`
        square, start = tau * tau, shape.inclination
        per_square = math.cos(start) - square * math.sin(start)
        mean = np.divide(energy, risen, np.ones_like(risen), where=risen > 0.0)
        root = np.sqrt(2.0 * self.weight_torque * per_square * mean / (1.0 + square * square))
        pulled = shape.arm * shape.pull_cosine(beta, delta)
        per_tau = shape.base_radius * shape.u_per_tau(tau) / pulled
        return tau, np.sqrt(2.0 * mass) * root / (pushed * per_tau)

    def angle_of_potential(self, potential: float) -> float:
        """Return θ ≥ 0 at which V is `potential` [J], at most the end of the geometry."""
        edge = self.edges[1]
        top = float(self._energy(self._risen(np.asarray(edge))))
        energy = np.array([min(potential / self.weight_torque, top)])
        tau = min(float(self._tau_of_risen(self._risen_of_energy(energy))[0]), edge)
        return float(self.geometry.theta(np.array([tau]))[0])

    def far_turning(self, amplitude: float) -> float:
        """Return θ at the other end of a free swing released at `amplitude` [rad]."""
        return float(self.geometry.theta(self.swing(amplitude, np.array([math.pi]))[0])[0])

    def period(self, amplitude: float) -> float:
        """Return the period of free swings on land, without drag [s].

        The sign of the amplitude matters, since the well is not even. 0 gives the limit 2π/ω. The
        thread stays taut, since W cos β + J β″θ̇² > 0: within the geometry β″ > 0.
        CamRangeError: an amplitude, or its far turning point, beyond the geometry.
        """
        if amplitude == 0.0:
            return self.small_period
        self._within(np.asarray(amplitude))
        # V is even in τ: the swing turns at −τ on the other side
        tau = -float(self.geometry.tau_of(np.asarray(amplitude)))
        low, high = self.edges
        if not low <= tau <= high:
            raise CamRangeError(
                f'a swing from {amplitude!r} rad goes beyond the lever geometry on the other '
                f'side: it reaches from {self.sides[0]:.6g} to {self.sides[1]:.6g} rad. Use a '
                'smaller amplitude or a longer lever'
            )
        edges = np.array([0.0, 0.5 * math.pi, math.pi])
        halves = integrate(lambda w: self.swing(amplitude, w)[1], edges[:-1], edges[1:])
        return 2.0 * float(np.sum(halves))

    def _tau(self, angle: ArrayLike) -> FloatArray:
        return self.geometry.tau_of(self._within(np.asarray(angle, np.float64)))

    def _within(self, angle: FloatArray) -> FloatArray:
        low, high = self.sides
        if not np.all((angle >= low) & (angle <= high)):
            worst = float(np.ravel(angle)[np.argmax(np.abs(np.ravel(angle)))])
            raise CamRangeError(
                f'the angle {worst!r} rad is beyond the lever geometry, which reaches from '
                f'{low:.6g} to {high:.6g} rad: there the lever is almost in line with the thread, '
                'or the thread is wound up. Use a smaller angle or a longer lever'
            )
        return angle


STEEPEST = 1.2
"""Largest inclination of a lever at rest, to either side [rad]: twenty degrees from upright."""


class Tail(Section):
    """The small weight on the lever's tail, beyond the fulcrum."""

    mass: Positive = Field(description='mass [kg]')
    distance: Positive = Field(description='distance from the fulcrum [m]')


class LeverThread(ThreadKind):
    """Thread that pulls a lever, which carries the weight or is pulled by a force or a spring.

    With `arc` it wraps an arc of the lever, as Sully built it (1724). With `arm` it is tied to a
    point, as Euler reports it (1727, V).
    """

    moves_the_weight = True
    grows_alike = True
    takes_a_force = True
    rank = 3
    starter = {'arm': 0.1, 'weight_arm': 0.1, 'length': 0.3}

    kind: Literal['lever'] = 'lever'
    arm: Positive | None = Field(
        default=None,
        description='distance from the fulcrum to the point where the thread is tied [m], as '
        'Euler reports it (this or arc)',
    )
    arc: Positive | None = Field(
        default=None,
        description='radius of the arc about the fulcrum to which the thread is tangent [m], as '
        'Sully built it (this or arm)',
    )
    weight_arm: Positive = Field(description='distance from the fulcrum to the weight [m]')
    length: Positive = Field(description='free length of the thread at rest [m]')
    inclination: Annotated[float, Strict(), Field(ge=-STEEPEST, le=STEEPEST)] = Field(
        default=0.0,
        description='angle of the lever above the level at rest [rad], '
        f'-{STEEPEST:g} to {STEEPEST:g}, or angle of the arm with the weight for an arc',
    )
    inertia: NonNegative = Field(
        default=0.0, description="the lever's own moment of inertia about the fulcrum [kg m2]"
    )
    fulcrum: Literal['starboard', 'port'] = Field(
        default='starboard', description='side of the thread on which the fulcrum is'
    )
    tail: Tail | None = Field(default=None, description='mapping: mass, distance')

    @property
    def pulled_at(self) -> float:
        """AB, from the fulcrum to the thread at rest [m]."""
        return (self.arm if self.arc is None else self.arc) or 0.0

    def problems(
        self, power: PowerKind, drag: DragKind | None, escapement: EscapementKind | None
    ) -> Iterator[Problem]:
        """Yield contradictions between its keys, and keys that a lever excludes."""
        yield from super().problems(power, drag, escapement)
        has_arm, is_force, tail = self.arm is not None, not power.pull.pulling_mass, self.tail
        kind = f'does not go with trochlea.power.kind {power.kind}'
        yield from wrong(
            (
                has_arm == (self.arc is not None),
                'trochlea.thread.arc' if has_arm else 'trochlea.thread.arm',
                self.arc if has_arm else ABSENT,
                'does not go with trochlea.thread.arm' if has_arm else 'is missing, and so is arc',
                'Give arm for a thread tied to a point of the lever (Euler), or arc for one that '
                'wraps an arc about the fulcrum (Sully).',
            ),
            (
                is_force and self.inertia == 0.0,
                'trochlea.thread.inertia',
                0.0,
                f'{kind}: then only the lever itself has inertia',
                "Give the lever's moment of inertia about the fulcrum, such as 1.0e-6.",
            ),
        )
        if tail is None:
            return
        moment = power.pull.carried_mass * self.weight_arm
        yield from wrong(
            (
                is_force,
                'trochlea.thread.tail.mass',
                tail.mass,
                f'{kind}, on which gravity does not act',
                'Leave out trochlea.thread.tail, or use power kind weight.',
            ),
            (
                not is_force and not tail.mass * tail.distance < moment,
                'trochlea.thread.tail.mass',
                tail.mass,
                f'at {tail.distance!r} m outweighs the weight, which has a moment of '
                f'{moment:.6g} kg m, and the thread would go slack',
                f'Use less than {moment / tail.distance:.4g} kg.',
            ),
        )

    def machine(self, parts: Parts) -> LeverMachine:
        """Return the lever machine. SceneError: a cam that does not go with a lever."""
        pull, tail = parts.power.pull, self.tail
        mass, force, law = pull.carried_mass, pull.force, self._law(pull)
        tip = (0.0, 0.0) if tail is None else (tail.mass, tail.distance)
        balance = tip[0] * parts.gravity * tip[1]
        lever = LeverSetting(
            inertia=parts.inertia,
            weight_torque=(mass * parts.gravity + force) * self.weight_arm - balance,
            turned_inertia=mass * self.weight_arm**2 + self.inertia + tip[0] * tip[1] ** 2,
            arm=self.pulled_at,
            length=self.length,
            on_arc=self.arc is not None,
            inclination=self.inclination,
            varies=law is not None,
        )
        shape = possible_lever(parts.cam.on_lever(lever), parts.cam.kind)
        return LeverMachine(
            inertia=parts.inertia,
            mass=mass,
            weight_arm=self.weight_arm,
            lever_inertia=self.inertia,
            geometry=MirroredLever(shape) if self.fulcrum == 'port' else shape,
            gravity=parts.gravity,
            drag=parts.drag,
            escapement=parts.escapement,
            release_angle=parts.release_angle,
            tail=tip,
            heat=parts.heat,
            stops_when_slack=law is not None,
            force=force,
            law=law,
        )

    def _law(self, pull: Pull) -> ForceLaw | None:
        """Return the law of a pull over the draw of the lever's end, unless it is constant."""
        if not pull.stiffness:
            return pull.law
        # the end of a lever rises no farther
        draws = 2.0 * self.weight_arm * np.linspace(0.0, 1.0, LEAST_POINTS)
        force = pull.force + pull.stiffness * draws
        return ForceLaw(tuple(zip(draws.tolist(), force.tolist(), strict=True)))


KIND = LeverThread
