"""Weather and air from a hindcast: linear fields against their closed form along the track."""

import math
import sys

import numpy as np
import pytest
from scipy.integrate import trapezoid

import tauto_core as tauto
from tauto_core.scene import SceneError, load_scene, parse_scene
from tauto_core.scene.loader import scene_yaml
from tauto_core.ship import ShipMotion
from tauto_core.ship.passage import Passage
from tauto_core.ship.weathers.log import grown_seas

xarray = pytest.importorskip('xarray', reason='the extra hindcast is not installed')
pytest.importorskip('h5netcdf', reason='the extra hindcast is not installed')
pytest.importorskip('h5py', reason='the extra hindcast is not installed')

DAYS = 3.0
SAILS_AT, ARRIVES_AT = 7200.0, 7200.0 + 2.0 * 86_400.0

SCENE = """
duration: {duration}
trochlea:
  inertia: 4.0e-4
  cam: {{kind: involute, base_radius: 0.005}}
  thread: {{kind: vertical}}
  power: {{kind: weight, mass: 0.322}}
  release_angle: 1.0
ship:
  kind: sea
  roll: {{natural_period: 11.0, damping_ratio: 0.08, slope_coefficient: 0.7}}
  weather: {weather}
{air}
voyage:
  departure: [{start}]
  arrival: [{end}]
  date: 2010-01-05
  sails_at: 7200.0
  arrives_at: 180000.0
"""

# value at a place and time: constant, per degree north, per degree east, per hour
LINEAR = {
    'swh': (2.0, 0.01, 0.02, 0.005),
    'pp1d': (9.0, 0.03, -0.02, 0.01),
    'mwp': (7.0, 0.03, -0.02, 0.01),
    'mwd': (358.0, 0.5, 0.3, 0.1),
    'u10': (5.0, 0.1, 0.05, -0.03),
    'v10': (-4.0, 0.05, 0.1, 0.02),
    't2m': (290.0, -0.4, 0.05, 0.03),
}
MIDNIGHT = np.datetime64('2010-01-05T00:00', 'ns')


def linear(name, hours, north, east):
    at, per_north, per_east, per_hour = LINEAR[name]
    return at + per_north * (north - 40.0) + per_east * (east + 20.0) + per_hour * hours


def written(
    path,
    names,
    *,
    east=None,
    north=None,
    time='valid_time',
    engine='h5netcdf',
    hours=None,
    changed=None,
):
    """Write linear fields on a grid of half a degree, every two hours, as ERA5 has them."""
    hours = np.arange(0.0, 24.0 * DAYS + 12.0, 2.0) if hours is None else hours
    north = np.arange(45.0, 33.9, -0.5) if north is None else north
    east = np.arange(-25.0, -9.9, 0.5) if east is None else east
    of_track = np.mod(east + 180.0, 360.0) - 180.0
    fields = {}
    for name in names:
        values = linear(name, hours[:, None, None], north[:, None], of_track)
        values = np.broadcast_to(values, (len(hours), len(north), len(east))).copy()
        if name == 'mwd':
            values %= 360.0
        if changed is not None:
            values = changed(name, values, of_track)
        fields[name] = ((time, 'latitude', 'longitude'), values)
    times = MIDNIGHT + np.round(hours * 3600e9).astype('timedelta64[ns]')
    data = xarray.Dataset(fields, {time: times, 'latitude': north, 'longitude': east})
    data.to_netcdf(path, engine=engine)
    return path


def scene_of(file=None, air=None, *, start='40.2, -20.3', end='36.1, -13.7', begins=None, **keys):
    weather = '{kind: states, states: [{at: 0.0, significant_wave_height: 1.0, peak_period: 8.0}]}'
    asked = '' if begins is None else f', begins: {begins}'
    if file is not None:
        weather = f'{{kind: hindcast, path: {file}{asked}}}'
    airs = '' if air is None else f'air: {{kind: hindcast, path: {air}{asked}}}'
    keys = {'duration': 86_400.0 * DAYS, **keys}
    return parse_scene(SCENE.format(weather=weather, air=airs, start=start, end=end, **keys), 'it')


