"""The facts of `tauto scene check`: what would run and why, and how a hanging link follows."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tauto_core as tauto
from tauto_core.checks.facts import (
    case_following,
    reason,
    slack_thread,
    thread,
    thread_following,
    way,
)
from tauto_core.machines import compile_machine
from tauto_core.machines.axle_pendulum import answers, modes
from tauto_core.motion import propagator_name
from tauto_core.scene import Scene, load_scene
from tauto_core.scene.errors import ABSENT
from tauto_core.scene.tables import data_path
from tauto_core.scene.times import DAY_S
from tauto_core.ship.coast import ends_of

RECOIL = {'kind': 'impulse', 'energy': 9e-5, 'rest': {'recoil': 1e-6}}


@pytest.mark.parametrize(
    'name', ['hanging_thread_at_sea', 'sully_lever_at_sea', 'involute_weight_at_sea']
)
@pytest.mark.parametrize('still', [False, True])
@pytest.mark.parametrize('drag', [ABSENT, {'viscous': 1e-5}])
@pytest.mark.parametrize('escapement', [ABSENT, RECOIL])
def test_a_reason_has_the_causes_of_its_scene_alone(name, still, drag, escapement):
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


def test_a_force_in_the_case_leaves_a_lever_to_the_roll() -> None:
    """The apparent gravity acts on a weight, a force turns with the case, as the lever does."""
    power = {'kind': 'force', 'force': 0.5}
    keys = {'trochlea.power': power, 'trochlea.thread.inertia': 1e-6}
    scene = load_scene('sully_lever_at_sea', **keys)
    said = reason(scene, compile_machine(scene), 'collocation')
    assert 'the roll and drag in a well that is not harmonic' in said
    assert 'gravity' not in said


G = 9.80665
SIZES = st.floats(0.01, 10.0)


@given(SIZES, SIZES, SIZES, st.floats(0.05, 50.0))
def test_the_answer_solves_the_equations(e, c, k, frequency):
    """−eX θ − cX φ + gθ = gτ and −k²X φ + gc(φ − θ) = 0 with X = Ω², away from resonance."""
    own, square = modes(e, c, k * k), frequency**2
    apart = min(abs(square / mode - 1.0) for mode in own.squared_frequencies(G))
    if apart < 0.01:
        return
    system = [[G - e * square, -c * square], [-G * c, G * c - k * k * square]]
    expected = np.linalg.solve(system, [G, 0.0])
    found = np.ravel(answers(own, c, k * k, np.array([frequency]), G, 1e9))
    # θ vanishes where the body is its own absorber: by the larger of both
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_in_resonance_the_answer_grows_with_the_duration():
    own = modes(0.015, 0.1, 0.04)
    slow = math.sqrt(own.squared_frequencies(G)[0])
    short, long = (answers(own, 0.1, 0.04, np.array([slow]), G, t)[1][0] for t in (1e3, 1e4))
    assert long == pytest.approx(10.0 * short, rel=1e-9)


def hanging(length, **ship):
    keys = {'trochlea.thread.length': length, 'trochlea.release_angle': 0.5}
    scene = load_scene('hanging_thread_at_sea', ship=ship or ROLL, **keys)
    return scene, compile_machine(scene)


ROLL = {'kind': 'components', 'components': [{'amplitude': 0.1, 'period': 9.0}]}


@pytest.mark.parametrize(
    ('length', 'resonates'),
    [
        # threads.md: the rows of the table of threads that gain and lose
        (0.2, ('wheel',)), (0.26, ('wheel',)), (0.5, ()), (1.0, ()), (4.0, ()),
        (16.0, ('waves',)), (20.0, ('waves',)), (32.0, ('waves',)),
    ],
)  # fmt: skip
def test_the_threads_that_the_theory_warns_of(length, resonates):
    found = thread_following(*hanging(length))
    assert found.resonates_with == resonates
    if not resonates:
        # a plain pendulum that the wheel hardly moves: X/(ω² − X)
        ratio = (found.periods_s[0] / 9.0) ** 2
        assert found.departure == pytest.approx(ratio / (1.0 - ratio), rel=0.02)
        tilt = 3.0 * 0.1 * (math.tau / 9.0) ** 2 / G / math.sqrt(2.0)
        assert found.departure_rad == pytest.approx(found.departure * tilt, rel=1e-12)


def test_between_which_lengths_a_thread_is_fair():
    """Theory A: 0.248 m and 20.1 m."""
    assert thread(*hanging(1.0))['fair_lengths_m'] == pytest.approx([0.248, 20.1], rel=3e-3)


def test_where_no_wave_is_known_no_departure_is_told():
    scene, machine = hanging(1.0, kind='still')
    found = thread_following(scene, machine)
    assert (found.departure, found.departure_rad, found.resonates_with) == (None, None, ())
    assert thread(scene, machine)['fair_lengths_m'][1] is None
    assert case_following(scene, machine) is None


RIPPLES = {
    'kind': 'sea',
    'heave': True,
    'rate': 20.0,
    'roll': {'natural_period': 11.0, 'damping_ratio': 0.3, 'slope_coefficient': 0.3},
    'sea': {'spectrum': 'jonswap', 'significant_wave_height': 1.5, 'peak_period': 3.0},
}
"""Waves so short and steep that a cork falls away from a weight."""


def in_ripples(power: dict[str, Any], clock: dict[str, Any] = {}, **ship: Any) -> Scene:  # noqa: B006
    keys = {'log.interval': 10.0, 'solver.tolerance': 1e-9, 'seed': 0, 'ship': RIPPLES | ship}
    keys |= {'trochlea.cam.base_radius': 0.02, 'trochlea.power': power, 'duration': 7200.0}
    return load_scene('involute_weight_at_sea', **keys | clock)


HIGHER = {'spectrum': 'jonswap', 'significant_wave_height': 1.8, 'peak_period': 3.0}
GOING = {
    'duration': 2400.0,
    'drag': {'viscous': 4e-4},
    'escapement': {'kind': 'impulse', 'energy': 2e-3, 'angle': 0.1},
}


def test_as_many_slack_threads_are_expected_as_are_counted():
    """Within twice the scatter √N. Without drag the sea would wind the wheel up."""
    scene = in_ripples({'kind': 'weight', 'mass': 0.05}, clock=GOING, sea=HIGHER)
    found = slack_thread(scene)
    assert found is not None
    expected = found['times_a_day'] * scene.duration / DAY_S
    counted = tauto.sail(scene).result['trochlea']['slacks']
    assert expected > 60.0
    assert abs(counted - expected) < 2.0 * math.sqrt(expected)


@pytest.mark.parametrize(
    ('power', 'ship'),
    [
        ({'kind': 'force', 'force': 0.5}, {}),
        ({'kind': 'weight_and_spring', 'mass': 0.05, 'stiffness': 5.0}, {}),
        ({'kind': 'weight', 'mass': 0.05}, {'heave': False}),
    ],
)
def test_no_slack_is_reckoned_where_no_weight_alone_is_heaved(power, ship):
    assert slack_thread(in_ripples(power, **ship)) is None


def test_no_slack_is_reckoned_for_an_operator_without_heave(tmp_path):
    head, *rows = data_path('shipped:supply_rao/supply_rao.csv').read_text('utf-8').split()
    flat = [','.join([*row.split(',')[:4], '0', '0']) for row in rows]
    operator = tmp_path / 'flat.csv'
    operator.write_text('\n'.join([head, *flat]) + '\n', 'utf-8')
    assert slack_thread(load_scene('buoy_44004_supply')) is not None
    scene = load_scene('buoy_44004_supply', **{'ship.rao.path': str(operator)})
    assert slack_thread(scene) is None


@pytest.mark.parametrize(
    ('name', 'landfalls', 'at_sea'),
    [('boussole_pacific', 0, True), ('portsmouth_jamaica', 2, False)],
)
def test_the_check_and_the_voyage_agree_on_a_landfall(name, landfalls, at_sea):
    """The log of the Boussole ends 176 km from a coast. Madeira and Jamaica are landfalls."""
    scene = tauto.load(name)
    facts = way(scene)
    assert facts is not None
    assert len(facts['landfalls_s']) == landfalls
    ends = {key: facts[key] for key in ('ends',) if key in facts}
    assert ends == ends_of(scene.voyage, scene.duration)
    assert bool(ends) is at_sea
