"""What a scene may contain: one frozen model per section and per kind.

SI units, radians, seconds. Sections that may be `None` are not simulated when absent. Rules that
tie several keys together are in `checks`.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, Strict, model_validator
from pydantic_core import PydanticCustomError

from tauto_core.scene.checks import problems
from tauto_core.scene.constants import DAY_S, STANDARD_GRAVITY
from tauto_core.scene.fields import (
    Flag,
    Number,
    Positive,
    Section,
    Text,
)
from tauto_core.scene.regulators import Drag, Escapement, FluidTautochroneRegulator, Trochlea
from tauto_core.scene.ships import AxleSuspension, Ship, StillShip
from tauto_core.scene.times import nanoseconds, samples_beyond_end, step_of_rate
from tauto_core.scene.voyages import Voyage

Wander: TypeAlias = Annotated[float, Strict(), Field(ge=0.0, le=DAY_S)]


class Clock(Section):
    """The dial. Without a nominal period it is the regulator's small-amplitude period.

    Noise is not simulated where it is left out or 0 (theory E8).
    """

    nominal_period: Positive | None = Field(
        default=None, description='time the dial gains in a full swing [s]'
    )
    white_fm: Wander | None = Field(
        default=None,
        description='white frequency noise: standard deviation of the reading after a day, '
        'growing with the root of time, 0 to 86400 [s]',
    )
    random_walk_fm: Wander | None = Field(
        default=None,
        description='random walk of the frequency: standard deviation of the rate after a day, '
        'growing with the root of time, 0 to 86400 [s/day]',
    )

    @property
    def white_fm_s(self) -> float:
        """q1: variance of the reading in a second [s²/s]."""
        return (self.white_fm or 0.0) ** 2 / DAY_S

    @property
    def random_walk_fm_per_s(self) -> float:
        """q2: variance of the relative rate in a second [1/s]."""
        return ((self.random_walk_fm or 0.0) / DAY_S) ** 2 / DAY_S

    @property
    def is_noisy(self) -> bool:
        """Whether the dial has noise of its own."""
        return bool(self.white_fm or self.random_walk_fm)


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
    gate: Annotated[float, Strict(), Field(ge=1.0, le=1e9)] = Field(
        default=5.0,
        description='sigmas beyond which an observation is refused as an outlier, 1 to 1e9 '
        '(1e9: none is)',
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
    escapement: Escapement | None = Field(
        default=None, description='mapping: kind, energy, angle, rest'
    )
    ship: Ship = Field(default=StillShip(), description='mapping with `kind` and how it moves')
    suspension: AxleSuspension | None = Field(
        default=None,
        description='mapping: kind, support_radius, axle_radius, depth, gyration_radius, …',
    )
    clock: Clock = Field(
        default=Clock(), description='mapping: nominal_period, white_fm, random_walk_fm'
    )
    voyage: Voyage | None = Field(
        default=None,
        description='mapping: departure, arrival, sails_at, arrives_at or speed, …',
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
