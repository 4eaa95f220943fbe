"""A trial gives the rows of its clocks sailed alone."""

import math
from dataclasses import replace
from datetime import datetime, timedelta
from functools import partial

import numpy as np
import pytest
from trial_examples import CLOCK, LOG, OTHER, clock, write_log

from tauto_core import voyage
from tauto_core.ensembles import trials, workers
from tauto_core.ensembles.comparison import Sea, on_passage_of, regulated, with_rate
from tauto_core.ensembles.rows import FIGURES
from tauto_core.ensembles.trials import (
    Trial,
    TriedClock,
    answers_of,
    clocks_beside,
    is_wanted,
    make_trial,
    ocean_of_passage,
    sail_passage,
    sail_trial,
    season_of,
)
from tauto_core.machines import compile_machine
from tauto_core.scene import load_scene
from tauto_core.scene.errors import ABSENT, SceneError, UsageError
from tauto_core.ship.logbook import LoggedPassage, read_passages
from tauto_core.ship.sampling import rate_for

ALL = 0.0, math.inf


def made(folder, names=(CLOCK,), text=LOG, days=ALL, **more):
    """Return a trial of clocks on the ship of the first one."""
    path = write_log(folder, text)
    first = clock(names[0])
    others = [(name, on_passage_of(name, clock(name), first, names[0])) for name in names[1:]]
    scenes = [(names[0], first), *others]
    return make_trial(path, scenes, days=days, harbour_days=0.5, **more)


def lasting(rows):
    """Return the rows less what another run changes."""
    return [{key: value for key, value in row.items() if key != 'run_s'} for row in rows]


@pytest.fixture(scope='module')
def trial(tmp_path_factory):
    folder = tmp_path_factory.mktemp('logs')
    return made(folder, (CLOCK, OTHER), days=(0.0, 2.0), longest_s=130_200.0)


@pytest.fixture(scope='module')
def alone(trial):
    return sail_trial(trial, 1)


def test_a_row_is_the_voyage_of_its_clock_alone(trial, alone):
    """Clocks that share a sea have the bits of those that sail by themselves."""
    for place, row in enumerate(alone[:2]):
        scene = trial.scene(trial.clocks[place], trial.passages[0])
        report = voyage.sail(regulated(scene, compile_machine(scene)))
        for column, (section, key) in FIGURES.items():
            assert row[column] == report.result[section][key], column
        # the trace is the error at the entries: noon of each day, after 12 hours in harbour
        noons = np.searchsorted(report.time_s, [43200.0, 129600.0])
        assert row['noon_error_nmi'] == report.longitude_error_nmi[noons].tolist()


def planned(folder, names, **more):
    """Return a trial of clocks on the ship of esperance_to_the_cape, and passages."""
    first = load_scene('esperance_to_the_cape', **{'log.interval': 600.0})
    scenes = [('first', first), *clocks_beside(first, 'first', names)]
    priors = {name: {'value': -1.0, 'sigma': 0.1} for name in ('heave', 'roll', 'gravity')}
    clocks = tuple(
        TriedClock(origin, scene.name, trials._content(scene, origin), tuple(priors), priors)
        for origin, scene in scenes
    )
    return Trial('log', clocks, first.seed, 0.1, **more), read_passages(write_log(folder))


def test_clocks_with_shared_inputs_keep_their_bits(tmp_path):
    """Forcing and integrals of the covariates are computed once for two of three clocks."""
    names = ('clock_cheek_weight', 'clock_own_cam_spring')
    trial, passages = planned(tmp_path, names, longest_s=14400.0)
    sailing = 0, next(iter(passages))
    together = lasting(sail_passage(trial, sailing, lambda _: None))
    assert all(row['sensed_error_nmi'] is not None for row in together)
    for place, each in enumerate(trial.clocks):
        (row,) = sail_passage(replace(trial, clocks=(each,)), sailing, lambda _: None)
        assert lasting([{**row, 'ship': place}]) == [together[place]]


