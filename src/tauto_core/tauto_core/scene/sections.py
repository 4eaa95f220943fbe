"""Base classes and types of the scene's models, and the sections with only one kind.

These are dial, navigator, log, solver and voyage.
"""

from __future__ import annotations

import datetime
import math
import pkgutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib import import_module
from itertools import pairwise
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Literal,
    NamedTuple,
    TypeAlias,
    Union,
    cast,
)

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    PlainSerializer,
    SerializerFunctionWrapHandler,
    Strict,
    ValidationError,
    WithJsonSchema,
    WrapValidator,
    model_serializer,
    model_validator,
)
from pydantic_core import CoreSchema, PydanticCustomError

from tauto_core.scene.errors import ABSENT, Problem, problems_where
from tauto_core.scene.times import (
    DAY_S,
    EARLIEST_YEAR,
    LAST_STAMP_S,
    LATEST_YEAR,
    nanoseconds,
    utc_in,
)
from tauto_core.scene.units import declared, in_unit, in_words

LONGEST_TEXT = 1000

Number: TypeAlias = Annotated[float, Strict()]
Positive: TypeAlias = Annotated[float, Strict(), Field(gt=0.0)]
NonNegative: TypeAlias = Annotated[float, Strict(), Field(ge=0.0)]
# from the start of the scene [s], within the range of stamps
SceneTime: TypeAlias = Annotated[float, Strict(), Field(ge=0.0, le=LAST_STAMP_S)]
Flag: TypeAlias = Annotated[bool, Strict()]
# no control characters, line or paragraph separators
OneLine: TypeAlias = Annotated[
    str,
    Strict(),
    Field(min_length=1, max_length=LONGEST_TEXT, pattern=r'^[^\p{Cc}\p{Zl}\p{Zp}]+$'),
]
Latitude: TypeAlias = Annotated[float, Strict(), Field(ge=-90.0, le=90.0)]
Longitude: TypeAlias = Annotated[float, Strict(), Field(ge=-180.0, le=180.0)]
Position: TypeAlias = tuple[Latitude, Longitude]


if TYPE_CHECKING:
    Gravity: TypeAlias = float | Literal['normal']
else:
    # a union would report errors for each of its members
    Gravity = Annotated[
        Positive,
        WrapValidator(lambda value, number: value if value == 'normal' else number(value)),
        PlainSerializer(lambda value: value),
        WithJsonSchema(
            {'anyOf': [{'type': 'number', 'exclusiveMinimum': 0.0}, {'const': 'normal'}]}
        ),
    ]


class Section(BaseModel):
    """Base of all models: frozen, no unknown keys, finite numbers.

    If the description of a key declares a unit, a text such as `5 mm` is converted to it.
    """

    model_config = ConfigDict(frozen=True, extra='forbid', allow_inf_nan=False)

    @model_validator(mode='before')
    @classmethod
    def _numbers_of_units(cls, keys: Any) -> Any:
        if not isinstance(keys, dict):
            return keys
        numbers = {}
        for key, value in keys.items():
            if key in cls.model_fields and in_words(value):
                unit = declared(cls.model_fields[key].description)
                numbers[key] = value if unit is None else in_unit(value, unit)
        return {**keys, **numbers} if numbers else keys


# -----------------------------------------------------------------------------
# Kinds of a section, found by listing their folder.
#
# The key `kind` selects the kind of a section such as `trochlea.cam`. Each kind is one module,
# with keys, checks, equations and messages, and lists its models in `KINDS`.


class Kind(Section):
    """Base of all kinds of one section.

    Attributes:
        rank: its order in lists, simplest first.
        starter: values of a new scene (`scene/reference.py`) for all keys without a default, for
            a machine with a period of about one second.
    """

    rank: ClassVar[int] = 100
    starter: ClassVar[Mapping[str, Any]] = {}


@cache
def kinds_in(folder: str) -> tuple[type[Kind], ...]:
    """Return the models of all kinds in a package, sorted by rank, then by module name.

    Each module has `KINDS`, a tuple of models, or `KIND`. The package may have `KINDS`, too.
    """
    package = import_module(folder)
    kinds: list[type[Kind]] = list(getattr(package, 'KINDS', ()))
    for name in sorted(item.name for item in pkgutil.iter_modules(package.__path__)):
        module = import_module(f'{folder}.{name}')
        kinds += getattr(module, 'KINDS', None) or [module.KIND]
    return tuple(sorted(kinds, key=lambda kind: kind.rank))


