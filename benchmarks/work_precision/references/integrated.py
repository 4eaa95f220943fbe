"""References by integration, in two ways: heyoka in long double, and Gauss–Legendre in double."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from mpmath import mp
from numpy.polynomial import legendre

from benchmarks.work_precision.equations.sea import constants_of, sea_from, stretches, turns_at
from benchmarks.work_precision.equations.wheel_kernels import gauss_advance
from benchmarks.work_precision.peer import MissingPeerError
from benchmarks.work_precision.problems import HungCase, Numbers, Sea, WheelProblem
from benchmarks.work_precision.references import exact
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import TautoError

# -----------------------------------------------------------------------------
# The second way to a reference: Gauss–Legendre of order 16 in double precision.
#
# Equal steps of the plain equations of motion, sums compensated, impulses located to rounding. It
# shares nothing with the propagators but the name of the method: no turning frame, no sampling.

STAGES = 8
GAUSS_STRETCH_S = 60.0
"""Short, so that the phases of the sea round no worse than the state."""


def gauss_rule(stages: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return nodes c (s,), a_ij/b_j (s, s) and weights b (s,) of Gauss–Legendre on [0, 1].

    a_ij integrates the Lagrange polynomial of node j up to node i; both are written in Legendre
    polynomials, whose integrals are (P_k+1 - P_k-1)/(2k + 1). a_ij/b_j + a_ji/b_i = 1 is what
    makes the method symplectic; it is kept in spite of rounding, or the amplitude drifts
    (Antoñana, Makazaga, Murua 2017).
    """
    x, w = legendre.leggauss(stages)
    values = legendre.legvander(x, stages)
    below = np.hstack([-np.ones((stages, 1)), values[:, : stages - 1]])
    integrals = values[:, 1:] - below
    ratio = 0.5 * (integrals @ values[:, :stages].T)
    below_diagonal = np.tril(ratio, -1)
    ratio = below_diagonal + np.triu(1.0 - below_diagonal.T, 1) + 0.5 * np.eye(stages)
    return 0.5 * (1.0 + x), ratio, 0.25 * (w + w[::-1])


def gauss_states(
    problem: WheelProblem, times_s: Sequence[float], steps_a_second: float
) -> list[tuple[float, float]]:
    """Return theta [rad] and theta' [rad/s] of a weight-driven problem at rising times.

    Args:
        problem: b, c or e.
        times_s: whole multiples of `GAUSS_STRETCH_S` [s], rising.
        steps_a_second: of the integration.
    """
    numbers = problem.numbers
    constants, rule = constants_of(numbers), gauss_rule(STAGES)
    with mp.workdps(exact.DIGITS):
        state = np.array([float(value) for value in exact.release(numbers)])
    lost, side, wanted, states = np.zeros(2), 1.0, set(times_s), []
    for start, length in stretches(max(times_s), GAUSS_STRETCH_S):
        sea = sea_from(numbers.sea, start)
        steps = round(length * steps_a_second)
        side = gauss_advance(state, lost, side, length, steps, *rule, constants, sea)
        if start + length in wanted:
            with mp.workdps(exact.DIGITS):
                x, p = (mp.mpf(float(value)) for value in state)
                angle, rate = exact.wheel(numbers, start + length, x, p)
            states.append((float(angle), float(rate)))
    return states


# -----------------------------------------------------------------------------
# The first way to a reference: heyoka's Taylor method in x87 long double, 64 bits of fraction.
#
# Its state is (x, p) like that of the kernels, but its equations are written anew, as expressions.

TOLERANCE = 1e-19
STRETCH_S = 3600.0
COOLDOWN_S = 0.1
"""After an impulse no other is looked for so long: a fifth of a half swing [s]."""
_DIGITS = 25

Long = np.longdouble


class LongDoubleError(TautoError):
    """No long double of 64 bits here, or an integration that did not arrive."""


