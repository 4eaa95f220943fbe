"""A plan of voyages, sailed by several processes, gives one table of rows.

    rows = sail(plan, jobs, out, progress)

A plan (`Voyages`) is clocks × seas × draws. Its voyages are independent. The clocks of a voyage
share one sea. Any process (`workers`) can sail a voyage and make its rows.

| command | a voyage                           | its task              | its rows           |
|---------|------------------------------------|-----------------------|--------------------|
| compare | clocks of one sea in one process   | `comparison.sail_sea` | one for each clock |
| fleet   | a ship with its drawn values       | `fleets.sail_ship`    | one                |
| trial   | a passage as logged, or drawn anew | `trials.sail_passage` | one for each clock |
| budget  | stretches with a cause left out    | `budget.sail_job`     | one                |

An event that ends the motion of a clock is a result: the row has the reason. A voyage is lost if
memory runs out or its process dies, and has no rows. With `out` the other voyages go on and the
same command sails the lost ones. Without it the first lost voyage ends the plan. A scene that
cannot sail always ends it.
"""

from __future__ import annotations

import math
import shutil
import time
import warnings
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar, overload

import numpy as np

from tauto_core.ensembles.workers import Task, WorkerError, jobs_for, run_each
from tauto_core.files import DRAFTS, one_writer, write_whole
from tauto_core.scene.errors import (
    Argument,
    SceneError,
    TautoError,
    TautoWarning,
    UsageError,
    install,
)
from tauto_core.scene.loader import read_mapping, write_mapping
from tauto_core.wording import counted

if TYPE_CHECKING:
    import pyarrow as pa


Columns: TypeAlias = Mapping[str, type]
"""Names of columns with the type of their values, `list` for a list of numbers."""


class Rows(Sequence[dict[str, Any]]):
    """Rows with the same names, kept by columns.

    A number takes 8 bytes: a million ships take 250 MB, their mappings would take 2 GB. Numbers
    are finite or `None`. Indexing makes a new mapping.
    """

    def __init__(self, rows: Iterable[Mapping[str, Any]] = ()) -> None:
        self._columns: dict[str, array[float] | list[Any]] = {}
        self._count = 0
        self.extend(rows)

    def extend(self, rows: Iterable[Mapping[str, Any]]) -> None:
        """Add rows. A row with other names than the earlier rows is a ValueError."""
        for row in rows:
            if not self._count:
                self._columns = {name: array('d') for name in row}
            elif row.keys() != self._columns.keys():
                raise ValueError(f'a row of {list(row)}, after rows of {list(self._columns)}')
            for name, value in row.items():
                column = self._columns[name]
                if isinstance(column, array):
                    if value is None or isinstance(value, float):
                        column.append(math.nan if value is None else value)
                        continue
                    column = self._columns[name] = [_told(number) for number in column]
                column.append(value)
            self._count += 1

    def column(self, name: str) -> list[Any]:
        """Return the values of a column, an empty list if there are no rows."""
        return [_told(value) for value in self._columns.get(name, ())]

    def sort(self) -> None:
        """Sort the rows by ship."""
        if not self._count:
            return
        order = np.argsort(np.array(self._columns['ship'], np.int64), kind='stable').tolist()
        for name, column in self._columns.items():
            values = [column[place] for place in order]
            self._columns[name] = array('d', values) if isinstance(column, array) else values

    def table(self, columns: Columns) -> pa.Table:
        """Return these columns as an Arrow table."""
        import pyarrow as pa

        integer, number = pa.int64(), pa.float64()
        kinds = {int: integer, float: number, str: pa.string(), bool: pa.bool_()}
        kinds[list] = pa.list_(number)
        arrays = {}
        for name, kind in columns.items():
            column = self._columns.get(name, [])
            is_array = isinstance(column, array)
            values = np.array(column) if is_array else column
            arrays[name] = pa.array(values, kinds[kind], from_pandas=is_array)
        return pa.table(arrays)

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, place: int) -> dict[str, Any]: ...
    @overload
    def __getitem__(self, place: slice) -> list[dict[str, Any]]: ...
    def __getitem__(self, place: int | slice) -> dict[str, Any] | list[dict[str, Any]]:
        if isinstance(place, slice):
            return [self[index] for index in range(self._count)[place]]
        return {name: _told(column[place]) for name, column in self._columns.items()}

    def __iter__(self) -> Iterator[dict[str, Any]]:
        for values in zip(*self._columns.values(), strict=True):
            yield dict(zip(self._columns, map(_told, values), strict=True))


