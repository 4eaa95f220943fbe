"""A plan of voyages, sailed by several processes, gives one table of rows.

    rows = sail(plan, jobs, out, progress)

A plan (`Voyages`) is clocks × seas × draws. Its voyages are independent. The clocks of a voyage
share one sea. Any process (`workers`) can sail a voyage and make its rows.

| command | a voyage                         | its task              | its rows           |
|---------|----------------------------------|-----------------------|--------------------|
| compare | clocks of one sea in one process | `comparison.sail_sea` | one for each clock |
| fleet   | a ship with its drawn values     | `fleets.sail_ship`    | one                |
| trial   | a passage of a log-book          | `trials.sail_passage` | one for each clock |
| budget  | stretches with a cause left out  | `budget.sail_job`     | one                |

An event that ends the motion of a clock is a result: the row has the reason. A voyage is lost if
memory runs out or its process dies, and has no rows. With `out` the other voyages go on and the
same command sails the lost ones. Without it the first lost voyage ends the plan. A scene that
cannot sail always ends it.
"""

from __future__ import annotations

import json
import math
import shutil
import warnings
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field
from operator import itemgetter
from pathlib import Path
from typing import Any, Generic, TypeAlias, TypeVar

import numpy as np

from tauto_core.ensembles.workers import Task, WorkerError, jobs_for, run_each
from tauto_core.files import DRAFTS, one_writer, write_whole
from tauto_core.navigation.longitude import AWARDS
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import (
    Argument,
    SceneError,
    TautoError,
    TautoWarning,
    UsageError,
    install,
)
from tauto_core.scene.loader import read_mapping, write_mapping
from tauto_core.wording import counted, percent

Row: TypeAlias = dict[str, Any]
Columns: TypeAlias = Mapping[str, type]
"""Names of columns with the type of their values, `list` for a list of numbers."""

# -----------------------------------------------------------------------------
# The rows of a fleet on disk, in a Parquet file. An interrupted fleet can go on.
#
# `fleet.yaml` identifies the fleet, `ships.parquet` has its rows. Under way each voyage adds a
# file of JSON to `ships/`. At the end they are joined with the earlier rows. Only one process
# writes to the folder.

_SAYS, _TABLE, _PARTS, _LOCK = 'fleet.yaml', 'ships.parquet', 'ships', '.lock'


class FleetError(TautoError):
    """The rows of a fleet cannot be read or written."""


