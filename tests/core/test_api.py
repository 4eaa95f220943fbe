"""`import tauto_core as tauto`: the commands as functions, arrays with units, errors."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.text import Text
from typer.testing import CliRunner

import tauto_core as tauto
from tauto_core.bags import check_bag, read_bag
from tauto_core.bags.codec import decode_as
from tauto_core.bags.read import chunk_records
from tauto_core.cli.app import app
from tauto_core.ensembles.trials import _content, replaced_by_log
from tauto_core.results import LOGGED, MOTION, OBSERVED
from tauto_core.samples import Samples
from tauto_core.scene.errors import TautoWarning
from tauto_core.ship.logbook import LoggedPassage, scene_of_passage

BAGS = Path(__file__).parents[2] / 'bags'
ARRAYS = [*LOGGED, *OBSERVED, *MOTION]
FIGURES = {
    'error_s': 'clock',
    'rate_s_per_day': 'clock',
    'amplitude_rad': 'trochlea',
    'raw_error_nmi': 'longitude',
    'error_nmi': 'longitude',
    'sigma_nmi': 'longitude',
}


@pytest.fixture(scope='module')
def sailed() -> tauto.Voyage:
    return tauto.sail('second_cam_at_sea', duration=120.0, **{'ship.rate': 20.0})


def test_importing_it_imports_nothing_else() -> None:
    program = (
        'import sys; before = set(sys.modules); import tauto_core; '
        'new = {name.partition(".")[0] for name in set(sys.modules) - before}; '
        'print(sorted(new - set(sys.stdlib_module_names)))'
    )
    found = subprocess.run(
        [sys.executable, '-c', program], capture_output=True, text=True, check=True
    )
    assert found.stdout.strip() == "['tauto_core']"


def test_every_public_name_is_there_and_explained() -> None:
    assert tauto.__doc__
    for name in tauto.__all__:
        value = getattr(tauto, name)
        assert isinstance(value, str) or value.__doc__, name
    assert set(dir(tauto)) == set(tauto.__all__)
    with pytest.raises(AttributeError, match='sale'):
        tauto.sale  # noqa: B018


def test_a_fleet_is_that_of_the_command(tmp_path: Path) -> None:
    key = 'trochlea.release_angle'
    file = tmp_path / 'vary.yaml'
    file.write_text(f'{key}: {{kind: uniform, low: 0.9, high: 1.1}}')
    vary = {key: {'kind': 'uniform', 'low': 0.9, 'high': 1.1}}
    found = tauto.fleet('second_cam_at_sea', ships=3, vary=vary, jobs=1, duration=60.0)
    words = ['fleet', 'second_cam_at_sea', '--ships', '3', '--vary', str(file)]
    printed = CliRunner().invoke(app, [*words, '--jobs', '1', '--duration', '60', '--json'])
    of_scene = {'scene': 'second_cam_at_sea'}
    assert json.loads(printed.stdout) == of_scene | json.loads(json.dumps(asdict(found.answers)))
    assert all(0.9 <= row[key] <= 1.1 for row in found.rows)


def test_a_voyage_has_the_figures_and_the_arrays_of_the_command(sailed: tauto.Voyage) -> None:
    words = ['sail', 'second_cam_at_sea', '--duration', '120', '--set', 'ship.rate=20.0', '--json']
    printed = json.loads(CliRunner().invoke(app, words).stdout)
    assert {**printed, 'wall_s': 0.0} == {**sailed.result, 'wall_s': 0.0}
    assert sailed.answer in repr(sailed)
    assert sailed.time_s[[0, -1]].tolist() == [0.0, 120.0]
    assert sailed.clock_error_s[-1] == printed['clock']['error_s']
    assert sailed.estimated_error_s[-1] == printed['drift']['offset_s']
    with pytest.warns(TautoWarning, match='offset_s is now estimated_error_s'):
        assert np.array_equal(sailed.offset_s, sailed.estimated_error_s)  # its name in 0.2
    assert sailed.raw_longitude_error_nmi[-1] == printed['longitude']['raw_error_nmi']
    assert sailed.angle_rad[0] == 1.0
    assert np.abs(sailed.motion_roll_rad).max() < 0.3
    assert sailed.motion_gravity_m_s2.mean() == pytest.approx(9.80665, abs=0.2)
    for name, section in FIGURES.items():
        assert getattr(sailed, name) == printed[section][name]
    for name in ARRAYS:
        array = getattr(sailed, name)
        assert array.ndim == 1, name
        with pytest.raises(ValueError, match='read-only'):
            array[:] = 5.0
        if not name.startswith(('motion_', 'obs', 'temp')):
            assert len(array) == len(sailed.time_s), name


def test_a_bag_replays_to_the_same_voyage(sailed: tauto.Voyage, tmp_path: Path) -> None:
    sailed.write(tmp_path / 'bag')
    again = tauto.replay(tmp_path / 'bag')
    assert again.result['damage'] == []
    assert len(ARRAYS) > 15
    for name in ARRAYS:
        # times of the observations count from the first reading, which the bag holds too
        assert getattr(again, name).tobytes() == getattr(sailed, name).tobytes(), name
    assert again.result['longitude'] == sailed.result['longitude']
    assert again.scene == sailed.scene
    with pytest.raises(tauto.TautoError, match='force=True to replace'):
        sailed.write(tmp_path / 'bag')
    sailed.write(tmp_path / 'bag', force=True)


@pytest.mark.parametrize(
    'use',
    [
        tauto.replay,
        lambda bag: tauto.plot(bag, 'error'),
        lambda bag: CliRunner().invoke(app, ['replay', str(bag)], catch_exceptions=False),
    ],
    ids=['replay', 'plot', 'command'],
)
def test_a_bag_is_decompressed_and_its_scene_decoded_once(
    sailed: tauto.Voyage,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    use: Callable[[Path], object],
) -> None:
    sailed.write(tmp_path / 'bag')
    [file] = read_bag(tmp_path / 'bag').files
    read: list[bytes] = []
    decoded: list[str] = []

    def records(chunk: bytes) -> bytes:
        read.append(chunk)
        return chunk_records(chunk)

    def decode(ros_type: str, *args: Any) -> Samples:
        decoded.append(ros_type)
        return decode_as(ros_type, *args)

    monkeypatch.setattr('tauto_core.bags.read.chunk_records', records)
    monkeypatch.setattr('tauto_core.bags.read.decode_as', decode)
    use(tmp_path / 'bag')
    assert len(set(read)) == len(file.spans) > 2
    assert len(read) == len(set(read))
    assert decoded.count('std_msgs/msg/String') == 1


@pytest.fixture(scope='module')
def torn(sailed: tauto.Voyage, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bag as a killed recorder leaves it: most of the file, no metadata."""
    folder = tmp_path_factory.mktemp('torn') / 'bag'
    sailed.write(folder)
    file = folder / 'bag_0.mcap'
    file.write_bytes(file.read_bytes()[: 7 * file.stat().st_size // 10])
    (folder / 'metadata.yaml').unlink()
    return folder


def test_the_answer_of_a_torn_bag_says_so(torn: Path) -> None:
    found = tauto.replay(torn)
    unended, chunk, cut = found.result['damage']
    assert 'it has no metadata.yaml' in unended
    assert 'is damaged' in chunk
    assert 'cut at byte' in cut
    assert found.result['warnings'][:3] == found.result['damage']
    assert found.answer.startswith('The bag is not whole. After ')
    printed = CliRunner().invoke(app, ['--quiet', 'replay', str(torn)]).stdout
    assert 'The bag is not whole.' in printed


@pytest.mark.filterwarnings('ignore::tauto_core.scene.errors.TautoWarning')
def test_the_pictures_of_a_torn_bag_say_so(torn: Path) -> None:
    for figure in [tauto.plot(torn, what) for what in ('error', 'machine', 'stability')]:
        texts = [each.get_text() for each in figure.findobj(Text)]
        [notice] = [' '.join(text.split()) for text in texts if 'not whole' in text]
        assert re.search(r'The bag is not whole: .* chunk at byte \d+ is damaged', notice)


@pytest.mark.filterwarnings('ignore::tauto_core.scene.errors.TautoWarning')
def test_the_page_of_a_torn_bag_says_so(torn: Path, sailed: tauto.Voyage, tmp_path: Path) -> None:
    banner = re.compile('<p class="damage" role="alert">The bag is not whole: .*is damaged')
    pages = [tmp_path / 'torn.html', tmp_path / 'sailed.html']
    for source, page in zip((torn, sailed), pages, strict=True):
        tauto.report(source, page)
    whole = pages[1].read_text()
    assert [bool(banner.search(page.read_text())) for page in pages] == [True, False]
    assert 'role="alert"' not in whole
    assert 'tauto.report(' in whole
    assert sailed.answer.split()[0] in whole


def test_a_torn_bag_written_again_does_not_become_whole(torn: Path, tmp_path: Path) -> None:
    tauto.replay(torn).write(tmp_path / 'bag')
    assert check_bag(tmp_path / 'bag').cut_short
    again = tauto.replay(tmp_path / 'bag')
    assert again.answer.startswith('The bag is not whole. ')
    assert 'its recording ended before the voyage did' in again.result['damage'][0]


def test_a_scene_can_be_loaded_changed_and_sailed() -> None:
    scene = tauto.load('ideal', duration=600.0)
    assert tauto.load(scene) is scene
    assert tauto.sail(scene).time_s[-1] == 600.0
    assert 'ideal' in tauto.scenes()


def test_numbers_of_numpy_are_numbers() -> None:
    given = {'seed': np.int64(3), 'duration': np.float32(60.0), 'log.motion': np.bool_(True)}
    roll = {'amplitude': np.float32(0.5), 'period': np.int16(9)}
    ship = {'kind': 'components', 'components': [roll]}
    scene = tauto.load('ideal', ship=ship, **given)
    ship['components'] = [{'amplitude': 0.5, 'period': 9}]
    assert scene == tauto.load('ideal', ship=ship, seed=3, duration=60.0, log__motion=True)


def test_a_key_in_a_section_is_named_by_its_path() -> None:
    by_name = tauto.load('measured', trochlea__cam__base_radius=0.006)
    assert by_name == tauto.load('measured', **{'trochlea.cam.base_radius': 0.006})
    again = tauto.load(by_name, trochlea__release_angle=0.5)
    assert (again.trochlea.cam.base_radius, again.trochlea.release_angle) == (0.006, 0.5)


def test_one_clock_with_two_values_is_compared() -> None:
    """Each row is the voyage of its scene with the common arguments."""
    clock = tauto.load('clock_cheek_weight')
    narrow = tauto.load(clock, name='narrow', trochlea__release_angle=0.5)
    given = {'duration': 600.0, 'escapement__energy': 1.3e-4}
    found = tauto.compare([clock, narrow], jobs=1, suspension='without', **given)
    assert [row.clock for row in found.rows] == ['clock_cheek_weight', 'narrow']
    for row, scene in zip(found.rows, (clock, narrow), strict=True):
        alone = tauto.load(scene, **given).model_copy(update={'suspension': None})
        assert row.rate_s_per_day == tauto.sail(alone).result['clock']['rate_s_per_day']


@pytest.mark.parametrize(
    ('call', 'words'),
    [
        (lambda: tauto.load('ideal', duration=0.0), r'\(duration is given, in place'),
        (lambda: tauto.load({'name': 'mine'}), 'a built-in name .*, and is of type dict'),
        (lambda: tauto.compare(['ideal'], 'measured'), 'scene: must be .*, and is of type list'),
        (lambda: tauto.sail('ideal', trochlea_inertia=1.0), 'key of a scene. Write trochlea__in'),
        (lambda: tauto.replay('no_bag', smooth=True), 'smooth=True: no drift in hindsight'),
        (lambda: tauto.isochronism('measured', [30, 60]), '30: 4.8 turns.* Write 30deg'),
        (lambda: tauto.sail('nowhere'), 'no such file or built-in scene'),
        (lambda: tauto.load('ideal', trochlea__inerta=1.0), 'Did you mean `inertia`'),
        (
            lambda: tauto.load('ideal', ship__rate=1.0, **{'ship.rate': 2.0}),
            r'ship\.rate is given twice',
        ),
        (lambda: tauto.replay('no_bag'), 'no_bag does not exist'),
        (lambda: tauto.cam('measured', reach_rad=-1.0), r'reach_rad = -1\.0 rad: must be > 0'),
        (lambda: tauto.cam('measured', bore_mm=1.0), 'bore_mm = 1 mm: .* Ask for one, plate=True'),
        (
            lambda: tauto.cam('ideal', svg='x.svg', thread_mm=0.5, reach_rad=8.0),
            r'\(reach_rad=7\.99',
        ),
        (lambda: tauto.design(period=1.0), r'in period=1 pull=3 base_radius=0\.005'),
        (lambda: tauto.design(period=-1.0), r'period = -1\.0: must be > 0'),
        (lambda: tauto.design(inertia=1, disc_weight=1), 'inertia= and disc_weight= say the same'),
        (lambda: tauto.design(disc_is_base=True, period=1), 'with disc_is_base=True three of'),
        (
            lambda: tauto.design(period=2, inertia=1, pull='5 stone'),
            'fit: N, mN, g, kg, lb, oz, p',
        ),
        (lambda: tauto.new_scene(cam='round'), 'cam=round: unknown kind'),
        (lambda: tauto.new_scene('x.txt'), r'file=x\.txt: must end in \.yaml or \.yml'),
        (lambda: tauto.compare('ideal', roll_deg=[-10.0]), 'roll_deg=-10: must be between'),
        (lambda: tauto.plot('ideal', 'sound'), "'sound': is not a picture"),
        (lambda: tauto.plot('ideal', 'error', 'x.jpg'), 'file=x.jpg: must end in .svg'),
        (lambda: tauto.report('ideal', 'x.pdf'), 'file=x.pdf: must end in .html'),
        (lambda: tauto.isochronism('measured', []), 'amplitudes: none given'),
        (lambda: tauto.isochronism('measured', '1,a'), "amplitudes = 'a': must be a number .rad"),
        (lambda: tauto.isochronism('measured', [True]), 'amplitudes = True: is not a number'),
        (lambda: tauto.altitudes(altitudes_deg=3, times=(), latitude_deg=0), 'must be a list'),
        (lambda: tauto.replay(3), 'bag = 3: must be a path'),
        (lambda: tauto.fleet('ideal', ships=0), r'^ships=0: must be between'),
        (lambda: tauto.trial('ideal', 'no.csv'), r'logs=no\.csv: '),
        (lambda: tauto.trial('ideal', __file__, days=(9, 1)), r'days=\(9, 1\): must be a range'),
        (lambda: tauto.trial('ideal', __file__, days='5mm..'), "days = '5mm': must be a time"),
        (lambda: tauto.trial('ideal', __file__, years='nan..3'), r'years=nan\.\.3: must be a r'),
        (lambda: tauto.sail('ideal', force=True), 'the bag in out=. Give out=, too'),
        (
            lambda: tauto.sail('ideal', accuracy=0.0),
            r'solver\.accuracy = 0\.0: must be at least 1e-09',
        ),
        (lambda: tauto.load('ideal', accuracy=1, solver__accuracy=1), 'is given twice'),
        (lambda: tauto.replay('no_bag', plot='x.svg'), r'plot=x\.svg: the stability is drawn by'),
        (lambda: tauto.replay('no_bag', smoth=True), 'smoth=True: is no argument of replay'),
        (lambda: tauto.trial('ideal', __file__, compare='ideal'), "compare = 'ideal': must be"),
        (lambda: tauto.fleet('ideal', ships=2.5), r'ships = 2\.5: must be a whole number'),
        (lambda: tauto.fleet('ideal', vary=3), 'vary = 3: must be a mapping of keys, or a file'),
        (lambda: tauto.isochronism('measured', [-1.0]), r'amplitude -1\.0 rad: must be > 0'),
        (lambda: tauto.isochronism('ideal', [1], **{'trochlea.inertia': 0}), 'inertia is given'),
        (lambda: tauto.cam('measured', **{'trochlea.cam.kind': 'round'}), 'trochlea.cam.kind'),
    ],
)
def test_wrong_arguments_get_errors_in_words_of_calls(call, words: str) -> None:
    with pytest.raises(tauto.TautoError, match=words) as caught:
        call()
    assert '--' not in str(caught.value)


# Another section of a scene changes the answer of a command, or the answer names it. A fleet and
# reports sail as `sail` does, and an involute is the same in any gravity. A trial sails the scene
# of each passage.
_VARIED: dict[str, dict[str, Any]] = {
    'gravity': {'gravity': 9.7},
    'trochlea': {'trochlea__cam__base_radius': 5.1e-3},
    'drag': {'escapement': {'energy': 3e-5, 'angle': 0.1}, 'drag': {'viscous': 1e-6}},
    'escapement': {'escapement': {'energy': 4e-5, 'angle': 0.1}, 'drag': {'viscous': 1e-6}},
    'ship': {'ship__sea__peak_period': 8.0},
    'suspension': {'suspension': tauto.load('suspended_weight_at_sea').suspension.model_dump()},
    'air': {'air': {'celsius': 30.0}},
    'clock': {'clock__nominal_period': 1.0},
    'voyage': {'voyage': tauto.load('measured').voyage},
}
PASSAGE = LoggedPassage('a', 'log.csv', entries=(('1761-11-18', 50.0, -1.0, 90.0, 5.0, 8.0),))


_COMMANDS: dict[str, Callable[[tauto.Scene], Mapping[str, Any]]] = {
    'sail': lambda scene: tauto.sail(scene, keep=False).result,
    'check': tauto.check,
    'isochronism': lambda scene: vars(tauto.isochronism(scene, [0.5])),
    'cam': lambda scene: tauto.cam(scene, points=11).facts(),
    'budget': lambda scene: tauto.budget(scene, jobs=1).facts(),
    'compare': lambda scene: asdict(tauto.compare(scene, jobs=1)),
    'trial': lambda scene: {
        'sailed': scene_of_passage(_content(scene, ''), PASSAGE),
        'keys_left_out': replaced_by_log(scene),
    },
}


@pytest.mark.parametrize('command', _COMMANDS)
def test_no_command_ignores_a_section_that_changes_its_answer(command: str) -> None:
    def answer(**keys: Any) -> dict[str, Any]:
        common = {'duration': 20.0, 'trochlea__material': 'brass'}
        found = _COMMANDS[command](tauto.load('involute_weight_at_sea', **common, **keys))
        return json.loads(json.dumps({**found, 'wall_s': 0.0}, default=repr))

    plain = answer() | {'keys_left_out': None}
    for section, keys in _VARIED.items():
        changed = answer(**keys)
        named = {key.partition('.')[0] for key in changed.get('keys_left_out', ())}
        is_felt = changed | {'keys_left_out': None} != plain
        assert is_felt or section in named or (section, command) == ('gravity', 'cam'), section
