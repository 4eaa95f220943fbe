"""Runs on several processes: the same as in one, also when a process dies."""

import os
import signal
import socket
import subprocess
import sys
import time
from concurrent.futures import CancelledError
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import dask
import psutil
import pytest
from distributed.scheduler import KilledWorker

from tauto_core.cli.terminal import Terminated, ended_by_sigterm
from tauto_core.ensembles import workers
from tauto_core.ensembles.workers import WorkerError, WorkerPool, _Attention, run_each
from tauto_core.scene.errors import EstimationError, TautoWarning, UsageError


def half(number, tell):
    """Return half of a number, the process, and whether it hears a terminal's Ctrl-C."""
    tell(0.5)
    return (
        number / 2,
        os.getpid(),
        signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, []),
    )


def odd_only(number, tell):
    del tell
    if number % 2 == 0:
        raise EstimationError(f'{number} is even')
    return number


def dies(folder, number, tell):
    """Kill the process that runs number 1, as often as `folder` has files to spend."""
    del tell
    if number == 1:
        for file in Path(folder).iterdir():
            file.unlink()
            os.kill(os.getpid(), signal.SIGKILL)
    return number


def results(runs):
    ended = list(runs)
    assert [each.error for each in ended] == [None] * len(ended)
    return {each.place: each.result for each in ended}


def test_processes_return_what_this_one_does():
    alone = results(run_each(half, [4, 5, 6], WorkerPool(1)))
    shares: list[float] = []
    beside = results(run_each(half, [4, 5, 6], WorkerPool(2), shares.append))
    assert [alone[k][0] for k in range(3)] == [beside[k][0] for k in range(3)] == [2.0, 2.5, 3.0]
    assert {found[1:] for found in alone.values()} == {(os.getpid(), True)}
    assert os.getpid() not in {found[1] for found in beside.values()}
    assert not any(found[2] for found in beside.values())
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_a_script_without_a_guard_runs_once(tmp_path):
    """Nor is a module in the working folder, by them and by the trackers of their resources."""
    for name in ('json', 'loky', 'multiprocessing', 'struct', 'threading'):
        (tmp_path / f'{name}.py').write_text(f'open({str(tmp_path / "hit")!r}, "x")')
    script = tmp_path / 'scripts' / 'script.py'
    script.parent.mkdir()
    script.write_text(
        'from tauto_core.ensembles.workers import WorkerPool, run_each\n'
        "print('begins')\n"
        'ended = run_each(lambda number, tell: number / 2, [1.0, 2.0], WorkerPool(2))\n'
        'print(sorted(each.result for each in ended))\n'
    )
    command, pipes = [sys.executable, script], {'capture_output': True, 'text': True}
    done = subprocess.run(command, cwd=tmp_path, check=False, timeout=300, **pipes)
    assert (done.returncode, done.stdout) == (0, 'begins\n[0.5, 1.0]\n'), done.stderr
    assert not (tmp_path / 'hit').exists()


LONG = """
import os, time
from tauto_core.cli.terminal import Terminated, ended_by_sigterm
from tauto_core.ensembles.workers import WorkerPool, run_each
def long(number, tell):
    print(os.getpid(), flush=True)
    time.sleep(3600.0)
list(run_each(long, [1, 2], WorkerPool(2)))
"""


@pytest.mark.parametrize('number', [signal.SIGKILL, signal.SIGHUP])
def test_processes_end_with_their_parent(number):
    with subprocess.Popen(
        [sys.executable, '-c', LONG], stdout=subprocess.PIPE, text=True
    ) as parent:
        pids = [int(parent.stdout.readline()) for _ in range(2)]
        parent.send_signal(number)
        parent.wait()
        # they have the other end of the pipe
        assert parent.stdout.read() == ''
    deadline_s = time.monotonic() + 60.0
    while any(psutil.pid_exists(pid) and psutil.Process(pid).status() != 'zombie' for pid in pids):
        assert time.monotonic() < deadline_s
        time.sleep(0.05)


def test_few_runs_are_submitted_ahead_and_closing_ends_them(monkeypatch):
    monkeypatch.setattr(workers, 'AHEAD', 3)
    handed, submit = [], workers._Processes.submit

    def counted(self, *arguments):
        handed.append(arguments)
        return submit(self, *arguments)

    monkeypatch.setattr(workers._Processes, 'submit', counted)
    runs = run_each(half, list(range(50)), WorkerPool(2))
    for seen in range(1, 6):
        pid = next(runs).result[1]
        assert len(handed) - seen <= 3
    runs.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.parametrize('jobs', [1, 2])
