"""Rules between the times of a scene: whole nanoseconds, and grids that fit into each other."""

from __future__ import annotations

import math
from collections.abc import Iterator
from decimal import Decimal
from typing import TYPE_CHECKING

from tauto_core.scene.errors import Problem
from tauto_core.scene.times import (
    LAST_STAMP_S,
    MAX_GAP_S,
    NS_PER_S,
    exact_nanoseconds,
    exact_step,
    samples_beyond_end,
)

if TYPE_CHECKING:
    from tauto_core.scene.models import Scene


def time_problems(scene: Scene) -> Iterator[Problem]:
    """Yield what is wrong with the times of a scene."""
    grid = list(_whole_nanoseconds(scene))
    yield from grid
    if not grid:
        yield from _grids(scene)


def _whole_nanoseconds(scene: Scene) -> Iterator[Problem]:
    times = {
        'starts_at': scene.starts_at,
        'duration': scene.duration,
        'log.interval': scene.log.interval,
        'drift.observation_interval': scene.drift.observation_interval,
    }
    for key, value in times.items():
        if exact_nanoseconds(value).denominator != 1:
            yield Problem(
                key,
                value,
                'is not a whole number of nanoseconds',
                'Give it to at most nine decimals.',
            )
    if scene.ship.kind == 'still':
        return
    step = exact_step(scene.ship.rate)
    if step.denominator != 1 or step < 1:
        whole = max(round(step), 1)
        yield Problem(
            'ship.rate',
            scene.ship.rate,
            f'makes steps of {float(step):.12g} ns, which must be whole nanoseconds',
            f'Use a rate that divides 1e9, for example {_near_rate(scene.ship.rate)} Hz, '
            f'or exactly 1e9/{whole}.',
        )
    elif step > MAX_GAP_S * NS_PER_S:
        yield Problem(
            'ship.rate',
            scene.ship.rate,
            f'leaves {float(step) / NS_PER_S:.6g} s between samples of the motion; at most '
            f'{MAX_GAP_S:g} s are interpolated',
            f'Use {_least_rate(scene)}.',
        )


def _least_rate(scene: Scene) -> str:
    """Return in words at which rates the motion can be interpolated."""
    least_hz, periods = 1.0 / MAX_GAP_S, [math.inf]
    if scene.ship.kind == 'components':
        periods += [c.period for c in (*scene.ship.components, *(scene.ship.heave or ()))]
    if 2.0 / min(periods) >= least_hz:
        return (
            f'more than {2.0 / min(periods):.6g} Hz, two samples in a wave of {min(periods)!r} s'
        )
    return f'{least_hz!r} Hz or more'


def _near_rate(rate_hz: float) -> float:
    """Return the nearest common sampling rate."""
    common = (1.0, 2.0, 4.0, 5.0, 8.0, 10.0, 12.5, 16.0, 20.0, 25.0, 32.0, 40.0, 50.0)
    fast = (64.0, 80.0, 100.0, 125.0, 128.0, 160.0, 200.0, 250.0, 400.0, 500.0, 1000.0)
    return min((*common, *fast), key=lambda near: abs(math.log(near / rate_hz)))


def _grids(scene: Scene) -> Iterator[Problem]:
    interval_ns, step_ns = scene.log_interval_ns, scene.step_ns
    interval = scene.log.interval
    if interval_ns % step_ns:
        yield Problem(
            'log.interval',
            interval,
            f'is not a whole number of steps of {Decimal(step_ns) / 10**9:.12g} s (ship.rate '
            f'{scene.ship.rate!r} Hz)',
            f'Use {_multiple(interval_ns, step_ns)}.',
        )
    for key, value, value_ns in (
        ('duration', scene.duration, scene.duration_ns),
        (
            'drift.observation_interval',
            scene.drift.observation_interval,
            round(exact_nanoseconds(scene.drift.observation_interval)),
        ),
    ):
        if value_ns % interval_ns:
            yield Problem(
                key,
                value,
                f'is not a whole number of log intervals (log.interval {interval!r} s)',
                f'Use {_multiple(value_ns, interval_ns)}, or change log.interval.',
            )
    beyond = samples_beyond_end(scene)
    end_ns = scene.starts_at_ns + scene.duration_ns + beyond * step_ns
    if end_ns > LAST_STAMP_S * 10**9:
        yield Problem(
            'duration',
            scene.duration,
            f'ends at {Decimal(end_ns) / 10**9:.12g} s with the {beyond} steps beyond '
            f'the end; ROS stamps end at {LAST_STAMP_S} s',
            'Shorten it, or let starts_at be earlier.',
        )


def _multiple(value_ns: int, grid_ns: int) -> str:
    below = value_ns // grid_ns * grid_ns
    near = [f'{Decimal(ns) / 10**9:.15g}' for ns in (below, below + grid_ns) if ns]
    return ' or '.join(near) + ' s'