def _told(value: Any) -> Any:
    return None if value != value else value  # noqa: PLR0124 - NaN stands for None in a column


# -----------------------------------------------------------------------------
# The rows of a fleet on disk, in Parquet files. An interrupted fleet can go on.
#
# `fleet.yaml` identifies the fleet, `ships.parquet` has its rows. Under way the rows are in small
# files in `ships/`, written atomically and joined at the end. A killed fleet loses the rows of
# its last second. Only one process writes to the folder.

EVERY_S = 1.0
"""Interval at which rows are written while ships finish."""

_AT_ONCE = 4096
"""Number of rows that are converted to mappings at a time."""

_SAYS, _TABLE, _PARTS, _LOCK = 'fleet.yaml', 'ships.parquet', 'ships', '.lock'


class FleetError(TautoError):
    """The rows of a fleet cannot be read or written."""


def need_parquet() -> None:
    """Refuse an option that needs Parquet files if pyarrow is not installed (UsageError)."""
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError:
        raise UsageError(
            Argument('out'),
            f': needs pyarrow, which is not installed. Run {install("fleet")}, or leave out ',
            Argument('out'),
        ) from None


class Store:
    """The rows of one fleet in a folder.

    Args:
        folder: made if it does not exist.
        identity: everything that determines the rows, except their number.
        columns: columns of the rows.

    Attributes:
        rows: the stored rows, sorted by ship, from `opened` on.

    Raises:
        UsageError: the folder has other contents or another fleet, or another process writes to
            it (when it is opened).
        FleetError: its contents cannot be read.
    """

    def __init__(self, folder: Path, identity: Mapping[str, Any], columns: Columns) -> None:
        need_parquet()
        self._folder, self._identity, self._columns = folder, identity, columns
        self._waiting = Rows()
        self._written_s = time.monotonic()
        self.rows = Rows()

    @contextmanager
    def opened(self) -> Iterator[None]:
        """Lock the folder, write the identity and read the rows. It is made if need be."""
        parts = self._folder / _PARTS
        self._check_folder()
        with ExitStack() as stack:
            with _saying(self._folder):
                self._folder.mkdir(parents=True, exist_ok=True)
                try:
                    stack.enter_context(one_writer(self._folder / _LOCK))
                except BlockingIOError:
                    raise UsageError(
                        Argument('out', self._folder),
                        ': another process sails a fleet into it. Wait until it ends, or name '
                        'another folder',
                    ) from None
            self._check_folder()  # another fleet may have started here
            self.rows = Rows(self._read())
            self.rows.sort()
            with _saying(self._folder):
                write_whole(self._folder / _SAYS, write_mapping(dict(self._identity)).encode())
                parts.mkdir(exist_ok=True)
                for drafts in (self._folder.glob(DRAFTS), parts.glob(DRAFTS)):
                    for draft in drafts:  # of a killed process
                        draft.unlink()
            yield

    def add(self, rows: Iterable[dict[str, Any]]) -> None:
        """Take rows that were made together. They are written at once or within `EVERY_S`."""
        self._waiting.extend(rows)
        if time.monotonic() >= self._written_s + EVERY_S:
            self.flush()

    def flush(self) -> None:
        """Write the rows in memory."""
        if not self._waiting:
            return
        number = int(self._waiting[0]['ship'])
        self._write(self._waiting, self._folder / _PARTS / f'{number:07d}.parquet')
        self.rows.extend(self._waiting)
        self._waiting, self._written_s = Rows(), time.monotonic()

    def close(self) -> None:
        """Join all rows in one file, sorted by ship."""
        self.flush()
        self.rows.sort()
        self._write(self.rows, self._folder / _TABLE)
        with _saying(self._folder):
            shutil.rmtree(self._folder / _PARTS)

    def _check_folder(self) -> None:
        folder, says = self._folder, self._folder / _SAYS
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
            stored = read_mapping(says.read_text('utf-8'), str(says))
        ours = read_mapping(write_mapping(dict(self._identity)), 'ours')
        names = [key for key in ours if stored.get(key) != ours[key]]
        if names:
            raise UsageError(
                Argument('out', folder),
                f': holds another fleet; {", ".join(names)} differ. Name a new folder, or give '
                'the same scene and draws, in the same versions, to go on',
            )

    def _read(self) -> Iterable[dict[str, Any]]:
        import pyarrow as pa
        import pyarrow.parquet as pq

        ships: set[int] = set()
        for file in (self._folder / _TABLE, *sorted((self._folder / _PARTS).glob('*.parquet'))):
            if not file.exists():
                continue
            try:
                table = pq.read_table(file)
            except (OSError, pa.ArrowException) as error:
                raise FleetError(
                    f'{file}: cannot be read ({error}). Remove it to sail its ships again'
                ) from None
            for batch in table.to_batches(_AT_ONCE):
                for row in batch.to_pylist():
                    if row['ship'] not in ships:
                        ships.add(row['ship'])
                        yield row

    def _write(self, rows: Rows, file: Path) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        buffer = pa.BufferOutputStream()
        pq.write_table(rows.table(self._columns), buffer)
        with _saying(self._folder):
            write_whole(file, buffer.getvalue())


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
# The figures of a row, and a plan that is sailed.

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


