"""The runner on Tauto and on the peers that need no extra."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace
from typing import Any

import pytest

from benchmarks.work_precision.first_run import first_runs
from benchmarks.work_precision.passage import passage, two_at_once
from benchmarks.work_precision.peer import PEERS, MissingPeerError, Outcome, make_peers
from benchmarks.work_precision.problems import QUALITY, Problem, problems
from benchmarks.work_precision.ratios import FAMILIES, best_ratio, ratio
from benchmarks.work_precision.references.stored import reference
from benchmarks.work_precision.runner import Row, bench, measure
from tauto_core.scene.errors import PropagationError

PROBLEMS = {problem.key: problem for problem in problems()}


class Known:
    """A peer that knows the references and has an error of a given rate."""

    name = 'known'

    def __init__(self, rad_per_s: float = 0.0, cost: float = 1e-9) -> None:
        self.rad_per_s, self.cost = rad_per_s, cost
        self.runs: list[float] = []

    def version(self) -> str:
        return '1'

    def settings(self, problem: Problem) -> tuple[str, ...]:
        return () if problem.key == 'd' else ('only',)

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        assert setting == 'only'
        self.runs.append(duration_s)
        true, omega = reference(problem, duration_s), problem.numbers.frequency
        turned = complex(true.angle, -true.rate / omega)
        turned *= cmath.exp(1j * self.rad_per_s * duration_s)
        return Outcome(duration_s, turned.real, -omega * turned.imag, self.cost * duration_s, 0.25)


def bench_with(peer: object, key: str, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    monkeypatch.setitem(PEERS, 'known', lambda: peer)
    return bench([key], ['known'])


def test_the_longest_reference_within_the_budget_is_run(monkeypatch: pytest.MonkeyPatch) -> None:
    # 20 s of budget at 1 ms a second of sea end between 3600 s and 21600 s
    result = bench_with(Known(cost=1e-3), 'b', monkeypatch)
    (row,) = result['rows']
    assert row['duration_s'] == 3600.0
    assert row['run_s'] == pytest.approx(3.6)
    assert row['compile_s'] == 0.25
    assert row['us_per_oscillation'] == pytest.approx(1e3 * PROBLEMS['b'].period_s)
    assert row['error_rad'] < 1e-13
    assert {'processor', 'cpus', 'python', 'date', 'versions'} <= set(result['machine'])
    assert result['machine']['versions']['known'] == '1'


def test_a_phase_that_could_turn_unseen_ends_the_climb(monkeypatch: pytest.MonkeyPatch) -> None:
    # 1e-6 rad/s is 0.0864 rad after a day; in ten days it may be a hundred times as much
    peer = Known(rad_per_s=1e-6)
    (row,) = bench_with(peer, 'b', monkeypatch)['rows']
    assert max(peer.runs) == row['duration_s'] == 86_400.0
    assert row['error_rad'] == pytest.approx(0.0864, rel=1e-9)
    per_day = 1e-6 * 86_400.0 / PROBLEMS['b'].numbers.frequency
    assert row['error_s_per_day'] == pytest.approx(per_day, rel=1e-9)


def test_what_is_lost_at_once_is_no_measurement(monkeypatch: pytest.MonkeyPatch) -> None:
    result = bench_with(Known(rad_per_s=0.02), 'b', monkeypatch)
    assert result['rows'] == []
    assert 'off by 1.2 rad after 60 s' in result['failed'][0]['why']


def test_a_run_that_fails_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    class Failing(Known):
        def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
            if duration_s > 60.0:
                raise PropagationError('gave up', 61.5)
            return super().solve(problem, setting, duration_s)

    result = bench_with(Failing(), 'b', monkeypatch)
    assert [row['duration_s'] for row in result['rows']] == [60.0]
    assert 'run of 600 s: at t = 61.5' in result['failed'][0]['why']


def test_what_a_peer_cannot_express_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    result = bench_with(Known(), 'd', monkeypatch)
    assert result['rows'] == []
    assert result['not_offered'] == {'known': ['d']}


def test_a_missing_peer_is_named_and_skipped(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> Known:
        raise MissingPeerError('heyoka')

    said: list[str] = []
    monkeypatch.setitem(PEERS, 'heyoka', missing)
    monkeypatch.setitem(PEERS, 'known', Known)
    result = bench(['a'], ['heyoka', 'known'], say=said.append)
    assert {row['program'] for row in result['rows']} == {'known'}
    assert len(result['missing']) == 1
    remedy = 'Install it with pip install -r benchmarks/requirements.txt'
    assert f'heyoka is not installed. {remedy}' in said[0]


@pytest.mark.parametrize('key', ['a', 'b'])
def test_tauto_on_land_is_where_the_reference_is_after_81_days(key: str) -> None:
    (tauto,), _ = make_peers(['tauto'])
    row = measure(PROBLEMS[key], tauto, 'closed form', 81.0 * 86_400.0)
    # 1e-9 rad, and half an ulp of a phase of 4.4e7 rad
    assert row.error_rad < 1e-9 + 2.0**-53 * 4.4e7


@pytest.mark.parametrize(
    ('key', 'setting', 'bound_s'),
    [('c', '20 Hz 1e-12', 1e-8), ('d', '20 Hz', 1e-9), ('e', '20 Hz 1e-12', 1e-8)],
)
def test_tauto_at_sea_is_where_the_reference_is(key: str, setting: str, bound_s: float) -> None:
    # sampling at 20 Hz: 1e-9 s of reading for roll, 1e-8 s with the apparent vertical (design 3)
    problem = PROBLEMS[key]
    (tauto,), _ = make_peers(['tauto'])
    row = measure(problem, tauto, setting, 600.0)
    assert row.error_rad / problem.numbers.frequency < bound_s


def test_impulses_of_e_make_good_for_its_drag() -> None:
    numbers = PROBLEMS['e'].numbers
    omega = numbers.frequency
    assert numbers.inertia * omega / numbers.viscous == pytest.approx(QUALITY)
    # half a swing of 1 rad: the integral of c omega^2 sin^2 over pi/omega
    lost = 0.5 * math.pi * numbers.viscous * omega
    assert numbers.impulse_energy == pytest.approx(lost, rel=1e-12)
    true = reference(PROBLEMS['e'], 3600.0)
    assert math.hypot(true.angle, true.rate / omega) == pytest.approx(1.0, abs=0.05)


def a_row(**changes: Any) -> dict[str, Any]:
    return vars(replace(Row('c', 'tauto', '', 60.0, 1e-10, 0.0, 1.0, 0.0, 0.0, 2.0), **changes))


def test_ratios_count_only_what_is_accurate_enough() -> None:
    rows = [a_row()]
    for error, cost in ((1e-6, 3.0), (9e-10, 60.0), (1e-12, 90.0)):
        rows += [a_row(program='heyoka', error_s_per_day=error, us_per_oscillation=cost)]
    assert ratio(rows[0], rows, ['heyoka'], 1e-9) == 30.0
    assert ratio(rows[0], rows, ['heyoka'], 1e-11) == 45.0
    assert ratio(rows[0], rows, ['dop853_compiled'], 1e-9) is None
    assert best_ratio(rows, 'c', ['heyoka']) == 30.0
    tuned = a_row(program='heyoka_tuned', us_per_oscillation=8.0)
    assert best_ratio([*rows, tuned], 'c', FAMILIES['heyoka']) == 4.0


def test_a_whole_run_is_its_set_up_and_its_swings() -> None:
    ours = a_row(problem='a', error_s_per_day=0.0, setup_s=1e-3, us_per_oscillation=0.0)
    theirs = {**ours, 'program': 'heyoka', 'setup_s': 0.0, 'us_per_oscillation': 1.0}
    # 81 days of a swing a second take 7 s at 1 us a swing
    found = best_ratio([ours, theirs], 'a', ['heyoka'], setup=True)
    assert found == pytest.approx(6.998400 / PROBLEMS['a'].period_s / 1e-3)


def test_set_up_is_the_least_and_compiling_the_most(monkeypatch: pytest.MonkeyPatch) -> None:
    class Compiling(Known):
        def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
            found = super().solve(problem, setting, duration_s)
            seconds = {1: 3.0, 2: 0.5}.get(len(self.runs), 0.7)
            return replace(found, compile_s=seconds)

    (row,) = bench_with(Compiling(), 'b', monkeypatch)['rows']
    assert (row['compile_s'], row['setup_s']) == (3.0, 0.5)


def test_passage_and_two_at_once_say_what_they_measured() -> None:
    result = passage(600.0)
    per_swing = 1e6 * result['run_s'] * PROBLEMS['c'].period_s / 600.0
    assert result['us_per_oscillation'] == pytest.approx(per_swing)
    both = two_at_once(60.0)
    assert both['ratio'] == both['two_s'] / both['one_s'] > 0.0
    assert both['processes_ratio'] > 0.0


def test_first_runs_take_the_setting_that_is_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str, ...]] = []

    def known(*arguments: str) -> float:
        asked.append(arguments)
        return 1.5

    monkeypatch.setattr(f'{first_runs.__module__}.first_run', known)
    rows = [a_row(setting='fast'), a_row(setting='slow', us_per_oscillation=9.0)]
    rows += [
        a_row(program='heyoka', setting=x, error_s_per_day=e) for x, e in (('a', 1), ('b', 0.1))
    ]
    found = first_runs(rows, lambda _: None)
    assert asked == [('c', 'tauto', 'fast'), ('c', 'heyoka', 'b')]
    assert [each['first_run_s'] for each in found] == [1.5, 1.5]
