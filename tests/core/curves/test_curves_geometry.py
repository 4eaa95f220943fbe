"""The cams as curves: golden numbers, and properties of any cheek and thread from its points."""

import math

import mpmath
import numpy as np
import pytest
from golden_numbers import entries, numbers
from numpy.polynomial import Chebyshev

from tauto_core.curves import CircularArc, Hole, Involute, Table, TableLever, outline
from tauto_core.curves.numerics import gauss_sums, sine_defect
from tauto_core.scene.errors import CamRangeError, UsageError


def odd_quintic(distance=math.inf):
    """A cam with t = 0.01 ϑ + 0.001 ϑ³ − 0.0001 ϑ⁵, as a table of one piece."""
    coefficients = np.array([[0.0, 0.01, 0.0, 0.001, 0.0, -0.0001]])
    return Table('quintic', TableLever(np.array([0.0, 2.0]), coefficients, np.zeros(1)), distance)


CAMS = {
    'involute': Involute(0.01),
    'hole': Hole(0.01, 0.08),
    'near hole': Hole(0.03, 0.015),
    'arc': CircularArc(0.02, 0.01),
    'table': odd_quintic(),
    'table through hole': odd_quintic(0.05),
}
every_cam = pytest.mark.parametrize('cam', CAMS.values(), ids=CAMS.keys())


def upper(cam):
    return 0.9 * min(cam.range_rad, 2.0)


def fits(cam):
    """Chebyshev fits of the points. 40 terms reach rounding on these intervals."""
    interval = [0.0, upper(cam)]

    def coordinate(s, i):
        return cam.contact(s)[i]

    return [Chebyshev.interpolate(coordinate, 60, interval, args=(i,)) for i in range(2)]


@every_cam
def test_lever_derivatives_and_lift(cam):
    top = upper(cam)
    arm = Chebyshev.interpolate(cam.lever_arm, 40, domain=[0.0, top])
    angle = np.linspace(0.05, 0.95, 7) * top
    # differentiating a fit loses about n² ulps a time
    np.testing.assert_allclose(cam.lever_rate(angle), arm.deriv()(angle), rtol=1e-11)
    np.testing.assert_allclose(cam.lever_curvature(angle), arm.deriv(2)(angle), atol=1e-11)
    np.testing.assert_allclose(cam.lift(angle), arm.integ(lbnd=0.0)(angle), rtol=1e-13)


@every_cam
def test_symmetry(cam):
    angle = np.linspace(0.1, 1.0, 5) * upper(cam)
    for odd in (cam.lever_arm, cam.lever_curvature, cam.psi, lambda s: cam.contact(s)[0]):
        np.testing.assert_array_equal(odd(-angle), -odd(angle))
    even = (cam.lift, cam.lever_rate, cam.p, cam.radius_of_curvature)
    for function in (*even, lambda s: cam.contact(s)[1]):
        np.testing.assert_array_equal(function(-angle), function(angle))


@every_cam
def test_thread_touches_the_cheek_at_the_lever_arm(cam):
    """The thread is tangent to the points' curve and passes the axle at the distance t."""
    angle = np.linspace(0.1, 0.9, 9) * upper(cam)
    x, y = cam.contact(angle)
    psi = cam.psi(angle)
    along = np.array([-np.sin(psi), np.cos(psi)])
    np.testing.assert_allclose(x * along[1] - y * along[0], cam.lever_arm(angle), rtol=1e-13)
    np.testing.assert_allclose(x * along[0] + y * along[1], cam.p(angle), rtol=1e-12, atol=1e-16)
    dx, dy = (fit.deriv()(angle) for fit in fits(cam))
    np.testing.assert_allclose((dx * along[1] - dy * along[0]) / np.hypot(dx, dy), 0, atol=1e-8)


@every_cam
def test_curvature_of_the_points(cam):
    x, y = fits(cam)
    angle = np.linspace(0.2, 0.9, 8) * upper(cam)
    dx, dy, ddx, ddy = (fit.deriv(n)(angle) for n in (1, 2) for fit in (x, y))
    radius = (dx * dx + dy * dy) ** 1.5 / (dx * ddy - dy * ddx)
    np.testing.assert_allclose(cam.radius_of_curvature(angle), radius, rtol=1e-7)


