"""Many independent runs: in this process, or in several of this machine.

A run keeps one core busy, so it takes a process with one thread. A process that dies costs its own
run alone, and the next takes it. (The executors of `concurrent.futures` and loky give up the runs
of all their processes then.) Runs in this process do not import loky.
"""

from __future__ import annotations

import ctypes
import os
import pickle
import platform
import signal
import time
import traceback
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from multiprocessing import Pipe, resource_tracker
from multiprocessing.connection import Connection, wait
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeAlias, TypeVar, cast

from tauto_core.scene.errors import Argument, TautoError
from tauto_core.version import identity

if TYPE_CHECKING:
    from loky.backend.process import LokyProcess

Item = TypeVar('Item')
Result = TypeVar('Result')
Share: TypeAlias = Callable[[float], None]
Task: TypeAlias = Callable[[Item, Share], Result]

TELL_S = 0.2
"""Interval at which a run in another process reports its progress [s]."""

_ALIKE = ('numpy', 'scipy', 'llvmlite', 'pydantic')
"""Libraries with versions on which results may depend."""

MOST_DEATHS = 4
"""Deaths of its process after which a run is given up."""

POOL_START_S = 1.5
"""Approximate time in which a process starts and loads the modules of a run [s]."""


class WorkerError(TautoError):
    """Processes are not available, or died. The run is not at fault."""


def jobs_for(works_s: Sequence[float], jobs: int) -> int:
    """Return 1, this process, if other processes would take longer to start than they would save.

    `works_s` are the expected processor times of the runs [s].
    """
    saved_s = sum(works_s) * (1.0 - 1.0 / min(jobs, len(works_s))) if jobs > 1 else 0.0
    return jobs if saved_s > POOL_START_S else 1


@dataclass(frozen=True)
class Ended(Generic[Result]):
    """A run that has ended.

    Attributes:
        place: index of its item.
        result: result of the task, `None` if it failed.
        error: the exception, a WorkerError if its processes died, `None` if there is a result.
    """

    place: int
    result: Result | None
    error: Exception | None = None


def run_each(
    task: Task[Item, Result],
    items: Sequence[Item],
    jobs: int,
    progress: Share | None = None,
) -> Generator[Ended[Result]]:
    """Yield the result of each item as runs end. They begin in the order of the items.

    The task is called with an item and a function that takes the fraction done. Both, and the
    result, are pickled. A run is repeated up to three times if its process dies. Closing the
    iterator ends the processes.

    Raises:
        WorkerError: no process can be started.
    """
    shares, total = [0.0] * len(items), 0.0

    def tell(place: int, share: float) -> None:
        """Add the progress of one run. A run that is repeated does not reduce it."""
        nonlocal total
        gained = share - shares[place]
        if gained > 0.0:
            shares[place] = share
            total += gained
            if progress is not None:
                progress(min(total / len(items), 1.0))

    if jobs == 1:
        for place, item in enumerate(items):
            ended = _ended(task, place, item, partial(tell, place))
            tell(place, 1.0)
            yield ended
        return
    for news in _run_beside(task, items, jobs):
        if isinstance(news, Ended):
            tell(news.place, 1.0)
            yield news
        else:
            tell(*news)


def _ended(task: Task[Item, Result], place: int, item: Item, tell: Share) -> Ended[Result]:
    try:
        return Ended(place, task(item, tell))
    except Exception as error:
        return Ended(place, None, error)


# -----------------------------------------------------------------------------
# Processes without a port, which get their runs through pipes.


class _Run(NamedTuple):
    """A run: the place of its item, the pickled call, and how many processes it has killed."""

    place: int
    call: bytes
    deaths: int = 0


_Crew: TypeAlias = 'dict[Connection, tuple[LokyProcess, _Run | None]]'
"""Processes by their pipes, with the run of each, `None` if it is idle."""


