"""The machine as outlines, and how far its cheeks are drawn."""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np
import pytest
from scipy.optimize import brentq

import tauto_core as tauto
from tauto_core.curves import CircularArc, Hole, Involute
from tauto_core.curves.drawing import cheeks_meet_rad
from tauto_core.curves.fluid import coordinates
from tauto_core.machines import FluidPendulum, compile_machine
from tauto_core.machines.axle_pendulum import AxleRegulator
from tauto_core.plots.machine import (
    BRASS_KG_M3,
    LEAD_KG_M3,
    RIM_SIDE,
    MachineDrawing,
    Outline,
    cam_extent,
    draw_machine,
)
from tauto_core.samples import FloatArray

MM = 1000.0
SCENES = (
    'measured',
    'hanging_thread_at_sea',
    'sully_lever_at_sea',
    'suspended_weight_at_sea',
    'second_cam_at_sea',
    'clock_own_cam_spring',
    'clock_own_cam_lever',
    'globe_in_oil',
)


def part(drawn: MachineDrawing, name: str) -> Outline:
    """Return the only part of a name."""
    (found,) = (each for each in drawn.parts if each.name == name)
    return found


def radii(of: Outline, centre: tuple[float, float] = (0.0, 0.0)) -> FloatArray:
    """Return the distances of the points of an outline from a place."""
    return np.hypot(of.x - centre[0], of.y - centre[1])


@pytest.mark.parametrize('inertia', [4e-4, 0.2])
def test_the_rim_is_a_brass_ring_with_the_inertia_of_the_wheel(inertia: float) -> None:
    """For a ring of height a, ρ a π/2 (R₂⁴ − R₁⁴), from the radii that are drawn."""
    drawn = draw_machine(tauto.load('measured', **{'trochlea.inertia': inertia}))
    size = radii(part(drawn, 'wheel')) / MM
    inner, outer = size.min(), size.max()
    assert outer - inner == pytest.approx(RIM_SIDE * 0.5 * (outer + inner), rel=1e-12)
    turned = 0.5 * math.pi * BRASS_KG_M3 * (outer - inner) * (outer**4 - inner**4)
    assert turned == pytest.approx(inertia, rel=1e-12)
    grams = math.pi * BRASS_KG_M3 * (outer - inner) * (outer**2 - inner**2) * 1000.0
    assert f'({grams:.3g} g' in drawn.note


@pytest.mark.parametrize('scene', ['measured', 'sully_lever_at_sea', 'clock_own_cam_weight'])
def test_the_weight_is_a_lead_cylinder_of_its_mass(scene: str) -> None:
    loaded = tauto.load(scene)
    assert loaded.trochlea is not None
    weight = part(draw_machine(loaded), 'weight')
    width, height = np.ptp(weight.x) / MM, np.ptp(weight.y) / MM
    mass = 0.25 * math.pi * width**2 * height * LEAD_KG_M3
    assert mass == pytest.approx(loaded.trochlea.power.pull.pulling_mass, rel=1e-12)


def test_a_thread_is_as_long_as_it_is_or_broken_and_says_so() -> None:
    """From the tip of an involute of 5 mm. The weight's centre of gravity is at its end."""
    short = draw_machine(tauto.load('hanging_thread_at_sea', **{'trochlea.thread.length': 0.3}))
    assert part(short, 'thread').y.tolist() == pytest.approx([-5.0, -305.0], rel=1e-9)
    assert np.mean(part(short, 'weight').y[:-1]) == pytest.approx(-305.0, rel=1e-9)
    assert not short.is_broken
    assert all(each.name != 'break' for each in short.parts)
    long = draw_machine(tauto.load('hanging_thread_at_sea'))
    assert long.is_broken
    end = float(part(long, 'thread').y[-1])
    assert end > -500.0
    assert end < part(long, 'break').y.min() < part(long, 'break').y.max() < -60.0
    assert 'it ends 1005 mm below the axle' in long.note
    assert 'length of the thread' not in long.note
    # 30 kg of lead are ten times as high as the radius of the wheel
    changed = {'trochlea.inertia': 1e-6, 'trochlea.power.mass': 30.0}
    heavy = draw_machine(tauto.load('involute_weight_at_sea', **changed))
    assert not heavy.is_broken
    assert 'length of the thread' in heavy.note
    assert part(heavy, 'weight').y.max() < part(heavy, 'wheel').y.min()


