"""The suspended case at any angles: collocation in the two planes of its modes, compiled.

    N/M = ((g + z̈) cos θ − ÿ sin θ + e θ̇² + c φ̇² cos δ)/(1 + (c/k)² sin²δ),    δ = φ − θ
    φ̈ = −(N/M) c sin δ/k²,    e θ̈ = −(g + z̈) sin θ − ÿ cos θ − c φ̈ cos δ + c φ̇² sin δ

(theory C and E3.) X = q and Y = q̇/ω of the modes, θ = c (q + q′) and φ = Bq + B′q′: the
disturbance of the planes consists of terms of the third order in the swing, and of the motion of
the bearing.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.kernels import compiled, entry, inlined
from tauto_core.motion.lanes import Lanes, filled, fma, lane, largest, least, load, store, width
from tauto_core.motion.rotation import sine_versine
from tauto_core.motion.step_size import step_error
from tauto_core.motion.system import Mode
from tauto_core.motion.turning import Omega, Step, between, collocate, copy_planes, expand, finish
from tauto_core.motion.work import PART_STEP, WHOLE_STEP, Planes, Work
from tauto_core.samples import FloatArray, IntArray

PLANES = 2
NODES = 'sway', 'lift', 'contact', 'theta', 'delta'

OK, LIFTED_OFF, TURNED_OVER, NO_CONVERGENCE = 0, 1, 2, 3
OVER = 3.0
"""Tilt of the contact, or of the case from it, at which the case counts as turned over [rad]."""

MAX_HALVINGS = 24
NO_MODE = Mode(0.0, 0.0, 0.0)
BISECTIONS = 40

ERROR_OF_LAST = 1.0
"""Error of a step per square of its last coefficient, at most."""


ROW = np.dtype([(name, 'f8') for name in ('theta', 'phi', 'theta_rate', 'phi_rate')])
"""The case at the end of a part."""


class Bearing(NamedTuple):
    """Pieces of the bearing's motion: coefficients of ÿ and of g + z̈, (n, m) each."""

    sway: FloatArray
    lift: FloatArray


class Parts(NamedTuple):
    """Parts of pieces: the piece, the beginning and end of the part in it, and its length [s]."""

    piece: IntArray
    begin: FloatArray
    end: FloatArray
    length_s: FloatArray


class Part(NamedTuple):
    """A part, or a part of that: its piece, where it begins, its size, both in x, its length [s].

    `kind` is that of a step over it.
    """

    piece: int
    begin: float
    size: float
    length_s: float
    kind: int


class CaseRun(NamedTuple):
    """What all steps of a run share; `tolerance` and `settled` are those of `system.Tolerance`."""

    system: SuspendedCase
    omega: Omega
    bearing: Bearing
    tolerance: float
    settled: float
    planes: Planes
    work: Work


