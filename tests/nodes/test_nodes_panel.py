"""The panel of `tauto graph`, seen through a pseudo-terminal, and its rows."""

from __future__ import annotations

import fcntl
import io
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rich.console import Console

from tauto_core.bags import encode
from tauto_core.samples import ESTIMATE, JOINT_STATES, READING, JointSamples, TimeSamples
from tauto_core.scene import load_scene
from tauto_core.scene.times import NS_PER_S
from tauto_nodes import graph
from tauto_nodes.graph import NODE_NAMES, UNDER_WAY, Standing, Supervisor
from tauto_nodes.panel import drawn
from tauto_nodes.recorder import RecorderReport, newest_numbers

DEADLINE_S = 300.0
HIDDEN, SHOWN = b'\x1b[?25l', b'\x1b[?25h'
COLOUR = re.compile(rb'\x1b\[(?:\d+;)*3[0-9](?:;\d+)*m')


class Terminal:
    """A command on a pseudo-terminal, and what it has written."""

    def __init__(self, command: list[str], columns: int, **environment: str) -> None:
        self._ours, theirs = pty.openpty()
        size = struct.pack('HHHH', 30, columns, 0, 0)
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, size)
        unset = ('NO_COLOR', 'FORCE_COLOR', 'COLUMNS', 'LINES')
        mine = {name: value for name, value in os.environ.items() if name not in unset}
        self.process = subprocess.Popen(
            command,
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            start_new_session=True,
            env={**mine, 'TERM': 'xterm-256color', **environment},
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),  # noqa: PLW1509
        )
        os.close(theirs)
        self.written = b''

    def read(self) -> bool:
        """Read what has come; False when the command has closed the terminal."""
        try:
            if select.select([self._ours], [], [], 0.2)[0]:
                self.written += os.read(self._ours, 65536)
        except OSError:
            return False
        return True

    def until(self, words: bytes) -> None:
        deadline_s = time.monotonic() + DEADLINE_S
        while words not in re.sub(rb'\x1b\[[\d;?]*[A-Za-z]', b'', self.written):
            assert self.read(), self.written
            assert time.monotonic() < deadline_s, (words, self.written)

    def press(self, key: bytes) -> None:
        os.write(self._ours, key)

    def end(self) -> int:
        deadline_s = time.monotonic() + DEADLINE_S
        while self.read():
            assert time.monotonic() < deadline_s, self.written
        os.close(self._ours)
        return self.process.wait(DEADLINE_S)


@contextmanager
def sailing(folder: Path, columns: int, *options: str, **environment: str) -> Iterator[Terminal]:
    command = [sys.executable, '-m', 'tauto_core', 'graph', 'measured', '--speed', '10', *options]
    terminal = Terminal([*command, '--out', str(folder / 'bag')], columns, **environment)
    try:
        yield terminal
    finally:
        if terminal.process.poll() is None:
            terminal.process.terminate()
            terminal.process.wait(DEADLINE_S)


def test_ctrl_c_gives_the_terminal_back(tmp_path: Path) -> None:
    with sailing(tmp_path, 30, NO_COLOR='1') as terminal:
        terminal.until(b'ship_motion      under way')
        assert not COLOUR.search(terminal.written)
        terminal.press(b'\x03')
        assert terminal.end() == 128 + signal.SIGINT
    assert terminal.written.rfind(SHOWN) > terminal.written.rfind(HIDDEN) >= 0
    assert b'stopped early' in terminal.written


def children(parent: int) -> Iterator[tuple[int, bytes]]:
    """Yield number and command line of a process' children."""
    for entry in Path('/proc').glob('[0-9]*'):
        try:
            status = (entry / 'stat').read_text().rpartition(')')[2].split()
            line = (entry / 'cmdline').read_bytes()
        except OSError:
            continue
        if int(status[1]) == parent:
            yield int(entry.name), line


def test_the_death_of_a_node_stays_on_the_screen(tmp_path: Path) -> None:
    with sailing(tmp_path, 80) as terminal:
        terminal.until(b'ship_motion      under way')
        terminal.until(b'beat')
        assert COLOUR.search(terminal.written)
        killed = [
            number for number, line in children(terminal.process.pid) if b'\0trochlea\0' in line
        ]
        os.kill(killed[0], signal.SIGKILL)
        assert terminal.end() == 1
    screen = terminal.written[: terminal.written.rfind(b'tauto: node trochlea')]
    last = screen[screen.rfind(b'recorder') :]
    assert re.search(rb'trochlea[^\n]*ended by SIGKILL', last)
    assert b'\x1b[2K' not in last, 'it was wiped after it was drawn'
    assert terminal.written.rfind(SHOWN) > terminal.written.rfind(HIDDEN) >= 0


