"""The command line as a page, docs/cli.md, from the help of each command.

`python -m tauto_core.cli.reference > docs/cli.md` renews it; tauto_nodes adds `graph` and
`play`.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator

_HEAD = """# The command line

SCENE is a YAML file or the name of a built-in scene, BAG a rosbag2 folder or an `.mcap` file. Exit
code 0: success; 2: a bad command line or scene, nothing was started; 1: it failed on the way; 130
(Ctrl-C) or 143 (SIGTERM): the bag holds what was sailed until then.

This page is made from the output of `-h` by `python -m tauto_core.cli.reference`.
"""
_COMMAND = re.compile(r'^  ([a-z]+)(?:  |$)', re.MULTILINE)


def page() -> str:
    """Return the help of all commands as Markdown."""
    sections = (
        f'\n## `{" ".join(["tauto", *words])}`\n\n```text\n{said}\n```\n'
        for words, said in _helps()
    )
    return _HEAD + ''.join(sections)


def _helps(words: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield the help of a command and of all below it, by their words."""
    from typer.testing import CliRunner

    from tauto_core.cli.app import app

    said = CliRunner().invoke(app, [*words, '--help'], prog_name='tauto').stdout
    yield words, '\n'.join(map(str.rstrip, said.strip().splitlines()))
    for name in sorted(_COMMAND.findall(said.partition('Commands:')[2])):
        yield from _helps((*words, name))


if __name__ == '__main__':
    sys.stdout.write(page())
