"""A step by Gauss–Legendre collocation in a rotating (Lawson) frame.

The method is symmetric and symplectic, of order 16 with eight stages and 32 with sixteen. The
error falls with the strength of the disturbance, and undisturbed motion is exact. State and
rotations have twofold precision, and the rounding errors of n steps grow like √n. A comment above
`fill_rotations` has the equations.

Source: M. Antoñana, J. Makazaga, A. Murua, Reducing and monitoring round-off error propagation for
symplectic implicit Runge–Kutta schemes, Numer. Algorithms 76 (2017).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.lanes import (
    SIZE,
    WIDE_SIZE,
    combined,
    combined_both,
    filled,
    fma,
    folded_both,
    larger,
    largest,
    row_of,
    store,
    total,
    width,
)
from tauto_core.samples import FloatArray

# -----------------------------------------------------------------------------
# Gauss–Legendre collocation with s stages on [0, 1].
#
# The stage derivatives f(c_j) determine a polynomial of degree s − 1, in Legendre polynomials of
# t = 2x − 1, and its integral, in powers of t (with smaller coefficients than in powers of x):
#
#     f(x) = Σ_n F_n P_n(t),         F = projection · (f(c_1) … f(c_s)),
#     ∫_0^x f = x · Σ_n G_n t^n,     G = integral · (f(c_1) … f(c_s)).
#
# Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, II.7; J.
# C. Butcher, Implicit Runge–Kutta processes, Math. Comp. 18 (1964).


class Gauss(NamedTuple):
    """The constants of a method of s stages.

    Attributes:
        nodes: c_i, (s,).
        weights: b_i, (s,).
        projection: the matrix from values at the nodes to Legendre coefficients F_n, (s, s).
        columns: columns[j, i] = a_ij = ∫_0^{c_i} ℓ_j, with Lagrange's polynomials ℓ_j, (s, s).
        integral: the matrix from values at the nodes to the powers G_n, (s, s).
        folded: `columns` by sums and differences over mirrored nodes j′ = s + 1 − j, for even s
            and h = s/2, (h + 1, s). Row j ≤ h is p_1j … p_hj q_1j … q_hj, with
            p_ij = (a_ij + a_ij′ − b_j)/2 and q_ij = (a_ij − a_ij′)/2. The last row is
            b_1/2 … b_h/2, twice (`lanes.folded_both`).
    """

    nodes: FloatArray
    weights: FloatArray
    projection: FloatArray
    columns: FloatArray
    integral: FloatArray
    folded: FloatArray


@cache
def gauss_constants(stages: int) -> Gauss:
    """Return the constants of a method of 8 or 16 stages, each correctly rounded.

    They come from a table, since computing them takes 50 digits. The table has the rows of all
    fields of `Gauss` in order. `gauss_derivation` of the tests makes and checks it.
    """
    lines = Path(__file__).with_name('gauss_coefficients.txt').read_text('ascii').splitlines()
    rows = np.array([line.split() for line in lines if line.count(' ') == stages - 1], np.float64)
    ends = np.cumsum([1, 1, stages, stages, stages])
    nodes, weights, *matrices = np.split(rows, ends)
    return Gauss(nodes[0], weights[0], *matrices)


# -----------------------------------------------------------------------------
# The workspace of the steps: one record of named rows, allocated once.

MOST_POWERS = 24
"""Most powers of the polynomials of the forcing."""

PLANE = np.dtype([(name, 'f8') for name in ('x', 'x_rest', 'y', 'y_rest')])
ROTATION = np.dtype([(name, 'f8') for name in ('h', 'cos', 'cos_rest', 'sin', 'sin_rest')])
WHOLE_STEP, PART_STEP = 0, 1
"""Tables of rotations: for laid-out steps, mostly of one length, and for steps of any length."""


class PlaneState(Protocol):
    """X and Y of a rotating plane, and the rounding error of each."""

    x: float
    x_rest: float
    y: float
    y_rest: float


Planes: TypeAlias = Sequence[PlaneState]

Omega: TypeAlias = tuple[float, ...]
"""Frequencies of the rotating planes [rad/s]."""


class Mode(NamedTuple):
    """The signs, 1 or −1, that are constant between two events.

    Attributes:
        side: sign of the coordinate on the acting side of a kinked cam.
        direction: d, the sign of θ̇.
        pallet: s, the sign of θ̇ at the last impulse. Recoil pushes against it.
    """

    side: float
    direction: float
    pallet: float


class Work(Protocol):
    """The workspace record in compiled code. A row has one number per stage unless noted.

    Attributes:
        coefficients: row j has a_ij of all stages i (`Gauss.columns`).
        folded: `Gauss.folded`, then two scratch rows for each plane.
        expansion: row j has the powers of `Gauss.integral` for stage j.
        quadrature, fractions, tail: weights and nodes of the quadrature, and the weights of the
            last Legendre coefficient.
        piece: the polynomials of the ship's motion (`system`), a power of x in each row of 8, or
            of 16 if heat changes the machine.
        u, v, x, y: U, V, X and Y at the stages, a row for each plane.
        d1, d2: the disturbances, a row for each plane. They are zero until a system writes them.
        k1, k2: U̇ and V̇, a row for each plane.
        f1, f2: integrals of k1 and k2 over the fraction of the step, in powers.
        cosine, sine: of ωt at the stages, a row for each plane of WHOLE_STEP, then of PART_STEP.
        nodes: a record of the system's rows.
        end: X and Y of each plane at the end of a step.
        rotations: records of ROTATION, cos ωh and sin ωh of a step of length h [s], twofold, for
            each plane of WHOLE_STEP, then of PART_STEP.
    """

    coefficients: FloatArray
    folded: FloatArray
    expansion: FloatArray
    quadrature: FloatArray
    fractions: FloatArray
    tail: FloatArray
    piece: FloatArray
    u: FloatArray
    v: FloatArray
    k1: FloatArray
    k2: FloatArray
    x: FloatArray
    y: FloatArray
    d1: FloatArray
    d2: FloatArray
    f1: FloatArray
    f2: FloatArray
    cosine: FloatArray
    sine: FloatArray
    nodes: Any
    end: Planes
    rotations: Any


def make_work(
    planes: int, nodes: Sequence[str], stages: int = SIZE, columns: int = SIZE
) -> NDArray[np.void]:
    """Return the workspace of a system with `planes` rotating planes and the rows `nodes`.

    A name that is repeated has as many rows. Rows are aligned to cache lines. A row across two
    lines costs twice the time.
    """
    rows = {
        **dict.fromkeys(('coefficients', 'expansion'), stages),
        'folded': stages // 2 + 1 + 2 * planes,
        **dict.fromkeys(('quadrature', 'fractions', 'tail'), 1),
        **dict.fromkeys(('u', 'v', 'k1', 'k2', 'x', 'y', 'd1', 'd2', 'f1', 'f2'), planes),
        **dict.fromkeys(('cosine', 'sine'), 2 * planes),
    }
    node_type = np.dtype(
        [(name, 'f8', (nodes.count(name), stages)) for name in dict.fromkeys(nodes)]
    )
    kind = np.dtype(
        [
            ('piece', 'f8', (MOST_POWERS, columns)),
            *((name, 'f8', (count, stages)) for name, count in rows.items()),
            *([('nodes', node_type)] if nodes else []),
            ('end', PLANE, (planes,)),
            ('rotations', ROTATION, (2 * planes,)),
        ]
    )
    work = _aligned(kind.itemsize // 8, stages).view(kind).reshape(())
    constants = gauss_constants(stages)
    work['coefficients'], work['expansion'] = constants.columns, constants.integral.T
    work['folded'][: stages // 2 + 1] = constants.folded
    work['quadrature'], work['fractions'] = constants.weights, constants.nodes
    work['tail'] = constants.projection[-1]
    work['rotations']['h'] = np.nan
    return work


def rows_of_eight(count: int) -> FloatArray:
    """Return rows of eight zeros, aligned to cache lines, (count, 8)."""
    return _aligned(SIZE * count, SIZE).reshape(count, SIZE)


def _aligned(count: int, unit: int) -> FloatArray:
    """Return zeros at an address that is a multiple of so many doubles."""
    raw = np.zeros(count + unit)
    offset = -(raw.ctypes.data // raw.itemsize) % unit
    return raw[offset : offset + count]


# -----------------------------------------------------------------------------
# Rotations by ωh: to the stages of a step in double, over the step in twofold precision.
#
# A twofold number is an unevaluated sum of two doubles, some 106 bits. A rotation matrix rounded
# to doubles has the same error of angle and length in each step. The error of n steps would grow
# like n instead of √n. Source: T. J. Dekker, A floating-point technique for extending the
# available precision, Numer. Math. 18 (1971).

# Terms of the twofold series: at an eighth of MAX_ANGLE the next one is below 1e-31.
_TERMS = 14

# Halvings of the angle before its series, and doublings of the result after it.
_HALVINGS = 3

SINE, COSINE = (
    tuple((-1) ** n / math.factorial(2 * n + first) for n in range(10)) for first in (1, 2)
)
"""Taylor's coefficients of sin(x)/x and (1 − cos x)/x² in powers of x²."""

