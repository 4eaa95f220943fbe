"""The case in gimbals: against DOP853 with events, in the case and under the wheel."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tauto_core.motion.suspended_case import BearingMotion, GimbalsSwing
from tauto_core.samples import JOINT_STATES, Batches, JointSamples, join
from tauto_core.scene import SceneError, load_scene
from tauto_core.ship.imu import sensed
from tauto_core.ship.suspension import BearingBuffer
from tauto_core.voyage import sail

L, K, G = 0.05, 0.12, 9.81
PULL = L / (L * L + K * K)
OMEGA = math.sqrt(PULL * G)
WAVE = {'amplitude': 0.25, 'period': 4.3, 'phase': 1.0}
HEIGHT = 3.0


def ship_at(t):
    """ÿ, g + z̈, ρ, ρ̇ and ρ̈ of a ship that rolls about an axis HEIGHT below the pivots."""
    frequency = math.tau / WAVE['period']
    turn = frequency * t + WAVE['phase']
    rho, rho1 = WAVE['amplitude'] * math.cos(turn), -WAVE['amplitude'] * frequency * math.sin(turn)
    rho2 = -(frequency**2) * rho
    sway = -HEIGHT * (rho2 * math.cos(rho) - rho1**2 * math.sin(rho))
    return sway, G - HEIGHT * (rho2 * math.sin(rho) + rho1**2 * math.cos(rho)), rho, rho1, rho2


def turned_by(t, phi):
    """The torque of gravity and the ship's accelerations over the moment of inertia, reversed."""
    sway, lift, *_ = ship_at(t)
    return PULL * (lift * math.sin(phi) + sway * math.cos(phi))


def pieces(seconds, step_s=0.01):
    """The ship's motion as polynomials of degree 9, one for each step."""
    n, x = round(seconds / step_s), np.linspace(0.0, 1.0, 10)
    powers = np.vander(x, 10, increasing=True)
    fitted = np.array(
        [np.linalg.solve(powers, [ship_at(step_s * (i + at))[:3] for at in x]) for i in range(n)]
    )
    step_ns = round(step_s * 1e9)
    whole = np.arange(n) * step_ns, np.full(n, step_ns), np.ones(n, np.int64)
    return BearingMotion(*whole, *(np.ascontiguousarray(fitted[:, :, c]) for c in range(3)))


def simulated(times, damping, friction, pull=None, released=0.0):
    """φ and ψ by DOP853 between events, and how often the pivots held. Without `pull` ψ rests."""
    sway, lift, _, rho1, _ = ship_at(0.0)
    tilt = math.atan2(-sway, lift)
    seen_at, t, end, held = np.empty((2, len(times))), 0.0, times[-1], 0
    seen_at[:, 0] = tilt, released + tilt
    state, direction = np.array([tilt, 0.0, released + tilt, 0.0]), -math.copysign(1.0, rho1)

    def swung(t, y, phi2):
        return y[3], 0.0 if pull is None else -pull(t, y[0], y[1], phi2) * (y[2] - y[0])

    def moved_over(slopes, until, state, events=None):
        found = solve_ivp(
            slopes, (t, until), state, 'DOP853', None, True, events, rtol=1e-12, atol=1e-14,
            max_step=0.05,
        )  # fmt: skip
        seen = (times > t) & (times <= found.t[-1])
        if np.any(seen):
            seen_at[:, seen] = found.sol(times[seen])[::2]  # type: ignore[misc]
        return found.t[-1], found.y[:, -1]

    while t < end:

        def slopes(t, y, d=direction):
            sliding = y[1] - ship_at(t)[3]
            phi2 = -turned_by(t, y[0]) - damping * sliding - friction * d
            return y[1], phi2, *swung(t, y, phi2)

        def slides(t, y, d=direction):
            return d * (y[1] - ship_at(t)[3])

        slides.terminal, slides.direction = True, -1.0
        t, state = moved_over(slopes, end, state, slides if friction else None)
        angle = state[0] - ship_at(t)[2]
        if t >= end:
            break

        def needed(t, angle=angle):
            return turned_by(t, angle + ship_at(t)[2]) + ship_at(t)[4]

        if abs(needed(t)) <= friction:
            held += 1
            near = np.arange(t, end, 1e-3)
            loose = np.flatnonzero([abs(needed(at)) > friction for at in near])
            until = end
            if loose.size:
                edges = near[loose[0] - 1], near[loose[0]]
                until = brentq(lambda at: abs(needed(at)) - friction, *edges, xtol=1e-15)

            def rides(t, y):
                _, _, _, rho1, rho2 = ship_at(t)
                return rho1, rho2, *swung(t, y, rho2)

            t, state = moved_over(rides, until, [angle + ship_at(t)[2], ship_at(t)[3], *state[2:]])
        state[:2] = angle + ship_at(t)[2], ship_at(t)[3]
        direction = -math.copysign(1.0, needed(t))
    return *seen_at, held


def moved(swing, bearing):
    sway, lift, rho, rho1, _ = ship_at(0.0)
    swing.release(sway, lift, rho, rho1)
    return swing.advance(bearing)


@pytest.mark.parametrize(
    ('damping', 'friction', 'holds'), [(0.6, 0.0, 0), (0.0, 1.0, 4), (0.3, 2.5, 6)]
)
def test_the_case_follows_dop853_also_where_its_pivots_hold(damping, friction, holds):
    bearing = pieces(10.0)
    found = moved(GimbalsSwing(PULL, G, damping=damping, friction=friction), bearing)
    wanted, _, held = simulated(bearing.end_ns * 1e-9, damping, friction)
    assert held == holds
    np.testing.assert_allclose(found.phi, wanted, rtol=0, atol=3e-12)


