"""The budget of a rate: its parts against closed forms, its sum, how it is kept."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import invoke

import tauto_core as tauto
from tauto_core.cli.tables import budget_text
from tauto_core.clockwork.trochlea import nominal_period_s
from tauto_core.ensembles import budget
from tauto_core.ensembles.budget import Budget, account, budget_file, kept_budget
from tauto_core.machines import (
    AnyMachine,
    LeverMachine,
    Machine,
    SteadySwing,
    compile_machine,
    steady_swing,
)
from tauto_core.results import budget_rows
from tauto_core.scene import Scene, scene_yaml
from tauto_core.scene.errors import UsageError
from tauto_core.scene.times import DAY_S
from tauto_core.ship.passage import normal_gravity

HEAVE_M, PERIOD_S = 0.5, 10.0


def made(**changes: Any) -> Scene:
    """Return a linear clock with a weight that has no inertia, on a ship that heaves."""
    heave = [{'amplitude': HEAVE_M, 'period': PERIOD_S, 'phase': 0.3}]
    ship = {'kind': 'components', 'heave': heave}
    keys: dict[str, Any] = {'trochlea.power.massless': True, 'ship': ship, **changes}
    return tauto.load('involute_weight_at_sea', **keys)


def rows_of(found: Budget) -> dict[str, float]:
    return {row.cause: row.rate_s_per_day for row in found.rows}


def test_heave_alone_costs_its_mean_square_over_eight_g_squared() -> None:
    found = account(made(), 1)
    square = 0.5 * (HEAVE_M * (math.tau / PERIOD_S) ** 2) ** 2
    expected = -DAY_S * square / (8.0 * 9.80665**2)
    # the static formula, for waves ten times slower than the swing, over whole waves
    assert rows_of(found)['heave'] == pytest.approx(expected, rel=0.02)
    # a single cause does not interact
    assert abs(found.interaction.rate_s_per_day) < 1e-6
    sailed = tauto.sail(made()).result['clock']['rate_s_per_day']
    assert found.whole.rate_s_per_day == pytest.approx(sailed, abs=1e-5)


def test_gravity_acts_by_half_of_its_change() -> None:
    # two hours from 50 degrees north southwards at 40 m/s, hardly a degree of longitude
    voyage = {'departure': [50.0, -10.0], 'arrival': [47.0, -10.0], 'sails_at': 0.0}
    way = {'voyage': {**voyage, 'arrives_at': 7200.0}, 'duration': 7200.0}
    scene = made(gravity='normal', ship={'kind': 'still'}, log={'interval': 10.0}, **way)
    found = account(scene, 1, anyway=True)
    here, there = (float(normal_gravity(math.radians(each))) for each in (50.0, 48.5))
    # along the meridian Eötvös' term is v²/M: 4.3 s/day at 46 m/s
    speed = 3.0 * 111_200.0 / 7200.0
    change = there - here - speed**2 / 6.37e6
    assert rows_of(found)['gravity'] == pytest.approx(0.5 * DAY_S * change / here, rel=0.01)


def test_small_changes_are_worth_half_their_part() -> None:
    scene = made(duration=120.0)
    found = account(scene, 1)
    worth = {each.what: each.rate_s_per_day for each in found.worth}
    trochlea: Any = scene.trochlea
    dial = 1.0 + rows_of(found)['dial'] / DAY_S
    # a linear wheel: the rate goes as the root of radius times mass, at any amplitude
    cheek, mass = 1e-5 / trochlea.cam.base_radius, 1e-4 / trochlea.power.mass
    half = 0.5 * DAY_S * dial
    assert worth['10 µm of lever arm at 1 rad'] == pytest.approx(half * cheek, rel=1e-4)
    assert worth['0.1 g of weight'] == pytest.approx(half * mass, rel=1e-4)
    assert abs(worth['0.1 rad of amplitude']) < 1e-6


def test_a_tenth_of_a_radian_agrees_with_two_releases() -> None:
    heave = {'kind': 'components', 'heave': [{'amplitude': 0.1, 'period': 8.0, 'phase': 0.3}]}
    found = []
    for angle in (0.95, 1.0, 1.05):
        keys = {'duration': 120.0, 'ship': heave, 'trochlea.release_angle': angle}
        scene = tauto.load('clock_cheek_weight', **keys)
        left_out = {'suspension': None, 'drag': None, 'escapement': None}
        found.append(account(scene.model_copy(update=left_out), 1))
    rows = [rows_of(each)['amplitude'] for each in found]
    worth = {each.what: each.rate_s_per_day for each in found[1].worth}['0.1 rad of amplitude']
    assert worth == pytest.approx(rows[2] - rows[0], rel=1e-6)
    assert worth > 1000.0


def test_stretches_agree_with_the_whole_voyage(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(budget, 'STRETCHES', 48)
    whole = account(made(duration=7200.0), 1)
    scene = made(duration=86_400.0 * 30, **{'log.interval': 60.0})
    stretches = account(scene, 1)
    assert (whole.stretches, stretches.stretches) == (1, 48)
    sigma = stretches.whole.sigma_s_per_day
    assert sigma is not None
    apart = stretches.whole.rate_s_per_day - whole.whole.rate_s_per_day
    assert abs(apart) < 4.0 * sigma + 0.05


def test_a_hull_has_all_its_motions_and_what_is_known_roughly() -> None:
    keys = {'ship.sea.components': 16, 'ship.heading': 2.4, 'duration': 600.0}
    shipped = tauto.load('involute_weight_at_sea', **keys, **{'trochlea.power.massless': True})
    found = account(shipped, 1)
    assert {'heave', 'sway', 'surge', 'roll', 'pitch and yaw'} <= rows_of(found).keys()
    assert rows_of(found)['heave'] < 0.0 < rows_of(found)['sway']
    assert sum(rows_of(found).values()) == pytest.approx(found.sum.rate_s_per_day, abs=1e-9)
    together = found.sum.rate_s_per_day + found.interaction.rate_s_per_day
    assert together == pytest.approx(found.whole.rate_s_per_day, abs=1e-9)
    names = [each.key.rpartition('.')[2] for each in found.rough]
    assert names == ['damping_ratio', 'k_yy', 'centre_of_gravity']
    assert found.rough_s_per_day >= max(each.half_range for each in found.rough) > 0.0


def brassy(celsius: tuple[float, float], hours: float, **changes: Any) -> Scene:
    """Return a clock of brass on a still ship, in air that warms within an hour."""
    air = {'kind': 'record', 'source': 'a test', 'longest_gap_hours': 1000.0, 'box_hours': 1e-3}
    air |= {'time': [0.0, hours * 3600.0, 1e6], 'celsius': (*celsius, celsius[1])}
    keys = {'ship': {'kind': 'still'}, 'air': air, 'trochlea.material': 'brass', 'clock': {}}
    return made(**{**keys, **changes})


TEN_K = DAY_S * ((1.0 + 18.9e-6 * 10.0) ** -0.5 - 1.0)
"""Rate of wheel and cam of brass, 10 K warmer: -8.16 s/day (heat.4)."""


def test_heat_is_that_since_the_departure() -> None:
    found = account(brassy((10.0, 20.0), 1e-3), 1)
    # the box follows in some seconds of an hour
    assert rows_of(found)['heat'] == pytest.approx(TEN_K, rel=3e-3)
    assert abs(rows_of(found)['dial']) < 1e-9
    # the second order, (8.2/86400)² of a day, is the interaction of dial and heat alone
    assert abs(found.interaction.rate_s_per_day) < 1e-3
    worth = {each.what: each.rate_s_per_day for each in found.worth}
    assert worth['1 K'] == pytest.approx(0.1 * TEN_K, rel=1e-3)
    # the dial shows the temperature at departure, since its period holds at 20 degrees
    warm, nominal = (brassy((each, each), 1e-3) for each in (30.0, 20.0))
    stated = {'nominal_period': nominal_period_s(nominal, compile_machine(nominal))}
    shown = rows_of(account(tauto.load(warm, clock=stated), 1))
    assert shown['heat'] == 0.0
    assert shown['dial'] == pytest.approx(TEN_K, rel=1e-4)


def test_heat_is_felt_in_stretches(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(budget, 'STRETCHES', 4)
    monkeypatch.setattr(budget, 'FEWEST_STRETCHES', 4)
    scene = brassy((10.0, 30.0), 240.0, duration=864_000.0, **{'log.interval': 60.0})
    found = account(scene, 1)
    assert found.stretches == 4
    # evenly spread over a steady warming: its mean, 10 K
    assert rows_of(found)['heat'] == pytest.approx(TEN_K, rel=1e-2)
    brass = {each.key: each for each in found.rough}['trochlea.material']
    assert brass.half_range == pytest.approx(0.05 * abs(TEN_K), rel=0.5)


def test_a_larger_cheek_agrees_with_a_larger_involute() -> None:
    scene = tauto.load('clock_sully_lever')
    machine, trochlea = compile_machine(scene), scene.trochlea
    assert isinstance(machine, LeverMachine)
    assert trochlea is not None

    def of_radius(more_m: float) -> LeverMachine:
        radius = trochlea.cam.base_radius + more_m
        cam = trochlea.cam.model_copy(update={'base_radius': radius})
        other = trochlea.model_copy(update={'cam': cam})
        made = compile_machine(scene.model_copy(update={'trochlea': other}))
        assert isinstance(made, LeverMachine)
        return made

    def arm_m(each: LeverMachine) -> float:
        """Return t = r u at θ = 1, u = θ − δ with the lean δ of the free thread (threads.md)."""
        tau = each.geometry.tau_of(np.ones(1))
        return each.geometry.base_radius * (1.0 - float(each.geometry.pose(tau).delta[0]))

    def period_s(each: AnyMachine) -> float:
        found = steady_swing(each)
        assert isinstance(found, SteadySwing)
        return found.period

    small, large = of_radius(-1e-5), of_radius(1e-5)
    a_metre = (period_s(large) - period_s(small)) / (arm_m(large) - arm_m(small))
    changed = [period_s(budget._larger_cheek(machine, more)) for more in (-1e-5, 1e-5)]
    assert (changed[1] - changed[0]) / 2e-5 == pytest.approx(a_metre, rel=0.01)


def test_the_oil_of_a_stretch_has_its_age() -> None:
    drag = {'viscous': 1e-5, 'thickens_per_month': 0.1}
    young = compile_machine(made(drag=drag))
    assert isinstance(young, Machine)
    month_s = 365.25 / 12.0 * DAY_S
    aged = budget._aged(young, month_s)
    assert isinstance(aged, Machine)
    assert aged.drag is not None
    assert aged.drag.viscous == pytest.approx(1.1e-5, rel=1e-12)


def test_what_is_left_open_is_compared_in_the_same_stretches(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tried: dict[str, budget.Job] = {}

    def sailed(jobs: dict[str, budget.Job], *_: object) -> dict[str, Any]:
        tried.update(jobs)
        # a rate that drifts by far more than the number matters
        return {
            name: np.array(job.begins_ns) * 1e-18 + (1e-6 if ' = ' in name else 0.0) + 1.0
            for name, job in jobs.items()
        }

    monkeypatch.setattr(budget, '_sailed', sailed)
    scene = tauto.load('involute_weight_at_sea', duration=86_400.0 * 30, **{'log.interval': 60.0})
    found = account(scene, 1, anyway=True)
    nominal_s = scene.clock.nominal_period or 0.0
    assert 'ship.roll.damping_ratio' in [each.key for each in found.rough]
    for row in found.rough:
        assert row.least_s_per_day == pytest.approx(DAY_S * nominal_s * 1e-6, rel=1e-6)
    thinned = [job.begins_ns for name, job in tried.items() if ' = ' in name]
    assert thinned == [tried[''].begins_ns[::3]] * 2 * len(found.rough)


def test_a_hung_case_is_told_beside_the_same_case_fixed() -> None:
    scene = tauto.load('suspended_weight_at_sea', duration=300.0)
    found = account(scene, 1)
    fixed = tauto.sail(scene.model_copy(update={'suspension': None})).result['clock']
    assert found.fixed_s_per_day == pytest.approx(fixed['rate_s_per_day'], abs=1e-3)


def test_clocks_without_a_rate_are_refused() -> None:
    with pytest.raises(UsageError, match='dies away'):
        account(made(drag={'viscous': 1e-5}), 1)
    with pytest.raises(UsageError, match='body in a fluid'):
        tauto.budget('globe_in_oil')


def test_a_row_is_printed_as_far_as_it_is_known() -> None:
    """Terminal and page take these texts. A cause of no effect has no side."""

    def row(rate: float, sigma: float, east: float, found: str = 'sea') -> dict[str, Any]:
        names = ('rate_s_per_day', 'sigma_s_per_day', 'east_nmi', 'found', 'cause')
        return dict(zip(names, (rate, sigma, east, found, 'heave'), strict=True))

    rows = [row(0.0, 0.0, 0.0, 'land'), row(2e-4, 3e-4, -0.003), row(-11.982, 0.291, 216.6)]
    of = {'rows': rows, 'sum': row(-12.0, 0.0, 217.0), 'interaction': row(0.0, 0.0, 0.0)}
    said = [each[1:] for each in budget_rows({**of, 'whole': row(-12.0, 0.5, 217.0)})]
    assert said[:3] == [
        ('0', '0', 'on land'),
        ('<0.001', '<0.01 west', 'at sea'),
        ('−11.98 ± 0.29', '217 east', 'at sea'),
    ]
    assert [each[0] for each in said[3:]] == ['−12.0', '0', '−12.00 ± 0.50']


def test_it_is_kept_with_the_voyage_and_the_report_shows_it(tmp_path: Path) -> None:
    scene, bag = made(duration=60.0), tmp_path / 'bag'
    tauto.sail(scene).write(bag)
    (file := tmp_path / 'scene.yaml').write_text(scene_yaml(scene), 'utf-8')
    typed = ['budget', str(file), '--jobs', '1', '--out', str(bag), '--json']
    run = invoke(*typed)
    assert run.exit_code == 0
    assert run.stderr.strip().endswith('budget.json')
    assert kept_budget(bag) == json.loads(run.stdout)
    assert budget_text(json.loads(run.stdout))
    page = tmp_path / 'page.html'
    tauto.report(bag, page)
    assert 'The causes of the rate' in page.read_text(encoding='utf-8')
    # the budget goes with the voyage that it is of
    tauto.sail(scene).write(bag, force=True)
    assert kept_budget(bag) is None
    (bag / 'budget.json').write_text('{}', encoding='utf-8')
    with pytest.raises(UsageError, match='not a budget of this version'):
        kept_budget(bag)


def test_it_is_kept_nowhere_else(tmp_path: Path) -> None:
    scene, bag = made(duration=60.0), tmp_path / 'bag'
    tauto.sail(scene).write(bag)
    with pytest.raises(UsageError, match='another scene'):
        budget_file(bag, made(duration=120.0))
    with pytest.raises(UsageError, match='must be the folder of a voyage'):
        budget_file(tmp_path / 'budget.json', scene)
