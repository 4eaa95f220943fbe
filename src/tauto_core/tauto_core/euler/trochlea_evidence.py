"""Reference values for the trochlea, from points, lines, sums and motions.

None uses the formulas that are checked. Lengths are metres; the unrolled circle has the radius 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.polynomial import Chebyshev

from tauto_core.samples import FloatArray

G = 9.81
BASE_RADIUS = 0.02
HOLE, RATE = 2.0, 1.0

Function = Callable[[FloatArray], FloatArray]


def slope(function: Function, x: float) -> float:
    """Return the derivative of a smooth function, by a Chebyshev series about x."""
    fit = Chebyshev.interpolate(function, 20, domain=[x - 0.25, x + 0.25])
    return float(fit.deriv()(x))


def circle_unrolled(z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the end of a thread that is unrolled from a unit circle by the angle z."""
    return np.cos(z) + z * np.sin(z), np.sin(z) - z * np.cos(z)


def polar_angle(z: FloatArray) -> FloatArray:
    """Return the polar angle of the unrolled curve from its tip [rad]."""
    x, y = circle_unrolled(np.asarray(z))
    return np.arctan2(y, x)


def _tangent(z: float) -> tuple[float, float]:
    """Return the unit tangent of the unrolled curve, from its points."""
    dx = slope(lambda s: circle_unrolled(s)[0], z)
    dy = slope(lambda s: circle_unrolled(s)[1], z)
    return dx / math.hypot(dx, dy), dy / math.hypot(dx, dy)


def distance_of_normal(z: float) -> float:
    """Return CT, the distance of the normal of the curve from the axle."""
    x, y = circle_unrolled(np.array(z))
    across, along = _tangent(z)
    return BASE_RADIUS * abs(float(x) * across + float(y) * along)


def distance_of_normal_side(z: float) -> float:
    """Return the distance from C of the curve's tangent, along which the thread leaves it."""
    x, y = circle_unrolled(np.array(z))
    across, along = _tangent(z)
    return BASE_RADIUS * abs(float(x) * along - float(y) * across)


def _speed(z: FloatArray) -> FloatArray:
    x_rate, y_rate = _rates()
    return np.asarray(np.hypot(x_rate(z), y_rate(z)))


@lru_cache(maxsize=1)
def _rates() -> tuple[Chebyshev, Chebyshev]:
    """Return the derivatives of the points' coordinates up to z = 3."""
    x = Chebyshev.interpolate(lambda s: circle_unrolled(s)[0], 40, domain=[0.0, 3.0])
    y = Chebyshev.interpolate(lambda s: circle_unrolled(s)[1], 40, domain=[0.0, 3.0])
    return x.deriv(), y.deriv()


def length(z: float) -> float:
    """Return the length of the unrolled curve."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    return 0.5 * z * float(weights @ _speed(0.5 * z * (nodes + 1.0)))


def unwound(angle: FloatArray) -> FloatArray:
    """Return the lift of the weight, the length wound on the cheek, from its points."""
    return np.array([BASE_RADIUS * length(float(each)) for each in np.ravel(angle)])


def curvature_radius(z: float) -> float:
    """Return the radius of curvature of the unrolled curve, ds/dz over its turning rate."""

    def turned(s: FloatArray) -> FloatArray:
        return np.array([math.atan2(*_tangent(float(each))[::-1]) for each in np.ravel(s)])

    return float(_speed(np.array(z))) / abs(slope(turned, z))


def disc_inertia(weight: float, radius: float) -> float:
    """Return the moment of inertia of a homogeneous disc, summed over its rings [kg m2]."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    ring = 0.5 * radius * (nodes + 1.0)
    density = weight / G / (math.pi * radius**2)
    return float(0.5 * radius * weights @ (density * 2.0 * math.pi * ring * ring**2))


def disc_energy(weight: float, radius: float, rim: float) -> float:
    """Return the kinetic energy of a disc from the velocity of its rim [J]."""
    return 0.5 * disc_inertia(weight, radius) * (rim / radius) ** 2


