"""What a scene may contain: one frozen model per section and per kind.

SI units, radians, seconds. Numbers are finite and never read from strings or booleans; unknown
keys are refused. Sections that may be `None` are not simulated when absent. Rules that tie several
keys together are in `checks`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    Strict,
    model_serializer,
    model_validator,
)
from pydantic_core import PydanticCustomError

from tauto_core.scene.checks import problems, samples_beyond_end
from tauto_core.scene.times import nanoseconds, step_of_rate

STANDARD_GRAVITY = 9.80665
DAY_S = 86_400.0

Number: TypeAlias = Annotated[float, Strict()]
Positive: TypeAlias = Annotated[float, Strict(), Field(gt=0.0)]
NonNegative: TypeAlias = Annotated[float, Strict(), Field(ge=0.0)]
Flag: TypeAlias = Annotated[bool, Strict()]
# One line: no control characters, no line or paragraph separators.
Text: TypeAlias = Annotated[
    str, Strict(), Field(min_length=1, max_length=1000, pattern=r'^[^\p{Cc}\p{Zl}\p{Zp}]+$')
]
Latitude: TypeAlias = Annotated[float, Strict(), Field(ge=-90.0, le=90.0)]
Longitude: TypeAlias = Annotated[float, Strict(), Field(ge=-180.0, le=180.0)]
Position: TypeAlias = tuple[Latitude, Longitude]


class Section(BaseModel):
    """Base of all models: frozen, no unknown keys, finite numbers."""

    model_config = ConfigDict(frozen=True, extra='forbid', allow_inf_nan=False)


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


class Escapement(Section):
    """Impulse once a beat, at angle · sgn θ̇ (positive: after the middle)."""

    kind: Literal['impulse'] = 'impulse'
    energy: Positive = Field(description='energy given each beat [J]')
    angle: Number = Field(default=0.0, description='angle of the wheel in its case [rad]')


class Component(Section):
    """One harmonic: amplitude · cos(2π t/period + phase), t from the start of the scene."""

    amplitude: NonNegative = Field(description='amplitude, of roll [rad], of heave [m]')
    period: Positive = Field(description='period [s]')
    phase: Number = Field(default=0.0, description='phase at the start [rad]')


class Sea(Section):
    """Spectrum of a long-crested sea and how many components stand for it."""

    spectrum: Literal['bretschneider', 'jonswap'] = Field(description='bretschneider or jonswap')
    significant_wave_height: Annotated[float, Strict(), Field(gt=0.0, le=100.0)] = Field(
        description='significant wave height, at most 100 [m]'
    )
    peak_period: Positive = Field(description='period of the spectral peak [s]')
    gamma: Annotated[float, Strict(), Field(ge=1.0, le=10.0)] = Field(
        default=3.3, description='peak enhancement of jonswap, 1 to 10; 3.3 when left out'
    )
    components: Annotated[int, Strict(), Field(ge=1, le=4096)] = Field(
        default=64, description='number of components, 1 to 4096'
    )

    @model_serializer(mode='wrap')
    def _without_foreign_gamma(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        keys: dict[str, Any] = handler(self)
        if self.spectrum != 'jonswap':
            del keys['gamma']
        return keys


class Roll(Section):
    """Linear roll: ρ̈ + 2ζω_nρ̇ + ω_n²ρ = ω_n² κ_e · wave slope (theory E5)."""

    natural_period: Positive = Field(description='natural period 2π/ω_n of the roll [s]')
    damping_ratio: Positive = Field(description='damping ratio ζ, > 0')
    slope_coefficient: NonNegative = Field(description='effective wave-slope coefficient κ_e')


class Recorded(Section):
    """Measured motion: a CSV (columns named) or an MCAP bag with sensor_msgs/Imu (topic named).

    Columns carry their unit as a suffix: _s, _deg or _rad, _m. Roll is positive with the starboard
    side down, heave upwards; a negative `scale` turns both round.
    """

    path: Text = Field(description='CSV file, .mcap file or rosbag2 folder')
    time_column: Text | None = Field(default=None, description='CSV column of the time, …_s')
    roll_column: Text | None = Field(default=None, description='CSV column of the roll, …_deg')
    heave_column: Text | None = Field(default=None, description='CSV column of the heave, …_m')
    topic: Text | None = Field(default=None, description='topic of sensor_msgs/Imu in a bag')
    scale: Number = Field(default=1.0, description='factor on the motion, not 0')
    passband: tuple[NonNegative, Positive] = Field(
        default=(0.02, 0.4), description='[lowest, highest] frequency kept [Hz]'
    )
    max_gap: Positive = Field(
        default=3.0, description='longest gap between samples that is interpolated [s]'
    )


class _Ship(Section):
    rate: Positive = Field(default=20.0, description='samples of the motion a second [Hz]')
    height: Number = Field(default=3.0, description='height of the clock above the roll axis [m]')


class StillShip(_Ship):
    """A ship that lies still, or a clock on land."""

    kind: Literal['still'] = 'still'


class ComponentsShip(_Ship):
    """Roll, and heave where given, as sums of harmonics."""

    kind: Literal['components'] = 'components'
    components: tuple[Component, ...] = Field(
        default=(), description='list of {amplitude [rad], period [s], phase [rad]} of the roll'
    )
    heave: Annotated[tuple[Component, ...], Field(min_length=1)] | None = Field(
        default=None, description='list of {amplitude [m], period [s], phase [rad]} of the heave'
    )


class SeaShip(_Ship):
    """Roll, and heave where asked, from a sea."""

    kind: Literal['sea'] = 'sea'
    sea: Sea = Field(description='mapping: spectrum, significant_wave_height, peak_period, …')
    roll: Roll = Field(description='mapping: natural_period, damping_ratio, slope_coefficient')
    heave: Flag = Field(default=False, description='true: the ship follows the elevation')


class RecordedShip(_Ship):
    """Motion as measured."""

    kind: Literal['recorded'] = 'recorded'
    recorded: Recorded = Field(description='mapping: path, and CSV columns or a topic')


Ship: TypeAlias = Annotated[
    StillShip | ComponentsShip | SeaShip | RecordedShip, Field(discriminator='kind')
]


class AxleSuspension(Section):
    """The clock's case hung on a cylindrical axle in a bearing of the ship (theory E3)."""

    kind: Literal['axle'] = 'axle'
    support_radius: Positive = Field(description='radius of the hollow bearing [m]')
    axle_radius: Positive = Field(description='radius of the axle that lies in it [m]')
    depth: Number = Field(description='depth of the clock, the centre of gravity, under it [m]')
    gyration_radius: Number = Field(description='radius of gyration about that centre [m]')
    large_angles: Flag = Field(default=False, description='true: equations of any angles')