def kind_of(model: type[Kind]) -> str:
    """Return the value of the key `kind` for a model."""
    return str(model.model_fields['kind'].default)


@dataclass(frozen=True)
class KindIn:
    """Marks a field that takes any kind of a folder: `Annotated[CamKind, KindIn(folder)]`.

    Attributes:
        folder: name of the package.
        default: kind of a mapping without `kind`, if any.
        by: key that such a mapping must have.
    """

    folder: str
    default: str | None = None
    by: str | None = None

    @property
    def models(self) -> tuple[type[Kind], ...]:
        """The models of the folder."""
        return kinds_in(self.folder)

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Return the schema of the union of all kinds, discriminated by `kind`."""
        del source
        if len(self.models) == 1:
            return handler.generate_schema(self.models[0])
        union: Any = Annotated[Union[self.models], Field(discriminator='kind')]  # noqa: UP007
        if self.default is not None:
            union = Annotated[union, BeforeValidator(self._with_default)]
        return handler.generate_schema(union)

    def _with_default(self, value: object) -> object:
        if isinstance(value, dict) and 'kind' not in value and self.by in (None, *value):
            return {'kind': self.default, **cast(dict[str, object], value)}
        return value


# -----------------------------------------------------------------------------
# Sections with only one kind: dial, navigator, log, solver.

Wander: TypeAlias = Annotated[float, Strict(), Field(ge=0.0, le=DAY_S)]
Sigma: TypeAlias = Annotated[float, Strict(), Field(ge=1e-9, le=DAY_S)]
# a step rounds to several times 1.1e-16; 1e-3 of a swing is minutes per day
LEAST_TOLERANCE, LARGEST_TOLERANCE = 1e-15, 1e-3
LEAST_ACCURACY, LARGEST_ACCURACY = 1e-9, 1.0

ACCURACY = 1e-6
"""Default of the largest error of the reading in a day [s/day].

