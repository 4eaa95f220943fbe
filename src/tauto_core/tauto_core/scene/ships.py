"""Models of the ship: how it moves, and how the clock's case hangs in it."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, SerializerFunctionWrapHandler, Strict, model_serializer

from tauto_core.scene.fields import Flag, NonNegative, Number, Positive, Section, Text


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
