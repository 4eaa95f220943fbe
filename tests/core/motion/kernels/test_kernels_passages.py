"""The bounds by which a swing is told to be clear of the tilt."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tauto_core.kernels import entry
from tauto_core.motion.stepping import bounds_of


@entry
def bounds(channel, k, per):
    return bounds_of(channel, k, per)


@pytest.mark.parametrize('turned', [0.3, 2.0, 5.5])
def test_bounds_hold_and_are_close_in_pieces_up_to_a_wave(turned):
    """Taylor's series of waves; the coefficients' sum would be e^5.5 = 245 times as large."""
    j = np.arange(30)
    factorials = np.array([math.factorial(n) for n in j], dtype=float)
    x = np.linspace(0.0, 1.0, 1001)
    for phase in np.linspace(0.0, math.tau, 13):
        wave = np.cos(phase + 0.5 * math.pi * j) * turned**j / factorials
        value, slope = bounds(wave[None, :], 0, 1.0)
        most, fastest = (
            np.abs(np.cos(turned * x + phase)),
            turned * np.abs(np.sin(turned * x + phase)),
        )
        # 30 terms of the series leave 1e-9
        assert most.max() <= value <= 1.500001 * most.max()
        assert fastest.max() <= slope <= 1.500001 * fastest.max()
