"""The benchmark: every peer at every setting on every problem, run time beside error.

A run climbs through the durations at which a reference is known, as far as its budget lasts and
its error stays a small part of a turn, since a larger one could not be told from a smaller. The
row is the longest run. Peers take turns, so that a disturbed minute hits all alike; runs that are
cheap are repeated in a second round, and the faster counts.
"""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from importlib.metadata import version
from itertools import zip_longest
from pathlib import Path
from typing import Any

from benchmarks.work_precision.first_run import first_runs
from benchmarks.work_precision.peer import Outcome, Peer, make_peers
from benchmarks.work_precision.problems import Problem, problems
from benchmarks.work_precision.references.stored import (
    error_rad,
    rad_to_s_per_day,
    reference,
    references,
)
from tauto_core.scene.errors import TautoError, UsageError

BUDGET_S = 20.0
QUICK_BUDGET_S = 1.0
LARGEST_ERROR_RAD = 0.5
CHEAP = 0.25
"""Part of the budget up to which a run is repeated."""

Say = Callable[[str], None]


@dataclass(frozen=True)
class Row:
    """One point of the work–precision diagram.

    Attributes:
        problem: its key.
        program: name of the peer.
        setting: of the peer.
        duration_s: length of the run [s].
        error_s_per_day: size of the clock's error at the end over the run's length [s/day].
        error_rad: size of the phase error at the end [rad].
        run_s: best run time [s].
        compile_s: compiling and setting up, the first time [s].
        setup_s: the same when all is compiled that can be kept: the least of all runs [s].
        us_per_oscillation: run time per swing of the problem's period [us].
    """

    problem: str
    program: str
    setting: str
    duration_s: float
    error_s_per_day: float
    error_rad: float
    run_s: float
    compile_s: float
    setup_s: float
    us_per_oscillation: float


@dataclass
class _Entry:
    """A peer at a setting, and how far it came."""

    problem: Problem
    peer: Peer
    setting: str
    row: Row | None = None
    failure: str | None = None


def bench(
    problem_keys: Sequence[str] | None = None,
    peer_names: Sequence[str] | None = None,
    *,
    quick: bool = False,
    budget_s: float | None = None,
    cold: bool = False,
    say: Say = lambda _: None,
) -> dict[str, Any]:
    """Run the benchmark; return the object that `--json` prints.

    Args:
        problem_keys: of the problems; None: all.
        peer_names: of the peers; None: all that are installed.
        quick: three settings a peer and a second a run: to see that all works.
        budget_s: time allowed a run [s]; None: 20, or 1 if quick.
        cold: also time each program's first run in a new process.
        say: told what is under way.

    Returns:
        `machine`, `rows`, `first_runs` (where `cold`), `missing` (peers that are not installed),
        `not_offered` (problems that a peer cannot express) and `failed` (runs without a row, and
        why).

    Raises:
        UsageError: a problem or a peer that is not known.
    """
    chosen = choose(problem_keys)
    peers, missing = make_peers(peer_names)
    for each in missing:
        say(each)
    budget = (QUICK_BUDGET_S if quick else BUDGET_S) if budget_s is None else budget_s
    entries = [e for problem in chosen for e in _bench_problem(problem, peers, quick, budget, say)]
    rows = [asdict(e.row) for e in entries if e.row is not None]
    return {
        'machine': machine_facts({peer.name: peer.version() for peer in peers}),
        'rows': rows,
        'first_runs': first_runs(rows, say) if cold else [],
        'missing': missing,
        'not_offered': {
            peer.name: keys
            for peer in peers
            if (keys := [p.key for p in chosen if not peer.settings(p)])
        },
        'failed': [
            {
                'problem': e.problem.key,
                'program': e.peer.name,
                'setting': e.setting,
                'why': e.failure,
            }
            for e in entries
            if e.failure is not None
        ],
    }


def choose(keys: Sequence[str] | None) -> list[Problem]:
    """Return the problems of these keys; None: all.

    Raises:
        UsageError: a key that is not known.
    """
    known = {problem.key: problem for problem in problems()}
    unknown = [key for key in keys or () if key not in known]
    if unknown:
        raise UsageError(f'problem {unknown[0]!r} is not known. Choose from {", ".join(known)}')
    return list(known.values()) if keys is None else [known[key] for key in keys]


