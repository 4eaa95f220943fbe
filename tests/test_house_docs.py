"""Statements of the README and the pages, checked."""

from __future__ import annotations

import json
import math
import re
import shlex
import sys
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml
from matplotlib.image import imread
from modules import module_of, run_program

import tauto_core as tauto
from tauto_core.ensembles.comparison import CLOCKS
from tauto_core.machines import SteadySwing, compile_machine, steady_swing
from tauto_core.plots.chart import COLOURS
from tauto_core.results import groups
from tauto_core.wording import figure, with_sigma

ROOT = Path(__file__).parents[1]
DOCS = ROOT / 'docs'
README = (ROOT / 'README.md').read_text(encoding='utf-8')
GLANCE = (DOCS / 'glance.md').read_text(encoding='utf-8')
WEIGHTS = (DOCS / 'sully_1724.md').read_text(encoding='utf-8')
COMPARE = (DOCS / 'howto' / 'compare.md').read_text(encoding='utf-8')


@pytest.fixture(scope='module')
def outputs() -> ModuleType:
    return module_of(ROOT / 'docs' / 'outputs.py')


@pytest.mark.parametrize('page', ['tutorial', 'sully_1724', 'altitudes'])
def test_a_page_shows_what_its_commands_print(outputs: ModuleType, page: str) -> None:
    """`python docs/outputs.py` renews it."""
    text = (DOCS / f'{page}.md').read_text(encoding='utf-8')
    assert outputs.BLOCK.search(text)
    assert outputs.renewed(text) == text


