"""Round trips, paths, shipped scenes. Any text gives a scene or its refusal."""

import copy
import hashlib
import math
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core.checks.readiness import check_scene
from tauto_core.scene import Scene, SceneError, load_scene, parse_scene, scene_yaml, shipped_scenes
from tauto_core.scene.errors import UsageError
from tauto_core.scene.tables import data_path

REFERENCES = sorted((Path(__file__).parents[1] / 'scenes_ref').glob('*.yaml'))


@pytest.mark.parametrize('name', shipped_scenes())
def test_shipped_scenes_load_and_round_trip(name: str) -> None:
    scene = load_scene(name)
    assert scene.name == name
    check_scene(scene)
    text = scene_yaml(scene)
    assert parse_scene(text, 'bag') == scene
    assert scene_yaml(parse_scene(text, 'bag')) == text
    assert str(Path(__file__).parents[3]) not in text
    assert yaml.safe_load(text)['duration'] == scene.duration


@pytest.mark.parametrize('path', REFERENCES, ids=lambda path: path.stem)
def test_reference_scenes_load_and_round_trip(path: Path) -> None:
    scene = load_scene(path)
    assert parse_scene(scene_yaml(scene), 'bag') == scene


def test_the_reference_scenes_are_there() -> None:
    assert len(REFERENCES) == 6


def test_shipped_data_are_those_of_the_source() -> None:
    """The README has the checksum of the derived file."""
    scene = load_scene('measured')
    assert scene.ship.kind == 'recorded'
    file = data_path(scene.ship.recorded.path)
    digest = hashlib.sha256(file.read_bytes()).hexdigest()
    assert digest in (file.parent / 'README').read_text()
    assert digest.startswith('3802f3c7')


def test_regulators_beat_seconds_or_half_seconds() -> None:
    """T0 = 2π √(I/(P r)) within 30 % of the design. A low centre of mass adds to P r."""
    for name in shipped_scenes():
        scene = load_scene(name)
        if scene.trochlea is None:
            continue
        cam, power = scene.trochlea.cam, scene.trochlea.power
        design = 2.0 if name in ('sully_1724', 'coach_1724', 'euler_1727') else 1.0
        if hasattr(cam, 'period'):
            assert cam.period == design
            continue
        rate = {'involute': 'base_radius', 'hole': 'lever_rate', 'circular_arc': 'root_depth'}
        lever = getattr(cam, rate[cam.kind])
        pull = power.mass * scene.g if power.kind == 'weight' else power.force
        hangs = scene.trochlea.imbalance
        stiff = pull * lever + (0.0 if hangs is None else hangs.moment * scene.g)
        period = 2.0 * math.pi * math.sqrt(scene.trochlea.inertia / stiff)
        assert period == pytest.approx(design, rel=0.3), name


def test_euler_s_own_design_has_the_numbers_of_his_paragraph_xx() -> None:
    """BC = 2 P AO/Q of AO = 3166 scruples of 0.31385 mm. The scene rounds to five digits."""
    scene = load_scene('euler_1727')
    radius, mass = scene.trochlea.cam.base_radius, scene.trochlea.power.mass
    assert radius == pytest.approx(2.0 * 3166 / 100 * 0.31385e-3, rel=2e-5)
    assert scene.trochlea.inertia == pytest.approx(0.5 * 100.0 * mass * radius**2, rel=2e-5)


def test_weight_scenes_are_regulated_at_their_swing() -> None:
    """T/T0 = 1 + ε/4 − 3ε²/64 + 5ε³/256 (A in wheel.md, weight's inertia); next term 2e-9."""
    for name in ('measured', 'involute_weight_at_sea'):
        scene = load_scene(name)
        cam, power = scene.trochlea.cam, scene.trochlea.power
        assert cam.kind == 'involute'
        assert power.kind == 'weight'
        inertia, mass, radius = scene.trochlea.inertia, power.mass, cam.base_radius
        eps = mass * radius**2 * scene.trochlea.release_angle**2 / inertia
        small = 2.0 * math.pi * math.sqrt(inertia / (mass * scene.g * radius))
        period = small * (1.0 + eps / 4.0 - 3.0 * eps**2 / 64.0 + 5.0 * eps**3 / 256.0)
        assert scene.clock.nominal_period == pytest.approx(period, rel=3e-9)


