"""Many independent runs: in this process, in several of this machine, or on a dask scheduler.

The last two are executors of `concurrent.futures`: `_Processes` here, dask's own on a cluster. A
run keeps one core busy, so it takes a process with one thread. Runs in this process import
neither loky nor dask.
"""

from __future__ import annotations

import ctypes
import logging
import os
import pickle
import platform
import queue
import signal
import threading
import time
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass
from functools import cache, partial
from importlib.metadata import version
from itertools import islice
from multiprocessing import Pipe, resource_tracker
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

from tauto_core.scene.errors import (
    Argument,
    ArgumentText,
    TautoError,
    TautoWarning,
    UsageError,
    install,
)
from tauto_core.version import identity
from tauto_core.wording import counted

if TYPE_CHECKING:
    from distributed import Client

Item = TypeVar('Item')
Result = TypeVar('Result')
Share: TypeAlias = Callable[[float], None]
Task: TypeAlias = Callable[[Item, Share], Result]

REACHED_WITHIN_S = 10.0
"""Time limit for reaching a scheduler [s]."""

AHEAD = 4096
"""Runs that are submitted before the first of them has ended: two each for 2000 processes."""

ASK_S = 5.0
"""Time without news after which the scheduler is asked for its workers [s]."""

TELL_S = 0.2
"""Interval at which a run reports its progress [s]."""

_ALIKE = ('numpy', 'scipy', 'llvmlite', 'pydantic')
"""Libraries with versions on which results may depend."""

_TOPIC = 'tauto-share'

MOST_DEATHS = 4
"""Deaths of its process after which a run is given up."""

POOL_START_S = 1.5
"""Approximate time in which a process starts and loads the modules of a run [s]."""

_DIED = (
    'its process died four times, for want of memory perhaps. Use fewer processes at once (',
    Argument('jobs', 1),
    '), or machines with more memory',
)


class WorkerError(TautoError):
    """Processes or a scheduler are not available, or died. The run is not at fault."""


