"""Claims of paper B on the curve, §2–22: descent, ascent, and both together."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.curves.descent_curve import ActaCurve
from tauto_core.euler import fluid_checks as check
from tauto_core.euler.claim import Claim
from tauto_core.euler.fluid_checks import (
    CLOSE,
    CYLINDER,
    FAIR,
    GAMMA,
    GLOBE,
    NOTHING,
    A,
    B,
    E,
    F,
    G,
    H,
    M,
    N,
    S,
    holds,
    misprint,
)
from tauto_core.machines.half_swing import descent_time

_QUARTER = 0.5 * math.pi * math.sqrt(F / G)


def curve_claims() -> list[Claim]:
    """Return the claims of §2–22."""
    return [
        *_of_the_acta(),
        *_motion(),
        *_cylinder(),
        *_cylinder_by_height(),
        *_globe(),
        *_without_fluid(),
        *_ascent(),
        *_both(),
    ]


def _of_the_acta() -> list[Claim]:
    curve = ActaCurve(GLOBE, GAMMA, F, S)
    return [
        holds(
            '2-5',
            'on the curve of the Acta of 1726 only the descent from the arc S that it is made '
            'for takes (π/2)√(f/g)',
            'γf dx/ds = s + κ(S² − s²)',
            _QUARTER,
            descent_time(curve, G, S),
            CLOSE,
        ),
    ]


def _motion() -> list[Claim]:
    v, p = check.speed_height(S), check.slope(S)
    grown = math.exp(2.0 * GLOBE * S)
    return [
        misprint(
            '12',
            'speed along the curve, cylinder (here of the same κ)',
            ('dv  n v ds/ma  (m − n) dx/m', NOTHING),
            check.derivative(check.speed_height, S),
            ('dv − n v ds/(ma) = −(m − n) dx/m', 2.0 * GLOBE * v - (M - N) / M * p),
            'signs and "=" are lost in the print',
            FAIR,
        ),
        holds(
            '13',
            'height of fall v of the speed, with t = γ ∫ e^{−2κs} dx',
            'v = e^{2κs} (b − t)',
            grown * (B - check.fallen(S)),
            v,
            CLOSE,
        ),
    ]


def _cylinder() -> list[Claim]:
    k = CYLINDER
    q = math.exp(-N * S / (2.0 * M * A))
    rate = M * A / N * (1.0 - q) * q / E
    return [
        misprint(
            '14',
            'the time does not depend on b, the value of v at A, if √t is proportional to ∫ '
            'e^{−κs} ds',
            ('∫ dt/√(bt − it)', NOTHING),
            math.pi,
            ('∫ dt/√(bt − tt) = π for any b', _time_of_any_fall()),
            'i has no meaning: the square of t is meant',
        ),
        holds(
            '14-15',
            'the curve for a cylinder, in terms of t; q = c^{−ns/2ma}',
            '(m²a²/n²)(1 − q)² = e t',
            M**2 * A**2 / N**2 * (1.0 - q) ** 2 / E,
            check.fallen(S, k),
            CLOSE,
        ),
        misprint(
            '15',
            'its differential',
            ('(na/n)(1 − q) q ds = e dt', A * (1.0 - q) * q / E),
            check.derivative(lambda s: check.fallen(s, k), S),
            ('(ma/n)(1 − q) q ds = e dt', rate),
            'the printed factor is a; the curve needs ma/n',
            FAIR,
        ),
        holds(
            '15',
            'length of the simple pendulum: a quarter swing takes (π/2)√(2e/g)',
            'f = 2e',
            0.5 * math.pi * math.sqrt(2.0 * E / G),
            check.quarter(S),
            CLOSE,
        ),
    ]


def _cylinder_by_height() -> list[Claim]:
    k = CYLINDER
    x = check.height(S, k)
    rest = M**2 * N * A * S
    denominator = (M - N) * N**2 * E
    grown = math.expm1(N * S / (2.0 * M * A))
    right = (2.0 * M**3 * A**2 * grown - rest) / denominator
    return [
        misprint(
            '16',
            'the curve for a cylinder, in terms of x',
            (
                'c^{ns/2ma} with 2m^{3/2}aa/n',
                (2.0 * M**1.5 * A**2 * grown - rest) / denominator,
            ),
            x,
            ('c^{ns/2ma} = [m²nas + 2m³aa + (m − n)n²ex]/(2m³aa)', right),
            'the power of m must make both sides lengths times m³: 2m³aa/n',
        ),
        misprint(
            '16',
            'the same after integration',
            ('− mmads', NOTHING),
            x,
            ('− mmas', right),
            'a differential is left after the integration',
        ),
        misprint(
            '16',
            'the same, the factor of x',
            ('(m − n) n^{2/2} e x', (2.0 * M**3 * A**2 * grown - rest) / ((M - N) * N * E)),
            x,
            ('(m − n) n² e x', right),
            'n^{2/2} would be n; the other terms have n²',
        ),
        holds(
            '16',
            'logarithmic form',
            'κs = l(1 + κs + γκ²f x)',
            math.log1p(k * S + GAMMA * k * k * F * x) / k,
            S,
            CLOSE,
        ),
        holds(
            '17',
            'differential form, cylinder',
            'm²as ds + (m − n)nex ds = 2(m − n)mae dx',
            (M**2 * A * S + (M - N) * N * E * x) / (2.0 * (M - N) * M * A * E),
            check.slope(S, k),
            CLOSE,
        ),
    ]


def _time_of_any_fall() -> float:
    """Return ∫ dt/√(bt − t²) from 0 to b, with t = b sin²u, by a sum."""
    u = (np.arange(16) + 0.5) * (0.5 * math.pi / 16)
    t = B * np.sin(u) ** 2
    speed = 2.0 * B * np.sin(u) * np.cos(u)
    return float(np.sum(speed / np.sqrt(B * t - t * t)) * (0.5 * math.pi / 16))


def _globe() -> list[Claim]:
    x, slope = check.height(S), check.slope(S)
    factor = 9.0 * (M - N) * N**2 * F
    grown = math.expm1(3.0 * N * S / (8.0 * M * A))
    right = (64.0 * M**3 * A**2 * grown - 24.0 * M**2 * N * A * S) / factor
    differential = (8.0 * M**2 * A * S + 3.0 * (M - N) * N * F * x) / (8.0 * (M - N) * M * A * F)
    weak = 3.0 * N / (4.0 * M * A)
    drag = 0.5 * 0.5 * N * 0.25 * math.pi * A**2 / (M * math.pi / 6.0 * A**3)
    return [
        holds(
            '17',
            'a globe is resisted like a cylinder of height 4a/3 (drag coefficient 1/2 on its '
            'section)',
            'κ = 3n/8ma',
            3.0 * N / (8.0 * M * A),
            drag,
            CLOSE,
        ),
        misprint(
            '17, 23, 31',
            'height of the cylinder equivalent to a globe, checked by x of its curve',
            (
                '2/3 a loco a',
                (math.expm1(weak * S) - weak * S) / (GAMMA * weak * weak * F),
            ),
            x,
            ('4/3 a loco a', right),
            '§17 prints 4/3, and only 4/3 gives 64, 24, 9 and 3n/8ma',
        ),
        holds(
            '17, 23',
            'the curve for a globe',
            '64m³a²(c^{3ns/8ma} − 1) − 24m²nas = 9(m − n)n²fx',
            right,
            x,
            CLOSE,
        ),
        misprint(
            '17, 23',
            'its differential form',
            ('fxdx, f c ds, nexds', NOTHING),
            slope,
            ('8m²as ds + 3(m − n)nfx ds = 8(m − n)maf dx', differential),
            'letters are mixed up: everywhere f x ds',
        ),
    ]


def _without_fluid() -> list[Claim]:
    return [
        holds(
            '18',
            'without a fluid the curve is the cycloid',
            's² = 2fx',
            S * S / (2.0 * F),
            GAMMA * check.height(S, kappa=1e-11),
            CLOSE,
        ),
    ]


def _ascent() -> list[Claim]:
    u = check.height(-S, length=H)
    scale = GAMMA * GLOBE**2
    k = GLOBE * S
    right = (math.exp(-k) - 1.0 + k) / (scale * H)
    forward = check.swing(S)[0] - check.quarter(S)
    return [
        holds(
            '19-20',
            'the branch of ascent, t in place of −s',
            'γκ²h u = c^{−κt} − 1 + κt',
            right,
            u,
            CLOSE,
        ),
        holds(
            '19-20',
            'ascents take the same time, whatever their arc',
            '(π/2) √(h/g), here h = f',
            _QUARTER,
            forward,
            CLOSE,
        ),
        misprint(
            '20-23, 28',
            'pendulum length of the ascent',
            ('b', (math.exp(-k) - 1.0 + k) / (scale * B)),
            u,
            ('h', right),
            'b is the height of fall at A; the length is h',
        ),
        misprint(
            '23, 28',
            'the exponential of the ascent',
            ('c^{+3nt/8ma}', (math.exp(k) - 1.0 + k) / (scale * H)),
            u,
            ('c^{−3nt/8ma}', right),
            's has become −t',
        ),
    ]


def _both() -> list[Claim]:
    q = 0.5
    start = -math.log1p(-q) / GLOBE
    # down a branch of f, up one of h
    time = check.quarter(S) + check.ascent(S, H)
    length = G * (time / math.pi) ** 2
    whole = check.swing(S)[0]
    back = check.swing(-start)[0]
    return [
        holds(
            '21',
            'pendulum of the composed oscillation, down f and up h',
            'L = (f + 2√(fh) + h)/4',
            0.25 * (F + 2.0 * math.sqrt(F * H) + H),
            length,
            CLOSE,
        ),
        holds(
            '22',
            'f = h gives one continuous curve, and the half swing down and up takes π√(f/g)',
            'π √(f/g)',
            2.0 * _QUARTER,
            whole,
            CLOSE,
        ),
        Claim(
            'B',
            '22',
            'perhaps swings in the other direction, down the branch of ascent, take π√(f/g) too '
            f'(q = 1 − c^(−κs) = {q:g} at the start)',
            '1',
            1.0,
            back / (2.0 * _QUARTER),
            CLOSE,
            because='w = (c^{κs} − 1)/κ obeys ẅ = −(g/f)(w + κw²): T = 1 + 5q²/12 − 5q³/18 + …, '
            '1.00395 at q = 0.1, 1.0984 at 0.5, 1.538 at 0.9, without bound; the errors of the '
            'two quarters, ±4q/3π, cancel, so that it fails only at second order',
            expected='fails',
        ),
    ]
