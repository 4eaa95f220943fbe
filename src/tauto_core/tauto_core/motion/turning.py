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

Who uses it says what disturbs: the method `disturb(mode, omega, work)` of its `system` reads the
rows x and y of the record `work` (and rows of its own, `work.nodes`) and writes d1 and d2.

Sources: J. D. Lawson, SIAM J. Numer. Anal. 4 (1967); M. Antoñana, J. Makazaga, A. Murua, Reducing
and monitoring round-off error propagation for symplectic implicit Runge–Kutta schemes, Numer.
Algorithms 76 (2017).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeAlias

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.lanes import (
    WIDE_SIZE,
    Lanes,
    combined,
    combined_both,
    filled,
    fma,
    folded_both,
    lane,
    larger,
    largest,
    load,
    store,
    total,
    width,
)
from tauto_core.motion.rotation import (
    multiply_exactly,
    rotation,
    sum_exactly,
    twofold_rotation,
)
from tauto_core.motion.work import WHOLE_STEP, Planes, Work
from tauto_core.samples import FloatArray

if TYPE_CHECKING:
    from tauto_core.motion.system import Mode

Omega: TypeAlias = tuple[float, ...]
"""Frequencies of the rotating planes [rad/s]."""

Twofold: TypeAlias = tuple[float, float]

MAX_SWEEPS = 60
MAX_NEWTON = 12
ROUNDING = 2.0**-53
SETTLED = 0.25 * ROUNDING
"""Best relative accuracy to which stages can be computed."""


