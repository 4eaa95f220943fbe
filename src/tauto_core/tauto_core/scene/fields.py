"""Building blocks of the models of a scene: types of numbers and text, and the base class.

Numbers are finite and never read from strings or booleans; unknown keys are refused.
"""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, Strict

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


class Section(BaseModel):
    """Base of all models: frozen, no unknown keys, finite numbers."""

    model_config = ConfigDict(frozen=True, extra='forbid', allow_inf_nan=False)
