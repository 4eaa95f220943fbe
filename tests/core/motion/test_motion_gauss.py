"""The constants of the collocation, against 40 digits."""

from itertools import pairwise

import pytest
from mpmath import mp

from tauto_core.motion.gauss import COLUMNS, NODES, PROJECTION, STAGES, WEIGHTS


@pytest.fixture
def roots():
    with mp.workdps(40):
        legendre = [mp.findroot(lambda x: mp.legendre(STAGES, x), 2 * c - 1) for c in NODES]
        assert all(b - a > 0.1 for a, b in pairwise(legendre))
        yield legendre


def lagrange(roots, j, x):
    others = (root for k, root in enumerate(roots) if k != j)
    return mp.fprod((x - root) / (roots[j] - root) for root in others)


def test_nodes_and_weights_are_correctly_rounded(roots):
    assert NODES.tolist() == [float((x + 1) / 2) for x in roots]
    weights = [mp.quad(lambda x, j=j: lagrange(roots, j, x), [-1, 1]) / 2 for j in range(STAGES)]
    assert WEIGHTS.tolist() == [float(weight) for weight in weights]


def test_the_integrals_to_the_nodes_are_correctly_rounded(roots):
    for j in range(STAGES):
        exact = [mp.quad(lambda x, j=j: lagrange(roots, j, x), [-1, end]) / 2 for end in roots]
        assert COLUMNS[j].tolist() == [float(value) for value in exact]


def test_the_projection_gives_legendre_coefficients(roots):
    for n in range(STAGES):
        for j in range(STAGES):

            def product(x, j=j, n=n):
                return lagrange(roots, j, x) * mp.legendre(n, x)

            exact = (2 * n + 1) * mp.quad(product, [-1, 1]) / 2
            assert PROJECTION[n, j] == float(exact)
