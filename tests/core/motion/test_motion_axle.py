"""The suspended case over polynomial pieces: both modes exactly, and the full equations."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tauto_core.machines.axle_pendulum import AxlePendulum, AxleState, SupportMotion
from tauto_core.motion.axle import forces
from tauto_core.motion.suspended_case import AxleModes, AxleSwing, BearingMotion, CaseMotion
from tauto_core.scene.errors import PropagationError

E, C, K, G = 0.015, 0.1, 0.05, 9.80665
BODY = AxlePendulum(1.0 / E, C, K, G)
STEP_NS = 50_000_000
SEED = 1780
SIZES = np.array([[1.0, 1.0, 60.0, 60.0]]).T
"""Rates of the fast mode by its angles."""


def bearing(sway, lift=None, parts=8, lengths_ns=None, start_ns=0):
    """Pieces with coefficients of ÿ and of z̈ in rows."""
    n = len(sway)
    lengths = np.full(n, STEP_NS) if lengths_ns is None else np.asarray(lengths_ns)
    begin = start_ns + np.concatenate([[0], np.cumsum(lengths)[:-1]])
    heave = np.zeros((n, 1)) if lift is None else np.array(lift, float)
    heave[:, 0] += G
    return BearingMotion(begin, lengths, np.full(n, parts), np.array(sway, float), heave)


def rough(n, size, seed=SEED):
    """Independent pieces: the acceleration jumps between them."""
    rng = np.random.default_rng(seed)
    return size * rng.normal(size=(n, 10)) / np.arange(1, 11) ** 2


def columns(motion: CaseMotion):
    return np.array([motion.theta, motion.phi, motion.theta_rate, motion.phi_rate])


def polynomial(coefficients, x):
    return float(np.polynomial.polynomial.polyval(x, coefficients))


def small_slope(y, sway, _lift, lengths=(E, C, K)):
    e, c, k = lengths
    phi_bend = -G * c / k**2 * (y[1] - y[0])
    return [y[2], y[3], (-sway - G * y[0] - c * phi_bend) / e, phi_bend]


def full_slope(y, sway, lift):
    state = AxleState(E * y[0], y[1], E * y[2], y[3])
    now = forces(BODY, state, SupportMotion(turn=0.0, down=G - lift, lateral=sway))
    return [y[2], y[3], float(now.arc_acceleration) / E, float(now.tilt_acceleration)]


def simulated(slope, pieces: BearingMotion, tilt):
    """The state at the ends of the pieces by DOP853."""
    y, found = np.array([tilt, tilt, 0.0, 0.0]), []
    for n in range(len(pieces.length_ns)):
        length = pieces.length_ns[n] * 1e-9

        def right(t, y, n=n, length=length):
            x = t / length
            return slope(y, polynomial(pieces.sway[n], x), polynomial(pieces.lift[n], x))

        y = solve_ivp(right, (0.0, length), y, method='DOP853', rtol=3e-14, atol=1e-16).y[:, -1]
        found.append(y)
    return np.array(found).T


def released(swing, tilt):
    """Let the case hang at a tilt, under an acceleration since long before the run."""
    small = isinstance(swing, AxleModes)
    assert swing.release(-G * (tilt if small else math.tan(tilt)), G) == pytest.approx(tilt)


def run(swing, pieces, tilt):
    released(swing, tilt)
    return columns(swing.advance(pieces))


# e c = k² + c²: both modes have nearly one length
NEAR = 0.2, 0.1, 0.1


@pytest.mark.parametrize(
    ('swing', 'slope', 'lengths'),
    [
        (AxleModes, small_slope, (E, C, K)),
        (AxleSwing, full_slope, (E, C, K)),
        (AxleModes, lambda y, sway, lift: small_slope(y, sway, lift, NEAR), NEAR),
    ],
    ids=['small', 'full', 'two modes of nearly one length'],
)
def test_both_follow_dop853_over_rough_pieces(swing, slope, lengths):
    """Two seconds, twenty swings of the fast mode."""
    pieces = bearing(rough(40, 0.3), rough(40, 0.3, SEED + 1))
    found = run(swing(*lengths, G), pieces, 0.02)[:, 7::8]
    wanted = simulated(slope, pieces, 0.02)
    assert np.max(np.abs(wanted[:2])) > 0.05
    np.testing.assert_allclose(found / SIZES, wanted / SIZES, rtol=0, atol=5e-13)


@pytest.mark.parametrize('step_s', [0.0, 1.0])
def test_the_golden_large_swing_to_rounding(step_s):
    """From rest at θ = φ = 0.5 rad, in both orders, against 20 digits of another program."""
    entries = json.loads((Path(__file__).parents[1] / 'golden.json').read_text())['entries']
    (entry,) = [e for e in entries if e['id'] == 'C10-nonlinear-e0.1-th0.5-ph0.5-t1']
    e, c, k, g = (float(entry['params'][key]['value']) for key in 'eckG')
    swing = AxleSwing(e, c, k, g, step_s=step_s)
    assert swing.release(-g * math.tan(0.5), g) == pytest.approx(0.5, rel=1e-15)
    pieces = bearing(np.zeros((20, 1)), np.full((20, 1), g - G))
    found = columns(swing.advance(pieces))[:, -1]
    wanted = [float(entry['expected'][key]) for key in ('theta', 'phi', 'thetadot', 'phidot')]
    np.testing.assert_allclose(found, wanted, rtol=0, atol=2e-13)


def long_steps(e, c, k, g):
    """Return the case at any angles, as for steps of a second: of sixteen stages."""
    return AxleSwing(e, c, k, g, step_s=1.0)


@pytest.mark.parametrize('swing', [AxleModes, AxleSwing, long_steps])
def test_parts_and_uneven_pieces_do_not_matter(swing):
    """The same polynomials in one part or 64, and cut at any place."""
    sway = rough(40, 0.3)
    whole = run(swing(E, C, K, G), bearing(sway), 0.02)[:, 7::8]
    fine = run(swing(E, C, K, G), bearing(sway, parts=64), 0.02)[:, 63::64]
    np.testing.assert_allclose(fine / SIZES, whole / SIZES, rtol=0, atol=1e-13)
    first, second = 17_000_001, STEP_NS - 17_000_001
    x = first / STEP_NS
    cut = []
    for row in sway:
        p = np.polynomial.Polynomial(row)
        early, late = p(np.polynomial.Polynomial([0, x])), p(np.polynomial.Polynomial([x, 1 - x]))
        cut += [early.coef, late.coef]
    pieces = bearing(cut, parts=3, lengths_ns=[first, second] * 40)
    found = run(swing(E, C, K, G), pieces, 0.02)[:, 5::6]
    np.testing.assert_allclose(found / SIZES, whole / SIZES, rtol=0, atol=1e-12)


@pytest.mark.parametrize('swing', [AxleModes, AxleSwing, long_steps])
def test_any_split_and_any_resumption_give_the_same_bits(swing):
    sway, cuts = rough(50, 0.3), [0, 1, 2, 19, 50]
    whole = run(swing(E, C, K, G), bearing(sway), 0.02)
    now, parts = swing(E, C, K, G), []
    released(now, 0.02)
    for begin, end in pairwise(cuts):
        parts.append(columns(now.advance(bearing(sway[begin:end], start_ns=begin * STEP_NS))))
        state = now.state()
        now = swing(E, C, K, G)
        now.restore(state)
    assert np.concatenate(parts, axis=1).tobytes() == whole.tobytes()


def exactly(time_s, tilt, sway):
    """θ and φ under a constant ÿ, from rest, in 40 digits of the machine's own numbers."""
    with mpmath.workdps(40):
        e, c, k2, g = mpmath.mpf(E), mpmath.mpf(C), mpmath.mpf(K) ** 2, mpmath.mpf(G)
        total, rest = k2 + c * c + c * e, k2 + c * c - c * e
        root = mpmath.sqrt(total**2 - 4 * c * e * k2)
        hanging = -mpmath.mpf(sway) / g
        off, theta, phi = mpmath.mpf(tilt) - hanging, hanging, hanging
        ratios = [(rest + root) / (2 * c), (rest - root) / (2 * c)]
        for ratio, other in (ratios, ratios[::-1]):
            q = off * (c - other) / (c * (ratio - other))
            swing = q * mpmath.cos(mpmath.sqrt(g / (e + ratio)) * mpmath.mpf(time_s))
            theta, phi = theta + c * swing, phi + ratio * swing
        return float(theta), float(phi)


