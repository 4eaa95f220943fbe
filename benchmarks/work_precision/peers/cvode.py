"""CVODE of SUNDIALS (scikit-sundae): multistep methods, Adams and BDF.

Right-hand side, Jacobian and event are compiled by numba and called through the binding. The
binding offers only CVODE's default Newton iteration, so it is given the Jacobian (with the mean
gravity, which is sufficient for Newton's iteration).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import numpy as np

from benchmarks.work_precision.equations.sea import (
    angular_frequency,
    end_of,
    library,
    mass_ratio,
    start_of,
)
from benchmarks.work_precision.equations.sea import vertical as vertical_at
from benchmarks.work_precision.peer import Outcome
from benchmarks.work_precision.problems import CaseProblem, Numbers, Problem
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import PropagationError

NAME = 'cvode'
MOST_STEPS = 2**31 - 1


class Cvode:
    """CVODE; a setting is the method and the tolerance, relative and absolute."""

    name = NAME

    def __init__(self) -> None:
        library(NAME, 'sksundae', 'scikit-sundae')
        self._compiled: dict[str, tuple[Any, Any, Any]] = {}

    def version(self) -> str:
        """Return the version of the binding."""
        return version('scikit-sundae')

    def settings(self, problem: Problem) -> tuple[str, ...]:  # noqa: ARG002
        """Return tolerances, coarse to fine: BDF, then Adams."""
        adams = tuple(f'Adams {each}' for each in ('1e-6', '1e-8', '1e-10', '1e-12', '1e-14'))
        return ('BDF 1e-6', 'BDF 1e-8', 'BDF 1e-10', 'BDF 1e-12', *adams)

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem with the method and the tolerance that `setting` says.

        Raises:
            PropagationError: CVODE stopped before the end.
        """
        began = time.perf_counter()
        method, tolerance = setting.split()
        sense = np.array([1.0])
        solver = self._solver(problem, method, float(tolerance), sense)
        state = np.array(start_of(problem))
        ready = time.perf_counter()
        state = _advance(solver, problem, state, duration_s, sense)
        run_s = time.perf_counter() - ready
        angle, rate = end_of(problem, duration_s, state)
        return Outcome(duration_s, angle, rate, run_s, ready - began)

    def _solver(self, problem: Problem, method: str, tolerance: float, sense: FloatArray) -> Any:
        cvode = library(NAME, 'sksundae.cvode', 'scikit-sundae')
        if problem.key not in self._compiled:
            self._compiled[problem.key] = (
                _compiled_case(problem)
                if isinstance(problem, CaseProblem)
                else _compiled(problem.numbers)
            )
        slope, jacobian, crossing = self._compiled[problem.key]
        scale = np.abs(np.array([problem.numbers.release_angle, 2 * math.pi / problem.period_s]))
        if isinstance(problem, CaseProblem):
            scale = np.repeat(scale, 2)
        options: dict[str, Any] = {
            'method': method,
            'rtol': tolerance,
            'atol': tolerance * scale,
            'max_num_steps': MOST_STEPS,
            'jacfn': jacobian,
            'userdata': sense,
        }
        if not isinstance(problem, CaseProblem) and problem.numbers.impulse_energy:

            def events(t: float, y: FloatArray, out: FloatArray, sense: FloatArray) -> None:
                crossing(t, y, out, sense)

            events.terminal = [True]  # type: ignore[attr-defined]
            events.direction = [-1]  # type: ignore[attr-defined]
            options |= {'eventsfn': events, 'num_events': 1}
        return cvode.CVODE(slope, **options)


def _advance(
    solver: Any, problem: Problem, state: FloatArray, end_s: float, sense: FloatArray
) -> FloatArray:
    """Return the state at the end; CVODE starts anew after each impulse."""
    now = 0.0
    sense[0] = math.copysign(1.0, problem.numbers.release_angle)
    while True:
        solver.init_step(now, state)
        result = solver.step(end_s, method='normal', tstop=end_s)
        now, state = float(result.t), np.array(result.y, dtype=np.float64).reshape(-1)
        if not result.success:
            raise PropagationError(
                f'CVODE stopped: {result.message}. Choose a coarser tolerance.', now
            )
        if now >= end_s or isinstance(problem, CaseProblem):
            return state
        state[1] += _gain(problem.numbers, now, state)
        sense[0] = -sense[0]


def _gain(numbers: Numbers, now_s: float, state: FloatArray) -> float:
    """Return what u gains by the impulse: v becomes sqrt(v^2 + 2 E/M), M = I (1 + eps x^2)."""
    at = vertical_at(numbers, now_s)
    load = 1 + mass_ratio(numbers) * state[0] ** 2
    speed = (state[1] - at.lean_rate - at.roll_rate) / load + at.lean_rate
    faster = np.sqrt(speed**2 + 2 * numbers.impulse_energy / (numbers.inertia * load))
    return float(load * (np.copysign(faster, speed) - speed))


