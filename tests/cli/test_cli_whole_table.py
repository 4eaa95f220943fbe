"""Tables on narrow terminals: labels wrap, figures stay whole."""

from __future__ import annotations

import pytest
from rich.console import Console

from tauto_core.cli.tables import WholeTable


def shown(table: WholeTable, width: int) -> str:
    console = Console(width=width, color_system=None)
    with console.capture() as captured:
        console.print(table, crop=False)
    return captured.get()


def two_figures() -> WholeTable:
    table = WholeTable('worst, by the clock', box=None)
    table.add_column('error', no_wrap=True, justify='right')
    table.add_column('bound', no_wrap=True, justify='right')
    table.add_row('after five minutes', '−1,234.5 ± 0.678', '9,876,543')
    return table


@pytest.mark.parametrize('width', [10, 20, 30, 40, 50])
def test_no_figure_is_cut(width: int) -> None:
    said = shown(two_figures(), width)
    assert '−1,234.5 ± 0.678' in said
    assert '9,876,543' in said
    assert '…' not in said


def test_labels_wrap_between_words_as_far_as_that_helps() -> None:
    lines = shown(two_figures(), 44).splitlines()
    assert max(map(len, lines)) <= 44
    assert 'after five' in lines[2]
    assert lines[3].strip() == 'minutes'


def test_where_there_is_room_each_row_is_a_line() -> None:
    assert len(shown(two_figures(), 80).splitlines()) == 2


def test_a_column_that_folds_takes_what_is_left() -> None:
    table = WholeTable('key', box=None)
    table.add_column('text', overflow='fold')
    table.add_row('file', 'a/very/long/path/without/any/blank.csv')
    assert max(map(len, shown(table, 20).splitlines())) <= 20
