"""Names of a package that are imported at their first use."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def loaded_from(package: str, modules: Mapping[str, str]) -> Callable[[str], Any]:
    """Return the `__getattr__` (PEP 562) of a package.

    `modules` maps each name to its module, in the package or with its full name.
    """

    def find(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f'module {package!r} has no attribute {name!r}')
        home = modules[name]
        home = home if home.startswith('tauto_core.') else f'{package}.{home}'
        value = getattr(import_module(home), name)
        setattr(sys.modules[package], name, value)
        return value

    return find
