"""Compiled sums of harmonics; import on first use only (numba)."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tauto_core.samples import FloatArray

RADIANS_PER_UNIT = 2.0 * math.pi / 2.0**64


@njit(cache=True, nogil=True)
def sum_blocks(
    first_block: int,
    phase: NDArray[np.uint64],
    increment: NDArray[np.uint64],
    amplitude: FloatArray,
    omega: FloatArray,
    cosine: FloatArray,
    sine: FloatArray,
    value: FloatArray | None,
    rate: FloatArray | None,
    acceleration: FloatArray | None,
) -> None:
    """Add sum a cos(phi) and its first and second derivative over whole blocks.

    phi = phi_b + theta_j: phi_b at the start of block b, exact in 2^-64 turns; theta_j of the
    j-th sample of any block, from a table. Outputs that are None are not in the compiled code.

    Args:
        first_block: index of the first block, counted from the start of the scene, >= 0.
        phase: phase at the start of the scene [2^-64 turns], shape (n,).
        increment: advance of the phase in a block [2^-64 turns], shape (n,).
        amplitude: a, shape (n,).
        omega: angular frequency [rad/s], shape (n,).
        cosine: cos(theta_j), shape (n, block).
        sine: sin(theta_j), shape (n, block).
        value: output, shape (blocks, block), or None.
        rate: output, likewise.
        acceleration: output, likewise.
    """
    out = value if value is not None else acceleration
    for b in range(out.shape[0]):  # type: ignore[union-attr]
        for i in range(phase.shape[0]):
            turns = phase[i] + np.uint64(first_block + b) * increment[i]
            start = np.int64(turns) * RADIANS_PER_UNIT
            p = amplitude[i] * math.cos(start)
            q = amplitude[i] * math.sin(start)
            w = omega[i]
            ww = w * w
            cosine_i = cosine[i]
            sine_i = sine[i]
            for j in range(cosine_i.shape[0]):
                v = p * cosine_i[j] - q * sine_i[j]
                if value is not None:
                    value[b, j] += v
                if rate is not None:
                    rate[b, j] -= w * (p * sine_i[j] + q * cosine_i[j])
                if acceleration is not None:
                    acceleration[b, j] -= ww * v


@njit(cache=True, nogil=True)
def fit_windows(
    columns: FloatArray,
    values: FloatArray,
    rates: FloatArray | None,
    length_s: FloatArray,
    first: NDArray[np.int64],
    rows: NDArray[np.int64],
    result: FloatArray,
) -> None:
    """Fill rows with the coefficients of the polynomials through windows of samples.

    Row r is columnsᵀ · (values, then rates · length, from sample first[r] on), summed in the order
    of the samples: the bits do not depend on the batch.

    Args:
        columns: transposed matrix from samples to coefficients, shape (k, k).
        values: the channel, shape (m,).
        rates: its time derivative [1/s], shape (m,), or None.
        length_s: length of each row's piece [s], shape (n,).
        first: first sample of each row's window, shape (n,).
        rows: indices of the rows to fill.
        result: output, shape (n, k).
    """
    width = columns.shape[0]
    points = width if rates is None else width // 2
    for r in rows:
        for j in range(width):
            result[r, j] = 0.0
        for i in range(points):
            value = values[first[r] + i]
            for j in range(width):
                result[r, j] += columns[i, j] * value
        if rates is not None:
            for i in range(points):
                value = rates[first[r] + i] * length_s[r]
                for j in range(width):
                    result[r, j] += columns[points + i, j] * value