@pytest.mark.parametrize('a', [1e3, 1e9, 1e15])
@pytest.mark.parametrize('phi', [1e-6, 0.7, 40.0])
def test_far_hole_keeps_its_digits(a, phi):
    """The reference is the textbook form in 60 digits. In doubles it would lose the ratio a/b."""
    cam = Hole(1.0, a)
    with mpmath.workdps(60):
        t, far = mpmath.mpf(phi), mpmath.mpf(a)
        s = mpmath.sqrt(far**2 - t**2)
        psi, p = t + mpmath.asin(t / far), s / (1 + s)
        radius = t * (1 - 1 / (1 + s) ** 3)
        x = t * mpmath.cos(psi) - p * mpmath.sin(psi)
        y = t * mpmath.sin(psi) + p * mpmath.cos(psi)
        expected = [float(value) for value in (psi, p, radius, x, y)]
    found = [cam.psi(phi), cam.p(phi), cam.radius_of_curvature(phi)]
    np.testing.assert_allclose(found, expected[:3], rtol=1e-14)
    # coordinates are differences of lengths of about p, 1 m
    np.testing.assert_allclose(cam.contact(phi), expected[3:], rtol=1e-14, atol=4e-16)


def test_circular_cheek_is_a_circle():
    radius, depth = 0.02, 0.01
    cam = CircularArc(radius, depth)
    angle = np.linspace(0.0, math.pi, 13)
    x, y = cam.contact(angle)
    np.testing.assert_allclose(np.hypot(x + radius, y - depth), radius, rtol=1e-14)
    np.testing.assert_allclose(cam.radius_of_curvature(angle), radius, rtol=1e-13)
    np.testing.assert_allclose([x[-1], y[-1]], [-2 * radius, depth], rtol=1e-14)
    assert cam.lever_curvature(0.0) == radius
    assert cam.lever_curvature(-0.0) == -radius
    assert cam.kinked


@pytest.mark.parametrize('depth', [1e-9, 0.0])
@pytest.mark.parametrize('angle', [1e-9, 1e-4, 0.3, 0.999, 1.001, 3.0])
def test_circular_cheek_at_small_angles(angle, depth):
    """Rooted in the axle, depth 0 (Euler 1727, II), its arm is R (1 − cos ϑ) alone."""
    cam = CircularArc(0.02, depth)
    with mpmath.workdps(60):
        x, d, r = mpmath.mpf(angle), mpmath.mpf(depth), mpmath.mpf(0.02)
        arm = float(d * mpmath.sin(x) + r * (1 - mpmath.cos(x)))
        rate = float(d * mpmath.cos(x) + r * mpmath.sin(x))
        lift = float(d * (1 - mpmath.cos(x)) + r * (x - mpmath.sin(x)))
    np.testing.assert_allclose(cam.lever_arm(angle), arm, rtol=1e-15)
    np.testing.assert_allclose(cam.lever_rate(angle), rate, rtol=1e-15)
    np.testing.assert_allclose(cam.lift(angle), lift, rtol=2e-15)


@pytest.mark.parametrize('x', [1e-12, 1e-3, 0.4999, 0.9999, 1.0001, 2.0, 30.0])
def test_the_sine_defect_keeps_its_digits(x):
    with mpmath.workdps(60):
        expected = float(mpmath.mpf(x) - mpmath.sin(mpmath.mpf(x)))
    # at the switch from series to difference 0.84/0.16 ulps are lost
    assert float(sine_defect(np.asarray(x))) == pytest.approx(expected, rel=3e-15)
    assert float(sine_defect(np.asarray(-x))) == -float(sine_defect(np.asarray(x)))


NODES = 24
LEFT_OUT = math.factorial(NODES) ** 4 / ((2 * NODES + 1) * math.factorial(2 * NODES) ** 2)
"""∫ x⁴⁸ over an interval of length 1, less the rule's sum."""


def test_a_panel_is_of_order_48():
    """∫ cos x over widths w about 0: the rule errs by w⁴⁸ LEFT_OUT/48!, by the width.

    What follows has the same sign and takes e^{−w²/792}: the derivative's mean over the kernel.
    """
    width = np.array([44.0, 45.0, 46.0, 48.0, 50.0])
    exact = 2.0 * np.sin(0.5 * width)
    errors = (exact - gauss_sums(np.cos, -0.5 * width, width)) / width
    expected = LEFT_OUT / math.factorial(48) * width**48 * np.exp(-(width**2) / 792.0)
    np.testing.assert_allclose(errors, expected, rtol=0.1)
    assert np.all(errors > 1e-12)
    order = np.diff(np.log(errors)) / np.diff(np.log(width))
    np.testing.assert_allclose(order, 48.0 - width[1:] ** 2 / 396.0, atol=1.0)


