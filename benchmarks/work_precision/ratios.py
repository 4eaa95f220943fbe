"""Speed ratios: the cheapest rows of others that are at least as accurate."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from benchmarks.work_precision.problems import Problem, problems
from tauto_core.scene.times import DAY_S

LAND_ERROR_RAD = 1e-9
UNIT_ROUNDING = 2.0**-53

FAMILIES: Mapping[str, tuple[str, ...]] = {
    'heyoka': ('heyoka', 'heyoka_tuned'),
    'heyoka, 8 ships': ('heyoka_batch',),
    'dop853': ('dop853_compiled',),
}
"""The programs with which a method is compared, the plain formulation first; the best counts.

Rows of eight ships hold the time of one of them; Tauto sails them one after the other.
"""

BenchRow = Mapping[str, Any]


def targets() -> dict[str, float]:
    """Return the errors at which programs are compared [s/day], by the problems' keys."""
    land = {p.key: _land_error(p) for p in problems() if p.key in 'ab'}
    return {**land, 'c': 1e-9, 'd': 1e-9, 'e': 1e-7, 'f': 1e-9}


FINE_S_PER_DAY, NAVIGATORS_S_PER_DAY = 1e-8, 1e-3
"""Errors at which programs are compared besides: a fine one, a navigator's need [s/day]."""

ASKED_S_PER_DAY = 1e-6, NAVIGATORS_S_PER_DAY
"""Errors that scenes ask for: that of those that state none, and that of the clocks to compare."""


def _land_error(problem: Problem) -> float:
    """Return 1e-9 rad and the rounding of the phase at the end, as a clock's rate [s/day]."""
    omega, length = problem.numbers.frequency, problem.duration_s
    error = LAND_ERROR_RAD + UNIT_ROUNDING * omega * length
    return error / omega / length * DAY_S


def cheapest(
    rows: Iterable[BenchRow], key: str, programs: Iterable[str], error_s_per_day: float
) -> BenchRow | None:
    """Return the cheapest row of a problem and some programs within an error, or None."""
    names = tuple(programs)
    enough = [
        row
        for row in rows
        if row['problem'] == key
        and row['program'] in names
        and row['error_s_per_day'] <= error_s_per_day
    ]
    return min(enough, key=lambda row: float(row['us_per_oscillation']), default=None)


def ratio(
    row: BenchRow, rows: Iterable[BenchRow], programs: Iterable[str], bound: float
) -> float | None:
    """Return the cost of the cheapest row of similar accuracy over the cost of this row.

    A row counts if its error is at most that of `row`, or the bound [s/day] if that is larger.
    None: no row of the other programs is so accurate.
    """
    enough = max(bound, row['error_s_per_day'])
    other = cheapest(rows, row['problem'], programs, enough)
    if other is None:
        return None
    found = float(other['us_per_oscillation'] / row['us_per_oscillation'])
    return found if math.isfinite(found) else None


def whole_run_s(row: BenchRow) -> float:
    """Return the time of a run of the problem's full length, set-up included [s].

    Shorter runs are extrapolated at their cost per swing. Set-up is everything before the first
    step, with all code compiled that can be kept.
    """
    (problem,) = (each for each in problems() if each.key == row['problem'])
    swings = problem.duration_s / problem.period_s
    return float(row['setup_s'] + 1e-6 * row['us_per_oscillation'] * swings)


def best(rows: Iterable[BenchRow], key: str) -> BenchRow | None:
    """Return Tauto's cheapest row within the target's error; None where there is none."""
    return cheapest(rows, key, ['tauto'], targets()[key])


def best_ratio(
    rows: Iterable[BenchRow], key: str, programs: Iterable[str], *, setup: bool = False
) -> float | None:
    """Return the time of others at their best over that of Tauto, or None.

    With `setup`, whole runs are compared, set-up included, instead of swings.
    """
    rows, bound = list(rows), targets()[key]
    ours = best(rows, key)
    if ours is None:
        return None
    if not setup:
        return ratio(ours, rows, programs, bound)
    theirs = cheapest(rows, key, programs, max(bound, ours['error_s_per_day']))
    return None if theirs is None else whole_run_s(theirs) / whole_run_s(ours)
