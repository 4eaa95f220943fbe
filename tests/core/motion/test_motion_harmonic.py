"""The ideal cam a hundred days later, whatever its period: only the last bit is rounded."""

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from mpmath import mpf

from tauto_core.curves import Hole
from tauto_core.machines import Machine
from tauto_core.motion.closed_forms import Harmonic
from tauto_core.motion.forcing import half_turns

HUNDRED_DAYS_NS = 100 * 86_400 * 10**9
RATE = 0.01
# a second, a day, an odd one, a bell's and one of years
PERIODS_S = [1.0, 86_400.0, math.sqrt(2.0) / 3.0, 1.0 / 440.0, 1e8 / 3.0]


def instants():
    """Times from the release [ns]: the ends, whole seconds, powers of two, and any."""
    random = np.random.default_rng(1727)
    ends = HUNDRED_DAYS_NS - np.arange(3)
    seconds = random.integers(0, 8_640_000, 40) * 10**9
    powers = np.array([2**k + d for k in (0, 31, 32, 33, 52) for d in (-1, 0, 1)])
    return np.concatenate([ends, seconds, powers, random.integers(0, HUNDRED_DAYS_NS, 80)])


def ideal(period_s, release_angle):
    inertia = 4e-4
    force = inertia * (math.tau / period_s) ** 2 / RATE
    cam = Hole(RATE, 1.0)
    return Machine(inertia, 0.0, 0.0, force, 0.0, 9.81, cam, False, None, None, release_angle)


@pytest.mark.parametrize('period_s', PERIODS_S)
def test_phase_angle_and_rate_after_a_hundred_days(period_s):
    """φ = ωt of the machine's own numbers in 50 digits.

    The fraction of a half turn is one sum of products, good to two units of 2⁻⁵³. cos and sin add
    one rounding, π times the fraction's error, and a rounding of ω.
    """
    machine, times = ideal(period_s, 0.7), instants()
    motion = Harmonic(machine).motion_at(times)
    with mpmath.workdps(50):
        omega = mpmath.sqrt(mpf(machine.force) * mpf(RATE) / mpf(machine.inertia))
        turns = [omega * int(t) / 10**9 / mpmath.pi for t in times]
        phase = [
            n + mpf(f) for n, f in zip(motion.half_turns.tolist(), motion.fraction, strict=True)
        ]
        off = [float(found - exact) for found, exact in zip(phase, turns, strict=True)]
        angle = [float(0.7 * mpmath.cospi(turn)) for turn in turns]
        rate = [float(-0.7 * omega * mpmath.sinpi(turn)) for turn in turns]
    assert max(map(abs, off)) <= 2.5 * 2.0**-53
    assert np.all((motion.fraction >= 0.0) & (motion.fraction < 1.0))
    np.testing.assert_allclose(motion.angle, angle, rtol=0.0, atol=0.7 * 1.2e-15)
    np.testing.assert_allclose(motion.rate, rate, rtol=0.0, atol=0.7 * float(omega) * 1.2e-15)


@pytest.mark.parametrize('rate', [2e-9, 1 / 3e9, 1e-17 / 7, 8.8e-7, 0.499])
def test_whole_half_turns_are_exact(rate):
    """For a rate given as two floats, in fractions. 0.499 per nanosecond is the fastest."""
    low = rate * 2.0**-55 / 3.0
    times = instants()
    whole, fraction = half_turns(times, (rate, low))
    for t, n, f in zip(times.tolist(), whole.tolist(), fraction.tolist(), strict=True):
        exact = t * (Fraction(rate) + Fraction(low))
        assert abs(n + Fraction(f) - exact) <= Fraction(5, 2**54)
        assert 0.0 <= f < 1.0


def test_an_instant_has_the_same_bits_alone_or_with_others():
    """Bit for bit, though times beyond 104 days take another pass."""
    times = np.array([5, 2**53 - 1, 2**53, 2**53 + 1, 3 * 2**53 + 12_345, 2**62 + 7])
    rate = 1 / 3e9, 1e-27
    together = np.stack(half_turns(times, rate))
    alone = np.concatenate([np.stack(half_turns(times[[i]], rate)) for i in range(6)], axis=1)
    np.testing.assert_array_equal(together, alone)
    exact = [t * (Fraction(rate[0]) + Fraction(rate[1])) for t in times.tolist()]
    np.testing.assert_array_equal(together[0], [float(e.__floor__()) for e in exact])
