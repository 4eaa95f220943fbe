"""Recoil and friction between the impulses: closed forms, the predicted rate, invariants."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from motion_cases import (
    FORCE,
    LEVER_RATE,
    OMEGA,
    SWINGS,
    angles,
    foretold,
    impulse,
    released_steady,
    rolling,
    run,
    scene_of,
)
from reference_propagator import by_reference

from tauto_core.clockwork import TrochleaStage
from tauto_core.machines import compile_machine, steady_swing
from tauto_core.samples import JOINT_STATES, PHASE
from tauto_core.scene import Scene
from tauto_core.scene.errors import SceneError
from tauto_core.ship import ShipMotion

STIFFNESS = FORCE * LEVER_RATE


def arcs(times: np.ndarray, energy: float, angle: float, recoil: float, friction: float) -> Any:
    """Return θ of a wheel released at 1 rad, each arc a harmonic one about its own centre.

    On the side to which the wheel went last, the centre is −(R + c₀)/k on the way out, and
    −(R − c₀)/k on the way home up to −angle.
    """
    found, side, begin, amplitude = np.empty_like(times), 1.0, 0.0, 1.0
    out, home = (recoil + friction) / STIFFNESS, (recoil - friction) / STIFFNESS
    while begin <= times[-1]:
        reach = amplitude + home
        struck = begin + math.acos((home - angle) / reach) / OMEGA
        now = (times >= begin) & (times <= struck)
        found[now] = side * (reach * np.cos(OMEGA * (times[now] - begin)) - home)
        rate = reach**2 - (home - angle) ** 2 + 2.0 * energy / STIFFNESS
        reach, side = math.sqrt((angle + out) ** 2 + rate), -side
        begin = struck + math.acos((angle + out) / reach) / OMEGA
        now = (times >= struck) & (times <= begin)
        found[now] = side * (reach * np.cos(OMEGA * (times[now] - begin)) - out)
        amplitude = reach - out
    return found


@pytest.mark.parametrize(
    ('energy', 'angle', 'recoil'),
    [
        # only recoil drives it, up to 1.6 rad
        (0.0, 0.3, 1.2e-3),
        (6e-4, 0.0, 1e-3),
        # recoil takes from it
        (9e-4, -0.2, 5e-4),
    ],
)
def test_a_harmonic_well_swings_in_arcs_about_shifted_middles(energy, angle, recoil):
    friction = 2e-4
    scene = scene_of(
        escapement=impulse(energy, angle, recoil=recoil, friction=friction), duration=30.0
    )
    times, found, _ = angles(scene)
    exact = arcs(times, energy, angle, recoil, friction)
    # 33 swings with four events in each, every one found to 1e-15 of a swing or so
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-12)
    assert abs(np.max(np.abs(found[-40:])) - 1.0) > 0.05


@pytest.mark.parametrize(('energy', 'angle'), [(0.0, 0.5), (4e-4, -0.4)])
def test_recoil_gains_as_its_describing_function_says(energy, angle):
    """2R/(πkA) √(1 − α²/A²), in addition to Airy's −E tan χ/(πkA²), A sin χ = α.

    To first order: half the torques differ by a quarter. Friction takes 2 c₀ A from half a swing,
    and E + 2 R α is given. A swing released there repeats itself.
    """
    left = []
    for part in (1.0, 0.5):
        recoil, given = part * 4e-4, part * energy
        friction = 0.5 * given + recoil * angle
        sections = {'escapement': impulse(given, angle, recoil=recoil, friction=friction)}
        swing = foretold(scene_of(**sections))
        assert swing.amplitude == pytest.approx(1.0, abs=1e-12)
        joints = run(released_steady(swing, **sections))[JOINT_STATES]
        np.testing.assert_allclose(joints.position[:, 0], 1.0, rtol=0, atol=1e-12)
        # the log is up to half a nanosecond a swing off the turning point
        late = SWINGS * abs(swing.period - round(swing.period, 9))
        bend = OMEGA**2 * (1.0 + (recoil + friction) / STIFFNESS)
        np.testing.assert_allclose(joints.velocity[:, 0], 0.0, rtol=0, atol=bend * late + 1e-11)
        inner = math.sqrt(1.0 - angle * angle)
        gain = 2.0 * recoil * inner / (math.pi * STIFFNESS)
        airy = -given * angle / inner / (math.pi * STIFFNESS)
        left.append(math.tau / OMEGA / swing.period - 1.0 - gain - airy)
        assert abs(left[-1]) < 0.05 * gain
    assert left[0] / left[1] == pytest.approx(4.0, rel=0.1)


def test_friction_of_the_rest_is_drag_by_another_name():
    """Bit for bit, also added to another drag."""
    plain = {'kind': 'impulse', 'energy': 3e-4}
    same = (
        {'escapement': plain, 'drag': {'coulomb': 2e-4}},
        {'escapement': {**plain, 'rest': {'friction': 2e-4}}},
        {'escapement': {**plain, 'rest': {'friction': 1e-4}}, 'drag': {'coulomb': 1e-4}},
    )
    said = [run(scene_of(**sections)) for sections in same]
    for topic in (JOINT_STATES, PHASE):
        for other in said[1:]:
            np.testing.assert_array_equal(other[topic].position, said[0][topic].position)
            np.testing.assert_array_equal(other[topic].velocity, said[0][topic].velocity)


def test_recoil_starts_a_wheel_that_lies_short_of_its_impulse():
    """With R > kα the wheel rests on neither side: an anchor clock starts by itself."""
    scene = scene_of(
        trochlea={'release_angle': 0.1},
        escapement=impulse(0.0, 0.15, recoil=4e-3, friction=3e-4),
        duration=200.0,
    )
    machine = compile_machine(scene)
    found = foretold(scene)
    # E = 0: 2 c₀ A = 2 R α
    assert found.amplitude == pytest.approx(2.0, rel=1e-12)
    _, angle, _ = angles(scene)
    # 50 ms from the turning point it is short by (ωτ/2)²/2 of A at the most
    assert np.max(np.abs(angle[-200:])) == pytest.approx(found.amplitude, rel=0.02)
    stuck = replace(machine, drag=machine.drag.model_copy(update={'coulomb': 4.5e-3}))
    assert 'released at 0.1 rad it does not swing' in steady_swing(stuck).why


def test_friction_holds_the_wheel_where_recoil_and_well_leave_it():
    """Short of any impulse s stays: arcs about −0.1 home and −0.4 out turn at −1.2, 0.4, −0.6.

    At −0.2 rad kθ + R = 1e-3 N m is within the friction.
    """
    scene = scene_of(escapement=impulse(1e-6, 2.0, recoil=5e-3, friction=3e-3), duration=10.0)
    times, angle, rate = angles(scene)
    turned = np.searchsorted(times, math.pi / OMEGA * np.arange(1, 5))
    np.testing.assert_allclose(angle[turned], [-1.2, 0.4, -0.6, -0.2], rtol=0, atol=0.1)
    held = times > 4.0 * math.pi / OMEGA
    np.testing.assert_allclose(angle[held], -0.2, rtol=0, atol=1e-13)
    assert not np.any(rate[held])


AT_SEA = rolling((0.5, 1.8, 0.4), (0.2, 2.7, 1.9), rate=20.0)
"""The wheel reaches one side, and not the other."""


def impulses(scene: Scene) -> tuple[np.ndarray, list[int]]:
    """Return θ at the logged instants, and the directions of the impulses between them."""
    ship, stage = ShipMotion(scene), TrochleaStage(scene)
    struck, given, found = [], 0, []
    for _ in range(ship.total):
        said = stage.feed({'ship/imu': ship.produce(1)})
        found += [said[JOINT_STATES].position[:, 0]] if said else []
        if said:
            state = stage.state()['propagator']
            assert state['given'] - given <= 1
            struck += [round(state['pallet'])] * (state['given'] - given)
            given = state['given']
    return np.concatenate(found), struck


def test_a_pallet_pushes_again_only_after_the_other_one():
    """A wheel that turns back before it reaches the other side finds the tooth still there."""
    angle = 0.15
    scene = scene_of(
        trochlea={'release_angle': 0.3},
        ship=AT_SEA,
        escapement=impulse(1e-5, angle, recoil=4e-4),
        drag={'viscous': 1e-4},
        duration=20.0,
    )
    found, struck = impulses(scene)
    with by_reference():
        exact, pushed = impulses(scene)
    assert struck == pushed
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-10)
    assert set(np.diff(struck)) == {-2, 2}
    # the wheel comes to the angle of an impulse more often, on either side
    came = (np.abs(exact[1:]) >= angle) & (np.sign(exact[1:]) * exact[:-1] < angle)
    assert len(struck) + 3 < np.count_nonzero(came)


def test_recoil_starts_a_wheel_released_in_the_middle():
    """A release at 0 counts as +, and the tooth drives the wheel to −."""
    sections = {
        'escapement': impulse(3e-5, 0.15, recoil=4e-3),
        'drag': {'viscous': 1e-4},
        'duration': 10.0,
    }
    scene = scene_of(trochlea={'release_angle': 0.0}, **sections)
    _, found, _ = angles(scene)
    with by_reference():
        exact, struck = impulses(scene)
    assert len(struck) > 15
    assert exact[1] < 0.0
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-10)
    _, near, _ = angles(scene_of(trochlea={'release_angle': 1e-300}, **sections))
    np.testing.assert_allclose(found, near, rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ('friction', 'recoil', 'remedy'),
    [(5e-3, 4e-3, 'give it a recoil above 0.005 N m'), (0.0, 0.0, 'other than 0 rad.')],
)
def test_a_wheel_in_the_middle_without_recoil_never_starts(friction, recoil, remedy):
    with pytest.raises(SceneError, match='at rest for ever') as caught:
        scene_of(
            trochlea={'release_angle': 0.0},
            escapement=impulse(1e-4, 0.1, recoil=recoil, friction=friction),
        )
    assert remedy in str(caught.value)