@dataclass(frozen=True)
class WorkerPool:
    """The processes on which runs are made.

    Attributes:
        jobs: number of parallel processes on this machine, >= 1. 1: this process.
        scheduler: address of a dask scheduler, for example `tls://ship:8786`, which replaces
            `jobs`. A scheduler without TLS causes a warning.
    """

    jobs: int = 2
    scheduler: str | None = None

    def __post_init__(self) -> None:
        if self.jobs < 1:
            raise UsageError(
                Argument('jobs', self.jobs), ': must be at least 1. Use for example 2'
            )

    def for_work(self, works_s: Iterable[float]) -> WorkerPool:
        """Return this process alone if others would take longer to start than they would save.

        `works_s` are the expected processor times of the runs [s].
        """
        if self.jobs == 1 or self.scheduler is not None:
            return self
        works = list(works_s)
        saved_s = sum(works) * (1.0 - 1.0 / min(self.jobs, len(works)))
        return self if saved_s > POOL_START_S else WorkerPool(1)


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
    crew: WorkerPool,
    progress: Share | None = None,
) -> Generator[Ended[Result]]:
    """Yield the result of each item as runs end. They begin in the order of the items.

    The task is called with an item and a function that takes the fraction done. Both, and the
    result, are pickled. At most `AHEAD` runs are submitted at a time. A run is repeated up to
    three times if its process dies. A TautoWarning tells when runs wait for workers. Closing the
    iterator drops waiting runs and ends the processes on this machine.

    Raises:
        WorkerError: the scheduler cannot be reached or is lost, or a worker has other versions.
            Workers may join at any time. Each run checks them.
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

    if crew.jobs == 1 and crew.scheduler is None:
        for place, item in enumerate(items):
            try:
                ended = Ended(place, task(item, partial(tell, place)))
            except Exception as error:
                ended = Ended(place, None, error)
            tell(place, 1.0)
            yield ended
        return
    yield from _run_beside(task, items, crew, tell)


def _run_beside(
    task: Task[Item, Result],
    items: Sequence[Item],
    crew: WorkerPool,
    tell: Callable[[int, float], None],
) -> Generator[Ended[Result]]:
    news: queue.SimpleQueue[tuple[int, float] | Future[Result]] = queue.SimpleQueue()
    with ExitStack() as started:
        pool: Executor
        attention = None
        if crew.scheduler is None:
            pool = started.enter_context(closing(_Processes(min(crew.jobs, len(items)), news.put)))
            submit = partial(pool.submit, _run)
        else:
            client = started.enter_context(_joined(crew.scheduler))
            attention = _Attention(client, crew.scheduler)
            pool = client.get_executor(pure=False)
            client.subscribe_topic(_TOPIC, lambda event: news.put(event[1]))
            started.callback(attention.leave, pool)
            submit = partial(_as_bytes(pool), partial(_run_alike, versions()))
        running: dict[Future[Result], int] = {}
        waiting, came = enumerate(items), 0

        def hand_on(count: int) -> None:
            for place, item in islice(waiting, count):
                run = submit(task, place, item)
                running[run] = place
                run.add_done_callback(news.put)

        hand_on(AHEAD)
        while running:
            try:
                new = news.get(timeout=ASK_S)
            except queue.Empty:
                if attention is not None:
                    attention.ask(len(items) - came)
                continue
            if isinstance(new, tuple):
                tell(*new)
                continue
            place = running.pop(new)
            came += 1
            hand_on(1)
            try:
                ended = Ended(place, new.result())
            except Exception as error:
                meant = error if attention is None else attention.meaning(error)
                ended = Ended(place, None, meant)
            tell(place, 1.0)
            yield ended


_to_parent: Callable[[tuple[int, float] | Ended[Any]], None] | None = None
"""In a process of `_Processes`: sends the progress of a run, then its result."""


def _run(task: Task[Item, Result], place: int, item: Item) -> Result:
    told_s = time.monotonic()

    def tell(share: float) -> None:
        nonlocal told_s
        if time.monotonic() < told_s + TELL_S:
            return
        told_s = time.monotonic()
        if _to_parent is not None:
            _to_parent((place, share))
            return
        from distributed import get_worker

        get_worker().log_event(_TOPIC, (place, share))

    return task(item, tell)


@cache
def _versions_here() -> dict[str, str]:
    return versions()


def _run_alike(
    ours: Mapping[str, str], task: Task[Item, Result], place: int, item: Item
) -> Result:
    """Run one item on a worker with the same versions as the client."""
    if ours != _versions_here():
        from distributed import get_worker

        raise WorkerError(_unlike(get_worker().address, ours, _versions_here()))
    return _run(task, place, item)


def _as_bytes(pool: Executor) -> Callable[..., Future[Any]]:
    """Return a `submit` with calls that do not end a worker without tauto_core."""
    from distributed.protocol.pickle import dumps

    def opened(call: bytes) -> Any:  # a closure, which is pickled by its code
        import pickle

        return pickle.loads(call)()

    return lambda run, *args: pool.submit(opened, dumps(partial(run, *args)))


class _Processes(Executor):
    """Makes each run in a process of this machine, or in a new one if that dies, without port."""

    def __init__(self, jobs: int, tell: Callable[[tuple[int, float]], None]) -> None:
        from loky.backend import resource_tracker as loky_tracker

        # A process inherits a signal mask from its thread: Ctrl-C and the end of a terminal do
        # not end it. The trackers reset it in the thread that starts them, so start them here.
        with _safe_path():
            resource_tracker.ensure_running()
            loky_tracker.ensure_running()
        self._tell, self._changing, self._is_open = tell, threading.Lock(), True
        self._begun: dict[int, tuple[Any, Connection, Connection]] = {}
        self._threads = ThreadPoolExecutor(
            jobs,
            initializer=signal.pthread_sigmask,
            initargs=(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP}),
        )

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Return the future of a call in the next process that is free."""
        return self._threads.submit(self._in_process, partial(fn, *args, **kwargs))

    def close(self) -> None:
        """End all processes and drop their runs."""
        with self._changing:
            self._is_open = False
            for process, *_ in list(self._begun.values()):
                process.terminate()
        self._threads.shutdown(cancel_futures=True)
        for thread in list(self._begun):
            self._end(thread)

    def _in_process(self, call: Callable[[], Any]) -> Any:
        from loky.backend.reduction import dumps

        message, sent = None, dumps(call)
        for _ in range(MOST_DEATHS):
            _, to_process, from_process = self._process()
            try:
                to_process.send_bytes(sent)
                while not isinstance(message, Ended):
                    if message is not None:
                        self._tell(message)
                    message = from_process.recv()
            except (EOFError, OSError):  # it died
                self._end(threading.get_ident())
                continue
            if message.error is not None:
                raise message.error
            return message.result
        raise WorkerError(*_DIED)

    def _process(self) -> tuple[Any, Connection, Connection]:
        from loky.backend.process import LokyProcess

        with self._changing:
            if not self._is_open:
                raise CancelledError
            if threading.get_ident() in self._begun:
                return self._begun[threading.get_ident()]
            try:
                (calls, to_process), (from_process, answers) = (Pipe(duplex=False) for _ in '12')
                args = calls, answers, os.getpid()
                process = LokyProcess(target=_serve, args=args, daemon=True, env=_SAFE_PATH)
                process.start()
            except OSError as error:
                raise WorkerError(
                    f'no process can be started ({error}). Use fewer at once (',
                    Argument('jobs', 1),
                    ')',
                ) from None
            calls.close()
            answers.close()
            begun = self._begun[threading.get_ident()] = process, to_process, from_process
            return begun

    def _end(self, thread: int) -> None:
        process, *pipes = self._begun.pop(thread)
        process.join()
        for pipe in pipes:
            pipe.close()


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


