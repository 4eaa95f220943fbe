"""Comparison of clocks in one sea or with several rolls: its entries and their voyages.

Each process samples the sea, and moves the case that clocks hang in, once for all its clocks.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, cast

import numpy as np

from tauto_core import voyage
from tauto_core.checks.cost import work_s
from tauto_core.checks.readiness import check_known, check_scene
from tauto_core.clockwork.trochlea import on_first_day, regulated_period_s
from tauto_core.ensembles.rows import Voyages, figures_of, has_arrived, sail
from tauto_core.ensembles.workers import Share, jobs_for
from tauto_core.machines import AnyMachine, OtherRegulator
from tauto_core.navigation.regressors import SHAKEN_BY, SharedIntegrals
from tauto_core.results import Summary, drawn_by
from tauto_core.samples import READING, SHIP_IMU, Batches, Samples, TimeSamples
from tauto_core.scene import Scene, load_scene, parse_scene, scene_yaml
from tauto_core.scene.errors import (
    Argument,
    MotionDataError,
    PropagationError,
    SceneError,
    TautoError,
    UsageError,
    naming,
)
from tauto_core.scene.loader import origin_of
from tauto_core.scene.times import DAY_S, NS_PER_S
from tauto_core.ship import ShipMotion
from tauto_core.ship.buffer import SharedBuffers
from tauto_core.ship.imu import Sensed, kept, message
from tauto_core.ship.waves import Harmonics
from tauto_core.wording import counted, figure, least, span

# -----------------------------------------------------------------------------
# The amplitude of a ship's roll, and the same ship in the same waves with another roll.

LARGEST_DEG = 45.0
"""Largest roll that may be set. The linear roll equation does not hold for a larger roll."""


def significant_roll_deg(scene: Scene) -> float | None:
    """Return the significant amplitude of a ship's roll, 2 √(Σ a²/2) [deg].

    It is twice the root mean square, which in a narrow-banded sea is the mean of the highest third
    of the amplitudes (Longuet-Higgins 1952). For a single harmonic of amplitude a it is √2 a. In
    weather it belongs to the highest sea. It is `None` if the roll was measured, 0 for a still
    ship.
    """
    if not scene.ship.is_computed:
        return None
    roll = scene.ship.roughest(scene).channels(scene).roll
    if not isinstance(roll, Harmonics):
        return 0.0
    return math.degrees(2.0 * math.sqrt(0.5 * float(np.sum(roll.amplitude**2))))


def with_roll(scene: Scene, roll_deg: float) -> Scene:
    """Return the scene with another significant amplitude of the roll.

    Every harmonic of the roll is scaled by the same factor, in a sea through the slope coefficient
    or the response operator. Waves and heave stay unchanged. UsageError if the ship does not roll
    or is not of kind sea or components, or if the amplitude exceeds LARGEST_DEG.
    """
    if not 0.0 <= roll_deg <= LARGEST_DEG:
        raise UsageError(
            Argument('roll_deg', f'{roll_deg:g}'),
            f': must be between 0 and {LARGEST_DEG:g} degrees, twice the root mean square of the '
            'roll. Write for example 0,10,20',
        )
    ship, now = scene.ship, significant_roll_deg(scene)
    if not now or not ship.roll_scales:
        why = 'was measured' if now is None else 'follows from the hull' if now else 'is zero'
        raise UsageError(
            Argument('roll_deg', f'{roll_deg:g}'),
            f': the roll of {scene.name} (ship.kind {ship.kind}) {why} and cannot be scaled. Use '
            'a ship of kind sea or components that rolls, or leave out ',
            Argument('roll_deg'),
        )
    return scene.model_copy(update={'ship': ship.with_roll_scaled(roll_deg / now)})


# -----------------------------------------------------------------------------
# The entries of a comparison: clocks, fixed or suspended, in one sea or with several rolls.

CLOCKS = (
    'clock_cheek_weight',
    'clock_involute_weight',
    'clock_own_cam_weight',
    'clock_second_cam_force',
    'clock_own_cam_spring',
    'clock_hanging_thread',
    'clock_sully_lever',
    'clock_own_cam_lever',
)
"""The built-in clocks in order. All have the same wheel, drag and escapement."""

BEYOND_SULLY = 'clock_pendulum', 'clock_balance_spring'
"""Later and earlier clocks, which take part only if they are named."""

SHARED = ('duration', 'starts_at', 'seed', 'gravity', 'air', 'ship', 'voyage', 'drift', 'log')
"""Keys of a scene that describe the passage, not the clock."""

OF_THE_CLOCK = ('white_fm', 'random_walk_fm')
"""Keys of `drift` that describe the clock."""


@dataclass(frozen=True)
class Entry:
    """A clock that takes part.

    Attributes:
        origin: file or name that the user gave.
        scene: the scene that runs.
        roll_deg: significant amplitude of its ship's roll [deg], `None` if measured.
    """

    origin: str
    scene: Scene
    roll_deg: float | None

    @property
    def hung(self) -> bool:
        """Whether the case is suspended."""
        return self.scene.suspension is not None


def make_entries(
    clocks: Sequence[str | Path | Scene] = (),
    *,
    ship_of: str | Path | Scene | None = None,
    duration: float | str | None = None,
    accuracy: float | str | None = None,
    rolls_deg: Sequence[float] = (),
    cases: Literal['both', 'with', 'without'] = 'both',
    anyway: bool = False,
    overrides: Mapping[str, object] = MappingProxyType({}),
) -> list[Entry]:
    """Return the checked entries of a comparison, in the order of roll, clock, fixed before hung.

    Without clocks they are CLOCKS. All take the keys SHARED of `ship_of`. Without it they must
    agree in them. `cases` selects clocks with or without suspension. `anyway` allows machines and
    ships larger than any known (a roll that is set may be larger). `overrides` are values by the
    paths of their keys. Keys of the passage go to `ship_of`.

    Raises:
        SceneError: a scene cannot run.
        UsageError: scenes in different seas, names or rolls given twice, or a missing suspension.
    """
    scenes = _scenes(clocks or CLOCKS, ship_of, duration, accuracy, overrides)
    for origin, scene in scenes:
        if not anyway:
            with naming(origin, scene.name):
                check_known(scene)
    refuse_same_names(scenes)
    _check_shared(scenes)
    if len(set(rolls_deg)) < len(rolls_deg):
        twice = Argument('roll_deg', ','.join(f'{roll:g}' for roll in rolls_deg))
        raise UsageError(twice, ': a roll comes twice. Leave one out')
    entries = []
    for roll in rolls_deg or (None,):
        for origin, scene in scenes:
            rolled = scene if roll is None else _as_given(origin, with_roll(scene, roll))
            for cased in _in_cases(origin, rolled, cases):
                with naming(origin, cased.name):
                    check_scene(cased)
                entries.append(Entry(origin, cased, significant_roll_deg(cased)))
    return entries


def refuse_same_names(scenes: Sequence[tuple[str, Scene]]) -> None:
    """Refuse two clocks of one name, which identifies their rows (UsageError)."""
    origins: dict[str, str] = {}
    for origin, scene in scenes:
        if scene.name in origins:
            raise UsageError(
                f'{origin}: {origins[scene.name]} has the same name, {scene.name!r}, which its '
                'row needs. Leave one out, or give another `name`'
            )
        origins[scene.name] = origin


def _scenes(
    clocks: Sequence[str | Path | Scene],
    ship_of: str | Path | Scene | None,
    duration: float | str | None,
    accuracy: float | str | None,
    overrides: Mapping[str, object],
) -> list[tuple[str, Scene]]:
    solver: dict[str, Any] = {'solver.accuracy': accuracy}
    changed = {**solver, **overrides}
    shared: dict[str, Any] = {}
    if ship_of is not None:
        own_keys = [f'drift.{name}' for name in OF_THE_CLOCK]
        of_passage = {
            key: value
            for key, value in overrides.items()
            if key.partition('.')[0] in SHARED and key not in own_keys
        }
        changed = {key: value for key, value in changed.items() if key not in of_passage}
        passage = load_scene(ship_of, **solver, **of_passage)
        shared = {key: getattr(passage, key) for key in SHARED}
    scenes = [(origin_of(clock), load_scene(clock, **changed)) for clock in clocks]
    if duration is not None:
        shared['duration'] = duration
    # one motion for all, at the highest of their sampling rates
    passages = [] if ship_of is None else [shared['ship']]
    rates = {ship.rate for ship in (*passages, *(scene.ship for _, scene in scenes))}
    if not shared and len(rates) == 1:
        return scenes
    whose = None if ship_of is None else origin_of(ship_of)
    entries = []
    for name, scene in scenes:
        ship = shared.get('ship', scene.ship).model_copy(update={'rate': max(rates)})
        entries.append((name, _taking(name, scene, {**shared, 'ship': ship}, whose)))
    return entries


def with_rate(scene: Scene, rate_hz: float) -> Scene:
    """Return a scene with another sampling rate of the ship's motion [Hz]."""
    ship = scene.ship.model_copy(update={'rate': rate_hz})
    return scene.model_copy(update={'ship': ship})


