"""A ship's motion in each state of the sea, and how reports describe the states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from tauto_core.samples import NS_PER_S
from tauto_core.ship.fading import Fades
from tauto_core.ship.waves import Harmonics
from tauto_core.ship.weather_kind import State


def sums_of(states: Sequence[State]) -> tuple[int, ...]:
    """Return the number of each state's sum of harmonics, which equal states in a row share."""
    sums = [0]
    for number, (before, after) in enumerate(pairwise(states), 1):
        sums.append(sums[-1] if after.goes_on(before) else number)
    return tuple(sums)


def fades_of(
    states: Sequence[State],
    motion_of: Callable[[int], tuple[Harmonics, Harmonics | None]],
    *,
    heave: bool,
) -> tuple[Fades, Fades | None]:
    """Return roll and heave that change from state to state; heave is None if not asked for.

    Args:
        states: in the order of their times.
        motion_of: function that gives roll and heave of a state with waves, by its number.
        heave: whether heave is asked for.
    """
    at_ns, sums = tuple(state.at_ns for state in states), sums_of(states)
    made = lru_cache(maxsize=4)(motion_of)

    def roll_of(number: int) -> Harmonics | None:
        return None if states[number].sea is None else made(number)[0]

    def heave_of(number: int) -> Harmonics | None:
        return None if states[number].sea is None else made(number)[1]

    return Fades(at_ns, sums, roll_of), Fades(at_ns, sums, heave_of) if heave else None


def seas_at_once(states: Sequence[State], duration_ns: int) -> float:
    """Return the average number of seas that are summed at an instant of the scene: 0 to 2."""
    edges = np.array([0, *(state.at_ns for state in states), duration_ns])
    lengths = np.diff(np.clip(edges, 0, max(duration_ns, 1)))
    sums = sums_of(states)
    pairs = [(sums[0],), *pairwise(sums), (sums[-1],)]
    present = [sum(states[number].sea is not None for number in set(pair)) for pair in pairs]
    return float(np.dot(lengths, present) / max(lengths.sum(), 1))


def told(states: Sequence[State]) -> list[dict[str, Any]]:
    """Return the states as rows of numbers; for a calm the height is 0 and the rest None."""
    return [
        {
            'at_s': state.at_ns / NS_PER_S,
            'significant_wave_height_m': state.height,
            'peak_period_s': None if state.sea is None else state.sea.peak_period,
            'heading_rad': None if state.sea is None else state.heading,
            'speed_m_s': None if state.sea is None else state.speed,
        }
        for state in states
    ]
