"""A body on a curve in a fluid, against its integrated motion; states, chunks, long runs."""

import math
from decimal import Decimal, getcontext

import numpy as np
import pytest
from motion_cases import regulator_scene, spans_to
from scipy.integrate import solve_ivp

from tauto_core.clockwork import TrochleaStage
from tauto_core.machines import compile_machine
from tauto_core.machines.fluid_pendulum import duration_excess, end_arc
from tauto_core.motion import make_propagator, propagator_name
from tauto_core.motion.fluid import HalfSwings, HalfSwingTable
from tauto_core.samples import JOINT_STATES, PHASE, READING
from tauto_core.scene.errors import PropagationError
from tauto_core.ship import ShipMotion

CURVES = ['euler', 'cycloid', 'symmetric']
RELEASED = ('euler', 0.4), ('euler', -0.6), ('cycloid', 0.4), ('symmetric', -0.6)
POINTS = {
    'curve': 'companion',
    'of': {
        'kind': 'points',
        'points': [[0.2, 0.022], [0.4, 0.09], [0.6, 0.21], [0.8, 0.39], [1.0, 0.66]],
    },
}
BRANCHED = {
    'companion of a circle': {'curve': 'companion', 'of': {'kind': 'circle', 'radius': 1.0}},
    'to a given cycloid': {
        'curve': 'companion',
        'of': {'kind': 'cycloid', 'pendulum_length': 0.9},
        'given': 'ascent',
    },
    'companion of points': POINTS,
    'two lengths': {'ascent_length': 0.7},
    'friction': {'friction': 0.003},
    'friction on a cycloid': {'curve': 'cycloid', 'friction': 0.003},
}
"""Curves with different branches, or with constant friction."""
REGULATOR = {
    'kind': 'fluid_tautochrone',
    'curve': 'euler',
    'body': 'globe',
    'diameter': 0.05,
    'body_density': 7800.0,
    'fluid_density': 900.0,
    'pendulum_length': 1.0,
    'release_arc': 0.4,
}


def scene_of(duration=30.0, log=0.05, **changes):
    return regulator_scene(REGULATOR | changes, duration, log)


def integrated(machine, times):
    """s, ds/dt by DOP853 of s̈ = −γg (p(s) ± μ) − κ ṡ|ṡ|, from one standstill to the next."""
    curve, gravity = machine.curve, machine.gravity

    def law(_, y):
        pull = float(curve.slope(y[0])) - math.copysign(machine.friction, state[0])
        return [y[1], -curve.gamma * gravity * pull - curve.kappa * y[1] * abs(y[1])]

    def still(_, y):
        return y[1]

    still.terminal = True
    found, begin, state = np.empty((2, len(times))), 0.0, [machine.release_arc, 0.0]
    turns = []
    while True:
        still.direction = math.copysign(1.0, state[0])
        run = solve_ivp(
            law, (begin, times[-1] + 9.0), state, 'DOP853', dense_output=True, events=still,
            rtol=1e-13, atol=1e-15, first_step=1e-3,
        )  # fmt: skip
        end = run.t_events[0][0]
        rows = (times >= begin) & (times < end)
        assert run.sol is not None
        found[:, rows] = run.sol(times[rows])
        turns.append(end)
        if end > times[-1]:
            return found, np.array(turns)
        begin, state = end, [run.y_events[0][0][0], 0.0]


