"""The reading of the dial, with whole half turns and the fraction kept apart."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.samples import NS_PER_S, FloatArray, IntArray


def dial_ns(half_turns: IntArray, fraction: FloatArray, nominal_period_s: float) -> IntArray:
    """Return the reading [ns] since the dial was set: nominal_period · φ / 2π (theory E4).

    The whole part is counted in integers, so long runs lose no resolution.

    Args:
        half_turns: whole half turns of the phase, (n,).
        fraction: the remaining fraction, 0 ≤ fraction < 1, (n,).
        nominal_period_s: time by which the dial advances in a full turn of the phase [s].
    """
    half_period = 0.5 * nominal_period_s * NS_PER_S
    whole = math.floor(half_period)
    rest = half_period - whole
    # Blocks of 2^20 half turns keep the product with the rest exact to far below 1 ns.
    blocks, left = np.divmod(half_turns, 2**20)
    block_ns = rest * 2**20
    whole_block = math.floor(block_ns)
    small = blocks * (block_ns - whole_block) + left * rest + fraction * half_period
    return np.asarray(
        half_turns * whole + blocks * whole_block + np.rint(small).astype(np.int64), np.int64
    )
