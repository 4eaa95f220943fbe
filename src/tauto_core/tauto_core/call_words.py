"""Errors of the command line in the words of a Python call: arguments in place of options."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

from tauto_core.scene.errors import Problem, SceneError, TautoError


@contextmanager
def in_words_of_calls() -> Iterator[None]:
    """Rename options in errors to the arguments of a Python call."""
    try:
        yield
    except SceneError as error:
        first, *further = [
            Problem(each.key, each.value, _renamed(each.problem), _renamed(each.remedy))
            for each in error.problems
        ]
        raise SceneError(
            error.file, first.key, first.value, first.problem, first.remedy, further=further
        ) from None
    except TautoError as error:
        error.args = tuple(_renamed(str(part)) for part in error.args)
        raise


def _renamed(words: str) -> str:
    """Return words with `--some-option VALUE` as `some_option=VALUE`, and `--set KEY` as `KEY`."""
    words = words.replace('--set ', '')

    def argument(match: re.Match[str]) -> str:
        name = match[1].replace('-', '_')
        return name if match[3] else f'{name}={(match[2] or "").strip()}'

    return re.sub(r'--([a-z][a-z-]*[a-z])(?:( [^\s:),]+)(?=[:)])|(?=( = )))?', argument, words)
