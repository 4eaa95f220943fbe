"""A body that swings to and fro on a curve in a fluid, as a regulator.

Euler, *Curva tautochrona in fluido* (1729). On his curve every half swing down the branch of
descent takes π√(f/g), and the reverse half swing takes longer. Both have closed forms.
`half_swings` has other curves, constant friction and linear resistance.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves.branches import JoinedCurve
from tauto_core.curves.fluid import (
    Cycloid,
    DescentCurve,
    FluidTautochrone,
    SymmetricCurve,
)
from tauto_core.curves.numerics import (
    exponential_mean,
    integrate,
    logarithmic_mean,
    repeated_rule,
)
from tauto_core.machines.half_swings import BothWays
from tauto_core.machines.parts import (
    AmplitudeTable,
    OtherRegulator,
    checked_amplitudes,
    rate_s_per_day,
)
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import DescentError

# -----------------------------------------------------------------------------
# Motion along Euler's tautochrone, in closed form (Euler 1729, 13–15, 21, 31–35).
#
# On the way towards −s, z = (1 − e^{−κs})/κ obeys z̈ = −(g/f) z: it is the harmonic coordinate. As
# in Euler's paper, the height of fall v = V²/2g stands for a speed V, and b is v at A. A curve
# made for constant friction keeps the motion, but A is not its lowest point. `gravity` is g [m/s2]
# in vacuum.


class Arcs(NamedTuple):
    """The arcs of descent and ascent of a half swing [m], each > 0."""

    descent: float
    ascent: float
    loss: float
    """descent − ascent, and also the arc before A with the greatest speed."""


def harmonic_of_arc(kappa: float, arc: ArrayLike) -> FloatArray:
    """Return z = (1 − e^{−κs})/κ [m]."""
    s = np.asarray(arc, np.float64)
    return s * exponential_mean(-kappa * s)


def arc_of_harmonic(kappa: float, z: ArrayLike) -> FloatArray:
    """Return s = −ln(1 − κz)/κ [m], for κz < 1."""
    z = np.asarray(z, np.float64)
    return z * logarithmic_mean(-kappa * z)


def composed_length(descent: float, ascent: float) -> float:
    """Return L = ((√f + √h)/2)² [m], descent on a curve of f and ascent on one of h (§21)."""
    return (0.5 * (math.sqrt(descent) + math.sqrt(ascent))) ** 2


def euler_half_swing(
    curve: FluidTautochrone, gravity: float, start: ArrayLike, time: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return arc [m] and ds/dt [m/s] at times since the release at rest, 0 to π√(f/g) [s].

    Arcs of release > 0 and times have one shape. DescentError: a start off the branch of descent.
    """
    top = harmonic_of_arc(curve.kappa, _on_descent(curve, start))
    omega = math.sqrt(gravity / curve.pendulum_length)
    angle = omega * np.asarray(time, np.float64)
    z, rate = top * np.cos(angle), -top * omega * np.sin(angle)
    return arc_of_harmonic(curve.kappa, z), rate / (1.0 - curve.kappa * z)


def velocity_height(curve: FluidTautochrone, arc: ArrayLike, at_lowest: float) -> FloatArray:
    """Return v(s) = b e^{2κs} − (e^{κs} − 1)²/(2κ²f) [m] in a half swing, b at A (§31–32)."""
    s = np.asarray(arc, np.float64)
    top = _top(curve, at_lowest)
    z = harmonic_of_arc(curve.kappa, s)
    fall = (top - z) * (top + z) / (2.0 * curve.pendulum_length)
    return np.exp(2.0 * curve.kappa * s) * fall


def height_at_lowest(curve: FluidTautochrone, start: float) -> float:
    """Return b = z²/2f [m] of a descent from rest at an arc.

    DescentError: a start off the branch of descent.
    """
    z = float(harmonic_of_arc(curve.kappa, _on_descent(curve, start)))
    return z * z / (2.0 * curve.pendulum_length)


