"""Local polynomials: exact for polynomials, of the stated order and size for waves."""

import math

import numpy as np
import pytest

from tauto_core.ship.interpolation import (
    FORCE_BEFORE,
    FORCE_POINTS,
    ROLL_BEFORE,
    ROLL_POINTS,
    polynomials,
)

STEP = 50_000_000


def coefficients(stamps, values, rates, before, points):
    piece = np.arange(before, len(stamps) - points + before)
    return piece, polynomials(stamps, values, rates, piece - before, points, piece)


@pytest.mark.parametrize('irregular', [False, True])
@pytest.mark.parametrize('slopes', [False, True])
def test_polynomials_are_reproduced(slopes, irregular):
    """Degree 7 from four values and slopes, 9 from ten values; irregular systems lose digits."""
    degree = 7 if slopes else 9
    rng = np.random.default_rng(3)
    exact = np.polynomial.Polynomial(rng.normal(size=degree + 1), domain=[0, 1.0], window=[-1, 1])
    stamps = np.arange(20) * STEP
    if irregular:
        stamps = stamps + rng.integers(-STEP // 5, STEP // 5, 20)
    times = stamps * 1e-9
    rates = exact.deriv()(times) if slopes else None
    before, points = (ROLL_BEFORE, ROLL_POINTS) if slopes else (FORCE_BEFORE, FORCE_POINTS)
    piece, found = coefficients(stamps, exact(times), rates, before, points)
    for k, row in zip(piece, found, strict=True):
        x = np.linspace(0.0, 1.0, 7)
        t = times[k] + x * (times[k + 1] - times[k])
        tolerance = 1e-9 if irregular else 1e-12
        np.testing.assert_allclose(
            np.polynomial.polynomial.polyval(x, row), exact(t), rtol=0, atol=tolerance
        )


@pytest.mark.parametrize(
    ('slopes', 'order', 'constant'),
    [
        (True, 8, (3 / 4) ** 4 / math.factorial(8)),
        (False, 10, (945 / 32) ** 2 / math.factorial(10)),
    ],
)
def test_error_of_a_wave_is_that_of_the_remainder(slopes, order, constant):
    """At the middle of the piece the remainder is constant · (Ωh)^order · the derivative there."""
    before, points = (ROLL_BEFORE, ROLL_POINTS) if slopes else (FORCE_BEFORE, FORCE_POINTS)
    errors = []
    for cycles in (8, 16):
        wave = 2 * math.pi / cycles
        n = np.arange(40)
        rates = -np.sin(wave * n) * wave / (STEP * 1e-9) if slopes else None
        piece, found = coefficients(n * STEP, np.cos(wave * n), rates, before, points)
        middle = np.polynomial.polynomial.polyval(0.5, found.T)
        errors.append(np.max(np.abs(middle - np.cos(wave * (piece + 0.5)))))
        predicted = constant * wave**order
        # the next term of the remainder is (Ωh)² smaller, up to a factor of order one
        assert errors[-1] == pytest.approx(predicted, rel=1.5 * wave**2)
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.4)
