"""Weather and air along the voyage from a hindcast: NetCDF with the names of ERA5.

The waves are `swh` [m], `pp1d` or `mwp` [s] and `mwd` [degrees, from which they come]. If the file
has none, seas grow from the winds `u10` and `v10` [m/s] as from a log's. The air is `t2m` [K].
Values are linear in time, latitude and longitude. The running scene contains the values along the
track, every `INTERVAL_S`.

Names and units are from the ECMWF parameter database (140229, 140231, 140232, 140230, 165, 166,
167).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import date
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol

import numpy as np
from pydantic import Field

from tauto_core.samples import FloatArray
from tauto_core.scene.errors import ABSENT, SceneError, install
from tauto_core.scene.sections import LONGEST_TEXT, Flag, Itinerary, OneLine
from tauto_core.scene.tables import data_path, source_name, utc, words_of
from tauto_core.scene.times import DAY_S, NS_PER_S, nanoseconds
from tauto_core.ship.airs import AirKind
from tauto_core.ship.motions import Surroundings
from tauto_core.ship.passage import Passage
from tauto_core.ship.sea_files import section_read
from tauto_core.ship.sections import names_hindcast
from tauto_core.ship.weathers import HIGHEST_M, WeatherKind
from tauto_core.ship.weathers.log import RIPPLES_M, grown_seas

if TYPE_CHECKING:
    import xarray

INTERVAL_S = 10_800.0
"""Time between the rows of a scene [s]."""

LONGEST_STEP_S = 43_200.0
"""Longest time between two fields of the file [s]. Monthly means do not describe weather."""

NEAREST_SEA_KM = 100.0
"""Largest distance of the sea from which a corner on land takes its value."""

MEAN_OF_PEAK = 1.25**-0.25 * math.gamma(1.25)
"""Mean period `mwp`, m₋₁/m₀, over the peak period of Bretschneider's spectrum: 0.857.

With m_n = ∫ fⁿ S df and S ∝ f⁻⁵ exp(−(5/4)(f_p/f)⁴), it is (5/4)^(−1/4) Γ(5/4).
"""

KELVIN = 273.15


class FieldUnit(NamedTuple):
    """Unit of a field in messages, its spellings in files, and the limits of the values."""

    unit: str
    low: float
    high: float
    spelled: frozenset[str]


_M_S = FieldUnit('m/s', -60.0, 60.0, frozenset({'m s**-1', 'm s-1', 'm/s', 'm s^-1'}))
_S = FieldUnit('s', 0.1, 60.0, frozenset({'s', 'sec', 'second', 'seconds'}))
FIELDS = {
    'swh': FieldUnit('m', 0.0, HIGHEST_M, frozenset({'m', 'metre', 'metres', 'meter', 'meters'})),
    'pp1d': _S,
    'mwp': _S,
    'mwd': FieldUnit(
        'degrees',
        -360.0,
        720.0,  # packed values pass 360 by a little
        frozenset({'degree', 'degrees', 'degree true', 'degrees true', 'degree_true', 'deg', '°'}),
    ),
    'u10': _M_S,
    'v10': _M_S,
    't2m': FieldUnit('K', 213.15, 333.15, frozenset({'k', 'kelvin'})),
}
"""The fields by ERA5's names."""

_KM_PER_DEG = 111.0
_ROWS_AT_ONCE = 32
_TIMES, _LATITUDES, _LONGITUDES = ('valid_time', 'time'), ('latitude', 'lat'), ('longitude', 'lon')
_AXES = (_TIMES, _LATITUDES, _LONGITUDES)
_FORM = 'Give NetCDF of ERA5 on single levels, as the Climate Data Store has it.'
_FORMATS = (
    (
        b'PK\x03\x04',
        'is a ZIP archive, not NetCDF',
        'Unpack it: the store packs waves and air as two files.',
    ),
    (b'GRIB', 'is GRIB, not NetCDF', 'Fetch it as NetCDF, which the store offers as well.'),
)
_BEGINS = (
    'UTC at the start of the scene, as 2010-01-05T12:00. When left out it follows from voyage.date'
)


