"""The coefficients of the rate equation as further states of the drift filter (theory E11).

The rate of the dial is y + Σ k_j x_j, with regressors x_j that an inertial sensor measures and
constant coefficients k_j. Over a time τ in which the integrals of the regressors grow by ΔX_j, the
transition of the clock (`kalman`) has these in the row of the offset:

    x' = x + τ y + τ²/2 d + Σ ΔX_j k_j,   k_j' = k_j.

As in `kalman`, formulas are sums and products in a fixed order, the same for floats and arrays.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations_with_replacement
from typing import Any, NamedTuple


class Coefficient(NamedTuple):
    """Prior of a coefficient, before any observation.

    Attributes:
        name: name of its covariate.
        value: expected k [1].
        sigma: its standard deviation [1], > 0.
    """

    name: str
    value: float
    sigma: float


def pairs(size: int) -> list[tuple[int, int]]:
    """Return the indices of a covariance that are kept: its upper triangle, row by row."""
    return list(combinations_with_replacement(range(size), 2))


def prediction(clock: int, size: int) -> Callable[..., tuple[Any, ...]]:
    """Return the prediction step of `size` states, of which the first `clock` are the clock's.

    Its arguments are the numbers (means, then the `pairs` of the covariance), the time t [s], q1,
    q2, q3 of `kalman`, and the growth of each integral [s]. It returns the numbers after that
    time.
    """
    kept = pairs(size)

    def ahead(
        now: tuple[Any, ...], t: Any, q1: float, q2: float, q3: float, *gained: Any
    ) -> tuple[Any, ...]:
        h = 0.5 * t * t
        ageing = clock == 3
        moved = {
            0: [(1, t), *[(2, h)] * ageing, *zip(range(clock, size), gained, strict=True)],
            1: [(2, t)] * ageing,
        }
        mean, p = list(now[:size]), _square(now, size)
        for row, terms in moved.items():
            for column, factor in terms:
                mean[row] = mean[row] + factor * mean[column]
                p[row] = [a + factor * b for a, b in zip(p[row], p[column], strict=True)]
        for row, terms in moved.items():
            for above in range(row + 1):
                for column, factor in terms:
                    p[above][row] = p[above][row] + factor * p[above][column]
        p[0][0] = p[0][0] + t * (q1 + t * t * (q2 / 3.0 + t * t * (q3 / 20.0)))
        p[0][1] = p[0][1] + h * (q2 + h * (q3 / 2.0))
        p[1][1] = p[1][1] + t * (q2 + t * t * (q3 / 3.0))
        if ageing:
            p[0][2] = p[0][2] + h * t * (q3 / 3.0)
            p[1][2] = p[1][2] + h * q3
            p[2][2] = p[2][2] + t * q3
        return (*mean, *(p[i][j] for i, j in kept))

    return ahead


def correction(size: int) -> Callable[..., tuple[float, ...]]:
    """Return the update of `size` states by an observed phase, in Joseph's form.

    Its arguments are the numbers predicted, the innovation ν, its variance s = P_xx + r, and r.
    """
    kept = pairs(size)

    def corrected(
        now: tuple[float, ...], innovation: float, s: float, r: float
    ) -> tuple[float, ...]:
        p = _square(now, size)
        gain = [each / s for each in p[0]]
        # 1 - P_xx/s would lose digits for a precise observation
        g = r / s
        left = [g * each for each in p[0]]

        def less(i: int, j: int) -> Any:
            if i == 0:
                return g * left[j]
            return (p[i][j] - gain[i] * p[0][j]) - gain[j] * left[i]

        return (
            *(now[i] + gain[i] * innovation for i in range(size)),
            *(less(i, j) + gain[i] * gain[j] * r for i, j in kept),
        )

    return corrected


def _square(now: tuple[Any, ...], size: int) -> list[list[Any]]:
    """Return the whole covariance, row by row."""
    whole: list[list[Any]] = [[0.0] * size for _ in range(size)]
    for (i, j), number in zip(pairs(size), now[size:], strict=True):
        whole[i][j] = whole[j][i] = number
    return whole
