"""The claims of all three papers, in their order."""

from __future__ import annotations

from tauto_core.euler import axle_1780, fluid_1729, trochlea_1727
from tauto_core.euler.claim import Claim


def all_claims() -> list[Claim]:
    """Return the claims in the order of paper and paragraph."""
    return [*trochlea_1727.claims(), *fluid_1729.claims(), *axle_1780.claims()]
