"""The periodic swing of a wheel and its thread together: Fourier series and Newton's method.

Both angles start at rest and pass the middle together, so their series have odd cosines only:
ψ = Σ a_k cos(2k + 1)ωt, δ = Σ b_k cos(2k + 1)ωt. The unknowns are determined by the equations of
motion at as many instants of a quarter swing, and by Σ a_k = A. The series converge
geometrically, so the period is accurate to rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tauto_core.samples import FloatArray
from tauto_core.scene.errors import TautoError

FEWEST_TERMS, MOST_TERMS = 8, 128
TAIL = 2.0**-46
"""Size of the last coefficients over the amplitude at which a series is complete."""

SETTLED = 2.0**-48
_ITERATIONS = 40
_STRIDE = 0.25
_IMAGINARY = 1e-30

Accelerations = Callable[
    [np.ndarray, np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]
]


class SwingError(TautoError):
    """A swing for which no common periodic motion of wheel and thread was found."""


class CommonSwing(NamedTuple):
    """A periodic swing, at instants of a quarter of it.

    Attributes:
        period: [s].
        psi: ψ of the wheel [rad], (n,).
        delta: δ of the thread [rad], (n,).
        psi_rate: ψ̇ [rad/s], (n,).
        delta_rate: δ̇ [rad/s], (n,).
    """

    period: float
    psi: FloatArray
    delta: FloatArray
    psi_rate: FloatArray
    delta_rate: FloatArray


def common_swing(
    accelerations: Accelerations, amplitude: float, frequency: float, share: float
) -> CommonSwing:
    """Return the periodic swing of an amplitude, continued from a mode of small swings.

    Args:
        accelerations: function that gives ψ̈ and δ̈ from (ψ, δ, ψ̇, δ̇), complex arrays.
        amplitude: amplitude of ψ [rad], > 0.
        frequency: frequency of the mode [rad/s].
        share: δ/ψ in the mode.

    Raises:
        SwingError: no such swing is found, or it takes more than 128 terms.
    """
    terms = FEWEST_TERMS
    while terms <= MOST_TERMS:
        found = _continued(accelerations, amplitude, frequency, share, terms)
        if found is None:
            break
        if np.max(np.abs(found[[terms - 2, terms - 1, -3, -2]])) <= TAIL * amplitude:
            angles, rates, _ = _along(found[None], terms)
            parts = [part[0] for part in (*angles, *rates)]
            return CommonSwing(math.tau / float(found[-1]), *parts)
        terms *= 2
    raise SwingError(
        f'at {amplitude:.6g} rad wheel and thread have no common swing that continues the mode of '
        'small swings: the thread is near a resonance with the wheel, or goes slack. Use a '
        'smaller amplitude, a longer thread or a lighter weight'
    )


def _continued(
    accelerations: Accelerations, amplitude: float, frequency: float, share: float, terms: int
) -> FloatArray | None:
    """Return a_k, b_k, ω at the amplitude, continued from small swings; None if that fails."""
    unknowns = np.zeros(2 * terms + 1)
    unknowns[-1] = frequency
    steps = max(1, math.ceil(amplitude / _STRIDE))
    unknowns[0], unknowns[terms] = amplitude / steps, share * amplitude / steps
    for step in range(1, steps + 1):
        reached = amplitude * step / steps
        unknowns[: 2 * terms] *= reached / np.sum(unknowns[:terms])
        found = _newton(accelerations, reached, unknowns, terms)
        if found is None:
            return None
        unknowns = found
    return unknowns


def _newton(
    accelerations: Accelerations, amplitude: float, unknowns: FloatArray, terms: int
) -> FloatArray | None:
    scale = np.append(np.full(2 * terms, amplitude), unknowns[-1])
    before = math.inf
    for _ in range(_ITERATIONS):
        residual, matrix = _linearised(accelerations, amplitude, unknowns, terms)
        if not np.all(np.isfinite(residual)):
            return None
        change = np.linalg.solve(matrix, residual)
        unknowns = unknowns - change
        moved = float(np.max(np.abs(change / scale)))
        if moved <= SETTLED or (moved <= 2.0**-40 and moved >= 0.5 * before):
            return unknowns
        if not math.isfinite(moved) or not unknowns[-1] > 0.0:
            return None
        before = moved
    return None


def _linearised(
    accelerations: Accelerations, amplitude: float, unknowns: FloatArray, terms: int
) -> tuple[FloatArray, FloatArray]:
    """Return the residuals of the equations over ω² and their derivatives, by complex steps.

    All columns are computed together.
    """
    count = len(unknowns)
    shifted = np.broadcast_to(unknowns.astype(complex), (count, count)).copy()
    steps = _IMAGINARY * np.maximum(np.abs(unknowns), 1.0)
    shifted[np.arange(count), np.arange(count)] += 1j * steps
    left = _left(accelerations, amplitude, shifted, terms)
    return left[0].real, (left.imag / steps[:, None]).T


def _left(
    accelerations: Accelerations, amplitude: float, unknowns: np.ndarray, terms: int
) -> np.ndarray:
    angles, rates, bends = _along(unknowns, terms)
    pushed = accelerations(angles[0], angles[1], rates[0], rates[1])
    omega = unknowns[:, -1:]
    rest = [bend - push / omega**2 for bend, push in zip(bends, pushed, strict=True)]
    size = np.sum(unknowns[:, :terms], axis=1, keepdims=True)
    return np.hstack([*rest, size - amplitude])


def _along(
    unknowns: np.ndarray, terms: int
) -> tuple[list[np.ndarray], list[np.ndarray], list[np.ndarray]]:
    """Return ψ and δ, their rates over ω and second derivatives over ω², each (m, n)."""
    orders = 2.0 * np.arange(terms) + 1.0
    phases = 0.5 * math.pi * (np.arange(terms) + 0.5) / terms
    cosines, sines = np.cos(np.outer(orders, phases)), np.sin(np.outer(orders, phases))
    omega = unknowns[:, -1:]
    series = unknowns[:, :terms], unknowns[:, terms:-1]
    angles = [part @ cosines for part in series]
    rates = [-omega * ((orders * part) @ sines) for part in series]
    bends = [-((orders * orders * part) @ cosines) for part in series]
    return angles, rates, bends
