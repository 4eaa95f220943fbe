"""The second way to a reference: Gauss–Legendre of order 16 in double precision.

Equal steps of the plain equations of motion, sums compensated, impulses located to rounding. It
shares nothing with the propagators but the name of the method: no turning frame, no sampling.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mpmath import mp
from numpy.polynomial import legendre

from benchmarks.work_precision.equations.sea import constants_of, sea_from, stretches
from benchmarks.work_precision.equations.wheel_kernels import gauss_advance
from benchmarks.work_precision.problems import WheelProblem
from benchmarks.work_precision.references import exact
from tauto_core.samples import FloatArray

STAGES = 8
STRETCH_S = 60.0
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
        times_s: whole multiples of `STRETCH_S` [s], rising.
        steps_a_second: of the integration.
    """
    numbers = problem.numbers
    constants, rule = constants_of(numbers), gauss_rule(STAGES)
    with mp.workdps(exact.DIGITS):
        state = np.array([float(value) for value in exact.release(numbers)])
    lost, side, wanted, states = np.zeros(2), 1.0, set(times_s), []
    for start, length in stretches(max(times_s), STRETCH_S):
        sea = sea_from(numbers.sea, start)
        steps = round(length * steps_a_second)
        side = gauss_advance(state, lost, side, length, steps, *rule, constants, sea)
        if start + length in wanted:
            with mp.workdps(exact.DIGITS):
                x, p = (mp.mpf(float(value)) for value in state)
                angle, rate = exact.wheel(numbers, start + length, x, p)
            states.append((float(angle), float(rate)))
    return states
