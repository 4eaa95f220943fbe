"""Compiled readings of an IMU: correct to rounding, and each sample independent of others."""

import math

import mpmath
import numpy as np
import pytest

from tauto_core.motion.forcing import LEAST_UPWARD
from tauto_core.ship.kernels import force_of, roll_of

ROUNDING = 2.0**-53


def forces(angles, size=9.8):
    """Return forces at about these directions in the case."""
    return np.stack([0.0 * angles, -size * np.sin(angles), size * np.cos(angles)], axis=1)


def directions(force):
    tilt, size = np.empty((2, len(force)))
    force_of(force, tilt, size)
    return tilt, size


@pytest.mark.parametrize('widest', [1e-9, 0.39, 1.45])
def test_directions_are_right_to_two_roundings(widest):
    """Against 40 digits: the series, and beyond 22.5 degrees the library's function."""
    force = forces(np.random.default_rng(7).uniform(-widest, widest, 203))
    tilt, size = directions(force)
    with mpmath.workdps(40):
        exact = [mpmath.atan2(-mpmath.mpf(y), mpmath.mpf(z)) for _, y, z in force.tolist()]
        wrong = [abs(a / b - 1) for a, b in zip(tilt.tolist(), exact, strict=True)]
    assert max(wrong) <= 2.0 * ROUNDING
    np.testing.assert_allclose(size, 9.8, rtol=4.0 * ROUNDING)


def test_direction_and_pull_are_smooth_down_to_weightlessness():
    """From 2 m/s² upwards to 2 downwards, 0.3 across: direction and pull are smooth."""
    up = np.linspace(2.0, -2.0, 4001)
    tilt, pull = directions(np.stack([0.0 * up, 0.0 * up - 0.3, up], axis=1))
    as_felt = up >= LEAST_UPWARD
    np.testing.assert_allclose(tilt[as_felt], np.arctan2(0.3, up[as_felt]), rtol=1e-15)
    np.testing.assert_allclose(pull[as_felt], np.hypot(0.3, up[as_felt]), rtol=1e-15)
    assert np.all(tilt <= math.atan(0.3 / (0.5 * LEAST_UPWARD)))
    for found in (tilt, pull):
        slope = np.diff(found) / 1e-3
        assert np.max(np.abs(np.diff(slope))) < 5e-3
        assert np.max(np.abs(slope)) < 1.3
    # on a lean that stays the pull is the component along it
    down = directions(np.array([[0.0, -0.3, -2.0], [0.0, 0.0, -2.0]]))
    lean = down[0][0]
    assert down[1][0] == pytest.approx(0.3 * math.sin(lean) - 2.0 * math.cos(lean), rel=1e-14)
    assert (down[0][1], down[1][1]) == (0.0, -2.0)


def test_a_direction_does_not_depend_on_its_neighbours():
    """Moderate and steep tilts, and forces that point down, across and nowhere, in any batch."""
    rng = np.random.default_rng(8)
    angles = rng.uniform(-1.5, 1.5, 64)
    angles[32:] *= 2.0
    force = forces(angles)
    force[[5, 40]] = 0.0
    force[[6, 41]] = [0.0, 3.0, 0.0]
    whole = np.stack(directions(force))
    assert np.isfinite(whole).all()
    for first, last in ((0, 1), (3, 20), (5, 7), (40, 64)):
        part = np.stack(directions(force[first:last].copy()))
        np.testing.assert_array_equal(part, whole[:, first:last])


def test_a_roll_does_not_depend_on_its_neighbours():
    rng = np.random.default_rng(9)
    orientation = rng.normal(size=(64, 4))
    orientation[::3] = [0.1, 0.02, -0.01, 1.0]
    velocity = rng.normal(size=(64, 3))
    whole = np.empty((2, 64))
    roll_of(orientation, velocity, *whole)
    for first, last in ((0, 5), (3, 20), (17, 64)):
        part = np.empty((2, last - first))
        roll_of(orientation[first:last].copy(), velocity[first:last].copy(), *part)
        np.testing.assert_array_equal(part, whole[:, first:last])
