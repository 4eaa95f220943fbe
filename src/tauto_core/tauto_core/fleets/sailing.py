"""Sailing a fleet: a ship's voyage as a row, the rows on disk, ships on several processes.

A ship has arrived, has failed by physics, or is lost with her process or the scheduler. The lost
are no observations: they have no row, there is no answer without them, and they sail again.
"""

from __future__ import annotations

import shutil
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager, nullcontext, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tauto_core import voyage
from tauto_core.checks.readiness import check_scene
from tauto_core.files import DRAFTS, one_writer, write_whole
from tauto_core.fleets.answers import Answers, answers
from tauto_core.fleets.plan import Normal, OneOf, Plan, Uniform
from tauto_core.scene.errors import (
    Argument,
    MotionDataError,
    TautoError,
    TautoWarning,
    UsageError,
    install,
    naming,
)
from tauto_core.scene.loader import read_mapping, write_mapping
from tauto_core.wording import counted
from tauto_core.workers import Crew, WorkerError, run_each, versions

if TYPE_CHECKING:
    import pyarrow as pa


# -----------------------------------------------------------------------------
# The voyage of one ship of a fleet: a row of figures, or the reason why there are none.
#
# A voyage that physics ends is an observation, and a row. One that never ended, for want of
# memory or of a file, is none: its error is raised, and she sails again.

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
"""Columns of a row, and their place in the result of `voyage.sail`. They belong to the sample by
which a voyage is judged, the last one before the landfall or the end (`navigation.tally`), and are
positive to the east.
"""


def sail_ship(plan: Plan, number: int, progress: Callable[[float], None]) -> dict[str, Any]:
    """Return the row of a ship: number and seed, drawn values, FIGURES, and processor time.

    `failure` is None, or says what ended the voyage early; then there are no figures. `run_s` is
    the processor time of the thread, the only column that differs in another run.

    Args:
        plan: the plan of the fleet.
        number: number of the ship.
        progress: called with the fraction done, from 0 to 1.

    Raises:
        Exception: what has nothing to do with her voyage, such as a MemoryError.
    """
    ship, began, failure = plan.ship(number), time.thread_time(), None
    report: Mapping[str, Any] = {}
    try:
        report = voyage.sail(
            ship.scene,
            origin=plan.origin,
            anyway=True,  # all ships were checked together
            keep=False,
            progress=progress,
        ).result
    except MotionDataError:  # a file that is not on this machine, or cannot be read
        raise
    except TautoError as error:
        failure = str(error) or type(error).__name__
    return {
        'ship': number,
        'seed': ship.scene.seed,
        **ship.drawn,
        **{column: report.get(section, {}).get(key) for column, (section, key) in FIGURES.items()},
        'failure': failure,
        'run_s': time.thread_time() - began,
    }


# -----------------------------------------------------------------------------
# The rows of a fleet on disk: Parquet, written as ships finish, and continued after a break.
#
# The folder contains `fleet.yaml`, which identifies the fleet, and `ships.parquet`. While the
# fleet sails, its rows are in small files in `ships/`, each written completely or not at all; at
# the end they are joined in the order of the ships. A fleet that is killed loses the rows of its
# last second. Only one process writes to the folder.

EVERY_S = 1.0
"""Interval at which rows are written while ships finish."""

_SAYS, _ALL, _PARTS, _LOCK = 'fleet.yaml', 'ships.parquet', 'ships', '.lock'


class FleetError(TautoError):
    """A fleet whose rows cannot be read or written."""


def need_parquet() -> None:
    """Refuse an option that needs Parquet files if they cannot be written.

    Raises:
        UsageError: pyarrow is not installed.
    """
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError:
        raise UsageError(
            Argument('out'),
            f': needs pyarrow, which is not installed. Run {install("fleet")}, or leave out ',
            Argument('out'),
        ) from None


