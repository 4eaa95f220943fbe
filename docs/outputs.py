"""Renew what commands print in the README: python docs/outputs.py.

A comment `<!-- output: COMMAND -->` is followed by an indented block, what COMMAND prints.
"""

from __future__ import annotations

import re
from pathlib import Path

from typer.testing import CliRunner

from tauto_core.cli.app import app

README = Path(__file__).parents[1] / 'README.md'
BLOCK = re.compile(r'(<!-- output: tauto (.*?) -->\n\n)((?:(?:    .*)?\n)+?)(?=\S)')


def printed(command: str) -> str:
    """Return what a command prints, indented as code, without blanks at the ends of lines."""
    run = CliRunner().invoke(app, command.split())
    assert run.exit_code == 0, run.stderr
    return ''.join(f'    {line}'.rstrip() + '\n' for line in run.stdout.splitlines()) + '\n'


def renewed(text: str) -> str:
    """Return a page with each block as its command prints it now."""
    return BLOCK.sub(lambda found: found[1] + printed(found[2]), text)


if __name__ == '__main__':
    README.write_text(renewed(README.read_text(encoding='utf-8')), encoding='utf-8')
