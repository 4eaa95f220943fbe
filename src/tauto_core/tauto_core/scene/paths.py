"""Values in the mapping of a scene, by the paths of their keys, such as `ship.sea.peak_period`."""

from __future__ import annotations

from typing import Any


def value_at(content: Any, path: str) -> Any:
    """Return the value at a path; None where there is none.

    Args:
        content: mapping of a scene, as its file holds it.
        path: keys with dots between them; an item of a list is named by its number, from 0.
    """
    for name in path.split('.'):
        key = _key_in(content, name)
        content = None if key is None else content[key]
    return content


def remove_at(content: dict[str, Any], path: str) -> None:
    """Remove the key or item at a path, in place; where there is none, nothing happens.

    Args:
        content: as for `value_at`.
        path: as for `value_at`.
    """
    section, _, last = path.rpartition('.')
    here: Any = value_at(content, section) if section else content
    key = _key_in(here, last)
    if key is not None:
        del here[key]


def put_at(content: dict[str, Any], path: str, value: object) -> None:
    """Set the value at a path, in place; sections that are absent are added.

    Args:
        content: as for `value_at`.
        path: as for `value_at`.
        value: anything that a scene may hold there.

    Raises:
        KeyError: the path leads through something that is neither a mapping nor a list with
            such an item.
    """
    *sections, last = path.split('.')
    here: Any = content
    for name in sections:
        if isinstance(here, dict) and here.get(name) is None:
            here[name] = {}
        here = value_at(here, name)
    key = last if isinstance(here, dict) else _key_in(here, last)
    if key is None:
        raise KeyError(path)
    here[key] = value


def _key_in(content: Any, name: str) -> str | int | None:
    """Return what a name stands for in a mapping or list; None where nothing is there."""
    if isinstance(content, list) and name.isdecimal() and int(name) < len(content):
        return int(name)
    return name if isinstance(content, dict) and name in content else None