def figures_of(
    report: Mapping[str, Any], ended: BaseException | None, run_s: float
) -> dict[str, Any]:
    """Return FIGURES and ENDED from the result of a voyage. Missing figures are `None`."""
    return {
        **{name: report.get(section, {}).get(key) for name, (section, key) in FIGURES.items()},
        'failure': None if ended is None else str(ended) or type(ended).__name__,
        'run_s': run_s,
    }


def has_arrived(row: Mapping[str, Any]) -> bool:
    """Return whether the clock ran to the end: no event ended the voyage and it did not stop."""
    return row['failure'] is None and row['stopped_s'] is None


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

    task: Task[Voyage, list[dict[str, Any]]]
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
) -> Rows:
    """Sail a plan, or the rest of it, and return all rows sorted by `ship`.

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
    store = None if out is None else Store(out, plan.identity, plan.columns)
    clocks, voyages = plan.clocks, plan.voyages
    with nullcontext() if store is None else store.opened():
        rows = Rows() if store is None else store.rows
        keep = rows.extend if store is None else store.add
        stored = {ship // clocks for ship in rows.column('ship')}
        pending = [item for item in voyages if not stored or plan.number(item) not in stored]
        total, lost = clocks * len(voyages), list[str]()
        came_in = total - clocks * len(pending)

        def tell(share: float) -> None:
            if progress is not None:
                progress(total - clocks * len(pending) * (1.0 - share))

        # all voyages, not only the pending ones: a continued run uses as many processes
        works_s = [plan.cost_s(item) for item in pending[:1]] * len(voyages)
        jobs = jobs_for(works_s, jobs) if pending else 1
        try:
            with closing(run_each(plan.task, pending, jobs, tell)) as ended:
                for run in ended:
                    if run.result is not None:
                        came_in += clocks
                        keep(run.result)
                        continue
                    error, is_lost = run.error, isinstance(run.error, WorkerError)
                    if isinstance(error, SceneError) or (store is None and not is_lost):
                        assert error is not None
                        raise error
                    why = str(error) or type(error).__name__
                    lost.append(f'{plan.called(pending[run.place])}: {why}')
                    if store is None:
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
                if store is None
                else ('they are kept, and the same command sails ',)
            )
            raise WorkerError(error.message, tally, *advice, 'the others') from None
        finally:
            if store is not None:
                store.flush()
        if store is not None:
            store.close()
    rows.sort()
    if store is not None and len(rows) > total:
        numbers = set(map(plan.number, voyages))
        return Rows(row for row in rows if row['ship'] // clocks in numbers)
    return rows