def regulated(scene: Scene, machine: AnyMachine | OtherRegulator) -> Scene:
    """Return a scene with the dial regulated at the mean temperature of its first day."""
    period_s = regulated_period_s(on_first_day(scene, machine))
    dial = scene.clock.model_copy(update={'nominal_period': period_s})
    return scene.model_copy(update={'clock': dial})


def on_passage_of(name: str, scene: Scene, passage: Scene, ship_of: str) -> Scene:
    """Return a clock with the keys SHARED of a passage, the scene that is named `ship_of`."""
    return _taking(name, scene, {key: getattr(passage, key) for key in SHARED}, ship_of)


def _taking(name: str, scene: Scene, shared: Mapping[str, Any], ship_of: str | None) -> Scene:
    update = dict(shared)
    if ship_of is not None:
        settings = {key: getattr(scene.drift, key) for key in OF_THE_CLOCK}
        update['drift'] = shared['drift'].model_copy(update=settings)
    return _as_given(name, scene.model_copy(update=update), ship_of)


def _as_given(origin: str, changed: Scene, ship_of: str | None = None) -> Scene:
    try:
        return parse_scene(scene_yaml(changed), origin)
    except SceneError as error:
        whose = '' if ship_of is None else f' and the passage of {ship_of}'
        error.add_note(f'{origin} was read with the options given{whose}')
        raise


