"""Materials, oils, compensation, and the numbers of a machine at a temperature."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tauto_core.machines import Machine, compile_machine, steady_swing
from tauto_core.machines.heat import OILS, thinning
from tauto_core.machines.steady_swing import SteadySwing
from tauto_core.scene import load_scene
from tauto_core.scene.errors import ABSENT, SceneError

INVOLUTE = {'kind': 'involute', 'base_radius': 0.005}
FORCE = {'kind': 'force', 'force': 3.158}


def scene_of(drag: Any = ABSENT, air: Any = ABSENT, **trochlea: Any) -> Any:
    parts = {'inertia': 4e-4, 'cam': INVOLUTE, 'thread': {'kind': 'vertical'}, 'power': FORCE}
    trochlea = parts | {'release_angle': 1.0} | trochlea
    return load_scene('ideal', duration=60.0, drag=drag, air=air, trochlea=trochlea)


def made(**trochlea: Any) -> Machine:
    machine = compile_machine(scene_of(**trochlea))
    assert isinstance(machine, Machine)
    return machine


def per_kelvin(machine: Machine) -> float:
    """dln ω/dT of small swings [1/K], by central differences of 0.01 K."""
    above, below = (machine.at_celsius(20.0 + each).frequency for each in (0.01, -0.01))
    return (math.log(above) - math.log(below)) / 0.02


WEIGHT = {'kind': 'weight', 'mass': 0.322}
SPRING = {'kind': 'spring', 'force': 3.158, 'stiffness': 50.0}


@pytest.mark.parametrize(
    ('trochlea', 'expected', 's_per_day'),
    [
        ({'material': 'brass', 'power': WEIGHT}, 0.5 * (18.9e-6 - 2 * 18.9e-6), -0.82),
        ({'material': 'brass', 'cam': {**INVOLUTE, 'material': {}}, 'power': WEIGHT},
         -18.9e-6, -1.63),
        ({'material': 'steel', 'power': {**SPRING, 'material': 'steel'}},
         0.5 * (-2.285e-4 - 11.5e-6), -10.4),
        ({'material': 'brass', 'power': {**FORCE, 'material': 'steel'}},
         0.5 * (-2.285e-4 - 18.9e-6), -10.7),
        ({'compensation': {'takes': -10.7, 'leaves': -0.5, 'middle': 20.0}}, 10.7 / 86400.0, 10.7),
    ],
)  # fmt: skip
def test_small_swings_change_by_the_closed_form(trochlea, expected, s_per_day):
    """½(β + α_c − 2α), and its value in s/day/K."""
    machine = made(**trochlea)
    assert per_kelvin(machine) == pytest.approx(expected, rel=1e-5)
    assert 86400.0 * expected == pytest.approx(s_per_day, rel=0.008)


def test_a_compensation_leaves_what_it_says_about_its_middle() -> None:
    taken = {'takes': -10.7, 'leaves': -0.01, 'middle': 12.0}
    machine = made(compensation=taken)
    cold = machine.frequency
    for celsius in (0.0, 12.0, 20.0, 31.0):
        rate = 86400.0 * (machine.at_celsius(celsius).frequency / cold - 1.0)
        left = -0.01 * ((celsius - 12.0) ** 2 - 8.0**2)
        assert rate == pytest.approx(10.7 * (celsius - 20.0) + left, abs=1e-9)


def test_a_hot_machine_has_the_period_of_one_with_grown_parts() -> None:
    """With the involute's radius, the ring and the spring grown by hand."""
    machine = made(
        material='zinc',
        cam={**INVOLUTE, 'material': 'brass'},
        power={**SPRING, 'material': 'steel'},
    )
    cam, ring, spring = 1.0 + 18.9e-6 * 15.0, 1.0 + 30.2e-6 * 15.0, 1.0 - 2.285e-4 * 15.0
    grown = made(
        inertia=4e-4 * ring**2,
        cam={'kind': 'involute', 'base_radius': 0.005 * cam},
        power={'kind': 'spring', 'force': 3.158 * spring, 'stiffness': 50.0 * spring},
    )
    for amplitude in (0.01, 0.7, 1.5):
        hot = machine.at_celsius(35.0).period(amplitude)
        assert hot == pytest.approx(grown.period(amplitude), rel=1e-13)


