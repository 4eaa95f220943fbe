"""Claims of paper B on the shape of the curve, §26–30: cusps, coordinates, curvature."""

from __future__ import annotations

import math

from tauto_core.curves import FluidTautochrone
from tauto_core.curves.fluid_outline import abscissa, chained, coordinates
from tauto_core.euler import fluid_checks as check
from tauto_core.euler.claim import Claim
from tauto_core.euler.fluid_checks import (
    BETA,
    CLOSE,
    FAIR,
    GAMMA,
    GLOBE,
    NOTHING,
    A,
    F,
    M,
    N,
    S,
    holds,
    misprint,
)

_CURVE = FluidTautochrone(GLOBE, GAMMA, F)


def shape_claims() -> list[Claim]:
    """Return the claims of §26–30."""
    return [
        *_cusp(),
        *_height_of_cusp(),
        *_ascent_cusp(),
        *_by_slope(),
        *_curvature(),
        *_beyond_the_cusps(),
    ]


def _cusp() -> list[Claim]:
    s = check.root(lambda s: check.slope(s) - 1.0, 0.1, 1.5)
    long, part = 8.0 * M * A / (3.0 * N), 3.0 * (M - N) * N * F / (8.0 * M**2 * A)
    return [
        holds(
            '26',
            'arc to the cusp of the descent',
            's = (8ma/3n) l(1 + 3(m − n)nf/8mma)',
            long * math.log1p(part),
            s,
            CLOSE,
        ),
        misprint(
            '26',
            'the same, where it is printed',
            ('s = (8ma/3n)(1 + 3(m − n)nf/8mma)', long * (1.0 + part)),
            s,
            ('s = (8ma/3n) l(1 + 3(m − n)nf/8mma)', long * math.log1p(part)),
            'the l of the logarithm is lost',
        ),
        misprint(
            '26',
            'what kind of point it is, by its radius of curvature',
            ('punctum flexus contrarii', NOTHING),
            0.0,
            ('punctum reversionis', _radius_before(s)),
            'at an inflection the radius would be infinite; here it is 0',
            1e-2,
        ),
    ]


def _height_of_cusp() -> list[Claim]:
    s = check.root(lambda s: check.slope(s) - 1.0, 0.1, 1.5)
    x = check.height(s)
    long, part = 8.0 * M * A / (3.0 * N), 3.0 * (M - N) * N * F / (8.0 * M**2 * A)
    area = 64.0 * M**3 * A**2 / (9.0 * (M - N) * N**2 * F)
    right = long - area * math.log1p(part)
    thin = 0.01
    series = GAMMA * F / 2.0 - GAMMA**2 * F**2 * thin / 3.0 + GAMMA**3 * F**3 * thin**2 / 4.0
    low = check.height(check.root(lambda s: check.slope(s, thin) - 1.0, 0.1, 1.5), thin)
    return [
        holds(
            '27',
            'its height',
            'x = 1/κ − l(1 + β)/(γκ²f)',
            right,
            x,
            CLOSE,
        ),
        misprint(
            '27',
            'the same, its first term',
            ('8ms/3n', 8.0 * M * s / (3.0 * N) - area * math.log1p(part)),
            x,
            ('8ma/3n', right),
            's for a',
        ),
        misprint(
            '27',
            'the same, its second term',
            ('(1 + β) without l', long - area * (1.0 + part)),
            x,
            ('l(1 + β)', right),
            'the l of the logarithm is lost',
        ),
        holds(
            '27',
            'series of the height (κ = 0.01)',
            'γf/2 − γ²f²κ/3 + γ³f³κ²/4 − …',
            series,
            low,
            2.0 * thin**3,
        ),
        misprint(
            '27',
            'a power in the series',
            ('j²', NOTHING),
            low,
            ('f³ etc.', series),
            'there is no j; the powers of f rise',
            2.0 * thin**3,
        ),
    ]


def _radius_before(cusp: float) -> float:
    """Return R shortly before the cusp [m], from dτ/ds; it goes to 0 as √(s* − s)."""
    place = cusp - 1e-5
    bend = check.derivative(lambda s: math.asin(check.slope(s)), place, 1e-6)
    return 1.0 / bend


def _ascent_cusp() -> list[Claim]:
    t = check.root(lambda t: check.slope(-t) + 1.0, 0.1, 4.0)
    u = check.height(-t)
    thin = 0.01
    end = check.root(lambda t: check.slope(-t, thin) + 1.0, 0.1, 1.5)
    series = GAMMA * F / 2.0 + GAMMA**2 * F**2 * thin / 3.0 + GAMMA**3 * F**3 * thin**2 / 4.0
    long = 3.0
    return [
        holds(
            '28',
            'arc to the cusp of the ascent',
            't = −(8ma/3n) l(1 − 3(m − n)nh/8mma), here h = f',
            -math.log1p(-BETA) / GLOBE,
            t,
            CLOSE,
        ),
        holds(
            '28',
            'its height',
            'u = −1/κ − l(1 − β)/(γκ²h)',
            -1.0 / GLOBE - math.log1p(-BETA) / (GAMMA * GLOBE**2 * F),
            u,
            CLOSE,
        ),
        holds(
            '28',
            'series of the height (κ = 0.01)',
            'γh/2 + γ²h²κ/3 + …',
            series,
            check.height(-end, thin),
            2.0 * thin**3,
        ),
        holds(
            '28',
            'no cusp if 3(m − n)nh ≥ 8m²a: the slope only tends to 1/β (h = 3 m, κt = 40)',
            '8m²a/3(m − n)nh',
            8.0 * M**2 * A / (3.0 * (M - N) * N * long),
            -check.slope(-40.0 / GLOBE, length=long),
            CLOSE,
        ),
    ]


