"""Runs on several processes: the same as in one, also when a process dies."""

import os
import signal
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

PIPES = {'capture_output': True, 'text': True}


def ports(*pids):
    return {each.laddr for each in psutil.net_connections('inet') if each.pid in pids}


def work(folder, what, tell):
    """Return a text, the process, whether it hears a terminal's Ctrl-C, and its open ports.

    `dies` kills its process as often as `folder` has files to spend.
    """
    tell(0.5)
    if what == 'fails':
        raise EstimationError('it fails')
    for file in Path(folder).iterdir() if what == 'dies' else ():
        file.unlink()
        os.kill(os.getpid(), signal.SIGKILL)
    hears = signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])
    return what, os.getpid(), hears, ports(os.getppid(), os.getpid())


def ended(folder, items, jobs, progress=None):
    runs = run_each(partial(work, str(folder)), items, jobs, progress)
    return {items[run.place]: run for run in runs}


def test_processes_return_what_this_one_does(tmp_path):
    """Also if one dies. A run that fails ends no other. No process can be reached."""
    items, shares = ['one', 'fails', 'two', 'dies', 'three'], list[float]()
    alone = ended(tmp_path, items, 1)
    (tmp_path / 'once').touch()
    beside = ended(tmp_path, items, 2, shares.append)
    assert not list(tmp_path.iterdir())
    assert alone.keys() == beside.keys() == set(items)
    for runs in (alone, beside):
        assert isinstance(runs['fails'].error, EstimationError)
        assert str(runs.pop('fails').error) == 'it fails'
        assert [runs[item].error for item in runs] == [None] * 4
        assert all(runs[item].result[0] == item for item in runs)
    assert {run.result[1:3] for run in alone.values()} == {(os.getpid(), True)}
    assert os.getpid() not in {run.result[1] for run in beside.values()}
    assert not any(run.result[2] for run in beside.values())
    assert all(run.result[3] == ports(os.getpid()) for run in beside.values())
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_a_run_that_kills_every_process_is_given_up(tmp_path, monkeypatch):
    monkeypatch.setattr(workers, 'MOST_DEATHS', 2)
    for k in range(20):
        (tmp_path / str(k)).touch()
    runs = ended(tmp_path, ['one', 'dies'], 2)
    assert runs['one'].result[0] == 'one'
    assert isinstance(runs['dies'].error, WorkerError)
    assert len(list(tmp_path.iterdir())) == 18


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
    command = [sys.executable, script]
    done = subprocess.run(command, cwd=tmp_path, check=False, timeout=300, **PIPES)
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


def test_processes_end_with_their_parent():
    with subprocess.Popen(
        [sys.executable, '-c', LONG], stdout=subprocess.PIPE, text=True
    ) as parent:
        pids = [int(parent.stdout.readline()) for _ in range(2)]
        parent.kill()
        parent.wait()
        # they have the other end of the pipe
        assert parent.stdout.read() == ''
    deadline_s = time.monotonic() + 60.0
    while any(psutil.pid_exists(pid) and psutil.Process(pid).status() != 'zombie' for pid in pids):
        assert time.monotonic() < deadline_s
        time.sleep(0.05)


def test_closing_ends_the_processes(tmp_path):
    runs = run_each(partial(work, str(tmp_path)), list('abcdef'), 2)
    pid = next(runs).result[1]
    runs.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


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


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGHUP])
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
    command, options = [sys.executable, '-c', script], {**PIPES, 'start_new_session': True}
    done = subprocess.run(command, check=False, timeout=300, **options)
    said = 'KeyboardInterrupt' if number == signal.SIGINT else 'Terminated'
    assert (done.returncode, done.stdout, done.stderr) == (0, f'{said}\n', '')


@pytest.mark.parametrize(
    ('work', 'runs', 'jobs', 'used'),
    [(0.5, 4, 2, 1), (0.7, 3, 2, 2), (0.33, 4, 4, 1), (0.36, 4, 4, 4), (0.72, 2, 4, 1)],
)
def test_work_that_is_small_is_done_in_this_process(work, runs, jobs, used):
    """Work in starts of a process. Two runs leave two of four processes idle."""
    assert jobs_for([work * workers.POOL_START_S] * runs, jobs) == used
    assert jobs_for([99.0], 1) == 1
