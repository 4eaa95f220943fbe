"""A step by Gauss collocation in a rotating frame: its solution, error, end and interior.

Eight stages make the method symmetric, symplectic and of order 16 in the length of the step,
sixteen of order 32. The error falls with the strength of the disturbance, too: undisturbed motion
is exact. The state is kept in twofold numbers (`rotation`) and rotated in twofold precision, so
that rounding errors of n steps grow like √n. The equations are those of `stages`.

Source: M. Antoñana, J. Makazaga, A. Murua, Reducing and monitoring round-off error propagation for
symplectic implicit Runge–Kutta schemes, Numer. Algorithms 76 (2017).
"""

from __future__ import annotations

import math
from typing import TypeAlias

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.lanes import combined, fma, load, store, total, width
from tauto_core.motion.rotation import multiply_exactly, rotation, sum_exactly
from tauto_core.motion.stage_newton import newton
from tauto_core.motion.stages import MAX_SWEEPS, Step, fill_rotations, start_stages, sweep
from tauto_core.motion.work import Omega, Planes, Work

Twofold: TypeAlias = tuple[float, float]


@compiled
def collocate(step: Step, settled: float) -> tuple[float, bool]:
    """Solve the stage equations of a step.

    Args:
        step: to be solved.
        settled: error to which the stage equations are iterated, relative to the state,
            >= `stages.SETTLED`.

    Returns:
        The last Legendre coefficient of the slopes times h, relative to the state – infinite
        without convergence – and whether Newton's method was needed.
    """
    _, _, omega, h, _, _, work = step
    fill_rotations(step)
    start_stages(step)
    converged, size = sweep(step, settled, MAX_SWEEPS)
    needs_newton = not converged
    if needs_newton:
        converged, size = newton(step)
        if not converged:
            return math.inf, True
    last = 0.0
    for slopes in (work.k1, work.k2):
        for p in range(len(omega)):
            coefficient = h * total(load(work.tail) * load(slopes, p))
            if not math.isfinite(coefficient):
                return math.inf, needs_newton
            last = max(last, abs(coefficient))
    return last / size if size > 0.0 else 0.0, needs_newton


@inlined
def _rotated(
    cosine: Twofold, sine: Twofold, a: Twofold, b: Twofold, add_a: float, add_b: float
) -> Twofold:
    """Return cos·(a + add_a) + sin·(b + add_b) for twofold cos, sin, a, b and small additions."""
    first, first_rest = multiply_exactly(cosine[0], a[0])
    second, second_rest = multiply_exactly(sine[0], b[0])
    whole, rest = sum_exactly(first, second)
    rest += first_rest + second_rest
    rest += cosine[1] * a[0] + sine[1] * b[0]
    rest += cosine[0] * (a[1] + add_a) + sine[0] * (b[1] + add_b)
    return sum_exactly(whole, rest)


@compiled
def finish(step: Step) -> None:
    """Fill `work.end` with the state at the end of the step last collocated.

    U₁ = U₀ + h Σ b_i U̇_i and V₁ likewise, rotated by ωh: X₁ = cU₁ + sV₁, Y₁ = cV₁ − sU₁.
    """
    _, _, omega, h, kind, planes, work = step
    weights = load(work.quadrature)
    for p in range(len(omega)):
        over, begin, end = work.rotations[kind * len(omega) + p], planes[p], work.end[p]
        cosine, sine = (over.cos, over.cos_rest), (over.sin, over.sin_rest)
        minus = -sine[0], -sine[1]
        u, v = (begin.x, begin.x_rest), (begin.y, begin.y_rest)
        add_u = h * total(weights * load(work.k1, p))
        add_v = h * total(weights * load(work.k2, p))
        end.x, end.x_rest = _rotated(cosine, sine, u, v, add_u, add_v)
        end.y, end.y_rest = _rotated(cosine, minus, v, u, add_v, add_u)


@compiled
def copy_planes(omega: Omega, source: Planes, target: Planes) -> None:
    """Copy the state of each plane."""
    for p in range(len(omega)):
        old, new = source[p], target[p]
        new.x, new.x_rest, new.y, new.y_rest = old.x, old.x_rest, old.y, old.y_rest


@compiled
def fill_integrals(omega: Omega, work: Work) -> None:
    """Fill f1 and f2, the stage polynomials' integrals in powers, which `inside` evaluates."""
    for p in range(len(omega)):
        store(work.f1, p, combined(work.expansion, 0, load(work.k1, p)))
        store(work.f2, p, combined(work.expansion, 0, load(work.k2, p)))


@compiled
def inside(
    omega: Omega, p: int, h: float, xi: float, planes: Planes, work: Work
) -> tuple[float, float]:
    """Return X and Y of plane p at a fraction ξ of the step, from the stage polynomials.

    U = U₀ + hξ Σ_n G_n tⁿ with t = 2ξ − 1 and the powers G_n of `gauss`; V likewise.
    """
    stages, t = width(work.f1), 2.0 * xi - 1.0
    first = p * stages
    u, v = work.f1[first + stages - 1], work.f2[first + stages - 1]
    for n in range(stages - 2, -1, -1):
        u = fma(u, t, work.f1[first + n])
        v = fma(v, t, work.f2[first + n])
    u, v = fma(u, xi * h, planes[p].x), fma(v, xi * h, planes[p].y)
    c, s = rotation(omega[p] * (xi * h))
    return c * u + s * v, c * v - s * u
