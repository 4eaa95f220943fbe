"""The claims of paper A, *Dissertatio de novo quodam curvarum tautochronarum genere* (1727, E6).

Examples: a base radius r = 20 mm, the involute at the roll angle z = 2, a hole at a = 2 b.
Computed values come from the points of the unrolled circle, from the lines of the thread, from
sums over the disc, or from the motion integrated by DOP853 (`trochlea_evidence`).
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from tauto_core.euler.claim import Claim
from tauto_core.euler.trochlea_evidence import (
    BASE_RADIUS,
    HOLE,
    RATE,
    G,
    angle_of_hole,
    circle_unrolled,
    curvature_radius,
    cycloid_slope,
    direction,
    directions,
    disc_energy,
    disc_inertia,
    distance_of_normal,
    distance_of_normal_side,
    envelope_distance,
    length,
    period,
    polar_angle,
    radius_of_pendulum,
    rim_height,
    slope,
    small_triangles,
    unwound,
)
from tauto_core.machines.design import (
    base_radius_of_disc,
    equivalent_pendulum_length,
    length_of_thick_disc,
)

ROLL = 2.0
TURNED = 0.7
QUADRATURE, MOTION = 1e-10, 1e-9
"""Tolerances of sums and of derivatives by Chebyshev series, and of integrated periods."""


_claim = partial(Claim, 'A')


def claims() -> list[Claim]:
    """Return every claim of the paper, in its order; each is computed anew."""
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
            slope(lambda angle: 2.0 * unwound(angle), TURNED),
            QUADRATURE,
        ),
        _claim(
            'VII',
            'the perpendicular from the axle on the thread is the lever arm TM',
            'PM',
            math.nan,
            distance_of_normal_side(TURNED),
            QUADRATURE,
            'TM',
            arm,
            'PM is the thread itself, which is not the perpendicular',
            'corrected',
        ),
        _claim(
            'VIII',
            'the force at the rim, at right angles to CO, that does the same',
            'P.TM/CO',
            2.0 * arm / (3.0 * BASE_RADIUS),
            slope(lambda angle: 2.0 * unwound(angle), TURNED) / (3.0 * BASE_RADIUS),
            QUADRATURE,
            adds='by virtual work, with CO = 3 CT',
        ),
        _claim(
            'IX',
            'where TM is proportional to the angle all swings take the same time: 3 rad against '
            '0.1 rad',
            '',
            1.0,
            period(3.0) / period(0.1),
            MOTION,
            adds='T(3 rad)/T(0.1 rad) = 1',
        ),
        _claim(
            'X-XI',
            'the thread is normal to the curve, and CT, the distance of that normal, is constant',
            'CT constans',
            BASE_RADIUS,
            distance_of_normal(ROLL),
            QUADRATURE,
            adds='CT = r',
        ),
    ]


def _polar_equation() -> list[Claim]:
    y = math.hypot(1.0, ROLL)
    angle_rate = slope(polar_angle, ROLL)
    radius_rate = slope(lambda z: np.hypot(*circle_unrolled(z)), ROLL)
    return [
        _claim(
            'XII',
            'polar equation of the curve, at y = √5',
            'dx = (dy/y)√(yy − 1)',
            math.sqrt(y * y - 1.0) / y,
            angle_rate / radius_rate,
            QUADRATURE,
        ),
        _claim(
            'XIII',
            'the same with z = √(yy − 1), at z = 2',
            'dx = zdz/(z² + 1) = dz − dz/(z² + 1)',
            ROLL / (ROLL * ROLL + 1.0),
            angle_rate,
            QUADRATURE,
            'dx = zzdz/(z² + 1)',
            ROLL * ROLL / (ROLL * ROLL + 1.0),
            'the second form, dz − dz/(z² + 1), needs zz',
            'corrected',
        ),
        _claim(
            'XIII',
            'integrated: the polar angle, at z = 2',
            'x = z − ∫dz/(z² + 1)',
            ROLL - math.atan(ROLL),
            float(polar_angle(np.array(ROLL))),
            QUADRATURE,
            adds='x = z − arctan z',
        ),
        _claim(
            'XIII',
            'and the radius, at z = 2',
            'y = √(zz + 1)',
            y,
            float(np.hypot(*circle_unrolled(np.array(ROLL)))),
            QUADRATURE,
        ),
    ]


def _involute() -> list[Claim]:
    return [
        _claim(
            'XIV',
            "the curve is the circle's involute: its radius of curvature is the lever arm",
            '',
            BASE_RADIUS * ROLL,
            BASE_RADIUS * curvature_radius(ROLL),
            1e-8,
            adds='R = TM = rz',
        ),
        _claim(
            'XIV',
            'the arc wound up, which is the lift of the weight',
            '',
            0.5 * BASE_RADIUS * ROLL**2,
            BASE_RADIUS * length(ROLL),
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
            'vis viva (here the kinetic energy) of a homogeneous disc; v is the height of fall '
            'of the velocity of its rim',
            'Qv²/2',
            0.5 * weight * height**2,
            disc_energy(weight, BASE_RADIUS, math.sqrt(2.0 * G * height)),
            QUADRATURE,
            'Qv/2',
            0.5 * weight * height,
            'its differential follows as Qdv/2',
            'corrected',
        ),
        _claim(
            'XVIII',
            'the rise of the power is to the arc of the rim as the lever arm to the radius',
            'Mμ; Mm = Bm : BC',
            math.nan,
            slope(unwound, TURNED) / BASE_RADIUS,
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
            'increase, along the arc s of the rim, of the height of fall v of its velocity',
            'dv : Ss = 2P.BS/Q.BC',
            2.0 * pull * arc / (weight * BASE_RADIUS),
            slope(height, 0.0),
            QUADRATURE,
        ),
        _claim(
            'XIX',
            'on the cycloid of the pendulum AO the accelerating force is proportional to the arc',
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
            'length of the isochronous pendulum, P : Q = r/2 : L; here Q = 100 P',
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
            'base radius BC for Q = 100 P and a pendulum of 3166 scruples',
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
            'a weight of Q/100 may replace the spring: T(1 rad)/T(0) within 9 s a day',
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
    own = disc_inertia(weight, radius)
    thick = disc_inertia(weight * (radius / BASE_RADIUS) ** 2, radius)
    return [
        _claim(
            'XXI',
            'a larger disc of the same thickness, a in units of BC, Q the weight of the small one',
            'g.a⁴.BC/2P',
            math.nan,
            G * (period(1.0, pull=pull, inertia=thick) / math.tau) ** 2,
            MOTION,
            'Q.a⁴.BC/2P',
            length_of_thick_disc(weight, radius, pull, BASE_RADIUS),
            'a length has no g; whether the print has one only a scan would show',
            'corrected',
        ),
        _claim(
            'XXI',
            'the same, with Q the weight of the large disc itself and a a length',
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
            'the distance CP of the normal, where the lever arm is t = b φ',
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
    turning = 1.0 / slope(lambda angle: directions(angle, HOLE), TURNED)
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
            'the angle has its vertex at C and its second leg through the hole O',
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
            'arcs are divided by their radii OC and OM',
            'corrected',
        ),
    ]


def _last_remarks() -> list[Claim]:
    carried = 1e-4 / G
    return [
        _claim(
            'XXIX',
            'for a hole far away the curve becomes the involute, and p tends to b; here a = 10⁸ b',
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