def _serve(calls: Connection, answers: Connection, parent: int) -> None:
    """Make the calls of `_Processes` until the pipe closes. Linux ends this with its parent."""
    from loky.backend.reduction import dumps
    from loky.process_executor import _ExceptionWithTraceback

    prctl = getattr(ctypes.CDLL(None), 'prctl', None)
    if prctl is not None:
        prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG
    if os.getppid() != parent:
        return

    def send(message: tuple[int, float] | Ended[Any]) -> None:
        answer = dumps(message)
        try:
            answers.send_bytes(answer)
        except OSError:  # the parent was killed: the result is not needed
            os._exit(1)

    global _to_parent  # noqa: PLW0603 - `_run` is called by name in every kind of process
    _to_parent = send
    with suppress(EOFError):
        while True:
            sent = calls.recv_bytes()
            try:
                send(Ended(0, pickle.loads(sent)()))
            except Exception as error:
                send(Ended(0, None, _ExceptionWithTraceback(error)))


class _Attention:
    """Asks a silent scheduler for a reply: a run must not wait for ever."""

    def __init__(self, client: Client, address: str) -> None:
        self._client, self._address = client, address
        self._said = ''
        self._ready: set[Any] = set()
        self.lost = False

    def ask(self, count: int) -> None:
        """Warn once that runs wait for workers, or that the scheduler is silent."""
        scheduler, text = self._client.scheduler, ''
        # A result that breaks off in transit would let its future wait for ever.
        states = list(self._client.futures.items())
        ready = {key for key, state in states if state.status == 'finished'}
        if ready & self._ready:
            raise self.gone('results do not arrive')
        self._ready = ready
        try:
            if scheduler is None:
                raise self.gone('closed')
            if not self._client.sync(scheduler.ncores, callback_timeout=REACHED_WITHIN_S):
                text = (
                    f'there is no worker process for {counted(count, "run")}. Start some '
                    f'(dask worker {scheduler.address} --nthreads 1), or stop with Ctrl-C'
                )
        except TimeoutError:
            text = (
                f'the scheduler has not answered for {REACHED_WITHIN_S:g} s. See its own log, or '
                'stop with Ctrl-C'
            )
        except OSError as error:
            raise self.gone(str(error)) from None
        if text and text != self._said:
            warnings.warn(text, TautoWarning, stacklevel=2)
        self._said = text

    def gone(self, why: str) -> WorkerError:
        """Return the error for a lost scheduler."""
        self.lost = True
        return WorkerError(f'the scheduler is lost ({why}). See its own log; start it again')

    def meaning(self, error: Exception) -> Exception:
        """Return the cause of a failed future. WorkerError if the scheduler is lost."""
        from distributed.scheduler import KilledWorker

        if isinstance(error, CancelledError):
            raise self.gone('it let go of the runs') from None
        if isinstance(error, KilledWorker):
            return WorkerError(*_DIED)
        if isinstance(error, WorkerError):
            raise error
        _check_alike(self._client, self._address)  # other code fails in other ways
        return error

    def leave(self, pool: Executor) -> None:
        """Drop the runs that have not begun."""
        self._client.unsubscribe_topic(_TOPIC)
        if not self.lost:  # otherwise it would wait for a reply
            pool.shutdown(wait=False)


