"""Sully's lever machine in one turning plane, with the arc for its coordinate.

Per inertia of the wheel, with s, n, w, χ' and j of lever_shape, κ = m AD/√(IJ), A = n + √j w and
α = β − τ the tilt of the case,

    L/I = ½ ṡ² + A α̇ ṡ + … − √j κ g_eff sin(β_lever − τ),    p = ṡ + A α̇,
    ṡ = p − A α̇,    ṗ = ṡ α̇ χ' (√j n − w) − κ w g_eff cos(β_lever − τ) − n · drag:

no second derivative of the ship's motion is needed. X is s, ωY is p. The ship's motion is that of
the fulcrum.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from tauto_core.kernels import compiled, inlined, overload
from tauto_core.motion import mechanism, turning
from tauto_core.motion.lanes import filled, fma, largest, load, store
from tauto_core.motion.lever_shape import (
    ANGLE,
    BEND,
    COSINE,
    RIDE,
    SHORTENING,
    SINE,
    LeverShape,
    Powers,
)
from tauto_core.motion.mechanism import resistance
from tauto_core.motion.outside import (
    D1_ROW,
    D2_ROW,
    GRAVITY,
    LINE_BEND,
    LINE_RATE,
    OUTSIDE_ROW,
    TILT,
    TILT_BEND,
    TILT_RATE,
    X_ROW,
    Y_ROW,
    column,
    difference,
    nodes_of,
)
from tauto_core.motion.rotation import sine_versine

TURN_ROW, TURN_BEND_ROW, UP_ROW, ACROSS_ROW = range(OUTSIDE_ROW, OUTSIDE_ROW + 4)
"""Rows of α̇, α̈ and of g_eff cos τ, g_eff sin τ at the nodes."""

ROWS = 4


class Lever(NamedTuple):
    """Sully's lever machine as `turning` and `spans` take it.

    Attributes:
        shape: the functions of the arc.
        carried: √j, of J/I.
        weight: κ.
        viscous: c₁/I.
        quadratic: c₂/I.
        energy: twice the impulse's over I.
        recoil: R/I, or None.
    """

    shape: LeverShape
    carried: float
    weight: float
    viscous: float
    quadratic: float
    energy: float
    recoil: float | None


def _is_lever(system: Any) -> bool:
    return getattr(system, 'instance_class', None) is Lever


@inlined
def _clenshaw(terms: Any, x: Any, zero: Any) -> Any:
    """Return n, w, χ', cos β, sin β and θ by Clenshaw's recurrence, side by side."""
    twice = 2.0 * x
    n = w = bend = cosine = sine = angle = zero
    n_old = w_old = bend_old = cosine_old = sine_old = angle_old = zero
    for j in range(terms.shape[1] - 1, 0, -1):
        n, n_old = fma(twice, n, terms[SHORTENING, j] - n_old), n
        w, w_old = fma(twice, w, terms[RIDE, j] - w_old), w
        bend, bend_old = fma(twice, bend, terms[BEND, j] - bend_old), bend
        cosine, cosine_old = fma(twice, cosine, terms[COSINE, j] - cosine_old), cosine
        sine, sine_old = fma(twice, sine, terms[SINE, j] - sine_old), sine
        angle, angle_old = fma(twice, angle, terms[ANGLE, j] - angle_old), angle
    return (
        fma(x, n, terms[SHORTENING, 0] - n_old),
        fma(x, w, terms[RIDE, 0] - w_old),
        fma(x, bend, terms[BEND, 0] - bend_old),
        fma(x, cosine, terms[COSINE, 0] - cosine_old),
        fma(x, sine, terms[SINE, 0] - sine_old),
        fma(x, angle, terms[ANGLE, 0] - angle_old),
    )


@inlined
def _horner(terms: Any, x: Any, zero: Any) -> Any:
    """Return the same by Horner's, side by side."""
    n = w = bend = cosine = sine = angle = zero
    for j in range(terms.shape[1] - 1, -1, -1):
        n = fma(n, x, terms[SHORTENING, j])
        w = fma(w, x, terms[RIDE, j])
        bend = fma(bend, x, terms[BEND, j])
        cosine = fma(cosine, x, terms[COSINE, j])
        sine = fma(sine, x, terms[SINE, j])
        angle = fma(angle, x, terms[ANGLE, j])
    return n, w, bend, cosine, sine, angle


def _series_at(series: Any, s: Any, zero: Any) -> Any:
    """Return n, w, χ', cos β, sin β and θ of lanes of s or a float; `zero` is one of that kind."""
    raise TypeError('_series_at runs in compiled code only')


@overload(_series_at)
def _series_of(series: Any, s: Any, zero: Any) -> Any:
    scheme = _horner if series.instance_class is Powers else _clenshaw

    def at(series: Any, s: Any, zero: Any) -> Any:
        return scheme(series.terms, (s - series.middle) * (1.0 / series.half), zero)

    return at


@compiled
def _shape_at(shape: Any, s: Any) -> Any:
    """Return n, w, χ', cos β and sin β of lanes of s."""
    if largest(s - shape.near.middle) <= shape.near.half:
        return _series_at(shape.near, s, filled(s, 0.0))[:5]
    return _series_at(shape.whole, s, filled(s, 0.0))[:5]