@pytest.mark.parametrize(
    ('changes', 'close', 'close_rate'),
    [
        *(({'curve': c, 'release_arc': s}, 2e-9, 1e-2) for c, s in RELEASED),
        # DOP853 steps over the joint of the branches, and the rate of the phase has a step there
        *((changes, 5e-9, 0.06) for changes in BRANCHED.values() if changes is not POINTS),
    ],
)
def test_the_motion_is_the_integrated_one(changes, close, close_rate):
    """The dense output of DOP853 is good to 1e-10 or so."""
    machine = compile_machine(scene_of(**changes))
    times = np.arange(1, 300) * 0.05
    motion = make_propagator(machine, still=True).advance(spans_to(np.rint(times * 1e9)))
    expected, turns = integrated(machine, times)
    np.testing.assert_allclose(motion.angle, expected[0], atol=close)
    np.testing.assert_allclose(motion.rate, expected[1], atol=6.0 * close)
    np.testing.assert_array_equal(motion.half_turns, np.searchsorted(turns, times))
    assert np.all((motion.fraction >= 0.0) & (motion.fraction < 1.0))
    phase = np.pi * (motion.half_turns + motion.fraction)
    rate = np.gradient(phase, times)[1:-1]
    np.testing.assert_allclose(motion.phase_rate[1:-1], rate, rtol=close_rate)
    if machine.friction:
        return
    omega, release = machine.frequency, machine.release_arc
    side = math.copysign(1.0, release)
    polar = np.unwrap(np.arctan2(-side * expected[1] / omega, side * expected[0]))
    # relative to the arc at the time, at least a tenth of the release
    np.testing.assert_allclose(phase, polar, atol=50.0 * close)
    beats = np.cumsum(np.diff(np.sign(expected[0]), prepend=np.sign(release)) != 0)
    np.testing.assert_array_equal(motion.beats, beats)
    slope = machine.curve.slope(expected[0])
    weight = (7800.0 - 900.0) * math.pi / 6.0 * 0.05**3 * machine.gravity
    np.testing.assert_allclose(motion.torque, -weight * slope, atol=10.0 * close * weight)


def test_friction_stops_the_body_for_good():
    """Without a fluid each half swing is harmonic about ±γfμ, and takes 2γfμ from the amplitude.

    From 0.35 γf with μ = 0.1 they end at −0.15 and −0.05 γf. There the slope is less than μ.
    """
    changes = {'curve': 'cycloid', 'friction': 0.1, 'fluid_density': 0.0, 'release_arc': 0.35}
    machine = compile_machine(scene_of(**changes))
    half = math.pi / machine.frequency
    times = np.array([0.5, 1.0, 1.5, 2.0, 2.5, 9.0]) * half
    motion = HalfSwings(machine).advance(spans_to(np.rint(times * 1e9)))
    np.testing.assert_allclose(motion.angle, [0.1, -0.15, -0.1, -0.05, -0.05, -0.05], atol=1e-8)
    np.testing.assert_array_equal(motion.rate[-2:], 0.0)
    assert (motion.half_turns[-1], motion.fraction[-1], motion.phase_rate[-1]) == (2, 0.0, 0.0)


def test_twenty_thousand_half_swings_take_their_exact_time():
    """Ends of 20,000 half swings against sums of the closed forms, in 40 digits."""
    getcontext().prec = 40
    machine = compile_machine(scene_of())
    engine = HalfSwings(machine)
    kappa = machine.curve.kappa
    there, arc, back = 0, 0.4, Decimal(0)
    for _ in range(10_000):
        there, arc = there + 1, math.log1p(-math.expm1(-kappa * arc)) / kappa
        back += 1 + Decimal(float(duration_excess(kappa, arc)))
        arc = float(end_arc(kappa, arc))
    pi = Decimal('3.14159265358979323846264338327950288419716939937510582')
    exact = (there + back) * pi * (1 / Decimal(machine.gravity)).sqrt()
    before, after = (int((exact + Decimal(d)) * 10**9) for d in ('-1e-6', '1e-6'))
    motion = engine.advance(spans_to([before, after]))
    np.testing.assert_array_equal(motion.half_turns, [19_999, 20_000])
    assert motion.angle[1] == pytest.approx(arc, rel=1e-9)
    # each half swing errs by 1e-15 of itself: the table, and its sum
    begin = Decimal(engine.state()['begin_ns']) + Decimal(engine.state()['begin_rest'])
    assert abs(begin - exact * 10**9) < Decimal('2e-2')


