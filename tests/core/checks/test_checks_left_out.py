"""The effects that a scene leaves out: six kinds of scene, the words and the figures."""

import json
import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipe

import tauto_core as tauto
from tauto_core.checks.facts import TABLE, USUAL_MASS, Omission, frequency_in_light_case, left_out
from tauto_core.curves.materials import MATERIALS
from tauto_core.machines import compile_machine
from tauto_core.scene.errors import ABSENT, SceneError
from tauto_core.scene.reference import schema

DAY_S = 86_400.0
CLOCK = {'mass and stretch of the thread', 'wear', 'friction of the pivots', 'clock noise'}
FREE = CLOCK | {'drag', 'escapement'}
DRIVEN = CLOCK | {'quadratic drag', 'ageing of the oil', 'recoil', 'fall of the drive'}
SEA = {'short-crested sea', 'shallow water', 'heel under sail', 'motions of the ship'}
CORK = SEA | {'sideways half of the sea'}
HULL = SEA - {'motions of the ship'} | {'slamming and green water'}
AS_A_CORK = {'ship.hull': ABSENT, 'ship.heave': True, 'ship.roll.slope_coefficient': 0.7}
GIMBALS = {'kind': 'gimbals', 'depth': 0.05, 'gyration_radius': 0.12}


def found(name: str, **changes: Any) -> dict[str, Omission]:
    """Return the effects that a shipped scene with changes leaves out, by name."""
    scene = tauto.load(name, **changes)
    return {row.what: row for row in left_out(scene, compile_machine(scene))}


@pytest.mark.parametrize(
    ('name', 'changes', 'names'),
    [
        ('ideal', {}, FREE | {'balance of the wheel', 'heat', 'motions of the ship', 'voyage'}),
        ('globe_in_oil', {}, {'added mass', 'viscosity of the fluid', 'motions of the ship',
                              'clock noise', 'voyage'}),
        ('measured', {}, FREE | {'balance of the wheel', 'heat', 'swing of the thread',
                                 'suspension', 'motions of the ship', 'gravity by latitude'}),
        ('sully_lever_at_sea', {}, DRIVEN | HULL | {'balance of the wheel', 'mass of the lever',
                                                    'heat', 'suspension', 'voyage'}),
        ('hanging_thread_at_sea', AS_A_CORK, FREE | CORK | {
            'balance of the wheel', 'damping of the thread', 'thread fore and aft', 'heat',
            'suspension', 'voyage'}),
        ('second_cam_at_sea', {'suspension': GIMBALS}, FREE | HULL | {
            'balance of the wheel', 'heat', "the case's answer to the wheel",
            'damping of the case', 'outer ring of the gimbals', 'voyage'}),
        ('portsmouth_jamaica', {'drag.oil': ABSENT}, DRIVEN | HULL | {
            'balance of the wheel', 'swing of the thread', 'heat in the oil',
            'spells of warm and cold', 'suspension', 'push of the waves under way',
            'anomalies of gravity'}),
        ('clock_own_cam_spring', {
            'trochlea.material': ABSENT, 'trochlea.power.material': ABSENT,
            'trochlea.compensation': ABSENT, 'drag.thickens_per_month': 0.02,
            'drag.coulomb': 1e-7, 'drag.quadratic': 1e-9, 'clock.white_fm': 0.1,
            **AS_A_CORK, 'ship.heave': False},
         DRIVEN - {'ageing of the oil', 'quadratic drag', 'friction of the pivots',
                   'clock noise'} | SEA | {
            'balance of the wheel', 'heat in wheel and cam', 'heat in the spring',
            'heat in the suspension', 'spells of warm and cold', 'damping of the case',
            "the case's answer to the wheel"}),
    ],
)  # fmt: skip
def test_a_scene_leaves_out_what_it_has_not_and_nothing_else(name, changes, names):
    assert set(found(name, **changes)) == names


