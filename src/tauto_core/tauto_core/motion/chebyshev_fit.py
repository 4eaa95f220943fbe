"""Chebyshev series of functions that are known at the Chebyshev nodes of the first kind."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.samples import FloatArray


def nodes(count: int) -> FloatArray:
    """Return the nodes x_k = cos(π (k + ½)/n), k = 0 … n − 1, which fall from 1 to −1, (n,)."""
    return np.asarray(np.cos(math.pi / count * (np.arange(count) + 0.5)))


def coefficients(values: FloatArray) -> FloatArray:
    """Return the coefficients c_j of the polynomials Σ c_j T_j(x) with given values, (…, n).

    c_j = (2/n) Σ_k values_k cos(πj (k + ½)/n), half of that for j = 0. This discrete cosine
    transform is computed as the Fourier transform of the values and their mirror image.

    Args:
        values: values at `nodes(n)`, (…, n).
    """
    count = values.shape[-1]
    mirrored = np.concatenate([values, values[..., ::-1]], axis=-1)
    half_a_node = np.exp(-0.5j * math.pi / count * np.arange(count))
    found = (np.fft.rfft(mirrored)[..., :count] * half_a_node).real / count
    found[..., 0] *= 0.5
    return np.ascontiguousarray(found)
