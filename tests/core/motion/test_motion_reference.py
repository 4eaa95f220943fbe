"""The collocation engine against independent programs and exact solutions."""

import json
import math
from functools import partial
from pathlib import Path

import mpmath
import numpy as np
import pytest
from motion_cases import (
    SEA,
    TOO_SMALL_TO_MATTER,
    WEIGHT,
    at_rest_at_sea,
    run,
    sampled_forcing,
    scene_of,
)
from reference_propagator import Reference

from tauto_core.machines import compile_machine
from tauto_core.motion import Forcing, make_propagator
from tauto_core.motion.closed_forms import ActionAngle
from tauto_core.motion.collocation import Collocation
from tauto_core.motion.gauss_step import make_work
from tauto_core.motion.wheel import WHEEL_NODES
from tauto_core.samples import JOINT_STATES, PHASE
from tauto_core.scene import Drag, load_scene, parse_scene
from tauto_core.scene.errors import PropagationError
from tauto_core.scene.reference import all_that_go, new_scene

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
        'escapement': {'kind': 'impulse', 'energy': 2e-4, 'angle': 0.1},
    },
    'weight, drag, recoil': {
        'trochlea': WEIGHT,
        'drag': {'viscous': 1e-5, 'quadratic': 1e-4},
        'escapement': {
            'kind': 'impulse',
            'energy': 2e-4,
            'angle': 0.1,
            'rest': {'friction': 1e-5, 'recoil': 5e-4},
        },
    },
    'arc': {
        'trochlea': {
            'cam': {'kind': 'circular_arc', 'radius': 0.02, 'root_depth': 0.01},
            'thread': {'kind': 'vertical'},
            'inertia': 8e-3,
        },
        'drag': {'viscous': 1e-5},
        'escapement': {'kind': 'impulse', 'energy': 2e-4, 'angle': 0.1},
    },
}


@pytest.mark.parametrize('name', AT_SEA)
def test_a_minute_and_a_half_at_sea_against_dop853_on_the_same_samples(name):
    """Physics E2 as printed, in ϑ with the second derivative of γ: another formulation.

    DOP853 at 1e-13 leaves a few 1e-14 rad a swing, 2e-12 of these 22 (the weight's) to 24; some
    300 steps may each err by 2e-12 of the amplitude, and leave up to 1e-11 together.
    """
    scene = scene_of(ship=SEA, duration=96.0, log={'interval': 4.0}, **AT_SEA[name])
    machine = compile_machine(scene)
    forcing = sampled_forcing(scene, machine)
    engine, reference = Collocation(machine), Reference(machine)
    for found, exact in (
        (engine.release(forcing), reference.release(forcing)),
        (engine.advance(forcing), reference.advance(forcing)),
    ):
        close = {'rtol': 0.0, 'atol': 2e-11}
        np.testing.assert_allclose(found.angle, exact.angle, **close)
        np.testing.assert_allclose(
            found.rate / machine.frequency, exact.rate / machine.frequency, **close
        )
        np.testing.assert_allclose(found.fraction, exact.fraction, **close)
        np.testing.assert_allclose(found.phase_rate, exact.phase_rate, **close)
        torque = machine.inertia * machine.frequency**2
        np.testing.assert_allclose(found.torque / torque, exact.torque / torque, **close)
        np.testing.assert_array_equal(found.half_turns, exact.half_turns)
        np.testing.assert_array_equal(found.beats, exact.beats)
    assert exact.half_turns[-1] > 40


WHEELS = sorted(
    {
        (kinds['cam'], kinds['thread'], kinds['power'])
        for kinds in all_that_go()
        if kinds['thread'] in ('vertical', 'hole')
    }
)


@pytest.mark.parametrize('kinds', WHEELS, ids='-'.join)
def test_every_kind_of_wheel_at_sea_against_dop853(kinds):
    """All cams and powers that go together, by collocation, for 16 s; bound: twice the above's."""
    written = new_scene('new', dict(zip(('cam', 'thread', 'power'), kinds, strict=True)))
    trochlea = parse_scene(written, 'new').trochlea
    scene = scene_of(
        ship=SEA,
        duration=16.0,
        log={'interval': 4.0},
        trochlea=trochlea.model_dump(exclude_none=True),
        drag={'viscous': 1e-5, 'quadratic': 1e-5},
    )
    machine = compile_machine(scene)
    forcing = sampled_forcing(scene, machine)
    engine, reference = Collocation(machine), Reference(machine)
    engine.release(forcing)
    reference.release(forcing)
    found, exact = engine.advance(forcing), reference.advance(forcing)
    np.testing.assert_allclose(found.angle, exact.angle, rtol=0.0, atol=4e-11)
    np.testing.assert_array_equal(found.beats, exact.beats)


