"""diffrax: Dopri8 in double precision, compiled by XLA through JAX.

A PID controller chooses the steps (its defaults), only the end is kept, and the whole run is one
compiled program. Problem e is a compiled loop over beats. Each solve ends at diffrax's event,
whose root is found on Dopri8's interpolant; theta is a state there, the event's condition.
"""

from __future__ import annotations

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
from benchmarks.work_precision.peer import Outcome
from benchmarks.work_precision.problems import CaseProblem, HungCase, Numbers, Problem
from tauto_core.scene.errors import PropagationError

NAME = 'diffrax'
ROOT_TOLERANCE = 1e-14


class Diffrax:
    """diffrax's Dopri8; a setting is the tolerance, relative and absolute.

    Switches JAX to double precision for the whole process.
    """

    name = NAME

    def __init__(self) -> None:
        library(NAME, 'diffrax', 'diffrax')
        library(NAME, 'jax', 'jax').config.update('jax_enable_x64', True)
        self._compiled: dict[str, Any] = {}

    def version(self) -> str:
        """Return the version of the library, and of JAX below it."""
        return f'{version("diffrax")} (jax {version("jax")})'

    def settings(self, problem: Problem) -> tuple[str, ...]:  # noqa: ARG002
        """Return tolerances, coarse to fine."""
        return ('1e-6', '1e-8', '1e-10', '1e-12', '1e-14')

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem at the tolerance that `setting` says.

        Raises:
            PropagationError: diffrax stopped before the end.
        """
        began = time.perf_counter()
        tolerance = float(setting)
        state, program = _start_and_program(problem)
        if problem.key not in self._compiled:
            run = library(NAME, 'jax', 'jax').jit(program)
            self._compiled[problem.key] = run.lower(state, duration_s, tolerance).compile()
        run = self._compiled[problem.key]
        ready = time.perf_counter()
        reached, end = run(state, duration_s, tolerance)
        reached, end = float(reached), [float(each) for each in end]
        run_s = time.perf_counter() - ready
        if not (np.isclose(reached, duration_s) and np.all(np.isfinite(end))):
            raise PropagationError(
                'diffrax stopped before the end. Choose a coarser tolerance.', reached
            )
        angle, rate = end_of(problem, duration_s, end)
        return Outcome(duration_s, angle, rate, run_s, ready - began)


def _solve(
    term: Any, state: Any, span: tuple[Any, Any], tolerance: Any, **options: Any
) -> tuple[Any, Any]:
    """Return time and state at the end of one solve."""
    dfx = library(NAME, 'diffrax', 'diffrax')
    solution = dfx.diffeqsolve(
        term,
        dfx.Dopri8(),
        *span,
        None,
        state,
        stepsize_controller=dfx.PIDController(rtol=tolerance, atol=tolerance),
        saveat=dfx.SaveAt(t1=True),
        adjoint=dfx.ForwardMode(),
        max_steps=None,
        throw=False,
        **options,
    )
    return solution.ts[-1], tuple(each[-1] for each in solution.ys)


def _start_and_program(problem: Problem) -> tuple[tuple[float, ...], Callable[..., Any]]:
    """Return the state at the start and the program that takes it to the end.

    It is (x, u), with impulses (x, u, theta), of the case (theta, phi, theta', phi').
    """
    state = start_of(problem)
    if isinstance(problem, CaseProblem):
        return state, _one_run(_case_slope(problem.numbers))
    numbers = problem.numbers
    if numbers.impulse_energy:
        return (*state, numbers.release_angle), _swings(numbers)
    slope = _slope(numbers)
    return state, _one_run(lambda t, y, args: slope(t, y, args)[:2])


def _one_run(slope: Callable[[Any, Any, Any], Any]) -> Callable[[Any, Any, Any], Any]:
    """Return the program of a problem without impulses."""
    term = library(NAME, 'diffrax', 'diffrax').ODETerm(slope)

    def run(state: Any, end_s: Any, tolerance: Any) -> tuple[Any, Any]:
        return _solve(term, state, (0.0, end_s), tolerance)

    return run


def _case_slope(case: HungCase) -> Callable[[Any, Any, Any], Any]:
    """Return the derivative of the case's state as a function of (t, y, args)."""
    from benchmarks.work_precision.equations.case_kernels import bends

    jnp = library(NAME, 'jax.numpy', 'jax')
    numbers = case.e, case.c, case.k, case.gravity

    def slope(_t: Any, y: Any, _args: Any) -> Any:
        theta, delta = y[0], y[1] - y[0]
        normal, tilt = (jnp.sin(theta), jnp.cos(theta)), (jnp.sin(delta), jnp.cos(delta))
        return y[2], y[3], *bends(numbers, (y[2], y[3]), normal, tilt)

    return slope


