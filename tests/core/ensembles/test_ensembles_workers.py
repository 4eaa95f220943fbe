"""Runs on several processes: the same as in one, also when a process dies."""

import os
import signal
import socket
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import psutil
import pytest

from tauto_core.cli.terminal import Terminated, ended_by_sigterm
from tauto_core.ensembles import workers
from tauto_core.ensembles.workers import WorkerError, jobs_for, run_each
from tauto_core.scene.errors import EstimationError


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
    alone = results(run_each(half, [4, 5, 6], 1))
    shares: list[float] = []
    beside = results(run_each(half, [4, 5, 6], 2, shares.append))
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
        'from tauto_core.ensembles.workers import run_each\n'
        "print('begins')\n"
        'ended = run_each(lambda number, tell: number / 2, [1.0, 2.0], 2)\n'
        'print(sorted(each.result for each in ended))\n'
    )
    command, pipes = [sys.executable, script], {'capture_output': True, 'text': True}
    done = subprocess.run(command, cwd=tmp_path, check=False, timeout=300, **pipes)
    assert (done.returncode, done.stdout) == (0, 'begins\n[0.5, 1.0]\n'), done.stderr
    assert not (tmp_path / 'hit').exists()


LONG = """
import os, time
from tauto_core.cli.terminal import Terminated, ended_by_sigterm
from tauto_core.ensembles.workers import run_each
def long(number, tell):
    print(os.getpid(), flush=True)
    time.sleep(3600.0)
list(run_each(long, [1, 2], 2))
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


def test_closing_ends_the_processes():
    runs = run_each(half, list(range(50)), 2)
    pid = next(runs).result[1]
    runs.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.parametrize('jobs', [1, 2])
def test_a_run_that_fails_is_told_and_ends_no_other(jobs):
    ended = {each.place: each for each in run_each(odd_only, [1, 2, 3], jobs)}
    assert (ended[0].result, ended[2].result) == (1, 3)
    assert isinstance(ended[1].error, EstimationError)
    assert str(ended[1].error) == '2 is even'


def test_a_run_whose_process_is_killed_is_made_again(tmp_path):
    (tmp_path / 'once').touch()
    found = results(run_each(partial(dies, str(tmp_path)), [0, 1, 2, 3], 2))
    assert found == {0: 0, 1: 1, 2: 2, 3: 3}
    assert not list(tmp_path.iterdir())


def test_a_run_that_kills_every_process_is_given_up(tmp_path):
    for k in range(20):
        (tmp_path / str(k)).touch()
    ended = {each.place: each for each in run_each(partial(dies, str(tmp_path)), [0, 1], 2)}
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
        'from tauto_core.ensembles.workers import run_each\n'
        'start = LokyProcess.start\n'
        'def interrupted(self):\n'
        '    LokyProcess.start = start\n'
        f'    os.{"killpg(0" if number == signal.SIGINT else "kill(os.getpid()"}, {int(number)})\n'
        '    return start(self)\n'
        'LokyProcess.start = interrupted\n'
        'signal.signal(signal.SIGINT, signal.default_int_handler)\n'
        'try:\n'
        '    with ended_by_sigterm():\n'
        '        list(run_each(lambda number, tell: number, [1, 2], 2))\n'
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
    """Return the sockets of a process and of those that it has started."""
    del number, tell
    family = [psutil.Process(top), *psutil.Process(top).children(recursive=True)]
    pids = {one.pid for one in family}
    return {each[1:6] for each in psutil.net_connections('inet') if each.pid in pids}


def test_processes_of_this_machine_open_no_socket():
    """They are unreachable: they get their work through pipes of their parent."""
    before = sockets(os.getpid())
    seen = results(run_each(partial(sockets, os.getpid()), [0, 1], 2))
    assert seen == {0: before, 1: before}
    with socket.socket() as own:  # it is seen if there is one
        own.bind(('127.0.0.1', 0))
        own.listen()
        assert len(sockets(os.getpid()) - before) == 1


def test_work_that_is_small_is_done_in_this_process():
    start_s = workers.POOL_START_S
    assert jobs_for([0.5 * start_s] * 4, 2) == 1
    assert jobs_for([0.7 * start_s] * 3, 2) == 2
    assert jobs_for([0.33 * start_s] * 4, 4) == 1
    assert jobs_for([0.36 * start_s] * 4, 4) == 4
    assert jobs_for([0.72 * start_s] * 2, 4) == 1  # the others would be idle
    assert jobs_for([99.0 * start_s], 1) == 1
