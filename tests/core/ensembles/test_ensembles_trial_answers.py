"""Shares and intervals of a trial against figures worked out by hand."""

from tauto_core.ensembles.answers import answers_of
from tauto_core.ensembles.trials import Trial, TriedClock
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


def row(number, name, error, **more):
    return {
        'ship': number,
        'clock': 'made',
        'passage': name,
        'raw_error_nmi': 2.0 * error,
        'error_nmi': error,
        'sensed_error_nmi': 0.1 * error,
        'noon_error_nmi': [0.0, error],
        'stopped_s': None,
        'failure': None,
        **more,
    }


def trial(passages, **more):
    return Trial('log.csv', (CLOCK,), 0, 14.0, passages=tuple(passages), **more)


def test_shares_count_those_that_failed_or_stopped_as_outside():
    passages = [passage(k) for k in range(10)]
    errors = [-5.0, 29.9, 30.0, -30.1, 39.0, 59.0, 61.0, 300.0, 1.0, 2.0]
    rows = [row(k, each.name, errors[k]) for k, each in enumerate(passages)]
    rows[8]['stopped_s'] = 1e6
    rows[9] = row(9, passages[9].name, 0.0, failure='the thread broke', raw_error_nmi=None)
    rows[9] |= {'error_nmi': None, 'sensed_error_nmi': None}
    found = answers_of(trial(passages), rows).clocks[0]
    prizes = found.ways['corrected'].prizes
    assert [each.passages for each in prizes] == [3, 5, 6]
    assert [each.pounds for each in prizes] == [20_000, 15_000, 10_000]
    assert prizes[0].low < prizes[0].share == 0.3 < prizes[0].high
    assert (found.stopped, found.failures) == (1, {'the thread broke': 1})
    assert [each.passages for each in found.ways['raw'].prizes] == [1, 1, 3]


def test_short_passages_are_not_judged_and_parts_add_up():
    passages = [
        passage(0, days=30),
        passage(1, month=1, latitude=40.0),
        passage(2, month=6, latitude=40.0),
        passage(3, month=6, latitude=-40.0, longitude=60.0),
    ]
    rows = [row(k, each.name, 10.0 * (k + 1)) for k, each in enumerate(passages)]
    found = answers_of(trial(passages), rows)
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
    short = answers_of(trial(passages, longest_s=35 * 86400.0), rows)
    assert (short.judged, short.clocks[0].ways['raw'].prizes) == (0, [])
    assert short.clocks[0].ways['corrected'].quantiles_nmi is not None
