"""Curves in a fluid: golden numbers, other forms of the same curve, limits, and refusals."""

import math

import mpmath
import numpy as np
import pytest
from golden_numbers import entries
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core.curves import Cycloid, FluidTautochrone, SymmetricCurve
from tauto_core.curves.fluid import (
    ActaCurve,
    abscissa,
    chained,
    coordinates,
    fluid_outline,
    radius_of_curvature,
)
from tauto_core.scene.errors import DescentError

OIL = FluidTautochrone(0.75, 0.9, 1.0)
THICK = FluidTautochrone(22.5, 0.1, 1.0)
CURVES = [
    OIL,
    THICK,
    FluidTautochrone(0.75, 0.9, 1.0, 0.03),
    FluidTautochrone(0.0, 1.0, 1.0),
    Cycloid(0.75, 0.9, 1.0),
    SymmetricCurve(0.75, 0.9, 1.0),
    ActaCurve(0.4, 0.9, 0.6, 0.3),
]
# few roundings in each form
ROUNDING = 4e-15


def points(curve):
    low = max(curve.ascent_cusp, -curve.descent_cusp)
    return np.linspace(0.999 * low, 0.999 * curve.descent_cusp, 13)


@pytest.mark.parametrize('curve', CURVES, ids=repr)
def test_slope_and_its_rate_are_derivatives_of_the_height(curve):
    """The reference is central differences, with the error h² x'''/6 and the rounding eps/h."""
    s, h = points(curve), 1e-5 * curve.descent_cusp
    rise = (curve.height(s + h) - curve.height(s - h)) / (2.0 * h)
    np.testing.assert_allclose(rise, curve.slope(s), atol=1e-9)
    bend = (curve.slope(s + h) - curve.slope(s - h)) / (2.0 * h)
    np.testing.assert_allclose(bend, curve.slope_rate(s), rtol=1e-8)


@pytest.mark.parametrize('curve', CURVES, ids=repr)
def test_the_cusps_are_where_the_curve_is_upright(curve):
    assert float(curve.slope(curve.descent_cusp)) == pytest.approx(1.0, rel=ROUNDING)
    if not math.isinf(curve.ascent_cusp):
        assert float(curve.slope(curve.ascent_cusp)) == pytest.approx(-1.0, rel=ROUNDING)


@pytest.mark.parametrize('curve', CURVES[4:], ids=repr)
def test_the_abscissa_is_that_of_another_quadrature(curve):
    for s in points(curve)[::3].tolist():

        def level(t):
            return mpmath.sqrt(1 - mpmath.mpf(float(curve.slope(float(t)))) ** 2)

        assert float(abscissa(curve, s)) == pytest.approx(float(mpmath.quad(level, [0, s])), 1e-13)


def exact(curve, s):
    """x = (e^{κs} − 1 − κs)/(γκ²f) and dx/ds in 60 digits."""
    kappa, gamma, f = map(mpmath.mpf, (curve.kappa, curve.gamma, curve.pendulum_length))
    rise = mpmath.expm1(kappa * s) / (gamma * kappa * f)
    return rise / kappa - s / (gamma * kappa * f), rise


@pytest.mark.parametrize('kappa', [1e-12, 1e-6, 0.1, 0.99, 1.01, 10.0, 1e4])
def test_the_abscissa_keeps_its_digits_from_thin_to_thick(kappa):
    curve = FluidTautochrone(kappa, 0.999, 1.0)
    for s in (0.9 * curve.descent_cusp, -0.5 * curve.descent_cusp, -3.0 / max(kappa, 4.0)):
        with mpmath.workdps(60):
            y = mpmath.quad(lambda t: mpmath.sqrt(1 - exact(curve, t)[1] ** 2), [0, s])
        assert float(abscissa(curve, s)) == pytest.approx(float(y), rel=2e-15)


def test_friction_takes_the_cusp_of_ascent_away_sooner():
    """β = 0.9: with μ = 0.1 the branch of ascent ends in a cusp, with 0.12 it does not."""
    near = FluidTautochrone(0.9, 1.0, 1.0, 0.1)
    assert float(near.slope(near.ascent_cusp)) == pytest.approx(-1.0, rel=ROUNDING)
    assert FluidTautochrone(0.9, 1.0, 1.0, 0.12).ascent_cusp == -math.inf


@settings(max_examples=25)
@given(st.floats(-14.0, 3.0), st.floats(-6.0, 0.0), st.booleans())
def test_height_and_its_inverse_keep_all_digits(power, part, descent):
    curve = FluidTautochrone(10.0**power, 0.9, 1.0)
    s = 10.0**part * (curve.descent_cusp if descent else -5.0 / max(curve.kappa, 1.0))
    height = float(curve.height(s))
    with mpmath.workdps(60):
        assert height == pytest.approx(float(exact(curve, mpmath.mpf(s))[0]), rel=1e-15)
    back = curve.arc_of_height(height, 'descent' if descent else 'ascent')
    assert float(back) == pytest.approx(s, rel=2e-15)


def test_without_a_fluid_it_is_the_cycloid():
    free, cycloid = FluidTautochrone(0.0, 1.0, 2.0), Cycloid(0.0, 1.0, 2.0)
    s = points(cycloid)
    for name in ('slope', 'slope_rate', 'height'):
        np.testing.assert_array_equal(getattr(free, name)(s), getattr(cycloid, name)(s))
    assert free.descent_cusp == -free.ascent_cusp == 2.0
    # a cycloid of f = 2 m is a circle's of 0.5 m: width to the cusp π/2, height 1
    assert float(abscissa(free, 2.0)) == pytest.approx(0.5 * math.pi, rel=1e-15)
    assert float(free.arc_of_height(1.0, 'ascent')) == pytest.approx(-2.0, rel=1e-15)


