"""A voyage: a scene sailed offline or replayed from a bag, and its data as arrays."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast
from warnings import warn

import numpy as np

from tauto_core.checks.readiness import check_known, check_scene, plausibility_warnings
from tauto_core.clockwork import TrochleaStage
from tauto_core.kernels import optimised
from tauto_core.machines import AnyMachine, OtherRegulator
from tauto_core.navigation import DriftStage, LongitudeStage, Route, drift_warnings
from tauto_core.navigation.regressors import SHAKEN_BY, RecordedIntegrals, integral_names
from tauto_core.results import Summary, answer, dataset, drawn_by, frame, sea_of
from tauto_core.samples import (
    CORRECTED,
    ESTIMATE,
    JOINT_STATES,
    LONGITUDE_ERROR,
    LONGITUDE_FIX,
    OBSERVATION,
    PHASE,
    READING,
    SCENE,
    SHIP_FIX,
    SHIP_IMU,
    SHIP_TEMPERATURE,
    SLACK,
    Batches,
    FloatArray,
    ImuSamples,
    JointSamples,
    Samples,
    SpatialImu,
    Stage,
    Stateful,
    TemperatureSamples,
    TimeSamples,
    join,
    merged,
    text,
)
from tauto_core.scene import Scene, parse_scene, scene_yaml
from tauto_core.scene.errors import (
    Argument,
    BagError,
    PropagationError,
    TautoError,
    TautoWarning,
    naming,
)
from tauto_core.scene.times import NS_PER_S
from tauto_core.ship import REFUSALS, Observations, ShipMotion, bag_metadata
from tauto_core.ship.airs import BoxTemperature
from tauto_core.ship.buffer import SharedBuffers
from tauto_core.ship.coast import ends_of
from tauto_core.ship.imu import attitude, message, screen

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame
    from xarray import Dataset

    from tauto_core.bags import Bag

# `bags` is imported when a bag is needed: it would take a tenth of the start.


CHUNK = 65_536
"""Motion samples processed at once. The result does not depend on it."""

QUIET_CHUNK = 2 * CHUNK
"""The same without motion as messages: a linear machine takes a fifth less time."""

HUNG_CHUNK = CHUNK // 2
"""The same for a suspended clock: its arrays stay in the cache, which saves a quarter of the time.
"""

SAILED_TO_COMPILE_S = 20.0
"""Length of a voyage that calls all its kernels, including those for long pieces of forcing
[s]."""


class ShipSource(Stateful):
    """The samples of the ship, in order of their stamps: motion, position, observations.

    A scene with `air` adds the temperature in the box of the clock, on the log grid up to the
    first instant at or after the last sample of the motion. With `says_scene` the scene's text
    comes first. Without `as_messages` the motion is computed for the clock only.

    Attributes:
        total: number of motion samples, including some beyond the end.
        produced: number of those produced so far.
    """

    state_names = ('produced', 'motion')
    outputs = (SCENE, SHIP_IMU, SHIP_FIX, SHIP_TEMPERATURE, OBSERVATION)

    def __init__(
        self,
        scene: Scene,
        motion: ShipMotion | None = None,
        *,
        says_scene: bool = True,
        as_messages: bool = True,
    ) -> None:
        self._scene, self._says_scene = scene, says_scene
        self._starts_at_ns, self._duration_ns = scene.starts_at_ns, scene.duration_ns
        self._step_ns, self._log_ns = scene.step_ns, scene.log_interval_ns
        self._motion = ShipMotion(scene) if motion is None else motion
        self._observations = Observations(scene)
        self._route = Route(scene)
        self._box = None if scene.air is None else BoxTemperature(scene)
        self.produced, self._as_messages = 0, as_messages
        self.total = self._motion.total

    def produce(self, count: int) -> Batches:
        """Return the next `count` motion samples and the other samples up to their stamps."""
        starts_at, interval = self._starts_at_ns, self._log_ns
        imu = self._motion.produce(count) if self._as_messages else self._motion.sense(count)
        if not len(imu.stamp_ns):
            return {}
        start, stop = self.produced, self.produced + len(imu.stamp_ns)
        self.produced = stop
        batches: Batches = {SHIP_IMU: imu}
        if start == 0 and self._says_scene:
            batches[SCENE] = text(starts_at, scene_yaml(self._scene))
        begin, end = start * self._step_ns, min(stop * self._step_ns, self._duration_ns + 1)
        logs = np.arange(-(-begin // interval), -(-end // interval))
        if len(logs):
            batches[SHIP_FIX] = self._route.fixes(starts_at + logs * interval)
        if self._box is not None:
            # the clock interpolates the motion a little beyond the end
            margin = self._step_ns if stop < self.total else interval
            until = (stop - 1) * self._step_ns + margin
            grid = np.arange(-(-begin // interval), -(-until // interval))
            if len(grid):
                batches[SHIP_TEMPERATURE] = TemperatureSamples(
                    starts_at + grid * interval,
                    'clock_case',
                    self._box.at(grid),
                    np.zeros(len(grid)),
                )
        if begin < end:
            observations = self._observations.between(starts_at + begin, starts_at + end)
            if len(observations.stamp_ns):
                batches[OBSERVATION] = observations
        return batches


class Pipeline(Stateful):
    """Stages in their order: each stage receives the output of all earlier ones."""

    state_names = ('stages',)

    def __init__(self, stages: Sequence[Stage]) -> None:
        self._stages = tuple(stages)

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Return the input and the outputs of all stages."""
        return self._run(dict(batches), final=False)

    def finish(self) -> Batches:
        """Return the remaining samples of all stages."""
        return self._run({}, final=True)

    def _run(self, known: Batches, *, final: bool) -> Batches:
        for stage in self._stages:
            wanted = {topic: known[topic] for topic in stage.inputs if topic in known}
            outputs = [stage.feed(wanted)] if wanted else []
            outputs += [stage.finish()] if final else []
            for batches in outputs:
                for topic, samples in batches.items():
                    earlier = [known[topic]] if topic in known else []
                    known[topic] = join([*earlier, samples])  # type: ignore[type-var]
        return known

    def health(self) -> dict[str, int]:
        """Return the nonzero counters of all stages."""
        counters: dict[str, int] = {}
        for stage in self._stages:
            counters.update({name: n for name, n in stage.health().items() if n})
        return counters


