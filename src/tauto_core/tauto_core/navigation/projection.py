"""The error that the rate of a short run would cause on a voyage of the Act of 1714."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from tauto_core.navigation.estimates import mean_rate
from tauto_core.navigation.kalman import ClockModel, Estimate, predict
from tauto_core.navigation.longitude import ARCMIN_PER_S
from tauto_core.samples import SECONDS_PER_DAY

PROJECTED_DAYS = (42.0, 81.0)
"""Six weeks, about a passage to the West Indies, to which the Act sends the clock; and the days
that H4 went between its comparisons at Portsmouth and in Jamaica, 1761 to 1762.
"""


def projection(
    clock: Mapping[str, Any],
    estimate: Mapping[str, float],
    model: ClockModel,
    latitude_deg: float,
) -> list[dict[str, Any]]:
    """Return the error after `PROJECTED_DAYS` unchecked of a clock set right at departure.

    The dial gains y T, which puts the ship y T · ¼ arcmin/s · cos φ to the west. Correction by the
    estimated rate ŷ leaves (y − ŷ) T. Its standard deviation is that of the navigator's model
    (`kalman.predict`, from an exact offset); that of y T follows from the standard error of y.

    Args:
        clock: figures of the clock, among them y, the mean rate of the dial over the run,
            `rate_s_per_day` [s/day, fast is positive], and its standard error or None,
            `rate_standard_error_s_per_day`.
        estimate: the last estimate, with ŷ and its standard deviation (`estimates.mean_rate`). A
            rate that depends on the ship's motion assumes that the motion continues.
        model: the model of the clock, for the noise that accumulates under way; without
            coefficients.
        latitude_deg: φ of the landfall [degrees].

    Returns:
        For each number of `days`: `raw_error_nmi` of the dial, `error_nmi` of the corrected
        clock, both positive to the east, and the standard deviations `raw_sigma_nmi` (None where
        that of y is not known) and `sigma_nmi`.
    """
    nmi_per_s = ARCMIN_PER_S * math.cos(math.radians(latitude_deg))
    rate, scatter = clock['rate_s_per_day'], clock['rate_standard_error_s_per_day']
    estimated, sigma = mean_rate(estimate)
    left = rate - estimated

    def sigma_nmi(days: float, rate_sigma_s_per_day: float) -> float:
        variance = (rate_sigma_s_per_day / SECONDS_PER_DAY) ** 2
        known = Estimate(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, variance, 0.0, 0.0)
        return math.sqrt(predict(known, days * SECONDS_PER_DAY, model).xx) * nmi_per_s

    return [
        {
            'days': days,
            'raw_error_nmi': -rate * days * nmi_per_s,
            'raw_sigma_nmi': None if scatter is None else sigma_nmi(days, scatter),
            'error_nmi': -left * days * nmi_per_s,
            'sigma_nmi': sigma_nmi(days, sigma),
        }
        for days in PROJECTED_DAYS
    ]
