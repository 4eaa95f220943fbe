"""Renew what commands print in the pages: python docs/outputs.py [--clocks] [--passage].

A comment `<!-- output: COMMAND -->` is followed by an indented block, what COMMAND prints. A
comment `<!-- clocks: COMMAND -->` is followed by the table of a comparison, a comment
`<!-- passage: COMMAND -->` by the table of what navigators make of one voyage. Their voyages take
nine and six minutes of processor time, so they are made anew only when asked for.
"""

from __future__ import annotations

import argparse
import json
import re
import shlex
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from tauto_core.cli.app import app
from tauto_core.wording import figure, to_sigma

PAGES = [
    Path(__file__).parent / f'{each}.md'
    for each in ('tutorial', 'howto/compare', 'theory/rate', 'sully_1724', 'altitudes')
]
BLOCK = re.compile(r'(<!-- output: tauto (.*?) -->\n\n)((?:(?:    .*)?\n)+?)(?=\S)')
TABLE = re.compile(r'(<!-- clocks: tauto (.*?) -->\n\n)((?:\|.*\n)+)')
PASSAGE = re.compile(r'(<!-- passage: tauto (.*?) -->\n\n)((?:\|.*\n)+)')

CLOCKS = {
    'clock_cheek_weight': 'circular cheek, weight',
    'clock_involute_weight': "Euler's involute, weight",
    'clock_own_cam_weight': "cam made for the weight's inertia",
    'clock_second_cam_force': "Euler's second cam, far-stretched steel spring",
    'clock_own_cam_spring': 'cam made for a spring, compensated for heat',
    'clock_hanging_thread': 'involute, weight on half a metre of swinging thread',
    'clock_sully_lever': "Sully's lever as Euler reports it",
    'clock_own_cam_lever': "Sully's lever, cam made for it",
}
HEADINGS = (
    'clock',
    'rate at sea, s/day',
    'by the dial, nmi off',
    'the Act of 1714 pays',
    'rated in port, nmi off',
    'the Act pays',
)


EQUATION = 'drift.covariates=[heave, roll, gravity, temperature, temperature_squared]'
NAVIGATORS = {
    'nothing: the dial as set': ('raw_', ()),
    'the rate found in port': ('', ()),
    'the rate equation': ('', (EQUATION,)),
    'the rate equation, and a lunar distance a day': ('', (EQUATION, 'drift.lunars={}')),
}
"""What each allows for: whose error of the result it is, and what is set in the scene."""
LANDFALLS = ('Madeira', 'Jamaica')


def printed(command: str) -> str:
    """Return what a command prints, indented as code, without blanks at the ends of lines."""
    return ''.join(f'    {line}'.rstrip() + '\n' for line in _stdout(command).splitlines()) + '\n'


def clocks_table(command: str) -> str:
    """Return the table of a comparison in Markdown, one row for each clock."""
    rows = json.loads(_stdout(f'{command} --json'))['rows']
    lines = [HEADINGS, ('---',) * len(HEADINGS), *map(_cells, rows)]
    return ''.join(f'| {" | ".join(cells)} |\n' for cells in lines)


def passage_table(command: str) -> str:
    """Return what each navigator makes of a voyage in Markdown, one row each."""
    sailed = {
        given: json.loads(_stdout(command, '--json', *(f'--set={each}' for each in given)))
        for _, given in NAVIGATORS.values()
    }
    columns = [name for place in LANDFALLS for name in (f'miles off at {place}', 'his *σ*')]
    lines = [('what the navigator allows for', *columns), ('---',) * (1 + len(columns))]
    for name, (kind, given) in NAVIGATORS.items():
        cells = [name]
        for landfall in sailed[given]['longitude']['landfalls']:
            error, sigma = abs(landfall[f'{kind}error_nmi']), landfall['sigma_nmi']
            if kind:
                cells += [figure(error, 'nmi'), '–']
            else:
                cells += [to_sigma(error, sigma), to_sigma(sigma, sigma)]
        lines.append(tuple(cells))
    return ''.join(f'| {" | ".join(cells)} |\n' for cells in lines)


def renewed(text: str, *, clocks: bool = False, passage: bool = False) -> str:
    """Return a page with each block as its command prints it now, and the tables asked for."""
    text = BLOCK.sub(lambda found: found[1] + printed(found[2]), text)
    if clocks:
        text = TABLE.sub(lambda found: found[1] + clocks_table(found[2]), text)
    if passage:
        text = PASSAGE.sub(lambda found: found[1] + passage_table(found[2]), text)
    return text


def _stdout(command: str, *arguments: str) -> str:
    run = CliRunner().invoke(app, [*shlex.split(command), *arguments])
    assert run.exit_code == 0, run.stderr
    return run.stdout


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    return (
        CLOCKS[row['clock']],
        figure(row['rate_s_per_day'], 's/day', signed=True),
        figure(abs(row['raw_error_nmi']), 'nmi'),
        _pounds(row['raw_prize_pounds']),
        figure(abs(row['error_nmi']), 'nmi'),
        _pounds(row['prize_pounds']),
    )


def _pounds(prize: int | None) -> str:
    return '–' if prize is None else f'£{prize:,}'


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description='Renew what commands print in the pages.')
    parser.add_argument('--clocks', action='store_true', help='the table of the clocks, too')
    parser.add_argument('--passage', action='store_true', help='the table of the passage, too')
    asked = vars(parser.parse_args())
    for page in PAGES:
        page.write_text(renewed(page.read_text('utf-8'), **asked), 'utf-8')
