"""SciPy's solve_ivp: DOP853, LSODA and Radau, on right-hand sides compiled by numba.

Everything is done in SciPy's favour. The right-hand side costs a call and no interpreted
arithmetic, the state is that in which the equation is shortest, absolute tolerances follow the
size of each part, and every hour begins anew at time zero, so that neither time nor the sea's
phases lose digits. Impulses are terminal events; their function is compiled too.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from benchmarks.work_precision.equations.sea import (
    constants_of,
    end_of,
    sea_from,
    start_of,
    stretches,
    vertical,
)
from benchmarks.work_precision.peer import Outcome
from benchmarks.work_precision.problems import CaseProblem, Numbers, Problem
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import PropagationError

STRETCH_S = 3600.0

SETTINGS = {
    'DOP853': ('1e-6', '1e-8', '1e-10', '1e-12', '1e-13', '3e-14'),
    'LSODA': ('1e-6', '1e-8', '1e-10', '1e-12'),
    'Radau': ('1e-5', '1e-7', '1e-9', '1e-11'),
}


class SciPy:
    """One method of solve_ivp; settings are relative tolerances.

    Args:
        method: a key of `SETTINGS`.
    """

    def __init__(self, method: str) -> None:
        self._method = method
        self.name = method.lower()

    def version(self) -> str:
        """Return the version of SciPy."""
        import scipy

        return str(scipy.__version__)

    def settings(self, problem: Problem) -> tuple[str, ...]:
        """Return tolerances, coarse to fine; every problem can be expressed.

        Radau's finer ones are left out for the case, where a run of a minute takes minutes.
        """
        if self._method == 'Radau' and isinstance(problem, CaseProblem):
            return SETTINGS[self._method][:2]
        return SETTINGS[self._method]

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem at a relative tolerance.

        Raises:
            PropagationError: SciPy gave up.
        """
        began = time.perf_counter()
        run: _Run | _CaseRun
        if isinstance(problem, CaseProblem):
            run = _CaseRun(problem, self._method, float(setting))
        else:
            run = _Run(problem.numbers, self._method, float(setting))
        ready = time.perf_counter()
        for start, length in stretches(duration_s, STRETCH_S):
            run.advance(start, length)
        run_s = time.perf_counter() - ready
        if isinstance(problem, CaseProblem):
            angle, rate = end_of(problem, duration_s, run.state)
        else:
            angle, rate = wheel_of(problem.numbers, duration_s, run.state)
        return Outcome(duration_s, angle, rate, run_s, ready - began)


class _Run:
    """A state of the wheel during a run."""

    def __init__(self, numbers: Numbers, method: str, tolerance: float) -> None:
        from scipy.integrate import solve_ivp

        from benchmarks.work_precision.equations import wheel_kernels as kernels

        self._solve_ivp, self._kernels = solve_ivp, kernels
        self._constants, self._sea = constants_of(numbers), numbers.sea
        self._slope = kernels.weight_slope if numbers.mass else kernels.linear_slope
        self.state = release_of(numbers)
        speed = numbers.frequency * (numbers.inertia if numbers.mass else 1.0)
        atol = tolerance * numbers.release_angle * np.array([1.0, speed])
        self._options: dict[str, Any] = {'method': method, 'rtol': tolerance, 'atol': atol}
        self._event = _Passage(kernels.wheel_angle) if numbers.impulse_energy else None
        # compiles, or loads what was compiled
        sea = sea_from(numbers.sea, 0.0)
        self._slope(0.0, self.state, self._constants, sea)
        if self._event is not None:
            self._event(0.0, self.state, self._constants, sea)
            kernels.impulse(0.0, self.state, self._constants, sea)

    def advance(self, start_s: float, length_s: float) -> None:
        """Advance over a stretch."""
        arguments, now = (self._constants, sea_from(self._sea, start_s)), 0.0
        while now < length_s:
            found = self._solve_ivp(
                self._slope,
                (now, length_s),
                self.state,
                args=arguments,
                events=self._event,
                **self._options,
            )
            if not found.success:
                raise PropagationError(f'SciPy gave up: {found.message}', start_s + found.t[-1])
            now, self.state = float(found.t[-1]), found.y[:, -1].copy()
            if self._event is not None and found.status == 1:
                self.state[1] += self._kernels.impulse(now, self.state, *arguments)
                self._event.direction = -self._event.direction


class _CaseRun:
    """A state of the case during a run."""

    def __init__(self, problem: CaseProblem, method: str, tolerance: float) -> None:
        from scipy.integrate import solve_ivp

        from benchmarks.work_precision.equations.case_kernels import case_slope

        self._solve_ivp, self._slope, case = solve_ivp, case_slope, problem.numbers
        self._numbers = case.e, case.c, case.k, case.gravity
        self.state = np.array(start_of(problem))
        atol = tolerance * case.release_angle * np.repeat([1.0, case.frequency], 2)
        self._options: dict[str, Any] = {'method': method, 'rtol': tolerance, 'atol': atol}
        # compiles, or loads what was compiled
        case_slope(0.0, self.state, self._numbers)

    def advance(self, start_s: float, length_s: float) -> None:
        """Advance over a stretch."""
        found = self._solve_ivp(
            self._slope, (0.0, length_s), self.state, args=(self._numbers,), **self._options
        )
        if not found.success:
            raise PropagationError(f'SciPy gave up: {found.message}', start_s + found.t[-1])
        self.state = found.y[:, -1].copy()


class _Passage:
    """Event: theta passes zero, downwards first and then by turns."""

    terminal = True

    def __init__(self, angle: Any) -> None:
        self._angle = angle
        self.direction = -1.0

    def __call__(self, *arguments: Any) -> float:
        return float(self._angle(*arguments))


def release_of(numbers: Numbers) -> FloatArray:
    """Return the kernels' state of the wheel released at rest in its case, shape (2,)."""
    at = vertical(numbers, 0.0)
    if not numbers.mass:
        return np.array([numbers.release_angle + at.roll, at.roll_rate])
    x = numbers.release_angle - at.lean
    momentum = numbers.inertia * (at.lean_rate + at.roll_rate) - _mass(numbers, x) * at.lean_rate
    return np.array([x, momentum])


def wheel_of(numbers: Numbers, time_s: float, state: FloatArray) -> tuple[float, float]:
    """Return theta [rad] and theta' [rad/s] of a kernels' state at a time from the start [s]."""
    at = vertical(numbers, time_s)
    if not numbers.mass:
        return float(state[0] - at.roll), float(state[1] - at.roll_rate)
    turning = numbers.inertia * (at.lean_rate + at.roll_rate)
    speed = (state[1] - turning) / _mass(numbers, state[0])
    return float(state[0] + at.lean), float(speed + at.lean_rate)


def _mass(numbers: Numbers, x: float) -> float:
    return numbers.inertia + numbers.mass * (numbers.lever_rate * x) ** 2