@pytest.mark.parametrize(
    ('name', 'changes', 'what'),
    [
        ('ideal', {'drag': {'viscous': 1e-6}}, 'drag'),
        ('ideal', {'drag': {'coulomb': 1e-9}}, 'friction of the pivots'),
        ('ideal', {'escapement': {'energy': 1e-6}}, 'escapement'),
        ('sully_lever_at_sea', {'escapement.rest': {'recoil': 1e-6}}, 'recoil'),
        ('portsmouth_jamaica', {'escapement.train': {'fall': 0.1, 'impulses': 100}},
         'fall of the drive'),
        ('ideal', {'trochlea.imbalance': {'moment': 1e-6}}, 'balance of the wheel'),
        ('hanging_thread_at_sea', {'trochlea.thread.damping_ratio': 0.1},
         'damping of the thread'),
        ('hanging_thread_at_sea', {'ship': {'kind': 'still'}}, 'thread fore and aft'),
        ('measured', {'gravity': 'normal'}, 'gravity by latitude'),
        ('globe_in_oil', {'regulator.added_mass': 0.5}, 'added mass'),
        ('sully_lever_at_sea', {'trochlea.thread.inertia': 1e-5}, 'mass of the lever'),
        ('second_cam_at_sea', {'suspension': GIMBALS | {'damping_ratio': 0.1}, 'seed': 2},
         'damping of the case'),
    ],
)  # fmt: skip
def test_what_the_key_brings_in_is_left_out_no_more(name, changes, what):
    without = {key: value for key, value in changes.items() if key == 'suspension'}
    if without:
        without = {'suspension': GIMBALS}
    assert what in found(name, **without)
    assert what not in found(name, **changes)


def test_what_depends_on_the_scene_is_said_for_that_scene() -> None:
    lying = found('ideal')
    assert lying['motions of the ship'].why == 'The ship does not move.'
    assert lying['heat'].key == 'air'
    recorded = found('measured')['motions of the ship']
    assert recorded.why == 'The ship has no surge, no sway, no pitch, no yaw.'
    cork = found('involute_weight_at_sea', **AS_A_CORK)
    assert cork['motions of the ship'].why == 'The ship has no pitch, no yaw.'
    assert cork['motions of the ship'].key == 'ship.hull'
    lever = found('sully_lever_at_sea')
    assert {lever[what].key for what in ('balance of the wheel', 'fall of the drive')} == {None}
    assert lever['heat'].key == 'air'
    assert lever['heel under sail'].worth is not None
    assert found('clock_sully_lever')['heel under sail'].worth is None
    # a force in gimbals: the sea's other half and its own weight do not matter to it
    hung = found('second_cam_at_sea', suspension=GIMBALS, **AS_A_CORK)
    assert hung['sideways half of the sea'].worth is None
    answer = hung["the case's answer to the wheel"]
    assert answer.worth == '+376 s/day in a case of 10 kg'
    parts = ('trochlea.material', 'drag.oil')
    cold = found('portsmouth_jamaica', **dict.fromkeys(parts, ABSENT))
    assert (cold['heat'].key, cold['heat'].why) == (
        'trochlea.material',
        'Heat changes no part of the clock.',
    )
    massless = found('measured', **{'trochlea.power.massless': True})
    assert massless['inertia of the weight'].key == 'trochlea.power.massless'


def test_every_entry_has_name_sentence_and_key() -> None:
    known = json.dumps(schema())
    assert len({row.what for row in TABLE}) == len(TABLE)
    for row in TABLE:
        assert row.what[0].islower()
        assert row.why[0].isupper()
        assert row.why.endswith('.')
        assert len(row.why.split()) <= 18
        assert row.worth is None or not row.worth.endswith('.')
        for part in (row.key or 'drag').split('.'):
            assert f'"{part}"' in known