def arcs(curve: FluidTautochrone, at_lowest: float) -> Arcs:
    """Return the arcs of descent and ascent and their difference (§33–34), 0 < b < 1/(2κ²f).

    S_d = −ln(1 − κ√(2bf))/κ, S_a = ln(1 + κ√(2bf))/κ, S_d − S_a = −ln(1 − 2κ²bf)/κ. DescentError:
    no descent on the curve reaches b [m].
    """
    top = _top(curve, at_lowest)
    kappa = curve.kappa
    swing = Arcs(
        float(arc_of_harmonic(kappa, top)),
        -float(arc_of_harmonic(kappa, -top)),
        float(arc_of_harmonic(kappa, kappa * top * top)),
    )
    if swing.descent > curve.descent_cusp:
        limit = height_at_lowest(curve, curve.descent_cusp)
        raise DescentError(
            f'at_lowest = {at_lowest!r} m: needs a descent of {swing.descent!r} m, beyond the '
            f'cusp at {curve.descent_cusp!r} m. Give at most {limit!r} m, or take a longer '
            'pendulum'
        )
    return swing


def _top(curve: FluidTautochrone, at_lowest: float) -> float:
    """Return √(2bf), the z from which a descent reaches b. DescentError: no descent does."""
    kappa, length = curve.kappa, curve.pendulum_length
    top = math.sqrt(2.0 * max(at_lowest, 0.0) * length)
    if not (0.0 <= at_lowest < math.inf and kappa * top < 1.0):
        limit = 1.0 / (2.0 * kappa * kappa * length) if kappa else math.inf
        raise DescentError(
            f'at_lowest = {at_lowest!r} m: must be at least 0 and less than {limit!r} m, the '
            'limit of an endless descent against the resistance'
        )
    return top


def _on_descent(curve: DescentCurve, start: ArrayLike) -> FloatArray:
    release = np.asarray(start, np.float64)
    if not np.all((release > 0.0) & (release <= curve.descent_cusp) & np.isfinite(release)):
        raise DescentError(
            f'start = {float(np.min(release))!r} m: must be > 0 and at most at the cusp, '
            f'{curve.descent_cusp!r} m. Start nearer to A, or take a longer pendulum'
        )
    return release


# -----------------------------------------------------------------------------
# The time to A on any curve in a fluid.

_LONGEST_REDUCED = 1e6


def descent_time(curve: DescentCurve, gravity: float, start: float) -> float:
    """Return the time from rest at an arc [m] to A [s], over a positive slope.

    Down to the arc s, ½ṡ² = γg (S − s) times the mean of e^{2κ(s − σ)} p(σ) from s to S.
    DescentError: a start off the branch of descent, or κS above a million.
    """
    reduced = curve.kappa * float(_on_descent(curve, start))
    if not reduced <= _LONGEST_REDUCED:
        raise DescentError(
            f'an arc of {reduced:.6g}/kappa: the fluid resists too strongly, at most '
            f'{_LONGEST_REDUCED:g}/kappa is allowed. Use a smaller amplitude, a larger or denser '
            'body, or a lighter fluid'
        )
    # as many panels as resolve the exponential
    panels = 1 + int(reduced / 4.0)
    shares, weights = repeated_rule(panels)

    def integrand(u: FloatArray) -> FloatArray:
        # s = S (1 − u²) removes the square root at the start
        begin = start * (1.0 - u * u)
        length = (start - begin)[..., None] * shares
        weighed = np.exp(-2.0 * curve.kappa * length) * weights
        sums = np.sum(weighed * curve.slope(begin[..., None] + length), axis=-1)
        mean: FloatArray = sums / (2.0 * panels)
        return np.sqrt(2.0 * start / (curve.gamma * gravity * mean))

    return float(integrate(integrand, np.zeros(1), np.ones(1))[0])


