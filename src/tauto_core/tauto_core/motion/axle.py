"""The suspended case at any angles: collocation in the two planes of its modes, compiled.

    N/M = ((g + z̈) cos θ − ÿ sin θ + e θ̇² + c φ̇² cos δ)/(1 + (c/k)² sin²δ),    δ = φ − θ
    φ̈ = −(N/M) c sin δ/k²,    e θ̈ = −(g + z̈) sin θ − ÿ cos θ − c φ̈ cos δ + c φ̇² sin δ

(theory C and E3.) X = q and Y = q̇/ω of the modes, θ = c (q + q′) and φ = Bq + B′q′: what is left
to disturb the planes is of the third order in the swing, and what the bearing does.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from tauto_core.kernels import compiled, entry, inlined
from tauto_core.motion import turning
from tauto_core.motion.lanes import filled, fma, lane, largest, least, load, pointer, store, width
from tauto_core.motion.rotation import sine_versine
from tauto_core.motion.step_size import step_error
from tauto_core.motion.turning import (
    D1,
    D2,
    FIRST,
    FRACTIONS,
    OUTSIDE,
    PART_STEP,
    WHOLE_STEP,
    X,
    Y,
    collocate,
    copy_state,
    expand,
    finish,
    pointers,
    row,
)

PLANES = 2
SWAY, LIFT, CONTACT, THETA, DELTA = range(5)
MORE_ROWS = 5
OUTSIDE_ROW = FIRST + OUTSIDE * PLANES

OK, LIFTED_OFF, TURNED_OVER, NO_CONVERGENCE = 0, 1, 2, 3
OVER = 3.0
"""Tilt of the contact, or of the case from it, at which the case counts as turned over [rad]."""

MAX_HALVINGS = 24

ERROR_OF_LAST = 1.0
"""Error of a step per square of its last coefficient, at most."""


class SuspendedCase(NamedTuple):
    """What disturbs the planes: e, c, k, and B and B′ of the modes."""

    e: float
    c: float
    k: float
    tilt: float
    tilt_prime: float

    @inlined
    def disturb(self, mode: Any, omega: Any, work: Any) -> None:
        """Fill what disturbs the planes, contact force and angles."""
        e, c, k, tilt, tilt_prime = self
        q, other = load(work, row(X, PLANES, 0)), load(work, row(X, PLANES, 1))
        rate, other_rate = load(work, row(Y, PLANES, 0)), load(work, row(Y, PLANES, 1))
        theta, delta = c * (q + other), fma(other, tilt_prime - c, (tilt - c) * q)
        rates = _angles(self, omega[0] * rate, omega[1] * other_rate)
        sway, lift = load(work, OUTSIDE_ROW + SWAY), load(work, OUTSIDE_ROW + LIFT)
        contact, sine, cosine, across, along = _pressed(self, theta, delta, rates, sway, lift)
        # what waits for the contact force comes last, and is short
        free = fma(across, c * (rates[1] * rates[1]), -fma(lift, sine, sway * cosine))
        bend = contact * (across * (-c / (k * k)))
        turned = fma(along * -c, bend, free)
        per = 1.0 / (c * (tilt - tilt_prime))
        first, second = per / omega[0], per / omega[1]
        less, more = fma(bend, c * first, omega[0] * q), fma(bend, -c * second, omega[1] * other)
        store(work, row(D1, PLANES, 0), filled(work, 0.0))
        store(work, row(D1, PLANES, 1), filled(work, 0.0))
        store(work, row(D2, PLANES, 0), fma(turned, -tilt_prime * first / e, less))
        store(work, row(D2, PLANES, 1), fma(turned, tilt * second / e, more))
        store(work, OUTSIDE_ROW + CONTACT, contact)
        store(work, OUTSIDE_ROW + THETA, theta)
        store(work, OUTSIDE_ROW + DELTA, delta)


@inlined
def _angles(system: Any, q: Any, other: Any) -> Any:
    """Return θ and φ, or their rates, from those of the modes."""
    return system[1] * (q + other), system[3] * q + system[4] * other


@inlined
def _pressed(system: Any, theta: Any, delta: Any, rates: Any, sway: Any, lift: Any) -> Any:
    """Return N/M and sin, cos of θ and of δ; floats or lanes."""
    e, c, k, _, _ = system
    sine, versine = sine_versine(theta)
    across, less = sine_versine(delta)
    cosine, along = 1.0 - versine, 1.0 - less
    wide = (c / k) * across
    turning_rates = fma(c * (rates[1] * rates[1]), along, e * (rates[0] * rates[0]))
    pressed = fma(lift, cosine, fma(-sway, sine, turning_rates))
    return pressed / fma(wide, wide, 1.0), sine, cosine, across, along


@inlined
def _value(coefficients: Any, n: int, x: Any, value: Any) -> Any:
    """Return Σ c_nj x^j; `value` is a zero of the kind of x."""
    for j in range(coefficients.shape[1] - 1, -1, -1):
        value = fma(value, x, coefficients[n, j])
    return value


@compiled
def _contact_at(
    system: Any, omega: Any, bearing: Any, place: Any, h: float, xi: float, state: Any, work: Any
) -> float:
    """Return N/M at the fraction xi of the step last collocated and expanded."""
    sway, lift = bearing
    n, x0, hx = place
    q, y = turning.between(omega, 0, h, xi, state, work)
    other, other_y = turning.between(omega, 1, h, xi, state, work)
    theta, phi = _angles(system, q, other)
    rates = _angles(system, omega[0] * y, omega[1] * other_y)
    x = x0 + xi * hx
    a, b = _value(sway, n, x, 0.0), _value(lift, n, x, 0.0)
    return _pressed(system, theta, phi - theta, rates, a, b)[0]


@compiled
def _lift_off(
    system: Any, omega: Any, bearing: Any, place: Any, h: float, state: Any, work: Any
) -> float:
    """Return the fraction of the step at which the contact force falls to zero."""
    expand(PLANES, work)
    upper = 1.0
    for i in range(width(work) - 1, -1, -1):
        if lane(load(work, OUTSIDE_ROW + CONTACT), i) <= 0.0:
            upper = lane(load(work, FRACTIONS), i)
    lower = 0.0
    for _ in range(40):
        middle = 0.5 * (lower + upper)
        if _contact_at(system, omega, bearing, place, h, middle, state, work) > 0.0:
            lower = middle
        else:
            upper = middle
    return upper


@compiled
def _over(
    system: Any,
    omega: Any,
    bearing: Any,
    place: Any,
    step: Any,
    tolerance: Any,
    state: Any,
    memory: Any,
) -> tuple[int, float]:
    """Advance over a step; return a code and, if it is not OK, the fraction of the step.

    NO_CONVERGENCE leaves the state as it was.
    """
    h, kind = step
    n, x0, hx = place
    work = memory.work
    x = load(work, FRACTIONS) * hx + x0
    store(work, OUTSIDE_ROW + SWAY, _value(bearing[0], n, x, filled(work, 0.0)))
    store(work, OUTSIDE_ROW + LIFT, _value(bearing[1], n, x, filled(work, 0.0)))
    last, newton = collocate(system, 0.0, omega, h, kind, tolerance[1], state, memory)
    if not step_error(ERROR_OF_LAST, last, newton) <= tolerance[0]:
        return NO_CONVERGENCE, 0.0
    if not least(load(work, OUTSIDE_ROW + CONTACT)) > 0.0:
        return LIFTED_OFF, _lift_off(system, omega, bearing, place, h, state, work)
    theta, delta = load(work, OUTSIDE_ROW + THETA), load(work, OUTSIDE_ROW + DELTA)
    if not max(largest(theta), largest(delta)) < OVER:
        return TURNED_OVER, 0.0
    finish(omega, h, kind, state, memory)
    copy_state(PLANES, memory.end, state)
    return OK, 0.0


@entry
def advance(
    system: Any,
    omega: Any,
    tolerance: Any,
    bearing: Any,
    parts: Any,
    state: Any,
    memory: Any,
    rows: Any,
) -> tuple[int, int, float]:
    """Advance over parts of pieces; fill θ, φ, θ̇, φ̇ at their ends.

    Args:
        system: a SuspendedCase.
        omega: ω of both modes [rad/s].
        tolerance: error allowed a step relative to the state, and how far its stages are iterated.
        bearing: coefficients of ÿ and g + z̈ of the pieces, (n, m) each.
        parts: piece of each part, where in it the part begins and ends, and its length [s], (k,).
        state: X and Y of both planes, each in two doubles, (8,).
        memory: turning.Memory of two planes and MORE_ROWS.
        rows: output, (k, 4).

    Returns:
        A code (OK, LIFTED_OFF, TURNED_OVER, NO_CONVERGENCE), the part and the fraction of it.
    """
    piece, begin, end, length = parts
    memory, state = pointers(memory), pointer(state)
    for i in range(len(piece)):
        cell, cells = 0, 1
        while cell < cells:
            hx = (end[i] - begin[i]) / cells
            place = piece[i], begin[i] + cell * hx, hx
            step = length[i] / cells, WHOLE_STEP if cells == 1 else PART_STEP
            code, xi = _over(system, omega, bearing, place, step, tolerance, state, memory)
            if code == NO_CONVERGENCE and cells < 2**MAX_HALVINGS:
                cell, cells = 2 * cell, 2 * cells
                continue
            if code != OK:
                return code, i, (cell + xi) / cells
            cell += 1
        rows[i, 0], rows[i, 1] = _angles(system, state[0], state[4])
        rows[i, 2], rows[i, 3] = _angles(system, omega[0] * state[2], omega[1] * state[6])
    return OK, 0, math.nan