A thousandth of the error that a navigator could notice after a passage.
"""


def white_s(white_fm: float) -> float:
    """Return q1, the variance of the reading after a second [s²/s].

    `white_fm` is the standard deviation of the reading after a day [s].
    """
    return white_fm**2 / DAY_S


def walk_per_s(random_walk_fm: float) -> float:
    """Return q2, the variance of the relative rate after a second [1/s].

    `random_walk_fm` is the standard deviation of the rate after a day [s/day].
    """
    return (random_walk_fm / DAY_S) ** 2 / DAY_S


class Clock(Section):
    """The dial, by default regulated at the steady swing of the machine (reading.md)."""

    nominal_period: Positive | None = Field(
        default=None,
        description='time by which the dial advances in a full swing [s] (when left out: the '
        'period of the steady swing or, without one, of small swings)',
    )
    white_fm: Wander | None = Field(
        default=None,
        description='white frequency noise: standard deviation of the reading after a day, which '
        'grows with the square root of time, 0 to 86400 [s]',
    )
    random_walk_fm: Wander | None = Field(
        default=None,
        description='random walk of the frequency: standard deviation of the rate after a day, '
        'which grows with the square root of time, 0 to 86400 [s/day]',
    )

    @property
    def white_fm_s(self) -> float:
        """q1: variance of the reading after a second [s²/s]."""
        return white_s(self.white_fm or 0.0)

    @property
    def random_walk_fm_per_s(self) -> float:
        """q2: variance of the relative rate after a second [1/s]."""
        return walk_per_s(self.random_walk_fm or 0.0)

    @property
    def is_noisy(self) -> bool:
        """Whether the dial has noise."""
        return bool(self.white_fm or self.random_walk_fm)


class Lunars(Section):
    """Lunar distances at sea, which give the time by the Moon's motion among the stars.

    The Moon moves by half a degree per hour. Sextant and almanac together erred by half a minute
    of arc, which is a minute of time. According to Flinders (A Voyage to Terra Australis, 1814)
    the longitude from a set of six sights may be wrong by 30 minutes of arc (two minutes of time),
    and probably not by more than 12. A standard deviation of a minute agrees with both.
    """

    interval: Positive = Field(
        default=DAY_S, description='time between lunar distances at sea [s]'
    )
    sigma: Sigma = Field(
        default=60.0, description='standard deviation of their time, 1e-9 to 86400 [s]'
    )


Covariate: TypeAlias = Literal['heave', 'roll', 'gravity', 'temperature', 'temperature_squared']


class CoefficientPrior(Section):
    """Prior of a coefficient of the rate equation, before any observation."""

    value: Number = Field(
        description='expected coefficient, about 1 for a weight in heave and gravity'
    )
    sigma: Annotated[float, Strict(), Field(ge=1e-9, le=1e9)] = Field(
        description='its standard deviation, 1e-9 to 1e9'
    )


_TrialPrior: TypeAlias = Annotated[
    CoefficientPrior | None,
    Field(description='mapping: value, sigma (when left out: from trial runs)'),
]


class Coefficients(Section):
    """Priors of coefficients of the rate equation, in place of trial runs."""

    heave: _TrialPrior = None
    roll: _TrialPrior = None
    gravity: _TrialPrior = None
    temperature: CoefficientPrior | None = Field(
        default=None,
        description='mapping: value, sigma [1/K], 1.16e-5 is a second per day (when left out: '
        'from the machine at other temperatures)',
    )
    temperature_squared: CoefficientPrior | None = Field(
        default=None,
        description='mapping: value, sigma [1/K2] (when left out: from the machine at other '
        'temperatures)',
    )


class DriftSettings(Section):
    """The navigator's observations, and the assumptions of the drift estimate."""

    observation_interval: Positive = Field(
        default=DAY_S, description='time between observations in port [s]'
    )
    observation_sigma: Sigma = Field(
        default=0.5, description='standard deviation of an observation, 1e-9 to 86400 [s]'
    )
    lunars: Lunars | None = Field(
        default=None, description='mapping: interval, sigma of lunar distances between the ports'
    )
    gnss_sigma: Sigma | None = Field(
        default=None,
        description='standard deviation of the time that a GNSS receiver gives the graph (source '
        'gnss or gps), 1e-9 to 86400 [s] (when left out: 0.2, the delay of its messages)',
    )
    clouds: Annotated[float, Strict(), Field(ge=0.0, le=1.0)] = Field(
        default=0.0,
        description='share of the observations in port and by the Moon that clouds hide, 0 to 1',
    )
    states: Literal[2, 3] = Field(default=2, description='2: offset and rate, 3: ageing too')
    prior_rate_sigma: Sigma = Field(
        default=1000.0,
        description="prior standard deviation of the clock's rate, 1e-9 to 86400 [s/day] (the "
        'default covers a dial regulated for small swings, navigator.md)',
    )
    gate: Annotated[float, Strict(), Field(ge=1.0, le=1e9)] = Field(
        default=5.0,
        description='number of standard deviations beyond which an observation is refused as an '
        'outlier, 1 to 1e9 (1e9: all are used)',
    )
    white_fm: Wander | None = Field(
        default=None,
        description='white frequency noise that the navigator expects of the clock at sea, not '
        'simulated: standard deviation of the reading after a day, which grows with the square '
        'root of time, 0 to 86400 [s] (when left out: clock.white_fm)',
    )
    random_walk_fm: Wander | None = Field(
        default=None,
        description='random walk of the rate that the navigator expects of the clock at sea, not '
        'simulated: standard deviation of the rate after a day, which grows with the square root '
        'of time, 0 to 86400 [s/day] (when left out: clock.random_walk_fm, and in a voyage the '
        'effects of air, gravity and sea, navigator.md)',
    )
    covariates: Annotated[tuple[Covariate, ...], Field(min_length=1)] | None = Field(
        default=None,
        description='list of heave, roll, gravity, temperature, temperature_squared: motions of '
        'the ship, gravity by latitude, and temperature of the clock, the regressors of the rate '
        '(rate.md)',
    )
    coefficients: Coefficients | None = Field(
        default=None,
        description='mapping: heave, roll, gravity, temperature, temperature_squared (priors of '
        'the coefficients of the covariates)',
    )

    def problems(self) -> Iterator[Problem]:
        """Yield the problems of the covariates."""
        named = list(self.covariates or ())
        for name in sorted(set(named)):
            if named.count(name) > 1:
                yield Problem(
                    'drift.covariates', named, f'names {name} twice', 'Name each of them once.'
                )
        values = {} if self.coefficients is None else self.coefficients.model_dump()
        for key in (key for key, stated in values.items() if stated and key not in named):
            yield Problem(
                f'drift.coefficients.{key}',
                values[key],
                f'is unused: drift.covariates does not name {key}',
                f'Write covariates: [{", ".join([*named, key])}], or leave the coefficient out.',
            )