def _in_cases(origin: str, scene: Scene, cases: str) -> Iterator[Scene]:
    if cases == 'with' and scene.suspension is None:
        raise UsageError(
            Argument('suspension', 'with'),
            f': {origin} has no suspension. Write one (`suspension: {{kind: axle, …}}`, as in '
            f'{CLOCKS[0]}), or use ',
            Argument('suspension', 'both'),
        )
    if cases != 'with':
        yield scene.model_copy(update={'suspension': None})
    if cases != 'without' and scene.suspension is not None:
        yield scene


def _check_shared(scenes: Sequence[tuple[str, Scene]]) -> None:
    (leader, scene), *followers = scenes
    passage = _passage(scene)
    for origin, peer in followers:
        differences = list(_differences('', passage, _passage(peer)))
        if differences:
            text = '; '.join(
                f'only {leader if isinstance(ours, dict) else origin} has {key}'
                if isinstance(ours, dict) or isinstance(theirs, dict)
                else f'{key} = {theirs} against {ours}'
                for key, ours, theirs in differences
            )
            raise UsageError(
                f'{origin} does not make the passage of {leader}: {text}. Let the scenes agree, '
                'or take one passage for all with ',
                Argument('ship_of', leader),
            )


def _passage(scene: Scene) -> dict[str, Any]:
    return scene.model_dump(include=set(SHARED), exclude={'drift': set(OF_THE_CLOCK)})


def _differences(path: str, ours: Any, theirs: Any) -> Iterator[tuple[str, Any, Any]]:
    if not (isinstance(ours, dict) and isinstance(theirs, dict)):
        if ours != theirs:
            yield path, ours, theirs
        return
    for key in dict.fromkeys((*ours, *theirs)):
        place = f'{path}.{key}' if path else str(key)
        yield from _differences(place, ours.get(key, 'absent'), theirs.get(key, 'absent'))


# -----------------------------------------------------------------------------
# The error of a clock along a passage.

PIECES = 96
"""Number of equal pieces of a passage at whose ends the error is kept."""


