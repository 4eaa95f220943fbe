"""`python -m benchmarks.work_precision` from the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from benchmarks.work_precision import page as speed_page
from benchmarks.work_precision.__main__ import app
from tauto_core.scene.errors import UsageError

# one closed form: the whole path in a moment
CHEAP = ('--problem', 'a', '--peers', 'tauto', '--quick')


def bench(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_json_is_one_object_and_the_rest_goes_to_stderr(tmp_path: Path) -> None:
    figure = tmp_path / 'figure.svg'
    result = bench(*CHEAP, '--json', '--plot', figure)
    assert result.exit_code == 0
    (row,) = json.loads(result.stdout)['rows']
    assert (row['problem'], row['program'], row['duration_s']) == ('a', 'tauto', 81 * 86_400.0)
    assert 'a: tauto closed form' in result.stderr
    assert figure.read_text('utf-8').lstrip().startswith('<?xml')


def test_the_terminal_shows_the_table_of_the_page() -> None:
    result = bench(*CHEAP)
    assert result.exit_code == 0
    assert "| a, Euler's second cam with a force, on land (closed form) |" in result.stdout


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (('--problem', 'z'), "problem 'z' is not known. Choose from a, b, c, d, e, f"),
        (('--peers', 'matlab'), "peer 'matlab' is not known. Choose from tauto, heyoka"),
        (('--plot', 'figure.gif'), 'must end in .svg'),
        (('--plot', 'nowhere/figure.png'), 'there is no folder nowhere'),
    ],
)
def test_what_cannot_be_is_refused_before_anything_runs(
    arguments: tuple[str, ...], words: str
) -> None:
    result = bench(*arguments)
    assert isinstance(result.exception, UsageError)
    assert words in str(result.exception)
    assert result.stdout == ''
    assert 'tauto closed form' not in result.stderr


ROOT = Path(__file__).parents[2]
RESULT = ROOT / 'benchmarks' / 'work_precision.json'


def test_the_page_says_what_was_measured() -> None:
    """Put right by `python -m benchmarks.work_precision --show FILE --page docs/speed.md`."""
    result = json.loads(RESULT.read_text('utf-8'))
    assert speed_page.current(ROOT / 'docs' / 'speed.md') == speed_page.block(result)


def a_row(program: str, setting: str, us: float, setup_s: float) -> dict[str, object]:
    numbers = {'error_s_per_day': 1e-12, 'us_per_oscillation': us, 'setup_s': setup_s}
    return {'problem': 'b', 'program': program, 'setting': setting, **numbers}


def test_the_page_names_the_best_formulation_and_the_plain_one(tmp_path: Path) -> None:
    result = {
        'machine': {'processor': 'none', 'python': '3', 'date': '2026-01-01'},
        'rows': [
            a_row('tauto', 'closed form', 1e-4, 0.01),
            a_row('heyoka', '1e-16', 8.0, 0.0),
            a_row('heyoka_tuned', '1e-14', 3.0, 0.0),
        ],
        'first_runs': [{'problem': 'b', 'program': 'tauto', 'first_run_s': 4.25}],
    }
    page = tmp_path / 'page.md'
    page.write_text(f'before\n{speed_page.BEGIN}\nold\n{speed_page.END}\nafter\n', 'utf-8')
    speed_page.update(page, result)
    text = page.read_text('utf-8')
    assert text.startswith('before\n')
    assert text.endswith('after\n')
    # 81 days of a swing of 1.000084 s at 3 us take 21 s: 2,000 times 10 ms and a little
    assert '| 2,000× in 81 days with set-up, 30,000× without (1e-14) |' in text
    assert '| 80,000× | – | not reached | 4.2, – |' in text
    assert 'old' not in text


def test_a_page_without_marks_is_refused(tmp_path: Path) -> None:
    page = tmp_path / 'page.md'
    page.write_text('no marks', 'utf-8')
    with pytest.raises(UsageError, match='has no lines'):
        speed_page.update(page, {'rows': [], 'machine': {}})