def pipeline(
    scene: Scene,
    machine: AnyMachine | OtherRegulator | None = None,
    buffers: SharedBuffers | None = None,
) -> Pipeline:
    """Return the stages of a scene: trochlea, drift, longitude.

    Args:
        scene: the scene.
        machine: its machine, if it is built already.
        buffers: shared by several clocks in one sea, see `TrochleaStage`.
    """
    trochlea = TrochleaStage(scene, machine=machine, buffers=buffers)
    return Pipeline([trochlea, DriftStage(scene), LongitudeStage(scene)])


# -----------------------------------------------------------------------------
# A voyage as arrays, each named with its unit.


_RENAMED = {
    'offset_s': 'estimated_error_s',
    'offset_sigma_s': 'estimated_error_sigma_s',
    'rate_sigma_s_per_day': 'estimated_rate_sigma_s_per_day',
    'mean_rate_s_per_day': 'estimated_mean_rate_s_per_day',
    'mean_rate_sigma_s_per_day': 'estimated_mean_rate_sigma_s_per_day',
}
"""Arrays of estimates by their names in version 0.2."""


def _fixed(values: FloatArray) -> FloatArray:
    """Return a read-only view of an array."""
    return np.broadcast_to(values, values.shape)


def _error_s(clock: TimeSamples) -> FloatArray:
    return (clock.time_ref_ns - clock.stamp_ns) / NS_PER_S


def _array(
    topic: str, column: Callable[[Any], FloatArray] | str | None = None
) -> cached_property[FloatArray]:
    return cached_property(lambda voyage: voyage._read(topic, column))


def _figure(section: str, name: str) -> cached_property[float]:
    def figure(voyage: Voyage) -> float:
        value = voyage.result.get(section, {}).get(name)
        return math.nan if value is None else float(value)

    return cached_property(figure)


