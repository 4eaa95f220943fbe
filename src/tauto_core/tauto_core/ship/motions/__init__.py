"""The kinds of ship's motion: their base, the ship at rest, and given harmonics.

Level axes: x along the mean heading, y to port, z up. The ship's own axes follow from them by yaw
ψ about z (bow to port), pitch θ about y (bow down) and roll ρ about x (starboard down), in this
order.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field, fields, replace
from typing import Annotated, Any, ClassVar, Generic, Literal, NamedTuple, Protocol, Self, TypeVar

import numpy as np
from pydantic import Field

from tauto_core.scene.errors import Problem, problems_where
from tauto_core.scene.sections import Itinerary, Kind, NonNegative, Number, Positive, Section
from tauto_core.ship.waves import Fades, Harmonics

FOLDER = 'tauto_core.ship.motions'


M = TypeVar('M', Harmonics, Fades)


@dataclass(frozen=True)
class SixMotions(Generic[M]):
    """The motions of a ship, each a sum of harmonics, with the displacements of the clock.

    Attributes:
        surge: forward [m].
        sway: to port [m].
        heave: up [m].
        roll: starboard down [rad].
        pitch: bow down [rad].
        yaw: bow to port [rad].
    """

    surge: M
    sway: M
    heave: M
    roll: M
    pitch: M
    yaw: M


class Surroundings(Protocol):
    """The parts of a scene on which a ship's motion depends."""

    @property
    def name(self) -> str:
        """Name of the scene, for error messages."""

    @property
    def seed(self) -> int:
        """Seed of all random numbers."""

    @property
    def g(self) -> float:
        """Acceleration of gravity at the start [m/s2]."""

    @property
    def duration(self) -> float:
        """Length of the scene [s]."""

    @property
    def duration_ns(self) -> int:
        """Length of the scene [ns]."""

    @property
    def log_interval_ns(self) -> int:
        """Log interval [ns]. The scene lasts a whole number of them."""

    @property
    def voyage(self) -> Itinerary | None:
        """The voyage from port to port, or `None`."""


