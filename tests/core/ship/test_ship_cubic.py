"""Splines and Akima curves against scipy.interpolate, which is slow to import."""

import numpy as np
import pytest
from scipy.interpolate import Akima1DInterpolator, CubicSpline

from tauto_core.curves.numerics import akima, spline

RANDOM = np.random.default_rng(1727)


def points(n: int, gaps: tuple[float, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    x = np.cumsum(RANDOM.uniform(*gaps, n))
    return x, RANDOM.normal(size=n), np.sort(np.append(RANDOM.uniform(x[0], x[-1], 500), x))


@pytest.mark.parametrize('n', [4, 5, 6, 500])
@pytest.mark.parametrize('gaps', [(0.9, 1.1), (0.001, 3.0)])
def test_the_spline_is_scipys(n, gaps):
    """If steps differ much, SciPy pivots, and the two differ by rounding."""
    x, y, at = points(n, gaps)
    expected = CubicSpline(x, y)(at)
    rounding = 1e-13 * np.max(np.abs(expected))
    np.testing.assert_allclose(spline(x, y, at), expected, rtol=0, atol=rounding)


def test_splines_through_columns_have_the_bits_of_each():
    x, _, at = points(20, (0.001, 3.0))
    y = RANDOM.normal(size=(20, 2, 3))
    found = spline(x, y, at)
    assert found.shape == (len(at), 2, 3)
    for j, k in np.ndindex(2, 3):
        assert np.array_equal(found[:, j, k], spline(x, y[:, j, k], at))


@pytest.mark.parametrize('n', [2, 3, 4, 5, 500])
@pytest.mark.parametrize('gaps', [(0.9, 1.1), (0.001, 3.0)])
def test_akimas_curve_is_scipys(n, gaps):
    x, y, at = points(n, gaps)
    y[n // 3 : n // 2] = 1.0  # a straight run has zero weights
    expected = Akima1DInterpolator(x, y)(at)
    rounding = 1e-14 * np.max(np.abs(expected))
    np.testing.assert_allclose(akima(x, y, at), expected, rtol=0, atol=rounding)


def test_the_spline_reads_no_memory_that_nobody_has_written(monkeypatch):
    """NumPy's empty arrays hold old memory, usually finite numbers."""
    x, y, at = points(20, (0.9, 1.1))
    expected, empty = spline(x, y, at), np.empty

    def poisoned(shape, *args):
        return np.full(shape, np.nan) if not args else empty(shape, *args)

    monkeypatch.setattr(np, 'empty', poisoned)
    np.testing.assert_array_equal(spline(x, y, at), expected)