class Disturbed(Protocol):
    """What disturbs the planes."""

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the rows d1 and d2 from x and y."""


class Step(NamedTuple):
    """A step.

    Attributes:
        system: what disturbs.
        mode: passed to its `disturb`.
        omega: ω of each plane.
        h: length [s], |ωh| ≤ MAX_ANGLE.
        kind: WHOLE_STEP or PART_STEP: which table of rotations it uses.
        planes: the state at the beginning.
        work: from `make_work`.
    """

    system: Disturbed
    mode: Mode
    omega: Omega
    h: float
    kind: int
    planes: Planes
    work: Work


@inlined
def _short_of_one(cosine: float, sine: float) -> float:
    """Return 1 − cos² − sin² of rounded numbers, exactly enough."""
    first, first_rest = multiply_exactly(cosine, cosine)
    second, second_rest = multiply_exactly(sine, sine)
    square, rest = sum_exactly(first, second)
    return (1.0 - square) - (rest + first_rest + second_rest)


@compiled
def turn_to(step: Step) -> None:
    """Fill the rotations to the stages and the end of a step, unless they are there.

    Steps to events have lengths of their own, so that the rounding of their angles varies; for
    them doubles are enough, corrected so that they neither stretch nor shrink the state.
    """
    _, _, omega, h, kind, _, work = step
    first = kind * len(omega)
    if work.turns[first].h == h:
        return
    for p in range(len(omega)):
        turn, angle = work.turns[first + p], omega[p] * h
        c, s = rotation(load(work.fractions) * angle)
        store(work.cosine, first + p, c)
        store(work.sine, first + p, s)
        turn.h = h
        if kind == WHOLE_STEP:
            cosine, sine = twofold_rotation(omega[p], h)
            turn.cos, turn.cos_rest = cosine
            turn.sin, turn.sin_rest = sine
        else:
            whole_cosine, whole_sine = rotation(angle)
            more = 0.5 * _short_of_one(whole_cosine, whole_sine)
            turn.cos, turn.cos_rest = whole_cosine, more * whole_cosine
            turn.sin, turn.sin_rest = whole_sine, more * whole_sine


@inlined
def _evaluate(step: Step) -> None:
    """Fill the slopes k1, k2 from the stages u, v."""
    system, mode, omega, _, kind, _, work = step
    first = kind * len(omega)
    for p in range(len(omega)):
        c, s = load(work.cosine, first + p), load(work.sine, first + p)
        u, v = load(work.u, p), load(work.v, p)
        store(work.x, p, fma(c, u, s * v))
        store(work.y, p, fma(c, v, -(s * u)))
    system.disturb(mode, omega, work)
    for p in range(len(omega)):
        c, s = load(work.cosine, first + p), load(work.sine, first + p)
        d1, d2 = load(work.d1, p), load(work.d2, p)
        store(work.k1, p, fma(c, d1, -(s * d2)))
        store(work.k2, p, fma(s, d1, c * d2))


@inlined
def _move_stages(step: Step) -> float:
    """Move the stages u, v to where their slopes lead; return the largest change of a stage."""
    _, _, omega, h, _, planes, work = step
    change = filled(work.u, 0.0)
    for p in range(len(omega)):
        k1, k2 = load(work.k1, p), load(work.k2, p)
        if width(work.u) == WIDE_SIZE:
            u, v = folded_both(work.folded, 0, WIDE_SIZE // 2 + 1 + 2 * p, k1, k2)
        else:
            u, v = combined_both(work.coefficients, 0, k1, k2)
        u, v = fma(u, h, planes[p].x), fma(v, h, planes[p].y)
        moved = larger(u - load(work.u, p), v - load(work.v, p))
        change = larger(change, moved)
        store(work.u, p, u)
        store(work.v, p, v)
    return largest(change)


@inlined
def _size(omega: Omega, work: Work) -> float:
    """Return the largest magnitude of the stages."""
    size = filled(work.u, 0.0)
    for p in range(len(omega)):
        size = larger(larger(size, load(work.u, p)), load(work.v, p))
    return largest(size)


@compiled
def _iterate(step: Step, settled: float, most: int) -> tuple[bool, float]:
    """Sweep until the stages have settled; return whether they do, and their size.

    They have settled if, at the measured rate of convergence, less than that is still to come. The
    slopes are those of the last stages; after no sweeps, of the stages as they are. The
    disturbance is compiled here, once.

    Args:
        step: to be solved.
        settled: part of the state to which stages are iterated.
        most: sweeps at most.
    """
    before, size, floor = math.inf, 0.0, 0.0
    settles, ends = False, False
    for n in range(most + 1):
        _evaluate(step)
        if ends or n == most:
            break
        change = _move_stages(step)
        if n == 0:
            size = _size(step.omega, step.work)
            floor = settled * size
        if change <= floor or (n > 0 and change * change <= floor * (before - change)):
            settles = ends = True
        elif not change < before and n > 0:
            settles, ends = change <= 64.0 * ROUNDING * size, True
        before = change
    return settles, size


@inlined
def _begin(step: Step) -> None:
    """Let the stages be the state at the beginning of the step."""
    _, _, omega, _, _, planes, work = step
    for p in range(len(omega)):
        store(work.u, p, filled(work.u, planes[p].x))
        store(work.v, p, filled(work.v, planes[p].y))


@inlined
def _of(r: int, omega: Omega, first: FloatArray, second: FloatArray) -> tuple[FloatArray, int]:
    """Return in which rows the unknown r is, U of each plane, then V, and in which of these."""
    return (first, r) if r < len(omega) else (second, r - len(omega))


@inlined
def _slope(r: int, omega: Omega, work: Work) -> Lanes:
    """Return the slope of an unknown at the stages."""
    rows, p = _of(r, omega, work.k1, work.k2)
    return load(rows, p)


@compiled
def _linearised(step: Step) -> None:
    """Fill the matrix I − h A ∂K/∂(U, V), by central differences at all stages together."""
    _, _, omega, h, _, _, work = step
    unknowns, stages = 2 * len(omega), width(work.u)
    side = unknowns * stages
    for column in range(unknowns):
        rows, p = _of(column, omega, work.u, work.v)
        there = load(rows, p)
        away = 1e-6 * (largest(there) + 1e-9)
        store(rows, p, there + away)
        _iterate(step, 0.0, 0)
        for r in range(unknowns):
            store(work.slopes, r, _slope(r, omega, work))
        store(rows, p, there - away)
        _iterate(step, 0.0, 0)
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
def _solve(step: Step) -> tuple[bool, float]:
    """Solve the stage equations by Newton's method; return whether it converges, and the size."""
    _, _, omega, h, _, planes, work = step
    unknowns, stages, right = 2 * len(omega), width(work.u), work.right
    _begin(step)
    before, size = math.inf, 0.0
    for _ in range(MAX_NEWTON):
        _linearised(step)
        _iterate(step, 0.0, 0)
        for r in range(unknowns):
            rows, p = _of(r, omega, work.u, work.v)
            begin = planes[p].x if r < len(omega) else planes[p].y
            moved = combined(work.coefficients, 0, _slope(r, omega, work))
            wanted = fma(moved, h, begin) - load(rows, p)
            for i in range(stages):
                right[r * stages + i] = lane(wanted, i)
        change = _eliminate(unknowns * stages, work.matrix, right)
        for r in range(unknowns):
            rows, p = _of(r, omega, work.u, work.v)
            for i in range(stages):
                rows[p * stages + i] += right[r * stages + i]
        size = _size(omega, work)
        if not math.isfinite(change):
            return False, size
        floor = 4.0 * ROUNDING * size
        if change <= floor or (not change < before and change <= 64.0 * floor):
            _iterate(step, 0.0, 0)
            return True, size
        if not change < 4.0 * before:
            return False, size
        before = change
    return False, size


