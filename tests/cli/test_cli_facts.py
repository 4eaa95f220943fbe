"""`tauto scene check`: propagator, omissions, cost and accuracy."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml

import tauto_core as tauto
from tauto_core.checks.facts import propagator_name, reason
from tauto_core.checks.readiness import check_scene
from tauto_core.cli.tables import facts_table
from tauto_core.machines import SlackThreadError
from tauto_core.scene import load_scene, parse_scene, scene_yaml

IDEAL = yaml.safe_load(scene_yaml(load_scene('ideal')))
TROCHLEA = IDEAL['trochlea']
FORCE, WEIGHT = TROCHLEA['power'], {'kind': 'weight', 'mass': 0.16}
VERTICAL = {
    'cam': {'kind': 'involute', 'base_radius': 0.01},
    'thread': {'kind': 'vertical'},
    'power': WEIGHT,
}
ROLL = {'kind': 'components', 'components': [{'amplitude': 0.1, 'period': 9.0}]}
HUNG = {'support_radius': 0.02, 'axle_radius': 0.005, 'depth': 0.1, 'gyration_radius': 0.05}
HEAVE = {'kind': 'components', 'heave': [{'amplitude': 0.5, 'period': 9.0}]}


pytestmark = pytest.mark.usefixtures('short_trials')
"""Errors are tested in test_checks_cost.py."""


def facts(folder: Path, trochlea: dict[str, Any] | None = None, **changes: Any) -> dict[str, Any]:
    """Return the facts of the ideal scene with changes."""
    content = IDEAL | {'trochlea': TROCHLEA | (trochlea or {})} | changes
    scene = folder / 'scene.yaml'
    scene.write_text(yaml.safe_dump(content))
    found = tauto.check(scene)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    return found


@pytest.mark.parametrize(
    ('changes', 'propagator', 'said'),
    [
        ({}, 'harmonic', ['a still ship']),
        ({'trochlea': {'power': FORCE | {'kind': 'spring', 'stiffness': 5.0}}}, 'action_angle',
         ["spring's stiffness"]),
        ({'ship': ROLL}, 'forced_harmonic', ['the roll in a harmonic well', 'exact step']),
        ({'drag': {'viscous': 1e-6}}, 'forced_harmonic', ['viscous drag in a harmonic well']),
        ({'drag': {'viscous': 1.0}}, 'collocation', ['stops the wheel before it swings']),
        ({'drag': {'quadratic': 1e-6}}, 'collocation', ['quadratic drag is not linear']),
        ({'drag': {'coulomb': 1e-9}}, 'collocation', ['friction turns round']),
        ({'trochlea': VERTICAL, 'drag': {}}, 'collocation', ['leave it out']),
        ({'escapement': {'energy': 1e-6, 'rest': {'friction': 1e-9, 'recoil': 1e-6}}},
         'collocation', ['friction turns round', 'recoil turns round at each impulse']),
    ],
)  # fmt: skip
def test_the_reason_names_what_decides(
    changes: dict[str, Any], propagator: str, said: list[str]
) -> None:
    trochlea = TROCHLEA | changes.get('trochlea', {})
    scene = parse_scene(yaml.safe_dump(IDEAL | changes | {'trochlea': trochlea}), 'ideal')
    machine, _ = check_scene(scene)
    assert propagator_name(machine, still=scene.lies_still) == propagator
    assert all(words in reason(scene, machine, propagator) for words in said)


def test_a_voyage_is_shown_with_length_speed_and_landfalls(tmp_path: Path) -> None:
    """Two degrees of the equator, 222 639.0 m, in 100 s. The landfall is half way."""
    assert facts(tmp_path)['voyage'] is None
    way = {'departure': [0, 0], 'arrival': [0, 2], 'track': 'rhumb', 'sails_at': 100.0}
    way |= {'waypoints': [{'place': [0, 1], 'landfall': True}], 'speed': 2226.39}
    found = facts(tmp_path, duration=600.0, voyage=way)
    voyage = found['voyage']
    assert voyage['length_m'] == pytest.approx(222_638.98, abs=0.01)
    assert voyage['landfalls_s'] == pytest.approx([150.0, 200.0], abs=1e-3)
    said = 'rhumb of 120.2 nmi in 100 seconds, 2,230 m/s, landfalls after 2.5 minutes, 3.33 min'
    assert said in printed(found)


def test_a_wheel_that_creeps_home_is_tried_for_a_minute(tmp_path: Path) -> None:
    """No swing predicts its steps. Two hours of it took 10 s, after which the trial was cut."""
    found = facts(tmp_path, drag={'viscous': 1.0}, duration=86_400.0)['expected']
    assert found['tried_s'] == 60.0
    assert not found['was_cut']
    assert found['error_s'] is not None


def test_steps_are_shown_if_steps_are_taken(tmp_path: Path) -> None:
    assert facts(tmp_path)['expected']['steps_a_swing'] is None
    assert facts(tmp_path)['expected']['tolerance'] is None
    steps = []
    seldom = ROLL | {'rate': 5.0}  # pieces of more than a step
    for tolerance in (1e-15, 1e-9):
        found = facts(tmp_path, VERTICAL, ship=seldom, solver={'tolerance': tolerance})
        assert found['expected']['tolerance'] == tolerance
        steps.append(found['expected']['steps_a_swing'])
    assert steps[0] > steps[1] >= 1.0


def printed(found: dict[str, Any]) -> str:
    """Return the table of facts without its line breaks."""
    return ' '.join(facts_table(found).split())


def test_the_table_keeps_every_word_at_any_width(monkeypatch: pytest.MonkeyPatch) -> None:
    found = tauto.check('cheek_before_euler')
    monkeypatch.setenv('COLUMNS', '70')
    assert max(map(len, facts_table(found).splitlines())) <= 70
    text = printed(found)
    assert f'collocation: {found["reason"]}' in text
    assert 'drag.coulomb: The pivots turn without dry friction.' in text
    assert 'wear: No part wears.' in text
    assert 'air: The clock stays at one temperature (−10.4 s/day/K with all of steel' in text
    for row in found['left_out']:
        assert f'{row["key"] or row["what"]}: {row["why"][:-1]}' in text


@pytest.mark.parametrize(
    ('name', 'said'),
    [
        ('globe_in_oil', ['from the period']),
        ('cheek_before_euler', ['from the tolerance']),
        ('measured', ['from sampling the motion', 'taken as measured']),
        ('involute_weight_at_sea', ['from sampling waves down to 1.69 s']),
    ],
)
def test_the_table_says_which_error_there_is(name: str, said: list[str]) -> None:
    text = printed(tauto.check(name))
    assert all(words in text for words in said)


def test_the_table_names_extrapolated_and_unknown_errors() -> None:
    found = tauto.check('ideal')
    found['expected'] |= {'error_s': 2.0, 'tried_s': 43_200.0}
    text = printed(found)
    assert 'at most 2 s of the reading, extrapolated from 12 hours' in text
    assert 'cannot be predicted' in text
    found['expected']['error_s'] = None
    assert 'not known: the step of ship.rate' in printed(found)


def test_a_suspension_is_named_with_its_periods(tmp_path: Path) -> None:
    """b + b' = (k² + c² + ce)/c = 0.14 m, b b' = ek²/c = 3.75e-4 m²; T = 2π√(b/g)."""
    assert facts(tmp_path)['suspension'] is None
    found = facts(tmp_path, ship=ROLL, suspension=HUNG)
    assert 'warnings' not in found
    slow, fast = found['suspension']['lengths_m']
    assert (slow + fast, slow * fast) == pytest.approx((0.14, 3.75e-4), rel=1e-12)
    assert found['suspension']['periods_s'] == pytest.approx([0.74337, 0.10487], rel=1e-4)
    assert found['suspension']['step_s'] == 0.00625
    # Ω²(1/ω² + 1/ω′²) to the first order: a case far below its own swings
    departure = (0.74337**2 + 0.10487**2) / 9.0**2
    assert found['suspension']['departure'] == pytest.approx(departure, rel=0.02)
    assert 'suspension' not in {row['what'] for row in found['left_out']}
    assert 'the swing of the case in a harmonic well' in found['reason']
    text = printed(found)
    assert 'axle, small angles: the case swings in 0.7434 s and 0.1049 s' in text
    large = facts(tmp_path, ship=ROLL, suspension=HUNG | {'large_angles': True})
    assert 'axle, any angles' in printed(large)


def test_the_steady_swing_is_predicted(tmp_path: Path) -> None:
    """Friction c₀ and an impulse E in the middle: A = E/(2 c₀), on any cam."""
    free = facts(tmp_path)['steady_swing']
    assert (free['amplitude_rad'], free['time_constant_s']) == (TROCHLEA['release_angle'], None)
    assert free['rate_s_per_day'] == pytest.approx(0.0, abs=1e-6)
    driven = {'drag': {'coulomb': 1e-5}, 'escapement': {'energy': 1.6e-5, 'angle': 0.0}}
    found = facts(tmp_path, VERTICAL, **driven)
    swing = found['steady_swing']
    assert swing['amplitude_rad'] == pytest.approx(0.8, rel=1e-12)
    assert swing['free_rate_s_per_day'] < -100.0
    assert swing['rate_s_per_day'] == pytest.approx(swing['free_rate_s_per_day'], abs=2.0)
    text = printed(found)
    kept_up = swing['rate_s_per_day'] - swing['free_rate_s_per_day']
    assert -0.1 < kept_up < -0.001
    told = f'rate −{-swing["rate_s_per_day"]:.0f} s/day (−{-kept_up:.3f} of it by drag and esc'
    assert f'0.8 rad, {told}' in text
    stops = facts(tmp_path, **driven | {'escapement': {'energy': 1e-6, 'angle': 0.5}})
    assert 'the clock stops' in stops['steady_swing']['why']
    assert 'none: the clock stops' in printed(stops)
    assert tauto.check('globe_in_oil')['steady_swing'] is None
    assert tauto.check('hanging_thread_at_sea')['steady_swing'] is None


def test_a_case_in_resonance_with_the_wheel_is_warned_of(tmp_path: Path) -> None:
    found = facts(tmp_path, ship=ROLL, suspension=HUNG | {'gyration_radius': 0.1192})
    (warning,) = found['warnings']
    assert 'suspension: swings by itself in 1 s and 0.1858 s, in resonance with' in warning


def test_the_expected_number_of_slacks_is_shown(tmp_path: Path) -> None:
    found = facts(tmp_path, VERTICAL, ship=ROLL)
    assert 'slack' not in found
    found['slack'] = {'acceleration_m_s2': 3.3647, 'times_a_day': 1e-9}
    said = 'not expected in the highest sea, with a vertical acceleration of 3.4 m/s² rms'
    assert said in printed(found)
    found['slack']['times_a_day'] = 963.9
    assert 'about 964 times a day in the highest sea' in printed(found)


def test_the_range_of_the_ideal_thread_is_shown(tmp_path: Path) -> None:
    """From g/ω² = I/(m r) to g/Ω²."""
    assert facts(tmp_path)['thread'] is None
    found = facts(tmp_path, VERTICAL, ship=ROLL)
    said = 'is much longer than 0.25 m (wheel) and much shorter than 20.1 m (waves)'
    assert said in printed(found)


def test_coefficients_are_shown_with_their_source(tmp_path: Path) -> None:
    """The roll does not act on a force: the trials give 0, with the allowance for small waves."""
    drift = {
        'covariates': ['heave', 'roll'],
        'coefficients': {'heave': {'value': 0.0, 'sigma': 0.05}},
    }
    found = facts(tmp_path, ship=ROLL | HEAVE, drift=drift)
    assert found['covariates']['heave'] == {'value': 0.0, 'sigma': 0.05, 'at_periods': None}
    roll = found['covariates']['roll']
    assert roll['sigma'] == pytest.approx(0.005, rel=1e-3)
    assert list(roll['at_periods']) == ['6.0', '9.0', '13.0']
    assert [abs(k) < 1e-6 for k in (roll['value'], *roll['at_periods'].values())] == [True] * 4
    text = printed(found)
    assert 'coefficient of heave 0.000 ± 0.050, from the scene' in text
    assert 'coefficient of roll 0.0000 ± 0.0050, from trial runs' in text


def test_a_rate_that_walks_more_than_expected_is_warned_of(tmp_path: Path) -> None:
    content = yaml.safe_load(scene_yaml(load_scene('hanging_thread_at_sea')))
    scene = tmp_path / 'scene.yaml'
    scene.write_text(yaml.safe_dump(content))
    assert 'warnings' not in tauto.check(scene)
    del content['drift']['random_walk_fm']
    scene.write_text(yaml.safe_dump(content))
    (warning,) = tauto.check(scene)['warnings']
    _, _, advised = warning.rpartition('Write drift.random_walk_fm: ')
    content['drift']['random_walk_fm'] = float(advised)
    scene.write_text(yaml.safe_dump(content))
    assert 'warnings' not in tauto.check(scene)


@pytest.mark.parametrize(
    ('scene', 'wanders'), [('clock_sully_lever', True), ('clock_second_cam_force', False)]
)
def test_a_weight_in_a_hung_case_is_warned_of_a_wandering_rate(
    scene: str, *, wanders: bool
) -> None:
    """The force and the spring do not feel how the case swings."""
    found = tauto.check(scene, duration=3600.0).get('warnings', [])
    assert any('the swing of the case is undamped' in each for each in found) == wanders


def test_a_machine_stopped_by_the_trial_sea_is_warned_of(monkeypatch: pytest.MonkeyPatch) -> None:
    def slack(*_: object) -> None:
        raise SlackThreadError('the thread went slack')

    monkeypatch.setattr('tauto_core.checks.facts.fit', slack)
    (warning,) = tauto.check('hanging_thread_at_sea')['warnings']
    assert 'could not be tried: the thread went slack' in warning


def test_the_decisive_sea_is_shown() -> None:
    found = tauto.check('portsmouth_jamaica', **{'ship.rate': 2.5})
    sea, wave_s = found['expected']['decided_by'], found['expected']['shortest_wave_s']
    assert sea['why'] in ('highest', 'met fastest')
    text = printed(found)
    day = f'on day {sea["at_s"] / 86_400.0:.2f}'
    assert f'sampling waves down to {wave_s:.3g} s in the sea {sea["why"]}, {day}' in text


def test_chaos_is_reported_with_growth_time_and_bound(tmp_path: Path) -> None:
    found = facts(tmp_path)
    assert (found['expected']['growth'], found['expected']['bounded_until_s']) == (None, None)
    growth = {'followed_s': 7200.0, 'per_s': 2e-3, 'per_s_sigma': 2e-4, 'is_chaotic': True}
    found['expected'] |= {'error_s': 0.01, 'growth': growth}
    text = printed(found)
    assert 'at most 0.01 s of the reading' in text
    assert 'chaotic: a small difference grows e-fold in 7.6 minutes to 9.3 minutes' in text
    found['expected'] |= {'error_s': None, 'bounded_until_s': 7200.0}
    text = printed(found)
    assert 'cannot be bounded beyond 2 hours' in text
    assert 'from sampling' not in text


def test_trials_that_were_cut_are_reported(tmp_path: Path) -> None:
    found = facts(tmp_path, VERTICAL, ship=ROLL)
    found['expected'] |= {'was_cut': True, 'tried_s': 12.0}
    text = printed(found)
    assert 'trial runs ended after 10 s of processor time, at 12 seconds of the voyage' in text
    found['expected'] |= {'error_s': None}
    assert 'not known: the trial runs cost too much' in printed(found)
