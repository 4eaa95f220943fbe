"""The supervisor sees a standstill in the recorder's reports, and reads the nodes' output."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tauto_core.samples import READING
from tauto_nodes import GraphError
from tauto_nodes.live.recorder import RecorderReport
from tauto_nodes.simulation import supervisor as graph
from tauto_nodes.simulation.supervisor import NODE_NAMES, SILENT_S, STALL_S, Child, Watchdog

LONG_AGO_S = -2.0 * STALL_S


def report(
    silent: tuple[str, ...] = (), heard: tuple[str, ...] = NODE_NAMES, moved_s: float = 0.0
) -> RecorderReport:
    """Return a report in which some nodes have been silent for longer than is allowed."""
    now_s = time.monotonic()
    return RecorderReport(
        complete=False,
        began_s=now_s,
        closed_s=None,
        topics={READING: {'received': 7, 'written': 7, 'lost': 0}},
        heard_s={node: now_s - (SILENT_S + 1.0) * (node in silent) for node in heard},
        moved_s=now_s + moved_s,
    )


def watch_of(file: Path, said: RecorderReport | None) -> Watchdog:
    """Return a watch that began long ago and has read this."""
    if said is not None:
        said.write(file)
    watch = Watchdog(file, blind_s=time.monotonic() + LONG_AGO_S)
    watch.look()
    return watch


def test_a_graph_that_moves_is_left_alone(tmp_path: Path) -> None:
    watch = watch_of(tmp_path / 'report.json', report())
    watch.check()
    assert watch.recorded(READING) == 7


@pytest.mark.parametrize(
    ('said', 'words'),
    [
        (
            {'silent': ('trochlea', 'longitude')},
            'node longitude, trochlea has not been heard for 120',
        ),
        # the recorder hears for all: while it stands still no node is heard
        ({'silent': NODE_NAMES}, 'node recorder has not been heard for 120 s'),
        ({'moved_s': LONG_AGO_S}, 'for 600 s (nodes never heard: none)'),
        (
            {'heard': ('recorder', 'longitude', 'trochlea'), 'moved_s': LONG_AGO_S},
            'for 600 s (nodes never heard: drift_estimator, ship_motion)',
        ),
        (None, f'(nodes never heard: {", ".join(sorted(NODE_NAMES))})'),
    ],
)
def test_who_stands_still_is_named(
    said: dict[str, Any] | None, words: str, tmp_path: Path
) -> None:
    # The report is made here: pytest gathers parameters minutes before some tests run.
    watch = watch_of(tmp_path / 'report.json', None if said is None else report(**said))
    with pytest.raises(GraphError, match=re.escape(words)):
        watch.check()


def test_what_cannot_be_read_accuses_nobody(tmp_path: Path) -> None:
    file = tmp_path / 'report.json'
    watch = watch_of(file, replace(report(NODE_NAMES), moved_s=time.monotonic() + LONG_AGO_S))
    file.write_text('{"complete": fal')  # half written, or on a full disk
    watch.look()
    watch.check()
    assert watch.recorded(READING) == 7


def test_a_report_that_could_not_be_written_is_told(tmp_path: Path) -> None:
    file = tmp_path / 'report.json'
    file.write_text('{"complete": tr')  # the disk was full
    with pytest.raises(GraphError, match='the recorder could not write its report'):
        graph._recorded(file, graph.Supervisor(tmp_path, {}), 'recorder', interrupted=False)


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
    assert graph.Supervisor(tmp_path, {}, children).node_warnings() == (
        '[WARN] [trochlea]: the thread is slack',
        '[XMLPARSER Error] no such element',
        '[ERROR] [longitude]: no fix',
    )
    assert '\x1b' not in children[0].said()
