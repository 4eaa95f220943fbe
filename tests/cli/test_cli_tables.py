"""The tables: sides, signs, what is absent."""

from __future__ import annotations

from io import StringIO
from typing import Any

import pytest
from rich.console import Console

from tauto_core.cli.tables import replay_table, span, voyage_table

RESULT: dict[str, Any] = {
    'scene': 'h4',
    'duration_s': 7_000_000.0,
    'trochlea': {'period_s': 1.0},
    'clock': {'reading_s': 6_999_994.9, 'error_s': -5.1, 'rate_s_per_day': -0.0629},
    'drift': {
        'offset_s': -5.0,
        'offset_sigma_s': 0.4,
        'rate_s_per_day': 0.25,
        'rate_sigma_s_per_day': 0.01,
    },
    'longitude': {
        'raw_error_arcmin': 1.275,
        'raw_error_nmi': 1.2126,
        'error_arcmin': -0.025,
        'error_nmi': -0.02378,
        'sigma_nmi': 0.0951,
        'prize_pounds': 20000,
    },
    'bag': 'bags/out/h4',
}


def rows(table: Any) -> dict[str, str]:
    """Return the table as it is printed: label to value."""
    out = StringIO()
    Console(file=out, width=120).print(table)
    cells = [line.split('│') for line in out.getvalue().splitlines() if line.count('│') == 3]
    return {label.strip(): value.strip() for _, label, value, _ in cells}


def test_a_slow_clock_puts_the_ship_east() -> None:
    said = rows(voyage_table(RESULT))
    assert said['clock error'] == '5.100000 s slow'
    assert said['longitude error, raw'] == '1.2750 arcmin = 1.2126 nmi east'
    assert said['longitude error, corrected'] == '0.0250 arcmin = 0.0238 nmi west'
    assert said['the Act of 1714 pays'] == '£20,000'
    assert said['drift: offset estimated'] == '-5.000000 ± 0.400000 s'
    assert said['drift: rate estimated'] == '+0.250000 ± 0.010000 s/day'
    assert said['bag'] == 'bags/out/h4'


def test_the_verdict_names_landfall_and_worst_moment() -> None:
    landfall = {
        **RESULT['longitude'],
        'at_s': 95.0 * 86_400.0,
        'raw_prize_pounds': 15000,
        'unchecked_days': 81.0,
        'required_rate_s_per_day': 1.5571,
    }
    madeira = {**landfall, 'at_s': 20.0 * 86_400.0, 'raw_error_nmi': -41.5, 'raw_prize_pounds': 0}
    worst = {
        'worst_error_nmi': 2.5,
        'worst_at_s': 50.0 * 86_400.0,
        'worst_prize_pounds': 20000,
        'worst_raw_error_nmi': 61.0,
        'worst_raw_at_s': 7200.0,
        'worst_raw_prize_pounds': 0,
    }
    longitude = {**landfall, **worst, 'landfalls': [madeira, landfall]}
    said = rows(voyage_table({'longitude': longitude}))
    assert said['judged'] == 'at the landfall, after 95 days'
    assert said['the Act of 1714 pays'] == '£20,000'
    assert said['… for the raw clock'] == '£15,000'
    assert said['worst on the way, raw'] == '61.0000 nmi after 2 hours: £0'
    assert said['worst on the way, corrected'] == '2.5000 nmi after 50 days: £20,000'
    assert said['landfall after 20 days'] == ('raw 41.5000 nmi: £0; corrected 0.0238 nmi: £20,000')
    assert said['rate for £20,000 after 81 days unchecked'] == 'within 1.557 s/day'
    unjudged = {**longitude, 'landfalls': [], 'required_rate_s_per_day': None}
    said = rows(voyage_table({'longitude': unjudged}))
    assert said['judged'] == 'after 95 days'
    assert not any('unchecked' in label for label in said)


def test_no_side_is_named_where_nothing_is_left_to_print() -> None:
    said = rows(voyage_table({**RESULT, 'clock': {'error_s': -1e-9, 'rate_s_per_day': 0.0}}))
    assert said['clock error'] == '0.000000 s'


def test_absent_sections_give_no_rows_and_absent_values_a_dash() -> None:
    assert rows(voyage_table({'scene': 'x', 'clock': {}, 'drift': None})) == {}
    unknown = dict.fromkeys(RESULT['longitude'])
    said = rows(voyage_table({'longitude': unknown}))
    assert said['the Act of 1714 pays'] == '–'


def test_a_replay_also_counts_messages() -> None:
    said = rows(replay_table({**RESULT, 'counts': {'clock/reading': 61}}))
    assert said['messages on clock/reading'] == '61'


@pytest.mark.parametrize(
    ('seconds', 'said'),
    [(60.0, '60 seconds'), (600.0, '10 minutes'), (8_207_940.0, '95 days')],
)
def test_span_uses_the_unit_a_reader_would(seconds: float, said: str) -> None:
    assert span(seconds) == said
