"""Rows come back from a folder as they went in, also if their process was killed."""

from contextlib import ExitStack

import pytest

from tauto_core.ensembles.rows import FleetError, read_rows, stored

MIXED = [
    {'ship': 0, 'seed': 7, 'error': None, 'failure': None, 'day': [1.5, None]},
    {'ship': 1, 'seed': 8, 'error': 1e-300, 'failure': 'slack', 'day': []},
    {'ship': 2, 'seed': 2**63 - 1, 'error': -0.1, 'failure': None, 'day': None},
]
COLUMNS = {'ship': int, 'seed': int, 'error': float, 'failure': str, 'day': list}


def typed(rows):
    return [{name: (type(value), value) for name, value in row.items()} for row in rows]


def test_rows_are_what_was_put_in(tmp_path):
    part = tmp_path / 'ships' / '0000000.json'
    killed = ExitStack()
    _, add = killed.enter_context(stored(tmp_path, {}, COLUMNS))
    add(MIXED[2:])
    with pytest.raises(KeyboardInterrupt), killed:
        raise KeyboardInterrupt
    assert typed(read_rows(tmp_path)) == typed(MIXED[2:])
    with stored(tmp_path, {}, COLUMNS) as (rows, add):
        assert typed(rows) == typed(MIXED[2:])
        add(MIXED[:2])
        written = part.read_bytes()
    assert typed(read_rows(tmp_path)) == typed(MIXED)
    assert sorted(file.name for file in tmp_path.iterdir()) == ['fleet.yaml', 'ships.parquet']
    part.parent.mkdir()
    part.write_bytes(written)  # killed before it was removed
    assert typed(read_rows(tmp_path)) == typed(MIXED)
    part.write_bytes(b'?')
    with pytest.raises(FleetError, match=r'0000000\.json: cannot be read'):
        read_rows(tmp_path)
