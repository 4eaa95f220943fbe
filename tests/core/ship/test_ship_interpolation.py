"""Local polynomials: exact for polynomials, of the stated order and size for waves."""

import math

import numpy as np
import pytest

from tauto_core.ship.buffer import SamplePieces, polynomials
from tauto_core.ship.sampling import FORCE_BEFORE, MAX_STRIDE

STEP = 50_000_000
power = np.polynomial.polynomial


def fitted(stamps, values, rates, begin, stride, *, regular):
    pieces = SamplePieces(begin, begin + stride, np.full(len(begin), regular))
    return polynomials(stamps, values, rates, pieces, stride=stride, offset=0)


def conditions(stride, slopes):
    return 2 * (stride + 3) if slopes else stride + 9


@pytest.mark.parametrize('stride', range(1, MAX_STRIDE + 1))
@pytest.mark.parametrize('slopes', [False, True])
def test_polynomials_are_reproduced_over_several_samples(slopes, stride):
    """Of the highest degree that the conditions fix, in every block of rows and in odd rows."""
    degree = conditions(stride, slopes) - 1
    exact = np.polynomial.Polynomial(np.random.default_rng(3).normal(size=degree + 1))
    stamps = np.arange(2 * MAX_STRIDE + 3 * 256) * STEP
    scale = 1e9 / (STEP * len(stamps))  # the whole record is 0 … 1
    rates = exact.deriv()(stamps * 1e-9 * scale) * scale if slopes else None
    begin = np.arange(FORCE_BEFORE, len(stamps) - stride - FORCE_BEFORE, stride)
    values = exact(stamps * 1e-9 * scale)
    found = fitted(stamps, values, rates, begin, stride, regular=True)
    for x in (0.0, 0.3, 1.0):
        at = (stamps[begin] + x * stride * STEP) * 1e-9 * scale
        # the values have a size of 10 and are off by 1e-15, and the windows magnify that little
        np.testing.assert_allclose(power.polyval(x, found.T), exact(at), rtol=0, atol=1e-13)
    some = fitted(stamps, values, rates, begin[1::7], stride, regular=True)
    np.testing.assert_array_equal(some, found[1::7])


@pytest.mark.parametrize('slopes', [False, True])
def test_polynomials_are_reproduced_at_uneven_samples(slopes):
    """Degree 7 from four values and slopes, 9 from ten values, with one-sided end windows."""
    rng = np.random.default_rng(3)
    exact = np.polynomial.Polynomial(rng.normal(size=8 if slopes else 10))
    stamps = np.arange(20) * STEP + rng.integers(-STEP // 5, STEP // 5, 20)
    times = stamps * 1e-9
    begin = np.arange(19)
    rates = exact.deriv()(times) if slopes else None
    found = fitted(stamps, exact(times), rates, begin, 1, regular=False)
    for k, row in zip(begin, found, strict=True):
        x = np.linspace(0.0, 1.0, 7)
        t = times[k] + x * (times[k + 1] - times[k])
        # one-sided windows magnify rounding of 1e-16 some hundred times
        np.testing.assert_allclose(power.polyval(x, row), exact(t), rtol=0, atol=1e-13)


@pytest.mark.parametrize('stride', range(1, MAX_STRIDE + 1))
@pytest.mark.parametrize('slopes', [False, True])
def test_a_wave_of_5_s_at_20_hz_is_met_to_rounding(slopes, stride):
    """The table of the module: twice its figures, which come from another set of phases."""
    limits = (4e-15 if stride == 1 else 2e-15, 6e-14, 3e-11)
    turn = 2 * math.pi / 5.0 * STEP * 1e-9
    k = np.arange(stride + 1 + 2 * FORCE_BEFORE)
    rate = turn / (STEP * 1e-9)
    for phase in np.linspace(-3.0, 3.0, 40):
        angle = turn * (k - FORCE_BEFORE - 0.5 * stride) + phase
        rates = -rate * np.sin(angle) if slopes else None
        begin = np.array([FORCE_BEFORE])
        row = fitted(k * STEP, np.cos(angle), rates, begin, stride, regular=True)[0]
        x = np.linspace(0.0, 1.0, 2 * stride + 1)
        angle = turn * stride * (x - 0.5) + phase
        for order, exact in enumerate((np.cos(angle), -np.sin(angle), -np.cos(angle))):
            got = power.polyval(x, power.polyder(row, order)) / (turn * stride) ** order
            np.testing.assert_allclose(got, exact, rtol=0, atol=limits[order])
