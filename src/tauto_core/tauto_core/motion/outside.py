"""The forcing in compiled code: at an instant, and at the nodes of a step."""

from __future__ import annotations

from typing import Any

from numba import types
from numba.extending import overload

from tauto_core.motion.compiled import compiled, inlined
from tauto_core.motion.lanes import fma, load, splat, store
from tauto_core.motion.turning import D1, D2, FIRST, FRACTIONS, OUTSIDE, X, Y
from tauto_core.motion.wells import horner

LINE_RATE, LINE_BEND, TILT_RATE, GRAVITY = 0, 1, 2, 3
ROWS = 4
X_ROW, Y_ROW, D1_ROW, D2_ROW = FIRST + X, FIRST + Y, FIRST + D1, FIRST + D2
OUTSIDE_ROW = FIRST + OUTSIDE
"""Rows of `work` in the one plane of the wheel (turning.row)."""


@compiled
def channel(coefficients: Any, k: int, x: float, per_s: float) -> tuple[float, float, float]:
    """Return a channel and its first two time derivatives; zeros where it is absent."""
    if coefficients is None:
        return 0.0, 0.0, 0.0
    value, first, second = horner(coefficients, k, x)
    return value, first * per_s, second * per_s * per_s


@compiled
def forcing_at(forcing: Any, k: int, x: float) -> Any:
    """Return (γ̇, γ̈), (τ, τ̇, τ̈) and the apparent gravity at x in piece k."""
    length, neutral, tilt, gravity = forcing
    per_s = 1.0 / length[k]
    line = channel(neutral, k, x, per_s)
    g_eff = channel(gravity, k, x, per_s)
    return (line[1], line[2]), channel(tilt, k, x, per_s), g_eff[0]


@inlined
def lanes_channel(coefficients: Any, k: int, x: Any) -> Any:
    """Return Σ c_kj x^j and its first two derivatives in x, for lanes."""
    value, first, half_second = splat(0.0), splat(0.0), splat(0.0)
    for j in range(coefficients.shape[1] - 1, -1, -1):
        half_second = fma(half_second, x, first)
        first = fma(first, x, value)
        value = fma(value, x, coefficients[k, j])
    return value, first, 2.0 * half_second


@inlined
def _store_line(neutral: Any, k: int, x: Any, per_s: float, row: int, work: Any) -> None:
    if neutral is None:
        return
    _, first, second = lanes_channel(neutral, k, x)
    store(work, row + LINE_RATE, first * per_s)
    store(work, row + LINE_BEND, second * (per_s * per_s))


@inlined
def _store_tilt(tilt: Any, k: int, x: Any, per_s: float, row: int, work: Any) -> None:
    if tilt is None:
        return
    store(work, row + TILT_RATE, lanes_channel(tilt, k, x)[1] * per_s)


@inlined
def _store_gravity(gravity: Any, k: int, x: Any, row: int, work: Any) -> None:
    if gravity is None:
        return
    store(work, row + GRAVITY, lanes_channel(gravity, k, x)[0])


@compiled
def forcing_at_nodes(place: Any, drag: bool, row: int, work: Any) -> None:
    """Fill rows `row` and on with γ̇, γ̈, τ̇ and g at the nodes of a step.

    Args:
        place: forcing, piece k, where the step begins in it and its length, both in x.
        drag: whether τ̇ is felt.
        row: first of ROWS rows; those of absent channels are left alone.
        work: rows of 8.
    """
    forcing, k, x0, hx = place
    length, neutral, tilt, gravity = forcing
    per_s = 1.0 / length[k]
    x = load(work, FRACTIONS) * hx + x0
    _store_line(neutral, k, x, per_s, row, work)
    if drag:
        _store_tilt(tilt, k, x, per_s, row, work)
    _store_gravity(gravity, k, x, row, work)


def node_row(channel: Any, work: Any, row: int) -> Any:
    """Return a row of the nodes, 0 where its channel is absent."""
    raise TypeError('node_row runs in compiled code only')


@overload(node_row, strict=False)
def _node_row(channel: Any, work: Any, row: Any) -> Any:
    if isinstance(channel, types.NoneType):
        return lambda channel, work, row: 0.0
    return lambda channel, work, row: load(work, row)


def presence(channel: Any) -> Any:
    """Return None where a channel is absent, else 0: a tuple of them costs nothing to hand on."""
    raise TypeError('presence runs in compiled code only')


@overload(presence, strict=False)
def _presence(channel: Any) -> Any:
    if isinstance(channel, types.NoneType):
        return lambda channel: None
    return lambda channel: 0
