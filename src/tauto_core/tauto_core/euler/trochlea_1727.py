"""The claims of paper A, *Dissertatio de novo quodam curvarum tautochronarum genere* (1727, E6).

Examples: a base radius r = 20 mm, the involute at the roll angle z = 2, a hole at a = 2 b.
Computed values come from the points of the unrolled circle, from the lines of the thread, from
sums over the disc, or from the motion integrated by DOP853.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache, partial

import numpy as np
from numpy.polynomial import Chebyshev

from tauto_core.euler.edition import Claim, G
from tauto_core.machines.design import (
    base_radius_of_disc,
    equivalent_pendulum_length,
    length_of_thick_disc,
)
from tauto_core.samples import FloatArray

# -----------------------------------------------------------------------------
# Reference values, from points, lines, sums and motions.
#
# None uses the formulas that are checked. Lengths are metres; the unrolled circle has the radius
# 1.

BASE_RADIUS = 0.02
HOLE, RATE = 2.0, 1.0

OfArray = Callable[[FloatArray], FloatArray]


def slope_at(function: OfArray, x: float) -> float:
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
    dx = slope_at(lambda s: circle_unrolled(s)[0], z)
    dy = slope_at(lambda s: circle_unrolled(s)[1], z)
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

    return float(_speed(np.array(z))) / abs(slope_at(turned, z))


def inertia_of_rings(weight: float, radius: float) -> float:
    """Return the moment of inertia of a homogeneous disc, summed over its rings [kg m2]."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    ring = 0.5 * radius * (nodes + 1.0)
    density = weight / G / (math.pi * radius**2)
    return float(0.5 * radius * weights @ (density * 2.0 * math.pi * ring * ring**2))


def disc_energy(weight: float, radius: float, rim: float) -> float:
    """Return the kinetic energy of a disc from the velocity of its rim [J]."""
    return 0.5 * inertia_of_rings(weight, radius) * (rim / radius) ** 2


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
    # from rest to the middle, which the event misses by rounding
    times, states = run.t_events or [], run.y_events or []
    angle, rate = states[0][0]
    return 4.0 * (float(times[0][0]) - float(angle) / float(rate))


def rim_height(arc: float, weight: float, pull: float) -> OfArray:
    """Return v/r, r the base radius, as a function of (s − place of the rim)/r."""
    inertia = inertia_of_rings(weight, BASE_RADIUS)

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
    x = slope_at(lambda s: 0.25 * (s + np.sin(s)), turned)
    y = slope_at(lambda s: 0.25 * (1.0 - np.cos(s)), turned)
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
    return RATE / slope_at(lambda each: directions(each, distance), angle)


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


# -----------------------------------------------------------------------------
# The claims.

ROLL_ANGLE = 2.0
TURNED = 0.7
QUADRATURE, MOTION = 1e-10, 1e-9
"""Tolerances of sums and of derivatives by Chebyshev series, and of integrated periods."""


_claim = partial(Claim, 'A')


def claims() -> list[Claim]:
    """Return every claim of the paper, in its order; each is computed."""
    return [
        *_torque_and_isochronism(),
        *_polar_equation(),
        *_involute(),
        *_disc(),
        *_pendulum(),
        *_small_weight(),
        *_large_disc(),
        *_hole(),
        *_hole_proportions(),
        *_last_remarks(),
    ]


def _torque_and_isochronism() -> list[Claim]:
    arm = BASE_RADIUS * TURNED
    return [
        _claim(
            'VII',
            'the thread turns the wheel with the torque power × lever arm',
            'P.TM',
            2.0 * arm,
            slope_at(lambda angle: 2.0 * unwound(angle), TURNED),
            QUADRATURE,
        ),
        _claim(
            'VII',
            'the perpendicular from the axle on the thread is the lever arm *TM*',
            'PM',
            math.nan,
            distance_of_normal_side(TURNED),
            QUADRATURE,
            'TM',
            arm,
            '*PM* is the thread itself, which is not the perpendicular',
            'corrected',
        ),
        _claim(
            'VIII',
            'the force at the rim, at right angles to *CO*, that does the same',
            'P.TM/CO',
            2.0 * arm / (3.0 * BASE_RADIUS),
            slope_at(lambda angle: 2.0 * unwound(angle), TURNED) / (3.0 * BASE_RADIUS),
            QUADRATURE,
            adds='by virtual work, with CO = 3 CT',
        ),
        _claim(
            'IX',
            'where *TM* is proportional to the angle all swings take the same time: 3 rad '
            'against 0.1 rad',
            '',
            1.0,
            period(3.0) / period(0.1),
            MOTION,
            adds='T(3 rad)/T(0.1 rad) = 1',
        ),
        _claim(
            'X-XI',
            'the thread is normal to the curve, and *CT*, the distance of that normal, is '
            'constant',
            'CT constans',
            BASE_RADIUS,
            distance_of_normal(ROLL_ANGLE),
            QUADRATURE,
            adds='CT = r',
        ),
    ]