class Store:
    """The rows of one fleet in its folder.

    Args:
        folder: made if it does not exist.
        plan: the plan of the fleet.

    Attributes:
        rows: the stored rows in the order of the ships, while it is opened.

    Raises:
        UsageError: the folder holds something else, or another fleet, or another process writes
            to it.
        FleetError: its contents cannot be read.
    """

    def __init__(self, folder: Path, plan: Plan) -> None:
        need_parquet()
        self._folder, self._plan = folder, plan
        self._waiting: list[dict[str, Any]] = []
        self._written_s = time.monotonic()
        self.rows: list[dict[str, Any]] = []
        with (
            _saying(folder),
            suppress(FileNotFoundError, NotADirectoryError),
            self._one_writer(make=False),
        ):
            pass
        self._check_folder()

    @contextmanager
    def opened(self) -> Iterator[None]:
        """Make the folder, be its only writer, identify the fleet in it and read its rows."""
        parts = self._folder / _PARTS
        with ExitStack() as held:
            with _saying(self._folder):
                self._folder.mkdir(parents=True, exist_ok=True)
                held.enter_context(self._one_writer())
            self._check_folder()  # another fleet may have sailed here since
            self.rows = sorted(self._read(), key=lambda row: int(row['ship']))
            with _saying(self._folder):
                write_whole(self._folder / _SAYS, write_mapping(self._identity()).encode())
                parts.mkdir(exist_ok=True)
                for drafts in (self._folder.glob(DRAFTS), parts.glob('.*')):
                    for left in drafts:  # by a process that was killed
                        left.unlink()
            yield

    @contextmanager
    def _one_writer(self, *, make: bool = True) -> Iterator[None]:
        with ExitStack() as held:
            try:
                held.enter_context(one_writer(self._folder / _LOCK, make=make))
            except BlockingIOError:
                raise UsageError(
                    Argument('out', self._folder),
                    ': another process sails a fleet into it. Wait until it ends, or name another '
                    'folder',
                ) from None
            yield

    def add(self, row: dict[str, Any]) -> None:
        """Take the row of a ship that finished; write it at once, or later with the next rows."""
        self._waiting.append(row)
        if time.monotonic() >= self._written_s + EVERY_S:
            self.flush()

    def flush(self) -> None:
        """Write the rows in memory."""
        if not self._waiting:
            return
        first = int(self._waiting[0]['ship'])
        self._write(self._waiting, self._folder / _PARTS / f'{first:07d}.parquet')
        self.rows += self._waiting
        self._waiting, self._written_s = [], time.monotonic()

    def close(self) -> None:
        """Join all rows in one file, in the order of the ships."""
        self.flush()
        self.rows.sort(key=lambda row: int(row['ship']))
        self._write(self.rows, self._folder / _ALL)
        with _saying(self._folder):
            shutil.rmtree(self._folder / _PARTS)

    def _identity(self) -> dict[str, Any]:
        """Return all on which the rows of this folder depend, except the number of ships."""
        return {
            'scene': self._plan.content,
            'vary': {
                key: draw.model_dump(exclude_none=True) for key, draw in self._plan.draws.items()
            },
            'versions': versions(),
        }

    def _check_folder(self) -> None:
        folder, says = self._folder, self._folder / _SAYS
        if not folder.exists():
            return
        if not folder.is_dir():
            raise UsageError(Argument('out', folder), ': is a file. Name a folder')
        if not says.exists():
            # killed at its start, a fleet leaves no more than these
            if any(not each.match(DRAFTS) for each in folder.iterdir() if each.name != _LOCK):
                other = ': holds something else. Name a new folder'
                raise UsageError(Argument('out', folder), other)
            return
        with _saying(folder):
            found = read_mapping(says.read_text('utf-8'), str(says))
        ours = read_mapping(write_mapping(self._identity()), 'ours')
        apart = [key for key in ours if found.get(key) != ours[key]]
        if apart:
            raise UsageError(
                Argument('out', folder),
                f': holds another fleet; {", ".join(apart)} differ. Name a new folder, or give '
                'the same scene and draws, in the same versions, to go on',
            )

    def _read(self) -> Iterable[dict[str, Any]]:
        """Yield the stored rows, one for each ship."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        seen: set[int] = set()
        lost: set[int] = set()
        for file in (self._folder / _ALL, *sorted((self._folder / _PARTS).glob('*.parquet'))):
            if not file.exists():
                continue
            try:
                rows = pq.read_table(file).to_pylist()
            except (OSError, pa.ArrowException) as error:
                raise FleetError(
                    f'{file}: cannot be read ({error}). Remove it to sail its ships again'
                ) from None
            for row in rows:
                # Tauto 0.2.0 entered ships as failed whose processes or scheduler it had lost.
                # They cost no time: a voyage that failed by itself did.
                if row['failure'] is not None and row['run_s'] is None:
                    lost.add(row['ship'])
                elif row['ship'] not in seen:
                    seen.add(row['ship'])
                    yield row
        if lost := lost - seen:
            warnings.warn(
                f'{self._folder}: {counted(len(lost), "ship")} in it failed by no fault of the '
                'voyage, with the process or the scheduler: lost ships sail again',
                TautoWarning,
                stacklevel=2,
            )

    def _write(self, rows: Sequence[Mapping[str, Any]], file: Path) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        table = pa.Table.from_pylist(list(rows), schema=schema(self._plan))
        buffer = pa.BufferOutputStream()
        pq.write_table(table, buffer)
        with _saying(self._folder):
            write_whole(file, buffer.getvalue())


def schema(plan: Plan) -> pa.Schema:
    """Return the columns of a fleet's rows, with their types."""
    import pyarrow as pa

    pounds = {'raw_prize_pounds', 'prize_pounds'}
    return pa.schema(
        [
            ('ship', pa.int64()),
            ('seed', pa.int64()),
            *((key, _type_of(draw)) for key, draw in plan.draws.items()),
            *((name, pa.int64() if name in pounds else pa.float64()) for name in FIGURES),
            ('failure', pa.string()),
            ('run_s', pa.float64()),
        ]
    )


