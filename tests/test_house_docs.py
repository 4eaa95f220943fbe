"""The README and the pages say what is so."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tauto_core.cli.app import app
from tauto_core.scene import shipped_scenes

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / 'README.md', *sorted((ROOT / 'docs').glob('*.md'))]
README = (ROOT / 'README.md').read_text(encoding='utf-8')


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r'\]\(([^)#]+)', page.read_text(encoding='utf-8')):
        assert target.startswith('https://') or (page.parent / target).exists(), target


def test_the_index_leads_to_every_page() -> None:
    index = (ROOT / 'docs' / 'index.md').read_text(encoding='utf-8')
    for page in PAGES[1:]:
        assert page.name == 'index.md' or f'({page.name})' in index


def test_the_table_of_scenes_is_complete() -> None:
    assert sorted(re.findall(r'^\| `(\w+)` \|', README, re.MULTILINE)) == shipped_scenes()


def test_every_command_and_option_of_the_readme_exists() -> None:
    rows = re.findall(r'^\| `tauto ([a-z]+)[^`]*`', README, re.MULTILINE)
    listed = CliRunner().invoke(app, ['--help']).stdout
    commands = re.findall(r'^  ([a-z]+)  ', listed.partition('Commands:')[2], re.MULTILINE)
    assert {*rows, 'scene'} == set(commands)
    for line in re.findall(r'^\| `(tauto [^`]*)`', README, re.MULTILINE):
        words = line.split()
        help_text = CliRunner().invoke(app, [words[1], '--help']).stdout
        for option in re.findall(r'--[a-z-]+', line):
            assert option in help_text, line


def test_every_make_target_of_the_pages_exists() -> None:
    makefile = (ROOT / 'Makefile').read_text(encoding='utf-8')
    for page in PAGES:
        text = page.read_text(encoding='utf-8')
        for target in re.findall(r'(?:^    |`)make ([a-z]+)\b', text, re.MULTILINE):
            assert re.search(f'^{target}:', makefile, re.MULTILINE), (page.name, target)
