"""Euler's curves against the golden numbers (50-digit arithmetic of an independent program)."""

import numpy as np
import pytest
from golden_numbers import entries, numbers

from tauto_core.curves import Hole, Involute

# The papers' two formulas are asked for to 1e-14 relative; so, then, is all that follows.
TIGHT = 1e-14


def close(actual, expected):
    np.testing.assert_allclose(actual, expected, rtol=TIGHT, atol=1e-300)


@pytest.mark.parametrize('entry', entries('A13-polar'))
def test_involute(entry):
    given, expected = numbers(entry)
    cam, z = Involute(1.0), given['z']
    polar_angle, radius = cam.polar(z)
    close(polar_angle, expected['x_polar_angle'])
    close(radius, expected['y_radius_over_r'])
    close(cam.arc_length(z), expected['arc_length_over_r'])
    # golden has the tip on +x, the wheel's frame has it on +y
    x, y = cam.contact(z)
    close([y, -x], [expected['cart_X'], expected['cart_Y']])


@pytest.mark.parametrize('entry', entries('A29-hole-a'))
def test_hole(entry):
    given, expected = numbers(entry)
    cam, phi = Hole(given['b'], given['a_over_b']), expected['phi']
    close(cam.p(phi), expected['p'])
    close(cam.p(given['t_over_a'] * cam.distance / cam.rate), expected['p'])
    close(cam.psi(phi), expected['psi'])
    close(cam.radius_of_curvature(phi), expected['R'])
    close(cam.arc_length(phi), expected['arc'])
    close(cam.contact(phi), [expected['X'], expected['Y']])
    close(np.hypot(*cam.contact(phi)), expected['CM'])


@pytest.mark.parametrize('entry', entries('A29-hole-Rmax'))
def test_greatest_radius_of_curvature(entry):
    given, expected = numbers(entry)
    cam = Hole(given['b'], given['a_over_b'])
    place = expected['t_at_Rmax'] / cam.rate
    # R is stationary there, so the rounded place costs nothing
    close(cam.radius_of_curvature(place), expected['Rmax'])
    aside = cam.radius_of_curvature([place * 0.999, place * 1.001])
    assert np.all(aside < expected['Rmax'])
    # level there: a place off by 2e-6 of itself would tilt it by more
    low, high = cam.radius_of_curvature([place * 0.9999, place * 1.0001])
    assert abs(high - low) < 5e-9 * expected['Rmax']
    close(cam.range_rad, expected['phi_max'])
    close(cam.psi(cam.range_rad), expected['psi_max'])
