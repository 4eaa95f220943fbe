"""The collocation engine against independent programs and exact solutions."""

import json
import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from motion_cases import (
    SEA,
    WEIGHT,
    arc,
    assert_same_swing,
    at_rest_at_sea,
    impulse,
    moved,
    on_land,
    rolling,
    run,
    sampled,
    scene_of,
    weight_of,
)
from reference_propagator import Reference

from tauto_core.machines import compile_machine
from tauto_core.machines.drags import Drag
from tauto_core.motion import make_propagator
from tauto_core.motion.closed_forms import ActionAngle
from tauto_core.motion.collocation import Collocation
from tauto_core.samples import JOINT_STATES
from tauto_core.scene import load_scene, parse_scene
from tauto_core.scene.reference import compatible_kinds, new_scene

HERE = Path(__file__).resolve().parent.parent / 'scenes_ref'
REFERENCES = json.loads((HERE / 'refs.json').read_text())['scenes']


@pytest.mark.parametrize('name', REFERENCES)
def test_reference_scenes_of_a_taylor_integrator(name):
    """Half an hour against the exact roll: sampling, interpolation and steps together."""
    scene, reference = load_scene(HERE / f'{name}.yaml'), REFERENCES[name]
    if name == 'e5_hole_spring_roll':  # with a drag that does nothing it shares the kernel of e6
        scene = scene.model_copy(update={'drag': Drag(viscous=1e-300)})
    machine = compile_machine(scene)
    joints = run(scene)[JOINT_STATES]
    angle, rate = joints.position[-1, 0], joints.velocity[-1, 0]
    assert angle == pytest.approx(reference['angle_rad'], abs=reference['tolerance'])
    assert rate == pytest.approx(
        reference['rate_rad_s'], abs=reference['tolerance'] * machine.frequency
    )
    # what the engine reaches, with a margin of ten: a looser result is a regression
    assert angle == pytest.approx(reference['angle_rad'], abs=5e-11)


AT_SEA = {
    'weight': {'trochlea': WEIGHT},
    'weight, drag, escapement': {
        'trochlea': WEIGHT,
        'drag': {'viscous': 1e-5, 'quadratic': 1e-4, 'coulomb': 1e-5},
        'escapement': impulse(2e-4, 0.1),
    },
    'weight, drag, recoil': {
        'trochlea': WEIGHT,
        'drag': {'viscous': 1e-5, 'quadratic': 1e-4},
        'escapement': impulse(2e-4, 0.1, friction=1e-5, recoil=5e-4),
    },
    'arc': {
        'trochlea': {'cam': arc(0.02, 0.01), 'thread': {'kind': 'vertical'}, 'inertia': 8e-3},
        'drag': {'viscous': 1e-5},
        'escapement': impulse(2e-4, 0.1),
    },
}


@pytest.mark.parametrize('name', AT_SEA)
def test_half_a_minute_at_sea_against_dop853_on_the_same_samples(name):
    """The printed equation in ϑ with γ̈ (machine_at_sea.md), another formulation.

    DOP853 at 1e-13 errs by a few 1e-14 rad a swing. Each of some 100 steps may err by 2e-12 of the
    amplitude.
    """
    scene = scene_of(ship=SEA, duration=32.0, log={'interval': 4.0}, **AT_SEA[name])
    machine = compile_machine(scene)
    forcing = sampled(scene, machine, 8)
    engine, reference = Collocation(machine), Reference(machine)
    for found, exact in (
        (engine.release(forcing), reference.release(forcing)),
        (engine.advance(forcing), reference.advance(forcing)),
    ):
        assert_same_swing(found, exact, 2e-11)
        sizes = {'fraction': 1.0, 'phase_rate': 1.0, 'rate': machine.frequency}
        sizes['torque'] = machine.inertia * machine.frequency**2
        for column, size in sizes.items():
            columns = (getattr(each, column) / size for each in (found, exact))
            np.testing.assert_allclose(*columns, rtol=0.0, atol=2e-11, err_msg=column)
    assert exact.half_turns[-1] > 12


