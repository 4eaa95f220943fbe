"""The rows of a fleet on disk: Parquet, written as ships finish, and continued after a break.

The folder contains `fleet.yaml`, which identifies the fleet, and `ships.parquet`. While the fleet
sails, its rows are in small files in `ships/`, each written completely or not at all; at the end
they are joined in the order of the ships. A fleet that is killed loses the rows of its last
second. Only one process writes to the folder.
"""

from __future__ import annotations

import shutil
import time
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tauto_core.fleets.draws import Normal, OneOf, Uniform
from tauto_core.fleets.member import FIGURES
from tauto_core.fleets.plan import Plan
from tauto_core.scene.errors import TautoError, TautoWarning, UsageError, install
from tauto_core.scene.yaml_text import read_mapping, write_mapping
from tauto_core.whole_file import DRAFTS, one_writer, write_whole
from tauto_core.wording import counted
from tauto_core.workers import versions

if TYPE_CHECKING:
    import pyarrow as pa

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
            f'--out: needs pyarrow, which is not installed. Run {install("fleet")}, or leave out '
            '--out'
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
                    f'--out {self._folder}: another process sails a fleet into it. Wait until it '
                    'ends, or name another folder'
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
            raise UsageError(f'--out {folder}: is a file. Name a folder')
        if not says.exists():
            # killed at its start, a fleet leaves no more than these
            if any(not each.match(DRAFTS) for each in folder.iterdir() if each.name != _LOCK):
                raise UsageError(f'--out {folder}: holds something else. Name a new folder')
            return
        with _saying(folder):
            found = read_mapping(says.read_text('utf-8'), str(says))
        ours = read_mapping(write_mapping(self._identity()), 'ours')
        apart = [key for key in ours if found.get(key) != ours[key]]
        if apart:
            raise UsageError(
                f'--out {folder}: holds another fleet; {", ".join(apart)} differ. Name a new '
                'folder, or give the same scene and draws, in the same versions, to go on'
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
            f'--out {folder}: {error.strerror or error}. Make room, or name another folder; the '
            'ships that came in before are kept, and the same command goes on'
        ) from None
