"""What a program has to answer to take part in the benchmark."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from benchmarks.work_precision.problems import Problem
from tauto_core.scene.errors import TautoError

REQUIREMENTS = 'benchmarks/requirements.txt'
"""What installs the peers."""


class MissingPeerError(TautoError):
    """A program whose library is not installed.

    Args:
        name: of the peer.
        library: what is to be installed for it; the peer's name when left out.
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
        time_s: time from the start at which the state is [s].
        angle: theta of the wheel in its case [rad].
        rate: theta' [rad/s].
        run_s: time that the run took, without compilation [s].
        compile_s: time that compiling and setting up took before it [s]; 0 where it was done.
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
        """Return the settings to sweep, coarse to fine; none: it cannot express the problem."""
        ...

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem from its start to `duration_s` on one core.

        Raises:
            TautoError: the run failed.
        """
        ...