class ErrorTrace:
    """Keeps the clock's error at the ends of at most PIECES equal pieces of a scene.

    A piece is a whole number of log intervals. A shorter remainder at the end is not used.

    Attributes:
        piece_s: length of a piece [s].
        time_s: ends of the pieces since the start, with the start itself [s].
        error_s: reading minus true time then [s].
    """

    def __init__(self, scene: Scene) -> None:
        self._starts_at_ns = scene.starts_at_ns
        self._piece_ns = scene.log_interval_ns * math.ceil((scene.log_count - 1) / PIECES)
        self.piece_s = self._piece_ns / NS_PER_S
        self.time_s, self.error_s = list[float](), list[float]()

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take batches of any topics, in order within a topic."""
        reading = batches.get(READING)
        if not isinstance(reading, TimeSamples):
            return
        since_ns = reading.stamp_ns - self._starts_at_ns
        ends = since_ns % self._piece_ns == 0
        self.time_s += (since_ns[ends] / NS_PER_S).tolist()
        self.error_s += ((reading.time_ref_ns - reading.stamp_ns)[ends] / NS_PER_S).tolist()

    def rate_spread(self) -> float | None:
        """Return the standard deviation of the pieces' rates [s/day], `None` for one piece."""
        rates = np.diff(self.error_s) / self.piece_s * DAY_S
        return float(np.std(rates, ddof=1)) if len(rates) > 1 else None


@dataclass(frozen=True)
class Stop:
    """The event that stopped a clock: its time since the start [s] and the reason."""

    at_s: float
    why: str


@dataclass(frozen=True)
class Row:
    """The result for one clock. Figures at the end are `None` if an event ended its motion.

    Attributes:
        clock, scene: name of the scene, and the file or name that the user gave.
        suspended: whether its case was suspended.
        roll_deg: significant amplitude of the ship's roll [deg], `None` if measured.
        release: angle of the wheel [rad], or arc of a body in a fluid [m], at the start.
        propagator: name of the propagator of its motion.
        rate_s_per_day: mean rate.
        rate_spread_s_per_day: standard deviation over the pieces, `None` if the clock stopped.
        error_s: reading minus true time at the end.
        raw_error_nmi: error to the east of the dial as the scene sets it.
        error_nmi: the same, corrected for the rate observed in port.
        raw_prize_pounds, prize_pounds: prize of the Act of 1714 for these errors.
        stopped: the event that ended its motion, or the time when it stopped, `None` if it runs.
        time_s, trace_s: ends of the pieces, up to an event, and the clock's error then [s].
        run_s: processor time.
    """

    clock: str
    scene: str
    suspended: bool
    roll_deg: float | None
    release: float
    propagator: str
    rate_s_per_day: float | None
    rate_spread_s_per_day: float | None
    error_s: float | None
    raw_error_nmi: float | None
    error_nmi: float | None
    raw_prize_pounds: int | None
    prize_pounds: int | None
    stopped: Stop | None
    time_s: list[float]
    trace_s: list[float]
    run_s: float


@dataclass(frozen=True)
class Comparison:
    """The result of a comparison.

    Attributes:
        duration_s: length of the run [s].
        piece_s: length of the pieces of `rate_spread_s_per_day` and the traces [s].
        wall_s: wall time of the comparison [s].
        rows: in the order of the entries.
    """

    duration_s: float
    piece_s: float
    wall_s: float
    rows: list[Row]

    @property
    def answer(self) -> str:
        """Which dials have the least and the largest error at the end, in a sentence."""

        def called(row: Row) -> str:
            case = 'hung' if row.suspended else 'fixed'
            several = sum(item.clock == row.clock for item in self.rows) > 1
            return f'{row.clock} ({case})' if several else row.clock

        went = [row for row in self.rows if row.raw_error_nmi is not None and not row.stopped]
        text = f'After {span(self.duration_s)} in the same sea'
        if not went:
            return f'{text} no clock goes.'
        went.sort(key=lambda row: abs(row.raw_error_nmi or 0.0))
        best, worst = went[0], went[-1]
        if best is worst:
            text += f' the dial of {called(best)} errs by {_miles(best)}.'
        else:
            text += f' the dial of {called(best)} errs least, by {_miles(best)}, and the dial of '
            text += f'{called(worst)} most, by {_miles(worst)}.'
        stopped = len(self.rows) - len(went)
        return f'{text} {counted(stopped, "clock")} stopped.' if stopped else text

    def _repr_html_(self) -> str:
        return str(drawn_by('notebook', 'comparison_html')(self))


