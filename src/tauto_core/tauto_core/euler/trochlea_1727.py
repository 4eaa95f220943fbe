"""The claims of paper A, *Dissertatio de novo quodam curvarum tautochronarum genere* (1727, E6).

Examples: a base radius r = 20 mm, the involute at the roll angle z = 2, a hole at a = 2 b.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.polynomial import Chebyshev

from tauto_core.euler.edition import Claim, G, letters_of, read_claims
from tauto_core.samples import FloatArray

# -----------------------------------------------------------------------------
# Reference values, independent of the claims' formulas: from the points of the unrolled circle,
# which has the radius 1, the lines of the thread, sums over the disc, and motions integrated by
# DOP853. Lengths are in metres.

_LETTERS = letters_of('trochlea')
BASE_RADIUS, ROLL_ANGLE, HOLE, TURNED = (_LETTERS[name] for name in 'rzat')
RATE = 1.0

OfArray = Callable[[FloatArray], FloatArray]


def slope_at(function: OfArray, x: float) -> float:
    """Return the derivative of a smooth function, by a Chebyshev series about x."""
    fit = Chebyshev.interpolate(function, 20, domain=[x - 0.25, x + 0.25])
    return float(fit.deriv()(x))


def circle_unrolled(z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the end of a thread that unrolls from a unit circle by the angle z."""
    return np.cos(z) + z * np.sin(z), np.sin(z) - z * np.cos(z)


def polar_angle(z: FloatArray) -> FloatArray:
    """Return the polar angle of the unrolled curve from its tip [rad]."""
    x, y = circle_unrolled(np.asarray(z))
    return np.arctan2(y, x)


def _tangent(z: float) -> tuple[float, float]:
    """Return the unit tangent of the unrolled curve, from its points."""
    dx = slope_at(lambda s: circle_unrolled(s)[0], z)
    dy = slope_at(lambda s: circle_unrolled(s)[1], z)
    return dx / math.hypot(dx, dy), dy / math.hypot(dx, dy)


def distances_of_lines(z: float) -> tuple[float, float]:
    """Return the distances of the curve's normal, CT, and of its tangent, the thread, from C."""
    x, y = (float(part) for part in circle_unrolled(np.array(z)))
    across, along = _tangent(z)
    return BASE_RADIUS * abs(x * across + y * along), BASE_RADIUS * abs(x * along - y * across)


def _speed(z: FloatArray) -> FloatArray:
    x_rate, y_rate = _rates()
    return np.asarray(np.hypot(x_rate(z), y_rate(z)))


@lru_cache(maxsize=1)
def _rates() -> tuple[Chebyshev, Chebyshev]:
    x = Chebyshev.interpolate(lambda s: circle_unrolled(s)[0], 40, domain=[0.0, 3.0])
    y = Chebyshev.interpolate(lambda s: circle_unrolled(s)[1], 40, domain=[0.0, 3.0])
    return x.deriv(), y.deriv()


def length(z: float) -> float:
    """Return the length of the unrolled curve."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    return 0.5 * z * float(weights @ _speed(0.5 * z * (nodes + 1.0)))


def unwound(angle: FloatArray) -> FloatArray:
    """Return the lift of the weight, the length of thread on the cheek."""
    return np.array([BASE_RADIUS * length(float(value)) for value in np.ravel(angle)])


def curvature_radius(z: float) -> float:
    """Return the radius of curvature of the unrolled curve, ds/dz over its turning rate."""

    def turned(s: FloatArray) -> FloatArray:
        return np.array([math.atan2(*_tangent(float(value))[::-1]) for value in np.ravel(s)])

    return float(_speed(np.array(z))) / abs(slope_at(turned, z))


def inertia_of_rings(weight: float, radius: float) -> float:
    """Return the moment of inertia of a homogeneous disc, integrated over its rings [kg m2]."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    ring = 0.5 * radius * (nodes + 1.0)
    density = weight / G / (math.pi * radius**2)
    return float(0.5 * radius * weights @ (density * 2.0 * math.pi * ring * ring**2))


