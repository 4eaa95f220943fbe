"""Problem f, the case on its axle at large angles: its equations, references, peers and table."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.work_precision import figure
from benchmarks.work_precision.equations.case_kernels import fill_slope
from benchmarks.work_precision.peer import make_peers
from benchmarks.work_precision.problems import CaseProblem, HungCase, problems
from benchmarks.work_precision.references.integrated import gauss_case, long_double_case
from benchmarks.work_precision.references.stored import CASE_STEPS_A_SECOND, error_rad, reference
from benchmarks.work_precision.runner import Row, measure
from tauto_core.machines.axle_pendulum import AxlePendulum, AxleState, small_motion
from tauto_core.motion.axle import forces

(PROBLEM,) = (problem for problem in problems() if isinstance(problem, CaseProblem))
CASE = PROBLEM.numbers
NUMBERS = CASE.e, CASE.c, CASE.k, CASE.gravity
SEED = 1780
# setting of a peer and what it stays within after a minute, in rad
AFTER_A_MINUTE = {'tauto': ('50 Hz 2e-12', 3e-12), 'dop853_compiled': ('1e-12', 1e-8)}


def body(case: HungCase) -> AxlePendulum:
    return AxlePendulum(1.0 / case.e, case.c, case.k, case.gravity)


def axle_state(state: np.ndarray) -> AxleState:
    return AxleState(CASE.e * state[0], state[1], CASE.e * state[2], state[3])


def random_states(n: int) -> np.ndarray:
    # angles up to a radian, rates as the fast mode has them
    return np.random.default_rng(SEED).uniform(-1, 1, (n, 4)) * [1.0, 1.0, 30.0, 8.0]


def test_an_oscillation_is_a_small_swing_of_the_slow_mode() -> None:
    slow = math.sqrt(CASE.gravity / body(CASE).modes.h)
    assert math.tau / PROBLEM.period_s == pytest.approx(slow, rel=1e-14)


def test_peers_equations_are_those_of_the_axle_pendulum() -> None:
    for state in random_states(20):
        found, now = np.empty(4), forces(body(CASE), axle_state(state))
        fill_slope(state, NUMBERS, found)
        np.testing.assert_array_equal(found[:2], state[2:])
        assert found[2] == pytest.approx(float(now.arc_acceleration) / CASE.e, rel=1e-11)
        assert found[3] == pytest.approx(float(now.tilt_acceleration), rel=1e-11)


def test_small_angles_swing_in_both_modes() -> None:
    # the swing is slower by its square over 16: 1e-6 of 1e-5^2 in a phase of 500 rad
    small = replace(CASE, release_angle=1e-5)
    (state,) = gauss_case(small, [60.0], CASE_STEPS_A_SECOND)
    start = AxleState(CASE.e * 1e-5, 1e-5, 0.0, 0.0)
    true = small_motion(body(CASE), start, 60.0)
    assert state[1] == pytest.approx(float(true.tilt), abs=1e-5 * 1e-7)
    assert state[0] == pytest.approx(float(true.arc) / CASE.e, abs=1e-5 * 1e-7)


def test_both_ways_end_where_the_stored_state_is() -> None:
    pytest.importorskip('heyoka')
    times = [60.0, 600.0]
    first = long_double_case(CASE, times)
    second = gauss_case(CASE, times, CASE_STEPS_A_SECOND)
    for time, digits, state in zip(times, first, second, strict=True):
        true = reference(PROBLEM, time)
        # the last digits of a long double differ from one processor to another
        found = float(digits[1]), float(digits[3])
        assert found == pytest.approx((true.angle, true.rate), abs=1e-13)
        assert abs(error_rad(PROBLEM, state[1], state[3], true)) < 3e-12


@pytest.mark.parametrize('name', AFTER_A_MINUTE)
def test_peers_end_where_the_reference_is(name: str) -> None:
    (peer,), _ = make_peers([name])
    setting, bound = AFTER_A_MINUTE[name]
    assert setting in peer.settings(PROBLEM)
    assert measure(PROBLEM, peer, setting, 60.0).error_rad < bound


def test_tauto_halves_steps_that_are_too_long_for_its_tolerance() -> None:
    (tauto,), _ = make_peers(['tauto'])
    coarse, fine = (measure(PROBLEM, tauto, f'{rate} Hz 2e-12', 600.0) for rate in (20, 160))
    # each step errs by 2e-12 at most: ten minutes have 1e5
    assert max(coarse.error_rad, fine.error_rad) < 1e-9


def test_a_figure_of_all_problems_is_drawn(tmp_path: Path) -> None:
    machine = {'processor': 'none', 'python': '3', 'date': '2026-01-01'}
    row = vars(Row('f', 'tauto', '40 Hz 2e-12', 60.0, 1e-10, 0.0, 1.0, 0.0, 0.0, 2.0))
    rows = [row, {**row, 'program': 'heyoka', 'us_per_oscillation': 6.0}]
    every = [{**each, 'problem': problem.key} for problem in problems() for each in rows]
    figure.draw({'machine': machine, 'rows': every}, tmp_path / 'all.svg')
    assert f'(f) {PROBLEM.title}' in (tmp_path / 'all.svg').read_text('utf-8')