@dataclass(frozen=True, eq=False, repr=False)
class Voyage:
    """The data of a clock on a voyage.

    Figures of the end of the voyage are numbers, NaN if unknown. Arrays are (n,) and read-only,
    with one value for each logged sample, at `time_s` from the start. Arrays named `motion_…` have
    the full rate of the ship's motion, if the voyage logs it (`log.motion`). Arrays without data
    are empty.

    Attributes:
        scene: the scene that was sailed.
        result: the figures, as `tauto sail --json` and `tauto replay --json` print them.
        samples: the contents of the messages, by topic and field.
    """

    scene: Scene
    result: Mapping[str, Any]
    samples: Mapping[str, Samples]

    def __repr__(self) -> str:
        return f'<Voyage of {self.scene.name}: {self.answer}>'

    def _repr_html_(self) -> str:
        return str(drawn_by('notebook', 'voyage_html')(self))

    @property
    def answer(self) -> str:
        """The result of the voyage in a sentence."""
        return str(self.result['answer'])

    error_s = _figure('clock', 'error_s')
    """Reading of the dial less the true time at the end [s], positive if fast."""

    rate_s_per_day = _figure('clock', 'rate_s_per_day')
    """Mean rate of the dial over the voyage [s/day], positive if fast."""

    amplitude_rad = _figure('trochlea', 'amplitude_rad')
    """Amplitude of the wheel at the end [rad]."""

    raw_error_nmi = _figure('longitude', 'raw_error_nmi')
    """Error of the ship's longitude by the dial at the end, to the east [nautical miles]."""

    error_nmi = _figure('longitude', 'error_nmi')
    """Error of the ship's longitude by the corrected clock at the end [nautical miles]."""

    sigma_nmi = _figure('longitude', 'sigma_nmi')
    """Standard deviation of `error_nmi` as the navigator states it [nautical miles]."""

    @cached_property
    def ship_motion(self) -> ShipMotion:
        """The motion of the ship, computed from the scene."""
        return ShipMotion(self.scene)

    @cached_property
    def start_ns(self) -> int:
        """Stamp of the first reading [ns]."""
        return int(self.samples[READING].stamp_ns[0])

    time_s = _array(READING)
    """True time since the first reading [s]."""

    clock_error_s = _array(READING, _error_s)
    """Reading of the dial less the true time [s], positive if fast."""

    corrected_error_s = _array(CORRECTED, _error_s)
    """Reading less its estimated error, less the true time [s]."""

    estimated_error_s = _array(ESTIMATE, 'offset_s')
    """Error of the dial as the navigator estimates it [s]."""

    estimated_error_sigma_s = _array(ESTIMATE, 'offset_sigma_s')
    """Standard deviation of `estimated_error_s` [s]."""

    estimated_rate_s_per_day = _array(ESTIMATE, 'rate_s_per_day')
    """Estimated rate of the dial [s/day], positive if fast. With covariates: at rest."""

    estimated_mean_rate_s_per_day = _array(ESTIMATE, 'mean_rate_s_per_day')
    """Estimated rate [s/day]. With covariates: its mean since the start."""

    estimated_mean_rate_sigma_s_per_day = _array(ESTIMATE, 'mean_rate_sigma_s_per_day')
    """Standard deviation of `estimated_mean_rate_s_per_day` [s/day]."""

    estimated_rate_sigma_s_per_day = _array(ESTIMATE, 'rate_sigma_s_per_day')
    """Standard deviation of `estimated_rate_s_per_day` [s/day]."""

    def __getattr__(self, name: str) -> FloatArray:
        """Return an array of estimates by its name in version 0.2."""
        renamed = _RENAMED.get(name)
        if renamed is None:
            raise AttributeError(f'{type(self).__name__!r} object has no attribute {name!r}')
        warn(f'Voyage.{name} is now {renamed}. Use that', TautoWarning, stacklevel=2)
        array: FloatArray = getattr(self, renamed)
        return array

    angle_rad = _array(JOINT_STATES, lambda states: states.position[:, 0])
    """Angle of the wheel in its case [rad], or arc of a body in a fluid [m]."""

    angular_velocity_rad_s = _array(JOINT_STATES, lambda states: states.velocity[:, 0])
    """Angular velocity of the wheel in its case [rad/s], or speed of a body in a fluid
    [m/s]."""

    phase_rad = _array(PHASE, 'phase')
    """Phase of the swing since the release [rad], 2π per period."""

    raw_longitude_error_nmi = _array(LONGITUDE_ERROR, 'raw_error_nmi')
    """Error of the ship's longitude by the dial, to the east [nautical miles]."""

    longitude_error_nmi = _array(LONGITUDE_ERROR, 'error_nmi')
    """Error of the ship's longitude by the corrected clock, to the east [nautical miles]."""

    longitude_sigma_nmi = _array(LONGITUDE_ERROR, 'sigma_nmi')
    """Standard deviation of `longitude_error_nmi` [nautical miles]."""

    latitude_deg = _array(SHIP_FIX, lambda fix: fix.latitude)
    """True latitude of the ship [degrees north]."""

    longitude_deg = _array(SHIP_FIX, lambda fix: fix.longitude)
    """True longitude of the ship [degrees east]."""

    clock_longitude_deg = _array(LONGITUDE_FIX, lambda fix: fix.longitude)
    """Longitude of the ship by the corrected clock [degrees east]."""

    @cached_property
    def temperature_celsius(self) -> FloatArray:
        """Temperature in the box of the clock at `time_s` [°C], empty without `air`."""
        celsius = self._read(SHIP_TEMPERATURE, lambda samples: samples.temperature)
        return self._at_logs(self._read(SHIP_TEMPERATURE), celsius)

    observation_time_s = _array(OBSERVATION)
    """Times at which the clock was compared with the true time, from the first reading [s]."""

    @cached_property
    def observed_error_s(self) -> FloatArray:
        """Reading at `observation_time_s` less the observed true time [s]."""
        if OBSERVATION not in self.samples:
            return np.empty(0)
        error = np.interp(self.observation_time_s, self.time_s, self.clock_error_s)
        return _fixed(error - self._read(OBSERVATION, _error_s))

    motion_time_s = _array(SHIP_IMU)
    """Time of the motion's samples, from the first reading [s]."""

    motion_roll_rad = _array(SHIP_IMU, lambda imu: attitude(imu).roll)
    """Roll of the ship [rad], positive with starboard side down."""

    @cached_property
    def roll_rad(self) -> FloatArray:
        """Roll of the ship at `time_s` [rad], empty if the voyage does not log its motion."""
        return self._at_logs(self.motion_time_s, self.motion_roll_rad)

    motion_gravity_m_s2 = _array(
        SHIP_IMU, lambda imu: np.sqrt(np.square(imu.linear_acceleration).sum(axis=1))
    )
    """Apparent gravity at the clock: magnitude of the specific force [m/s2]."""

    def plot(
        self,
        what: str,
        file: str | Path | None = None,
        *,
        from_s: float | str | None = None,
        to_s: float | str | None = None,
    ) -> Figure:
        """Draw a picture of the voyage, see `tauto_core.plot`."""
        picture = drawn_by('contents', 'picture')
        return cast('Figure', picture(self, what, file, from_s=from_s, to_s=to_s))

    def report(self, file: str | Path) -> None:
        """Write the voyage as a page, see `tauto_core.report`."""
        drawn_by('page', 'check_report')(Path(file))
        drawn_by('page', 'write_report')(self, Path(file), f'voyage.report({str(file)!r})')

    def to_xarray(self) -> Dataset:
        """Return the arrays of the voyage as a dataset of xarray, with `units` and `long_name`.

        Its dimensions are `time_s` (logged samples), `observation_time_s`, and `motion_time_s`
        (samples of the ship's motion), its attributes `scene` and `answer`. Empty arrays are left
        out.

        Raises:
            TautoError: xarray is not installed (extra `arrays`).
        """
        return dataset(self)

    def to_pandas(self) -> DataFrame:
        """Return the arrays of the logged samples as a frame of pandas, indexed by `time_s`.

        `attrs` has `scene`, `answer` and the `units` by column. Empty arrays are left out.

        Raises:
            TautoError: xarray, which has pandas, is not installed (extra `arrays`).
        """
        return frame(self)

    def write(self, bag: str | Path, *, force: bool = False) -> None:
        """Write a rosbag2 folder, with the messages that `tauto sail --out` writes.

        Args:
            bag: a new folder.
            force: replace an existing bag.

        Raises:
            BagError: the folder cannot be written.
        """
        from tauto_core.bags import BagWriter, check_folder

        folder = Path(bag)
        check_folder(folder, force=force)
        with BagWriter(folder, force=force) as writer:
            writer.describe(bag_metadata(self.scene))
            writer.describe(self.result.get('marks', {}))
            samples = dict(self.samples)
            samples.setdefault(SCENE, text(self.start_ns, scene_yaml(self.scene)))
            writer.write(samples)

    def _read(
        self, topic: str, column: Callable[[Any], FloatArray] | str | None = None
    ) -> FloatArray:
        """Return a column of a topic by its name or a function, else the times of its samples [s].

        It is empty if the voyage lacks the topic.
        """
        samples: Any = self.samples.get(topic)
        if samples is None:
            return _fixed(np.empty(0))
        if column is None:
            return _fixed((samples.stamp_ns - self.start_ns) / NS_PER_S)
        if callable(column):
            return _fixed(column(samples))
        # without covariates the rate is the same as its mean
        name = column if column in samples.name else column.removeprefix('mean_')
        return _fixed(samples.position[:, samples.name.index(name)])

    def _at_logs(self, times: FloatArray, values: FloatArray) -> FloatArray:
        return _fixed(np.interp(self.time_s, times, values)) if len(times) else times


