"""The constants of the collocation, against 50 digits and against their definition."""

from itertools import pairwise

import numpy as np
import pytest
from gauss_derivation import derived
from mpmath import mp

from tauto_core.motion.gauss_step import gauss_constants

STAGES = pytest.mark.parametrize('stages', [8, 16])


@pytest.fixture(autouse=True)
def digits():
    with mp.workdps(50):
        yield


@STAGES
def test_the_table_holds_the_constants_derived_in_decimals(stages):
    for stored, exact in zip(gauss_constants(stages), derived(stages), strict=True):
        np.testing.assert_array_equal(stored, exact, strict=True)


@STAGES
def test_the_constants_integrate_legendre_polynomials(stages):
    """Nodes are the roots of P_s, and each rule is exact for P_n, n < s, to its roundings."""
    constants = gauss_constants(stages)
    starts = [2 * c - 1 for c in constants.nodes]
    roots = [mp.findroot(lambda x: mp.legendre(stages, x), start) for start in starts]
    assert all(b - a > 0.04 for a, b in pairwise(roots))
    assert constants.nodes.tolist() == [float((x + 1) / 2) for x in roots]

    def integral(n, end):
        """½∫ of P_n from −1."""
        if n == 0:
            return (end + 1) / 2
        return (mp.legendre(n + 1, end) - mp.legendre(n - 1, end)) / (4 * n + 2)

    def check(row, values, exact):
        terms = [mp.mpf(float(c)) * value for c, value in zip(row, values, strict=True)]
        assert abs(mp.fsum(terms) - exact) < stages * max(map(abs, terms)) * mp.mpf(2) ** -53

    for n in range(stages):
        at_nodes = [mp.legendre(n, x) for x in roots]
        check(constants.weights, at_nodes, integral(n, 1))
        for i, end in enumerate(roots):
            check(constants.columns[:, i], at_nodes, integral(n, end))
            check(constants.projection[i], at_nodes, i == n)
        powers = [mp.fdot(row, at_nodes) for row in constants.integral.tolist()]
        for t in map(mp.mpf, (-0.9, -0.35, 0.0, 0.6, 1.0)):
            found = (t + 1) / 2 * mp.fsum(g * t**k for k, g in enumerate(powers))
            size = np.abs(constants.integral).max()
            assert abs(found - integral(n, t)) < stages**2 * size * mp.mpf(2) ** -53
