"""`make`: refusals before any download, and its children's environment under a sourced ROS."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

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


def make_venv(folder: Path, python: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run .ci/venv in a folder whose bin/ comes before everything else."""
    return subprocess.run(
        [ROOT / '.ci' / 'venv', *([python] if python else [])],
        cwd=folder,
        env={'PATH': f'{folder / "bin"}:/usr/bin:/bin'},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / 'bin').mkdir()
    return tmp_path


def refused(run: subprocess.CompletedProcess[str], folder: Path, *words: str) -> bool:
    assert run.returncode == 1, run.stderr
    assert all(word in run.stderr for word in words), run.stderr
    return not (folder / '.venv').exists()


def test_another_processor_is_refused_and_told_what_works_there(folder: Path) -> None:
    script(folder / 'bin' / 'uname', 'case $1 in -s) echo Linux;; *) echo aarch64;; esac')
    assert refused(make_venv(folder), folder, 'x86-64', 'aarch64', 'tauto sail')


def test_a_python_that_does_not_fit_is_refused_with_the_remedy(folder: Path) -> None:
    old = script(folder / 'bin' / 'old', 'exit 1')
    assert refused(make_venv(folder, old), folder, '3.11', str(old), 'apt-get install')


def test_a_python_without_venv_is_refused_with_the_remedy(folder: Path) -> None:
    bare = script(folder / 'bin' / 'bare', 'case "$2" in *ensurepip*) exit 1;; *) exit 0;; esac')
    assert refused(make_venv(folder, bare), folder, str(bare), 'python3-venv')


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
    run = subprocess.run(
        ['make', '--silent', '--file', makefile, 'show'],
        cwd=folder,
        env=base | sourced,
        capture_output=True,
        text=True,
        check=True,
    )
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
    run = subprocess.run(
        ['make', '--dry-run', '--no-print-directory', 'sail'],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.splitlines()[-2:] == [
        '.venv/bin/tauto graph measured --speed 60 --out bags/out/measured --force',
        '.venv/bin/tauto sail portsmouth_jamaica --set ship.rate=2 --set solver.tolerance=1e-6',
    ]
