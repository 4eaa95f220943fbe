"""The supervisor reads the output of the nodes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

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
