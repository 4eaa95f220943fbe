"""The folder of a running graph: its parameters, the nodes' output, the recorder's report."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tauto_core.whole_file import one_writer
from tauto_nodes.errors import GraphError

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