# -----------------------------------------------------------------------------
# A scene sailed offline, and a bag replayed.


def sail(
    scene: Scene,
    out: Path | None = None,
    *,
    origin: str | None = None,
    force: bool = False,
    anyway: bool = False,
    keep: bool = True,
    progress: Callable[[float], None] | None = None,
    watch: Callable[[Batches], None] | None = None,
    judge: bool = False,
) -> Voyage:
    """Sail a scene offline and return the voyage.

    Its `result` has `sea` for a ship in a sea, and `warnings` if a number is probably in the wrong
    unit, measured motion could not be read to its end, waves were left out, or observations
    disagreed with the clock by more than `drift.gate`.

    Args as of `tauto.sail`, and:
        origin: file or name that the user gave, for errors. Default: the scene's name.
        keep: keep the samples. Without them the voyage has only its `result`, memory does not grow
            with its length, and a linear machine takes less time.
        watch: called with all samples, batch after batch.
        judge: add the `accuracy` asked and reached to the result, by trials of the beginning, if
            the scene states `solver.accuracy`, or the ship rolls too steeply for the default.

    Raises:
        TautoError: bad scene, no place for the bag, or an event that ends the motion.
    """
    started = time.perf_counter()
    with naming(origin or scene.name, scene.name):
        if not anyway:
            check_known(scene)
        machine, motion = check_scene(scene)
    logs = out is not None or keep
    as_messages = (
        any(name in SHAKEN_BY for name in scene.drift.covariates or ())
        or watch is not None
        or (logs and scene.keeps_motion)
    )
    source = ShipSource(
        scene, motion, says_scene=logs or watch is not None, as_messages=as_messages
    )
    stages, summary, parts = pipeline(scene, machine), Summary(scene, machine), list[Batches]()
    chunk, under_way = CHUNK if as_messages else QUIET_CHUNK, True
    if scene.suspension is not None:
        chunk = min(chunk, HUNG_CHUNK)
    with ExitStack() as stack:
        bag = None
        if out is not None:
            from tauto_core.bags import BagWriter

            bag = stack.enter_context(BagWriter(out, force=force))
            bag.describe(bag_metadata(scene))
        while under_way:
            under_way = source.produced < source.total
            batches = stages.feed(source.produce(chunk)) if under_way else stages.finish()
            if words := refused_words(stages.health()):
                raise PropagationError(words, source.produced * scene.step_ns / NS_PER_S)
            summary.feed(batches)
            if watch is not None:
                watch(batches)
            logged = {t: batches[t] for t in batches if t != SHIP_IMU or scene.keeps_motion}
            if bag is not None:
                bag.write(logged)
            if keep:
                parts.append(logged)
            if progress is not None:
                progress(source.produced / source.total)
    odd = plausibility_warnings(scene, machine)
    warnings = [*odd, *motion.warnings, *drift_warnings(stages.health(), scene)]
    reached = None
    if judge and scene.accuracy is not None:
        from tauto_core.checks.cost import accuracy_reached, is_steep, missed_words

        is_stated = scene.solver is not None and scene.solver.accuracy is not None
        if is_stated or is_steep(scene, machine):
            reached = accuracy_reached(scene, machine)
            if not reached['holds']:
                warnings.append(missed_words(reached))
    result = {
        **summary.result(),
        **({} if reached is None else {'accuracy': reached}),
        'wall_s': time.perf_counter() - started,
        'bag': None if out is None else str(out),
        **({'warnings': warnings} if warnings else {}),
    }
    return Voyage(scene, result, merged(parts))