class SuspendedCase(NamedTuple):
    """The disturbance of the planes: e, c, k, and B and B′ of the modes."""

    e: float
    c: float
    k: float
    tilt: float
    tilt_prime: float

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill what disturbs the planes, contact force and angles."""
        e, c, k, tilt, tilt_prime = self
        q, other, nodes = load(work.x, 0), load(work.x, 1), work.nodes
        rate, other_rate = load(work.y, 0), load(work.y, 1)
        theta, delta = c * (q + other), fma(other, tilt_prime - c, (tilt - c) * q)
        rates = _angles(self, omega[0] * rate, omega[1] * other_rate)
        sway, lift = load(nodes.sway), load(nodes.lift)
        contact, sine, cosine, across, along = _pressed(self, theta, delta, rates, sway, lift)
        # what waits for the contact force comes last, and is short
        free = fma(across, c * (rates[1] * rates[1]), -fma(lift, sine, sway * cosine))
        bend = contact * (across * (-c / (k * k)))
        turned = fma(along * -c, bend, free)
        per = 1.0 / (c * (tilt - tilt_prime))
        first, second = per / omega[0], per / omega[1]
        less, more = fma(bend, c * first, omega[0] * q), fma(bend, -c * second, omega[1] * other)
        store(work.d1, 0, filled(work.d1, 0.0))
        store(work.d1, 1, filled(work.d1, 0.0))
        store(work.d2, 0, fma(turned, -tilt_prime * first / e, less))
        store(work.d2, 1, fma(turned, tilt * second / e, more))
        store(nodes.contact, 0, contact)
        store(nodes.theta, 0, theta)
        store(nodes.delta, 0, delta)


@inlined
def _angles(system: SuspendedCase, q: Lanes, other: Lanes) -> tuple[Lanes, Lanes]:
    """Return θ and φ, or their rates, from those of the modes."""
    return system.c * (q + other), system.tilt * q + system.tilt_prime * other


@inlined
def _pressed(
    system: SuspendedCase,
    theta: Lanes,
    delta: Lanes,
    rates: tuple[Lanes, Lanes],
    sway: Lanes,
    lift: Lanes,
) -> tuple[Lanes, Lanes, Lanes, Lanes, Lanes]:
    """Return N/M and sin, cos of θ and of δ; floats or lanes."""
    e, c, k = system.e, system.c, system.k
    sine, versine = sine_versine(theta)
    across, less = sine_versine(delta)
    cosine, along = 1.0 - versine, 1.0 - less
    wide = (c / k) * across
    turning_rates = fma(c * (rates[1] * rates[1]), along, e * (rates[0] * rates[0]))
    pressed = fma(lift, cosine, fma(-sway, sine, turning_rates))
    return pressed / fma(wide, wide, 1.0), sine, cosine, across, along


@inlined
def _value(coefficients: FloatArray, n: int, x: Lanes, value: Lanes) -> Lanes:
    """Return Σ c_nj x^j; `value` is a zero of the kind of x."""
    for j in range(coefficients.shape[1] - 1, -1, -1):
        value = fma(value, x, coefficients[n, j])
    return value


@compiled
def _contact_at(run: CaseRun, part: Part, xi: float) -> float:
    """Return N/M at the fraction xi of the step last collocated and expanded."""
    omega, work = run.omega, run.work
    q, y = between(omega, 0, part.length_s, xi, run.planes, work)
    other, other_y = between(omega, 1, part.length_s, xi, run.planes, work)
    theta, phi = _angles(run.system, q, other)
    rates = _angles(run.system, omega[0] * y, omega[1] * other_y)
    x = part.begin + xi * part.size
    sway = _value(run.bearing.sway, part.piece, x, 0.0)
    lift = _value(run.bearing.lift, part.piece, x, 0.0)
    contact: float = _pressed(run.system, theta, phi - theta, rates, sway, lift)[0]
    return contact


@compiled
def _lift_off(run: CaseRun, part: Part) -> float:
    """Return the fraction of the step at which the contact force falls to zero."""
    work = run.work
    expand(run.omega, work)
    upper = 1.0
    for i in range(width(work.fractions) - 1, -1, -1):
        if lane(load(work.nodes.contact), i) <= 0.0:
            upper = lane(load(work.fractions), i)
    lower = 0.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (lower + upper)
        if _contact_at(run, part, middle) > 0.0:
            lower = middle
        else:
            upper = middle
    return upper


@compiled
def _over(run: CaseRun, part: Part) -> tuple[int, float]:
    """Advance over a step; return a code and, if it is not OK, the fraction of the step.

    NO_CONVERGENCE leaves the state as it was.
    """
    omega, planes, work = run.omega, run.planes, run.work
    x, none = load(work.fractions) * part.size + part.begin, filled(work.fractions, 0.0)
    store(work.nodes.sway, 0, _value(run.bearing.sway, part.piece, x, none))
    store(work.nodes.lift, 0, _value(run.bearing.lift, part.piece, x, none))
    step = Step(run.system, NO_MODE, omega, part.length_s, part.kind, planes, work)
    last, newton = collocate(step, run.settled)
    if not step_error(ERROR_OF_LAST, last, newton) <= run.tolerance:
        return NO_CONVERGENCE, 0.0
    if not least(load(work.nodes.contact)) > 0.0:
        return LIFTED_OFF, _lift_off(run, part)
    theta, delta = load(work.nodes.theta), load(work.nodes.delta)
    if not max(largest(theta), largest(delta)) < OVER:
        return TURNED_OVER, 0.0
    finish(step)
    copy_planes(omega, work.end, planes)
    return OK, 0.0


@entry
def advance(
    system: SuspendedCase,
    omega: Omega,
    bearing: Bearing,
    tolerance: float,
    settled: float,
    planes: Planes,
    work: Work,
    parts: Parts,
    rows: NDArray[np.void],
) -> tuple[int, int, float]:
    """Advance over parts of pieces; fill a row at the end of each.

    Args:
        system, omega, bearing, tolerance, settled, planes, work: as of `CaseRun`.
        parts: over which.
        rows: of ROW, one a part.

    Returns:
        A code (OK, LIFTED_OFF, TURNED_OVER, NO_CONVERGENCE), the part and the fraction of it.
    """
    run = CaseRun(system, omega, bearing, tolerance, settled, planes, work)
    for i in range(len(parts.piece)):
        cell, cells = 0, 1
        while cell < cells:
            size = (parts.end[i] - parts.begin[i]) / cells
            begin, kind = parts.begin[i] + cell * size, WHOLE_STEP if cells == 1 else PART_STEP
            part = Part(parts.piece[i], begin, size, parts.length_s[i] / cells, kind)
            code, xi = _over(run, part)
            if code == NO_CONVERGENCE and cells < 2**MAX_HALVINGS:
                cell, cells = 2 * cell, 2 * cells
                continue
            if code != OK:
                return code, i, (cell + xi) / cells
            cell += 1
        end = rows[i]
        end.theta, end.phi = _angles(system, planes[0].x, planes[1].x)
        rates = _angles(system, omega[0] * planes[0].y, omega[1] * planes[1].y)
        end.theta_rate, end.phi_rate = rates
    return OK, 0, math.nan