def test_lever_fulcrum_and_hole_are_in_their_places() -> None:
    """AB 100 mm, AD 150 mm, 300 mm of thread from the tip of an involute of 20 mm."""
    drawn = draw_machine(tauto.load('sully_lever_at_sea'))
    lever, fulcrum = part(drawn, 'lever'), part(drawn, 'fulcrum')
    np.testing.assert_allclose(lever.x, [-100.0, 50.0], rtol=1e-12)
    np.testing.assert_allclose(lever.y, -320.0, rtol=1e-12)
    np.testing.assert_allclose(fulcrum.x[:-1].mean(), -100.0, rtol=1e-12)
    np.testing.assert_allclose(part(drawn, 'weight').x[:-1].mean(), 50.0, rtol=1e-12)
    hole = draw_machine(tauto.load('second_cam_at_sea'))
    scene = tauto.load('second_cam_at_sea')
    assert scene.trochlea is not None
    distance = MM * scene.trochlea.thread.hole_distance
    assert part(hole, 'thread').y[-1] == pytest.approx(-distance, rel=1e-12)
    np.testing.assert_allclose(part(hole, 'hole').y, -distance, rtol=1e-12)


def test_a_suspended_case_hangs_from_its_axle_in_its_bearing() -> None:
    """Radii of 20 and 5 mm, the axle 100 mm above the clock, on the lowest place."""
    drawn = draw_machine(tauto.load('suspended_weight_at_sea'))
    np.testing.assert_allclose(radii(part(drawn, 'axle of the case'), (0.0, 100.0)), 5.0)
    bearing = part(drawn, 'bearing')
    hollow = slice(0, 41)
    centre = (0.0, 100.0 - 5.0 + 20.0)
    np.testing.assert_allclose(radii(bearing, centre)[hollow], 20.0, rtol=1e-12)
    assert bearing.y[hollow].min() == pytest.approx(95.0, rel=1e-12)
    assert (bearing.moves_with, part(drawn, 'case').moves_with) == ('ship', 'case')
    assert 'bearing' not in {each.name for each in draw_machine(tauto.load('measured')).parts}


@pytest.mark.parametrize('body', ['globe', 'cylinder'])
def test_a_body_in_a_fluid_is_drawn_on_its_curve(body: str) -> None:
    scene = tauto.load('globe_in_oil', **{'regulator.body': body})
    drawn, machine = draw_machine(scene), compile_machine(scene)
    assert isinstance(machine, FluidPendulum)
    curve, shape = part(drawn, 'curve'), part(drawn, f'{body} at rest')
    assert np.ptp(shape.x) == pytest.approx(50.0, rel=1e-3)  # of 120 sides
    assert (shape.x[:-1].mean(), shape.y[:-1].mean()) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert curve.y.min() == pytest.approx(0.0, abs=1e-9)
    up, across = (MM * float(each) for each in coordinates(machine.curve, 0.4))
    released = part(drawn, 'at the release')
    assert released.x[:-1].mean() == pytest.approx(across, rel=1e-9)
    assert released.y[:-1].mean() == pytest.approx(up, rel=1e-9)
    # the drawn curve passes there, but for the chord of a hundredth of it
    assert float(np.interp(across, curve.x, curve.y)) == pytest.approx(up, abs=0.1)


@pytest.mark.parametrize('support', ['concave', 'plane', 'convex', 'cradle'])
def test_a_body_on_an_axle_touches_its_support(support: str) -> None:
    """The support is an arc of its radius that touches the axle below its centre."""
    flat = support in ('plane', 'cradle')
    scene = tauto.load('axle_at_sea')
    changed = {'support': support, **({'support_radius': None} if flat else {})}
    regulator = cast(AxleRegulator, scene.regulator).model_copy(update=changed)
    drawn = draw_machine(scene.model_copy(update={'regulator': regulator}))
    under, body = part(drawn, 'support'), part(drawn, 'body at rest')
    middle = len(under.x) // 2
    assert (under.x[middle], under.y[middle]) == pytest.approx((0.0, -20.0), abs=1e-9)
    if not flat:
        centre = (0.0, -20.0 + (100.0 if support == 'concave' else -100.0))
        np.testing.assert_allclose(radii(under, centre), 100.0, rtol=1e-9)
    else:
        np.testing.assert_allclose(under.y, -20.0)
    np.testing.assert_allclose(radii(body, (0.0, -950.0)), 200.0, rtol=1e-9)
    # rolled to the tilt of 0.1 rad, the axle's centre has gone 2 mm to the other side
    start = part(drawn, 'at the start')
    assert np.mean(start.x[:-1]) == pytest.approx(950.0 * math.sin(0.1) - 2.0, abs=0.05)


