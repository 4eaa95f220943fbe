"""The entries of a comparison, in one sea or with several rolls, and their voyages.

Clocks in one sea sail together, in as many processes as there are: each process samples the sea,
and moves the case in which clocks hang, once.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias, cast

import numpy as np

from tauto_core import voyage
from tauto_core.checks.cost import step_ns, work_s
from tauto_core.checks.readiness import check_known, check_scene
from tauto_core.ensembles.workers import Crew, WorkerError, run_each
from tauto_core.files import write_figure
from tauto_core.machines import AnyMachine, InPlaceOfWheel, LeverMachine, Machine
from tauto_core.machines.steady_swing import SteadySwing, steady_swing
from tauto_core.navigation.longitude import ARCMIN_PER_S, AWARDS
from tauto_core.navigation.regressors import SHAKEN_BY
from tauto_core.results import Summary, drawn_by
from tauto_core.samples import (
    READING,
    SHIP_IMU,
    Batches,
    FloatArray,
    Samples,
    TimeSamples,
)
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
from tauto_core.scene.loader import checked_scene, origin_of, read_mapping
from tauto_core.scene.times import DAY_S, NS_PER_S
from tauto_core.ship import ShipMotion
from tauto_core.ship.airs import BoxTemperature
from tauto_core.ship.buffer import SharedBuffers
from tauto_core.ship.imu import Sensed, kept
from tauto_core.ship.logbook import LoggedPassage, scene_of_passage
from tauto_core.ship.waves import Harmonics
from tauto_core.wording import counted, figure, least, span

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# -----------------------------------------------------------------------------
# The amplitude of a ship's roll, and the same ship in the same waves with another roll.

LARGEST_DEG = 45.0
"""Largest roll that may be set; beyond it the linear roll equation does not hold."""


def significant_roll_deg(scene: Scene) -> float | None:
    """Return the significant amplitude of a ship's roll, 2 √(Σ a²/2) [deg].

    It is twice the root mean square, which in a narrow-banded sea is the mean of the highest third
    of the amplitudes (Longuet-Higgins 1952); for a single harmonic of amplitude a it is √2 a. None
    where the roll was measured, 0 for a ship that lies still; in weather it is that in the highest
    sea.
    """
    if not scene.ship.is_computed:
        return None
    roll = scene.ship.roughest(scene).channels(scene).roll
    if not isinstance(roll, Harmonics):
        return 0.0
    return math.degrees(2.0 * math.sqrt(0.5 * float(np.sum(roll.amplitude**2))))


def with_roll(scene: Scene, roll_deg: float) -> Scene:
    """Return the scene with a ship that rolls by another significant amplitude.

    Every harmonic of the roll is scaled by the same factor, in a sea through the slope coefficient
    or the response operator; waves and heave are not changed. A ship that does not roll, or is not
    of kind sea or components, and an amplitude beyond LARGEST_DEG are a UsageError.
    """
    if not 0.0 <= roll_deg <= LARGEST_DEG:
        raise UsageError(
            Argument('roll_deg', f'{roll_deg:g}'),
            f': must lie between 0 and {LARGEST_DEG:g} degrees, twice the root mean square of the '
            'roll. Write for example 0,10,20',
        )
    ship, now = scene.ship, significant_roll_deg(scene)
    if not now or not ship.roll_scales:
        why = 'was measured' if now is None else 'follows from her hull' if now else 'is zero'
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
"""The built-in clocks in order; all have the same wheel, drag and escapement."""

BEYOND_SULLY = 'clock_pendulum', 'clock_balance_spring'
"""Clocks of before and after in the same sea, which take part where they are named."""

SHARED = ('duration', 'starts_at', 'seed', 'gravity', 'air', 'ship', 'voyage', 'drift', 'log')
"""Keys of a scene that describe the passage, not the clock."""

OF_THE_CLOCK = ('white_fm', 'random_walk_fm')
"""Keys of `drift` that describe the clock."""

_Cases: TypeAlias = Literal['both', 'with', 'without']


@dataclass(frozen=True)
class Entry:
    """A clock that takes part.

    Attributes:
        origin: file or name that the user gave.
        scene: the scene that runs.
        roll_deg: significant amplitude of its ship's roll [deg]; None: measured.
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
    cases: _Cases = 'both',
    anyway: bool = False,
    passage: LoggedPassage | None = None,
    harbour_days: float = 14.0,
    overrides: Mapping[str, object] = MappingProxyType({}),
) -> list[Entry]:
    """Return the entries of a comparison, each checked as before a voyage.

    They are in the order of roll, then clock, with fixed cases before suspended ones. Without
    clocks they are CLOCKS. All take the keys SHARED of `ship_of`; otherwise they must agree in
    them. `cases` are 'with' and 'without' suspension, or 'both' where a scene has one. With
    `anyway` machines and ships larger than any known sail too; a set roll may be larger.
    `overrides` are values by the paths of their keys; those of a passage go to `ship_of`.

    With a `passage` of a log-book, one without problems, they sail it in the ship of `ship_of`, or
    of the first clock, after `harbour_days` in harbour, and each dial is regulated there.

    A scene that cannot run is a SceneError; scenes that do not share their sea, names or rolls
    given twice, or a suspension that a scene does not have, are a UsageError.
    """
    scenes = _scenes(clocks or CLOCKS, ship_of, duration, accuracy, overrides)
    if passage is not None:
        scenes = _along(scenes, passage, harbour_days, shortened=duration is not None)
    for origin, scene in scenes:
        if not anyway:
            with naming(origin, scene.name):
                check_known(scene)
    first: dict[str, str] = {}
    for origin, scene in scenes:
        if scene.name in first:
            raise UsageError(
                f'{origin}: its name, {scene.name!r}, is that of {first[scene.name]} too, and a '
                'row is called by it. Leave one out, or give another `name`'
            )
        first[scene.name] = origin
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
                    machine, _ = check_scene(cased)
                sailing = cased if passage is None else regulated(cased, machine)
                entries.append(Entry(origin, sailing, significant_roll_deg(cased)))
    return entries