def _quarter(
    amplitude: float, inertia: float, pull: float, carried: float
) -> tuple[float, FloatArray]:
    """Return the time from rest to the middle, and the state there, by DOP853."""
    from scipy.integrate import solve_ivp

    r = BASE_RADIUS

    def motion(_: float, state: FloatArray) -> list[float]:
        angle, rate = state
        push = pull * r * angle + carried * r * r * angle * rate * rate
        return [rate, -push / (inertia + carried * (r * angle) ** 2)]

    def middle(_: float, state: FloatArray) -> float:
        return float(state[0])

    middle.terminal = True  # type: ignore[attr-defined]
    long = 10.0 * math.sqrt((inertia + carried * (r * amplitude) ** 2) / (pull * r))
    run = solve_ivp(
        motion, (0.0, long), [amplitude, 0.0], 'DOP853', events=middle, rtol=1e-12, atol=1e-15
    )
    times, states = run.t_events or [], run.y_events or []
    return float(times[0][0]), np.asarray(states[0][0])


@lru_cache(maxsize=32)
def period(
    amplitude: float,
    weight: float = 100.0,
    pull: float = 1.0,
    *,
    inertia: float | None = None,
    carried: float = 0.0,
) -> float:
    """Return the period on an involute of base radius r, of a disc of radius r or an inertia."""
    wheel = disc_inertia(weight, BASE_RADIUS) if inertia is None else inertia
    time, (angle, rate) = _quarter(amplitude, wheel, pull, carried)
    return 4.0 * (time - float(angle) / float(rate))


def rim_height(arc: float, weight: float, pull: float) -> Function:
    """Return v/r, r the base radius, as a function of (s − place of the rim)/r."""
    inertia = disc_inertia(weight, BASE_RADIUS)

    def height(within: FloatArray) -> FloatArray:
        places = arc - BASE_RADIUS * np.asarray(within)
        lift = unwound(places / BASE_RADIUS)
        top = float(unwound(np.array([1.0]))[0])
        rim = BASE_RADIUS * np.sqrt(2.0 * pull * (top - lift) / inertia)
        return rim**2 / (2.0 * G) / BASE_RADIUS

    return height


def cycloid_slope(part: float) -> float:
    """Return the sine of the slope of a cycloid where its arc from the bottom is `part` of AO."""
    # the cycloid of a pendulum of unit length, by its rolling circle of radius 1/4
    turned = 2.0 * math.asin(part)
    x = slope(lambda s: 0.25 * (s + np.sin(s)), turned)
    y = slope(lambda s: 0.25 * (1.0 - np.cos(s)), turned)
    return y / math.hypot(x, y)


def radius_of_pendulum(weight: float, pull: float, length: float) -> float:
    """Return the base radius at which a disc of that radius keeps time with a pendulum.

    The period is proportional to the root of the radius; one integrated motion gives the factor.
    """
    seconds = period(1.0, weight, pull)
    return BASE_RADIUS * length / (G * (seconds / math.tau) ** 2)


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
    return np.array([direction(float(each), distance) for each in np.ravel(angle)])


def envelope_distance(angle: float, distance: float) -> float:
    """Return p, from the foot of the lever arm to the cheek along the thread's line.

    Neighbouring lines x cos ψ + y sin ψ = t intersect where −x sin ψ + y cos ψ = dt/dψ.
    """
    return RATE / slope(lambda each: directions(each, distance), angle)


def angle_of_hole(angle: float) -> float:
    """Return the angle at C between the hole at rest and after a turn of the wheel [rad]."""
    at_rest, turned = _hole_place(0.0, HOLE), _hole_place(angle, HOLE)
    cross = at_rest[0] * turned[1] - at_rest[1] * turned[0]
    return math.atan2(float(cross), float(at_rest @ turned))


def small_triangles(angle: float) -> float:
    """Return (Oo/OC) : (On/OM) with a small turn, o the hole after it."""
    turn = 1e-6
    before, after = (_hole_place(angle + side * turn, HOLE) for side in (-0.5, 0.5))
    psi = direction(angle, HOLE)
    normal = np.array([math.cos(psi), math.sin(psi)])
    along = np.array([-normal[1], normal[0]])
    contact = RATE * angle * normal + envelope_distance(angle, HOLE) * along
    moved = after - before
    free = np.linalg.norm(_hole_place(angle, HOLE) - contact)
    return float(np.linalg.norm(moved) / HOLE / (abs(moved @ normal) / free))
