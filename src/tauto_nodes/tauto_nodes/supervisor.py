"""The processes of a graph: started together, watched, stopped together."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

from tauto_nodes.errors import GraphError
from tauto_nodes.running import SUPERVISOR

TERM_S = 60.0
KILL_S = 5.0
POLL_S = 0.02
TAIL_LINES = 25

_COMPLAINT = re.compile(r'\[(WARN|ERROR|FATAL)\]|\w (Error|Warning)\]')
"""What marks a line of rclpy's log, and one of Fast DDS's."""

_COLOUR = re.compile(r'\x1b\[[\d;]*m')
_TIME = re.compile(r'^[-\d]+ [.:\d]+ |\[\d+\.\d+\] ')


@dataclass
class Child:
    """One node's process, with the file that takes its output."""

    name: str
    process: subprocess.Popen[bytes]
    log: Path

    def said(self) -> str:
        """Return the last lines that it wrote."""
        return '\n'.join(self.lines()[-TAIL_LINES:])

    def lines(self) -> list[str]:
        """Return all lines that it wrote, without colours."""
        words = self.log.read_text('utf-8', 'replace')
        return _COLOUR.sub('', words).strip().splitlines()


@dataclass
class Supervisor:
    """Starts nodes as processes of their own group and ends them; a context manager.

    Args:
        folder: for the logs.
        environment: environment of the children.
    """

    folder: Path
    environment: Mapping[str, str]
    children: list[Child] = field(default_factory=list)

    def start(self, name: str, arguments: Sequence[str]) -> None:
        """Start `python -m tauto_nodes.<name>` with these arguments."""
        log = self.folder / f'{name}.log'
        with log.open('wb') as words:
            process = subprocess.Popen(
                [sys.executable, '-m', f'tauto_nodes.{name}', *arguments],
                stdin=subprocess.DEVNULL,
                stdout=words,
                stderr=subprocess.STDOUT,
                env={**self.environment, SUPERVISOR: str(os.getpid())},
                start_new_session=True,
            )
        self.children.append(Child(name, process, log))

    def check(self, ended: Sequence[str] = ()) -> None:
        """Raise if a node has ended before its time.

        Args:
            ended: names of the nodes that may have ended.

        Raises:
            GraphError: names the node, how it ended, and its last output.
        """
        for child in self.children:
            if child.process.poll() is not None and child.name not in ended:
                raise self.died(child.name)

    def died(self, name: str) -> GraphError:
        """Return the error that says how a node ended, with its last output."""
        child = next(child for child in self.children if child.name == name)
        code = child.process.returncode
        how = f'by {signal.Signals(-code).name}' if code < 0 else f'with exit code {code}'
        return GraphError(
            f'node {name} ended {how} before the voyage did. It said:\n{child.said() or "nothing"}'
        )

    def exit_code(self, name: str) -> int | None:
        """Return a node's exit code; None while it runs."""
        return next(c.process.poll() for c in self.children if c.name == name)

    def complaints(self) -> tuple[str, ...]:
        """Return the warnings and errors that the nodes and the middleware wrote, each once."""
        lines = (line for child in self.children for line in child.lines())
        return tuple(
            dict.fromkeys(_TIME.sub('', line) for line in lines if _COMPLAINT.search(line))
        )

    def stop(self) -> list[Child]:
        """End all nodes by SIGTERM; return those that did not end within TERM_S and were killed.

        Those get SIGABRT first, at which a node writes where each of its threads is (`run`).
        """
        self._signal(signal.SIGTERM, TERM_S)
        late = [child for child in self.children if child.process.poll() is None]
        self._signal(signal.SIGABRT, KILL_S)
        self._signal(signal.SIGKILL, KILL_S)
        return late

    def _signal(self, number: signal.Signals, limit_s: float) -> None:
        for child in self.children:
            if child.process.poll() is None:
                os.killpg(child.process.pid, number)
        self._wait(limit_s)

    def _wait(self, limit_s: float) -> None:
        deadline_s = time.monotonic() + limit_s
        while time.monotonic() < deadline_s:
            if all(child.process.poll() is not None for child in self.children):
                return
            time.sleep(POLL_S)

    def __enter__(self) -> Supervisor:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


@dataclass
class Signals:
    """The first SIGINT or SIGTERM that came; 0: none."""

    came: int = 0


@contextmanager
def noted_signals() -> Iterator[Signals]:
    """Note SIGINT and SIGTERM for as long as the context lasts."""
    signals = Signals()

    def note(number: int, frame: FrameType | None) -> None:
        del frame
        signals.came = signals.came or number

    before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield signals
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
