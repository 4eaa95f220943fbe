"""The verdict of the Longitude Act of 1714 (12 Anne c. 15)."""

from __future__ import annotations

from tauto_core.scene.errors import EstimationError

AWARDS = ((30.0, 20_000), (40.0, 15_000), (60.0, 10_000))
"""(distance [nautical miles], pounds): within half a degree, two thirds, one degree."""


def prize_pounds(distance_nmi: float) -> int:
    """Return what the Act pays for a longitude found within a distance [pounds].

    £20,000 within 30 miles, £15,000 within 40, £10,000 within 60, the limits included, else 0
    (theory E6).

    Args:
        distance_nmi: how far from the truth the ship is put [nautical miles], >= 0.

    Raises:
        EstimationError: NaN or a negative distance.
    """
    if not distance_nmi >= 0.0:
        raise EstimationError(
            f'distance = {distance_nmi} nmi: must be a number >= 0. '
            'Give the magnitude of the error in nautical miles'
        )
    return next((pounds for limit, pounds in AWARDS if distance_nmi <= limit), 0)
