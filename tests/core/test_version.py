"""Version: one base everywhere, the commit from git, and a hash of the code."""

from __future__ import annotations

import os
import runpy
import shutil
import subprocess
from pathlib import Path

import pytest

import tauto_core
from tauto_core import version as v
from tauto_core.ensembles.fleets import Plan, sail_fleet
from tauto_core.ensembles.workers import versions
from tauto_core.scene import load_scene
from tauto_core.scene.errors import UsageError
from tauto_core.voyage import sail

PACKAGE = Path(tauto_core.__file__).parent


class Checkout:
    """A git repository with version.py at the same path."""

    def __init__(self, root: Path) -> None:
        self.root, self.file = root, root / 'src/tauto_core/tauto_core/version.py'
        self.file.parent.mkdir(parents=True)
        shutil.copy(PACKAGE / 'version.py', self.file)

    def git(self, *words: str) -> str:
        who = ('-c', 'user.name=a', '-c', 'user.email=a@b')
        clean = {name: value for name, value in os.environ.items() if name[:4] != 'GIT_'}
        done = subprocess.run(
            ('git', *who, *words),
            cwd=self.root,
            env=clean | {'GIT_CONFIG_GLOBAL': os.devnull, 'GIT_CONFIG_NOSYSTEM': '1'},
            capture_output=True,
            text=True,
            check=True,
        )
        return done.stdout.strip()

    def commit(self) -> str:
        """Commit all there is. Return the first digits of the commit."""
        self.git('add', '.')
        self.git('commit', '--allow-empty', '--message', 'x')
        return self.git('rev-parse', 'HEAD')[:12]

    def said(self) -> str:
        return str(runpy.run_path(str(self.file))['version']())


@pytest.fixture
def checkout(tmp_path: Path) -> Checkout:
    if shutil.which('git') is None:
        pytest.skip('no git')
    made = Checkout(tmp_path)
    made.git('init', '--quiet')
    return made


def test_each_commit_has_a_version_of_its_own(checkout: Checkout) -> None:
    first = checkout.commit()
    assert checkout.said() == f'{v.BASE}+g{first}'
    second = checkout.commit()
    assert checkout.said() == f'{v.BASE}+g{second}' != f'{v.BASE}+g{first}'


def test_a_release_is_its_tag_alone(checkout: Checkout) -> None:
    checkout.commit()
    checkout.git('tag', f'v{v.BASE}')
    assert checkout.said() == v.BASE
    later = checkout.commit()
    assert checkout.said() == f'{v.BASE}+g{later}'


def test_code_that_is_not_committed_is_dirty(checkout: Checkout) -> None:
    commit = checkout.commit()
    with checkout.file.open('a') as stream:
        stream.write('# changed\n')
    assert checkout.said() == f'{v.BASE}+g{commit}.dirty'
    checkout.git('tag', f'v{v.BASE}')
    assert checkout.said() == f'{v.BASE}+dirty'


def test_only_the_repository_of_this_code_is_asked(
    checkout: Checkout, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A hook runs with GIT_DIR of its repository. An environment may be within another one."""
    commit = checkout.commit()
    within = Checkout(tmp_path / 'environment')
    assert within.said() == v.BASE
    monkeypatch.setenv('GIT_DIR', str(PACKAGE.parents[2] / '.git'))
    assert checkout.said() == f'{v.BASE}+g{commit}'


def test_without_git_the_base_remains(checkout: Checkout, monkeypatch: pytest.MonkeyPatch) -> None:
    assert checkout.said() == v.BASE  # no commit yet
    checkout.commit()
    monkeypatch.setenv('PATH', '')
    assert checkout.said() == v.BASE


def test_an_editable_install_cannot_be_stale() -> None:
    """The version comes from the sources, not from installed metadata."""
    assert tauto_core.__version__ == v.version()
    assert v.version().partition('+')[0] == v.BASE


def test_any_byte_of_the_sources_or_their_data_changes_the_hash(tmp_path: Path) -> None:
    copy = tmp_path / 'tauto_core'
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns('__pycache__'))
    for name in ('motion/stepping.py', 'scene/data/lever_arms/measured.csv'):
        with (copy / name).open('ab') as stream:
            before = v.code.__wrapped__(copy)
            stream.write(b'\n')
        assert v.code.__wrapped__(copy) != before
    before = v.code.__wrapped__(copy)
    (copy / 'motion/stepping.py').rename(copy / 'motion/stepping_2.py')
    assert v.code.__wrapped__(copy) != before


def test_what_python_and_editors_leave_does_not_change_the_hash(tmp_path: Path) -> None:
    copy = tmp_path / 'another_place'
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns('__pycache__'))
    (copy / 'motion/__pycache__').mkdir()
    (copy / 'motion/__pycache__/stepping.pyc').write_bytes(b'compiled')
    (copy / 'motion/.stepping.py.swp').write_bytes(b'edited')
    assert v.code.__wrapped__(copy) == v.code()


def test_a_bag_says_which_code_wrote_it(tmp_path: Path) -> None:
    """Without the commit: the same code gives the same bytes, committed or not."""
    sail(load_scene('ideal', duration=60.0), tmp_path / 'bag')
    head = (tmp_path / 'bag/bag_0.mcap').read_bytes()[:100]
    assert f'tauto_core {v.BASE} (code {v.code()})'.encode() in head
    described = (tmp_path / 'bag/metadata.yaml').read_text('utf-8')
    assert f'tauto_core: {v.BASE} (code {v.code()})' in described


def test_rows_of_other_code_do_not_mix(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert versions()['tauto_core'] == f'{v.BASE} (code {v.code()})'
    plan = Plan(load_scene('ideal', duration=60.0), 'ideal', 1, {}, 'vary')
    sail_fleet(plan, 1, tmp_path / 'fleet')
    sail_fleet(plan, 1, tmp_path / 'fleet')
    monkeypatch.setattr('tauto_core.version.code', lambda: '0123456789ab')
    with pytest.raises(UsageError, match='holds another fleet; versions differ'):
        sail_fleet(plan, 1, tmp_path / 'fleet')