@pytest.mark.parametrize('angle', [0.004, 0.012])
def test_an_impulse_just_after_the_middle_makes_no_beat_of_its_own(angle):
    """Beats are changes of sign of θ, also where a span ends between θ = 0 and the angle."""
    scene = scene_of(
        trochlea=WEIGHT,
        ship=SEA,
        drag={'viscous': 1e-5, 'quadratic': 1e-4, 'coulomb': 1e-5},
        escapement={'kind': 'impulse', 'energy': 2e-4, 'angle': angle},
        duration=120.0,
        log={'interval': 0.05},
    )
    machine = compile_machine(scene)
    spans = sampled_forcing(scene, machine)
    angles = np.append(machine.release_angle, collocated(machine, spans).angle)
    passages = np.count_nonzero(np.diff(np.sign(angles)))
    for interval in (0.05, 1.0):
        log = scene.log.model_copy(update={'interval': interval})
        coarse = sampled_forcing(scene.model_copy(update={'log': log}), machine)
        assert collocated(machine, coarse).beats[-1] == passages


def collocated(machine, forcing):
    engine = Collocation(machine)
    engine.release(forcing)
    return engine.advance(forcing)


def test_a_kink_passed_twice_within_a_step_is_seen():
    """A swing of 1.5 mrad, all of it the roll's doing, that turns back just beyond the middle."""
    trochlea = {**AT_SEA['arc']['trochlea'], 'inertia': 4e-4, 'release_angle': 1e-6}
    ship = {
        'kind': 'components',
        'components': [{'amplitude': 0.1075, 'period': 10.5746}],
        'rate': 5.0,
    }
    scene = scene_of(trochlea=trochlea, ship=ship, duration=20.0, log={'interval': 1.0})
    machine = compile_machine(scene)
    forcing = sampled_forcing(scene, machine)
    engine, reference = Collocation(machine), Reference(machine)
    engine.release(forcing)
    reference.release(forcing)
    # 1e-9 rad where such a passage is missed
    np.testing.assert_allclose(
        engine.advance(forcing).angle, reference.advance(forcing).angle, rtol=0, atol=1e-14
    )


def test_the_reference_goes_on_from_a_state_and_says_when_friction_holds():
    scene = scene_of(drag={'coulomb': 0.004}, duration=20.0, log={'interval': 0.5})
    machine = compile_machine(scene)
    whole, first, second = (Reference(machine) for _ in range(3))
    spans = [
        Forcing(
            length_s=np.full(6, 0.0625),
            begin=np.zeros(6),
            end=np.ones(6),
            end_ns=np.arange(6 * k + 1, 6 * k + 7) * 62_500_000,
            logged=np.ones(6, bool),
        )
        for k in range(3)
    ]
    for each in (whole, first):
        each.release(spans[0])
        each.advance(spans[0])
    second.restore(first.state())
    np.testing.assert_array_equal(second.advance(spans[1]).angle, whole.advance(spans[1]).angle)
    # each swing loses 2 c₀/(P b) = 0.4 rad: 1, −0.6, 0.2, and 0.2 is held
    with pytest.raises(PropagationError, match=r'friction of 0\.004 N m holds') as caught:
        whole.advance(spans[2])
    assert caught.value.time_s == pytest.approx(2.0 * math.pi / machine.frequency, abs=1e-12)


def last_instant(engine, machine, seconds):
    """The motion after some whole seconds, undisturbed."""
    n = round(20 * seconds)
    spans = Forcing(
        length_s=np.full(n, 0.05),
        begin=np.zeros(n),
        end=np.ones(n),
        end_ns=np.arange(1, n + 1) * 50_000_000,
        logged=np.arange(1, n + 1) == n,
    )
    spans = at_rest_at_sea(spans, machine)
    engine.release(spans)
    return engine.advance(spans)


CONSERVATIVE = {
    'arc': (
        {'kind': 'circular_arc', 'radius': 0.02, 'root_depth': 0.01},
        {'kind': 'vertical'},
        {'kind': 'force', 'force': 2.0},
    ),
    'weight': (
        {'kind': 'involute', 'base_radius': 0.01},
        {'kind': 'vertical'},
        {'kind': 'weight', 'mass': 2.0},
    ),
    'spring': (
        {'kind': 'hole', 'lever_rate': 0.01},
        {'kind': 'hole', 'distance': 0.08},
        {'kind': 'spring', 'force': 2.0, 'stiffness': 50.0},
    ),
}


