"""The claims of paper C, 'De motu penduli circa axem cylindricum' (Acta 1780 II).

Printed formulas are evaluated as they stand; the paper's 2g is G here. Computed values come from
`axle_truth` and from quadrature.
"""

from __future__ import annotations

import math

import numpy as np

from tauto_core.euler import axle_truth as truth
from tauto_core.euler.axle_truth import PHI, SPEED, SPIN, THETA, TIME, C, E, G, K, TrueModes
from tauto_core.euler.claim import Claim
from tauto_core.machines.axle_pendulum import (
    AxlePendulum,
    AxleState,
    amplitudes_from_rest,
    forces,
    plane_period,
    small_motion,
)
from tauto_core.machines.modes import modes

EXACT = 1e-12
CLOSE = 1e-9
"""Tolerance of values from an integrated motion."""


def claims() -> list[Claim]:
    """Return every claim of the paper, in its order."""
    return [
        *_geometry(),
        *_equations(),
        *_first_solution(),
        *_second_solution(),
        *_from_rest(),
        *_regular(),
        *_plane(),
        *_periods(),
        *_any_motion(),
        *_convex(),
        *_cradle(),
    ]


def _geometry() -> list[Claim]:
    centre = E * np.exp(1j * THETA) + C * np.exp(1j * PHI)
    return [
        Claim(
            'C', '5', 'tilt of the body, from the position of its centre of gravity',
            'cos θ = (x − e cos θ)/c',
            math.cos(THETA), (float(centre.real) - E * math.cos(THETA)) / C, EXACT,
            'cos Φ = (x − e cos θ)/c', math.cos(PHI),
            'the angle of the body is Φ; θ is that of the contact', 'misprint',
        ),
    ]  # fmt: skip


def _equations() -> list[Claim]:
    printed, true = truth.by_euler(), truth.by_lagrange()
    theta, phi = 4e-8, -7e-8
    body = AxlePendulum(1.0 / E, C, K, G)
    tiny = forces(body, AxleState(E * theta, phi, 0.0, 0.0))
    bend, turn = float(tiny.tilt_acceleration), float(tiny.arc_acceleration) / E
    return [
        Claim(
            'C', '8-10', 'the equations of motion are exact at any angles: θ̈ far from rest',
            'ẍ sin θ − ÿ cos θ = 2g sin θ', float(printed[0]), float(true[0]), EXACT,
        ),
        Claim(
            'C', '8-10', 'and φ̈',
            'c sin(Φ−θ)(ẍ cos θ + ÿ sin θ) = k²Φ̈ + 2gc cos θ sin(Φ−θ)',
            float(printed[1]), float(true[1]), EXACT,
        ),
        Claim(
            'C', '11', "the centre of gravity's height under the bearing's centre, x",
            'x = e cos θ + c cos Φ', E * math.cos(THETA) + C * math.cos(PHI),
            float((E * np.exp(1j * THETA) + C * np.exp(1j * PHI)).real), EXACT,
        ),
        Claim(
            'C', '12-13', 'small swings: θ̈', 'e θ̈ + c Φ̈ = −2gθ',
            (-G * theta - C * bend) / E, turn, EXACT,
        ),
        Claim(
            'C', '12-13', 'small swings: Φ̈', 'k² Φ̈ = −2gc(Φ − θ)',
            -G * C * (phi - theta) / K**2, bend, EXACT,
        ),
    ]  # fmt: skip


def _first_solution() -> list[Claim]:
    true = truth.true_modes(E, C, K)
    f = 0.5 * (C + E - K * K / C)
    root = math.sqrt(f * f + K * K)
    own, tied = K * K + C * f, E * K * K
    a, b, d = 0.5, 0.7, 1.3
    z = ((a - b * C) * THETA + b * C * PHI) / d
    lost_c = 'c is missing before the root: a length is added to an area'
    return [
        Claim(
            'C', '15', 'θ from Dz = (A − Bc)θ + BcΦ', 'θ = Dz/A − BcΦ/(Bc)',
            d * z / a - PHI, THETA, EXACT,
            'θ = Dz/(A − Bc) − BcΦ/(A − Bc)', (d * z - b * C * PHI) / (a - b * C),
            'the divisor A − Bc is split in two', 'misprint',
        ),
        Claim(
            'C', '17-21', 'length of the slow mode, first solution',
            'b = ekk/(kk + cf − √(ff + kk)), 2f = c + e − kk/c',
            tied / (own - root), true.b, EXACT,
            'b = ekk/(kk + cf − c√(ff + kk))', tied / (own - C * root), lost_c, 'misprint',
        ),
        Claim(
            'C', '17-21', 'length of the fast mode, first solution',
            'b′ = ekk/(kk + cf + √(ff + kk))', tied / (own + root), true.b_prime, EXACT,
            'b′ = ekk/(kk + cf + c√(ff + kk))', tied / (own + C * root), lost_c, 'misprint',
        ),
        _sum_of_modes(f, root, true),
        _time_of_a_swing(true),
    ]  # fmt: skip


