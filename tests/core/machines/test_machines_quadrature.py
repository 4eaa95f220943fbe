"""The order of the quadratures.

Gauss's rule of n nodes has order 2n in the width of a panel. For a function that is analytic
beyond its ends it is spectral in n: twice the nodes give about twice the digits, down to rounding.
A root that a substitution leaves at an end has its own, lower order.
"""

import importlib
import math

import numpy as np
import pytest

from tauto_core.curves import Cycloid, numerics

outline = importlib.import_module('tauto_core.curves.fluid')

ROUNDING = 2e-14
"""Rounding error of sums of about sixty terms, and of the terms."""


def spectral(errors):
    """Whether errors at n, 2n, 4n … nodes gain four tenths as many digits at each doubling."""
    last = errors[0]
    for error in errors[1:]:
        if error > max(last**1.4, ROUNDING):
            return False
        last = max(error, ROUNDING)
    return errors[0] > 100 * ROUNDING and errors[-1] <= ROUNDING


def fixed(nodes):
    """Return an `integrate` of one panel of Gauss's rule, without halving."""
    roots, weights = np.polynomial.legendre.leggauss(nodes)

    def integrate(function, lower, upper):
        half = 0.5 * (upper - lower)[:, None]
        values = function(lower[:, None] + half * (1.0 + roots))
        return (half * values) @ weights

    return integrate


NODES = 24
LEFT_OUT = math.factorial(NODES) ** 4 / ((2 * NODES + 1) * math.factorial(2 * NODES) ** 2)
"""∫ x⁴⁸ over an interval of length 1, less the rule's sum."""


def test_a_panel_is_of_order_48():
    """∫ cos x over widths w about 0: the rule errs by w⁴⁸ LEFT_OUT/48!, by the width.

    What follows has the same sign and takes e^{−w²/792}: the derivative's mean over the kernel.
    """
    width = np.array([44.0, 45.0, 46.0, 48.0, 50.0])
    exact = 2.0 * np.sin(0.5 * width)
    errors = (exact - numerics.gauss_sums(np.cos, -0.5 * width, width)) / width
    expected = LEFT_OUT / math.factorial(48) * width**48 * np.exp(-(width**2) / 792.0)
    np.testing.assert_allclose(errors, expected, rtol=0.1)
    assert np.all(errors > 1e-12)
    order = np.diff(np.log(errors)) / np.diff(np.log(width))
    np.testing.assert_allclose(order, 48.0 - width[1:] ** 2 / 396.0, atol=1.0)


def test_a_root_left_in_is_not_spectral():
    """∫ √(1 − x²) dx has ends of order 3."""
    errors = []
    for nodes in (2, 4, 8, 16, 32, 64):
        found = fixed(nodes)(lambda x: np.sqrt(1 - x * x), np.zeros(1), np.ones(1))[0]
        errors.append(abs(found * 4.0 / math.pi - 1.0))
    assert not spectral(errors)
    assert errors[-2] / errors[-1] == pytest.approx(8.0, rel=0.1)


@pytest.mark.parametrize('share', [0.5, 0.999])
def test_the_outline_of_a_curve_is_spectral(share, monkeypatch):
    """Of a cycloid ∫ √(1 − (s/f)²) ds is known. A substitution removes the root at its cusp."""
    curve = Cycloid(0.0, 1.0, 1.0)
    exact = 0.5 * (share * math.sqrt(1.0 - share * share) + math.asin(share))
    errors = []
    for nodes in (2, 4, 8, 16):
        rule = np.polynomial.legendre.leggauss(nodes)
        with monkeypatch.context() as patched:
            patched.setattr(numerics, 'gauss_rule', lambda rule=rule: rule)
            errors.append(abs(float(outline.abscissa(curve, share)) / exact - 1.0))
    assert spectral(errors), errors