# -----------------------------------------------------------------------------
# Euler's open remark (1729, end of 22): the half swing in the other direction on his curve.
#
# It is not isochronous. Down the branch of ascent and up the branch of descent, w = (e^{κs} − 1)/κ
# obeys ẅ = −(g/f)(w + κw²). From a start at the arc s₁ on the branch of ascent, q = 1 − e^{−κs₁},
# W = κw runs from −q to the root W₂ of
#
#     (W + q)(W − W₂)(W − W₃) = 0,     W₂, W₃ = ½[−(3/2 − q) ± √((3/2 − q)(3/2 + 3q))],
#
# as a Jacobian elliptic function of the parameter m = (W₂ + q)/(W₂ − W₃). All forms are free of
# cancellation, from κ = 0, the harmonic swing, to e^{−κs₁} near 0. The arithmetic–geometric mean
# computes the elliptic functions from m₁ = 1 − m, which m does not resolve near 1 (Abramowitz &
# Stegun 16.4, 17.6).

SERIES = (0.0, 0.0, 5 / 12, -5 / 18, 385 / 576, -385 / 432)
"""Coefficients of the duration over π√(f/g) in powers of q, without the leading 1."""
# Number of arithmetic–geometric means, which agree to rounding down to m₁ = 1e-300.
_MEANS = 12
# Below it the next term, 1.67 q⁶, is negligible.
_SMALL_Q = 1e-3


class _Course(NamedTuple):
    """The roots of the swing, arrays of one shape."""

    fall: FloatArray
    """q/κ, distance of the start from 0 in w [m]."""
    rise: FloatArray
    """W₂/κ, end of the swing in w [m]."""
    decay: FloatArray
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
            'ascent, at an arc above 0 m from A. Swing forward from other arcs'
        )
    fall, decay = s * exponential_mean(-kappa * s), np.exp(-kappa * s)
    q, upper = kappa * fall, 0.5 + decay
    third = 0.5 * (upper + np.sqrt(upper * (1.5 + 3.0 * q)))
    rise = fall * upper / third
    breadth = kappa * rise + third
    complement = 3.0 * fall * decay / ((rise + fall) * breadth)
    return _Course(fall, rise, decay, third, breadth, np.minimum(complement, 1.0))


def duration_excess(kappa: float, start: ArrayLike) -> FloatArray:
    """Return T/(π√(f/g)) − 1 of the reverse half swing: 5q²/12 − 5q³/18 + …, q = 1 − e^{−κs₁}."""
    course = _course(kappa, start)
    q = kappa * course.fall
    series = np.polynomial.polynomial.polyval(np.minimum(q, _SMALL_Q), SERIES)
    scale = 2.0 / math.pi * np.sqrt(1.5 / course.breadth)
    exact = scale * quarter_period(course.complement) - 1.0
    return np.where(q < _SMALL_Q, series, exact)


def end_arc(kappa: float, start: ArrayLike) -> FloatArray:
    """Return the arc that the body reaches on the branch of descent [m], less than ln(3/2)/κ."""
    rise = _course(kappa, start).rise
    return rise * logarithmic_mean(kappa * rise)