MAX_ANGLE = 6.5
"""Largest ωh of a rotation: twice the range of the series, which truncate at 6e-16."""


@inlined
def sum_exactly(a: float, b: float) -> tuple[float, float]:
    """Return a + b rounded, and its rounding error."""
    high = a + b
    part = high - a
    return high, (a - (high - part)) + (b - part)


@inlined
def multiply_exactly(a: float, b: float) -> tuple[float, float]:
    """Return a·b rounded, and its rounding error."""
    high = a * b
    return high, fma(a, b, -high)


@compiled
def _sum(a: Any, b: Any) -> Any:
    """Return the sum of two twofold numbers."""
    high, low = sum_exactly(a[0], b[0])
    return sum_exactly(high, low + a[1] + b[1])


@compiled
def _product(a: Any, b: Any) -> Any:
    """Return the product of two twofold numbers."""
    high, low = multiply_exactly(a[0], b[0])
    return sum_exactly(high, low + (a[0] * b[1] + a[1] * b[0]))


@compiled
def _quotient(a: Any, n: float) -> Any:
    """Return a twofold number divided by a small whole number."""
    high = a[0] / n
    return sum_exactly(high, (fma(-high, n, a[0]) + a[1]) / n)


@compiled
def twofold_rotation(rate: float, time: float) -> Any:
    """Return cos and sin of ωh, |ωh| ≤ MAX_ANGLE, each as two doubles, good to 1e-30."""
    part = 0.5**_HALVINGS
    high, low = multiply_exactly(rate, time)
    angle = high * part, low * part
    square = _product(angle, angle)
    sine = term = angle
    for n in range(1, _TERMS):
        term = _quotient(_product(term, square), -(2.0 * n) * (2.0 * n + 1.0))
        sine = _sum(sine, term)
    # 1 − cos, unlike cos, keeps the digits of a small angle through the doublings
    short = term = _quotient(square, 2.0)
    for n in range(2, _TERMS):
        term = _quotient(_product(term, square), -(2.0 * n) * (2.0 * n - 1.0))
        short = _sum(short, term)
    for _ in range(_HALVINGS):
        cosine = _sum((1.0, 0.0), (-short[0], -short[1]))
        doubled = _product(sine, sine)
        short = 2.0 * doubled[0], 2.0 * doubled[1]
        turned = _product(sine, cosine)
        sine = 2.0 * turned[0], 2.0 * turned[1]
    return _sum((1.0, 0.0), (-short[0], -short[1])), sine


