"""The arrays of a voyage as a dataset of xarray and as a frame of pandas, with their units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tauto_core.scene.errors import TautoError, install

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

    from tauto_core.voyage import Voyage

LOGGED: dict[str, tuple[str, str]] = {
    'time_s': ('s', 'true time since the first reading'),
    'clock_error_s': ('s', 'reading of the dial less the true time'),
    'corrected_error_s': ('s', 'corrected reading less the true time'),
    'offset_s': ('s', 'estimated error of the dial'),
    'offset_sigma_s': ('s', 'standard deviation of the estimated error of the dial'),
    'rate_s_per_day': ('s/day', 'estimated rate of the dial; with covariates at rest'),
    'rate_sigma_s_per_day': ('s/day', 'standard deviation of the estimated rate'),
    'mean_rate_s_per_day': ('s/day', 'estimated rate; with covariates its mean since the start'),
    'mean_rate_sigma_s_per_day': ('s/day', 'standard deviation of the mean rate'),
    'angle_rad': ('rad', 'angle of the wheel in its case'),
    'angular_velocity_rad_s': ('rad/s', 'angular velocity of the wheel in its case'),
    'phase_rad': ('rad', 'phase of the swing since the release'),
    'raw_longitude_error_nmi': ('nautical_mile', 'error of the longitude by the dial, east'),
    'longitude_error_nmi': (
        'nautical_mile',
        'error of the longitude by the corrected clock, east',
    ),
    'longitude_sigma_nmi': ('nautical_mile', 'standard deviation of the longitude'),
    'latitude_deg': ('degrees_north', 'true latitude of the ship'),
    'longitude_deg': ('degrees_east', 'true longitude of the ship'),
    'clock_longitude_deg': ('degrees_east', 'longitude of the ship by the corrected clock'),
    'temperature_celsius': ('degC', 'temperature in the box of the clock'),
    'roll_rad': ('rad', 'roll of the ship, starboard side down'),
}
"""Units and meanings of the arrays with a value for each logged sample, the time first.

The units are those of the UDUNITS library, which the CF conventions use.
"""

OBSERVED: dict[str, tuple[str, str]] = {
    'observation_time_s': ('s', 'time of an observation, from the first reading'),
    'observed_error_s': ('s', 'reading less the true time as it was observed'),
}
"""The same with a value for each observation."""

MOTION: dict[str, tuple[str, str]] = {
    'motion_time_s': ('s', 'time of a sample of the motion, from the first reading'),
    'motion_roll_rad': ('rad', 'roll of the ship, starboard side down'),
    'motion_gravity_m_s2': ('m/s2', 'apparent gravity at the clock'),
}
"""The same with a value for each sample of the ship's motion."""

ON_A_CURVE: dict[str, tuple[str, str]] = {
    'angle_rad': ('m', 'arc of the body from its lowest point'),
    'angular_velocity_rad_s': ('m/s', 'speed of the body'),
}
"""What two arrays hold where a regulator stands in place of the wheel."""


def dataset(voyage: Voyage) -> Dataset:
    """Return the arrays of a voyage as a dataset; see `Voyage.to_xarray`."""
    try:
        import xarray
    except ModuleNotFoundError:
        raise _missing('xarray') from None
    held: dict[str, Any] = {}
    for table in (LOGGED, OBSERVED, MOTION):
        axis = next(iter(table))
        for name, values in _arrays(voyage, table).items():
            unit, meaning = _said(voyage, name, table)
            held[name] = axis, values, {'units': unit, 'long_name': meaning}
    return xarray.Dataset(held, attrs={'scene': voyage.scene.name, 'answer': voyage.answer})


def frame(voyage: Voyage) -> DataFrame:
    """Return the logged arrays of a voyage as a frame; see `Voyage.to_pandas`."""
    try:
        import pandas as pd
    except ModuleNotFoundError:
        raise _missing('pandas') from None
    arrays = _arrays(voyage, LOGGED)
    found = pd.DataFrame(arrays).set_index(next(iter(LOGGED)))
    units = {name: _said(voyage, name, LOGGED)[0] for name in arrays}
    found.attrs = {'scene': voyage.scene.name, 'answer': voyage.answer, 'units': units}
    return found


def _arrays(voyage: Voyage, table: dict[str, tuple[str, str]]) -> dict[str, np.ndarray]:
    """Return the arrays of a table that the voyage has."""
    found = {name: getattr(voyage, name) for name in table}
    return {name: values for name, values in found.items() if len(values)}


def _said(voyage: Voyage, name: str, table: dict[str, tuple[str, str]]) -> tuple[str, str]:
    """Return unit and meaning of an array."""
    return (ON_A_CURVE if voyage.scene.regulator is not None else {}).get(name, table[name])


def _missing(library: str) -> TautoError:
    return TautoError(f'{library} is not installed. Run {install("arrays")}')