def _scenes(
    clocks: Sequence[str | Path | Scene],
    ship_of: str | Path | Scene | None,
    duration: float | str | None,
    accuracy: float | str | None,
    overrides: Mapping[str, object],
) -> list[tuple[str, Scene]]:
    asked: dict[str, Any] = {'solver.accuracy': accuracy}
    changed = {**asked, **overrides}
    taken: dict[str, Any] = {}
    if ship_of is not None:
        of_passage = {key: value for key, value in overrides.items() if _is_shared(key)}
        changed = {key: value for key, value in changed.items() if key not in of_passage}
        passage = load_scene(ship_of, **asked, **of_passage)
        taken = {key: getattr(passage, key) for key in SHARED}
    scenes = [(origin_of(clock), load_scene(clock, **changed)) for clock in clocks]
    if duration is not None:
        taken['duration'] = duration
    # one motion for all, sampled as the most demanding of them needs
    passages = [] if ship_of is None else [taken['ship']]
    rates = {ship.rate for ship in (*passages, *(scene.ship for _, scene in scenes))}
    if not taken and len(rates) == 1:
        return scenes
    whose = None if ship_of is None else origin_of(ship_of)
    found = []
    for name, scene in scenes:
        ship = taken.get('ship', scene.ship).model_copy(update={'rate': max(rates)})
        found.append((name, _taking(name, scene, {**taken, 'ship': ship}, whose)))
    return found


def _along(
    scenes: Sequence[tuple[str, Scene]],
    passage: LoggedPassage,
    harbour_days: float,
    *,
    shortened: bool,
) -> list[tuple[str, Scene]]:
    """Return the clocks on a passage of a log-book, in the ship of the first of them."""
    origin, first = scenes[0]
    found = []
    for name, scene in scenes:
        content = read_mapping(scene_yaml(on_passage_of(name, scene, first, origin)), name)
        if scene.accuracy is not None:
            content['ship'].pop('rate', None)  # it follows from the sea
        content = scene_of_passage(content, passage, harbour_days)
        if shortened:
            content['duration'] = scene.duration
        found.append((name, checked_scene(content | {'name': scene.name}, name)))
    rate = max(scene.ship.rate for _, scene in found)
    return [
        (name, scene.model_copy(update={'ship': scene.ship.model_copy(update={'rate': rate})}))
        for name, scene in found
    ]