@compiled
def collocate(step: Step, settled: float) -> tuple[float, bool]:
    """Solve the stage equations of a step.

    Args:
        step: to be solved.
        settled: part of the state to which the stage equations are iterated, >= SETTLED.

    Returns:
        Last Legendre coefficient of the slopes over the step, relative to the state – infinite
        without convergence – and whether Newton's method was needed.
    """
    _, _, omega, h, _, _, work = step
    turn_to(step)
    _begin(step)
    converged, size = _iterate(step, settled, MAX_SWEEPS)
    newton = not converged
    if newton:
        converged, size = _solve(step)
        if not converged:
            return math.inf, True
    last = 0.0
    for rows in (work.k1, work.k2):
        for p in range(len(omega)):
            tail = h * total(load(work.tail) * load(rows, p))
            if not math.isfinite(tail):
                return math.inf, newton
            last = max(last, abs(tail))
    return last / size if size > 0.0 else 0.0, newton


@inlined
def _turned(
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
    """Fill `work.end` with the state at the end of the step last collocated."""
    _, _, omega, h, kind, planes, work = step
    weights = load(work.quadrature)
    for p in range(len(omega)):
        turn, begin, end = work.turns[kind * len(omega) + p], planes[p], work.end[p]
        cosine, sine = (turn.cos, turn.cos_rest), (turn.sin, turn.sin_rest)
        minus = -sine[0], -sine[1]
        u, v = (begin.x, begin.x_rest), (begin.y, begin.y_rest)
        add_u = h * total(weights * load(work.k1, p))
        add_v = h * total(weights * load(work.k2, p))
        end.x, end.x_rest = _turned(cosine, sine, u, v, add_u, add_v)
        end.y, end.y_rest = _turned(cosine, minus, v, u, add_v, add_u)


@compiled
def copy_planes(omega: Omega, source: Planes, target: Planes) -> None:
    """Copy the state of each plane."""
    for p in range(len(omega)):
        old, new = source[p], target[p]
        new.x, new.x_rest, new.y, new.y_rest = old.x, old.x_rest, old.y, old.y_rest


@compiled
def expand(omega: Omega, work: Work) -> None:
    """Fill f1, f2 with the slopes' integrals over the fraction, in powers: for `between`."""
    for p in range(len(omega)):
        store(work.f1, p, combined(work.expansion, 0, load(work.k1, p)))
        store(work.f2, p, combined(work.expansion, 0, load(work.k2, p)))


@compiled
def between(
    omega: Omega, p: int, h: float, xi: float, planes: Planes, work: Work
) -> tuple[float, float]:
    """Return X and Y of plane p at the fraction xi of the step, from the stage polynomials."""
    stages, t = width(work.f1), 2.0 * xi - 1.0
    first = p * stages
    u, v = work.f1[first + stages - 1], work.f2[first + stages - 1]
    for n in range(stages - 2, -1, -1):
        u = fma(u, t, work.f1[first + n])
        v = fma(v, t, work.f2[first + n])
    u, v = fma(u, xi * h, planes[p].x), fma(v, xi * h, planes[p].y)
    c, s = rotation(omega[p] * (xi * h))
    return c * u + s * v, c * v - s * u
