"""The whole scene: its sections, the kinds that each takes, and the rules between them.

Numbers are in SI units and radians. Sections that are `None` are not simulated. Each section or
kind has its own rules; the rules here are those that connect several of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field, Strict, model_validator
from pydantic_core import PydanticCustomError

from tauto_core.machines.parts import DRAGS, ESCAPEMENTS, DragKind, EscapementKind
from tauto_core.machines.sections import FluidTautochroneRegulator, Trochlea
from tauto_core.scene.errors import ABSENT, Problem
from tauto_core.scene.fields import Gravity, OneOf, Positive, Section, Text
from tauto_core.scene.refuse import SECTIONS, Times, out_of_proportion
from tauto_core.scene.sections import Clock, DriftSettings, Log, Solver, Voyage
from tauto_core.scene.times import DAY_S, LOOKAHEAD, STANDARD_GRAVITY, nanoseconds, step_of_rate
from tauto_core.ship.gravity import normal_gravity
from tauto_core.ship.motion_kind import FOLDER as SHIPS
from tauto_core.ship.motion_kind import ShipKind
from tauto_core.ship.motions.still import StillShip
from tauto_core.ship.sections import AxleSuspension


class Scene(Section):
    """A whole scene. Only `duration` and one of `trochlea` and `regulator` must be given."""

    name: Text = Field(default='unnamed', description='name of the scene')
    duration: Positive = Field(description='length of the scene [s]')
    starts_at: Positive = Field(default=DAY_S, description='stamp of the first sample [s]')
    seed: Annotated[int, Strict(), Field(ge=0, le=2**63 - 1)] = Field(
        default=1726, description='seed of all random numbers, 0 to 2**63 - 1'
    )
    gravity: Gravity | Literal['normal'] = Field(
        default=STANDARD_GRAVITY,
        description='acceleration of gravity [m/s2], or normal: that of each place on the voyage, '
        "with Eötvös' term; normal when left out where there is a voyage",
    )
    trochlea: Trochlea | None = Field(
        default=None,
        description='mapping: inertia, cam, thread, power, release_angle of the regulator',
    )
    regulator: FluidTautochroneRegulator | None = Field(
        default=None, description='mapping with `kind`: an oscillator in place of a trochlea'
    )
    drag: Annotated[DragKind, OneOf(DRAGS, default='polynomial')] | None = Field(
        default=None, description='mapping: viscous, quadratic, coulomb'
    )
    escapement: Annotated[EscapementKind, OneOf(ESCAPEMENTS, default='impulse')] | None = Field(
        default=None, description='mapping: kind, energy, angle, rest'
    )
    ship: Annotated[ShipKind, OneOf(SHIPS)] = Field(
        default=StillShip(), description='mapping with `kind` and the motion of the ship'
    )
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

    @model_validator(mode='before')
    @classmethod
    def _gravity_of_the_voyage(cls, keys: Any) -> Any:
        """Take normal gravity where there is a voyage and nothing else is said."""
        if isinstance(keys, dict) and keys.get('voyage') and keys.get('gravity') is None:
            return {**keys, 'gravity': 'normal'}
        return keys

    @model_validator(mode='after')
    def _refuse_impossible_combinations(self) -> Scene:
        found = tuple(self._problems())
        if found:
            raise PydanticCustomError(
                'combination', '{summary}', {'summary': str(found[0]), 'problems': found}
            )
        return self

    @property
    def g(self) -> float:
        """Acceleration of gravity at the start [m/s²], for which the dial is regulated."""
        if self.gravity != 'normal':
            return self.gravity
        if self.voyage is None:  # refused, but all that is wrong with the scene is found first
            return STANDARD_GRAVITY
        return float(normal_gravity(math.radians(self.voyage.departure[0])))

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
    def lies_still(self) -> bool:
        """Whether nothing moves the clock: neither waves nor gravity that changes on the way."""
        weight = self.trochlea is not None and self.trochlea.power.pull.pulling_mass > 0.0
        return self.ship.lies_still and not (self.gravity == 'normal' and weight)

    @property
    def step_ns(self) -> int:
        """Time between samples of ship/imu [ns]; a still ship sends one per log interval."""
        return self.log_interval_ns if self.ship.lies_still else step_of_rate(self.ship.rate)

    @property
    def samples(self) -> int:
        """Number of samples of ship/imu within the duration, both ends counted."""
        return self.duration_ns // self.step_ns + 1

    @property
    def samples_beyond_end(self) -> int:
        """Samples of ship/imu that the stages need beyond the end: none of a still ship."""
        return 0 if self.lies_still else self._lookahead

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

    @property
    def _lookahead(self) -> int:
        """Samples that interpolation needs beyond the end of a motion.

        With a suspension both the case and the clock in it look ahead.
        """
        return LOOKAHEAD if self.suspension is None else 2 * LOOKAHEAD

    def _problems(self) -> Iterator[Problem]:
        """Yield all contradictions between the keys of valid sections."""
        yield from out_of_proportion(self.model_dump(include=set(SECTIONS)))
        yield from self._regulator_problems()
        yield from Times(
            self.starts_at,
            self.duration,
            self.log.interval,
            self.drift.observation_interval,
            None if self.drift.lunars is None else self.drift.lunars.interval,
            self.ship.rate,
            self.ship.shortest_wave_s,
            self.lies_still,
            self.step_ns,
            self._lookahead,
        ).problems()
        yield from self.ship.problems()
        yield from self.drift.problems()
        if self.suspension is not None:
            yield from self.suspension.problems(still=self.lies_still)
        if self.voyage is None and self.gravity == 'normal':
            yield Problem(
                'gravity',
                'normal',
                'is that of a latitude, and there is no voyage that gives one',
                'Give a number [m/s2], such as 9.80665, or write `voyage: …`.',
            )
        if self.voyage is not None:
            yield from self.voyage.problems()
        elif self.drift.lunars is not None:
            yield Problem(
                'drift.lunars',
                ABSENT,
                'needs a voyage: in port the time is known better',
                'Write `voyage: …`, or leave lunars out.',
            )
        if self.solver is not None:
            yield from self.solver.problems()

    def _regulator_problems(self) -> Iterator[Problem]:
        """Yield what is wrong with the trochlea, or with the regulator in its place."""
        if self.regulator is not None:
            others = {
                'trochlea': self.trochlea,
                'drag': self.drag,
                'escapement': self.escapement,
                'suspension': self.suspension,
            }
            yield from self.regulator.problems(others, self.ship.kind, still=self.lies_still)
            if self.drift.covariates:
                yield Problem(
                    'drift.covariates',
                    list(self.drift.covariates),
                    'does not go with regulator: a body in a fluid does not go to sea',
                    'Leave it out.',
                )
        if self.trochlea is not None:
            yield from self.trochlea.problems(
                self.g, self.drag, self.escapement, still=self.lies_still
            )
        if self.escapement is not None:
            yield from self.escapement.problems()
        if self.trochlea is None and self.regulator is None:
            yield Problem(
                'trochlea',
                ABSENT,
                'is missing, and there is no regulator in its place',
                'Write `trochlea: …`, mapping: inertia, cam, thread, power, release_angle; or '
                '`regulator: …`, mapping with `kind`.',
            )