def regulated(scene: Scene, machine: AnyMachine | InPlaceOfWheel) -> Scene:
    """Return a scene whose dial is right at its start.

    It is regulated at the steady swing, where there is one, in the gravity of the start and at the
    mean temperature of the first day.
    """
    if scene.air is not None and not isinstance(machine, InPlaceOfWheel):
        first_day = np.arange(0, math.ceil(DAY_S * NS_PER_S / scene.log_interval_ns))
        machine = machine.at_celsius(float(BoxTemperature(scene).at(first_day).mean()))
    period_s = machine.small_period
    if isinstance(machine, Machine | LeverMachine):
        swing = steady_swing(machine)
        if isinstance(swing, SteadySwing):
            period_s = swing.period
    dial = scene.clock.model_copy(update={'nominal_period': period_s})
    return scene.model_copy(update={'clock': dial})


def _is_shared(key: str) -> bool:
    """Return whether the key at a path is one of the passage."""
    section, _, rest = key.partition('.')
    return section in SHARED and not (section == 'drift' and rest in OF_THE_CLOCK)


def on_passage_of(name: str, scene: Scene, passage: Scene, ship_of: str) -> Scene:
    """Return a clock on the passage of another scene, named `ship_of`: with its keys SHARED."""
    return _taking(name, scene, {key: getattr(passage, key) for key in SHARED}, ship_of)


def _taking(name: str, scene: Scene, taken: Mapping[str, Any], ship_of: str | None) -> Scene:
    update = dict(taken)
    if ship_of is not None:
        kept = {key: getattr(scene.drift, key) for key in OF_THE_CLOCK}
        update['drift'] = taken['drift'].model_copy(update=kept)
    return _as_given(name, scene.model_copy(update=update), ship_of)


def _as_given(origin: str, changed: Scene, ship_of: str | None = None) -> Scene:
    """Return a changed scene, checked as if it had been written that way."""
    try:
        return parse_scene(scene_yaml(changed), origin)
    except SceneError as error:
        whose = '' if ship_of is None else f' and the passage of {ship_of}'
        error.add_note(f'{origin} was read with the options given{whose}')
        raise


def _in_cases(origin: str, scene: Scene, cases: _Cases) -> Iterator[Scene]:
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
    """Refuse clocks that are not on the same ship."""
    (first, scene), *others = scenes
    passage = _passage(scene)
    for origin, other in others:
        apart = list(_differences('', passage, _passage(other)))
        if apart:
            told = '; '.join(
                f'only {first if isinstance(ours, dict) else origin} has {key}'
                if isinstance(ours, dict) or isinstance(theirs, dict)
                else f'{key} = {theirs} against {ours}'
                for key, ours, theirs in apart
            )
            raise UsageError(
                f'{origin} does not make the passage of {first}: {told}. Let the scenes agree, '
                'or take one passage for all with ',
                Argument('ship_of', first),
            )


def _passage(scene: Scene) -> dict[str, Any]:
    return scene.model_dump(include=set(SHARED), exclude={'drift': set(OF_THE_CLOCK)})


def _differences(path: str, ours: Any, theirs: Any) -> Iterator[tuple[str, Any, Any]]:
    """Yield the path of every key whose values differ, and both values."""
    if not (isinstance(ours, dict) and isinstance(theirs, dict)):
        if ours != theirs:
            yield path, ours, theirs
        return
    for key in dict.fromkeys((*ours, *theirs)):
        here = f'{path}.{key}' if path else str(key)
        yield from _differences(here, ours.get(key, 'absent'), theirs.get(key, 'absent'))


# -----------------------------------------------------------------------------
# The error of a clock along a passage, at as many instants as a figure needs.

PIECES = 96
"""Number of equal pieces of a passage at whose ends the error is kept."""


