"""Tables of numbers: reading, and refusals with place, value and limit."""

import math
import os
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from tauto_core.ensembles.fleets import read_draws
from tauto_core.scene import load_scene
from tauto_core.scene.errors import SceneError, TautoError
from tauto_core.scene.tables import (
    ANGLE_UNITS,
    LARGEST_BYTES,
    Column,
    Columns,
    header_words,
    read_data,
    read_header,
    read_table,
    unit_factor,
)
from tauto_core.ship.hull import hull_of_file
from tauto_core.ship.logbook import read_passages

TIME = Column('time_s', unit='s', rising='later than the time before')
HEAT = Column('air_degc', unit='°C', least=-60.0, most=60.0, why='no sea is so')


def read(path: Path, text: str, *columns: Column, **keys) -> Columns:
    path.write_text(text, encoding='utf-8')
    return read_table(str(path), columns or (TIME, HEAT), remedy='Give a table.', **keys)


def test_columns_are_found_by_name_in_any_order(tmp_path):
    table = read(tmp_path / 'a.csv', '\ufeffair_degc, note ,time_s\n\n3,x,0\n  \n4.5,"y,z",2\n')
    np.testing.assert_array_equal(table['time_s'], [0.0, 2.0])
    np.testing.assert_array_equal(table['air_degc'], [3.0, 4.5])
    assert 'note' not in table
    assert [table.where(0), table.where(1)] == ['line 3', 'line 5']
    assert read_header(str(tmp_path / 'a.csv'), remedy='') == ['air_degc', 'note', 'time_s']


def test_optional_columns_gaps_and_units(tmp_path):
    wind = Column('wind_deg', optional=True, gaps='nan', factor=math.pi / 180.0)
    columns = Column('t'), Column('h', gaps='skip'), wind
    table = read(tmp_path / 'a.csv', 't,h,wind_deg\n0,1,90\nnever,MM,\n2,1,nan\n3,1,\n', *columns)
    np.testing.assert_array_equal(table['t'], [0.0, 2.0, 3.0])
    np.testing.assert_array_equal(table['wind_deg'], [math.pi / 2.0, math.nan, math.nan])
    assert 'wind_deg' not in read(tmp_path / 'b.csv', 't,h\n0,1\n', *columns)


def test_gaps_are_counted_and_long_ones_refused():
    table = Columns('a.csv', {'time_s': np.array([0.0, 1.0, 2.0, 4.0, 5.0])}, range(5), 'message')
    assert table.gaps('time_s', 2.0, limit='max_gap', remedy='') == 1
    with pytest.raises(
        SceneError, match=r'a\.csv: message 3: comes 2 s after .* max_gap is 1\.5 s'
    ):
        table.gaps('time_s', 1.5, limit='max_gap', remedy='')


@pytest.mark.parametrize(
    ('text', 'said'),
    [
        ('', 'line 1, column time_s: is missing; the columns are none. Give a table.'),
        ('time_s\n', 'line 1, column air_degc: is missing; the columns are time_s. Give a table.'),
        ('time_s,air_degc,time_s\n', 'line 1, column time_s: is named more than once; the col'),
        ('time_s,air_degc\n\n', 'holds no rows below its header. Give a table.'),
        ('time_s,air_degc\n0\n', 'line 2: has 1 cells, the header 2. Correct or drop the row.'),
        ('time_s,air_degc\n0,warm\n', "line 2, air_degc = 'warm': is not a finite number."),
        ('time_s,air_degc\n0,1_0\n', "line 2, air_degc = '1_0': is not a finite number."),
        ('time_s,air_degc\n0,inf\n', "line 2, air_degc = 'inf': is not a finite number."),
        (
            'time_s,air_degc\n0,1\n1,273.15\n',
            'line 3, air_degc = 273.15: must be at least -60 and at most 60 °C: no sea is so.',
        ),
        (
            'time_s,air_degc\n0,1\n\n0,2\n',
            'line 4, time_s = 0.0: must be later than the time before',
        ),
        ('time_s,air_degc\n0,"' + 200_000 * '1' + '"\n', 'cannot be read as text: field larger'),
    ],
)
def test_refusals_name_file_line_column_value_limit_and_remedy(tmp_path, text, said):
    with pytest.raises(SceneError) as refused:
        read(tmp_path / 'a.csv', text)
    assert str(refused.value).startswith(f'{tmp_path / "a.csv"}: {said}')


