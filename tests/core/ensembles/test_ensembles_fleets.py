"""A fleet gives the rows of its ships sailed alone, also if interrupted."""

import math
import os
import re
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tauto_core import voyage
from tauto_core.ensembles import fleets, workers
from tauto_core.ensembles import rows as stored
from tauto_core.ensembles.fleets import Plan, as_draws, sail_fleet, sail_ship, statistics_of
from tauto_core.ensembles.rows import FIGURES, FleetError
from tauto_core.ensembles.workers import Ended, WorkerError
from tauto_core.plots.ensembles import fleet_figure
from tauto_core.scene import load_scene
from tauto_core.scene.errors import SceneError, TautoWarning, UsageError

NAME = 'second_cam_at_sea'
VARY = {
    'trochlea.cam.lever_rate': {'kind': 'normal', 'sigma': 1e-6},
    'trochlea.release_angle': {'kind': 'uniform', 'low': 0.8, 'high': 1.2},
}
DEADLINE_S = 300.0


def plan(ships=6, vary=VARY, duration=120.0):
    scene = load_scene(NAME, duration=duration)
    return Plan(scene, NAME, ships, as_draws(vary, 'vary.yaml', scene))


def lasting(rows):
    """Return the rows less what another run changes."""
    return [{key: value for key, value in row.items() if key != 'run_s'} for row in rows]


@pytest.fixture(scope='module')
def alone():
    return sail_fleet(plan(), 1)


def test_a_row_is_the_voyage_of_its_ship(alone):
    for number in (0, 5):
        ship, row = plan().ship(number), alone.rows[number]
        report = voyage.sail(ship.scene).result
        assert row['ship'] == number
        assert row['trochlea.release_angle'] == ship.scene.trochlea.release_angle
        assert row['failure'] is None
        for column, (section, key) in FIGURES.items():
            assert row[column] == report[section][key], column
    assert len({row['clock_error_s'] for row in alone.rows}) == 6


def test_processes_give_the_rows_of_one(alone, tmp_path, monkeypatch):
    monkeypatch.setattr(workers, 'POOL_START_S', 0.0)  # also for work that is small
    told: list[float] = []
    beside = sail_fleet(plan(), 2, tmp_path / 'fleet', told.append)
    assert lasting(beside.rows) == lasting(alone.rows)
    assert told == sorted(told)
    assert told[-1] == pytest.approx(6.0)
    table = pq.read_table(tmp_path / 'fleet' / 'ships.parquet')
    assert lasting(table.to_pylist()) == lasting(alone.rows)
    files = {file.name for file in (tmp_path / 'fleet').iterdir()}
    assert files == {'fleet.yaml', 'ships.parquet'}


def test_a_fleet_goes_on_where_it_was(alone, tmp_path, monkeypatch):
    folder = tmp_path / 'fleet'
    sail_fleet(plan(2), 1, folder)
    sailed = []

    def counted(plan, number, progress):
        sailed.append(number)
        if number == 4:
            raise KeyboardInterrupt
        return sail_ship(plan, number, progress)

    monkeypatch.setattr(fleets, 'sail_ship', counted)
    with pytest.raises(KeyboardInterrupt):
        sail_fleet(plan(), 1, folder)
    assert sailed == [2, 3, 4]
    monkeypatch.setattr(fleets, 'sail_ship', sail_ship)
    whole = sail_fleet(plan(), 1, folder)
    assert lasting(whole.rows) == lasting(alone.rows)
    again = sail_fleet(plan(4), 1, folder)  # all rows are there
    assert lasting(again.rows) == lasting(alone.rows[:4])
    assert pq.read_table(folder / 'ships.parquet').num_rows == 6


def test_a_ship_that_is_lost_has_no_row_and_sails_again(alone, tmp_path, monkeypatch):
    """Dead processes and lack of memory are no results of a clock."""
    folder = tmp_path / 'fleet'

    def without_3(task, items, jobs, progress):
        for each in workers.run_each(task, items, jobs, progress):
            lost = items[each.place] == 3
            yield Ended(each.place, None, WorkerError('its process died')) if lost else each

    def without_4(scene, **further):
        if scene == plan().ship(4).scene:
            raise MemoryError
        return sail(scene, **further)

    sail = voyage.sail
    monkeypatch.setattr(stored, 'run_each', without_3)
    monkeypatch.setattr(voyage, 'sail', without_4)
    with (
        pytest.warns(TautoWarning) as said,
        pytest.raises(WorkerError, match=r'ship 3: its process .*1 more.* 4 of 6 ships came in: '),
    ):
        sail_fleet(plan(), 1, folder)
    assert [str(each.message) for each in said] == [
        'ship 3: its process died. It is lost',
        'ship 4: MemoryError. It is lost',
    ]
    monkeypatch.undo()
    whole = sail_fleet(plan(), 1, folder)
    assert lasting(whole.rows) == lasting(alone.rows)
    run_s = [{row['ship']: row['run_s'] for row in fleet.rows} for fleet in (alone, whole)]
    assert all(each[ship] is not None for each in run_s for ship in range(6))