@inlined
def _series(c: Any, x: Any) -> Any:
    """Return Σ c_n x^n of ten terms by Estrin's scheme, in a short chain of operations."""
    square = x * x
    fourth = square * square
    low = fma(fma(x, c[3], c[2]), square, fma(x, c[1], c[0]))
    high = fma(fma(x, c[7], c[6]), square, fma(x, c[5], c[4]))
    return fma(fma(x, c[9], c[8]), fourth * fourth, fma(high, fourth, low))


@inlined
def sine_versine(angle: Any) -> Any:
    """Return sin and 1 − cos of lanes or a float, |angle| ≤ π, with errors of 5e-16 and 2e-15.

    Taylor's series at half the angle, and the double-angle formulas.
    """
    half_angle = 0.5 * angle
    square = half_angle * half_angle
    sine, short = half_angle * _series(SINE, square), _series(COSINE, square)
    twice = 2.0 * sine
    return twice * fma(-square, short, 1.0), twice * sine


@inlined
def rotation(angle: Any) -> Any:
    """Return cos and sin of lanes or a float, |angle| ≤ MAX_ANGLE."""
    sine, versine = sine_versine(0.5 * angle)
    return 1.0 - 2.0 * (sine * sine), 2.0 * (sine * (1.0 - versine))


# -----------------------------------------------------------------------------
# The stage equations of a step: Gauss collocation in a rotating (Lawson) frame.
#
# A system consists of rotating planes (modes), harmonic oscillators with a disturbance:
#
#     Ẋ = ωY + d₁,    Ẏ = −ωX + d₂          (X a coordinate, ωY nearly its rate)
#
# In the frame that rotates with ω from the beginning t₀ of the step on,
#
#     X = cU + sV,    Y = cV − sU,    c = cos ω(t − t₀),    s = sin ω(t − t₀),
#
# the undisturbed motion is at rest, and only the disturbance is integrated:
#
#     U̇ = c d₁ − s d₂,    V̇ = s d₁ + c d₂.
#
# With Gauss's coefficients a_ij (`gauss_constants`) the stages U_i, V_i of a step of length h obey
#
#     U_i = U₀ + h Σ_j a_ij U̇_j,            V_i likewise.
#
# Fixed-point iteration solves them. Its rate of convergence is h times the strength of the
# disturbance. If that is too large, the driver halves the step. `System.disturb` computes the rows
# d1 and d2 of `work` from its rows x and y.
#
# Source: J. D. Lawson, Generalized Runge–Kutta processes for stable systems with large Lipschitz
# constants, SIAM J. Numer. Anal. 4 (1967).