def _sum_of_modes(f: float, root: float, true: TrueModes) -> Claim:
    """§19: z and z′ are the modes' shares of the state, over −A and −A′ = −f ∓ √(ff + kk)."""
    whole = 0.0
    for a, other in ((f + root, true.B), (f - root, true.B_prime)):
        # (1, −c/other) leaves out the mode in which φ : θ = other : c
        whole += -(THETA - C * PHI / other) / a
    return Claim(
        'C', '19', 'the sum of both solutions',
        'θ + Φ(ef + kk)/(ef) = (kk/2f)(z + z′)',
        THETA + PHI * (E * f + K * K) / (E * f), K * K / (2.0 * f) * whole, EXACT,
        'θ + Φ(cf + kk)/(ef) = (kk/2f)(z + z′)', THETA + PHI * (C * f + K * K) / (E * f),
        'e for c; the right side is garbled in print as well', 'misprint',
    )  # fmt: skip


def _time_of_a_swing(true: TrueModes) -> Claim:
    quarter = 0.5 * truth.half_period(true.B)
    return Claim(
        'C', '20', 'time from the middle to the end of a swing, dt = √(b/2g) dz/√(αα − zz)',
        'g dz²/b = dz²/(αα − zz)', 0.5 * math.pi * math.sqrt(true.b / (0.5 * G)), quarter, CLOSE,
        '2g dt²/b = dz²/(αα − zz)', 0.5 * math.pi * math.sqrt(true.b / G),
        'the 2 of 2g is lost, and dz² stands for dt²', 'misprint',
    )  # fmt: skip


def _second_solution() -> list[Claim]:
    true = truth.true_modes(E, C, K)
    f = 0.5 * (K * K + C * C - C * E) / C
    root = math.sqrt(f * f + C * E)
    theta, phi = 4e-8, -7e-8
    tiny = forces(AxlePendulum(1.0 / E, C, K, G), AxleState(E * theta, phi, 0.0, 0.0))
    bend = float(tiny.tilt_acceleration)
    right = G * (C * theta - C * phi) / K**2
    return [
        Claim(
            'C', '22-23', 'angular acceleration of the body', 'kk Φ̈/g = −cΦ + cθ',
            0.5 * right, bend, EXACT, 'kk Φ̈/2g = −cΦ + cθ', right,
            'the 2 of 2g is lost', 'misprint',
        ),
        Claim(
            'C', '22-23', 'angular acceleration of the body', 'kk Φ̈/2g = −cΦ + eθ',
            G * (E * theta - C * phi) / K**2, bend, EXACT, 'kk Φ̈/2g = −cΦ + cθ', right,
            'e for c', 'misprint',
        ),
        Claim(
            'C', '24-28', 'tilt of the body in the slow mode', 'B = f + √(ff + ce)',
            f + root, true.B, EXACT,
        ),
        Claim(
            'C', '24-28', 'tilt of the body in the fast mode', 'B′ = f − √(ff + ce)',
            f - root, true.B_prime, EXACT,
        ),
        Claim('C', '26-28', 'length of the slow mode', 'b = e + B', E + f + root, true.b, EXACT),
        Claim(
            'C', '26-28', 'length of the fast mode', 'b′ = e + B′',
            E + f - root, true.b_prime, EXACT,
        ),
    ]  # fmt: skip


def _from_rest() -> list[Claim]:
    true = truth.true_modes(E, C, K)
    body = AxlePendulum(1.0 / E, C, K, G)
    alpha, other = amplitudes_from_rest(body, SPEED, SPIN)
    slow, fast = math.sqrt(G / true.b), math.sqrt(G / true.b_prime)
    pushed = truth.pushed_amplitudes()
    theta = C * (alpha * math.sin(slow * TIME) + other * math.sin(fast * TIME))
    phi = alpha * true.B * math.sin(slow * TIME) + other * true.B_prime * math.sin(fast * TIME)
    after = truth.pushed_motion(TIME)
    return [
        Claim(
            'C', '29', 'the contact after half a second, from equilibrium',
            'θ = Σ αc sin(t√(2g/b) + δ)', theta, float(after[0]), CLOSE,
        ),
        Claim(
            'C', '29', 'the body after half a second, from equilibrium',
            'Φ = Σ αB sin(t√(2g/b) + δ)', phi, float(after[1]), CLOSE,
        ),
        Claim(
            'C', '30-32', 'amplitude of the slow mode',
            'α√(2g/b) = νb′/(2e√(ff + ce)) − nB′/(2ce√(ff + ce))',
            alpha, float(pushed[0]), EXACT,
        ),
        Claim(
            'C', '30-32', 'amplitude of the fast mode',
            'α′√(2g/b′) = −νb/(2e√(ff + ce)) + nB/(2ce√(ff + ce))',
            other, float(pushed[1]), EXACT,
        ),
        Claim(
            'C', '30-32', 'velocity of the centre of gravity', 'n = αc√(2gb) + α′c√(2gb′)',
            C * (alpha * math.sqrt(G * true.b) + other * math.sqrt(G * true.b_prime)),
            SPEED, EXACT,
        ),
        Claim(
            'C', '32', 'angular velocity of the body', 'v = −R√(…)',
            math.nan, SPIN, EXACT,
            'ν = αB√(2g/b) + α′B′√(2g/b′)', alpha * true.B * slow + other * true.B_prime * fast,
            'the formula is garbled', 'misprint',
        ),
    ]  # fmt: skip


