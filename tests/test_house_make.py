"""`make`: refusals before any download, and its children's environment under a sourced ROS."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from subprocess import CompletedProcess

import pytest
from modules import run_program

ROOT = Path(__file__).parents[1]
SOURCED = {
    'ROS_DISTRO': 'jazzy',
    'ROS_VERSION': '2',
    'RMW_IMPLEMENTATION': 'rmw_cyclonedds_cpp',
    'AMENT_PREFIX_PATH': '/srv/sully/ws/install/boat:/opt/ros/jazzy',
    'COLCON_PREFIX_PATH': '/srv/sully/ws/install',
    'PYTHONPATH': '/srv/sully/ws/install/boat/lib:/srv/sully/mine:/opt/ros/jazzy/lib/python',
    'LD_LIBRARY_PATH': '/opt/ros/jazzy/lib:/usr/lib/mine',
}


def script(path: Path, body: str) -> Path:
    path.write_text(f'#!/bin/sh\n{body}\n', encoding='utf-8')
    path.chmod(0o755)
    return path


def make_venv(folder: Path, *python: Path) -> CompletedProcess[str]:
    """Run .ci/venv in a folder whose bin/ comes before everything else."""
    path = {'PATH': f'{folder / "bin"}:/usr/bin:/bin'}
    return run_program(ROOT / '.ci' / 'venv', *python, cwd=folder, env=path)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / 'bin').mkdir()
    return tmp_path


@pytest.mark.parametrize(
    ('name', 'body', 'words'),
    [
        (
            'uname',
            'case $1 in -s) echo Linux;; *) echo aarch64;; esac',
            ('x86-64', 'aarch64', 'tauto sail'),
        ),
        ('old', 'exit 1', ('3.11', 'bin/old', 'apt-get install')),
        (
            'bare',
            'case "$2" in *ensurepip*) exit 1;; *) exit 0;; esac',
            ('bin/bare', 'python3-venv'),
        ),
    ],
)
def test_a_processor_or_python_that_does_not_fit_is_refused(
    name: str, body: str, words: tuple[str, ...], folder: Path
) -> None:
    program = script(folder / 'bin' / name, body)
    run = make_venv(folder, *([program] if name != 'uname' else []))
    assert run.returncode == 1, run.stderr
    assert all(word in run.stderr for word in words), run.stderr
    assert not (folder / '.venv').exists()


def test_a_name_without_a_program_behind_it_is_passed_over(folder: Path) -> None:
    for name in ('python3.13', 'python3.12'):
        script(folder / 'bin' / name, 'echo "no such version" >&2; exit 127')
    fits = 'venv' if sys.version_info < (3, 14) else 'none'
    script(
        folder / 'bin' / 'python3.11',
        f'case "$2" in *venv) mkdir -p .{fits};; esac; [ "$1" != -m ] || echo "$@" > made',
    )
    run = make_venv(folder)
    assert run.returncode == 0, run.stderr
    assert (folder / 'made').read_text(encoding='utf-8') == '-m venv --clear .venv\n'


def children_see(folder: Path, sourced: dict[str, str]) -> tuple[str, dict[str, str]]:
    """Return the message of make about a sourced ROS, and the environment that it passes on."""
    makefile = folder / 'Makefile'
    makefile.write_text(f'include {ROOT}/Makefile\nshow: environment\n\t@env -0\n', 'utf-8')
    base = {k: v for k, v in os.environ.items() if k not in SOURCED and not k.startswith('MAKE')}
    command = ('make', '--silent', '--file', makefile, 'show')
    run = run_program(*command, cwd=folder, env=base | sourced)
    assert run.returncode == 0, run.stderr
    first, *rest = run.stdout.split('\0')
    said, _, pair = first.rpartition('\n')
    return said, dict(item.split('=', 1) for item in [pair, *rest] if '=' in item)


def test_a_sourced_ros_is_hidden_and_said(tmp_path: Path) -> None:
    said, seen = children_see(tmp_path, SOURCED)
    assert set(seen) & set(SOURCED) == {'PYTHONPATH', 'LD_LIBRARY_PATH'}
    assert seen['PYTHONPATH'] == '/srv/sully/mine'
    assert seen['LD_LIBRARY_PATH'] == '/usr/lib/mine'
    assert all(name in said for name in SOURCED)


def test_without_ros_nothing_is_touched_or_said(tmp_path: Path) -> None:
    mine = {'PYTHONPATH': '/a:/b', 'LD_LIBRARY_PATH': '/c'}
    said, seen = children_see(tmp_path, mine)
    assert said == ''
    assert {name: seen[name] for name in mine} == mine


def test_a_foreign_bootstrap_guard_is_not_handed_on(tmp_path: Path) -> None:
    guard = '_ROS_WHEELS_BOOTSTRAP_COMPLETE'
    assert guard not in children_see(tmp_path, {guard: '1'})[1]


def test_sail_echoes_the_commands_it_runs() -> None:
    run = run_program('make', '--dry-run', '--no-print-directory', 'sail', cwd=ROOT)
    assert run.stdout.splitlines()[-2:] == [
        '.venv/bin/tauto graph measured --speed 60 --out bags/out/measured --force',
        '.venv/bin/tauto sail portsmouth_jamaica --set ship.rate=2 --set solver.tolerance=1e-6',
    ]