class Log(Section):
    """The log: one sample per interval, on request with the ship's motion at its full rate."""

    interval: Positive = Field(default=1.0, description='time between logged samples [s]')
    motion: Flag | None = Field(
        default=None,
        description='whether ship/imu is logged at its full rate (when left out: in scenes of up '
        'to a day)',
    )


class Solver(Section):
    """Settings of numerical propagators."""

    accuracy: Annotated[float, Strict(), Field(ge=LEAST_ACCURACY, le=LARGEST_ACCURACY)] | None = (
        Field(
            default=None,
            description='largest error of the reading in a day of the run [s/day], 1e-9 to 1 '
            f'(when left out without a tolerance: {ACCURACY:g}). It sets the tolerance and, '
            'unless given, ship.rate',
        )
    )
    tolerance: (
        Annotated[float, Strict(), Field(ge=LEAST_TOLERANCE, le=LARGEST_TOLERANCE)] | None
    ) = Field(
        default=None,
        description='largest relative error of a step, 1e-15 to 1e-3, in place of an accuracy',
    )

    def problems(self) -> Iterator[Problem]:
        """Yield the problem of an accuracy with a tolerance."""
        if self.accuracy is not None and self.tolerance is not None:
            yield Problem(
                'solver.tolerance',
                self.tolerance,
                f'follows from solver.accuracy {self.accuracy:g} s/day',
                'Leave one of them out.',
            )


# -----------------------------------------------------------------------------
# The voyage, from port to port.

WIDEST_AWARD_NMI = 60.0
"""Largest error for a prize by the Act of 1714 [nautical miles]."""

HIGHEST_LATITUDE_DEG = math.degrees(math.acos(WIDEST_AWARD_NMI / (180.0 * 60.0)))
"""89.68°. Nearer to a pole half a parallel, 10800′ cos φ, is shorter than `WIDEST_AWARD_NMI`."""

_NEAR_A_POLE = (
    f'is nearer to a pole than {HIGHEST_LATITUDE_DEG:.2f}°: any longitude there is within '
    f'{WIDEST_AWARD_NMI:g} nautical miles of any other'
)

SAME_PLACE_DEG = 1e-9
"""Smaller differences of latitude and longitude, 0.1 mm, are the same place."""


def _with_place(value: object) -> object:
    """Accept a waypoint written as `[latitude, longitude]`."""
    return {'place': value} if isinstance(value, list | tuple) else value


class Waypoint(Section):
    """A place that the ship passes, also written as `[latitude, longitude]`."""

    place: Position = Field(description='[latitude, longitude] in degrees, north and east +')
    landfall: Flag = Field(
        default=False,
        description='true: land is sighted, so the longitude is known and the clock is checked',
    )
    at: SceneTime | None = Field(
        default=None,
        description='time of passing it, from the start [s] (when left out: at constant speed '
        'between the given times)',
    )


def _plain_date(value: object) -> object:
    """Return a date, but not from numbers and times, which pydantic would convert."""
    if isinstance(value, datetime.date) and not isinstance(value, datetime.datetime):
        return value
    try:
        return datetime.date.fromisoformat(value if isinstance(value, str) else '')
    except ValueError:
        raise PydanticCustomError('date', 'is not a day, such as 1761-11-18') from None


# -----------------------------------------------------------------------------
# A log-book: places, times, wind and air (theory/logbooks.md).

FASTEST_KNOTS = 14.0
"""A faster step of a log is a correction of the reckoning [knots]."""

NEAREST_ENTRIES_S = 3600.0
"""Shortest time between two entries of a log [s]."""

STRONGEST_WIND = 40.0
"""Limit of winds, above the strongest class of the logs, 35 m/s [m/s]."""

AIR_CELSIUS = -60.0, 60.0
"""Limits of the air temperature at sea [°C]."""

