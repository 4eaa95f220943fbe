"""Newton's method for the stage equations, where the fixed-point iteration does not converge.

The unknowns are U_i and V_i of all planes and stages, the equations

    U_i − U₀ − h Σ_j a_ij U̇_j = 0,            V_i likewise.

The slopes at a stage depend on the unknowns at that stage alone, so that one central difference
for each of U and V of each plane gives the whole matrix I − h A ∂(U̇, V̇)/∂(U, V).
"""

from __future__ import annotations

import math

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.lanes import Lanes, combined, fma, lane, largest, load, store, width
from tauto_core.motion.stages import ROUNDING, Step, largest_stage, start_stages, sweep
from tauto_core.motion.work import Omega, Work
from tauto_core.samples import FloatArray

MAX_ITERATIONS = 12


@inlined
def _rows_of(
    r: int, omega: Omega, first: FloatArray, second: FloatArray
) -> tuple[FloatArray, int]:
    """Return the array and the row of unknown r: U of each plane come first, then V of each."""
    return (first, r) if r < len(omega) else (second, r - len(omega))


@inlined
def _slope(r: int, omega: Omega, work: Work) -> Lanes:
    """Return the slope of unknown r at the stages."""
    rows, p = _rows_of(r, omega, work.k1, work.k2)
    return load(rows, p)


@compiled
def _fill_matrix(step: Step) -> None:
    """Fill the matrix I − h A ∂(U̇, V̇)/∂(U, V), by central differences at all stages together."""
    _, _, omega, h, _, _, work = step
    unknowns, stages = 2 * len(omega), width(work.u)
    side = unknowns * stages
    for column in range(unknowns):
        rows, p = _rows_of(column, omega, work.u, work.v)
        there = load(rows, p)
        # near the cube root of a rounding, at which truncation and rounding err alike
        away = 1e-6 * (largest(there) + 1e-9)
        store(rows, p, there + away)
        sweep(step, 0.0, 0)
        for r in range(unknowns):
            store(work.slopes, r, _slope(r, omega, work))
        store(rows, p, there - away)
        sweep(step, 0.0, 0)
        store(rows, p, there)
        for r in range(unknowns):
            slope = (load(work.slopes, r) - _slope(r, omega, work)) / (2.0 * away)
            for i in range(stages):
                for j in range(stages):
                    a = work.coefficients[j * stages + i] * h * lane(slope, j)
                    work.matrix[(r * stages + i) * side + column * stages + j] = -a
    for i in range(side):
        work.matrix[i * side + i] += 1.0


@compiled
def _eliminate(n: int, matrix: FloatArray, right: FloatArray) -> float:
    """Solve matrix · x = right in place, with pivots; return the largest |x|, NaN if singular."""
    for c in range(n):
        pivot = c
        for r in range(c + 1, n):
            pivot = r if abs(matrix[r * n + c]) > abs(matrix[pivot * n + c]) else pivot
        if not abs(matrix[pivot * n + c]) > 0.0:
            return math.nan
        for k in range(c, n):
            low, high = c * n + k, pivot * n + k
            matrix[low], matrix[high] = matrix[high], matrix[low]
        right[c], right[pivot] = right[pivot], right[c]
        for r in range(c + 1, n):
            factor = matrix[r * n + c] / matrix[c * n + c]
            for k in range(c + 1, n):
                matrix[r * n + k] -= factor * matrix[c * n + k]
            right[r] -= factor * right[c]
    biggest = 0.0
    for c in range(n - 1, -1, -1):
        for k in range(c + 1, n):
            right[c] -= matrix[c * n + k] * right[k]
        right[c] /= matrix[c * n + c]
        biggest = biggest if biggest > abs(right[c]) else abs(right[c])
    return biggest


@compiled
def newton(step: Step) -> tuple[bool, float]:
    """Solve the stage equations; return whether the method converges, and the stages' size.

    It has converged when a correction is within four roundings, or within 256 and no smaller than
    the one before. A correction four times the one before ends it: it diverges.
    """
    _, _, omega, h, _, planes, work = step
    unknowns, stages, right = 2 * len(omega), width(work.u), work.right
    start_stages(step)
    before, size = math.inf, 0.0
    for _ in range(MAX_ITERATIONS):
        _fill_matrix(step)
        sweep(step, 0.0, 0)
        for r in range(unknowns):
            rows, p = _rows_of(r, omega, work.u, work.v)
            begin = planes[p].x if r < len(omega) else planes[p].y
            moved = combined(work.coefficients, 0, _slope(r, omega, work))
            wanted = fma(moved, h, begin) - load(rows, p)
            for i in range(stages):
                right[r * stages + i] = lane(wanted, i)
        change = _eliminate(unknowns * stages, work.matrix, right)
        for r in range(unknowns):
            rows, p = _rows_of(r, omega, work.u, work.v)
            for i in range(stages):
                rows[p * stages + i] += right[r * stages + i]
        size = largest_stage(omega, work)
        if not math.isfinite(change):
            return False, size
        floor = 4.0 * ROUNDING * size
        if change <= floor or (not change < before and change <= 64.0 * floor):
            sweep(step, 0.0, 0)
            return True, size
        if not change < 4.0 * before:
            return False, size
        before = change
    return False, size