def track(scene, times):
    passage = Passage(scene, scene.voyage)
    latitude, longitude = passage.places(np.round(np.array(times) * 1e9).astype(np.int64))
    return np.array(times) / 3600.0, latitude, longitude


def apart(one, other):
    return np.abs(np.mod(np.asarray(one) - other + math.pi, math.tau) - math.pi).max()


GRIDS = {
    'north first': {},
    'south first, to 360': {
        'north': np.arange(34.0, 45.1, 0.5),
        'east': np.arange(335.0, 350.1, 0.5),
    },
    'round the globe': {'east': np.arange(0.0, 360.0, 2.5)},
    'of 1950': {'time': 'time', 'engine': 'scipy'},
}


@pytest.mark.parametrize('grid', GRIDS.values(), ids=GRIDS.keys())
def test_linear_fields_are_exact_along_the_track(tmp_path, grid):
    file = written(tmp_path / 'era5.nc', ['swh', 'pp1d', 'mwd', 't2m'], **grid)
    scene = scene_of(file, file)
    weather = scene.ship.weather
    assert weather.time[:2] == (SAILS_AT, SAILS_AT + 10_800.0)
    assert weather.time[-1] == ARRIVES_AT
    assert weather.seas[0] == weather.seas[-1] == ()
    heights, periods, waves_to = np.array([row[0] for row in weather.seas[1:-1]]).T
    at = track(scene, weather.time[1:-1])
    np.testing.assert_allclose(heights, linear('swh', *at), rtol=1e-10)
    np.testing.assert_allclose(periods, linear('pp1d', *at), rtol=1e-10)
    # some come from west of north, some from east of it
    waves_from = linear('mwd', *at)
    assert waves_from.min() < 360.0 < waves_from.max()
    assert apart(waves_to, np.radians(waves_from + 180.0)) < 1e-10
    celsius = linear('t2m', *track(scene, scene.air.time)) - 273.15
    np.testing.assert_allclose(scene.air.celsius, celsius, atol=1e-10)
    assert scene.air.kind == 'record'


def as_of_2024(data):
    """Return a file as the store has had it since 2024: with number, and expver by time."""
    versions = np.array(['0001'] * data.sizes['valid_time'], object)
    units = {'swh': 'm', 'pp1d': 's', 'mwd': 'Degree true', 't2m': 'K'}
    for name in data.data_vars:
        data[name].attrs['units'] = units[name]
    return data.assign_coords(number=0, expver=('valid_time', versions))


def as_from_grib(data):
    """Return a file as a reader of GRIB makes it: valid_time is a coordinate, no axis."""
    times = data['valid_time'].to_numpy()
    data = data.rename(valid_time='time')
    return data.assign_coords(valid_time=('time', times), step=0, surface=0.0)


@pytest.mark.parametrize('form', [as_of_2024, as_from_grib])
def test_files_of_the_store_and_from_grib_are_read(tmp_path, form):
    file = written(tmp_path / 'plain.nc', ['swh', 'pp1d', 'mwd', 't2m'])
    with xarray.open_dataset(file) as plain:
        form(plain.load()).to_netcdf(tmp_path / 'other.nc', engine='h5netcdf')
    with xarray.open_dataset(tmp_path / 'other.nc') as other:
        assert {'number', 'surface'} & set(other.coords)
    plain, other = (scene_of(each, each) for each in (file, tmp_path / 'other.nc'))
    assert other.ship.weather.seas == plain.ship.weather.seas
    assert other.air.celsius == plain.air.celsius


def test_tracks_over_greenwich_and_the_date_line_have_no_seam(tmp_path):
    def steady(name, values, east):
        return values - LINEAR[name][2] * (east + 20.0)

    file = written(
        tmp_path / 'era5.nc',
        ['swh', 'pp1d', 'mwd'],
        east=np.arange(0.0, 360.0, 2.5),
        changed=steady,
    )
    for start, end in (('40.2, -2.3', '36.1, 3.7'), ('40.2, 178.1', '36.1, -177.0')):
        scene = scene_of(file, start=start, end=end)
        hours, north, _ = track(scene, scene.ship.weather.time[1:-1])
        heights = [row[0][0] for row in scene.ship.weather.seas[1:-1]]
        np.testing.assert_allclose(heights, linear('swh', hours, north, -20.0), rtol=1e-10)