@pytest.mark.parametrize(
    'changes',
    [*({'curve': curve} for curve in CURVES), POINTS, BRANCHED['friction']],
)
def test_a_run_does_not_depend_on_its_pieces_and_can_be_resumed(changes):
    machine = compile_machine(scene_of(**changes))
    times = np.cumsum(np.random.default_rng(5).integers(1, 3 * 10**9, 40))
    whole = HalfSwings(machine).advance(spans_to(times))
    first, second = HalfSwings(machine), HalfSwings(machine)
    parts = [first.advance(spans_to(part)) for part in (times[:7], times[7:8], times[8:31])]
    second.restore(first.state())
    parts.append(second.advance(spans_to(times[31:])))
    for name in ('angle', 'rate', 'torque', 'half_turns', 'fraction', 'phase_rate', 'beats'):
        found = np.concatenate([getattr(part, name) for part in parts])
        np.testing.assert_array_equal(found, getattr(whole, name))


@pytest.mark.parametrize('curve', CURVES)
@pytest.mark.parametrize('release', [1e-140, -1e-12, 0.35])
def test_a_swing_that_dies_away_stays_a_number(curve, release):
    machine = compile_machine(scene_of(curve=curve, release_arc=release, diameter=0.01))
    motion = HalfSwings(machine).advance(spans_to(np.arange(1, 40) * 10**12 // 3))
    for name in ('angle', 'rate', 'torque', 'fraction', 'phase_rate'):
        assert np.all(np.isfinite(getattr(motion, name))), name
    assert np.all(np.abs(motion.angle) <= abs(release))
    assert np.any(motion.angle != 0.0)
    np.testing.assert_allclose(motion.phase_rate, machine.frequency, rtol=1e-2)


@pytest.mark.parametrize('curve', CURVES)
def test_without_a_fluid_the_swing_stays_harmonic(curve):
    """For two days, against ωt in 40 digits."""
    getcontext().prec = 40
    machine = compile_machine(scene_of(curve=curve, fluid_density=0.0))
    seconds = np.array([1, 3600, 2 * 86_400 + 12_345]) * 10**9 + 678_901_234
    motion = HalfSwings(machine).advance(spans_to(seconds))
    pi = Decimal('3.14159265358979323846264338327950288419716939937510582')
    omega = Decimal(machine.gravity).sqrt()
    turned = [omega * Decimal(int(ns)) / 10**9 / pi for ns in seconds]
    phase = [
        Decimal(int(h)) + Decimal(f)
        for h, f in zip(motion.half_turns, motion.fraction, strict=True)
    ]
    for found, exact in zip(phase, turned, strict=True):
        # the table of a curve by quadrature is good to 1e-16 a half swing
        assert abs(found - exact) < Decimal('1e-9' if curve != 'euler' else '1e-14')


def test_stage_and_reading():
    """On the dial a half swing forward takes half its nominal period, and the next ones lag."""
    scene = scene_of(duration=10.0, log=0.001)
    ship, stage = ShipMotion(scene), TrochleaStage(scene)
    said = stage.feed({'ship/imu': ship.produce(ship.total)})
    assert said[JOINT_STATES].name == ('body',)
    machine = compile_machine(scene)
    assert propagator_name(machine, still=True) == 'half_swings'
    beats = said[PHASE].position[:, 3]
    # the first passage of A after a quarter, the second after a half and the way down backward
    quarter = 0.25 * machine.small_period
    first = np.argmax(beats == 1.0) * 1e-3
    assert first == pytest.approx(quarter, abs=1e-3)
    error = said[READING].time_ref_ns - said[READING].stamp_ns
    turns = said[PHASE].position[:, 1]
    ends = np.flatnonzero(np.diff(turns))
    assert abs(error[ends[0]]) < 1e6
    excess = float(duration_excess(machine.curve.kappa, -said[JOINT_STATES].position[ends[0], 0]))
    assert error[ends[1]] == pytest.approx(-0.5e9 * machine.small_period * excess, abs=1.1e6)


def test_half_swings_that_no_series_describes_are_refused():
    with pytest.raises(PropagationError, match='resists too strongly'):
        HalfSwingTable(lambda s: (abs(math.sin(1e3 * s)), -s), 1.0)