def test_a_run_that_fails_is_told_and_ends_no_other(jobs):
    ended = {each.place: each for each in run_each(odd_only, [1, 2, 3], WorkerPool(jobs))}
    assert (ended[0].result, ended[2].result) == (1, 3)
    assert isinstance(ended[1].error, EstimationError)
    assert str(ended[1].error) == '2 is even'


def test_a_run_whose_process_is_killed_is_made_again(tmp_path):
    (tmp_path / 'once').touch()
    found = results(run_each(partial(dies, str(tmp_path)), [0, 1, 2, 3], WorkerPool(2)))
    assert found == {0: 0, 1: 1, 2: 2, 3: 3}
    assert not list(tmp_path.iterdir())


def test_a_run_that_kills_every_process_is_given_up(tmp_path):
    for k in range(20):
        (tmp_path / str(k)).touch()
    ended = {
        each.place: each for each in run_each(partial(dies, str(tmp_path)), [0, 1], WorkerPool(2))
    }
    assert ended[0].result == 0
    assert isinstance(ended[1].error, WorkerError)
    assert 'died' in str(ended[1].error)


def test_a_second_signal_does_not_interrupt_the_first():
    def run(number, closed):
        try:
            signal.raise_signal(number)
        finally:
            signal.raise_signal(signal.SIGTERM)
            signal.raise_signal(signal.SIGHUP)
            closed.append(number)

    for number in (signal.SIGTERM, signal.SIGHUP):
        closed: list[int] = []
        with pytest.raises(Terminated) as caught, ended_by_sigterm():
            run(number, closed)
        assert closed == [caught.value.args[0]] == [number]


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupt_at_the_start_has_no_traceback(number):
    """A terminal sends Ctrl-C to all processes of a command, here at the start of the first."""
    script = (
        'import os, signal\n'
        'from loky.backend.process import LokyProcess\n'
        'from tauto_core.cli.terminal import ended_by_sigterm\n'
        'from tauto_core.ensembles.workers import WorkerPool, run_each\n'
        'start = LokyProcess.start\n'
        'def interrupted(self):\n'
        '    LokyProcess.start = start\n'
        f'    os.{"killpg(0" if number == signal.SIGINT else "kill(os.getpid()"}, {int(number)})\n'
        '    return start(self)\n'
        'LokyProcess.start = interrupted\n'
        'signal.signal(signal.SIGINT, signal.default_int_handler)\n'
        'try:\n'
        '    with ended_by_sigterm():\n'
        '        list(run_each(lambda number, tell: number, [1, 2], WorkerPool(2)))\n'
        'except KeyboardInterrupt as error:\n'
        '    print(type(error).__name__)\n'
    )
    done = subprocess.run(
        [sys.executable, '-c', script],
        check=False,
        capture_output=True,
        text=True,
        timeout=300,
        start_new_session=True,
    )
    said = 'KeyboardInterrupt' if number == signal.SIGINT else 'Terminated'
    assert (done.returncode, done.stdout, done.stderr) == (0, f'{said}\n', '')


def sockets(top, number=0, tell=None):
    """Return the sockets of a process and of those that it has started, of any family."""
    del number, tell
    family = [psutil.Process(top), *psutil.Process(top).children(recursive=True)]
    pids = {one.pid for one in family}
    return {each[1:6] for each in psutil.net_connections('all') if each.pid in pids}


def test_processes_of_this_machine_open_no_socket():
    """They are unreachable: they get their work through pipes of their parent."""
    before = sockets(os.getpid())
    seen = results(run_each(partial(sockets, os.getpid()), [0, 1], WorkerPool(2)))
    assert seen == {0: before, 1: before}
    with socket.socket() as own:  # it is seen if there is one
        own.bind(('127.0.0.1', 0))
        own.listen()
        assert len(sockets(os.getpid()) - before) == 1


def test_no_process_at_all_is_refused():
    with pytest.raises(UsageError, match='jobs=0: must be at least 1'):
        WorkerPool(0)


def test_a_scheduler_that_is_not_there_is_named(monkeypatch):
    monkeypatch.setattr(workers, 'REACHED_WITHIN_S', 1.0)
    with socket.socket() as taken:
        taken.bind(('127.0.0.1', 0))  # bound and not listening: no answer
        address = f'tcp://127.0.0.1:{taken.getsockname()[1]}'
        with (
            pytest.warns(TautoWarning, match='without TLS, whoever reaches it can run code'),
            pytest.raises(WorkerError) as caught,
        ):
            next(run_each(half, [1], WorkerPool(2, address)))
    assert address in str(caught.value)
    assert 'after 1' in str(caught.value)
    assert 'leave out scheduler=' in str(caught.value)


