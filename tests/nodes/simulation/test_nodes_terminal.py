"""`tauto graph` on a pseudo-terminal."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import signal
import struct
import subprocess
import sys
import termios
from pathlib import Path

from tauto_core.bags import read_bag

HIDDEN, SHOWN = b'\x1b[?25l', b'\x1b[?25h'


class Terminal:
    """A command on a pseudo-terminal, and its output."""

    def __init__(self, command: list[str], **environment: str) -> None:
        self._ours, theirs = pty.openpty()
        size = struct.pack('HHHH', 30, 80, 0, 0)
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, size)
        unset = ('NO_COLOR', 'FORCE_COLOR', 'COLUMNS', 'LINES')
        mine = {name: value for name, value in os.environ.items() if name not in unset}
        self.process = subprocess.Popen(
            command,
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            start_new_session=True,
            env={**mine, **environment},
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),  # noqa: PLW1509
        )
        os.close(theirs)
        self.written = b''

    def read(self) -> bool:
        """Read the output. False: the command has closed the terminal."""
        try:
            if select.select([self._ours], [], [], 0.2)[0]:
                self.written += os.read(self._ours, 65536)
        except OSError:
            return False
        return True

    def press(self, key: bytes) -> None:
        os.write(self._ours, key)

    def end(self) -> int:
        while self.read():
            pass
        os.close(self._ours)
        return self.process.wait()


def test_ctrl_c_gives_the_terminal_back(tmp_path: Path) -> None:
    """A bar is shown while the graph sails. The bag is closed."""
    command = [sys.executable, '-m', 'tauto_core', 'graph', 'measured', '--speed', '10']
    command += ['--namespace', 'h4']
    out = tmp_path / 'bag'
    terminal = Terminal([*command, '--out', str(out)], TERM='xterm-256color')
    try:
        while not any(file.stat().st_size > 2000 for file in out.glob('*.mcap')):
            assert terminal.read(), terminal.written
        terminal.press(b'\x03')
        assert terminal.end() == 128 + signal.SIGINT
    finally:
        terminal.process.kill()
    assert b'measured' in terminal.written
    assert terminal.written.rfind(SHOWN) >= terminal.written.rfind(HIDDEN) >= 0
    assert b'stopped early' in terminal.written
    bag = read_bag(out)
    assert (bag.warnings, bag.namespace, bag.counts['/h4/scene']) == ((), 'h4', 1)
