"""The regressors of the rate equation, integrated from `ship/imu` (theory E11).

For each sample, with f the apparent gravity that pulls a weight at the clock and ⟨f⟩ its running
mean,

    x_heave = -(f - ⟨f⟩)²/(8 g²),    x_roll = ρ².

Between samples the regressors are linear, and their integral X is exact.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from tauto_core.kernels import entry
from tauto_core.navigation.longitude import BEFORE_ALL, in_order
from tauto_core.samples import (
    NS_PER_S,
    SHIP_IMU,
    FloatArray,
    ImuSamples,
    IntArray,
    JointSamples,
    Samples,
    State,
    take,
)
from tauto_core.scene import Scene
from tauto_core.scene.times import MAX_GAP_S
from tauto_core.ship.imu import Continuity, content_reasons, imu_from_roll, plain, screen

# -----------------------------------------------------------------------------
# The running mean of a signal, compiled; import on first use only.


@entry
def followed(value: FloatArray, share: FloatArray, mean: float, out: FloatArray) -> None:
    """Fill the running mean of a value, which becomes m + c (v - m) at each sample.

    Args:
        value: v, shape (n,).
        share: c of each sample, 0 to 1, shape (n,).
        mean: m before the first sample.
        out: output, shape (n,).
    """
    for i in range(len(value)):
        mean = mean + share[i] * (value[i] - mean)
        out[i] = mean


MEAN_S = 300.0
"""Time constant of ⟨f⟩, a first-order high-pass [s]. It removes an accelerometer's bias, and
1/(Ω · 300 s)² of a wave's square, 3e-5 at 10 s and 1e-4 at 20 s.
"""

USUAL_S = 600.0
"""Time constant of the mean that bridges a gap in the motion [s]: several groups of waves, and
short compared with the hours in which a sea changes.
"""

HELD_S = 10.0
"""Time, by their stamps, for which readings of a live graph wait for the motion [s]."""


class Motion(Protocol):
    """A source of the integrals of the regressors."""

    inputs: tuple[str, ...]

    @property
    def reached_ns(self) -> int:
        """Stamp up to which motion has arrived; BEFORE_ALL if none has."""
        ...

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take new samples of any of its inputs."""
        ...

    def at(self, stamp_ns: IntArray) -> FloatArray:
        """Return the integrals at increasing stamps [s], (n, c), and forget those before them."""
        ...

    def state(self) -> State:
        """Return all that the next result depends on."""
        ...

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        ...

    def health(self) -> dict[str, int]:
        """Return counters."""
        ...


