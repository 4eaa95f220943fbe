"""Log-books: their formats, refusals by passage and row, and scenes."""

import datetime
import gzip
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cliwoc import release_21

import tauto_core as tauto
from tauto_core.scene import SceneError, load_scene, parse_scene, scene_yaml
from tauto_core.scene.loader import write_mapping
from tauto_core.scene.sections import nautical_miles
from tauto_core.ship import Passage
from tauto_core.ship.airs import departures
from tauto_core.ship.logbook import find_passage, read_passages, scene_of_passage
from tauto_core.ship.motions.sea import SeaShip

SHIPPED = Path(tauto.__file__).parent / 'scene' / 'shipped'
HEADER = 'passage,nation,ship,from,to,utc,latitude,longitude,wind_from_deg,wind_mps,air_celsius\n'
ROWS = (
    'A-1,French,La Folle,Brest,,1785-08-01T12:00,48.0,-7.0,270,6.7,18.5\n'
    'A-1,French,La Folle,Brest,,1785-08-02T12:00,46.5,-9.0,270,9.3,\n'
    'A-1,French,La Folle,Brest,,1785-08-03T13:00,45.0,-11.0,180,9.3,19.0\n'
    'A-1,French,La Folle,Brest,,1785-08-05T12:00,41.0,-13.0,,,20.0\n'
    'B-2,Spanish,,,Lima,1790-01-01T18:00,-10.0,-79.0,362,2.6,\n'
    'B-2,Spanish,,,Lima,1790-01-02T18:00,-11.0,-80.0,140,0.0,\n'
)
SCENE = """\
log: {{interval: 60.0}}
trochlea:
  inertia: 4e-4
  cam: {{kind: involute, base_radius: 0.005}}
  thread: {{kind: vertical}}
  power: {{kind: weight, mass: 0.322}}
  release_angle: 1.0
ship:
  kind: sea
  weather: {{kind: log}}
  hull: deptford
  roll: {{natural_period: 11.0, damping_ratio: 0.08}}
  rate: 10.0
air: {{kind: log}}
voyage: {{log: {{path: {path}, passage: A-1, harbour_days: 2}}}}
"""


def book(folder: Path, text: str = HEADER + ROWS, name: str = 'log.csv') -> str:
    file = folder / name
    file.write_text(text, encoding='utf-8')
    return str(file)


def scene_in(folder: Path, text: str = HEADER + ROWS) -> str:
    book(folder, text)
    file = folder / 'scene.yaml'
    file.write_text(SCENE.format(path='log.csv'), encoding='utf-8')
    return str(file)


@pytest.fixture(scope='module')
def own():
    """The mapping of a scene that may sail any passage."""
    return load_scene('esperance_to_the_cape').model_dump(mode='json', exclude_none=True)


def test_our_columns_are_read_passage_by_passage(tmp_path):
    one, other = read_passages(book(tmp_path))
    assert (one.name, one.ship, one.nation, one.sailed_from) == (
        'A-1',
        'La Folle',
        'French',
        'Brest',
    )
    assert one.lines == (2, 3, 4, 5)
    assert one.entries[1] == ('1785-08-02T12:00', 46.5, -9.0, 270.0, 9.3, None)
    assert one.days == 4.0
    assert (one.share(4), one.share(5)) == (0.75, 0.75)
    assert other.bound_to == 'Lima'
    assert not [*one.problems(), *other.problems()]
    assert any('without a wind, 1 variable' in note for note in other.notes())


def test_compressed_files_and_letters_of_one_byte_are_read_too(tmp_path):
    text = (HEADER + ROWS).replace('La Folle', 'Le Prothée')
    file = tmp_path / 'log.csv.gz'
    file.write_bytes(gzip.compress(text.encode('latin-1')))
    assert next(read_passages(str(file))).ship == 'Le Prothée'


