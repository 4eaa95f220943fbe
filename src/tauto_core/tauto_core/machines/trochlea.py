"""The trochlea as a mechanism, a wheel with its cam and a power, and the base of all threads.

I ψ̈ + m h'(ϑ) d²h/dt² + F h'(ϑ) = torques, with h the lift and F the pull: P + κh for a force or a
spring, m g_eff for a weight (machine_at_sea.md, Euler 1727, XVI–XX). In a case at rest the wheel
moves in a well V(ϑ) = ∫ F h' dϑ with the varying inertia M(ϑ) = I + m h'².
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves.cam import Cam, CamKind, Setting, possible_cam
from tauto_core.curves.numerics import bracketed_newton, gauss_sums, integrate, root_of
from tauto_core.machines.heat import NO_HEAT, Heat
from tauto_core.machines.parts import (
    DragKind,
    EscapementKind,
    Imbalance,
    PowerKind,
    wrong,
)
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import CamRangeError, Problem, SceneError, TautoError
from tauto_core.scene.sections import Kind


class SlackThreadError(TautoError):
    """A swing in which the thread would have to push."""


@dataclass(frozen=True)
class Machine:
    """A trochlea as numbers.

    Attributes:
        inertia: I of the wheel about its axle [kg m2], > 0.
        carried_mass: m in M = I + m t² [kg], 0 unless the inertia of a weight counts.
        pulling_mass: mass of the weight that pulls the thread [kg], 0 for a force or a spring.
        force: P, constant pull, or pull of a spring at zero draw [N], 0 for a weight.
        stiffness: κ of the spring [N/m], 0 without a spring.
        gravity: g [m/s2].
        cam: the cam, with its thread.
        follows_apparent_vertical: whether the thread's neutral line is the apparent vertical
            (γ = β: a weight on a vertical thread) instead of a line of the case (γ = α_c).
        drag: torques against the motion in the case, if any.
        escapement: the escapement, if any.
        release_angle: angle of the wheel in its case at release, from rest [rad].
        imbalance: imbalance of the wheel, if any. It makes the well neither harmonic nor even.
        heat: changes with temperature and age. The numbers above hold at `heat.at_celsius`.
        stops_when_slack: whether the motion ends when the thread goes slack.
    """

    inertia: float
    carried_mass: float
    pulling_mass: float
    force: float
    stiffness: float
    gravity: float
    cam: Cam
    follows_apparent_vertical: bool
    drag: DragKind | None
    escapement: EscapementKind | None
    release_angle: float
    imbalance: Imbalance | None = None
    heat: Heat = NO_HEAT
    stops_when_slack: bool = False

    limited_by: ClassVar[str] = 'the cam, whose range is'

    def at_celsius(self, celsius: float, time_s: float = 0.0) -> Machine:
        """Return the machine with its parameters at this temperature [°C] and time [s].

        The result has constant parameters. The cam is unchanged: masses, force and stiffness
        absorb the growth of the lever arm (heat.2), which leaves angles, rates, periods and
        torques right.
        """
        factors = self.heat.factors(np.asarray(celsius), np.asarray(time_s))
        inertia, carried, weight, force, stiffness, viscous = (float(factor) for factor in factors)
        drag = self.drag
        if drag is not None:
            drag = drag.thinned(viscous)
        imbalance = self.imbalance
        if imbalance is not None:
            imbalance = imbalance._replace(moment=imbalance.moment * math.sqrt(inertia))
        return replace(
            self,
            inertia=self.inertia * inertia,
            carried_mass=self.carried_mass * carried,
            pulling_mass=self.pulling_mass * weight,
            force=self.force * force,
            stiffness=self.stiffness * stiffness,
            drag=drag,
            imbalance=imbalance,
            heat=Heat(celsius),
        )

    @cached_property
    def frequency(self) -> float:
        """Small-amplitude angular frequency on land, ω = √(F(0) t'(0)/I) [rad/s].

        With an imbalance it is √(V″/M) at `rest_angle`. A cam without small swings gives it for
        the swing from the release angle, or from 1 rad.
        """
        if not self.has_small_swings:
            return math.tau / self.period(self.release_angle or 1.0)
        if self.imbalance is not None:
            # the difference errs by the square of the step, and by 1e-12 of rounding
            centre, step = self.rest_angle, 1e-4
            below, above = self._slope(centre + np.array([-step, step])).tolist()
            return math.sqrt((above - below) / (2.0 * step * float(self.mass(centre))))
        return math.sqrt(self._rest_pull * float(self.cam.lever_rate(0.0)) / self.inertia)

    @property
    def has_small_swings(self) -> bool:
        """Whether small swings have a period, which they lack on cheeks rooted in the axle."""
        return self.imbalance is not None or float(self.cam.lever_rate(0.0)) > 0.0

    @property
    def small_period(self) -> float:
        """Small-amplitude period on land, 2π/ω [s]."""
        return math.tau / self.frequency

    @property
    def is_harmonic(self) -> bool:
        """Whether the well is exactly harmonic in the arc, as on the power's isochronous cam."""
        stiffness = self.stiffness / self._rest_pull if self.stiffness else 0.0
        return self.imbalance is None and self.cam.suits == (
            self.carried_mass / self.inertia,
            stiffness,
        )

    @property
    def is_linear(self) -> bool:
        """Whether the torque on land is −I ω²ϑ: a harmonic well without a carried mass."""
        return self.is_harmonic and self.carried_mass == 0.0

    @property
    def range_rad(self) -> float:
        """Largest |ϑ|, which the cam sets [rad]."""
        return self.cam.range_rad

    @property
    def feels_gravity(self) -> bool:
        """Whether a weight pulls the thread, or the wheel is unbalanced."""
        return self.pulling_mass > 0.0 or self.imbalance is not None

    def sensed_angle(self, angle: float, tilt: float) -> float:
        """Return ϑ of the wheel at `angle` in its case, for a tilt of the apparent vertical."""
        return angle - tilt if self.follows_apparent_vertical else angle

    @property
    def widening(self) -> str:
        """The change that widens the range, as the end of a sentence."""
        return self.cam.widening

    def pull(self, lift: ArrayLike, apparent_gravity: ArrayLike | None = None) -> FloatArray:
        """Return F = P + κh + m g_eff [N] at the lift h, by default on land."""
        weight = self.gravity if apparent_gravity is None else np.asarray(apparent_gravity)
        return self.force + self.stiffness * np.asarray(lift) + self.pulling_mass * weight

    def potential(self, angle: ArrayLike) -> FloatArray:
        """Return V(ϑ) = P h + κh²/2 + m g h + the imbalance's part on land, V(0) = 0 [J]."""
        lift = self.cam.lift(angle)
        thread = lift * (self._rest_pull + 0.5 * self.stiffness * lift)
        if self.imbalance is None:
            return thread
        half_angle, (moment, direction) = 0.5 * np.asarray(angle), self.imbalance
        # cos φ₀ − cos(ϑ + φ₀)
        risen = 2.0 * np.sin(half_angle + direction) * np.sin(half_angle)
        return np.asarray(thread + moment * self.gravity * risen)

    def _slope(self, angle: FloatArray) -> FloatArray:
        """Return V′(ϑ), with an imbalance [N m]."""
        moment, direction = self.imbalance or (0.0, 0.0)
        pull = self.pull(self.cam.lift(angle)) * self.cam.lever_arm(angle)
        return np.asarray(pull + moment * self.gravity * np.sin(angle + direction))

    @cached_property
    def rest_angle(self) -> float:
        """ϑ at which the wheel rests on land [rad], 0 if it is balanced."""
        if self.imbalance is None:
            return 0.0
        # short of the end of the cam, where the lever arm may diverge
        end = min(math.pi, 0.999 * self.cam.range_rad)
        return root_of(lambda angle: float(self._slope(np.asarray(angle))), -end, end, 1e-16)

    def lift_of_potential(self, potential: ArrayLike) -> FloatArray:
        """Return the lift h at which V = P h + κh²/2 + m g h on land [m]."""
        pull, potential = self._rest_pull, np.asarray(potential)
        return 2.0 * potential / (pull + np.sqrt(pull * pull + 2.0 * self.stiffness * potential))

    def mass(self, angle: ArrayLike) -> FloatArray:
        """Return M(ϑ) = I + m t² [kg m2]."""
        arm = self.cam.lever_arm(angle)
        return self.inertia + self.carried_mass * arm * arm

    def arc(self, angle: ArrayLike) -> FloatArray:
        """Return s(ϑ) = ∫ √M dϑ from 0 [√kg m], odd in ϑ.

        With a linear lever arm and k = b√(m/I): s = √I/2 · (ϑ√(1 + k²ϑ²) + asinh(kϑ)/k). In a
        harmonic well s = √(2V)/ω.
        """
        angle = self.cam.within(angle)
        root = math.sqrt(self.inertia)
        if self.carried_mass == 0.0:
            return root * angle
        if self.is_harmonic:
            arc: FloatArray = np.sqrt(2.0 * self.potential(angle)) / self.frequency
            return np.copysign(arc, angle)
        rate = self.cam.linear_rate
        if rate is not None:
            k = rate * math.sqrt(self.carried_mass) / root
            return 0.5 * root * (angle * np.hypot(1.0, k * angle) + np.arcsinh(k * angle) / k)

        def slope(inner: FloatArray) -> FloatArray:
            return np.sqrt(self.mass(inner))

        # piece by piece: √M is not smooth at the joints of the cam
        flat = np.atleast_1d(np.abs(angle))
        edges = np.concatenate([[0.0], self.cam.joints])
        sums = np.concatenate([[0.0], np.cumsum(integrate(slope, edges[:-1], edges[1:]))])
        piece = np.searchsorted(edges, flat, side='right') - 1
        arc = sums[piece] + integrate(slope, edges[piece], flat)
        return np.copysign(arc.reshape(np.shape(angle)), angle)

    def angle_of_arc(self, arc: ArrayLike) -> FloatArray:
        """Return ϑ at which the arc in a harmonic well is s [√kg m], odd in s, V = ½ω²s²."""
        along: FloatArray = self.frequency * np.asarray(arc, dtype=np.float64)
        lift = self.lift_of_potential(0.5 * along * along)
        return np.copysign(self.cam.angle_of_lift(lift), along)

    def period(self, amplitude: float) -> float:
        """Return the period of free swings on land, without drag [s].

        T = 4 ∫ √(M/(2(V(A) − V(ϑ)))) dϑ from 0 to A. With V(ϑ) = V(A) sin²u the integrand 4 √(2
        V(A) M) sin u/V'(ϑ) is smooth in u from 0 to π/2. The sign of A does not matter, and A = 0
        gives the limit 2π/ω. CamRangeError: an amplitude beyond the cam. SlackThreadError: a swing
        in which the thread goes slack.
        """
        if self.imbalance is not None:
            return self._unbalanced_period(amplitude)
        cam, amplitude = self.cam, abs(amplitude)
        top = float(self.potential(amplitude))
        if top == 0.0:
            return self.small_period if self.has_small_swings else math.inf
        joints = cam.joints[cam.joints < amplitude]

        def integrand(u: FloatArray) -> FloatArray:
            angle, lift = self._along(amplitude, top, u)
            mass = self.mass(angle)
            # the tension F + m ḧ = I (F + m t' ϑ̇²)/M
            kinetic, rate, pull = top * np.cos(u) ** 2, cam.lever_rate(angle), self.pull(lift)
            tension = pull + self.carried_mass * rate * 2.0 * kinetic / mass
            if not np.all(tension > 0.0):
                where = float(angle[tension <= 0.0].min())
                raise SlackThreadError(
                    f'the thread goes slack at an angle of {where!r} rad: there the lever arm of '
                    f'{cam!r} falls so fast that the thread would have to push. Use a smaller '
                    'amplitude, a lighter weight or a cam with a lever arm that does not fall'
                )
            return np.sqrt(mass) * np.sin(u) / (pull * cam.lever_arm(angle))

        if not self.has_small_swings:
            # V ∝ ϑ³ there, which makes the integrand smooth in the cube root of u
            def smooth(root: FloatArray) -> FloatArray:
                return integrand(root**3) * (3.0 * root * root)

            end = np.array([(0.5 * math.pi) ** (1.0 / 3.0)])
            return 4.0 * math.sqrt(2.0 * top) * float(integrate(smooth, np.zeros(1), end)[0])
        cuts = np.arcsin(np.sqrt(self.potential(joints) / top))
        edges = np.concatenate([[0.0], cuts, [0.5 * math.pi]])
        parts = integrate(integrand, edges[:-1], edges[1:])
        return 4.0 * math.sqrt(2.0 * top) * float(np.sum(parts))

    def _unbalanced_period(self, amplitude: float) -> float:
        """Return the period of a swing from an angle of either sign, for a taut thread.

        T = 2 ∫ √(M/(2(V(A) − V))) dϑ from end to end, which need not be symmetric.
        """
        top = float(self.potential(amplitude))
        # the period differs by the square of 1e-7, and the two ends nearly coincide
        if abs(amplitude - self.rest_angle) < 1e-7:
            return self.small_period
        turn = self.far_turning(amplitude)
        middle, size = 0.5 * (amplitude + turn), 0.5 * (amplitude - turn)

        def integrand(w: FloatArray) -> FloatArray:
            angle = middle + size * np.cos(w)
            kinetic = top - self.potential(angle)
            # near its ends integrated from there, without cancellation
            sides = (amplitude, -(np.sin(0.5 * w) ** 2)), (turn, np.cos(0.5 * w) ** 2)
            for end, share in sides:
                is_near = np.abs(share) < 0.05
                way = 2.0 * size * share[is_near]
                kinetic[is_near] = -gauss_sums(self._slope, np.full(way.shape, end), way)
            return np.sqrt(0.5 * self.mass(angle) / kinetic) * abs(size) * np.sin(w)

        joints = np.concatenate([-self.cam.joints, [0.0] * self.cam.kinked, self.cam.joints])
        inner = (joints - middle) / size
        edges = np.sort(np.arccos(np.array([1.0, *inner[np.abs(inner) < 1.0], 0.0, -1.0])))
        return 2.0 * float(np.sum(integrate(integrand, edges[:-1], edges[1:])))

    def far_turning(self, amplitude: float) -> float:
        """Return ϑ at the other end of a free swing of an unbalanced wheel on land [rad].

        CamRangeError: that end is beyond the cam.
        """
        centre, top = self.rest_angle, float(self.potential(amplitude))
        edge = math.copysign(self.cam.range_rad, centre - amplitude)
        turn = centre - (amplitude - centre)
        while self.potential(np.clip(turn, -abs(edge), abs(edge))) < top:
            if abs(turn) > abs(edge):
                raise CamRangeError(
                    f'a swing from {amplitude!r} rad goes beyond the cam on the other side, at '
                    f'{edge:.6g} rad, since the wheel is unbalanced. Use a smaller amplitude'
                )
            turn += 0.5 * (turn - centre)
        turn = float(np.clip(turn, -abs(edge), abs(edge)))
        return root_of(lambda angle: float(self.potential(angle)) - top, centre, turn, 1e-15)

    def raised(self, angle: ArrayLike) -> FloatArray:
        """Return V(ϑ) − V(rest) of an unbalanced wheel on land [J], without cancellation."""
        angle, centre = np.asarray(angle, np.float64), self.rest_angle
        energy = np.asarray(self.potential(angle) - self.potential(centre))
        # near rest by integrating the slope, if the lever arm is smooth there
        is_near = np.abs(angle - centre) < 0.05 * (0.0 if self.cam.joints.size else 1.0)
        is_near &= (angle * centre >= 0.0) | (not self.cam.kinked)
        way = (angle - centre)[is_near]
        energy[is_near] = gauss_sums(self._slope, np.full(way.shape, centre), way)
        return energy

    def uneven_swing(self, amplitude: float, w: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return ϑ and dt/dW of a free swing of an unbalanced wheel on land, 0 < W < π, W ≠ π/2.

        `raised` at the amplitude times cos²W gives ϑ, from the amplitude to the other end. With
        Y² = `raised`, dt/dW = √(M/2)/(dY/dϑ), dY/dϑ = V′/2Y.
        """
        centre, turn = self.rest_angle, self.far_turning(amplitude)
        goal = math.sqrt(float(self.raised(np.array([amplitude]))[0])) * np.cos(w)
        ends = np.where(goal > 0.0, amplitude, turn) - centre

        def excess(way: FloatArray) -> tuple[FloatArray, FloatArray]:
            angle = centre + np.sign(ends) * way
            root = np.sqrt(np.maximum(self.raised(angle), 0.0))
            slope = np.abs(self._slope(angle))
            return root - np.abs(goal), np.divide(
                slope, 2.0 * root, np.zeros_like(root), where=root > 0.0
            )

        start = np.abs(ends) * np.abs(np.cos(w))
        offset = bracketed_newton(excess, start, (0.0, np.abs(ends)), relative=4e-16)
        angle = centre + np.sign(ends) * offset
        slowness = np.sqrt(0.5 * self.mass(angle)) * 2.0 * np.abs(goal)
        return angle, slowness / np.abs(self._slope(angle))

    def swing(self, amplitude: float, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return ϑ ≥ 0 and dt/du along a quarter of a free swing on land, for any u in (0, π/2].

        V = V(A) sin²u: u runs from 0 in the middle to π/2 at the turning point.
        """
        top = float(self.potential(amplitude))
        angle, lift = self._along(amplitude, top, u)
        torque = self.pull(lift) * self.cam.lever_arm(angle)
        return angle, np.sqrt(2.0 * top * self.mass(angle)) * np.sin(u) / torque

    def angle_of_potential(self, potential: float) -> float:
        """Return ϑ ≥ 0 at which V is `potential` [J], at most the cam's range."""
        edge = self.cam.range_rad
        if self.imbalance is not None:
            high, low = min(edge, 1.0), max(self.rest_angle, 0.0)
            while high < edge and self.potential(high) < potential:
                high = min(2.0 * high, edge)
            if self.potential(high) <= potential:
                return high
            return root_of(
                lambda angle: float(self.potential(angle)) - potential, low, high, 2e-12
            )
        if math.isfinite(edge):
            potential = min(potential, float(self.potential(edge)))
        return float(self.cam.angle_of_lift(self.lift_of_potential(potential)))

    def _along(self, amplitude: float, top: float, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return ϑ and the lift at which V = V(A) sin²u, from `top` = V(A)."""
        cam = self.cam
        sine, kinetic = np.sin(u), top * np.cos(u) ** 2
        lift = self.lift_of_potential(top * sine * sine)
        angle = cam.angle_of_lift(lift)
        # a corrected cam has a closed form for the angle of a lift
        if not cam.knows_angle_of_lift:
            joint = cam.joints[cam.joints < amplitude].max(initial=0.0)
            is_near = (sine * sine > 0.5) & (angle > joint)
            angle[is_near] = self._angle_at(kinetic[is_near], angle[is_near], amplitude)
        return angle, lift

    def _angle_at(self, kinetic: FloatArray, guess: FloatArray, amplitude: float) -> FloatArray:
        """Return the angle of a swing's kinetic energy [J], by integrating from the turning point.

        If the lever arm decreases, integrating from 0 would lose the last digits of the angle
        there. The arm must be smooth from the guess up to the amplitude.
        """
        pull = float(self.pull(self.cam.lift(amplitude), self.gravity))
        drop = 2.0 * kinetic / (pull + np.sqrt(pull * pull - 2.0 * self.stiffness * kinetic))
        guess = np.minimum(guess, amplitude)
        wrong = gauss_sums(self.cam.lever_arm, guess, amplitude - guess) - drop
        return np.minimum(guess + wrong / self.cam.lever_arm(guess), amplitude)

    @property
    def _rest_pull(self) -> float:
        return self.force + self.pulling_mass * self.gravity


# -----------------------------------------------------------------------------
# The base of all kinds of thread.

THREADS = 'tauto_core.machines.threads'


class Parts(NamedTuple):
    """The parts that a thread joins to a `Machine`, with attributes as there.

    The drag includes the friction of resting teeth.
    """

    inertia: float
    cam: CamKind
    power: PowerKind
    release_angle: float
    gravity: float
    drag: DragKind | None
    escapement: EscapementKind | None
    imbalance: Imbalance | None = None
    heat: Heat = NO_HEAT


class ThreadKind(Kind):
    """A thread. Each kind is a module of `machines/threads` with a `KIND`.

    Attributes:
        moves_the_weight: whether the machine includes the motion of the weight on the thread.
        upright: whether a weight keeps it along the apparent vertical.
        grows_alike: whether the parts of the machine must be of one material.
        compensable: whether a compensation may act on its pull.
        takes_a_force: whether a force without mass may replace the weight that it moves.
        takes_a_spring: whether a spring may pull at the weight that it moves.
    """

    moves_the_weight: ClassVar[bool] = False
    upright: ClassVar[bool] = False
    grows_alike: ClassVar[bool] = False
    compensable: ClassVar[bool] = True
    takes_a_force: ClassVar[bool] = False
    takes_a_spring: ClassVar[bool] = False

    kind: str

    @property
    def swinging_length(self) -> float:
        """Length with which the weight swings about the apparent vertical [m], or 0."""
        return 0.0

    @property
    def hole_distance(self) -> float:
        """Distance of the hole from the axle [m], inf without a hole."""
        return math.inf

    def setting(self, parts: Parts) -> Setting:
        """Return the properties of the machine that determine the cam."""
        return Setting(parts.inertia, parts.power.pull, parts.gravity, self.hole_distance)

    def cam(self, parts: Parts) -> Cam:
        """Return the cam for this thread.

        Raises:
            SceneError: an impossible cam (`possible_cam`).
        """
        return possible_cam(
            parts.cam.made(self.setting(parts)), parts.cam.kind, parts.cam.if_hollow
        )

    def machine(self, parts: Parts) -> Any:
        """Return the machine, with the properties and methods of `Machine` that its motion needs.

        Raises:
            SceneError: an impossible cam.
        """
        return self.ideal(parts)

    def ideal(self, parts: Parts) -> Machine:
        """Return the machine with an ideal thread.

        Raises:
            SceneError: an impossible cam.
        """
        pull, cam = parts.power.pull, self.cam(parts)
        if pull.law is not None:
            # slow to import, rarely needed
            from tauto_core.curves.cams.corrected import pulled

            cam = pulled(cam, pull.law)
        if parts.imbalance is not None:
            limit = pull.at_rest(parts.gravity) * float(cam.lever_rate(0.0)) / parts.gravity
            # a wheel that hangs straight down is a pendulum, stable without the thread
            if parts.imbalance.direction != 0.0 and not parts.imbalance.moment < limit:
                raise SceneError(
                    'trochlea',
                    'trochlea.imbalance.moment',
                    parts.imbalance.moment,
                    f'outweighs the thread, which holds the wheel against {limit:.6g} kg m',
                    f'Use less than {limit:.4g} kg m.',
                )
        return Machine(
            inertia=parts.inertia,
            carried_mass=pull.carried_mass,
            pulling_mass=pull.pulling_mass,
            force=pull.force,
            stiffness=pull.stiffness,
            gravity=parts.gravity,
            cam=cam,
            follows_apparent_vertical=pull.pulling_mass > 0.0 and self.upright,
            drag=parts.drag,
            escapement=parts.escapement,
            release_angle=parts.release_angle,
            imbalance=parts.imbalance,
            heat=parts.heat,
        )

    def problems(
        self, power: PowerKind, drag: DragKind | None, escapement: EscapementKind | None
    ) -> Iterator[Problem]:
        """Yield the parts that exclude a thread that moves its weight."""
        if not self.moves_the_weight:
            return
        pull, kind = power.pull, f'does not go with trochlea.thread.kind {self.kind}'
        yield from wrong(
            (
                not (pull.pulling_mass or self.takes_a_force),
                'trochlea.power.kind',
                power.kind,
                f'{kind}, which carries a weight',
                'Use power kind weight or weight_and_spring, or thread kind vertical or hole: a '
                'thread without mass runs straight from the cam to a hole or an anchor.',
            ),
            (
                pull.pulling_mass and not pull.carried_mass,
                'trochlea.power.massless',
                True,
                f'{kind}: its weight moves the thread',
                'Leave it out, or use thread kind vertical.',
            ),
            (
                pull.pulling_mass
                and pull.carried_mass
                and pull.stiffness
                and not self.takes_a_spring,
                'trochlea.power.kind',
                power.kind,
                f'{kind}: weight and spring together are not in its equations',
                'Use power kind weight or spring, or thread kind vertical.',
            ),
            (
                escapement is not None and escapement.ebb is not None,
                'escapement.kind',
                '' if escapement is None else escapement.kind,
                f'with impulses that weaken {kind}',
                'Give impulses that are all the same (fall 0), or use thread kind vertical or '
                'hole.',
            ),
            *(
                (
                    friction > 0.0,
                    key,
                    friction,
                    kind,
                    'Use viscous or quadratic drag, or thread kind vertical or hole.',
                )
                for key, friction in (
                    ('drag.coulomb', 0.0 if drag is None else drag.coulomb),
                    (
                        'escapement.rest.friction',
                        0.0 if escapement is None else escapement.friction,
                    ),
                )
            ),
        )
