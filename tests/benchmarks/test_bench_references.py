"""References against independent closed forms and against each other."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from mpmath import mp

from benchmarks.work_precision.equations.sea import start
from benchmarks.work_precision.problems import problems
from benchmarks.work_precision.references import exact
from benchmarks.work_precision.references.integrated import gauss_rule, gauss_states
from benchmarks.work_precision.references.stored import (
    FILE,
    NoReferenceError,
    Reference,
    error_rad,
    rad_to_s_per_day,
    reference,
    references,
)
from tauto_core.ship import ShipMotion
from tauto_core.ship.imu import attitude

PROBLEMS = {problem.key: problem for problem in problems()}


def test_ideal_cam_on_land_is_a_cosine() -> None:
    numbers = PROBLEMS['a'].numbers
    with mp.workdps(50):
        omega = mp.sqrt(mp.mpf(numbers.force) * mp.mpf(numbers.lever_rate))
        omega /= mp.sqrt(mp.mpf(numbers.inertia))
        for time, true in references('a').items():
            assert true.angle == float(mp.cos(omega * time))
            assert true.rate == float(-omega * mp.sin(omega * time))


def test_weight_on_land_keeps_its_energy() -> None:
    numbers = PROBLEMS['b'].numbers
    pull = numbers.mass * numbers.gravity * numbers.lever_rate
    for true in references('b').values():
        mass = numbers.inertia + numbers.mass * (numbers.lever_rate * true.angle) ** 2
        energy = 0.5 * mass * true.rate**2 + 0.5 * pull * true.angle**2
        assert energy == pytest.approx(0.5 * pull, rel=1e-14)


@pytest.mark.parametrize('key', ['b', 'c', 'e'])
def test_gauss_arrives_where_the_reference_is(key: str) -> None:
    # double precision with 8.37 and 10.1 steps a second: both leave some 1e-13 rad
    problem = PROBLEMS[key]
    for steps in (8.37, 10.1):
        ((angle, rate),) = gauss_states(problem, [600.0], steps)
        assert abs(error_rad(problem, angle, rate, reference(problem, 600.0))) < 3e-12


def test_both_ways_agree_a_tenth_below_the_errors_to_be_measured() -> None:
    bounds_s_per_day = {'c': 1e-9, 'e': 1e-7, 'f': 1e-7}
    stored = json.loads(FILE.read_text('utf-8'))['problems']
    for key, bound in bounds_s_per_day.items():
        for row in stored[key]['states']:
            off = rad_to_s_per_day(PROBLEMS[key], row['agree_rad'], row['time_s'])
            assert off < 0.1 * bound


@pytest.mark.parametrize('stages', [2, 8])
def test_gauss_rule_integrates_polynomials_and_is_symplectic(stages: int) -> None:
    nodes, ratio, weights = gauss_rule(stages)
    for power in range(2 * stages):
        assert weights @ nodes**power == pytest.approx(1.0 / (power + 1), abs=2e-15)
    for power in range(stages):
        whole = nodes ** (power + 1) / (power + 1)
        np.testing.assert_allclose((ratio * weights) @ nodes**power, whole, atol=2e-15)
    np.testing.assert_array_equal(ratio + ratio.T, np.ones((stages, stages)))


@pytest.mark.parametrize('time', [0.0, 43_200.0, 864_000.0])
def test_the_exact_sea_is_the_one_that_tauto_samples(time: float) -> None:
    # the ship's phases are good to 1e-13 rad and its forces are felt in the ship's axes
    problem = PROBLEMS['c']
    ship = ShipMotion(problem.scene)
    ship.restore({'next': round(time * problem.scene.ship.rate)})
    sampled = attitude(ship.produce(1))
    felt = exact.felt(problem.numbers, time)
    lean = math.atan2(-sampled.force_y[0], sampled.force_z[0])
    assert sampled.roll[0] == pytest.approx(float(felt.roll), abs=1e-14)
    assert lean == pytest.approx(float(felt.vertical - felt.roll), abs=1e-13)


def test_release_is_that_of_the_peers() -> None:
    numbers = PROBLEMS['e'].numbers
    x, p = exact.release(numbers)
    peers_x, peers_u = start(numbers)
    assert float(x) == pytest.approx(float(peers_x), abs=1e-15)
    assert float(p) / numbers.inertia == pytest.approx(float(peers_u), abs=1e-15)


def test_error_is_the_angle_between_states_and_ahead_is_positive() -> None:
    problem = PROBLEMS['a']
    omega = problem.numbers.frequency
    true = Reference(60.0, math.cos(0.3), -omega * math.sin(0.3))
    late = error_rad(problem, math.cos(0.29), -omega * math.sin(0.29), true)
    assert late == pytest.approx(-0.01, rel=1e-12)
    # a hundredth of a radian in a day is a hundredth of omega's inverse in s/day
    assert rad_to_s_per_day(problem, 0.01, 86_400.0) == pytest.approx(0.01 / omega, rel=1e-12)


def test_a_duration_without_reference_is_refused() -> None:
    with pytest.raises(NoReferenceError, match=r'problem c: no reference at 61.0 s.*600'):
        reference(PROBLEMS['c'], 61.0)
