"""Rules between the times of a scene: whole nanoseconds, and steps that fit each other."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from decimal import Decimal
from itertools import count, islice

from tauto_core.scene.errors import Problem
from tauto_core.scene.times import (
    LAST_STAMP_S,
    MAX_GAP_S,
    NS_PER_S,
    exact_nanoseconds,
    exact_step,
    nanoseconds,
)

_MOST_TRIED = 100_000
"""Number of parts into which a length is divided in the search of a log interval."""


@dataclass(frozen=True)
class Times:
    """The times that a scene gives.

    Attributes:
        starts_at: stamp of the first sample [s].
        duration: length of the scene [s].
        log_interval: time between logged samples [s].
        observation_interval: time between observations in port [s].
        lunar_interval: time between lunar distances [s]; None: none are taken.
        rate: sampling rate of the motion of a ship that moves [Hz].
        shortest_wave_s: shortest period of the given waves [s]; inf where there are none.
        still: whether the ship lies still; then the rate does not matter.
        step_ns: time between samples of the ship's motion [ns].
        beyond: number of steps that are sent beyond the end.
    """

    starts_at: float
    duration: float
    log_interval: float
    observation_interval: float
    lunar_interval: float | None
    rate: float
    shortest_wave_s: float
    still: bool
    step_ns: int
    beyond: int

    def problems(self) -> Iterator[Problem]:
        """Yield what is wrong with them."""
        grid = list(_whole_nanoseconds(self))
        yield from grid
        if not grid:
            yield from _grids(self)


def _whole_nanoseconds(times: Times) -> Iterator[Problem]:
    values = {
        'starts_at': times.starts_at,
        'duration': times.duration,
        'log.interval': times.log_interval,
        'drift.observation_interval': times.observation_interval,
        **_of_lunars(times),
    }
    for key, value in values.items():
        if exact_nanoseconds(value).denominator != 1:
            yield Problem(
                key,
                value,
                'is not a whole number of nanoseconds',
                'Give it to at most nine decimals.',
            )
    if times.still:
        return
    step = exact_step(times.rate)
    if step.denominator != 1 or step < 1:
        yield Problem(
            'ship.rate',
            times.rate,
            f'makes steps of {float(step):.12g} ns, which must be whole nanoseconds',
            f'Use a rate that divides 1e9, for example {_near_rate(times)} Hz.',
        )
    elif step > MAX_GAP_S * NS_PER_S:
        yield Problem(
            'ship.rate',
            times.rate,
            f'leaves {float(step) / NS_PER_S:.6g} s between samples of the motion; at most '
            f'{MAX_GAP_S:g} s are interpolated',
            f'Use {_least_rate(times.shortest_wave_s)}.',
        )


def _least_rate(shortest_wave_s: float) -> str:
    """Return in words the rates at which the motion can be interpolated."""
    least_hz, two_a_wave_hz = 1.0 / MAX_GAP_S, 2.0 / shortest_wave_s
    if two_a_wave_hz >= least_hz:
        return f'more than {two_a_wave_hz:.6g} Hz, two samples in a wave of {shortest_wave_s!r} s'
    return f'{least_hz!r} Hz or more'


def _near_rate(times: Times) -> float:
    """Return the nearest common sampling rate whose steps fit the log, if one does."""
    common = (1.0, 2.0, 4.0, 5.0, 8.0, 10.0, 12.5, 16.0, 20.0, 25.0, 32.0, 40.0, 50.0)
    fast = (64.0, 80.0, 100.0, 125.0, 128.0, 160.0, 200.0, 250.0, 400.0, 500.0, 1000.0)
    least_hz, log_ns = 2.0 / times.shortest_wave_s, nanoseconds(times.log_interval)
    enough = [near for near in (*common, *fast) if near > least_hz] or [fast[-1]]
    fitting = [near for near in enough if log_ns % exact_step(near) == 0]
    return min(fitting or enough, key=lambda near: abs(math.log(near / times.rate)))


def _grids(times: Times) -> Iterator[Problem]:
    yield from _log_grid(times)
    beyond_ns = times.beyond * times.step_ns
    end_ns = nanoseconds(times.starts_at) + nanoseconds(times.duration) + beyond_ns
    if end_ns > LAST_STAMP_S * 10**9:
        yield Problem(
            'duration',
            times.duration,
            f'ends at {Decimal(end_ns) / 10**9:.12g} s with the {times.beyond} steps beyond '
            f'the end; ROS stamps end at {LAST_STAMP_S} s',
            'Shorten it, or let starts_at be earlier.',
        )


def _log_grid(times: Times) -> Iterator[Problem]:
    """Yield what does not fit log.interval; where nothing fits it, only the interval."""
    interval, step_ns = times.log_interval, 1 if times.still else times.step_ns
    interval_ns = nanoseconds(interval)
    lengths = {
        'duration': times.duration,
        'drift.observation_interval': times.observation_interval,
        **_of_lunars(times),
    }
    apart = {key: value for key, value in lengths.items() if nanoseconds(value) % interval_ns}
    off_steps = interval_ns % step_ns
    if off_steps or (apart == lengths and _all_whole(lengths.values())):
        said = (
            f'is not a whole number of steps of {_digits(step_ns)} s (ship.rate {times.rate!r} Hz)'
        )
        each = ', nor '.join(f'{key}, {value!r} s' for key, value in lengths.items())
        yield Problem(
            'log.interval',
            interval,
            said if off_steps else f'does not divide {each}',
            f'Use {_fitting(interval_ns, step_ns, map(nanoseconds, lengths.values()))}.',
        )
        return
    for key, value in apart.items():
        yield Problem(
            key,
            value,
            f'is not a whole number of log intervals (log.interval {interval!r} s)',
            f'Use {_multiple(nanoseconds(value), interval_ns)}, or change log.interval.',
        )


def _all_whole(lengths: Iterable[float]) -> bool:
    """Return whether lengths are whole seconds, so that they fit a log as it is by default."""
    return all(value.is_integer() for value in lengths)


def _fitting(interval_ns: int, step_ns: int, lengths_ns: Iterable[int]) -> str:
    """Return the nearest log intervals that are whole steps and, if there are such, divide all
    lengths.
    """
    steps, rest = divmod(math.gcd(*lengths_ns), step_ns)
    if rest:
        return _multiple(interval_ns, step_ns)
    parts = steps * step_ns / interval_ns
    more, fewer = count(math.ceil(parts)), range(math.floor(parts), 0, -1)
    near = [
        next((steps // n for n in islice(counts, _MOST_TRIED) if steps % n == 0), None)
        for counts in (more, fewer)
    ]
    found = dict.fromkeys(_digits(each * step_ns) for each in near if each)
    return ' or '.join(found) + ' s' if found else _multiple(interval_ns, step_ns)


def _of_lunars(times: Times) -> dict[str, float]:
    lunars = times.lunar_interval
    return {} if lunars is None else {'drift.lunars.interval': lunars}


def _multiple(value_ns: int, grid_ns: int) -> str:
    below = value_ns // grid_ns * grid_ns
    return ' or '.join(_digits(ns) for ns in (below, below + grid_ns) if ns) + ' s'


def _digits(length_ns: int) -> str:
    return f'{Decimal(length_ns) / 10**9:.15g}'
