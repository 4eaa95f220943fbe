"""Runs all clocks of a comparison, several at once.

Each run computes the motion of ship and case for itself, so processes need not exchange it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import TypeAlias

from tauto_core import voyage
from tauto_core.comparison.entries import Entry
from tauto_core.comparison.trace import ErrorTrace
from tauto_core.scene import Scene
from tauto_core.scene.errors import PropagationError
from tauto_core.summary import Summary
from tauto_core.voyage_cost import step_ns
from tauto_core.wording import span
from tauto_core.workers import Crew, WorkerError, run_each

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
            for a clock that still goes.
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


def compare(
    entries: Sequence[Entry], *, jobs: int = 2, progress: Progress | None = None
) -> Comparison:
    """Return the comparison of all entries.

    Args:
        entries: result of `make_entries`, at least one.
        jobs: number of parallel processes, >= 1; 1: in this process.
        progress: called with the fraction done, from 0 to 1.

    Raises:
        UsageError: jobs below 1.
        TautoError: a clock failed otherwise than by an event in its motion, or its processes died;
            the comparison ends.
    """
    crew = Crew(min(jobs, len(entries)))
    began, order = time.perf_counter(), _dearest_first(entries)
    rows: dict[int, Row] = {}
    with closing(run_each(sail_entry, [entries[k] for k in order], crew, progress)) as ended:
        for each in ended:
            entry = entries[order[each.place]]
            if isinstance(each.error, WorkerError):
                raise WorkerError(f'{entry.scene.name}: {each.error}') from None
            if each.error is not None:
                raise each.error
            assert each.result is not None
            rows[order[each.place]] = each.result
    scene = entries[0].scene
    wall_s = time.perf_counter() - began
    in_order = [rows[k] for k in range(len(entries))]
    return Comparison(scene.duration, ErrorTrace(scene).piece_s, wall_s, in_order)


def sail_entry(entry: Entry, progress: Progress | None = None) -> Row:
    """Run one clock; an event that stops it is part of the result.

    Args:
        entry: the clock.
        progress: called with the fraction done, from 0 to 1.
    """
    scene, began = entry.scene, time.process_time()
    trace, report, stopped = ErrorTrace(scene), {}, None
    try:
        report = voyage.sail(
            scene,
            origin=entry.origin,
            anyway=True,  # checked before its roll was scaled
            progress=progress,
            watch=trace.feed,
        )
    except PropagationError as error:
        stopped = Stop(error.time_s, str(error))
    clock, longitude = report.get('clock', {}), report.get('longitude', {})
    trochlea = report.get('trochlea', {})
    went_s = trochlea.get('stopped_s')
    if went_s is not None:
        stopped = Stop(went_s, f'after {span(went_s)}: {trochlea["stopped_why"]}')
    return Row(
        clock=scene.name,
        scene=entry.origin,
        suspended=entry.hung,
        roll_deg=entry.roll_deg,
        release=_release(scene),
        propagator=report.get('propagator') or Summary(scene).propagator,
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
        run_s=time.process_time() - began,
    )


def _release(scene: Scene) -> float:
    if scene.trochlea is not None:
        return scene.trochlea.release_angle
    assert scene.regulator is not None
    return scene.regulator.release_arc


def _dearest_first(entries: Sequence[Entry]) -> list[int]:
    """Return the indices by falling cost, so that no long run is left alone at the end.

    The swing of a suspended case costs more than any kind of thread.
    """
    return sorted(
        range(len(entries)),
        key=lambda index: (entries[index].hung, step_ns(entries[index].scene)),
        reverse=True,
    )
