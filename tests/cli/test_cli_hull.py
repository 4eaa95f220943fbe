"""`tauto hull`."""

import json
import math
import sys
from functools import partial

import numpy as np
import pytest
from command_line import invoke, refused, run
from matplotlib.figure import Figure

from tauto_core.plots import chart
from tauto_core.ship.hull import ClockPlace, Hull, hull_of_file, named_hull, rate_by_place
from tauto_core.ship.sea import bretschneider


def hull(*arguments):
    return invoke('hull', *arguments)


def facts(*arguments):
    return json.loads(run('hull', *arguments, '--json'))


def test_the_table_of_a_shipped_shape_is_that_of_the_library():
    found = facts('--shape', 'deptford', '--roll-period', 11)
    ship = Hull(named_hull('deptford'), 11.0, 0.08)
    assert found['ship']['centre_of_gravity_m'] == ship.z_g
    assert len(found['rates_s_per_day']) == 15
    ahead = [each for each in found['rates_s_per_day'] if each['heading_rad'] == math.pi]
    row = next(each for each in ahead if each['forward_m'] == pytest.approx(12.0))
    place = ClockPlace(row['forward_m'], 0.0, row['up_m'])
    spectrum = partial(bretschneider, significant_wave_height=2.5, peak_period=9.0)
    [same] = rate_by_place(ship, spectrum, headings=[math.pi], places=[place])
    assert row['heave'] == same.heave
    assert row['pitching'] == same.pitching
    printed = hull('--shape', 'deptford', '--roll-period', 11).stdout
    assert f'−{-row["heave"]:.1f}' in printed
    assert 'capytaine 3.0.0, 1056 panels' in printed


def test_her_operators_are_drawn(tmp_path, monkeypatch):
    drawn = []

    def draw(of, name):
        drawn.append((of, name))
        return Figure()

    monkeypatch.setattr(chart, 'draw', draw)
    picture = tmp_path / 'operators.svg'
    result = hull('--shape', 'deptford', '--speed', 2.0, '--plot', picture)
    assert result.exit_code == 0, result.stderr
    assert picture.is_file()
    [(top, name)] = drawn
    assert name == 'deptford, 44 m at 2 m/s'
    labels = [panel.y_label for panel in top.panels]
    lengths, turns = ('surge', 'sway', 'heave'), ('roll', 'pitch', 'yaw')
    assert labels == [*(f'{of}, m/m' for of in lengths), *(f'{of}, °/m' for of in turns)]
    roll, beam = top.panels[3], Hull(named_hull('deptford'), 3.1 * math.sqrt(12.6), 0.08)
    line = roll.lines[2]
    wanted = beam.response(math.tau / line.x, 0.5 * math.pi, 2.0).motions[:, 3]
    np.testing.assert_allclose(line.y, np.degrees(np.abs(wanted)), rtol=1e-9)
    asked = ('hull', '--shape', 'deptford', '--plot', tmp_path / 'operators.gif')
    assert 'must end in .svg' in refused(*asked)


def test_a_shape_is_scaled_by_its_length_and_kept_in_a_file(tmp_path):
    mine = tmp_path / 'mine.npz'
    found = facts('--shape', 'sloop', '--length', 34, '--out', mine)
    assert found['path'] == str(mine)
    assert found['hull']['beam_m'] == pytest.approx(8.15 * 34.0 / 29.4)
    assert hull_of_file(mine.read_bytes(), str(mine)).length == 34.0
    # a shape moves as its small sister does in small waves: the operators' sizes stay
    small = facts('--shape', 'sloop')
    for one, other in zip(found['operators'], small['operators'], strict=True):
        assert one['heave_m_per_m'] == pytest.approx(other['heave_m_per_m'], rel=1e-3)


def test_a_form_is_solved_and_printed(tmp_path, monkeypatch):
    pytest.importorskip('capytaine')
    import numpy as np

    from tauto_core.ship import hull_bem

    coarse = {'frequencies': np.linspace(0.6, 4.0, 8), 'headings': 7}
    usual = dict(hull_bem.compute.__kwdefaults__ or {})
    monkeypatch.setattr(hull_bem.compute, '__kwdefaults__', usual | coarse)
    monkeypatch.setattr(hull_bem.form_mesh, '__defaults__', (12, 4))
    sizes = ('--length', 20, '--beam', 6, '--draught', 2, '--block', 0.5)
    found = facts(*sizes, '--out', tmp_path / 'mine.npz')
    assert found['hull']['name'] == 'parametric form'
    assert found['hull']['block_coefficient'] == pytest.approx(0.5, rel=0.06)
    said = refused('hull', *sizes, '--roll-period', 2)
    assert '--roll-period = 2.0: must lie in [4.41, 73.5] s for a beam of 6 m' in said
    again = facts('--shape', 'yacht')
    assert found.keys() == {*again.keys(), 'path'}


@pytest.mark.parametrize(
    ('sizes', 'words'),
    [
        ((44, 5, 12.6, 0.59), 'draught = 12.6: must not exceed the beam, 5 m'),
        ((44, 12.6, 5, 59), 'block = 59.0: must be in [0.3, 0.96]'),
        ((44, 12.6, 5, 0.59), "Run pip install 'tauto_core[hull]'"),
    ],
)
def test_sizes_are_checked_before_capytaine_is_looked_for(monkeypatch, sizes, words):
    monkeypatch.setitem(sys.modules, 'capytaine', None)
    names = ('--length', '--beam', '--draught', '--block')
    asked = (word for pair in zip(names, sizes, strict=True) for word in pair)
    assert words in refused('hull', *asked)
