"""Estimates at many instants as vectors and matrices, for use outside the filter's steps."""

from __future__ import annotations

import numpy as np

from tauto_core.navigation.coefficients import pairs
from tauto_core.navigation.kalman import Estimate, covariances, estimate_of
from tauto_core.samples import FloatArray


def means(known: Estimate[FloatArray], coefficients: tuple[str, ...]) -> FloatArray:
    """Return the means of x, y, d and the coefficients, (n, 3 + c)."""
    return np.column_stack([getattr(known, name) for name in ('x', 'y', 'd', *coefficients)])


def covariance(known: Estimate[FloatArray], coefficients: tuple[str, ...]) -> FloatArray:
    """Return P of each instant, (n, 3 + c, 3 + c)."""
    names = ('x', 'y', 'd', *coefficients)
    p = np.empty((len(known.x), len(names), len(names)))
    for (i, j), field in zip(pairs(len(names)), covariances(names), strict=True):
        p[:, i, j] = p[:, j, i] = getattr(known, field)
    return p


def estimate(
    mean: FloatArray, p: FloatArray, coefficients: tuple[str, ...]
) -> Estimate[FloatArray]:
    """Return the estimate with these means, (n, 3 + c), and covariances, (n, 3 + c, 3 + c)."""
    names = ('x', 'y', 'd', *coefficients)
    upper = zip(pairs(len(names)), covariances(names), strict=True)
    return estimate_of(coefficients)(
        **dict(zip(names, mean.T, strict=True)), **{field: p[:, i, j] for (i, j), field in upper}
    )
