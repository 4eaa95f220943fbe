"""The rate at which a ship's motion is sampled, chosen for the accuracy that a scene asks for.

The error of the motion between its samples is known without sailing: that of the interpolation of
each wave (`ship.buffer`), by the product of the distances to the nodes. How much of it reaches the
reading depends on the machine. It is bounded by factors that were measured over the shipped scenes
and those of the benchmark, from 2 to 12.5 Hz, against 40 Hz: see docs/theory/propagators.md.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from tauto_core.samples import FloatArray
from tauto_core.scene.errors import TautoError
from tauto_core.scene.times import DAY_S, NS_PER_S, exact_step
from tauto_core.ship.motion_kind import Channels, ShipKind, Surroundings
from tauto_core.ship.waves import Harmonics

if TYPE_CHECKING:
    from collections.abc import Iterator

ROLL_BEFORE, FORCE_BEFORE = 1, 4
"""Samples on either side of a piece in the windows of roll, which has a rate, and of the force."""

MAX_STRIDE = 8
"""Most samples that one piece spans."""

LARGEST_TURN = 0.4
"""Largest phase of the fast mode of a case between two samples [rad]; the interpolation error is
then below 3e-8 of the amplitude of that mode.
"""

LARGEST_SLOW_TURN = 0.05
"""Largest phase of the slow mode between two samples where angles may be large [rad]. A swing of
1 rad has overtones, which then put the wheel off by 1e-9 of its swing; at 0.1 rad it is 1e-6.
"""

MOST_STEP_PARTS = 64
"""Largest number of parts into which a step of the ship's motion is divided."""

RATES_HZ: tuple[float, ...] = (
    *(1.0, 1.25, 1.6, 2.0, 2.5, 4.0, 5.0, 8.0, 10.0, 12.5, 16.0, 20.0, 25.0, 40.0, 50.0),
    *(80.0, 100.0, 125.0, 200.0, 250.0, 400.0, 500.0, 1000.0, 2000.0),
)
"""Rates to choose from [Hz]; their steps are whole nanoseconds."""

REACHES = 1e-2
"""Part of the error of the motion that reaches the clock's rate, both relative: at most 1.3e-4 in
fixed clocks with an escapement over six hours, 2e-3 in half a minute. It is largest in the first
piece, whose window has one side.
"""

REMEMBERS = 10.0
"""The same over that of a clock with an escapement, where there is none: it keeps a wrong
amplitude, and its rate with it: 5e-2 in all at most.
"""

HUNG = 30.0
"""The same over that of a fixed clock, in a suspended case, which the sea may excite (found: 50,
and 200 without an escapement, both in all).
"""


ROUNDING = 1e-14
"""Error of the motion below which it is that of rounding, which finer samples do not reduce."""


def rate_for(
    scene: Surroundings, ship: ShipKind, accuracy: float, *, forgets: bool, case_hz: float | None
) -> float:
    """Return the lowest of `RATES_HZ` that keeps the error of the rate below the accuracy.

    The steps divide the log interval, and a wave has more than two of them. Where no rate is
    high enough it is the highest that fits; where the motion cannot be had, the ship's own.

    Args:
        scene: what the motion depends on.
        ship: how she moves; her own rate does not matter.
        accuracy: error of the clock's rate by sampling [s/day].
        forgets: whether an escapement keeps the amplitude.
        case_hz: least rate that the modes of a suspended case allow [Hz]; None without a case.
    """
    rates = [rate for rate in RATES_HZ if scene.log_interval_ns % exact_step(rate) == 0]
    rates = [rate for rate in rates if case_hz is None or rate >= case_hz]
    if not rates:
        return ship.rate
    allowed = accuracy / (DAY_S * REACHES)
    allowed /= (1.0 if forgets else REMEMBERS) * (1.0 if case_hz is None else HUNG)
    allowed = max(allowed, ROUNDING)
    try:
        finest = ship.model_copy(update={'rate': rates[-1]})
        seas = [
            tuple(_waves(scene, ship, sea.ship.channels(scene)))
            for sea in finest.worst_seas(scene)
            if not sea.ship.lies_still
        ]
    except TautoError:  # it is said where the motion is made
        return ship.rate
    for rate in rates[:-1]:
        logs = round(scene.log_interval_ns * rate / NS_PER_S)
        strides = (n for n in range(MAX_STRIDE, 0, -1) if logs % n == 0)
        stride = next(strides) if case_hz is None else 1
        errors = (
            amplitude * _remainder(stride, omega / rate, slopes=slopes)
            for waves in seas
            for amplitude, omega, slopes in waves
        )
        if all(np.linalg.norm(error) <= allowed for error in errors) and _follows(
            scene, ship, rate
        ):
            return rate
    return rates[-1]


