"""Euler's curve in a fluid against the golden numbers (50-digit arithmetic of another program)."""

import math

import numpy as np
import pytest
from golden_numbers import entries

from tauto_core.curves import FluidTautochrone
from tauto_core.curves.fluid import abscissa, radius_of_curvature

# Golden asks 1e-13; the formulas lose a few roundings. R near a cusp is the square root of what is
# left to 1, by which the rounding of s grows.
TIGHT, CURVATURE = 1e-15, 5e-15


def curve_of(entry):
    given = {key: item['value'] for key, item in entry['params'].items()}
    ratio, size = float(given['n_over_m']), float(given['a'])
    kappa = ratio / (2.0 * size) if given['shape'] == 'cylinder' else 3.0 * ratio / (8.0 * size)
    friction = float(given.get('mu', 0.0))
    return FluidTautochrone(kappa, 1.0 - ratio, float(given['f']), friction), given


def close(actual, expected, tolerance=TIGHT):
    np.testing.assert_allclose(actual, float(expected), rtol=tolerance, atol=1e-300)


@pytest.mark.parametrize('entry', entries('B16-30-curve'))
def test_curve(entry):
    curve, given = curve_of(entry)
    s, expected = float(given['s']), entry['expected']
    close(curve.height(s), expected['x'])
    close(curve.slope(s), expected['dx_ds'])
    close(1.0 / curve.slope(s), expected['slope_p_ds_dx'])
    close(abscissa(curve, s), expected['y'])
    close(radius_of_curvature(curve, s), expected['R'], CURVATURE)
    close(curve.arc_of_height(float(expected['x']), 'descent' if s > 0 else 'ascent'), s)


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


@pytest.mark.parametrize('entry', entries('B35-friction'))
def test_friction(entry):
    curve, given = curve_of(entry)
    s, expected = float(given['s']), entry['expected']
    close(curve.height(s), expected['x'])
    close(curve.slope(s), expected['dx_ds'])
    side = 'descent' if s > curve.lowest_arc else 'ascent'
    close(curve.arc_of_height(float(expected['x']), side), s)
