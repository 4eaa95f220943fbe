"""The claims of paper C, 'De motu penduli circa axem cylindricum' (Acta 1780 II).

Euler's 2g is G here, and his e is a − b until §11.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import quad

from tauto_core.curves.numerics import root_of
from tauto_core.euler.edition import Claim, G, letters_of, read_claims
from tauto_core.machines.axle_pendulum import AxlePendulum, AxleState, plane_period, small_motion
from tauto_core.motion.axle import forces
from tauto_core.samples import FloatArray

# -----------------------------------------------------------------------------
# Reference values, independent of the formulas of the paper: h and h′ are the eigenvalues of the
# flexibility matrix with the rows (e, c) and (e, c + k²/c), motions are integrated, and far from
# rest they obey Lagrange's equations.

_LETTERS = letters_of('axle')
E, C, K = (_LETTERS[name] for name in 'eck')
"""The body of the examples [m]."""

THETA, PHI, THETA_RATE, PHI_RATE = _LETTERS['θ'], _LETTERS['Φ'], 1.1, -0.3
"""A state far from rest [rad, rad/s]."""

SPEED, SPIN, TIME = (_LETTERS[name] for name in 'nνt')
"""Initial n [m/s] and ν [rad/s] of a motion from equilibrium, and its time of comparison [s]."""


class TrueModes(NamedTuple):
    """h, h′ and B, B′ = cφ/θ of both modes."""

    h: float
    h_prime: float
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
    """Return θ, φ and their rates after a time, by the linear equations and DOP853."""
    from scipy.integrate import solve_ivp

    def slope(_: float, y: FloatArray) -> list[float]:
        bend = -G * C / K**2 * (y[1] - y[0])
        return [y[2], y[3], (-G * y[0] - C * bend) / e, bend]

    solution = solve_ivp(slope, (0.0, time_s), start, method='DOP853', rtol=1e-12, atol=1e-18)
    end: FloatArray = solution.y[:, -1]
    return end


def time_to_rest(ratio: float) -> float:
    """Return the time of a body released with θ : φ = c : ratio to its first rest [s]."""

    def rate(time_s: float) -> float:
        return float(linear_motion(E, np.array([C, ratio, 0.0, 0.0]) * 1e-3, time_s)[3])

    guess = math.pi * math.sqrt((E + ratio) / G)
    return root_of(rate, 0.9 * guess, 1.1 * guess, 1e-14)


def on_a_plane(body: AxlePendulum, phi: float, time_s: float) -> FloatArray:
    """Return s, φ and their rates after a release from rest, by the full equations."""
    from scipy.integrate import solve_ivp

    def slope(_: float, y: FloatArray) -> list[float]:
        now = forces(body, AxleState(*y))
        return [y[2], y[3], float(now.arc_acceleration), float(now.tilt_acceleration)]

    solution = solve_ivp(
        slope, (0.0, time_s), [0.0, phi, 0.0, 0.0], method='DOP853', rtol=1e-12, atol=1e-14
    )
    end: FloatArray = solution.y[:, -1]
    return end


# -----------------------------------------------------------------------------
# The reference values of the claims, by their names in `axle.yaml`.


def claims() -> list[Claim]:
    """Return every claim of the paper, in its order."""
    return read_claims(
        'C', 'axle', _far_from_rest() | _of_modes() | _of_motions() | _of_supports()
    )


def _far_from_rest() -> dict[str, float]:
    # Lagrange's equations for a link and a body
    cosine, sine = math.cos(PHI - THETA), math.sin(PHI - THETA)
    mass = np.array([[E * E, E * C * cosine], [E * C * cosine, C * C + K * K]])
    force = [
        E * C * sine * PHI_RATE**2 - G * E * math.sin(THETA),
        -E * C * sine * THETA_RATE**2 - G * C * math.sin(PHI),
    ]
    turn, bend = np.linalg.solve(mass, np.array(force))
    # x + iy, and its second derivative
    link, rod = E * np.exp(1j * THETA), C * np.exp(1j * PHI)
    centre = link + rod
    pull = link * (1j * turn - THETA_RATE**2) + rod * (1j * bend - PHI_RATE**2)
    tiny = forces(AxlePendulum(1.0 / E, C, K, G), AxleState(E * 4e-8, -7e-8, 0.0, 0.0))
    return {
        'tilt_of_body': (float(centre.real) - E * math.cos(THETA)) / C,
        'ddx': float(pull.real),
        'ddy': float(pull.imag),
        'ddΦ': float(bend),
        'depth': float(centre.real),
        'small_turn': float(tiny.arc_acceleration) / E,
        'small_bend': float(tiny.tilt_acceleration),
    }


def _of_modes() -> dict[str, float]:
    true, point, flat = (true_modes(*body) for body in ((E, C, K), (E, C, 0.0), (1e4, C, K)))
    swings = time_to_rest(true.B), time_to_rest(true.B_prime)
    return {
        'slow': true.h,
        'fast': true.h_prime,
        'slow_tilt': true.B,
        'fast_tilt': true.B_prime,
        'slow_swing': swings[0],
        'fast_swing': swings[1],
        'quarter_swing': 0.5 * swings[0],
        'angle_at_half': float(
            quad(lambda x: 1.0 / math.sqrt(1.0 - x * x), 0.0, 0.5, epsrel=1e-13)[0]
        ),
        'simple_length': float(np.max(np.linalg.eigvals(np.array([[0.0, C], [0.0, C]])))),
        'f_of_point': 0.5 * (point.B + point.B_prime),
        'length_of_point': point.h,
        'slow_on_flat': flat.h,
        'fast_on_flat': flat.h_prime,
    }


def _of_motions() -> dict[str, float]:
    body, true = AxlePendulum(1.0 / E, C, K, G), true_modes(E, C, K)
    # the push of SPEED and SPIN in equilibrium, and its components along the eigenvectors
    push = np.array([(SPEED - C * SPIN) / E, SPIN])
    motion = linear_motion(E, np.array([0.0, 0.0, *push]), TIME)
    speeds = np.sqrt([G / true.h, G / true.h_prime])
    pushes = np.linalg.solve(np.array([[C, C], [true.B, true.B_prime]]) * speeds, push) * speeds
    slow, _ = body.modes.tilt_per_arc
    half_s = math.pi / math.sqrt(body.modes.squared_frequencies(G)[0])
    in_mode = linear_motion(E, np.array([1e-3, 1e-3 * slow * E, 0.0, 0.0]), half_s)
    start = np.array([0.02, -0.03, 0.1, 0.2])
    # α sin δ and α cos δ of both modes
    lengths = np.array([true.h, true.h_prime])
    shapes, rates = np.stack([[C, C], lengths - E]), np.sqrt(G / lengths)
    sines = np.linalg.solve(shapes, start[:2])
    cosines = np.linalg.solve(shapes, start[2:]) / rates
    amplitudes, phases = np.hypot(sines, cosines), np.arctan2(sines, cosines)
    return {
        'pushed_contact': float(motion[0]),
        'pushed_body': float(motion[1]),
        'pushed_arc': E * float(motion[0]),
        'slow_push': float(pushes[0]),
        'fast_push': float(pushes[1]),
        'one_mode': float(in_mode[1]),
        'body_in_any_motion': float(linear_motion(E, start, TIME)[1]),
        'slow_amplitude': float(amplitudes[0]),
        'fast_amplitude': float(amplitudes[1]),
        'slow_phase': float(phases[0]),
        'fast_phase': float(phases[1]),
    }


def _of_supports() -> dict[str, float]:
    plane, i = AxlePendulum(0.0, C, K, G), 0.5
    swing = on_a_plane(plane, 1.0, 0.4)
    convex = true_modes(-i, C, K)
    falls = min(convex.h, convex.h_prime)
    rate = 1e-3 * math.sqrt(-G / falls)
    falling = linear_motion(-i, np.array([0.0, 0.0, rate, rate * (falls + i) / C]), TIME)
    # 1000 random bodies on convex supports
    e, c, k = 10.0 ** np.random.default_rng(1780).uniform(-2.0, 2.0, (3, 1000))
    matrices = np.stack([np.stack([-e, c], 1), np.stack([-e, c + k * k / c], 1)], 1)
    lowest = np.min(np.linalg.eigvals(matrices).real, axis=1)
    e, c, k = 1.2, 0.25, 0.4
    cradle = true_modes(e, c, k)
    return {
        'fast_on_plane': G * (plane_period(plane, 1e-7) / math.tau) ** 2,
        'tilt_on_plane': float(swing[1]),
        'arc_on_plane': float(swing[0]),
        'drift': float(np.asarray(small_motion(plane, AxleState(0.0, 0.0, 0.2, 0.0), 3.0).arc)),
        'convex_swings': max(convex.h, convex.h_prime),
        'convex_falls': falls,
        'share_that_falls': float(np.mean(lowest < 0.0)),
        'falling_contact': float(falling[0]),
        'falling_cradle': float(
            np.min(np.linalg.eigvals(np.array([[e, -c], [e, -c - k * k / c]])))
        ),
        'slow_cradle': cradle.h,
        'fast_cradle': cradle.h_prime,
        'slow_tilt_of_cradle': cradle.B / (c * e),
        'fast_tilt_of_cradle': cradle.B_prime / (c * e),
    }