@lru_cache(maxsize=32)
def period(
    amplitude: float,
    weight: float = 100.0,
    pull: float = 1.0,
    *,
    inertia: float | None = None,
    carried: float = 0.0,
) -> float:
    """Return the period on an involute of base radius r, of an inertia or a disc of radius r."""
    from scipy.integrate import solve_ivp

    wheel = inertia_of_rings(weight, BASE_RADIUS) if inertia is None else inertia
    r = BASE_RADIUS

    def motion(_: float, state: FloatArray) -> list[float]:
        angle, rate = state
        push = pull * r * angle + carried * r * r * angle * rate * rate
        return [rate, -push / (wheel + carried * (r * angle) ** 2)]

    def middle(_: float, state: FloatArray) -> float:
        return float(state[0])

    middle.terminal = True  # type: ignore[attr-defined]
    long = 10.0 * math.sqrt((wheel + carried * (r * amplitude) ** 2) / (pull * r))
    run = solve_ivp(
        motion, (0.0, long), [amplitude, 0.0], 'DOP853', events=middle, rtol=1e-12, atol=1e-15
    )
    # from rest to the middle, corrected for the event's rounding
    times, states = run.t_events or [], run.y_events or []
    angle, rate = states[0][0]
    return 4.0 * (float(times[0][0]) - float(angle) / float(rate))


def rim_height(arc: float, weight: float, pull: float) -> OfArray:
    """Return v/r, r the base radius, as a function of (s − place of the rim)/r."""
    inertia = inertia_of_rings(weight, BASE_RADIUS)

    def height(place: FloatArray) -> FloatArray:
        places = arc - BASE_RADIUS * np.asarray(place)
        lift = unwound(places / BASE_RADIUS)
        top = float(unwound(np.array([1.0]))[0])
        rim = BASE_RADIUS * np.sqrt(2.0 * pull * (top - lift) / inertia)
        return rim**2 / (2.0 * G) / BASE_RADIUS

    return height


def _hole_place(angle: float, distance: float) -> FloatArray:
    """Return the position of the hole in the wheel's frame."""
    turned = 0.5 * math.pi + angle
    return distance * np.array([math.cos(turned), math.sin(turned)])


def direction(angle: float, distance: float) -> float:
    """Return the direction of the lever arm, from C to the thread, in the wheel's frame [rad]."""
    hole, arm = _hole_place(angle, distance), RATE * angle
    free = math.sqrt((distance - arm) * (distance + arm))
    # the foot F of length t with F ⊥ (hole − F): hole = F + free · F⊥/t
    foot = (arm * hole + free * np.array([hole[1], -hole[0]])) / distance**2
    return math.atan2(float(foot[1]), float(foot[0]))


def directions(angle: FloatArray, distance: float) -> FloatArray:
    """Return `direction` for an array of angles."""
    return np.array([direction(float(value), distance) for value in np.ravel(angle)])


def envelope_distance(angle: float, distance: float) -> float:
    """Return p, from the foot of the lever arm to the cheek along the thread's line.

    Neighbouring lines x cos ψ + y sin ψ = t intersect at −x sin ψ + y cos ψ = dt/dψ.
    """
    return RATE / slope_at(lambda value: directions(value, distance), angle)


def small_triangles(angle: float) -> float:
    """Return (Oo/OC) : (On/OM) with o, the hole after a small turn."""
    turn = 1e-6
    start, end = (_hole_place(angle + side * turn, HOLE) for side in (-0.5, 0.5))
    psi = direction(angle, HOLE)
    normal = np.array([math.cos(psi), math.sin(psi)])
    along = np.array([-normal[1], normal[0]])
    contact = RATE * angle * normal + envelope_distance(angle, HOLE) * along
    shift = end - start
    free = np.linalg.norm(_hole_place(angle, HOLE) - contact)
    return float(np.linalg.norm(shift) / HOLE / (abs(shift @ normal) / free))