def test_beyond_each_cusp_the_curve_goes_on_as_its_mirror_image():
    top = chained(OIL, OIL.descent_cusp, 0)
    np.testing.assert_allclose(chained(OIL, OIL.descent_cusp, 1), top, rtol=1e-15)
    low = chained(OIL, OIL.ascent_cusp, 1)
    np.testing.assert_allclose(chained(OIL, OIL.ascent_cusp, 2), low, rtol=1e-15)
    width = abscissa(OIL, OIL.descent_cusp) - abscissa(OIL, OIL.ascent_cusp)
    moved = np.subtract(chained(OIL, 0.2, 2), chained(OIL, 0.2, 0))
    np.testing.assert_allclose(moved, [0.0, 2.0 * width], atol=1e-15)
    x, y = coordinates(OIL, 0.2)
    assert chained(OIL, 0.2, 1) == (x, pytest.approx(2.0 * top[1] - float(y), rel=1e-15))
    with pytest.raises(DescentError, match='not there'):
        chained(THICK, 0.01, 1)


@pytest.mark.parametrize('curve', [OIL, THICK, Cycloid(0.75, 0.9, 1.0)], ids=repr)
def test_the_outline_is_no_higher_than_the_descent(curve):
    level, height = fluid_outline(curve, 41)
    assert level.shape == height.shape == (81,)
    assert (level[40], height[40]) == (0.0, 0.0)
    assert np.all(np.diff(level) > 0.0)
    top = float(curve.height(curve.descent_cusp))
    assert height[-1] == top
    assert height.max() <= top * (1.0 + 1e-12)
    with pytest.raises(DescentError, match='points = 1'):
        fluid_outline(curve, 1)


@pytest.mark.parametrize(
    ('make', 'named'),
    [
        (lambda: FluidTautochrone(-0.1, 0.9, 1.0), 'kappa = -0.1'),
        (lambda: FluidTautochrone(math.nan, 0.9, 1.0), 'kappa = nan'),
        (lambda: FluidTautochrone(0.1, 0.0, 1.0), 'gamma = 0.0'),
        (lambda: Cycloid(0.1, 1.1, 1.0), 'gamma = 1.1'),
        (lambda: SymmetricCurve(0.1, 0.9, 0.0), 'pendulum_length = 0.0'),
        (lambda: FluidTautochrone(0.75, 0.9, 1.0, 1.0), 'friction = 1.0'),
        (lambda: FluidTautochrone(22.5, 0.1, 1.0, 0.45), 'less than 0.444'),
        (lambda: ActaCurve(0.4, 0.9, 1.0, 0.95), 'start = 0.95'),
        (lambda: ActaCurve(4.0, 0.9, 1.0, 0.5), 'its slope at 0.125 m'),
        (lambda: OIL.arc_of_height(-1e-9, 'descent'), 'height -1e-09 m'),
        (lambda: abscissa(OIL, 0.7), '0.687'),
        (lambda: radius_of_curvature(OIL, math.nan), 'arc nan m'),
        (lambda: abscissa(THICK, -math.inf), 'arc -inf m'),
    ],
)
def test_what_makes_no_curve_is_refused_with_its_limit(make, named):
    with pytest.raises(DescentError, match=named):
        make()


# Golden asks 1e-13, and the formulas lose a few roundings. R near a cusp is the square root of the
# gap to 1, which amplifies the rounding of s.
TIGHT, CURVATURE = 1e-15, 5e-15


def curve_of(entry):
    given = {key: item['value'] for key, item in entry['params'].items()}
    ratio, size = float(given['n_over_m']), float(given['a'])
    kappa = ratio / (2.0 * size) if given['shape'] == 'cylinder' else 3.0 * ratio / (8.0 * size)
    friction = float(given.get('mu', 0.0))
    return FluidTautochrone(kappa, 1.0 - ratio, float(given['f']), friction), given


def close(actual, expected, tolerance=TIGHT):
    np.testing.assert_allclose(actual, float(expected), rtol=tolerance, atol=1e-300)


@pytest.mark.parametrize('entry', [*entries('B16-30-curve'), *entries('B35-friction')])
def test_height_slope_and_arc(entry):
    curve, given = curve_of(entry)
    s, expected = float(given['s']), entry['expected']
    close(curve.height(s), expected['x'])
    close(curve.slope(s), expected['dx_ds'])
    side = 'descent' if s > curve.lowest_arc else 'ascent'
    close(curve.arc_of_height(float(expected['x']), side), s)


@pytest.mark.parametrize('entry', entries('B16-30-curve'))
def test_curve(entry):
    curve, given = curve_of(entry)
    s, expected = float(given['s']), entry['expected']
    close(1.0 / curve.slope(s), expected['slope_p_ds_dx'])
    close(abscissa(curve, s), expected['y'])
    close(radius_of_curvature(curve, s), expected['R'], CURVATURE)


@pytest.mark.parametrize('entry', entries('B26-28-cusp'))
def test_cusps(entry):
    curve, _ = curve_of(entry)
    expected = entry['expected']
    close(curve.kappa, expected['kappa_per_m'])
    close(curve.gamma, expected['gamma'])
    close(curve.beta, expected['beta'])
    close(curve.descent_cusp, expected['s_cusp'])
    close(curve.height(curve.descent_cusp), expected['x_cusp'])
    close(abscissa(curve, curve.descent_cusp), expected['y_cusp'])
    close(radius_of_curvature(curve, 0.0), expected['R_at_A'])
    if expected['t_cusp_ascent'].startswith('none'):
        assert curve.ascent_cusp == -math.inf
    else:
        close(-curve.ascent_cusp, expected['t_cusp_ascent'])
        close(curve.height(curve.ascent_cusp), expected['u_cusp_ascent'])