class ErrorTrace:
    """Keeps the clock's error at the ends of at most PIECES equal pieces of a scene.

    A piece is a whole number of log intervals; a shorter remainder at the end is not used.
    """

    def __init__(self, scene: Scene) -> None:
        self._starts_at_ns = scene.starts_at_ns
        self._piece_ns = scene.log_interval_ns * math.ceil((scene.log_count - 1) / PIECES)
        self._stamps: list[int] = []
        self._errors: list[int] = []

    @property
    def piece_s(self) -> float:
        """Length of a piece [s]."""
        return self._piece_ns / NS_PER_S

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take batches of any topics, in order within a topic."""
        reading = batches.get(READING)
        if not isinstance(reading, TimeSamples):
            return
        kept = (reading.stamp_ns - self._starts_at_ns) % self._piece_ns == 0
        stamps = reading.stamp_ns[kept]
        self._stamps += (stamps - self._starts_at_ns).tolist()
        self._errors += (reading.time_ref_ns[kept] - stamps).tolist()

    @property
    def time_s(self) -> FloatArray:
        """Time from the start at the ends of the pieces, the start itself first [s], (n,)."""
        return np.array(self._stamps, np.int64) / NS_PER_S

    @property
    def error_s(self) -> FloatArray:
        """Reading less true time then [s], (n,)."""
        return np.array(self._errors, np.int64) / NS_PER_S

    def rate_spread(self) -> float | None:
        """Return the standard deviation of the rates of the pieces [s/day]; None for one piece."""
        rates = np.diff(self.error_s) / self.piece_s * DAY_S
        return float(np.std(rates, ddof=1)) if len(rates) > 1 else None


Progress: TypeAlias = Callable[[float], None]


@dataclass(frozen=True)
class Stop:
    """The event that stopped a clock: its time [s] from the start, and the reason."""

    at_s: float
    why: str


@dataclass(frozen=True)
class Row:
    """The result for one clock. Figures at the end are None where an event ended its motion.

    Attributes:
        clock: name of the scene.
        scene: file or name that the user gave.
        suspended: whether its case was suspended.
        roll_deg: significant amplitude of the ship's roll [deg]; None: measured.
        release: angle of the wheel [rad], or arc of a body in a fluid [m], at the start.
        propagator: name of the propagator that computed its motion.
        rate_s_per_day: mean rate over the run.
        rate_spread_s_per_day: standard deviation of the rates over pieces of the run (`piece_s`
            of the comparison), up to the event for a clock that stopped.
        error_s: reading less true time at the end.
        raw_error_nmi: error to the east by the reading alone, the dial as the scene sets it.
        error_nmi: error to the east by the reading corrected for the rate observed in port.
        raw_prize_pounds: prize of the Act of 1714 for the raw error.
        prize_pounds: prize of the Act of 1714 for the corrected error.
        stopped: the event that ended its motion, or the time from which it no longer went; None
            for a clock that still runs.
        time_s: ends of the pieces, from the start, up to an event.
        trace_s: the clock's error then [s].
        run_s: processor time of the run.
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
        piece_s: length of the pieces for `rate_spread_s_per_day` and the traces [s].
        wall_s: wall time of the comparison [s].
        rows: in the order of the entries.
    """

    duration_s: float
    piece_s: float
    wall_s: float
    rows: list[Row]

    @property
    def answer(self) -> str:
        """Which clock's dial errs least and which most at the end, in a sentence."""

        def called(row: Row) -> str:
            case = 'hung' if row.suspended else 'fixed'
            several = sum(each.clock == row.clock for each in self.rows) > 1
            return f'{row.clock} ({case})' if several else row.clock

        went = [row for row in self.rows if row.raw_error_nmi is not None and not row.stopped]
        said = f'After {span(self.duration_s)} in the same sea'
        if not went:
            return f'{said} no clock goes.'
        went.sort(key=lambda row: abs(row.raw_error_nmi or 0.0))
        best, worst = went[0], went[-1]
        if best is worst:
            said += f' the dial of {called(best)} errs by {_miles(best)}.'
        else:
            said += f' the dial of {called(best)} errs least, by {_miles(best)}; that of '
            said += f'{called(worst)} most, by {_miles(worst)}.'
        stopped = len(self.rows) - len(went)
        return f'{said} {counted(stopped, "clock")} stopped.' if stopped else said

    def _repr_html_(self) -> str:
        return str(drawn_by('notebook', 'comparison_html')(self))


