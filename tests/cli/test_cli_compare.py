"""`tauto compare` from the command line."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from command_line import invoke, run

from tauto_core.cli.tables import comparison_table, failures
from tauto_core.ensembles import rows as stored
from tauto_core.ensembles.comparison import Comparison, Row, Stop
from tauto_core.ensembles.workers import Ended, WorkerError
from tauto_core.files import write_figure
from tauto_core.plots.ensembles import comparison_figure

# one closed form in two seas: the whole path without a kernel that must be compiled
CHEAP = ('compare', 'second_cam_at_sea', '--duration', '600', '--jobs', '1')


def row(clock: str, hung: bool, roll_deg: float, **changes: Any) -> Row:
    return replace(Row(clock, clock, hung, roll_deg, **FIGURES), **changes)


RATES = {'rate_s_per_day': -60.0, 'rate_spread_s_per_day': 3.0, 'error_s': -120.0}
ERRORS = {'raw_error_nmi': 29.0, 'error_nmi': -45.0}
PRIZES = {'raw_prize_pounds': 20_000, 'prize_pounds': 10_000}
TRACE = {'time_s': [0.0, 86_400.0, 172_800.0], 'trace_s': [0.0, -60.0, -120.0]}
FIGURES: dict[str, Any] = {'release': 1.0, 'propagator': 'collocation', 'stopped': None}
FIGURES |= {'run_s': 1.0, **RATES, **ERRORS, **PRIZES, **TRACE}
STOPPED: dict[str, Any] = {
    **dict.fromkeys(('rate_s_per_day', 'error_s', *ERRORS, *PRIZES)),
    'stopped': Stop(100_000.0, 'at t = 100000.000 s: the thread goes slack'),
    'time_s': [0.0, 86_400.0],
    'trace_s': [0.0, -60.0],
}


def test_json_is_one_object() -> None:
    # the roll follows from a hull, but can be chosen for a ship of harmonics
    found = json.loads(run(*CHEAP, '--ship-of', 'cheek_before_euler', '--roll', '0,20', '--json'))
    assert found['duration_s'] == 600.0
    assert [row['roll_deg'] for row in found['rows']] == pytest.approx([0.0, 20.0])
    still, rolling = (row['trace_s'] for row in found['rows'])
    # Euler's second cam is linear: the roll shakes the readings and leaves no drift
    # (machine_at_sea.md)
    assert max(map(abs, still)) < 1e-9
    assert 1e-5 < max(map(abs, rolling)) < 0.1


def test_the_table_fits_a_narrow_terminal() -> None:
    rows = [row('clock_second_cam_force', hung, 10.0) for hung in (False, True)]
    text = comparison_table(
        Comparison(172_800.0, 1800.0, 1.0, [*rows, row('b', True, 10.0, **STOPPED)])
    )
    assert '2 days in the same sea, released at 1 rad' in text
    line = next(line for line in text.splitlines() if 'second cam force' in line)
    said = 'second cam force fixed −60.0 3.00 −120.0 +29.0 −45.0 20,000 10,000'
    assert line.split() == said.split()
    assert max(map(len, text.splitlines())) <= 80
    assert 'stopped' in text
    assert 'roll' not in text
    two = comparison_table(Comparison(60.0, 1.0, 1.0, [row('a', False, x) for x in (5.0, 20.0)]))
    assert 'roll' in two
    assert ' 20.0 ' in two


def test_the_prizes_of_a_long_voyage_are_not_cut_off() -> None:
    """The longest numbers that the eight clocks have after 81 days."""
    small = {'rate_s_per_day': 3.346e-4, 'rate_spread_s_per_day': 3.7e-4, 'error_s': 0.02743}
    ends = {'raw_error_nmi': -0.006526, 'error_nmi': 10.18, 'prize_pounds': 20_000}
    long = row('clock_second_cam_force', False, 5.0, **small, **ends)
    text = comparison_table(Comparison(7_084_740.0, 1800.0, 1.0, [long]))
    line = next(line for line in text.splitlines() if 'second cam force' in line)
    said = '<0.001 <0.001 +0.027 <0.01 +10.2 20,000 20,000'
    assert line.split()[-7:] == said.split()
    assert '…' not in text


def test_a_short_run_has_no_column_of_prizes_and_says_why() -> None:
    unpaid = {'raw_prize_pounds': None, 'prize_pounds': None}
    text = comparison_table(Comparison(60.0, 1.0, 1.0, [row('a', False, 5.0, **unpaid)]))
    assert '£' not in text.partition('rate:')[0]
    assert 'six weeks' in ' '.join(text.split())


def test_a_failure_is_reported_once() -> None:
    rows = [row('a', True, roll, **STOPPED) for roll in (10.0, 20.0)]
    told = failures(Comparison(60.0, 1.0, 1.0, [*rows, row('b', False, 10.0)]))
    assert told == ['a, hung: at t = 100000.000 s: the thread goes slack']


def test_the_figure_is_the_same_each_time(tmp_path: Path) -> None:
    rows = [row(clock, hung, roll) for clock in 'ab' for hung in (False, True) for roll in (5, 9)]
    for name, some in (('rolls', rows), ('errors', [*rows[:1], row('c', True, 5, **STOPPED)])):
        result = Comparison(172_800.0, 1800.0, 1.0, some)
        files = [tmp_path / f'{name}{k}.svg' for k in range(2)]
        for file in files:
            write_figure(partial(comparison_figure, result), file)
        first, second = (file.read_bytes() for file in files)
        assert first == second
        assert first.lstrip().startswith(b'<?xml')


def test_the_figure_shows_the_limits_of_the_act_if_it_judges() -> None:
    unpaid = {'raw_prize_pounds': None, 'prize_pounds': None}
    for some, bands in ((row('a', False, 5.0), 1), (row('a', False, 5.0, **unpaid), 0)):
        figure = comparison_figure(Comparison(172_800.0, 1800.0, 1.0, [some]))
        assert len(figure.axes[0].patches) == bands
        named = [text.get_text() for text in figure.legends[0].get_texts()]
        assert ('within 30 miles at the equator' in named) == bool(bands)


def test_a_clock_whose_processes_died_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    lost: Ended[Row] = Ended(0, None, WorkerError('its process died four times'))
    monkeypatch.setattr(stored, 'run_each', lambda *_: (each for each in [lost]))
    result = invoke(*CHEAP)
    assert (result.exit_code, result.stdout) == (1, '')
    assert 'second_cam_at_sea: its process died four times' in result.stderr