@dataclass(frozen=True)
class Channels:
    """The simulated motions (`None` without), and the specific force if it was measured.

    A motion is a sum of harmonics, or in weather changes gradually from sum to sum.

    Attributes:
        roll: [rad], starboard down positive.
        heave: [m], upwards.
        force_y: specific force along the ship's y [m/s2].
        force_z: specific force along the ship's z [m/s2].
        metadata: describes the source of the motion.
        warnings: its peculiarities.
        six: all motions at the clock of a ship with a hull. They include `roll` and `heave`.
    """

    roll: Harmonics | Fades | None = None
    heave: Harmonics | Fades | None = None
    force_y: Harmonics | None = None
    force_z: Harmonics | None = None
    metadata: dict[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    six: SixMotions[Harmonics] | SixMotions[Fades] | None = None

    def moves(self) -> tuple[tuple[str, ...], ...]:
        """Return the motions that act on a clock, in groups that cannot be separated.

        A measured force contains the roll. With a hull, yaw acts on the clock in the same way as
        pitch.
        """
        if self.six is not None:
            return (('heave',), ('sway',), ('surge',), ('roll',), ('pitch', 'yaw'))
        if self.force_z is not None:
            return (('roll', 'force_y', 'force_z'),)
        return tuple((name,) for name in ('heave', 'roll') if getattr(self, name) is not None)

    def without(self, names: Collection[str]) -> Channels:
        """Return the same with some motions switched off. A force keeps its mean."""
        present = [name for name in ('roll', 'heave', 'force_y', 'force_z') if name in names]
        changed: dict[str, Any] = {name: _quiet(name, getattr(self, name)) for name in present}
        if self.six is not None:
            six: dict[str, Any] = {
                item.name: _quiet(item.name, getattr(self.six, item.name))
                for item in fields(self.six)
                if item.name in names
            }
            changed['six'] = replace(self.six, **six)
        return replace(self, **changed)


def _quiet(name: str, motion: Harmonics | Fades | None) -> Harmonics | Fades | None:
    """Return a motion without its waves."""
    if isinstance(motion, Fades):
        return replace(motion, of=lambda _: None)
    zero = np.zeros(1)
    mean = motion.mean if motion is not None and name.startswith('force') else 0.0
    return None if motion is None else Harmonics(zero, zero + 1.0, zero, mean)


class WorstSea(NamedTuple):
    """A sea in which the simulation may err most.

    Attributes:
        why: `highest`, `met fastest`, or both.
        figures: its state of the weather in reports, or `None` without weather.
        ship: the ship in it.
        lasts_s: time in it that causes the same error, if errors do not grow afterwards, as
            sampling all seas of the scene [s].
    """

    why: str
    figures: dict[str, Any] | None
    ship: ShipKind
    lasts_s: float


class UncertainNumber(NamedTuple):
    """A number of a ship that is known roughly.

    Attributes:
        key: its key in the scene.
        unit: of the values, or ''.
        values: its least and its largest value.
        ships: the ship with each of them.
    """

    key: str
    unit: str
    values: tuple[float, float]
    ships: tuple[ShipKind, ShipKind]


class ShipKind(Kind):
    """How the ship moves. Each kind is a module of `ship/motions` that names its model `KIND`.

    Attributes:
        lies_still: whether the ship is at rest and sends one sample per log interval.
        is_computed: whether its harmonics are the motion itself, not a measured one: smooth at the
            start, with known waves and a roll that can be scaled.
        is_random: whether it is drawn from the seed.
    """

    is_random: ClassVar[bool] = False
    lies_still: ClassVar[bool] = False
    is_computed: ClassVar[bool] = True

    rate: Positive = Field(default=20.0, description='sampling rate of the motion [Hz]')
    height: Number = Field(
        default=3.0,
        description='height of the clock above the roll axis [m], with a hull over the waterline',
    )
    kind: str

    @property
    def reported_as(self) -> str:
        """Key of its metadata in reports and bags, or ''."""
        return ''

    @property
    def shortest_wave_s(self) -> float:
        """Shortest given period of its waves [s], or inf."""
        return math.inf

    @classmethod
    def with_files_read(cls, ship: dict[str, Any], origin: str) -> dict[str, Any]:
        """Return its unchecked keys with the contents of the files that they name.

        `origin` names the scene in errors.

        Raises:
            SceneError: wrong keys or files.
        """
        return ship

    def channels(self, scene: Surroundings) -> Channels:
        """Return the motions.

        Raises:
            MotionDataError: measured motion that cannot be used.
            SceneError: a sea for which the ship has no response.
        """
        raise NotImplementedError

    def metadata(self, scene: Surroundings) -> dict[str, Any]:
        """Return the metadata for reports and bags, under `reported_as`."""
        return {}

    def roughest(self, scene: Surroundings) -> ShipKind:
        """Return the ship in the highest sea of the scene, with harmonics as channels."""
        return self

    def worst_seas(self, scene: Surroundings) -> tuple[WorstSea, ...]:
        """Return the ship in each sea in which the simulation may err most.

        Their channels are harmonics for the whole scene.
        """
        return (WorstSea('the only sea', None, self, scene.duration),)

    def seas_at_start(self, scene: Surroundings) -> tuple[ShipKind, ...]:
        """Return the ship in each sea that it may meet first, with harmonics as channels."""
        return (self,)

    def known_roughly(self, scene: Surroundings) -> Iterator[UncertainNumber]:
        """Yield the ship's roughly known numbers, with their ranges."""
        return iter(())

    @property
    def roll_scales(self) -> bool:
        """Whether `with_roll_scaled` can change the roll alone."""
        return self.is_computed

    def with_roll_scaled(self, factor: float) -> Self:
        """Return the ship in the same waves with its roll times a factor, if `roll_scales`."""
        return self

    def files(self) -> Iterator[tuple[str, str, bool]]:
        """Yield key and path of the files that must exist, and whether a folder is allowed."""
        return iter(())

    def problems(self) -> Iterator[Problem]:
        """Yield the contradictions between its keys."""
        return iter(())

    @property
    def motions(self) -> tuple[str, ...]:
        """The motions that it has, by the names of `SixMotions`."""
        return tuple(item.name for item in fields(SixMotions))


def sampled(key: str, period: float, rate_hz: float) -> Iterator[Problem]:
    """Yield a problem if a wave is too short to be sampled."""
    return problems_where(
        (
            period * rate_hz <= 2.0,
            key,
            period,
            f'is not longer than two steps ({2.0 / rate_hz:.6g} s): ship.rate {rate_hz!r} Hz '
            'cannot sample it',
            'Use a longer period or a higher ship.rate.',
        )
    )


# -----------------------------------------------------------------------------
# The smallest kinds.


class StillShip(ShipKind):
    """A ship at rest, or a clock on land."""

    lies_still = True
    rank = 1

    kind: Literal['still'] = 'still'

    def channels(self, scene: Surroundings) -> Channels:
        """Return no motion."""
        return Channels()

    @property
    def motions(self) -> tuple[str, ...]:
        """No motions."""
        return ()


class Component(Section):
    """One harmonic: amplitude · cos(2π t/period + phase), t from the start of the scene."""

    amplitude: NonNegative = Field(description='amplitude, of roll [rad], of heave [m]')
    period: Positive = Field(description='period [s]')
    phase: Number = Field(default=0.0, description='phase at the start [rad]')


class ComponentsShip(ShipKind):
    """Roll, and optionally heave, as sums of harmonics."""

    rank = 2
    starter = {
        'components': [
            {'amplitude': 0.08, 'period': 11.0, 'phase': 0.3},
            {'amplitude': 0.03, 'period': 8.1, 'phase': 1.9},
        ],
        'heave': [{'amplitude': 0.5, 'period': 9.0, 'phase': 0.0}],
    }

    kind: Literal['components'] = 'components'
    components: tuple[Component, ...] = Field(
        default=(), description='list of {amplitude [rad], period [s], phase [rad]} of the roll'
    )
    heave: Annotated[tuple[Component, ...], Field(min_length=1)] | None = Field(
        default=None, description='list of {amplitude [m], period [s], phase [rad]} of the heave'
    )

    @property
    def shortest_wave_s(self) -> float:
        """Shortest given period [s], or inf."""
        waves = (*self.components, *(self.heave or ()))
        return min((wave.period for wave in waves), default=math.inf)

    def channels(self, scene: Surroundings) -> Channels:
        """Return the harmonics."""
        heave = None if self.heave is None else _harmonics(self.heave)
        metadata = {'components': len(self.components), 'heave': self.heave is not None}
        return Channels(_harmonics(self.components), heave, metadata=metadata)

    def with_roll_scaled(self, factor: float) -> Self:
        """Return the ship with all amplitudes of the roll times a factor."""
        scaled = tuple(
            part.model_copy(update={'amplitude': factor * part.amplitude})
            for part in self.components
        )
        return self.model_copy(update={'components': scaled})

    def problems(self) -> Iterator[Problem]:
        """Yield the contradictions between its keys."""
        if not self.components and self.heave is None:
            yield Problem(
                'ship.components',
                list(self.components),
                'has no component, and there is no heave either',
                'Give at least one {amplitude, period, phase}, or use kind still.',
            )
        for name, components in (('components', self.components), ('heave', self.heave or ())):
            for index, component in enumerate(components):
                yield from sampled(f'ship.{name}[{index}].period', component.period, self.rate)
        total = math.fsum(component.amplitude for component in self.components)
        if total >= math.pi / 2:
            yield Problem(
                'ship.components',
                total,
                'is the sum of the amplitudes [rad], which must be less than π/2: the ship '
                'would capsize',
                'Give amplitudes in radians, not degrees.',
            )

    @property
    def motions(self) -> tuple[str, ...]:
        """Roll and heave, if they are given."""
        return ('roll',) * bool(self.components) + ('heave',) * bool(self.heave)


def _harmonics(components: tuple[Component, ...]) -> Harmonics:
    return Harmonics(
        np.array([c.amplitude for c in components]),
        np.array([c.period for c in components]),
        np.array([c.phase for c in components]),
    )


KINDS = (StillShip, ComponentsShip)