@pytest.mark.parametrize(
    ('old', 'new', 'where', 'what'),
    [
        ('1785-08-03T13:00', '1785-08-02T24:00', 'row 3 (line 4), utc', 'hour 24'),
        ('1785-08-03T13:00', '1785-08-02T12:30', 'row 3 (line 4), utc', 'previous entry'),
        ('1785-08-03T13:00', '0001-01-01T00:00+23:59', 'row 3 (line 4), utc', '1500 to 2999'),
        ('45.0,-11.0', '4_5.0,-11.0', 'row 3 (line 4), latitude', 'not a number'),
        ('1785-08-03T13:00', '1785-02-29T13:00', 'row 3 (line 4), utc', 'not a date'),
        ('1785-08-05', '1785-08-15', 'row 4 (line 5), utc', 'longest_gap_days'),
        ('45.0,-11.0', '45.0,-19.0', 'row 3 (line 4), latitude', 'nautical miles'),
        ('45.0,-11.0', '95.0,-11.0', 'row 3 (line 4), latitude', '90'),
        ('180,9.3', '180,61', 'row 3 (line 4), wind_mps', 'hurricane'),
        ('180,9.3', 'NaN,9.3', 'row 3 (line 4), wind_from_deg', 'not a number'),
        ('180,9.3', '180,-9999', 'row 3 (line 4), wind_mps', 'between 0 and 40'),
        ('180,9.3', '180,inf', 'row 3 (line 4), wind_mps', 'not a finite number'),
        ('45.0,-11.0', '89.8,-11.0', 'row 3 (line 4), latitude', 'nearer to a pole'),
        ('45.0,-11.0', ',-11.0', 'row 3 (line 4), latitude', 'is missing'),
        ('180,9.3', '410,9.3', 'row 3 (line 4), wind_from_deg', '360'),
        ('180,9.3,19.0', '180,9.3,292.1', 'row 3 (line 4), air_celsius', '60'),
        ('180,9.3,19.0', '180,9.3', 'row 3 (line 4)', 'cells'),
    ],
)
def test_a_row_that_cannot_be_is_refused_by_passage_and_row(tmp_path, old, new, where, what):
    with pytest.raises(SceneError) as caught:
        load_scene(scene_in(tmp_path, HEADER + ROWS.replace(old, new)))
    assert caught.value.key.startswith('passage A-1, ')
    assert where in caught.value.key
    assert what in caught.value.problem
    assert caught.value.remedy.endswith('.')


@pytest.mark.parametrize('column', ['latitude', 'longitude', 'wind_mps', 'wind_from_deg'])
def test_missing_column_is_named(tmp_path, column):
    with pytest.raises(SceneError) as caught:
        list(read_passages(book(tmp_path, HEADER.replace(column, column.upper()) + ROWS)))
    assert caught.value.key == f'line 1, column {column}'
    assert column.upper() in caught.value.problem


FIRST = ROWS.splitlines()[0]


@pytest.mark.parametrize(
    ('text', 'problem'),
    [
        (f'{HEADER}{FIRST},1,2\n', 'cells, the header'),
        (f'{HEADER}{ROWS}{FIRST}\n', 'comes again'),
        (HEADER + ROWS.replace('B-2', ''), 'passage , row 1 (line 6), passage: is missing'),
        (f'{HEADER}{FIRST}\n', 'a passage needs two'),
    ],
)
def test_faulty_passage_has_its_problem(tmp_path, text, problem):
    *_, last = read_passages(book(tmp_path, text))
    assert problem in str(next(last.problems()))


def test_long_names_and_names_of_several_lines_are_cut(tmp_path, own):
    named = '"La\r\nFolle\x1b[2J\u2028 et fille"'
    text = ROWS.replace('A-1', 'A' * 5000).replace('La Folle', named)
    one, other = read_passages(book(tmp_path, HEADER + text))
    assert one.ship == 'La Folle [2J et fille'
    assert one.name == 'A' * 1000
    assert other.name == 'B-2'
    scene = parse_scene(write_mapping(scene_of_passage(own, one, 1.0)), 'made')
    assert scene.voyage.log.passage == one.name


WITHOUT = 'entries without a wind'
SILENT = ROWS.replace('270,6.7', '362,6.7').replace(',270,9.3,', ',,,')


