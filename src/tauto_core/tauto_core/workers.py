"""Many independent runs on several processes, here or on other machines, by dask.distributed.

The mechanics keep one core busy each, so a run takes a process with one thread. With one job and
no scheduler, runs are made in this process and dask is not loaded.
"""

from __future__ import annotations

import logging
import platform
import queue
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from multiprocessing import resource_tracker
from types import ModuleType
from typing import TYPE_CHECKING, Generic, TypeAlias, TypeVar

from tauto_core.scene.errors import Argument, TautoError, TautoWarning, UsageError
from tauto_core.version import identity
from tauto_core.wording import counted

if TYPE_CHECKING:
    from distributed import Client, Future


# -----------------------------------------------------------------------------
# Ctrl-C and SIGTERM, held back while something starts that cannot be left half started.


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Hold back SIGINT and SIGTERM for as long as the context lasts; then let them act.

    A terminal sends SIGINT to all processes of a command. Those that start meanwhile never see it:
    this process has to end them. Only the main thread is interrupted by signals; in another this
    does nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    held: list[int] = []
    before = {
        number: signal.signal(number, lambda came, _: held.append(came))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for number, handler in before.items():
            signal.signal(number, handler)
        if held:
            signal.raise_signal(held[0])


Item = TypeVar('Item')
Result = TypeVar('Result')
Share: TypeAlias = Callable[[float], None]
Task: TypeAlias = Callable[[Item, Share], Result]

REACHED_WITHIN_S = 10.0
"""Time limit for reaching a scheduler."""

ASK_S = 5.0
"""Time without news after which the scheduler is asked whether it has workers."""

_TELL_S = 0.2
"""Interval at which a process reports its progress."""

_ALIKE = ('numpy', 'scipy', 'llvmlite', 'pydantic')
"""Libraries on whose versions results may depend."""

_TOPIC = 'tauto-share'

_UNWATCHED = {
    'distributed.worker.profile.enabled': False,
    'distributed.worker.memory.monitor-interval': '1s',
    'distributed.admin.tick.interval': '1s',
    'distributed.admin.system-monitor.interval': '10s',
    'distributed.admin.system-monitor.gil.enabled': False,
}
"""Settings of a cluster on this machine, without the measurements for dask's dashboard. They
would cost a tenth of the workers' processor time, and as much again in this process.
"""


class WorkerError(TautoError):
    """Processes or a scheduler that are not available, or that died: no fault of a run."""


@dataclass(frozen=True)
class Crew:
    """The processes on which runs are made.

    Attributes:
        jobs: number of parallel processes on this machine, >= 1; 1: in this process.
        scheduler: address of a dask scheduler, for example `tcp://ship:8786`; then `jobs` is not
            used.
    """

    jobs: int = 2
    scheduler: str | None = None

    def __post_init__(self) -> None:
        if self.jobs < 1:
            raise UsageError(
                Argument('jobs', self.jobs), ': must be at least 1. Use for example 2'
            )


@dataclass(frozen=True)
class Ended(Generic[Result]):
    """A run that has ended.

    Attributes:
        place: index of its item.
        result: result of the task; None where it failed.
        error: the exception; a WorkerError where its processes died; None where there is a result.
    """

    place: int
    result: Result | None
    error: Exception | None = None


def run_each(
    task: Task[Item, Result],
    items: Sequence[Item],
    crew: Crew,
    progress: Share | None = None,
) -> Generator[Ended[Result]]:
    """Yield the result of each item, as runs end; they begin in the order of the items.

    A run whose process dies is repeated on another one, up to three times. While nothing runs for
    want of workers, a TautoWarning says so. When the iterator is closed, runs that have not begun
    are dropped, and processes on this machine end.

    Args:
        task: called with an item and a function that reports the share done; both, and the result,
            are sent between processes.
        items: at least one.
        crew: the processes.
        progress: called with the share of all that is done, increasing from 0 to 1.

    Raises:
        WorkerError: the scheduler cannot be reached or is lost on the way, or its workers have
            other versions.
    """
    if crew.jobs == 1 and crew.scheduler is None:
        yield from _here(task, items, progress)
        return
    with _client(crew) as client:
        yield from _on(client, task, items, progress)


def _here(
    task: Task[Item, Result], items: Sequence[Item], progress: Share | None
) -> Iterator[Ended[Result]]:
    shares = _Shares(len(items), progress)
    for place, item in enumerate(items):
        try:
            ended = Ended(place, task(item, partial(shares.tell, place)))
        except Exception as error:
            ended = Ended(place, None, error)
        shares.tell(place, 1.0)
        yield ended


class _Shares:
    """The share of all runs that is done."""

    def __init__(self, count: int, progress: Share | None) -> None:
        self._shares = [0.0] * count
        self._done = 0.0
        self._progress = progress

    def tell(self, place: int, share: float) -> None:
        """Take the share of one run; a run that is repeated does not reduce it."""
        gained = share - self._shares[place]
        if gained <= 0.0:
            return
        self._shares[place] = share
        self._done += gained
        if self._progress is not None:
            self._progress(min(self._done / len(self._shares), 1.0))


def _on(
    client: Client, task: Task[Item, Result], items: Sequence[Item], progress: Share | None
) -> Iterator[Ended[Result]]:
    news: queue.SimpleQueue[tuple[int, float] | Future[Result]] = queue.SimpleQueue()
    client.subscribe_topic(_TOPIC, lambda event: news.put(event[1]))
    futures = client.map(partial(_run, task), list(enumerate(items)), pure=False)
    left: dict[object, tuple[int, Future[Result]]] = {}
    for place, future in enumerate(futures):
        left[future.key] = place, future
        future.add_done_callback(news.put)
    del futures  # results that were handed on need not be kept
    shares, attention = _Shares(len(items), progress), _Attention(client)
    try:
        while left:
            try:
                new = news.get(timeout=ASK_S)
            except queue.Empty:
                attention.ask(len(left))
                continue
            if isinstance(new, tuple):
                shares.tell(*new)
                continue
            ended = _ended(left[new.key][0], new, attention)
            del left[new.key]
            shares.tell(ended.place, 1.0)
            yield ended
    finally:
        client.unsubscribe_topic(_TOPIC)
        if not attention.lost:
            client.cancel([future for _, future in left.values()])


class _Attention:
    """Asks a scheduler from which nothing comes, so that nobody waits for it in vain.

    Attributes:
        lost: whether it is gone.
    """

    def __init__(self, client: Client) -> None:
        self._client = client
        self._said = ''
        self.lost = False

    def ask(self, left: int) -> None:
        """Say once that there are no workers, or that the scheduler does not answer.

        Args:
            left: number of runs that wait.

        Raises:
            WorkerError: it is lost.
        """
        scheduler, here = self._client.scheduler, self._client.cluster is not None
        said = ''
        try:
            if scheduler is None:
                raise self.gone('closed')
            if not self._client.sync(scheduler.ncores, callback_timeout=REACHED_WITHIN_S):
                start = f'Start some (dask worker {scheduler.address} --nthreads 1)'
                said = (
                    f'no worker process is left for {counted(left, "run")}. '
                    f'{"They are being started again" if here else start}, or stop with Ctrl-C'
                )
        except TimeoutError:
            said = (
                f'the scheduler has not answered for {REACHED_WITHIN_S:g} s. See what its own log '
                'says, or stop with Ctrl-C'
            )
        except OSError as error:
            raise self.gone(str(error)) from None
        if said and said != self._said:
            warnings.warn(said, TautoWarning, stacklevel=2)
        self._said = said

    def gone(self, why: str) -> WorkerError:
        """Return the error for a scheduler that is lost."""
        self.lost = True
        return WorkerError(f'the scheduler is lost ({why}). See its own log; start it again')


def _ended(place: int, future: Future[Result], attention: _Attention) -> Ended[Result]:
    from distributed import CancelledError
    from distributed.scheduler import KilledWorker

    while True:
        try:
            return Ended(place, future.result(timeout=ASK_S))
        except KilledWorker:
            died = WorkerError(
                'its process died four times, for want of memory perhaps. Use fewer processes at '
                'once (',
                Argument('jobs', 1),
                '), or machines with more memory',
            )
            return Ended(place, None, died)
        except CancelledError as error:
            raise attention.gone(getattr(error, 'reason', '') or 'cancelled') from None
        except OSError as error:
            if future.status == 'error':  # the run's own
                return Ended(place, None, error)
            # The way to the result is broken, or the worker that had it is gone. The run is
            # repeated, unless it is the scheduler: then the client lets go of the future.
            time.sleep(_TELL_S)
            if future.status != 'cancelled':
                attention.ask(1)
        except Exception as error:
            return Ended(place, None, error)


def _run(task: Task[Item, Result], placed: tuple[int, Item]) -> Result:
    """Run one item in a worker."""
    from distributed import get_worker

    place, item = placed
    worker, told = get_worker(), time.monotonic()

    def tell(share: float) -> None:
        nonlocal told
        if time.monotonic() >= told + _TELL_S:
            told = time.monotonic()
            worker.log_event(_TOPIC, (place, share))

    return task(item, tell)


@contextmanager
def _client(crew: Crew) -> Iterator[Client]:
    """Yield a client of the crew's processes; end those of this machine afterwards."""
    import dask
    import distributed

    if crew.scheduler is not None:
        with _joined(crew.scheduler) as client:
            yield client
        return
    with _main_not_run_again(), ExitStack() as started:
        # the first process to start would start it, and then see SIGINT again
        resource_tracker.ensure_running()
        # dask cannot close a cluster whose processes have not all started
        with interrupts_held(), dask.config.set(_UNWATCHED):
            cluster = distributed.LocalCluster(
                n_workers=crew.jobs,
                threads_per_worker=1,
                processes=True,
                host='127.0.0.1',
                dashboard_address='127.0.0.1:0',  # None would ask for one fixed port
                scheduler_kwargs={'dashboard': False},
                silence_logs=logging.CRITICAL,
            )
            started.enter_context(cluster)
            client = distributed.Client(cluster, set_as_default=False)
            started.enter_context(client)
        yield client


@contextmanager
def _main_not_run_again() -> Iterator[None]:
    """Let processes that start meanwhile begin without the script that is running.

    Python gives a new process the main module by running its file again. That would start a script
    without `if __name__ == '__main__':` from its beginning in every process, and a script that
    comes from standard input has no file at all. The runs need nothing from it.
    """
    main = sys.modules['__main__']
    sys.modules['__main__'] = ModuleType('__main__')
    try:
        yield
    finally:
        sys.modules['__main__'] = main


@contextmanager
def _joined(address: str) -> Iterator[Client]:
    import distributed
    from distributed.utils import silence_logging_cmgr

    began = time.monotonic()
    quiet = silence_logging_cmgr(logging.CRITICAL)  # what it would log of a lost scheduler is said
    try:
        client = distributed.Client(address, timeout=REACHED_WITHIN_S, set_as_default=False)
    except (OSError, ValueError) as error:
        waited = time.monotonic() - began
        raise WorkerError(
            Argument('scheduler', address),
            f': cannot be reached, after {waited:.1f} s ({error}). Start it (dask scheduler), '
            'check the address, or leave out ',
            Argument('scheduler'),
        ) from None
    with quiet, client:
        _check_alike(client, address)
        yield client


def versions() -> dict[str, str]:
    """Return the versions on which results may depend; of this package the code itself."""
    return {
        'python': platform.python_version(),
        'tauto_core': identity(),
        **{name: version(name) for name in _ALIKE},
    }


def _check_alike(client: Client, address: str) -> None:
    """Refuse workers that could give other bits than this machine."""
    with suppress(TimeoutError):
        client.wait_for_workers(1, timeout=REACHED_WITHIN_S)
    ours = versions()
    theirs = client.run(versions, on_error='return')
    if not theirs:
        raise WorkerError(
            Argument('scheduler', address),
            f': has no workers, after {REACHED_WITHIN_S:g} s. Start some '
            f'(dask worker {address} --nthreads 1)',
        )
    for worker, found in theirs.items():
        if not isinstance(found, dict):
            raise WorkerError(
                Argument('scheduler', address),
                f': worker {worker} cannot run tauto_core ({found}). Install tauto_core '
                f'{ours["tauto_core"]} there',
            )
        apart = [
            f'{name} {found[name]} against {ours[name]}'
            for name in ours
            if found[name] != ours[name]
        ]
        if apart:
            raise WorkerError(
                Argument('scheduler', address),
                f': worker {worker} has other versions than this machine: {", ".join(apart)}. '
                'Install the same on both',
            )