def wheels() -> list[tuple[str, ...]]:
    """Return compatible kinds in which each cam, thread and power is there at least once."""
    found: list[tuple[str, ...]] = []
    for kinds in compatible_kinds():
        parts = kinds['cam'], kinds['thread'], kinds['power']
        if kinds['thread'] in ('vertical', 'hole') and set(parts).difference(*found):
            found.append(parts)
    return found


@pytest.mark.parametrize('kinds', wheels(), ids='-'.join)
def test_every_kind_of_wheel_at_sea_against_dop853(kinds):
    """All cams and powers for 8 s, to twice the bound of the test above."""
    written = new_scene('new', dict(zip(('cam', 'thread', 'power'), kinds, strict=True)))
    trochlea = parse_scene(written, 'new').trochlea
    scene = scene_of(
        ship=SEA,
        duration=8.0,
        log={'interval': 4.0},
        trochlea=trochlea.model_dump(exclude_none=True),
        drag={'viscous': 1e-5, 'quadratic': 1e-5},
    )
    machine = compile_machine(scene)
    forcing = sampled(scene, machine, 8)
    assert_same_swing(
        moved(Collocation(machine), forcing), moved(Reference(machine), forcing), 4e-11
    )


@pytest.mark.parametrize('angle', [0.004, 0.012])
def test_an_impulse_just_after_the_middle_adds_no_beat(angle):
    """Beats are changes of sign of θ, also where a span ends between θ = 0 and the angle."""
    scene = scene_of(
        trochlea=WEIGHT,
        ship=SEA,
        drag={'viscous': 1e-5, 'quadratic': 1e-4, 'coulomb': 1e-5},
        escapement=impulse(2e-4, angle),
        duration=120.0,
        log={'interval': 0.05},
    )
    machine = compile_machine(scene)
    spans = sampled(scene, machine, 8)
    angles = np.append(machine.release_angle, moved(Collocation(machine), spans).angle)
    passages = np.count_nonzero(np.diff(np.sign(angles)))
    for interval in (0.05, 1.0):
        log = scene.log.model_copy(update={'interval': interval})
        coarse = sampled(scene.model_copy(update={'log': log}), machine, 8)
        assert moved(Collocation(machine), coarse).beats[-1] == passages


def test_a_kink_passed_twice_within_a_step_is_seen():
    """A swing of 1.5 mrad, driven by the roll, turns back just beyond the middle."""
    trochlea = {**AT_SEA['arc']['trochlea'], 'inertia': 4e-4, 'release_angle': 1e-6}
    ship = rolling((0.1075, 10.5746), rate=5.0)
    scene = scene_of(trochlea=trochlea, ship=ship, duration=20.0, log={'interval': 1.0})
    machine = compile_machine(scene)
    forcing = sampled(scene, machine, 8)
    found, exact = moved(Collocation(machine), forcing), moved(Reference(machine), forcing)
    # 1e-9 rad if such a passage is missed
    np.testing.assert_allclose(found.angle, exact.angle, rtol=0, atol=1e-14)


CONSERVATIVE = {
    'arc': {'cam': arc(0.02, 0.01), 'thread': {'kind': 'vertical'}},
    'weight': weight_of(2.0, 0.01),
    'spring': {'power': {'kind': 'spring', 'force': 2.0, 'stiffness': 50.0}},
}


@pytest.mark.parametrize('engine', [ActionAngle, partial(Collocation, tolerance=1e-15)])
@pytest.mark.parametrize('name', CONSERVATIVE)
def test_conservative_wells_keep_the_period_of_the_quadrature(name, engine):
    """After 100 s, minus whole periods by quadrature, DOP853 gives the angle.

    DOP853 at 1e-13 errs by 1e-12 rad in one swing, a hundred swings at rounding by another 1e-12.
    """
    machine = compile_machine(scene_of(trochlea={**CONSERVATIVE[name], 'release_angle': 1.3}))
    period = machine.period(1.3)
    assert make_propagator(machine, still=True).name == 'action_angle'
    motion_at_end = moved(engine(machine), at_rest_at_sea(on_land(2000, 0.05, 2000), machine))
    angle = motion_at_end.angle[0]
    turns = math.floor(100.0 / period)
    left = on_land(1, 100.0 - turns * period)
    assert angle == pytest.approx(moved(Reference(machine), left).angle[0], abs=2e-11)
    assert motion_at_end.half_turns[0] // 2 == turns
