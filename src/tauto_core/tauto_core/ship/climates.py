"""Wave climates with their sources, for `weathers.climate`.

From a record of hourly significant wave heights Hs: the median is exp⟨ln Hs⟩, the deviation is
that of ln Hs, and the correlation time τ follows from exp(−24 h/τ) = the autocorrelation of ln Hs
at a lag of a day.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from tauto_core.scene.times import DAY_S

HOUR_S = DAY_S / 24.0


class Climate(NamedTuple):
    """The wave climate of a part of the ocean in a season.

    Attributes:
        median_wave_height: median of the significant wave heights [m].
        log_deviation: standard deviation of their logarithm.
        correlation_time: correlation time of the logarithm [s].
        steepness: significant steepness s_p = 2π Hs/(g Tp²).
        waves_to: direction in which the waves run, from north to the east [rad]; None: not known.
        source: source of these numbers.
    """

    median_wave_height: float
    log_deviation: float
    correlation_time: float
    steepness: float
    waves_to: float | None
    source: str


CLIMATES = {
    'north_atlantic_winter': Climate(
        median_wave_height=4.06,
        log_deviation=0.42,
        correlation_time=41.0 * HOUR_S,
        # 0.040 by the record's mean period, which in a Bretschneider sea is 0.710 Tp (ITTC)
        steepness=0.020,
        waves_to=math.radians(76.0),
        source='Marine Institute of Ireland, buoy M6 (53.07 N, 15.88 W), 2156 hours of November '
        '2025 to January 2026',
    ),
    'trades': Climate(
        median_wave_height=1.31,
        log_deviation=0.30,
        correlation_time=70.0 * HOUR_S,
        # that of a fully developed sea (Pierson and Moskowitz, J. Geophys. Res. 69, 1964):
        # Hs = 0.209 U²/g and Tp = 7.16 U/g at any wind U
        steepness=0.0256,
        waves_to=math.radians(267.0),
        source='NDBC buoy 42060 (16.4 N, 63.3 W), 58,452 records of November to April, '
        '2009 to 2025; steepness of a fully developed sea',
    ),
}
"""The climates by their names in `ship.weather.regions[…].climate`."""