@contextmanager
def _joined(address: str) -> Iterator[Client]:
    try:
        import distributed
        from distributed.utils import silence_logging_cmgr
    except ImportError:
        raise UsageError(
            Argument('scheduler', address),
            ': needs distributed, which is not installed. Run ',
            f'{install("cluster")}, or leave out ',
            Argument('scheduler'),
        ) from None
    if address.startswith('tls://'):
        try:
            keys = distributed.Security().get_connection_args('client')
        except OSError as error:  # of a file that it names
            raise UsageError(
                Argument('scheduler', address),
                f': its certificates cannot be read ({error}). See docs/fleets.md',
            ) from None
        if keys.get('ssl_context') is None:
            raise UsageError(
                Argument('scheduler', address),
                ': no certificate is named for it. Set distributed.comm.tls in dask (or '
                'DASK_DISTRIBUTED__COMM__TLS__CA_FILE and so on, see docs/fleets.md)',
            )
    else:
        open_to_all = ArgumentText(
            Argument('scheduler', address),
            ': without TLS, whoever reaches it can run code on its workers and on this machine, '
            'its other users too. Use tls:// (docs/fleets.md), unless all who can are trusted',
        )
        warnings.warn(open_to_all, TautoWarning, stacklevel=2)
    began = time.monotonic()
    quiet = silence_logging_cmgr(logging.CRITICAL)  # we report a lost scheduler ourselves
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
    """Return the versions on which results may depend, for this package a hash of its code."""
    return {
        'python': platform.python_version(),
        'tauto_core': identity(),
        **{name: version(name) for name in _ALIKE},
    }


def _check_alike(client: Client, address: str) -> None:
    """Refuse workers with other versions, which could give other bits, or without tauto_core."""
    ours = versions()
    for worker, theirs in client.run(versions, on_error='return').items():
        if not isinstance(theirs, dict):
            raise WorkerError(
                Argument('scheduler', address),
                f': worker {worker} cannot run tauto_core ({theirs}). Install tauto_core '
                f'{ours["tauto_core"]} there',
            )
        if theirs != ours:
            raise WorkerError(Argument('scheduler', address), f': {_unlike(worker, ours, theirs)}')


def _unlike(worker: str, ours: Mapping[str, str], theirs: Mapping[str, str]) -> str:
    unlike = ', '.join(
        f'{name} {theirs.get(name)} against {mine}'
        for name, mine in ours.items()
        if theirs.get(name) != mine
    )
    return (
        f'worker {worker} has other versions than this machine: {unlike}. Install the same on both'
    )