UNIT_ROUNDOFF = 2.0**-53
"""Largest relative error of one rounding."""

LEAST_SETTLED = 0.25 * UNIT_ROUNDOFF
"""Least useful error of the stages, relative to the state."""

MAX_SWEEPS = 60
"""Most sweeps. An iteration that halves its error each time reaches rounding before."""


class Disturbed(Protocol):
    """A system as a step uses it."""

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the rows d1 and d2 from x and y."""


class Step(NamedTuple):
    """A step.

    Attributes:
        system: the system that disturbs the planes.
        mode: passed to its `disturb`.
        omega: ω of each plane [rad/s].
        h: length [s], |ωh| ≤ MAX_ANGLE.
        kind: its table of rotations, WHOLE_STEP or PART_STEP.
        planes: X₀ = U₀ and Y₀ = V₀ of each plane at the beginning.
        work: from `make_work`.
    """

    system: Disturbed
    mode: Mode
    omega: Omega
    h: float
    kind: int
    planes: Planes
    work: Work


@compiled
def fill_rotations(step: Step) -> None:
    """Fill the rotations to the stages and to the end of a step, unless they are there.

    Whole steps mostly have one length. Its angle is twofold, since its error would recur in each.
    In steps to events the rounding of the angles varies. Doubles are enough for them, with a
    correction that keeps the length of the state.
    """
    _, _, omega, h, kind, _, work = step
    offset = kind * len(omega)
    if work.rotations[offset].h == h:
        return
    for p in range(len(omega)):
        record, angle = work.rotations[offset + p], omega[p] * h
        c, s = rotation(row_of(work.fractions) * angle)
        store(work.cosine, offset + p, c)
        store(work.sine, offset + p, s)
        record.h = h
        if kind == WHOLE_STEP:
            cosine, sine = twofold_rotation(omega[p], h)
            record.cos, record.cos_rest = cosine
            record.sin, record.sin_rest = sine
        else:
            rounded_cosine, rounded_sine = rotation(angle)
            # half of 1 − cos² − sin² of the rounded numbers, to a relative rounding error
            first_square, first_rest = multiply_exactly(rounded_cosine, rounded_cosine)
            second_square, second_rest = multiply_exactly(rounded_sine, rounded_sine)
            square, low = sum_exactly(first_square, second_square)
            stretch = 0.5 * ((1.0 - square) - (low + first_rest + second_rest))
            record.cos, record.cos_rest = rounded_cosine, stretch * rounded_cosine
            record.sin, record.sin_rest = rounded_sine, stretch * rounded_sine


@inlined
def evaluate(step: Step) -> None:
    """Fill the slopes k1 = U̇ and k2 = V̇ at the stages u, v."""
    system, mode, omega, _, kind, _, work = step
    offset = kind * len(omega)
    for p in range(len(omega)):
        c, s = row_of(work.cosine, offset + p), row_of(work.sine, offset + p)
        u, v = row_of(work.u, p), row_of(work.v, p)
        store(work.x, p, fma(c, u, s * v))
        store(work.y, p, fma(c, v, -(s * u)))
    system.disturb(mode, omega, work)
    for p in range(len(omega)):
        c, s = row_of(work.cosine, offset + p), row_of(work.sine, offset + p)
        d1, d2 = row_of(work.d1, p), row_of(work.d2, p)
        store(work.k1, p, fma(c, d1, -(s * d2)))
        store(work.k2, p, fma(s, d1, c * d2))


@inlined
def move_stages(step: Step) -> float:
    """Compute the stages from their slopes and return the largest change of a stage."""
    _, _, omega, h, _, planes, work = step
    change = filled(work.u, 0.0)
    for p in range(len(omega)):
        k1, k2 = row_of(work.k1, p), row_of(work.k2, p)
        if width(work.u) == WIDE_SIZE:
            u, v = folded_both(work.folded, 0, WIDE_SIZE // 2 + 1 + 2 * p, k1, k2)
        else:
            u, v = combined_both(work.coefficients, 0, k1, k2)
        u, v = fma(u, h, planes[p].x), fma(v, h, planes[p].y)
        changes = larger(u - row_of(work.u, p), v - row_of(work.v, p))
        change = larger(change, changes)
        store(work.u, p, u)
        store(work.v, p, v)
    return largest(change)


@inlined
def largest_stage(omega: Omega, work: Work) -> float:
    """Return the largest |U_i| or |V_i|."""
    size = filled(work.u, 0.0)
    for p in range(len(omega)):
        size = larger(larger(size, row_of(work.u, p)), row_of(work.v, p))
    return largest(size)


@inlined
def start_stages(step: Step) -> None:
    """Set all stages to the state at the beginning of the step."""
    _, _, omega, _, _, planes, work = step
    for p in range(len(omega)):
        store(work.u, p, filled(work.u, planes[p].x))
        store(work.v, p, filled(work.v, planes[p].y))


@compiled
def sweep(step: Step, settled: float, most_sweeps: int) -> tuple[bool, float]:
    """Sweep until the stages have settled; return whether they have, and their size.

    A sweep evaluates the slopes and moves the stages. With the changes Δ of the last sweep and Δ′
    of the one before, the rate of convergence is Δ/Δ′ and the remaining error Δ²/(Δ′ − Δ). The
    stages have settled when it is at most `settled` times their size, or when Δ stops falling
    within 64 roundings. A last evaluation of the slopes keeps the errors of the iteration from
    adding up.

    With `most_sweeps` = 0 only the slopes are evaluated. All callers evaluate them here, and the
    disturbance is compiled once.
    """
    change_before, size, floor = math.inf, 0.0, 0.0
    settles, ends = False, False
    for n in range(most_sweeps + 1):
        evaluate(step)
        if ends or n == most_sweeps:
            break
        change = move_stages(step)
        if n == 0:
            size = largest_stage(step.omega, step.work)
            floor = settled * size
        if change <= floor or (n > 0 and change * change <= floor * (change_before - change)):
            settles = ends = True
        elif not change < change_before and n > 0:
            # a change that stops falling above the rounding of the sums over the stages diverges
            settles, ends = change <= 64.0 * UNIT_ROUNDOFF * size, True
        change_before = change
    return settles, size


Twofold: TypeAlias = tuple[float, float]


@compiled
def collocate(step: Step, settled: float) -> float:
    """Solve the stage equations to an error `settled`, relative to the state, ≥ `LEAST_SETTLED`.

    Returns the last Legendre coefficient of the slopes times h, relative to the state, infinite
    without convergence.
    """
    _, _, omega, h, _, _, work = step
    fill_rotations(step)
    start_stages(step)
    converged, size = sweep(step, settled, MAX_SWEEPS)
    if not converged:
        return math.inf
    last_term = 0.0
    for slopes in (work.k1, work.k2):
        for p in range(len(omega)):
            coefficient = h * total(row_of(work.tail) * row_of(slopes, p))
            if not math.isfinite(coefficient):
                return math.inf
            last_term = max(last_term, abs(coefficient))
    return last_term / size if size > 0.0 else 0.0


@inlined
def _rotated(
    cosine: Twofold, sine: Twofold, a: Twofold, b: Twofold, add_a: float, add_b: float
) -> Twofold:
    """Return cos·(a + add_a) + sin·(b + add_b) for twofold cos, sin, a, b and small additions."""
    first_high, first_rest = multiply_exactly(cosine[0], a[0])
    second, second_rest = multiply_exactly(sine[0], b[0])
    high, low = sum_exactly(first_high, second)
    low += first_rest + second_rest
    low += cosine[1] * a[0] + sine[1] * b[0]
    low += cosine[0] * (a[1] + add_a) + sine[0] * (b[1] + add_b)
    return sum_exactly(high, low)


@compiled
def finish(step: Step) -> None:
    """Fill `work.end` with the state at the end of the step last collocated.

    U₁ = U₀ + h Σ b_i U̇_i and V₁ likewise, rotated by ωh: X₁ = cU₁ + sV₁, Y₁ = cV₁ − sU₁.
    """
    _, _, omega, h, kind, planes, work = step
    weights = row_of(work.quadrature)
    for p in range(len(omega)):
        record, begin, end = work.rotations[kind * len(omega) + p], planes[p], work.end[p]
        cosine, sine = (record.cos, record.cos_rest), (record.sin, record.sin_rest)
        minus = -sine[0], -sine[1]
        u, v = (begin.x, begin.x_rest), (begin.y, begin.y_rest)
        add_u = h * total(weights * row_of(work.k1, p))
        add_v = h * total(weights * row_of(work.k2, p))
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
    """Fill f1 and f2, the integrals of the stage polynomials, for `inside`."""
    for p in range(len(omega)):
        store(work.f1, p, combined(work.expansion, 0, row_of(work.k1, p)))
        store(work.f2, p, combined(work.expansion, 0, row_of(work.k2, p)))


@compiled
def inside(
    omega: Omega, p: int, h: float, xi: float, planes: Planes, work: Work
) -> tuple[float, float]:
    """Return X and Y of plane p at a fraction ξ of the step, from the stage polynomials.

    U = U₀ + hξ Σ_n G_n tⁿ with t = 2ξ − 1 and the powers G_n (`Gauss.integral`), and V likewise.
    """
    stages, t = width(work.f1), 2.0 * xi - 1.0
    offset = p * stages
    u, v = work.f1[offset + stages - 1], work.f2[offset + stages - 1]
    for n in range(stages - 2, -1, -1):
        u = fma(u, t, work.f1[offset + n])
        v = fma(v, t, work.f2[offset + n])
    u, v = fma(u, xi * h, planes[p].x), fma(v, xi * h, planes[p].y)
    c, s = rotation(omega[p] * (xi * h))
    return c * u + s * v, c * v - s * u
