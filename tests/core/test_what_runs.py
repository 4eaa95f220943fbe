"""Why a propagator runs: every cause that a scene has, and none that it has not."""

from __future__ import annotations

from itertools import product
from typing import Any

import pytest

import tauto_core as tauto
from tauto_core.checks.facts import reason
from tauto_core.machines import compile_machine
from tauto_core.motion import propagator_name
from tauto_core.scene.errors import ABSENT

ESCAPEMENT = {'kind': 'impulse', 'energy': 9e-5}
RECOIL = ESCAPEMENT | {'rest': {'recoil': 1e-6}}


@pytest.mark.parametrize(
    ('name', 'still', 'drag', 'escapement'),
    list(
        product(
            ('hanging_thread_at_sea', 'sully_lever_at_sea', 'involute_weight_at_sea'),
            (False, True),
            (ABSENT, {'viscous': 1e-5}),
            (ABSENT, ESCAPEMENT, RECOIL),
        )
    ),
)
def test_a_reason_has_the_causes_of_its_scene_alone(
    name: str, still: bool, drag: Any, escapement: Any
) -> None:
    ship: dict[str, Any] = {'ship': {'kind': 'still'}} if still else {}
    scene = tauto.load(name, drag=drag, escapement=escapement, **ship)
    machine = compile_machine(scene)
    propagator = propagator_name(machine, still=still)
    said = reason(scene, machine, propagator)
    hanging, lever = name.startswith('hanging'), name.startswith('sully')
    causes = {
        'the thread swings': hanging,
        'moves the lever': lever and not still,
        'moves the weight': not lever and not still,
        'not harmonic': (drag is not ABSENT and not hanging)
        or (not hanging and not lever and not still),
        'escapement acts': escapement is not ABSENT,
        'recoil turns': escapement is RECOIL,
    }
    if propagator == 'action_angle':
        assert 'undisturbed' in said
        assert not any(present for cause, present in causes.items())
        return
    clauses = said.split('; ')
    for cause, present in causes.items():
        assert any(cause in clause for clause in clauses) == present, (cause, said)
    assert len(clauses) == sum(causes.values()), said
