"""Both ways to a reference of the suspended case.

The first writes nothing but the energies: heyoka forms Lagrange's equations of them and solves
them in x87 long double. The second is Gauss–Legendre of order 16 in double precision on the
equations of the peers (`equations.case_kernels`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.work_precision.equations.sea import stretches
from benchmarks.work_precision.problems import HungCase
from benchmarks.work_precision.references.gauss import STAGES, STRETCH_S, gauss_rule
from benchmarks.work_precision.references.long_double import (
    TOLERANCE,
    Long,
    propagate,
    require_long_double,
)
from tauto_core.samples import FloatArray


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
    """Return theta, phi [rad] and their rates [rad/s] at rising times, multiples of `STRETCH_S`.

    Args:
        case: what swings.
        times_s: [s].
        steps_a_second: of the integration.
    """
    from benchmarks.work_precision.equations.case_kernels import case_gauss_advance

    _, ratio, weights = gauss_rule(STAGES)
    numbers: Any = case.e, case.c, case.k, case.gravity
    state = np.array([case.release_angle, case.release_angle, 0.0, 0.0])
    lost, wanted, states = np.zeros(4), set(times_s), []
    for begin, length in stretches(max(times_s), STRETCH_S):
        steps = round(length * steps_a_second)
        case_gauss_advance(state, lost, length / steps, steps, ratio, weights, numbers)
        if begin + length in wanted:
            states.append(state.copy())
    return states
