"""The regulators of a scene: the trochlea with its rules, and the body that swings in a fluid.

`fluid_pendulum` has the mechanics of the latter. It is imported only for such a scene.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Literal, cast

import numpy as np
from pydantic import Field

from tauto_core.curves.cam import CAMS, Cam, CamKind
from tauto_core.curves.materials import MATERIALS, NamedMaterial, as_written, material
from tauto_core.curves.numerics import QuadratureError
from tauto_core.machines.drags import Drag
from tauto_core.machines.heat import (
    COLDEST,
    HOTTEST,
    MONTH_S,
    Compensation,
    Heat,
    thinning,
)
from tauto_core.machines.parts import (
    POWERS,
    DragKind,
    EscapementKind,
    Imbalance,
    PowerKind,
    beside_regulator,
    wrong,
)
from tauto_core.machines.trochlea import THREADS, Parts, ThreadKind
from tauto_core.scene.errors import ABSENT, DescentError, Problem, SceneError
from tauto_core.scene.sections import (
    KindIn,
    NonNegative,
    Number,
    Positive,
    Section,
    kind_of,
    kinds_in,
)

if TYPE_CHECKING:
    from tauto_core.curves.branches import Branch
    from tauto_core.machines.fluid_pendulum import Curve, FluidPendulum


def cam_kinds() -> tuple[type[CamKind], ...]:
    """Return all kinds of cam."""
    return cast(tuple[type[CamKind], ...], kinds_in(CAMS))


class Unbalanced(Section):
    """The imbalance of the wheel: its centre of mass is off its axle (Euler 1727, III)."""

    moment: Positive = Field(
        description='mass of the wheel times the distance of its centre from the axle [kg m]'
    )
    direction: Number = Field(
        default=0.0,
        description='direction of the centre of mass from straight down, with the wheel at 0 '
        '[rad], positive as the angle of the wheel',
    )


class Trochlea(Section):
    """The regulator: a wheel with a cam on which a thread winds, pulled by the power."""

    inertia: Positive = Field(description="the wheel's moment of inertia about its axle [kg m2]")
    cam: Annotated[CamKind, KindIn(CAMS)] = Field(
        description='mapping with `kind` and the dimensions of the cam'
    )
    thread: Annotated[ThreadKind, KindIn(THREADS)] = Field(
        description='mapping with `kind` and the dimensions of the thread'
    )
    power: Annotated[PowerKind, KindIn(POWERS)] = Field(
        description='mapping with `kind` and the numbers of the power, which pulls the thread'
    )
    release_angle: Number = Field(
        description="the wheel's angle in its case at release, from rest [rad], at most ten turns"
    )

    plane: Literal['free', 'vertical', 'ship'] | None = Field(
        default=None,
        description='plane in which the thread can follow the apparent vertical on a ship that '
        'pitches: free (any), vertical (held upright by gimbals) or ship (athwart, fixed to the '
        'ship). When left out it is free for a weight on a vertical thread, else ship',
    )
    at_celsius: Number = Field(
        default=20.0,
        description=f'temperature for which the numbers hold, {COLDEST:g} to {HOTTEST:g} [°C]',
    )
    material: NamedMaterial | None = Field(
        default=None,
        description=f'of wheel, cam and lever: {", ".join(sorted(MATERIALS))}, or mapping: '
        'expansion. When left out they do not expand',
    )
    compensation: Compensation | None = Field(
        default=None, description='mapping: takes, leaves, middle'
    )

    imbalance: Unbalanced | None = Field(
        default=None,
        description='mapping: moment, direction. When left out the wheel is balanced',
    )
    slack: Literal['fall', 'stop'] | None = Field(
        default=None,
        description='motion of a slack thread: fall (the weight falls until the thread tautens) '
        'or stop (the run ends), fall when left out',
    )

    @property
    def thread_plane(self) -> Literal['free', 'vertical', 'ship']:
        """The plane in which the thread can follow the apparent vertical."""
        return self.plane or ('free' if self.thread.upright else 'ship')

    def parts(
        self,
        gravity: float,
        drag: DragKind | None = None,
        escapement: EscapementKind | None = None,
    ) -> Parts:
        """Return the parts of a machine. The friction of resting teeth is added to the drag."""
        heat = self._heat(drag)
        if escapement is not None and escapement.friction:
            drag = (drag or Drag()).with_friction(escapement.friction)
        imbalance = None
        if self.imbalance is not None:
            imbalance = Imbalance(self.imbalance.moment, self.imbalance.direction)
        return Parts(
            self.inertia,
            self.cam,
            self.power,
            self.release_angle,
            gravity,
            drag,
            escapement,
            imbalance,
            heat,
        )

    def _heat(self, drag: DragKind | None) -> Heat:
        wheel, compensation = material(self.material), self.compensation
        heat = Heat(
            self.at_celsius,
            wheel.expansion,
            wheel.expansion
            if self.cam.material is None
            else material(self.cam.material).expansion,
            material(getattr(self.power, 'material', None)).force,
            middle=self.at_celsius,
        )
        if drag is not None:
            thickening = math.log1p(drag.thickens_per_month) / MONTH_S
            oil = thinning(drag.oil, self.at_celsius)
            heat = replace(heat, oil=oil, thickening=thickening)
        if compensation is None:
            return heat
        middle = self.at_celsius if compensation.middle is None else compensation.middle
        return replace(heat, takes=compensation.takes, leaves=compensation.leaves, middle=middle)

    def made_cam(self, gravity: float) -> Cam:
        """Return the cam for the thread of this trochlea.

        SceneError: an impossible cam (`possible_cam`), or an unusable table.
        """
        return self.thread.cam(self.parts(gravity))

    def problems(
        self,
        drag: DragKind | None,
        escapement: EscapementKind | None,
        *,
        still: bool,
    ) -> Iterator[Problem]:
        """Yield contradictions between its keys, or with the scene's drag and escapement."""
        fitting = self.cam.threads
        if self.thread.kind not in fitting:
            cams = (kind_of(kind) for kind in cam_kinds() if self.thread.kind in kind.threads)
            yield Problem(
                'trochlea.thread.kind',
                self.thread.kind,
                f'does not go with trochlea.cam.kind {self.cam.kind}',
                f'Use thread kind {" or ".join(fitting)}, or a cam of kind {", ".join(cams)}.',
            )
        if self.cam.corrects not in ('', self.power.acts_as):
            yield self._not_corrected()
        yield from self._power_problems()
        yield from self.thread.problems(self.power, drag, escapement)
        # at rest in the middle only recoil pushes the wheel
        recoil = 0.0 if escapement is None else escapement.recoil
        friction = 0.0 if drag is None else drag.coulomb
        friction += 0.0 if escapement is None else escapement.friction
        yield from wrong(
            (
                self.imbalance is not None and self.thread.moves_the_weight,
                'trochlea.imbalance.moment',
                0.0 if self.imbalance is None else self.imbalance.moment,
                f'does not go with trochlea.thread.kind {self.thread.kind}, whose wheel is '
                'balanced in its equations',
                'Leave out trochlea.imbalance, or use thread kind vertical or hole.',
            )
        )
        yield from self._heat_problems(drag)
        yield from wrong(
            (
                self.plane == 'free' and not self.thread.upright,
                'trochlea.plane',
                'free',
                f'does not go with trochlea.thread.kind {self.thread.kind}, which is guided or '
                'swings in one plane',
                'Use vertical (gimbals), or ship.',
            ),
            (
                still and self.release_angle == 0.0 and not recoil > friction,
                'trochlea.release_angle',
                0.0,
                'leaves the wheel at rest for ever on a still ship',
                'Release it at an angle other than 0 rad'
                + (f', or give it a recoil above {friction!r} N m.' if recoil else '.'),
            ),
        )

    def _power_problems(self) -> Iterator[Problem]:
        """Yield problems of the power, and of the cam under a force that depends on the lift."""
        yield from self.power.problems()
        pull, kind = self.power.pull, f'does not go with trochlea.power.kind {self.power.kind}'
        yield from wrong(
            (
                self.slack == 'fall'
                and self.thread.moves_the_weight
                and (pull.law or pull.stiffness),
                'trochlea.slack',
                'fall',
                f'{kind} on trochlea.thread.kind {self.thread.kind}, whose slack motion has no '
                'spring',
                'Leave it out: the run ends when the thread goes slack.',
            )
        )
        if pull.law is None and not (self.thread.grows_alike and pull.stiffness):
            return
        alloy = None if self.thread.grows_alike else self.cam.material
        why = {
            'circular_arc': 'its lever arm has a kink at rest',
            'synthesised': 'it is made of polynomials, which have no joints',
        }
        yield from wrong(
            (
                self.cam.kind in why,
                'trochlea.cam.kind',
                self.cam.kind,
                f'{kind}: {why.get(self.cam.kind)}',
                'Use cam kind force_table_corrected, involute, hole, table or measured.',
            ),
            (
                self._heat(None).cam,
                'trochlea.material' if alloy is None else 'trochlea.cam.material',
                material(self.material if alloy is None else alloy).expansion,
                f'1/K {kind}: its force is computed for a cam that does not grow',
                'Leave it out.'
                if self.thread.grows_alike
                else 'Give cam.material: {expansion: 0.0}.',
            ),
        )

    def _heat_problems(self, drag: DragKind | None) -> Iterator[Problem]:
        """Yield the problems of temperature and materials."""
        compensation = self.compensation
        for key, celsius in (
            ('at_celsius', self.at_celsius),
            ('compensation.middle', None if compensation is None else compensation.middle),
        ):
            if celsius is None or COLDEST <= celsius <= HOTTEST:
                continue
            kelvin = celsius - 273.15
            meant = f'Write {key.rpartition(".")[2]}: {kelvin:.6g}, if kelvin are meant.'
            yield Problem(
                f'trochlea.{key}',
                celsius,
                f'must lie in [{COLDEST:g}, {HOTTEST:g}] °C',
                meant if COLDEST <= kelvin <= HOTTEST else 'Give the temperature in °C.',
            )
            return
        spring, cam = getattr(self.power, 'material', None), self.cam.material
        elastic = (name for name, item in MATERIALS.items() if item.modulus is not None)
        heat, kind = self._heat(drag), f'does not go with trochlea.thread.kind {self.thread.kind}'
        yield from wrong(
            (
                spring is not None and material(spring).modulus is None,
                'trochlea.power.material',
                as_written(spring),
                'has no modulus, which gives the change of a spring with temperature',
                f'Use {", ".join(elastic)}, or mapping: expansion, modulus.',
            ),
            (
                self.thread.grows_alike and heat.wheel != heat.cam,
                'trochlea.cam.material',
                as_written(cam),
                f'{kind}: its wheel, cam and lever grow alike',
                'Leave it out, and give trochlea.material for all of them.',
            ),
            (
                compensation is not None and not self.thread.compensable,
                'trochlea.compensation',
                as_written(compensation),
                f'{kind}, which the weight alone pulls',
                'Leave it out, or use thread kind vertical, hole or lever.',
            ),
        )

    def _not_corrected(self) -> Problem:
        """Return the problem of a power for which the cam was not made."""
        power, plain = self.power, 'involute' if self.thread.kind == 'vertical' else 'hole'
        made = [kind_of(kind) for kind in cam_kinds() if kind.corrects == power.acts_as]
        fitting = plain if power.acts_as == 'force' else [*made, 'synthesised'][0]
        weightless = power.kind == 'weight' and power.acts_as == 'force'
        return Problem(
            'trochlea.power.massless' if weightless else 'trochlea.power.kind',
            True if weightless else power.kind,
            f'does not go with trochlea.cam.kind {self.cam.kind}, which is made for power kind '
            f'{self.cam.corrects}',
            f'For {power.words} use cam kind {fitting}.',
        )


