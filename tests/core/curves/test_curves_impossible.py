"""Impossible cams are refused whatever their kind."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from tauto_core.curves.cam import Cam, possible_cam, possible_lever
from tauto_core.curves.cams.corrected import WeightCorrected
from tauto_core.curves.cams.linear import Hole, Involute
from tauto_core.curves.lever_geometry import LeverGeometry
from tauto_core.scene.errors import CamRangeError, SceneError


@dataclass(frozen=True)
class Bent(Cam):
    """t = b ϑ + c ϑ³."""

    b: float = 0.01
    c: float = 0.0
    edge: float = math.inf
    distance: float = math.inf

    @property
    def range_rad(self) -> float:
        return self.edge

    def _arm(self, x: Any) -> Any:
        return x * (self.b + self.c * x**2)

    def _rate(self, x: Any) -> Any:
        return self.b + 3.0 * self.c * x**2

    def _bend(self, x: Any) -> Any:
        return 6.0 * self.c * x

    def _lift(self, x: Any) -> Any:
        return 0.5 * self.b * x**2 + 0.25 * self.c * x**4


class BeyondDeadPoint(LeverGeometry):
    """Goes on beyond its dead point."""

    @property
    def edges(self) -> tuple[float, float]:
        return -0.99, 0.99


@pytest.mark.parametrize(
    ('cam', 'message'),
    [
        # the evidence of issue 26: an arm of 0.2 m a radian through a hole at 0.08 m
        (Bent(0.2, distance=0.08), 'has a lever arm of 0.08'),
        # R = t + t'' = (b + 6c + cϑ²) ϑ of a vertical thread: hollow from rest, and from 2 rad
        (Bent(c=-0.002, edge=1.2), 'hollow from 0 to 1.2 rad .*Let the lever'),
        (Bent(c=-0.001, edge=3.0), 'hollow from 2 to 3 rad .*End the cam before 2 rad, or let'),
        (Bent(c=-0.001, edge=4.0), 'does not drive the wheel back'),
        (Bent(-0.01), 'does not drive the wheel back'),
        (Bent(edge=0.0), r'has a range of 0\.0 rad'),
        (BeyondDeadPoint(0.02, 0.1, 0.3), 'turns the wheel back as the lever rises'),
    ],
)
def test_an_impossible_cam_is_refused(cam: Any, message: str) -> None:
    check: Any = possible_cam if isinstance(cam, Cam) else possible_lever
    with pytest.raises(SceneError, match=message) as caught:
        check(cam, 'mine')
    assert (caught.value.key, caught.value.value) == ('trochlea.cam.kind', 'mine')


def test_no_lever_arm_is_cut_to_the_distance_of_the_hole() -> None:
    """The geometry raises beyond the hole instead."""
    cam = Bent(0.2, distance=0.08)
    for found in (cam.psi, cam.contact, cam.radius_of_curvature):
        with pytest.raises(CamRangeError, match=r'longer than the hole is away, 0\.08 m'):
            found(0.5)


@pytest.mark.parametrize('rate', np.geomspace(1e-4, 1e-1, 7).tolist())
def test_the_very_edge_of_a_range_is_possible(rate: float) -> None:
    """There t exceeds the distance of the hole by a rounding error, which a steep arm enlarges."""
    for cam in (
        Bent(rate),
        Hole(rate, 0.0830001),
        Involute(rate),
        WeightCorrected(rate, 800.0, 0.0830001),
        WeightCorrected(rate, 8000.0, 3.1),
        WeightCorrected(rate, 800.0),
    ):
        assert possible_cam(cam, 'any') is cam
        if math.isfinite(cam.range_rad):
            assert np.isfinite(cam.psi(cam.range_rad))
