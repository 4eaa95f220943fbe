"""Gauss collocation of the disturbance in a rotating (Lawson) frame.

There are any number P of planes (modes), each a harmonic oscillator with a disturbance:

    Ẋ = ωY + d₁,    Ẏ = −ωX + d₂          (X a coordinate, ωY nearly its rate)

In coordinates U, V that stand still without disturbance, X = cU + sV, Y = cV − sU with c, s of
the angle ω(t − t₀), only the disturbance is left to integrate:

    U̇ = c d₁ − s d₂,    V̇ = s d₁ + c d₂.

Eight Gauss stages make this symmetric, symplectic and of order 16 in the step, sixteen of order
32; the error falls with the strength of the disturbance too, and the undisturbed motion is exact.
The stage equations are iterated, to rounding if need be; where the disturbance is too strong for
that, Newton's method takes over. The state is kept in twofold numbers and rotated in twofold
precision, so that the rounding error of n steps grows like √n.

The caller defines the disturbance: the method `disturb(mode, omega, work)` of its `system` reads
the rows X, Y (and rows of its own from OUTSIDE on) and writes the rows D1, D2, each as lanes, one
for each stage. `row` returns their places in `work`, which `make_memory` makes.

Sources: J. D. Lawson, SIAM J. Numer. Anal. 4 (1967); M. Antoñana, J. Makazaga, A. Murua, Reducing
and monitoring round-off error propagation for symplectic implicit Runge–Kutta schemes, Numer.
Algorithms 76 (2017).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from tauto_core.kernels import compiled, inlined, overload
from tauto_core.motion.gauss import gauss
from tauto_core.motion.lanes import (
    SIZE,
    WIDE_SIZE,
    combined,
    combined_both,
    filled,
    fma,
    folded_both,
    lane,
    larger,
    largest,
    load,
    pointer,
    store,
    total,
    wide_pointer,
    width,
)
from tauto_core.motion.rotation import (
    multiply_exactly,
    rotation,
    sum_exactly,
    twofold_rotation,
)
from tauto_core.samples import FloatArray

TERMS = 24
"""Largest number of powers in the polynomials of the forcing."""

COEFFICIENTS, EXPANSION, FOLDED, QUADRATURE, FRACTIONS, TAIL, PIECE = 0, 16, 32, 41, 42, 43, 44
FIRST = PIECE + TERMS
K1, K2, U, V, X, Y, D1, D2, F1, F2, WHOLE, PART, OUTSIDE = *range(11), 12, 14
TURNED = 5
"""Numbers for each plane and kind of step in `turned`: h, then cos and sin of ωh, each twofold."""

WHOLE_STEP, PART_STEP = 0, 1
MAX_SWEEPS = 60
MAX_NEWTON = 12
ROUNDING = 2.0**-53
SETTLED = 0.25 * ROUNDING
"""Best relative accuracy to which stages can be computed."""


@inlined
def row(kind: int, planes: int, p: int) -> int:
    """Return the row of `work` that holds K1, … or PART of plane p."""
    return FIRST + kind * planes + p


class Memory(NamedTuple):
    """The working memory of steps; a few kB, made once.

    Attributes:
        work: rows with one number for each stage: constants, the forcing's piece, the planes
            (`row`) and the system, one after the other. They begin at cache lines, since a row
            across two lines costs twice the time.
        turned: rotations over whole and part steps, TURNED·P numbers of each.
        end: X and Y of each plane at the end of a step, each in two doubles, (4P,).
        matrix, right, slopes: the linear system of Newton's method, (2PS · 2PS,), (2PS,), (2P ·
            S,) of S stages.
        wide: None for eight stages, 0 for sixteen: compiled code distinguishes them by the type.
    """

    work: FloatArray
    turned: FloatArray
    end: FloatArray
    matrix: FloatArray
    right: FloatArray
    slopes: FloatArray
    wide: int | None


def make_memory(planes: int, more: int, stages: int = SIZE) -> Memory:
    """Return the memory of P planes, with so many rows from OUTSIDE on and 8 or 16 stages."""
    rows = FIRST + OUTSIDE * planes + more
    raw = np.zeros(stages * (rows + 1))
    first = -(raw.ctypes.data // raw.itemsize) % stages
    work = raw[first : first + stages * rows].reshape(rows, stages)
    constants = gauss(stages)
    work[COEFFICIENTS : COEFFICIENTS + stages] = constants.columns
    work[EXPANSION : EXPANSION + stages] = constants.integral.T
    work[FOLDED : FOLDED + stages // 2 + 1] = constants.folded
    work[QUADRATURE] = constants.weights
    work[FRACTIONS] = constants.nodes
    work[TAIL] = constants.projection[-1]
    unknowns = 2 * planes * stages
    return Memory(
        work.reshape(-1),
        np.full(2 * TURNED * planes, math.nan),
        np.zeros(4 * planes),
        np.zeros(unknowns * unknowns),
        np.zeros(unknowns),
        np.zeros(unknowns),
        0 if stages == WIDE_SIZE else None,
    )


def _rows(work: Any, wide: Any) -> Any:
    raise TypeError('_rows runs in compiled code only')


@overload(_rows)
def _rows_of(work: Any, wide: Any) -> Any:
    if wide is None:
        return lambda work, wide: pointer(work)
    return lambda work, wide: wide_pointer(work)


@inlined
def pointers(memory: Any) -> Any:
    """Return the memory as pointers, which kernels pass to each other."""
    work, turned, end, matrix, right, slopes, wide = memory
    return Memory(
        _rows(work, wide),
        pointer(turned),
        pointer(end),
        pointer(matrix),
        pointer(right),
        _rows(slopes, wide),
        wide,
    )


@inlined
def _short_of_one(cosine: float, sine: float) -> float:
    """Return 1 − cos² − sin² of rounded numbers, exactly enough."""
    first, first_rest = multiply_exactly(cosine, cosine)
    second, second_rest = multiply_exactly(sine, sine)
    square, rest = sum_exactly(first, second)
    return (1.0 - square) - (rest + first_rest + second_rest)


@compiled
def turn_to(omega: Any, h: float, kind: int, work: Any, turned: Any) -> None:
    """Fill the rotations to the stages and the end of a step of h, unless they are there.

    Steps to events have lengths of their own, so that the rounding of their angles varies; for
    them doubles are enough, corrected so that they neither stretch nor shrink the state.
    """
    planes = len(omega)
    if turned[kind * TURNED * planes] == h:
        return
    for p in range(planes):
        first, angle = TURNED * (kind * planes + p), omega[p] * h
        c, s = rotation(load(work, FRACTIONS) * angle)
        store(work, row(WHOLE + 2 * kind, planes, p), c)
        store(work, row(WHOLE + 2 * kind, planes, p) + planes, s)
        turned[first] = h
        if kind == WHOLE_STEP:
            whole_cosine, whole_sine = twofold_rotation(omega[p], h)
            turned[first + 1], turned[first + 2] = whole_cosine
            turned[first + 3], turned[first + 4] = whole_sine
        else:
            cosine, sine = rotation(angle)
            more = 0.5 * _short_of_one(cosine, sine)
            turned[first + 1], turned[first + 2] = cosine, more * cosine
            turned[first + 3], turned[first + 4] = sine, more * sine


@inlined
def _evaluate(system: Any, mode: Any, omega: Any, kind: int, work: Any) -> None:
    """Fill the slopes K1, K2 from the stages U, V."""
    planes = len(omega)
    table = row(WHOLE + 2 * kind, planes, 0)
    for p in range(planes):
        c, s = load(work, table + p), load(work, table + planes + p)
        u, v = load(work, row(U, planes, p)), load(work, row(V, planes, p))
        store(work, row(X, planes, p), fma(c, u, s * v))
        store(work, row(Y, planes, p), fma(c, v, -(s * u)))
    system.disturb(mode, omega, work)
    for p in range(planes):
        c, s = load(work, table + p), load(work, table + planes + p)
        d1, d2 = load(work, row(D1, planes, p)), load(work, row(D2, planes, p))
        store(work, row(K1, planes, p), fma(c, d1, -(s * d2)))
        store(work, row(K2, planes, p), fma(s, d1, c * d2))


@inlined
def _move_stages(omega: Any, h: float, state: Any, work: Any) -> float:
    """Update the stages U, V from their slopes; return the largest change of a stage."""
    planes = len(omega)
    change = filled(work, 0.0)
    for p in range(planes):
        k1, k2 = load(work, row(K1, planes, p)), load(work, row(K2, planes, p))
        if width(work) == WIDE_SIZE:
            u, v = folded_both(work, FOLDED, row(F1, planes, 2 * p), k1, k2)
        else:
            u, v = combined_both(work, COEFFICIENTS, k1, k2)
        u, v = fma(u, h, state[4 * p]), fma(v, h, state[4 * p + 2])
        moved = larger(u - load(work, row(U, planes, p)), v - load(work, row(V, planes, p)))
        change = larger(change, moved)
        store(work, row(U, planes, p), u)
        store(work, row(V, planes, p), v)
    return largest(change)


@inlined
def _size(planes: int, work: Any) -> float:
    """Return the largest magnitude of the stages."""
    size = filled(work, 0.0)
    for r in range(2 * planes):
        size = larger(size, load(work, row(U, planes, r)))
    return largest(size)


@compiled
def _iterate(
    system: Any,
    mode: Any,
    omega: Any,
    h: float,
    kind: int,
    settled: float,
    most: int,
    state: Any,
    work: Any,
) -> tuple[bool, float]:
    """Sweep until the stages have settled; return whether they do, and their size.

    They have settled if, at the measured rate of convergence, less than that is still to come. The
    slopes are those of the last stages; after no sweeps, of the stages as they are. The
    disturbance is compiled here, once.

    Args:
        most: largest number of sweeps.
    """
    before, size, floor = math.inf, 0.0, 0.0
    settles, ends = False, False
    for n in range(most + 1):
        _evaluate(system, mode, omega, kind, work)
        if ends or n == most:
            break
        change = _move_stages(omega, h, state, work)
        if n == 0:
            size = _size(len(omega), work)
            floor = settled * size
        if change <= floor or (n > 0 and change * change <= floor * (before - change)):
            settles = ends = True
        elif not change < before and n > 0:
            settles, ends = change <= 64.0 * ROUNDING * size, True
        before = change
    return settles, size


@inlined
def _begin(planes: int, state: Any, work: Any) -> None:
    """Set the stages to the state at the beginning of the step."""
    for p in range(planes):
        store(work, row(U, planes, p), filled(work, state[4 * p]))
        store(work, row(V, planes, p), filled(work, state[4 * p + 2]))


@compiled
def _linearised(
    system: Any,
    mode: Any,
    omega: Any,
    h: float,
    kind: int,
    state: Any,
    work: Any,
    slopes: Any,
    matrix: Any,
) -> None:
    """Fill the matrix I − h A ∂K/∂(U, V), by central differences at all stages together."""
    planes = len(omega)
    unknowns = 2 * planes
    stages = width(work)
    side = unknowns * stages
    for column in range(unknowns):
        place = row(U, planes, column)
        there = load(work, place)
        step = 1e-6 * (largest(there) + 1e-9)
        store(work, place, there + step)
        _iterate(system, mode, omega, h, kind, 0.0, 0, state, work)
        for r in range(unknowns):
            store(slopes, r, load(work, row(K1, planes, r)))
        store(work, place, there - step)
        _iterate(system, mode, omega, h, kind, 0.0, 0, state, work)
        store(work, place, there)
        for r in range(unknowns):
            slope = (load(slopes, r) - load(work, row(K1, planes, r))) / (2.0 * step)
            for i in range(stages):
                for j in range(stages):
                    a = work[(COEFFICIENTS + j) * stages + i] * h * lane(slope, j)
                    matrix[(r * stages + i) * side + column * stages + j] = -a
    for i in range(side):
        matrix[i * side + i] += 1.0


@compiled
def _eliminate(n: int, matrix: Any, right: Any) -> float:
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
def _solve(
    system: Any, mode: Any, omega: Any, h: float, kind: int, state: Any, memory: Any
) -> tuple[bool, float]:
    """Solve the stage equations by Newton's method; return whether it converges, and the size."""
    work, _, _, matrix, right, slopes, _ = memory
    planes, stages = len(omega), width(memory.work)
    unknowns = 2 * planes
    _begin(planes, state, work)
    before, size = math.inf, 0.0
    for _ in range(MAX_NEWTON):
        _linearised(system, mode, omega, h, kind, state, work, slopes, matrix)
        _iterate(system, mode, omega, h, kind, 0.0, 0, state, work)
        for r in range(unknowns):
            begin = state[4 * (r % planes) + 2 * (r // planes)]
            new = fma(combined(work, COEFFICIENTS, load(work, row(K1, planes, r))), h, begin)
            wanted = new - load(work, row(U, planes, r))
            for i in range(stages):
                right[r * stages + i] = lane(wanted, i)
        change = _eliminate(unknowns * stages, matrix, right)
        for r in range(unknowns):
            for i in range(stages):
                work[row(U, planes, r) * stages + i] += right[r * stages + i]
        size = _size(planes, work)
        if not math.isfinite(change):
            return False, size
        floor = 4.0 * ROUNDING * size
        if change <= floor or (not change < before and change <= 64.0 * floor):
            _iterate(system, mode, omega, h, kind, 0.0, 0, state, work)
            return True, size
        if not change < 4.0 * before:
            return False, size
        before = change
    return False, size


@compiled
def collocate(
    system: Any,
    mode: Any,
    omega: Any,
    h: float,
    kind: int,
    settled: float,
    state: Any,
    memory: Any,
) -> tuple[float, bool]:
    """Solve the stage equations of a step of h from `state`.

    Args:
        system: the system, which defines the disturbance.
        mode: passed to its `disturb`.
        omega: ω of each plane [rad/s], a tuple.
        h: length of the step [s], |ωh| ≤ MAX_ANGLE.
        kind: WHOLE_STEP or PART_STEP: which table of rotations it uses.
        settled: part of the state to which the stage equations are iterated, >= SETTLED.
        state: X and Y of each plane, each in two doubles, shape (4P,).
        memory: from `make_memory`.

    Returns:
        Last Legendre coefficient of the slopes over the step, relative to the state – infinite
        without convergence – and whether Newton's method was needed.
    """
    work, turned = memory.work, memory.turned
    planes = len(omega)
    turn_to(omega, h, kind, work, turned)
    _begin(planes, state, work)
    converged, size = _iterate(system, mode, omega, h, kind, settled, MAX_SWEEPS, state, work)
    newton = not converged
    if newton:
        converged, size = _solve(system, mode, omega, h, kind, state, memory)
        if not converged:
            return math.inf, True
    last = 0.0
    for r in range(2 * planes):
        tail = h * total(load(work, TAIL) * load(work, row(K1, planes, r)))
        if not math.isfinite(tail):
            return math.inf, newton
        last = max(last, abs(tail))
    return last / size if size > 0.0 else 0.0, newton


@inlined
def _turned(cosine: Any, sine: Any, a: Any, b: Any, add_a: float, add_b: float) -> Any:
    """Return cos·(a + add_a) + sin·(b + add_b) for twofold cos, sin, a, b and small additions."""
    first, first_rest = multiply_exactly(cosine[0], a[0])
    second, second_rest = multiply_exactly(sine[0], b[0])
    whole, rest = sum_exactly(first, second)
    rest += first_rest + second_rest
    rest += cosine[1] * a[0] + sine[1] * b[0]
    rest += cosine[0] * (a[1] + add_a) + sine[0] * (b[1] + add_b)
    return sum_exactly(whole, rest)


@compiled
def finish(omega: Any, h: float, kind: int, state: Any, memory: Any) -> None:
    """Fill `memory.end` with the state at the end of the step last collocated."""
    work, turned, end = memory.work, memory.turned, memory.end
    planes = len(omega)
    weights = load(work, QUADRATURE)
    for p in range(planes):
        at = TURNED * (kind * planes + p)
        cosine = turned[at + 1], turned[at + 2]
        sine = turned[at + 3], turned[at + 4]
        minus = -sine[0], -sine[1]
        u, v = (state[4 * p], state[4 * p + 1]), (state[4 * p + 2], state[4 * p + 3])
        add_u = h * total(weights * load(work, row(K1, planes, p)))
        add_v = h * total(weights * load(work, row(K2, planes, p)))
        end[4 * p], end[4 * p + 1] = _turned(cosine, sine, u, v, add_u, add_v)
        end[4 * p + 2], end[4 * p + 3] = _turned(cosine, minus, v, u, add_v, add_u)


@compiled
def copy_state(planes: int, source: Any, target: Any) -> None:
    """Copy X and Y of each plane, in two doubles each."""
    for i in range(4 * planes):
        target[i] = source[i]


@compiled
def expand(planes: int, work: Any) -> None:
    """Fill F1, F2 with the slopes' integrals over the fraction, in powers: for `between`."""
    for r in range(2 * planes):
        slopes = load(work, row(K1, planes, r))
        store(work, row(F1, planes, r), combined(work, EXPANSION, slopes))


@compiled
def between(omega: Any, p: int, h: float, xi: float, state: Any, work: Any) -> Any:
    """Return X and Y of plane p at the fraction xi of the step, from the stage polynomials."""
    planes, stages, t = len(omega), width(work), 2.0 * xi - 1.0
    first, second = row(F1, planes, p) * stages, row(F2, planes, p) * stages
    u, v = work[first + stages - 1], work[second + stages - 1]
    for n in range(stages - 2, -1, -1):
        u = fma(u, t, work[first + n])
        v = fma(v, t, work[second + n])
    u, v = fma(u, xi * h, state[4 * p]), fma(v, xi * h, state[4 * p + 2])
    c, s = rotation(omega[p] * (xi * h))
    return c * u + s * v, c * v - s * u
