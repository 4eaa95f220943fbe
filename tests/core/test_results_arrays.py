"""A voyage as a dataset of xarray and a frame of pandas: the same numbers, each with its unit."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import tauto_core as tauto
from tauto_core.results import LOGGED, MOTION, OBSERVED, attributes
from tauto_core.samples import FloatArray


@pytest.fixture(scope='module')
def voyage() -> tauto.Voyage:
    return tauto.sail('second_cam_at_sea', duration=60.0)


def test_every_array_of_a_voyage_is_in_one_table(voyage: tauto.Voyage) -> None:
    arrays = {
        name
        for name in dir(tauto.Voyage)
        if not name.startswith('_') and isinstance(getattr(voyage, name), np.ndarray)
    }
    assert sorted(arrays) == sorted([*LOGGED, *OBSERVED, *MOTION])


@pytest.mark.parametrize(
    ('name', 'units', 'words'),
    [
        ('estimated_rate_s_per_day', 's/day', 'estimated rate'),
        ('angular_velocity_rad_s', 'rad/s', 'angular velocity'),
        ('longitude_sigma_nmi', 'nautical_mile', 'longitude sigma'),
        ('temperature_celsius', 'degC', 'temperature'),
        ('motion_gravity_m_s2', 'm/s2', 'motion gravity'),
        ('latitude_deg', 'degrees_north', 'latitude'),
        ('clock_longitude_deg', 'degrees_east', 'clock longitude'),
    ],
)
def test_units_are_those_of_udunits(
    voyage: tauto.Voyage, name: str, units: str, words: str
) -> None:
    assert attributes(voyage, name) == {'units': units, 'long_name': words}


def test_a_dataset_has_the_arrays_with_units(voyage: tauto.Voyage) -> None:
    pytest.importorskip('xarray', reason='the extra `arrays` is not installed')
    found = voyage.to_xarray()
    assert set(found.dims) == {'time_s', 'motion_time_s', 'observation_time_s'}
    assert found.attrs == {'scene': 'second_cam_at_sea', 'answer': voyage.answer}
    for name in (*LOGGED, *OBSERVED, *MOTION):
        array: FloatArray = getattr(voyage, name)
        if not len(array):
            assert name not in found, name
            continue
        assert found[name].to_numpy().tobytes() == array.tobytes(), name
        assert found[name].attrs['long_name'], name
    assert found.clock_error_s.attrs['units'] == 's'
    at = found.clock_error_s.sel(time_s=30.0)
    assert float(at) == voyage.clock_error_s[np.flatnonzero(voyage.time_s == 30.0)[0]]


def test_a_frame_has_the_logged_arrays(voyage: tauto.Voyage) -> None:
    pytest.importorskip('pandas', reason='the extra `arrays` is not installed')
    found = voyage.to_pandas()
    assert found.index.name == 'time_s'
    assert found.loc[60.0, 'clock_error_s'] == voyage.clock_error_s[-1]
    assert 'temperature_celsius' not in found  # the scene has no air
    assert found.attrs['units']['estimated_rate_s_per_day'] == 's/day'


def test_a_body_in_a_fluid_moves_in_metres() -> None:
    pytest.importorskip('xarray', reason='the extra `arrays` is not installed')
    found = tauto.sail('globe_in_oil', duration=20.0).to_xarray()
    assert found.angle_rad.attrs['units'] == 'm'
    assert found.angular_velocity_rad_s.attrs['units'] == 'm/s'


def test_without_the_library_its_extra_is_named(
    voyage: tauto.Voyage, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, 'xarray', None)
    for convert in (voyage.to_xarray, voyage.to_pandas):
        with pytest.raises(tauto.TautoError, match=r"xarray is not .*'tauto_core\[arrays\]'"):
            convert()