@pytest.mark.parametrize(
    ('rows', 'notes'),
    [
        (ROWS, ['1 of 4 entries without a wind']),
        (
            ROWS.replace('270,6.7', '270,13').replace(',9.3', ',18'),
            ['1 of 4 entries without a wind', 'a wind of 16.3 m/s in the mean: perhaps in knots'],
        ),
        (SILENT, ['3 of 4 entries without a wind, 1 variable']),
        (
            SILENT.replace(',180,9.3,', ',,,'),
            [f'4 of 4 {WITHOUT}, 1 variable: no sea grows from it'],
        ),
    ],
)
def test_doubtful_winds_have_a_note(tmp_path, rows, notes):
    passage = next(read_passages(book(tmp_path, HEADER + rows)))
    assert [note for note in passage.notes() if 'wind' in note] == notes


@pytest.mark.parametrize(
    ('text', 'what'),
    [
        (HEADER.replace('wind_mps', 'wind_knots') + ROWS, 'wind_mps'),
        (HEADER.replace('\n', ',latitude\n') + ROWS, 'column latitude: is named more than once'),
        (HEADER, 'no rows'),
        ('a,b\n1,2\n', 'is not a known log-book'),
        ('RecID,Lat3,Lon3\n1,2,3\n', 'is not a known log-book.*CLIWOC, release 2.1'),
        ('', 'is not a known log-book'),
    ],
)
def test_unknown_log_book_is_refused_with_its_columns(tmp_path, text, what):
    with pytest.raises(SceneError, match=what) as caught:
        list(read_passages(book(tmp_path, text)))
    assert 'wind_knots' in str(caught.value) or 'knots' not in text


