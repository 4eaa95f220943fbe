"""The claims of all three papers, in their order."""

from __future__ import annotations

from collections.abc import Sequence

from tauto_core.euler import axle_1780, fluid_1729, trochlea_1727
from tauto_core.euler.claim import Claim


def all_claims() -> list[Claim]:
    """Return the claims in the order of paper and paragraph."""
    return [*trochlea_1727.claims(), *fluid_1729.claims(), *axle_1780.claims()]


def summary(claims: Sequence[Claim]) -> str:
    """Return how many claims there are, and of each verdict, in words."""
    found = [claim.verdict for claim in claims]
    hold, misprinted, fail = (found.count(name) for name in ('holds', 'misprint', 'fails'))
    return f'{len(claims)} claims: {hold} hold, {misprinted} are misprinted, {fail} do not hold'
