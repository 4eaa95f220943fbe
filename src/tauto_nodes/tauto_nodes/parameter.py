"""One parameter of a node: its type, its limits, and the message for a value that is refused."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from tauto_core.scene import shipped_scenes

Value: TypeAlias = bool | float | str | tuple[str, ...]

_TYPES = {bool: 'bool', float: 'double', str: 'string', tuple: 'string[]'}

FOLDER = 'TAUTO_FOLDER'
"""Environment variable: what nodes read and write by their parameters lies in this folder."""


@dataclass(frozen=True)
class Parameter:
    """One parameter of a node.

    Args:
        name: as in a parameter file.
        default: its type is the parameter's type (double, bool, string or string array).
        description: what it sets.
        unit: unit of the value, empty where it has none.
        low, high: closed range of a double.
        choices: the strings allowed; empty: any.
        required: an empty string is refused.
        is_path: it names a file or folder, which must lie in TAUTO_FOLDER where that is set.
        read_only: set at the start only.
    """

    name: str
    default: Value
    description: str
    unit: str = ''
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[str, ...] = ()
    required: bool = False
    is_path: bool = False
    read_only: bool = True

    @property
    def type(self) -> str:
        """The type's name in ROS."""
        return _TYPES[type(self.default)]

    @property
    def allowed(self) -> str:
        """The range or choices in words; empty where anything goes."""
        if self.choices:
            return ', '.join(f'`{choice}`' for choice in self.choices)
        if isinstance(self.default, float) and math.isfinite(self.low):
            return f'{self.low:g} … {self.high:g}'
        return 'not empty' if self.required else ''

    def problem(self, value: object) -> str:
        """Return why the value is refused; empty where it is not."""
        said = f'{self.name} = {value!r}'
        if isinstance(self.default, float) and isinstance(value, float):
            if not self.low <= value <= self.high:  # also false for NaN
                return f'{said}: must lie in [{self.low:g}, {self.high:g}] {self.unit}'.rstrip()
        elif self.choices and value not in self.choices:
            return f'{said}: must be one of {", ".join(self.choices)}'
        elif self.required and not value:
            return f'{said}: must be given, for example -p {self.name}:=…  ({self.description})'
        return self._stray(said, value) if self.is_path and value else ''

    def _stray(self, said: str, value: object) -> str:
        """Return why a path is refused: it leads out of the folder that the environment names."""
        folder = os.environ.get(FOLDER)
        if not folder or value in shipped_scenes():
            return ''
        inside = Path(str(value)).resolve().is_relative_to(Path(folder).resolve())
        return '' if inside else f'{said}: lies outside of {FOLDER} = {folder}; name a place in it'