def integral_names(covariates: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the integrals on `drift/estimate`."""
    return tuple(f'{name}_integral_s' for name in covariates)


class Regressors:
    """Integrates the regressors over `ship/imu`; the result does not depend on batches.

    Args:
        scene: names the covariates, and gives gravity and the sampling rate of the ship.
        live: whether the samples are a live sensor's. Those that do not continue the ones before
            are then left out, and over a gap the integrals grow as usual.
    """

    inputs: tuple[str, ...] = (SHIP_IMU,)

    def __init__(self, scene: Scene, *, live: bool) -> None:
        known = {'heave': self._heave, 'roll': _roll}
        self._columns = [known[name] for name in scene.drift.covariates or ()]
        self._gravity = self._mean = scene.gravity
        self._continuity: Continuity | None = None
        if live:
            longest_ns = max(round(MAX_GAP_S * NS_PER_S), 2 * scene.step_ns * scene.lies_still)
            self._continuity = Continuity(scene.step_ns, longest_ns)
        width = len(self._columns)
        self._stamp: IntArray = np.empty(0, np.int64)
        self._value, self._integral = np.empty((0, width)), np.empty((0, width))
        self._last, self._usual = np.zeros((1, width)), np.zeros(width)
        self._health = {'motion_refused': 0, 'motion_gaps': 0, 'motion_unknown': 0}
        begun = self.state()
        none = np.zeros(1)
        self._add(imu_from_roll(np.zeros(1, np.int64), none, none, none, none))  # compiles
        self.restore(begun)

    @property
    def reached_ns(self) -> int:
        """Stamp of the last sample; BEFORE_ALL if none has arrived."""
        return int(self._stamp[-1]) if len(self._stamp) else BEFORE_ALL

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take motion samples; bad ones are counted and left out."""
        imu = batches.get(SHIP_IMU)
        if not isinstance(imu, ImuSamples) or not len(imu.stamp_ns):
            return
        if self._continuity is None:
            last_ns = self.reached_ns if len(self._stamp) else None
            imu, refused = screen(imu, last_ns, compiled=True)
            self._health['motion_refused'] += sum(refused.values())
            self._add(imu)
            return
        good = content_reasons(imu) == 0
        self._health['motion_refused'] += int(np.count_nonzero(~good))
        for run in self._continuity.feed(imu if good.all() else take(imu, good)):
            if run.begins and len(self._stamp):
                self._bridge(int(run.imu.stamp_ns[0]))
            self._add(run.imu)

    def at(self, stamp_ns: IntArray) -> FloatArray:
        """Return the integrals at increasing stamps [s], (n, c); earlier ones are forgotten.

        Stamps before the first sample have its integrals; after the last one they grow as usual.
        Such stamps are counted.
        """
        known = self._stamp
        if not len(known) or not len(stamp_ns):
            self._health['motion_unknown'] += len(stamp_ns)
            return np.repeat(self._last, len(stamp_ns), axis=0)
        at = np.maximum(stamp_ns, known[0])
        before = np.searchsorted(known, at, 'right') - 1
        after = np.minimum(before + 1, len(known) - 1)
        since = ((at - known[before]) / NS_PER_S)[:, None]
        step = (np.maximum(known[after] - known[before], 1) / NS_PER_S)[:, None]
        rise = (self._value[after] - self._value[before]) / step
        late = at > known[-1]
        growth = since * (self._value[before] + 0.5 * rise * since)
        growth = np.where(late[:, None], self._usual * since, growth)
        self._health['motion_unknown'] += int(np.count_nonzero(late | (at > stamp_ns)))
        found: FloatArray = self._integral[before] + growth
        first = int(before[-1])
        self._stamp, self._value = known[first:], self._value[first:]
        self._integral = self._integral[first:]
        return found

    def _add(self, imu: ImuSamples) -> None:
        """Take samples that continue the ones before."""
        stamps = imu.stamp_ns
        if not len(stamps):
            return
        before = self._stamp[-1:] if len(self._stamp) else stamps[:1]
        steps = np.diff(stamps, prepend=before) / NS_PER_S
        value = np.column_stack([column(imu, steps) for column in self._columns])
        if self._continuity is not None:
            for j, column in enumerate(value.T):
                self._usual[j] = _followed(column, steps, USUAL_S, float(self._usual[j]))[-1]
        self._append(stamps, value)

    def _heave(self, imu: ImuSamples, steps: FloatArray) -> FloatArray:
        """Return -a²/(8 g²), with a the apparent gravity less its running mean."""
        force = _apparent_gravity(imu)
        means = np.concatenate(([self._mean], _followed(force, steps, MEAN_S, self._mean)))
        self._mean = float(means[-1])
        # centred between two steps of the mean; otherwise a wave would lose Δ/τ of its square
        heaved = (force - 0.5 * (means[:-1] + means[1:])) / self._gravity
        return -0.125 * heaved * heaved

    def _append(self, stamps: IntArray, value: FloatArray) -> None:
        """Integrate the regressors up to further points."""
        times = np.concatenate((self._stamp[-1:], stamps))
        values = np.concatenate((self._value[-1:], value))
        areas = 0.5 * (np.diff(times) / NS_PER_S)[:, None] * (values[:-1] + values[1:])
        sums = np.cumsum(np.concatenate((self._last, areas)), axis=0)
        self._stamp = np.concatenate((self._stamp, stamps))
        self._value = np.concatenate((self._value, value))
        self._integral = np.concatenate((self._integral, sums[len(sums) - len(stamps) :]))
        self._last = self._integral[-1:].copy()

    def _bridge(self, begins_ns: int) -> None:
        """Bridge the time from the last sample to another run with the usual growth."""
        self._health['motion_gaps'] += 1
        edges = np.array([self._stamp[-1] + 1, begins_ns - 1], np.int64)
        if edges[1] > edges[0]:
            self._append(edges, np.stack([self._usual, self._usual]))
        elif begins_ns <= self._stamp[-1]:  # stamps have gone back, so another time begins
            none = slice(0, 0)
            self._stamp, self._value = self._stamp[none], self._value[none]
            self._integral = self._integral[none]

    def state(self) -> State:
        """Return all that the next result depends on."""
        return {
            'stamp': self._stamp.copy(),
            'value': self._value.copy(),
            'integral': self._integral.copy(),
            'last': self._last.copy(),
            'mean': self._mean,
            'usual': self._usual.copy(),
            'continuity': self._continuity and self._continuity.state(),
            'health': dict(self._health),
        }

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._stamp, self._value = state['stamp'], state['value']
        self._integral, self._last = state['integral'], state['last']
        self._mean, self._usual = state['mean'], state['usual'].copy()
        if self._continuity is not None:
            self._continuity.restore(state['continuity'])
        self._health = dict(state['health'])

    def health(self) -> dict[str, int]:
        """Return counters of samples refused, gaps, and stamps where the motion is not known."""
        return dict(self._health)


class RecordedIntegrals:
    """The integrals from a `drift/estimate` with the same covariates.

    Args:
        estimate: the estimate, with increasing stamps; at least one.
        covariates: names of the covariates.
    """

    inputs: tuple[str, ...] = ()

    def __init__(self, estimate: JointSamples, covariates: tuple[str, ...]) -> None:
        columns = [estimate.name.index(name) for name in integral_names(covariates)]
        kept = in_order(estimate.stamp_ns, BEFORE_ALL)
        self._stamp = estimate.stamp_ns[kept]
        self._integral = estimate.position[kept][:, columns]
        self._unknown = 0

    @property
    def reached_ns(self) -> int:
        """Stamp of the last estimate."""
        return int(self._stamp[-1])

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Ignore the samples; all integrals are known."""

    def at(self, stamp_ns: IntArray) -> FloatArray:
        """Return the integrals at stamps [s], (n, c), linear between estimates."""
        first, known = self._stamp[0], self._stamp
        self._unknown += int(np.count_nonzero((stamp_ns < first) | (stamp_ns > known[-1])))
        at, times = (stamp_ns - first) / NS_PER_S, (known - first) / NS_PER_S
        return np.column_stack([np.interp(at, times, column) for column in self._integral.T])

    def state(self) -> State:
        """Return an empty state, since nothing changes."""
        return {'unknown': self._unknown}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._unknown = state['unknown']

    def health(self) -> dict[str, int]:
        """Return the number of stamps outside the estimates."""
        return {'motion_unknown': self._unknown}


def _apparent_gravity(imu: ImuSamples) -> FloatArray:
    """Return the apparent gravity at the clock [m/s2], as the trochlea uses it (theory E1)."""
    from tauto_core.ship.kernels import force_of

    size = np.empty(len(imu.stamp_ns))
    force_of(plain(imu.linear_acceleration), None, size)
    return size


def _followed(value: FloatArray, steps: FloatArray, time_s: float, mean: float) -> FloatArray:
    """Return the running mean of a value with a time constant, m + c (v - m), c = Δ/(τ + Δ).

    Args:
        value: v of each sample, (n,).
        steps: Δ, time since the sample before [s], (n,).
        time_s: τ [s].
        mean: m before the first sample.
    """

    means = np.empty_like(value)
    followed(np.ascontiguousarray(value), steps / (time_s + steps), mean, means)
    return means


def _roll(imu: ImuSamples, steps: FloatArray) -> FloatArray:
    """Return ρ²."""
    from tauto_core.ship.kernels import roll_of

    del steps
    roll = np.empty(len(imu.stamp_ns))
    roll_of(plain(imu.orientation), None, roll, None)
    return roll * roll