def _by_slope() -> list[Claim]:
    p = 1.0 / check.slope(S)

    def place(p: float) -> float:
        return check.height(check.root(lambda s: 1.0 / check.slope(s) - p, 0.01, 0.65))

    rate = check.derivative(place, p, 1e-2)
    right = -8.0 * (M - N) * M * A * F / (8.0 * M**2 * A * p**3 + 3.0 * (M - N) * N * F * p**2)
    lost = -8.0 * (M - N) * M * A * F / (8.0 * M**2 * A * p**2 + 3.0 * (M - N) * N * F * p)
    bend = check.derivative(check.slope, S)
    x = check.height(S)
    double = GLOBE * check.slope(S) + 1.0 / (GAMMA * F)
    return [
        misprint(
            '29',
            'the differential form differentiated once more',
            ('8(m − n)maf dx', NOTHING),
            bend,
            ('8m²a ds² + 3(m − n)nf dx ds = 8(m − n)maf ddx', double),
            'the second differential is meant',
            FAIR,
        ),
        holds(
            '29',
            'the curve by p = ds/dx',
            'dx = −γf dp/(p³ + βp²)',
            -GAMMA * F / (p**3 + BETA * p**2),
            rate,
            FAIR,
        ),
        misprint(
            '29',
            'the same, written out',
            ('dx = −8(m − n)maf dp/(8m²ap² + 3(m − n)nfp)', lost),
            rate,
            ('dx = −8(m − n)maf dp/(8m²ap³ + 3(m − n)nfp²)', right),
            'the factor 1/p of "dp : p" is lost',
            FAIR,
        ),
        holds(
            '29',
            'y by circle and logarithm or arc tangent (β < 1)',
            'dy = √(pp − 1) dx',
            _closed_abscissa(),
            float(abscissa(_CURVE, _CURVE.arc_of_height(x, 'descent'))),
            CLOSE,
        ),
    ]


def _closed_abscissa() -> float:
    """Return y at S from ∫ √(p² − 1) dx in closed form, with sin τ = 1/p."""
    tau = math.asin(math.expm1(GLOBE * S) / BETA)
    w = math.sqrt(1.0 - BETA * BETA)
    turn = math.atan((math.tan(0.5 * tau) + BETA) / w) - math.atan(BETA / w)
    rest = tau - 2.0 * w * turn
    return GAMMA * F * ((math.cos(tau) - 1.0) / BETA + rest / BETA**2)


def _curvature() -> list[Claim]:
    level = math.sqrt(1.0 - check.slope(S) ** 2)
    turning = check.derivative(lambda s: math.asin(check.slope(s)), S)
    right = (M - N) * F * level / (M * math.exp(3.0 * N * S / (8.0 * M * A)))
    at_lowest = check.derivative(lambda s: math.asin(check.slope(s)), 0.0)
    return [
        holds(
            '30',
            'radius of curvature',
            'R = γf (dy/ds) c^{−κs}',
            GAMMA * F * level * math.exp(-GLOBE * S),
            1.0 / turning,
            FAIR,
        ),
        misprint(
            '30',
            'the same, written out',
            ('(m − n)f dy/(3ns)', (M - N) * F * level / (3.0 * N * S)),
            1.0 / turning,
            ('(m − n)f dy/(m c^{3ns:8ma} ds)', right),
            'the exponential is printed as part of the denominator 3ns',
            FAIR,
        ),
        holds(
            '30',
            'radius of curvature at A',
            'γf',
            GAMMA * F,
            1.0 / at_lowest,
            FAIR,
        ),
    ]


def _beyond_the_cusps() -> list[Claim]:
    cusps = [chained(_CURVE, end, 1)[1] for end in (_CURVE.ascent_cusp, _CURVE.descent_cusp)]
    width = float(coordinates(_CURVE, _CURVE.descent_cusp)[1])
    width -= float(coordinates(_CURVE, _CURVE.ascent_cusp)[1])
    return [
        misprint(
            '30',
            'the arcs beyond the cusps are congruent to that between them: their width',
            ('BD, ED', NOTHING),
            width,
            ('BD, CE', cusps[0] - cusps[1]),
            'the arc at the other cusp, C, is meant',
        ),
    ]
