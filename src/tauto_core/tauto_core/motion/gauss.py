"""Gauss–Legendre collocation with 8 stages on [0, 1]: order 16, symmetric, symplectic.

The stage derivatives f(c_j) determine a polynomial of degree 7, written in Legendre polynomials
of 2x − 1 so that it is evaluated without cancellation:

    f(x) = Σ_n F_n P_n(2x − 1),    F = PROJECTION · (f(c_1) … f(c_8)).

Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, II.7;
J. C. Butcher, Implicit Runge–Kutta processes, Math. Comp. 18 (1964).
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre

STAGES = 8
_roots, _weights = legendre.leggauss(STAGES)
_values = legendre.legvander(_roots, STAGES)
_degree = 2 * np.arange(STAGES) + 1

NODES = 0.5 * (_roots + 1.0)
"""The nodes c_i."""

WEIGHTS = 0.5 * _weights
"""The weights b_i."""

PROJECTION = 0.5 * _degree[:, None] * (_weights * _values[:, :STAGES].T)
"""Legendre coefficients from the values at the nodes, shape (8, 8)."""

_integrals = np.empty((STAGES, STAGES))
_integrals[:, 0] = 0.5 * (_roots + 1.0)
_integrals[:, 1:] = 0.5 * (_values[:, 2:] - _values[:, : STAGES - 1]) / _degree[1:]

COLUMNS = np.ascontiguousarray((_integrals @ PROJECTION).T)
"""COLUMNS[j, i] = a_ij = ∫_0^{c_i} ℓ_j."""
