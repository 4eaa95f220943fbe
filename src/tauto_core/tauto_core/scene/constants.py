"""Default numbers of scenes; code that needs only these loads no pydantic."""

from __future__ import annotations

STANDARD_GRAVITY = 9.80665
"""[m/s2]; exact by definition (3rd CGPM, 1901)."""

DAY_S = 86_400.0
