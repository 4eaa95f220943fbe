"""Names of a package whose modules are loaded at the first use of the name."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def loaded_from(package: str, modules: Mapping[str, str]) -> Callable[[str], Any]:
    """Return the `__getattr__` (PEP 562) of a package.

    `modules` has, for each name, the module that defines it: one of the package's own, or by its
    full name.
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