def _run_beside(
    task: Task[Item, Result], items: Sequence[Item], jobs: int
) -> Generator[tuple[int, float] | Ended[Result]]:
    """Yield the progress of runs in other processes, and their results."""
    from loky.backend import resource_tracker as loky_tracker
    from loky.backend.reduction import dumps

    # They reset the signal mask of the thread that starts them, so start them here.
    with _safe_path():
        resource_tracker.ensure_running()
        loky_tracker.ensure_running()
    crew: _Crew = {}
    waiting = enumerate(items)

    def hand(pipe: Connection, run: _Run | None) -> None:
        crew[pipe] = crew[pipe][0], run
        if run is not None:
            with suppress(OSError):  # its process has died: the pipe says so
                pipe.send_bytes(run.call)

    def following() -> _Run | None:
        for place, item in waiting:
            return _Run(place, dumps((task, place, item)))
        return None

    try:
        for _ in range(min(jobs, len(items))):
            hand(_start(crew), following())
        while busy := {pipe: run for pipe, (_, run) in crew.items() if run is not None}:
            for ready in wait(list(busy)):
                pipe = cast('Connection', ready)
                run = busy[pipe]
                try:
                    news = pipe.recv()
                except (EOFError, OSError):  # it died
                    _end(crew, pipe)
                    pipe = _start(crew)
                    if run.deaths + 1 < MOST_DEATHS:
                        hand(pipe, run._replace(deaths=run.deaths + 1))
                        continue
                    news = Ended(run.place, None, WorkerError(*_DIED))
                if isinstance(news, Ended):
                    hand(pipe, following())
                yield news
    finally:
        for pipe in list(crew):
            _end(crew, pipe)


_DIED = (
    'its process died four times, for want of memory perhaps. Use fewer processes at once (',
    Argument('jobs', 1),
    '), or a machine with more memory',
)

_SAFE_PATH = {'PYTHONSAFEPATH': '1'}
"""Environment of the processes: they must not import modules from the working folder."""


@contextmanager
def _safe_path() -> Iterator[None]:
    old = os.environ.get('PYTHONSAFEPATH')
    os.environ.update(_SAFE_PATH)
    try:
        yield
    finally:
        del os.environ['PYTHONSAFEPATH']
        os.environ.update({} if old is None else {'PYTHONSAFEPATH': old})


def _start(crew: _Crew) -> Connection:
    """Start a process, which Ctrl-C and the end of a terminal do not reach: we end it."""
    from loky.backend.process import LokyProcess

    ours, theirs = Pipe()
    # a process inherits the signal mask
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
    try:
        process = LokyProcess(
            target=_serve, args=(theirs, os.getpid()), daemon=True, env=_SAFE_PATH
        )
        process.start()
        crew[ours] = process, None
    except OSError as error:
        raise WorkerError(
            f'no process can be started ({error}). Use fewer at once (', Argument('jobs', 1), ')'
        ) from None
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        theirs.close()
    return ours


def _end(crew: _Crew, pipe: Connection) -> None:
    process, _ = crew.pop(pipe)
    process.terminate()
    process.join()
    pipe.close()


def _serve(pipe: Connection, parent: int) -> None:
    """Make runs until the pipe closes. Linux ends this with its parent."""
    from loky.backend.reduction import dumps

    prctl = getattr(ctypes.CDLL(None), 'prctl', None)
    if prctl is not None:
        prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG
    if os.getppid() != parent:
        return
    told_s = 0.0

    def tell(share: float) -> None:
        nonlocal told_s
        if time.monotonic() >= told_s + TELL_S:
            told_s = time.monotonic()
            pipe.send_bytes(dumps((place, share)))

    with suppress(EOFError, ConnectionError):  # the parent was killed, or needs no more
        while True:
            task, place, item = pickle.loads(pipe.recv_bytes())
            ended = _ended(task, place, item, tell)
            if ended.error is not None and not isinstance(ended.error, TautoError):
                ended.error.add_note(''.join(traceback.format_exception(ended.error)))
            pipe.send_bytes(dumps(ended))


def versions() -> dict[str, str]:
    """Return the versions on which results may depend, for this package a hash of its code."""
    return {
        'python': platform.python_version(),
        'tauto_core': identity(),
        **{name: version(name) for name in _ALIKE},
    }
