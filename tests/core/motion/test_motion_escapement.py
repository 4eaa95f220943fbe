"""The escapement simulated repeats the predicted steady swing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from motion_cases import (
    FORCE,
    INERTIA,
    LEVER,
    LEVER_RATE,
    SWINGS,
    arc,
    foretold,
    impulse,
    released_steady,
    run,
    scene_of,
)

from tauto_core.machines import compile_machine
from tauto_core.machines.compiling import amplitude_of, recoil_energy, swing_energy
from tauto_core.samples import JOINT_STATES, PHASE

STIFFNESS = FORCE * LEVER_RATE


CHEEK = {'cam': arc(0.02, LEVER_RATE), 'thread': {'kind': 'vertical'}}


@pytest.mark.parametrize(
    ('trochlea', 'drag', 'energy', 'angle'),
    [({}, {'coulomb': 1e-3}, 2e-3, -0.4), (CHEEK, {'viscous': 2e-4}, 3e-3, 0.25)],
)
def test_a_clock_released_in_its_steady_swing_repeats_it(trochlea, drag, energy, angle):
    """At quality factors of 10 to 30."""
    sections = {'drag': drag, 'escapement': impulse(energy, angle)}
    found = foretold(scene_of(trochlea=trochlea, **sections))
    scene = released_steady(found, trochlea=trochlea, **sections)
    joints = run(scene)[JOINT_STATES]
    # the log is up to half a nanosecond a swing off the turning point
    late = SWINGS * abs(found.period - round(found.period, 9))
    bend = STIFFNESS / INERTIA * 4.0
    np.testing.assert_allclose(joints.position[:, 0], found.amplitude, rtol=0, atol=1e-10)
    np.testing.assert_allclose(joints.velocity[:, 0], 0.0, rtol=0, atol=bend * late + 1e-9)


def test_sullys_lever_settles_where_it_is_foretold():
    """Its turning points are not quite at one height: the amplitude errs by the loss squared.

    20 swings are 10 time constants, then 5.
    """
    missed = []
    for part in (1.0, 0.5):
        sections = {
            'drag': {'viscous': part * 2e-4},
            'escapement': impulse(part * 1e-3, 0.3, recoil=part * 1e-3),
        }
        found = foretold(scene_of(trochlea=LEVER, **sections))
        scene = released_steady(found, trochlea=LEVER, **sections)
        said, machine = run(scene), compile_machine(scene)
        turned = np.diff(said[PHASE].position[-2:, 0])[0] / math.tau
        assert turned == pytest.approx(1.0, abs=2e-7)
        wheel = said[JOINT_STATES]
        state = wheel.position[-1], wheel.velocity[-1]
        reached = swing_energy(machine, *state)[0] + recoil_energy(machine, *state)[0]
        missed.append(amplitude_of(machine, float(reached)) / found.amplitude - 1.0)
    assert abs(missed[0]) < 1e-5
    assert missed[0] / missed[1] == pytest.approx(4.0, rel=0.1)