def test_pivots_that_hold_throughout_take_the_case_with_the_ship():
    bearing = pieces(10.0)
    swing = GimbalsSwing(PULL, G, friction=1e3)
    found = moved(swing, bearing)
    late = bearing.end_ns > 10**9
    rho = np.array([ship_at(t)[2:] for t in bearing.end_ns[late] * 1e-9])
    np.testing.assert_allclose(np.ptp(found.phi[late] - rho[:, 0]), 0.0, atol=1e-13)
    # derivatives of the fitted polynomials: the step divides their rounding once and twice
    np.testing.assert_allclose(found.phi_rate[late], rho[:, 1], rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.phi_bend[late], rho[:, 2], rtol=0, atol=1e-6)


def scene_of(power='weight', plane=None, **suspension):
    """A force or a massless weight on Euler's second cam, in gimbals on a rolling ship."""
    weight = {'kind': 'weight', 'mass': 0.06, 'massless': True}
    return load_scene(
        'ideal',
        gravity=G,
        duration=10.0,
        trochlea={
            'inertia': 1e-4,
            'cam': {'kind': 'hole', 'lever_rate': 0.006},
            'thread': {'kind': 'hole', 'distance': 0.3},
            'power': weight if power == 'weight' else {'kind': 'force', 'force': 0.6},
            'plane': plane,
            'release_angle': 0.6,
        },
        ship={'kind': 'components', 'components': [WAVE], 'rate': 20.0, 'height': HEIGHT},
        suspension={'kind': 'gimbals', 'depth': L, 'gyration_radius': K} | suspension,
        clock={},
        log={'interval': 1.0},
    )


@pytest.mark.parametrize(
    ('power', 'damping', 'friction', 'close'),
    [('weight', 0.1, 0.0, 1e-10), ('weight', 0.0, 0.04, 6e-6), ('force', 0.0, 0.04, 4e-7)],
)
def test_the_wheel_in_gimbals_follows_dop853(power, damping, friction, close):
    """Where pivots hold or turn back φ̈ jumps by 2f = 2.3 rad/s²: polynomials err by jump · h²/8.

    h is 6.25 ms: 1e-5 rad for a step or two. A weight depends on φ̈ itself.
    """
    scene = scene_of(power, damping_ratio=damping, friction_angle=friction)
    batches: list[Batches] = []
    sail(scene, watch=batches.append)
    found = [each[JOINT_STATES] for each in batches if JOINT_STATES in each]
    wheel = join([each for each in found if isinstance(each, JointSamples)])

    def pull(t, phi, phi1, phi2):
        sway, lift, *_ = ship_at(t)
        aside = sway * math.cos(phi) + lift * math.sin(phi) + L * phi2
        up = lift * math.cos(phi) - sway * math.sin(phi) + L * phi1**2
        return (0.6 if power == 'force' else 0.06 * math.hypot(aside, up)) * 0.006 / 1e-4

    times = (wheel.stamp_ns - scene.starts_at_ns) * 1e-9
    rubbed = 2.0 * damping * OMEGA, OMEGA**2 * math.sin(friction)
    phi, psi, held = simulated(times, *rubbed, pull, 0.6)
    assert held == (4 if friction else 0)
    np.testing.assert_allclose(wheel.position[:, 0], psi - phi, rtol=0, atol=close)


def test_gimbals_keep_the_plane_upright_on_a_ship_that_pitches():
    """At rest, with the bow and starboard down: gravity acts in full along the case."""
    roll, pitch = 0.1, 0.2
    sr, cr, sp, cp = (of(0.5 * angle) for angle in (roll, pitch) for of in (math.sin, math.cos))
    turned = [sr * cp, cr * sp, -sr * sp, cr * cp]
    sr, cr, sp, cp = (of(angle) for angle in (roll, pitch) for of in (math.sin, math.cos))
    force = [-G * sp, G * sr * cp, G * cr * cp]
    rows = (np.tile(row, (3, 1)) for row in (turned, [0.0, 0.0, 0.0], force))
    imu = sensed(np.arange(3) * 50_000_000, *rows)
    scene = scene_of()
    buffer = BearingBuffer(scene, scene.suspension, max_gap_s=1.0)
    buffer.add(imu, 0)
    sway, lift, rho, rho1 = buffer.first()
    np.testing.assert_allclose([sway, lift, rho, rho1], [0.0, G, roll, 0.0], rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ('changes', 'key', 'said'),
    [
        ({'depth': 0.0}, 'suspension.depth', 'greater than 0'),
        ({'damping_ratio': -0.1}, 'suspension.damping_ratio', '0'),
        ({'damping_ratio': 5.0}, 'suspension.damping_ratio', 'at most 1'),
        ({'friction_angle': -0.1}, 'suspension.friction_angle', '0'),
        ({'friction_angle': 1.0}, 'suspension.friction_angle', '0.5'),
        ({'axle_radius': 0.1}, 'suspension.axle_radius', ''),
    ],
)
def test_gimbals_that_cannot_hang_a_case_are_refused(changes, key, said):
    with pytest.raises(SceneError) as caught:
        scene_of(**changes)
    assert caught.value.key == key
    assert said in str(caught.value)


def test_the_plane_of_a_thread_in_gimbals_is_theirs():
    with pytest.raises(SceneError, match=r'trochlea\.plane.*gimbals.*Leave it out'):
        scene_of(plane='ship')
