"""The folder of a running graph: parameters, output of the nodes, the recorder's report."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tauto_core.files import one_writer
from tauto_nodes.errors import GraphError

# -----------------------------------------------------------------------------
# What the recorder says of a voyage, while it runs and at its end, in the file named `report`.


@dataclass(frozen=True)
class Recorded:
    """The report of the recorder.

    Times are those of `time.monotonic()`, which on Linux is one clock for all processes.

    Args:
        complete: whether the ends of all topics had come.
        began_s: when its first message came [s]; None: none came.
        closed_s: when the bag was closed [s]; None: it is open.
        topics: received, written and lost, by topic.
        heard_s: when each node of the graph was last heard [s].
        moved_s: when the report of any of them last said something new [s].
    """

    complete: bool
    began_s: float | None
    closed_s: float | None
    topics: dict[str, Any]
    heard_s: dict[str, float]
    moved_s: float

    def write(self, file: Path) -> None:
        """Write the report, as JSON."""
        file.write_text(json.dumps(asdict(self)), 'utf-8')

    @staticmethod
    def read(file: Path) -> Recorded | None:
        """Return the report; None if there is none yet.

        Raises:
            ValueError: it is being written, or there was no room for it.
        """
        try:
            return Recorded(**json.loads(file.read_text('utf-8')))
        except FileNotFoundError:
            return None


PREFIX = 'tauto_graph_'
LOCK = 'lock'


@contextmanager
def work_folder(parent: str | None) -> Iterator[Path]:
    """Yield a folder for as long as the context lasts; remove those of graphs that were killed.

    A folder whose lock can be had is one that nobody uses any more.

    Args:
        parent: where to make it; None: where the system has temporary files.

    Raises:
        GraphError: no folder can be made there.
    """
    place = Path(parent or tempfile.gettempdir())
    for lock in place.glob(f'{PREFIX}*/{LOCK}'):
        _remove_if_left(lock)
    try:
        made = tempfile.TemporaryDirectory(prefix=PREFIX, dir=place)
    except OSError as error:
        raise GraphError(
            f'{place}: no folder can be made there ({error.strerror}), and a graph keeps its '
            'parameters in one. Make room, or set TMPDIR to another place'
        ) from error
    with made as name:
        # Under its own name the lock could be had before it is locked.
        lock = Path(name, 'not_locked_yet')
        with one_writer(lock):
            yield lock.rename(Path(name, LOCK)).parent


def _remove_if_left(lock: Path) -> None:
    with suppress(OSError):  # it is held, or another start was faster
        if lock.parent.lstat().st_uid == os.getuid():
            with one_writer(lock, make=False):
                shutil.rmtree(lock.parent, ignore_errors=True)
