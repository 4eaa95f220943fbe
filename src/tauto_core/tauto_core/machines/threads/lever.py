"""Sully's machine: the thread pulls a lever that carries the weight.

The thread is tied to a point of the lever, as Euler reports it (1727, V), or lies on an arc of the
lever, as Sully built it (Académie 1724).

One degree of freedom. With the lever's angle β(θ) of `lever_geometry`, the weight m at the
distance AD from the fulcrum, a tail weight m′ at AE beyond it and J = m AD² + m′AE² + J_lever,

    M(θ) = I + J (dβ/dθ)²,    V(θ) = (m AD − m′AE) g sin β.

It is not isochronous with the involute. The well is not even, so the two turning points differ.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from tauto_core.curves.cam import possible_lever
from tauto_core.curves.lever_geometry import LeverLinkage, LeverSetting, Loads, MirroredLever
from tauto_core.curves.numerics import integrate
from tauto_core.machines.heat import NO_HEAT, Heat
from tauto_core.machines.parts import DragKind, EscapementKind, PowerKind
from tauto_core.machines.trochlea import Parts, ThreadKind
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import ABSENT, CamRangeError, Problem
from tauto_core.scene.sections import NonNegative, Positive, Section


@dataclass(frozen=True)
class LeverMachine:
    """Sully's lever machine as numbers.

    Attributes:
        inertia: I of the wheel about its axle [kg m2], > 0.
        mass: m of the weight [kg]; 0 where a force pulls the lever.
        weight_arm: AD, from the fulcrum to the weight or to the force [m], > 0.
        lever_inertia: moment of inertia of the lever itself about its fulcrum, at which it is
            balanced [kg m2], ≥ 0.
        geometry: cam, thread and lever.
        gravity: g [m/s2].
        drag: torques against the motion in the case, or None.
        escapement: the escapement, or None.
        release_angle: angle of release of the wheel in its case, at rest at the start [rad].
        tail: mass [kg] and distance from the fulcrum [m] of the weight on the lever's tail.
        heat: how the numbers change with temperature and age; wheel, cam, lever and thread grow
            alike.
        stops_when_slack: whether the motion ends where the thread goes slack.
        force: P, a pull without mass from far off in the case, along its vertical [N]; 0 for a
            weight.
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

    limited_by = 'what the thread allows,'

    @property
    def follows_apparent_vertical(self) -> bool:
        """Whether the direction of the apparent vertical acts on it: on a weight."""
        return self.mass > 0.0

    @property
    def feels_gravity(self) -> bool:
        """Whether the strength of the apparent gravity acts on it: on a weight."""
        return self.mass > 0.0

    def at_celsius(self, celsius: float, time_s: float = 0.0) -> LeverMachine:
        """Return the machine as it is at a temperature [°C], a time after the start [s].

        It does not change with temperature any more. Its geometry is the same, since β(θ) depends
        on ratios of lengths alone. A compensation is in the masses; J is as without it.
        """
        factors = self.heat.factors(np.asarray(celsius), np.asarray(time_s))
        grown = math.sqrt(float(factors.inertia))
        # `kept` scales the pull by the masses. J must not change with a compensation, so the lever
        # takes the moment of inertia that the scaled masses lose.
        kept = float(factors.weight) / grown
        of_weights = self.turned_inertia - self.lever_inertia
        return replace(
            self,
            inertia=self.inertia * grown * grown,
            mass=kept * self.mass,
            weight_arm=grown * self.weight_arm,
            lever_inertia=grown * grown * (self.lever_inertia + (1.0 - kept) * of_weights),
            drag=None if self.drag is None else self.drag.thinned(float(factors.viscous)),
            tail=(kept * self.tail[0], grown * self.tail[1]),
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
        """m AD − m′AE, of the weight less that of the tail weight; P AD/g of a force [kg m]."""
        moment = self.mass * self.weight_arm - self.tail[0] * self.tail[1]
        return moment + self.force * self.weight_arm / self.gravity

    @property
    def weight_torque(self) -> float:
        """Torque about the fulcrum, the lever level: (m AD − m′AE) g on land, or P AD [N m]."""
        mass, distance = self.tail
        torque = self.mass * self.gravity * self.weight_arm - mass * self.gravity * distance
        return torque + self.force * self.weight_arm

    @property
    def frequency(self) -> float:
        """Small-amplitude ω on land, √(m g (AD/AB) r (1 + r/l₀)/I) [rad/s]."""
        shape = self.geometry
        stiffness = shape.base_radius / shape.arm * (shape.depth / shape.length)
        return math.sqrt(self.weight_torque * stiffness / self.inertia)

    @property
    def small_period(self) -> float:
        """Small-amplitude period on land, 2π/ω [s]."""
        return math.tau / self.frequency

    @cached_property
    def sides(self) -> tuple[float, float]:
        """Least and largest θ that the geometry allows [rad]."""
        low, high = self.geometry.theta(np.array(self.geometry.edges)).tolist()
        return low, high

    @property
    def range_rad(self) -> float:
        """Largest |θ| that the geometry allows on both sides [rad]."""
        return min(-self.sides[0], self.sides[1])

    def felt_angle(self, angle: float, tilt: float) -> float:
        """Return the angle that `range_rad` bounds: θ, since the lever is fixed in the case."""
        del tilt
        return angle

    def wider_range(self, amplitude: float) -> str:
        """Return the change that widens the range to an amplitude, as the end of a sentence."""

        def of_mass(mass: float) -> tuple[float, float]:
            heavier = replace(self, mass=mass)
            return heavier.weight_torque, heavier.turned_inertia

        loads = Loads(self.mass, self.small_period, of_mass)
        return self.geometry.wider(amplitude, loads)

    def with_inertia(self, inertia: float) -> LeverMachine:
        """Return the machine with another wheel [kg m2], and with the cam made for that."""
        return replace(self, inertia=inertia, geometry=self.geometry.of_inertia(inertia))

    def beta(self, angle: ArrayLike) -> FloatArray:
        """Return β of the lever [rad]."""
        return self.geometry.pose(self._tau(angle)).beta

    def ratio(self, angle: ArrayLike) -> FloatArray:
        """Return dβ/dθ."""
        return self.geometry.slopes(self._tau(angle))[0]

    def ratio_rate(self, angle: ArrayLike) -> FloatArray:
        """Return d²β/dθ² [1/rad]."""
        return self.geometry.slopes(self._tau(angle))[1]

    def mass_at(self, angle: ArrayLike) -> FloatArray:
        """Return M(θ) [kg m2]."""
        ratio = self.ratio(angle)
        return self.inertia + self.turned_inertia * ratio * ratio

    def potential(self, angle: ArrayLike) -> FloatArray:
        """Return V(θ), on land [J]."""
        return self.weight_torque * np.sin(self.beta(angle))

    def arc(self, angle: ArrayLike) -> FloatArray:
        """Return s(θ) = ∫√M dθ from 0 [√kg m], with the sign of θ.

        As an integral over τ, √(I θ_τ² + J β_τ²) has no singularity at a dead point.
        """
        tau = np.atleast_1d(self._tau(angle))
        return integrate(self.arc_slope, np.zeros(tau.size), tau.ravel()).reshape(np.shape(angle))

    def arc_slope(self, tau: FloatArray) -> FloatArray:
        """Return ds/dτ [√kg m]."""
        theta, beta = self.geometry.rates(tau)
        return np.hypot(math.sqrt(self.inertia) * theta, math.sqrt(self.turned_inertia) * beta)

    def swing(self, amplitude: float, w: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return τ and dt/dW along a swing released at rest at A ≠ 0, for any W in [0, π].

        V = V(A) cos²W runs once through the swing as W goes from 0 to π. With Y = ±√V, of the sign
        of θ, dt/dW = √(M/2)/(dY/dθ); 2 Y/τ and dV/(τ dθ) do not vanish at rest.
        """
        shape, cosine = self.geometry, np.cos(w)
        top = float(np.sin(self.beta(amplitude)))
        sine = top * cosine * cosine
        side = math.copysign(1.0, amplitude) * np.where(cosine < 0.0, -1.0, 1.0)
        tau = side * _tau_of_sine(sine)
        _, beta, delta, _ = shape.pose(tau)
        slope, _ = shape.slopes(tau)
        mass = self.inertia + self.turned_inertia * slope * slope
        pushed = self.weight_torque * np.cos(beta)
        square = tau * tau
        root = np.sqrt(2.0 * self.weight_torque / (1.0 + square * square))
        pulled = shape.arm * shape.pull_cosine(beta, delta)
        per_tau = shape.base_radius * shape.u_per_tau(tau) / pulled
        return tau, np.sqrt(2.0 * mass) * root / (pushed * per_tau)

    def angle_of_potential(self, potential: float) -> float:
        """Return θ ≥ 0 at which V is `potential` [J], at most the end of the geometry."""
        sine = np.array(min(potential / self.weight_torque, 1.0))
        tau = min(float(_tau_of_sine(sine)), self.geometry.edges[1])
        return float(self.geometry.theta(np.array([tau]))[0])

    def far_turning(self, amplitude: float) -> float:
        """Return θ at the other end of a free swing released at `amplitude` [rad]."""
        return float(self.geometry.theta(self.swing(amplitude, np.array([math.pi]))[0])[0])

    def period(self, amplitude: float) -> float:
        """Return the period of free swings on land, without drag [s].

        The sign of the amplitude matters, since the well is not even; 0 gives the limit 2π/ω. The
        thread stays taut, since W cos β + J β″θ̇² > 0: within the geometry β″ > 0.
        CamRangeError: an amplitude, or its far turning point, beyond the geometry.
        """
        if amplitude == 0.0:
            return self.small_period
        self._within(np.asarray(amplitude))
        # V is even in τ, so that the swing turns at −τ on the other side
        far = -float(self.geometry.tau_of(np.asarray(amplitude)))
        low, high = self.geometry.edges
        if not low <= far <= high:
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
                f'the angle {worst!r} rad lies beyond the lever geometry, which reaches from '
                f'{low:.6g} to {high:.6g} rad: there the lever is all but in line with the '
                'thread, or the thread is wound up. Use a smaller angle or a longer lever'
            )
        return angle


def _tau_of_sine(sine: FloatArray) -> FloatArray:
    """Return |τ| = √tan(β/2) of sin β."""
    # tan(β/2) = sin β/(1 + cos β); cos² β as a product keeps its digits near a dead point
    return np.asarray(np.sqrt(sine / (1.0 + np.sqrt((1.0 - sine) * (1.0 + sine)))))


class Tail(Section):
    """The small weight on the lever's tail, beyond the fulcrum."""

    mass: Positive = Field(description='mass [kg]')
    distance: Positive = Field(description='distance from the fulcrum [m]')


class LeverThread(ThreadKind):
    """Thread that pulls a lever, level at rest, which carries the weight or is pulled by a force.

    With `arc` it lies on an arc of the lever, as Sully built it (1724); with `arm` it is tied to a
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
        'Euler reports it; this or arc',
    )
    arc: Positive | None = Field(
        default=None,
        description='radius of the arc about the fulcrum to which the thread is tangent [m], as '
        'Sully built it; this or arm',
    )
    weight_arm: Positive = Field(description='distance from the fulcrum to the weight [m]')
    length: Positive = Field(description='free length of the thread at rest [m]')
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
        """Yield what is wrong between its keys, or not compatible with a lever."""
        yield from super().problems(power, drag, escapement)
        if (self.arm is None) == (self.arc is None):
            both = self.arm is not None
            yield Problem(
                'trochlea.thread.arc' if both else 'trochlea.thread.arm',
                self.arc if both else ABSENT,
                'does not go with trochlea.thread.arm' if both else 'is missing, and so is arc',
                'Give arm for a thread tied to a point of the lever (Euler), or arc for one that '
                'lies on an arc about the fulcrum (Sully).',
            )
        if power.acts_as == 'force' and not power.pull.pulling_mass:
            if self.inertia == 0.0:
                yield Problem(
                    'trochlea.thread.inertia',
                    0.0,
                    f'does not go with trochlea.power.kind {power.kind}: then only the lever '
                    'itself has inertia',
                    "Give the lever's moment of inertia about the fulcrum, such as 1.0e-6.",
                )
            if self.tail is not None:
                yield Problem(
                    'trochlea.thread.tail.mass',
                    self.tail.mass,
                    f'does not go with trochlea.power.kind {power.kind}, which feels no gravity',
                    'Leave out trochlea.thread.tail, or use power kind weight.',
                )
            return
        if self.tail is not None:
            moment = power.pull.carried_mass * self.weight_arm
            if not self.tail.mass * self.tail.distance < moment:
                yield Problem(
                    'trochlea.thread.tail.mass',
                    self.tail.mass,
                    f'at {self.tail.distance!r} m outweighs the weight, whose moment is '
                    f'{moment:.6g} kg m, so that nothing keeps the thread taut',
                    f'Use less than {moment / self.tail.distance:.4g} kg.',
                )

    def machine(self, parts: Parts) -> LeverMachine:
        """Return the lever machine; SceneError: a cam that is not compatible with a lever."""
        mass, force, tail = parts.power.pull.carried_mass, parts.power.pull.force, self.tail
        beyond = (0.0, 0.0) if tail is None else (tail.mass, tail.distance)
        balance = beyond[0] * parts.gravity * beyond[1]
        lever = LeverSetting(
            inertia=parts.inertia,
            weight_torque=(mass * parts.gravity + force) * self.weight_arm - balance,
            turned_inertia=mass * self.weight_arm**2 + self.inertia + beyond[0] * beyond[1] ** 2,
            arm=self.pulled_at,
            length=self.length,
            on_arc=self.arc is not None,
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
            tail=beyond,
            heat=parts.heat,
            force=force,
        )


KIND = LeverThread
