"""Rotations by ωh: to the stages of a step in double, over the step in twofold precision.

A twofold number is an unevaluated sum of two doubles, some 106 bits. A rotation matrix rounded to
doubles would rotate a little too far, or stretch, by the same amount each step, and the error of n
steps would grow like n, instead of √n. Source: T. J. Dekker, A floating-point technique for
extending the available precision, Numer. Math. 18 (1971).
"""

from __future__ import annotations

from typing import Any

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.lanes import fma

_TERMS = 14
"""Terms of the twofold series: at an eighth of MAX_ANGLE the next one is below 1e-31."""

_HALVINGS = 3
"""Times that an angle is halved before its series, and the result doubled after it."""

_SINE = (1.0, -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800, 1 / 6227020800)
_SINE_REST = (-1 / 1307674368000, 1 / 355687428096000, -1 / 121645100408832000)
_COSINE = (0.5, -1 / 24, 1 / 720, -1 / 40320, 1 / 3628800, -1 / 479001600, 1 / 87178291200)
_COSINE_REST = (-1 / 20922789888000, 1 / 6402373705728000, -1 / 2432902008176640000)
SINE = _SINE + _SINE_REST
COSINE = _COSINE + _COSINE_REST
"""Taylor's coefficients of sin(x)/x and (1 − cos x)/x² in powers of x²."""

MAX_ANGLE = 6.5
"""Largest ωh of a rotation: twice what the series take; the first term left out is then 6e-16."""


@inlined
def sum_exactly(a: float, b: float) -> tuple[float, float]:
    """Return a + b as rounded, and its rounding error."""
    whole = a + b
    part = whole - a
    return whole, (a - (whole - part)) + (b - part)


@inlined
def multiply_exactly(a: float, b: float) -> tuple[float, float]:
    """Return a·b as rounded, and its rounding error."""
    whole = a * b
    return whole, fma(a, b, -whole)


@compiled
def _sum(a: Any, b: Any) -> Any:
    """Return the sum of two twofold numbers."""
    whole, rest = sum_exactly(a[0], b[0])
    return sum_exactly(whole, rest + a[1] + b[1])


@compiled
def _product(a: Any, b: Any) -> Any:
    """Return the product of two twofold numbers."""
    whole, rest = multiply_exactly(a[0], b[0])
    return sum_exactly(whole, rest + (a[0] * b[1] + a[1] * b[0]))


@compiled
def _quotient(a: Any, n: float) -> Any:
    """Return a twofold number divided by a small whole number."""
    whole = a[0] / n
    return sum_exactly(whole, (fma(-whole, n, a[0]) + a[1]) / n)


@compiled
def twofold_rotation(rate: float, time: float) -> Any:
    """Return cos and sin of rate · time, each as two doubles, good to 1e-30.

    Args:
        rate: ω [rad/s].
        time: h [s]; |ωh| ≤ MAX_ANGLE.
    """
    part = 0.5**_HALVINGS
    whole, rest = multiply_exactly(rate, time)
    angle = whole * part, rest * part
    square = _product(angle, angle)
    sine = term = angle
    for n in range(1, _TERMS):
        term = _quotient(_product(term, square), -(2.0 * n) * (2.0 * n + 1.0))
        sine = _sum(sine, term)
    # 1 − cos, unlike cos, keeps the digits of a small angle through the doublings
    short = term = _quotient(square, 2.0)
    for n in range(2, _TERMS):
        term = _quotient(_product(term, square), -(2.0 * n) * (2.0 * n - 1.0))
        short = _sum(short, term)
    for _ in range(_HALVINGS):
        cosine = _sum((1.0, 0.0), (-short[0], -short[1]))
        doubled = _product(sine, sine)
        short = 2.0 * doubled[0], 2.0 * doubled[1]
        turned = _product(sine, cosine)
        sine = 2.0 * turned[0], 2.0 * turned[1]
    return _sum((1.0, 0.0), (-short[0], -short[1])), sine


@inlined
def _series(c: Any, x: Any) -> Any:
    """Return Σ c_n x^n of ten terms by Estrin's scheme: few operations wait for others."""
    square = x * x
    fourth = square * square
    low = fma(fma(x, c[3], c[2]), square, fma(x, c[1], c[0]))
    high = fma(fma(x, c[7], c[6]), square, fma(x, c[5], c[4]))
    return fma(fma(x, c[9], c[8]), fourth * fourth, fma(high, fourth, low))


@inlined
def sine_versine(angle: Any) -> Any:
    """Return sin and 1 − cos of lanes or a float, |angle| ≤ π, with errors of 5e-16 and 2e-15.

    Taylor's series at half the angle, and the formulas of the double angle.
    """
    half = 0.5 * angle
    square = half * half
    sine, short = half * _series(SINE, square), _series(COSINE, square)
    twice = 2.0 * sine
    return twice * fma(-square, short, 1.0), twice * sine


@inlined
def rotation(angle: Any) -> Any:
    """Return cos and sin of lanes or a float, |angle| ≤ MAX_ANGLE."""
    sine, versine = sine_versine(0.5 * angle)
    return 1.0 - 2.0 * (sine * sine), 2.0 * (sine * (1.0 - versine))
