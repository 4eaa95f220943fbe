"""DOP853 compiled by numba: SciPy's method without Python between the steps.

At sea it uses the exact sum of waves ('waves') or pieces of it (`SeaPieces`, 'pieces'), whose fit
is part of the run. Steps end at the ends of pieces, which costs a few per cent.
"""

from __future__ import annotations

import time

import numpy as np

from benchmarks.work_precision.equations.sea import (
    SeaPieces,
    constants_of,
    end_of,
    pieces_start,
    pieces_wheel,
    sea_from,
    start_of,
    stretches,
)
from benchmarks.work_precision.peer import Outcome
from benchmarks.work_precision.problems import CaseProblem, HungCase, Problem
from tauto_core.samples import FloatArray

STRETCH_S = 3600.0
PIECE_S = 1.0
POINTS = 12
FIRST_STEP_S = 1e-3
_TOLERANCES = ('1e-6', '1e-8', '1e-10', '1e-11', '3e-12', '1e-12', '3e-13', '1e-13', '3e-14')


class CompiledDop853:
    """DOP853 in numba; settings are relative tolerances, and at sea the form of the waves."""

    name = 'dop853_compiled'

    def version(self) -> str:
        """Return the version of numba, which compiles it."""
        import numba

        return f'numba {numba.__version__}'

    def settings(self, problem: Problem) -> tuple[str, ...]:
        """Return tolerances, coarse to fine."""
        if isinstance(problem, CaseProblem) or problem.numbers.sea is None:
            return _TOLERANCES
        return tuple(f'{each} {way}' for way in ('waves', 'pieces') for each in _TOLERANCES)

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem at a relative tolerance."""
        began = time.perf_counter()
        tolerance, *way = setting.split()
        run = _Run(problem, float(tolerance), pieces=way == ['pieces'])
        run.warm_up()
        ready = time.perf_counter()
        for begin_s, length_s in stretches(duration_s, STRETCH_S):
            run.advance(begin_s, length_s)
        run_s = time.perf_counter() - ready
        angle, rate = run.end(duration_s)
        return Outcome(duration_s, angle, rate, run_s, ready - began)


class _Run:
    def __init__(self, problem: Problem, tolerance: float, *, pieces: bool) -> None:
        from benchmarks.work_precision.equations import dop853_kernels as kernels

        self._problem, self._kernels, self._rtol = problem, kernels, tolerance
        self._pieces, self._side, self._h = None, 0.0, FIRST_STEP_S
        if isinstance(problem, CaseProblem):
            case = problem.numbers
            self._kind, self._state = kernels.CASE, np.array(start_of(problem))
            self._constants = np.array([case.e, case.c, case.k, case.gravity])
            sizes = np.repeat([1.0, case.frequency], 2)
            self._atol: FloatArray = tolerance * case.release_angle * sizes
            return
        numbers = problem.numbers
        # with a weight the state holds a momentum
        self._momentum = numbers.inertia if numbers.mass else 1.0
        sizes = np.array([1.0, self._momentum])
        self._kind, self._state = kernels.WAVES, sizes * pieces_start(numbers)
        self._constants = constants_of(numbers)
        self._atol = tolerance * numbers.release_angle * sizes * [1.0, numbers.frequency]
        self._side = 1.0 if numbers.impulse_energy else 0.0
        if pieces and numbers.sea is not None:
            self._kind = kernels.PIECES
            self._pieces = SeaPieces(numbers, numbers.sea, PIECE_S, POINTS, 1.0)

    def warm_up(self) -> None:
        """Compile, or load what was compiled."""
        state, side = self._state.copy(), self._side
        self.advance(0.0, 1e-9)
        self._state, self._side, self._h = state, side, FIRST_STEP_S

    def advance(self, begin_s: float, length_s: float) -> None:
        """Advance over a stretch."""
        if self._pieces is None:
            numbers = self._problem.numbers
            sea = None if isinstance(numbers, HungCase) else numbers.sea
            self._over(length_s, sea_from(sea, begin_s))
            return
        for left_s, chains in self._pieces.blocks(begin_s, length_s):
            for number, row in enumerate(chains):
                left = left_s - number * PIECE_S
                self._over(min(PIECE_S, left), row.reshape(self._pieces.channels, -1))

    def _over(self, length_s: float, sea: FloatArray) -> None:
        self._h, self._side = self._kernels.advance_dop853(
            self._kind,
            self._state,
            0.0,
            length_s,
            self._h,
            self._rtol,
            self._atol,
            self._constants,
            sea,
            2.0 / PIECE_S,
            self._side,
        )

    def end(self, time_s: float) -> tuple[float, float]:
        """Return the angle [rad] and rate [rad/s] that are compared."""
        if isinstance(self._problem, CaseProblem):
            return end_of(self._problem, time_s, self._state)
        numbers, (x, p) = self._problem.numbers, self._state
        angle, rate = pieces_wheel(numbers, time_s, x, p / self._momentum)
        return float(angle), float(rate)