@compiled
def _values(shape: Any, s: float) -> Any:
    """Return n, w, χ', cos β, sin β and θ."""
    if abs(s - shape.near.middle) <= shape.near.half:
        return _series_at(shape.near, s, 0.0)
    return _series_at(shape.whole, s, 0.0)


@overload(mechanism.at_nodes)
def _at_nodes(system: Any, place: Any, work: Any) -> Any:
    if not _is_lever(system):
        return None

    def fill(system: Any, place: Any, work: Any) -> None:
        terms, x = place[1], nodes_of(place, work)
        sine, versine = sine_versine(column(TILT, terms, x, work))
        g_eff = column(GRAVITY, terms, x, work)
        store(work, TURN_ROW, difference(LINE_RATE, TILT_RATE, terms, x, work))
        store(work, TURN_BEND_ROW, difference(LINE_BEND, TILT_BEND, terms, x, work))
        store(work, UP_ROW, g_eff - g_eff * versine)
        store(work, ACROSS_ROW, g_eff * sine)

    return fill


@overload(turning.disturb)
def _disturb(system: Any, mode: Any, omega: Any, work: Any) -> Any:
    if not _is_lever(system):
        return None

    def disturb(system: Any, mode: Any, omega: Any, work: Any) -> None:
        s, p = load(work, X_ROW), omega[0] * load(work, Y_ROW)
        n, w, bend, cosine, sine = _shape_at(system.shape, s)
        turn = load(work, TURN_ROW)
        dragged = turn * fma(system.carried, w, n)
        rate = p - dragged
        pull = load(work, UP_ROW) * cosine + load(work, ACROSS_ROW) * sine
        pushed = (omega[0] * omega[0]) * s - (system.weight * w) * pull
        ride = rate * turn * bend * (system.carried * n - w)
        more = pushed + ride - n * resistance(system, mode, n * rate)
        store(work, D1_ROW, -dragged)
        store(work, D2_ROW, more * (1.0 / omega[0]))

    return disturb


@overload(mechanism.margins)
def _margins(system: Any, mode: Any, omega: Any, work: Any) -> Any:
    if not _is_lever(system):
        return None

    def margins(system: Any, mode: Any, omega: Any, work: Any) -> Any:
        s, p = load(work, X_ROW), omega[0] * load(work, Y_ROW)
        n, w, bend, cosine, sine = _shape_at(system.shape, s)
        dragged = fma(system.carried, w, n)
        rate = p - load(work, TURN_ROW) * dragged
        pull = load(work, UP_ROW) * cosine + load(work, ACROSS_ROW) * sine
        turned = load(work, TURN_BEND_ROW)
        push = (system.weight * w) * pull + n * resistance(system, mode, n * rate)
        bent = -(push + dragged * turned)
        tension = w * bent + n * bend * (rate * rate) + system.carried * turned
        whole = system.shape.whole
        x = (s - whole.middle) * (1.0 / whole.half)
        return tension + system.weight * pull, 1.0 - x * x

    return margins


@overload(mechanism.instant)
def _instant(system: Any, mode: Any, omega: Any, state: Any, at: Any) -> Any:
    if not _is_lever(system):
        return None

    def instant(system: Any, mode: Any, omega: Any, state: Any, at: Any) -> Any:
        line, tilt, g_eff = at
        shape, s = system.shape, state[0]
        n, w, bend, cosine, sine, angle = _values(shape, s)
        dragged = n + system.carried * w
        turned = line[2] - tilt[2]
        rate = omega[0] * state[2] - dragged * (line[1] - tilt[1])
        pull = g_eff * (cosine * math.cos(tilt[0]) + sine * math.sin(tilt[0]))
        drag = resistance(system, mode, n * rate)
        bent = -(system.weight * w * pull + n * drag + dragged * turned)
        tension = w * bent + n * bend * rate * rate + system.carried * turned
        wheel_bend = n * bent - w * bend * rate * rate
        x = (s - shape.whole.middle) / shape.whole.half
        return (
            angle,
            n * rate,
            wheel_bend,
            tension + system.weight * pull,
            1.0 - x * x,
            wheel_bend + turned + drag,
            s,
            rate,
            bent,
        )

    return instant


@overload(mechanism.wheel_angle)
def _wheel_angle(system: Any, state: Any, at: Any) -> Any:
    if not _is_lever(system):
        return None
    return lambda system, state, at: _values(system.shape, state[0])[5]


@overload(mechanism.strike)
def _strike(system: Any, mode: Any, omega: Any, at: Any, state: Any) -> Any:
    if not _is_lever(system):
        return None

    def strike(system: Any, mode: Any, omega: Any, at: Any, state: Any) -> None:
        # ½ M θ̇² = ½ I ṡ²
        n, w, _, _, _, _ = _values(system.shape, state[0])
        rate = omega[0] * state[2] - (n + system.carried * w) * (at[0][1] - at[1][1])
        state[2] += (mode[0] * math.sqrt(rate * rate + system.energy) - rate) / omega[0]
        state[3] = 0.0

    return strike
