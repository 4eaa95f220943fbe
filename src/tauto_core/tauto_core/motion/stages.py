"""The stage equations of a step: Gauss collocation in a rotating (Lawson) frame.

A system consists of rotating planes (modes). Each is a harmonic oscillator with a disturbance:

    Ẋ = ωY + d₁,    Ẏ = −ωX + d₂          (X a coordinate, ωY nearly its rate)

In the frame that rotates with ω from the beginning t₀ of the step on,

    X = cU + sV,    Y = cV − sU,    c = cos ω(t − t₀),    s = sin ω(t − t₀),

the undisturbed motion stands still, and only the disturbance is left to integrate:

    U̇ = c d₁ − s d₂,    V̇ = s d₁ + c d₂.

With Gauss's coefficients a_ij (`gauss`) the stages U_i, V_i of a step of length h obey

    U_i = U₀ + h Σ_j a_ij U̇_j,            V_i likewise.

They are solved by fixed-point iteration, whose rate of convergence is h times the strength of the
disturbance, or by Newton's method (`stage_newton`) where that is too large. What disturbs is said
by `System.disturb`: it reads the rows x and y of the record `work` and writes d1 and d2.

Source: J. D. Lawson, Generalized Runge–Kutta processes for stable systems with large Lipschitz
constants, SIAM J. Numer. Anal. 4 (1967).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple, Protocol

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.lanes import (
    WIDE_SIZE,
    combined_both,
    filled,
    fma,
    folded_both,
    larger,
    largest,
    load,
    store,
    width,
)
from tauto_core.motion.rotation import (
    multiply_exactly,
    rotation,
    sum_exactly,
    twofold_rotation,
)
from tauto_core.motion.work import WHOLE_STEP, Omega, Planes, Work

if TYPE_CHECKING:
    from tauto_core.motion.system import Mode

ROUNDING = 2.0**-53
"""Largest relative error of one rounding."""

SETTLED = 0.25 * ROUNDING
"""Smallest share of the state to which iterating the stages makes sense."""

MAX_SWEEPS = 60
"""Most sweeps: an iteration that halves its error each time has reached rounding before."""


class Disturbed(Protocol):
    """A system, as far as a step knows it."""

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the rows d1 and d2 from x and y."""


class Step(NamedTuple):
    """A step.

    Attributes:
        system: the system that disturbs the planes.
        mode: passed to its `disturb`.
        omega: ω of each plane [rad/s].
        h: length [s], |ωh| ≤ `rotation.MAX_ANGLE`.
        kind: WHOLE_STEP or PART_STEP: which of the tables of rotations it uses.
        planes: X₀ = U₀ and Y₀ = V₀ of each plane, at the beginning.
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
    """Return 1 − cos² − sin² of rounded numbers, to a relative error of about one rounding."""
    first, first_rest = multiply_exactly(cosine, cosine)
    second, second_rest = multiply_exactly(sine, sine)
    square, rest = sum_exactly(first, second)
    return (1.0 - square) - (rest + first_rest + second_rest)


@compiled
def fill_rotations(step: Step) -> None:
    """Fill the rotations to the stages and to the end of a step, unless they are there.

    Whole steps are mostly of one length, whose angle must be exact, since its error would recur in
    each. Steps to events have lengths of their own, so that the rounding of their angles varies:
    doubles are enough for them, corrected so that they neither stretch nor shrink the state.
    """
    _, _, omega, h, kind, _, work = step
    first = kind * len(omega)
    if work.rotations[first].h == h:
        return
    for p in range(len(omega)):
        over, angle = work.rotations[first + p], omega[p] * h
        c, s = rotation(load(work.fractions) * angle)
        store(work.cosine, first + p, c)
        store(work.sine, first + p, s)
        over.h = h
        if kind == WHOLE_STEP:
            cosine, sine = twofold_rotation(omega[p], h)
            over.cos, over.cos_rest = cosine
            over.sin, over.sin_rest = sine
        else:
            rounded_cosine, rounded_sine = rotation(angle)
            stretch = 0.5 * _short_of_one(rounded_cosine, rounded_sine)
            over.cos, over.cos_rest = rounded_cosine, stretch * rounded_cosine
            over.sin, over.sin_rest = rounded_sine, stretch * rounded_sine


@inlined
def _evaluate(step: Step) -> None:
    """Fill the slopes k1 = U̇ and k2 = V̇ at the stages u, v."""
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
    """Move the stages to where their slopes lead; return the largest change of a stage."""
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
def largest_stage(omega: Omega, work: Work) -> float:
    """Return the largest |U_i| or |V_i|."""
    size = filled(work.u, 0.0)
    for p in range(len(omega)):
        size = larger(larger(size, load(work.u, p)), load(work.v, p))
    return largest(size)


@inlined
def start_stages(step: Step) -> None:
    """Let all stages be the state at the beginning of the step."""
    _, _, omega, _, _, planes, work = step
    for p in range(len(omega)):
        store(work.u, p, filled(work.u, planes[p].x))
        store(work.v, p, filled(work.v, planes[p].y))


@compiled
def sweep(step: Step, settled: float, most: int) -> tuple[bool, float]:
    """Sweep until the stages have settled; return whether they have, and their size.

    A sweep evaluates the slopes and moves the stages. If Δ and Δ′ are the changes of the last
    sweep and the one before, the rate of convergence is Δ/Δ′, and Δ²/(Δ′ − Δ) is still to come:
    the stages have settled when that is at most `settled` times their size. If Δ does not fall any
    more, only rounding may be left, for which 64 roundings are allowed. The slopes are evaluated
    once more at the last stages, which keeps the error of the iteration from adding up.

    With `most` = 0 the slopes are evaluated and nothing else. All evaluations are made here, so
    that the disturbance is compiled once.

    Args:
        step: to be solved.
        settled: error allowed, relative to the state.
        most: most sweeps.
    """
    before, size, floor = math.inf, 0.0, 0.0
    settles, ends = False, False
    for n in range(most + 1):
        _evaluate(step)
        if ends or n == most:
            break
        change = _move_stages(step)
        if n == 0:
            size = largest_stage(step.omega, step.work)
            floor = settled * size
        if change <= floor or (n > 0 and change * change <= floor * (before - change)):
            settles = ends = True
        elif not change < before and n > 0:
            settles, ends = change <= 64.0 * ROUNDING * size, True
        before = change
    return settles, size