def reverse_half_swing(
    kappa: float, frequency: float, start: ArrayLike, time: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return arc [m] and ds/dt [m/s] at times since rest at −start, of one shape.

    `frequency` is √(g/f) [rad/s]. Rounding errors of the arc are amplified by e^{κs₁/2}, which
    matters beyond 15/κ, close to unstable equilibrium.
    """
    course = _course(kappa, start)
    span, m1 = course.rise + course.fall, course.complement
    pace = 0.5 * frequency * np.sqrt(course.breadth / 1.5)
    quarter = quarter_period(m1)
    turned = np.clip(pace * np.asarray(time, np.float64), 0.0, quarter)
    phi = jacobi_amplitude(turned, m1)
    sine, cosine = np.sin(phi), np.cos(phi)
    delta = np.sqrt(m1 + (1.0 - m1) * cosine * cosine)
    # counted from the start, at which 1 + κw may be small: w + q/κ = (w₂ + q/κ) m₁ sd²
    ratio = sine / delta
    gained = span * m1 * (ratio * ratio)
    rate = 2.0 * span * pace * m1 * sine * cosine / (delta * delta * delta)
    w, above = gained - course.fall, course.decay + kappa * gained
    deep = kappa * w < -0.5
    shallow = w * logarithmic_mean(np.where(deep, 0.0, kappa * w))
    arc = np.where(deep, np.log(above) / (kappa or 1.0), shallow)
    return arc, rate / above


def quarter_period(complement: FloatArray) -> FloatArray:
    """Return K(m) = π/(2 agm(1, √m₁)) for m₁ = 1 − m, 0 < m₁ ≤ 1."""
    a, b = np.ones_like(complement), np.sqrt(complement)
    for _ in range(_MEANS):
        a, b = 0.5 * (a + b), np.sqrt(a * b)
    return 0.5 * math.pi / a


def jacobi_amplitude(argument: FloatArray, complement: FloatArray) -> FloatArray:
    """Return φ = am(u | m): sn = sin φ, cn = cos φ, dn² = m₁ + m cos²φ.

    For 0 ≤ u ≤ K and m₁ = 1 − m, 0 < m₁ ≤ 1, of one shape.
    """
    a, b = np.ones_like(complement), np.sqrt(complement)
    ratios: list[FloatArray] = []
    for _ in range(_MEANS):
        mean = 0.5 * (a + b)
        ratios.append(0.5 * (a - b) / mean)
        a, b = mean, np.sqrt(a * b)
    phi = 2.0**_MEANS * a * argument
    for ratio in reversed(ratios):
        phi = 0.5 * (phi + np.arcsin(ratio * np.sin(phi)))
    return phi


Curve: TypeAlias = FluidTautochrone | Cycloid | SymmetricCurve | JoinedCurve


@dataclass(frozen=True, eq=False)
class DescentIsochronism(AmplitudeTable):
    """Descent, period and rate of a body in a fluid at n amplitudes, a table as `str`.

    The amplitude is the arc of the release on the branch of descent. `descent_s` lasts to the
    lowest point, `half_swing_s` to the other side, `period_s` there and back.
    """

    amplitude_m: FloatArray
    descent_s: FloatArray
    half_swing_s: FloatArray
    period_s: FloatArray
    rate_s_per_day: FloatArray


@dataclass(frozen=True)
class FluidPendulum(OtherRegulator):
    """A body on a curve in a fluid, as numbers.

    Attributes:
        curve: the curve, with κ and γ of the body in the fluid, and the pendulum length f.
        weight: weight of body less displaced fluid, in vacuum's gravity [N].
        gravity: g [m/s2].
        release_arc: arc of the release at rest [m], < 0 on the branch of ascent.
        friction: μ, constant friction over the weight in the fluid.
        viscous: λ, linear resistance over the speed and the mass that moves [1/s].
    """

    curve: Curve
    weight: float
    gravity: float
    release_arc: float
    friction: float = 0.0
    viscous: float = 0.0

    propagator = 'half_swings'

    @property
    def frequency(self) -> float:
        """Angular frequency of small swings without λ, ω = √(g/f) [rad/s]."""
        return math.sqrt(self.gravity / self.curve.pendulum_length)

    @property
    def small_period(self) -> float:
        """Period of small swings, 2π/√(ω² − λ²/4) [s]."""
        omega, slower = self.frequency, 0.5 * self.viscous
        if not slower:
            return math.tau / omega
        return math.tau / math.sqrt((omega - slower) * (omega + slower))

    def swing_energy(self, place: FloatArray, rate: FloatArray) -> FloatArray:
        """Return ½ (W/g)(ω² s² + ṡ²) [J] of arcs s [m] and speeds [m/s], with the weight W."""
        small = (self.frequency * place) ** 2 + rate * rate
        return 0.5 * self.weight / self.gravity * small

    @property
    def propagator_reason(self) -> str:
        """Why it moves half swing by half swing."""
        how = 'in closed form' if self.is_euler else 'by quadrature'
        how = 'by collocation' if self.viscous else how
        return (
            'the fluid takes a known part of the arc from each half swing: one after the other, '
            f'any instant in them {how}'
        )

    @property
    def largest_start(self) -> float:
        """Arc of the release from A [m]."""
        return abs(self.release_arc)

    @property
    def is_euler(self) -> bool:
        """Whether the curve is Euler's, on which half swings have closed forms."""
        return isinstance(self.curve, FluidTautochrone) and not (self.friction or self.viscous)

    def both_ways(self, start: float) -> BothWays:
        """Return the half swings from a start on. DescentError: the body would leave the curve."""
        return BothWays(self.curve, self.gravity, self.friction, start, self.viscous)

    def swing(self, start: float) -> tuple[float, float]:
        """Return duration over π/ω, less 1, and end [m] of the half swing from rest at an arc [m].

        DescentError: a start beyond the cusp. QuadratureError: a resistance too strong for the
        series.
        """
        kappa = self.curve.kappa
        if not self.is_euler:
            course = self.both_ways(start).course(start)
            return course.duration * self.frequency / math.pi - 1.0, course.end
        if start > 0.0:
            return 0.0, float(arc_of_harmonic(kappa, -harmonic_of_arc(kappa, start)))
        return float(duration_excess(kappa, -start)), float(end_arc(kappa, -start))

    def period(self, amplitude: float) -> float:
        """Return the duration of a swing from rest to the other side and back [s].

        The sign of the amplitude [m] is its branch. 0 gives `small_period`. DescentError: an
        amplitude beyond the cusp, or so small that friction holds the body.
        """
        if amplitude == 0.0:
            return self.small_period
        out_excess, end = self.swing(amplitude)
        in_excess, _ = self.swing(end)
        if math.isinf(out_excess + in_excess):
            raise DescentError(
                f'amplitude {amplitude!r} m: friction of {self.friction!r} of the weight holds '
                f'the body at {amplitude if math.isinf(out_excess) else end!r} m before it comes '
                'back. Give a larger amplitude, or less friction'
            )
        return math.tau / self.frequency * (1.0 + 0.5 * (out_excess + in_excess))

    def descent(self, amplitude: float) -> float:
        """Return the time from rest on the branch of descent to the zero of the force [s].

        Without friction that is A. The amplitude [m] is > 0.
        """
        if not (self.friction or self.viscous):
            return descent_time(self.curve, self.gravity, amplitude)
        return self.both_ways(amplitude).fall_time(amplitude)


def descent_isochronism(
    machine: FluidPendulum, amplitudes: Iterable[float], nominal_period_s: float | None = None
) -> DescentIsochronism:
    """Return descent time, period and rate at several arcs on the branch of descent [m].

    The descent is integrated, even on Euler's curve. The nominal period, by which the dial
    advances in a full swing, defaults to the small-amplitude one. UsageError: no amplitude, or one
    out of range.
    """
    edge = machine.curve.descent_cusp
    sizes = checked_amplitudes(
        amplitudes, edge, 'm', 'in metres of arc', 'at most the arc of the cusp'
    )
    nominal = machine.small_period if nominal_period_s is None else nominal_period_s
    descent = [machine.descent(amplitude) for amplitude in sizes]
    half = math.pi / machine.frequency
    halves = [half * (1.0 + machine.swing(amplitude)[0]) for amplitude in sizes]
    period = [machine.period(amplitude) for amplitude in sizes]
    rate = [rate_s_per_day(seconds, nominal) for seconds in period]
    return DescentIsochronism(nominal, *map(np.array, (sizes, descent, halves, period, rate)))
