"""Rotations and error-free sums against mpmath and exact fractions."""

from __future__ import annotations

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from tauto_core.kernels import entry
from tauto_core.motion.gauss_step import (
    MAX_ANGLE,
    multiply_exactly,
    rotation,
    sine_versine,
    sum_exactly,
    twofold_rotation,
)
from tauto_core.motion.lanes import row_of, store


@entry
def exact_pairs(a, b, out):
    out[0], out[1] = sum_exactly(a, b)
    out[2], out[3] = multiply_exactly(a, b)


@entry
def twofold(rate, time, out):
    cosine, sine = twofold_rotation(rate, time)
    out[0], out[1] = cosine
    out[2], out[3] = sine


@entry
def functions(angle, angles, out, lanes):
    out[0], out[1] = sine_versine(angle)
    out[2], out[3] = rotation(2.0 * angle)
    s, v = sine_versine(row_of(angles, 0))
    store(lanes, 0, s)
    store(lanes, 1, v)
    c, s = rotation(2.0 * row_of(angles, 0))
    store(lanes, 2, c)
    store(lanes, 3, s)


def pairs():
    random = np.random.default_rng(5)
    a, b = random.standard_normal((2, 200)) * 10.0 ** random.integers(-60, 60, (2, 200))
    near = random.standard_normal(50)
    return [
        *zip(a.tolist(), b.tolist(), strict=True),
        *((x, -x * (1.0 + 2.0**-40)) for x in near.tolist()),
        (1.0, 2.0**-54),
        (1e300, -1e-300),
        (0.0, -3.0),
    ]


def test_sums_and_products_lose_nothing():
    out = np.zeros(4)
    for a, b in pairs():
        exact_pairs(a, b, out)
        assert Fraction(out[0]) + Fraction(out[1]) == Fraction(a) + Fraction(b)
        assert Fraction(out[2]) + Fraction(out[3]) == Fraction(a) * Fraction(b)
        assert out[0] == a + b
        assert out[2] == a * b


@pytest.mark.parametrize('rate', [1e-3, 0.7, math.pi, 31.0 / 7.0, 1e3])
def test_twofold_rotation_is_good_to_thirty_digits(rate):
    out = np.zeros(4)
    with mpmath.workdps(50):
        for angle in [*np.linspace(-MAX_ANGLE, MAX_ANGLE, 23), 1e-12, 1e-3, math.pi / 2]:
            time = float(angle) / rate
            twofold(rate, time, out)
            whole = mpmath.mpf(rate) * mpmath.mpf(time)
            cosine, sine = (mpmath.mpf(out[i]) + mpmath.mpf(out[i + 1]) for i in (0, 2))
            assert abs(cosine - mpmath.cos(whole)) < 1e-30
            assert abs(sine - mpmath.sin(whole)) < 1e-30
            # the first double of each is the number rounded, the second no more than what is left
            assert abs(out[1]) <= math.ulp(out[0])
            assert abs(out[3]) <= math.ulp(out[2])


def test_series_and_rotations_are_good_to_few_roundings():
    """Angles up to π, 1 − cos relative to itself, and rotations by twice as much.

    As floats and, with the same bits, as lanes.
    """
    angles = np.concatenate([np.linspace(-math.pi, math.pi, 801), np.geomspace(1e-9, 1.0, 79)])
    rows = angles.reshape(-1, 8)
    floats, lanes = np.zeros((len(angles), 4)), np.zeros((4, len(angles)))
    for k, row in enumerate(rows):
        part = np.zeros((4, 8))
        for i, angle in enumerate(row):
            functions(float(angle), row[None].copy(), floats[8 * k + i], part)
        lanes[:, 8 * k : 8 * k + 8] = part
    np.testing.assert_array_equal(lanes.T, floats)
    with mpmath.workdps(40):
        for angle, found in zip(angles.tolist(), floats.tolist(), strict=True):
            (sine, versine, cosine_2, sine_2), exact = found, mpmath.mpf(angle)
            short = 2 * mpmath.sin(exact / 2) ** 2
            assert abs(sine - mpmath.sin(exact)) < 5e-16
            assert abs(versine - short) <= 1e-15 * short
            assert abs(cosine_2 - mpmath.cos(2 * exact)) < 1.5e-15
            assert abs(sine_2 - mpmath.sin(2 * exact)) < 3e-15
            if 0.0 < abs(angle) < 1.0:
                # the sine of a long series would have the error of its largest term
                assert abs(sine / mpmath.sin(exact) - 1) < 4e-16
