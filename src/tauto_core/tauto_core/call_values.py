"""Arguments of Python calls: their types, checked before anything runs."""

from __future__ import annotations

from collections.abc import Iterable
from numbers import Integral, Real
from pathlib import Path

from tauto_core.scene.errors import UsageError


def whole(name: str, value: object) -> int:
    """Return a whole number, of NumPy too.

    Raises:
        UsageError: anything else.
    """
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise UsageError(f'{name} = {value!r}: must be a whole number. Write for example 2')
    return int(value)


def numbers(name: str, values: object) -> list[float]:
    """Return a list of numbers, of NumPy too.

    Raises:
        UsageError: not a list, or not of numbers.
    """
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise UsageError(f'{name} = {values!r}: must be a list of numbers. Write it in [ ]')
    listed = list(values)
    for each in listed:
        if isinstance(each, bool) or not isinstance(each, Real):
            raise UsageError(f'{name}: {each!r} is not a number. Write numbers')
    return [float(each) for each in listed]


def path(name: str, value: object) -> Path:
    """Return a path.

    Raises:
        UsageError: neither a string nor a path.
    """
    if not isinstance(value, str | Path):
        raise UsageError(f'{name} = {value!r}: must be a path. Write it as text')
    return Path(value)