def test_six_hours_at_small_angles_cost_no_digit():
    """216 000 steps, 29 000 slow swings and 205 000 fast ones: 1e-12 of the swing is promised."""
    swing, chunk = AxleModes(E, C, K, G), 43_200
    released(swing, 0.02)
    for begin in range(0, 216_000, chunk):
        pieces = bearing(
            np.full((chunk, 1), 0.15),
            parts=1,
            lengths_ns=np.full(chunk, 2 * STEP_NS),
            start_ns=2 * begin * STEP_NS,
        )
        found = swing.advance(pieces)
        time_s = (begin + chunk) // 10
        wanted = exactly(time_s, 0.02, 0.15)
        np.testing.assert_allclose([found.theta[-1], found.phi[-1]], wanted, rtol=0, atol=4e-14)


def test_a_coarser_tolerance_is_kept_a_finer_one_changes_nothing():
    """Ten steps of 0.1 s: off by at most ten times the tolerance, and not by 0."""
    pieces = bearing(np.zeros((10, 1)), parts=1, lengths_ns=np.full(10, 100_000_000))

    def at_the_end(tolerance):
        swing = AxleSwing(E, C, K, G, tolerance=tolerance, step_s=0.1)
        return run(swing, pieces, 0.7)[:, -1]

    fine = at_the_end(None)
    assert at_the_end(1e-15).tobytes() == fine.tobytes()
    off = np.max(np.abs(at_the_end(1e-6) - fine) / SIZES[:, 0])
    assert 1e-12 < off < 10 * 1e-6


