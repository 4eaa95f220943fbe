"""Collocation in n rotating frames, on a test system: Hénon and Heiles.

    ẍ_p + ω_p² x_p + ∂V/∂x_p = 0,    V = λ (x₁² x_n − x_n³/3)

In one plane the two coordinates are the same, and V = ⅔ λ x³.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import mpmath
import numpy as np
import pytest

from tauto_core.kernels import entry
from tauto_core.motion.gauss_step import (
    LEAST_SETTLED,
    PLANE,
    WHOLE_STEP,
    Step,
    collocate,
    copy_planes,
    finish,
    make_work,
)
from tauto_core.motion.lanes import filled, row_of, store

OMEGA = 1.0, 1.7


class Coupled(NamedTuple):
    """Planes that λ couples."""

    coupling: float

    def disturb(self, mode: Any, omega: Any, work: Any) -> None:
        planes = len(omega)
        last = planes - 1
        first_x, last_x = row_of(work.x), row_of(work.x, last)
        for p in range(planes):
            slope = filled(work.x, 0.0)
            if p == 0:
                slope = slope + (2.0 * self.coupling) * (first_x * last_x)
            if p == last:
                slope = slope + self.coupling * (first_x * first_x - last_x * last_x)
            store(work.d1, p, filled(work.d1, 0.0))
            store(work.d2, p, -(slope / omega[p]))


@entry
def run(system: Any, omega: Any, h: float, steps: int, state: Any, work: Any) -> Any:
    """Advance the state; return the largest last coefficient."""
    worst = 0.0
    for _ in range(steps):
        step = Step(system, None, omega, h, WHOLE_STEP, state, work)
        last = collocate(step, LEAST_SETTLED)
        worst = last if last > worst else worst
        if not last < math.inf:
            break
        finish(step)
        copy_planes(omega, work.end, state)
    return worst


def advance(x, y, h, steps, *, omega=OMEGA, coupling=0.0, stages=8):
    """X and Y after so many steps, and what `run` says."""
    state = np.zeros(len(omega), PLANE)
    state['x'], state['y'] = x, y
    said = run(Coupled(coupling), omega, h, steps, state, make_work(len(omega), (), stages))
    return state['x'].copy(), state['y'].copy(), said


def taylor_step(x, v, omega, coupling, t, order):
    """One step of the Taylor series in mpmath numbers: the undamped equations above."""
    a = [[x[0]], [x[-1]]]
    b = [[v[0]], [v[-1]]]
    squares = omega[0] ** 2, omega[-1] ** 2
    one = len(x) == 1

    def product(p, q, n):
        return mpmath.fsum(p[i] * q[n - i] for i in range(n + 1))

    for n in range(order):
        across = 2 * coupling * product(a[0], a[1], n)
        along = coupling * (product(a[0], a[0], n) - product(a[1], a[1], n))
        forces = (across + along,) * 2 if one else (across, along)
        for p in range(2):
            a[p].append(b[p][n] / (n + 1))
            b[p].append(-(squares[p] * a[p][n] + forces[p]) / (n + 1))
    powers = [t**n for n in range(order + 1)]
    values = [[mpmath.fdot(series, powers) for series in pair] for pair in (a, b)]
    return values[0][: len(x)], values[1][: len(x)]


def taylor(x, y, time, steps, omega, coupling):
    """X and Y after `time` by Taylor's method: 30 digits, terms below 1e-25 left out."""
    with mpmath.workdps(30):
        omega = [mpmath.mpf(each) for each in omega]
        x = [mpmath.mpf(each) for each in x]
        v = [mpmath.mpf(each) * o for each, o in zip(y, omega, strict=True)]
        for _ in range(steps):
            x, v = taylor_step(x, v, omega, mpmath.mpf(coupling), mpmath.mpf(time) / steps, 40)
        return [float(each) for each in x], [float(e / o) for e, o in zip(v, omega, strict=True)]


@pytest.mark.parametrize(
    ('omega', 'x', 'y', 'coupling'),
    [(OMEGA, (0.3, -0.2), (0.1, 0.25), 0.5), ((1.3,), (0.4,), (0.1,), 0.2)],
)
def test_coupled_planes_follow_taylors_series(omega, x, y, coupling):
    """Six periods. Halved steps have the same error: only rounding is left.

    Sixteen stages take steps three and a half times as long.
    """
    exact = np.array(taylor(x, y, 40.0, 160, omega, coupling))
    for steps, stages in ((100, 8), (200, 8), (28, 16), (56, 16)):
        found_x, found_y, last = advance(
            x, y, 40.0 / steps, steps, omega=omega, coupling=coupling, stages=stages
        )
        np.testing.assert_allclose([found_x, found_y], exact, rtol=0, atol=1e-12)
        assert 0.0 < last < 1e-3
    plain = advance(x, y, 0.4, 100, omega=omega)[0]
    assert np.max(np.abs(plain - exact[0])) > 0.01


def energy(x, y, coupling):
    square = np.array(OMEGA) ** 2
    return 0.5 * np.sum(square * (x * x + y * y)) + coupling * (x[0] ** 2 * x[1] - x[1] ** 3 / 3)


@pytest.mark.parametrize(('h', 'stages'), [(0.4, 8), (1.6, 16)])
def test_energy_is_kept_for_ten_thousand_periods(h, stages):
    """157 000 steps or a quarter: √n roundings of 1.1e-16 are 4e-14 of the energy."""
    x, y, coupling = np.array([0.3, -0.2]), np.array([0.1, 0.25]), 0.2
    before = energy(x, y, coupling)
    assert abs(energy(x, y, 0.0) / before - 1.0) > 1e-3
    for _ in range(10):
        steps = round(6283.2 / h)
        x, y, _ = advance(x, y, h, steps, coupling=coupling, stages=stages)
        assert energy(x, y, coupling) == pytest.approx(before, rel=4e-14)


@pytest.mark.parametrize(('h', 'stages'), [(0.7, 8), (0.7, 16), (3.8, 16)])
def test_undisturbed_steps_are_one_rotation(h, stages):
    """The state is rounded once, at the end: to half an ulp of 0.4 in each coordinate.

    3.8 s turn the second plane by 6.46 rad: as much as rotations take.
    """
    x, y, steps = (0.3, -0.2), (0.1, 0.25), 100_000
    found_x, found_y, _ = advance(x, y, h, steps, stages=stages)
    with mpmath.workdps(50):
        for p, omega in enumerate(OMEGA):
            angle = mpmath.mpf(omega) * mpmath.mpf(h) * steps
            c, s = mpmath.cos(angle), mpmath.sin(angle)
            assert abs(found_x[p] - (c * x[p] + s * y[p])) < 6e-17
            assert abs(found_y[p] - (c * y[p] - s * x[p])) < 6e-17


@pytest.mark.parametrize('coupling', [math.nan, math.inf, -math.inf, 1e300])
def test_what_cannot_be_solved_is_said_and_leaves_the_state(coupling):
    state = np.zeros(2, PLANE)
    state['x'], state['y'] = (0.3, -0.2), (0.1, 0.25)
    before = state.copy()
    last = run(Coupled(coupling), OMEGA, 0.4, 1, state, make_work(2, ()))
    assert last == math.inf
    np.testing.assert_array_equal(state, before)


def test_a_state_that_is_no_number_is_said():
    assert advance((math.nan, 0.1), (0.0, 0.0), 0.4, 1)[2] == math.inf