def test_oils_thin_as_in_their_tables() -> None:
    """Through the three points. Olive oil also at 20 °C, 84.0, and castor at 30 °C, 451 mPa s."""
    for name, table in OILS.items():
        law = thinning(name, table.celsius[1])
        found = np.exp(law.exponent(np.array(table.celsius) - table.celsius[1]))
        np.testing.assert_allclose(
            found, np.array(table.viscosity) / table.viscosity[1], rtol=1e-12
        )
    for name, celsius, viscosity in (('olive', 20.0, 84.0), ('castor', 30.0, 451.0)):
        law = thinning(name, OILS[name].celsius[1])
        ratio = math.exp(float(law.exponent(np.array(celsius - OILS[name].celsius[1]))))
        assert ratio * OILS[name].viscosity[1] == pytest.approx(viscosity, rel=0.02)


def test_thinner_oil_changes_the_rate_of_the_involute_clock() -> None:
    """3.5 % less drag under a fixed impulse: −15.6 s/day (DOP853)."""
    scene = load_scene('portsmouth_jamaica')
    machine = compile_machine(scene)
    assert isinstance(machine, Machine)
    assert machine.drag is not None
    oil = machine.drag.model_copy(update={'viscous': 0.965 * machine.drag.viscous})
    swings = steady_swing(machine), steady_swing(replace(machine, drag=oil))
    assert all(isinstance(each, SteadySwing) for each in swings)
    slow, fast = (each.period for each in swings)
    assert 86400.0 * (slow / fast - 1.0) == pytest.approx(-15.6, abs=0.1)
    stated = machine.heat.at_celsius
    heat = replace(machine.heat, oil=thinning('sperm', stated))
    hot = replace(machine, heat=heat).at_celsius(stated + 5.0)
    assert hot.drag is not None
    assert hot.drag.viscous / machine.drag.viscous == pytest.approx(
        math.exp(float(heat.oil.exponent(np.array(5.0)))), rel=1e-15
    )


def test_oil_that_thickens_does_so_by_its_part_a_month() -> None:
    machine = made(drag={'viscous': 1e-5, 'thickens_per_month': 0.1})
    year = machine.at_celsius(20.0, 365.25 * 86400.0)
    assert year.drag is not None
    assert year.drag.viscous == pytest.approx(1e-5 * 1.1**12, rel=1e-12)


def test_without_air_a_machine_of_materials_is_as_without_them() -> None:
    plain, named = made(), made(material='brass', power={**FORCE, 'material': 'steel'})
    assert not named.heat.acts
    assert named.frequency == plain.frequency
    assert named.heat.feels_temperature


@pytest.mark.parametrize(
    ('trochlea', 'key', 'words'),
    [
        ({'material': 'bras'}, 'trochlea.material', 'did you mean brass?'),
        ({'material': {'expansion': 1.0}}, 'trochlea.material.expansion', '0.001'),
        ({'cam': INVOLUTE | {'material': 'stel'}}, 'trochlea.cam.material', 'did you mean steel?'),
        ({'power': {**FORCE, 'material': 'brass'}}, 'trochlea.power.material', 'no modulus'),
        ({'at_celsius': 293.0}, 'trochlea.at_celsius', 'Write at_celsius: 19.85'),
        ({'compensation': {'takes': -10.0, 'middle': 290.0}}, 'trochlea.compensation.middle',
         'Write middle: 16.85'),
        ({'at_celsius': -60.0}, 'trochlea.at_celsius', '[-40, 60]'),
        ({'drag': {'viscous': 1e-5, 'oil': 'olives'}}, 'drag.oil', 'did you mean olive?'),
        ({'drag': {'viscous': 1e-5, 'thickens_per_month': -0.1}}, 'drag.thickens_per_month', '0'),
        ({'compensation': {}}, 'trochlea.compensation.takes', 'is missing'),
        ({'compensation': {'takes': -1.0}, 'power': WEIGHT,
          'thread': {'kind': 'hanging', 'length': 0.6}}, 'trochlea.compensation', 'hanging'),
        ({'material': 'brass', 'cam': INVOLUTE | {'material': 'steel'}, 'power': WEIGHT,
          'thread': {'kind': 'lever', 'arm': 0.1, 'weight_arm': 0.1, 'length': 0.3}},
         'trochlea.cam.material', 'lever grow alike'),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_by_key(trochlea: dict[str, Any], key: str, words: str) -> None:
    with pytest.raises(SceneError) as found:
        scene_of(**trochlea)
    assert key in str(found.value)
    assert words in str(found.value)
