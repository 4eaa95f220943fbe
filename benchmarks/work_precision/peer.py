"""The programs that take part in the benchmark: their interface, and all of them by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Protocol

from benchmarks.work_precision.problems import Problem
from tauto_core.scene.errors import TautoError, UsageError

REQUIREMENTS = 'benchmarks/requirements.txt'
"""Requirements of the peers."""


class MissingPeerError(TautoError):
    """A program whose library is not installed.

    Args:
        name: name of the peer.
        library: name of the package to install; the peer's name when left out.
    """

    def __init__(self, name: str, library: str | None = None) -> None:
        self.name = name
        super().__init__(
            f'{name}: {library or name} is not installed. Install it with '
            f'pip install -r {REQUIREMENTS}'
        )


@dataclass(frozen=True)
class Outcome:
    """The end of one run.

    Attributes:
        time_s: time of the state, from the start [s].
        angle: theta of the wheel in its case [rad].
        rate: theta' [rad/s].
        run_s: run time without compilation [s].
        compile_s: time of compiling and setting up before the run [s]; 0 if that was done before.
    """

    time_s: float
    angle: float
    rate: float
    run_s: float
    compile_s: float


class Peer(Protocol):
    """A program that solves the problems. Its constructor raises `MissingPeerError`."""

    name: str

    def version(self) -> str:
        """Return the version of the library."""
        ...

    def settings(self, problem: Problem) -> tuple[str, ...]:
        """Return the settings to sweep, coarse to fine; none if it cannot express the problem."""
        ...

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem from its start to `duration_s` on one core.

        Raises:
            TautoError: the run failed.
        """
        ...


def _member(module: str, name: str) -> Callable[[], Peer]:
    """Return the constructor of a peer; its module is imported only then."""

    def make() -> Peer:
        peer: Peer = getattr(import_module(f'benchmarks.work_precision.peers.{module}'), name)()
        return peer

    return make


PEERS: dict[str, Callable[[], Peer]] = {
    'tauto': _member('tauto', 'Tauto'),
    'heyoka': _member('heyoka', 'Heyoka'),
    'heyoka_tuned': _member('heyoka', 'HeyokaTuned'),
    'heyoka_batch': _member('heyoka', 'HeyokaBatch'),
    'dop853_compiled': _member('dop853', 'CompiledDop853'),
}


def make_peers(names: Sequence[str] | None = None) -> tuple[list[Peer], list[str]]:
    """Return the peers that are installed, and messages about the others.

    Args:
        names: keys of `PEERS`; None: all.

    Raises:
        UsageError: a name that is not known.
    """
    asked = list(PEERS) if names is None else list(names)
    unknown = [name for name in asked if name not in PEERS]
    if unknown:
        raise UsageError(f'peer {unknown[0]!r} is not known. Choose from {", ".join(PEERS)}')
    found, missing = [], []
    for name in asked:
        try:
            found.append(PEERS[name]())
        except MissingPeerError as error:
            missing.append(str(error))
    return found, missing