def test_the_rate_of_a_trial_keeps_the_accuracy_asked_for(tmp_path):
    """Against 16 Hz. Fewer samples suffice than if all pieces were like the first one."""
    trial, passages = planned(tmp_path, (), longest_s=86400.0)
    passage = next(iter(passages))
    scenes = [trial.scene(trial.clocks[0], passage, rate_hz=hz) for hz in (None, 16.0)]
    asked, ship = scenes[0].accuracy, scenes[0].ship
    of_all = rate_for(scenes[0], ship, asked, forgets=True, swings=False, case_hz=None)
    assert ship.rate < of_all < 16.0
    error_s = [voyage.sail(scene).clock_error_s for scene in scenes]
    assert np.max(np.abs(error_s[0] - error_s[1])) <= asked


def test_the_second_navigator_has_a_scenes_covariates(trial, alone):
    tried = trial.clocks[0]
    assert tried.covariates == ('heave', 'roll', 'gravity')
    scene = trial.scene(tried, trial.passages[0])
    rated = regulated(scene, compile_machine(scene))
    keys = {**scene.drift.model_dump(), 'covariates': tried.covariates}
    drift = type(scene.drift).model_validate({**keys, 'coefficients': tried.priors})
    sensed = voyage.sail(rated.model_copy(update={'drift': drift}), keep=False)
    assert alone[0]['sensed_error_nmi'] == sensed.result['longitude']['error_nmi']
    assert alone[0]['sensed_sigma_nmi'] == sensed.result['longitude']['sigma_nmi']
    # no rate equation fits the other clock, and that is said
    assert trial.clocks[1].covariates == ()
    assert 'no rate equation fits' in trial.clocks[1].why_unsensed
    assert alone[1]['sensed_error_nmi'] is None


def test_an_error_of_the_sea_names_clock_and_passage(trial):
    """The sea is made of the scene that needs the most samples, here the second clock's."""
    scene = trial.scene(trial.clocks[1], trial.passages[0])
    hung = load_scene('suspended_weight_at_sea').suspension
    slow = with_rate(scene.model_copy(update={'suspension': hung}), 0.05)
    fixed = slow.model_copy(update={'suspension': None})
    with pytest.raises(SceneError) as refused:
        Sea([fixed, slow], ['one.yaml', 'other.yaml, passage 3'])
    assert str(refused.value).startswith('other.yaml, passage 3: voyage.log')


def test_a_trial_goes_on_where_it_was(trial, alone, tmp_path, monkeypatch):
    folder, sailed = tmp_path / 'trial', []

    def killed(trial, sailing, progress):
        sailed.append(sailing[0])
        if len(sailed) == 2:
            raise KeyboardInterrupt
        return sail_passage(trial, sailing, progress)

    monkeypatch.setattr(trials, 'sail_passage', killed)
    with pytest.raises(KeyboardInterrupt):
        sail_trial(trial, 1, folder)
    monkeypatch.setattr(trials, 'sail_passage', sail_passage)
    # the others sail in other processes
    monkeypatch.setattr(workers, 'POOL_START_S', 0.0)
    assert lasting(sail_trial(trial, 2, folder)) == lasting(alone)
    assert sailed == [number for number, _ in trial.sailings[:2]]
    assert [row['ship'] for row in alone] == list(range(4))
    other = replace(trial, harbour_days=1.0)
    with pytest.raises(UsageError, match='holds another fleet; rules differ'):
        sail_trial(other, 1, folder)


def test_passages_are_chosen(tmp_path, monkeypatch):
    monkeypatch.setattr(trials, '_sensed', lambda _trial, clock, _typical: clock)

    def chosen(**asked):
        return [each.name[-1] for each in made(tmp_path, **asked).passages]

    assert chosen() == ['1', '2', '3']
    assert chosen(days=(2.5, 10.0)) == ['3']
    assert chosen(days=(0.0, 2.0)) == ['1', '2']
    assert chosen(years=(1780, 1800)) == ['3']
    assert chosen(sample=2) == ['1', '3']
    with pytest.raises(UsageError, match='none of its 3 passages'):
        chosen(days=(42.0, math.inf))
    passages = list(read_passages(write_log(tmp_path)))
    assert season_of(passages[0]) == 'December to February'
    assert season_of(passages[2]) == 'June to August'
    assert ocean_of_passage(passages[2]) == 'South Pacific'


