"""The figures of a voyage, from the contents of the topics alone.

`tauto sail`, `tauto graph` and `tauto replay` share this, so the summary is the same function of
the same messages, however the stages were run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import Any

from tauto_core.clockwork import SwingTally
from tauto_core.machines import AnyMachine, FluidPendulum, compile_machine
from tauto_core.motion import propagator_name
from tauto_core.navigation import (
    LEAST_UNCHECKED_DAYS,
    LongitudeTally,
    RatedTime,
    RateError,
    RateScatter,
    forgets_its_start,
    projection,
)
from tauto_core.navigation.drift import dial_model, expected_walk_per_s, has_mean_rate, mean_rate
from tauto_core.samples import (
    ESTIMATE,
    JOINT_STATES,
    LONGITUDE_ERROR,
    LONGITUDE_FIX,
    NS_PER_S,
    OBSERVATION,
    PHASE,
    READING,
    SECONDS_PER_DAY,
    FixSamples,
    JointSamples,
    Samples,
    TimeSamples,
)
from tauto_core.scene import Scene


class Summary:
    """Keeps the last sample of each topic, and the largest error where a figure needs it.

    Args:
        scene: the scene of the voyage.
        machine: the regulator of the scene, if it has been built already.
    """

    def __init__(self, scene: Scene, machine: AnyMachine | FluidPendulum | None = None) -> None:
        self._scene, self._built = scene, machine
        self._last: dict[str, JointSamples] = {}
        self._first_reading: tuple[int, int] | None = None
        self._last_reading: tuple[int, int] | None = None
        self._scatter: RateScatter | None = None
        self._rated = RatedTime()
        self._tally = LongitudeTally()
        self._swings = SwingTally(scene, machine)

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take batches of any topics, in order within a topic.

        Observations must come no later than the longitudes that include them, and readings no
        later than the estimates at their stamps.
        """
        self._swings.feed(batches)
        observed = batches.get(OBSERVATION)
        if isinstance(observed, TimeSamples):
            self._tally.observe(observed)
            self._rated.observe(observed)
        reading = batches.get(READING)
        if isinstance(reading, TimeSamples):
            self._rated.read(reading)
        for topic, samples in batches.items():
            if not len(samples.stamp_ns):
                continue
            if topic == READING and isinstance(samples, TimeSamples):
                ends = [(int(samples.stamp_ns[i]), int(samples.time_ref_ns[i])) for i in (0, -1)]
                if self._first_reading is None:
                    length_ns = max(self._scene.log_count - 1, 1) * self._scene.log_interval_ns
                    self._first_reading = ends[0]
                    self._scatter = RateScatter(ends[0][0], length_ns)
                self._last_reading = ends[1]
                if self._scatter is not None:
                    self._scatter.feed(samples)
            elif isinstance(samples, FixSamples):
                if topic == LONGITUDE_FIX:
                    self._tally.place(samples)
            elif isinstance(samples, JointSamples):
                self._last[topic] = samples
                if topic == ESTIMATE:
                    self._rated.estimate(samples)
                if topic == LONGITUDE_ERROR:
                    self._tally.feed(samples)

    def clock(self) -> dict[str, Any]:
        """Return the dial's reading since the start, its error and its mean rate.

        `rate_standard_error_s_per_day` is None where the run alone cannot show it: see
        `RateScatter` and `forgets_its_start`.
        """
        error = self._rate_error()
        if self._first_reading is None or self._last_reading is None or error is None:
            return {}
        (_, dial_start), (end, dial_end) = self._first_reading, self._last_reading
        return {
            'reading_s': (dial_end - dial_start) / NS_PER_S,
            'error_s': (dial_end - end) / NS_PER_S,
            'rate_s_per_day': _rate(self._first_reading, self._last_reading),
            'rate_standard_error_s_per_day': error.standard_error_s_per_day,
        }

    def _rate_error(self) -> RateError | None:
        if self._scatter is None:
            return None
        return forgets_its_start(self._scene, self._machine, self._scatter.rate_error())

    @cached_property
    def _machine(self) -> AnyMachine | FluidPendulum:
        return self._built or compile_machine(self._scene)

    @property
    def propagator(self) -> str:
        """Name of the propagator that runs the scene."""
        return propagator_name(self._machine, still=self._scene.lies_still)

    def trochlea(self) -> dict[str, float | str | None]:
        """Return the regulator's small-amplitude period, its state at the end, and its swing.

        The swing is the result of `SwingTally.result`.
        """
        wheel, phase = self._last.get(JOINT_STATES), self._last.get(PHASE)
        if wheel is None or phase is None:
            return {}
        machine = self._machine
        in_fluid = isinstance(machine, FluidPendulum)
        place, speed = ('arc_m', 'speed_m_s') if in_fluid else ('angle_rad', 'rate_rad_s')
        return {
            'period_s': machine.small_period,
            place: float(wheel.position[-1, 0]),
            speed: float(wheel.velocity[-1, 0]),
            'phase_rad': _named(phase)['phase'],
            'beats': round(_named(phase)['beats']),
            **self._swings.result(),
        }

    def drift(self) -> dict[str, float]:
        """Return the last estimate, and its errors in its own standard deviations.

        `offset_error_sigmas` compares the estimated offset with the error of the dial.
        `rate_error_sigmas` compares the estimated rate with the mean rate of the dial over the
        time in which the filter takes it for one and the same: since the start or, where the state
        has been reopened, since then (`RatedTime`). With covariates the estimated mean of the
        voyage is compared with the mean rate since the start. Where the rate of the dial walks at
        random its departure from that mean is part of the standard deviation.
        `rate_compared_s_per_day` is the mean, and `rate_compared_from_s` when it begins, from the
        first reading. All three are left out where there is only one instant.
        """
        last, clock = self._last.get(ESTIMATE), self.clock()
        if last is None:
            return {}
        found = _named(last)
        if clock:
            wrong_s = found['offset_s'] - clock['error_s']
            found['offset_error_sigmas'] = wrong_s / found['offset_sigma_s']
        first, end = self._first_reading, self._last_reading
        if first is not None and end is not None and first != end:
            rate, sigma = mean_rate(found)
            start = (None if has_mean_rate(found) else self._rated.start()) or first
            true = _rate(start, end)
            wrong = rate - true
            found['rate_error_sigmas'] = wrong / math.hypot(sigma, self._wandered(start, end))
            found['rate_compared_from_s'] = (start[0] - first[0]) / NS_PER_S
            found['rate_compared_s_per_day'] = true
        return found

    def _wandered(self, start: tuple[int, int], end: tuple[int, int]) -> float:
        """Return the standard deviation of the rate at the end from its mean since [s/day].

        A random walk with the density q departs from its mean over T by √(qT/3).
        """
        elapsed_s = (end[0] - start[0]) / NS_PER_S
        density = expected_walk_per_s(self._scene)
        return SECONDS_PER_DAY * math.sqrt(density * elapsed_s / 3.0)

    def longitude(self) -> dict[str, Any]:
        """Return the longitude errors and what the Act of 1714 would have paid.

        Keys: those of `LongitudeTally.result`; and the result of `projection` where the clock was
        unchecked for less than `LEAST_UNCHECKED_DAYS`, otherwise one without rows and reason.
        """
        found = self._tally.result()
        if found is None:
            return {}
        clock, estimate, error = self.clock(), self.drift(), self._rate_error()
        tried = found['unchecked_days'] >= LEAST_UNCHECKED_DAYS
        if tried or not clock or not estimate or error is None:
            return {**found, 'projection': [], 'not_projected': None}
        return {
            **found,
            **projection(
                clock['rate_s_per_day'],
                error,
                estimate,
                dial_model(self._scene),
                found['latitude_deg'] or 0.0,
                self._scene.clock.random_walk_fm_per_s,
            ),
        }


def _rate(first: tuple[int, int], last: tuple[int, int]) -> float:
    """Return what a dial gains from one stamp and reading to another [s/day], 0 for the same."""
    (start, dial_start), (end, dial_end) = first, last
    elapsed, gained = (end - start) / NS_PER_S, (dial_end - end) - (dial_start - start)
    return gained / NS_PER_S / elapsed * SECONDS_PER_DAY if elapsed else 0.0


def _named(samples: JointSamples) -> dict[str, float]:
    """Return the last sample's values by name."""
    values = samples.position[-1].tolist()
    return dict(zip(samples.name, values, strict=True))
