"""The constants of Gauss–Legendre collocation, derived in decimal arithmetic.

`python tests/core/motion/gauss_derivation.py` writes the table that `motion.gauss_step` reads.
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from pathlib import Path
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from tauto_core.motion import gauss_step
from tauto_core.motion.gauss_step import Gauss
from tauto_core.motion.lanes import SIZE, WIDE_SIZE

DIGITS = 50
"""Digits of the decimal arithmetic: all constants are rounded once, at the end."""


def _polynomials(x: Any, stages: int) -> Any:
    """Return P_0 … P_s at x, (s + 1, n), by their recurrence."""
    rows = [0 * x + 1, x]
    for n in range(1, stages):
        rows.append(((2 * n + 1) * x * rows[n] - n * rows[n - 1]) / (n + 1))
    return np.array(rows)


def _powers(stages: int) -> Any:
    """Return the coefficients of ∫ P_n(2x − 1) / x, (s, s): [j, n] of t^j.

    ∫ from −1 to t is (P_n+1 − P_n−1)/(2n + 1), half that in x, and divided by x = (1 + t)/2.
    """
    nothing = [Decimal(0)] * (stages + 1)
    series = [[Decimal(1), *nothing[1:]], [Decimal(0), Decimal(1), *nothing[2:]]]
    for n in range(1, stages):
        raised = [Decimal(0), *series[n][:-1]]
        pairs = zip(raised, series[n - 1], strict=True)
        series.append([((2 * n + 1) * a - n * b) / (n + 1) for a, b in pairs])
    before = [-Decimal(1), *nothing[1:]], *series
    columns = []
    for n in range(stages):
        pairs = zip(series[n + 1], before[n], strict=True)
        integral = [(a - b) / (2 * n + 1) for a, b in pairs]
        left, column = Decimal(0), []
        for j in range(stages, 0, -1):
            left = integral[j] - left
            column.append(left)
        columns.append(column[::-1])
    return np.array(columns).T


def _folded(columns: Any, weights: Any) -> Any:
    """Return `Gauss.folded`."""
    half = len(weights) // 2
    near, far = columns[:half, :half], columns[-1 : -half - 1 : -1, :half]
    shared = weights[:half] / 2
    rows = np.hstack([(near + far) / 2 - shared[:, None], (near - far) / 2])
    return np.vstack([rows, np.tile(shared, 2)])


def derived(stages: int) -> Gauss:
    """Return the constants, each correctly rounded."""
    with localcontext() as context:
        context.prec = DIGITS
        roots = np.array([Decimal(float(x)) for x in legendre.leggauss(stages)[0]])
        for _ in range(3):
            values = _polynomials(roots, stages)
            slope = stages * (roots * values[-1] - values[-2]) / (roots * roots - 1)
            roots = roots - values[-1] / slope
        values = _polynomials(roots, stages)
        weights = (1 - roots * roots) / (stages * values[-2]) ** 2
        degree = np.array([[Decimal(2 * n + 1)] for n in range(stages)])
        projection = degree * weights * values[:-1]
        integrals = (values[2:] - values[:-2]) / (2 * degree[1:])
        integrals = np.concatenate([[(roots + 1) / 2], integrals])
        columns = projection.T @ integrals
        found = (
            (roots + 1) / 2,
            weights,
            projection,
            columns,
            _powers(stages) @ projection,
            _folded(columns, weights),
        )
    return Gauss(*(np.array(each, np.float64) for each in found))


def table() -> str:
    """Return the text of the table: a line for each row of each field."""
    fields = [np.atleast_2d(field) for stages in (SIZE, WIDE_SIZE) for field in derived(stages)]
    return ''.join(' '.join(map(repr, row.tolist())) + '\n' for field in fields for row in field)


if __name__ == '__main__':
    place = Path(gauss_step.__file__).with_name('gauss_coefficients.txt')
    place.write_text(table(), 'ascii')