def test_passages_are_chosen_by_the_year_of_an_entry(tmp_path):
    text = LOG.replace('17700101-1,', 'La Une,').replace('17910701-3,', '1770-El Tres,')
    path = write_log(tmp_path, text.replace('1791-07-0', '1791070').replace('T18:00', 'T1800'))
    of_1780s = partial(is_wanted, days=ALL, years=(1780, 1800))
    chosen = list(filter(of_1780s, read_passages(path)))
    assert [each.name for each in chosen] == ['1770-El Tres']
    assert season_of(chosen[0]) == 'June to August'
    # a passage of unknown year is not passed over
    path = write_log(tmp_path, text.replace('1770-01-01T12:00,48.0,', 'noon,48.0,'))
    chosen = list(filter(of_1780s, read_passages(path)))
    assert [each.name for each in chosen] == ['La Une', '1770-El Tres']


FIRST, *OTHERS = LOG.splitlines()
NO_WIND = [f'{",".join(row.split(",")[:8])},,,' for row in OTHERS if '17910701' in row]


@pytest.mark.parametrize(
    ('text', 'key', 'said'),
    [
        (
            '\n'.join([FIRST, *(row for row in OTHERS if '17910701' not in row), *NO_WIND, '']),
            'passage 17910701-3, wind_mps',
            'has no wind',
        ),
        (
            LOG.replace('1770-01-02T12:00,46.55,-8.0', '1770-01-02T12:00,36.55,-8.0'),
            'passage 17700101-2, row 2 (line 6), latitude',
            'nautical miles from the previous entry',
        ),
    ],
)
def test_a_wrong_log_is_refused_by_passage_and_row(tmp_path, monkeypatch, text, key, said):
    monkeypatch.setattr(trials, 'sail_passage', lambda *_: pytest.fail('it sails'))
    with pytest.raises(SceneError) as refused:
        made(tmp_path, text=text)
    assert refused.value.problems[0].key == key
    assert said in str(refused.value)


THREE_WRONG = LOG.replace('46.5,-8.0,200,6.7', '46.5,-8.0,200,61').replace(
    '150,4.6', '400,4.6'
).replace('-13.5,-84.0,160,4.6', '-13.5,-84.0,160,99')  # fmt: skip


def test_wrong_passages_are_listed_or_left_out(tmp_path):
    with pytest.raises(SceneError) as refused:
        made(tmp_path, text=THREE_WRONG)
    one, three, how = refused.value.problems
    assert one.key == 'passage 17700101-1, row 2 (line 3), wind_mps'
    assert three.key == 'passage 17910701-3, row 1 (line 8), wind_from_deg'
    said = '2 passages cannot be sailed. Correct them, or leave them out with skip_wrong=True.'
    assert how.text == said
    found = made(tmp_path, text=THREE_WRONG, skip_wrong=True)
    assert [each.name for each in found.passages] == ['17700101-2']
    assert found.left_out == (('17700101-1', one), ('17910701-3', three))
    # passages that are left out do not reduce the sample
    sampled = made(tmp_path, text=THREE_WRONG, sample=1, skip_wrong=True)
    assert sampled.passages == found.passages
    with pytest.raises(UsageError, match='none of its'):
        made(tmp_path, text=THREE_WRONG, years=(1780, 1800), skip_wrong=True)


def test_a_background_swell_is_on_every_passage(tmp_path):
    path = write_log(tmp_path)
    swell = {'significant_wave_height': 1.5, 'peak_period': 11.0, 'waves_to': 0.0}
    changed = {'ship.weather.background_swell': swell, 'air': ABSENT}
    own = load_scene('esperance_to_the_cape', **changed)
    tried = TriedClock('own', own.name, trials._content(own, 'own'))
    *_, passage = read_passages(path)
    scene = Trial(path, (tried,), own.seed, 14.0).scene(tried, passage)
    assert scene.ship.weather.background_swell.model_dump() == swell


