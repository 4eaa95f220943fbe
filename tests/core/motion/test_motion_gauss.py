"""The constants of the collocation, against 50 digits."""

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


def roots_of(stages):
    starts = (2 * c - 1 for c in gauss_constants(stages).nodes)
    roots = [mp.findroot(lambda x: mp.legendre(stages, x), start) for start in starts]
    assert all(b - a > 0.04 for a, b in pairwise(roots))
    return roots


def legendre_integral(n, end):
    """∫ of P_n from −1."""
    if n == 0:
        return end + 1
    return (mp.legendre(n + 1, end) - mp.legendre(n - 1, end)) / (2 * n + 1)


def projections(roots):
    """Legendre coefficients of the Lagrange polynomials: Gauss quadrature is exact here."""
    s = len(roots)
    weights = [2 / ((1 - x * x) * mp.diff(lambda y: mp.legendre(s, y), x) ** 2) for x in roots]
    return [
        [
            (2 * n + 1) / mp.mpf(2) * w * mp.legendre(n, x)
            for x, w in zip(roots, weights, strict=True)
        ]
        for n in range(s)
    ]


@STAGES
def test_the_table_holds_the_constants_derived_in_decimal_arithmetic(stages):
    for stored, exact in zip(gauss_constants(stages), derived(stages), strict=True):
        np.testing.assert_array_equal(stored, exact, strict=True)


@STAGES
def test_nodes_and_weights_are_correctly_rounded(stages):
    roots, constants = roots_of(stages), gauss_constants(stages)
    assert constants.nodes.tolist() == [float((x + 1) / 2) for x in roots]
    # ∫ℓ_j is half its first Legendre coefficient's integral over [-1, 1]
    assert constants.weights.tolist() == [float(row) for row in projections(roots)[0]]


@STAGES
def test_the_integrals_to_the_nodes_are_correctly_rounded(stages):
    roots = roots_of(stages)
    rows = projections(roots)
    for j in range(stages):
        exact = [
            mp.fsum(rows[n][j] * legendre_integral(n, end) for n in range(stages)) / 2
            for end in roots
        ]
        assert gauss_constants(stages).columns[j].tolist() == [float(value) for value in exact]


@STAGES
def test_folded_integrals_unfold_to_the_integrals_to_the_nodes(stages):
    """Of nodes j and j' and their mirror images: the rule is symmetric."""
    constants, h = gauss_constants(stages), stages // 2
    shared = constants.folded[h, :h]
    assert constants.folded[h, h:].tolist() == shared.tolist()
    assert (2.0 * shared).tolist() == constants.weights[:h].tolist()
    for j in range(h):
        p, q = constants.folded[j, :h], constants.folded[j, h:]
        for row, sign in ((j, 1.0), (-1 - j, -1.0)):
            wanted = constants.columns[row]
            near, far = shared[j] + (p + sign * q), shared[j] - (p - sign * q)
            sizes = np.abs(p) + np.abs(q) + shared[j]
            assert np.all(np.abs(near - wanted[:h]) < 2.0**-51 * sizes)
            assert np.all(np.abs(far[::-1] - wanted[h:]) < 2.0**-51 * sizes)


@STAGES
def test_the_projection_gives_legendre_coefficients(stages):
    exact = [[float(value) for value in row] for row in projections(roots_of(stages))]
    assert gauss_constants(stages).projection.tolist() == exact


@STAGES
def test_the_powers_sum_to_the_integral(stages):
    """x Σ_n G_n t^n, t = 2x − 1, of each Lagrange polynomial, at places that are no nodes.

    Sixteen coefficients of up to 950 are rounded once each, and cancel.
    """
    rows, powers = projections(roots_of(stages)), gauss_constants(stages).integral
    for t in map(mp.mpf, (-0.9, -0.35, 0.0, 0.6, 1.0)):
        for j in range(stages):
            found = (t + 1) / 2 * mp.fsum(mp.mpf(powers[n, j]) * t**n for n in range(stages))
            exact = mp.fsum(rows[n][j] * legendre_integral(n, t) for n in range(stages)) / 2
            assert abs(found - exact) < stages * abs(powers[:, j]).max() * mp.mpf(2) ** -53