@pytest.mark.parametrize(
    ('before', 'filling', 'said'),
    [
        ('', '0', 'line 1 has 65,536 characters or more'),
        (HEADER + ROWS, '0', 'line 8 has 65,536 characters or more'),
        (HEADER + ROWS, ',' * 999 + '\n', 'unpacks to more than 16,777,216 bytes'),
        ('<gpx>', ' ', 'has more than 16,777,216 bytes'),
    ],
)
def test_a_small_file_that_unpacks_without_end_is_refused(tmp_path, before, filling, said):
    pytest.importorskip('gpxpy')
    file = tmp_path / 'bomb.csv.gz'
    file.write_bytes(gzip.compress((before + filling * (24_000_000 // len(filling))).encode()))
    tracemalloc.start()
    try:
        with pytest.raises(SceneError, match=said):
            list(read_passages(str(file)))
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # a track is parsed as a whole: its text, and the parts of it as they are joined
    assert most < (4 * 2**24 if before == '<gpx>' else 20_000_000)


def test_unknown_name_of_a_passage_is_refused(tmp_path):
    path = book(tmp_path, f'{HEADER}{FIRST}\n')
    with pytest.raises(SceneError, match=r'not one of the 1 passages.*A-1'):
        find_passage(path, 'A-2')
    with pytest.raises(SceneError, match='has 2 passages'):
        find_passage(book(tmp_path), None)


def test_a_scene_of_a_passage_is_where_its_log_says_and_when(tmp_path):
    scene = load_scene(scene_in(tmp_path))
    # two days of harbour, then the log: the stamps of days are whole, and the first noon is noon
    assert scene.voyage.sails_at == 2 * 86_400.0
    assert (scene.starts_at + scene.voyage.sails_at) % 86_400.0 == 43_200.0
    assert scene.voyage.date.isoformat() == '1785-08-01'
    assert scene.duration == 6 * 86_400.0 + 60.0
    passage = Passage(scene, scene.voyage)
    at = np.array(passage.places_ns)
    np.testing.assert_allclose((at - at[0]) / 3.6e12, [0.0, 24.0, 49.0, 96.0], rtol=0, atol=1e-9)
    latitude, longitude = passage.places(at)
    np.testing.assert_allclose(latitude, [48.0, 46.5, 45.0, 41.0], rtol=0, atol=1e-11)
    np.testing.assert_allclose(longitude, [-7.0, -9.0, -11.0, -13.0], rtol=0, atol=1e-11)
    # one nautical mile is 1852 m, and the sphere of the check is good to half a per cent
    miles = nautical_miles((48.0, -7.0), (46.5, -9.0))
    assert passage.speed_m_s(int(at[0]) + 1) * 86_400.0 / 1852.0 == pytest.approx(miles, rel=5e-3)


def test_a_scene_that_has_its_log_needs_no_file(tmp_path):
    scene = load_scene(scene_in(tmp_path))
    (tmp_path / 'log.csv').unlink()
    assert parse_scene(scene_yaml(scene), 'bag') == scene
    assert str(tmp_path) not in scene_yaml(scene)


def test_keys_that_the_log_gives_are_refused(tmp_path):
    file = scene_in(tmp_path)
    for key, value in (('departure', [48.0, -7.0]), ('date', '1785-08-01'), ('speed', 3.0)):
        with pytest.raises(SceneError) as caught:
            load_scene(file, **{f'voyage.{key}': value})
        assert caught.value.key == f'voyage.{key}'
    with pytest.raises(SceneError, match='another hour of the day'):
        load_scene(file, starts_at=86_400.0)
    with pytest.raises(SceneError, match='longer than the log'):
        load_scene(file, duration=7 * 86_400.0)
    assert load_scene(file, duration=3_600.0).duration == 3_600.0


def test_air_by_the_log_follows_its_thermometer(tmp_path):
    scene = load_scene(scene_in(tmp_path))
    at_ns, celsius = scene.air.knots(scene)
    np.testing.assert_array_equal(at_ns, Passage(scene, scene.voyage).places_ns)
    assert celsius[[0, 2, 3]].tolist() == [18.5, 19.0, 20.0]
    # the climate has 15 °C at 46.5 N, and the thermometer a day before and after was 4 K over it
    assert 18.0 < celsius[1] < 19.5
    # without a thermometer it is ITU-R P.1510-1: at 46.5 N in summer between 40 N, 20.2 and 22.0,
    # and 50 N, 11.3 and 13.0
    bare = HEADER + ROWS.replace(',18.5', ',').replace(',19.0', ',').replace(',20.0', ',')
    without = load_scene(scene_in(tmp_path, bare))
    assert 13.0 < without.air.knots(without)[1][1] < 18.0


def test_departure_is_expectation_of_ornstein_uhlenbeck():
    """By the normal distribution given the known values, of the covariance exp(−|t − t'|/τ)."""
    days = np.array([0.0, 1.0, 2.0, 4.0, 5.0, 19.0, 20.0, 60.0, 61.5])
    known = np.array([np.nan, 3.0, np.nan, np.nan, -1.0, np.nan, np.nan, 2.0, np.nan])
    there = ~np.isnan(known)
    covariance = np.exp(-np.abs(days[:, None] - days) / 8.0)
    gain = np.linalg.solve(covariance[np.ix_(there, there)], known[there])
    expected = covariance[:, there] @ gain
    found = departures(days * 86_400.0, known)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)
    assert found[there].tolist() == [3.0, -1.0, 2.0]
    assert not departures(days * 86_400.0, np.full(9, np.nan)).any()


def test_a_passage_cut_at_a_thermometer_has_the_same_air(tmp_path):
    """Bit for bit: only the next thermometer on either side counts, by differences of times."""
    entries = [
        f'A-1,,,,,1785-08-{1 + day:02d}T{12 + day % 3}:07,{48 - day},-7.0,270,6.7,{celsius}\n'
        for day, celsius in enumerate(('', '18.5', '', '', '21.25', '', '24.5', '', ''))
    ]
    parts = [entries, entries[:5], entries[4:]]
    made = [load_scene(scene_in(tmp_path, HEADER + ''.join(each))) for each in parts]
    whole, first, second = (each.air.knots(each)[1].tolist() for each in made)
    assert first == whole[:5]
    assert second == whole[4:]


def test_weather_and_air_by_a_log_need_one():
    with pytest.raises(SceneError, match='log-book'):
        load_scene('portsmouth_jamaica', air={'kind': 'log'})
    scene = load_scene('portsmouth_jamaica', **{'ship.weather': {'kind': 'log'}})
    assert isinstance(scene.ship, SeaShip)
    with pytest.raises(SceneError, match='log-book'):
        scene.ship.states(scene)


def logged(days=30, begins='1785-08-01T13:00', at=(48.0, -10.0), made=(-0.9, -0.6), hours=24):
    """Return the rows of a passage, each a list of cells from `utc` to `air_celsius`."""
    first = datetime.datetime.fromisoformat(begins)
    rows = []
    for number in range(days):
        utc = (first + number * datetime.timedelta(hours=hours)).isoformat(timespec='minutes')
        east = (at[1] + number * made[1] + 180.0) % 360.0 - 180.0
        rows.append([utc, f'{at[0] + number * made[0]:.4f}', f'{east:.4f}', '270', '9.3', ''])
    return rows


def with_cells(where, **cells):
    """Return the rows of a passage, some of them with other cells."""
    columns = ('utc', 'latitude', 'longitude', 'wind_from', 'wind', 'air')
    rows = logged()
    for row in rows[where]:
        for name, cell in cells.items():
            row[columns.index(name)] = cell
    return rows


ANY = slice(None)
LOGS = {
    'no wind for two weeks': with_cells(slice(5, 20), wind_from='', wind=''),
    'variable': with_cells(slice(3, 6), wind_from='362', wind='2.6'),
    'a speed without a direction': with_cells(slice(3, 6), wind_from=''),
    'a hurricane that turns': [
        [*row[:3], str(97 * number % 360), str((0, 35, 1, 22.6, 0.9)[number % 5]), '']
        for number, row in enumerate(logged())
    ],
    'to the west over the date line': logged(at=(-20.0, -170.0), made=(0.1, -2.0)),
    'to the east over the date line': logged(at=(-20.0, 170.0), made=(0.1, 2.0)),
    'at 0 and 180 degrees': logged(at=(0.0, 180.0), made=(0.0, -0.5)),
    'in the ice': logged(at=(70.0, -10.0), made=(0.3, 1.0)),
    'a leap day': logged(begins='1788-02-25T13:00'),
    'the year of eleven days': logged(begins='1752-08-25T13:00'),
    'a week at anchor': [*logged()[:10], *[[row[0], *logged()[9][1:]] for row in logged()[10:17]]],
    'a gap of six days': [*logged()[:10], *logged()[15:]],
    'three entries': logged(days=3),
    'air on one day': with_cells(slice(12, 13), air='17.5'),
    'another zone': with_cells(slice(4, 5), utc='1785-08-05T16:00+03:00'),
    'a day without an hour': with_cells(slice(4, 5), utc='1785-08-05'),
}


@pytest.mark.parametrize('rows', LOGS.values(), ids=LOGS.keys())
def test_any_sound_log_is_sailed(tmp_path, own, rows):
    text = ''.join(f'It,,,,,{",".join(row)}\n' for row in rows)
    passage = find_passage(book(tmp_path, HEADER + text), None)
    assert not list(passage.problems())
    scene = parse_scene(write_mapping(scene_of_passage(own, passage, 1.0)), 'made')
    way, at = Passage(scene, scene.voyage), np.array([0, 43_200, 86_400, 129_600]) * 10**9
    latitude, longitude = way.places(np.concatenate([at, at + way.arrives_ns - at[-1]]))
    assert np.abs(latitude).max() < 80.0
    assert np.abs(longitude).max() <= 360.0
    states = scene.ship.states(scene)
    assert all(0.0 <= state.height < 30.0 for state in states)
    _, celsius = scene.air.knots(scene)
    assert -30.0 < celsius.min() <= celsius.max() < 35.0
    assert way.arrives_ns / 1e9 == (passage.days + 1.0) * 86_400.0


DAYS = [
    (
        day,
        4800 - 100 * number,
        35300 - 120 * number,
        (270, 67, 185) if number % 5 else (362, 20, 0),
    )
    for number, day in enumerate(range(1, 31))
]


def test_the_table_of_release_2_1_is_read_by_its_header(tmp_path):
    names = 'record_number\tYR\tMO\tDY\tHR\tLAT\tLON\tID\tC1\tD\tW\tAT\tShipName\tVoyageFrom'
    rows = [
        f'{n}\t1785\t8\t{day}\t1300\t{lat}\t{lon}\t1920\tFR\t{wind[0]}\t{wind[1]}\t'
        f'{wind[2] or ""}\tX\tBREST'
        for n, (day, lat, lon, wind) in enumerate(DAYS)
    ]
    (passage,) = read_passages(book(tmp_path, '\n'.join([names, *rows]), 'cliwoc21.tsv'))
    assert (passage.name, passage.sailed_from) == ('17850801-1920', 'BREST')
    for entry, (day, lat, lon, (wind_from, wind, air)) in zip(passage.entries, DAYS, strict=True):
        assert entry[0] == f'1785-08-{day:02d}T13:00'
        place = lat / 100.0, lon / 100.0 - 360.0
        wanted = *place, wind_from, wind / 10.0, air / 10.0 if air else None
        assert entry[1:] == pytest.approx(wanted, abs=1e-9)


NAMES_21 = 'YR\tMO\tDY\tHR\tLAT\tLON\tID\tD\tW'


def cells_21(day: int, lat: int, lon: int, wind: tuple[int, int, int]) -> str:
    """Return the cells of a row of release 2.1 from YR to W."""
    return f'1785\t8\t{day}\t1300\t{lat}\t{lon}\t1920\t{wind[0]}\t{wind[1]}'


IMPOSSIBLE = ('1785\t13', '1\t1', '9999\t12', '1e18\t8', '1e300\t8', '1785\t1e300', '17_85\t8')


@pytest.mark.parametrize(
    ('old', 'new', 'said'),
    [
        ('\t1300\t', '\t2400\t', '30 lines of 1 log, 30 with the hour 24'),
        ('\t1300\t', '\t\t', '30 without a possible time'),
        *(('1785\t8\t', f'{new}\t', '30 without a possible time') for new in IMPOSSIBLE),
        ('\t1300\t', '\t1_300\t', '30 without a possible time'),
        ('\t1920\t', '\t1920\t0\t', '30 with more or fewer cells than the header'),
        ('\t4800\t', '\tNA\t', None),
    ],
)
def test_a_file_without_a_passage_says_what_became_of_its_rows(tmp_path, old, new, said):
    rows = [cells_21(*each).replace(old, new) for each in DAYS]
    path = book(tmp_path, '\n'.join([NAMES_21, *rows]))
    if said is None:
        (passage,) = read_passages(path)
        assert len(passage.entries) == 29
        return
    with pytest.raises(SceneError, match='has no passage of 25 entries') as refused:
        list(read_passages(path))
    assert said in str(refused.value)


def test_dropped_rows_are_counted_by_reason(tmp_path):
    rows = [cells_21(*each) for each in DAYS]
    rows[3] = rows[3].replace('1300', '2400')
    rows[4] = rows[4].replace('\t8\t5\t', '\t8\t32\t')
    rows[7] = rows[7].replace(f'\t{DAYS[7][1]}\t', '\t9100\t')
    path = book(tmp_path, '\n'.join([NAMES_21, *rows]))
    (passage,) = read_passages(path)
    told = [each for each in passage.notes() if each.endswith('left out')]
    assert told == [
        '1 row of this log with the hour 24, left out',
        '1 row of this log without a possible time, left out',
        '1 row of this log with a place that is not on the globe, left out',
    ]


def test_log_is_cut_at_jumps_without_short_pieces(tmp_path):
    rows = [
        cells_21(day, lat, lon - 2000 * (n > 25), wind)
        for n, (day, lat, lon, wind) in enumerate(DAYS)
    ]
    (passage,) = read_passages(book(tmp_path, '\n'.join([NAMES_21, *rows])))
    assert len(passage.entries) == 26


def test_the_rows_of_all_logs_take_little_memory(tmp_path):
    """Passages are made one log at a time: of the others only the numbers are kept."""
    release_21(tmp_path / 'cliwoc.tsv', 2_002)
    tracemalloc.start()
    try:
        entries = sum(len(each.entries) for each in read_passages(str(tmp_path / 'cliwoc.tsv')))
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert entries > 1_800
    # 7 numbers of 8 bytes a row, and room to grow by an eighth. A row as an entry takes 400 bytes
    assert most < 2_002 * 150


def track(time: str = '2020-06-01T00:00:00Z', lat: str = '1', lon: str = '2') -> str:
    point = f'<trkpt lat="{lat}" lon="{lon}"><time>{time}</time></trkpt>'
    return f'<trk><trkseg>{point}</trkseg></trk>'


@pytest.mark.parametrize(
    ('inside', 'said'),
    [
        ('', 'has no tracks'),
        ('<wpt lat="1" lon="2"/>', 'has no tracks'),
        ('<trk><trkseg/></trk>', 'track 1 has no points with a time'),
        ('<trk><trkseg><trkpt lat="1" lon="2"/></trkseg></trk>', 'track 1 has no points with a'),
        (track(), 'has no passage of 2 entries, but 1 point'),
        ('<trk>', 'cannot be read as GPX'),
        (track(lat='nan'), 'track 1, point 1, latitude = nan: must be within 90 degrees'),
        (track(lon='1e9'), 'track 1, point 1, longitude = 1000000000.0: must be within 360 deg'),
        (track(lat='1_0'), '1_0 is not a number'),
        (track('0001-01-01T00:00:00+12:00'), 'point 1, time = .*: must lie in the years 1500 to'),
        (track('9999-12-31T23:59:59-12:00'), 'point 1, time = .*: must lie in the years 1500 to'),
    ],
)
def test_a_file_without_a_recorded_track_is_refused(tmp_path, inside, said):
    pytest.importorskip('gpxpy')
    text = f'<gpx version="1.1" creator="x">{inside}</gpx>'
    with pytest.raises(SceneError, match=said):
        list(read_passages(book(tmp_path, text, 'track.gpx')))


def test_a_track_takes_its_winds_from_a_table(tmp_path):
    pytest.importorskip('gpxpy')
    points = ''.join(
        f'<trkpt lat="{48 - n / 60:.6f}" lon="-7"><time>2020-06-{1 + n // 288:02d}T'
        f'{n // 12 % 24:02d}:{n % 12 * 5:02d}:00Z</time></trkpt>'
        for n in range(300)
    )
    text = (
        '<gpx version="1.1" creator="x" xmlns="http://www.topografix.com/GPX/1/1"><trk>'
        f'<name>Yacht</name><trkseg>{points}</trkseg></trk></gpx>'
    )
    winds = book(
        tmp_path,
        'utc,wind_from_deg,wind_mps\n2020-06-01T06:02:30,270,8\n2020-06-01T18:00,280,9\n',
        'winds.csv',
    )
    packed = tmp_path / 'track.gpx.gz'
    packed.write_bytes(gzip.compress(text.encode()))
    (passage,) = read_passages(str(packed), winds=winds)
    assert [passage] == [
        replace(each, source='track.gpx.gz')
        for each in read_passages(book(tmp_path, text, 'track.gpx'), winds=winds)
    ]
    assert (passage.name, passage.ship) == ('Yacht', 'Yacht')
    # a track of a day with two winds twelve hours apart: the first has blown since its beginning
    assert passage.share(4) == pytest.approx(18.0 / 24.0, abs=0.001)
    assert passage.notes() == ['2 winds, each has blown since the one before: 75 % of the time']
    made = scene_of_passage({'name': 'portsmouth_jamaica'}, passage)
    assert made['name'] == made['voyage']['log']['passage'] == 'Yacht'
    # of two tracks of one name each has its number
    twice = text.replace('</trk>', '</trk>' + text[text.index('<trk>') : text.index('</gpx>')])
    both = [each.name for each in read_passages(book(tmp_path, twice, 'twice.gpx'))]
    assert both == ['20200601-1', '20200601-2']
    assert not list(passage.problems())
    (windy,) = (each for each in passage.entries if each[0] == '2020-06-01T06:02:30')
    # 72.5 steps of five minutes and of a minute of latitude, written to six decimals
    assert windy[1:] == pytest.approx((48 - 72.5 / 60, -7.0, 270.0, 8.0, None), abs=1e-6)