@pytest.mark.parametrize('engine', [ActionAngle, partial(Collocation, tolerance=1e-15)])
@pytest.mark.parametrize('name', CONSERVATIVE)
def test_conservative_wells_swing_with_the_period_of_the_quadrature(name, engine):
    """After a hundred swings: the quadrature's period takes off the whole ones, DOP853 the rest.

    DOP853 at 1e-13 leaves 1e-12 rad in one swing, a hundred swings at rounding another 1e-12.
    """
    cam, thread, power = CONSERVATIVE[name]
    trochlea = {'cam': cam, 'thread': thread, 'power': power, 'release_angle': 1.3}
    scene = scene_of(trochlea=trochlea, duration=100.0, log={'interval': 1.0})
    machine = compile_machine(scene)
    period = machine.period(1.3)
    assert make_propagator(machine, still=True).name == 'action_angle'
    motion_at_end = last_instant(engine(machine), machine, 100.0)
    angle = motion_at_end.angle[0]
    turns = math.floor(100.0 / period)
    left = Forcing(
        length_s=np.array([100.0 - turns * period]),
        begin=np.zeros(1),
        end=np.ones(1),
        end_ns=np.array([100_000_000_000]),
        logged=np.ones(1, bool),
    )
    reference = Reference(machine)
    reference.release(left)
    assert angle == pytest.approx(reference.advance(left).angle[0], abs=2e-11)
    assert motion_at_end.half_turns[0] // 2 == turns


def test_phase_of_the_ideal_machine_is_exact_after_a_hundred_days():
    """ωt reduced by 50-digit arithmetic; what is left is the rounding of the fraction."""
    scene = scene_of(duration=8_640_000.0, log={'interval': 86_400.0})
    phase = run(scene)[PHASE].position
    with mpmath.workdps(50):
        omega = mpmath.sqrt(mpmath.mpf(2.0) * mpmath.mpf(0.01) / mpmath.mpf(4.0e-4))
        for k, row in enumerate(phase):
            half = omega * 86_400 * k / mpmath.pi
            assert row[1] == int(mpmath.floor(half))
            assert row[2] == pytest.approx(float(half - mpmath.floor(half)), abs=4e-16)


def test_collocation_agrees_with_the_closed_form_of_the_ideal_machine():
    """The same machine forced through the general engine."""
    tiny = scene_of(drag=TOO_SMALL_TO_MATTER, duration=1000.0, log={'interval': 1.0})
    exact = scene_of(duration=1000.0, log={'interval': 1.0})
    a, b = run(tiny)[JOINT_STATES], run(exact)[JOINT_STATES]
    assert math.isclose(float(np.max(np.abs(a.position - b.position))), 0.0, abs_tol=1e-12)


def state_after(machine, engine, span_s, level):
    """θ and θ̇/ω after 2^level equal steps."""
    spans = Forcing(
        length_s=np.array([span_s]),
        begin=np.zeros(1),
        end=np.ones(1),
        end_ns=np.array([round(span_s * 1e9)]),
        logged=np.ones(1, bool),
    )
    engine.release(spans)
    # whatever the error
    engine._tolerance = engine._tolerance._replace(step=math.inf)
    engine.longest_step_s = span_s / 2**level
    end = engine.advance(spans)
    return np.array([end.angle[0], end.rate[0] / machine.frequency])


def test_the_observed_order_of_eight_stages_is_near_sixteen():
    """Errors in the phase plane after spans of 0.4 to 0.6 s, with two and four steps each.

    They run from 1e-6 to 1e-13 rad, ωh from 0.7 to 2.1: as far from rounding as the order
    allows, and not yet asymptotic, whence ±2. A scheme of order 8 would show 8.
    """
    machine = compile_machine(
        scene_of(
            trochlea={
                'cam': {'kind': 'involute', 'base_radius': 0.01},
                'thread': {'kind': 'vertical'},
                'power': {'kind': 'weight', 'mass': 0.4},
            }
        )
    )
    engine = Collocation(machine)
    # doubles have no room for the order of sixteen (benchmarks/stress_motion.py)
    engine._work = make_work(1, WHEEL_NODES)
    observed = []
    for span in (0.4, 0.45, 0.5, 0.55, 0.6):
        exact, *coarse = (state_after(machine, engine, span, level) for level in (5, 1, 2))
        errors = [np.linalg.norm(found - exact) for found in coarse]
        observed.append(math.log2(errors[0] / errors[1]))
    assert np.mean(observed) == pytest.approx(16.0, abs=2.0)
