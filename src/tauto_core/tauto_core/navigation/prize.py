"""The verdict of the Longitude Act of 1714 (13 Ann. c. 14)."""

from __future__ import annotations

import math

from tauto_core.navigation.longitude import ARCMIN_PER_S
from tauto_core.scene.errors import EstimationError
from tauto_core.scene.voyages import WIDEST_AWARD_NMI

AWARDS = ((30.0, 20_000), (40.0, 15_000), (WIDEST_AWARD_NMI, 10_000))
"""(distance [nautical miles], pounds): half a degree, two thirds of a degree, one degree."""

LEAST_UNCHECKED_DAYS = 42.0
"""Six weeks, a voyage to the West Indies; a shorter voyage does not qualify for the prize."""


def prize_pounds(distance_nmi: float) -> int:
    """Return what the Act pays for a longitude found within a distance [pounds].

    £20,000 within 30 miles, £15,000 within 40, £10,000 within 60, the limits included, else 0
    (theory E6).

    Args:
        distance_nmi: error of the longitude as a distance [nautical miles], >= 0.

    Raises:
        EstimationError: NaN or a negative distance.
    """
    if not distance_nmi >= 0.0:
        raise EstimationError(
            f'distance = {distance_nmi} nmi: must be a number >= 0. '
            'Give the magnitude of the error in nautical miles'
        )
    return next((pounds for limit, pounds in AWARDS if distance_nmi <= limit), 0)


def required_rate_s_per_day(days: float, latitude_deg: float) -> float:
    """Return the error of the rate [s/day] that just keeps within the first award, 30 miles.

    30 nmi/(cos φ · ¼ arcmin/s · days): a constant error, since the clock was last compared with
    the true time (theory E6).

    Args:
        days: time since that comparison [days], > 0.
        latitude_deg: latitude of the landfall [degrees].

    Raises:
        EstimationError: no time has passed.
    """
    if not days > 0.0:
        raise EstimationError(
            f'days = {days}: must be > 0. Give the time since the clock was last compared'
        )
    seconds = AWARDS[0][0] / (ARCMIN_PER_S * math.cos(math.radians(latitude_deg)))
    return seconds / days