def _bench_problem(
    problem: Problem, peers: Sequence[Peer], quick: bool, budget_s: float, say: Say
) -> list[_Entry]:
    columns = [
        [_Entry(problem, peer, setting) for setting in _few(peer.settings(problem), quick)]
        for peer in peers
    ]
    turns = [e for turn in zip_longest(*columns) for e in turn if e is not None]
    for entry in turns:
        say(f'{problem.key}: {entry.peer.name} {entry.setting}')
        _climb(entry, budget_s)
    for entry in turns:
        if entry.row is not None and entry.row.run_s <= CHEAP * budget_s:
            say(f'{problem.key}: {entry.peer.name} {entry.setting}, again')
            _repeat(entry, entry.row)
    return [entry for column in columns for entry in column]


def _few(settings: Sequence[str], quick: bool) -> Sequence[str]:
    if not quick or len(settings) <= 3:
        return settings
    return settings[0], settings[len(settings) // 2], settings[-1]


def _climb(entry: _Entry, budget_s: float) -> None:
    """Run ever longer; keep the longest run, or why there is none."""
    compile_s, setup_s = 0.0, math.inf
    for duration_s in references(entry.problem.key):
        row = entry.row
        if row is not None and not _may_go_on(row, duration_s, budget_s):
            break
        try:
            new = measure(entry.problem, entry.peer, entry.setting, duration_s)
        except TautoError as error:
            entry.failure = f'run of {duration_s:g} s: {error}'
            break
        compile_s, setup_s = max(compile_s, new.compile_s), min(setup_s, new.setup_s)
        if not new.error_rad <= LARGEST_ERROR_RAD:
            if row is None:
                entry.failure = (
                    f'off by {new.error_rad:.2g} rad after {duration_s:g} s: too coarse'
                )
            break
        entry.row = replace(new, compile_s=compile_s, setup_s=setup_s)


def _may_go_on(row: Row, duration_s: float, budget_s: float) -> bool:
    """Return whether a longer run fits the budget and its phase can still be told by the turn."""
    longer = duration_s / row.duration_s
    return row.run_s * longer <= budget_s and row.error_rad * longer**2 <= LARGEST_ERROR_RAD


def _repeat(entry: _Entry, row: Row) -> None:
    again = measure(entry.problem, entry.peer, entry.setting, row.duration_s)
    row = replace(row, setup_s=min(row.setup_s, again.setup_s))
    if again.run_s < row.run_s:
        row = replace(row, run_s=again.run_s, us_per_oscillation=again.us_per_oscillation)
    entry.row = row


def measure(problem: Problem, peer: Peer, setting: str, duration_s: float) -> Row:
    """Run once and compare with the reference.

    Raises:
        TautoError: the run failed, or no reference is known for its duration.
    """
    true = reference(problem, duration_s)
    outcome: Outcome = peer.solve(problem, setting, duration_s)
    if outcome.time_s != duration_s:
        raise UsageError(f'{peer.name} ended at {outcome.time_s} s instead of {duration_s} s')
    error = abs(error_rad(problem, outcome.angle, outcome.rate, true))
    return Row(
        problem=problem.key,
        program=peer.name,
        setting=setting,
        duration_s=duration_s,
        error_s_per_day=rad_to_s_per_day(problem, error, duration_s),
        error_rad=error if math.isfinite(error) else math.inf,
        run_s=outcome.run_s,
        compile_s=outcome.compile_s,
        setup_s=outcome.compile_s,
        us_per_oscillation=1e6 * outcome.run_s * problem.period_s / duration_s,
    )


def machine_facts(versions: Mapping[str, str]) -> dict[str, Any]:
    """Return processor, cores, system, Python, date, and versions with those of the peers."""
    return {
        'processor': _processor(),
        'cpus': os.cpu_count(),
        'system': platform.system(),
        'python': platform.python_version(),
        'date': datetime.now(UTC).date().isoformat(),
        'versions': {
            **versions,
            **{name: version(name) for name in ('numpy', 'numba', 'scipy')},
        },
    }


def _processor() -> str:
    known = Path('/proc/cpuinfo')
    if known.exists():
        for line in known.read_text('utf-8').splitlines():
            name, _, value = line.partition(':')
            if name.strip() == 'model name':
                return value.strip()
    return platform.processor() or platform.machine()
