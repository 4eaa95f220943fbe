"""A body on an axle as a regulator, against DOP853, energy, closed forms and the hung case."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from motion_cases import regulator_scene, rolling
from mpmath import mp, mpf
from scipy.integrate import solve_ivp

from tauto_core.clockwork import TrochleaStage
from tauto_core.machines import compile_machine
from tauto_core.machines.axle_pendulum import (
    AxleClock,
    AxleContact,
    AxlePendulum,
    AxleState,
    SupportMotion,
)
from tauto_core.motion.axle import axle_table, forces
from tauto_core.samples import JOINT_STATES, PHASE, READING
from tauto_core.scene.errors import PropagationError
from tauto_core.ship import ShipMotion

G = 9.81


def clock_of(
    curvature: float, depth: float, k: float, start: tuple[float, ...], **touch: Any
) -> AxleClock:
    """Return a clock with s, φ, ṡ, φ̇ at the start."""
    given = {'radius': 0.02, 'contact': 'smooth', 'friction': 0.0} | touch
    body = AxlePendulum(curvature, depth, k, G)
    return AxleClock(body, mass=1.0, arc=start[0], tilt=start[1], arc_rate=start[2],
                     tilt_rate=start[3], **given)  # fmt: skip


def with_friction(clock: AxleClock, y: Any, force: str, slip: int = 0) -> tuple[float, ...]:
    """Return s̈, φ̈, N/M and F/M by solving the equations of the forces as a linear system."""
    body, b, mu = clock.body, clock.radius, clock.friction
    s, phi, s1, phi1 = y
    theta = body.curvature * s
    c, k, delta = body.depth, body.gyration_radius, phi - theta
    # along the normal n (outwards) and the tangent t; G̈ = C̈ + c (φ̈ u′ − φ̇² u)
    rows = [
        [0.0, -c * math.sin(delta), 1.0, 0.0],
        [1.0, c * math.cos(delta), 0.0, -1.0],
        [0.0, k * k, c * math.sin(delta), c * math.cos(delta) - b],
    ]
    right = [
        G * math.cos(theta) + body.curvature * s1**2 + c * phi1**2 * math.cos(delta),
        -G * math.sin(theta) + c * phi1**2 * math.sin(delta),
        0.0,
    ]
    last = {
        'rolls': [1.0, b, 0.0, 0.0],
        'slides': [0.0, 0.0, slip * mu, 1.0],
        'smooth': [0.0, 0.0, 0.0, 1.0],
    }[force]
    return tuple(np.linalg.solve(np.array([*rows, last]), np.array([*right, 0.0])))


def law_of(clock: AxleClock, force: str, slip: int = 0) -> tuple[Any, Any]:
    """Return the slopes of s, φ, ṡ, φ̇, and their values at the start."""
    start = [clock.arc, clock.tilt, clock.arc_rate, clock.tilt_rate]
    return lambda _, y: [y[2], y[3], *with_friction(clock, y, force, slip)[:2]], np.array(start)


EXACT: dict[str, Any] = {'method': 'DOP853', 'rtol': 1e-13, 'atol': 1e-15}
CASES: dict[str, AxleClock] = {
    'in a hollow': clock_of(12.5, 0.3, 0.15, (0.004, 0.4, 0.0, 0.3)),
    'on a plane': clock_of(0.0, 0.3, 0.15, (0.1, 0.5, 0.2, 0.0)),
    'on a convex support': clock_of(-1.0, 0.3, 0.25, (0.0, 0.05, 0.0, 0.0)),
    'rolling in a hollow': clock_of(5.0, 0.3, 0.15, (-0.016, 0.8, 0.0, 0.0), contact='rolling'),
    'a cradle': clock_of(0.0, 0.2, 0.3, (-0.25, 0.5, 0.0, 0.0), contact='rolling', radius=0.5),
    'rolling on a convex support': clock_of(
        -1.0, 0.3, 0.25, (-0.04, 0.4, 0.0, 0.0), contact='rolling', radius=0.1
    ),
}


@pytest.mark.parametrize('name', CASES)
def test_the_motion_agrees_with_dop853(name: str) -> None:
    """To 1e-11, with forces from a linear system of the equations."""
    clock = CASES[name]
    force = 'rolls' if clock.contact == 'rolling' else 'smooth'
    time_s = 0.4 if name == 'on a convex support' else 1.5
    law, start = law_of(clock, force)
    instants = [0.5 * time_s, time_s]
    run = solve_ivp(law, (0.0, time_s), start, t_eval=instants, max_step=0.005, **EXACT)
    found = axle_table(clock, time_s, 0.5 * time_s)
    np.testing.assert_allclose(found.phi_rad[1:], run.y[1], atol=1e-11)
    np.testing.assert_allclose(found.arc_m[1:], run.y[0], atol=1e-11)
    pressed = [with_friction(clock, y, force)[2] / G for y in run.y.T]
    np.testing.assert_allclose(found.contact[1:], pressed, rtol=1e-10)


@pytest.mark.parametrize('curvature', [4.0, 0.0, -2.0])
@pytest.mark.parametrize('touch', [AxleContact(0.1, rolls=True), AxleContact(0.1, friction=-0.3)])
def test_on_a_support_that_moves_they_obey_newton(curvature: float, touch: AxleContact) -> None:
    """Places by the geometry in 50 digits, accelerations by second differences."""
    body = AxlePendulum(curvature, 0.3, 0.2, G)
    s, phi, s1, phi1 = 0.05, 0.4, 0.3, -0.8
    rho, rho1, rho2 = 0.1, 0.5, -0.7
    if touch.rolls:
        s1 = -touch.radius * (phi1 - rho1)
    support = SupportMotion(rho, rho1, rho2, 0.6, -0.4)
    found = forces(body, AxleState(s, phi, s1, phi1), support, touch)
    bend, arc_bend = float(found.tilt_acceleration), float(found.arc_acceleration)
    with mp.workdps(50):

        def places(t: Any) -> tuple[Any, ...]:
            turn = rho + rho1 * t + mpf(rho2) * t * t / 2
            arc, tilt = s + s1 * t + arc_bend * t * t / 2, phi + phi1 * t + bend * t * t / 2
            sigma = curvature * arc
            x = (mp.cos(sigma) - 1) / curvature if curvature else mpf(0)
            y = mp.sin(sigma) / curvature if curvature else arc
            down = mpf(0.6) * t * t / 2 + x * mp.cos(turn) - y * mp.sin(turn)
            lateral = -mpf(0.4) * t * t / 2 + x * mp.sin(turn) + y * mp.cos(turn)
            return down + 0.3 * mp.cos(tilt), lateral + 0.3 * mp.sin(tilt)

        h = mpf('1e-9')
        after, now, before = places(h), places(mpf(0)), places(-h)
        down, lateral = (
            float((a - 2 * b + c) / (h * h)) for a, b, c in zip(after, now, before, strict=True)
        )
    theta = rho + curvature * s
    n, f = float(found.contact), float(found.along)
    assert down == pytest.approx(G - n * math.cos(theta) - f * math.sin(theta), abs=1e-13)
    assert lateral == pytest.approx(-n * math.sin(theta) + f * math.cos(theta), abs=1e-13)
    delta = phi - theta
    moment = -n * 0.3 * math.sin(delta) + f * (touch.radius - 0.3 * math.cos(delta))
    assert 0.2**2 * bend == pytest.approx(moment, abs=1e-14)
    if touch.rolls:
        assert arc_bend == pytest.approx(-touch.radius * (bend - rho2), abs=1e-14)
    else:
        assert f == pytest.approx(-0.3 * n, abs=1e-14)


def sliding(clock: AxleClock, time_s: float) -> np.ndarray:
    """Return s, φ, ṡ, φ̇ by DOP853 from one change of the contact to the next."""
    y, at, slip = law_of(clock, 'rolls')[1], 0.0, 0
    b, mu = clock.radius, clock.friction
    changes = 0

    def kept(y: Any) -> float:
        found = with_friction(clock, y, 'rolls')
        return float(mu * found[2] - abs(found[3]))

    if kept(y) < 0.0:
        slip = -1 if with_friction(clock, y, 'rolls')[3] > 0.0 else 1
    while at < time_s:
        law, _ = law_of(clock, 'slides' if slip else 'rolls', slip)

        def ends(t: float, y: Any, slip: int = slip, begin: float = at) -> float:
            if t <= begin + 1e-7:
                return 1.0
            return float(slip * (y[2] + b * y[3])) if slip else kept(y)

        ends.terminal = True
        run = solve_ivp(law, (at, time_s), y, events=ends, max_step=0.003, **EXACT)
        at, y = float(run.t[-1]), run.y[:, -1]
        if run.status != 1:
            break
        changes += 1
        needed = with_friction(clock, y, 'rolls')[3]
        if slip and kept(y) >= 0.0:
            slip, y[2] = 0, -b * y[3]
        else:
            slip = -1 if needed > 0.0 else 1
    assert changes >= 2
    return y


@pytest.mark.parametrize(
    'clock',
    [
        clock_of(0.0, 0.3, 0.15, (-0.02, 1.0, 0.0, 0.0), contact='coulomb', friction=0.2),
        clock_of(5.0, 0.3, 0.15, (-0.016, 0.8, 0.0, 0.0), contact='coulomb', friction=0.3),
        clock_of(
            0.0, 0.2, 0.3, (-0.4, 0.8, 0.0, 0.0), contact='coulomb', friction=0.1, radius=0.5
        ),
    ],
    ids=['plane', 'hollow', 'cradle'],
)
def test_an_axle_that_rolls_and_slides_agrees_with_dop853(clock: AxleClock) -> None:
    """DOP853 locates a change to some 1e-12 s."""
    found = axle_table(clock, 1.2, 1.2)
    expected = sliding(clock, 1.2)
    np.testing.assert_allclose(found.phi_rad[-1], expected[1], atol=1e-10)
    np.testing.assert_allclose(found.arc_m[-1], expected[0], atol=1e-10)


def test_small_motions_are_those_of_the_modes() -> None:
    """§30–32: pushed from rest. The difference is of third order in the amplitude."""
    for size, most in ((1e-2, 3e-5), (1e-3, 3e-8)):
        clock = clock_of(12.5, 0.3, 0.15, (0.0, 0.0, 0.04 * size, 2.0 * size))
        found = axle_table(clock, 2.0, 0.05)
        assert np.max(np.abs(found.phi_rad - found.small_phi_rad)) < most
        assert np.max(np.abs(found.phi_rad)) > 0.1 * size


def test_an_unstable_body_lifts_off_and_says_when() -> None:
    """N reaches 0 at DOP853's instant, within the next node."""
    clock = clock_of(-5.0, 0.3, 0.15, (0.0, 0.01, 0.0, 0.0))
    found = axle_table(clock, 3.0, 0.1)

    def lifts(_: float, y: Any) -> float:
        return with_friction(clock, y, 'smooth')[2]

    lifts.terminal = True
    law, start = law_of(clock, 'smooth')
    run = solve_ivp(law, (0.0, 3.0), start, events=lifts, **EXACT)
    assert found.ends_s == pytest.approx(run.t[-1], abs=0.01)
    assert 'lifted off' in found.ends_why
    assert len(found.time_s) == math.floor(run.t[-1] / 0.1) + 1


