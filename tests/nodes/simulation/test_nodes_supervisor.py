"""The supervisor reads the output of the nodes."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tauto_nodes.simulation import supervisor as graph
from tauto_nodes.simulation.supervisor import Child, Supervisor

WORDS = """\
[INFO] [1795404890.263812763] [recorder]: scene: received 1, written 1, lost 0
[WARN] [1795404890.264281814] [trochlea]: the thread is slack
\x1b[37;1m2026-11-23 03:55:04.307 \x1b[31;1m[XMLPARSER Error] \x1b[37mno such element\x1b[m
[WARN] [1795404999.000000001] [trochlea]: the thread is slack
[ERROR] [1795404999.1] [longitude]: no fix
"""


def test_warnings_are_printed_once_without_time_and_colour(tmp_path: Path) -> None:
    children = []
    for name in ('recorder', 'trochlea'):
        log = tmp_path / f'{name}.log'
        log.write_text(WORDS)
        ended = subprocess.Popen([sys.executable, '-c', ''])
        ended.wait()
        children.append(Child(name, ended, log))
    supervisor = Supervisor(tmp_path, {}, children)
    assert supervisor.node_warnings() == (
        '[WARN] [trochlea]: the thread is slack',
        '[XMLPARSER Error] no such element',
        '[ERROR] [longitude]: no fix',
    )
    assert '\x1b' not in children[0].said()


# Actions of a node after SIGTERM, for twice the allowed standstill, and at its end.
ENDINGS = {
    'writes': ('time.sleep(0.05); note("x")', False),
    'waits for its turn': ('run(0.02); time.sleep(0.1)', False),
    'stands': ('time.sleep(0.05)', True),
    'runs in a circle': ('run(0.05)', True),
}


@pytest.mark.parametrize('name', ENDINGS)
def test_a_node_that_gets_on_with_its_end_is_not_killed(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(graph, 'TERM_S', 1.0)
    does, is_killed = ENDINGS[name]
    code = f"""
import signal, threading, time
def note(word):
    with open({str(tmp_path / 'wrote')!r}, 'a') as file:
        file.write(word)
def run(for_s):
    since_s = time.thread_time()
    while time.thread_time() < since_s + for_s:
        pass
came = []
signal.signal(signal.SIGTERM, lambda *_: came.append(1))
threading.Thread(target=lambda: [time.sleep(0.02) for _ in iter(int, 1)], daemon=True).start()
print('ready', flush=True)
while not came:
    time.sleep(0.01)
end_s = time.monotonic() + 2.0
while time.monotonic() < end_s or {is_killed}:
    {does}
"""
    process = subprocess.Popen(
        [sys.executable, '-c', code], stdout=subprocess.PIPE, start_new_session=True
    )
    assert process.stdout is not None
    process.stdout.readline()
    child = Child(name, process, tmp_path / 'log')
    killed = Supervisor(tmp_path, {}, [child]).stop()
    process.stdout.close()
    assert killed == ([child] if is_killed else [])
    assert process.returncode == (-signal.SIGABRT if is_killed else 0)