def _swings(numbers: Numbers) -> Callable[[Any, Any, Any], tuple[Any, Any]]:
    """Return the program of a problem with impulses, a solve a beat; the state is (x, u, theta).

    The event has a sense: theta that starts at zero give or take rounding does not meet it again.
    """
    dfx = library(NAME, 'diffrax', 'diffrax')
    jax = library(NAME, 'jax', 'jax')
    newton = library(NAME, 'optimistix', 'optimistix').Newton(ROOT_TOLERANCE, ROOT_TOLERANCE)
    slope = _slope(numbers)
    term = dfx.ODETerm(slope)

    def ahead(t: Any, y: Any, args: Any, **_: Any) -> Any:  # noqa: ARG001
        return args * y[2]

    event = dfx.Event(ahead, newton, direction=False)
    eps = float(mass_ratio(numbers))
    twice = 2.0 * numbers.impulse_energy / numbers.inertia

    def run(state: Any, end_s: Any, tolerance: Any) -> tuple[Any, Any]:
        def beat(carry: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
            now, y, sense = carry
            now, y = _solve(term, y, (now, end_s), tolerance, args=sense, event=event)
            load, speed = 1.0 + eps * y[0] ** 2, slope(now, y, sense)[2]
            faster = jax.numpy.sign(speed) * jax.numpy.sqrt(speed**2 + twice / load)
            kick = jax.numpy.where(now < end_s, load * (faster - speed), 0.0)
            return now, (y[0], y[1] + kick, y[2]), -sense

        def going(carry: tuple[Any, Any, Any]) -> Any:
            return (carry[0] < end_s) & jax.numpy.isfinite(carry[1][1])

        sense = jax.numpy.sign(state[2])
        now, y, _ = jax.lax.while_loop(going, beat, (jax.numpy.zeros(()), state, sense))
        return now, y

    return run


def _slope(numbers: Numbers) -> Callable[[Any, Any, Any], Any]:
    """Return (x', u', theta') of (t, y, args)."""
    vertical = _vertical(numbers)
    eps, inertia = float(mass_ratio(numbers)), numbers.inertia
    steady = numbers.lever_rate * numbers.force / inertia
    weighted = numbers.lever_rate * numbers.mass / inertia
    drag = numbers.viscous / inertia

    def slope(t: Any, y: Any, _args: Any) -> Any:
        g_eff, lean_rate, roll_rate = vertical(t)
        speed = (y[1] - lean_rate - roll_rate) / (1.0 + eps * y[0] ** 2)
        torque = y[0] * (eps * speed**2 - steady - weighted * g_eff)
        if drag:
            torque = torque - drag * (speed + lean_rate)
        return speed, torque, speed + lean_rate

    return slope


def _vertical(numbers: Numbers) -> Callable[[Any], tuple[Any, Any, Any]]:
    """Return g_eff, the lean's rate and the roll's as a function of time."""
    jnp = library(NAME, 'jax.numpy', 'jax')
    sea, gravity = numbers.sea, numbers.gravity
    if sea is None:
        return lambda _t: (gravity, 0.0, 0.0)
    omega = angular_frequency(sea).tolist()
    waves = list(zip(sea.amplitude.tolist(), omega, sea.phase.tolist(), strict=True))
    height, follows = sea.height, numbers.follows_vertical

    def vertical(t: Any) -> tuple[Any, Any, Any]:
        roll = first = second = third = 0.0
        # Unrolled into scalars, of which XLA makes one kernel, three times as fast as arrays.
        for a, w, phase in waves:
            cosine, sine = a * jnp.cos(w * t + phase), a * jnp.sin(w * t + phase)
            roll, first = roll + cosine, first - w * sine
            second, third = second - w**2 * cosine, third + w**3 * sine
        if not (follows or numbers.mass):
            return gravity, 0.0, first
        across = height * second - gravity * jnp.sin(roll)
        along = gravity * jnp.cos(roll) - height * first**2
        square = across**2 + along**2
        if not follows:
            return jnp.sqrt(square), 0.0, first
        across_rate = height * third - gravity * jnp.cos(roll) * first
        along_rate = -first * (gravity * jnp.sin(roll) + 2.0 * height * second)
        turned = across_rate * along - across * along_rate
        return jnp.sqrt(square), turned / square, first

    return vertical