# -----------------------------------------------------------------------------
# As a regulator, on land and at sea.

REGULATOR: dict[str, Any] = {
    'kind': 'axle',
    'support': 'concave',
    'support_radius': 0.1,
    'axle_radius': 0.02,
    'depth': 0.3,
    'gyration_radius': 0.15,
    'release_tilt': 0.3,
}
ROLL = rolling((0.1, 7.0), height=3.0)


def scene_of(duration: float = 10.0, ship: Any = None, **changes: Any) -> Any:
    return regulator_scene(REGULATOR | changes, duration, 0.1, ship)


def sailed(scene: Any, chunks: int = 1) -> dict[str, Any]:
    ship, stage = ShipMotion(scene), TrochleaStage(scene)
    parts: list[Any] = []
    for k in range(chunks):
        first, last = (n * ship.total // chunks for n in (k, k + 1))
        parts.append(stage.feed({'ship/imu': ship.produce(last - first)}))
        if k == chunks // 2:
            saved = stage.state()
            stage = TrochleaStage(scene)
            stage.restore(saved)
    parts.append(stage.finish())
    said = [part for part in parts if part]
    return {
        'tilt': np.concatenate([part[JOINT_STATES].position[:, 0] for part in said]),
        'phase': np.concatenate([part[PHASE].position for part in said]),
        'reading': np.concatenate([part[READING].time_ref_ns for part in said]),
    }


def test_on_land_dial_and_beats_count_the_swings() -> None:
    """A rolling axle: its period by quadrature gives the phase at every return."""
    scene = scene_of(contact='rolling')
    clock = compile_machine(scene)
    assert isinstance(clock, AxleClock)
    period = clock.period(0.3)
    said = sailed(scene)
    time = 0.1 * np.arange(len(said['tilt']))
    turns = said['phase'][:, 0] / (2.0 * math.pi)
    # the phase of a wide swing differs a little from a harmonic one's
    np.testing.assert_allclose(turns, time / period, atol=0.01)
    beats = np.floor(2.0 * time / period + 0.5)
    np.testing.assert_array_equal(said['phase'][:, 3], beats)


@pytest.mark.parametrize('changes', [{}, {'contact': 'rolling'}], ids=['smooth', 'rolling'])
def test_at_sea_it_is_the_body_on_a_support_that_rolls(changes: dict[str, Any]) -> None:
    """DOP853 with the support's motion in closed form: roll ρ = A cos Ωt about an axis below."""
    scene = scene_of(duration=6.0, ship=ROLL, **changes)
    clock, said = compile_machine(scene), sailed(scene)
    assert isinstance(clock, AxleClock)
    omega, size, height = math.tau / 7.0, 0.1, 3.0
    phase = float(scene.ship.components[0].phase)

    def support(t: float) -> SupportMotion:
        angle = omega * t + phase
        rho, rate = size * math.cos(angle), -size * omega * math.sin(angle)
        bend = -omega * omega * rho
        lateral = -height * (bend * math.cos(rho) - rate**2 * math.sin(rho))
        lift = -height * (bend * math.sin(rho) + rate**2 * math.cos(rho))
        return SupportMotion(rho, rate, bend, -lift, lateral)

    start = support(0.0)
    first = [clock.arc, start.turn + clock.tilt, 0.0, start.turn_rate]

    def law(t: float, y: Any) -> list[float]:
        found = forces(clock.body, AxleState(*y), support(t), clock.touch)
        return [y[2], y[3], float(found.arc_acceleration), float(found.tilt_acceleration)]

    times = 0.1 * np.arange(61)
    run = solve_ivp(law, (0.0, 6.0), first, t_eval=times, max_step=0.02, **EXACT)
    rho = np.array([float(np.asarray(support(t).turn)) for t in run.t])
    np.testing.assert_allclose(said['tilt'], run.y[1] - rho, atol=2e-9)


def test_chunks_and_a_restart_do_not_change_a_bit() -> None:
    for contact in ({}, {'contact': 'coulomb', 'friction': 0.02}):
        scene = scene_of(duration=5.0, ship=ROLL, **contact)
        whole, parts = sailed(scene), sailed(scene, 7)
        for name, values in whole.items():
            np.testing.assert_array_equal(parts[name], values)


def test_a_push_that_throws_it_ends_the_run() -> None:
    scene = scene_of(duration=5.0, release_tilt=0.0, push_spin=20.0)
    with pytest.raises(PropagationError, match=r'lifted off|turned over') as ended:
        sailed(scene)
    assert 0.0 < ended.value.time_s < 1.0
    assert str(ended.value).count('t =') <= 1