def test_the_peak_follows_from_bretschneiders_mean_period(tmp_path):
    scene = scene_of(written(tmp_path / 'era5.nc', ['swh', 'mwp', 'mwd']))
    at = track(scene, scene.ship.weather.time[1:-1])
    periods = np.array([row[0][1] for row in scene.ship.weather.seas[1:-1]])
    # moments of the spectrum by numbers, not by the Gamma function
    part = np.linspace(1e-3, 60.0, 600_001)[1:]
    density = part**-5 * np.exp(-1.25 * part**-4)
    mean = trapezoid(density / part, part) / trapezoid(density, part)
    np.testing.assert_allclose(linear('mwp', *at) / periods, mean, rtol=1e-5)


def test_seas_grow_from_the_wind_where_the_file_has_no_waves(tmp_path):
    scene = scene_of(written(tmp_path / 'era5.nc', ['u10', 'v10']))
    times, seas = scene.ship.weather.time[1:-1], scene.ship.weather.seas[1:-1]
    hours, north, east = track(scene, times)
    u, v = linear('u10', hours, north, east), linear('v10', hours, north, east)
    # a wind to the south-east comes from the north-west
    assert u[0] > 0.0 > v[0]
    blows_from = (270.0 - np.degrees(np.arctan2(v, u))) % 360.0
    for row, (sea, _) in zip(seas, grown_seas(hours, np.hypot(u, v), blows_from), strict=True):
        assert row[0][:2] == pytest.approx(sea[:2], rel=1e-10)
        assert apart(row[0][2], math.radians(sea.runs_from + 180.0)) < 1e-10


def test_a_corner_on_land_has_the_value_of_the_nearest_sea(tmp_path):
    def coast(name, values, east):
        del name
        values[:, :, east > -14.6] = np.nan
        return values

    scene = scene_of(written(tmp_path / 'era5.nc', ['swh', 'pp1d', 'mwd'], changed=coast))
    at = track(scene, scene.ship.weather.time[1:-1])
    assert at[2].max() > -14.5
    # the sea nearest to two meridians of land is that at 15° W, 90 km from the second
    expected = linear('swh', at[0], at[1], np.minimum(at[2], -15.0))
    heights = [row[0][0] for row in scene.ship.weather.seas[1:-1]]
    np.testing.assert_allclose(heights, expected, rtol=1e-10)


def far_inland(name, values, east):
    del name
    values[:, :, east > -16.1] = np.nan
    return values


WRONG = {
    'land': ({'changed': far_inland}, {}, 'has no value within 100 km of'),
    'before': ({}, {'begins': '2009-12-31T00:00'}, 'lasts from 2010-01-05T00:00 to 2010-01-08T10'),
    'outside': ({'east': np.arange(-25.0, -14.9, 0.5)}, {}, 'longitude: goes from -25° to -15°'),
    'months': ({'hours': np.arange(0.0, 240.0, 24.0)}, {}, 'has no field for 24 h about'),
    'no port': ({}, {'start': '31.0, -20.3'}, 'latitude: goes from 34° to 45°'),
}


@pytest.mark.parametrize(('file', 'keys', 'said'), WRONG.values(), ids=WRONG.keys())
def test_a_track_without_values_is_refused_with_place_and_time(tmp_path, file, keys, said):
    path = written(tmp_path / 'era5.nc', ['swh', 'pp1d', 'mwd'], **file)
    with pytest.raises(SceneError) as refused:
        scene_of(path, **keys)
    assert said in str(refused.value)
    assert 'UTC' in str(refused.value)


def sized(name, factor, unit=None):
    """Return a change of a file: a field times a factor, in another unit."""

    def change(data):
        attributes = {} if unit is None else {'units': unit}
        return data.assign({name: (data[name] * factor).assign_attrs(attributes)})

    return change