KILLED_AT_A_NAME = """
import os, signal, sys
from pathlib import Path
sys.path.insert(0, sys.argv[3])
from test_ensembles_fleets import plan
from tauto_core.ensembles import fleets
replace, names = os.replace, []
def killed(draft, place):
    names.append(place)
    if len(names) == int(sys.argv[2]):
        os.kill(os.getpid(), signal.SIGKILL)
    replace(draft, place)
os.replace = killed
fleets.sail_fleet(plan(), 1, Path(sys.argv[1]))
"""


def test_a_fleet_that_is_killed_while_it_writes_goes_on(alone, tmp_path):
    """The eighth name is ships.parquet, after fleet.yaml and six parts."""
    folder = tmp_path / 'fleet'
    words = [sys.executable, '-c', KILLED_AT_A_NAME, folder, '8', Path(__file__).parent]
    assert subprocess.run(words, check=False, timeout=DEADLINE_S).returncode == -signal.SIGKILL
    for _ in range(2):
        assert lasting(sail_fleet(plan(), 1, folder).rows) == lasting(alone.rows)
    assert {file.name for file in folder.iterdir()} == {'fleet.yaml', 'ships.parquet'}


def test_a_folder_has_one_fleet_at_a_time(alone, tmp_path, monkeypatch):
    folder = tmp_path / 'fleet'

    def beside(task, items, jobs, progress):
        with pytest.raises(UsageError, match='another process sails a fleet into it'):
            sail_fleet(plan(8), 1, folder)
        yield from workers.run_each(task, items, jobs, progress)

    monkeypatch.setattr(stored, 'run_each', beside)
    assert lasting(sail_fleet(plan(), 1, folder).rows) == lasting(alone.rows)


def test_a_ship_that_fails_is_a_row(tmp_path):
    """A roll of the wheel's own period carries it beyond the end of its cam."""
    key = 'ship.components.0.period'
    waves = [{'amplitude': 0.1, 'period': 5}]
    ship = {'kind': 'components', 'rate': 10.0, 'components': waves}
    scene = load_scene(NAME, duration=600.0, ship=ship)
    vary = as_draws({key: {'kind': 'list', 'values': [1.0, 9.0]}}, 'vary.yaml', scene)
    fleet = sail_fleet(Plan(scene, NAME, 6, vary), 1, tmp_path / 'fleet')
    failed = [row for row in fleet.rows if row['failure'] is not None]
    assert 0 < len(failed) < 6
    for row in fleet.rows:
        assert (row['failure'] is None) == (row[key] == 9.0) == (row['error_nmi'] is not None)
    assert all('cam' in row['failure'] for row in failed)
    assert fleet.answers.ships == 6
    assert sum(fleet.answers.failures.values()) == len(failed)
    kept = pq.read_table(tmp_path / 'fleet' / 'ships.parquet').to_pylist()
    assert lasting(kept) == lasting(fleet.rows)


def test_nothing_starts_where_a_draw_is_no_scene(tmp_path):
    bad = plan(50, {'trochlea.release_angle': {'kind': 'normal', 'mean': 1.0, 'sigma': 1e9}})
    far = plan(3, {'trochlea.inertia': {'kind': 'normal', 'mean': 0.0, 'sigma': 1e-4}})
    for refused in (bad, far):
        with pytest.raises(SceneError):
            sail_fleet(refused, 1, tmp_path / 'fleet')
        assert not (tmp_path / 'fleet').exists()


def test_ships_beyond_the_first_are_checked_when_they_sail(tmp_path, monkeypatch):
    """A million ships would be checked for half an hour before any sails."""
    vary = {'trochlea.release_angle': {'kind': 'list', 'values': [1.0, 1.1, 1.2, 1e9]}}
    many = plan(50, vary)
    with pytest.raises(SceneError) as caught:
        many.check()
    wrong = int(re.search(r'ship (\d+), as drawn', str(caught.value))[1])
    assert wrong > 0
    monkeypatch.setattr(fleets, 'CHECKED_FIRST', wrong)
    with pytest.raises(SceneError, match=f'ship {wrong}, as drawn'):
        sail_fleet(many, 1, tmp_path / 'fleet')
    assert any((tmp_path / 'fleet' / 'ships').iterdir())  # what came in is kept