def _compiled(numbers: Numbers) -> tuple[Any, Any, Any]:
    """Return right-hand side, Jacobian and event, compiled for CVODE's arrays."""
    njit = library(NAME, 'numba', 'numba').njit
    eps, inertia = float(mass_ratio(numbers)), numbers.inertia
    steady = numbers.lever_rate * numbers.force / inertia
    weighted = numbers.lever_rate * numbers.mass / inertia
    drag, gravity = numbers.viscous / inertia, numbers.gravity
    attitude = njit(_attitude(numbers))

    @njit  # type: ignore[untyped-decorator]
    def slope(t: float, y: FloatArray, out: FloatArray, sense: FloatArray) -> None:  # noqa: ARG001
        _, lean_rate, roll_rate, g_eff = attitude(t)
        speed = (y[1] - lean_rate - roll_rate) / (1.0 + eps * y[0] * y[0])
        pull = steady + weighted * g_eff
        out[0] = speed
        out[1] = y[0] * (eps * speed * speed - pull) - drag * (speed + lean_rate)

    @njit  # type: ignore[untyped-decorator]
    def jacobian(
        t: float,  # noqa: ARG001
        y: FloatArray,
        rate: FloatArray,
        out: FloatArray,
        sense: FloatArray,  # noqa: ARG001
    ) -> None:
        load, speed = 1.0 + eps * y[0] * y[0], rate[0]
        out[0, 0] = -2.0 * eps * y[0] * speed / load
        out[0, 1] = 1.0 / load
        lever = 2.0 * eps * y[0] * speed - drag
        pull = steady + weighted * gravity
        out[1, 0] = eps * speed * speed - pull + lever * out[0, 0]
        out[1, 1] = lever * out[0, 1]

    @njit  # type: ignore[untyped-decorator]
    def crossing(t: float, y: FloatArray, out: FloatArray, sense: FloatArray) -> None:
        out[0] = sense[0] * (y[0] + attitude(t)[0])

    state, square, one = np.ones(2), np.ones((2, 2)), np.ones(1)
    frozen = state.copy()
    frozen.flags.writeable = False
    slope(0.0, frozen, state, one)
    jacobian(0.0, frozen, frozen, square, one)
    crossing(0.0, frozen, one.copy(), one)
    return slope, jacobian, crossing


def _compiled_case(problem: CaseProblem) -> tuple[Any, Any, None]:
    """Return right-hand side and Jacobian of the case, compiled for CVODE's arrays; no event."""
    njit = library(NAME, 'numba', 'numba').njit
    from benchmarks.work_precision.equations.case_kernels import fill_jacobian, fill_slope

    case = problem.numbers
    numbers = case.e, case.c, case.k, case.gravity

    @njit  # type: ignore[untyped-decorator]
    def slope(t: float, y: FloatArray, out: FloatArray, sense: FloatArray) -> None:  # noqa: ARG001
        fill_slope(y, numbers, out)

    @njit  # type: ignore[untyped-decorator]
    def jacobian(
        t: float,  # noqa: ARG001
        y: FloatArray,
        rate: FloatArray,  # noqa: ARG001
        out: FloatArray,
        sense: FloatArray,  # noqa: ARG001
    ) -> None:
        fill_jacobian(y, numbers, out)

    frozen = np.array(start_of(problem))
    frozen.flags.writeable = False
    slope(0.0, frozen, np.ones(4), np.ones(1))
    jacobian(0.0, frozen, frozen, np.ones((4, 4)), np.ones(1))
    return slope, jacobian, None


def _attitude(numbers: Numbers) -> Callable[[float], tuple[float, float, float, float]]:
    """Return lean, its rate, roll rate and g_eff as a plain function of time for numba."""
    gravity, sea = numbers.gravity, numbers.sea
    if sea is None:
        return lambda _t: (0.0, 0.0, 0.0, gravity)
    amplitude, omega, phase = sea.amplitude, angular_frequency(sea), sea.phase
    height, follows, felt = sea.height, numbers.follows_vertical, numbers.mass != 0.0

    def linear(t: float) -> tuple[float, float, float, float]:
        first = 0.0
        for i in range(len(omega)):
            first -= amplitude[i] * omega[i] * math.sin(omega[i] * t + phase[i])
        return 0.0, 0.0, first, gravity

    def tilted(t: float) -> tuple[float, float, float, float]:
        roll = first = second = third = 0.0
        for i in range(len(omega)):
            w = omega[i]
            angle = w * t + phase[i]
            cosine, sine = amplitude[i] * math.cos(angle), amplitude[i] * math.sin(angle)
            roll += cosine
            first -= w * sine
            second -= w * w * cosine
            third += w * w * w * sine
        sine, cosine = math.sin(roll), math.cos(roll)
        across = height * second - gravity * sine
        along = gravity * cosine - height * first * first
        across_rate = height * third - gravity * cosine * first
        along_rate = -first * (gravity * sine + 2.0 * height * second)
        square = across * across + along * along
        if not follows:
            return 0.0, 0.0, first, math.sqrt(square)
        rate = (across_rate * along - across * along_rate) / square
        return math.atan2(across, along), rate, first, math.sqrt(square)

    return tilted if follows or felt else linear