class Scheduler:
    """A scheduler that answers in a given way."""

    scheduler = SimpleNamespace(ncores=None, address='tcp://ship:8786')

    def __init__(self, answer):
        self.answer, self.futures = answer, {}

    def run(self, _asked, on_error):
        assert on_error == 'return'
        return {}

    def sync(self, _asked, callback_timeout):
        assert callback_timeout == workers.REACHED_WITHIN_S
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


@pytest.mark.parametrize(
    ('client', 'said'),
    [
        (Scheduler({}), r'no worker process for 3 runs. Start .*dask worker tcp://ship:8'),
        (Scheduler(TimeoutError()), 'the scheduler has not answered for 10 s'),
    ],
)
def test_nobody_is_waited_for_without_a_word(client, said):
    attention = _Attention(client, 'tcp://ship:8786')
    with pytest.warns(TautoWarning, match=said):
        attention.ask(3)
    attention.ask(3)  # once said is enough: a warning would be an error here
    client.answer = {'tcp://worker:1': 1}
    attention.ask(3)
    client.answer = {}
    with pytest.warns(TautoWarning, match='no worker'):
        attention.ask(3)
    client.answer = OSError('Stream is closed')
    with pytest.raises(WorkerError, match=r'the scheduler is lost .Stream is closed'):
        attention.ask(3)
    assert attention.lost


def test_a_result_that_does_not_arrive_is_not_waited_for_in_vain():
    client = Scheduler({'tcp://worker:1': 1})
    client.futures = {'a': SimpleNamespace(status='pending')}
    attention = _Attention(client, 'tcp://ship:8786')
    attention.ask(2)
    client.futures = {key: SimpleNamespace(status='finished') for key in 'ab'}
    attention.ask(2)
    client.futures = {'c': SimpleNamespace(status='finished')}  # the others have come
    attention.ask(1)
    with pytest.raises(WorkerError, match=r'the scheduler is lost .results do not arrive'):
        attention.ask(1)
    assert attention.lost


def test_what_a_scheduler_says_of_a_run():
    attention = _Attention(Scheduler({}), 'tcp://ship:8786')
    own = OSError('Connection reset by peer')
    assert attention.meaning(own) is own
    died = attention.meaning(KilledWorker('run', None, {}))
    assert isinstance(died, WorkerError)
    assert 'died four times' in str(died)
    assert not attention.lost
    with pytest.raises(WorkerError, match='the scheduler is lost'):
        attention.meaning(CancelledError())
    assert attention.lost


def test_a_scheduler_by_tls_needs_certificates(tmp_path):
    with pytest.raises(UsageError, match='no certificate is named for it'):
        next(run_each(half, [1], WorkerPool(2, 'tls://ship:8786')))
    tls = {key: str(tmp_path / 'none.pem') for key in ('ca-file', 'client.cert', 'client.key')}
    with (
        dask.config.set({f'distributed.comm.tls.{key}': file for key, file in tls.items()}),
        pytest.raises(UsageError, match=r'certificates cannot be read .*No such file'),
    ):
        next(run_each(half, [1], WorkerPool(2, 'tls://ship:8786')))


def test_a_scheduler_needs_an_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, 'distributed', None)
    with pytest.raises(UsageError, match=r"Run pip install 'tauto_core\[cluster\]'"):
        next(run_each(half, [1], WorkerPool(2, 'tcp://ship:8786')))


def test_work_that_is_small_is_done_in_this_process():
    start_s = workers.POOL_START_S
    assert WorkerPool(2).for_work([0.5 * start_s] * 4) == WorkerPool(1)
    assert WorkerPool(2).for_work([0.7 * start_s] * 3) == WorkerPool(2)
    assert WorkerPool(4).for_work([0.33 * start_s] * 4) == WorkerPool(1)
    assert WorkerPool(4).for_work([0.36 * start_s] * 4) == WorkerPool(4)
    assert WorkerPool(4).for_work([0.72 * start_s] * 2) == WorkerPool(
        1
    )  # the others would be idle
    assert WorkerPool(1).for_work([99.0 * start_s]) == WorkerPool(1)
    assert WorkerPool(2, 'tcp://ship:8786').for_work([0.0]).scheduler is not None