def test_lifting_off_is_found_in_time():
    """The bearing falls away faster and faster: N = 0 at DOP853's time, to 1e-9 s."""
    lift = np.zeros((40, 2))
    lift[:, 0], lift[:, 1] = -0.5 * np.arange(40), -0.5
    pieces = bearing(np.zeros((40, 1)), lift, parts=8)

    def right(t, y):
        return full_slope(y, 0.0, G - 10.0 * t)

    def contact(t, y):
        state = AxleState(E * y[0], y[1], E * y[2], y[3])
        return float(forces(BODY, state, SupportMotion(down=10.0 * t)).contact)

    contact.terminal = True
    found = solve_ivp(
        right, (0, 2), [0.1, 0.1, 0, 0], method='DOP853', rtol=1e-12, atol=1e-14, events=contact
    )
    (time_s,) = found.t_events[0]
    swing = AxleSwing(E, C, K, G)
    released(swing, 0.1)
    with pytest.raises(PropagationError, match='lifted off its bearing') as caught:
        swing.advance(pieces)
    assert 0.5 < time_s < 1.5
    assert caught.value.time_s == pytest.approx(time_s, abs=1e-9)


def test_a_case_that_turns_over_is_an_error():
    """A bearing thrown sideways at 30 g: from below the case swings up on the other side."""
    swing = AxleSwing(E, C, K, G)
    released(swing, 0.0)
    with pytest.raises(PropagationError, match='turned over'):
        swing.advance(bearing(np.full((200, 1), 300.0)))
