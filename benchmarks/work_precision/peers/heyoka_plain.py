"""heyoka: Taylor integration of arbitrary order, compiled by LLVM.

Used at its fastest, as tried on problems c, d and e. Without events, every component of the sea is
a pair of states (a omega cos, a omega sin) that turn into each other, which costs half of what
sines of hy.time do. With events (e) a step costs by the number of states, and in double precision
sines of hy.time are the cheaper way. Roll and its second derivative are integrated from the sums
that serve their derivatives too; no compact mode, which takes several times as long; fast_math.
The case (f) has no sea; sin and cos of an angle are computed together.
`high_accuracy` sums the Taylor series with compensation; it is a setting of its own, without
fast_math. heyoka keeps compiled code on disk, so that `compile_s` is small from the second run on.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.work_precision.equations.states import (
    angular_frequency,
    end_of,
    library,
    mass_ratio,
    start,
    start_of,
    wheel,
)
from benchmarks.work_precision.equations.states import vertical as vertical_at
from benchmarks.work_precision.peer import Outcome
from benchmarks.work_precision.problems import CaseProblem, Numbers, Problem, WheelProblem
from tauto_core.scene.errors import PropagationError

NAME = 'heyoka'
COMPENSATED = 'compensated'
REFERENCE_TOLERANCE = 1e-18

_LINEAR = ('1e-9', '1e-12', '1e-15', '1e-18', '1e-21', '1e-24', '1e-30')
_TOLERANCES = {
    'a': _LINEAR,
    'b': ('1e-9', '1e-12', '1e-13', '1e-14', '1e-15', '1e-16', '1e-18'),
    'c': ('1e-9', '1e-11', '1e-12', '3e-13', '1e-13', '1e-15', '1e-18'),
    'd': _LINEAR,
    'e': ('1e-6', '1e-8', '3e-9', '1e-9', '3e-10', '1e-12', '1e-15'),
    'f': ('1e-9', '1e-12', '1e-13', '3e-14', '1e-14', '3e-15', '1e-15', '1e-18'),
}
"""A linear wheel's steps grow with the order that a tolerance asks for, far below rounding."""

_X, _U, _THETA, _ROLL, _ROLL_2 = range(5)
_STATES = 5


