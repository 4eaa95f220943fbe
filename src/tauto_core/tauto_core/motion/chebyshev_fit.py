"""Chebyshev coefficients of a function that is known at Chebyshev's nodes."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.samples import FloatArray


def nodes(count: int) -> FloatArray:
    """Return cos(π (k + ½)/n), from nearly 1 to nearly −1, (n,)."""
    return np.asarray(np.cos(math.pi / count * (np.arange(count) + 0.5)))


def coefficients(values: FloatArray) -> FloatArray:
    """Return the coefficients of the interpolating polynomials, (…, n).

    A discrete cosine transform, as the Fourier transform of the values and their mirror image.

    Args:
        values: the values at `nodes(n)`, (…, n).
    """
    count = values.shape[-1]
    mirrored = np.concatenate([values, values[..., ::-1]], axis=-1)
    turned = np.exp(-0.5j * math.pi / count * np.arange(count))
    found = (np.fft.rfft(mirrored)[..., :count] * turned).real / count
    found[..., 0] *= 0.5
    return np.ascontiguousarray(found)