def _regular() -> list[Claim]:
    body = AxlePendulum(1.0 / E, C, K, G)
    slow, _ = body.modes.tilt_per_arc
    time = math.pi / math.sqrt(body.modes.squared_frequencies(G)[0])
    start = np.array([1e-3, 1e-3 * slow * E, 0.0, 0.0])
    point, simple = truth.true_modes(E, C, 0.0), np.linalg.eigvals(np.array([[0.0, C], [0.0, C]]))
    return [
        Claim(
            'C', '33-35', 'a motion in one mode stays in that mode: φ after half a period',
            'Φ : θ = B : c always', -float(start[1]),
            float(truth.linear_motion(E, start, time)[1]), CLOSE,
        ),
        Claim('C', '36', 'a body without extent, k = 0', 'b = c + e', C + E, point.b, EXACT),
        Claim(
            'C', '36', 'then f', 'f = c/2 = e', 0.5 * C,
            0.5 * (point.B + point.B_prime), EXACT,
            'f = (c − e)/2', 0.5 * (C - E), 'the minus is printed as =', 'misprint',
        ),
        Claim(
            'C', '36', 'a simple pendulum, k = e = 0', 'b = c', C,
            float(np.max(simple)), EXACT,
        ),
    ]  # fmt: skip


def _plane() -> list[Claim]:
    body, far = AxlePendulum(0.0, C, K, G), truth.true_modes(1e4, C, K)
    fast = G * (plane_period(body, 1e-7) / math.tau) ** 2
    swing = truth.on_a_plane(body, 1.0, 0.4)
    drift = small_motion(body, AxleState(0.0, 0.0, 0.2, 0.0), 3.0)
    return [
        Claim(
            'C', '37', 'on a plane, e → ∞: b′ = (ekk/2c) : f with f = e/2', 'ekkk/2c',
            K**3 / C, fast, EXACT, 'ekk/2c', K**2 / C, 'one k too many', 'misprint',
        ),
        Claim(
            'C', '37-38', 'on a nearly flat support, e = 10 km', 'b = e + c',
            1e4 + C, far.b, 1e-8,
        ),
        Claim(
            'C', '37-38', 'and the fast mode, to first order in c/e', 'b′ = (kk/c)(1 − c/e)',
            K * K / C * (1.0 - C / 1e4), far.b_prime, 1e-8,
        ),
        Claim(
            'C', '38', 'on a plane the axle moves opposite to the body, at any angle',
            's = −c sin Φ', -C * (math.sin(swing[1]) - math.sin(1.0)), float(swing[0]), CLOSE,
        ),
        Claim(
            'C', '39', 'the paragraph between 38 and 40', '§29', math.nan, 39.0, 0.0,
            '§39', 39.0, 'a 2 for a 3', 'misprint',
        ),
        Claim(
            'C', '39-40', 'after a push the body moves on steadily, without swinging: s after 3 s',
            's = nt, Φ = 0', 0.6, float(np.asarray(drift.arc)), EXACT,
        ),
    ]  # fmt: skip


def _periods() -> list[Claim]:
    true = truth.true_modes(E, C, K)
    total = K * K + C * C + C * E
    root = math.sqrt(K**4 + 2.0 * C * K * K * (C - E) + (C * (C + E)) ** 2)
    return [
        Claim(
            'C', '41', 'an oscillation (half a period) of the slow mode', 'π√(b/2g)',
            math.pi * math.sqrt(true.b / G), truth.half_period(true.B), CLOSE,
        ),
        Claim(
            'C', '41', 'an oscillation of the fast mode', 'π√(b′/2g)',
            math.pi * math.sqrt(true.b_prime / G), truth.half_period(true.B_prime), CLOSE,
        ),
        Claim(
            'C', '42', 'both lengths without f: the slow mode',
            'b = (kk + cc + ce + √(k⁴ + 2ckk(c − e) + cc(c + e)²))/2c',
            (total + root) / (2.0 * C), true.b, EXACT,
        ),
        Claim(
            'C', '42', 'the fast mode', 'b′ = (kk + cc + ce − √(…))/2c',
            (total - root) / (2.0 * C), true.b_prime, EXACT,
        ),
    ]  # fmt: skip


