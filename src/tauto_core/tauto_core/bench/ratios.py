"""How many times faster: peers' cheapest rows that are no less accurate."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from tauto_core.bench.problems import Problem, problems
from tauto_core.samples import SECONDS_PER_DAY

LAND_ERROR_RAD = 1e-9
UNIT_ROUNDING = 2.0**-53


@dataclass(frozen=True)
class Target:
    """What is to be reached on a problem.

    Attributes:
        error_s_per_day: error at which programs are compared [s/day].
        faster: how many times faster than a program, by its name.
    """

    error_s_per_day: float
    faster: Mapping[str, float]


def targets() -> dict[str, Target]:
    """Return the targets by the problems' keys; f has none."""
    found = {p.key: p for p in problems()}
    land = {'heyoka': 1e5, 'dop853': 1e7}
    return {
        'a': Target(_land_error(found['a']), land),
        'b': Target(_land_error(found['b']), land),
        'c': Target(1e-9, {'heyoka': 20.0, 'dop853': 500.0}),
        'd': Target(1e-9, {'heyoka': 60.0, 'dop853': 2000.0}),
        'e': Target(1e-7, {'heyoka': 10.0, 'dop853': 300.0}),
    }


def _land_error(problem: Problem) -> float:
    """Return 1e-9 rad and the rounding of the phase at the end, as a clock's rate [s/day]."""
    omega, length = problem.numbers.frequency, problem.duration_s
    error = LAND_ERROR_RAD + UNIT_ROUNDING * omega * length
    return error / omega / length * SECONDS_PER_DAY


def ratio(
    row: Mapping[str, Any], rows: Iterable[Mapping[str, Any]], program: str, bound: float
) -> float | None:
    """Return how many times a program's cheapest row of like accuracy costs this row.

    A row counts if its error is at most that of `row`, or the bound where that is larger.

    Args:
        row: of the faster program.
        rows: of all.
        program: the other one.
        bound: error that is good enough [s/day].

    Returns:
        None where it has no row so accurate.
    """
    enough = max(bound, row['error_s_per_day'])
    costs = [
        other['us_per_oscillation']
        for other in rows
        if other['problem'] == row['problem']
        and other['program'] == program
        and other['error_s_per_day'] <= enough
    ]
    return min(costs) / row['us_per_oscillation'] if costs else None


def best_ratio(rows: Iterable[Mapping[str, Any]], key: str, program: str) -> float | None:
    """Return the ratio of Tauto's cheapest row within the target's error; None where none is.

    Args:
        rows: of all problems.
        key: of the problem; without a target, there is no ratio.
        program: compared with.
    """
    if key not in targets():
        return None
    rows, bound = list(rows), targets()[key].error_s_per_day
    ours = [
        row
        for row in rows
        if row['problem'] == key and row['program'] == 'tauto' and row['error_s_per_day'] <= bound
    ]
    if not ours:
        return None
    cheapest = min(ours, key=lambda row: float(row['us_per_oscillation']))
    found = ratio(cheapest, rows, program, bound)
    return found if found is not None and math.isfinite(found) else None