# -----------------------------------------------------------------------------
# The reference values of the claims, by their names in `trochlea.yaml`.


def claims() -> list[Claim]:
    """Return every claim of the paper, in its order."""
    return read_claims('A', 'trochlea', _of_involute() | _of_motion() | _of_hole())


def _of_involute() -> dict[str, float]:
    torque = slope_at(lambda angle: 2.0 * unwound(angle), TURNED)
    angle_rate = slope_at(polar_angle, ROLL_ANGLE)
    radius_rate = slope_at(lambda z: np.hypot(*circle_unrolled(z)), ROLL_ANGLE)
    return {
        'torque': torque,
        'force_at_rim': torque / (3.0 * BASE_RADIUS),
        'distance_of_thread': distances_of_lines(TURNED)[1],
        'distance_of_normal': distances_of_lines(ROLL_ANGLE)[0],
        'dx_by_dy': angle_rate / radius_rate,
        'polar_rate': angle_rate,
        'polar_angle': float(polar_angle(np.array(ROLL_ANGLE))),
        'polar_radius': float(np.hypot(*circle_unrolled(np.array(ROLL_ANGLE)))),
        'curvature_radius': BASE_RADIUS * curvature_radius(ROLL_ANGLE),
        'lift': BASE_RADIUS * length(ROLL_ANGLE),
        'rise': slope_at(unwound, TURNED) / BASE_RADIUS,
    }


def _of_motion() -> dict[str, float]:
    large = 3.0 * BASE_RADIUS
    thin, thick = (inertia_of_rings(weight, large) for weight in (100.0, 900.0))

    def pendulum(inertia: float | None = None) -> float:
        return G * (period(1.0, inertia=inertia) / math.tau) ** 2

    def ratio(pull: float, large: float = 1.0, small: float = 1e-3) -> float:
        a, b = (period(radius, 100.0, pull, carried=pull / G) for radius in (large, small))
        return a / b

    # the cycloid of a pendulum of unit length, by its rolling circle of radius 1/4
    turned = 2.0 * math.asin(0.3)
    x = slope_at(lambda s: 0.25 * (s + np.sin(s)), turned)
    y = slope_at(lambda s: 0.25 * (1.0 - np.cos(s)), turned)
    rim = math.sqrt(2.0 * G * 0.2)
    return {
        'ratio_of_periods': period(3.0) / period(0.1),
        'disc_energy': 0.5 * inertia_of_rings(3.0, BASE_RADIUS) * (rim / BASE_RADIUS) ** 2,
        'rise_of_speed': slope_at(rim_height(0.5 * BASE_RADIUS, 100.0, 1.0), 0.0),
        'slope_of_cycloid': y / math.hypot(x, y),
        'pendulum_length': pendulum(),
        # the period is proportional to the root of the radius
        'radius_in_scruples': BASE_RADIUS * 3166.0 / pendulum(),
        'ratio_of_sullys_arcs': ratio(1.0, math.pi / 3.0, math.pi / 6.0),
        'pendulum_of_thick_disc': pendulum(thick),
        'pendulum_of_own_disc': pendulum(thin),
        'ratio_with_small_weight': ratio(1e-4),
    }


def _of_hole() -> dict[str, float]:
    turns = 1.0 / slope_at(lambda angle: directions(angle, HOLE), TURNED)
    distance = envelope_distance(TURNED, HOLE)
    at_rest, turned = _hole_place(0.0, HOLE), _hole_place(TURNED, HOLE)
    cross = at_rest[0] * turned[1] - at_rest[1] * turned[0]
    return {
        'direction_of_arm': direction(TURNED, HOLE),
        'distance_with_hole': distance,
        'ratio_of_turns': turns,
        'given_ratio': turns / distance,
        'angle_of_hole': math.atan2(float(cross), float(at_rest @ turned)),
        'ratio_in_triangles': small_triangles(TURNED),
        'distance_with_far_hole': envelope_distance(TURNED, 1e8),
    }
