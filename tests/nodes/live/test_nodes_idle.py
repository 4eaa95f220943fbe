"""How often a live node that waits wakes up, counted by its callbacks, and its loaded modules."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

COUNTED = """
import os, signal, sys
from rclpy.node import Node
from tauto_nodes.live import run_nodes
from tauto_nodes.live.node import PERIOD_S
from tauto_nodes.live import recorder, stages

calls, statuses = 0, 0
create = Node.create_timer

def counted(node, period_s, callback, **options):
    def call():
        global calls, statuses
        calls += 0 < statuses < 3  # a recorder lingers for the last messages
        statuses += period_s == PERIOD_S
        callback()
        if statuses == 3:
            os.kill(os.getpid(), signal.SIGINT)
            statuses += 1

    return create(node, period_s, call, **options)

Node.create_timer = counted
role, *arguments = sys.argv[1:]
node = {'trochlea': stages.TrochleaNode, 'recorder': recorder.RecorderNode}[role]
assert run_nodes((node,), arguments) == 0
assert not [name for name in sys.modules if 'simulation' in name]  # it belongs on no boat
print(calls)
"""


def test_nodes_that_wait_wake_nine_times_a_second(tmp_path: Path) -> None:
    """A busy machine can only make them wake less often: a late timer skips what it missed.

    Counted over two intervals of the status, each a second: 3.3 looks, 5 checks and a status.
    """
    arguments = {
        'trochlea': ['-p', 'source:=foreign'],
        'recorder': ['-p', f'output:={tmp_path / "bag"}', '-p', 'topics:=[clock/reading]'],
    }
    processes = {
        role: subprocess.Popen(
            [sys.executable, '-c', COUNTED, role, '--ros-args', *own],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for role, own in arguments.items()
    }
    for role, process in processes.items():
        said, words = process.communicate(timeout=300)
        assert process.returncode == 0, words
        assert 2 <= int(said.split()[-1]) <= 2 * 12, (role, said)