def _polar_equation() -> list[Claim]:
    y = math.hypot(1.0, ROLL_ANGLE)
    angle_rate = slope_at(polar_angle, ROLL_ANGLE)
    radius_rate = slope_at(lambda z: np.hypot(*circle_unrolled(z)), ROLL_ANGLE)
    return [
        _claim(
            'XII',
            'polar equation of the curve, at *y = √5*',
            'dx = (dy/y)√(yy − 1)',
            math.sqrt(y * y - 1.0) / y,
            angle_rate / radius_rate,
            QUADRATURE,
        ),
        _claim(
            'XIII',
            'the same with *z = √(yy − 1)*, at *z = 2*',
            'dx = zdz/(z² + 1) = dz − dz/(z² + 1)',
            ROLL_ANGLE / (ROLL_ANGLE * ROLL_ANGLE + 1.0),
            angle_rate,
            QUADRATURE,
            'dx = zzdz/(z² + 1)',
            ROLL_ANGLE * ROLL_ANGLE / (ROLL_ANGLE * ROLL_ANGLE + 1.0),
            'the second form, *dz − dz/(z² + 1)*, needs *zz*',
            'corrected',
        ),
        _claim(
            'XIII',
            'integrated: the polar angle, at *z = 2*',
            'x = z − ∫dz/(z² + 1)',
            ROLL_ANGLE - math.atan(ROLL_ANGLE),
            float(polar_angle(np.array(ROLL_ANGLE))),
            QUADRATURE,
            adds='x = z − arctan z',
        ),
        _claim(
            'XIII',
            'and the radius, at *z = 2*',
            'y = √(zz + 1)',
            y,
            float(np.hypot(*circle_unrolled(np.array(ROLL_ANGLE)))),
            QUADRATURE,
        ),
    ]


def _involute() -> list[Claim]:
    return [
        _claim(
            'XIV',
            "the curve is the circle's involute: its radius of curvature is the lever arm",
            '',
            BASE_RADIUS * ROLL_ANGLE,
            BASE_RADIUS * curvature_radius(ROLL_ANGLE),
            1e-8,
            adds='R = TM = rz',
        ),
        _claim(
            'XIV',
            'the arc wound up, which is the lift of the weight',
            '',
            0.5 * BASE_RADIUS * ROLL_ANGLE**2,
            BASE_RADIUS * length(ROLL_ANGLE),
            QUADRATURE,
            expected='added',
            adds='rzz/2',
            euler=False,
        ),
    ]


def _disc() -> list[Claim]:
    weight, height = 3.0, 0.2
    return [
        _claim(
            'XVIII',
            'vis viva (here the kinetic energy) of a homogeneous disc; *v* is the height of fall'
            ' of the velocity of its rim',
            'Qv²/2',
            0.5 * weight * height**2,
            disc_energy(weight, BASE_RADIUS, math.sqrt(2.0 * G * height)),
            QUADRATURE,
            'Qv/2',
            0.5 * weight * height,
            'its differential follows as *Qdv/2*',
            'corrected',
        ),
        _claim(
            'XVIII',
            'the rise of the power is to the arc of the rim as the lever arm to the radius',
            'Mμ; Mm = Bm : BC',
            math.nan,
            slope_at(unwound, TURNED) / BASE_RADIUS,
            QUADRATURE,
            'Mμ : Mm = Bm : BC',
            TURNED,
            'a semicolon where the proportion has its colon',
            'corrected',
        ),
    ]


def _pendulum() -> list[Claim]:
    weight, pull, arc = 100.0, 1.0, 0.5 * BASE_RADIUS
    length = 0.5 * weight * BASE_RADIUS / pull
    found = G * (period(1.0, weight, pull) / math.tau) ** 2
    height = rim_height(arc, weight, pull)
    return [
        _claim(
            'XVIII',
            'increase, along the arc *s* of the rim, of the height of fall *v* of its velocity',
            'dv : Ss = 2P.BS/Q.BC',
            2.0 * pull * arc / (weight * BASE_RADIUS),
            slope_at(height, 0.0),
            QUADRATURE,
        ),
        _claim(
            'XIX',
            'on the cycloid of the pendulum *AO* the accelerating force is proportional to the '
            'arc',
            'nt/Nn = (AN/AO) (BS/AO)',
            0.3 * 0.3,
            cycloid_slope(0.3),
            QUADRATURE,
            'nt/Nn = AN/AO = BS/AO',
            0.3,
            'the two ratios are equal, and their product would not make a pendulum',
            'corrected',
        ),
        _claim(
            'XIX',
            'length of the isochronous pendulum, *P : Q = r/2 : L*; here *Q = 100 P*',
            'AO = Q.BC/2P',
            length,
            found,
            MOTION,
        ),
    ]


