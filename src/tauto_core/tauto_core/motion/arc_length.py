"""Arc length as the coordinate of a wheel that lifts a heavy weight by a linear lever arm.

With t = bϑ and k² = μb² (μ = m/I) the inertia M/I = 1 + k²ϑ² grows with the angle. In
s = ∫√(M/I) dϑ = ½ (ϑ√(1 + k²ϑ²) + asinh(kϑ)/k) it is constant, and the mechanics is that of a
unit mass: with n = dϑ/ds and the momentum p = ṡ + γ̇n,

    ṡ = p − γ̇n,    ṗ = ṡ γ̇ dn/ds − n (pull · t + drag).

The functions of s that the steps need are even: polynomials in u = s²/limit, fitted by Chebyshev's
to rounding. Beyond the limit the functions themselves are evaluated. The disturbance is half that
in ϑ and smoother: at five steps a swing the error falls thirteenfold.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.polynomial.polynomial import polyval

from tauto_core.curves.newton import bracketed_newton
from tauto_core.machines import Machine
from tauto_core.samples import FloatArray

MAX_TERMS = 20
"""Largest number of terms; with more, steps would be slower than with the angle as coordinate."""

MARGIN = 1.5
"""How far beyond the release the polynomials reach: as far as a sea or an escapement may drive the
wheel.
"""

_ASINH = [(-0.25) ** n * math.comb(2 * n, n) / (2 * n + 1) for n in range(1, 18)]
"""asinh(x)/x − 1 = Σ x^2n (−1/4)^n (2n over n)/(2n + 1)."""

_CHECKED = (np.arange(64) + 0.5) / 64


class ArcShape(NamedTuple):
    """A heavy weight's machine along its arc.

    Attributes:
        rate: b, dt/dϑ [m/rad].
        k: b√μ [1/rad].
        limit: s² up to which the polynomials hold [rad2].
        per_limit: 1/limit.
        terms: coefficients of u^j, shape (4, n), n even: of n, of (dn/ds)/s, of (nt/s − b)/u and
            of ϑ/s.
    """

    rate: float
    k: float
    limit: float
    per_limit: float
    terms: FloatArray


SETTLED = 4e-16
"""Change of the angle, as a share of the arc, at which Newton's method ends: two roundings."""


def arc_of(angle: float, k: float) -> float:
    """Return s of the angle ϑ."""
    return 0.5 * (angle * math.hypot(1.0, k * angle) + math.asinh(k * angle) / k)


def angle_of(arc: float, k: float) -> float:
    """Return ϑ of the arc s: Newton's method, from beyond, where it converges monotonously."""
    size = abs(arc)
    angle = min(size, math.sqrt(2.0 * size / k))
    for _ in range(60):
        root = math.sqrt(1.0 + (k * angle) * (k * angle))
        step = (0.5 * (angle * root + math.asinh(k * angle) / k) - size) / root
        angle -= step
        if abs(step) <= SETTLED * size:
            break
    return math.copysign(angle, arc)


def angles_of(arcs: FloatArray, k: float) -> FloatArray:
    """Return ϑ of many arcs s, as `angle_of`."""
    sizes = np.abs(arcs)
    beyond = np.minimum(sizes, np.sqrt(2.0 * sizes / k))

    def excess(angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        root = np.sqrt(1.0 + (k * angles) ** 2)
        return 0.5 * (angles * root + np.arcsinh(k * angles) / k) - sizes, root

    angles = bracketed_newton(excess, beyond, (0.0, math.inf), absolute=SETTLED * sizes)
    return np.copysign(angles, arcs)


def arc_shape(machine: Machine) -> ArcShape | None:
    """Return the shape of a machine; None where ϑ itself is the better coordinate.

    A spring's pull grows with the lift, which the polynomials do not hold.
    """
    rate = machine.cam.linear_rate
    if rate is None or machine.carried_mass == 0.0 or machine.stiffness > 0.0:
        return None
    k = rate * math.sqrt(machine.carried_mass / machine.inertia)
    reach = min(machine.cam.range_rad, MARGIN * abs(machine.release_angle) + 0.1)
    return _fitted(k, arc_of(reach, k) ** 2, rate)


@lru_cache(maxsize=64)  # the machines of a fleet are often alike
def _fitted(k: float, limit: float, rate: float) -> ArcShape | None:
    for terms in range(2, MAX_TERMS + 1):
        nodes = 0.5 * (chebyshev.chebpts1(terms) + 1.0)
        rows = [_polynomial(nodes, values) for values in _functions(nodes, limit, k, rate)]
        found = [np.asarray(polyval(_CHECKED, row), np.float64) for row in rows]
        wanted = _functions(_CHECKED, limit, k, rate)
        if all(_agree(a, b) for a, b in zip(found, wanted, strict=True)):
            slope = np.append(rows[0][1:] * np.arange(1, terms), 0.0) * (2.0 / limit)
            padded = np.pad([rows[0], slope, *rows[1:]], ((0, 0), (0, terms % 2)))
            return ArcShape(rate, k, limit, 1.0 / limit, np.ascontiguousarray(padded))
    return None


def _agree(found: FloatArray, wanted: FloatArray) -> bool:
    return bool(np.all(np.abs(found - wanted) <= 4e-15 * np.max(np.abs(wanted))))


def _functions(u: FloatArray, limit: float, k: float, rate: float) -> tuple[FloatArray, ...]:
    """Return n, (nt/s − b)/u and ϑ/s at u = s²/limit."""
    arcs = np.sqrt(limit * u)
    angles = angles_of(arcs, k)
    square = (k * angles) ** 2
    n = 1.0 / np.sqrt(1.0 + square)
    return (
        n,
        rate * _departure(angles, arcs, n, square) / u,
        angles / arcs,
    )


def _departure(
    angles: FloatArray, arcs: FloatArray, n: FloatArray, square: FloatArray
) -> FloatArray:
    """Return nϑ/s − 1 without cancellation.

    s − ϑ = ½ϑ (√(1 + k²ϑ²) − 1 + asinh(kϑ)/(kϑ) − 1) and n − 1 = −k²ϑ²n²/(1 + n).
    """
    kq = np.sqrt(square)
    sinh = np.where(
        kq < 0.3,
        square * polyval(square, _ASINH),
        np.arcsinh(kq) / kq - 1.0,
    )
    longer = 0.5 * angles * (square / (1.0 + np.sqrt(1.0 + square)) + sinh)
    shorter = -square * n * n / (1.0 + n)
    return (shorter * angles - longer) / arcs


def _polynomial(nodes: FloatArray, values: FloatArray) -> FloatArray:
    """Return the coefficients of u^j through values at Chebyshev's nodes."""
    series = chebyshev.chebfit(2.0 * nodes - 1.0, values, len(nodes) - 1)
    polynomial = chebyshev.Chebyshev(series, domain=[0.0, 1.0])
    coefficients = polynomial.convert(kind=np.polynomial.Polynomial, domain=[-1, 1]).coef
    return np.asarray(np.pad(coefficients, (0, len(nodes) - len(coefficients))))
