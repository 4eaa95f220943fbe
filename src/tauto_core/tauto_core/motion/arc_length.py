"""The arc as the coordinate of a wheel that lifts a heavy weight by a linear lever arm.

With the lever arm t = bϑ and k² = mb²/I the inertia M/I = 1 + k²ϑ² grows with the angle. Along the
arc s = ∫√(M/I) dϑ = ½ (ϑ√(1 + k²ϑ²) + asinh(kϑ)/k) it is one. With n = dϑ/ds and the momentum
p = ṡ + γ̇n,

    (P.2)   ṡ = p − γ̇n,    ṗ = ṡγ̇ dn/ds − n (pull · t + drag).

Steps need functions of s that are even, and take them as polynomials in u = s²/limit that agree
with them to rounding (interpolated at Chebyshev nodes). Beyond the limit the functions themselves
are evaluated. In s the disturbance of the rotating plane is half that in ϑ and smoother: at five
steps a swing the error falls thirteenfold.
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
"""Largest number of terms; with more, steps would take longer than with ϑ as the coordinate."""

MARGIN = 1.5
"""How far beyond the release the polynomials reach: as far as a sea or an escapement commonly
drives the wheel. Beyond it the functions take longer, to the same accuracy.
"""

_ASINH = [(-0.25) ** n * math.comb(2 * n, n) / (2 * n + 1) for n in range(1, 18)]
"""Coefficients of x^2n in asinh(x)/x − 1, |x| < 1: (−1/4)^n (2n over n)/(2n + 1)."""

_SERIES_TO = 0.3
"""Largest kϑ for that series: the first term left out is 0.0036 · 0.3^36 = 5e-22."""

_CHECKED = (np.arange(64) + 0.5) / 64
"""u at which polynomials are compared with the functions."""

_AGREED = 4e-15
"""Largest difference there, as a share of the function's largest value."""


SETTLED = 4e-16
"""Change of ϑ, as a share of s, at which Newton's method ends: two roundings."""


class ArcShape(NamedTuple):
    """A machine with a heavy weight along its arc.

    Attributes:
        rate: b = dt/dϑ [m/rad].
        k: b√(m/I) [1/rad].
        limit: s² up to which the polynomials hold [rad2].
        per_limit: 1/limit.
        terms: coefficients of u^j of n, (dn/ds)/s, (nt/s − b)/u and ϑ/s, (4, count); the count
            is even, since two powers are summed side by side.
    """

    rate: float
    k: float
    limit: float
    per_limit: float
    terms: FloatArray


def arc_of(angle: float, k: float) -> float:
    """Return the arc s of the angle ϑ."""
    return 0.5 * (angle * math.hypot(1.0, k * angle) + math.asinh(k * angle) / k)


def angle_of(arc: float, k: float) -> float:
    """Return the angle ϑ of the arc s.

    Newton's method converges monotonically from above, since s(ϑ) is convex for ϑ > 0; it starts
    from bounds that s ≥ ϑ and s ≥ ½kϑ² give.
    """
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
    """Return the angles ϑ of many arcs s, as `angle_of`."""
    sizes = np.abs(arcs)
    beyond = np.minimum(sizes, np.sqrt(2.0 * sizes / k))

    def excess(angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        root = np.sqrt(1.0 + (k * angles) ** 2)
        return 0.5 * (angles * root + np.arcsinh(k * angles) / k) - sizes, root

    angles = bracketed_newton(excess, beyond, (0.0, math.inf), absolute=SETTLED * sizes)
    return np.copysign(angles, arcs)


def arc_shape(machine: Machine) -> ArcShape | None:
    """Return the shape of a machine; None where ϑ itself is the better coordinate.

    That is so where the lever arm is not linear or no weight rides along, where the polynomials
    take more than `MAX_TERMS`, and with a spring, whose pull grows with the lift.
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
    return bool(np.all(np.abs(found - wanted) <= _AGREED * np.max(np.abs(wanted))))


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
    """Return nϑ/s − 1 = ((n − 1) ϑ − (s − ϑ))/s without cancellation.

    s − ϑ = ½ϑ (√(1 + k²ϑ²) − 1 + asinh(kϑ)/(kϑ) − 1) and n − 1 = −k²ϑ²n²/(1 + n).
    """
    x = np.sqrt(square)
    asinh = np.where(
        x < _SERIES_TO,
        square * polyval(square, _ASINH),
        np.arcsinh(x) / x - 1.0,
    )
    longer = 0.5 * angles * (square / (1.0 + np.sqrt(1.0 + square)) + asinh)
    shorter = -square * n * n / (1.0 + n)
    return (shorter * angles - longer) / arcs


def _polynomial(nodes: FloatArray, values: FloatArray) -> FloatArray:
    """Return the coefficients of u^j of the polynomial with some values at Chebyshev nodes."""
    series = chebyshev.chebfit(2.0 * nodes - 1.0, values, len(nodes) - 1)
    polynomial = chebyshev.Chebyshev(series, domain=[0.0, 1.0])
    coefficients = polynomial.convert(kind=np.polynomial.Polynomial, domain=[-1, 1]).coef
    return np.asarray(np.pad(coefficients, (0, len(nodes) - len(coefficients))))
