"""Numerical stability: the rows of `make stress` that are quick."""

from importlib import import_module
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).resolve().parents[3] / 'benchmarks'


@pytest.mark.parametrize(
    ('module', 'table', 'asked'),
    [
        # enough lags for the exponent within 0.15 of a half
        ('stress_motion', 'isochronous', (2e4, 3)),
        ('stress_motion', 'escapement', ()),
        ('stress_motion', 'resonance', ()),
        # random scenes run the same in chunks, or are refused in words
        ('stress_search', 'search', (10, 1)),
    ],
)
def test_every_row_holds(module, table, asked, monkeypatch):
    """The modules of the table import each other by name."""
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    rows = getattr(import_module(module), table)(*asked)
    assert rows
    assert not [f'{row.name} ({row.setting}): {row.measured}' for row in rows if not row.holds]
