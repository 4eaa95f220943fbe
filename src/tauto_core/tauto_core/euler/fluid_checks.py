"""The example of paper B, and its quantities from quadrature and integrated motion.

Nothing here uses the formulas that are checked. The slope follows from the condition that every
descent takes the same time (§14), the height from the slope by quadrature, and speeds and times
from the equation of motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from tauto_core.euler.edition import G
from tauto_core.samples import FloatArray

# The fluid has a tenth of the density of the globe; m is not 1, so that its powers matter.
M, N, A, F = 2.0, 0.2, 0.05, 1.0
E = 0.5 * F
H = 0.64
B = 0.05
S = 0.3
GLOBE = 3.0 * N / (8.0 * M * A)
CYLINDER = N / (2.0 * M * A)
GAMMA = (M - N) / M
BETA = GAMMA * GLOBE * F


NOTHING = math.nan
CLOSE, FAIR = 1e-10, 1e-8
"""Tolerances; quadratures and motions are accurate to 1e-12, differences of them to 1e-10."""


def slope(s: float, kappa: float = GLOBE, length: float = F) -> float:
    """Return dx/ds = e^{2κs} (dt/ds)/γ, with √t proportional to ∫ e^{−κs} ds (§14)."""
    root, _ = quad(lambda r: math.exp(-kappa * r), 0.0, s, epsabs=0.0, epsrel=1e-13)
    return root * math.exp(kappa * s) / (GAMMA * length)


def height(s: float, kappa: float = GLOBE, length: float = F) -> float:
    """Return x(s) [m] by quadrature of the slope."""
    found, _ = quad(lambda r: slope(r, kappa, length), 0.0, s, epsabs=0.0, epsrel=1e-13)
    return float(found)


def fallen(s: float, kappa: float = GLOBE, length: float = F) -> float:
    """Return t = γ ∫ e^{−2κs} dx [m] (§13) by quadrature."""
    found, _ = quad(
        lambda r: GAMMA * math.exp(-2.0 * kappa * r) * slope(r, kappa, length), 0.0, s,
        epsabs=0.0, epsrel=1e-13,
    )  # fmt: skip
    return float(found)


def speed_height(s: float, at_lowest: float = B) -> float:
    """Return v(s) [m] from dv = 2κ v ds − γ dx (§12), integrated from A."""
    run = solve_ivp(
        lambda r, v: 2.0 * GLOBE * v - GAMMA * slope(r),
        (0.0, s),
        [at_lowest],
        method='DOP853',
        rtol=1e-12,
        atol=1e-16,
    )
    return float(run.y[0, -1])


def derivative(function: Callable[[float], float], at: float, step: float = 1e-3) -> float:
    """Return a derivative by differences of fourth order, good to 1e-10 or so."""
    near = function(at + step) - function(at - step)
    far = function(at + 2.0 * step) - function(at - 2.0 * step)
    return (8.0 * near - far) / (12.0 * step)


def zero_of(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function is 0, between two places, to rounding."""
    return float(brentq(function, low, high, xtol=1e-15, rtol=1e-14))


def quarter(start: float, friction: float = 0.0, length: float = F) -> float:
    """Return the time from rest at an arc to A on the curve, by the equation of motion [s].

    A negative arc goes in the other direction, down the branch of ascent; with friction μ, over
    the weight in the fluid, the curve is steeper by μ.
    """
    found = _motion(start, friction, length, to_rest=False)
    return found[0]


def swing(start: float) -> tuple[float, float]:
    """Return time [s] and signed end [m] of the half swing from rest at an arc."""
    return _motion(start, 0.0, F, to_rest=True)


def _motion(start: float, friction: float, length: float, *, to_rest: bool) -> tuple[float, float]:
    # s̈ = −γg (p ∓ μ) ± κṡ²; on the descent, where p is steeper by μ, friction cancels
    side = math.copysign(1.0, start)
    beta = GAMMA * GLOBE * length

    def law(_: float, y: FloatArray) -> list[float]:
        p = friction * side + math.expm1(GLOBE * y[0]) / beta
        drag = side * (GLOBE * y[1] * y[1] + GAMMA * G * friction)
        return [y[1], -GAMMA * G * p + drag]

    def passage(_: float, y: FloatArray) -> float:
        return float(y[1] if to_rest else y[0])

    passage.terminal = True  # type: ignore[attr-defined]
    passage.direction = side if to_rest else -side  # type: ignore[attr-defined]
    run = solve_ivp(
        law, (0.0, 20.0), [start, 0.0], method='DOP853', events=passage, rtol=1e-12, atol=1e-15
    )
    # the motion ends with the event
    return float(run.t[-1]), float(run.y[0, -1])


def ascent(start: float, length: float) -> float:
    """Return the time from A to rest, up a branch of this pendulum length [s].

    The speed at A is that of the descent from rest at an arc of the branch of f.
    """
    beta = GAMMA * GLOBE * length
    speed = math.sqrt(2.0 * G * fallen(start))

    def law(_: float, y: FloatArray) -> list[float]:
        return [y[1], -GAMMA * G * math.expm1(GLOBE * y[0]) / beta + GLOBE * y[1] * y[1]]

    def rest(_: float, y: FloatArray) -> float:
        return float(y[1])

    rest.terminal = True  # type: ignore[attr-defined]
    run = solve_ivp(
        law, (0.0, 20.0), [0.0, -speed], method='DOP853', events=rest, rtol=1e-12, atol=1e-15
    )
    return float(run.t[-1])
