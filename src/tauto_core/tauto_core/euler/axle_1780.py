"""The claims of paper C, 'De motu penduli circa axem cylindricum' (Acta 1780 II).

Formulas are evaluated as they stand in the text; its 2g is G here, its e is a − b until §11.
Computed values come from reference values, found without those formulas, and from quadrature.
"""

from __future__ import annotations

import math
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.integrate import quad

from tauto_core.curves.numerics import root_of
from tauto_core.euler.edition import Claim, G
from tauto_core.machines.axle_pendulum import (
    AxlePendulum,
    AxleState,
    plane_period,
    small_motion,
)
from tauto_core.motion.axle import forces
from tauto_core.samples import FloatArray

# -----------------------------------------------------------------------------
# Reference values, found without the formulas of the paper.
#
# The eigenvalues of the flexibility matrix, whose rows are (e, c) and (e, c + k²/c), are b and b′;
# motions are integrated; Lagrange's equations check Euler's own.

E, C, K = 0.1, 0.3, 0.15
"""The body of the examples [m]."""

THETA, PHI, THETA_RATE, PHI_RATE = 0.4, -0.7, 1.1, -0.3
"""A state far from rest [rad, rad/s]."""

SPEED, SPIN, TIME = 0.01, 0.02, 0.5
"""Initial n [m/s] and ν [rad/s] of a motion from equilibrium, and its time of comparison [s]."""


class TrueModes(NamedTuple):
    """b, b′ and B, B′ = cφ/θ of both modes."""

    b: float
    b_prime: float
    B: float
    B_prime: float


def true_modes(e: float, c: float, k: float) -> TrueModes:
    """Return both modes from the flexibility matrix."""
    values, vectors = np.linalg.eig(np.array([[e, c], [e, c + k * k / c]]))
    # body and link tilt to the same side in the slow mode, to opposite sides in the fast one
    tilts = c * vectors[1] / vectors[0]
    slow = int(np.argmax(tilts))
    fast = 1 - slow
    return TrueModes(*(float(x) for x in (values[slow], values[fast], tilts[slow], tilts[fast])))


def linear_motion(e: float, start: FloatArray, time_s: float) -> FloatArray:
    """Return θ, φ and their rates after some time by the linear equations, through DOP853."""
    from scipy.integrate import solve_ivp

    def slope(_: float, y: FloatArray) -> list[float]:
        bend = -G * C / K**2 * (y[1] - y[0])
        return [y[2], y[3], (-G * y[0] - C * bend) / e, bend]

    found = solve_ivp(slope, (0.0, time_s), start, method='DOP853', rtol=1e-12, atol=1e-18)
    end: FloatArray = found.y[:, -1]
    return end


def time_to_rest(ratio: float) -> float:
    """Return when a body released in the shape θ : φ = c : ratio first comes to rest [s]."""

    def rate(time_s: float) -> float:
        return float(linear_motion(E, np.array([C, ratio, 0.0, 0.0]) * 1e-3, time_s)[3])

    guess = math.pi * math.sqrt((E + ratio) / G)
    return root_of(rate, 0.9 * guess, 1.1 * guess, 1e-14)


def by_euler() -> FloatArray:
    """Return θ̈ and φ̈ far from rest by §8–10, whose two equations are linear in both."""

    def excess(bend: FloatArray) -> FloatArray:
        x = -E * (bend[0] * math.sin(THETA) + THETA_RATE**2 * math.cos(THETA))
        x -= C * (bend[1] * math.sin(PHI) + PHI_RATE**2 * math.cos(PHI))
        y = E * (bend[0] * math.cos(THETA) - THETA_RATE**2 * math.sin(THETA))
        y += C * (bend[1] * math.cos(PHI) - PHI_RATE**2 * math.sin(PHI))
        delta = math.sin(PHI - THETA)
        turned = C * delta * (x * math.cos(THETA) + y * math.sin(THETA))
        return np.array(
            [
                x * math.sin(THETA) - y * math.cos(THETA) - G * math.sin(THETA),
                turned - K**2 * bend[1] - G * C * math.cos(THETA) * delta,
            ]
        )

    at_zero = excess(np.zeros(2))
    matrix = np.stack([excess(unit) - at_zero for unit in np.eye(2)], axis=1)
    return np.asarray(np.linalg.solve(matrix, -at_zero), np.float64)


