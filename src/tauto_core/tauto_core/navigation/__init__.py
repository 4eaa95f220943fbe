"""Navigation: drift of the clock, the route, longitude by the clock, the prize."""

from tauto_core.navigation.assumptions import clock_model
from tauto_core.navigation.drift import DriftStage
from tauto_core.navigation.drift_warnings import drift_warnings
from tauto_core.navigation.estimates import ESTIMATE_NAMES, estimate_names
from tauto_core.navigation.filtering import Filtered, Known, filter_phases
from tauto_core.navigation.kalman import ClockModel, Estimate, predict, prior, update
from tauto_core.navigation.longitude import ERROR_NAMES, LongitudeStage
from tauto_core.navigation.prize import (
    LEAST_UNCHECKED_DAYS,
    prize_pounds,
    required_rate_s_per_day,
)
from tauto_core.navigation.projection import forgets_its_start, projection
from tauto_core.navigation.rate_scatter import RateError, RateScatter
from tauto_core.navigation.rated_time import RatedTime
from tauto_core.navigation.route import Route
from tauto_core.navigation.tally import LongitudeTally

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
    'forgets_its_start',
    'predict',
    'prior',
    'prize_pounds',
    'projection',
    'required_rate_s_per_day',
    'update',
]
