"""Output reaches any terminal: of another encoding, closed or full."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tauto_core.cli.app import app
from tauto_core.scene.loader import scene_text

NO_TEXT = os.fsdecode(b'b\xe4g')
"""A Latin-1 file name on a system with UTF-8 names."""


def tauto(
    *arguments: str, encoding: str = 'utf-8', stdout: int = subprocess.PIPE, **others: str
) -> subprocess.CompletedProcess[bytes]:
    """Run a command as a terminal of an encoding does, in a strict locale."""
    return subprocess.run(
        [sys.executable, '-m', 'tauto_core', *arguments],
        env={**os.environ, 'PYTHONIOENCODING': f'{encoding}:strict', **others},
        stdout=stdout,
        stderr=subprocess.PIPE,
        check=False,
    )


def in_process(*arguments: str) -> None:
    assert CliRunner().invoke(app, list(arguments)).exit_code == 0


@pytest.mark.parametrize('closed', ['>&-', '<&- >&- 2>&-'])
def test_streams_that_are_closed_do_no_harm(closed: str) -> None:
    command = f'{Path(sys.executable).with_name("tauto")} scene check ideal {closed}'
    assert subprocess.run(['sh', '-c', command], capture_output=True, check=False).returncode == 0


@pytest.mark.parametrize('command', ['scenes', '--help'])
def test_output_that_cannot_be_written_is_said(command: str) -> None:
    with Path('/dev/full').open('w') as full:
        run = tauto(command, stdout=full.fileno())
    assert run.returncode == 1
    assert run.stderr.startswith(b'tauto: standard output cannot be written: No space left')
    assert b'Traceback' not in run.stderr


@pytest.mark.parametrize(
    'arguments', [('bag', 'check'), ('scene', 'new', '-o'), ('report', 'ideal', '-o')]
)
def test_a_place_that_the_system_refuses_is_said_in_one_line(arguments: tuple[str, ...]) -> None:
    place = 'b' * 300 + '.html'  # most systems allow 255
    run = tauto(*arguments, place)
    assert run.returncode in (1, 2)
    assert run.stderr.decode().splitlines() == [
        f'tauto: {place}: File name too long. Name another place'
    ]


@pytest.mark.parametrize(
    'arguments', [('cam', 'measured', '--dxf'), ('report', 'ideal', '--duration', '60', '-o')]
)
def test_a_file_has_the_same_bytes_in_any_process(
    arguments: tuple[str, ...], tmp_path: Path
) -> None:
    """Sets have another order with another seed of Python's hashes."""
    made = []
    for run in (partial(tauto, PYTHONHASHSEED='1'), in_process):
        file = tmp_path / f'file.{"dxf" if "--dxf" in arguments else "html"}'
        run(*arguments, str(file))
        made.append(file.read_bytes())
        file.unlink()
    assert made[0] == made[1]


def test_a_character_that_the_terminal_lacks_is_escaped() -> None:
    run = tauto('sail', 'measured', '--duration', '20', encoding='latin-1')
    assert run.returncode == 0, run.stderr
    said = run.stdout.decode('latin-1')
    assert '\\u2212' in said  # the minus
    assert '±' in said


def test_files_whose_names_are_no_text_serve_as_any_other(tmp_path: Path) -> None:
    scene, bag, page = (str(tmp_path / f'{NO_TEXT}{end}') for end in ('.yaml', '', '.html'))
    Path(scene).write_text(scene_text('ideal'), encoding='utf-8')
    for arguments in (
        ('sail', scene, '--duration', '60', '--out', bag),
        ('report', bag, '-o', page),
    ):
        run = tauto(*arguments)
        assert run.returncode == 0, run.stderr
        assert repr(NO_TEXT)[1:-1].encode() in run.stdout + run.stderr
    assert 'tauto.report' in Path(page).read_text(encoding='utf-8')


def test_a_cache_that_cannot_be_written_is_reported_in_a_line(tmp_path: Path) -> None:
    (tmp_path / 'file').touch()
    told = tauto('sail', 'globe_in_oil', TAUTO_CACHE_DIR=str(tmp_path / 'file'))
    assert told.returncode == 0
    (line,) = told.stderr.decode().splitlines()
    assert line.startswith('tauto: compiled kernels cannot be kept in ')