def compile_kernels(scene: Scene) -> None:
    """Compile and optimise the kernels of a scene before a node needs them.

    The first seconds are run. Errors are ignored: the voyage reports them with their time.
    """
    source, stages = ShipSource(scene), pipeline(scene)
    samples = math.ceil(SAILED_TO_COMPILE_S * NS_PER_S / scene.step_ns)
    with optimised(), suppress(TautoError):
        motion = source.produce(samples)
        imu = motion[SHIP_IMU]
        assert isinstance(imu, ImuSamples | SpatialImu)
        screen(message(imu), None)  # a node receives messages
        stages.feed(motion)
        stages.finish()


def refused_words(health: Mapping[str, int]) -> str:
    """Return a sentence about samples of the ship that the stages refused, if any."""
    refused = [f'{n} {reason}' for reason in REFUSALS if (n := health.get(reason, 0))]
    if not refused:
        return ''
    return (
        f'samples of the ship that cannot be integrated: {", ".join(refused)}. Check the size of '
        'its motion, its height and gravity'
    )


def bag_scene(bag: Bag) -> Scene:
    """Return the scene of a bag; BagError without one, SceneError if it cannot be read."""
    if bag.scene is None:
        raise BagError(
            f'{bag.path}: no topic {SCENE!r}, so the bag has no scene. Give its scene (',
            Argument('scene', 'SCENE'),
            ')',
        )
    return parse_scene(bag.scene, f'{bag.path}:{SCENE}')


