"""`tauto fleet`: the answer first, shares, quantiles, influences. All of it as JSON."""

from dataclasses import replace

import pytest
from command_line import invoke

from tauto_core.cli.tables import fleet_tables
from tauto_core.ensembles import workers
from tauto_core.ensembles.fleets import Answers
from tauto_core.ensembles.rows import Portion
from tauto_core.ensembles.workers import Ended, WorkerError

SCENE = 'second_cam_at_sea'
VARY = """\
trochlea.cam.lever_rate: {kind: normal, sigma: 1.0e-6}
clock.nominal_period: {kind: uniform, low: 0.99, high: 1.01}
"""


@pytest.fixture
def vary(tmp_path):
    path = tmp_path / 'vary.yaml'
    path.write_text(VARY)
    return path


def answers(**changes):
    shares = [Portion(limit, 18, 0.9, 0.699, 0.972) for limit in (30.0, 40.0, 60.0)]
    raw, corrected = [1e-3, 2e-3, 3e-3, 0.5, 1.25], [1.0, 5.0, 10.2, 20.0, 31.23]
    within, quantiles = {'raw': shares, 'corrected': shares}, {'raw': raw, 'corrected': corrected}
    return replace(Answers(20, {}, (81.0, 81.0), within, quantiles, []), **changes)


def test_a_long_voyage_is_judged_and_a_short_one_is_not():
    judged = answers()
    assert judged.answer.startswith('Of 20 ships 90 % (69.9 % to 97.2 % with 95 % confidence)')
    assert fleet_tables(judged)[0].startswith('ships within\n')
    short = answers(within=None, unchecked_days=(0.25, 12.0))
    assert short.answer == (
        'Of 20 ships, 6 hours to 12 days unchecked, half are within 10.2 nautical miles by the '
        'rated clock and 95 % within 31.2; by the dial alone within 0.01 and 1.25. '
        'That is no verdict: the Act of 1714 asks for six weeks.'
    )
    assert not any('within' in table for table in fleet_tables(short)[1:])
    assert len(fleet_tables(short)) == len(fleet_tables(judged)) - 1
    lost = answers(within=None, unchecked_days=(0.0, 0.0), failures={'slack': 2})
    assert lost.answer.startswith('Of the 18 of 20 ships that arrived, checked to the end, half')


def test_a_fleet_of_which_no_ship_arrived_is_not_judged():
    lost = {'failures': {'slack': 20}, 'quantiles_nmi': {'raw': None, 'corrected': None}}
    none = answers(within=None, unchecked_days=None, **lost)
    assert none.answer == 'None of 20 ships arrived.'
    assert len(fleet_tables(none)) == 1


def fleet(*words):
    return invoke('fleet', SCENE, '--duration', '60', '--jobs', '1', *words)


def test_the_answer_comes_first_and_no_row_wraps(vary, tmp_path):
    out = tmp_path / 'rows'
    said = fleet('--ships', '12', '--vary', str(vary), '--out', str(out))
    assert said.exit_code == 0, said.stderr
    assert said.stdout.startswith('Of 12 ships, 60 seconds unchecked, half are within 0.')
    assert all(len(line) <= 80 for line in said.stdout.splitlines())
    assert 'clock.nominal_period' in said.stdout
    assert 'ships.parquet' in said.stderr
    assert (out / 'ships.parquet').exists()


@pytest.mark.parametrize(('drawn', 'alike'), [('', True), ('trochlea.release_angle', False)])
def test_ships_in_the_same_motion_are_named(vary, drawn, alike):
    """`measured` has recorded motion and a clock without noise."""
    vary.write_text(f'{drawn}: {{kind: uniform, low: 0.9, high: 1.1}}' if drawn else '{}')
    few = ('fleet', 'measured', '--ships', '2', '--duration', '60', '--jobs', '1')
    said = invoke(*few, '--vary', str(vary)).stderr
    assert ('all ships meet the same motion, since ship.kind is recorded' in said) == alike


def test_a_fleet_is_drawn_and_the_file_named(tmp_path):
    path = tmp_path / 'fleet.png'
    said = fleet('--ships', '2', '--plot', str(path))
    assert said.exit_code == 0
    assert f'wrote {path}' in said.stderr
    assert path.read_bytes().startswith(b'\x89PNG')


def test_a_lost_ship_gives_no_answer_and_exit_code_1(tmp_path, monkeypatch):
    def lost(task, items, jobs, progress):
        first, *others = workers.run_each(task, items, jobs, progress)
        yield from others
        yield Ended(first.place, None, WorkerError('its process died'))

    monkeypatch.setattr('tauto_core.ensembles.rows.run_each', lost)
    ended = fleet('--ships', '3', '--out', str(tmp_path / 'rows'), '--json')
    assert (ended.exit_code, ended.stdout) == (1, '')
    assert 'ship 0: its process died. It is lost' in ended.stderr
    assert '2 of 3 ships came in: they are kept, and the same command sails' in ended.stderr
