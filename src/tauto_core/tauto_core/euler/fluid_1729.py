"""The reference values of paper B, *Curva tautochrona in fluido* (1729).

Euler's letters: m and n are the densities of body and fluid, a the diameter of the globe or the
height of the cylinder, f and h the pendulum lengths of descent and ascent, e = f/2, b the height
of fall of the speed at A. Tauto's are κ = 3n/8ma for a globe, n/2ma for a cylinder, γ = (m − n)/m
and β = γκf.

The values do not use the formulas of the claims. The slope follows from the condition that every
descent takes the same time (§14), the height from the slope by quadrature, speeds and times from
the integrated motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import quad, solve_ivp

from tauto_core.curves import FluidTautochrone
from tauto_core.curves.fluid import ActaCurve, abscissa, chained, coordinates
from tauto_core.curves.numerics import root_of
from tauto_core.euler.edition import Claim, G, letters_of, read_claims
from tauto_core.machines.fluid_pendulum import descent_time
from tauto_core.samples import FloatArray

_LETTERS = letters_of('fluid')
M, N, A, F, H, B, S = (_LETTERS[name] for name in 'mnafhbs')
GLOBE, GAMMA, BETA = (_LETTERS[name] for name in 'κγβ')
CYLINDER = N / (2.0 * M * A)
FRICTION = 0.03
SHORT, SMALL, THIN = 0.01, 1e-4, 0.01
"""An arc for the series of §24 [m], b for §34 [m], and κ for §27–28 [1/m]."""


def slope(s: float, kappa: float = GLOBE, length: float = F) -> float:
    """Return dx/ds = e^{2κs} (dt/ds)/γ, with √t proportional to ∫ e^{−κs} ds (§14)."""
    root, _ = quad(lambda r: math.exp(-kappa * r), 0.0, s, epsabs=0.0, epsrel=1e-13)
    return root * math.exp(kappa * s) / (GAMMA * length)


def height(s: float, kappa: float = GLOBE, length: float = F) -> float:
    """Return x(s) [m] by quadrature of the slope."""
    value, _ = quad(lambda r: slope(r, kappa, length), 0.0, s, epsabs=0.0, epsrel=1e-13)
    return float(value)


def fallen(s: float, kappa: float = GLOBE, length: float = F) -> float:
    """Return t = γ ∫ e^{−2κs} dx [m] (§13) by quadrature."""
    value, _ = quad(
        lambda r: GAMMA * math.exp(-2.0 * kappa * r) * slope(r, kappa, length), 0.0, s,
        epsabs=0.0, epsrel=1e-13,
    )  # fmt: skip
    return float(value)


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
    """Return a derivative by differences of fourth order, to about 1e-10."""
    inner = function(at + step) - function(at - step)
    outer = function(at + 2.0 * step) - function(at - 2.0 * step)
    return (8.0 * inner - outer) / (12.0 * step)


def quarter(start: float, friction: float = 0.0, length: float = F) -> float:
    """Return the time from rest at an arc to A, by the equation of motion [s].

    A negative arc is on the branch of ascent. Friction μ is relative to the weight in the fluid,
    and makes the curve steeper by μ.
    """
    return _motion(start, friction, length, to_rest=False)[0]


def swing(start: float) -> tuple[float, float]:
    """Return the time [s] and the signed end [m] of the swing from rest at an arc."""
    return _motion(start, 0.0, F, to_rest=True)


def _motion(start: float, friction: float, length: float, *, to_rest: bool) -> tuple[float, float]:
    # s̈ = −γg (p ∓ μ) ± κṡ², with p steeper by μ on the descent, which cancels friction
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

    The body has descended from rest at an arc of the branch of f.
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


# -----------------------------------------------------------------------------
# The reference values of the claims, by their names in `fluid.yaml`.


def claims() -> list[Claim]:
    """Return the claims of the paper, in its order."""
    return read_claims('B', 'fluid', _of_arc() | _of_cusps() | _of_shape() | _of_arcs())


def _of_arc() -> dict[str, float]:
    """Return the values at the arc S, by globe and cylinder, and of short arcs."""
    return {
        'x': height(S),
        'u': height(-S, length=H),
        't': fallen(S),
        'v': speed_height(S),
        'dx': slope(S),
        'ddx': derivative(slope, S),
        'dv': derivative(speed_height, S),
        'dx_of_ascent': -slope(-S, length=H),
        'growth': math.expm1(GLOBE * S),
        'quarter_swing': quarter(S),
        'quarter_ascent': swing(S)[0] - quarter(S),
        'half_swing': swing(S)[0],
        'backward_swing': swing(math.log1p(-0.5) / GLOBE)[0] / (math.tau * math.sqrt(F / G) / 2.0),
        # down a branch of f, up one of h
        'composed_length': G * ((quarter(S) + ascent(S, H)) / math.pi) ** 2,
        'acta_descent': descent_time(ActaCurve(GLOBE, GAMMA, F, S), G, S),
        'quarter_with_friction': quarter(S, FRICTION),
        'height_of_curve': height(S),
        'x_with_friction': float(FluidTautochrone(GLOBE, GAMMA, F, FRICTION).height(S)),
        'any_fall': _time_of_any_fall(),
        't_cylinder': fallen(S, CYLINDER),
        'dt_cylinder': derivative(lambda s: fallen(s, CYLINDER), S),
        'x_cylinder': height(S, CYLINDER),
        'dx_cylinder': slope(S, CYLINDER),
        'drag_of_globe': _drag_of_globe(A, N),
        'drag_of_twice': _drag_of_globe(2.0 * A, 2.0 * N) / _drag_of_globe(A, N),
        'x_in_vacuum': GAMMA * height(S, kappa=1e-11),
        'x_thin': height(S, kappa=1e-11),
        'x_short': height(SHORT),
        'u_short': height(-SHORT),
    }


def _time_of_any_fall() -> float:
    """Return ∫ dt/√(bt − t²) from 0 to b, with t = b sin²u, by the midpoint rule."""
    u = (np.arange(16) + 0.5) * (0.5 * math.pi / 16)
    t = B * np.sin(u) ** 2
    speed = 2.0 * B * np.sin(u) * np.cos(u)
    return float(np.sum(speed / np.sqrt(B * t - t * t)) * (0.5 * math.pi / 16))


def _drag_of_globe(size: float, density: float) -> float:
    """Return κ of a globe with a drag coefficient of 1/2 [1/m]."""
    mass = M * math.pi / 6.0 * size**3
    return 0.5 * 0.5 * density * 0.25 * math.pi * size**2 / mass


def _of_cusps() -> dict[str, float]:
    s = root_of(lambda s: slope(s) - 1.0, 0.1, 1.5, 1e-15)
    t = root_of(lambda t: slope(-t) + 1.0, 0.1, 4.0, 1e-15)
    down = root_of(lambda s: slope(s, THIN) - 1.0, 0.1, 1.5, 1e-15)
    up = root_of(lambda t: slope(-t, THIN, H) + 1.0, 0.1, 1.5, 1e-15)
    bent = derivative(lambda s: math.asin(slope(s)), s - 1e-5, 1e-6)
    of_h = root_of(lambda s: slope(s, length=H) - 1.0, 0.1, 1.5, 1e-15)
    return {
        's_cusp': s,
        'x_cusp': height(s),
        'radius_at_cusp': 1.0 / bent,
        'log_at_thin_cusp': THIN * down,
        'log_factor': (1.0 / GLOBE - height(of_h, length=H)) / (GLOBE * of_h),
        'x_thin_cusp': height(down, THIN),
        't_cusp': t,
        'u_cusp': height(-t),
        'u_thin_cusp': height(-up, THIN, H),
        'height_between_cusps': height(-t) - height(s),
        'steepest': -slope(-40.0 / GLOBE, length=3.0),
    }


def _of_shape() -> dict[str, float]:
    p = 1.0 / slope(S)

    def place(p: float) -> float:
        return height(root_of(lambda s: 1.0 / slope(s) - p, 0.01, 0.65, 1e-15))

    curve = FluidTautochrone(GLOBE, GAMMA, F)
    ends = curve.ascent_cusp, curve.descent_cusp
    cusps = [chained(curve, end, 1)[1] for end in ends]
    width = [float(coordinates(curve, end)[1]) for end in ends]
    return {
        'p': p,
        'dx_by_p': derivative(place, p, 1e-2),
        'y': float(abscissa(curve, curve.arc_of_height(height(S), 'descent'))),
        'x_of_ascent': height(-S),
        'dy': math.sqrt(1.0 - slope(S) ** 2),
        'curvature_radius': 1.0 / derivative(lambda s: math.asin(slope(s)), S),
        'radius_at_lowest': 1.0 / derivative(lambda s: math.asin(slope(s, length=H)), 0.0),
        'width': width[1] - width[0],
        'width_beyond': cusps[0] - cusps[1],
    }


def _of_arcs() -> dict[str, float]:
    limit = math.log1p(BETA) / GLOBE
    start = root_of(lambda s: fallen(s) - B, 0.1, limit, 1e-15)
    small = root_of(lambda s: fallen(s) - SMALL, 1e-3, limit, 1e-15)
    end, small_end = -swing(start)[1], -swing(small)[1]
    return {
        's_fastest': root_of(
            lambda s: 2.0 * GLOBE * speed_height(s) - GAMMA * slope(s), 1e-3, 0.3, 1e-15
        ),
        's_start': start,
        's_end': end,
        'loss_of_arc': start - end,
        'small_start': small,
        'small_end': small_end,
        'small_difference': small - small_end,
        'small_sum': small + small_end,
    }