def test_overrides_replace_what_the_file_says() -> None:
    assert load_scene('measured', duration=60).duration_ns == 60_000_000_000
    assert load_scene('measured', duration=None) == load_scene('measured')
    assert load_scene('measured', seed=3).seed == 3


def test_relative_paths_start_at_the_scene(tmp_path, monkeypatch):
    content = yaml.safe_load(scene_yaml(load_scene('measured')))
    content['ship']['recorded']['path'] = 'data/roll.csv'
    content['trochlea']['cam'] = {'kind': 'table', 'path': '../cam.csv'}
    del content['name']
    folder = tmp_path / 'scenes'
    (folder / 'data').mkdir(parents=True)
    (folder / 'data' / 'roll.csv').touch()
    (tmp_path / 'cam.csv').touch()
    (folder / 'mine.yaml').write_text(yaml.safe_dump(content))
    monkeypatch.chdir(tmp_path)
    scene = load_scene('scenes/mine.yaml')
    assert scene.name == 'mine'
    assert scene.ship.kind == 'recorded'
    assert data_path(scene.ship.recorded.path) == folder / 'data' / 'roll.csv'
    assert scene.trochlea.cam.kind == 'table'
    assert data_path(scene.trochlea.cam.path) == tmp_path / 'cam.csv'
    text = scene_yaml(scene)
    (tmp_path / 'cam.csv').unlink()
    assert parse_scene(text, 'a bag, replayed elsewhere') == scene


def test_shipped_paths_stay_within_the_shipped_data() -> None:
    for path in ('shipped:../loader.py', 'shipped:/etc/hostname'):
        with pytest.raises(UsageError, match='stay within'):
            data_path(path)


IDEAL = load_scene('ideal')
PRINTABLE = st.characters(exclude_categories=('Cc', 'Cs', 'Zl', 'Zp'))


@settings(max_examples=30, deadline=None)
@given(st.text(PRINTABLE, min_size=1, max_size=120))
def test_any_name_survives_the_round_trip(name: str) -> None:
    scene = IDEAL.model_copy(update={'name': name})
    assert parse_scene(scene_yaml(scene), 'bag') == scene


CONTENT: dict[str, Any] = yaml.safe_load(scene_yaml(load_scene('measured')))
SECTIONS = [yaml.safe_load(scene_yaml(load_scene(name))) for name in shipped_scenes()]
LEAVES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(10**300, 10**320),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(['still', 'sea', 'hole', 'weight', 'table', 'shipped:x', '1e-3']),
)
VALUES = st.recursive(
    LEAVES,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=6,
)


def paths(content: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the paths to everything in nested mappings and lists, the whole left out."""
    inner: list[tuple[Any, Any]] = []
    if isinstance(content, dict):
        inner = list(content.items())
    elif isinstance(content, list):
        inner = list(enumerate(content))
    return [found for key, value in inner for found in [(*path, key), *paths(value, (*path, key))]]


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_a_spoilt_scene_is_a_scene_or_refused(data: st.DataObject) -> None:
    content = copy.deepcopy(data.draw(st.sampled_from(SECTIONS)))
    for _ in range(data.draw(st.integers(1, 3))):
        path = data.draw(st.sampled_from(paths(content)))
        owner = content
        for key in path[:-1]:
            owner = owner[key]
        if isinstance(owner, dict) and data.draw(st.booleans()):
            owner[data.draw(st.sampled_from(['kind', 'path', 'rate', 'x.y[0]', 'gamma']))] = (
                data.draw(VALUES)
            )
        else:
            owner[path[-1]] = data.draw(VALUES)
    accepted_or_refused(yaml.safe_dump(content, allow_unicode=True))


@settings(max_examples=40, deadline=None)
@given(st.text(alphabet='abk: -[]{}!&*?|>"\'#%@\n\t019.e+~\x00ü', max_size=40))
def test_any_text_is_a_scene_or_refused(text: str) -> None:
    accepted_or_refused(text)
    accepted_or_refused(scene_yaml(IDEAL) + text)


def accepted_or_refused(text: str) -> None:
    try:
        scene = parse_scene(text, 'fuzz')
    except SceneError:
        return
    assert isinstance(scene, Scene)
    assert parse_scene(scene_yaml(scene), 'again') == scene
    assert scene.samples >= 1
    assert scene.log_count >= 2
