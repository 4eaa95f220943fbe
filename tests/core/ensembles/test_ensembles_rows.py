"""Rows come back as they went in, and take a tenth of the memory of their mappings."""

import tracemalloc

import pytest

from tauto_core.ensembles.rows import FIGURES, Rows

MIXED = [
    {'ship': 2, 'seed': 2**63 - 1, 'error': -0.1, 'failure': None, 'day': None},
    {'ship': 0, 'seed': 7, 'error': None, 'failure': None, 'day': [1.5, None]},
    {'ship': 1, 'seed': 8, 'error': 1e-300, 'failure': 'slack', 'day': []},
]


def typed(rows):
    return [{name: (type(value), value) for name, value in row.items()} for row in rows]


def test_rows_are_what_was_put_in():
    rows = Rows(MIXED)
    assert len(rows) == 3
    assert typed(rows) == typed(MIXED)
    assert typed([rows[1], rows[-1]]) == typed([MIXED[1], MIXED[-1]])
    assert typed(rows[1:]) == typed(MIXED[1:])
    rows.sort()
    assert typed(rows) == typed([MIXED[1], MIXED[2], MIXED[0]])
    assert list(Rows()) == []


def test_a_column_is_that_of_the_rows():
    rows = Rows(MIXED)
    for name in MIXED[0]:
        assert typed([{name: value} for value in rows.column(name)]) == typed(
            [{name: row[name]} for row in MIXED]
        )
    assert Rows().column('ship') == []


def test_a_row_of_other_names_is_refused():
    with pytest.raises(ValueError, match='after rows of'):
        Rows(MIXED).extend([{'ship': 3}])


def test_a_million_ships_fit():
    """Of 10,000 ships as they arrive: below 400 bytes a ship, which is 0.4 GB for a million."""
    count = 10_000

    def one(number):
        figures = {name: 1.0 / (number + place) for place, name in enumerate(FIGURES, 1)}
        figures |= {'stopped_s': None, 'raw_prize_pounds': None, 'prize_pounds': 20_000}
        own = {'ship': number, 'seed': 2**62 + number, 'drawn': 0.5 + number}
        return own | figures | {'failure': None, 'run_s': 0.1 * number}

    tracemalloc.start()
    try:
        before, _ = tracemalloc.get_traced_memory()
        rows = Rows(map(one, range(count)))
        after, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert rows[count - 1] == one(count - 1)
    assert (after - before) / count < 400.0
    assert (most - before) / count < 500.0  # no other objects of their size exist on the way