def _miles(row: Row) -> str:
    size = abs(row.raw_error_nmi or 0.0)
    side = 'east' if (row.raw_error_nmi or 0.0) > 0.0 else 'west'
    return f'{figure(size, "nmi")} nautical miles' + f' to the {side}' * (size >= least('nmi'))


def compare(
    entries: Sequence[Entry], *, jobs: int = 2, progress: Progress | None = None
) -> Comparison:
    """Return the comparison of all entries, at least one, by parallel processes.

    With one job, and where the work is small, this process makes all runs. A clock that failed
    otherwise than by an event in its motion ends the comparison with its TautoError. `progress` is
    called with the fraction done, from 0 to 1.
    """
    began = time.perf_counter()
    works_s = []
    for entry in entries:
        with naming(entry.origin, entry.scene.name):
            works_s.append(work_s(entry.scene))
    crew = Crew(jobs).for_work(works_s)
    fleets = _in_one_sea(entries, crew.jobs)
    together = [[entries[place] for place in places] for places in fleets]
    rows: dict[int, Row] = {}
    with closing(run_each(sail_together, together, crew, progress)) as ended:
        for each in ended:
            places = fleets[each.place]
            if isinstance(each.error, WorkerError):
                names = ', '.join(entries[place].scene.name for place in places)
                raise WorkerError(f'{names}: {each.error}') from None
            if each.error is not None:
                raise each.error
            assert each.result is not None
            rows |= dict(zip(places, each.result, strict=True))
    scene = entries[0].scene
    wall_s = time.perf_counter() - began
    in_order = [rows[k] for k in range(len(entries))]
    return Comparison(scene.duration, ErrorTrace(scene).piece_s, wall_s, in_order)


class Afloat:
    """A clock under way, beside others in one sea.

    Args:
        scene: its scene.
        motion: of the ship, which all share.
        buffers: what they feel alike.
        rated: whether the dial is regulated for its start (`regulated`).

    Attributes:
        events: errors that end its motion alone; others end the voyage of all.
        ended: the event that ended it; None: it goes.
        at_end: whether the clock says no more.
        run_s: its own processor time [s].
    """

    events: ClassVar[type[TautoError]] = TautoError

    def __init__(
        self, scene: Scene, motion: ShipMotion, buffers: SharedBuffers, *, rated: bool = False
    ) -> None:
        self.ended: TautoError | None = None
        self.at_end = False
        began = time.thread_time()
        machine, _ = check_scene(scene, motion)
        self.scene = regulated(scene, machine) if rated else scene
        self._stages = voyage.pipeline(self.scene, machine, buffers)
        self.summary = Summary(self.scene, machine)
        self.run_s = time.thread_time() - began

    def feed(self, ship: Batches | None) -> None:
        """Take the next batches of the ship; None at the end. An event ends its motion."""
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
        except MotionDataError:  # a file that is not on this machine, or cannot be read
            raise
        except self.events as error:
            self.ended = error
        self.run_s += time.thread_time() - began

    def keep(self, batches: Batches) -> None:
        """Take what the clock said."""
        raise NotImplementedError


def sail_in_one_sea(
    afloat: Sequence[Afloat],
    source: voyage.ShipSource,
    chunk: int,
    pass_on: Callable[[Batches], Batches],
    progress: Progress | None,
) -> None:
    """Sail clocks to the end; the sea is sampled once, and `pass_on` makes it readable for all."""
    if any(each.scene.suspension is not None for each in afloat):
        chunk = voyage.HUNG_CHUNK
    while source.produced < source.total:
        batches = pass_on(source.produce(chunk))
        for each in afloat:
            each.feed(batches)
        if progress is not None:
            progress(source.produced / source.total)
    for each in afloat:
        each.feed(None)