# -----------------------------------------------------------------------------
# A body that sinks in a fluid: its effective weight and its resistance.
#
# Euler, *Curva tautochrona in fluido* (1729), 10–12. The resistance is the weight of a column of
# fluid, as high as the fall that gives the speed, on the base of a cylinder moving along its axis
# (C_d = 1). A globe has half of it (C_d = 1/2).

# drag coefficient × base area × size a/(2 × volume): 1/2 and 3/8
_DRAG = {'cylinder': 0.5, 'globe': 0.375}
_VOLUME = {'cylinder': 0.25 * math.pi, 'globe': math.pi / 6.0}


@dataclass(frozen=True)
class ImmersedBody:
    """A globe or cylinder in its fluid.

    Attributes:
        shape: 'globe' or 'cylinder'.
        size: diameter a of the globe, height a of the cylinder along its motion [m], > 0.
        density: m of the body [kg/m3]. Except in the weight only its ratio to n counts.
        fluid_density: n of the fluid [kg/m3], 0 ≤ n < m.
        added_mass: C, coefficient of added mass, ≥ 0. Euler: 0. A globe in potential flow: 1/2.

    Raises:
        DescentError: a fluid as dense as the body.
    """

    shape: Literal['globe', 'cylinder']
    size: float
    density: float
    fluid_density: float
    added_mass: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.fluid_density < self.density:
            raise DescentError(
                f'fluid_density = {self.fluid_density!r} kg/m3: must be at least 0 and less than '
                f'the density of the {self.shape}, {self.density!r} kg/m3, or it does not sink. '
                'Take a denser body or a lighter fluid'
            )

    @property
    def kappa(self) -> float:
        """κ = n/(2(m + Cn)a) of a cylinder, 3n/(8(m + Cn)a) of a globe [1/m]."""
        return _DRAG[self.shape] * self.fluid_density / (self._inertia * self.size)

    @property
    def gamma(self) -> float:
        """γ = (m − n)/(m + Cn)."""
        return (self.density - self.fluid_density) / self._inertia

    @property
    def sunk_mass(self) -> float:
        """Mass of the body less the displaced mass of fluid [kg], of a cylinder as wide as high.

        The motion of a cylinder does not depend on its width.
        """
        return (self.density - self.fluid_density) * _VOLUME[self.shape] * self.size**3

    @property
    def _inertia(self) -> float:
        return self.density + self.added_mass * self.fluid_density


