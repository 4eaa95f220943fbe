"""Default numbers of scenes, apart from the models so that using them loads no pydantic."""

from __future__ import annotations

STANDARD_GRAVITY = 9.80665
"""Standard gravity [m/s2]; exact by definition (3rd CGPM, 1901)."""

DAY_S = 86_400.0

LEGIBLE = 0.25
"""Error of a reading, in periods, above which the phase is lost."""