FAULTS = {
    'in feet': (sized('swh', 3.28, 'ft'), "swh, units = 'ft': must be m"),
    'in radians': (sized('mwd', 0.0175, 'rad'), "mwd, units = 'rad': must be degrees"),
    'in centimetres': (sized('swh', 100.0), 'swh = 201.5: must be between 0 and 30 m, here near'),
    'in celsius': (
        lambda data: data.assign(t2m=data.t2m - 273.15),
        't2m = 16.825: must be between 213.15 and 333.15 K, here near 40.20°, -20.30° on 2010-01',
    ),
    'without a period': (sized('pp1d', 0.0), 'pp1d = 0.0: must be between 0.1 and 60 s'),
    'below zero': (sized('swh', -1.0), 'swh = -2.015: must be between 0 and 30 m'),
    'a fill value that is not marked': (sized('mwd', 0.0), 'mwd = -32767.0: must be between'),
    'words': (lambda data: data.assign(swh=data.swh.astype(str)), 'swh: is not numeric'),
    'backwards': (
        lambda data: data.isel(valid_time=slice(None, None, -1)),
        'does not increase from value to value: 2010-01-08T08:00 after 2010-01-08T10:00',
    ),
    'a time twice': (
        lambda data: data.isel(valid_time=[0, 1, 1, *range(2, 42)]),
        '2010-01-05T02:00 after 2010-01-05T02:00',
    ),
    'one time': (
        lambda data: data.isel(valid_time=[0]),
        'at least two values; the file has valid_time (1), latitude (23), longitude (31)',
    ),
    'times without a unit': (
        lambda data: data.assign_coords(valid_time=np.arange(42.0)),
        'is not a time in UTC',
    ),
}


@pytest.mark.parametrize(('change', 'said'), FAULTS.values(), ids=FAULTS.keys())
def test_a_file_with_a_fault_is_refused_once_by_field_and_value(tmp_path, change, said):
    with xarray.open_dataset(
        written(tmp_path / 'sound.nc', ['swh', 'pp1d', 'mwd', 't2m'])
    ) as sound:
        data = change(sound.load())
    if '-32767' in said:
        data['mwd'] -= 32767.0
    file = tmp_path / 'era5.nc'
    data.to_netcdf(file, engine='h5netcdf')
    with pytest.raises(SceneError) as refused:
        scene_of(file, file)
    assert str(refused.value).startswith(f'{file}: ')
    assert '\n' not in str(refused.value)
    assert said in str(refused.value).replace('16.825000000000045', '16.825')
    assert refused.value.remedy


def test_other_and_damaged_files_are_refused_by_their_format(tmp_path):
    whole = written(tmp_path / 'whole.nc', ['swh', 'pp1d', 'mwd']).read_bytes()
    for content, said in (
        (b'PK\x03\x04 and more', 'is a ZIP archive, not NetCDF. Unpack it'),
        (b'GRIB and more', 'is GRIB, not NetCDF. Fetch it as NetCDF'),
        (b'', 'is not NetCDF'),
        (b'time,swh', 'is not NetCDF'),
        (whole[:3000], 'truncated file'),
        (b'CDF\x01' + bytes(20), 'cannot be read as NetCDF'),
    ):
        (tmp_path / 'era5.nc').write_bytes(content)
        with pytest.raises(SceneError, match=said):
            scene_of(tmp_path / 'era5.nc')


def test_a_file_larger_than_other_data_is_read_about_the_track(tmp_path):
    file = written(tmp_path / 'era5.nc', ['swh', 'pp1d', 'mwd'])
    expected = scene_of(file).ship.weather.seas
    with file.open('r+b') as stream:
        stream.truncate(2**28 + 1)  # a sparse file, which takes no room
    assert scene_of(file).ship.weather.seas == expected