class Heyoka:
    """heyoka's adaptive Taylor integrator in double precision; settings are tolerances."""

    name = NAME

    def __init__(self) -> None:
        library(NAME, 'heyoka', 'heyoka')

    def version(self) -> str:
        """Return the version of the library."""
        return version('heyoka')

    def settings(self, problem: Problem) -> tuple[str, ...]:
        """Return tolerances, coarse to fine; closer where the error passes what is compared."""
        return (*_TOLERANCES[problem.key], f'1e-18 {COMPENSATED}')

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem at the tolerance that `setting` says.

        Raises:
            PropagationError: heyoka stopped before the end.
        """
        began = time.perf_counter()
        tolerance, *words = setting.split()
        compensated = COMPENSATED in words
        options = {
            'tol': float(tolerance),
            'high_accuracy': compensated,
            'fast_math': not compensated,
        }
        if isinstance(problem, CaseProblem):
            integrator = _case_integrator(problem, options)
        else:
            integrator = _integrator(problem.numbers, np.float64, **options)
        ready = time.perf_counter()
        _run(integrator, duration_s)
        run_s = time.perf_counter() - ready
        angle, rate = end_of(problem, duration_s, integrator.state)
        return Outcome(duration_s, angle, rate, run_s, ready - began)


def reference_states(
    problem: WheelProblem, times_s: Sequence[float], tolerance: float = REFERENCE_TOLERANCE
) -> list[tuple[float, float]]:
    """Return theta [rad] and theta' [rad/s] at times from the start, from extended precision.

    Arithmetic is np.longdouble (64 bits of significand on x86-64) with compensated Taylor sums;
    impulses are events of the same precision.

    Args:
        times_s: increasing, > 0 [s].
        tolerance: of the integrator, above the type's rounding (1.1e-19).

    Raises:
        MissingPeerError: heyoka is not installed.
        PropagationError: heyoka stopped before the end.
    """
    library(NAME, 'heyoka', 'heyoka')
    kind = np.longdouble
    integrator = _integrator(
        problem.numbers, kind, tol=kind(tolerance), high_accuracy=True, fp_type=kind
    )
    states = []
    for instant in times_s:
        _run(integrator, kind(instant))
        x, u = integrator.state[_X], integrator.state[_U]
        angle, rate = wheel(problem.numbers, instant, x, u, kind)
        states.append((float(angle), float(rate)))
    return states


def _run(integrator: Any, end_s: Any) -> None:
    outcome = integrator.propagate_until(end_s)[0]
    reached = library(NAME, 'heyoka', 'heyoka').taylor_outcome.time_limit
    if outcome != reached:
        raise PropagationError(
            f'heyoka stopped with {outcome}. Choose a coarser tolerance.', float(integrator.time)
        )


def _case_integrator(problem: CaseProblem, options: dict[str, Any]) -> Any:
    """Return an integrator with the state (theta, phi, theta', phi') of the case."""
    from benchmarks.work_precision.equations.case_kernels import bends

    hy, case = library(NAME, 'heyoka', 'heyoka'), problem.numbers
    theta, phi, theta_rate, phi_rate = hy.make_vars('theta', 'phi', 'theta_rate', 'phi_rate')
    delta = phi - theta
    theta_bend, phi_bend = bends(
        (case.e, case.c, case.k, case.gravity),
        (theta_rate, phi_rate),
        (hy.sin(theta), hy.cos(theta)),
        (hy.sin(delta), hy.cos(delta)),
    )
    equations = [(theta, theta_rate), (phi, phi_rate)]
    equations += [(theta_rate, theta_bend), (phi_rate, phi_bend)]
    return hy.taylor_adaptive(equations, np.array(start_of(problem)), **options)


def _integrator(numbers: Numbers, kind: type, **options: Any) -> Any:
    """Return an integrator with the state (x, u, theta, roll, roll'', cosines, sines)."""
    hy = library(NAME, 'heyoka', 'heyoka')
    x, u, theta, roll, second = hy.make_vars('x', 'u', 'theta', 'roll', 'second')
    pairs, first, third, turning = _turning(hy, numbers, kind)
    gravity, lean_rate = _vertical(hy, numbers, kind, (roll, first, second, third))
    eps, inertia = mass_ratio(numbers, kind), kind(numbers.inertia)
    lever, force, mass = kind(numbers.lever_rate), kind(numbers.force), kind(numbers.mass)
    pull = (lever * force / inertia) + (lever * mass / inertia) * gravity
    speed = u - lean_rate - first
    torque = -pull * x
    if numbers.mass:
        speed = speed / (kind(1.0) + eps * x * x)
        torque = x * (eps * speed * speed - pull)
    if numbers.viscous:
        torque = torque - (kind(numbers.viscous) / inertia) * (speed + lean_rate)
    equations = [(x, speed), (u, torque), (theta, speed + lean_rate)]
    equations += [(roll, first), (second, third), *pairs]
    if numbers.impulse_energy:
        event = hy.t_event(theta, callback=_impulse(numbers, kind), fp_type=kind)
        options['t_events'] = [event]
    state = np.concatenate([_start(numbers, kind), turning])
    return hy.taylor_adaptive(equations, state, **options)


def _start(numbers: Numbers, kind: type) -> NDArray[Any]:
    x, u = start(numbers, kind)
    at = vertical_at(numbers, 0.0, kind)
    second = kind(0.0)
    if numbers.sea is not None:
        omega = angular_frequency(numbers.sea, kind)
        phase: Any = np.asarray(numbers.sea.phase, dtype=kind)
        second = -np.sum(np.asarray(numbers.sea.amplitude, kind) * omega**2 * np.cos(phase))
    return np.array([x, u, numbers.release_angle, at.roll, second], dtype=kind)


def _turning(
    hy: Any, numbers: Numbers, kind: type
) -> tuple[list[tuple[Any, Any]], Any, Any, NDArray[Any]]:
    """Return the pairs' equations, roll', roll''' as sums, and the pairs at the start.

    There are none with impulses in double precision.
    """
    sea = numbers.sea
    if sea is None:
        nothing = hy.expression(kind(0.0))
        return [], nothing, nothing, np.empty(0, dtype=kind)
    omega = angular_frequency(sea, kind)
    phase: Any = np.asarray(sea.phase, dtype=kind)
    scale = np.asarray(sea.amplitude, dtype=kind) * omega
    indices = range(len(omega))
    turning: NDArray[Any] = np.empty(0, dtype=kind)
    equations: list[tuple[Any, Any]] = []
    if numbers.impulse_energy and kind is np.float64:
        sine = [scale[i] * hy.sin(omega[i] * hy.time + phase[i]) for i in indices]
    else:
        cosine = [hy.expression(f'c{i}') for i in indices]
        sine = [hy.expression(f's{i}') for i in indices]
        equations = [(cosine[i], -omega[i] * sine[i]) for i in indices]
        equations += [(sine[i], omega[i] * cosine[i]) for i in indices]
        turning = np.concatenate([scale * np.cos(phase), scale * np.sin(phase)])
    third = hy.sum([omega[i] ** 2 * sine[i] for i in indices])
    return equations, -hy.sum(sine), third, turning


def _vertical(
    hy: Any, numbers: Numbers, kind: type, roll: tuple[Any, Any, Any, Any]
) -> tuple[Any, Any]:
    """Return g_eff and the lean's rate as expressions of roll and its derivatives."""
    gravity = hy.expression(kind(numbers.gravity))
    nothing = hy.expression(kind(0.0))
    if numbers.sea is None or not (numbers.mass or numbers.follows_vertical):
        return gravity, nothing
    angle, first, second, third = roll
    height, g = kind(numbers.sea.height), kind(numbers.gravity)
    sine, cosine = hy.sin(angle), hy.cos(angle)
    across = height * second - g * sine
    along = g * cosine - height * first * first
    square = across * across + along * along
    if not numbers.follows_vertical:
        return hy.sqrt(square), nothing
    across_rate = height * third - g * cosine * first
    along_rate = -first * (g * sine + 2 * height * second)
    return hy.sqrt(square), (across_rate * along - across * along_rate) / square


def _impulse(numbers: Numbers, kind: type) -> Callable[[Any, int], bool]:
    """Return the callback that raises the kinetic energy where theta passes zero.

    v becomes sqrt(v^2 + 2 E/M) in the direction of the motion, M = I (1 + eps x^2); u gains
    (1 + eps x^2) times what v gains.
    """
    eps = mass_ratio(numbers, kind)
    twice = kind(2.0) * kind(numbers.impulse_energy) / kind(numbers.inertia)
    gravity, height, (scale, omega, phase) = _sea_numbers(numbers, kind)
    follows = numbers.follows_vertical

    def kick(state: Any, now: Any) -> None:
        sines = scale * np.sin(omega * now + phase)
        first, third = -sines.sum(), (omega * omega * sines).sum()
        roll, second = state[_ROLL], state[_ROLL_2]
        sine, cosine = np.sin(roll), np.cos(roll)
        across = height * second - gravity * sine
        along = gravity * cosine - height * first * first
        turned = (height * third - gravity * cosine * first) * along
        turned += across * first * (gravity * sine + 2 * height * second)
        lean_rate = turned / (across * across + along * along) if follows else 0 * first
        load = 1 + eps * state[_X] * state[_X]
        speed = (state[_U] - lean_rate - first) / load + lean_rate
        faster = np.sqrt(speed * speed + twice / load)
        state[_U] += load * ((faster if speed > 0 else -faster) - speed)

    if kind is np.float64:
        numba = library(NAME, 'numba', 'numba')
        kick = numba.njit(kick)
        kick(np.ones(_STATES), 0.0)

    def met(integrator: Any, _direction: int) -> bool:
        kick(integrator.state, integrator.time)
        return True

    return met


def _sea_numbers(numbers: Numbers, kind: type) -> tuple[Any, Any, Any]:
    """Return g, z0 and the components: amplitude of the rate, frequency, phase, shape (3, n)."""
    if numbers.sea is None:
        return kind(numbers.gravity), kind(0.0), np.empty((3, 0), dtype=kind)
    omega = angular_frequency(numbers.sea, kind)
    rate = np.asarray(numbers.sea.amplitude, dtype=kind) * omega
    components = np.stack([rate, omega, np.asarray(numbers.sea.phase, dtype=kind)])
    return kind(numbers.gravity), kind(numbers.sea.height), components