def by_lagrange() -> FloatArray:
    """Return θ̈ and φ̈ far from rest by Lagrange's equations for a link and a body."""
    cosine, sine = math.cos(PHI - THETA), math.sin(PHI - THETA)
    mass = np.array([[E * E, E * C * cosine], [E * C * cosine, C * C + K * K]])
    force = [
        E * C * sine * PHI_RATE**2 - G * E * math.sin(THETA),
        -E * C * sine * THETA_RATE**2 - G * C * math.sin(PHI),
    ]
    return np.asarray(np.linalg.solve(mass, np.array(force, np.float64)), np.float64)


def on_a_plane(body: AxlePendulum, phi: float, time_s: float) -> FloatArray:
    """Return s, φ and rates after a release from rest, by the full equations."""
    from scipy.integrate import solve_ivp

    def slope(_: float, y: FloatArray) -> list[float]:
        now = forces(body, AxleState(*y))
        return [y[2], y[3], float(now.arc_acceleration), float(now.tilt_acceleration)]

    found = solve_ivp(
        slope, (0.0, time_s), [0.0, phi, 0.0, 0.0], method='DOP853', rtol=1e-12, atol=1e-14
    )
    end: FloatArray = found.y[:, -1]
    return end


def part_that_falls() -> float:
    """Return the share of 1000 random bodies on convex supports that have an unstable mode."""
    rng = np.random.default_rng(1780)
    e, c, k = 10.0 ** rng.uniform(-2.0, 2.0, (3, 1000))
    matrices = np.stack([np.stack([-e, c], 1), np.stack([-e, c + k * k / c], 1)], 1)
    return float(np.mean(np.min(np.linalg.eigvals(matrices).real, axis=1) < 0.0))


def pushed_motion(time_s: float) -> FloatArray:
    """Return θ, φ and their rates after the push of SPEED and SPIN in equilibrium."""
    return linear_motion(E, np.array([0.0, 0.0, (SPEED - C * SPIN) / E, SPIN]), time_s)


def pushed_amplitudes() -> FloatArray:
    """Return α and α′ of that motion, its components along the eigenvectors."""
    own = true_modes(E, C, K)
    slow, fast = math.sqrt(G / own.b), math.sqrt(G / own.b_prime)
    shapes = np.array([[C * slow, C * fast], [own.B * slow, own.B_prime * fast]])
    return np.asarray(
        np.linalg.solve(shapes, np.array([(SPEED - C * SPIN) / E, SPIN])), np.float64
    )


# -----------------------------------------------------------------------------
# The claims.

TIGHT = 1e-12
CLOSE = 1e-9
"""Tolerance of values from an integrated motion."""

_claim = partial(Claim, 'C')