@pytest.mark.parametrize('given', ['descent', 'ascent'])
def test_a_branch_and_its_companion_are_on_their_sides(given: str) -> None:
    """The circle has its centre a metre above A, and the companion begins at its end."""
    drawn = draw_machine(tauto.load('companion_in_oil', **{'regulator.given': given}))
    circle, other = part(drawn, 'circle, the given branch'), part(drawn, 'its companion')
    np.testing.assert_allclose(radii(circle, (0.0, 1000.0)), 1000.0, rtol=1e-9)
    side = 1.0 if given == 'descent' else -1.0
    assert np.all(side * circle.x >= 0.0)
    assert np.all(side * other.x <= 0.0)
    assert np.ptp(other.x) > 100.0


@pytest.mark.parametrize('name', SCENES)
def test_assumed_dimensions_are_named(name: str) -> None:
    drawn = draw_machine(tauto.load(name))
    assert drawn.note.startswith('To scale.')
    names = [each.name for each in drawn.parts if each.name]
    assert len(names) == len(set(names))
    if name == 'globe_in_oil':
        return
    for assumed, present in {
        'case': True,
        'length of the thread': name in ('measured', 'suspended_weight_at_sea'),
        'thickness of the lever': 'lever' in names,
        'width of the hole': 'hole' in names,
        'spring': 'spring' in names,
        'outside of the bearing': 'bearing' in names,
    }.items():
        assert (assumed in drawn.note.split('Assumed: ')[1]) == present, assumed


def test_the_case_holds_all_but_its_bearing() -> None:
    for name in SCENES[:-1]:
        drawn = draw_machine(tauto.load(name))
        case = part(drawn, 'case')
        for each in drawn.parts:
            if each.name not in ('bearing', 'axle of the case', '') and each is not case:
                assert case.x.min() <= each.x.min() <= each.x.max() <= case.x.max(), each.name
                assert case.y.min() <= each.y.min() <= each.y.max() <= case.y.max(), each.name


# -----------------------------------------------------------------------------
# The default extent of cheeks.

DRIVEN = {'drag': {'viscous': 1.25e-5}, 'escapement': {'kind': 'impulse', 'energy': 1.234e-4}}
ARC = {'kind': 'circular_arc', 'radius': 0.02, 'root_depth': 0.01}


def extent(release: float, **changes: Any) -> float:
    keys = {'trochlea.release_angle': release, 'ship': {'kind': 'still'}, **changes}
    return cam_extent(tauto.load('involute_weight_at_sea', **keys))


def test_cheeks_of_an_involute_meet_at_tan_x_equal_x() -> None:
    """x = r (ϑ cos ϑ − sin ϑ) vanishes again, for a thread through a hole a little earlier."""
    meet = brentq(lambda angle: angle * math.cos(angle) - math.sin(angle), 4.0, 5.0)
    assert cheeks_meet_rad(Involute(0.005)) == pytest.approx(meet, rel=1e-14)
    assert cheeks_meet_rad(Hole(0.005, 50.0)) == pytest.approx(meet, rel=1e-3)
    assert 3.0 < cheeks_meet_rad(Hole(0.005, 0.04)) < meet
    assert cheeks_meet_rad(CircularArc(0.02, 0.01)) == math.inf


@pytest.mark.parametrize(
    ('release', 'expected'), [(0.02, 0.03), (-1.2, 1.8), (4.0, 4.493409457909064)]
)
def test_extent_is_half_as_far_again_as_the_release(release: float, expected: float) -> None:
    """But not beyond the cam, nor the angle at which its cheeks meet."""
    assert extent(release) == pytest.approx(expected, rel=1e-12)
    assert extent(3.1, trochlea__cam=ARC) == math.pi


def test_extent_of_a_wheel_released_below_its_steady_swing() -> None:
    assert extent(0.2, **DRIVEN) == extent(1.0, **DRIVEN) > 1.0
