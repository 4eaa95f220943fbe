"""heyoka on several ships at once: the lanes of a vector instruction carry a ship each.

`tauto fleet` and `tauto compare` sail many ships, and for those heyoka's batches are its best
formulation. Eight ships with eight seas (the first is that of the problem, so that its reference
holds; the others have its waves at other phases) advance by one compiled step, each with its own
step size, its own polynomials of the sea and its own impulses. The equations and the fitted
pieces are those of `heyoka_tuned`. The time that is reported is that of a ship.
"""

from __future__ import annotations

import time
from dataclasses import replace
from importlib.metadata import version

import numpy as np

from benchmarks.work_precision.equations.sea import stretches
from benchmarks.work_precision.equations.sea_pieces import SeaPieces
from benchmarks.work_precision.equations.states import library, mass_ratio, wheel
from benchmarks.work_precision.peer import Outcome
from benchmarks.work_precision.peers import heyoka_tuned
from benchmarks.work_precision.peers.heyoka_tuned import SCALE, STRETCH_S
from benchmarks.work_precision.problems import Numbers, Problem, WheelProblem
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import UsageError

NAME = 'heyoka_batch'
SHIPS = 8
"""Lanes of eight doubles: 512 bits; on processors with 256 heyoka splits them."""


class HeyokaBatch:
    """heyoka's batch integrator on polynomials of the sea, a ship a lane.

    Settings are those of `heyoka_tuned` at sea.
    """

    name = NAME

    def __init__(self) -> None:
        library(NAME, 'heyoka', 'heyoka')

    def version(self) -> str:
        """Return the version of the library."""
        return version('heyoka')

    def settings(self, problem: Problem) -> tuple[str, ...]:
        """Return tolerances with pieces for c and e; none for what is not an ensemble at sea."""
        return heyoka_tuned.settings_at_sea(problem.key) if problem.key in 'ce' else ()

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem, and it in seven other seas.

        Raises:
            UsageError: a problem other than c and e.
        """
        if not isinstance(problem, WheelProblem) or not self.settings(problem):
            raise UsageError(f"{NAME}: problem {problem.key!r} has no ensemble. Choose 'c' or 'e'")
        began = time.perf_counter()
        fleet = _Fleet(problem.numbers, *heyoka_tuned.piece_of(setting))
        ready = time.perf_counter()
        for begin_s, length_s in stretches(duration_s, STRETCH_S):
            fleet.advance(begin_s, length_s)
        run_s = time.perf_counter() - ready
        angle, rate = wheel(problem.numbers, duration_s, *fleet.state[:2, 0])
        return Outcome(duration_s, float(angle), float(rate), run_s / SHIPS, ready - began)


def eight_seas(numbers: Numbers) -> list[Numbers]:
    """Return the problem's numbers in its own sea, and in seven of other phases."""
    assert numbers.sea is not None
    rng = np.random.default_rng(8)
    others = [
        replace(numbers.sea, phase=rng.uniform(0.0, 2.0 * np.pi, len(numbers.sea.phase)))
        for _ in range(SHIPS - 1)
    ]
    return [replace(numbers, sea=sea) for sea in (numbers.sea, *others)]


class _Fleet:
    """Eight wheels at sea, piece by piece."""

    def __init__(self, numbers: Numbers, tolerance: float, length_s: float, points: int) -> None:
        from benchmarks.work_precision.equations.piece_kernels import advance_batch

        self._advance = advance_batch
        own = eight_seas(numbers)
        self._pieces = [
            SeaPieces(each, each.sea, length_s, points, SCALE) for each in own if each.sea
        ]
        chains = self._pieces[0].channels * points
        starts = np.array([heyoka_tuned.start_of(each) for each in own]).T
        self.state: FloatArray = np.concatenate([starts, np.zeros((chains, SHIPS))])
        integrator = heyoka_tuned.integrator_of(numbers, self._pieces[0], tolerance, SHIPS)
        self._engine, self._step = heyoka_tuned.compiled_step(integrator)
        self._taylor = np.zeros((2 + chains, integrator.order + 1, SHIPS))
        self._sides = np.full(SHIPS, 1.0 if numbers.impulse_energy else 0.0)
        twice = 2.0 * numbers.impulse_energy / numbers.inertia
        self._kick = float(mass_ratio(numbers)), twice, SCALE, 2.0 / length_s
        # compiles, or loads what was compiled
        first = self.state.copy()
        self.advance(0.0, 1e-9)
        self.state[:] = first

    def advance(self, begin_s: float, length_s: float) -> None:
        """Advance all ships over a stretch."""
        blocks = (each.blocks(begin_s, length_s) for each in self._pieces)
        for found in zip(*blocks, strict=True):
            chains = np.stack([chain for _, chain in found], axis=-1)
            self._advance(
                self._step,
                self.state,
                chains,
                self._pieces[0].length_s,
                found[0][0],
                self._sides,
                self._taylor,
                self._kick,
            )