class _Sailing(Afloat):
    """A clock of a comparison under way, with the trace of its error."""

    events = PropagationError

    def __init__(self, entry: Entry, motion: ShipMotion, buffers: SharedBuffers) -> None:
        self.entry, self.trace = entry, ErrorTrace(entry.scene)
        with naming(entry.origin, entry.scene.name):
            super().__init__(entry.scene, motion, buffers)

    def keep(self, batches: Batches) -> None:
        """Take the error of the clock."""
        self.trace.feed(batches)

    def row(self, shared_s: float) -> Row:
        """Return the figures; `shared_s` is its share of the time of all clocks together."""
        entry, scene, trace = self.entry, self.scene, self.trace
        stopped, report = None, dict[str, Any]()
        if self.ended is None:
            report = self.summary.result()
        else:
            assert isinstance(self.ended, PropagationError)
            stopped = Stop(self.ended.time_s, str(self.ended))
        clock, longitude = report.get('clock', {}), report.get('longitude', {})
        trochlea = report.get('trochlea', {})
        went_s = trochlea.get('stopped_s')
        if went_s is not None:
            stopped = Stop(went_s, f'after {span(went_s)}: {trochlea["stopped_why"]}')
        if scene.trochlea is not None:
            release = scene.trochlea.release_angle
        else:
            assert scene.regulator is not None
            release = scene.regulator.released_at
        return Row(
            clock=scene.name,
            scene=entry.origin,
            suspended=entry.hung,
            roll_deg=entry.roll_deg,
            release=release,
            propagator=self.summary.propagator,
            rate_s_per_day=clock.get('rate_s_per_day'),
            rate_spread_s_per_day=trace.rate_spread(),
            error_s=clock.get('error_s'),
            raw_error_nmi=longitude.get('raw_error_nmi'),
            error_nmi=longitude.get('error_nmi'),
            raw_prize_pounds=longitude.get('raw_prize_pounds'),
            prize_pounds=longitude.get('prize_pounds'),
            stopped=stopped,
            time_s=trace.time_s.tolist(),
            trace_s=trace.error_s.tolist(),
            run_s=self.run_s + shared_s,
        )


def sail_together(entries: Sequence[Entry], progress: Progress | None = None) -> list[Row]:
    """Run clocks in one sea, which is sampled once; an event that stops one is a result of hers.

    The others go on. `run_s` of a row is her own processor time, and an equal part of that of the
    sea; what several clocks feel alike counts for the first of them.
    """
    began = time.thread_time()
    scenes = [entry.scene for entry in entries]
    # a hung case needs samples farther beyond the end
    widest = max(scenes, key=lambda scene: scene.samples_beyond_end)
    motion, buffers = ShipMotion(widest), SharedBuffers()
    shaken = any(name in SHAKEN_BY for each in scenes for name in each.drift.covariates or ())
    source = voyage.ShipSource(widest, motion, says_scene=False, as_messages=shaken)
    chunk = voyage.CHUNK if shaken else voyage.QUIET_CHUNK
    sailing = [_Sailing(entry, motion, buffers) for entry in entries]

    def pass_on(batches: Batches) -> Batches:
        return {**batches, SHIP_IMU: kept(cast(Sensed, batches[SHIP_IMU]))}

    sail_in_one_sea(sailing, source, chunk, pass_on, progress)
    shared_s = time.thread_time() - began - sum(each.run_s for each in sailing)
    return [each.row(shared_s / len(sailing)) for each in sailing]


def _in_one_sea(entries: Sequence[Entry], jobs: int) -> list[list[int]]:
    """Return the places of the entries that sail together, the costliest first.

    Where there are fewer seas than processes, the clocks of a sea are dealt out, dearest first.
    """
    seas: dict[str, list[int]] = {}
    for place in _dearest_first(entries):
        seas.setdefault(repr(_passage(entries[place].scene)), []).append(place)
    parts = math.ceil(jobs / len(seas))
    dealt = [places[k::parts] for places in seas.values() for k in range(parts)]
    return [places for places in dealt if places]


def _dearest_first(entries: Sequence[Entry]) -> list[int]:
    """Return the indices by falling cost, so that they can be dealt out evenly.

    The swing of a suspended case costs more than any kind of thread.
    """
    return sorted(
        range(len(entries)),
        key=lambda index: (entries[index].hung, step_ns(entries[index].scene)),
        reverse=True,
    )


