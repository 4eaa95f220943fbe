"""Clocks run side by side: each as if alone, and an event in one does not affect others."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tauto_core.ensembles.comparison import (
    PIECES,
    Entry,
    ErrorTrace,
    compare,
    in_one_sea,
    make_entries,
    sail_sea,
)
from tauto_core.samples import READING, TimeSamples, same
from tauto_core.scene import load_scene
from tauto_core.scene.errors import SceneError
from tauto_core.ship import ShipMotion
from tauto_core.voyage import sail


def sail_together(entries):
    return [found['row'] for found in sail_sea(list(enumerate(entries)), None)]


def entry(name, distance=0.080, period=9.0, nominal=1.0):
    waves = [{'amplitude': 0.1, 'period': period}]
    way = {'departure': [50.0, 0.0], 'arrival': [51.0, 0.0], 'sails_at': 600.0}
    changed = {
        'trochlea.thread.distance': distance,
        'ship': {'kind': 'components', 'components': waves, 'rate': 10.0},
        'clock.nominal_period': nominal,
        'voyage': {**way, 'arrives_at': 6000.0},
        'drift': {
            'observation_interval': 60.0,
            'observation_sigma': 0.01,
            'prior_rate_sigma': 1e3,
        },
        'log.interval': 10.0,
    }
    return make_entries([load_scene('second_cam_at_sea', name=name, duration=1200.0, **changed)])[
        0
    ]


def figures(row):
    """Return a row without its run time."""
    return {key: value for key, value in vars(row).items() if key != 'run_s'}


@pytest.fixture(scope='module')
def pair():
    """A good clock, and one that resonates with a roll of its own period to the cam's end."""
    return entry('good', nominal=1.001), entry('off', 0.0125, 1.0)


