"""Which samples of a live sensor form one uninterrupted motion, and where a new one begins.

A sample continues the last one if it is later by at most the longest gap, and the roll has changed
by as much as the gyro says. Samples that do not continue it are set aside. If a later sample
continues the last good one, those set aside were wrong and are left out. If they continue each
other for `CONFIRMED_GAPS` longest gaps, time or motion has really jumped, and a new run begins
with them. This depends on the samples alone, not on batches or on the speed at which a bag is
played.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tauto_core.samples import FloatArray, ImuSamples, State, join, take
from tauto_core.ship.imu import attitude

CONFIRMED_GAPS = 1.0
LEAST_SUSPECTS = 3
MOST_SUSPECTS = 20_000

THINNED_PART = 0.75
"""A sensor faster than the scene's rate is thinned to steps of at least this part of its step."""
UNEVEN = 4.0
"""Largest ratio of neighbouring steps: polynomials through uneven nodes multiply their noise by
its cube."""
FILLED = 3.0
"""A step longer than so many of the ones before is filled with interpolated samples."""

JUMP_RAD = 0.05
"""Change of roll that the gyro may leave unexplained: more than the errors of sensors, less than
would disturb a clock.
"""
JUMP_RAD_PER_S3 = 0.2
"""Error of the trapezoid rule, |d³ρ/dt³|/12, in a sea of 4 s and 30 degrees."""


class Place(NamedTuple):
    """The last sample, for comparison with the next: stamp [ns], roll [rad], roll rate [rad/s]."""

    stamp_ns: int
    roll: float
    roll_rate: float


class Run(NamedTuple):
    """Samples of one uninterrupted motion; `begins`: the first of them begins a new one."""

    imu: ImuSamples
    begins: bool


