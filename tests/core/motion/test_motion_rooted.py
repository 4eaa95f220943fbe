"""Cheeks rooted in the axle (Euler 1727, II): an arc of a circle with its root in C itself.

t = sgn ϑ R (1 − cos ϑ) goes as ϑ². Small swings have no period: T goes as 1/√A.
"""

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from motion_cases import angles, scene_of
from reference_propagator import by_reference

from tauto_core import sail
from tauto_core.checks.facts import scene_facts
from tauto_core.machines import Machine, compile_machine
from tauto_core.machines.steady_swing import NoSteadySwing, steady_swing

R, FORCE = 0.02, 1.0
ROOTED = {
    'cam': {'kind': 'circular_arc', 'radius': R, 'root_depth': 0.0},
    'thread': {'kind': 'vertical'},
    'power': {'kind': 'force', 'force': FORCE},
    'release_angle': 1.0,
}


def machine_of(**more: Any) -> Machine:
    machine = compile_machine(scene_of(trochlea={**ROOTED, **more}))
    assert isinstance(machine, Machine)
    return machine


@pytest.mark.parametrize('amplitude', [2.5, 1.0, 0.1, 1e-3])
def test_its_period_agrees_with_mpmath(amplitude: float) -> None:
    """T = 4 ∫ dϑ/√(2 (V(A) − V)/I), V = P R (ϑ − sin ϑ), to 1e-13."""
    machine = machine_of()
    with mpmath.workdps(30):

        def height(angle: Any) -> Any:
            return FORCE * R * (angle - mpmath.sin(angle))

        def slowness(root: Any) -> Any:
            # ϑ = A − root² takes the end's singularity away
            left = height(mpmath.mpf(amplitude)) - height(amplitude - root * root)
            return 2 * root / mpmath.sqrt(2 * left / machine.inertia)

        end = mpmath.sqrt(amplitude)
        exact = 4 * mpmath.quad(slowness, mpmath.linspace(0, end, 5), method='gauss-legendre')
    assert machine.period(amplitude) == pytest.approx(float(exact), rel=1e-13)


def test_of_small_swings_the_period_goes_as_the_inverse_root() -> None:
    machine = machine_of()
    assert machine.period(1e-4) / machine.period(4e-4) == pytest.approx(2.0, rel=1e-7)
    assert machine.period(0.0) == math.inf
    assert machine.small_period == machine.period(1.0)


def test_it_sails_as_dop853_does() -> None:
    """With a weight and drag, half swing by half swing, for the arm has a kink in the middle."""
    scene = scene_of(
        trochlea={**ROOTED, 'power': {'kind': 'weight', 'mass': 0.1}, 'release_angle': -0.1},
        drag={'viscous': 1e-5},
        duration=10.0,
        log={'interval': 0.5},
        solver={'tolerance': 1e-13},
    )
    _, found, _ = angles(scene)
    with by_reference():
        _, exact, _ = angles(scene)
    assert np.ptp(found) > 0.15
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-10)


def test_a_steady_swing_is_not_computed() -> None:
    scene = scene_of(
        trochlea=ROOTED, drag={'viscous': 1e-5}, escapement={'kind': 'impulse', 'energy': 1e-5}
    )
    machine = compile_machine(scene)
    assert isinstance(machine, Machine)
    found = steady_swing(machine)
    assert isinstance(found, NoSteadySwing)
    assert 'rooted in the axle' in found.why


def test_small_swings_have_no_period_in_facts_and_answers() -> None:
    scene = scene_of(trochlea=ROOTED, duration=10.0)
    machine = compile_machine(scene)
    facts = scene_facts(scene)
    assert facts['small_period_s'] is None
    found = sail(scene).result['trochlea']
    assert (found['period_s'], found['period_of']) == (
        machine.period(1.0),
        'the swing as released',
    )