def test_an_event_stops_its_own_clock_alone(pair):
    shares: list[float] = []
    result = compare(pair, jobs=2, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    good, off = result.rows
    assert good.stopped is None
    assert off.rate_s_per_day is off.error_s is off.error_nmi is off.prize_pounds is None
    assert 0.0 < off.stopped.at_s < 1200.0
    assert 'cam' in off.stopped.why
    assert f'{off.stopped.at_s:.3f} s' in off.stopped.why
    assert (result.duration_s, result.piece_s) == (1200.0, 20.0)
    shares.clear()
    alone = compare(pair, jobs=1, progress=shares.append).rows
    assert [figures(row) for row in result.rows] == [figures(row) for row in alone]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_clocks_in_one_sea_have_the_figures_of_those_alone():
    """The sea is sampled once, and a case moves once, in which three of the clocks hang."""
    clocks = 'clock_involute_weight', 'clock_own_cam_weight', 'clock_second_cam_force'
    entries = make_entries(clocks, duration=3600.0)
    deep = entries[1].scene
    case = deep.suspension.model_copy(update={'depth': 0.4})
    entries[1] = replace(entries[1], scene=deep.model_copy(update={'suspension': case}))
    together = [figures(row) for row in sail_together(entries)]
    assert together == [figures(sail_together([each])[0]) for each in entries]
    assert together[1]['error_s'] == sail(entries[1].scene).result['clock']['error_s']
    assert len({row['error_s'] for row in together}) == 6


def test_a_force_that_no_clock_feels_is_not_computed(monkeypatch):
    """A wheel under a force feels the roll alone, one under a weight the heave too."""
    asked, sensed = [], ShipMotion._sensed

    def spied(motion, stamps, first, turning, felt):
        asked.append(felt)
        return sensed(motion, stamps, first, turning, felt)

    monkeypatch.setattr(ShipMotion, '_sensed', spied)
    force = load_scene('second_cam_at_sea', duration=120.0)
    weight = load_scene('involute_weight_at_sea', duration=120.0)
    for clocks, felt in (
        ([force, force.model_copy(update={'name': 'other'})], {False}),
        ([force, weight], {False, True}),
    ):
        sail_together(make_entries(clocks, ship_of=force, cases='without'))
        assert set(asked) == felt
        asked.clear()


def test_what_stops_a_case_stops_all_clocks_in_it():
    """It swings too wide. Clocks fixed to the ship go on."""
    waves = [{'amplitude': 0.6, 'period': 3.0}]
    wild = {'ship': {'kind': 'components', 'rate': 20.0, 'height': 3.0, 'components': waves}}
    clocks = 'clock_involute_weight', 'clock_second_cam_force'
    entries = make_entries(clocks, duration=600.0, overrides=wild)
    rows = sail_together(entries)
    hung, fixed = ([row for row in rows if row.suspended == which] for which in (True, False))
    assert len({row.stopped for row in hung}) == 1
    assert hung[0].stopped is not None
    assert [row.stopped for row in fixed] == [None, None]


def test_clocks_of_a_sea_are_divided_among_processes(pair):
    entries = make_entries(('clock_involute_weight', 'clock_second_cam_force'), duration=600.0)
    assert [len(each) for each in in_one_sea(entries, 1)] == [4]
    dealt = in_one_sea(entries, 3)
    assert [len(each) for each in dealt] == [2, 1, 1]
    assert sorted(place for sea in dealt for place, _ in sea) == [0, 1, 2, 3]
    assert [len(each) for each in in_one_sea(pair, 2)] == [1, 1]  # ships of two rolls


def test_clocks_in_a_hung_case_begin():
    entries = make_entries(('clock_cheek_weight', 'clock_sully_lever'))
    (order,) = in_one_sea(entries, 1)
    assert [each.hung for _, each in order] == [True, True, False, False]


def test_the_figures_are_those_of_the_voyage(pair):
    (row,), report = sail_together([pair[0]]), sail(pair[0].scene).result
    assert row.rate_s_per_day == report['clock']['rate_s_per_day']
    # a dial of 1.001 s on a wheel of 1 s, and the roll's forced response shakes single readings
    assert row.rate_s_per_day == pytest.approx(86.4, abs=1.0)
    assert row.error_s == report['clock']['error_s']
    assert row.raw_error_nmi == report['longitude']['raw_error_nmi']
    assert row.error_nmi == report['longitude']['error_nmi']
    assert row.raw_prize_pounds is row.prize_pounds is None  # twenty minutes are no trial
    assert (row.release, row.propagator, row.suspended) == (1.0, 'forced_harmonic', False)
    assert row.roll_deg == pytest.approx(math.degrees(0.1 * math.sqrt(2.0)))
    assert row.time_s == [20.0 * k for k in range(61)]
    assert row.trace_s[-1] == row.error_s


def test_a_clock_whose_swing_dies_away_counts_as_stopped(pair, monkeypatch):
    trochlea = {'stopped_s': 12.5, 'stopped_why': 'its swing had died away'}
    report = {'trochlea': trochlea, 'clock': {'rate_s_per_day': -5.0}}
    monkeypatch.setattr('tauto_core.results.Summary.result', lambda _: report)
    (row,) = sail_together([pair[0]])
    assert row.stopped.at_s == 12.5
    assert row.stopped.why == 'after 12.5 seconds: its swing had died away'
    assert row.rate_s_per_day == -5.0
    assert row.rate_spread_s_per_day is None


def test_a_scene_that_cannot_sail_ends_all(pair):
    scene = load_scene('second_cam_at_sea', duration=60.0)
    trochlea = scene.trochlea.model_copy(update={'release_angle': 9.0})
    bad = Entry('bad', scene.model_copy(update={'trochlea': trochlea}), None)
    with pytest.raises(SceneError, match=r'bad: trochlea\.release_angle = 9') as caught:
        compare([pair[0], bad], jobs=1)
    assert caught.value.key == 'trochlea.release_angle'


def test_the_spread_is_that_of_the_rates_over_the_pieces():
    """Rates of alternately +1 and −1 s/day: their mean is 0, their spread √(n/(n − 1))."""
    scene = load_scene('ideal', duration=86_400.0 * 2)
    assert scene.log_count == 2 * 1440 + 1
    trace = ErrorTrace(scene)
    piece = 30  # log intervals: 2880 in 96 pieces
    gains = np.repeat(np.tile([1.0, -1.0], PIECES // 2), piece) * 60.0 / 86_400.0
    errors = np.round(1e9 * np.concatenate(([0.0], np.cumsum(gains)))).astype(np.int64)
    stamps = scene.starts_at_ns + scene.log_interval_ns * np.arange(len(errors))
    for part in np.array_split(np.arange(len(errors)), 7):
        dial = same('dial', len(part))
        trace.feed({READING: TimeSamples(stamps[part], '', (stamps + errors)[part], dial)})
    assert trace.piece_s == 1800.0
    assert len(trace.time_s) == PIECES + 1
    assert trace.rate_spread() == pytest.approx(math.sqrt(PIECES / (PIECES - 1)), rel=1e-6)
    assert ErrorTrace(scene).rate_spread() is None
