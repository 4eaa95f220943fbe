"""`tauto logbook`: its list, its refusals, and its scenes."""

from __future__ import annotations

import json

import pytest
from cliwoc import release_21
from command_line import refused, run

from tauto_core.scene import load_scene

BOOK = (
    'passage,ship,utc,latitude,longitude,wind_from_deg,wind_mps,air_celsius\n'
    'A-1,La Folle,1785-08-01T12:00,48.0,-7.0,270,6.7,18.5\n'
    'A-1,La Folle,1785-08-02T12:00,46.5,-9.0,270,9.3,\n'
    'A-1,La Folle,1785-08-04T12:00,44.5,-10.0,,,\n'
    'B-2,,1790-01-01T18:00,-10.0,-79.0,90,61,\n'
    'B-2,,1790-01-02T18:00,-11.0,-80.0,140,5.0,\n'
)


@pytest.fixture
def book(tmp_path):
    file = tmp_path / 'log.csv'
    file.write_text(BOOK, encoding='utf-8')
    return str(file)


def test_every_passage_is_listed_with_what_is_doubtful_or_wrong(book):
    one, other = json.loads(run('logbook', book, '--json'))['passages']
    asked = ('passage', 'ship', 'days', 'entries')
    assert [one[key] for key in asked] == ['A-1', 'La Folle', 3.0, 3]
    assert one['wind_share'] == pytest.approx(2 / 3)
    *notes, last = one['notes']
    assert notes == ['1 gap of up to 2 days', '1 of 3 entries without a wind']
    assert last.startswith('last entry at sea')
    assert 'row 1 (line 5), wind_mps' in other['problems'][0]
    said = run('logbook', book)
    assert '2 passages, 1 of them can be sailed' in said
    assert '67%   33%  48° N 7° W, 44° N 10° W   La Folle; 1 gap' in said
    assert '  10° S 79° W, 11° S 80° W  ?; cannot be sailed' in said


def test_a_scene_of_a_passage_sails_by_itself(book, tmp_path):
    file = tmp_path / 'a1.yaml'
    run('logbook', book, '--passage', 'A-1', '-o', file, '--harbour-days', '1')
    scene = load_scene(file)
    assert scene.voyage.log.ship == 'La Folle'
    assert scene.duration == 4 * 86_400.0 + 60.0
    assert scene.trochlea == load_scene('portsmouth_jamaica').trochlea


def test_who_sails_a_log_is_told_that_it_makes_no_landfall(book, tmp_path):
    file = str(tmp_path / 'a1.yaml')
    asked = ['logbook', book, '--passage', 'A-1', '--scene', 'second_cam_at_sea', '-o', file]
    run(*asked, '--harbour-days', '0')
    light = ['--set', 'log.interval=600', '--set', 'ship.rate=8']
    found = run('sail', file, *light, '--duration', '259800')
    # 44.5° N 10° W is 178 km from Punta Candieira, and 170 from Cape Touriñán
    assert 'The last entry of the log is at sea, 1' in ' '.join(found.split())
    assert 'last entry' not in run('sail', file, *light, '--duration', '1 h')


@pytest.mark.parametrize(
    ('asked', 'what'),
    [
        (['--passage', 'B-2'], 'row 1 (line 5)'),
        (['--passage', 'C'], 'not one of the 2 passages'),
        (['-o', 'x.yaml'], '--passage'),
        (['--passage', 'A-1', '-o', 'x.txt'], '.yaml'),
    ],
)
def test_what_cannot_be_written_is_refused(book, asked, what):
    assert what in refused('logbook', book, *asked)


def test_places_far_inland_are_told_and_tracks_drawn(tmp_path):
    file, chart = tmp_path / 'log.csv', tmp_path / 'map.svg'
    file.write_text(
        'passage,utc,latitude,longitude,wind_from_deg,wind_mps\n'
        'A-1,1785-08-01T12:00,43.6,-8.5,,\n'
        'A-1,1785-08-03T12:00,40.42,-3.7,,\n'
    )
    [passage] = json.loads(run('logbook', str(file), '--plot', str(chart), '--json'))['passages']
    assert 'more than 30 km inland: row 2' in passage['notes']
    assert not any('last entry at sea' in note for note in passage['notes'])
    assert chart.read_text().startswith('<?xml')
    assert 'no such file' in refused('logbook', 'nowhere.csv')
    asked = ('logbook', file, '--plot', chart, '--passage', 'A-1')
    assert 'draws all passages' in refused(*asked)


def test_progress_grows_while_reading_and_making_passages(tmp_path, monkeypatch):
    """20,020 rows, with doubts."""
    from tauto_core.ship import logbook

    path = tmp_path / 'cliwoc.tsv'
    release_21(path, 20_020)
    shares: list[float] = []
    read = logbook.read_passages

    def reading(file, **_):
        return read(file, progress=shares.append)

    monkeypatch.setattr(logbook, 'read_passages', reading)
    found = json.loads(run('logbook', path, '--json'))['passages']
    entries = sum(each['entries'] for each in found)
    assert 19_000 < entries <= 20_020
    # it grows as the file is read, row by row, to a half, and then log by log
    assert shares == sorted(shares)
    assert 0.0 <= shares[0] < 0.05
    assert 0.35 < shares[4] <= 0.5 < shares[5]
    assert shares[-1] == 1.0
    assert len(shares) > 200
