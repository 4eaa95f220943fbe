"""The weather as a table on a terminal."""

import re
from typing import Any

from tauto_core.cli.tables import ROWS, weather_table, weather_words


def weather(count: int) -> dict[str, Any]:
    names = ('significant_wave_height_m', 'peak_period_s', 'heading_rad', 'speed_m_s', 'at_s')
    rows = [(1.0 + 0.1 * k, 8.0, 6.0 if k % 2 else 0.5, 1.5, 21_600.0 * k) for k in range(count)]
    calm = (0.0, None, None, None, 0.0)
    states = [dict(zip(names, row, strict=True)) for row in [calm, *rows[1:]]]
    facts = {'kind': 'climate', 'seed': 7, 'seas_at_once': 1.85, 'highest_m': 5.0, 'median_m': 2.0}
    return {**facts, 'states': states}


def printed(count: int) -> list[str]:
    return [line for line in weather_table(weather(count)).splitlines() if re.match(r' *\d', line)]


def test_a_few_states_have_a_row_each_and_a_calm_has_dashes():
    rows = [re.split(' {2,}', line.strip()) for line in printed(3)]
    assert rows == [
        ['0.00', '0.00', '–', '–', '–'],
        ['0.25', '1.10', '8.0', '−16', '1.50'],
        ['0.50', '1.20', '8.0', '29', '1.50'],
    ]


def test_many_states_share_rows_as_ranges():
    rows = [re.split(' {2,}', line.strip()) for line in printed(10 * ROWS)]
    assert len(rows) == ROWS
    assert rows[1] == ['2.50', '2.00 to 2.90', '8.0', '−16 to 29', '1.50']


def test_a_line_says_what_it_is_made_of():
    said = weather_words(weather(3))
    assert said.startswith('climate, 3 states, Hs 2 m in the median, 5 m at most, seed 7')
    record = {**weather(3), 'source': 'buoy.txt', 'gaps_bridged': 2}
    assert weather_words(record).startswith('buoy.txt, 3 states')
    assert weather_words(record).endswith('2 gaps bridged')
