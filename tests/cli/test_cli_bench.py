"""`tauto bench` as a user meets it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from tauto_core.cli.app import app

# one closed form: the whole path in a moment
CHEAP = ('bench', '--problem', 'a', '--peers', 'tauto', '--quick')


def tauto(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_json_is_one_object_and_the_rest_goes_to_stderr(tmp_path: Path) -> None:
    figure = tmp_path / 'figure.svg'
    result = tauto(*CHEAP, '--json', '--plot', figure)
    assert result.exit_code == 0
    (row,) = json.loads(result.stdout)['rows']
    assert (row['problem'], row['program'], row['duration_s']) == ('a', 'tauto', 81 * 86_400.0)
    assert 'a: tauto closed form' in result.stderr
    assert figure.read_text('utf-8').lstrip().startswith('<?xml')


def test_the_table_says_what_is_compared_and_what_is_needed() -> None:
    result = tauto(*CHEAP)
    assert result.exit_code == 0
    words = ' '.join(result.stdout.split())
    assert "a: Euler's second cam with a force, on land" in words
    assert 'heyoka 100000×' in words
    assert '81 d' in words


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (('--problem', 'z'), "problem 'z' is not known. Choose from a, b, c, d, e, f"),
        (('--peers', 'matlab'), "peer 'matlab' is not known. Choose from tauto, heyoka"),
        (('--plot', 'figure.jpg'), 'must end in .svg, .png or .pdf'),
        (('--plot', 'nowhere/figure.png'), 'there is no folder nowhere'),
    ],
)
def test_what_cannot_be_is_refused_before_anything_runs(
    arguments: tuple[str, ...], words: str
) -> None:
    result = tauto('bench', *arguments)
    assert result.exit_code == 2
    assert words in result.stderr
    assert result.stdout == ''
    assert 'tauto closed form' not in result.stderr
