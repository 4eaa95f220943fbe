"""The two forms in which the lever's kernels hold (methods.3).

At the stages of a step it is the disturbance of an oscillator, at an instant s̈ and the rate of the
momentum. `test_motion_real_threads` compares the motion with an independent integrator.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from motion_cases import scene_of

from tauto_core.kernels import entry
from tauto_core.machines import compile_machine
from tauto_core.motion.gauss_step import Mode, make_work
from tauto_core.motion.lanes import SIZE
from tauto_core.motion.lever import LEVER_NODES
from tauto_core.motion.real_threads import RealThreads, TautLever, _within
from tauto_core.motion.system import ChannelAt, Inputs, Plane

LEVER = {
    'cam': {'kind': 'involute', 'base_radius': 0.02},
    'thread': {'kind': 'lever', 'arm': 0.1, 'weight_arm': 0.15, 'length': 0.3},
    'power': {'kind': 'weight', 'mass': 0.05},
}


@entry
def rates(lever: Any, mode: Any, omega: Any, at: Any, work: Any, out: Any) -> None:
    """Fill a row for each stage: the rates of s and p by the stages, then by the instant."""
    lever.disturb(mode, omega, work)
    for i in range(len(out)):
        x, y = work.x[i], work.y[i]
        now = lever.instant(mode, omega, (Plane(x, y),), at)
        drift = lever.drift(mode, omega, at, now)
        out[i, 0] = omega[0] * y + work.d1[i]
        out[i, 1] = omega[0] * (-omega[0] * x + work.d2[i])
        out[i, 2], out[i, 3] = drift[0].x, drift[0].y


@pytest.mark.parametrize('drag', [{}, {'viscous': 3e-4, 'quadratic': 2e-4}])
def test_stages_and_instants_of_the_lever_have_the_same_rates(drag):
    machine = compile_machine(scene_of(trochlea=LEVER, drag=drag))
    engine = RealThreads(machine)
    lever, omega = engine._model
    random = np.random.default_rng(8)
    work, out = make_work(1, LEVER_NODES), np.empty((SIZE, 4))
    edge = float(machine.arc(machine.release_angle)) / np.sqrt(machine.inertia)
    for _ in range(20):
        line, tilt = (ChannelAt(*random.normal(0.0, 0.3, 3)) for _ in range(2))
        at = Inputs(line, tilt, 9.8 + random.normal())
        work['x'], work['y'] = random.uniform(-edge, edge, SIZE), random.normal(0.0, 1.0, SIZE)
        nodes = work['nodes']
        nodes['alpha_rate'], nodes['alpha_bend'] = line.rate - tilt.rate, line.bend - tilt.bend
        nodes['g_up'] = at.gravity * np.cos(tilt.value)
        nodes['g_across'] = at.gravity * np.sin(tilt.value)
        rates(lever, Mode(1.0, random.choice([-1.0, 1.0]), 1.0), omega, at, work, out)
        np.testing.assert_allclose(out[:, :2], out[:, 2:], rtol=2e-12, atol=2e-11)


@entry
def margin_of(lever: Any, held: TautLever, height: float) -> float:
    return _within(lever, held, height)


def test_the_margin_of_a_slack_lever_ends_with_its_arc() -> None:
    """The margin falls to 0 at both ends, and a quarter turn above or below where it is held."""
    lever, _ = RealThreads(compile_machine(scene_of(trochlea=LEVER)))._model
    middle, half, root = lever.shape.full.middle, lever.shape.full.half_width, lever.root_j
    assert middle != 0.0

    def margin(s: float, over: float, beta: float = 0.2) -> float:
        return margin_of(lever, TautLever(s, 0.0, 0.0, 0.0, beta), root * (beta + over))

    assert margin(middle, 0.0) == 1.0
    for side in (1.0, -1.0):
        assert margin(middle + side * half, 0.0) == pytest.approx(0.0, abs=1e-15)
        assert margin(middle + side * 1.01 * half, 0.0) == pytest.approx(-0.0201, rel=1e-9)
        assert margin(middle, side * 1.5) == pytest.approx(0.5 * np.pi - 1.5, rel=1e-12)
        assert margin(middle, side * 1.6) < 0.0
