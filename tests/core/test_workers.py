"""Runs on several processes: the same as in one, and none is lost when a process dies."""

import os
import signal
import socket
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest

from tauto_core import workers
from tauto_core.scene.errors import EstimationError, TautoWarning, UsageError
from tauto_core.workers import Crew, Ended, WorkerError, _Attention, _ended, run_each

# On a machine with much else to do, processes that were killed are not soon there again.
WAITS = pytest.mark.filterwarnings('ignore:no worker process is left')


def half(number, tell):
    tell(0.5)
    return number / 2, os.getpid()


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
    alone = results(run_each(half, [4, 5, 6], Crew(1)))
    shares: list[float] = []
    beside = results(run_each(half, [4, 5, 6], Crew(2), shares.append))
    assert [alone[k][0] for k in range(3)] == [2.0, 2.5, 3.0]
    assert {k: found[0] for k, found in beside.items()} == {
        k: found[0] for k, found in alone.items()
    }
    assert {pid for _, pid in alone.values()} == {os.getpid()}
    assert os.getpid() not in {pid for _, pid in beside.values()}
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_a_script_without_a_guard_is_not_run_again_by_its_processes(tmp_path):
    script = tmp_path / 'script.py'
    script.write_text(
        'from tauto_core.workers import Crew, run_each\n'
        "print('begins')\n"
        'ended = run_each(lambda number, tell: number / 2, [1.0, 2.0], Crew(2))\n'
        'print(sorted(each.result for each in ended))\n'
    )
    done = subprocess.run(
        [sys.executable, script], check=False, capture_output=True, text=True, timeout=100
    )
    assert (done.returncode, done.stdout) == (0, 'begins\n[0.5, 1.0]\n'), done.stderr


@pytest.mark.parametrize('jobs', [1, 2])
def test_a_run_that_fails_is_told_and_ends_no_other(jobs):
    ended = {each.place: each for each in run_each(odd_only, [1, 2, 3], Crew(jobs))}
    assert (ended[0].result, ended[2].result) == (1, 3)
    assert isinstance(ended[1].error, EstimationError)
    assert str(ended[1].error) == '2 is even'


@WAITS
def test_a_run_whose_process_is_killed_is_made_again(tmp_path):
    (tmp_path / 'once').touch()
    found = results(run_each(partial(dies, str(tmp_path)), [0, 1, 2, 3], Crew(2)))
    assert found == {0: 0, 1: 1, 2: 2, 3: 3}
    assert not list(tmp_path.iterdir())


@WAITS
def test_a_run_that_kills_every_process_is_given_up(tmp_path):
    for k in range(20):
        (tmp_path / str(k)).touch()
    ended = {each.place: each for each in run_each(partial(dies, str(tmp_path)), [0, 1], Crew(2))}
    assert ended[0].result == 0
    assert isinstance(ended[1].error, WorkerError)
    assert 'died' in str(ended[1].error)


def test_leaving_early_leaves_no_process_behind():
    runs = run_each(half, list(range(50)), Crew(2))
    pid = next(runs).result[1]
    runs.close()
    deadline = time.monotonic() + 20.0
    while time.monotonic() < deadline:
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return
        time.sleep(0.05)
    pytest.fail(f'process {pid} still runs')


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_while_processes_start_ends_without_a_traceback(number):
    """A terminal sends Ctrl-C to all processes of a command, here at the start of the first."""
    script = (
        'import os, signal\n'
        'from distributed import Nanny\n'
        'from tauto_core.cli.terminal import ended_by_sigterm\n'
        'from tauto_core.workers import Crew, run_each\n'
        'start = Nanny.start_unsafe\n'
        'async def interrupted(self):\n'
        '    Nanny.start_unsafe = start\n'
        f'    os.{"killpg(0" if number == signal.SIGINT else "kill(os.getpid()"}, {int(number)})\n'
        '    return await start(self)\n'
        'Nanny.start_unsafe = interrupted\n'
        'signal.signal(signal.SIGINT, signal.default_int_handler)\n'
        'try:\n'
        '    with ended_by_sigterm():\n'
        '        list(run_each(lambda number, tell: number, [1, 2], Crew(2)))\n'
        'except KeyboardInterrupt as error:\n'
        '    print(type(error).__name__)\n'
    )
    done = subprocess.run(
        [sys.executable, '-c', script],
        check=False,
        capture_output=True,
        text=True,
        timeout=100,
        start_new_session=True,
    )
    said = 'KeyboardInterrupt' if number == signal.SIGINT else 'Terminated'
    assert (done.returncode, done.stdout, done.stderr) == (0, f'{said}\n', '')


def test_processes_do_not_see_the_interrupt_of_a_terminal():
    script = (
        'import signal\n'
        'from tauto_core.workers import Crew, run_each\n'
        'def blocked(number, tell):\n'
        '    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])\n'
        'print({each.result for each in run_each(blocked, list(range(4)), Crew(2))})\n'
    )
    done = subprocess.run(
        [sys.executable, '-c', script], check=False, capture_output=True, text=True, timeout=100
    )
    assert (done.stdout, done.stderr) == ('{True}\n', '')


def test_no_process_at_all_is_refused():
    with pytest.raises(UsageError, match='jobs=0: must be at least 1'):
        Crew(0)


def test_a_scheduler_that_is_not_there_is_named(monkeypatch):
    monkeypatch.setattr(workers, 'REACHED_WITHIN_S', 1.0)
    with socket.socket() as taken:
        taken.bind(('127.0.0.1', 0))  # bound and not listening: nobody answers
        address = f'tcp://127.0.0.1:{taken.getsockname()[1]}'
        with pytest.raises(WorkerError) as caught:
            next(run_each(half, [1], Crew(2, address)))
    assert address in str(caught.value)
    assert 'after 1' in str(caught.value)
    assert 'leave out scheduler=' in str(caught.value)


class Scheduler:
    """What a client knows of a scheduler that answers in a given way."""

    scheduler = SimpleNamespace(ncores=None, address='tcp://ship:8786')

    def __init__(self, answer, cluster=None):
        self.answer, self.cluster = answer, cluster

    def sync(self, _asked, callback_timeout):
        assert callback_timeout == workers.REACHED_WITHIN_S
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


@pytest.mark.parametrize(
    ('client', 'said'),
    [
        (Scheduler({}), r'no worker process is left for 3 runs. Start .*dask worker tcp://ship:8'),
        (Scheduler({}, 'here'), 'no worker process is left for 3 runs. They are being started'),
        (Scheduler(TimeoutError()), 'the scheduler has not answered for 10 s'),
    ],
)
def test_nobody_is_waited_for_without_a_word(client, said):
    attention = _Attention(client)
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


@pytest.mark.parametrize('broken', [TimeoutError(), OSError('Connection reset by peer')])
def test_a_result_that_does_not_arrive_is_no_failure_of_its_run(broken):
    """A worker that is killed between its run and the fetching of the result breaks the way."""
    answers = [broken, broken, 'result']

    def result(timeout):
        assert timeout == workers.ASK_S
        answer = answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    future = SimpleNamespace(result=result, status='finished')
    attention = _Attention(Scheduler({'tcp://worker:1': 1}))
    assert _ended(7, future, attention) == Ended(7, 'result')
    answers, future.status = [broken], 'error'
    assert _ended(7, future, attention) == Ended(7, None, broken)
    answers, future.status = [broken], 'finished'
    attention = _Attention(Scheduler(OSError('Connection refused')))
    with pytest.raises(WorkerError, match='the scheduler is lost'):
        _ended(7, future, attention)
