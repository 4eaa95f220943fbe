"""The golden numbers of `core/golden.json`, in the precision of an independent program."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

GOLDEN: list[dict[str, Any]] = json.loads(
    (Path(__file__).parent / 'core' / 'golden.json').read_text(encoding='utf-8')
)['entries']


def entries(*prefixes: str) -> list[Any]:
    """Return the entries whose names begin so, as parameters of a test."""
    chosen = [entry for entry in GOLDEN if entry['id'].startswith(prefixes)]
    assert len(chosen) >= len(prefixes)
    return [pytest.param(entry, id=entry['id']) for entry in chosen]


def numbers(entry: dict[str, Any]) -> tuple[dict[str, Any], dict[str, float]]:
    """Return what is given and what is expected; a given text that is no number stays a text."""

    def value(text: str) -> Any:
        try:
            return float(text)
        except ValueError:
            return text

    given = {key: value(item['value']) for key, item in entry['params'].items()}
    return given, {key: float(each) for key, each in entry['expected'].items()}
