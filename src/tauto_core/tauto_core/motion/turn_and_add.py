"""The exact steps of a harmonic well in compiled code."""

from __future__ import annotations

from typing import Any

from tauto_core.motion.compiled import compiled, entry
from tauto_core.motion.outside import channel


@compiled
def _applied(row: Any, coefficients: Any, k: int) -> float:
    """Return row · coefficients of piece k; 0 on a platform at rest."""
    if coefficients is None:
        return 0.0
    total = 0.0
    for j in range(len(row)):
        total += row[j] * coefficients[k, j]
    return total


@entry
def turn_and_add(
    omega: float,
    delta: float,
    steps: Any,
    responses: Any,
    frame: Any,
    length: Any,
    neutral: Any,
    y: Any,
    lost: Any,
    angle: Any,
    rate: Any,
) -> None:
    """Advance Y_{n+1} = e^{−δh} (Y_n + e^{−iωt_n} b_n) and fill θ, θ̇ at the ends of the steps.

    Complex numbers are pairs. The additions are compensated (Kahan; `lost` is carried on), so
    that ten million of them cost no digit.
    """
    piece, end, decay, kind = steps
    for n in range(len(piece)):
        k = piece[n]
        re = _applied(responses[kind[n], 0], neutral, k)
        im = _applied(responses[kind[n], 1], neutral, k)
        c, s = frame[n, 0], frame[n, 1]
        add_re, add_im = c * re + s * im - lost[0], c * im - s * re - lost[1]
        new_re, new_im = y[0] + add_re, y[1] + add_im
        lost[0], lost[1] = (new_re - y[0]) - add_re, (new_im - y[1]) - add_im
        y[0], y[1] = decay[n] * new_re, decay[n] * new_im
        c, s = frame[n + 1, 0], frame[n + 1, 1]
        psi = (c * y[1] + s * y[0]) / omega
        line = channel(neutral, k, end[n], 1.0 / length[k])
        angle[n] = psi - line[0]
        rate[n] = c * y[0] - s * y[1] - delta * psi - line[1]