class CycloidBranch(Section):
    """A branch of a cycloid."""

    kind: Literal['cycloid'] = Field(default='cycloid', description='cycloid')
    pendulum_length: Positive = Field(
        description='length of the simple pendulum that keeps time with small swings on it [m]'
    )

    def curve(self, kappa: float, gamma: float) -> Branch:
        """Return the branch for a body in a fluid."""
        from tauto_core.curves.fluid import Cycloid

        return Cycloid(kappa, gamma, self.pendulum_length)


class CircleBranch(Section):
    """A branch of a circle."""

    kind: Literal['circle'] = Field(default='circle', description='circle')
    radius: Positive = Field(description='radius of the circle [m]')

    def curve(self, kappa: float, gamma: float) -> Branch:
        """Return the branch for a body in a fluid."""
        from tauto_core.curves.branches import CircularDescent

        return CircularDescent(kappa, gamma, self.radius / gamma)


class PointsBranch(Section):
    """A branch through points."""

    kind: Literal['points'] = Field(default='points', description='points')
    points: Annotated[
        tuple[tuple[Positive, Positive], ...], Field(min_length=3, max_length=200)
    ] = Field(
        description='pairs of horizontal distance from the lowest point and height above it [m], '
        '3 to 200, distances increasing'
    )

    def curve(self, kappa: float, gamma: float) -> Branch:
        """Return the branch for a body in a fluid. DescentError: a point that does not rise."""
        from tauto_core.curves.branches import ThroughPoints

        return ThroughPoints(kappa, gamma, np.array(self.points))


