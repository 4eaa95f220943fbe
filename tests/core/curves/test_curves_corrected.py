"""The cams corrected for a weight's inertia and a spring's stiffness (D in cams.md)."""

import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from golden_numbers import GOLDEN
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core.curves import Involute, SpringCorrected, WeightCorrected
from tauto_core.curves.cam import FitError, smooth_lever, too_sharp
from tauto_core.machines import Machine
from tauto_core.scene.errors import CamRangeError

POINTS = [entry for entry in GOLDEN if entry['id'].startswith('D-cam')]


def weight(entry):
    with mpmath.workdps(50):
        p = {key: mpmath.mpf(item['value']) for key, item in entry['params'].items()}
        rate = p['I'] * p['omega'] ** 2 / (p['m'] * p['g'])
        tangent = mpmath.tan(p['chi'])
        return float(rate), float(p['m']) / float(p['I']), float(tangent), p


@pytest.mark.parametrize('entry', POINTS, ids=lambda entry: entry['id'])
def test_golden_points(entry):
    rate, ratio, tangent, p = weight(entry)
    expected = {key: float(value) for key, value in entry['expected'].items() if key != 'cam_arc'}

    class AtSlope(WeightCorrected):
        """The cam at tan χ, since near the edge doubles do not resolve the angle."""

        def _slope(self, x):
            return np.where(np.asarray(x) == 0.0, 0.0, tangent)

        def within(self, angle):
            return np.asarray(angle, np.float64)

    cam = AtSlope(rate, ratio)
    angle = float(cam.angle_of_slope(tangent))
    inertia, mass, gravity = (float(p[key]) for key in ('I', 'm', 'g'))
    machine = Machine(inertia, mass, mass, 0.0, 0.0, gravity, cam, False, None, None, 0.1)
    x, y = cam.contact(angle)
    found = {
        'theta': angle,
        'h': cam.lift(angle),
        'lever_arm': cam.lever_arm(angle),
        'dlever_dtheta': cam.lever_rate(angle),
        'R_vertical_thread': cam.radius_of_curvature(angle),
        'cam_X': x,
        'cam_Y': y,
        's_arc': machine.arc(angle),
        'theta_max': cam.angle_of_slope(1e150),
        'h_max': cam.length / 2,
        'involute_r': rate,
    }
    assert found.keys() == expected.keys()
    for key, value in found.items():
        # the rounded parameters cost τ⁷'s condition in R; points are differences of t' and more
        unit = rate if key.startswith('cam_') else 0.0
        assert float(value) == pytest.approx(expected[key], rel=1e-13, abs=4e-16 * unit), key


@pytest.mark.parametrize('entry', POINTS, ids=lambda entry: entry['id'])
def test_golden_points_from_the_angle(entry):
    rate, ratio, tangent, _ = weight(entry)
    cam, angle = WeightCorrected(rate, ratio), float(entry['expected']['theta'])
    limit = float(entry['expected']['theta_max'])
    assert cam.range_rad == pytest.approx(limit, rel=4.3e-10)
    assert cam.range_rad < limit
    if angle > cam.range_rad:
        with pytest.raises(CamRangeError, match='wider range'):
            cam.lever_arm(angle)
        return
    # near the edge t goes like the cube root of the rest of the range, which is rounded
    condition = 2e-16 * limit / (limit - angle)
    assert float(cam.slope(angle)) == pytest.approx(tangent, rel=2e-15 + condition)
    assert float(cam.angle_of_lift(cam.lift(angle))) == pytest.approx(angle, rel=4e-15)


@pytest.mark.parametrize('name', ['0.001', '0.3', '0.5', '0.95', '0.999'])
def test_golden_periods(name):
    entry = next(entry for entry in GOLDEN if entry['id'] == f'D-period-amp{name}')
    p = {key: float(item['value']) for key, item in entry['params'].items()}
    amplitude = float(entry['expected']['amplitude_rad'])
    rate = p['I'] * p['omega'] ** 2 / (p['m'] * p['g'])
    cam = WeightCorrected(rate, p['m'] / p['I'])
    machine = Machine(p['I'], p['m'], p['m'], 0.0, 0.0, p['g'], cam, False, None, None, 0.1)
    ratio = machine.period(amplitude) * p['omega'] / math.tau
    expected = float(entry['expected']['T_over_2pi_omega_corrected'])
    assert ratio == pytest.approx(expected, rel=2e-15)
    wheel = replace(machine, cam=Involute(rate))
    excess = wheel.period(amplitude) / wheel.small_period
    assert excess == pytest.approx(float(entry['expected']['T_ratio_involute_same_r']), rel=2e-15)


@pytest.mark.parametrize('angle', [1e-9, 1e-3, 0.3, 5.0, 1e4])
@pytest.mark.parametrize('stiffness', [1e-12, 1.0, 30.0])
def test_spring_against_fifty_digits(angle, stiffness):
    rate, force = 0.01, 2.0
    cam = SpringCorrected(rate, stiffness / force)
    with mpmath.workdps(50):
        p, k, x = mpmath.mpf(force), mpmath.mpf(force) * mpmath.mpf(rate), mpmath.mpf(angle)
        kappa = mpmath.mpf(stiffness)

        def lift(value):
            return (mpmath.sqrt(p**2 + kappa * k * value**2) - p) / kappa

        root = mpmath.sqrt(p**2 + kappa * k * x**2)
        arm, slope = k * x / root, k * p**2 / root**3
        bend = -3 * kappa * k**2 * p**2 * x / root**5
        contact = (
            arm * mpmath.cos(x) - slope * mpmath.sin(x),
            arm * mpmath.sin(x) + slope * mpmath.cos(x),
        )
        expected = [float(v) for v in (lift(x), arm, slope, bend, *contact)]
    found = [cam.lift(angle), cam.lever_arm(angle), cam.lever_rate(angle)]
    np.testing.assert_allclose([*found, cam.lever_curvature(angle)], expected[:4], rtol=2e-15)
    # coordinates of a curve that winds round are differences
    np.testing.assert_allclose(
        cam.contact(angle), expected[4:], atol=3e-15 * math.hypot(*expected[4:])
    )
    assert float(cam.angle_of_lift(cam.lift(angle))) == pytest.approx(angle, rel=1e-15)


