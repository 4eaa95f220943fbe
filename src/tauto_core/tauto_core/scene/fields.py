"""Building blocks of the models of a scene: numbers, text, and kinds found by folder.

Numbers are finite and never read from strings or booleans; unknown keys are refused.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeAlias, Union, cast

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    PlainSerializer,
    Strict,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    WrapValidator,
)
from pydantic_core import CoreSchema

from tauto_core.scene.times import LAST_STAMP_S

LONGEST_TEXT = 1000

Number: TypeAlias = Annotated[float, Strict()]
Positive: TypeAlias = Annotated[float, Strict(), Field(gt=0.0)]
NonNegative: TypeAlias = Annotated[float, Strict(), Field(ge=0.0)]
# From the start of the scene [s]; later ones have no stamp.
Instant: TypeAlias = Annotated[float, Strict(), Field(ge=0.0, le=LAST_STAMP_S)]
Flag: TypeAlias = Annotated[bool, Strict()]
# One line: no control characters, no line or paragraph separators.
Text: TypeAlias = Annotated[
    str,
    Strict(),
    Field(min_length=1, max_length=LONGEST_TEXT, pattern=r'^[^\p{Cc}\p{Zl}\p{Zp}]+$'),
]
Latitude: TypeAlias = Annotated[float, Strict(), Field(ge=-90.0, le=90.0)]
Longitude: TypeAlias = Annotated[float, Strict(), Field(ge=-180.0, le=180.0)]
Position: TypeAlias = tuple[Latitude, Longitude]


def _number_or_normal(value: object, number: ValidatorFunctionWrapHandler) -> object:
    return value if value == 'normal' else number(value)


if TYPE_CHECKING:
    Gravity: TypeAlias = float | Literal['normal']
else:
    # A union would report what is wrong with a value for each of its members.
    Gravity = Annotated[
        Positive,
        WrapValidator(_number_or_normal),
        PlainSerializer(lambda value: value),
        WithJsonSchema(
            {'anyOf': [{'type': 'number', 'exclusiveMinimum': 0.0}, {'const': 'normal'}]}
        ),
    ]


class Section(BaseModel):
    """Base of all models: frozen, no unknown keys, finite numbers."""

    model_config = ConfigDict(frozen=True, extra='forbid', allow_inf_nan=False)


# -----------------------------------------------------------------------------
# Kinds of a section, found by listing their folder.
#
# A section such as `trochlea.cam` is of one of several kinds, which its key `kind` names. All of
# a kind is in one module: keys, checks, equations and messages. The module names its models
# `KINDS`; no list of kinds has to be extended.


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
        folder: name of the package whose modules each have `KINDS`, a tuple of models, or `KIND`;
            the package itself may have `KINDS` too.
    """
    package = import_module(folder)
    kinds: list[type[Kind]] = list(getattr(package, 'KINDS', ()))
    for name in sorted(each.name for each in pkgutil.iter_modules(package.__path__)):
        module = import_module(f'{folder}.{name}')
        kinds += getattr(module, 'KINDS', None) or [module.KIND]
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