class HindcastFile(WeatherKind):
    """Seas along the voyage from a hindcast. The running scene contains them.

    NetCDF with the names of ERA5: swh, mwd, and pp1d or mwp; or u10 and v10, from which a wind sea
    and a swell grow. Needs the extra `hindcast`.
    """

    kind: Literal['hindcast'] = 'hindcast'
    path: OneLine = Field(description='NetCDF file')
    begins: OneLine | None = Field(default=None, description=_BEGINS)
    follow_route: Flag = Field(
        default=True,
        description='true: speed and heading from the voyage; false: from ship.speed and '
        'ship.heading',
    )


class AirHindcastFile(AirKind):
    """Air along the voyage from a hindcast. The running scene contains a record of it.

    NetCDF with ERA5's name t2m. Needs the extra `hindcast`.
    """

    kind: Literal['hindcast'] = 'hindcast'
    path: OneLine = Field(description='NetCDF file')
    begins: OneLine | None = Field(default=None, description=_BEGINS)


class PlaceSource(Surroundings, Protocol):
    """The source of the ship's places and times."""

    @property
    def starts_at(self) -> float:
        """Stamp of the first sample [s]."""


def with_hindcast_read(content: dict[str, Any], scene: PlaceSource, origin: str) -> dict[str, Any]:
    """Return the unchecked keys of a scene with the values of hindcasts along its voyage.

    `scene` is the same voyage, checked, and `origin` its name in errors.

    Raises:
        SceneError: no voyage, wrong keys or files, or a track outside a file.
    """
    read = dict(content)
    ship = content.get('ship')
    if isinstance(ship, dict) and names_hindcast(ship.get('weather')):
        weather = partial(hindcast_weather, scene=scene)
        keys = section_read(HindcastFile, weather, ship, 'weather.path', origin, any_size=True)
        read['ship'] = {**ship, 'weather': keys}
    if names_hindcast(content.get('air')):
        air = partial(hindcast_air, scene=scene)
        read['air'] = section_read(
            AirHindcastFile, air, content, 'air.path', origin, prefix='', any_size=True
        )
    return read


def hindcast_weather(file: HindcastFile, scene: PlaceSource) -> dict[str, Any]:
    """Return the keys of `ship.weather` with the seas along the voyage.

    Both harbours are calm. Between them there is a row every `INTERVAL_S` from setting sail, the
    last at least half of it before arrival.
    """
    voyage, start_s = _voyage_and_start(scene, file.begins, 'ship.weather')
    passage, step_ns = Passage(scene, voyage), nanoseconds(INTERVAL_S)
    last_ns = passage.arrives_ns - step_ns // 2
    # with the row after the end, since the sea of a scene does not depend on its duration
    end_ns = min(last_ns, scene.duration_ns + step_ns)
    at_ns = np.array(range(passage.sails_ns + step_ns, end_ns + 1, step_ns), np.int64)
    if last_ns < passage.sails_ns + step_ns:
        under_way_h = (passage.arrives_ns - passage.sails_ns) / NS_PER_S / 3600.0
        problem = (
            f'has rows every {INTERVAL_S / 3600.0:g} h, but the passage lasts {under_way_h:.3g} h'
        )
        remedy = f'Sail for at least {1.5 * INTERVAL_S / 3600.0:g} h, or use weather kind states.'
        raise SceneError(scene.name, 'ship.weather.kind', file.kind, problem, remedy)
    with opened(file.path) as grid:
        track = (start_s + at_ns / NS_PER_S, *passage.places(at_ns))
        if grid.one_of('swh', 'u10') == 'swh':
            name = grid.one_of('pp1d', 'mwp')
            heights, directions = grid.along('swh', *track), grid.along('mwd', *track, turns=True)
            periods = grid.along(name, *track) / (1.0 if name == 'pp1d' else MEAN_OF_PEAK)
            rows = zip(heights.tolist(), periods.tolist(), directions.tolist(), strict=True)
            seas = [[row] for row in rows]
        else:
            east, north = grid.along('u10', *track), grid.along('v10', *track)
            winds, winds_from = np.hypot(east, north), np.degrees(np.arctan2(-east, -north))
            hours = at_ns / NS_PER_S / 3600.0
            grown = grown_seas(hours.tolist(), winds.tolist(), (winds_from % 360.0).tolist())
            seas = [[(*sea,) for sea in pair] for pair in grown]
    waves = [
        [
            [height, period, math.radians(come_from + 180.0) % math.tau]
            for height, period, come_from in row
            if height >= RIPPLES_M
        ]
        for row in seas
    ]
    arrives = passage.arrives_ns <= scene.duration_ns + step_ns
    times = [passage.sails_ns, *at_ns.tolist(), *[passage.arrives_ns] * arrives]
    return {
        **file.model_dump(exclude={'path', 'begins'}),
        'source': source_name(file.path)[-LONGEST_TEXT:],
        'time': [at_ns / NS_PER_S for at_ns in times],
        'seas': [[], *waves, *[[]] * arrives],
    }