class Clock(Section):
    """The dial. Without a nominal period it is the regulator's small-amplitude period."""

    nominal_period: Positive | None = Field(
        default=None, description='time the dial gains in a full swing [s]'
    )


class Voyage(Section):
    """From port to port on the geodesic; times from the start of the scene."""

    departure: Position = Field(description='[latitude, longitude] in degrees, north and east +')
    arrival: Position = Field(description='[latitude, longitude] in degrees, north and east +')
    sails_at: NonNegative = Field(description='time of setting sail, from the start [s]')
    arrives_at: Positive = Field(description='time of landfall, from the start [s]')


class DriftSettings(Section):
    """What the navigator observes, and what his estimate of the drift assumes."""

    observation_interval: Positive = Field(
        default=DAY_S, description='time between observations in port [s]'
    )
    observation_sigma: Annotated[float, Strict(), Field(ge=1e-9, le=DAY_S)] = Field(
        default=0.5, description='standard deviation of an observation, 1e-9 to 86400 [s]'
    )
    states: Literal[2, 3] = Field(default=2, description='2: offset and rate; 3: ageing too')
    prior_rate_sigma: Annotated[float, Strict(), Field(ge=1e-9, le=DAY_S)] = Field(
        default=10.0,
        description="standard deviation of the clock's rate beforehand, 1e-9 to 86400 [s/day]",
    )