@contextmanager
def stored(
    folder: Path, identity: Mapping[str, Any], columns: Columns
) -> Generator[tuple[list[Row], Callable[[list[Row]], None]]]:
    """Lock a folder, and yield its rows and a function that adds the rows of a voyage.

    Without an error all rows are joined in one Parquet file, sorted by ship.

    Args:
        folder: made if it does not exist.
        identity: everything that determines the rows, except their number.
        columns: columns of the rows.

    Raises:
        UsageError: the folder has other contents or another fleet, or another process writes to
            it, or pyarrow is not installed.
        FleetError: it cannot be read or written.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise UsageError(
            Argument('out'),
            f': needs pyarrow, which is not installed. Run {install("fleet")}, or leave out ',
            Argument('out'),
        ) from None
    _check_folder(folder, identity)
    with ExitStack() as stack:
        with _saying(folder):
            folder.mkdir(parents=True, exist_ok=True)
            try:
                stack.enter_context(one_writer(folder / _LOCK))
            except BlockingIOError:
                raise UsageError(
                    Argument('out', folder),
                    ': another process sails a fleet into it. Wait until it ends, or name '
                    'another folder',
                ) from None
        _check_folder(folder, identity)  # another fleet may have started here
        rows = read_rows(folder)
        with _saying(folder):
            write_whole(folder / _SAYS, write_mapping(dict(identity)).encode())
            (folder / _PARTS).mkdir(exist_ok=True)
            for draft in folder.rglob(DRAFTS):  # of a killed process
                draft.unlink()

        def add(new: list[Row]) -> None:
            part = folder / _PARTS / f'{new[0]["ship"]:07d}.json'
            with _saying(folder):
                write_whole(part, json.dumps(new, allow_nan=False).encode())
            rows.extend(new)

        yield rows, add
        rows.sort(key=itemgetter('ship'))
        number = pa.float64()
        kinds = {int: pa.int64(), float: number, str: pa.string(), bool: pa.bool_()}
        kinds[list] = pa.list_(number)
        schema = pa.schema([(name, kinds[kind]) for name, kind in columns.items()])
        buffer = pa.BufferOutputStream()
        pq.write_table(pa.Table.from_pylist(rows, schema), buffer)
        with _saying(folder):
            write_whole(folder / _TABLE, buffer.getvalue())
            shutil.rmtree(folder / _PARTS)


def read_rows(folder: Path) -> list[Row]:
    """Return the rows in the folder of a fleet, sorted by ship. FleetError if they are damaged."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    by_ship: dict[int, Row] = {}  # a process that was killed at its end leaves all files
    for file in (*folder.glob(_TABLE), *folder.glob(f'{_PARTS}/*.json')):
        try:
            is_table = file.suffix == '.parquet'
            rows = pq.read_table(file).to_pylist() if is_table else json.loads(file.read_bytes())
        except (OSError, ValueError, pa.ArrowException) as error:
            raise FleetError(
                f'{file}: cannot be read ({error}). Remove it to sail its ships again'
            ) from None
        by_ship |= {row['ship']: row for row in rows}
    return [by_ship[ship] for ship in sorted(by_ship)]


def _check_folder(folder: Path, identity: Mapping[str, Any]) -> None:
    says = folder / _SAYS
    if not folder.exists():
        return
    if not folder.is_dir():
        raise UsageError(Argument('out', folder), ': is a file. Name a folder')
    if not says.exists():
        # a fleet that was killed at its start leaves only these
        if any(not file.match(DRAFTS) for file in folder.iterdir() if file.name != _LOCK):
            why = ': holds something else. Name a new folder'
            raise UsageError(Argument('out', folder), why)
        return
    with _saying(folder):
        stored_identity = read_mapping(says.read_text('utf-8'), str(says))
    ours = read_mapping(write_mapping(dict(identity)), 'ours')
    names = [key for key in ours if stored_identity.get(key) != ours[key]]
    if names:
        raise UsageError(
            Argument('out', folder),
            f': holds another fleet; {", ".join(names)} differ. Name a new folder, or give '
            'the same scene and draws, in the same versions, to go on',
        )


