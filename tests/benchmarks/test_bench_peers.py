"""The peers against closed forms and SciPy (ship.md, machine_at_sea.md)."""

from __future__ import annotations

import math
import sys
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from benchmarks.work_precision.peer import MissingPeerError
from benchmarks.work_precision.peers import heyoka as heyoka_peers
from benchmarks.work_precision.peers.dop853 import CompiledDop853
from benchmarks.work_precision.peers.heyoka import Heyoka, HeyokaBatch, HeyokaTuned
from benchmarks.work_precision.problems import Numbers, Problem, problems
from benchmarks.work_precision.references.exact import exact_state
from benchmarks.work_precision.runner import measure
from tauto_core.scene.errors import UsageError

DURATION_S = 6.3
SETTING, BOUND = '1e-15', 1e-12
"""What plain heyoka reaches in six swings [rad]."""


@cache
def peer(kind):
    pytest.importorskip('heyoka')
    return kind()


def problem(key: str) -> Problem:
    return next(each for each in problems() if each.key == key)


def roll(numbers: Numbers, time):
    sea = numbers.sea
    if sea is None:
        return np.zeros(3)
    angle = sea.omega * time + sea.phase
    return np.array([
        np.sum(sea.amplitude * np.cos(angle)),
        -np.sum(sea.amplitude * sea.omega * np.sin(angle)),
        -np.sum(sea.amplitude * sea.omega**2 * np.cos(angle)),
    ])  # fmt: skip


def linear_wheel(numbers: Numbers, time: float) -> tuple[float, float]:
    """theta, theta' of I psi'' + P b (psi - roll) = 0: free swing, a response a component."""
    w2 = numbers.force * numbers.lever_rate / numbers.inertia
    w = math.sqrt(w2)
    sea = numbers.sea
    gain = w2 / (w2 - sea.omega**2) if sea else np.zeros(0)

    def forced(t: float) -> np.ndarray:
        if sea is None:
            return np.zeros(2)
        angle, a = sea.omega * t + sea.phase, sea.amplitude * gain
        return np.array([np.sum(a * np.cos(angle)), -np.sum(a * sea.omega * np.sin(angle))])

    x, v = np.array([numbers.release_angle, 0.0]) + roll(numbers, 0.0)[:2] - forced(0.0)
    cosine, sine = math.cos(w * time), math.sin(w * time)
    free = np.array([x * cosine + v / w * sine, -x * w * sine + v * cosine])
    angle, rate = free + forced(time) - roll(numbers, time)[:2]
    return float(angle), float(rate)


def vertical(numbers: Numbers, time: float) -> tuple[float, float]:
    """beta and g_eff from the acceleration of the clock in the earth's axes."""
    r, r1, r2 = roll(numbers, time)
    across = -numbers.sea.height * (r2 * math.cos(r) - r1**2 * math.sin(r))
    up = numbers.gravity - numbers.sea.height * (r2 * math.sin(r) + r1**2 * math.cos(r))
    return math.atan2(-across, up), math.hypot(across, up)


def vertical_rate(numbers: Numbers, time: float) -> float:
    """beta' by central differences of sixth order, good to 1e-12 with this step."""
    h, weights = 0.02, {1: 0.75, 2: -0.15, 3: 1.0 / 60.0}
    return sum(
        c * (vertical(numbers, time + k * h)[0] - vertical(numbers, time - k * h)[0]) / h
        for k, c in weights.items()
    )


def by_scipy(numbers: Numbers, end: float) -> tuple[float, float]:
    """theta, theta' from the canonical momentum p = I psi' + m b^2 x^2 x' by DOP853."""
    inertia, carried = numbers.inertia, numbers.mass * numbers.lever_rate**2

    def speed(t: float, y: np.ndarray) -> float:
        beta_rate = vertical_rate(numbers, t)
        return (y[1] - inertia * beta_rate) / (inertia + carried * y[0] ** 2) + beta_rate

    def slope(t: float, y: np.ndarray) -> list[float]:
        x_rate = speed(t, y) - vertical_rate(numbers, t)
        pull = numbers.mass * vertical(numbers, t)[1] * numbers.lever_rate
        drag = numbers.viscous * (speed(t, y) - roll(numbers, t)[1])
        return [x_rate, carried * y[0] * x_rate**2 - pull * y[0] - drag]

    def theta(t: float, y: np.ndarray) -> float:
        return y[0] + vertical(numbers, t)[0] - roll(numbers, t)[0]

    theta.terminal = bool(numbers.impulse_energy)
    beta_rate, now = vertical_rate(numbers, 0.0), 0.0
    x = numbers.release_angle + roll(numbers, 0.0)[0] - vertical(numbers, 0.0)[0]
    psi_rate = roll(numbers, 0.0)[1]
    y = np.array([x, inertia * psi_rate + carried * x**2 * (psi_rate - beta_rate)])
    sense = -1
    while True:
        theta.direction = sense
        run = solve_ivp(
            slope, (now, end), y, method='DOP853', rtol=1e-11, atol=1e-13, events=theta
        )
        now, y = run.t[-1], run.y[:, -1]
        v = speed(now, y) - roll(numbers, now)[1]
        if now >= end:
            return float(theta(now, y)), float(v)
        mass = inertia + carried * y[0] ** 2
        y[1] += mass * (math.copysign(math.sqrt(v**2 + 2 * numbers.impulse_energy / mass), v) - v)
        sense = -sense


@cache
def scipy_wheel(key: str) -> tuple[float, float]:
    return by_scipy(problem(key).numbers, DURATION_S)


