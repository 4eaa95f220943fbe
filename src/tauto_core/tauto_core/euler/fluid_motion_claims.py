"""Claims of paper B on the motion along the curve, §31–35: speeds, arcs, friction."""

from __future__ import annotations

import math

from tauto_core.curves import FluidTautochrone
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
    B,
    F,
    G,
    M,
    N,
    S,
    holds,
    misprint,
)

_QUARTER = 0.5 * math.pi * math.sqrt(F / G)
_CUSP = math.log1p(BETA) / GLOBE


def motion_claims() -> list[Claim]:
    """Return the claims of §31–35."""
    return [
        *_speeds(),
        *_fall(),
        *_descent_arc(),
        *_ascent_arc(),
        *_small_arcs(),
        *_loss(),
        *_friction(),
    ]


def _speeds() -> list[Claim]:
    v, x = check.speed_height(S), check.height(S)
    grown = math.exp(GLOBE * S)
    square = (8.0 * M**2 * A * S + 3.0 * (M - N) * N * F * x) ** 2
    return [
        holds(
            '31',
            'height of fall v of the speed at the arc s from A',
            'v = b c^{2κs} − (c^{κs} − 1)²/(2κ²f)',
            B * grown**2 - (grown - 1.0) ** 2 / (2.0 * GLOBE**2 * F),
            v,
            CLOSE,
        ),
        holds(
            '32',
            'the same, in terms of s and x',
            'v = b c^{3ns/4ma} − (8m²as + 3(m − n)nfx)²/(128m⁴a²f)',
            B * math.exp(3.0 * N * S / (4.0 * M * A)) - square / (128.0 * M**4 * A**2 * F),
            v,
            CLOSE,
        ),
    ]


def _fall() -> list[Claim]:
    grown = math.exp(GLOBE * S)
    square = (grown - 1.0) ** 2 / (2.0 * GLOBE**2 * F)
    factor = 9.0 * (M - N) * N**2 * F
    rest, curve = 24.0 * M**2 * N * A * S, math.expm1(GLOBE * S)
    return [
        misprint(
            '32',
            'the t of §13',
            (
                't = … c^{+3ns/8ma}(c^{3ns/8ma} − 1)²',
                grown * square,
            ),
            check.fallen(S),
            ('t = … c^{−3ns/4ma}(c^{3ns/8ma} − 1)²', square / grown**2),
            't must stay below 1/(2κ²f)',
        ),
        misprint(
            '32',
            'the curve that it is taken from',
            ('64m²aa', (64.0 * M**2 * A**2 * curve - rest) / factor),
            check.height(S),
            ('64m³aa', (64.0 * M**3 * A**2 * curve - rest) / factor),
            '§17 and §23 have m³',
        ),
    ]


def _descent_arc() -> list[Claim]:
    long = 8.0 * M * A / (3.0 * N)
    part = 9.0 * N**2 * B * F / (32.0 * M**2 * A**2)
    fastest = check.root(
        lambda s: 2.0 * GLOBE * check.speed_height(s) - GAMMA * check.slope(s), 1e-3, 0.3
    )
    reach = 3.0 * N * math.sqrt(B * F / 2.0) / (4.0 * M * A)
    start = check.root(lambda s: check.fallen(s) - B, 0.1, _CUSP)
    return [
        misprint(
            '33',
            'arc before A at which the descent is fastest',
            ('s = (8ma/3n)(1 − 9n²bf/32m²a²)', long * (1.0 - part)),
            fastest,
            ('s = −(8ma/3n) l(1 − 9n²bf/32m²a²)', -long * math.log1p(-part)),
            'l and sign are lost',
        ),
        holds(
            '33',
            'arc of the descent',
            '(8ma/3n) l(1/(1 − 3n√(bf/2)/4ma))',
            -long * math.log1p(-reach),
            start,
            CLOSE,
        ),
    ]


def _ascent_arc() -> list[Claim]:
    long = 8.0 * M * A / (3.0 * N)
    reach = 3.0 * N * math.sqrt(B * F / 2.0) / (4.0 * M * A)
    start = check.root(lambda s: check.fallen(s) - B, 0.1, _CUSP)
    end = -check.swing(start)[1]
    return [
        holds(
            '34',
            'arc of the ascent',
            '(8ma/3n) l(1 + 3n√(bf/2)/4ma)',
            long * math.log1p(reach),
            end,
            CLOSE,
        ),
        misprint(
            '34',
            'which arc has the + under the logarithm, compared with the arc of descent',
            ('totus arcus descensus: l(1 + …)', long * math.log1p(reach)),
            start,
            (
                'descensus: l(1/(1 − …)); l(1 + …) is totus arcus ascensus',
                -long * math.log1p(-reach),
            ),
            'resistance makes the ascent shorter',
        ),
    ]


def _small_arcs() -> list[Claim]:
    small = 1e-4
    arc = check.root(lambda s: check.fallen(s) - small, 1e-3, _CUSP)
    other = -check.swing(arc)[1]
    half = math.sqrt(small * F / 2.0)
    first = [2.0 * half, 2.0 * GLOBE * half**2]
    right = sum(first) + 8.0 * GLOBE**2 * half**3 / 3.0 + 4.0 * GLOBE**3 * half**4
    lost = sum(first) + 8.0 * GLOBE**2 * half**4 / 3.0 + 4.0 * GLOBE**3 * half**6
    # what the leading terms leave out, by the square of κ√(2bf)
    rough = (2.0 * GLOBE * half) ** 2
    return [
        misprint(
            '34',
            'series of the arcs',
            ('(bf/2)², (bf/2)³', lost),
            arc,
            ('(bf/2)^{3/2}, (bf/2)²', right),
            'the powers of √(bf/2) rise by one',
            1e-8,
        ),
        holds(
            '34',
            'sum of both arcs, for a small b',
            '2√(2bf)',
            4.0 * half,
            arc + other,
            rough,
        ),
        holds(
            '34',
            'difference of both arcs, for a small b',
            '3nbf/4ma',
            3.0 * N * small * F / (4.0 * M * A),
            arc - other,
            rough,
        ),
    ]


def _loss() -> list[Claim]:
    start = check.root(lambda s: check.fallen(s) - B, 0.1, _CUSP)
    end = -check.swing(start)[1]
    return [
        holds(
            '33-34',
            'not noticed by Euler: the arc from the greatest speed to A equals the loss of arc',
            '−l(1 − 2κ²bf)/κ',
            -math.log1p(-2.0 * GLOBE**2 * B * F) / GLOBE,
            start - end,
            CLOSE,
        ),
    ]


def _friction() -> list[Claim]:
    mu = 0.03
    return [
        holds(
            '35',
            'additional constant resistance: with x − μs for x the time of descent is unchanged',
            '(π/2) √(f/g)',
            _QUARTER,
            check.quarter(S, mu),
            CLOSE,
        ),
        misprint(
            '35',
            'the term added to x (g negative on the descent)',
            ('x + gr', NOTHING),
            check.slope(S) + mu,
            ('x + g s', check.derivative(_with_friction, S)),
            'the resistance acts along the arc s',
            FAIR,
        ),
    ]


def _with_friction(s: float) -> float:
    return float(FluidTautochrone(GLOBE, GAMMA, F, 0.03).height(s))
