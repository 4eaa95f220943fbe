"""Both distributions build, and the core is complete in an environment of its own."""

from __future__ import annotations

import re
import shutil
import sys
import tarfile
import venv
import zipfile
from email import message_from_bytes
from pathlib import Path

import pytest
import yaml
from modules import run_program

from tauto_core.version import BASE, code

ROOT = Path(__file__).parents[1]


def run(*words: str | Path, cwd: Path | None = None) -> str:
    done = run_program(*words, cwd=cwd)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope='module')
def wheels(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp('wheels')
    for name in ('tauto_core', 'tauto_nodes'):
        copy = folder / 'sources' / name  # a build leaves files beside its sources
        shutil.copytree(ROOT / 'src' / name, copy, ignore=shutil.ignore_patterns('__pycache__'))
        pip = ('-m', 'pip', 'wheel', '--quiet', '--no-deps', '--no-build-isolation')
        run(sys.executable, *pip, '--wheel-dir', folder, copy)
    return {wheel.name.partition('-')[0]: wheel for wheel in folder.glob('*.whl')}


def test_the_wheels_hold_all_that_the_sources_hold(wheels: dict[str, Path]) -> None:
    for name, wheel in wheels.items():
        held = set(zipfile.ZipFile(wheel).namelist())
        package = ROOT / 'src' / name / name
        for file in package.rglob('*'):
            if file.is_file() and '__pycache__' not in file.parts:
                assert file.relative_to(package.parent).as_posix() in held, file


def test_licence_notice_and_description_are_within(
    wheels: dict[str, Path], tmp_path: Path
) -> None:
    for name, wheel in wheels.items():
        with zipfile.ZipFile(wheel) as held:
            info = f'{name}-{BASE}.dist-info'
            for file in ('LICENSE', 'NOTICE'):  # newer setuptools have a folder for them
                places = {f'{info}/{file}', f'{info}/licenses/{file}'} & set(held.namelist())
                assert [held.read(each) for each in places] == [(ROOT / file).read_bytes()]
            said = message_from_bytes(held.read(f'{info}/METADATA'))
        assert said['Author']
        assert said.get_payload().startswith(f'# {name}\n')
        needs = said.get_all('Requires-Dist')
        ours = [need for need in needs if need.startswith('tauto')]
        assert ours
        assert all(f'=={BASE}' in need for need in ours), ours  # both packages of one version
    sources = wheels['tauto_core'].parent / 'sources'
    for name in wheels:
        made = tmp_path / name
        build = 'import sys; from setuptools.build_meta import build_sdist as b; b(sys.argv[1])'
        run(sys.executable, '-c', build, made, cwd=sources / name)
        [sdist] = made.glob('*.tar.gz')
        with tarfile.open(sdist) as held:
            names = {each.partition('/')[2] for each in held.getnames()}
        wanted = {'LICENSE', 'NOTICE', 'README.md', 'package.xml', 'setup.py'}
        assert wanted | {f'resource/{name}'} <= names


@pytest.mark.parametrize('file', sorted((ROOT / '.github/workflows').glob('*.yml')), ids=str)
def test_workflows_pin_what_they_use_and_may_do_little(file: Path) -> None:
    text = file.read_text(encoding='utf-8')
    assert yaml.safe_load(text)['permissions'] in ({}, {'contents': 'read'})
    used = re.findall(r'uses: (\S+)', text)
    assert used
    assert all(re.fullmatch(r'[\w/-]+@[0-9a-f]{40}', each) for each in used), used


def test_the_installed_wheel_sails_by_itself(wheels: dict[str, Path], tmp_path: Path) -> None:
    """An empty environment that sees the libraries of this one, and none of this tree."""
    venv.create(tmp_path / 'env', with_pip=False)
    libraries = next(path for path in map(Path, sys.path) if path.name == 'site-packages')
    python = tmp_path / 'env/bin/python'
    [own] = (tmp_path / 'env/lib').glob('python*/site-packages')
    pip = ('-m', 'pip', '--python', python, 'install', '--quiet', '--no-deps', '--no-index')
    run(sys.executable, *pip, wheels['tauto_core'], wheels['tauto_nodes'])
    # .pth files of the libraries, which lead to this tree, are not read there
    (own / 'libraries.pth').write_text(f'{libraries}\n', encoding='utf-8')
    said = run(
        *(python, '-c'),
        'import tauto_core as t; print(t.__file__); print(t.sail("ideal", duration=600.0))',
    )
    assert str(tmp_path) in said.splitlines()[0]
    assert 'Voyage of ideal' in said
    # no git there, but the same code as in this tree
    assert run(tmp_path / 'env/bin/tauto', '--version') == f'tauto {BASE} (code {code()})\n'
    assert all(f'-{BASE}-' in wheel.name for wheel in wheels.values())


def test_the_extras_are_those_that_the_page_names() -> None:
    from importlib.metadata import metadata

    extras = set(metadata('tauto_core').get_all('Provides-Extra') or ())
    assert {'ros', 'fleet', 'docs'} <= extras
    page = (ROOT / 'docs' / 'glance.md').read_text(encoding='utf-8')
    for name in ('ros', 'fleet', 'docs'):
        assert f'`{name}`' in page