def test_a_folder_with_other_contents_is_refused(tmp_path):
    sail_fleet(plan(1), 1, tmp_path / 'fleet')
    with pytest.raises(UsageError, match='another fleet; vary differ'):
        sail_fleet(plan(1, {}), 1, tmp_path / 'fleet')
    with pytest.raises(UsageError, match='another fleet; scene differ'):
        sail_fleet(plan(1, duration=60.0), 1, tmp_path / 'fleet')
    (tmp_path / 'other').mkdir()
    (tmp_path / 'other' / 'letter.txt').write_text('dear')
    with pytest.raises(UsageError, match='holds something else'):
        sail_fleet(plan(1), 1, tmp_path / 'other')
    with pytest.raises(UsageError, match='is a file'):
        sail_fleet(plan(1), 1, tmp_path / 'other' / 'letter.txt')
    (tmp_path / 'fleet' / 'ships.parquet').write_bytes(b'not parquet')
    with pytest.raises(FleetError, match=r'ships\.parquet: cannot be read'):
        sail_fleet(plan(1), 1, tmp_path / 'fleet')


def test_a_full_disk_is_named_and_keeps_what_came_in(alone, tmp_path, monkeypatch):
    folder = tmp_path / 'fleet'
    sail_fleet(plan(3), 1, folder)
    written = (folder / 'ships.parquet').read_bytes()

    def full(_file):
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr(os, 'fsync', full)
    with pytest.raises(FleetError, match=r'No space left on device.*Make room'):
        sail_fleet(plan(), 1, folder)
    monkeypatch.undo()
    assert (folder / 'ships.parquet').read_bytes() == written
    assert lasting(sail_fleet(plan(), 1, folder).rows) == lasting(alone.rows)


def row(number, error, **values):
    errors = {'raw_error_nmi': 2.0 * error, 'error_nmi': error, 'unchecked_days': 42.0}
    return {'ship': number, **errors, 'failure': None, 'stopped_s': None} | values


def test_shares_have_wilsons_interval():
    """Wilson's formula is (p + z²/2n ± z √(p(1 − p)/n + z²/4n²))/(1 + z²/n)."""
    rows = [row(k, -float(k)) for k in range(100)]
    # a clock that stopped has no longitude, as after an event
    rows += [row(100, 0.0, failure='lost'), row(101, 0.0, stopped_s=9.0)]
    answers = statistics_of(rows)
    assert answers.failures == {'lost': 1, 'the clock stopped': 1}
    found = answers.within['corrected'][0]
    n, k, z = 102, 31, 1.959963984540054
    p = k / n
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / (1 + z * z / n)
    assert (found.limit_nmi, found.ships, found.share) == (30.0, k, p)
    assert found.low == pytest.approx(middle - half, rel=1e-12)
    assert found.high == pytest.approx(middle + half, rel=1e-12)


def test_a_voyage_that_the_act_does_not_judge_is_not_judged():
    rows = [row(k, float(k)) for k in range(3)]
    found = statistics_of(rows)
    assert found.within is not None
    assert found.unchecked_days == (42.0, 42.0)
    found = statistics_of([*rows, row(3, 1.0, unchecked_days=41.99)])
    assert found.within is None
    assert found.unchecked_days == (41.99, 42.0)
    assert found.quantiles_nmi['corrected'] is not None
    found = statistics_of([row(0, 0.0, unchecked_days=None, failure='lost')])
    assert (found.within, found.unchecked_days) == (None, None)


def test_the_picture_shows_prizes_if_the_act_applies(alone):
    def said(fleet):
        axes = fleet_figure(fleet).axes[0]
        return axes.get_title(loc='left'), [text.get_text() for text in axes.texts]

    assert said(alone) == ('second_cam_at_sea: 6 ships, 2 minutes unchecked', [])
    rows = [row | {'unchecked_days': 81.0} for row in alone.rows]
    long = replace(alone, rows=rows, answers=statistics_of(rows))
    title, prizes = said(long)
    assert title == 'second_cam_at_sea: 6 ships'
    assert prizes == ['30 nmi: £20,000', '40 nmi: £15,000', '60 nmi: £10,000']


def test_quantiles_and_influences_are_of_those_that_arrived():
    rows = [row(k, (-1) ** k * float(k), key=math.exp(-k)) for k in range(101)]
    rows.append(row(101, 0.0, failure='lost', key=5.0))
    found = statistics_of(rows, ['key'])
    assert found.quantiles_nmi['corrected'] == pytest.approx([5.0, 25.0, 50.0, 75.0, 95.0])
    assert found.quantiles_nmi['raw'] == pytest.approx([10.0, 50.0, 100.0, 150.0, 190.0])
    assert [each.key for each in found.influences] == ['key']
    assert found.influences[0].corrected_size == pytest.approx(-1.0, abs=1e-12)
    assert abs(found.influences[0].corrected) < 0.05
    assert found.failures == {'lost': 1}


def test_a_tolerance_that_turns_the_error_either_way_is_seen():
    """The size of the error is least in the middle, so only its sign depends on the side."""
    rows = [row(k, 1.5 * (k - 50.0), key=1.0 + 0.01 * k) for k in range(101)]
    (found,) = statistics_of(rows, ['key']).influences
    assert found.raw == found.corrected == pytest.approx(1.0, abs=1e-12)
    assert abs(found.corrected_size) < 0.05