def test_missing_fields_files_and_libraries_are_refused(tmp_path, monkeypatch):
    with pytest.raises(SceneError, match=r'mwd.* is missing; the file has swh, pp1d'):
        scene_of(written(tmp_path / 'half.nc', ['swh', 'pp1d']))
    with pytest.raises(SceneError, match=r'swh or u10.* is missing; the file has t2m'):
        scene_of(written(tmp_path / 'air.nc', ['t2m']))
    with xarray.open_dataset(tmp_path / 'half.nc') as half:
        half.expand_dims(expver=2).to_netcdf(tmp_path / 'two.nc', engine='h5netcdf')
    with pytest.raises(SceneError, match=r'swh.* has more than times.* with one value of expver'):
        scene_of(tmp_path / 'two.nc')
    with pytest.raises(SceneError, match=r'ship\.weather\.path'):
        scene_of(tmp_path / 'nowhere.nc')
    monkeypatch.setitem(sys.modules, 'h5netcdf', None)
    with pytest.raises(SceneError, match=r"pip install 'tauto_core\[hindcast\]'"):
        scene_of(tmp_path / 'air.nc')


def test_the_voyage_must_have_a_day(tmp_path):
    file = written(tmp_path / 'era5.nc', ['swh', 'pp1d', 'mwd'])
    keys = {'duration': '60.0', 'start': '40.2, -20.3', 'end': '36.1, -13.7', 'air': ''}
    weather = f'{{kind: hindcast, path: {file}}}'
    text = SCENE.format(weather=weather, **keys)
    with pytest.raises(SceneError, match=r'ship\.weather\.begins.*the day of sailing is unknown'):
        parse_scene(text.replace('  date: 2010-01-05\n', ''), 'it')
    with pytest.raises(SceneError, match=r'needs a voyage'):
        parse_scene(text[: text.index('voyage:')], 'it')


def test_a_scene_keeps_rows_and_motion_without_the_file(tmp_path):
    file = written(tmp_path / 'era5.nc', ['swh', 'pp1d', 'mwd', 't2m'])
    scene = scene_of(file, file)
    short = scene_of(file, duration=60_000.0)
    file.unlink()
    again = parse_scene(scene_yaml(scene), 'again')
    assert again.ship == scene.ship
    assert again.air == scene.air
    assert str(file) not in scene_yaml(scene)
    bits = []
    for each in (scene, again, short):
        motion = ShipMotion(each)
        motion.restore({'next': int(50_000.0 * each.ship.rate)})
        imu = motion.produce(400)
        assert np.abs(imu.angular_velocity).max() > 1e-3
        bits.append(imu.angular_velocity.tobytes() + imu.linear_acceleration.tobytes())
    assert bits[0] == bits[1] == bits[2]
    with pytest.raises(SceneError, match=r'ship\.weather\.time'):
        ShipMotion(load_scene(short, duration=100_000.0))


@pytest.mark.usefixtures('short_trials')
def test_a_scene_file_is_checked_and_sails(tmp_path):
    written(tmp_path / 'era5.nc', ['swh', 'pp1d', 'mwd', 't2m'])
    keys = {'duration': '60.0', 'start': '40.2, -20.3', 'end': '36.1, -13.7'}
    asked = '{kind: hindcast, path: era5.nc, begins: 2010-01-05T00:00}'
    text = SCENE.format(weather=asked, air=f'air: {asked}', **keys)
    text = text.replace('sails_at: 7200.0', 'sails_at: 0.0').replace('  date: 2010-01-05\n', '')
    file = tmp_path / 'ship.yaml'
    file.write_text(text)
    states = tauto.check(file)['weather']['states']
    assert [each['at_s'] for each in states] == [0.0, 10_800.0]
    hours, north, east = track(load_scene(file), [10_800.0])
    height, period = (float(linear(name, hours, north, east)[0]) for name in ('swh', 'pp1d'))
    assert states[0]['significant_wave_height_m'] == 0.0
    assert states[1]['significant_wave_height_m'] == pytest.approx(height, rel=1e-10)
    assert states[1]['peak_period_s'] == pytest.approx(period, rel=1e-10)
    voyage = tauto.sail(file)
    assert voyage.result['clock']['reading_s'] == pytest.approx(60.0, abs=1.0)
    celsius = float(linear('t2m', 0.0, 40.2, -20.3)) - 273.15
    assert voyage.result['air']['lowest_celsius'] == pytest.approx(celsius, abs=0.001)
