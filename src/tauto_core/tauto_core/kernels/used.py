"""The dependencies of compiled code, which is valid as long as none of them changes."""

from __future__ import annotations

import hashlib
import sys
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any


@cache
def contents(path: str) -> bytes:
    """Return a file as it is when first asked for: what is translated is what is hashed."""
    try:
        return Path(path).read_bytes()
    except OSError:
        return b''


@cache
def digest(path: str) -> str:
    """Return the hash of a file."""
    return hashlib.sha256(contents(path)).hexdigest()


def token(x: Any) -> str:
    """Return what a name stood for when a kernel was compiled, as text."""
    if isinstance(x, ModuleType):
        return f'module {x.__name__}'
    if isinstance(x, type) and hasattr(x, '_fields'):
        return f'{x.__module__}.{x.__qualname__}{x._fields}'
    if isinstance(x, tuple):
        return f'({", ".join(token(item) for item in x)})'
    if x is None or isinstance(x, (bool, int, float, str)):
        return repr(x)
    name = getattr(x, '__qualname__', None) or getattr(x, '__name__', None)
    return f'{getattr(x, "__module__", "")}.{name}' if name else repr(x)


class Used:
    """The files and the values of names that a kernel was translated from.

    Attributes:
        files: hash of each, by its path.
        names: what each stood for, by module and name.
    """

    def __init__(self) -> None:
        self.files: dict[str, str] = {}
        self.names: dict[str, dict[str, str]] = {}

    def file(self, function: Any) -> None:
        """Note where a function comes from."""
        path = function.__code__.co_filename
        self.files[path] = digest(path)

    def type(self, named: type) -> None:
        """Note what a NamedTuple's fields are."""
        self.constant(named.__module__, named.__qualname__, named)

    def constant(self, module: str, name: str, value: Any) -> None:
        """Note what a name of a module means."""
        self.names.setdefault(module, {})[name] = token(value)


def is_as_it_was(files: dict[str, str], names: dict[str, dict[str, str]]) -> bool:
    """Return whether files and names are what they were."""
    if any(digest(path) != wanted for path, wanted in files.items()):
        return False
    for module, known in names.items():
        now = vars(sys.modules[module]) if module in sys.modules else {}
        for name, wanted in known.items():
            if name not in now or token(now[name]) != wanted:
                return False
    return True
