"""The longest step keeps the requested error, wherever in the swing it begins."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from motion_cases import arc, at_rest_at_sea, on_land, scene_of, weight_of

from tauto_core.machines import compile_machine
from tauto_core.motion.collocation import Collocation
from tauto_core.motion.gauss_step import MAX_ANGLE
from tauto_core.motion.wells import arc_shape
from tauto_core.motion.wheel import error_factor, longest_step, reference_frequency

MACHINES = {
    'light': weight_of(0.05, 0.01, release_angle=1.3),
    'heavy': weight_of(2.0, 0.01, release_angle=1.3),
    'spring': {'power': {'kind': 'spring', 'force': 2.0, 'stiffness': 50.0}},
    'stiff spring': {
        'power': {'kind': 'spring', 'force': 2.0, 'stiffness': 400.0},
        'release_angle': 1.3,
    },
    'arc': {'cam': arc(0.02, 0.01), 'thread': {'kind': 'vertical'}, 'release_angle': 1.3},
}
TOLERANCES = [10.0**-n for n in range(6, 15, 2)]
ROUNDING = 1e-15
"""Rounding errors of one step and of sixteen, relative to the state."""


def machine_of(name):
    return compile_machine(scene_of(trochlea=MACHINES[name]))


@cache
def longest(name, tolerance):
    machine = machine_of(name)
    shape = arc_shape(machine)
    omega, factor = reference_frequency(machine), error_factor(machine, shape)
    return longest_step(machine, shape, omega, factor=factor, tolerance=tolerance)


WEIGHT = weight_of(0.644, 0.0025)
OMEGA, INERTIA = 2.0 * math.pi, 4e-4
BUSY = {
    'drag with a kink': (WEIGHT, {'drag': {'quadratic': 1e-6}}),
    'friction': (WEIGHT, {'drag': {'coulomb': 1e-6}}),
    'kinked cam': (MACHINES['arc'], {}),
    'bent well': (MACHINES['stiff spring'], {}),
    'weight as heavy as the wheel': (MACHINES['heavy'], {}),
    'overdamped': (WEIGHT, {'drag': {'viscous': 1.1 * OMEGA * INERTIA}}),
}


@pytest.mark.parametrize('drag', [{}, {'drag': {'viscous': 0.9 * OMEGA * INERTIA}}])
def test_a_calm_swing_takes_long_steps_of_sixteen_stages(drag):
    engine = Collocation(compile_machine(scene_of(trochlea=WEIGHT, **drag)), 1e-10)
    assert engine.order == 32
    assert 4.0 < engine.longest_step_s * OMEGA < 5.0
    assert [engine.steps_in(length_s) for length_s in (0.1, 0.6, 0.8, 2.0)] == [1, 1, 2, 3]


def test_with_impulses_a_step_is_at_most_half_a_swing():
    """At any tolerance. A piece of forcing need not fit the steps."""
    sections = {'escapement': {'energy': 1e-6}, 'drag': {'viscous': 1e-6}}
    machine = compile_machine(scene_of(trochlea=WEIGHT, **sections))
    for tolerance in (1e-12, 1e-3):
        engine = Collocation(machine, tolerance)
        assert engine.order == 32
        assert engine.longest_step_s * OMEGA < math.pi
        assert engine.steps_in(60.0) == 1


@pytest.mark.parametrize('name', BUSY)
def test_what_ends_or_bends_steps_takes_eight_stages(name):
    trochlea, sections = BUSY[name]
    engine = Collocation(compile_machine(scene_of(trochlea=trochlea, **sections)), 1e-10)
    assert engine.order == 16
    assert engine.steps_in(60.0) == 1


def stepped(engine, state, length_s, level):
    """X and Y after 2^level equal steps from a state, whatever their error."""
    engine.restore(state)
    engine._tolerance = engine._tolerance._replace(step=math.inf)
    engine.longest_step_s = length_s / 2**level
    engine.advance(at_rest_at_sea(on_land(1, length_s, 2), engine._machine))
    plane = engine._state['planes'][0]
    return np.array([plane['x'], plane['y']])


@pytest.mark.parametrize('name', MACHINES)
def test_a_longest_step_keeps_its_tolerance_at_every_phase(name):
    """One step against sixteen, with an error 16^16 times smaller, from twelve phases of a swing.

    The step is no shorter than necessary: at the worst phase the error of a limited step is within
    four orders of the tolerance. A kink ends a step early.
    """
    machine = machine_of(name)
    engine = Collocation(machine)
    engine.release(at_rest_at_sea(on_land(1, 1.0), machine))
    size = abs(engine._state['planes']['x'][0])
    period, states = machine.period(machine.release_angle), []
    for _ in range(12):
        stepped(engine, engine.state(), period / 12, 4)
        states.append(engine.state())
    for tolerance in TOLERANCES:
        step = longest(name, tolerance)
        worst = 0.0
        for state in states:
            one, many = (stepped(engine, state, step, level) for level in (0, 4))
            worst = max(worst, float(np.linalg.norm(one - many)) / size)
        assert worst < tolerance + ROUNDING
        limited = step < longest(name, 1.0) and not machine.cam.kinked
        assert not limited or worst > 1e-4 * tolerance


@pytest.mark.parametrize('name', MACHINES)
def test_steps_grow_with_the_tolerance_up_to_a_rotation(name):
    machine = machine_of(name)
    steps = [longest(name, tolerance) for tolerance in TOLERANCES]
    assert all(a >= b > 0.0 for a, b in pairwise(steps))
    assert steps[0] * reference_frequency(machine) <= MAX_ANGLE
    assert Collocation(machine, 1e-9).longest_step_s == longest(name, 1e-9)


def test_the_turning_frame_goes_with_the_swing():
    """Of a harmonic well with ω itself, of a stiffening spring faster than its small swings."""
    plain = compile_machine(scene_of())
    assert reference_frequency(plain) == pytest.approx(plain.frequency, rel=1e-14)
    stiff = machine_of('stiff spring')
    assert reference_frequency(stiff) == math.tau / stiff.period(1.3)
    assert reference_frequency(stiff) > 1.1 * stiff.frequency
