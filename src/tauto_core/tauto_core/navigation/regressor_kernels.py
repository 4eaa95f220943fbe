"""The running mean of a signal, compiled; import on first use only."""

from tauto_core.kernels import entry
from tauto_core.samples import FloatArray


@entry
def followed(value: FloatArray, share: FloatArray, mean: float, out: FloatArray) -> None:
    """Fill the running mean of a value, which becomes m + c (v - m) at each sample.

    Args:
        value: v, shape (n,).
        share: c of each sample, 0 to 1, shape (n,).
        mean: m before the first sample.
        out: output, shape (n,).
    """
    for i in range(len(value)):
        mean = mean + share[i] * (value[i] - mean)
        out[i] = mean