def hindcast_air(file: AirHindcastFile, scene: PlaceSource) -> dict[str, Any]:
    """Return the keys of `air`, of kind record, with the temperatures along the voyage."""
    voyage, start_s = _voyage_and_start(scene, file.begins, 'air')
    step_ns = nanoseconds(INTERVAL_S)
    at_ns = np.array(range(0, scene.duration_ns + step_ns, step_ns), np.int64)
    with opened(file.path) as grid:
        places = Passage(scene, voyage).places(at_ns)
        celsius = grid.along(grid.one_of('t2m'), start_s + at_ns / NS_PER_S, *places) - KELVIN
    return {
        **file.model_dump(exclude={'path', 'begins', 'kind'}),
        'kind': 'record',
        'source': source_name(file.path)[-LONGEST_TEXT:],
        'time': (at_ns / NS_PER_S).tolist(),
        'celsius': celsius.tolist(),
    }


def _voyage_and_start(scene: PlaceSource, begins: str | None, key: str) -> tuple[Itinerary, float]:
    """Return the voyage, and UTC at the start of the scene, from 1970 [s]."""
    voyage = scene.voyage
    if voyage is None:
        problem, remedy = 'needs a voyage', 'Write `voyage: …`.'
        raise SceneError(scene.name, f'{key}.kind', 'hindcast', problem, remedy)
    if begins is not None:
        return voyage, utc(scene.name, f'{key}.begins', begins).timestamp()
    if voyage.date is None:
        problem = 'is missing, and so is voyage.date: the day of sailing is unknown'
        remedy = 'Write `begins: 2010-01-05T12:00`, UTC at the start of the scene.'
        raise SceneError(scene.name, f'{key}.begins', ABSENT, problem, remedy)
    days = voyage.day_at(scene.starts_at, scene.starts_at) - date(1970, 1, 1).toordinal()
    return voyage, round(days * DAY_S, 3)


# -----------------------------------------------------------------------------
# The file.


@contextmanager
def opened(path: str) -> Iterator[Hindcast]:
    """Yield a file, of which only the part around the track is read.

    Raises:
        SceneError: not NetCDF, not a grid of times and places, or a missing library.
    """
    file = data_path(path)
    try:
        with file.open('rb') as stream:
            begins = stream.read(8)
    except OSError as error:
        problem = f'cannot be read: {error.strerror}'
        raise SceneError(path, '', None, problem, 'Name another file.') from None
    is_hdf = begins == b'\x89HDF\r\n\x1a\n'
    if not is_hdf and begins[:3] != b'CDF':
        problem, remedy = next(
            (words for magic, *words in _FORMATS if begins.startswith(magic)),
            ('is not NetCDF', _FORM),
        )
        raise SceneError(path, '', None, problem, remedy)
    try:
        # xarray reads by h5netcdf, which does not require h5py
        import h5netcdf  # noqa: F401
        import h5py  # noqa: F401
        import xarray
    except ImportError:
        problem = 'is NetCDF, which xarray, h5netcdf and h5py read'
        raise SceneError(path, '', None, problem, f'Run {install("hindcast")}.') from None
    try:
        data = xarray.open_dataset(
            file, engine='h5netcdf' if is_hdf else 'scipy', decode_timedelta=False
        )
    except Exception as error:  # each library has its own errors
        problem = f'cannot be read as NetCDF: {words_of(error).rstrip(".")}'
        raise SceneError(path, '', None, problem, _FORM) from None
    with data:
        yield Hindcast(path, data)


