"""Print the page of the command line, the help of each command: python docs/command_line.py.

`make docs` writes it to docs/cli.md. tauto_nodes adds `graph` and `play`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from typer.testing import CliRunner

from tauto_core.cli.app import app

COMMAND = re.compile(r'^  ([a-z]+)(?:  |$)', re.MULTILINE)
HEAD = """# The command line

SCENE is a YAML file or the name of a built-in scene, BAG a rosbag2 folder or an `.mcap` file. Exit
code 0: success; 2: a bad command line or scene, nothing was started; 1: it failed on the way; 130
(Ctrl-C) or 143 (SIGTERM): the bag holds what was sailed until then.

`make docs` makes this page from the output of `-h`.
"""


def command_line() -> str:
    """Return the help of all commands as Markdown."""
    sections = (
        f'\n## `{" ".join(["tauto", *words])}`\n\n```text\n{said}\n```\n'
        for words, said in _helps()
    )
    return HEAD + ''.join(sections)


def _helps(words: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield the help of a command and of all below it, by their words."""
    said = CliRunner().invoke(app, [*words, '--help'], prog_name='tauto').stdout
    yield words, '\n'.join(map(str.rstrip, said.strip().splitlines()))
    for name in sorted(COMMAND.findall(said.partition('Commands:')[2])):
        yield from _helps((*words, name))


if __name__ == '__main__':
    print(command_line(), end='')
