"""The interface of a program that takes part in the benchmark."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from benchmarks.work_precision.problems import Problem
from tauto_core.scene.errors import TautoError

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