class Hindcast:
    """Fields on a grid of times, latitudes and longitudes, and their values along a track."""

    def __init__(self, path: str, data: xarray.Dataset) -> None:
        self._path = path
        # files converted from GRIB have a valid_time that is not an axis as well as time
        axes = [axis for axis in data.coords if axis in data.sizes]
        names = [next((axis for axis in spellings if axis in axes), None) for spellings in _AXES]
        for name, spellings in zip(names, _AXES, strict=True):
            if name is None or data[name].size < 2:
                sizes = ', '.join(f'{axis} ({data[axis].size})' for axis in axes) or 'no axes'
                problem = f'is not an axis of at least two values; the file has {sizes}'
                raise SceneError(path, ' or '.join(spellings), ABSENT, problem, _FORM)
        self._axes = time, latitude, longitude = tuple(map(str, names))
        if data[time].dtype.kind != 'M':
            raise SceneError(path, time, str(data[time].dtype), 'is not a time in UTC', _FORM)
        if data[latitude].values[0] > data[latitude].values[-1]:
            data = data.isel({latitude: slice(None, None, -1)})
        self._data = data
        since = data[time].values - np.datetime64(0, 's')
        self._at_s: FloatArray = since / np.timedelta64(1, 's')
        self._latitude = data[latitude].values.astype(np.float64)
        self._longitude = np.unwrap(data[longitude].values.astype(np.float64), period=360.0)
        for name, axis in zip(self._axes, self._grid, strict=True):
            for place in np.flatnonzero(~(np.diff(axis) > 0.0))[:1]:
                values = ' after '.join(
                    _day(value) if name == time and math.isfinite(value) else f'{value:g}'
                    for value in (axis[place + 1], axis[place])
                )
                problem = f'does not increase from value to value: {values}'
                raise SceneError(path, name, ABSENT, problem, 'Sort the file, each value once.')
        self._count = len(self._longitude)
        step = float(self._longitude[1] - self._longitude[0])
        self._round = float(self._longitude[-1] - self._longitude[0]) + 1.5 * step > 360.0
        if self._round:  # three times, for tracks in both directions
            turns = [self._longitude + turn for turn in (-360.0, 0.0, 360.0)]
            self._longitude = np.concatenate(turns)

    @property
    def _grid(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        return self._at_s, self._latitude, self._longitude

    def one_of(self, *names: str) -> str:
        """Return the first of some names that is a field.

        Raises:
            SceneError: the file has none of them.
        """
        for name in names:
            if name in self._data:
                return name
        problem = f'is missing; the file has {", ".join(map(str, self._data.data_vars)) or "none"}'
        raise SceneError(self._path, ' or '.join(names), ABSENT, problem, _FORM)

    def along(
        self,
        name: str,
        at_s: FloatArray,
        latitude: FloatArray,
        longitude: FloatArray,
        *,
        turns: bool = False,
    ) -> FloatArray:
        """Return the values of a field along a track.

        Args:
            name: of the field.
            at_s: UTC from 1970 [s], (n,), increasing.
            latitude: of the ship [degrees north], (n,).
            longitude: of the ship [degrees east], (n,), of any turn.
            turns: whether the values are directions [degrees]. Their mean is the direction of the
                mean vector, plus the mean of their differences from it: linear for directions
                within half a turn.

        Raises:
            SceneError: the track leaves the file, or is too far from any sea.
        """
        self.one_of(name)
        field, dims = self._data[name], set(self._data[name].dims) - set(self._axes)
        expected, spelling = FIELDS[name], field.attrs.get('units')
        if field.dtype.kind not in 'fiu':
            problem = f'is not numeric but of type {field.dtype}'
            raise SceneError(self._path, name, ABSENT, problem, _FORM)
        if spelling is not None and str(spelling).strip().casefold() not in expected.spelled:
            problem, remedy = f'must be {expected.unit}', f'Convert the field to {expected.unit}.'
            raise SceneError(self._path, f'{name}, units', str(spelling), problem, remedy)
        if several := sorted(str(dim) for dim in dims if field.sizes[dim] > 1):
            problem = f'has more than times and places: {", ".join(map(str, field.dims))}'
            remedy = f'Write a file with one value of {" and ".join(several)}.'
            raise SceneError(self._path, name, ABSENT, problem, remedy)
        field = field.isel(dict.fromkeys(dims, 0))
        if set(field.dims) != set(self._axes):
            problem = f'has the dimensions {", ".join(map(str, field.dims))}'
            raise SceneError(self._path, name, ABSENT, problem, _FORM)
        field = field.transpose(*self._axes)
        longitude = self._turned(longitude)
        self._refuse_outside(at_s, latitude, longitude)
        values = np.empty(len(at_s))
        for begin in range(0, len(at_s), _ROWS_AT_ONCE):
            rows = slice(begin, begin + _ROWS_AT_ONCE)
            values[rows] = self._part(
                name, field, (at_s[rows], latitude[rows], longitude[rows]), turns=turns
            )
        return values

    def _turned(self, longitude: FloatArray) -> FloatArray:
        """Return longitudes continued into the grid's range, without a jump for a grid round the
        globe.
        """
        west = float(self._longitude[self._count if self._round else 0])
        if self._round:
            # wider than the grid if the ship sails round the globe
            smooth = np.unwrap(longitude, period=360.0)
            return np.asarray(smooth - 360.0 * math.floor((float(smooth[0]) - west) / 360.0))
        east = np.mod(longitude - west, 360.0)
        return np.asarray(west + np.where(east > 360.0 - 1e-9, 0.0, east))

    def _refuse_outside(
        self, at_s: FloatArray, latitude: FloatArray, longitude: FloatArray
    ) -> None:
        """Refuse a track that leaves the times or the area, or meets a gap of the times."""
        begin, end = (_day(self._at_s[index]) for index in (0, -1))
        for row in np.flatnonzero((at_s < self._at_s[0]) | (at_s > self._at_s[-1]))[:1]:
            problem = f'lasts from {begin} to {end} UTC, and the ship needs {_day(at_s[row])}'
            remedy = 'Fetch the days of the voyage, or set begins, UTC at the start of the scene.'
            raise SceneError(self._path, self._axes[0], ABSENT, problem, remedy)
        upper = np.clip(np.searchsorted(self._at_s, at_s, 'right'), 1, len(self._at_s) - 1)
        steps = self._at_s[upper] - self._at_s[upper - 1]
        for row in np.flatnonzero(steps > LONGEST_STEP_S)[:1]:
            problem = f'has no field for {steps[row] / 3600.0:g} h about {_day(at_s[row])} UTC'
            remedy = f'Fetch fields at most {LONGEST_STEP_S / 3600.0:g} h apart.'
            raise SceneError(self._path, self._axes[0], ABSENT, problem, remedy)
        for name, axis, places in zip(
            self._axes[1:], self._grid[1:], (latitude, longitude), strict=True
        ):
            for row in np.flatnonzero((places < axis[0]) | (places > axis[-1]))[:1]:
                problem = (
                    f'goes from {axis[0]:g}° to {axis[-1]:g}°, and the ship is at '
                    f'{_place(latitude[row], longitude[row])} on {_day(at_s[row])} UTC'
                )
                remedy = 'Fetch an area with the whole voyage.'
                raise SceneError(self._path, name, ABSENT, problem, remedy)

    def _part(
        self,
        name: str,
        field: xarray.DataArray,
        track: tuple[FloatArray, FloatArray, FloatArray],
        *,
        turns: bool,
    ) -> FloatArray:
        """Return the values along a piece of the track, from one box of the grid."""
        lows, parts, box = [], [], []
        degrees = NEAREST_SEA_KM / _KM_PER_DEG
        wider = degrees / max(
            math.cos(math.radians(float(np.abs(track[1]).max()) + degrees)), 0.01
        )
        for axis, places, margin in zip(self._grid, track, (0.0, degrees, wider), strict=True):
            low = np.clip(np.searchsorted(axis, places, 'right') - 1, 0, len(axis) - 2)
            lows.append(low)
            parts.append((places - axis[low]) / (axis[low + 1] - axis[low]))
            begin = int(np.searchsorted(axis, axis[low.min()] - margin, 'left'))
            box.append((begin, int(np.searchsorted(axis, axis[low.max() + 1] + margin, 'right'))))
        times, latitudes, longitudes = (np.arange(*ends) for ends in box)
        # the box may cross the first meridian of the file
        part = field[times, latitudes, longitudes % self._count]
        values = part.to_numpy().astype(np.float64)
        # the eight corners about each row of the track, (3, 8, n)
        steps = np.array(list(product((0, 1), repeat=3))).T[:, :, None]
        at = np.array(lows)[:, None] + steps
        between = np.array(parts)[:, None]
        share = np.prod(np.where(steps, between, 1.0 - between), axis=0)
        samples = values[tuple(at - np.array(box)[:, :1, None])]
        samples[share == 0.0] = 0.0
        for corner, row in np.argwhere(np.isnan(samples)).tolist():
            samples[corner, row] = self._nearest(
                name, values, box, at[:, corner, row].tolist(), [axis[row] for axis in track]
            )
        limits = FIELDS[name]
        is_valid = (samples >= limits.low) & (samples <= limits.high)
        for which, row in np.argwhere(~is_valid & (share > 0.0))[:1]:
            problem = (
                f'must be between {limits.low:g} and {limits.high:g} {limits.unit}, here near '
                f'{_place(track[1][row], track[2][row])} on {_day(track[0][row])} UTC'
            )
            remedy = f'Give it in {limits.unit}, and mark missing values by _FillValue.'
            raise SceneError(self._path, name, float(samples[which, row]), problem, remedy)
        if not turns:
            return np.asarray((share * samples).sum(axis=0))
        angles = np.radians(samples)
        mean = np.degrees(
            np.arctan2((share * np.sin(angles)).sum(axis=0), (share * np.cos(angles)).sum(axis=0))
        )
        offsets = np.mod(samples - mean + 180.0, 360.0) - 180.0
        return np.asarray(np.mod(mean + (share * offsets).sum(axis=0), 360.0))

    def _nearest(
        self,
        name: str,
        values: FloatArray,
        box: list[tuple[int, int]],
        corner: list[int],
        place: list[Any],
    ) -> float:
        """Return the value of the sea nearest to a corner on land."""
        sea = values[corner[0] - box[0][0]]
        latitude, longitude = (
            np.radians(axis[slice(*ends)])
            for axis, ends in zip(self._grid[1:], box[1:], strict=True)
        )
        centre = math.radians(self._latitude[corner[1]]), math.radians(self._longitude[corner[2]])
        across = np.cos(latitude)[:, None] * math.cos(centre[0])
        haversine = (
            np.sin(0.5 * (latitude - centre[0]))[:, None] ** 2
            + across * np.sin(0.5 * (longitude - centre[1])) ** 2
        )
        apart_km = np.degrees(2.0 * np.arcsin(np.sqrt(np.minimum(haversine, 1.0)))) * _KM_PER_DEG
        apart_km[np.isnan(sea)] = math.inf
        nearest = np.unravel_index(np.argmin(apart_km), apart_km.shape)
        if apart_km[nearest] > NEAREST_SEA_KM:
            problem = (
                f'has no value within {NEAREST_SEA_KM:g} km of '
                f'{_place(place[1], place[2])} on {_day(place[0])} UTC: land, or ice'
            )
            remedy = 'Move the place out to sea, by a waypoint, or use another file.'
            raise SceneError(self._path, name, ABSENT, problem, remedy)
        return float(sea[nearest])


def _day(at_s: float) -> str:
    # the year may be outside datetime's range
    return str(np.datetime64(math.floor(at_s), 's').astype('datetime64[m]'))


def _place(latitude: float, longitude: float) -> str:
    return f'{latitude:.2f}°, {math.remainder(float(longitude), 360.0):.2f}°'
