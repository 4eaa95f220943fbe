"""Impossible cams are refused whatever their kind, also one that a user adds as a module."""

from __future__ import annotations

import json
import math
import subprocess
import sys

import numpy as np
import pytest

from tauto_core.curves.cam import possible_cam
from tauto_core.curves.cams.corrected import WeightCorrected
from tauto_core.curves.cams.linear import Hole, Involute
from tauto_core.scene.errors import CamRangeError

KIND = '''
"""A kind without a check of its own."""

import math
from dataclasses import dataclass
from typing import Literal

from tauto_core.curves.cam import Cam, CamKind, LinearLever
from tauto_core.curves.lever_geometry import LeverGeometry


@dataclass(frozen=True)
class Bent(Cam):
    """t = b ϑ + c ϑ³."""

    b: float
    c: float
    edge: float
    distance: float
    lever = LinearLever(0.01)

    @property
    def range_rad(self):
        return self.edge

    @property
    def hole_distance(self):
        return self.distance

    def _arm(self, x):
        return x * (self.b + self.c * x**2)

    def _rate(self, x):
        return self.b + 3.0 * self.c * x**2

    def _bend(self, x):
        return 6.0 * self.c * x

    def _lift(self, x):
        return 0.5 * self.b * x**2 + 0.25 * self.c * x**4


class BeyondDeadPoint(LeverGeometry):
    """Goes on beyond its dead point."""

    @property
    def edges(self):
        return -0.99, 0.99


class MyCam(CamKind):
    threads = ('vertical', 'hole', 'lever')
    kind: Literal['mine'] = 'mine'
    b: float = 0.01
    c: float = 0.0
    edge: float | None = None

    def made(self, setting):
        edge = math.inf if self.edge is None else self.edge
        return Bent(self.b, self.c, edge, setting.distance)

    def on_lever(self, lever):
        return BeyondDeadPoint(0.02, lever.arm, lever.length)


KIND = MyCam
'''

RUN = """
import json, sys
import tauto_core.curves.cams as cams
cams.__path__.append(sys.argv[1])
from tauto_core.machines import compile_machine
from tauto_core.scene import SceneError, load_scene
ideal = load_scene('ideal').trochlea.model_dump()
for cam, thread, power in json.loads(sys.argv[2]):
    trochlea = {**ideal, 'cam': {'kind': 'mine', **cam}, 'thread': thread, 'power': power}
    scene = load_scene('ideal', trochlea=trochlea)
    said = []
    for made in (lambda: compile_machine(scene), lambda: scene.trochlea.made_cam(9.81)):
        try:
            made()
            said.append('')
        except SceneError as error:
            said.append(str(error))
    print(json.dumps(said))
"""

HOLE = {'kind': 'hole', 'distance': 0.08}
VERTICAL = {'kind': 'vertical'}
LEVER = {'kind': 'lever', 'arm': 0.1, 'weight_arm': 0.15, 'length': 0.3}
FORCE = {'kind': 'force', 'force': 1.5791367041743}
WEIGHT = {'kind': 'weight', 'mass': 0.05}
CASES = [
    # the evidence of issue 26: an arm of 0.2 m a radian through a hole at 0.08 m
    ({'b': 0.2}, HOLE, FORCE, 'has a lever arm of 0.08'),
    # R = t + t'' = (b + 6c + cϑ²) ϑ of a vertical thread: hollow from rest, and from 2 rad
    ({'c': -0.002, 'edge': 1.2}, VERTICAL, FORCE, 'hollow from 0 to 1.2 rad'),
    ({'c': -0.001, 'edge': 3.0}, VERTICAL, FORCE, 'hollow from 2 to 3 rad'),
    ({'c': -0.001, 'edge': 4.0}, VERTICAL, FORCE, 'does not drive the wheel back'),
    ({'b': -0.01}, VERTICAL, FORCE, 'does not drive the wheel back'),
    ({'edge': 0.0}, VERTICAL, FORCE, 'has a range of 0.0 rad'),
    ({}, LEVER, WEIGHT, 'turns the wheel back as the lever rises'),
    ({'b': 0.02}, VERTICAL, FORCE, ''),
    ({'b': 0.02, 'edge': 4.0}, HOLE, FORCE, ''),
]


@pytest.fixture(scope='module')
def answers(tmp_path_factory: pytest.TempPathFactory) -> list[list[str]]:
    """What machine and drawing say of each case, with the kind added to its folder."""
    folder = tmp_path_factory.mktemp('cams')
    (folder / 'mine.py').write_text(KIND, encoding='utf-8')
    asked = json.dumps([case[:3] for case in CASES])
    command = [sys.executable, '-c', RUN, str(folder), asked]
    ran = subprocess.run(command, capture_output=True, text=True, check=True)
    return [json.loads(line) for line in ran.stdout.splitlines()]


@pytest.mark.parametrize('number', range(len(CASES)))
def test_a_new_kind_of_cam_is_refused_without_code_of_its_own(
    answers: list[list[str]], number: int
) -> None:
    cam, thread, _, expected = CASES[number]
    machine, drawing = answers[number]
    for said in (machine, *([drawing] if thread is not LEVER else [])):
        if expected:
            assert "trochlea.cam.kind = 'mine'" in said, cam
            assert expected in said
        else:
            assert said == ''


def test_no_lever_arm_is_cut_to_the_distance_of_the_hole() -> None:
    """The geometry raises beyond the hole instead."""

    class Endless(Hole):
        @property
        def range_rad(self) -> float:
            return math.inf

    cam = Endless(0.2, 0.08)
    for found in (cam.psi, cam.contact, cam.radius_of_curvature):
        with pytest.raises(CamRangeError, match=r'longer than the hole is away, 0\.08 m'):
            found(0.5)


@pytest.mark.parametrize('rate', np.geomspace(1e-4, 1e-1, 7).tolist())
def test_the_very_edge_of_a_range_is_possible(rate: float) -> None:
    """There t exceeds the distance of the hole by a rounding error, which a steep arm enlarges."""
    for cam in (
        Hole(rate, 0.0830001),
        Involute(rate),
        WeightCorrected(rate, 800.0, 0.0830001),
        WeightCorrected(rate, 8000.0, 3.1),
        WeightCorrected(rate, 800.0),
    ):
        assert possible_cam(cam, 'any') is cam
        if math.isfinite(cam.range_rad):
            assert np.isfinite(cam.psi(cam.range_rad))