def _type_of(draw: Normal | Uniform | OneOf) -> pa.DataType:
    import pyarrow as pa

    values = draw.values if isinstance(draw, OneOf) else (0.5,)
    if all(isinstance(value, bool) for value in values):
        return pa.bool_()
    if all(isinstance(value, str) for value in values):
        return pa.string()
    whole = all(isinstance(value, int) for value in values)
    return pa.int64() if whole else pa.float64()


@contextmanager
def _saying(folder: Path) -> Iterator[None]:
    """Turn errors of the file system into a clear message."""
    try:
        yield
    except OSError as error:
        raise FleetError(
            Argument('out', folder),
            f': {error.strerror or error}. Make room, or name another folder; the ships that came '
            'in before are kept, and the same command goes on',
        ) from None


@dataclass(frozen=True)
class Fleet:
    """A fleet that has sailed.

    Attributes:
        plan: the plan of the fleet.
        rows: results of `member.sail_ship`, in the order of the ships.
        answers: statistics of the rows.
    """

    plan: Plan
    rows: list[dict[str, Any]]
    answers: Answers


def sail_fleet(
    plan: Plan,
    crew: Crew,
    out: Path | None = None,
    progress: Callable[[float], None] | None = None,
    *,
    anyway: bool = False,
) -> Fleet:
    """Sail a fleet, or the rest of it.

    Args:
        plan: the plan of the fleet.
        crew: processes that sail it.
        out: folder for the rows, written as ships finish; ships that have a row there do not sail
            again. None: the rows are only returned.
        progress: called with the number of ships done, parts of voyages included.
        anyway: sail machines and ships beyond all that are known, too.

    Raises:
        SceneError: the scene of a ship, as drawn, is invalid; no ship has sailed then.
        UsageError: the folder holds something else, or another process writes there.
        FleetError: the folder cannot be used.
        WorkerError: there are no processes available, or ships were lost with them.
    """
    store = None if out is None else Store(out, plan)
    plan.check(anyway=anyway)
    first = plan.ship(0).scene
    with naming(plan.origin, first.name):
        check_scene(first)
    with nullcontext() if store is None else store.opened():
        rows = [] if store is None else [row for row in store.rows if row['ship'] < plan.ships]
        there = {int(row['ship']) for row in rows}
        left = [number for number in range(plan.ships) if number not in there]
        if left:
            rows += _sailed(plan, left, crew, store, progress)
        if store is not None:
            store.close()
    rows.sort(key=lambda row: int(row['ship']))
    return Fleet(plan, rows, answers(plan, rows))


def _sailed(
    plan: Plan,
    left: list[int],
    crew: Crew,
    store: Store | None,
    progress: Callable[[float], None] | None,
) -> list[dict[str, Any]]:
    """Return the rows of the ships that have not sailed yet, stored as they finish."""

    def tell(share: float) -> None:
        if progress is not None:
            progress(plan.ships - len(left) * (1.0 - share))

    rows: list[dict[str, Any]] = []
    lost: list[str] = []
    try:
        with closing(run_each(partial(sail_ship, plan), left, crew, tell)) as ended:
            for each in ended:
                if each.result is None:
                    why = str(each.error) or type(each.error).__name__
                    lost.append(f'ship {left[each.place]}: {why}')
                    warnings.warn(f'{lost[-1]}. She is lost', TautoWarning, stacklevel=2)
                    continue
                rows.append(each.result)
                if store is not None:
                    store.add(each.result)
        if lost:
            more = f' ({len(lost) - 1} more)' if len(lost) > 1 else ''
            first = lost[0].message if isinstance(lost[0], TautoError) else str(lost[0])
            count = counted(len(lost), 'ship')
            raise WorkerError(f'{count} did not end the voyage: ', first, more)
    except WorkerError as error:
        came = plan.ships - len(left) + len(rows)
        if came == 0:
            raise
        kept = (
            ('with ', Argument('out'), ' they would be kept, and the same command would sail the ')
            if store is None
            else ('they are kept, and the same command sails the ',)
        )
        many = f'. {came:,} of {counted(plan.ships, "ship")} came in; '
        raise WorkerError(error.message, many, *kept, 'others') from None
    finally:
        if store is not None:
            store.flush()
    return rows
