"""The regressors x_j of the rate equation y + Σ k_j x_j, integrated over time (rate.md).

Motion comes from `ship/imu`, gravity from the places of `ship/fix`, the temperature from
`ship/temperature`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.kernels import entry
from tauto_core.navigation.longitude import BEFORE_ALL, STATUS_FIX, LiveFixes, in_order
from tauto_core.samples import (
    SHIP_FIX,
    SHIP_IMU,
    SHIP_TEMPERATURE,
    FixSamples,
    FloatArray,
    ImuSamples,
    IntArray,
    JointSamples,
    Samples,
    Stateful,
    TemperatureSamples,
    take,
)
from tauto_core.scene import Scene
from tauto_core.scene.times import MAX_GAP_S, NS_PER_S
from tauto_core.ship.airs import COLDEST, WARMEST, BoxTemperature
from tauto_core.ship.imu import (
    Continuity,
    contiguous,
    imu_from_roll,
    level_force,
    refusal_reasons,
    screen,
)
from tauto_core.ship.passage import gravity_between

# -----------------------------------------------------------------------------
# The motion of the ship.
#
# With the specific force f at the clock in level axes, x forward and z up, and its running mean
# ⟨f_z⟩, each sample has
#
#     x_heave = [2 f_x² + 2 f_y² - (f_z - ⟨f_z⟩)²]/(8 g²),    x_roll = ρ².
#
# f_x counts if the thread can lean that way. Between samples the regressors are linear, and their
# integral X is exact.


@entry
def followed(value: FloatArray, share: FloatArray, mean: float, out: FloatArray) -> None:
    """Fill the running mean m of values v (n,), which becomes m + c (v - m) at each sample."""
    for i in range(len(value)):
        mean = mean + share[i] * (value[i] - mean)
        out[i] = mean


class Follower(NamedTuple):
    """The part of the specific force that a clock's thread follows, with its recent values.

    Attributes:
        gravity: g [m/s²].
        rate: ω of a thread that swings athwart [rad/s], 0 without one.
        leans: whether f_x counts.
        ship_fixed: whether the force along the ship's axle is subtracted from it.
        mean: ⟨f_z⟩ [m/s²] after the last sample, shape (1,).
        swing: q [m/s²] and q̇ after it, shape (2,).
    """

    gravity: float
    rate: float
    leans: bool
    ship_fixed: bool
    mean: FloatArray
    swing: FloatArray


@entry
def heaved(
    orientation: FloatArray, force: FloatArray, step: FloatArray, thread: Follower, out: FloatArray
) -> None:
    """Fill [2 f_x² + 2 f_y² - (f_z - ⟨f_z⟩)²]/(8 g²) of samples a step apart [s].

    A swinging thread has q instead of f_y: q̈ = ω² (f_y - q) - 2 ζ ω q̇, by trapezoids. A step uses
    f_y at its end: q comes half a step early, with the right size.
    """
    mean, q, v = thread.mean[0], thread.swing[0], thread.swing[1]
    for i in range(len(step)):
        x, y, z, w = orientation[i, 0], orientation[i, 1], orientation[i, 2], orientation[i, 3]
        # sine and cosine of roll and pitch; homogeneous in the quaternion
        square = (x * x + y * y) + (z * z + w * w)
        sr, cr = 2.0 * (w * x + y * z), (w * w - x * x) + (z * z - y * y)
        across = math.hypot(sr, cr)
        sr, cr, sp, cp = sr / across, cr / across, 2.0 * (w * y - z * x) / square, across / square
        along, port = force[i, 0], cr * force[i, 1] - sr * force[i, 2]
        deck = sr * force[i, 1] + cr * force[i, 2]
        forward, up = cp * along + sp * deck, cp * deck - sp * along
        if thread.rate > 0.0:
            h = thread.rate * step[i]
            even, odd = 1.0 + 0.25 * h * h, SWING_DAMPING * h
            faster = v * (even - 0.5 * h * h - odd) + thread.rate * h * (port - q)
            faster = faster / (even + odd)
            q = q + 0.5 * step[i] * (v + faster)
            v, port = faster, q
        aside = port * port
        if thread.leans:
            aside = aside + forward * forward
        if thread.ship_fixed:
            aside = aside - along * along
        previous = mean
        mean = previous + step[i] / (MEAN_S + step[i]) * (up - previous)
        # centred between two steps of the mean; otherwise a wave would lose Δ/τ of its square
        rise = (up - 0.5 * (previous + mean)) / thread.gravity
        out[i] = 0.25 * aside / (thread.gravity * thread.gravity) - 0.125 * rise * rise
    thread.mean[0], thread.swing[0], thread.swing[1] = mean, q, v


SWING_DAMPING = 0.05
"""ζ of the thread in `heaved`. A real one is undamped, but its free swing is unknown to the ship's
sensor and must decay. It takes 0.5 % of waves three times as slow.
"""

MEAN_S = 300.0
"""Time constant of ⟨f⟩, a first-order high-pass [s]. It removes an accelerometer's bias, and
1/(Ω · 300 s)² of a wave's square, 3e-5 at 10 s and 1e-4 at 20 s.
"""

USUAL_S = 600.0
"""Time constant of the mean that bridges a gap in the motion [s]: several groups of waves, but
less than the hours in which a sea changes.
"""

HELD_S = 10.0
"""Time, by their stamps, for which readings of a live graph wait for the motion [s]."""

HELD_NS = round(HELD_S * NS_PER_S)

STALE_S = 3600.0
"""Validity of a place or a temperature [s]: in an hour at 5 m/s due south gravity takes 0.6 s/day
from a weight, and the next sample corrects the integral.
"""

SHAKEN_BY = ('heave', 'roll')
"""Covariates from `ship/imu`."""

HEAT = {'temperature': 1, 'temperature_squared': 2}
"""Covariates from `ship/temperature`, and their powers of the temperature since the start."""


class MotionRegressors(Stateful):
    """A source of the integrals of the regressors.

    Attributes:
        inputs: topics of its samples.
        lost: the missing inputs of the last results: `latitude`, `temperature`.
    """

    inputs: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()
    _stamp: IntArray
    _health: dict[str, int]

    @property
    def reached_ns(self) -> int:
        """Stamp up to which samples have arrived, or BEFORE_ALL."""
        return int(self._stamp[-1]) if len(self._stamp) else BEFORE_ALL

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take new samples of any of its inputs."""

    def at(self, stamp_ns: IntArray) -> FloatArray:
        """Return the integrals at increasing stamps [s], (n, c), and drop earlier ones."""
        raise NotImplementedError

    def health(self) -> dict[str, int]:
        """Return counters of refused samples, of gaps, and of unknown stamps."""
        return dict(self._health)