def shown(standing: Standing, columns: int = 100) -> str:
    console = Console(file=io.StringIO(), width=columns)
    with console.capture() as captured:
        console.print(drawn(standing, load_scene('measured'), 2.0))
    return captured.get()


def report(newest: Mapping[str, float], lost: int = 0) -> RecorderReport:
    topics = {READING: {'received': 1234, 'written': 1234, 'lost': lost}}
    return RecorderReport(
        complete=False,
        began_s=0.0,
        closed_s=None,
        topics=topics,
        heard_s={},
        moved_s=0.0,
        newest=dict(newest),
    )


def test_the_newest_numbers_are_those_of_the_messages() -> None:
    stamp_ns = np.array([86_700 * NS_PER_S])
    reading = TimeSamples(stamp_ns, '', stamp_ns - 250_000_000, np.array(['dial'], object))
    names = ('offset_s', 'offset_sigma_s')
    estimate = JointSamples(
        stamp_ns, '', names, np.array([[-0.2, 0.1]]), np.empty((1, 0)), np.empty((1, 0))
    )
    wheel = JointSamples(
        stamp_ns, '', ('wheel',), np.array([[0.3]]), np.array([[0.8]]), np.array([[0.0]])
    )
    messages = {READING: reading, ESTIMATE: estimate, JOINT_STATES: wheel}
    newest = newest_numbers({topic: encode(topic, each)[0] for topic, each in messages.items()})
    assert newest == {
        'stamp_s': 86_700.0,
        'dial_error_s': -0.25,
        'offset_s': -0.2,
        'offset_sigma_s': 0.1,
        'angle': 0.3,
        'speed': 0.8,
    }
    # a swing of 0.3 rad and 0.8 rad/s at 2 rad/s has an amplitude of 0.5 rad, 28.6°
    words = shown(Standing(0.5, report(newest)))
    assert '+17.19°, amplitude about 28.6°' in words
    assert '5 minutes of 10 minutes at sea' in words
    assert '−0.250 s' in words
    assert '−0.20 ± 0.10 s' in words
    assert '1,234 recorded, 0 lost' in words


def test_what_is_not_known_is_a_dash_and_complaints_are_told() -> None:
    nodes = dict.fromkeys(NODE_NAMES, UNDER_WAY) | {'longitude': 'silent for 7 s'}
    words = shown(Standing(0.0, report({}, lost=3), nodes, ('first', 'last of them')))
    assert re.search('roll +–', words)
    assert '3 lost' in words
    assert re.search('longitude +silent for 7 s', words)
    assert '2 complaints: last of them' in words
    # a line that wraps on a narrow terminal would not be wiped
    narrow = shown(Standing(0.0, report({}, lost=3), nodes, ('first', 80 * 'long')), 24)
    assert len(narrow.splitlines()) == len(words.splitlines())
    assert max(map(len, narrow.splitlines())) <= 24
    assert '0 recorded' in shown(Standing())


def test_a_supervisor_tells_how_each_node_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    supervisor = Supervisor(tmp_path, dict(os.environ))
    monkeypatch.setattr(graph, 'time', SimpleNamespace(monotonic=lambda: 107.2))
    heard_s = {'recorder': 107.0, 'longitude': 100.0}
    nodes = supervisor.nodes(heard_s)
    assert nodes['recorder'] == UNDER_WAY
    assert nodes['longitude'] == 'silent for 7 s'
    assert nodes['trochlea'] == 'starting'


def test_a_terminal_without_a_cursor_gets_no_panel(tmp_path: Path) -> None:
    with sailing(tmp_path, 80, '--compose', TERM='dumb') as terminal:
        deadline_s = time.monotonic() + DEADLINE_S
        while not list(tmp_path.glob('bag/*.mcap')):
            assert terminal.read(), terminal.written
            assert time.monotonic() < deadline_s
        terminal.press(b'\x03')
        assert terminal.end() == 128 + signal.SIGINT
    assert b'under way' not in terminal.written
    assert HIDDEN not in terminal.written
