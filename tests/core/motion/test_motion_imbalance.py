"""A wheel with an eccentric centre of mass, on land and at sea, against DOP853."""

import math

import mpmath
import numpy as np
import pytest
from motion_cases import (
    INERTIA,
    angles,
    moved,
    on_land,
    phases,
    rolling,
    scene_of,
    waves,
    weight_of,
)
from reference_propagator import Reference, exact_phase

from tauto_core.machines import compile_machine, isochronism
from tauto_core.motion import propagator_name
from tauto_core.scene.errors import SceneError

G, FORCE, RATE = 9.80665, 2.0, 0.01
SEA = rolling((0.2, 7.3, 0.4), heave=waves((0.8, 9.1, 1.1)), height=2.5, rate=50.0)
WEIGHT = weight_of(0.2, RATE)
HOLE_WEIGHT = {'power': {'kind': 'weight', 'mass': 0.2, 'massless': True}}
UNBALANCED = {'imbalance': {'moment': 1.2e-4, 'direction': 0.7}}
MACHINES = {
    'force through a hole': UNBALANCED,
    'massless weight through a hole': HOLE_WEIGHT | UNBALANCED,
    'weight on a vertical thread': WEIGHT | UNBALANCED,
    'top-heavy by turns': {'imbalance': {'moment': 4e-4, 'direction': 3.0}, 'release_angle': 5.0},
}


@pytest.mark.parametrize(
    ('name', 'sea'), [*((name, True) for name in MACHINES), ('top-heavy by turns', False)]
)
def test_the_wheel_moves_as_by_dop853(name, sea):
    """Samples of 50 Hz are interpolated to 1e-12, and a step may err by 2e-12 of the swing."""
    ship = {'ship': SEA} if sea else {}
    scene = scene_of(trochlea=MACHINES[name], duration=30.0, log={'interval': 0.5}, **ship)
    machine = compile_machine(scene)
    assert propagator_name(machine, still=not sea) == 'collocation'
    phase = phases(scene)[1:]
    if sea:
        known = exact_phase(scene)
    else:
        exact = moved(Reference(machine), on_land(60, 0.5))
        known = math.pi * (exact.half_turns % 2 + exact.fraction)
    away = math.pi * (phase[:, 1] % 2.0 + phase[:, 2]) - known
    assert np.max(np.abs((away + math.pi) % math.tau - math.pi)) < 2e-9


def test_small_swings_gain_half_the_relative_moment():
    """ω² = (P b + m d g cos φ₀)/I: 43,200 m d g/(P b) s/day to the first order."""
    for direction, sign in ((0.0, 1.0), (math.pi, -1.0)):
        imbalance = {'moment': 1e-7, 'direction': direction}
        machine = compile_machine(scene_of(trochlea={'imbalance': imbalance}))
        plain = compile_machine(scene_of())
        share = 1e-7 * G / (FORCE * RATE)
        gain = 86400.0 * (plain.small_period / machine.small_period - 1.0)
        assert gain == pytest.approx(sign * 43200.0 * share, rel=1e-4)
        assert machine.period(1e-4) == pytest.approx(machine.small_period, rel=1e-8)
    # a weight on the vertical thread feels it in the same proportion everywhere
    rates = []
    for g in (9.78, 9.83):
        trochlea = WEIGHT | {'imbalance': {'moment': 1e-5}}
        machine = compile_machine(scene_of(trochlea=trochlea, gravity=g))
        rates.append(machine.frequency / math.sqrt(g))
    assert rates[0] == pytest.approx(rates[1], rel=1e-9)


@pytest.mark.parametrize('amplitude', [1.0, -1.0, 2.5])
def test_the_period_is_that_of_thirty_digits(amplitude):
    machine = compile_machine(scene_of(trochlea=UNBALANCED))
    mp = mpmath.mp.clone()
    mp.dps = 30
    stiff, torque, phi = mp.mpf(FORCE) * mp.mpf(RATE), mp.mpf(1.2e-4) * mp.mpf(G), mp.mpf(0.7)

    def well(x):
        return stiff * x * x / 2 - torque * (mp.cos(x + phi) - mp.cos(phi))

    top = well(mp.mpf(amplitude))
    ends = -0.5 * amplitude, -2.0 * amplitude
    far = mp.findroot(lambda x: well(x) - top, ends, solver='bisect', maxsteps=200)
    middle, half = (amplitude + far) / 2, (amplitude - far) / 2

    def slowness(w):
        x = middle + half * mp.cos(w)
        left = abs(top - well(x))
        return mp.sqrt(mp.mpf(INERTIA) / (2 * left)) * abs(half) * mp.sin(w)

    period = 2 * mp.quad(slowness, mp.linspace(0, mp.pi, 5))
    assert machine.period(amplitude) == pytest.approx(float(period), rel=1e-11)
    assert isochronism(machine, [1.0]).period_s[0] == machine.period(1.0)


def test_friction_holds_an_unbalanced_wheel_away_from_the_middle():
    """At rest at θ it holds while |P b θ + m d g sin(θ + φ₀)| ≤ c₀."""
    torque = FORCE * RATE * 0.01 + 1.2e-4 * G * math.sin(0.01 + 0.7)
    for friction, held in ((torque * 1.001, True), (torque * 0.999, False)):
        scene = scene_of(
            trochlea=UNBALANCED | {'release_angle': 0.01}, drag={'coulomb': friction}, duration=2.0
        )
        assert (np.ptp(angles(scene)[1]) == 0.0) == held


@pytest.mark.parametrize(
    ('trochlea', 'said'),
    [
        (
            {'imbalance': {'moment': 0.0}},
            r'trochlea\.imbalance\.moment = 0\.0: must be greater than 0',
        ),
        (
            WEIGHT | {'thread': {'kind': 'hanging', 'length': 1.0}} | UNBALANCED,
            r'moment = 0\.00012: does not go with trochlea\.thread\.kind hanging',
        ),
        (
            {'imbalance': {'moment': 0.01, 'direction': 0.7}},
            r'moment = 0\.01: outweighs the thread.* Use less than 0\.002039 kg m',
        ),
    ],
)
def test_an_impossible_imbalance_is_refused(trochlea, said):
    with pytest.raises(SceneError, match=said):
        compile_machine(scene_of(trochlea=trochlea))