def test_the_cost_of_sully_s_weights_is_that_of_his_clock() -> None:
    """Arcs and rates on land of each set of cheeks in the page's commands; at sea the last row."""
    found = re.search(r'(\| cheeks .*\n(?:\|.*\n)+)', WEIGHTS)
    assert found
    _, _, *rows = cells(found[1])
    cheeks = [
        [word.split('=', 1) for word in shlex.split(line)[6::2]]
        for line in re.findall(r'^    (tauto isochronism sully_1724 .*)', WEIGHTS, re.MULTILINE)
    ]
    light = {'trochlea.release_angle': '30 deg', 'escapement.energy': 1.89e-5}
    for k, row in enumerate(rows):
        given = {key: yaml.safe_load(value) for key, value in cheeks[k // 2]}
        given |= {} if k % 2 else light
        swing = steady_swing(compile_machine(tauto.load('sully_1724', **given)))
        assert isinstance(swing, SteadySwing)
        degrees = math.degrees(swing.amplitude)
        assert degrees == pytest.approx(60.0 if k % 2 else 30.0, abs=0.5)
        rate = figure(86400.0 * (2.0 / swing.period - 1.0), 's/day', signed=True)
        assert row[1:4] == ['8' if k % 2 else '1', f'{degrees:.2f}°', rate]
    sailed = tauto.sail('sully_1724', **given).result['clock']['rate_s_per_day']
    assert row[5] == figure(sailed, 's/day', signed=True)
    sailed = tauto.sail('euler_1727').result['clock']['rate_s_per_day']
    assert f' | {figure(sailed, "s/day", signed=True)} |\n\nThe two weights' in WEIGHTS


def cells(table: str) -> list[list[str]]:
    return [[cell.strip() for cell in line.split('|')[1:-1]] for line in table.splitlines()]


def test_the_table_of_the_clocks_is_one_that_its_maker_makes(outputs: ModuleType) -> None:
    """Its voyages of 81 days are too long for a test: `python docs/outputs.py --clocks`."""
    found = outputs.TABLE.search(COMPARE)
    assert found
    head, _, *rows = cells(found[3])
    assert head == list(outputs.HEADINGS)
    assert [row[0] for row in rows] == [outputs.CLOCKS[name] for name in CLOCKS]
    assert f'`tauto {found[2]}`' in COMPARE
    for _, *figures in rows:
        for shown in figures:
            assert re.fullmatch(r'[+−<]?[\d.,]+|£[\d,]+', shown), shown


def test_the_maker_s_figures_are_those_of_the_voyages(outputs: ModuleType) -> None:
    names = ('clock_second_cam_force', 'clock_own_cam_spring')
    table = outputs.clocks_table(
        f'compare {" ".join(names)} --suspension without --duration 600 --jobs 1'
    )
    for name, row in zip(names, cells(table)[2:], strict=True):
        scene = tauto.load(name, duration=600.0)
        result = tauto.sail(scene.model_copy(update={'suspension': None})).result
        assert row[0] == outputs.CLOCKS[name]
        longitude, rate = result['longitude'], result['clock']['rate_s_per_day']
        assert row[1] == figure(rate, 's/day', signed=True)
        assert row[2] == figure(abs(longitude['raw_error_nmi']), 'nmi')
        assert row[4] == figure(abs(longitude['error_nmi']), 'nmi')


def test_the_passage_of_the_readme_is_that_of_the_table(outputs: ModuleType) -> None:
    """Its voyages of 76 days are too long for a test: `python docs/outputs.py --passage`."""
    found = outputs.PASSAGE.search((DOCS / 'theory' / 'rate.md').read_text(encoding='utf-8'))
    assert found
    _, _, *rows = cells(found[3])
    assert [row[0] for row in rows] == list(outputs.NAVIGATORS)
    shown = README.partition('| what the navigator allows for')[2].partition('\n\n')[0]
    assert cells(shown)[2:] == [[row[0], *row[3:]] for row in rows]


def test_the_readmes_day_of_the_clock_is_a_row_of_the_benchmark() -> None:
    """Problem c: Euler's clock at sea, a swing a second, over ten days."""
    rows = json.loads((ROOT / 'benchmarks' / 'work_precision.json').read_text('utf-8'))['rows']
    days = {
        (f'{row["run_s"] * 86_400.0 / row["duration_s"]:.2f}', f'{row["error_s_per_day"]:.0e}')
        for row in rows
        if row['problem'] == 'c' and row['program'] == 'tauto'
    }
    shown = re.search(r'takes ([\d.]+) s to compute at an\s+error of (\S+)', README)
    assert shown
    assert (shown[1], shown[2]) in days


def test_the_maker_s_passage_is_that_of_the_voyages(outputs: ModuleType) -> None:
    """An hour from Portsmouth, half of it in port, with a landfall on the way."""
    voyage = '{departure: [50.8, -1.1], waypoints: [{place: [50.75, -1.2], landfall: true}], '
    voyage += 'arrival: [50.7, -1.3], sails_at: 1800, arrives_at: 3600}'
    given = {'voyage': yaml.safe_load(voyage), 'drift.observation_interval': 60.0}
    table = outputs.passage_table(
        "sail sully_lever_at_sea --duration 3610 --set 'air={kind: constant, celsius: 10.0}' "
        "--set 'drift.observation_interval=60' "
        f"--set 'voyage={voyage}'"
    )
    rows = cells(table)[2:]
    assert [row[0] for row in rows] == list(outputs.NAVIGATORS)
    sailed = tauto.sail(
        'sully_lever_at_sea',
        duration=3610.0,
        air={'kind': 'constant', 'celsius': 10.0},
        **given,
        **{'drift.covariates': yaml.safe_load(outputs.EQUATION.partition('=')[2])},
    )
    expected = [
        with_sigma(abs(landfall['error_nmi']), landfall['sigma_nmi'], signed=False)
        for landfall in sailed.result['longitude']['landfalls']
    ]
    assert [' ± '.join(rows[2][1:3]), ' ± '.join(rows[2][3:])] == expected
    assert rows[0][2] == rows[0][4] == '–'


def test_the_glossary_explains_each_row_of_a_result() -> None:
    """Each row has a word of the glossary; the numbers of messages are named by their topics."""
    glossary = GLANCE.partition('## Words')[2]
    words = set(re.findall(r'^\| ([\w ]+?)(?:, [^|]*)? \|', glossary, re.MULTILINE))
    assert {'trochlea', 'cheek', 'cam', 'involute', 'rate', 'rated', 'drift', 'landfall'} <= words
    for scene, given in (
        ('measured', {}),
        ('sully_lever_at_sea', {'duration': 60.0}),
        ('portsmouth_jamaica', {'duration': 3600.0}),
    ):
        for name, rows in groups(tauto.sail(scene, **given).result):
            for label, value, _ in rows:
                known = any(re.search(rf'\b{word}s?\b', f'{name}, {label}') for word in words)
                assert known or name == 'messages' or not value, (name, label)


@pytest.mark.parametrize('name', ['voyage', 'voyage_dark'])
def test_the_moving_picture_is_a_small_loop_of_six_seconds(name: str) -> None:
    """`python docs/img/voyage.py` draws it; each element moves for as long, and ends as it is."""
    file = DOCS / 'img' / f'{name}.svg'
    assert file.stat().st_size < 1_000_000
    found = ElementTree.parse(file)
    moved = [each for each in found.iter() if each.tag.rpartition('}')[2].startswith('animate')]
    assert len(moved) > 20
    assert {(each.get('dur'), each.get('repeatCount')) for each in moved} == {
        ('6.0s', 'indefinite')
    }
    for each in found.iter():
        for child in each:
            if child in moved and child.get('attributeName') in ('opacity', 'd'):
                assert (child.get('values') or '').split(';')[-1] == each.get(
                    child.get('attributeName') or ''
                )


def test_the_python_of_the_readme_runs(tmp_path: Path) -> None:
    lines = README.partition('## From Python')[2].split('\n')
    start = next(k for k, line in enumerate(lines) if line.startswith('    '))
    end = next(k for k in range(start, len(lines)) if lines[k] and not lines[k].startswith(' '))
    program = '\n'.join(line[4:] for line in lines[start:end]).strip()
    assert len(program.splitlines()) <= 10
    run = run_program(sys.executable, '-c', program, cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    assert (tmp_path / 'error.png').read_bytes().startswith(b'\x89PNG')


@pytest.mark.parametrize(
    ('picture', 'colours'),
    [
        ('map.png', ('blue', 'orange', 'green', 'grey')),
        ('error.png', ('blue', 'orange', 'grey')),
        ('rate.png', ('blue', 'orange', 'grey')),
        ('weather.png', ('blue', 'orange', 'green')),
        ('roll.svg', ('blue', 'green')),
    ],
)
def test_lines_of_the_gallery_have_the_colours_of_the_palette(
    picture: str, colours: tuple[str, ...]
) -> None:
    """Few colours in a file would make two lines alike; two of 255 are what 256 of them leave."""
    file = DOCS / 'img' / 'gallery' / picture
    if picture.endswith('.svg'):
        assert {COLOURS[name] for name in colours} <= set(re.findall(r'#\w{6}', file.read_text()))
        return
    drawn = 255.0 * imread(file)[..., :3].reshape(-1, 3)
    for name in colours:
        wanted = [int(COLOURS[name][at : at + 2], 16) for at in (1, 3, 5)]
        assert np.sum(np.max(np.abs(drawn - wanted), axis=1) <= 2.0) > 300, name