@pytest.mark.parametrize('distance', [0.05, 0.0999, 0.1001, math.inf])
def test_range_of_the_spring_cam(distance):
    """The lever arm tends to b/c = 0.1 m, so it reaches only a nearer hole."""
    cam = SpringCorrected(0.01, 1.0, distance)
    if distance < 0.1:
        assert float(cam.lever_arm(cam.range_rad)) == pytest.approx(distance, rel=1e-13)
    else:
        assert cam.range_rad == math.inf
        assert float(cam.lever_arm(1e9)) <= distance


def test_range_of_the_weight_cam_through_a_hole():
    cam = WeightCorrected(0.01, 100.0, 0.25)
    assert float(cam.lever_arm(cam.range_rad)) == pytest.approx(0.25, rel=1e-13)
    with pytest.raises(CamRangeError, match='lifts by at most'):
        cam.angle_of_lift(cam.length)


def test_hollow_spring_cheek():
    """On a vertical thread the cheek is convex up to bκ/P = 1/3, and from D = √3c on."""
    assert too_sharp(SpringCorrected(0.01, 33.3), 0.0) == []
    ((start, end),) = too_sharp(SpringCorrected(0.01, 100.0), 0.0)
    assert start == 0.0
    # t + t'' = 0 at 1 + c²ϑ² = √3 c, c = 1
    assert end == pytest.approx(math.sqrt(math.sqrt(3.0) - 1.0), rel=1e-9)
    # a hole bends the tip outwards: 1 + w + w² > 3c²(1 − w)², w = b/(a + b)
    w = 0.01 / 0.06
    limit = (1 + w + w * w) / (3 * (1 - w) ** 2)
    assert not too_sharp(SpringCorrected(0.01, 0.999 * limit / 0.01, 0.05), 0.0)
    assert too_sharp(SpringCorrected(0.01, 1.001 * limit / 0.01, 0.05), 0.0)


def test_too_sharp_for_a_thread():
    """R = rϑ of an involute: half a millimetre of thread needs ϑ ≥ 1/20 at r = 5 mm."""
    ((start, end),) = too_sharp(Involute(0.005), 0.25e-3)
    assert (start, end) == (0.0, pytest.approx(0.05, rel=1e-12))
    assert too_sharp(WeightCorrected(0.005, 100.0), 0.25e-3)[0][1] < 0.05
    # at the end of a hole's cam R vanishes again
    cam = replace(WeightCorrected(0.005, 100.0), distance=0.05)
    near, far = too_sharp(cam, 0.25e-3, cam.range_rad)
    assert (near[0], far[1]) == (0.0, cam.range_rad)
    radii = cam.radius_of_curvature([near[1], far[0]])
    np.testing.assert_allclose(radii, 0.25e-3, rtol=1e-6)


def pieces(law, angle):
    """Return t, t' and h of the stated layout, by a plain loop."""
    k = min(int(np.searchsorted(law.knots, angle, 'right')) - 1, len(law.knots) - 2)
    x, row = angle - law.knots[k], law.coefficients[k]
    polynomial = np.polynomial.Polynomial(row)
    return polynomial(x), polynomial.deriv()(x), law.lifts[k] + polynomial.integ()(x)


@settings(max_examples=25)
@given(st.floats(1e-12, 1.0), st.sampled_from([math.inf, 0.1, 0.01]))
def test_kernel_form_of_the_weight_cam(part, distance):
    cam = WeightCorrected(0.008, 125.0, distance)
    law, angle = LAWS[distance], part * cam.range_rad
    # t and t' feel the rounding of the angle near the edge
    left = 1.0 - angle / (math.pi / 4 / (0.008 * math.sqrt(125.0)))
    arm, rate, lift = pieces(law, angle)
    assert arm == pytest.approx(float(cam.lever_arm(angle)), rel=4e-15 + 1e-15 / left)
    assert rate == pytest.approx(float(cam.lever_rate(angle)), rel=2e-12 + 1e-13 / left)
    assert lift == pytest.approx(float(cam.lift(angle)), rel=1e-14)
    if angle <= law.knots[1]:
        u = (angle / law.knots[1]) ** 2
        first, second, third = (np.polynomial.polynomial.polyval(u, row) for row in law.middle)
        assert angle * first == pytest.approx(arm, rel=2e-15)
        assert second == pytest.approx(rate, rel=4e-15)
        assert angle * angle * third == pytest.approx(lift, rel=4e-15)


LAWS = {a: WeightCorrected(0.008, 125.0, a).lever for a in (math.inf, 0.1, 0.01)}


def test_a_law_that_is_not_smooth():
    def rough(angle):
        return angle * (1.0 + 1e-6 * np.sin(1e15 * angle))

    with pytest.raises(FitError, match='not smooth enough'):
        smooth_lever(rough, lambda angle: angle**2, 2.0)