FIRST_HOURS = 24.0
"""Duration of the first wind before its entry [h]."""

LEAST_WIND = 1.0
"""Weaker winds raise no sea [m/s]."""

VARIABLE_WINDS = (361.0, 362.0, 500.0, 999.0)
"""CLIWOC's numbers for a wind without a direction."""

LogEntry: TypeAlias = tuple[
    OneLine, Latitude, Longitude, Number | None, Number | None, Number | None
]
"""UTC, latitude, longitude, direction the wind comes from [deg], its speed [m/s], air [°C]."""


def has_wind(entry: LogEntry) -> bool:
    """Return whether an entry has the wind, with its direction unless it is weak."""
    wind_from, wind = entry[3:5]
    has_direction = wind_from is not None and wind_from not in VARIABLE_WINDS
    return wind is not None and (wind < LEAST_WIND or has_direction)


class EntryProblem(NamedTuple):
    """A problem of an entry of a log, numbered from 0."""

    entry: int
    column: str
    value: object
    problem: str
    remedy: str


def log_time(text: str) -> datetime.datetime:
    """Return the time of an entry, UTC without a zone, or raise ValueError."""
    return utc_in(text).replace(tzinfo=None)


@lru_cache(maxsize=64)
def _days(texts: tuple[str, ...]) -> tuple[float, ...]:
    """Return the times of entries since the first one [days]."""
    times = [log_time(text) for text in texts]
    return tuple((time - times[0]).total_seconds() / DAY_S for time in times)


def nautical_miles(a: Position, b: Position) -> float:
    """Return the distance between two places on a sphere [nmi], to half a per cent."""
    south, north = math.radians(a[0]), math.radians(b[0])
    east = math.radians(b[1] - a[1])
    part = math.sin(0.5 * (north - south)) ** 2
    part += math.cos(south) * math.cos(north) * math.sin(0.5 * east) ** 2
    return 10_800.0 / math.pi * 2.0 * math.asin(math.sqrt(min(part, 1.0)))


def entry_problems(entries: Sequence[LogEntry], longest_gap_days: float) -> Iterator[EntryProblem]:
    """Yield the problems of the entries of a log: times, jumps, winds and temperatures."""
    if len(entries) < 2:
        why = f'has {len(entries) or "no"} entr{"y" if len(entries) == 1 else "ies"}'
        yield EntryProblem(0, '', ABSENT, f'{why}: a passage needs two', 'Add more.')
    times: list[datetime.datetime] = []
    for number, (utc, latitude, longitude, *_) in enumerate(entries):
        try:
            times.append(log_time(utc))
        except ValueError as error:
            yield EntryProblem(number, 'utc', utc, str(error), 'Correct it.')
            return
        yield from _problems_of_entry(number, entries[number])
        if not number:
            continue
        took_s = (times[-1] - times[-2]).total_seconds()
        miles = nautical_miles(entries[number - 1][1:3], (latitude, longitude))
        if took_s < NEAREST_ENTRIES_S:
            why = 'is the time of the previous entry, too'
            if took_s < 0.0:
                why = f'is earlier than the previous entry, {entries[number - 1][0]}'
            elif took_s > 0.0:
                why = f'is {took_s / 60.0:.3g} minutes after the previous entry'
            remedy = 'Sort the entries, and keep one of two that are less than an hour apart.'
            yield EntryProblem(number, 'utc', utc, why, remedy)
        elif took_s > longest_gap_days * DAY_S:
            why = f'is {took_s / DAY_S:.3g} days after the previous entry; more than '
            why += f'{longest_gap_days:g} (longest_gap_days) are not bridged'
            yield EntryProblem(number, 'utc', utc, why, 'Cut the passage there, or fill the gap.')
        elif miles > FASTEST_KNOTS * took_s / 3600.0:
            why = f'is {miles:.0f} nautical miles from the previous entry, {took_s / 3600.0:.3g} '
            why += f'hours earlier; a ship makes at most {FASTEST_KNOTS:g} knots'
            remedy = 'Correct the place, or cut the passage where the reckoning was corrected.'
            yield EntryProblem(number, 'latitude', [latitude, longitude], why, remedy)