def test_a_unit_that_is_not_known_is_refused():
    assert unit_factor('a.csv', 'roll_column', 'roll_deg', ANGLE_UNITS) == math.pi / 180.0
    with pytest.raises(SceneError, match=r"roll_column = 'roll': has no known unit.*_rad or _deg"):
        unit_factor('a.csv', 'roll_column', 'roll', ANGLE_UNITS)


def test_pipes_devices_and_folders_are_not_opened(tmp_path):
    os.mkfifo(tmp_path / 'pipe.csv')
    for path in (str(tmp_path / 'pipe.csv'), '/dev/zero', str(tmp_path)):
        with pytest.raises(SceneError, match=r'is not a regular file \(pipes, devices'):
            read_table(path, (TIME,), remedy='')
    sea = {'spectrum': 'file', 'path': str(tmp_path / 'pipe.csv')}
    with pytest.raises(SceneError, match=r'ship\.sea\.path = .*is not a regular file'):
        load_scene('ideal', ship={'kind': 'sea', 'sea': sea})
    recorded = {'path': '/dev/zero', 'topic': 'imu'}
    with pytest.raises(SceneError, match=r'ship\.recorded\.path = .*is not a regular file'):
        load_scene('ideal', ship={'kind': 'recorded', 'recorded': recorded})


def test_a_file_beyond_the_limit_is_refused_unread(tmp_path):
    with (tmp_path / 'large.csv').open('wb') as file:
        file.truncate(LARGEST_BYTES + 1)  # sparse
    with pytest.raises(SceneError, match=rf'has {LARGEST_BYTES + 1} bytes; .*{LARGEST_BYTES}\.'):
        read_table(str(tmp_path / 'large.csv'), (TIME,), remedy='')


def test_a_large_file_takes_little_more_memory_than_its_numbers(tmp_path):
    rows = 100_000
    with (tmp_path / 'a.csv').open('w') as file:
        file.write('time_s,note\n')
        file.writelines(f'{row},{"x" * 90}\n' for row in range(rows))
    tracemalloc.start()
    table = read_table(str(tmp_path / 'a.csv'), (TIME,), remedy='')
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(table) == rows
    assert most < 5_000_000  # the text has 10 MB, the numbers and lines 1.6 MB


SECRET = 'root:$6$salt$hash:20228:0:99999:7:::\nsully:$6$pepper:20229::\n'


def test_messages_do_not_quote_a_file_named_by_mistake(tmp_path):
    """An error about another file, which may be passed on, quotes none of it."""
    file = tmp_path / 'shadow'
    file.write_text(SECRET)
    tries = [
        lambda: read_table(str(file), [Column('time_s')], remedy='Name another.'),
        lambda: load_scene(file),
        lambda: read_draws(file, load_scene('ideal')),
        lambda: hull_of_file(file.read_bytes(), str(file)),
        lambda: list(read_passages(str(file))),
    ]
    for refused in tries:
        with pytest.raises(TautoError) as caught:
            refused()
        assert not any(word in str(caught.value) for word in ('root:', 'salt', 'pepper', '20228'))


def test_a_header_is_told_where_it_has_names():
    assert header_words(['time_s', 'roll deg']) == 'time_s, roll deg'
    assert header_words([f'c{k}' for k in range(20)]).endswith('c11, …')
    assert header_words(['PATH=/bin']) == 'no names'
    assert header_words([]) == 'none'


def test_what_has_no_end_is_read_up_to_its_limit(tmp_path):
    with pytest.raises(OSError, match='not a regular file'):
        read_data(Path('/dev/zero'))
    with pytest.raises(FileNotFoundError):
        read_data(tmp_path / 'none')
    (tmp_path / 'some').write_bytes(b'1234')
    assert read_data(tmp_path / 'some', 4) == b'1234'
    with pytest.raises(OSError, match='more than 3 bytes'):
        read_data(tmp_path / 'some', 3)
    with pytest.raises(SceneError, match='cannot be read: is not a regular file'):
        read_draws(Path('/dev/zero'), load_scene('ideal'))
