"""A drag that is added as one module sails as the same law built in, and is kept and refused."""

import json
import math
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from tauto_core import sail
from tauto_core.machines import compile_machine
from tauto_core.machines.drags import Drag
from tauto_core.scene import load_scene

KIND = '''
"""A drag as the square of the speed, and as its cube."""

from typing import Literal, NamedTuple

from tauto_core.machines.parts import DragKind
from tauto_core.scene.sections import NonNegative


class Powers(NamedTuple):
    """s θ̇|θ̇| + c θ̇³ over the wheel's inertia."""

    s: float
    c: float

    def torque(self, rate, direction):
        return (self.s * direction + self.c * rate) * rate * rate


class OwnDrag(DragKind):
    """Torque of a law of its own, and the other three."""

    kind: Literal['own'] = 'own'
    square: NonNegative = 0.0
    cube: NonNegative = 0.0

    def law(self, inertia):
        return Powers(self.square / inertia, self.cube / inertia)


KIND = OwnDrag
'''

RUN = """
import json, sys
import tauto_core.machines.drags as drags
drags.__path__.append(sys.argv[1])
from tauto_core.scene import SceneError
from tauto_core.machines import compile_machine, steady_swing
from tauto_core.motion import propagator_name
from tauto_core.scene import load_scene, parse_scene, scene_yaml
from tauto_core import sail

answer = {}
for name, scene in json.loads(sys.argv[2]).items():
    joints = sail(load_scene(name, **scene)).samples['trochlea/joint_states']
    answer[name] = [joints.position[-1, 0], joints.velocity[-1, 0]]
scene = load_scene('ideal', drag={'kind': 'own', 'cube': 2e-5}, escapement={'energy': 1e-4})
machine = compile_machine(scene)
answer['steady'] = [steady_swing(machine).amplitude, machine.drag.damping(3.0)]
answer['propagator'] = propagator_name(machine, still=True)
answer['kept'] = parse_scene(scene_yaml(scene), 'again').drag == scene.drag
answer['plain'] = type(load_scene('ideal', drag={'viscous': 1e-6}).drag).__name__
answer['friction'] = machine.drag.with_friction(2e-6).coulomb
try:
    load_scene('ideal', drag={'kind': 'cubic'})
except SceneError as error:
    answer['unknown'] = str(error)
print(json.dumps(answer))
"""

EXACT: dict[str, Any] = {
    'duration': 2.0,
    'ship': {'kind': 'still'},
    'log': {'interval': 1.0},
    'solver': {'tolerance': 1e-12},
}
SAILS = ('ideal', 'sully_lever_at_sea', 'hanging_thread_at_sea')


@pytest.fixture(scope='module')
def answers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Return the results of the scenes, with the kind added to its folder."""
    folder = tmp_path_factory.mktemp('drags')
    (folder / 'own.py').write_text(KIND, encoding='utf-8')
    drag = {'kind': 'own', 'square': 8e-5, 'viscous': 3e-6}
    scenes = dict.fromkeys(SAILS, EXACT | {'drag': drag})
    command = [sys.executable, '-c', RUN, str(folder), json.dumps(scenes)]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    found: dict[str, Any] = json.loads(ran.stdout)
    return found


@pytest.mark.parametrize('name', SAILS)
def test_a_new_drag_sails_as_the_same_law_built_in(answers: dict[str, Any], name: str) -> None:
    """c₂θ̇|θ̇|, which other tests compare with DOP853. Steps are solved to 1e-12."""
    drag = {'quadratic': 8e-5, 'viscous': 3e-6}
    joints = sail(load_scene(name, drag=drag, **EXACT)).samples['trochlea/joint_states']
    built_in = [joints.position[-1, 0], joints.velocity[-1, 0]]
    np.testing.assert_allclose(answers[name], built_in, rtol=0.0, atol=2e-11)


def test_its_steady_swing_balances_the_cube(answers: dict[str, Any]) -> None:
    """∮ c₃θ̇³ dθ = (3π/4) c₃ω³A⁴ is two impulses, to second order. P′/θ̇ₘ = (3/2)c₃θ̇ₘ²."""
    omega = compile_machine(load_scene('ideal')).frequency
    amplitude, damping = answers['steady']
    balanced = 2e-4 / (0.75 * math.pi * 2e-5 * omega**3)
    assert amplitude == pytest.approx(balanced**0.25, rel=0.01)
    assert damping == pytest.approx(1.5 * 2e-5 * 9.0, rel=1e-7)


def test_the_rest_follows(answers: dict[str, Any]) -> None:
    assert answers['propagator'] == 'collocation'
    assert answers['kept'] is True
    assert answers['plain'] == Drag.__name__
    assert answers['friction'] == 2e-6
    assert 'drag.kind' in answers['unknown']
    assert 'cubic' in answers['unknown']
