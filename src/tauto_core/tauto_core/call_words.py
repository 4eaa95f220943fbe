"""Errors of the command line in the words of a Python call: arguments in place of options."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial

from tauto_core.scene.errors import Problem, SceneError, TautoError


@contextmanager
def in_words_of_calls(**arguments: str) -> Iterator[None]:
    """Rename options in errors to the arguments of a Python call.

    Args:
        arguments: by option, the arguments whose names differ, for example `out='file'`.
    """
    renamed = partial(_renamed, arguments=arguments)
    try:
        yield
    except SceneError as error:
        first, *further = [
            Problem(each.key, each.value, renamed(each.problem), renamed(each.remedy))
            for each in error.problems
        ]
        raise SceneError(
            error.file, first.key, first.value, first.problem, first.remedy, further=further
        ) from None
    except TautoError as error:
        error.args = tuple(renamed(str(part)) for part in error.args)
        raise


def _renamed(words: str, arguments: Mapping[str, str]) -> str:
    """Return words with `--some-option VALUE` as `some_option=VALUE`, and `--set KEY` as `KEY`.

    `--anyway` has no value.
    """
    words = words.replace('--set ', '').replace('--anyway', 'anyway=True')

    def argument(match: re.Match[str]) -> str:
        name = match[1].replace('-', '_')
        name = arguments.get(name, name)
        return name if match[3] else f'{name}={(match[2] or "").strip()}'

    return re.sub(r'--([a-z][a-z-]*[a-z])(?:( [^\s:),]+)(?=[:)]|$)|(?=( = )))?', argument, words)