class FluidTautochroneRegulator(Section):
    """A globe or cylinder that swings on a curve in a fluid, without a trochlea (Euler 1729)."""

    kind: Literal['fluid_tautochrone'] = Field(description='fluid_tautochrone')
    curve: Literal['euler', 'cycloid', 'symmetric', 'companion'] = Field(
        default='euler', description='euler, cycloid, symmetric or companion (B in fluid.md)'
    )
    of: Annotated[
        CycloidBranch | CircleBranch | PointsBranch | None, Field(discriminator='kind')
    ] = Field(
        default=None,
        description='mapping with `kind`: the branch to which the companion is sought',
    )
    given: Literal['descent', 'ascent'] = Field(
        default='descent',
        description='branch that `of` of a companion describes: descent or ascent',
    )
    body: Literal['globe', 'cylinder'] = Field(description='globe or cylinder')
    diameter: Positive = Field(
        description='diameter of the globe, or height of the cylinder along its motion [m]'
    )
    body_density: Positive = Field(description='density of the body [kg/m3]')
    fluid_density: NonNegative = Field(description='density of the fluid, below the body [kg/m3]')
    pendulum_length: Positive = Field(
        description='length f of the simple pendulum that keeps time with small swings, or with '
        'all half swings of a companion [m]'
    )
    ascent_length: Positive | None = Field(
        default=None,
        description="length h of the same kind for the branch of ascent, on Euler's curve only "
        '[m], f when left out',
    )
    friction: NonNegative = Field(
        default=0.0,
        description="constant friction, over the body's weight in the fluid (Euler's curve "
        'includes it)',
    )
    viscous: NonNegative = Field(
        default=0.0,
        description='resistance ∝ v (Newton), over the speed and the mass that moves [1/s], on '
        'the curves euler and cycloid',
    )
    release_arc: Number = Field(
        description='arc from the lowest point to the release at rest [m], negative on the '
        'branch of ascent'
    )
    added_mass: NonNegative = Field(
        default=0.0,
        description='coefficient of added mass: 0 (Euler), 0.5 (globe in potential flow)',
    )

    def problems(
        self, sections: Mapping[str, object], ship: str, *, still: bool
    ) -> Iterator[Problem]:
        """Yield its problems, and the sections and ships that it excludes."""
        yield from beside_regulator(
            sections,
            {
                'trochlea': 'a scene has one regulator',
                'drag': 'the fluid is the drag',
                'escapement': 'a body in a fluid has no escapement',
                'suspension': 'a fluid does not turn with its vessel',
            },
        )
        kind, missing = f'regulator.curve {self.curve}', self.of is None
        joined = self.ascent_length is not None or self.curve not in ('euler', 'cycloid')
        yield from wrong(
            (
                not still,
                'ship.kind',
                ship,
                'does not go with regulator: on a ship that rolls the fluid does not turn with '
                'its vessel, and resists otherwise than by the speed on the curve',
                'Use ship kind still.',
            ),
            (
                missing == (self.curve == 'companion'),
                'regulator.of',
                ABSENT if self.of is None else self.of.kind,
                'is missing: the branch whose companion is sought'
                if missing
                else f'does not go with {kind}, which is already complete',
                'Write of: {kind: circle, radius: 1.0}, or kind cycloid or points.'
                if missing
                else 'Leave it out, or use curve companion.',
            ),
            (
                self.given == 'ascent' and self.curve != 'companion',
                'regulator.given',
                self.given,
                f'does not go with {kind}, which has no given branch',
                'Leave it out.',
            ),
            (
                self.ascent_length is not None and self.curve != 'euler',
                'regulator.ascent_length',
                self.ascent_length,
                f"does not go with {kind}: branches of two lengths are Euler's",
                'Leave it out, or use curve euler.',
            ),
            (
                self.friction and self.curve == 'companion',
                'regulator.friction',
                self.friction,
                'does not go with regulator.curve companion, which is computed without friction',
                'Leave it out, or use curve euler, which allows for it.',
            ),
            (
                self.viscous and joined,
                'regulator.viscous',
                self.viscous,
                'does not go with a curve with a jump of curvature at its lowest point',
                'Leave it out, or use curve euler without ascent_length, or curve cycloid.',
            ),
            (
                self.release_arc == 0.0,
                'regulator.release_arc',
                0.0,
                'leaves the body at rest for ever',
                'Release it at an arc other than 0 m.',
            ),
        )

    @property
    def immersed(self) -> ImmersedBody:
        """The body in its fluid. DescentError: it does not sink."""
        return ImmersedBody(
            self.body, self.diameter, self.body_density, self.fluid_density, self.added_mass
        )

    @property
    def released_at(self) -> float:
        """Arc of the release [m]."""
        return self.release_arc

    def machine(self, name: str, gravity: float) -> FluidPendulum:
        """Return the regulator of a named scene as numbers (`compile_fluid_pendulum`)."""
        return compile_fluid_pendulum(name, gravity, self)