class Continuity:
    """Sorts screened samples of a live sensor into runs, independently of batches.

    Args:
        step_ns: the scene's time between samples.
        max_gap_ns: longest time between samples that is interpolated.
    """

    def __init__(self, step_ns: int, max_gap_ns: int) -> None:
        self._step_ns, self._max_gap_ns = step_ns, max_gap_ns
        self._last: Place | None = None
        self._kept: ImuSamples | None = None
        self._before_ns = step_ns
        self._suspects: list[tuple[Place, ImuSamples]] = []
        self.counts = {
            'duplicated': 0,
            'out_of_order': 0,
            'stamps_ahead': 0,
            'roll_jumps': 0,
            'bridged_gaps': 0,
        }

    @property
    def holds_s(self) -> float:
        """Stamp of the latest sample set aside less that of the last good one [s]; 0: none is."""
        if not self._suspects or self._last is None:
            return 0.0
        return (self._suspects[-1][0].stamp_ns - self._last.stamp_ns) * 1e-9

    def restart(self) -> None:
        """Make the next sample begin a new run, whatever it contains."""
        self._last = self._kept = None
        self._drop_suspects()

    def feed(self, imu: ImuSamples) -> list[Run]:
        """Return the samples to use, in runs. Their content has been screened."""
        return list(self._runs(imu))

    def _runs(self, imu: ImuSamples) -> Iterator[Run]:
        motion = attitude(imu)
        places = list(
            map(Place, imu.stamp_ns.tolist(), motion.roll.tolist(), motion.roll_rate.tolist())
        )
        parts: list[ImuSamples] = []
        begins = False
        for index, place in enumerate(places):
            one = take(imu, slice(index, index + 1))
            if self._last is None:
                self._before_ns, begins, parts = self._step_ns, True, [one]
                self._last, self._kept = place, one
            elif self._goes_on(self._last, place):
                self._drop_suspects()
                parts += self._spaced(place, one)
            elif place.stamp_ns == self._last.stamp_ns:
                self.counts['duplicated'] += 1
            elif (again := self._suspected(place, one)) is not None:
                if parts:
                    yield Run(join(parts), begins)
                self.restart()
                yield from self._runs(again)
                begins, parts = False, []
        if parts:
            yield Run(join(parts), begins)

    def _goes_on(self, before: Place, now: Place) -> bool:
        elapsed_ns = now.stamp_ns - before.stamp_ns
        if not 0 < elapsed_ns <= self._max_gap_ns:
            return False
        elapsed_s = elapsed_ns * 1e-9
        turned = math.remainder(now.roll - before.roll, math.tau)
        excess = turned - 0.5 * (before.roll_rate + now.roll_rate) * elapsed_s
        return abs(excess) <= JUMP_RAD + JUMP_RAD_PER_S3 * elapsed_s**3

    def _suspected(self, place: Place, one: ImuSamples) -> ImuSamples | None:
        """Set a sample aside; return all that are aside once they are confirmed as a new run."""
        aside = self._suspects
        if aside and (len(aside) == MOST_SUSPECTS or not self._goes_on(aside[-1][0], place)):
            self._drop_suspects()
        aside.append((place, one))
        covered_ns = place.stamp_ns - aside[0][0].stamp_ns
        if len(aside) < LEAST_SUSPECTS or covered_ns < CONFIRMED_GAPS * self._max_gap_ns:
            return None
        confirmed = join([sample for _, sample in aside])
        aside.clear()
        return confirmed

    def _drop_suspects(self) -> None:
        for place, _ in self._suspects:
            self.counts[self._fault(place)] += 1
        self._suspects.clear()

    def _fault(self, place: Place) -> str:
        last_ns = place.stamp_ns if self._last is None else self._last.stamp_ns
        if place.stamp_ns < last_ns:
            return 'out_of_order'
        return 'stamps_ahead' if place.stamp_ns > last_ns + self._max_gap_ns else 'roll_jumps'

    def _spaced(self, place: Place, one: ImuSamples) -> list[ImuSamples]:
        """Return a sample that continues the run, after any that fill a gap; none if too close."""
        assert self._last is not None
        assert self._kept is not None
        elapsed_ns = place.stamp_ns - self._last.stamp_ns
        if elapsed_ns < max(THINNED_PART * self._step_ns, self._before_ns / UNEVEN):
            return []
        usual_ns = max(self._step_ns, self._before_ns)
        parts = [one]
        if elapsed_ns > FILLED * usual_ns:
            self.counts['bridged_gaps'] += 1
            number = -(-elapsed_ns // usual_ns)
            parts = [_between(self._kept, one, number), one]
            self._before_ns = elapsed_ns // number
        else:
            self._before_ns = elapsed_ns
        self._last, self._kept = place, one
        return parts

    def state(self) -> State:
        """Return what the next decision depends on, and the counters."""
        return {
            'last': self._last and tuple(self._last),
            'kept': self._kept,
            'before_ns': self._before_ns,
            'suspects': [(tuple(place), sample) for place, sample in self._suspects],
            'counts': dict(self.counts),
        }

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._last = state['last'] and Place(*state['last'])
        self._kept, self._before_ns = state['kept'], state['before_ns']
        self._suspects = [(Place(*place), sample) for place, sample in state['suspects']]
        self.counts = dict(state['counts'])


def _between(before: ImuSamples, after: ImuSamples, number: int) -> ImuSamples:
    """Return the samples that divide a gap into `number` parts, linear in every quantity."""
    x = np.arange(1, number) / number
    first, last = int(before.stamp_ns[0]), int(after.stamp_ns[0])

    def mixed(one: FloatArray, other: FloatArray) -> FloatArray:
        return one + x[:, None] * (other - one)

    # q and −q are the same attitude; the nearer one is used
    sign = math.copysign(1.0, float(np.sum(before.orientation * after.orientation)))
    orientation = mixed(before.orientation, sign * after.orientation)
    rows = np.zeros(number - 1, np.int64)
    return ImuSamples(
        np.array([first + (last - first) * k // number for k in range(1, number)], np.int64),
        after.frame_id,
        orientation / np.linalg.norm(orientation, axis=1)[:, None],
        after.orientation_covariance[rows],
        mixed(before.angular_velocity, after.angular_velocity),
        after.angular_velocity_covariance[rows],
        mixed(before.linear_acceleration, after.linear_acceleration),
        after.linear_acceleration_covariance[rows],
    )
