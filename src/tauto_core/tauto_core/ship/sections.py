"""Sections that describe a ship in a sea: spectrum, roll, response operator, the hung case."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, SerializerFunctionWrapHandler, Strict, model_serializer

from tauto_core.scene.errors import ABSENT, Problem
from tauto_core.scene.sections import NonNegative, Number, OneLine, Positive, Section
from tauto_core.scene.times import STANDARD_GRAVITY
from tauto_core.ship.motions import sampled
from tauto_core.wording import counted

# -----------------------------------------------------------------------------
ComponentCount: TypeAlias = Annotated[int, Strict(), Field(ge=1, le=4096)]
# Out of range: 90, meant in degrees.
Heading: TypeAlias = Annotated[float, Strict(), Field(ge=0.0, lt=math.tau)]


RAO_HEADING_MEANS = (
    'direction in which the waves run, from the bow to port [rad]: 0 following seas, 1.5708 beam '
    'seas, 3.1416 head seas. The operator then has this heading alone, in all weather. When left '
    'out: all headings, by ship.heading or the weather'
)
RAO_LENGTH_MEANS = (
    'length of the ship between perpendiculars [m], 2 to 400: an operator at rest is then carried '
    'over to Froude numbers up to 0.25 alone, and the clock is within the ship'
)

CUTOFF = 4.0
"""Highest frequency of the waves over the peak's: all but 0.5 % of a Bretschneider sea's energy,
but not of its accelerations, which have no limit without a hull (hull.md).
"""
LEAST_CUTOFF = 1.5
Cutoff: TypeAlias = Annotated[float, Strict(), Field(ge=LEAST_CUTOFF, le=32.0)]
MOST_CUTOFF = 8.0
CUTOFF_MEANS = (
    'highest frequency of the components over the peak frequency, 1.5 to 32. When left out 4, '
    'with a hull the frequency of waves a tenth as long as it, within 4 to 8'
)


def cutoff_for(length: float | None, peak_period: float) -> float:
    """Return the cutoff of a sea; for a hull [m] at waves of a tenth of its length (hull.md)."""
    if length is None:
        return CUTOFF
    return min(max(still_from(length, peak_period), CUTOFF), MOST_CUTOFF)


def still_from(length: float, peak_period: float) -> float:
    """Return the frequency of waves of a tenth of a length [m], over the peak frequency."""
    highest = math.sqrt(20.0 * math.pi * STANDARD_GRAVITY / length)
    return highest * peak_period / math.tau


class Sea(Section):
    """Long-crested sea with a standard spectrum, represented by a number of components."""

    spectrum: Literal['bretschneider', 'jonswap'] = Field(description='bretschneider or jonswap')
    significant_wave_height: Annotated[float, Strict(), Field(gt=0.0, le=100.0)] = Field(
        description='significant wave height, at most 100 [m]'
    )
    peak_period: Positive = Field(description='period of the spectral peak [s]')
    gamma: Annotated[float, Strict(), Field(ge=1.0, le=10.0)] = Field(
        default=3.3, description='peak enhancement factor of jonswap, 1 to 10, when left out 3.3'
    )
    components: ComponentCount = Field(default=64, description='number of components, 1 to 4096')
    cutoff: Cutoff = Field(default=CUTOFF, description=CUTOFF_MEANS)

    @model_serializer(mode='wrap')
    def _without_foreign_gamma(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        keys: dict[str, Any] = handler(self)
        if self.spectrum != 'jonswap':
            del keys['gamma']
        return keys

    def problems(self, rate_hz: float) -> Iterator[Problem]:
        """Yield its problems for a ship sampled at a rate [Hz]."""
        yield from sampled('ship.sea.peak_period', self.peak_period, rate_hz)
        if self.spectrum == 'bretschneider' and 'gamma' in self.model_fields_set:
            yield Problem(
                'ship.sea.gamma',
                self.gamma,
                'does not go with spectrum bretschneider, which has no peak enhancement',
                'Leave it out, or use spectrum jonswap.',
            )


class SpectrumTable(Section):
    """Measured spectrum of a long-crested sea, linear between its rows."""

    spectrum: Literal['table'] = Field(description='table')
    source: OneLine = Field(description='origin and time of the spectrum')
    frequency: tuple[Positive, ...] = Field(description='list of increasing frequencies [Hz]')
    energy_density: tuple[NonNegative, ...] = Field(
        description='list of energy densities [m2/Hz], one for each frequency'
    )
    components: ComponentCount = Field(default=64, description='number of components, 1 to 4096')

    def problems(self, rate_hz: float) -> Iterator[Problem]:
        """Yield the problems of its rows. The rate is checked once the speed is known."""
        yield from _rising('ship.sea.frequency', self.frequency, 'Hz')
        yield from _as_many('ship.sea.energy_density', self.energy_density, len(self.frequency))
        if not any(self.energy_density):
            yield Problem(
                'ship.sea.energy_density',
                ABSENT,
                'is 0 m2/Hz at all frequencies: the spectrum is empty',
                'Choose another spectrum, or ship kind still for a calm.',
            )


class Roll(Section):
    """Linear roll: ρ̈ + 2ζω_nρ̇ + ω_n²ρ = ω_n² κ_e · wave slope (sea.md)."""

    natural_period: Positive = Field(description='natural period 2π/ω_n of the roll [s]')
    damping_ratio: Positive = Field(description='damping ratio ζ, > 0')
    slope_coefficient: NonNegative | None = Field(
        default=None,
        description='effective wave-slope coefficient κ_e, not used with a hull',
    )
    fitted_to: OneLine | None = Field(
        default=None, description='origin of period and damping ratio, for example a decay test'
    )


class HullWeights(Section):
    """Length of a hull and distribution of its weights (hull.md)."""

    length: Positive | None = Field(
        default=None, description='length of the waterline, to which the shape is scaled [m]'
    )
    k_xx: Positive | None = Field(
        default=None, description='radius of gyration in roll [m], when left out 0.38 of the beam'
    )
    k_yy: Positive | None = Field(
        default=None, description='in pitch [m], when left out 0.25 of the length'
    )
    k_zz: Positive | None = Field(
        default=None, description='in yaw [m], when left out 0.25 of the length'
    )
    centre_of_gravity: Number | None = Field(
        default=None,
        description="height of the ship's centre of gravity over the waterline [m], when left out "
        'the height that gives the roll its period. A given height changes inertia and pitch, '
        'not the righting moment in roll, which follows from the period',
    )


class HullSection(HullWeights):
    """Hull of a ship: a named shape, or the coefficients of a file, and its weights."""

    shape: OneLine | None = Field(
        default=None, description='sloop, deptford, ketch or yacht: parametric forms'
    )
    table: Annotated[str, Strict(), Field(max_length=1_000_000)] | None = Field(
        default=None, description='contents of the file of a `path`, in base64'
    )

    def problems(self) -> Iterator[Problem]:
        """Yield a problem unless it has either a shape or a table."""
        if (self.shape is None) == (self.table is None):
            yield Problem(
                'ship.hull',
                ABSENT,
                f'has {"neither" if self.shape is None else "both"} a shape '
                f'{"nor" if self.shape is None else "and"} a path',
                'Give `shape: sloop`, or `path: …` of a file that `tauto hull` has written.',
            )


class ClockSection(Section):
    """Place of the clock in the ship. Its height is `ship.height`."""

    forward: Number = Field(default=0.0, description='forward of amidships [m]')
    port: Number = Field(default=0.0, description='to port of the centreline [m]')


MOTIONS = ('surge', 'sway', 'heave', 'roll', 'pitch', 'yaw')
"""Motions of a ship forward, to port and up, and the rotations about these axes."""


ATHWART = ('sway', 'roll', 'yaw')
"""Motions that change sign in waves from the other side."""
ANGLES = MOTIONS[3:]


def _part(of: str) -> Any:
    return Field(default=None, description=f'list of {of}')


OperatorRow: TypeAlias = tuple[Number, ...]


class Rao(Section):
    """Response amplitude operator of a ship: factors of exp(iωt) per metre of wave amplitude.

    Each list of a motion has all frequencies at the first speed and heading, then at the next
    heading, then at the next speed. A motion without lists is left out.
    """

    source: OneLine = Field(description='origin of the operator')
    heading: Heading | None = Field(default=None, description=RAO_HEADING_MEANS)
    length: Annotated[float, Strict(), Field(ge=2.0, le=400.0)] | None = Field(
        default=None, description=RAO_LENGTH_MEANS
    )
    speeds: tuple[NonNegative, ...] | None = Field(
        default=None,
        description='list of increasing speeds [m/s] of the operator. When left out it is one at '
        'rest, carried over to ship.speed',
    )
    headings: tuple[Annotated[float, Strict(), Field(ge=0.0, le=math.pi)], ...] | None = Field(
        default=None, description='list of increasing headings, 0 to π [rad], in place of heading'
    )
    angular_frequency: tuple[Positive, ...] = Field(
        description='list of increasing ω of the waves [rad/s]'
    )
    roll_real: OperatorRow | None = _part('real parts of the roll [rad/m]')
    roll_imaginary: OperatorRow | None = _part('imaginary parts of the roll [rad/m]')
    heave_real: OperatorRow | None = _part('real parts of the heave [m/m]')
    heave_imaginary: OperatorRow | None = _part('imaginary parts of the heave [m/m]')
    surge_real: OperatorRow | None = _part('real parts of the surge [m/m]')
    surge_imaginary: OperatorRow | None = _part('imaginary parts of the surge [m/m]')
    sway_real: OperatorRow | None = _part('real parts of the sway [m/m]')
    sway_imaginary: OperatorRow | None = _part('imaginary parts of the sway [m/m]')
    pitch_real: OperatorRow | None = _part('real parts of the pitch [rad/m]')
    pitch_imaginary: OperatorRow | None = _part('imaginary parts of the pitch [rad/m]')
    yaw_real: OperatorRow | None = _part('real parts of the yaw [rad/m]')
    yaw_imaginary: OperatorRow | None = _part('imaginary parts of the yaw [rad/m]')

    @property
    def motions(self) -> tuple[str, ...]:
        """The motions that it has."""
        return tuple(name for name in MOTIONS if getattr(self, f'{name}_real') is not None)

    @property
    def turns_in_space(self) -> bool:
        """Whether all its motions are simulated, since it has more than roll and heave."""
        return not {'roll'} <= set(self.motions) <= {'roll', 'heave'}

    def problems(self, *, heave: bool) -> Iterator[Problem]:
        """Yield the problems of its rows, and the lack of a requested heave."""
        if (self.heading is None) == (self.headings is None):
            yield Problem(
                'ship.rao.heading',
                ABSENT if self.heading is None else self.heading,
                'is missing, and there are no headings in its place'
                if self.heading is None
                else 'does not go with ship.rao.headings',
                'Give either heading or headings.',
            )
        wanted = len(self.angular_frequency)
        yield from _rising('ship.rao.angular_frequency', self.angular_frequency, 'rad/s')
        for name, unit in (('speeds', 'm/s'), ('headings', 'rad')):
            rows = getattr(self, name)
            if rows is not None:
                yield from _rising(f'ship.rao.{name}', rows, unit, fewest=1)
                wanted *= len(rows)
        if not self.motions:
            yield Problem(
                'ship.rao', ABSENT, 'has no motion', f'Give one of {", ".join(MOTIONS)}.'
            )
        for name in MOTIONS:
            for part in ('real', 'imaginary'):
                values = getattr(self, f'{name}_{part}')
                # a motion needs both parts
                if values is not None or getattr(self, f'{name}_real') is not None:
                    yield from _as_many(f'ship.rao.{name}_{part}', values or (), wanted)
        if heave and 'heave' not in self.motions:
            yield Problem(
                'ship.heave',
                True,
                'asks for heave, which the operator does not have',
                'Give an operator with the columns heave_re and heave_im, or leave heave out.',
            )


def _rising(key: str, values: Sequence[float], unit: str, fewest: int = 2) -> Iterator[Problem]:
    if len(values) < fewest:
        problem = f'has less than {counted(fewest, "value")}'
        yield Problem(key, list(values), problem, f'Give {fewest} or more.')
    for index, (previous, current) in enumerate(pairwise(values), start=1):
        if not current > previous:
            yield Problem(
                f'{key}[{index}]',
                current,
                f'must be greater than the one before, {previous!r} {unit}',
                'Sort them, and drop duplicates.',
            )
            return


def _as_many(key: str, values: Sequence[float], wanted: int) -> Iterator[Problem]:
    if len(values) != wanted:
        yield Problem(
            key,
            ABSENT,
            f'has {len(values)} values for {wanted} frequencies',
            'Give one for each frequency, heading and speed.',
        )


def names_hindcast(section: object) -> bool:
    """Return whether unchecked weather or air refers to a hindcast's file."""
    if not isinstance(section, dict):
        return False
    return section.get('kind') == 'hindcast' and 'seas' not in section