def _small_weight() -> list[Claim]:
    return [
        _claim(
            'XX',
            'base radius *BC* for *Q = 100 P* and a pendulum of 3166 scruples',
            'BC = 63 scrup.',
            63.0,
            radius_of_pendulum(100.0, 1.0, 3166.0),
            0.5 / 63.0,
        ),
        _claim(
            'XX',
            'the same by the formula, not rounded [scruples]',
            'Q : 2P = AO : BC',
            base_radius_of_disc(100.0, 1.0, 3166.0),
            radius_of_pendulum(100.0, 1.0, 3166.0),
            MOTION,
        ),
        _claim(
            'XX',
            'a weight of *Q/100* may replace the spring: *T(1 rad)/T(0)* within 9 s a day',
            '',
            1.0,
            period(1.0, 100.0, 1.0, carried=1.0 / G) / period(1e-3, 100.0, 1.0, carried=1.0 / G),
            1e-4,
            adds='T(1 rad)/T(0) = 1',
            because='the inertia of the weight costs 428 s a day at 1 rad; a cam made for this '
            'weight has no such error',
            expected='fails',
        ),
    ]


def _large_disc() -> list[Claim]:
    weight, pull, radius = 100.0, 1.0, 3.0 * BASE_RADIUS
    own = inertia_of_rings(weight, radius)
    thick = inertia_of_rings(weight * (radius / BASE_RADIUS) ** 2, radius)
    return [
        _claim(
            'XXI',
            'a larger disc of the same thickness, *a* in units of *BC*, *Q* the weight of the '
            'small one',
            'g.a⁴.BC/2P',
            math.nan,
            G * (period(1.0, pull=pull, inertia=thick) / math.tau) ** 2,
            MOTION,
            'Q.a⁴.BC/2P',
            length_of_thick_disc(weight, radius, pull, BASE_RADIUS),
            'a length has no *g*; whether the print has one only a scan would show',
            'corrected',
        ),
        _claim(
            'XXI',
            'the same, with *Q* the weight of the large disc itself and *a* a length',
            '',
            equivalent_pendulum_length(weight * radius**2 / (2.0 * G), pull, BASE_RADIUS, G),
            G * (period(1.0, pull=pull, inertia=own) / math.tau) ** 2,
            MOTION,
            expected='added',
            adds='L = Qaa/2Pr',
            euler=False,
        ),
    ]


def _hole() -> list[Claim]:
    arm = RATE * TURNED
    free = math.sqrt(HOLE**2 - arm**2)
    return [
        _claim(
            'XXII',
            'thread through a fixed hole: the direction of the lever arm needs only arcs of '
            'circles',
            '',
            arm / RATE + math.asin(arm / HOLE),
            direction(TURNED, HOLE),
            QUADRATURE,
            adds='t/b + arcsin(t/a)',
        ),
        _claim(
            'XXII-XXIX',
            'the distance *CP* of the normal, where the lever arm is *t = b φ*',
            'p = b√(aa − tt)/(b + √(aa − tt))',
            RATE * free / (RATE + free),
            envelope_distance(TURNED, HOLE),
            QUADRATURE,
        ),
    ]


def _hole_proportions() -> list[Claim]:
    arm = RATE * TURNED
    free = math.sqrt(HOLE**2 - arm**2)
    p = RATE * free / (RATE + free)
    turning = 1.0 / slope_at(lambda angle: directions(angle, HOLE), TURNED)
    return [
        _claim(
            'XXVI',
            'the angles by which hole and normal turn',
            'OCo : PCt = CPt : b',
            math.nan,
            turning,
            QUADRATURE,
            'OCo : PCt = CP : b',
            p / RATE,
            'a ratio of angles cannot be that of a triangle to a length',
            'corrected',
        ),
        _claim(
            'XXVI',
            'the angle that the wheel has turned',
            'BCC',
            math.nan,
            angle_of_hole(TURNED),
            QUADRATURE,
            'BCO',
            TURNED,
            'the angle has its vertex at *C* and its second leg through the hole *O*',
            'corrected',
        ),
        _claim(
            'XXVII',
            'the same angles from the sides of the small triangles',
            'Oo/Oc : On/Om',
            math.nan,
            small_triangles(TURNED),
            1e-6,
            'Oo/OC : On/OM',
            p / RATE,
            'arcs are divided by their radii *OC* and *OM*',
            'corrected',
        ),
    ]


def _last_remarks() -> list[Claim]:
    carried = 1e-4 / G
    return [
        _claim(
            'XXIX',
            'for a hole far away the curve becomes the involute, and *p* tends to *b*; here *a ='
            ' 10⁸ b*',
            'p = ab/(a + b)',
            1e8 * RATE / (1e8 + RATE),
            envelope_distance(TURNED, 1e8),
            1e-9,
        ),
        _claim(
            'XXX',
            'a weight may replace the spring if it is small enough',
            '',
            1.0,
            period(1.0, 100.0, 1e-4, carried=carried) / period(1e-3, 100.0, 1e-4, carried=carried),
            1e-6,
            adds='Q = 10⁶ P: T(1 rad)/T(0) = 1 to a tenth of a second a day',
        ),
    ]
