"""A constant force in place of the weight on the lever: energy, gravity, heat, and its drawing.

L = ½I(θ̇ + α̇)² + ½J(β̇ + α̇)² − P AD sin β, in a case that turns by α: neither the apparent
vertical nor the size of gravity is in it. test_motion_lever_spring.py has its motion by DOP853.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from motion_cases import scene_of
from test_motion_heat import warmed
from thread_references import HELD, SignedReference, on_land

from tauto_core import sail
from tauto_core.ensembles.budget import _heavier, _larger_cheek
from tauto_core.machines import LeverMachine, compile_machine
from tauto_core.motion.real_threads import RealThreads
from tauto_core.plots.machine import draw_machine
from tauto_core.scene.errors import SceneError

FORCE = {'kind': 'force', 'force': 0.5}
ARC = {'kind': 'lever', 'arc': 0.1, 'weight_arm': 0.15, 'length': 0.3, 'inertia': 3e-4}
SEA = {
    'kind': 'components',
    'components': [{'amplitude': 0.15, 'period': 8.2, 'phase': 1.0}],
    'heave': [{'amplitude': 0.6, 'period': 10.2, 'phase': 0.7}],
    'height': 2.5,
}
EXACT = {'solver': {'tolerance': 1e-13}}


def trochlea(thread: dict[str, Any], **more: Any) -> dict[str, Any]:
    cam = {'kind': 'involute', 'base_radius': 0.02}
    return {'cam': cam, 'power': FORCE, 'thread': thread, **more}


def lever(thread: dict[str, Any], **more: Any) -> LeverMachine:
    found = compile_machine(scene_of(trochlea=trochlea(thread, **more)))
    assert isinstance(found, LeverMachine)
    return found


def reference(thread: dict[str, Any], machine: LeverMachine) -> SignedReference:
    side = -1.0 if 'fulcrum' in thread else 1.0
    return SignedReference(machine, side, arc='arc' in thread, moment=0.0, turned=3e-4)


def test_its_energy_is_kept() -> None:
    """½Mθ̇² + P AD sin β, without drag, over two minutes: to 1e-11 of the energy."""
    scene = scene_of(trochlea=trochlea(ARC), duration=120.0, log={'interval': 1.0}, **EXACT)
    machine, run = lever(ARC), sail(scene).samples['trochlea/joint_states']
    angle, rate = run.position[:, 0], run.velocity[:, 0]
    energy = machine.potential(angle) + 0.5 * machine.mass_at(angle) * rate**2
    np.testing.assert_allclose(energy, energy[0], rtol=1e-11)
    assert machine.potential(1.0) == pytest.approx(
        0.5 * 0.15 * math.sin(reference(ARC, machine).geometry(1.0)[0]), rel=1e-13
    )


def test_it_is_the_lever_of_a_weight_whose_inertia_is_the_levers() -> None:
    """On land: m = P/g and J' = J − m AD² give the same equation."""
    mass = 0.5 / 9.80665
    weight = compile_machine(
        scene_of(
            trochlea={
                **trochlea(ARC | {'inertia': 0.0}),
                'power': {'kind': 'weight', 'mass': mass},
            }
        )
    )
    turned = mass * 0.15**2
    force = lever(ARC | {'inertia': turned})
    for amplitude in (0.2, 1.0, -1.0):
        assert force.period(amplitude) == pytest.approx(weight.period(amplitude), rel=1e-14)


def test_gravity_and_heave_change_nothing() -> None:
    """Nor do they change the rate of a clock that keeps upright."""
    found = []
    for gravity, heave in ((9.80665, 0.6), (9.7, 0.0)):
        ship = SEA | {'heave': [{'amplitude': heave, 'period': 10.2, 'phase': 0.7}]}
        scene = scene_of(
            trochlea=trochlea(ARC), ship=ship, duration=30.0, gravity=gravity, **HELD, **EXACT
        )
        found.append(sail(scene).samples['trochlea/joint_states'].position[:, 0])
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=2e-11)


def test_heat_weakens_its_spring() -> None:
    """The small period grows as 1/√(force); wheel, cam and lever grow alike, by what α says."""
    steel = lever(ARC, power=FORCE | {'material': 'steel'})
    hot = steel.at_celsius(40.0)
    softer = 20.0 * -2.285e-4
    assert hot.small_period / steel.small_period == pytest.approx(
        1.0 / math.sqrt(1.0 + softer), rel=1e-9
    )
    warm = warmed(on_land(200, 0.02, 10), 0.2, np.full(21, 40.0))
    found = []
    for machine, forcing in ((steel, warm), (hot, on_land(200, 0.02, 10))):
        engine = RealThreads(replace(machine, heat=replace(machine.heat, varies=True)))
        engine.release(forcing)
        found.append(engine.advance(forcing).angle)
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-11)


def test_a_budget_changes_its_force() -> None:
    machine = lever(ARC)
    heavier = _heavier(machine, 1e-4)
    assert isinstance(heavier, LeverMachine)
    assert heavier == replace(machine, force=0.5 + 1e-4 * machine.gravity)
    larger = _larger_cheek(machine, 1e-5)
    assert isinstance(larger, LeverMachine)
    assert larger.force == machine.force
    more = larger.weight_torque / machine.weight_torque - 1.0
    assert more == pytest.approx(1e-5 / 0.02, rel=0.1)


def test_it_is_drawn_with_an_arrow_at_the_end_of_the_lever() -> None:
    parts = draw_machine(scene_of(trochlea=trochlea(ARC))).parts
    (pull,) = (part for part in parts if part.name == 'pull')
    assert not [part for part in parts if part.name == 'weight']
    assert float(np.median(pull.x)) == pytest.approx(50.0)


@pytest.mark.parametrize(
    ('thread', 'power', 'key', 'words'),
    [
        (ARC | {'inertia': 0.0}, FORCE, 'trochlea.thread.inertia', 'then only the lever'),
        (
            ARC | {'tail': {'mass': 0.01, 'distance': 0.05}},
            FORCE,
            'trochlea.thread.tail.mass',
            'feels no gravity',
        ),
        ({'kind': 'hanging', 'length': 0.3}, FORCE, 'trochlea.power.kind', 'carries a weight'),
    ],
)
def test_what_does_not_go_with_it_is_refused(
    thread: dict[str, Any], power: dict[str, Any], key: str, words: str
) -> None:
    with pytest.raises(SceneError, match=words) as caught:
        scene_of(trochlea=trochlea(thread, power=power))
    assert caught.value.key == key