@pytest.mark.parametrize('key', ['a', 'd'])
def test_linear_problems_end_where_the_closed_form_does(key):
    outcome = peer(Heyoka).solve(problem(key), SETTING, DURATION_S)
    angle, rate = linear_wheel(problem(key).numbers, DURATION_S)
    assert outcome.time_s == DURATION_S
    assert outcome.angle == pytest.approx(angle, abs=BOUND)
    assert outcome.rate == pytest.approx(rate, abs=2 * math.pi * BOUND)


@pytest.mark.parametrize('key', ['c', 'e'])
def test_weight_at_sea_ends_where_scipy_does(key):
    outcome = peer(Heyoka).solve(problem(key), SETTING, DURATION_S)
    angle, rate = scipy_wheel(key)
    # SciPy at 1e-11 with differences for beta' is good to some 1e-9.
    bound = 5e-9 + (BOUND if key == 'c' else 1e-11)
    assert outcome.angle == pytest.approx(angle, abs=bound)
    assert outcome.rate == pytest.approx(rate, abs=2 * math.pi * bound)


def test_weight_on_land_ends_where_the_closed_form_does():
    outcome = peer(Heyoka).solve(problem('b'), SETTING, DURATION_S)
    angle, _ = exact_state(problem('b'), DURATION_S)
    assert outcome.angle == pytest.approx(float(angle), abs=BOUND)


@pytest.mark.parametrize('kind', [Heyoka, HeyokaTuned, HeyokaBatch])
def test_missing_library_is_named_with_what_installs_it(kind, monkeypatch):
    monkeypatch.setitem(sys.modules, 'heyoka', None)
    with pytest.raises(
        MissingPeerError, match=r'heyoka is not installed.*benchmarks/requirements'
    ):
        kind()


@pytest.mark.parametrize(
    ('key', 'setting', 'bound'),
    [
        # bounds in rad after ten minutes: some three times what is left at these settings
        ('b', '1e-14', 2e-12),
        ('c', '1e-15 1 s 14 points', 2e-12),
        ('d', '1e-24 2 s 14 points', 3e-13),
        ('e', '1e-15 1 s 14 points', 2e-12),
        ('f', '1e-16', 3e-11),
    ],
)
def test_heyokas_best_formulations_end_at_the_reference(key, setting, bound):
    assert setting in peer(HeyokaTuned).settings(problem(key))
    assert measure(problem(key), peer(HeyokaTuned), setting, 600.0).error_rad < bound


def test_more_points_a_piece_bring_it_nearer():
    coarse, fine = (
        measure(problem('c'), peer(HeyokaTuned), f'1e-15 1 s {n} points', 600.0).error_rad
        for n in (8, 10)
    )
    # two Chebyshev terms more of waves of at most 2.75 rad/s over half a second
    assert fine < 0.05 * coarse


def test_a_run_of_heyoka_may_end_inside_a_piece():
    found = peer(HeyokaTuned).solve(problem('d'), '1e-24 2 s 14 points', DURATION_S)
    assert found.angle == pytest.approx(
        linear_wheel(problem('d').numbers, DURATION_S)[0], abs=1e-12
    )


def test_the_best_formulation_of_problem_a_is_the_plain_one():
    with pytest.raises(UsageError, match="problem 'a' has no better formulation"):
        peer(HeyokaTuned).solve(problem('a'), '1e-18', 60.0)


@pytest.mark.parametrize(
    'key', ['a', 'b', 'c waves', 'c pieces', 'd waves', 'd pieces', 'e pieces']
)
def test_compiled_dop853_ends_where_the_reference_does(key):
    # 1e-12 a step, some 60 steps a swing, over a minute
    key, *way = key.split()
    setting = ' '.join(['1e-12', *way])
    assert setting in CompiledDop853().settings(problem(key))
    assert measure(problem(key), CompiledDop853(), setting, 60.0).error_rad < 1e-9 * 6.3


@pytest.mark.parametrize('way', ['waves', 'pieces'])
def test_compiled_dop853_has_its_order(way):
    """With steps h the error of a step is proportional to h^8, and their number to 1/h."""
    coarse, fine = (
        measure(problem('e'), CompiledDop853(), f'{tolerance} {way}', 600.0).error_rad
        for tolerance in ('1e-8', '1e-11')
    )
    # the tolerance holds for h^8: the error over a run goes like its power 7/8
    assert math.log10(coarse / fine) == pytest.approx(3.0 * 7.0 / 8.0, abs=0.4)


@pytest.mark.parametrize(
    ('key', 'setting'), [('c', '3e-13 0.5 s 8 points'), ('e', '1e-9 1 s 10 points')]
)
def test_each_ship_of_a_batch_sails_as_it_would_alone(key, setting):
    """Two compilations of the same steps; their lengths differ as the others' do not matter."""
    pytest.importorskip('heyoka')
    tolerance, length_s, points = heyoka_peers.piece_of(setting)
    numbers = problem(key).numbers
    fleet = heyoka_peers._Fleet(numbers, tolerance, length_s, points)
    fleet.advance(0.0, 100.3)
    for lane, own in enumerate(heyoka_peers.eight_seas(numbers)):
        alone = heyoka_peers._Pieces(own, own.sea, tolerance, length_s, points)
        alone.advance(0.0, 100.3)
        assert fleet.state[:2, lane] == pytest.approx(alone._state[:2], abs=1e-9)
    assert len({*fleet.state[0]}) == heyoka_peers.SHIPS


@pytest.mark.parametrize(
    ('key', 'setting', 'bound'),
    [('c', '3e-13 0.5 s 8 points', 1e-9), ('e', '1e-8 0.5 s 6 points', 1e-7)],
)
def test_the_first_ship_of_a_batch_meets_the_reference(key, setting, bound):
    row = measure(problem(key), peer(HeyokaBatch), setting, 60.0)
    assert row.error_s_per_day < 10.0 * bound
