"""Renew what commands print in the README: python docs/outputs.py [--clocks].

A comment `<!-- output: COMMAND -->` is followed by an indented block, what COMMAND prints. A
comment `<!-- clocks: COMMAND -->` is followed by the table of a comparison; the voyages of that
table take nine minutes of processor time, so it is made anew only with `--clocks`.
"""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from tauto_core.cli.app import app
from tauto_core.wording import significant

README = Path(__file__).parents[1] / 'README.md'
BLOCK = re.compile(r'(<!-- output: tauto (.*?) -->\n\n)((?:(?:    .*)?\n)+?)(?=\S)')
TABLE = re.compile(r'(<!-- clocks: tauto (.*?) -->\n\n)((?:\|.*\n)+)')

CLOCKS = {
    'clock_cheek_weight': 'circular cheek, weight',
    'clock_involute_weight': "Euler's involute, weight",
    'clock_own_cam_weight': "cam made for the weight's inertia",
    'clock_second_cam_force': "Euler's second cam, steady force",
    'clock_own_cam_spring': 'cam made for a spring',
    'clock_hanging_thread': 'involute, weight on half a metre of swinging thread',
    'clock_sully_lever': "Sully's lever",
    'clock_own_cam_lever': "Sully's lever, cam made for it",
}
HEADINGS = (
    'clock',
    'rate at sea, s/day',
    'by the dial, nmi off',
    'the Act of 1714 pays',
    'rated in that sea, nmi off',
    'the Act pays',
)


def printed(command: str) -> str:
    """Return what a command prints, indented as code, without blanks at the ends of lines."""
    return ''.join(f'    {line}'.rstrip() + '\n' for line in _stdout(command).splitlines()) + '\n'


def clocks_table(command: str) -> str:
    """Return the table of a comparison in Markdown, one row for each clock."""
    rows = json.loads(_stdout(f'{command} --json'))['rows']
    lines = [HEADINGS, ('---',) * len(HEADINGS), *map(_cells, rows)]
    return ''.join(f'| {" | ".join(cells)} |\n' for cells in lines)


def renewed(text: str, *, clocks: bool = False) -> str:
    """Return a page with each block as its command prints it now, with `clocks` tables too."""
    text = BLOCK.sub(lambda found: found[1] + printed(found[2]), text)
    return TABLE.sub(lambda found: found[1] + clocks_table(found[2]), text) if clocks else text


def _stdout(command: str) -> str:
    run = CliRunner().invoke(app, command.split())
    assert run.exit_code == 0, run.stderr
    return run.stdout


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    return (
        CLOCKS[row['clock']],
        significant(row['rate_s_per_day'], 4, signed=True),
        significant(abs(row['raw_error_nmi'])),
        _pounds(row['raw_prize_pounds']),
        significant(abs(row['error_nmi'])),
        _pounds(row['prize_pounds']),
    )


def _pounds(prize: int | None) -> str:
    return '–' if prize is None else f'£{prize:,}'


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description='Renew what commands print in the README.')
    parser.add_argument('--clocks', action='store_true', help='the table of the clocks, too')
    page = renewed(README.read_text(encoding='utf-8'), clocks=parser.parse_args().clocks)
    README.write_text(page, encoding='utf-8')
