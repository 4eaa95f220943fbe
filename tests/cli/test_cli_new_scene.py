"""`tauto scene new` and `tauto scene schema` from the command line."""

from __future__ import annotations

import shlex
from pathlib import Path
from urllib.parse import urlparse
from urllib.request import url2pathname

from command_line import invoke, refused

from tauto_core.scene import load_scene
from tauto_core.scene.reference import FILE


def test_a_new_scene_is_written_named_and_sails(tmp_path: Path) -> None:
    file = tmp_path / 'mine.yaml'
    written = invoke('scene', 'new', '--thread', 'hole', '--escapement', 'impulse', '-o', file)
    assert (written.exit_code, written.stdout) == (0, '')
    assert str(file) in written.stderr
    assert load_scene(file).name == 'mine'
    assert load_scene(file).trochlea.thread.kind == 'hole'
    assert invoke('sail', file, '--duration', '20').exit_code == 0


def test_nothing_is_replaced(tmp_path: Path) -> None:
    file = tmp_path / 'mine.yaml'
    file.write_text('mine', encoding='utf-8')
    assert f'--out {file}: exists' in refused('scene', 'new', '-o', file)
    assert file.read_text(encoding='utf-8') == 'mine'
    said = refused('scene', 'new', '-o', tmp_path / 'none' / 'a.yaml')
    assert 'No such file or directory' in said


def test_the_next_command_can_be_pasted_whatever_the_name(tmp_path: Path) -> None:
    file = tmp_path / 'Über uns.yaml'
    said = invoke('scene', 'new', '-o', file).stderr
    command = said.partition('Sail it with: ')[2]
    assert shlex.split(command) == ['tauto', 'sail', str(file)]


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    for folder in (f'{tmp_path}/dir.d/', str(tmp_path)):
        said = refused('scene', 'new', '-o', folder)
        assert f'--out {folder}: is a folder. Name a file in it' in said
    assert not (tmp_path / 'dir.d').exists()


def test_a_file_is_known_for_a_scene_by_its_ending(tmp_path: Path) -> None:
    """`tauto sail measured` would sail the shipped scene, not a file of that name."""
    for name, near in (('measured', 'measured.yaml'), ('mine.txt', 'mine.yaml')):
        said = refused('scene', 'new', '-o', tmp_path / name)
        assert f'{name}: must end in .yaml or .yml. Use {tmp_path / near}' in said
    assert list(tmp_path.iterdir()) == []
    assert invoke('scene', 'new', '-o', tmp_path / 'mine.yml').exit_code == 0


def test_the_first_line_leads_editors_to_the_schema() -> None:
    first = invoke('scene', 'new').stdout.split('\n')[0]
    comment, _, uri = first.partition('$schema=')
    assert comment == '# yaml-language-server: '
    assert Path(url2pathname(urlparse(uri).path)) == FILE


def test_a_scene_is_shown_as_it_stands_in_its_file(tmp_path: Path) -> None:
    shown = invoke('scene', 'show', 'ideal')
    assert shown.stdout.startswith('# The ideal clock on land')
    (tmp_path / 'mine.yaml').write_text(shown.stdout)
    mine = load_scene(tmp_path / 'mine.yaml')
    assert mine == load_scene('ideal')
    assert 'Did you mean ideal?' in refused('scene', 'show', 'ideall')