def long_double_states(
    problem: WheelProblem, times_s: Sequence[float], tolerance: float = TOLERANCE
) -> list[tuple[str, str]]:
    """Return theta [rad] and theta' [rad/s] in 20 digits of a weight-driven problem.

    Args:
        problem: b, c or e.
        times_s: rising [s].
        tolerance: of a Taylor step, relative.

    Raises:
        LongDoubleError: this processor has no x87 long double.
        MissingPeerError: heyoka is not installed.
    """
    hy, numbers = require_long_double(), problem.numbers
    with mp.workdps(exact.DIGITS):
        start = [_long(value) for value in exact.release(numbers)]
    integrator, states, wanted = _integrator(hy, numbers, start, tolerance), [], set(times_s)
    cuts = sorted({begin for begin, _ in stretches(max(times_s), STRETCH_S)} | wanted)
    for begin, end in zip([0.0, *cuts], cuts, strict=False):
        if begin == end:
            continue
        integrator.time = Long(0)
        integrator.pars[:] = _phases(numbers.sea, begin)
        propagate(integrator, Long(end - begin), begin)
        if end in wanted:
            with mp.workdps(exact.DIGITS):
                x, p = (mp.mpf(_digits(value)) for value in integrator.state)
                angle, rate = exact.wheel(numbers, end, x, p)
                states.append((mp.nstr(angle, 20), mp.nstr(rate, 20)))
    return states


def require_long_double() -> Any:
    """Return heyoka's module where it can compute in x87 long double.

    Raises:
        LongDoubleError: this processor has no such type.
        MissingPeerError: heyoka is not installed.
    """
    if np.finfo(Long).nmant != 63:
        raise LongDoubleError(
            f'long double has {np.finfo(Long).nmant} bits of fraction here, not the 63 of x87. '
            'Make the references on x86-64 Linux'
        )
    try:
        import heyoka
    except ImportError:
        raise MissingPeerError('heyoka') from None
    return heyoka


def propagate(integrator: Any, end: Any, begin_s: float) -> None:
    """Advance heyoka's integrator to its time `end`; its zero is at `begin_s` of the run [s].

    Raises:
        LongDoubleError: it did not arrive.
    """
    import heyoka

    outcome = integrator.propagate_until(end)[0]
    if outcome != heyoka.taylor_outcome.time_limit:
        raise LongDoubleError(
            f'heyoka stopped with {outcome} at {begin_s + float(integrator.time):.6f} s'
        )


def _integrator(hy: Any, numbers: Numbers, start: list[Any], tolerance: float) -> Any:
    x, p, t = hy.make_vars('x', 'p', 't')
    inertia, lever = hy.expression(Long(numbers.inertia)), hy.expression(Long(numbers.lever_rate))
    mass, viscous = hy.expression(Long(numbers.mass)), hy.expression(Long(numbers.viscous))
    # heyoka derives by variables, not by its own time
    roll, gravity, vertical = _felt(hy, numbers, t)
    tilting, rolling = hy.diff(vertical, t), hy.diff(roll, t)
    roll, gravity, vertical, tilting, rolling = (
        hy.subs(each, {t: hy.time}) for each in (roll, gravity, vertical, tilting, rolling)
    )
    carried = mass * lever**2
    varying = inertia + carried * x**2
    speed = (p - inertia * tilting) / varying
    torque = carried * x * speed**2 - mass * gravity * lever * x
    wheel_speed = speed + tilting - rolling
    if numbers.viscous:
        torque = torque - viscous * wheel_speed
    events = []
    if numbers.impulse_energy:
        at_event = hy.cfunc([varying, wheel_speed], vars=[x, p], fp_type=Long, compact_mode=True)
        events.append(_impulses(hy, x + vertical - roll, at_event, numbers))
    return hy.taylor_adaptive(
        [(x, speed), (p, torque)],
        np.array(start, Long),
        fp_type=Long,
        tol=Long(tolerance),
        compact_mode=True,
        t_events=events,
        pars=_phases(numbers.sea, 0.0),
    )


def _impulses(hy: Any, wheel_angle: Any, at_event: Any, numbers: Numbers) -> Any:
    energy = Long(numbers.impulse_energy)

    def strike(integrator: Any, _sign: int) -> bool:
        mass, speed = at_event(
            np.array(integrator.state), pars=np.array(integrator.pars), time=integrator.time
        )
        faster = np.sqrt(speed * speed + 2 * energy / mass)
        integrator.state[1] += mass * (np.copysign(faster, speed) - speed)
        return True

    return hy.t_event(wheel_angle, fp_type=Long, callback=strike, cooldown=Long(COOLDOWN_S))


