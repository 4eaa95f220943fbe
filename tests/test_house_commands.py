"""The commands in the pages: they exist, and those that need no network and no ROS run."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from lint_prose import PAGES
from modules import module_of
from typer.testing import CliRunner

from tauto_core.cli.app import app

ROOT = Path(__file__).parents[1]
DOCS = ROOT / 'docs'
TYPED = re.compile(r'^ {4,}(?:ros2 run tauto_core )?(tauto .*?)(?:    #.*)?$', re.MULTILINE)
RUN = [DOCS / 'tutorial.md', *sorted((DOCS / 'howto').glob('*.md'))]
GRAPH = ('tauto graph', 'tauto play')
BROUGHT = ('measured_bag', 'logbooks.csv', 'passage.yaml', 'fiji')
"""Files that no command of a page writes, and the scene of such a log-book."""


def commands(page: Path) -> list[str]:
    return [line.strip() for line in TYPED.findall(page.read_text(encoding='utf-8'))]


def test_the_command_line_s_page_is_what_help_prints() -> None:
    page = module_of(DOCS / 'command_line.py').command_line()
    for name in ('sail', 'cam', 'scene new', 'graph', 'play'):
        printed = CliRunner().invoke(app, [*name.split(), '--help'], prog_name='tauto').stdout
        for line in printed.strip().splitlines():
            assert line.rstrip() in page.partition(f'## `tauto {name}`')[2], line


@pytest.mark.parametrize('page', PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_command_of_a_page_has_the_options_it_is_given(page: Path) -> None:
    for line in commands(page):
        words = line.split()
        name = words[1:3] if words[1] in ('scene', 'bag') else words[1:2]
        told = CliRunner().invoke(app, [*name, '--help'])
        assert told.exit_code == 0, line
        for option in re.findall(r'(?<=\s)--?[a-z][a-z-]*', line):
            assert option in told.stdout, line


@pytest.mark.parametrize('page', RUN, ids=lambda page: page.stem)
def test_the_commands_of_the_tutorial_and_of_each_how_to_run(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the order of the page, after writing the files that the page gives.

    A budget sails a few of its stretches; test_ensembles_budget.py checks what it finds.
    """
    monkeypatch.chdir(tmp_path)
    for least in ('STRETCHES', 'FEWEST_STRETCHES'):
        monkeypatch.setattr(f'tauto_core.ensembles.budget.{least}', 6)
    text = page.read_text(encoding='utf-8')
    for name, content in re.findall(r'`(\w+\.yaml)`[^`]*```yaml\n(.*?)```', text, re.DOTALL):
        Path(name).write_text(content, encoding='utf-8')
    for line in commands(page):
        if line.startswith(GRAPH) or any(file in line for file in BROUGHT):
            continue
        said = CliRunner().invoke(app, line.split()[1:])
        assert said.exit_code == 0, (line, said.output)