def _follows(scene: Surroundings, ship: ShipKind, rate: float) -> bool:
    """Return whether nothing refuses the ship at a rate."""
    sampled = ship.model_copy(update={'rate': rate})
    try:
        sampled.channels(scene)
    except TautoError:
        return False
    return next(sampled.problems(), None) is None


def _waves(
    scene: Surroundings, ship: ShipKind, moved: Channels
) -> Iterator[tuple[FloatArray, FloatArray, bool]]:
    """Yield amplitudes [rad, or over g], frequencies [rad/s], whether rates come with them."""
    for force in (moved.force_y, moved.force_z):
        if force is not None:
            yield np.abs(force.amplitude) / scene.g, force.angular_frequency, False
    if isinstance(moved.roll, Harmonics):
        size, omega = np.abs(moved.roll.amplitude), moved.roll.angular_frequency
        yield size, omega, True
        yield size * omega**2 * abs(ship.height) / scene.g, omega, False
    six = moved.six
    lifted = (moved.heave,) if six is None else (moved.heave, six.sway, six.surge)
    for each in lifted:
        if isinstance(each, Harmonics):
            omega = each.angular_frequency
            yield np.abs(each.amplitude) * omega**2 / scene.g, omega, False


def _remainder(stride: int, turns: FloatArray, *, slopes: bool) -> FloatArray:
    """Return the largest error over the first piece of a wave of unit amplitude.

    `turns` are Ωh of the waves. The window begins at the piece, as at the start of a run.
    """
    values, rates, places = _weights(stride, slopes)
    nodes = np.arange(values.shape[1])
    waves = np.exp(1j * np.outer(nodes, turns))
    seen = values @ waves + rates @ (1j * turns * waves)
    error: FloatArray = np.max(np.abs(seen - np.exp(1j * np.outer(places, turns))), axis=0)
    return error


@lru_cache(maxsize=2 * MAX_STRIDE)
def _weights(stride: int, slopes: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the weights of values and rates at places of the first piece, and the places.

    Lagrange's polynomials, or with slopes Hermite's (Stoer & Bulirsch, 2.1).
    """
    nodes = np.arange(stride + 1 + 2 * (ROLL_BEFORE if slopes else FORCE_BEFORE), dtype=np.float64)
    places: FloatArray = (np.arange(2 * stride, dtype=np.float64) + 0.5) / 2.0
    others = [np.delete(nodes, j) for j in range(len(nodes))]
    lagrange: FloatArray = np.stack(
        [
            np.prod((places[:, None] - rest) / (node - rest), axis=1)
            for node, rest in zip(nodes, others, strict=True)
        ],
        axis=1,
    )
    if not slopes:
        return lagrange, np.zeros_like(lagrange), places
    away = places[:, None] - nodes
    bend = np.array(
        [np.sum(1.0 / (node - rest)) for node, rest in zip(nodes, others, strict=True)]
    )
    square: FloatArray = lagrange * lagrange
    return (1.0 - 2.0 * away * bend) * square, away * square, places
