"""The regulator in a fluid: compatible and incompatible sections."""

from typing import Any

import pytest
import yaml

from tauto_core.machines import compile_machine
from tauto_core.scene import SceneError, load_scene, parse_scene, scene_yaml

OIL: dict[str, Any] = yaml.safe_load(scene_yaml(load_scene('globe_in_oil')))
TROCHLEA = yaml.safe_load(scene_yaml(load_scene('ideal')))['trochlea']


def refusal(**changes: Any) -> SceneError:
    with pytest.raises(SceneError) as refused:
        load_scene('globe_in_oil', **changes)
    return refused.value


@pytest.mark.parametrize(
    ('key', 'section'),
    [
        ('trochlea', TROCHLEA),
        ('drag', {'viscous': 1e-6}),
        ('escapement', {'kind': 'impulse', 'energy': 1e-6}),
    ],
)
def test_what_does_not_go_with_a_fluid_is_refused(key: str, section: dict[str, Any]) -> None:
    error = refusal(**{key: section})
    assert error.key == key
    assert 'does not go with regulator' in str(error)
    assert f'Leave out {key}' in error.remedy


def test_a_ship_that_moves_is_refused() -> None:
    ship = {'kind': 'components', 'components': [{'amplitude': 0.1, 'period': 9.0}]}
    error = refusal(ship=ship)
    assert (error.key, error.value) == ('ship.kind', 'components')
    assert error.remedy == 'Use ship kind still.'


CIRCLE = {'kind': 'circle', 'radius': 1.0}


@pytest.mark.parametrize(
    ('regulator', 'key', 'said'),
    [
        ({'release_arc': 0.0}, 'release_arc', 'at rest for ever'),
        ({'curve': 'circle'}, 'curve', 'cycloid'),
        ({'body': 'cube'}, 'body', 'globe'),
        ({'kind': 'pendulum'}, 'kind', 'fluid_tautochrone'),
        ({'curve': 'companion'}, 'of', 'is missing'),
        ({'of': CIRCLE}, 'of', 'does not go with regulator.curve euler'),
        ({'given': 'ascent'}, 'given', 'which has no given branch'),
        ({'curve': 'cycloid', 'ascent_length': 1.0}, 'ascent_length', "are Euler's"),
        ({'curve': 'companion', 'of': CIRCLE, 'friction': 0.1}, 'friction', 'without friction'),
        ({'curve': 'companion', 'of': {'kind': 'circle'}}, 'of.radius', 'is missing'),
        ({'curve': 'companion', 'of': CIRCLE, 'release_arc': 1.2}, 'release_arc', 'beyond the'),
        ({'curve': 'cycloid', 'friction': 0.5}, 'friction', 'holds the body at its release'),
        ({'friction': 0.15}, 'friction', 'holds the body after its first half swing'),
        ({'ascent_length': 0.1}, 'release_arc', 'beyond the end of the other branch'),
    ],
)
def test_what_makes_no_regulator_is_refused(
    regulator: dict[str, Any], key: str, said: str
) -> None:
    with pytest.raises(SceneError) as refused:
        compile_machine(
            parse_scene(yaml.safe_dump(OIL | {'regulator': OIL['regulator'] | regulator}), 'oil')
        )
    assert refused.value.key == f'regulator.{key}'
    assert said in str(refused.value)


def test_one_of_the_two_is_needed() -> None:
    content = {key: value for key, value in OIL.items() if key != 'regulator'}
    with pytest.raises(SceneError) as refused:
        parse_scene(yaml.safe_dump(content), 'oil')
    assert refused.value.key == 'trochlea'
    assert 'is missing' in str(refused.value)
    assert '`regulator: …`' in refused.value.remedy