def summarise_bag(path: Path) -> dict[str, Any]:
    """Return the result of a recorded voyage, as `sail` gives it, without the wall time.

    BagError without a bag or a scene in it.
    """
    from tauto_core.bags import read_bag

    bag = read_bag(path)
    summary = Summary(bag_scene(bag))
    computed = (
        JOINT_STATES,
        PHASE,
        ESTIMATE,
        LONGITUDE_FIX,
        LONGITUDE_ERROR,
        SHIP_TEMPERATURE,
        SLACK,
    )
    for topics in ((OBSERVATION, READING), computed):  # the summary needs these two first
        for topic, part in bag.parts([topic for topic in topics if topic in bag]):
            summary.feed({topic: part})
    return {**summary.result(), 'bag': str(path)}


def replay(
    bag: Bag, scene: Scene | None = None, *, stability: bool = False, keep: bool = True
) -> Voyage:
    """Return the voyage in a bag, with drift and longitude estimated again.

    Args:
        bag: a bag with `clock/reading`, `clock/observation` and, for distances, `ship/fix`.
        scene: replaces the bag's own scene.
        stability: also estimate the stability of the clock (`stability_of`).
        keep: keep the samples, including those that are not computed again.

    Returns:
        A voyage. Its `result` has `scene`, `answer`, `clock`, `drift` and `longitude`, if known
        `sea` and `air`, `duration_s` (of the scene if it was sailed to its end, else of the bag),
        and the bag's `start_s`, message `counts`, `damage`, `warnings` (which include the damage)
        and `marks` of losses, for the metadata of a copy. On request it has `stability`.

    Raises:
        BagError: no readings, or no scene.
        EstimationError: the stability cannot be estimated.
        SceneError: the bag's scene cannot be read.
    """
    from tauto_core.bags.check import marks_of
    from tauto_core.bags.write import CUT_SHORT

    scene = bag_scene(bag) if scene is None else scene
    stated = [SHIP_IMU, SHIP_FIX, SHIP_TEMPERATURE, OBSERVATION, JOINT_STATES, PHASE, SLACK]
    wanted = [READING, OBSERVATION, SHIP_FIX, SHIP_TEMPERATURE, *(stated if keep else [])]
    if scene.drift.covariates:
        wanted.append(ESTIMATE if ESTIMATE in bag else SHIP_IMU)
    recorded = bag.batches([topic for topic in wanted if topic == READING or topic in bag])
    # integrals on drift/estimate are exact even if the motion is logged thinly
    motion, covariates, estimate = None, scene.drift.covariates or (), recorded.get(ESTIMATE)
    names = set(integral_names(covariates))
    if names and isinstance(estimate, JointSamples) and names <= set(estimate.name):
        motion = RecordedIntegrals(estimate, covariates)
    drift = DriftStage(scene, expect_schedule=False, motion=motion)
    stages = Pipeline([drift, LongitudeStage(scene, expect_fix=SHIP_FIX in bag)])
    inputs = [topic for topic in dict.fromkeys((*drift.inputs, SHIP_FIX)) if topic in bag]
    if SHIP_IMU in inputs and SHIP_IMU not in recorded:  # estimates without the integrals
        recorded |= bag.batches([SHIP_IMU])
    summary = Summary(scene)
    fed = stages.feed({topic: recorded[topic] for topic in inputs})
    tail = stages.finish()
    summary.feed(fed)
    summary.feed(tail)
    if SHIP_TEMPERATURE in recorded and SHIP_TEMPERATURE not in inputs:
        summary.feed({SHIP_TEMPERATURE: recorded[SHIP_TEMPERATURE]})
    samples, reading = merged([fed, tail]), cast(TimeSamples, recorded[READING])
    figures = {
        'clock': summary.clock(),
        'drift': summary.drift(),
        'longitude': summary.longitude(),
    }
    if stability:
        from tauto_core.navigation.stability import stability_of

        figures['stability'] = stability_of(cast(TimeSamples, fed[READING]))
    start_ns, end_ns = bag.start_ns or 0, bag.end_ns or 0
    if len(reading.stamp_ns) and bag.logged_from_ns[READING] != reading.stamp_ns[0]:
        # log times of a live bag are times of receipt by the computer's clock
        start_ns, end_ns = int(reading.stamp_ns[0]), int(reading.stamp_ns[-1])
    # the motion goes some steps beyond the end, for interpolation
    read_to_ns = int(reading.stamp_ns[-1]) if len(reading.stamp_ns) else end_ns
    is_whole = (start_ns, read_to_ns) == (
        scene.starts_at_ns,
        scene.starts_at_ns + scene.duration_ns,
    )
    marks, sentences = marks_of(bag)
    damage = [*bag.warnings, *sentences]
    if bag.warnings:
        marks |= CUT_SHORT
    without = {
        OBSERVATION: 'the drift is the prior of the scene',
        SHIP_FIX: 'the ship is assumed to stay at the start of the scene',
        SHIP_TEMPERATURE: 'the temperature is assumed constant',
        SHIP_IMU: 'nor has drift/estimate the integrals of drift.covariates, so the ship is '
        'assumed to be at rest',
    }
    missing = [
        f'{bag.path}: there is no topic {topic}: {reason}'
        for topic, reason in without.items()
        if topic not in bag and topic in (*drift.inputs, SHIP_FIX)
    ]
    sea = sea_of(scene) | ends_of(scene.voyage, scene.duration)
    result = {
        'scene': scene.name,
        'answer': answer({**figures, **sea, 'damage': damage}),
        'bag': str(bag.path),
        **sea,
        **figures,
        **summary.air(),
        'start_s': start_ns / NS_PER_S,
        'duration_s': scene.duration if is_whole else (end_ns - start_ns) / NS_PER_S,
        'counts': bag.counts,
        'damage': damage,
        **({'marks': marks} if marks else {}),
        'warnings': [*damage, *missing, *drift_warnings(stages.health(), scene)],
    }
    if not keep:
        return Voyage(scene, result, {})
    texts = {} if bag.scenes is None else {SCENE: bag.scenes}
    remaining = {topic: recorded[topic] for topic in stated if topic in recorded}
    return Voyage(scene, result, {**texts, **remaining, **samples})