def _miles(row: Row) -> str:
    size = abs(row.raw_error_nmi or 0.0)
    side = 'east' if (row.raw_error_nmi or 0.0) > 0.0 else 'west'
    return f'{figure(size, "nmi")} nautical miles' + f' to the {side}' * (size >= least('nmi'))


def compare(
    entries: Sequence[Entry], *, jobs: int = 2, progress: Share | None = None
) -> Comparison:
    """Return the comparison of at least one entry, run by parallel processes.

    With one job, or little work, this process makes all runs. A failure other than an event in the
    motion of a clock ends the comparison with its TautoError. `progress` is called with the
    fraction done.
    """
    began, works_s = time.perf_counter(), []
    for entry in entries:
        with naming(entry.origin, entry.scene.name):
            works_s.append(work_s(entry.scene))
    jobs = jobs_for(works_s, jobs)
    seas = in_one_sea(entries, jobs)
    plan = Voyages(sail_sea, seas, lambda sea: ', '.join(entry.scene.name for _, entry in sea))
    report = None if progress is None else lambda count: progress(count / len(seas))
    rows = [row['row'] for row in sail(plan, jobs, None, report)]
    scene = entries[0].scene
    wall_s = time.perf_counter() - began
    return Comparison(scene.duration, ErrorTrace(scene).piece_s, wall_s, rows)


def in_one_sea(entries: Sequence[Entry], jobs: int) -> list[list[tuple[int, Entry]]]:
    """Return the entries that sail together with their places, the costly hung cases first.

    If there are fewer seas than processes, the clocks of a sea are divided.
    """
    seas: dict[str, list[tuple[int, Entry]]] = {}
    for place in sorted(range(len(entries)), key=lambda place: not entries[place].hung):
        sea = repr(_passage(entries[place].scene))
        seas.setdefault(sea, []).append((place, entries[place]))
    parts = math.ceil(jobs / len(seas))
    return [sea[k::parts] for sea in seas.values() for k in range(parts) if sea[k:]]


class Sea:
    """The sea of a voyage: the ship's motion and its integrals, which several clocks share.

    It is sampled for the scene that needs the most samples beyond its end (a hung case). `origins`
    are the files or names of the scenes, for errors.
    """

    def __init__(self, scenes: Sequence[Scene], origins: Sequence[str]) -> None:
        named = zip(scenes, origins, strict=True)
        self._scene, origin = max(named, key=lambda pair: pair[0].samples_beyond_end)
        with naming(origin, self._scene.name):
            self.motion = ShipMotion(self._scene)
        self.buffers = SharedBuffers()
        self._integrals: dict[tuple[object, ...], SharedIntegrals] = {}

    def integrals(self, scene: Scene) -> SharedIntegrals:
        """Return the shared integrals of a scene's covariates."""
        key = SharedIntegrals.key(scene)
        if key not in self._integrals:
            self._integrals[key] = SharedIntegrals(scene)
        return self._integrals[key]

    def sail(
        self,
        afloat: Sequence[ClockInSea],
        began_s: float,
        progress: Share | None,
        *,
        as_messages: bool = False,
    ) -> None:
        """Sail clocks to the end in the sea, which is sampled once.

        Each clock gets its own processor time and an equal share of the other time of this thread
        since `began_s`. Shared inputs count for the first clock that needs them.
        """
        source = voyage.ShipSource(
            self._scene, self.motion, says_scene=False, as_messages=as_messages
        )
        chunk = voyage.CHUNK if as_messages else voyage.QUIET_CHUNK
        if any(clock.scene.suspension is not None for clock in afloat):
            chunk = voyage.HUNG_CHUNK
        fields = set[str]()
        while source.produced < source.total:
            batches = source.produce(chunk)
            imu = kept(cast(Sensed, batches[SHIP_IMU]), fields)
            content = {**batches, SHIP_IMU: message(imu)} if self._integrals else batches
            for integrals in self._integrals.values():
                integrals.take(content)
            for clock in afloat:
                clock.feed({**batches, SHIP_IMU: imu})
            if progress is not None:
                progress(source.produced / source.total)
        for clock in afloat:
            clock.feed(None)
        shared_s = time.thread_time() - began_s - sum(clock.run_s for clock in afloat)
        for clock in afloat:
            clock.run_s += shared_s / len(afloat)


