"""Numerical stability: the rows of `make stress` that are quick."""

from importlib import import_module
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).resolve().parents[3] / 'benchmarks'


@pytest.mark.parametrize(
    ('table', 'asked'),
    [
        ('order', ()),
        ('reversal', (30,)),
        # enough lags for the exponent within 0.15 of a half
        ('isochronous', (2e4, 3)),
        ('escapement', ()),
        ('resonance', ()),
    ],
)
def test_every_row_holds(table, asked, monkeypatch):
    """The modules of the table import each other by name."""
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    rows = getattr(import_module('stress_motion'), table)(*asked)
    assert rows
    assert not [f'{row.name} ({row.setting}): {row.measured}' for row in rows if not row.holds]
