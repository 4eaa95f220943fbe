"""A drag that is added as one module sails, against DOP853 and closed forms."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tauto_core.machines import HangingMachine, LeverMachine, compile_machine
from tauto_core.scene import Drag, load_scene

KIND = '''
"""A drag as the cube of the speed."""

from typing import Literal, NamedTuple

from tauto_core.machines.parts import DragKind
from tauto_core.scene.sections import Positive


class Cubic(NamedTuple):
    """c θ̇³ over the wheel's inertia."""

    c: float

    def torque(self, rate, direction):
        return self.c * (rate * rate * rate)


class CubicDrag(DragKind):
    """Torque c₃θ̇³ and the other three."""

    kind: Literal['cubic'] = 'cubic'
    cubic: Positive = 1.0

    def law(self, inertia):
        return Cubic(self.cubic / inertia)


KIND = CubicDrag
'''

RUN = """
import json, math, sys
import tauto_core.machines.drags as drags
drags.__path__.append(sys.argv[1])
from tauto_core.scene import SceneError
from tauto_core.machines import compile_machine, steady_swing
from tauto_core.motion import propagator_name
from tauto_core.scene import CubicDrag, Drag, load_scene, parse_scene, scene_yaml
from tauto_core import sail

answer = {}
for name, scene in json.loads(sys.argv[2]).items():
    joints = sail(load_scene('ideal', **scene)).samples['trochlea/joint_states']
    answer[name] = [joints.position[-1, 0], joints.velocity[-1, 0]]
scene = load_scene('ideal', **json.loads(sys.argv[2])['driven'])
machine = compile_machine(scene)
swing = steady_swing(machine)
answer['steady'] = [swing.amplitude, swing.time_constant, machine.drag.damping(3.0)]
answer['propagator'] = propagator_name(machine, still=True)
answer['kept'] = parse_scene(scene_yaml(scene), 'again').drag == scene.drag
answer['plain'] = type(load_scene('ideal', drag={'viscous': 1e-6}).drag).__name__
answer['friction'] = machine.drag.with_friction(2e-6).coulomb
try:
    load_scene('ideal', drag={'kind': 'square'})
except SceneError as error:
    answer['unknown'] = str(error)
print(json.dumps(answer))
"""

CUBIC = 2e-5
DRAG = {'kind': 'cubic', 'cubic': CUBIC, 'viscous': 3e-6, 'quadratic': 4e-6}
PLAIN = load_scene('ideal').trochlea.model_dump()
LEVER = {
    **PLAIN,
    'cam': {'kind': 'involute', 'base_radius': 0.02},
    'thread': {'kind': 'lever', 'arm': 0.1, 'weight_arm': 0.1, 'length': 0.3},
    'power': {'kind': 'weight', 'mass': 0.05},
    'release_angle': 0.8,
}
HANGING = LEVER | {'thread': {'kind': 'hanging', 'length': 0.3}}
EXACT = {'solver': {'tolerance': 1e-12}}
SCENES: dict[str, dict[str, Any]] = {
    'land': {'drag': DRAG, 'duration': 10.0, 'log': {'interval': 1.0}, **EXACT},
    'lever': {'drag': DRAG, 'duration': 1.0, 'log': {'interval': 1.0}, 'trochlea': LEVER, **EXACT},
    'hanging': {
        'drag': DRAG,
        'duration': 2.0,
        'log': {'interval': 1.0},
        'trochlea': HANGING,
        **EXACT,
    },
    'driven': {
        'drag': {'kind': 'cubic', 'cubic': CUBIC},
        'escapement': {'energy': 1e-4},
        'duration': 1.0,
        'log': {'interval': 1.0},
    },
}


@pytest.fixture(scope='module')
def answers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Return the results of the scenes, with the kind added to its folder."""
    folder: Path = tmp_path_factory.mktemp('drags')
    (folder / 'cubic.py').write_text(KIND, encoding='utf-8')
    command = [sys.executable, '-c', RUN, str(folder), json.dumps(SCENES)]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    found: dict[str, Any] = json.loads(ran.stdout)
    return found


def torque(rate: float) -> float:
    return (3e-6 + 4e-6 * abs(rate) + CUBIC * rate * rate) * rate


@pytest.mark.parametrize('name', ['land', 'lever'])
def test_a_new_drag_sails_as_dop853_does(answers: dict[str, Any], name: str) -> None:
    """DOP853 at 1e-13 leaves some 1e-12 of the state in each swing."""
    scene = SCENES[name]
    machine = compile_machine(load_scene('ideal', trochlea=scene.get('trochlea', PLAIN)))
    assert isinstance(machine, LeverMachine) == (name == 'lever')

    def motion(_t: float, y: np.ndarray) -> list[float]:
        angle, rate = y.tolist()
        if not isinstance(machine, LeverMachine):
            return [rate, -(machine.frequency**2) * angle - torque(rate) / machine.inertia]
        tau = machine.geometry.tau_of(np.array([angle]))
        ratio, ratio_rate = (float(each[0]) for each in machine.geometry.slopes(tau))
        turned, beta = machine.turned_inertia, 2.0 * float(np.arctan(tau[0] ** 2))
        drawn = machine.weight_torque * np.cos(beta) * ratio
        ride = turned * ratio * ratio_rate * rate * rate
        return [rate, -(drawn + ride + torque(rate)) / (machine.inertia + turned * ratio**2)]

    begin, end = [machine.release_angle, 0.0], scene['duration']
    found = solve_ivp(motion, (0.0, end), begin, method='DOP853', rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(answers[name], found.y[:, -1], rtol=0.0, atol=5e-11)
    # the drag has taken much more than that
    swung = np.hypot(found.y[0], found.y[1] / machine.frequency)
    assert swung[-1] < 0.98 * machine.release_angle


def test_a_new_drag_on_a_hanging_thread_sails_as_dop853_does(answers: dict[str, Any]) -> None:
    """The equations of `threads/hanging.py` with the torque on the wheel, from a plumb thread."""
    scene = SCENES['hanging']
    machine = compile_machine(load_scene('ideal', trochlea=scene['trochlea']))
    assert isinstance(machine, HangingMachine)
    r, mass, g = machine.base_radius, machine.mass, machine.gravity

    def motion(_t: float, y: np.ndarray) -> list[float]:
        psi, delta, psi_rate, delta_rate = y.tolist()
        u = psi - delta
        free = machine.length - 0.5 * r * u * u
        pulled = g * np.cos(delta) + free * delta_rate**2 + r * psi_rate**2
        bend = -(mass * r * u * pulled + torque(psi_rate)) / (
            machine.inertia + mass * (r * u) ** 2
        )
        carried = r * u * delta_rate * (2.0 * psi_rate - delta_rate)
        return [psi_rate, delta_rate, bend, (carried - g * np.sin(delta) - r * bend) / free]

    def energy(y: list[float]) -> float:
        psi, delta, psi_rate, delta_rate = y
        return machine.energy(psi, delta, psi_rate, delta_rate, g)

    begin = [machine.release_angle, 0.0, 0.0, 0.0]
    found = solve_ivp(motion, (0.0, 2.0), begin, method='DOP853', rtol=1e-13, atol=1e-14)
    end = found.y[:, -1]
    np.testing.assert_allclose(answers['hanging'], end[[0, 2]], rtol=0.0, atol=5e-11)
    # the drag has taken much more than that
    assert energy(end.tolist()) < 0.98 * energy(begin)


def test_its_steady_swing_balances_the_cube(answers: dict[str, Any]) -> None:
    """∮ c₃θ̇³ dθ = (3π/4) c₃ω³A⁴ is two impulses of 1e-4 J, P′/θ̇ₘ = (3/2)c₃θ̇ₘ².

    Impulses in the middle of a harmonic swing that loses a tenth of its energy shift the balance
    in the second order of that.
    """
    omega = compile_machine(load_scene('ideal')).frequency
    amplitude, _, damping = answers['steady']
    assert amplitude == pytest.approx((2e-4 / (0.75 * np.pi * CUBIC * omega**3)) ** 0.25, rel=0.01)
    assert damping == pytest.approx(1.5 * CUBIC * 9.0, rel=1e-7)


def test_the_rest_follows(answers: dict[str, Any]) -> None:
    assert answers['propagator'] == 'collocation'
    assert answers['kept'] is True
    assert answers['plain'] == Drag.__name__
    assert answers['friction'] == 2e-6
    assert 'drag.kind' in answers['unknown']
    assert 'cubic' in answers['unknown']
