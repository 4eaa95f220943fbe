"""The examples of the documentation run, each in a folder of its own, and are short."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from modules import run_program

DOCS = Path(__file__).parents[1] / 'docs'
EXAMPLES = sorted((DOCS / 'examples').glob('*.py'))
WRITTEN = {
    'bag': ['voyage_bag'],
    'cam': ['cam.csv'],
    'compare': [],
    'plot': ['error.png', 'machine.svg', 'own.png'],
    'sail': [],
}


@pytest.mark.parametrize('example', EXAMPLES, ids=lambda file: file.stem)
def test_it_runs_and_writes_what_it_says(example: Path, tmp_path: Path) -> None:
    environment = {**os.environ, 'MPLBACKEND': 'agg'}
    run = run_program(sys.executable, '-W', 'error', example, cwd=tmp_path, env=environment)
    assert run.returncode == 0, run.stderr
    assert sorted(file.name for file in tmp_path.iterdir()) == WRITTEN[example.stem]
    assert run.stdout or WRITTEN[example.stem]


def test_they_are_short_and_a_page_leads_to_each() -> None:
    assert len(EXAMPLES) == len(WRITTEN)
    index = (DOCS / 'howto' / 'python.md').read_text(encoding='utf-8')
    for example in EXAMPLES:
        assert len(example.read_text(encoding='utf-8').splitlines()) < 30
        assert f'(../examples/{example.name})' in index


def test_the_fleets_of_several_clocks_are_compared(tmp_path: Path) -> None:
    """The command of docs/which_clock.md, for two ships that hardly leave their moorings."""
    figure = tmp_path / 'which_clock.svg'
    few = ('--ships', '2', '--jobs', '1', '--part', '0.001', '--plot', figure)
    run = run_program(sys.executable, DOCS / 'img' / 'which_clock.py', *few)
    assert run.returncode == 0, run.stderr
    rows = run.stdout.splitlines()
    assert [row.count('100 % (34–100)') for row in rows[2:]] == [3] * 6
    assert figure.stat().st_size > 5000
