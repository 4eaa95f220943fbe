"""The claims of all three papers, in their order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from tauto_core.euler import axle_1780, fluid_1729, trochlea_1727
from tauto_core.euler.claim import Claim


def all_claims() -> list[Claim]:
    """Return the claims in the order of paper and paragraph."""
    return [*trochlea_1727.claims(), *fluid_1729.claims(), *axle_1780.claims()]


def summary(claims: Sequence[Claim]) -> str:
    """Return how many claims there are and of each verdict, and what that does not say."""
    count = Counter(claim.verdict for claim in claims)
    return (
        f'{len(claims)} claims: {count["holds"]} hold as they stand, {count["corrected"]} once '
        f'corrected, {count["fails"]} do not hold; {count["added"]} are additions of Tauto and '
        'hold. The text is a transcription by machine: which of its faults are in the print, only '
        'scans can tell, and none were compared'
    )