def _any_motion() -> list[Claim]:
    start = np.array([0.02, -0.03, 0.1, 0.2])
    body = AxlePendulum(1.0 / E, C, K, G)
    found = small_motion(body, AxleState(E * start[0], start[1], E * start[2], start[3]), TIME)
    true, after = truth.true_modes(E, C, K), truth.linear_motion(E, start, TIME)
    alpha, other = amplitudes_from_rest(body, SPEED, SPIN)
    pushed = float(truth.pushed_motion(TIME)[0])
    waves = [
        size * math.sin(TIME * math.sqrt(G / length))
        for size, length in ((alpha, true.b), (other, true.b_prime))
    ]
    return [
        Claim(
            'C', '43', 'any small motion is the sum of both modes: Φ after half a second',
            'Φ = Σ αB sin(t√(2g/b) + δ)', float(np.asarray(found.tilt)), float(after[1]), CLOSE,
        ),
        Claim(
            'C', '44', 'path of the axle, s = eθ, from equilibrium',
            's = ae′c sin … + a′ec sin …', math.nan, E * pushed, CLOSE,
            's = αec sin t√(2g/b) + α′ec sin t√(2g/b′)', E * C * sum(waves),
            'the primes are misplaced', 'misprint',
        ),
    ]  # fmt: skip


def _convex() -> list[Claim]:
    i = 0.5
    true, own = truth.true_modes(-i, C, K), modes(-i, C, K * K)
    rate, ratio = math.sqrt(-G / own.b_prime), own.B_prime / C
    after = truth.linear_motion(-i, np.array([0.0, 0.0, 1e-3 * rate, 1e-3 * rate * ratio]), TIME)
    return [
        Claim(
            'C', '45', 'the letter of the depth of the centre of gravity', 'cg = e',
            math.nan, C, 0.0, 'cg = c', C, 'e for c', 'misprint',
        ),
        Claim(
            'C', '45', 'on a convex support of radius i, e becomes −i: the mode that swings',
            'b', own.b, max(true.b, true.b_prime), EXACT,
        ),
        Claim(
            'C', '46', 'the other length is negative, which "is to be feared"', 'b′', own.b_prime,
            min(true.b, true.b_prime), EXACT,
        ),
        Claim(
            'C', '46', 'the unstable mode, half a second after a push',
            'α′c sin t√(2g/b′)', math.nan, float(after[0]), CLOSE,
            'α′c sinh t√(2g/−b′)', 1e-3 * math.sinh(rate * TIME),
            'the root is imaginary, and its sine a sinh', 'misprint',
        ),
        Claim(
            'C', '47', 'it is certain: share of a thousand random bodies on convex supports that '
                       'are unstable',
            'b b′ = −ikk/c < 0', 1.0, truth.part_that_falls(), 0.0,
        ),
    ]  # fmt: skip


def _cradle() -> list[Claim]:
    e, c, k = 1.2, 0.25, 0.4
    true, own = truth.true_modes(e, c, k), modes(e, c, k * k)
    high, above = modes(e, -c, k * k), np.linalg.eigvals(np.array([[e, -c], [e, -c - k * k / c]]))
    slow, fast = own.tilt_per_arc
    return [
        Claim(
            'C', '48', 'a cradle, C the centre of its rockers: the slow mode', 'b',
            own.b, true.b, EXACT,
        ),
        Claim(
            'C', '49', 'with the centre of gravity above C it is unstable: the negative length',
            'b < 0', high.b, float(np.min(above)), EXACT,
        ),
        Claim('C', '50-51', 'the fast mode', 'b′', own.b_prime, true.b_prime, EXACT),
        Claim(
            'C', '51', 'tilt over path of the cradle, slow mode', 'Φ/s = B/ce',
            slow, true.B / (c * e), EXACT,
        ),
        Claim(
            'C', '51', 'tilt over path of the cradle, fast mode', 'Φ/s = B′/ce',
            fast, true.B_prime / (c * e), EXACT,
        ),
        Claim(
            'C', '52', 'the letter of the depth', 'e′', math.nan, c, 0.0, 'c', c,
            'e′ for c', 'misprint',
        ),
        Claim(
            'C', '53', 'the letters of both lengths: b + b′', 'h, h′', math.nan,
            true.b + true.b_prime, EXACT, 'b, b′', own.b + own.b_prime, 'h for b', 'misprint',
        ),
    ]  # fmt: skip
