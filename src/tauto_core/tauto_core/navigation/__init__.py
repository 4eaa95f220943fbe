"""Navigation: drift of the clock, the route, longitude by the clock, the prize."""

from tauto_core.navigation.covariates import clock_model
from tauto_core.navigation.drift import ESTIMATE_NAMES, DriftStage, drift_warnings, estimate_names
from tauto_core.navigation.kalman import (
    ClockModel,
    Estimate,
    Filtered,
    Known,
    filter_phases,
    predict,
    prior,
)
from tauto_core.navigation.longitude import (
    ERROR_NAMES,
    LEAST_UNCHECKED_DAYS,
    LongitudeStage,
    Route,
    grade,
    prize_pounds,
    required_rate_s_per_day,
)
from tauto_core.navigation.verdict import (
    LongitudeTally,
    RatedTime,
    RateError,
    RateScatter,
    has_settled,
    projection,
)

__all__ = [
    'ERROR_NAMES',
    'ESTIMATE_NAMES',
    'LEAST_UNCHECKED_DAYS',
    'ClockModel',
    'DriftStage',
    'Estimate',
    'Filtered',
    'Known',
    'LongitudeStage',
    'LongitudeTally',
    'RateError',
    'RateScatter',
    'RatedTime',
    'Route',
    'clock_model',
    'drift_warnings',
    'estimate_names',
    'filter_phases',
    'grade',
    'has_settled',
    'predict',
    'prior',
    'prize_pounds',
    'projection',
    'required_rate_s_per_day',
]
