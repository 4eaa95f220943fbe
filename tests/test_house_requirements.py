"""The requirements for PyPI, rosdep and a Jazzy machine agree."""

from __future__ import annotations

import re
import runpy
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest
import setuptools
from packaging.version import Version

from tauto_core.version import BASE

ROOT = Path(__file__).parents[1]
ROSDEP_KEYS = {
    name: f'python3-{name}'
    for name in (
        *('ezdxf', 'geographiclib', 'hypothesis', 'jsonschema', 'matplotlib', 'numba', 'numpy'),
        *('psutil', 'pydantic', 'pytest', 'pytest-xdist', 'rich', 'scipy', 'typer'),
    )
} | {'pillow': 'python3-pil', 'pyyaml': 'python3-yaml'}
"""Requirements that rosdep installs from Ubuntu's packages: rosdistro 8468e88, rosdep/python.yaml.

It has none for allantools, llvmlite, lz4, mcap, mpmath and zstandard; rosbags only by
pip, which Ubuntu 24.04 refuses to let into the system.
"""


def setup_of(package: str, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Return the arguments that a setup.py passes to setuptools."""
    said: dict[str, Any] = {}
    monkeypatch.setattr(setuptools, 'setup', lambda **keywords: said.update(keywords))
    monkeypatch.chdir(ROOT / 'src' / package)
    runpy.run_path('setup.py')
    return said


@pytest.fixture
def core(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    return setup_of('tauto_core', monkeypatch)


def bounds(lines: list[str]) -> dict[str, str]:
    return dict(re.split('(?=[<>=])', x, maxsplit=1) for x in lines)


def test_a_jazzy_machine_gets_every_requirement(core: dict[str, Any]) -> None:
    text = (ROOT / 'requirements-jazzy.txt').read_text(encoding='utf-8')
    pip = bounds([line for line in text.splitlines() if line and not line.startswith('#')])
    assert not any(name.startswith('ros-') for name in pip)
    for name, bound in bounds(core['install_requires']).items():
        assert pip[name].startswith(bound) if name in pip else name in ROSDEP_KEYS


def test_rosdep_is_asked_for_what_is_required(core: dict[str, Any]) -> None:
    manifest = ET.parse(ROOT / 'src' / 'tauto_core' / 'package.xml')
    for tag, required in (
        ('exec_depend', core['install_requires']),
        ('test_depend', core['extras_require']['test']),
    ):
        keys = {ROSDEP_KEYS[name] for name in bounds(required) if name in ROSDEP_KEYS}
        assert {element.text for element in manifest.iter(tag)} == keys


@pytest.mark.parametrize('package', ['tauto_core', 'tauto_nodes'])
def test_setup_and_manifest_say_the_same(monkeypatch: pytest.MonkeyPatch, package: str) -> None:
    said = setup_of(package, monkeypatch)
    manifest = ET.parse(ROOT / 'src' / package / 'package.xml').getroot()
    for key in ('name', 'license'):
        assert manifest.findtext(key) == said[key]
    # REP 149 has three numbers and no place for `.dev0`
    assert manifest.findtext('version') == Version(said['version']).base_version


@pytest.mark.parametrize(
    ('command', 'player'), [('install', 'player'), ('bdist_wheel', 'tauto-player')]
)
def test_executables_have_a_prefix_where_pip_installs_them(
    command: str, player: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`ros2 run tauto_nodes player` starts what colcon installs."""
    monkeypatch.setattr(sys, 'argv', ['setup.py', command])
    scripts = setup_of('tauto_nodes', monkeypatch)['entry_points']['console_scripts']
    names = [script.partition(' = ')[0] for script in scripts]
    assert player in names
    assert {name.startswith('tauto-') for name in names} == {player != 'player'}


def test_both_packages_and_the_changelog_say_one_version(monkeypatch: pytest.MonkeyPatch) -> None:
    """A release has its heading; before it, what is new is above the heading of the last one."""
    for each in ('tauto_core', 'tauto_nodes'):
        assert setup_of(each, monkeypatch)['version'] == BASE
    text = (ROOT / 'CHANGELOG.md').read_text(encoding='utf-8')
    newest = re.search(r'^## (\d+\.\d+\.\d+) – \d{4}-\d\d-\d\d$', text, re.MULTILINE)
    assert newest is not None
    ours = Version(BASE)
    assert Version(newest[1]) < ours if ours.is_devrelease else newest[1] == BASE


def test_each_library_has_a_lower_bound_and_is_explained(core: dict[str, Any]) -> None:
    page = (ROOT / 'docs' / 'libraries.md').read_text(encoding='utf-8').lower()
    for name, bound in bounds([*core['install_requires'], *core['extras_require']['dev']]).items():
        assert bound.startswith('>='), name
        assert f'`{name.lower()}`' in page, name