@contextmanager
def _saying(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise FleetError(
            Argument('out', folder),
            f': {error.strerror or error}. Make room, or name another folder; the ships that came '
            'in before are kept, and the same command goes on',
        ) from None


# -----------------------------------------------------------------------------
# The figures of a row.

FIGURES: dict[str, tuple[str, str]] = {
    'clock_error_s': ('clock', 'error_s'),
    'rate_s_per_day': ('clock', 'rate_s_per_day'),
    'estimated_rate_s_per_day': ('drift', 'rate_s_per_day'),
    'estimated_rate_sigma_s_per_day': ('drift', 'rate_sigma_s_per_day'),
    'raw_error_nmi': ('longitude', 'raw_error_nmi'),
    'error_nmi': ('longitude', 'error_nmi'),
    'sigma_nmi': ('longitude', 'sigma_nmi'),
    'judged_at_s': ('longitude', 'at_s'),
    'unchecked_days': ('longitude', 'unchecked_days'),
    'raw_prize_pounds': ('longitude', 'raw_prize_pounds'),
    'prize_pounds': ('longitude', 'prize_pounds'),
    'worst_raw_error_nmi': ('longitude', 'worst_raw_error_nmi'),
    'worst_raw_at_s': ('longitude', 'worst_raw_at_s'),
    'worst_error_nmi': ('longitude', 'worst_error_nmi'),
    'worst_at_s': ('longitude', 'worst_at_s'),
    'stopped_s': ('trochlea', 'stopped_s'),
}
"""Columns of a row and their section and key in the result of `voyage.sail`.

They belong to the judged sample, the last before the landfall or the end (`LongitudeTally`).
Errors are positive to the east.
"""

FIGURE_TYPES = dict.fromkeys(FIGURES, float) | {'raw_prize_pounds': int, 'prize_pounds': int}

ENDED: Columns = {'failure': str, 'run_s': float}
"""Last columns of a row: why the voyage ended early, or `None`, and its processor time [s].

Only `run_s` differs when a run is repeated.
"""


def figures_of(report: Mapping[str, Any], ended: BaseException | None, run_s: float) -> Row:
    """Return FIGURES and ENDED from the result of a voyage. Missing figures are `None`."""
    return {
        **{name: report.get(section, {}).get(key) for name, (section, key) in FIGURES.items()},
        'failure': None if ended is None else str(ended) or type(ended).__name__,
        'run_s': run_s,
    }


def has_arrived(row: Mapping[str, Any]) -> bool:
    """Return whether the clock ran to the end: no event ended the voyage and it did not stop."""
    return row['failure'] is None and row['stopped_s'] is None


# -----------------------------------------------------------------------------
# How often the longitude was found.

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)

ERRORS = {'raw': 'raw_error_nmi', 'corrected': 'error_nmi'}
"""Two ways of finding the longitude and their columns: the dial alone, and the dial corrected for
the estimated drift.
"""


class Proportion:
    """A share with the ends of its interval."""

    share: float
    low: float
    high: float

    @property
    def said(self) -> str:
        """The share with its interval, as text."""
        return f'{percent(self.share)} ({100.0 * self.low:.3g}–{percent(self.high)})'


@dataclass(frozen=True)
class Portion(Proportion):
    """Share of all ships with a longitude within a limit.

    A ship that failed, or lost its clock, counts as outside.

    Attributes:
        limit_nmi: limit of the Act of 1714.
        ships: number of ships within it.
        share: their share of all.
        low, high: Wilson's interval of the share, at 95 %.
    """

    limit_nmi: float
    ships: int
    share: float
    low: float
    high: float


def failures_of(rows: Iterable[Mapping[str, Any]]) -> Counter[str]:
    """Return the reasons why voyages ended early, with their numbers."""
    return Counter(row['failure'] for row in rows if row['failure'] is not None)


def sizes_nmi(rows: Iterable[Mapping[str, Any]], column: str) -> FloatArray:
    """Return the sizes of errors [nmi], infinite if a clock did not arrive or has no error."""
    sizes = (
        abs(row[column]) if has_arrived(row) and row[column] is not None else math.inf
        for row in rows
    )
    return np.fromiter(sizes, np.float64)


def quantiles_of(sizes: FloatArray) -> list[float] | None:
    """Return the quantiles at QUANTILES of the finite sizes, `None` if there are none."""
    finite = sizes[np.isfinite(sizes)]
    return np.quantile(finite, QUANTILES).tolist() if len(finite) else None


def shares_within(sizes: FloatArray) -> list[Portion]:
    """Return the shares of all ships within each limit of the Act, from `sizes_nmi`."""
    from scipy.stats import binomtest

    shares, total = [], len(sizes)
    for limit, _ in AWARDS:
        count = int(np.count_nonzero(sizes <= limit))
        interval = binomtest(count, total).proportion_ci(0.95, method='wilson')
        ends = float(interval.low), float(interval.high)
        shares.append(Portion(limit, count, count / total, *ends))
    return shares


# -----------------------------------------------------------------------------
# A plan that is sailed.

Voyage = TypeVar('Voyage')


