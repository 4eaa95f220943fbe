"""`new_scene`: every combination of kinds makes a scene that runs, with every key explained."""

import re
from itertools import product

import pytest

import tauto_core as tauto
from tauto_core.checks.readiness import check_scene, implausible, plausibility_warnings
from tauto_core.machines import compile_trochlea
from tauto_core.scene import SceneError, parse_scene
from tauto_core.scene.errors import UsageError
from tauto_core.scene.reference import FOLDERS, all_kinds, compatible_kinds, new_scene
from tauto_core.scene.sections import kind_of, kinds_in
from tauto_core.ship.airs import AirKind
from tauto_core.ship.motions import FOLDER as SHIPS
from tauto_core.ship.suspensions import SuspensionKind
from tauto_core.ship.weathers import WeatherKind

SHIP_KINDS = [kind_of(model) for model in kinds_in(SHIPS)]
# A few of many: a cam and a thread of each sort, with and without an escapement.
SAILED = [
    {},
    {'ship': 'recorded', 'escapement': 'remontoire'},
    {'cam': 'spring_corrected', 'thread': 'hole'},
]


def uncommented(text: str, key: str) -> str:
    """Return a text with a key and the keys below it uncommented."""
    lines = text.split('\n')
    start = next(k for k, line in enumerate(lines) if line.strip().startswith(f'#{key}:'))
    edge = lines[start].index('#')
    for k in range(start, len(lines)):
        if k > start and not lines[k].startswith(' ' * edge + '#  '):
            break
        lines[k] = lines[k][:edge] + lines[k][edge + 1 :]
    return '\n'.join(lines)


def test_every_combination_that_goes_together_can_sail() -> None:
    """Each cam, thread and power with the last escapement compatible with them."""
    rows = {tuple(kinds.values())[:3]: kinds for kinds in compatible_kinds()}
    assert len(rows) > 40
    for kinds in rows.values():
        asked = {key: kind for key, kind in kinds.items() if kind}
        scene = parse_scene(new_scene('new', {'ship': 'components', **asked}), 'new')
        check_scene(scene)
        assert not implausible(scene), kinds
        # the wheel swings about once a second, as the module says, and the dial is left to it
        assert 0.9 < compile_trochlea(scene).period(1.0) < 1.1, kinds
        assert scene.clock.nominal_period is None


def test_every_kind_is_in_some_combination() -> None:
    for key, folder in FOLDERS.items():
        found = {kinds[key] for kinds in compatible_kinds()} - {''}
        assert found == {kind_of(model) for model in kinds_in(folder)}


def test_what_no_combination_has_is_refused_by_the_scene() -> None:
    """The kinds are combined by hand. The models refuse those that `scene new` never chooses."""
    text = new_scene('new', {'ship': 'still', 'cam': 'involute', 'escapement': 'impulse'})
    good = {tuple(kinds.values()) for kinds in compatible_kinds()}
    assert ('involute', 'vertical', 'weight', 'impulse') in good
    with pytest.raises(SceneError, match=r'trochlea\.thread\.kind'):
        parse_scene(text.replace('kind: vertical ', 'kind: hole\n    distance: 0.08 '), 'new')


@pytest.mark.parametrize('kinds', SAILED, ids=str)
def test_it_sails_and_is_regulated_on_land(kinds: dict[str, str]) -> None:
    scene = parse_scene(new_scene('new', kinds), 'new')
    assert scene.clock.nominal_period is None
    voyage = tauto.sail(scene, duration=60.0)
    # the sea changes the reading by less than a swing in a minute
    assert abs(voyage.clock_error_s[-1]) < 1.0


@pytest.mark.parametrize('ship', SHIP_KINDS)
def test_every_ship_can_be_asked_for(ship: str) -> None:
    scene = parse_scene(new_scene('new', {'ship': ship}), 'new')
    assert scene.ship.kind == ship
    check_scene(scene)
    assert not plausibility_warnings(scene)


def test_every_key_of_every_kind_is_there_with_its_meaning() -> None:
    texts = {
        kind_of(model): new_scene('new', {key: kind_of(model)})
        for key, folder in {'ship': SHIPS, **FOLDERS}.items()
        for model in kinds_in(folder)
    }
    for model in all_kinds():
        if issubclass(model, WeatherKind | SuspensionKind | AirKind) and model.rank > 1:
            continue  # of the kinds of weather, suspension and air a new scene shows the first
        text = re.sub(r'\n *#* *# ', ' ', texts.get(kind_of(model), texts['sea']))
        for name, field in model.model_fields.items():
            if name == 'gamma':
                continue  # goes with jonswap alone
            assert re.search(rf'\b{name}:', text), (model, name)
            sections = ('mapping', 'list')
            if name != 'kind' and not (field.description or '').startswith(sections):
                assert field.description in text, (model, name)


@pytest.mark.parametrize('key', ['suspension', 'voyage', 'escapement'])
def test_a_section_in_comments_is_right_when_it_is_used(key: str) -> None:
    text = new_scene('new', {})
    assert getattr(parse_scene(text, 'new'), key) is None
    scene = parse_scene(uncommented(text, key), 'new')
    assert getattr(scene, key) is not None
    check_scene(scene)


@pytest.mark.parametrize('key', ['heading', 'motion'])
def test_a_key_in_comments_is_right_when_it_is_used(key: str) -> None:
    text = uncommented(new_scene('new', {}), key)
    assert parse_scene(text, 'new') != parse_scene(new_scene('new', {}), 'new')


def test_no_line_is_wider_than_a_page() -> None:
    for kinds, ship in product(({}, {'escapement': 'remontoire'}), SHIP_KINDS):
        text = new_scene('new', {**kinds, 'ship': ship}).partition('\n')[2]
        assert max(map(len, text.split('\n'))) < 100


def test_incompatible_kinds_are_refused_with_compatible_ones() -> None:
    said = {
        ('cam', 'involute', 'thread', 'hole'): 'thread=vertical or lever or hanging',
        ('cam', 'weight_corrected', 'power', 'spring'): 'power=weight',
        ('thread', 'lever', 'power', 'force'): 'power=weight',
        ('thread', 'hanging', 'power', 'spring'): 'power=weight or weight_and_spring',
    }
    for (one, kind, other, of), remedy in said.items():
        with pytest.raises(UsageError) as caught:
            new_scene('new', {one: kind, other: of})
        assert str(caught.value).startswith(f'{one}={kind} and {other}={of}: do not go')
        assert remedy in str(caught.value)
    # only the incompatible kinds are named
    with pytest.raises(UsageError, match=r'^thread=hanging and power=force: do not'):
        new_scene('new', {'cam': 'involute', 'thread': 'hanging', 'power': 'force'})


def test_a_kind_that_is_not_known_is_refused_with_the_nearest() -> None:
    with pytest.raises(UsageError, match=r'cam=involut: .*Did you mean involute\?'):
        new_scene('new', {'cam': 'involut'})
    with pytest.raises(UsageError, match=r'ship=raft: .*Use one of still, components'):
        new_scene('new', {'ship': 'raft'})


@pytest.mark.parametrize('name', ['true', 'of: "two"', 'Sully’s'])
def test_any_name_is_kept(name: str) -> None:
    assert parse_scene(new_scene(name, {}), 'new').name == name


def test_every_kind_has_values_for_what_it_must_be_given() -> None:
    for model in all_kinds():
        needed = {name for name, field in model.model_fields.items() if field.is_required()}
        assert needed <= set(model.starter), model
