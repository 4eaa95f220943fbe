"""Materials by name or numbers: changes of lengths and springs with temperature.

The tables hold at room temperature.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, TypeAlias

from pydantic import (
    Field,
    PlainSerializer,
    Strict,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    WrapValidator,
)
from pydantic_core import PydanticCustomError

from tauto_core.scene.sections import Section


class Material(Section):
    """A material by its numbers."""

    expansion: Annotated[float, Strict(), Field(ge=-1e-4, le=1e-3)] = Field(
        default=0.0, description='linear expansion, −1e-4 to 1e-3 [1/K]'
    )
    modulus: Annotated[float, Strict(), Field(ge=-1e-2, le=1e-2)] | None = Field(
        default=None,
        description='relative change of the shear modulus, −1e-2 to 1e-2 [1/K], needed by springs',
    )

    @property
    def force(self) -> float:
        """β, relative change of the force of a helical spring, G d⁴/8D³n times its draw [1/K].

        The sum for the shear modulus G and for d⁴/D³.
        """
        return (self.modulus or 0.0) + self.expansion


# CRC: CRC Handbook of Chemistry and Physics, thermal properties of pure metals, 25 °C.
MATERIALS = {
    # Kaye & Laby, Tables of Physical and Chemical Constants: brass with 34 % of zinc, 18.9e-6
    'brass': Material(expansion=18.9e-6),
    # the same, mild steel, some 11.5e-6. Modulus of uncompensated springs, some −2.4e-4
    'steel': Material(expansion=11.5e-6, modulus=-2.4e-4),
    'copper': Material(expansion=16.5e-6),  # CRC
    'gold': Material(expansion=14.2e-6),  # CRC
    'iron': Material(expansion=11.8e-6),  # CRC
    'lead': Material(expansion=28.9e-6),  # CRC
    'platinum': Material(expansion=8.8e-6),  # CRC
    'silver': Material(expansion=18.9e-6),  # CRC
    'zinc': Material(expansion=30.2e-6),  # CRC
    # C. É. Guillaume, Nobel lecture, 1920: 36 % of nickel, about 1.2e-6
    'invar': Material(expansion=1.2e-6),
}


def by_name(what: str, table: Mapping[str, object]) -> WrapValidator:
    """Return a validator that takes a name of a table, or else the numbers of a section."""

    def known(value: object, numbers: ValidatorFunctionWrapHandler) -> object:
        if not isinstance(value, str):
            return numbers(value)
        if value in table:
            return value
        matches = difflib.get_close_matches(value, list(table), 1)
        text = f'is an unknown {what}'
        text += f'; did you mean {matches[0]}?' if matches else ''
        raise PydanticCustomError(
            'unknown',
            '{said} (there are {known})',
            {'said': text, 'known': ', '.join(sorted(table))},
        )

    return WrapValidator(known)


def named(
    what: str, section: type[Section], table: Mapping[str, object], *required: str
) -> object:
    """Return the type of a name of a table, or of numbers, which is written as it was given."""
    numbers = {
        'type': 'object',
        'properties': {key: {'type': 'number'} for key in section.model_fields},
        **({'required': list(required)} if required else {}),
        'additionalProperties': False,
    }
    return Annotated[
        section,
        by_name(what, table),
        PlainSerializer(
            lambda value: (
                value
                if isinstance(value, str)
                else value.model_dump(exclude_none=True, exclude_unset=True)
            )
        ),
        WithJsonSchema({'anyOf': [{'enum': sorted(table)}, numbers]}),
    ]


if TYPE_CHECKING:
    NamedMaterial: TypeAlias = str | Material
else:
    NamedMaterial = named('material', Material, MATERIALS)


def as_written(named: str | Section | None) -> object:
    """Return a name, or the given numbers of a section, as in a scene."""
    return named.model_dump(exclude_none=True) if isinstance(named, Section) else named


def material(named: str | Material | None) -> Material:
    """Return a material by its name or numbers, by default one that does not change."""
    if named is None:
        return Material()
    return MATERIALS[named] if isinstance(named, str) else named
