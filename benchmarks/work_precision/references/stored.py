"""Where the wheel truly is: reference states, and how they are made.

    python -m benchmarks.work_precision.references.stored [--until SECONDS] [PROBLEM ...]

makes `references.json` again (half an hour and two cores for c and e, ten
minutes for a day of f). Problems a, b and d are closed forms in 40 digits (`exact`). Problems c,
e and f are integrated in two ways, heyoka in long double (stored) and Gauss–Legendre in double
precision (`long_double` and `gauss`; of f both in `case`); `agree_rad` is how far the
two are apart at each time.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks.work_precision.problems import CaseProblem, Problem, WheelProblem, problems
from tauto_core.scene.errors import TautoError
from tauto_core.scene.times import DAY_S

DURATIONS_S = (60.0, 600.0, 3600.0, 21_600.0, 86_400.0, 864_000.0, 6_998_400.0)
"""At which the states are known, as far as a problem lasts [s]."""
FILE = Path(__file__).with_name('references.json')
STEPS_A_SECOND = 8.37
"""Of the second way; not a whole number of steps in a swing, or its rounding would add up."""
CASE_STEPS_A_SECOND = 128.0
"""The same for the case, whose fast mode turns ten times as fast; a step is a binary fraction."""

_CLOSED = 'closed form, 40 digits (mpmath)'
_INTEGRATED = (
    'heyoka, Taylor in x87 long double at tolerance 1e-19; agree_rad: against Gauss-Legendre of '
    'order 16 in double precision, {:.4g} steps a second'
)


class NoReferenceError(TautoError):
    """A duration at which no reference is known."""


@dataclass(frozen=True)
class Reference:
    """The state of the wheel, or of the case, at a time.

    Attributes:
        time_s: from the start [s].
        angle: theta of the wheel, phi of the case [rad].
        rate: of the angle [rad/s].
    """

    time_s: float
    angle: float
    rate: float


@cache
def references(key: str) -> dict[float, Reference]:
    """Return the reference states of a problem by duration [s], rising."""
    rows = json.loads(FILE.read_text('utf-8'))['problems'][key]['states']
    found = [Reference(row['time_s'], float(row['angle']), float(row['rate'])) for row in rows]
    return {reference.time_s: reference for reference in found}


def reference(problem: Problem, duration_s: float) -> Reference:
    """Return the reference state of a problem at the end of a run.

    Raises:
        NoReferenceError: none is known for this duration.
    """
    known = references(problem.key)
    if duration_s not in known:
        raise NoReferenceError(
            f'problem {problem.key}: no reference at {duration_s!r} s. Run it for one of '
            f'{", ".join(f"{time:g}" for time in known)} s'
        )
    return known[duration_s]


def error_rad(problem: Problem, angle: float, rate: float, true: Reference) -> float:
    """Return the angle between two states in the plane (angle, -rate/omega) [rad].

    A turn there is a swing, so this is the error of the phase but for the well's departure from
    harmonic: within its square root of the mass, 0.5 % here. Of the case the angle is phi, and
    omega that of small swings in the slow mode; what the fast mode adds to phi'/omega stays a
    small part of the swing, so that states never come near the middle. Positive: ahead.
    """
    omega = problem.numbers.frequency
    here, there = complex(angle, -rate / omega), complex(true.angle, -true.rate / omega)
    ratio = here * there.conjugate()
    return math.atan2(ratio.imag, ratio.real)


def rad_to_s_per_day(problem: Problem, error: float, duration_s: float) -> float:
    """Return a phase error [rad] at the end of a run as the rate of a clock [s/day]."""
    return error / problem.numbers.frequency / duration_s * DAY_S


def _closed(problem: WheelProblem, times_s: Sequence[float]) -> list[dict[str, Any]]:
    from mpmath import mp

    from benchmarks.work_precision.references.exact import exact_state

    rows = []
    for time in times_s:
        angle, rate = (mp.nstr(value, 20) for value in exact_state(problem, time))
        rows.append({'time_s': time, 'angle': angle, 'rate': rate})
    return rows


def _first_way(problem: Problem, times_s: Sequence[float]) -> list[tuple[str, str]]:
    if isinstance(problem, CaseProblem):
        from benchmarks.work_precision.references.integrated import long_double_case

        return [(phi, rate) for _, phi, _, rate in long_double_case(problem.numbers, times_s)]
    from benchmarks.work_precision.references.integrated import long_double_states

    return long_double_states(problem, times_s)


def _second_way(problem: Problem, times_s: Sequence[float]) -> list[tuple[float, float]]:
    if isinstance(problem, CaseProblem):
        from benchmarks.work_precision.references.integrated import gauss_case

        states = gauss_case(problem.numbers, times_s, CASE_STEPS_A_SECOND)
        return [(float(phi), float(rate)) for _, phi, _, rate in states]
    from benchmarks.work_precision.references.integrated import gauss_states

    return gauss_states(problem, times_s, STEPS_A_SECOND)


def _both_ways(
    problem: Problem,
    times_s: Sequence[float],
    first: Future[list[tuple[str, str]]],
    second: Future[list[tuple[float, float]]],
) -> list[dict[str, Any]]:
    rows = []
    for time, (angle, rate), other in zip(times_s, first.result(), second.result(), strict=True):
        apart = abs(error_rad(problem, *other, Reference(time, float(angle), float(rate))))
        agree = float(f'{apart:.2g}')
        rows.append({'time_s': time, 'angle': angle, 'rate': rate, 'agree_rad': agree})
    return rows


def _made(asked: Sequence[Problem], until_s: float) -> dict[str, Any]:
    times = {
        p.key: [time for time in DURATIONS_S if time <= min(p.duration_s, until_s)] for p in asked
    }
    hard = [p for p in asked if p.key in 'cef']
    made: dict[str, Any] = {
        p.key: {'made_by': _CLOSED, 'states': _closed(p, times[p.key])}
        for p in asked
        if isinstance(p, WheelProblem) and p not in hard
    }
    with ProcessPoolExecutor(2) as pool:
        jobs = [
            (
                p,
                pool.submit(_first_way, p, times[p.key]),
                pool.submit(_second_way, p, times[p.key]),
            )
            for p in hard
        ]
        for p, first, second in jobs:
            states = _both_ways(p, times[p.key], first, second)
            steps = CASE_STEPS_A_SECOND if isinstance(p, CaseProblem) else STEPS_A_SECOND
            made[p.key] = {'made_by': _INTEGRATED.format(steps), 'states': states}
    return made


def main() -> None:
    """Make references again and write them beside this module."""
    keys = [problem.key for problem in problems()]
    parser = argparse.ArgumentParser(description='Make the reference states again.')
    parser.add_argument('problems', nargs='*', help='keys; default: all')
    parser.add_argument('--until', type=float, default=math.inf, metavar='SECONDS')
    options = parser.parse_args()
    asked = [p for p in problems() if p.key in (options.problems or keys)]
    made = _made(asked, options.until)
    known = json.loads(FILE.read_text('utf-8'))['problems'] if FILE.exists() else {}
    text = json.dumps({'problems': dict(sorted((known | made).items()))}, indent=1)
    FILE.write_text(text + '\n', 'utf-8')


if __name__ == '__main__':
    main()
