"""Models of the ship: how it moves, and how the clock's case hangs in it."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, SerializerFunctionWrapHandler, Strict, model_serializer

from tauto_core.scene.fields import Flag, NonNegative, Number, Positive, Section, Text

ComponentCount: TypeAlias = Annotated[int, Strict(), Field(ge=1, le=4096)]
# Courses are in degrees elsewhere; 90 is out of range, so that it is not taken for radians.
Heading: TypeAlias = Annotated[float, Strict(), Field(ge=0.0, lt=math.tau)]


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
    components: ComponentCount = Field(default=64, description='number of components, 1 to 4096')

    @model_serializer(mode='wrap')
    def _without_foreign_gamma(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        keys: dict[str, Any] = handler(self)
        if self.spectrum != 'jonswap':
            del keys['gamma']
        return keys


class SpectrumTable(Section):
    """Measured spectrum of a long-crested sea, linear between its rows."""

    spectrum: Literal['table'] = Field(description='table')
    source: Text = Field(description='where the spectrum is from, and of when')
    frequency: tuple[Positive, ...] = Field(description='list of rising frequencies [Hz]')
    energy_density: tuple[NonNegative, ...] = Field(
        description='list of energy densities [m2/Hz], one a frequency'
    )
    components: ComponentCount = Field(default=64, description='number of components, 1 to 4096')


class Roll(Section):
    """Linear roll: ρ̈ + 2ζω_nρ̇ + ω_n²ρ = ω_n² κ_e · wave slope (theory E5)."""

    natural_period: Positive = Field(description='natural period 2π/ω_n of the roll [s]')
    damping_ratio: Positive = Field(description='damping ratio ζ, > 0')
    slope_coefficient: NonNegative = Field(description='effective wave-slope coefficient κ_e')
    fitted_to: Text | None = Field(
        default=None, description='decay test that period and damping ratio are from'
    )


class Rao(Section):
    """Response amplitude operator at one heading, of exp(iωt), for a ship at rest."""

    source: Text = Field(description='where the operator is from')
    heading: Heading = Field(
        description='direction the waves run to, from the bow to port [rad]: 0 following, 1.5708 '
        'beam, 3.1416 head seas'
    )
    angular_frequency: tuple[Positive, ...] = Field(description='list of rising ω [rad/s]')
    roll_real: tuple[Number, ...] = Field(description='list of real parts of the roll [rad/m]')
    roll_imaginary: tuple[Number, ...] = Field(description='list of imaginary parts [rad/m]')
    heave_real: tuple[Number, ...] | None = Field(
        default=None, description='list of real parts of the heave [m/m]'
    )
    heave_imaginary: tuple[Number, ...] | None = Field(
        default=None, description='list of imaginary parts of the heave [m/m]'
    )


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
    """Roll, and heave where asked, from a sea that the ship meets at a speed and heading.

    Roll follows from `roll` or from `rao`. Heave is the elevation, or what `rao` makes of it.
    """

    kind: Literal['sea'] = 'sea'
    sea: Annotated[Sea | SpectrumTable, Field(discriminator='spectrum')] = Field(
        description='mapping: spectrum, significant_wave_height, peak_period, …; or spectrum '
        'file, path',
        # read before a scene is checked, and then a table
        examples=['file'],
    )
    roll: Roll | None = Field(
        default=None,
        description='mapping: natural_period, damping_ratio (or decay), slope_coefficient',
    )
    rao: Rao | None = Field(default=None, description='mapping: path, heading')
    heading: Heading | None = Field(
        default=None,
        description='with roll: direction the waves run to, from the bow to port [rad]: 0 '
        'following, 1.5708 beam (when left out), 3.1416 head seas',
    )
    speed: Annotated[float, Strict(), Field(ge=0.0, le=50.0)] = Field(
        default=0.0, description='speed of the ship, at most 50 [m/s]'
    )
    heave: Flag = Field(default=False, description='true: heave is simulated')

    @property
    def relative_heading(self) -> float:
        """Direction the waves run to, from the bow to port [rad], of `rao` or `heading`."""
        if self.rao is not None:
            return self.rao.heading
        return 0.5 * math.pi if self.heading is None else self.heading


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