@dataclass(frozen=True)
class Voyages(Generic[Voyage]):
    """A plan of voyages: clocks × seas × draws.

    Attributes:
        task: makes the rows of a voyage. It is pickled together with the voyage.
        voyages: in the order in which they begin.
        called: returns the name of a voyage for error messages.
        cost_s: returns the processor time of a voyage [s]; infinite: always use other processes.
        clocks: number of rows of a voyage.
        number: returns the number of a voyage, which must not depend on how many there are. The
            values `ship` of its rows count from that number times `clocks`.
        columns: columns of the rows. Empty: they cannot be stored.
        identity: everything that determines the rows, except their number.
    """

    task: Task[Voyage, list[Row]]
    voyages: Sequence[Voyage]
    called: Callable[[Voyage], str]
    cost_s: Callable[[Voyage], float] = lambda _: math.inf
    clocks: int = 1
    number: Callable[[Voyage], int] = lambda _: 0
    columns: Columns = field(default_factory=dict)
    identity: Mapping[str, Any] = field(default_factory=dict)


def sail(
    plan: Voyages[Any],
    jobs: int,
    out: Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Row]:
    """Sail a plan, or the rest of it, and return its rows sorted by `ship`.

    Args:
        jobs: processes at once.
        out: folder in which rows are stored as voyages end. `None`: they are not stored.
        progress: called with the number of finished rows, fractions of voyages included.

    Raises:
        UsageError: the folder has other contents, or another process writes to it.
        FleetError: the folder cannot be read or written.
        SceneError: a scene cannot sail.
        WorkerError: no process can be started, or voyages were lost with their process.
    """
    with ExitStack() as stack:
        rows = list[Row]()
        keep: Callable[[list[Row]], None] = rows.extend
        if out is not None:
            rows, keep = stack.enter_context(stored(out, plan.identity, plan.columns))
        numbers = {row['ship'] // plan.clocks for row in rows}
        pending = [item for item in plan.voyages if not rows or plan.number(item) not in numbers]
        total, lost = plan.clocks * len(plan.voyages), list[str]()
        came_in = total - plan.clocks * len(pending)

        def tell(share: float) -> None:
            if progress is not None:
                progress(total - plan.clocks * len(pending) * (1.0 - share))

        # all voyages, not only the pending ones: a continued run uses as many processes
        works_s = [plan.cost_s(item) for item in pending[:1]] * len(plan.voyages)
        jobs = jobs_for(works_s, jobs) if pending else 1
        try:
            with closing(run_each(plan.task, pending, jobs, tell)) as ended:
                for run in ended:
                    if run.result is not None:
                        came_in += plan.clocks
                        keep(run.result)
                        continue
                    error, is_lost = run.error, isinstance(run.error, WorkerError)
                    if isinstance(error, SceneError) or (out is None and not is_lost):
                        assert error is not None
                        raise error
                    why = str(error) or type(error).__name__
                    lost.append(f'{plan.called(pending[run.place])}: {why}')
                    if out is None:
                        break
                    warnings.warn(f'{lost[-1]}. It is lost', TautoWarning, stacklevel=2)
            if lost:
                suffix = f' ({len(lost) - 1} more)' if len(lost) > 1 else ''
                count = counted(len(lost), 'ship')
                raise WorkerError(f'{count} did not end the voyage: ', lost[0], suffix)
        except WorkerError as error:
            if not came_in or not plan.columns:
                raise
            tally = f'. {came_in:,} of {counted(total, "ship")} came in: '
            advice = (
                ('with ', Argument('out'), ' they would be kept, and the same command would sail ')
                if out is None
                else ('they are kept, and the same command sails ',)
            )
            raise WorkerError(error.message, tally, *advice, 'the others') from None
    numbers = set(map(plan.number, plan.voyages))
    asked = [row for row in rows if out is None or row['ship'] // plan.clocks in numbers]
    return sorted(asked, key=itemgetter('ship'))
