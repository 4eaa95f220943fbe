"""Euler's open remark (1729, end of 22): the half swing in the other direction on his curve.

It is not isochronous. Down the branch of ascent and up that of descent, w = (e^{κs} − 1)/κ obeys
ẅ = −(g/f)(w + κw²). For a start at the arc s₁ on the branch of ascent, q = 1 − e^{−κs₁}, W = κw
runs from −q to the root W₂ of

    (W + q)(W − W₂)(W − W₃) = 0,     W₂, W₃ = ½[−(3/2 − q) ± √((3/2 − q)(3/2 + 3q))],

as a Jacobian elliptic function of the parameter m = (W₂ + q)/(W₂ − W₃). All forms are free of
cancellation, from κ = 0, the harmonic swing, to starts at which e^{−κs₁} is almost 0. The
elliptic functions are computed by the arithmetic–geometric mean from m₁ = 1 − m, which m itself
does not resolve near 1 (Abramowitz & Stegun 16.4, 17.6).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves.series import exponential_mean, logarithmic_mean
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import DescentError

SERIES = (0.0, 0.0, 5 / 12, -5 / 18, 385 / 576, -385 / 432)
"""Coefficients of the duration over π√(f/g) in powers of q, without the leading 1."""
_MEANS = 12
"""Number of arithmetic–geometric means; they agree to rounding down to m₁ = 1e-300."""
_SMALL_Q = 1e-3
"""Below it the next term, 1.67 q⁶, is negligible."""


class _Course(NamedTuple):
    """The roots of the swing, arrays of one shape."""

    fall: FloatArray
    """q/κ, distance of the start from 0 in w [m]."""
    rise: FloatArray
    """W₂/κ, end of the swing in w [m]."""
    left: FloatArray
    """1 − q = e^{−κs₁}."""
    third: FloatArray
    """−W₃ > 0."""
    breadth: FloatArray
    """W₂ − W₃."""
    complement: FloatArray
    """1 − m."""


def _course(kappa: float, start: ArrayLike) -> _Course:
    s = np.asarray(start, np.float64)
    if not np.all((s > 0.0) & np.isfinite(s)):
        raise DescentError(
            f'start = {float(np.min(s))!r} m: a half swing backward starts on the branch of '
            'ascent, at an arc from A above 0 m; give another'
        )
    fall, left = s * exponential_mean(-kappa * s), np.exp(-kappa * s)
    q, most = kappa * fall, 0.5 + left
    third = 0.5 * (most + np.sqrt(most * (1.5 + 3.0 * q)))
    rise = fall * most / third
    breadth = kappa * rise + third
    complement = 3.0 * fall * left / ((rise + fall) * breadth)
    return _Course(fall, rise, left, third, breadth, np.minimum(complement, 1.0))


def duration_excess(kappa: float, start: ArrayLike) -> FloatArray:
    """Return T/(π√(f/g)) − 1 of the reverse half swing: 5q²/12 − 5q³/18 + ….

    Args:
        kappa: κ [1/m], ≥ 0.
        start: arc from A on the branch of ascent [m], > 0.
    """
    course = _course(kappa, start)
    q = kappa * course.fall
    series = np.polynomial.polynomial.polyval(np.minimum(q, _SMALL_Q), SERIES)
    scale = 2.0 / math.pi * np.sqrt(1.5 / course.breadth)
    exact = scale * quarter_period(course.complement) - 1.0
    return np.where(q < _SMALL_Q, series, exact)


def end_arc(kappa: float, start: ArrayLike) -> FloatArray:
    """Return the arc that the body reaches on the branch of descent [m]; less than ln(3/2)/κ."""
    rise = _course(kappa, start).rise
    return rise * logarithmic_mean(kappa * rise)


def quarter_ratios(kappa: float, start: float) -> tuple[float, float]:
    """Return the times down to A and up from it, over (π/2)√(f/g).

    To first order the quarters are wrong by ±4q/(3π), which cancels in the sum.
    """
    from scipy.special import elliprf

    course = _course(kappa, start)
    scale = 4.0 / math.pi * math.sqrt(1.5 / float(course.breadth))
    span = course.rise + course.fall
    sine = math.sqrt(float(course.rise / span))
    up = sine * float(elliprf(course.fall / span, course.third / course.breadth, 1.0))
    return scale * (float(quarter_period(course.complement)) - up), scale * up


def reverse_half_swing(
    kappa: float, frequency: float, start: ArrayLike, time: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return arc [m] and ds/dt [m/s] at times since the release at rest at −start.

    Rounding errors of the arc are amplified by e^{κs₁/2}, which matters for starts beyond 15/κ,
    where the body begins close to unstable equilibrium.

    Args:
        kappa: κ [1/m], ≥ 0.
        frequency: √(g/f) [rad/s].
        start: arc from A on the branch of ascent [m], > 0, any shape.
        time: from 0 to the duration of the half swing [s], of the same shape.
    """
    course = _course(kappa, start)
    span, m1 = course.rise + course.fall, course.complement
    pace = 0.5 * frequency * np.sqrt(course.breadth / 1.5)
    whole = quarter_period(m1)
    turned = np.clip(pace * np.asarray(time, np.float64), 0.0, whole)
    phi = amplitude(turned, m1)
    sine, cosine = np.sin(phi), np.cos(phi)
    delta = np.sqrt(m1 + (1.0 - m1) * cosine * cosine)
    # counted from the start, where 1 + κw may be small: w + q/κ = (w₂ + q/κ) m₁ sd²
    ratio = sine / delta
    gained = span * m1 * (ratio * ratio)
    rate = 2.0 * span * pace * m1 * sine * cosine / (delta * delta * delta)
    w, above = gained - course.fall, course.left + kappa * gained
    deep = kappa * w < -0.5
    near = w * logarithmic_mean(np.where(deep, 0.0, kappa * w))
    arc = np.where(deep, np.log(above) / (kappa or 1.0), near)
    return arc, rate / above


def quarter_period(complement: FloatArray) -> FloatArray:
    """Return K(m) = π/(2 agm(1, √m₁)).

    Args:
        complement: m₁ = 1 − m, 0 < m₁ ≤ 1.
    """
    one, other = np.ones_like(complement), np.sqrt(complement)
    for _ in range(_MEANS):
        one, other = 0.5 * (one + other), np.sqrt(one * other)
    return 0.5 * math.pi / one


def amplitude(argument: FloatArray, complement: FloatArray) -> FloatArray:
    """Return φ = am(u | m), so that sn = sin φ, cn = cos φ, dn² = m₁ + m cos²φ.

    Args:
        argument: u, 0 ≤ u ≤ K.
        complement: m₁ = 1 − m, 0 < m₁ ≤ 1, of the same shape.
    """
    one, other = np.ones_like(complement), np.sqrt(complement)
    ratios: list[FloatArray] = []
    for _ in range(_MEANS):
        mean = 0.5 * (one + other)
        ratios.append(0.5 * (one - other) / mean)
        one, other = mean, np.sqrt(one * other)
    phi = 2.0**_MEANS * one * argument
    for ratio in reversed(ratios):
        phi = 0.5 * (phi + np.arcsin(ratio * np.sin(phi)))
    return phi