class ClockInSea:
    """A clock under way, together with others in one sea. `rated` clocks are regulated first.

    Attributes:
        ended: the event that ended its motion, or `None`.
        at_end: whether the last batch has been made.
        run_s: its own processor time [s].
    """

    def __init__(self, scene: Scene, origin: str, sea: Sea, *, rated: bool = False) -> None:
        self.ended: TautoError | None = None
        self.at_end = False
        began = time.thread_time()
        with naming(origin, scene.name):
            machine, _ = check_scene(scene, sea.motion)
        self.scene = regulated(scene, machine) if rated else scene
        self._stages = voyage.pipeline(self.scene, machine, sea.buffers)
        self.summary = Summary(self.scene, machine)
        self.run_s = time.thread_time() - began

    def feed(self, ship: Batches | None) -> None:
        """Take the next batches of the ship, `None` at the end. An event ends the motion."""
        if self.ended is not None:
            return
        began = time.thread_time()
        try:
            batches = self._stages.finish() if ship is None else self._stages.feed(ship)
            if words := voyage.refused_words(self._stages.health()):
                raise PropagationError(words, 0.0)
            self.summary.feed(batches)
            self.at_end = ship is None
            self.keep(batches)
        except MotionDataError:  # a missing or unreadable file
            raise
        except TautoError as error:
            self.ended = error
        self.run_s += time.thread_time() - began

    def keep(self, batches: Batches) -> None:
        """Take the clock's output."""
        raise NotImplementedError

    @cached_property
    def report(self) -> dict[str, Any]:
        """The result of the voyage, empty if an event ended it."""
        return self.summary.result() if self.ended is None else {}

    def figures(self) -> dict[str, Any]:
        """Return the figures of its row."""
        return figures_of(self.report, self.ended, self.run_s)


class _Compared(ClockInSea):
    def __init__(self, entry: Entry, sea: Sea) -> None:
        self.entry, self.trace = entry, ErrorTrace(entry.scene)
        super().__init__(entry.scene, entry.origin, sea)

    def keep(self, batches: Batches) -> None:
        """Take the error of the clock."""
        self.trace.feed(batches)

    def row(self) -> Row:
        """Return its row."""
        scene, stopped, figures = self.scene, None, self.figures()
        if isinstance(self.ended, PropagationError):
            stopped = Stop(self.ended.time_s, str(self.ended))
        elif self.ended is not None:
            raise self.ended
        elif not has_arrived(figures):
            went_s = figures['stopped_s']
            stopped = Stop(
                went_s, f'after {span(went_s)}: {self.report["trochlea"]["stopped_why"]}'
            )
        if scene.trochlea is not None:
            release = scene.trochlea.release_angle
        else:
            assert scene.regulator is not None
            release = scene.regulator.released_at
        return Row(
            clock=scene.name,
            scene=self.entry.origin,
            suspended=self.entry.hung,
            roll_deg=self.entry.roll_deg,
            release=release,
            propagator=self.summary.propagator,
            rate_spread_s_per_day=None if stopped else self.trace.rate_spread(),
            error_s=figures['clock_error_s'],
            **{name: figures[name] for name in figures.keys() & Row.__annotations__},
            stopped=stopped,
            time_s=self.trace.time_s,
            trace_s=self.trace.error_s,
        )


def sail_sea(voyage: Sequence[tuple[int, Entry]], progress: Share | None) -> list[dict[str, Any]]:
    """Sail entries in one sea, and return each row as one value with its place.

    An event that stops a clock is its result, and the others go on.
    """
    began = time.thread_time()
    entries = [entry for _, entry in voyage]
    scenes = [entry.scene for entry in entries]
    sea = Sea(scenes, [entry.origin for entry in entries])
    sailing = [_Compared(entry, sea) for entry in entries]
    shaken = any(name in SHAKEN_BY for scene in scenes for name in scene.drift.covariates or ())
    sea.sail(sailing, began, progress, as_messages=shaken)
    return [
        {'ship': place, 'row': clock.row()}
        for (place, _), clock in zip(voyage, sailing, strict=True)
    ]
