"""Euler's tautochrone in a fluid that resists as the square of the speed (Euler 1729).

    γκ²f x = e^{κs} − 1 − κs,     dx/ds = (e^{κs} − 1)/(γκf) = s/(γf) + κx        (§16–20, 23)

for all signed s (`descent_curve`). A body that moves towards −s has the drag κṡ², and then
z = (1 − e^{−κs})/κ obeys z̈ = −(g/f) z exactly: the descent takes (π/2)√(f/g) from any start. All
formulas hold down to κ = 0, the cycloid (§18).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves.descent_curve import check_medium
from tauto_core.curves.newton import bracketed_newton
from tauto_core.curves.series import exponential_defect, exponential_mean, logarithmic_mean
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import DescentError

_ROUNDING = 4.0 * np.finfo(np.float64).eps


@dataclass(frozen=True)
class FluidTautochrone:
    """The joined curve of descent and ascent (§22), with or without constant friction (§35).

    Attributes:
        kappa: κ, deceleration over the square of the speed [1/m], ≥ 0.
        gamma: γ, acceleration in the fluid over that in vacuum, 0 < γ ≤ 1.
        pendulum_length: f [m].
        friction: μ, constant resistance over the weight in the fluid, 0 ≤ μ < 1. The curve is then
            x = μs + (e^{κs} − 1 − κs)/(γκ²f), which still has the slope μ at A.

    Raises:
        DescentError: a number out of its range, or β μ ≥ 1 with β = γκf: the friction leaves the
            curve without a lowest point.
    """

    kappa: float
    gamma: float
    pendulum_length: float
    friction: float = 0.0

    def __post_init__(self) -> None:
        check_medium(self.kappa, self.gamma, self.pendulum_length)
        limit = min(1.0, 1.0 / self.beta) if self.beta > 0.0 else 1.0
        if not 0.0 <= self.friction < limit:
            raise DescentError(
                f'friction = {self.friction!r}: must be at least 0 and less than {limit!r} of the '
                f'weight in the fluid, or the curve has no lowest point (beta = {self.beta!r}); '
                'give less friction'
            )

    @property
    def beta(self) -> float:
        """β = γκf, which measures the resistance; no ascent cusp if β ≥ 1 (without friction)."""
        return self.gamma * self.kappa * self.pendulum_length

    @property
    def descent_cusp(self) -> float:
        """Arc s* = ln(1 + β(1 − μ))/κ at which dx/ds = 1 [m] (§26)."""
        return self._arc_of_force(self._gf * (1.0 - self.friction))

    @property
    def ascent_cusp(self) -> float:
        """Arc ln(1 − β(1 + μ))/κ at which dx/ds = −1 [m]; −inf if β(1 + μ) ≥ 1 (§28)."""
        if self.beta * (1.0 + self.friction) >= 1.0:
            return -math.inf
        return self._arc_of_force(-self._gf * (1.0 + self.friction))

    @property
    def lowest_arc(self) -> float:
        """Arc of the lowest point [m]: 0 without friction, else ln(1 − βμ)/κ < 0."""
        return self._arc_of_force(-self._gf * self.friction)

    @property
    def _gf(self) -> float:
        return self.gamma * self.pendulum_length

    def _arc_of_force(self, force: float) -> float:
        """Return s with (e^{κs} − 1)/κ = force [m]."""
        return force * float(logarithmic_mean(np.asarray(self.kappa * force)))

    def slope(self, arc: ArrayLike) -> FloatArray:
        """Return p = dx/ds = μ + (e^{κs} − 1)/(γκf)."""
        s = np.asarray(arc, np.float64)
        return self.friction + s * exponential_mean(self.kappa * s) / self._gf

    def slope_rate(self, arc: ArrayLike) -> FloatArray:
        """Return dp/ds = e^{κs}/(γf) [1/m]."""
        return np.exp(self.kappa * np.asarray(arc, np.float64)) / self._gf

    def height(self, arc: ArrayLike) -> FloatArray:
        """Return x = μs + (e^{κs} − 1 − κs)/(γκ²f) [m]."""
        s = np.asarray(arc, np.float64)
        return self.friction * s + s * s * exponential_defect(self.kappa * s) / (2.0 * self._gf)

    def arc_of_height(self, height: ArrayLike, branch: Literal['descent', 'ascent']) -> FloatArray:
        """Return the arc s at a height above A [m].

        Solves the logarithmic form κs = ln(1 + κs + γκ²f x) (§16) by Newton's method on √x. With
        friction the curve about its lowest point is Euler's with f/(1 − βμ) in place of f.

        Args:
            height: x [m], not below the lowest point.
            branch: side of the lowest point.

        Raises:
            DescentError: a height below the lowest point, or NaN.
        """
        x = np.asarray(height, np.float64)
        lowest = self.lowest_arc
        above = x - self.height(lowest)
        if not np.all(above >= 0.0):
            raise DescentError(
                f'height {float(np.min(x))!r} m: the lowest point of the curve is at '
                f'{float(self.height(lowest))!r} m; give a height above it'
            )
        root = np.sqrt(2.0 * self._gf / (1.0 - self.beta * self.friction) * above)
        return lowest + _arc_of_root(self.kappa, root if branch == 'descent' else -root)

    def series_of_height(self, arc: ArrayLike, terms: int) -> FloatArray:
        """Return x by its first terms, γf x = s²/2 + κs³/6 + κ²s⁴/24 + … [m] (§24)."""
        s = np.asarray(arc, np.float64)
        total, term = np.zeros_like(s), 0.5 * s * s / self._gf
        for n in range(terms):
            total, term = total + term, term * self.kappa * s / (n + 3)
        return self.friction * s + total


def _arc_of_root(kappa: float, root: FloatArray) -> FloatArray:
    """Return s with s √(2(e^{κs} − 1 − κs)/(κs)²) = root [m].

    The left side is convex in s, so Newton's method from the right never overshoots.
    """
    scaled = kappa * root
    # e^z − 1 − z ≥ z²/2 for z ≥ 0; beyond, z < 2 ln(1 + root)
    start = np.where(scaled > 0.0, root * np.minimum(1.0, _twice_log(scaled)), root)

    def excess(arc: FloatArray) -> tuple[FloatArray, FloatArray]:
        z = kappa * arc
        growth = np.sqrt(exponential_defect(z))
        return arc * growth - root, exponential_mean(z) / growth

    return bracketed_newton(excess, start, (-math.inf, math.inf), relative=_ROUNDING)


def _twice_log(scaled: FloatArray) -> FloatArray:
    positive = np.where(scaled > 0.0, scaled, 0.0)
    return 2.0 * logarithmic_mean(positive)