def test_a_trial_sails_its_passages_in_random_order(trial):
    passages = tuple(replace(trial.passages[0], name=f'{1700 + k}') for k in range(100))
    whole = replace(trial, passages=passages).sailings
    assert sorted(number for number, _ in whole) == list(range(100))
    assert all(passage is passages[number] for number, passage in whole)
    assert whole == replace(trial, passages=passages).sailings  # so it can be resumed
    # the mean of a third drawn at random: 49.5 with a deviation of 4.1
    assert abs(np.mean([number for number, _ in whole[:33]]) - 49.5) < 5 * 4.1


MADE = TriedClock('made.yaml', 'made', {'ship': {}}, ('heave',))


def sailed(number, days=50, latitude=0.0, longitude=-30.0, month=1):
    first = datetime(1770, month, 1, 12)
    entries = tuple(
        (f'{first + timedelta(days=day):%Y-%m-%dT%H:%M}', latitude, longitude, 90.0, 5.0, None)
        for day in range(days)
    )
    return LoggedPassage(f'1770{month:02}01-{number}', 'log.csv', entries=entries)


def error_row(number, name, error, **more):
    errors = {'raw_error_nmi': 2.0 * error, 'error_nmi': error, 'sensed_error_nmi': 0.1 * error}
    ends = {'stopped_s': None, 'failure': None}
    return {'ship': number, 'clock': 'made', 'passage': name, **errors, **ends, **more}


def of(passages, **more):
    return Trial('log.csv', (MADE,), 0, 14.0, passages=tuple(passages), **more)


def test_shares_count_those_that_failed_or_stopped_as_outside():
    passages = [sailed(k) for k in range(10)]
    errors = [-5.0, 29.9, 30.0, -30.1, 39.0, 59.0, 61.0, 300.0, 1.0, 2.0]
    rows = [error_row(k, each.name, errors[k]) for k, each in enumerate(passages)]
    rows[8]['stopped_s'] = 1e6
    rows[9] = error_row(9, passages[9].name, 0.0, failure='the thread broke', raw_error_nmi=None)
    rows[9] |= {'error_nmi': None, 'sensed_error_nmi': None}
    found = answers_of(of(passages), rows).clocks[0]
    prizes = found.ways['corrected'].prizes
    assert [each.passages for each in prizes] == [3, 5, 6]
    assert [each.pounds for each in prizes] == [20_000, 15_000, 10_000]
    assert prizes[0].low < prizes[0].share == 0.3 < prizes[0].high
    assert (found.stopped, found.failures) == (1, {'the thread broke': 1})
    assert [each.passages for each in found.ways['raw'].prizes] == [1, 1, 3]


def test_short_passages_are_not_judged_and_parts_add_up():
    northern = [sailed(k, month=month, latitude=40.0) for k, month in ((1, 1), (2, 6))]
    southern = sailed(3, month=6, latitude=-40.0, longitude=60.0)
    passages = [sailed(0, days=30), *northern, southern]
    rows = [error_row(k, each.name, 10.0 * (k + 1)) for k, each in enumerate(passages)]
    found = answers_of(of(passages), rows)
    assert (found.passages, found.judged) == (4, 3)
    way = found.clocks[0].ways['corrected']
    assert [(each.name, each.passages, each.within) for each in way.seasons] == [
        ('December to February', 1, [1, 1, 1]),
        ('June to August', 2, [1, 2, 2]),
    ]
    medians = {each.name: each.median_nmi for each in way.oceans}
    assert medians == {'Indian Ocean': 40.0, 'North Atlantic': 25.0}
    # cut to three weeks at sea there is no verdict
    short = answers_of(of(passages, longest_s=35 * 86400.0), rows)
    assert (short.judged, short.clocks[0].ways['raw'].prizes) == (0, [])
    assert short.clocks[0].ways['corrected'].quantiles_nmi is not None