def claims() -> list[Claim]:
    """Return every claim of the paper, in its order."""
    return [
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


def _lengths(e: float, c: float, k: float, power: int = 4) -> tuple[float, float]:
    """Return b and b′ by §42; `power` is the exponent of k under the root."""
    total = k * k + c * c + c * e
    root = math.sqrt(k**power + 2.0 * c * k * k * (c - e) + (c * (c + e)) ** 2)
    return (total + root) / (2.0 * c), (total - root) / (2.0 * c)


def _pushed() -> tuple[float, float]:
    """Return α and α′ of a push from equilibrium by the two formulas of §32."""
    b, b_prime = _lengths(E, C, K)
    f = (K * K + C * C - C * E) / (2.0 * C)
    root = math.sqrt(f * f + C * E)
    slow = SPIN * b_prime / (2.0 * E * root) - SPEED * (f - root) / (2.0 * C * E * root)
    fast = -SPIN * b / (2.0 * E * root) + SPEED * (f + root) / (2.0 * C * E * root)
    return slow / math.sqrt(G / b), fast / math.sqrt(G / b_prime)


def _equations() -> list[Claim]:
    centre = E * np.exp(1j * THETA) + C * np.exp(1j * PHI)
    euler, true = by_euler(), by_lagrange()
    theta, phi = 4e-8, -7e-8
    tiny = forces(AxlePendulum(1.0 / E, C, K, G), AxleState(E * theta, phi, 0.0, 0.0))
    bend, turn = float(tiny.tilt_acceleration), float(tiny.arc_acceleration) / E
    return [
        _claim(
            '5', 'tilt of the body, from the position of its centre of gravity',
            'cos. θ = (x − (a − b) cos. θ)/c',
            math.cos(THETA), (float(centre.real) - E * math.cos(THETA)) / C, TIGHT,
            'cos. Φ = (x − (a − b) cos. θ)/c', math.cos(PHI),
            'the angle of the body is *Φ*; *θ* is that of the contact', 'corrected',
        ),
        _claim(
            '8-10', 'the equations of motion are exact at any angles: *θ̈* far from rest',
            'ddx sin. θ − ddy cos. θ = 2gdt² sin. θ', float(euler[0]), float(true[0]), TIGHT,
        ),
        _claim(
            '8-10', 'and *Φ̈*',
            'c sin. (Φ − θ)(ddx cos. θ + ddy sin. θ) = kkddΦ + 2gcdt² cos. θ sin. (Φ − θ)',
            float(euler[1]), float(true[1]), TIGHT,
        ),
        _claim(
            '11', "the centre of gravity's depth under the centre of the support",
            'x = e cos. θ + c cos. Φ', E * math.cos(THETA) + C * math.cos(PHI),
            float(centre.real), TIGHT,
        ),
        _claim(
            '12-13', 'small swings: *θ̈*', '(eddθ + cddΦ)/dt² = −2gθ',
            (-G * theta - C * bend) / E, turn, TIGHT,
        ),
        _claim(
            '12-13', 'small swings: *Φ̈*', 'kkddΦ/dt² = −2gc(Φ − θ)',
            -G * C * (phi - theta) / K**2, bend, TIGHT,
        ),
    ]  # fmt: skip


def _first_solution() -> list[Claim]:
    true = true_modes(E, C, K)
    f = 0.5 * (C + E - K * K / C)
    root = math.sqrt(f * f + K * K)
    own, tied = K * K + C * f, E * K * K
    a, b, d = 0.5, 0.7, 1.3
    shifted = ((a - b * C) * THETA + b * C * PHI) / d
    z = (E * THETA * (f + root) + (own + C * root) * PHI) / tied
    z_prime = (E * THETA * (f - root) + (own - C * root) * PHI) / tied
    lost_c = 'a length is added to an area; §16 has the *c* before the root'
    quarter = 0.5 * time_to_rest(true.B)
    rising = float(quad(lambda x: 1.0 / math.sqrt(1.0 - x * x), 0.0, 0.5, epsrel=1e-13)[0])
    return [
        _claim(
            '15', '*θ* from *Dz = (A − Bc)θ + BcΦ*', 'θ = Dz/A − BcΦ/Bc',
            d * shifted / a - PHI, THETA, TIGHT,
            'θ = Dz/(A − Bc) − BcΦ/(A − Bc)', (d * shifted - b * C * PHI) / (a - b * C),
            'the divisor *A − Bc* is torn in two', 'corrected',
        ),
        _claim(
            '17-20', 'length of the slow mode, first solution, *2f = c + e − kk/c*',
            'b = ekk/(kk + cf − √(ff + kk))',
            tied / (own - root), true.b, TIGHT,
            'b = ekk/(kk + cf − c√(ff + kk))', tied / (own - C * root), lost_c, 'corrected',
        ),
        _claim(
            '18-21', 'length of the fast mode, first solution',
            'b′ = ekk/(kk + cf + √(ff + kk))', tied / (own + root), true.b_prime, TIGHT,
            'b′ = ekk/(kk + cf + c√(ff + kk))', tied / (own + C * root), lost_c, 'corrected',
        ),
        _claim(
            '19', 'the sum of both solutions, as an equation for *θ*',
            'θ + Φ(ef + kk)/ef = (cΦ/f)(kk/z′)(z + z′)',
            C * PHI / f * K * K / z_prime * (z + z_prime) - PHI * (E * f + K * K) / (E * f),
            THETA, TIGHT,
            'θ + Φ(cf + kk)/ef = (kk/2f)(z + z′)',
            K * K / (2.0 * f) * (z + z_prime) - PHI * (C * f + K * K) / (E * f),
            '*e* for *c*, and a garbled factor', 'corrected',
        ),
        _claim(
            '19', 'their difference, likewise', 'θ + cΦ/e = kk(z − z′)/2√(ff + kk)',
            K * K * (z - z_prime) / (2.0 * root) - C * PHI / E, THETA, TIGHT,
        ),
        _claim(
            '19', 'the body from both solutions',
            'Φ = (ez(√(ff + kk) − f) + ez′(f + √(ff + kk)))/2√(ff + kk)',
            (E * z * (root - f) + E * z_prime * (f + root)) / (2.0 * root), PHI, TIGHT,
        ),
        _claim(
            '19', 'the contact from both solutions',
            'θ = z(kk + cf − c√(ff + kk))/2√(ff + kk) − z′(kk + cf + c√(ff + kk))/2√(ff + kk)',
            (z * (own - C * root) - z_prime * (own + C * root)) / (2.0 * root), THETA, TIGHT,
        ),
        _claim(
            '20', 'element of time, here from the middle to the end of a swing',
            'gdz²/b = dz²/(αα − zz)', 0.5 * math.pi * math.sqrt(true.b / (0.5 * G)), quarter,
            CLOSE, '2gdt²/b = dz²/(αα − zz)', 0.5 * math.pi * math.sqrt(true.b / G),
            'the 2 of *2g* is lost, and *dz²* stands for *dt²*', 'corrected',
        ),
        _claim(
            '20', 'its integral, here up to *z = α/2* with *α = 1*', 't√(2g/b) = α sin. z/α',
            math.sin(0.5), rising, TIGHT, 't√(2g/b) = arc. sin. z/α', math.asin(0.5),
            'the sine is taken of *t√(2g/b)*, as in the next line', 'corrected',
        ),
        _claim(
            '21', 'frequency of the fast mode', 'z′ = α′ sin. (t√(2g′/b′) + δ′)',
            math.nan, math.pi / time_to_rest(true.B_prime), CLOSE,
            'z′ = α′ sin. (t√(2g/b′) + δ′)', math.sqrt(G / true.b_prime),
            'there is one gravity', 'corrected',
        ),
    ]  # fmt: skip


def _second_solution() -> list[Claim]:
    true = true_modes(E, C, K)
    f = 0.5 * (K * K + C * C - C * E) / C
    root = math.sqrt(f * f + C * E)
    theta, phi = 4e-8, -7e-8
    tiny = forces(AxlePendulum(1.0 / E, C, K, G), AxleState(E * theta, phi, 0.0, 0.0))
    bend, turn = float(tiny.tilt_acceleration), float(tiny.arc_acceleration) / E
    return [
        _claim(
            '23', 'angular acceleration of the contact', '(eddθ + cddΦ)/gdt² = −θ',
            (-0.5 * G * theta - C * bend) / E, turn, TIGHT,
            '(eddθ + cddΦ)/2gdt² = −θ', (-G * theta - C * bend) / E,
            'the 2 of *2g* is lost; §13 has it', 'corrected',
        ),
        _claim(
            '23', 'angular acceleration of the body', 'kkddΦ/gdt² = −cΦ + eθ',
            0.5 * G * (E * theta - C * phi) / K**2, bend, TIGHT,
            'kkddΦ/2gdt² = −cΦ + cθ', G * (C * theta - C * phi) / K**2,
            '*e* for *c*, and the 2 of *2g* is lost; §13 has both', 'corrected',
        ),
        _claim(
            '27', 'tilt of the body in the slow mode, *f = (kk + cc − ce)/2c*',
            'B = f + √(ff + ce)', f + root, true.B, TIGHT,
        ),
        _claim(
            '27', 'tilt of the body in the fast mode', 'B′ = f − √(ff + ce)',
            f - root, true.B_prime, TIGHT,
        ),
        _claim(
            '28', 'length of the slow mode', 'b = e + f + √(ff + ce)',
            E + f + root, true.b, TIGHT,
        ),
        _claim(
            '28', 'length of the fast mode', 'b′ = e + f − √(ff + ce)',
            E + f - root, true.b_prime, TIGHT,
        ),
    ]  # fmt: skip


def _from_rest() -> list[Claim]:
    true = true_modes(E, C, K)
    alpha, other = _pushed()
    slow, fast = math.sqrt(G / true.b), math.sqrt(G / true.b_prime)
    parts = pushed_amplitudes()
    theta = C * (alpha * math.sin(slow * TIME) + other * math.sin(fast * TIME))
    phi = alpha * true.B * math.sin(slow * TIME) + other * true.B_prime * math.sin(fast * TIME)
    after = pushed_motion(TIME)
    return [
        _claim(
            '30', 'the contact half a second after a push from equilibrium',
            'θ = αc sin. t√(2g/b) + α′c sin. t√(2g/b′)', theta, float(after[0]), CLOSE,
        ),
        _claim(
            '30', 'the body half a second after it',
            'Φ = α(f + √(ff + ce)) sin. t√(2g/b) + α′(f − √(ff + ce)) sin. t√(2g/b′)',
            phi, float(after[1]), CLOSE,
        ),
        _claim(
            '31', 'velocity of the centre of gravity', 'n = αc√2gb + α′c√2gb′',
            C * (alpha * math.sqrt(G * true.b) + other * math.sqrt(G * true.b_prime)),
            SPEED, TIGHT,
        ),
        _claim(
            '32', 'angular velocity of the body', 'ν = −R√(2g/b) + α′B′√(2g/b′)',
            math.nan, SPIN, TIGHT,
            'ν = αB√(2g/b) + α′B′√(2g/b′)', alpha * true.B * slow + other * true.B_prime * fast,
            '*R* for *αB*; the next line has *αB*', 'corrected',
        ),
        _claim(
            '32', 'the push, divided between the modes: slow',
            'α√(2g/b) = νb′/2e√(ff + ce) − nB′/2ce√(ff + ce)',
            alpha * slow, float(parts[0]) * slow, TIGHT,
        ),
        _claim(
            '32', 'the push, divided between the modes: fast',
            'α′√(2g/b′) = −νb/2e√(ff + ce) + nB/2ce√(ff + ce)',
            other * fast, float(parts[1]) * fast, TIGHT,
        ),
    ]  # fmt: skip


def _regular() -> list[Claim]:
    body = AxlePendulum(1.0 / E, C, K, G)
    slow, _ = body.modes.tilt_per_arc
    time = math.pi / math.sqrt(body.modes.squared_frequencies(G)[0])
    start = np.array([1e-3, 1e-3 * slow * E, 0.0, 0.0])
    point, simple = true_modes(E, C, 0.0), np.linalg.eigvals(np.array([[0.0, C], [0.0, C]]))
    return [
        _claim(
            '33-35', 'a motion in one mode stays in that mode: *Φ* after half a period',
            '', -float(start[1]), float(linear_motion(E, start, time)[1]), CLOSE,
            adds='Φ : θ = B : c always',
        ),
        _claim('36', 'a simple pendulum, *k = e = 0*', 'b = c', C, float(np.max(simple)), TIGHT),
        _claim(
            '36', '*f* of a body without extent, *k = 0*', 'f = c/2 = e', 0.5 * C,
            0.5 * (point.B + point.B_prime), TIGHT,
            'f = (c − e)/2', 0.5 * (C - E), 'the minus has become *=*', 'corrected',
        ),
        _claim('36', 'and its length', 'b = c + e', C + E, point.b, TIGHT),
    ]  # fmt: skip


def _plane() -> list[Claim]:
    body, far = AxlePendulum(0.0, C, K, G), true_modes(1e4, C, K)
    fast = G * (plane_period(body, 1e-7) / math.tau) ** 2
    swing = on_a_plane(body, 1.0, 0.4)
    drift = small_motion(body, AxleState(0.0, 0.0, 0.2, 0.0), 3.0)
    return [
        _claim(
            '37', 'on a plane, *e → ∞*: the term of *k* in *ff*, over *f = e/2*, is the length '
                  'of the fast mode', 'ekkk/2c',
            K**3 / C, fast, TIGHT, 'ekk/2c', K**2 / C, 'one *k* too many', 'corrected',
        ),
        _claim('37', 'on a nearly flat support, *e = 10* km', 'b = c + e', 1e4 + C, far.b, 1e-8),
        _claim(
            '37', 'on a plane a push moves the axle on without swinging: *s = eθ* after 3 s', '',
            0.6, float(np.asarray(drift.arc)), TIGHT, adds='s = nt, Φ = 0',
        ),
        _claim('38', 'length of the fast mode on a plane', 'b = kk/c', K * K / C, fast, TIGHT),
        _claim(
            '38', 'the same on a nearly flat support, to first order in *c/e*', '',
            K * K / C * (1.0 - C / 1e4), far.b_prime, 1e-8,
            expected='added', adds='b′ = (kk/c)(1 − c/e)', euler=False,
        ),
        _claim(
            '38-40', 'on a plane the centre of gravity stays in the vertical: the path of the '
                     'axle, at any angle', '',
            -C * (math.sin(swing[1]) - math.sin(1.0)), float(swing[0]), CLOSE,
            adds='s = −c sin Φ',
        ),
    ]  # fmt: skip


def _periods() -> list[Claim]:
    true = true_modes(E, C, K)
    b, b_prime = _lengths(E, C, K)
    return [
        _claim(
            '41', 'an oscillation (half a period) of the slow mode', 't = π√(b/2g)',
            math.pi * math.sqrt(b / G), time_to_rest(true.B), CLOSE,
        ),
        _claim(
            '41', 'an oscillation of the fast mode', 't = π√(b′/2g)',
            math.pi * math.sqrt(b_prime / G), time_to_rest(true.B_prime), CLOSE,
        ),
        _claim(
            '42', 'both lengths without *f*: the slow mode',
            'b = (kk + cc + ce)/2c + (1/2c)√(k⁴ + 2ckk(c − e) + cc(c + e)²)',
            b, true.b, TIGHT,
        ),
        _claim(
            '42', 'the fast mode',
            'b′ = (kk + cc + ce)/2c − (1/2c)√(k⁴ + 2ckk(c − e) + cc(c + e)²)',
            b_prime, true.b_prime, TIGHT,
        ),
    ]  # fmt: skip


def _any_motion() -> list[Claim]:
    start = np.array([0.02, -0.03, 0.1, 0.2])
    after = linear_motion(E, start, TIME)
    lengths = np.array(_lengths(E, C, K))
    shapes = np.stack([[C, C], lengths - E])
    rates = np.sqrt(G / lengths)
    places, speeds = np.linalg.solve(shapes, start[:2]), np.linalg.solve(shapes, start[2:])
    swung = places * np.cos(rates * TIME) + speeds / rates * np.sin(rates * TIME)
    pushed = np.array(_pushed())
    path = E * C * float(np.sum(pushed * np.sin(rates * TIME)))
    return [
        _claim(
            '43', 'any small motion is the sum of both modes: *Φ* after half a second',
            'Φ = α(b − e) sin. (t√(2g/b) + δ) + α′(b′ − e) sin. (t√(2g/b′) + δ′)',
            float(shapes[1] @ swung), float(after[1]), CLOSE,
        ),
        _claim(
            '44', 'path of the axle, *s = eθ*, after a push from equilibrium',
            's = βc sin. t√(2g/b) + β′c sin. t√(2g/b′), β = ae′, β′ = a′e',
            math.nan, E * float(pushed_motion(TIME)[0]), CLOSE,
            's = βc sin. t√(2g/b) + β′c sin. t√(2g/b′), β = αe, β′ = α′e', path,
            '*a* for *α*, and a misplaced prime', 'corrected',
        ),
    ]  # fmt: skip


def _convex() -> list[Claim]:
    i = 0.5
    true = true_modes(-i, C, K)
    as_stands, right = _lengths(-i, C, K, 2), _lengths(-i, C, K)
    fourth = '*k²* under the root is no area squared; §42 has *k⁴*'
    rate, ratio = math.sqrt(-G / right[1]), (right[1] + i) / C
    after = linear_motion(-i, np.array([0.0, 0.0, 1e-3 * rate, 1e-3 * rate * ratio]), TIME)
    return [
        _claim(
            '45', 'on a convex support of radius *i*, *−i* for *e*: the mode that swings',
            'b = (kk + cc − ci)/2c + (1/2c)√(k² + 2ckk(c + i) + cc(c − i)²)',
            as_stands[0], max(true.b, true.b_prime), TIGHT,
            'b = (kk + cc − ci)/2c + (1/2c)√(k⁴ + 2ckk(c + i) + cc(c − i)²)', right[0],
            fourth, 'corrected',
        ),
        _claim(
            '45', 'the other, which is negative',
            'b′ = (kk + cc − ci)/2c − (1/2c)√(k² + 2ckk(c + i) + cc(c − i)²)',
            as_stands[1], min(true.b, true.b_prime), TIGHT,
            'b′ = (kk + cc − ci)/2c − (1/2c)√(k⁴ + 2ckk(c + i) + cc(c − i)²)', right[1],
            fourth, 'corrected',
        ),
        _claim(
            '47', 'with a negative length the body falls from its support, which is to be feared '
                  'where this is convex: a thousand random bodies all have one', '',
            1.0, part_that_falls(), 0.0, adds='bb′ = −ikk/c < 0: it is certain',
        ),
        _claim(
            '47', 'how it falls: *s/i* half a second after a push', '',
            1e-3 * math.sinh(rate * TIME), float(after[0]), CLOSE,
            expected='added', adds='α′c sinh t√(−2g/b′)', euler=False,
        ),
    ]  # fmt: skip


def _cradle() -> list[Claim]:
    e, c, k = 1.2, 0.25, 0.4
    true = true_modes(e, c, k)
    above = np.linalg.eigvals(np.array([[e, -c], [e, -c - k * k / c]]))
    as_stands, right = _lengths(e, c, k, 2), _lengths(e, c, k)
    fourth = '*k²* under the root is no area squared, and *h* stands for *b*; §42 has *k⁴*'
    return [
        _claim(
            '49', 'a cradle with its centre of gravity above *C*, the centre of its rockers, '
                  'does not rock: one of its lengths is negative', '',
            min(_lengths(e, -c, k)), float(np.min(above)), TIGHT, adds='§42 with −c for c',
        ),
        _claim(
            '53', 'a cradle: the slow mode',
            'h = (kk + cc + ce)/2c + (1/2c)√(k² + 2ckk(c − e) + cc(c + e)²)',
            as_stands[0], true.b, TIGHT,
            'b = (kk + cc + ce)/2c + (1/2c)√(k⁴ + 2ckk(c − e) + cc(c + e)²)', right[0],
            fourth, 'corrected',
        ),
        _claim(
            '53', 'the fast mode',
            'h′ = (kk + cc + ce)/2c − (1/2c)√(k² + 2ckk(c − e) + cc(c + e)²)',
            as_stands[1], true.b_prime, TIGHT,
            'b′ = (kk + cc + ce)/2c − (1/2c)√(k⁴ + 2ckk(c − e) + cc(c + e)²)', right[1],
            fourth, 'corrected',
        ),
        _claim(
            '53', 'tilt over path of the cradle, slow mode', 'Φ : s = β(b − e)/e : βc',
            (right[0] - e) / (e * c), true.B / (c * e), TIGHT,
        ),
        _claim(
            '53', 'tilt over path of the cradle, fast mode', 'Φ : s = β′(b′ − e)/e : β′c',
            (right[1] - e) / (e * c), true.B_prime / (c * e), TIGHT,
        ),
    ]  # fmt: skip
