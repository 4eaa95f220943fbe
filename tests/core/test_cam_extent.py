"""The default extent of cheeks."""

from __future__ import annotations

import math

import pytest
from scipy.optimize import brentq

from tauto_core.curves import CircularArc, Hole, Involute
from tauto_core.curves.drawing import cheeks_meet_rad
from tauto_core.plots.machine import cam_extent
from tauto_core.scene import Scene, parse_scene

SCENE = """
duration: 60.0
trochlea:
  inertia: 4.0e-4
  cam: {kind: CAM}
  thread: {kind: vertical}
  power: {kind: weight, mass: 0.322}
  release_angle: RELEASE
"""
DRIVEN = """
drag: {viscous: 1.25e-5}
escapement: {kind: impulse, energy: 1.234e-4}
"""
INVOLUTE, ARC = 'involute, base_radius: 0.005', 'circular_arc, radius: 0.02, root_depth: 0.01'


def scene(release: float, cam: str = INVOLUTE, more: str = '') -> Scene:
    return parse_scene(SCENE.replace('CAM', cam).replace('RELEASE', str(release)) + more, 'cam')


def test_the_cheeks_of_an_involute_meet_where_the_tangent_is_the_angle() -> None:
    """x = r (ϑ cos ϑ − sin ϑ) vanishes again; of a thread through a hole a little earlier."""
    meet = brentq(lambda angle: angle * math.cos(angle) - math.sin(angle), 4.0, 5.0)
    assert cheeks_meet_rad(Involute(0.005)) == pytest.approx(meet, rel=1e-14)
    assert cheeks_meet_rad(Hole(0.005, 50.0)) == pytest.approx(meet, rel=1e-3)
    assert 3.0 < cheeks_meet_rad(Hole(0.005, 0.04)) < meet


def test_cheeks_that_do_not_meet() -> None:
    assert cheeks_meet_rad(CircularArc(0.02, 0.01)) == math.inf


@pytest.mark.parametrize(('release', 'extent'), [(0.02, 0.03), (1.0, 1.5), (-1.2, 1.8)])
def test_half_as_far_again_as_the_wheel_is_released(release: float, extent: float) -> None:
    assert cam_extent(scene(release)) == extent


def test_no_further_than_the_cam_and_where_its_cheeks_meet() -> None:
    assert cam_extent(scene(3.1, ARC)) == math.pi
    assert cam_extent(scene(4.0)) == pytest.approx(4.493409457909064, rel=1e-12)


def test_a_wheel_released_below_its_steady_swing() -> None:
    assert cam_extent(scene(0.2, more=DRIVEN)) == cam_extent(scene(1.0, more=DRIVEN)) > 1.0