def make_descent_curve(regulator: FluidTautochroneRegulator) -> Curve:
    """Return the curve of a regulator for its body and fluid.

    DescentError: a body that does not sink, or a curve that does not exist.
    """
    from tauto_core.curves.branches import JoinedCurve, joined_companion
    from tauto_core.curves.fluid import Cycloid, FluidTautochrone, SymmetricCurve
    from tauto_core.machines.fluid_pendulum import composed_length

    kappa, gamma = regulator.immersed.kappa, regulator.immersed.gamma
    length, ascent, mu = regulator.pendulum_length, regulator.ascent_length, regulator.friction
    match regulator.curve:
        case 'cycloid':
            return Cycloid(kappa, gamma, length)
        case 'symmetric':
            return SymmetricCurve(kappa, gamma, length)
        case 'companion':
            assert regulator.of is not None  # `problems`
            return joined_companion(regulator.of.curve(kappa, gamma), regulator.given, length)
    curve = FluidTautochrone(kappa, gamma, length, mu)
    if ascent is None:
        return curve
    twin = FluidTautochrone(kappa, gamma, ascent, mu)
    return JoinedCurve(curve, twin, composed_length(length, ascent))


def compile_fluid_pendulum(
    name: str, gravity: float, regulator: FluidTautochroneRegulator
) -> FluidPendulum:
    """Return the regulator of a named scene as numbers.

    SceneError: a body that does not sink, or a release beyond the cusp.
    """
    if regulator.fluid_density >= regulator.body_density:
        raise SceneError(
            name,
            'regulator.fluid_density',
            regulator.fluid_density,
            f'must be less than regulator.body_density, {regulator.body_density!r} kg/m3, or the '
            f'{regulator.body} does not sink',
            'Take a denser body or a lighter fluid.',
        )
    try:
        curve = make_descent_curve(regulator)
    except DescentError as error:
        raise SceneError(
            name, 'regulator', regulator.kind, f'cannot be built: {error}', 'Change body or fluid.'
        ) from None
    start = regulator.release_arc
    edge = curve.descent_cusp if start > 0.0 else curve.ascent_cusp
    if not abs(start) <= abs(edge):
        limit = 'cusp' if regulator.of is None else 'end of the companion'
        raise SceneError(
            name,
            'regulator.release_arc',
            start,
            f'is beyond the {limit} at {edge!r} m',
            'Release the body nearer to A, or give a longer pendulum or a larger or denser body.',
        )
    from tauto_core.machines.fluid_pendulum import FluidPendulum

    if abs(float(curve.slope(start))) <= regulator.friction:
        raise SceneError(
            name,
            'regulator.friction',
            regulator.friction,
            f'holds the body at its release, on a slope of {float(curve.slope(start)):.6g}',
            'Give less friction, or release the body farther from A.',
        )
    weight = regulator.immersed.sunk_mass * gravity
    machine = FluidPendulum(curve, weight, gravity, start, regulator.friction, regulator.viscous)
    if not regulator.viscous < 2.0 * machine.frequency:
        raise SceneError(
            name,
            'regulator.viscous',
            regulator.viscous,
            'is so large that the body creeps back to A without a swing',
            f'Give less than {2.0 * machine.frequency:.6g} 1/s, or a shorter pendulum_length.',
        )
    if not machine.is_euler:
        try:
            ways = machine.both_ways(start)
        except (DescentError, QuadratureError) as error:
            raise SceneError(
                name,
                'regulator.release_arc',
                start,
                f'is too far: {error}',
                'Release the body nearer to A.',
            ) from None
        if ways.holds(end := ways.course(start).end):
            raise SceneError(
                name,
                'regulator.friction',
                regulator.friction,
                f'holds the body after its first half swing, at {end:.6g} m',
                'Give less friction, or release the body farther from A.',
            )
    return machine