def _problems_of_entry(number: int, entry: LogEntry) -> Iterator[EntryProblem]:
    """Yield the problems of the place, wind and temperature of an entry."""
    _, latitude, _, wind_from, wind, celsius = entry
    knots = 'Leave it empty if it was not recorded.'
    if wind is not None and wind > 0.0:
        knots = f'Write {wind * 1852.0 / 3600.0:.3g} if it is in knots.'
    coldest, warmest = AIR_CELSIUS
    for is_wrong, column, value, why, remedy in (
        (abs(latitude) > HIGHEST_LATITUDE_DEG, 'latitude', latitude, _NEAR_A_POLE, 'Correct it.'),
        (
            not 0.0 <= (wind_from or 0.0) <= 360.0 and wind_from not in VARIABLE_WINDS,
            'wind_from_deg',
            wind_from,
            'must lie between 0 and 360 degrees from true north',
            'Leave it empty if the wind was variable.',
        ),
        (
            not 0.0 <= (wind or 0.0) <= STRONGEST_WIND,
            'wind_mps',
            wind,
            f'must lie between 0 and {STRONGEST_WIND:g} m/s; a hurricane has 35',
            knots,
        ),
        (
            not coldest <= (celsius or 0.0) <= warmest,
            'air_celsius',
            celsius,
            f'must lie between {coldest:g} and {warmest:g} °C',
            'Give it in °C.',
        ),
    ):
        if is_wrong:
            yield EntryProblem(number, column, value, why, remedy)


# keys of a log-book in the scene or in a file
_HarbourDays: TypeAlias = Annotated[
    float,
    Strict(),
    Field(
        ge=0.0,
        le=1000.0,
        description='time in still water at the place of the first entry before it, for rating '
        'the clock, 0 to 1000 [days]',
    ),
]
_LongestGapDays: TypeAlias = Annotated[
    Positive, Field(description='longest time between two entries that is bridged [days]')
]


class VoyageLog(Section):
    """A passage of a log-book, in place of departure, waypoints, arrival and times."""

    source: OneLine = Field(description='origin of the log')
    passage: OneLine = Field(description='name of the passage there')
    ship: OneLine | None = Field(default=None, description='name of the ship')
    nation: OneLine | None = Field(default=None, description='nation of the ship')
    sailed_from: OneLine | None = Field(default=None, description='port of departure')
    bound_to: OneLine | None = Field(default=None, description='port of destination')
    entries: Annotated[tuple[LogEntry, ...], Field(max_length=10_000)] = Field(
        description='list of at most 10000 [UTC, latitude, longitude, direction the wind comes '
        'from (degrees), its speed (m/s), air (°C)], the last three or null'
    )
    harbour_days: _HarbourDays = 0.0
    longest_gap_days: _LongestGapDays = 6.0

    @property
    def days(self) -> tuple[float, ...]:
        """Times of the entries since the first one [days]."""
        return _days(tuple(entry[0] for entry in self.entries))

    @property
    def at(self) -> tuple[float, ...]:
        """Times of the entries from the start of the scene [s]."""
        return tuple(round((self.harbour_days + day) * DAY_S, 3) for day in self.days)

    @property
    def begins(self) -> datetime.datetime:
        """UTC of the first entry."""
        return log_time(self.entries[0][0])

    def problems(self) -> Iterator[Problem]:
        """Yield the problems of its entries."""
        for item in entry_problems(self.entries, self.longest_gap_days):
            yield Problem(
                f'voyage.log.entries[{item.entry}]',
                item.value,
                f'{item.column} {item.problem}'.lstrip(),
                item.remedy,
            )

    def itinerary(self) -> dict[str, Any]:
        """Return the keys of the voyage that follow from the log."""
        start, *between, end = (entry[1:3] for entry in self.entries)
        sails_at, *times, arrives_at = self.at
        return {
            'departure': start,
            'waypoints': [
                {'place': place, 'at': at} for place, at in zip(between, times, strict=True)
            ]
            or None,
            'arrival': end,
            'date': self.begins.date(),
            'sails_at': sails_at,
            'arrives_at': arrives_at,
        }


class LogFile(Section):
    """A log-book in a file. The loaded scene contains the entries of the passage."""

    path: OneLine = Field(description='the log-book (`tauto logbook` lists its passages)')
    passage: OneLine | None = Field(
        default=None, description='name of the passage, unless the file has only one'
    )
    winds: OneLine | None = Field(
        default=None,
        description='for a track in GPX: CSV file with utc, wind_from_deg, wind_mps, air_celsius',
    )
    harbour_days: _HarbourDays = 0.0
    longest_gap_days: _LongestGapDays = 6.0