def integral_names(covariates: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the integrals on `drift/estimate`."""
    return tuple(f'{name}_integral_s' for name in covariates)


class SampledRegressors(MotionRegressors):
    """Sums the integrals of polynomials between samples.

    Attributes:
        name: the measured quantity, in the names of counters.
        valid_s: validity of the last sample [s].
    """

    name: ClassVar[str]
    valid_s: ClassVar[float]
    state_names: ClassVar[tuple[str, ...]] = ('stamp', 'piece', 'integral', 'last', 'health')

    def __init__(self, width: int, numbers: int) -> None:
        self._stamp = np.empty(0, np.int64)
        # numbers that give the polynomial after each sample, X at the samples
        self._piece, self._integral = np.empty((0, numbers)), np.empty((0, width))
        self._last = np.zeros((1, width))
        self._health = {f'{self.name}_refused': 0, f'{self.name}_unknown': 0}

    def at(self, stamp_ns: IntArray) -> FloatArray:
        """Return the integrals at increasing stamps [s], (n, c), and drop earlier ones.

        Stamps before the first sample have its integrals. They and late ones are counted.
        """
        stamps, late = self._stamp, np.ones(len(stamp_ns), bool)
        result = np.repeat(self._last, len(stamp_ns), axis=0)
        if len(stamps) and len(stamp_ns):
            at = np.maximum(stamp_ns, stamps[0])
            late = (at > stamp_ns) | (at - stamps[-1] > self.valid_s * NS_PER_S)
            place = np.searchsorted(stamps, at, 'right') - 1
            since = (at - stamps[place]) / NS_PER_S
            result = self._integral[place] + self._grown(place, since)
            self._forget(int(place[-1]))
        self._health[f'{self.name}_unknown'] += int(np.count_nonzero(late))
        if self.valid_s and len(late):
            self.lost = (self.name,) if late[-1] else ()
        return result

    def _grown(self, place: IntArray, since: FloatArray) -> FloatArray:
        """Return the growth of X in times from the samples at some places [s], (n, c)."""
        raise NotImplementedError

    def _extend(self, stamps: IntArray, pieces: FloatArray, areas: FloatArray) -> None:
        """Take the next samples, and the growth of X up to each."""
        sums = np.cumsum(np.concatenate((self._last, areas)), axis=0)
        self._stamp = np.concatenate((self._stamp, stamps))
        self._piece = np.concatenate((self._piece, pieces))
        self._integral = np.concatenate((self._integral, sums[len(sums) - len(stamps) :]))
        self._last = self._integral[-1:].copy()

    def _forget(self, count: int) -> None:
        self._stamp, self._piece = self._stamp[count:], self._piece[count:]
        self._integral = self._integral[count:]


class Regressors(SampledRegressors):
    """Integrates the regressors over `ship/imu`. The result does not depend on batches.

    Args:
        scene: names the covariates, and gives gravity and the sampling rate of the ship.
        live: whether a live sensor gives the samples. Then discontinuous ones are left out, and
            over a gap the integrals grow as usual.
    """

    inputs = (SHIP_IMU,)
    name, valid_s = 'motion', 0.0
    state_names = (
        *SampledRegressors.state_names, 'usual', 'swung', 'mean', 'swing', 'continuity',
    )  # fmt: skip

    def __init__(self, scene: Scene, *, live: bool) -> None:
        laws = {'heave': self._heave, 'roll': _roll}
        self._columns = [laws[name] for name in scene.drift.covariates or () if name in laws]
        trochlea = scene.trochlea
        plane = 'ship' if trochlea is None else trochlea.thread_plane
        length = 0.0 if trochlea is None else trochlea.thread.swinging_length
        self._thread: dict[str, Any] = {
            'gravity': scene.g,
            'rate': math.sqrt(scene.g / length) if length else 0.0,
            'leans': plane != 'vertical',
            'ship_fixed': plane == 'ship',
        }
        self._mean, self._swing = np.full(1, scene.g), np.zeros(2)
        self._swung = False
        self._continuity: Continuity | None = None
        if live:
            longest_ns = max(round(MAX_GAP_S * NS_PER_S), 2 * scene.step_ns * scene.lies_still)
            self._continuity = Continuity(scene.step_ns, longest_ns)
        width = len(self._columns)
        super().__init__(width, width)
        self._usual, self._health['motion_gaps'] = np.zeros(width), 0
        begun = self.state()
        zero = np.zeros(1)
        self._add(imu_from_roll(np.zeros(1, np.int64), zero, zero, zero, zero))  # compiles
        self.restore(begun)

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take motion samples. Bad ones are counted and left out."""
        imu = batches.get(SHIP_IMU)
        if not isinstance(imu, ImuSamples) or not len(imu.stamp_ns):
            return
        if self._continuity is None:
            last_ns = self.reached_ns if len(self._stamp) else None
            imu, refused = screen(imu, last_ns)
            self._health['motion_refused'] += sum(refused.values())
            self._add(imu)
            return
        good = refusal_reasons(imu, None, by_stamp=False) == 0
        self._health['motion_refused'] += int(np.count_nonzero(~good))
        for run in self._continuity.feed(imu if good.all() else take(imu, good)):
            if run.begins and len(self._stamp):
                # the integrals grow as usual since the last sample of the earlier run
                self._health['motion_gaps'] += 1
                begins_ns = int(run.imu.stamp_ns[0])
                edges = np.array([self._stamp[-1] + 1, begins_ns - 1], np.int64)
                if edges[1] > edges[0]:
                    self._append(edges, np.stack([self._usual, self._usual]))
                elif begins_ns <= self._stamp[-1]:  # stamps have gone back: another time begins
                    self._forget(len(self._stamp))
            self._add(run.imu)

    def _grown(self, place: IntArray, since: FloatArray) -> FloatArray:
        """Return the growth of X, linear in the regressor, and after the last sample as usual."""
        stamps, value, elapsed = self._stamp, self._piece, since[:, None]
        upper = np.minimum(place + 1, len(stamps) - 1)
        step = (np.maximum(stamps[upper] - stamps[place], 1) / NS_PER_S)[:, None]
        rise = (value[upper] - value[place]) / step
        growth = elapsed * (value[place] + 0.5 * rise * elapsed)
        return np.where((upper == place)[:, None], self._usual * elapsed, growth)

    def _add(self, imu: ImuSamples) -> None:
        stamps = imu.stamp_ns
        if not len(stamps):
            return
        previous = self._stamp[-1:] if len(self._stamp) else stamps[:1]
        steps = np.diff(stamps, prepend=previous) / NS_PER_S
        value = np.column_stack([column(imu, steps) for column in self._columns])
        if self._continuity is not None:
            for j, column in enumerate(value.T):
                means, usual = np.empty(len(column)), float(self._usual[j])
                followed(np.ascontiguousarray(column), steps / (USUAL_S + steps), usual, means)
                self._usual[j] = means[-1]
        self._append(stamps, value)

    def _heave(self, imu: ImuSamples, steps: FloatArray) -> FloatArray:
        """Return [2 f_x² + 2 f_y² - (f_z - ⟨f_z⟩)²]/(8 g²), the rate of a shaken weight.

        f_x counts for a thread that leans freely (hull.md). With a plane fixed to the ship the
        force along the ship's axle, which the thread cannot follow, is subtracted. A thread of
        length l that swings athwart has its angle instead of f_y, 1/(1 - l Ω²/g) times as large.
        """
        values = np.empty(len(steps))
        thread = Follower(**self._thread, mean=self._mean, swing=self._swing)
        orientation, force = contiguous(imu.orientation), contiguous(imu.linear_acceleration)
        if thread.rate > 0.0 and not self._swung:
            # the thread hangs in the direction of the first force
            begins = take(imu, slice(0, 1))
            thread.swing[:] = level_force(begins)[1][0], 0.0
            self._swung = True
        heaved(orientation, force, steps, thread, values)
        return values

    def _append(self, stamps: IntArray, value: FloatArray) -> None:
        times = np.concatenate((self._stamp[-1:], stamps))
        values = np.concatenate((self._piece[-1:], value))
        areas = 0.5 * (np.diff(times) / NS_PER_S)[:, None] * (values[:-1] + values[1:])
        self._extend(stamps, value, areas)


# -----------------------------------------------------------------------------
# Slow covariates: gravity by the latitude, and the temperature.
#
# Between two samples such a quantity is a + b s after the time s, and so X is a polynomial. With
# gravity g_ref at which the dial was regulated, normal gravity γ and Eötvös' term E of the motion,
#
#     x_gravity = (γ - E - g_ref)/(2 g_ref),
#     x_temperature = T - T_ref [K],    x_temperature_squared = (T - T_ref)² [K²].


class SlowRegressor(SampledRegressors):
    """Integrates regressors that are linear or quadratic in time between samples.

    The result does not depend on batches. After the last sample the quantity stays constant,
    before the first it is as at the start.

    Args:
        live: whether stamps may go back, as in a graph with time that begins again.
        powers: exponents of the quantity in the regressors.
    """

    valid_s = STALE_S
    state_names: ClassVar[tuple[str, ...]] = (*SampledRegressors.state_names, 'said')
    topic: ClassVar[str]

    def __init__(self, *, live: bool, powers: tuple[int, ...] = (1,)) -> None:
        super().__init__(len(powers), 2)  # a, b of each piece
        self._live, self.powers = live, powers
        self.inputs = (self.topic,)
        self._said = np.empty((0, 0))

    def usable(self, samples: Any) -> NDArray[np.bool_]:
        """Return which samples can be used."""
        raise NotImplementedError

    def values(self, samples: Any) -> FloatArray:
        """Return the stored columns of samples, (n, m)."""
        raise NotImplementedError

    def pieces(self, stamp_ns: IntArray, values: FloatArray) -> FloatArray:
        """Return a and b from each sample to the next, and after the last, with b = 0, (n, 2)."""
        raise NotImplementedError

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take samples. Bad ones, and those out of order, are counted and left out."""
        samples = batches.get(self.topic)
        if samples is None or not len(samples.stamp_ns):
            return
        good = self.usable(samples)
        stamps = samples.stamp_ns
        if self._live:
            jumps = np.flatnonzero(np.diff(stamps, prepend=self.reached_ns) < -HELD_NS)
            if len(self._stamp) and len(jumps):  # another time begins
                good[: jumps[-1]] = False
                self._forget(len(self._stamp))
        good[good] = in_order(stamps[good], self.reached_ns)
        self._health[f'{self.name}_refused'] += int(np.count_nonzero(~good))
        if not good.any():
            return
        known_count, values = len(self._stamp[-1:]), self.values(samples)[good]
        stamps = np.concatenate((self._stamp[-1:], stamps[good]))
        values = np.concatenate((self._said, values)) if known_count else values
        pieces = self.pieces(stamps, values)
        if known_count:  # until now the last sample was constant
            self._piece[-1] = pieces[0]
        areas = self._of_pieces(pieces[:-1], np.diff(stamps) / NS_PER_S)
        self._extend(stamps[known_count:], pieces[known_count:], areas)
        self._said = values[-1:]

    def _grown(self, place: IntArray, since: FloatArray) -> FloatArray:
        """Return the growth of X since some samples [s], (n, c)."""
        return self._of_pieces(self._piece[place], since)

    def _of_pieces(self, piece: FloatArray, since: FloatArray) -> FloatArray:
        a, b = piece.T
        grown = {
            1: since * (a + 0.5 * b * since),
            2: since * (a * a + since * (a * b + b * b * since / 3.0)),
        }
        return np.column_stack([grown[power] for power in self.powers])


class Gravity(SlowRegressor):
    """Gravity at the places on `ship/fix`, minus Eötvös' term between them.

    Args:
        scene: gives gravity at which the dial was regulated.
        fixes: sorts the fixes of a live receiver. `None`: they are a scene's.
    """

    state_names = (*SlowRegressor.state_names, 'fixes')
    topic, name = SHIP_FIX, 'latitude'

    def __init__(self, scene: Scene, fixes: LiveFixes | None) -> None:
        super().__init__(live=fixes is not None)
        self._gravity, self._fixes = scene.g, fixes

    def usable(self, samples: FixSamples) -> NDArray[np.bool_]:
        """Return which fixes have a place on the globe, within the reach of a live ship."""
        on_globe = (np.abs(samples.latitude) <= 90.0) & (np.abs(samples.longitude) <= 360.0)
        good: NDArray[np.bool_] = on_globe & (samples.status >= STATUS_FIX)
        if self._fixes is not None and good.any():
            good[good] = self._fixes.taken(take(samples, good))
        return good

    def health(self) -> dict[str, int]:
        """Return counters, with the live fixes' reasons for refusals."""
        return {**super().health(), **(self._fixes.health() if self._fixes else {})}

    def values(self, samples: FixSamples) -> FloatArray:
        """Return latitude and longitude [degrees]."""
        return np.column_stack((samples.latitude, samples.longitude))

    def pieces(self, stamp_ns: IntArray, values: FloatArray) -> FloatArray:
        """Return the regressor from each fix to the next, constant after the last."""
        elapsed_s = np.diff(stamp_ns) / NS_PER_S
        gravity, lifted = gravity_between(elapsed_s, *values.T)
        net = gravity - np.append(lifted, lifted[-1:] if len(lifted) else 0.0)
        rise = np.append(np.diff(gravity) / elapsed_s, 0.0)
        return np.column_stack((0.5 * (net / self._gravity - 1.0), 0.5 * rise / self._gravity))


class Temperature(SlowRegressor):
    """Temperature of the clock's box minus its initial value, and its square.

    Between samples it is linear. Impossible values of air, such as 293, are left out.
    """

    topic, name = SHIP_TEMPERATURE, 'temperature'

    def __init__(self, scene: Scene, powers: tuple[int, ...], *, live: bool) -> None:
        super().__init__(live=live, powers=powers)
        self._begins = float(BoxTemperature(scene).at(np.zeros(1, np.int64))[0])

    def usable(self, samples: TemperatureSamples) -> NDArray[np.bool_]:
        """Return which samples may be degrees Celsius."""
        return (samples.temperature >= COLDEST) & (samples.temperature <= WARMEST)

    def values(self, samples: TemperatureSamples) -> FloatArray:
        """Return the temperature since the start [K]."""
        return samples.temperature[:, None] - self._begins

    def pieces(self, stamp_ns: IntArray, values: FloatArray) -> FloatArray:
        """Return the regressor from each sample to the next, constant after the last."""
        rise = np.diff(values[:, 0]) / (np.diff(stamp_ns) / NS_PER_S)
        return np.column_stack((values[:, 0], np.append(rise, 0.0)))


class AllRegressors(MotionRegressors):
    """Joins the integrals of several sources, in the order of the scene's covariates."""

    state_names = ('sources',)

    def __init__(self, covariates: tuple[str, ...], sources: dict[tuple[str, ...], Any]) -> None:
        self._sources: tuple[MotionRegressors, ...] = tuple(sources.values())
        all_names = [name for names in sources for name in names]
        self._order = [all_names.index(name) for name in covariates]
        self.inputs = tuple(topic for source in self._sources for topic in source.inputs)

    @property
    def reached_ns(self) -> int:
        """Stamp that all sources have reached."""
        return min(source.reached_ns for source in self._sources)

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take new samples."""
        for source in self._sources:
            source.feed(batches)

    def at(self, stamp_ns: IntArray) -> FloatArray:
        """Return the integrals at increasing stamps [s], (n, c), and drop earlier ones."""
        integrals = np.concatenate([source.at(stamp_ns) for source in self._sources], axis=1)
        self.lost = tuple(name for source in self._sources for name in source.lost)
        return integrals[:, self._order]

    def health(self) -> dict[str, int]:
        """Return counters."""
        return {name: n for source in self._sources for name, n in source.health().items()}


def regressors(scene: Scene, *, live: bool, fixes: LiveFixes | None = None) -> MotionRegressors:
    """Return the source of the integrals of a scene's covariates. Arguments as in its classes."""
    covariates = scene.drift.covariates or ()
    sources: dict[tuple[str, ...], MotionRegressors] = {}
    if moves := tuple(name for name in covariates if name in SHAKEN_BY):
        sources[moves] = Regressors(scene, live=live)
    if 'gravity' in covariates:
        sources['gravity',] = Gravity(scene, (fixes or LiveFixes()) if live else None)
    if heat := tuple(name for name in covariates if name in HEAT):
        sources[heat] = Temperature(scene, tuple(HEAT[name] for name in heat), live=live)
    only, *extra = sources.values()
    return AllRegressors(covariates, sources) if extra else only


class SharedIntegrals(MotionRegressors):
    """Gives the integrals at the logged instants to several clocks in one sea, computed once.

    The owner of the sea feeds it (`take`) before the clocks.

    Args:
        scene: of any of the clocks, which must agree in `key`.
    """

    state_names = ('next_ns', 'stamp', 'integral', 'source')

    def __init__(self, scene: Scene) -> None:
        self._source = regressors(scene, live=False)
        self._next_ns, self._every_ns = scene.starts_at_ns, scene.log_interval_ns
        self._stamp: IntArray = np.empty(0, np.int64)
        self._integral = np.empty((0, len(scene.drift.covariates or ())))

    @staticmethod
    def key(scene: Scene) -> tuple[object, ...]:
        """Return the settings that clocks in one sea must share."""
        trochlea = scene.trochlea
        leans = None if trochlea is None else (trochlea.thread_plane, trochlea.thread)
        return scene.drift.covariates, scene.g, repr(leans), repr(scene.air)

    def take(self, batches: Mapping[str, Samples]) -> None:
        """Take the next samples of the ship."""
        self._source.feed(batches)
        new = np.arange(self._next_ns, self._source.reached_ns + 1, self._every_ns)
        if len(new):
            self._next_ns = int(new[-1]) + self._every_ns
            self._stamp = np.concatenate((self._stamp, new))
            self._integral = np.concatenate((self._integral, self._source.at(new)))

    def at(self, stamp_ns: IntArray) -> FloatArray:
        """Return the integrals at logged instants that have been reached [s], (n, c)."""
        place = np.searchsorted(self._stamp, stamp_ns)
        if len(place) and not (
            place[-1] < len(self._stamp) and np.array_equal(self._stamp[place], stamp_ns)
        ):
            raise ValueError('stamps that are not logged, or not reached yet')
        return np.asarray(self._integral[place], np.float64)

    def health(self) -> dict[str, int]:
        """Return the counters of the source."""
        return self._source.health()


class RecordedIntegrals(MotionRegressors):
    """Gives the integrals of the covariates by a `drift/estimate` of at least one sample."""

    state_names = ('health',)

    def __init__(self, estimate: JointSamples, covariates: tuple[str, ...]) -> None:
        columns = [estimate.name.index(name) for name in integral_names(covariates)]
        is_new = in_order(estimate.stamp_ns, BEFORE_ALL)
        self._stamp = estimate.stamp_ns[is_new]
        self._integral = estimate.position[is_new][:, columns]
        self._health = {'motion_unknown': 0}

    def at(self, stamp_ns: IntArray) -> FloatArray:
        """Return the integrals at stamps [s], (n, c), linear between estimates."""
        origin_ns, stamps = self._stamp[0], self._stamp
        is_outside = (stamp_ns < origin_ns) | (stamp_ns > stamps[-1])
        self._health['motion_unknown'] += int(np.count_nonzero(is_outside))
        at, times = (stamp_ns - origin_ns) / NS_PER_S, (stamps - origin_ns) / NS_PER_S
        return np.column_stack([np.interp(at, times, column) for column in self._integral.T])


def _roll(imu: ImuSamples, steps: FloatArray) -> FloatArray:
    from tauto_core.ship.kernels import roll_of

    del steps
    roll = np.empty(len(imu.stamp_ns))
    roll_of(contiguous(imu.orientation), None, roll, None)
    return roll * roll