def test_the_figures_are_those_of_the_formulas() -> None:
    """(heat.4), (gravity.1), (wheel.2), and a level lever that heels: its weight pulls as cos."""
    worth = {row.what: str(row.worth) for row in TABLE}
    steel, brass = MATERIALS['steel'], MATERIALS['brass']
    spring = 0.5 * steel.force * DAY_S
    assert worth['heat in the spring'].startswith(f'−{-spring:.1f} ')
    of_steel = found('second_cam_at_sea')['heat'].worth
    assert str(of_steel).startswith(f'−{-spring + 0.5 * steel.expansion * DAY_S:.1f} ')
    of_brass = f'−{0.5 * brass.expansion * DAY_S:.1f} '
    assert worth['heat in wheel and cam'].startswith(of_brass)
    assert str(found('measured')['heat'].worth).startswith(of_brass)
    mgal = 2e5 * 9.80665 / DAY_S
    assert str(worth['anomalies of gravity']).startswith(
        f'1 s/day for a weight by {mgal:.1f} mGal'
    )
    # Q = 100 P and a disc as wide as the cam: ε = 2 P/Q
    lost = (1.0 - 0.5 * math.pi / ellipe(-0.02)) * DAY_S
    assert worth['inertia of the weight'].startswith(f'−{lost:.0f} ')
    heel = [(math.sqrt(math.cos(math.radians(angle))) - 1.0) * DAY_S for angle in (5.0, 10.0)]
    said = str(found('sully_lever_at_sea')['heel under sail'].worth)
    assert all(f'−{-each:.0f}' in said for each in heel)
    # Bretschneider's spectrum of 2.5 m and 9 s in units of ω_p, to 4 ω_p: ∫ ω⁴S dω
    square, _ = quad(lambda w: 5.0 / 16.0 * 2.5**2 / w * math.exp(-1.25 / w**4), 0.1, 4.0)
    square *= (math.tau / 9.0) ** 4
    cork = str(found('sully_lever_at_sea', **AS_A_CORK)['sideways half of the sea'].worth)
    assert cork.startswith(f'−{square / (8.0 * 9.80665**2) * DAY_S:.0f} ')
    fixed = found('portsmouth_jamaica', gravity=9.81)
    # 43 200 Δγ/γ, nearly
    assert '−115.4 s/day' in str(fixed['gravity by latitude'].worth)


@pytest.mark.parametrize(('depth', 'shift'), [(0.05, 376.0), (0.1, -1380.0)])
def test_the_rate_in_a_light_case_is_that_of_the_two_modes(depth: float, shift: float) -> None:
    """The formula ½(I/J)/(1 − ω_c²/ω²) has +386 and −3,848, not the roots of (suspension.5)."""
    inertia, omega, gravity = 4e-4, math.tau, 9.81
    hung = tauto.load('second_cam_at_sea', suspension=GIMBALS | {'depth': depth}).suspension
    assert hung is not None
    found = frequency_in_light_case(hung, inertia, omega, gravity)
    square = 0.12**2 + depth**2
    share, case = inertia / (USUAL_MASS * square), gravity * depth / square
    roots = np.sqrt(np.roots([1.0, -(omega**2 * (1.0 + share) + case), omega**2 * case]))
    assert np.min(np.abs(roots - found)) < 1e-12 * found
    assert (found / omega - 1.0) * DAY_S == pytest.approx(shift, abs=2.0)


def test_the_mode_on_an_axle_solves_the_printed_equations() -> None:
    """det(K − ω²M) = 0 of (suspension.1) with the wheel, written out."""
    e, c, k, inertia, omega, gravity = 0.015, 0.05, 0.12, 4e-4, math.tau, 9.81
    axle = {'kind': 'axle', 'support_radius': 0.02, 'axle_radius': 0.005}
    hung = tauto.load(
        'second_cam_at_sea', suspension=axle | {'depth': c, 'gyration_radius': k}
    ).suspension
    assert hung is not None
    square = frequency_in_light_case(hung, inertia, omega, gravity) ** 2
    per_mass = inertia / USUAL_MASS
    theta, phi = e * (gravity - e * square), gravity * c - (c * c + k * k) * square
    # ψ answers φ by ω²/(ω² − Ω²): its torque on the case is I ω² Ω²/(ω² − Ω²) φ
    back = per_mass * omega**2 * square / (omega**2 - square)
    assert theta * (phi - back) == pytest.approx((e * c * square) ** 2, rel=1e-6)


def test_the_mass_of_a_hung_case_is_refused_with_a_remedy() -> None:
    with pytest.raises(SceneError, match='is no longer a key') as caught:
        tauto.load('second_cam_at_sea', suspension=GIMBALS | {'mass': 10.0})
    assert caught.value.key == 'suspension.mass'
    assert 'tauto scene check' in str(caught.value)
