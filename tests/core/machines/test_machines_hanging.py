"""The swinging thread: its modes, its equations, its periodic swings."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from thread_references import hanging_energy

from tauto_core.machines import HangingMachine
from tauto_core.machines.threads.hanging import SwingError
from tauto_core.scene.errors import CamRangeError

MACHINE = HangingMachine(4e-4, 0.05, 0.02, 0.3, 9.81, None, None, 1.0)


def test_small_swings_are_the_modes():
    """E⁻¹ of the linear equations: frequencies to second order in the amplitude, 1e-8 here."""
    size = 1e-4
    for share, length in (
        (MACHINE.modes.B, MACHINE.modes.h),
        (MACHINE.modes.B_prime, MACHINE.modes.h_prime),
    ):
        psi, delta = size, size * MACHINE.base_radius / share
        bends = MACHINE.accelerations(psi, delta, 0.0, 0.0)
        for bend, angle in zip(bends, (psi, delta), strict=True):
            assert bend == pytest.approx(-MACHINE.gravity / length * angle, rel=3.0 * size**2 * 9)


def to_the_middle(machine, amplitude, delta):
    """Time to ψ = 0 from rest, and δ there, by DOP853."""

    def slopes(_, y):
        return [y[2], y[3], *machine.accelerations(*y)]

    def middle(_, y):
        return y[0]

    middle.terminal = True
    start, exact = [amplitude, delta, 0.0, 0.0], {'rtol': 1e-13, 'atol': 1e-15, 'max_step': 0.1}
    span = 0.0, 2.0 * machine.small_period
    found = solve_ivp(slopes, span, start, 'DOP853', events=middle, **exact)
    return found.t_events[0][0], found.y_events[0][0][1]


@pytest.mark.parametrize(
    ('length', 'amplitude', 'stiffness'),
    [(0.3, 1.5, 0.0), (0.5, 0.5, 0.0), (5.0, 1.5, 0.0), (0.3, 1.2, 40.0)],
)
def test_the_periodic_swing_is_that_of_a_shooting_method(length, amplitude, stiffness):
    """The thread passes the middle with the wheel. The event is good to 1e-10 of the period."""
    machine = replace(MACHINE, length=length, stiffness=stiffness)
    share = machine.modes.B_prime if machine.wheel_is_fast else machine.modes.B
    guess = amplitude * machine.base_radius / share
    delta = brentq(
        lambda d: to_the_middle(machine, amplitude, d)[1], 0.7 * guess, 1.3 * guess, xtol=1e-14
    )
    quarter, _ = to_the_middle(machine, amplitude, delta)
    assert machine.period(amplitude) == pytest.approx(4.0 * quarter, rel=1e-9)
    assert machine.period(-amplitude) == machine.period(amplitude)


def test_what_has_no_common_swing_is_refused():
    # a hundredth of the thread stays free
    assert MACHINE.range_rad == pytest.approx(math.sqrt(0.99 * 30.0))
    with pytest.raises(CamRangeError, match='winds up the whole thread'):
        MACHINE.period(5.5)
    with pytest.raises(SwingError, match='no common swing'):
        replace(MACHINE, length=0.45).period(3.0)


@pytest.mark.parametrize('stiffness', [0.0, 40.0])
def test_energy_is_kept_by_the_equations(stiffness):
    """dE/dt along the equations of motion, by central differences."""
    machine, rng = replace(MACHINE, stiffness=stiffness), np.random.default_rng(1)
    for state in rng.uniform(-1.0, 1.0, (20, 4)):
        psi, delta, psi_rate, delta_rate = state.tolist()
        bends = machine.accelerations(psi, delta, psi_rate, delta_rate)
        slope, step = np.array([psi_rate, delta_rate, *bends]), 1e-6
        ends = [hanging_energy(machine, *(state + n * step * slope)) for n in (-1, 1)]
        power = (ends[1] - ends[0]) / (2 * step)
        assert abs(power) < 1e-9 * 9.81
    assert hanging_energy(machine, 0.0, 0.0, 0.0, 0.0) == 0.0


@pytest.mark.parametrize('amplitude', [1e-300, 1e-30, 1e-13, 1e-11])
def test_the_smallest_swings_take_the_limit(amplitude):
    """They differ by a share of A², far below rounding. The rest is Newton's error."""
    assert MACHINE.period(amplitude) == pytest.approx(MACHINE.small_period, rel=1e-14)
