"""Measured motion: a CSV of roll and heave, or a bag of an inertial sensor."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from pydantic import Field

from tauto_core.scene.errors import ABSENT, Problem
from tauto_core.ship.motion_kind import Channels, ShipKind, Surroundings
from tauto_core.ship.recorded import Recorded, recorded_metadata, recorded_motion


class RecordedShip(ShipKind):
    """Measured motion."""

    is_computed = False
    rank = 4
    starter = {
        'recorded': {
            'path': 'shipped:nbp1406_seapath/s330_motion.csv',
            'time_column': 't_s',
            'roll_column': 'roll_deg',
            'heave_column': 'heave_m',
        }
    }

    kind: Literal['recorded'] = 'recorded'
    recorded: Recorded = Field(description='mapping: path, and CSV columns or a topic')

    def channels(self, scene: Surroundings) -> Channels:
        """Return the measured motion within its pass-band."""
        motion = recorded_motion(scene, self.recorded)
        return Channels(
            motion.roll,
            motion.heave,
            motion.force_y,
            motion.force_z,
            recorded_metadata(self.recorded, motion),
            motion.warnings,
        )

    def files(self) -> Iterator[tuple[str, str, bool]]:
        """Yield the record, which may be a folder if it is a bag."""
        yield 'ship.recorded.path', self.recorded.path, self.recorded.topic is not None

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong between its keys."""
        recorded = self.recorded
        yield from _source(recorded)
        low, high = recorded.passband
        band = list(recorded.passband)
        if low >= high:
            yield Problem(
                'ship.recorded.passband',
                band,
                'must rise from the lowest to the highest frequency [Hz]',
                f'Use [{min(low, high)!r}, {max(low, high)!r}].'
                if low > high
                else 'Give two different frequencies, for example [0.02, 0.4].',
            )
        if max(low, high) >= self.rate / 2.0:
            yield Problem(
                'ship.recorded.passband',
                band,
                f'must lie below half of ship.rate, {self.rate / 2.0:.6g} Hz',
                'Lower its upper edge or raise ship.rate.',
            )
        if recorded.scale == 0.0:
            yield Problem(
                'ship.recorded.scale',
                recorded.scale,
                'must not be 0: nothing moves',
                'Use 1.0 for the motion as measured, or ship kind still.',
            )

    def left_out(self) -> tuple[str, ...]:
        """Return the heave if none was measured."""
        measured = self.recorded.heave_column is not None or self.recorded.topic is not None
        return () if measured else ('heave',)


def _source(recorded: Recorded) -> Iterator[Problem]:
    columns = {
        'time_column': recorded.time_column,
        'roll_column': recorded.roll_column,
        'heave_column': recorded.heave_column,
    }
    if recorded.topic is not None:
        for key, column in columns.items():
            if column is not None:
                yield Problem(
                    f'ship.recorded.{key}',
                    column,
                    'names a CSV column, but topic says that path is a bag',
                    'Leave out topic for a CSV, the columns for a bag.',
                )
        if recorded.scale not in (0.0, 1.0):
            yield Problem(
                'ship.recorded.scale',
                recorded.scale,
                'does not go with a bag: a measured specific force holds gravity and cannot be '
                'scaled',
                'Use 1.0, or a CSV of roll and heave.',
            )
        return
    for key in ('time_column', 'roll_column'):
        if columns[key] is None:
            yield Problem(
                f'ship.recorded.{key}',
                ABSENT,
                'is missing',
                'Name the column with its unit, for example t_s and roll_deg; '
                'for a bag give topic instead.',
            )


KIND = RecordedShip