def log_of_voyage(voyage: object) -> VoyageLog | None:
    """Return the log of an unchecked voyage, None without a valid one."""
    if not isinstance(voyage, dict) or not isinstance(voyage.get('log'), dict):
        return None
    try:
        log = VoyageLog.model_validate(voyage['log'])
    except ValidationError:
        return None
    return None if any(log.problems()) else log


class Itinerary(Section):
    """A voyage from port to port, at constant speed between places with times."""

    departure: Position = Field(description='[latitude, longitude] in degrees, north and east +')
    waypoints: (
        Annotated[
            tuple[Annotated[Waypoint, BeforeValidator(_with_place)], ...], Field(max_length=10_000)
        ]
        | None
    ) = Field(
        default=None,
        description='list of [latitude, longitude] or {place: [latitude, longitude], '
        'landfall: true, at: 1e5}, at most 10000, in the order of the voyage',
    )
    arrival: Position = Field(description='[latitude, longitude] in degrees, north and east +')
    track: Literal['geodesic', 'rhumb'] | None = Field(
        default=None,
        description='geodesic, the shortest route between places, or rhumb, a constant course '
        '(when left out: geodesic)',
    )
    date: Annotated[datetime.date, BeforeValidator(_plain_date)] | None = Field(
        default=None,
        description='day of sailing, such as 1761-11-18, at Greenwich and in the Gregorian '
        'calendar, 1500 to 2999, for the climate of the air',
    )
    sails_at: SceneTime = Field(description='time of setting sail, from the start [s]')
    arrives_at: SceneTime | None = Field(
        default=None, description='time of landfall, from the start [s], or give speed'
    )
    speed: Positive | None = Field(
        default=None, description='speed over the ground [m/s], or give arrives_at'
    )
    log: VoyageLog | None = Field(
        default=None,
        description='mapping: path, passage, harbour_days (a log-book in place of departure, '
        'waypoints, arrival, date and times)',
    )

    @model_validator(mode='before')
    @classmethod
    def _by_its_log(cls, keys: Any) -> Any:
        """Take places and times from the log. A wrong log reports its own problems."""
        if not isinstance(keys, dict) or keys.get('log') is None:
            return keys
        log = log_of_voyage(keys)
        follows: dict[str, Any] = {'departure': (0.0, 0.0), 'arrival': (0.0, 0.0), 'sails_at': 0.0}
        if log is not None:
            follows = log.itinerary()
        problems = tuple(
            Problem(
                f'voyage.{key}',
                keys[key],
                'follows from voyage.log',
                'Leave one of them out.',
            )
            for key in _BY_LOG
            if keys.get(key) is not None
        )
        if problems:
            raise PydanticCustomError(
                'combination', '{summary}', {'summary': str(problems[0]), 'problems': problems}
            )
        return {**keys, **follows}

    @model_serializer(mode='wrap')
    def _without_what_the_log_says(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        keys: dict[str, Any] = handler(self)
        if self.log is not None:
            keys = {key: value for key, value in keys.items() if key not in _BY_LOG}
        return keys

    @property
    def places(self) -> tuple[Position, ...]:
        """Departure, waypoints, arrival."""
        between = (point.place for point in self.waypoints or ())
        return (self.departure, *between, self.arrival)

    @property
    def times(self) -> tuple[float | None, ...]:
        """Given times at each of the places [s]."""
        between = (point.at for point in self.waypoints or ())
        return (self.sails_at, *between, self.arrives_at)

    def day_at(self, stamp_s: float, starts_at: float) -> float:
        """Return the proleptic Gregorian ordinal of a stamp [days], with a `date`.

        Stamp 0 is midnight at Greenwich.

        Args:
            stamp_s: the stamp [s].
            starts_at: stamp of the start of the scene [s].
        """
        assert self.date is not None
        sails = math.floor((starts_at + self.sails_at) / DAY_S)
        return self.date.toordinal() - sails + stamp_s / DAY_S

    def problems(self) -> Iterator[Problem]:
        """Yield the problems of the keys, without computing the route."""
        wrong = [] if self.log is None else list(self.log.problems())
        if wrong:
            yield from wrong
            return
        year = EARLIEST_YEAR if self.date is None else self.date.year
        arrives_ns = math.inf if self.arrives_at is None else nanoseconds(self.arrives_at)
        yield from problems_where(
            (
                not EARLIEST_YEAR <= year <= LATEST_YEAR,
                'voyage.date',
                str(self.date),
                f'must lie in the years {EARLIEST_YEAR} to {LATEST_YEAR}',
                'Write year, month and day, such as 1761-11-18.',
            ),
            (
                self.arrives_at is None and self.speed is None,
                'voyage.arrives_at',
                ABSENT,
                'is missing, and there is no speed',
                'Write `arrives_at: …`, time of landfall from the start [s], or `speed: …` [m/s].',
            ),
            (
                self.arrives_at is not None and self.speed is not None,
                'voyage.speed',
                self.speed,
                f'does not go with voyage.arrives_at, {self.arrives_at!r} s',
                'Leave one of them out.',
            ),
            (
                arrives_ns <= nanoseconds(self.sails_at),
                'voyage.arrives_at',
                self.arrives_at,
                f'must be later than voyage.sails_at, {self.sails_at!r} s, by a nanosecond or '
                'more',
                'Give both from the start of the scene, in the order of the voyage.',
            ),
        )
        yield from self._out_of_order()
        for index, (latitude, longitude) in enumerate(self.places):
            if abs(latitude) > HIGHEST_LATITUDE_DEG:
                yield Problem(
                    key_of_place(self, index),
                    [latitude, longitude],
                    _NEAR_A_POLE,
                    'Choose a place farther from the pole.',
                )
        for index, (a, b) in enumerate(pairwise(self.places), 1):
            turn = abs(math.remainder(b[1] - a[1], 360.0))
            is_same = max(abs(b[0] - a[0]), turn) < SAME_PLACE_DEG
            lies_there = None not in self.times[index - 1 : index + 1]
            # a ship may stay in port throughout, but then a time of arrival is needed
            if is_same and not lies_there and (self.waypoints or self.speed is not None):
                yield Problem(
                    key_of_place(self, index),
                    list(b),
                    f'is the same place as {key_of_place(self, index - 1)}, before it',
                    'Leave one of them out, correct it, or give both a time `at`.'
                    if self.waypoints
                    else 'Give arrives_at in place of speed, or correct the place.',
                )
            elif self.track == 'rhumb' and turn == 180.0:
                yield Problem(
                    key_of_place(self, index),
                    list(b),
                    f'is 180° of longitude from {key_of_place(self, index - 1)}: the rhumb lines '
                    'to the east and to the west are equally long',
                    'Put a waypoint on the intended side.',
                )

    def _out_of_order(self) -> Iterator[Problem]:
        """Yield the problems of the times of waypoints."""
        timed = [(index, at) for index, at in enumerate(self.times) if at is not None]
        ends = timed if self.arrives_at is None else timed[:-1]
        for index, at in ends[1:] if self.speed is not None else ():
            yield Problem(
                f'{key_of_place(self, index)}.at',
                at,
                'does not go with voyage.speed: speeds follow from the times',
                'Give arrives_at in place of speed.',
            )
            return
        for (prior, earlier), (index, at) in pairwise(timed):
            first_to_last = prior == 0 and index == len(self.places) - 1
            if not first_to_last and nanoseconds(at) <= nanoseconds(earlier):
                key = key_of_place(self, index)
                yield Problem(
                    'voyage.arrives_at' if key == 'voyage.arrival' else f'{key}.at',
                    at,
                    f'must be later than the time of {key_of_place(self, prior)}, {earlier!r} s',
                    'Give the places in the order of the voyage, from the start of the scene.',
                )


# keys of a voyage that follow from its log
_BY_LOG = ('departure', 'waypoints', 'arrival', 'date', 'sails_at', 'arrives_at', 'speed')


def key_of_place(voyage: Itinerary, index: int) -> str:
    """Return the key of one of `voyage.places`."""
    if voyage.log is not None:
        return f'voyage.log.entries[{index}]'
    if index == 0:
        return 'voyage.departure'
    arrival = len(voyage.places) - 1
    return 'voyage.arrival' if index == arrival else f'voyage.waypoints[{index - 1}]'