def _felt(hy: Any, numbers: Numbers, time: Any) -> tuple[Any, Any, Any]:
    """Return roll, apparent gravity and apparent vertical as expressions of a variable."""
    sea, g = numbers.sea, hy.expression(Long(numbers.gravity))
    if sea is None:
        return hy.expression(Long(0)), g, hy.expression(Long(0))
    turn = 2 * _long(mp.pi)
    roll = hy.sum(
        [
            hy.expression(Long(a))
            * hy.cos(hy.expression(turn / Long(float(period))) * time + hy.par[i])
            for i, (a, period) in enumerate(zip(sea.amplitude, sea.period, strict=True))
        ]
    )
    height = hy.expression(Long(sea.height))
    across = hy.diff(hy.diff(-height * hy.sin(roll), time), time)
    up = hy.diff(hy.diff(height * hy.cos(roll), time), time) + g
    return roll, hy.sqrt(across**2 + up**2), -hy.atan2(across, up)


def _phases(sea: Sea | None, time_s: float) -> Any:
    if sea is None:
        return np.empty(0, Long)
    with mp.workdps(_DIGITS):
        angles = [
            mp.mpf(float(phase)) + 2 * mp.pi * mp.mpf(turn.numerator) / turn.denominator
            for phase, turn in zip(sea.phase, turns_at(sea, time_s), strict=True)
        ]
        return np.array([_long(angle) for angle in angles], Long)


def _long(value: Any) -> Any:
    with mp.workdps(_DIGITS):
        return Long(mp.nstr(+value, _DIGITS))


def _digits(value: Any) -> str:
    return np.format_float_scientific(value, precision=24, unique=False)


# -----------------------------------------------------------------------------
# Both ways to a reference of the suspended case.
#
# The first writes nothing but the energies: heyoka forms Lagrange's equations of them and solves
# them in x87 long double. The second is Gauss–Legendre of order 16 in double precision on the
# equations of the peers (`equations.case_kernels`).


def long_double_case(
    case: HungCase, times_s: Sequence[float], tolerance: float = TOLERANCE
) -> list[list[str]]:
    """Return theta, phi [rad] and their rates [rad/s] at rising times [s], in 20 digits.

    Raises:
        LongDoubleError: this processor has no x87 long double, or heyoka stopped.
        MissingPeerError: heyoka is not installed.
    """
    hy = require_long_double()
    theta, phi, theta_rate, phi_rate = hy.make_vars('theta', 'phi', 'theta_rate', 'phi_rate')
    e, c, k, g = (hy.expression(Long(number)) for number in (case.e, case.c, case.k, case.gravity))
    half = hy.expression(Long(0.5))
    # of the centre of gravity, at e (sin, cos) theta + c (sin, cos) phi
    lateral = e * hy.cos(theta) * theta_rate + c * hy.cos(phi) * phi_rate
    down = e * hy.sin(theta) * theta_rate + c * hy.sin(phi) * phi_rate
    moving = half * (lateral**2 + down**2 + k**2 * phi_rate**2)
    hanging = g * (e * hy.cos(theta) + c * hy.cos(phi))
    equations = hy.lagrangian(moving + hanging, [theta, phi], [theta_rate, phi_rate])
    start = np.array([case.release_angle, case.release_angle, 0.0, 0.0], Long)
    integrator = hy.taylor_adaptive(
        equations, start, fp_type=Long, tol=Long(tolerance), high_accuracy=True
    )
    states = []
    for time in times_s:
        propagate(integrator, Long(time), 0.0)
        states.append([np.format_float_positional(x, 20, unique=False) for x in integrator.state])
    return states


def gauss_case(
    case: HungCase, times_s: Sequence[float], steps_a_second: float
) -> list[FloatArray]:
    """Return theta, phi [rad] and their rates [rad/s] at rising times.

    Args:
        case: what swings.
        times_s: multiples of `GAUSS_STRETCH_S` [s].
        steps_a_second: of the integration.
    """
    from benchmarks.work_precision.equations.case_kernels import case_gauss_advance

    _, ratio, weights = gauss_rule(STAGES)
    numbers: Any = case.e, case.c, case.k, case.gravity
    state = np.array([case.release_angle, case.release_angle, 0.0, 0.0])
    lost, wanted, states = np.zeros(4), set(times_s), []
    for begin, length in stretches(max(times_s), GAUSS_STRETCH_S):
        steps = round(length * steps_a_second)
        case_gauss_advance(state, lost, length / steps, steps, ratio, weights, numbers)
        if begin + length in wanted:
            states.append(state.copy())
    return states
