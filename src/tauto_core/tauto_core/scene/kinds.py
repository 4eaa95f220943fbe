"""Kinds of a section, one module each, found by listing their folder.

A section such as `trochlea.cam` is of one of several kinds, which its key `kind` names. All of a
kind is in one module: keys, checks, equations and messages. The module names its model `KIND`; no
list of kinds has to be extended.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Annotated, Any, ClassVar, Union, cast

from pydantic import BeforeValidator, Field, GetCoreSchemaHandler
from pydantic_core import CoreSchema

from tauto_core.scene.fields import Section


class Kind(Section):
    """Base of all kinds of one section.

    Attributes:
        rank: its place among its siblings in lists, simplest first.
        starter: values with which a new scene starts (`scene/template.py`): all keys without a
            default, for a machine that swings about once a second.
    """

    rank: ClassVar[int] = 100
    starter: ClassVar[Mapping[str, Any]] = {}


@cache
def kinds_in(folder: str) -> tuple[type[Kind], ...]:
    """Return the models of a folder's kinds, sorted by rank, then by module name.

    Args:
        folder: name of the package whose modules each have a `KIND`.
    """
    names = sorted(each.name for each in pkgutil.iter_modules(import_module(folder).__path__))
    kinds: list[type[Kind]] = [import_module(f'{folder}.{name}').KIND for name in names]
    return tuple(sorted(kinds, key=lambda kind: kind.rank))


def kind_of(model: type[Kind]) -> str:
    """Return the value of the key `kind` for a model."""
    return str(model.model_fields['kind'].default)


@dataclass(frozen=True)
class OneOf:
    """Marks a field that takes any kind of a folder: `Annotated[CamKind, OneOf(folder)]`.

    Attributes:
        folder: name of the package.
        default: kind of a mapping that does not name one; None if it must.
    """

    folder: str
    default: str | None = None

    @property
    def models(self) -> tuple[type[Kind], ...]:
        """The models of the folder."""
        return kinds_in(self.folder)

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Return the schema of the union whose members `kind` distinguishes."""
        del source
        if len(self.models) == 1:
            return handler.generate_schema(self.models[0])
        union: Any = Annotated[Union[self.models], Field(discriminator='kind')]  # noqa: UP007
        if self.default is not None:
            union = Annotated[union, BeforeValidator(self._with_default)]
        return handler.generate_schema(union)

    def _with_default(self, value: object) -> object:
        if isinstance(value, dict) and 'kind' not in value:
            return {'kind': self.default, **cast(dict[str, object], value)}
        return value
