"""A voyage as a dataset of xarray and a frame of pandas: the same numbers, each with its unit."""

from __future__ import annotations

import inspect
import re
import sys

import numpy as np
import pytest

import tauto_core as tauto
from tauto_core.results import LOGGED, MOTION, OBSERVED
from tauto_core.samples import FloatArray

SUFFIXES = {
    '_s': 's',
    '_s_per_day': 's/day',
    '_rad': 'rad',
    '_rad_s': 'rad/s',
    '_nmi': 'nautical_mile',
    '_celsius': 'degC',
    '_m_s2': 'm/s2',
}


@pytest.fixture(scope='module')
def voyage() -> tauto.Voyage:
    return tauto.sail('second_cam_at_sea', duration=60.0)


def test_every_array_of_a_voyage_has_the_unit_of_its_name() -> None:
    named = {
        name: getattr(value, 'fget', None) or getattr(value, 'func', None)
        for name, value in inspect.getmembers(tauto.Voyage)
        if not name.startswith('_')
    }
    arrays = {
        name
        for name, function in named.items()
        if function and 'FloatArray' in function.__annotations__['return']
    }
    tables = LOGGED | OBSERVED | MOTION
    assert arrays == set(tables)
    for name, (unit, _) in tables.items():
        suffix = re.search('_(?:s|s_per_day|rad|rad_s|nmi|celsius|m_s2|deg)$', name)[0]
        assert unit == SUFFIXES.get(suffix, unit), name
        assert (suffix == '_deg') == unit.startswith('degrees_'), name


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


@pytest.mark.parametrize('library', ['xarray', 'pandas'])
def test_without_the_library_its_extra_is_named(
    voyage: tauto.Voyage, library: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(tauto.TautoError, match=rf"{library} is not .*'tauto_core\[arrays\]'"):
        getattr(voyage, f'to_{library}')()