# -----------------------------------------------------------------------------
# The comparison as a figure: error against time, or rate against roll, a panel per clock.

NEEDED_S = AWARDS[0][0] / ARCMIN_PER_S
"""Time in which the earth turns by half a degree: 30 nautical miles at the equator."""

_BAND = '#f4e9cd'
_STYLES: dict[bool, dict[str, Any]] = {
    False: {'color': '#003f88', 'linewidth': 1.3, 'label': 'fixed to the ship'},
    True: {
        'color': '#c1121f',
        'linewidth': 1.3,
        'linestyle': (0, (3, 2)),
        'label': 'hung on an axle',
    },
}


def draw_comparison(result: Comparison, path: Path) -> None:
    """Draw a comparison to an SVG, PNG or PDF file (`files.check_plot`); replaces the file.

    Errors against time where all clocks sail in one sea, with the error that the Act of 1714
    allows where it judges the voyage; where the roll differs, rates against the roll.
    """
    write_figure(lambda: side_by_side(result), path)


def side_by_side(result: Comparison) -> Figure:
    """Return the figure: small panels with common axes."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    clocks = list(dict.fromkeys(row.clock for row in result.rows))
    judged = any(row.prize_pounds is not None for row in result.rows)
    by_roll = len({row.roll_deg for row in result.rows}) > 1
    columns = min(4, len(clocks))
    lines = math.ceil(len(clocks) / columns)
    figure = Figure(figsize=(2.6 * columns + 0.6, 2.2 * lines + 0.9), layout='constrained')
    grid = figure.subplots(lines, columns, squeeze=False, sharex=True, sharey=not by_roll)
    for axes, clock in zip(grid.ravel(), clocks, strict=False):
        rows = [row for row in result.rows if row.clock == clock]
        (_rates if by_roll else _errors)(axes, rows)
        if judged and not by_roll:
            axes.axhspan(-NEEDED_S, NEEDED_S, color=_BAND, zorder=0, linewidth=0.0)
        axes.set_title(clock.removeprefix('clock_').replace('_', ' '), fontsize=9.0, loc='left')
        axes.axhline(0.0, color='#888888', linewidth=0.6, zorder=1)
        axes.grid(color='#e4e4e4', linewidth=0.5)
        axes.set_axisbelow(True)
        for side in ('top', 'right'):
            axes.spines[side].set_visible(False)
    for axes in grid.ravel()[len(clocks) :]:
        axes.set_axis_off()
    rate = f'mean rate over {span(result.duration_s)} [s/day]'
    figure.supylabel(rate if by_roll else 'error of the clock [s]', fontsize=9.0)
    figure.supxlabel('significant roll [degrees]' if by_roll else 'days', fontsize=9.0)
    shown = sorted({row.suspended for row in result.rows})
    handles: list[Line2D | Patch] = [Line2D([], [], **_STYLES[hung]) for hung in shown]
    if judged and not by_roll:
        handles.append(Patch(color=_BAND, label='within 30 miles at the equator'))
    figure.legend(handles=handles, loc='outside upper right', frameon=False, ncols=3)
    return figure


def _errors(axes: Axes, rows: Sequence[Row]) -> None:
    for row in rows:
        style = _STYLES[row.suspended]
        axes.plot([time / DAY_S for time in row.time_s], row.trace_s, **style)
        if row.stopped is not None:
            last = row.trace_s[-1] if row.trace_s else 0.0
            axes.plot(row.stopped.at_s / DAY_S, last, 'x', color=style['color'])


def _rates(axes: Axes, rows: Sequence[Row]) -> None:
    """Draw rates on the panel's own scale; those of a force are a millionth of a weight's."""
    for hung, style in _STYLES.items():
        shown = sorted(
            (row.roll_deg, row.rate_s_per_day)
            for row in rows
            if row.suspended == hung
            and row.rate_s_per_day is not None
            and row.roll_deg is not None
        )
        if shown:
            axes.plot(*zip(*shown, strict=True), **style, marker='o', markersize=3.0)
