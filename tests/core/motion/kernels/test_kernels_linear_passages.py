"""The bound by which spans of a linear wheel are calm."""

import math

import numpy as np
import pytest

from tauto_core.kernels import entry
from tauto_core.motion.forced_harmonic import BEYOND_SAMPLES, _bound_of_all, _rough
from tauto_core.motion.forcing import Polynomials

OMEGA0, STEP_S, SAMPLES = 6.3, 0.5, 400


@entry
def bound_of_all(omega0, u):
    return _bound_of_all(omega0, u, 0.0)


def bound(values, rates):
    return bound_of_all(
        OMEGA0, Polynomials(values, rates, np.zeros(1, np.int64), np.empty((0, 6)))
    )


def test_a_sea_with_four_samples_a_wave_keeps_the_bound():
    """Ehlich and Zeller: 1/cos(π/4) = 1.414 at most, of a wave with peaks between them."""
    t = STEP_S * np.arange(SAMPLES)
    between = np.linspace(0.0, t[-1], 40 * SAMPLES)
    shortest = 2.0 * math.pi / (4.0 * STEP_S)
    rng = np.random.default_rng(1)
    seas = [(np.array([1.0]), np.array([shortest]), np.array([math.pi / 4]))]
    for _ in range(20):
        seas.append(
            (rng.uniform(0, 1, 16), rng.uniform(0.1, 1, 16) * shortest, rng.uniform(0, 7, 16))
        )
    for amplitude, omega, phase in seas:

        def motion(at, amplitude=amplitude, omega=omega, phase=phase):
            turned = np.multiply.outer(at, omega) + phase
            return np.cos(turned) @ amplitude, -np.sin(turned) @ (amplitude * omega)

        found = bound(*motion(t))
        u, rate = motion(between)
        assert np.max(np.hypot(u, rate / OMEGA0)) <= found
    value, rate = motion(t)
    assert found == BEYOND_SAMPLES * math.hypot(abs(value).max(), abs(rate).max() / OMEGA0)


@entry
def checked_bound(omega0, u, step_s):
    return _bound_of_all(omega0, u, _rough(omega0, u, step_s))


@pytest.mark.parametrize('samples', [2.0, 2.001, 2.05, 2.1, 2.3, 2.7, 3.0, 3.3, 3.6, 5.0])
@pytest.mark.parametrize('step_s', [0.05, 0.5])
@pytest.mark.parametrize('phase', [0.0, 0.3, 0.8, 1.2, 1.57, 2.5])
def test_a_wave_of_two_samples_keeps_the_checked_bound(samples, phase, step_s):
    """Ten samples are at hand, as of one window: rates show what values hide."""
    omega = 2.0 * math.pi / (samples * step_s)

    def motion(at):
        return np.cos(omega * at + phase), -omega * np.sin(omega * at + phase)

    at_hand = motion(step_s * np.arange(10))
    u = Polynomials(at_hand[0], at_hand[1], np.zeros(1, np.int64), np.empty((0, 6)))
    value, rate = motion(np.linspace(0.0, 9.0 * step_s, 4001))
    found = checked_bound(OMEGA0, u, step_s)
    assert np.max(np.hypot(value, rate / OMEGA0)) <= found