@every_cam
def test_angle_of_lift_inverts_the_lift(cam):
    angle = np.concatenate([[0.0, 1e-12, 1e-9], np.linspace(1e-3, 1.0, 50) * upper(cam)])
    np.testing.assert_allclose(cam.angle_of_lift(cam.lift(angle)), angle, rtol=4e-15)
    if math.isfinite(cam.range_rad):
        with pytest.raises(CamRangeError, match='Use a smaller amplitude'):
            cam.angle_of_lift(1.001 * cam.lift(cam.range_rad))


@pytest.mark.parametrize('lift', [-1e-3, math.nan])
def test_lift_that_is_none(lift):
    with pytest.raises(CamRangeError, match='Use a smaller amplitude'):
        CAMS['arc'].angle_of_lift(lift)


METHODS = ['lever_arm', 'lever_rate', 'lever_curvature', 'lift', 'psi', 'p', 'contact']
METHODS += ['radius_of_curvature']


@pytest.mark.parametrize('method', METHODS)
@every_cam
def test_beyond_the_range(cam, method):
    function = getattr(cam, method)
    if math.isfinite(cam.range_rad):
        function([-cam.range_rad, cam.range_rad])
        with pytest.raises(CamRangeError, match='is beyond the range') as caught:
            function([0.0, -1.0000001 * cam.range_rad])
        assert repr(cam.range_rad) in str(caught.value)
    for bad in (math.nan, math.inf):
        with pytest.raises(CamRangeError, match=repr(bad)):
            function(bad)


@every_cam
def test_outline_is_both_cheeks(cam):
    x, y = outline(cam, points=31)
    assert x.shape == y.shape == (61,)
    np.testing.assert_array_equal((x[::-1], y[::-1]), (-x, y))
    np.testing.assert_allclose([x[30], y[30]], [0.0, float(cam.p(0.0))], rtol=1e-15)
    end = np.ravel(cam.contact(min(cam.range_rad, math.tau)))
    np.testing.assert_allclose([x[-1], y[-1]], end, rtol=1e-15)


def test_outline_refuses():
    with pytest.raises(UsageError, match='points = 1'):
        outline(CAMS['hole'], points=1)
    with pytest.raises(CamRangeError, match='range'):
        outline(CAMS['hole'], reach_rad=9.0)


def close(actual, expected, unit=0.0):
    """Compare to 1e-14 of a value, or two roundings of a curve's unit."""
    np.testing.assert_allclose(actual, expected, rtol=1e-14, atol=unit * 4e-16)


@pytest.mark.parametrize('entry', entries('A13-polar'))
def test_involute(entry):
    given, expected = numbers(entry)
    cam, z = Involute(1.0), given['z']
    # golden has the tip on +x, the wheel's frame has it on +y
    x, y = cam.contact(z)
    close([y, -x], [expected['cart_X'], expected['cart_Y']], max(z, 1.0))


@pytest.mark.parametrize('entry', entries('A29-hole-a'))
def test_hole(entry):
    given, expected = numbers(entry)
    cam, phi = Hole(given['b'], given['a_over_b']), expected['phi']
    close(cam.p(phi), expected['p'])
    close(cam.p(given['t_over_a'] * cam.distance / cam.rate), expected['p'])
    close(cam.psi(phi), expected['psi'])
    close(cam.radius_of_curvature(phi), expected['R'])
    close(cam.contact(phi), [expected['X'], expected['Y']], cam.distance)
    close(np.hypot(*cam.contact(phi)), expected['CM'], cam.distance)


@pytest.mark.parametrize('entry', entries('A29-hole-Rmax'))
def test_greatest_radius_of_curvature(entry):
    given, expected = numbers(entry)
    cam = Hole(given['b'], given['a_over_b'])
    place = expected['t_at_Rmax'] / cam.rate
    # R is stationary there, and a rounded place is harmless
    close(cam.radius_of_curvature(place), expected['Rmax'])
    aside = cam.radius_of_curvature([place * 0.999, place * 1.001])
    assert np.all(aside < expected['Rmax'])
    # level there: a place off by 2e-6 of itself would tilt it by more
    low, high = cam.radius_of_curvature([place * 0.9999, place * 1.0001])
    assert abs(high - low) < 5e-9 * expected['Rmax']
    close(cam.range_rad, expected['phi_max'])
    close(cam.psi(cam.range_rad), expected['psi_max'])
