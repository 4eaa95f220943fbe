"""Sections of a scene that have only one kind: dial, navigator, log, solver."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, TypeAlias

from pydantic import Field, Strict

from tauto_core.scene.constants import DAY_S
from tauto_core.scene.errors import Problem
from tauto_core.scene.fields import Flag, Number, Positive, Section

Wander: TypeAlias = Annotated[float, Strict(), Field(ge=0.0, le=DAY_S)]
# The rounding error of a step is several times 1.1e-16; 1e-3 of a swing is minutes a day.
LEAST_TOLERANCE, LARGEST_TOLERANCE = 1e-15, 1e-3


def white_s(white_fm: float) -> float:
    """Return q1, the variance of the reading after a second [s²/s].

    Args:
        white_fm: standard deviation of the reading after a day [s].
    """
    return white_fm**2 / DAY_S


def walk_per_s(random_walk_fm: float) -> float:
    """Return q2, the variance of the relative rate after a second [1/s].

    Args:
        random_walk_fm: standard deviation of the rate after a day [s/day].
    """
    return (random_walk_fm / DAY_S) ** 2 / DAY_S


class Clock(Section):
    """The dial. Without a nominal period it is set for small swings of the regulator.

    Noise that is left out or 0 is not simulated (theory E8).
    """

    nominal_period: Positive | None = Field(
        default=None, description='time by which the dial advances in a full swing [s]'
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
        """Whether the dial has noise of its own."""
        return bool(self.white_fm or self.random_walk_fm)


class Lunars(Section):
    """Lunar distances at sea, which give the time by the Moon's motion among the stars.

    The Moon moves by half a degree an hour. Sextant and almanac together erred by half a minute of
    arc, which is a minute of time. Flinders (A Voyage to Terra Australis, 1814) writes that the
    longitude from one set of six sights may be wrong by 30 minutes of arc (two minutes of time),
    and probably not by more than 12. A normal error with a sigma of a minute agrees with both.
    """

    interval: Positive = Field(
        default=DAY_S, description='time between lunar distances at sea [s]'
    )
    sigma: Annotated[float, Strict(), Field(ge=1e-9, le=DAY_S)] = Field(
        default=60.0, description='standard deviation of the time they give, 1e-9 to 86400 [s]'
    )


Covariate: TypeAlias = Literal['heave', 'roll']


class CoefficientPrior(Section):
    """Prior of a coefficient of the rate equation, before any observation."""

    value: Number = Field(description='expected coefficient; about 1 for a weight in heave')
    sigma: Annotated[float, Strict(), Field(ge=1e-9, le=1e9)] = Field(
        description='its standard deviation, 1e-9 to 1e9'
    )


class Coefficients(Section):
    """Priors of coefficients of the rate equation that replace those from trial runs."""

    heave: CoefficientPrior | None = Field(
        default=None, description='mapping: value, sigma; when left out: from trial runs'
    )
    roll: CoefficientPrior | None = Field(
        default=None, description='mapping: value, sigma; when left out: from trial runs'
    )


class DriftSettings(Section):
    """The navigator's observations, and the assumptions of the drift estimate."""

    observation_interval: Positive = Field(
        default=DAY_S, description='time between observations in port [s]'
    )
    observation_sigma: Annotated[float, Strict(), Field(ge=1e-9, le=DAY_S)] = Field(
        default=0.5, description='standard deviation of an observation, 1e-9 to 86400 [s]'
    )
    lunars: Lunars | None = Field(
        default=None, description='mapping: interval, sigma of lunar distances between the ports'
    )
    clouds: Annotated[float, Strict(), Field(ge=0.0, le=1.0)] = Field(
        default=0.0,
        description='share of the observations in port and by the Moon that clouds hide, 0 to 1',
    )
    states: Literal[2, 3] = Field(default=2, description='2: offset and rate; 3: ageing too')
    prior_rate_sigma: Annotated[float, Strict(), Field(ge=1e-9, le=DAY_S)] = Field(
        default=1000.0,
        description="prior standard deviation of the clock's rate, 1e-9 to 86400 [s/day]; the "
        'default covers a dial regulated for small swings (theory E7)',
    )
    gate: Annotated[float, Strict(), Field(ge=1.0, le=1e9)] = Field(
        default=5.0,
        description='number of standard deviations beyond which an observation is refused as an '
        'outlier, 1 to 1e9 (1e9: none is)',
    )
    white_fm: Wander | None = Field(
        default=None,
        description='white frequency noise that the navigator expects of the clock at sea: '
        'standard deviation of the reading after a day, which grows with the square root of time, '
        '0 to 86400 [s]; it is not simulated (when left out: clock.white_fm)',
    )
    random_walk_fm: Wander | None = Field(
        default=None,
        description='random walk of the rate that the navigator expects of the clock at sea: '
        'standard deviation of the rate after a day, which grows with the square root of time, 0 '
        'to 86400 [s/day]; it is not simulated (when left out: clock.random_walk_fm)',
    )
    covariates: Annotated[tuple[Covariate, ...], Field(min_length=1)] | None = Field(
        default=None,
        description='list of heave, roll: motions of the ship on which the rate is taken to '
        'depend (theory E11)',
    )
    coefficients: Coefficients | None = Field(
        default=None,
        description='mapping: heave, roll; priors of the coefficients of the covariates',
    )

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong with the covariates."""
        named = list(self.covariates or ())
        for name in sorted(set(named)):
            if named.count(name) > 1:
                yield Problem(
                    'drift.covariates', named, f'names {name} twice', 'Name each of them once.'
                )
        given = {} if self.coefficients is None else self.coefficients.model_dump()
        for key in (key for key, stated in given.items() if stated and key not in named):
            yield Problem(
                f'drift.coefficients.{key}',
                given[key],
                f'has no use: drift.covariates does not name {key}',
                f'Write covariates: [{", ".join([*named, key])}], or leave the coefficient out.',
            )


class Log(Section):
    """The log: one sample in each interval; the ship's motion at its full rate if asked for."""

    interval: Positive = Field(default=1.0, description='time between logged samples [s]')
    motion: Flag | None = Field(
        default=None,
        description='whether ship/imu is logged at its full rate; when left out: '
        'in scenes of up to a day',
    )


class Solver(Section):
    """Settings of the numerical propagator; propagators in closed form have none."""

    tolerance: Number | None = Field(
        default=None,
        description="relative error allowed in one step, 1e-15 to 1e-3; the propagator's default "
        'when left out',
    )

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong with the tolerance."""
        tolerance = self.tolerance
        if tolerance is None or LEAST_TOLERANCE <= tolerance <= LARGEST_TOLERANCE:
            return
        if tolerance < LEAST_TOLERANCE:
            yield Problem(
                'solver.tolerance',
                tolerance,
                f'is below {LEAST_TOLERANCE:g}, the rounding of double precision, which no step '
                'can meet',
                f'Leave it out, or use {LEAST_TOLERANCE:g}.',
            )
        else:
            yield Problem(
                'solver.tolerance',
                tolerance,
                f'must be at most {LARGEST_TOLERANCE:g} of the swing in one step',
                f'Leave it out, or use {LARGEST_TOLERANCE:g}.',
            )
