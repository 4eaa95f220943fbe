"""Shares, intervals and ± of a trial against figures worked out by hand or by chance."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tauto_core.ensembles.answers import answers_of
from tauto_core.ensembles.trials import Rules, SailedTrial, Trial, TriedClock
from tauto_core.ship.logbook import LoggedPassage

CLOCK = TriedClock('made.yaml', 'made', {'ship': {}}, ('heave',))


def passage(number, days=50, latitude=0.0, longitude=-30.0, month=1, drift=0.1):
    entries = tuple(
        (
            f'17{70 + day // 360}-{1 + (month - 1 + day // 28) % 12:02}-{1 + day % 28:02}T12:00',
            0,
            0,
        )
        for day in range(days)
    )
    placed = tuple(
        (utc, latitude, longitude + drift * day, 90.0, 5.0, None)
        for day, (utc, *_) in enumerate(entries)
    )
    return LoggedPassage(f'1770{month:02}01-{number}', 'log.csv', entries=placed)


def row(number, name, error, drawn='log', draw=0, **more):
    return {
        'ship': number,
        'clock': 'made',
        'passage': name,
        'drawn': drawn,
        'draw': draw,
        'raw_error_nmi': 2.0 * error,
        'error_nmi': error,
        'sensed_error_nmi': 0.1 * error,
        'noon_error_nmi': [0.0, error],
        'noon_raw_error_nmi': [0.0, error],
        'stopped_s': None,
        'failure': None,
        **more,
    }


def sailed(passages, rows, **draws):
    rules = Rules((CLOCK,), 0, 14.0)
    return SailedTrial(Trial('log.csv', rules, tuple(passages), **draws), rows)


def test_shares_count_those_that_failed_or_stopped_as_outside():
    passages = [passage(k) for k in range(10)]
    errors = [-5.0, 29.9, 30.0, -30.1, 39.0, 59.0, 61.0, 300.0, 1.0, 2.0]
    rows = [row(k, each.name, errors[k]) for k, each in enumerate(passages)]
    rows[8]['stopped_s'] = 1e6
    rows[9] = row(9, passages[9].name, 0.0, failure='the thread broke', raw_error_nmi=None)
    rows[9] |= {'error_nmi': None, 'sensed_error_nmi': None}
    found = answers_of(sailed(passages, rows)).clocks[0]
    prizes = found.ways['corrected'].prizes
    assert [each.passages for each in prizes] == [3, 5, 6]
    assert [each.pounds for each in prizes] == [20_000, 15_000, 10_000]
    assert prizes[0].low < prizes[0].share == 0.3 < prizes[0].high
    assert (found.stopped, found.failures) == (1, {'the thread broke': 1})
    assert [each.passages for each in found.ways['raw'].prizes] == [1, 1, 3]


def test_the_navigators_own_error_counts_as_chance_has_it():
    """By Monte Carlo: a normal error of 4 s in local time, 1 nmi at the equator, half at 60°."""
    passages = [passage(k, latitude=latitude) for k, latitude in enumerate((0.0, 0.0, 60.0, 60.0))]
    errors = np.array([29.5, 31.0, 29.5, -30.2])
    rows = [row(k, each.name, errors[k]) for k, each in enumerate(passages)]
    found = answers_of(sailed(passages, rows), 4.0).clocks[0].ways['corrected'].prizes[0]
    sigmas = np.array([1.0, 1.0, 0.5, 0.5])
    chance = errors + sigmas * np.random.default_rng(1).standard_normal((400_000, 4))
    share = np.mean(np.abs(chance) <= 30.0)
    assert found.share == 0.5
    # the standard error of 1.6 million draws is 4e-4
    assert found.with_local_time == pytest.approx(share, abs=2e-3)
    none = answers_of(sailed(passages, rows), 0.0).clocks[0].ways['corrected'].prizes[0]
    assert none.with_local_time == none.share


def test_the_plus_minus_is_by_how_much_the_share_changes():
    passages = [passage(k) for k in range(4)]
    rows = [
        row(k, each.name, error)
        for k, (each, error) in enumerate(zip(passages, [1, 2, 50, 70], strict=True))
    ]
    # the first draw brings one more within 30 miles, the second loses both
    for draw, errors in ((1, [1, 2, 29, 70]), (2, [31, 32, 50, 70])):
        rows += [
            row(10 * draw + k, each.name, errors[k], 'wind', draw)
            for k, each in enumerate(passages)
        ]
    rows += [row(50 + k, each.name, 50.0, 'hull', 1) for k, each in enumerate(passages)]
    found = answers_of(sailed(passages, rows, wind_draws=2)).clocks[0].ways['corrected']
    assert found.prizes[0].share == 0.5
    assert found.prizes[0].wind == pytest.approx(math.sqrt((0.25**2 + 0.5**2) / 2))
    assert found.prizes[0].hull == 0.5
    assert found.wind_nmi == pytest.approx(np.median([0, 0, 21, 0, 30, 30, 0, 0]))
    assert found.hull_nmi == pytest.approx(np.median([49, 48, 0, 20]))


def test_short_passages_are_not_judged_and_parts_add_up():
    passages = [
        passage(0, days=30),
        passage(1, month=1, latitude=40.0),
        passage(2, month=6, latitude=40.0),
        passage(3, month=6, latitude=-40.0, longitude=60.0),
    ]
    rows = [row(k, each.name, 10.0 * (k + 1)) for k, each in enumerate(passages)]
    found = answers_of(sailed(passages, rows))
    assert (found.passages, found.judged) == (4, 3)
    way = found.clocks[0].ways['corrected']
    assert [(each.name, each.passages, each.within) for each in way.seasons] == [
        ('December to February', 1, [1, 1, 1]),
        ('June to August', 2, [1, 2, 2]),
    ]
    assert [(each.name, each.median_nmi) for each in way.oceans] == [
        ('Indian Ocean', 40.0),
        ('North Atlantic', 25.0),
    ]
    # cut to three weeks at sea there is no verdict
    cut = sailed(passages, rows)
    rules = replace(cut.trial.rules, longest_s=35 * 86400.0)
    short = answers_of(SailedTrial(replace(cut.trial, rules=rules), rows))
    assert (short.judged, short.clocks[0].ways['raw'].prizes) == (0, [])
    assert short.clocks[0].ways['corrected'].quantiles_nmi is not None


def test_ships_in_company_have_the_difference_of_their_logs():
    one, beside = passage(1), passage(2, latitude=0.2)
    apart = passage(3, latitude=3.0)
    later = passage(4, month=7)
    passages = [one, beside, apart, later]
    rows = [row(k, each.name, 0.0) for k, each in enumerate(passages)]
    for k, each in enumerate(rows):
        each['noon_error_nmi'] = [float(day * (k + 1)) for day in range(50)]
        each['noon_raw_error_nmi'] = [0.0] * 50
    [company] = answers_of(sailed(passages, rows)).companies
    assert company.passages == (one.name, beside.name)
    assert company.days == 50
    assert company.differ_nmi == {'made': {'raw': 0.0, 'corrected': 49.0 - 98.0}}
