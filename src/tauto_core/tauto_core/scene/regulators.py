"""Models of the regulator: cams, threads, powers, a body in a fluid, drag, escapement."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from tauto_core.scene.fields import Flag, NonNegative, Number, Positive, Section, Text


class InvoluteCam(Section):
    """Involute of a circle (Euler 1727, XIV): lever arm = base_radius · angle."""

    kind: Literal['involute'] = 'involute'
    base_radius: Positive = Field(description='radius of the base circle [m]')


class HoleCam(Section):
    """Euler's second curve (1727, XXII–XXIX), for a thread through a fixed hole."""

    kind: Literal['hole'] = 'hole'
    lever_rate: Positive = Field(description='lever arm per angle of the wheel [m/rad]')


class WeightCorrectedCam(Section):
    """The tautochrone for a weight that has inertia, made for one period (theory D)."""

    kind: Literal['weight_corrected'] = 'weight_corrected'
    period: Positive = Field(description='period of every swing on land [s]')


class SpringCorrectedCam(Section):
    """The tautochrone for a spring with stiffness, made for one period (theory E2)."""

    kind: Literal['spring_corrected'] = 'spring_corrected'
    period: Positive = Field(description='period of every swing on land [s]')


class LeverCorrectedCam(Section):
    """The tautochrone for Sully's lever machine, made for one period (theory A)."""

    kind: Literal['lever_corrected'] = 'lever_corrected'
    period: Positive = Field(description='period of every swing on land [s]')


class CircularArcCam(Section):
    """Cheek of a circular arc, the cam before Euler (theory E2)."""

    kind: Literal['circular_arc'] = 'circular_arc'
    radius: Positive = Field(description='radius of the arc [m]')
    root_depth: Positive = Field(description='depth of its root under the axle [m]')


class TableCam(Section):
    """Lever arm tabulated against the angle: CSV with the columns angle_rad, lever_arm_m."""

    kind: Literal['table'] = 'table'
    path: Text = Field(description='CSV file with the columns angle_rad,lever_arm_m')


class VerticalThread(Section):
    """Thread that keeps to one direction: the apparent vertical, or the case's for a spring."""

    kind: Literal['vertical'] = 'vertical'


class HoleThread(Section):
    """Thread drawn through a hole fixed in the case."""

    kind: Literal['hole'] = 'hole'
    distance: Positive = Field(description='distance of the hole from the axle [m]')


class LeverThread(Section):
    """Thread tied to a lever, level at rest, that carries the weight: Sully's own (1727, V)."""

    kind: Literal['lever'] = 'lever'
    arm: Positive = Field(description='from the fulcrum to where the thread is tied [m]')
    weight_arm: Positive = Field(description='from the fulcrum to the weight [m]')
    length: Positive = Field(description='free length of the thread at rest [m]')
    inertia: NonNegative = Field(
        default=0.0, description="the lever's own moment of inertia about the fulcrum [kg m2]"
    )


class HangingThread(Section):
    """Thread that hangs free with its weight, and swings."""

    kind: Literal['hanging'] = 'hanging'
    length: Positive = Field(description='free length of the thread at rest [m]')


class ForcePower(Section):
    """Constant pull without inertia."""

    kind: Literal['force'] = 'force'
    force: Positive = Field(description='pull in the thread [N]')


class WeightPower(Section):
    """Hanging weight; `massless` keeps its pull and neglects its inertia."""

    kind: Literal['weight'] = 'weight'
    mass: Positive = Field(description='mass of the weight [kg]')
    massless: Flag = Field(default=False, description='true neglects the inertia of the weight')


class SpringPower(Section):
    """Spring without inertia: pull = force + stiffness · draw."""

    kind: Literal['spring'] = 'spring'
    force: Positive = Field(description='pull at zero draw [N]')
    stiffness: NonNegative = Field(description='stiffness [N/m]')


Cam: TypeAlias = Annotated[
    InvoluteCam
    | HoleCam
    | CircularArcCam
    | TableCam
    | WeightCorrectedCam
    | SpringCorrectedCam
    | LeverCorrectedCam,
    Field(discriminator='kind'),
]
Thread: TypeAlias = Annotated[
    VerticalThread | HoleThread | LeverThread | HangingThread, Field(discriminator='kind')
]
Power: TypeAlias = Annotated[ForcePower | WeightPower | SpringPower, Field(discriminator='kind')]


class Trochlea(Section):
    """The regulator: a balanced wheel whose cam winds up a thread under power."""

    inertia: Positive = Field(description="the wheel's moment of inertia about its axle [kg m2]")
    cam: Cam = Field(description='mapping with `kind` and the dimensions of the cam')
    thread: Thread = Field(description='mapping with `kind` and the dimensions of the thread')
    power: Power = Field(description='mapping with `kind` and what pulls the thread')
    release_angle: Number = Field(
        description="the wheel's angle in its case at the start, at rest there [rad]"
    )


class FluidTautochroneRegulator(Section):
    """A globe or cylinder that swings on a curve in a fluid (Euler 1729); no trochlea."""

    kind: Literal['fluid_tautochrone'] = Field(description='fluid_tautochrone')
    curve: Literal['euler', 'cycloid', 'symmetric'] = Field(
        default='euler', description='euler, cycloid or symmetric (theory B)'
    )
    body: Literal['globe', 'cylinder'] = Field(description='globe or cylinder')
    diameter: Positive = Field(
        description='diameter of the globe, or height of the cylinder along its motion [m]'
    )
    body_density: Positive = Field(description='density of the body [kg/m3]')
    fluid_density: NonNegative = Field(description='density of the fluid, below the body [kg/m3]')
    pendulum_length: Positive = Field(
        description='length f of the simple pendulum that keeps time with small swings [m]'
    )
    release_arc: Number = Field(
        description='arc from the lowest point at which it is released at rest [m], negative on '
        'the branch of ascent'
    )
    added_mass: NonNegative = Field(
        default=0.0,
        description='fluid carried along, by the fluid displaced; Euler: 0, globe: 0.5',
    )


class Drag(Section):
    """Torque against the motion in the case: c₁θ̇ + c₂θ̇|θ̇| + c₀ sgn θ̇."""

    viscous: NonNegative = Field(default=0.0, description='c₁ [N m s]')
    quadratic: NonNegative = Field(default=0.0, description='c₂ [N m s2]')
    coulomb: NonNegative = Field(default=0.0, description='c₀ [N m]')


class Rest(Section):
    """What the tooth that lies on a pallet between two impulses does to the wheel (theory E2)."""

    friction: NonNegative = Field(default=0.0, description='torque against the motion [N m]')
    recoil: NonNegative = Field(
        default=0.0, description='torque against the last impulse, until the next [N m]'
    )


class Escapement(Section):
    """Impulse once a beat, at angle · sgn θ̇ (positive: after the middle)."""

    kind: Literal['impulse'] = 'impulse'
    energy: NonNegative = Field(
        description='energy given each beat [J]; 0 only where recoil drives the wheel'
    )
    angle: Number = Field(default=0.0, description='angle of the wheel in its case [rad]')
    rest: Rest | None = Field(default=None, description='mapping: friction, recoil')

    @property
    def recoil(self) -> float:
        """Torque against the last impulse, until the next [N m]."""
        return 0.0 if self.rest is None else self.rest.recoil

    @property
    def friction(self) -> float:
        """Torque against the motion [N m]."""
        return 0.0 if self.rest is None else self.rest.friction

    @property
    def work(self) -> float:
        """What it gives in a swing [J]: two impulses, and the loop that recoil runs through."""
        return 2.0 * self.energy + 4.0 * self.recoil * self.angle