class Log(Section):
    """What is logged: one sample an interval, and the motion at its full rate where asked."""

    interval: Positive = Field(default=1.0, description='time between logged samples [s]')
    motion: Flag | None = Field(
        default=None, description='whether ship/imu is kept; when left out: up to a day'
    )


class Solver(Section):
    """What is asked of the numerical propagator; propagators in closed form ask nothing."""

    tolerance: Number | None = Field(
        default=None,
        description="relative error allowed in one step, 1e-15 to 1e-3; the propagator's default "
        'when left out',
    )


class Scene(Section):
    """A whole scene. Only `duration` and one of `trochlea` and `regulator` must be given."""

    name: Text = Field(default='unnamed', description='name of the scene')
    duration: Positive = Field(description='length of the scene [s]')
    starts_at: Positive = Field(default=DAY_S, description='stamp of the first sample [s]')
    seed: Annotated[int, Strict(), Field(ge=0, le=2**63 - 1)] = Field(
        default=1726, description='seed of everything random, 0 to 2**63 - 1'
    )
    gravity: Positive = Field(
        default=STANDARD_GRAVITY, description='acceleration of gravity [m/s2]'
    )
    trochlea: Trochlea | None = Field(
        default=None,
        description='mapping: inertia, cam, thread, power, release_angle of the regulator',
    )
    regulator: FluidTautochroneRegulator | None = Field(
        default=None, description='mapping with `kind`: what swings in place of a trochlea'
    )
    drag: Drag | None = Field(default=None, description='mapping: viscous, quadratic, coulomb')
    escapement: Escapement | None = Field(default=None, description='mapping: kind, energy, angle')
    ship: Ship = Field(default=StillShip(), description='mapping with `kind` and how it moves')
    suspension: AxleSuspension | None = Field(
        default=None,
        description='mapping: kind, support_radius, axle_radius, depth, gyration_radius, …',
    )
    clock: Clock = Field(default=Clock(), description='mapping: nominal_period')
    voyage: Voyage | None = Field(
        default=None, description='mapping: departure, arrival, sails_at, arrives_at'
    )
    drift: DriftSettings = Field(
        default=DriftSettings(), description='mapping: observation_interval, …'
    )
    log: Log = Field(default=Log(), description='mapping: interval, motion')
    solver: Solver | None = Field(default=None, description='mapping: tolerance')

    @model_validator(mode='after')
    def _refuse_impossible_combinations(self) -> Scene:
        found = tuple(problems(self))
        if found:
            raise PydanticCustomError(
                'combination', '{summary}', {'summary': str(found[0]), 'problems': found}
            )
        return self

    @property
    def starts_at_ns(self) -> int:
        """Stamp of the first sample [ns]."""
        return nanoseconds(self.starts_at)

    @property
    def duration_ns(self) -> int:
        """Length of the scene [ns]."""
        return nanoseconds(self.duration)

    @property
    def log_interval_ns(self) -> int:
        """Time between logged samples [ns]."""
        return nanoseconds(self.log.interval)

    @property
    def step_ns(self) -> int:
        """Time between samples of ship/imu [ns]; a still ship sends one per log interval."""
        if isinstance(self.ship, StillShip):
            return self.log_interval_ns
        return step_of_rate(self.ship.rate)

    @property
    def samples(self) -> int:
        """Number of samples of ship/imu within the duration, both ends counted."""
        return self.duration_ns // self.step_ns + 1

    @property
    def samples_beyond_end(self) -> int:
        """Samples of ship/imu that the stages need beyond the end: none of a still ship."""
        return 0 if isinstance(self.ship, StillShip) else samples_beyond_end(self)

    @property
    def log_count(self) -> int:
        """Number of logged samples, both ends counted."""
        return self.duration_ns // self.log_interval_ns + 1

    @property
    def keeps_motion(self) -> bool:
        """Whether the bag keeps ship/imu at its full rate."""
        if self.log.motion is None:
            return self.duration <= DAY_S
        return self.log.motion
