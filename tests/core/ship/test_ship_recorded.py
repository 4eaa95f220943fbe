"""Measured motion from CSV: the part that is kept, and refusals."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tauto_core.scene import load_scene
from tauto_core.scene.errors import MotionDataError
from tauto_core.ship import ShipMotion, attitude
from tauto_core.ship.motions.recorded import band_limited, recorded_motion
from tauto_core.ship.waves import Harmonics, SampledHarmonics


def values(harmonics: Harmonics, time_s: np.ndarray) -> np.ndarray:
    angle = 2.0 * np.pi * time_s[:, None] / harmonics.period + harmonics.phase
    return harmonics.mean + np.sum(harmonics.amplitude * np.cos(angle), axis=1)


def scene_of(recorded: dict[str, Any], duration: float = 10.0):
    ship = {'kind': 'recorded', 'recorded': recorded}
    return load_scene('ideal', duration=duration, ship=ship, log={'interval': 1.0})


def csv_scene(path: Path, text: str, duration: float = 10.0, **keys):
    path.write_text(text, encoding='utf-8')
    columns = {'time_column': 't_s', 'roll_column': 'roll_deg', **keys}
    return scene_of({'path': str(path), **columns}, duration)


def rows(n: int = 101, step: float = 1.0, header: str = 't_s,roll_deg') -> list[str]:
    return [header, *(f'{step * i:.6f},{np.sin(0.6 * step * i):.9f}' for i in range(n))]


def test_the_passband_separates_harmonics_exactly():
    """Cosines n/(2 length) are the harmonics of the mirrored record: no leakage at all."""
    time = np.arange(201) * 0.5
    kept = 0.3 * np.cos(2 * np.pi * 0.05 * time) - 0.1 * np.cos(2 * np.pi * 0.4 * time)
    dropped = 2.0 + np.cos(2 * np.pi * 0.045 * time) + np.cos(2 * np.pi * 0.405 * time)
    without = band_limited(time, kept + dropped, (0.05, 0.4), keep_mean=False)
    with_mean = band_limited(time, kept + dropped, (0.05, 0.4), keep_mean=True)
    np.testing.assert_allclose(values(without, time), kept, rtol=0, atol=1e-13)
    np.testing.assert_allclose(values(with_mean, time), kept + 2.0, rtol=0, atol=1e-13)


def test_jittered_times_are_resampled():
    """A 10 s wave sampled at 5 Hz with 30 ms jitter: the spline errs by (w h)^4/384 = 2e-6."""
    random = np.random.default_rng(2)
    time = np.arange(1001) * 0.2 + random.uniform(-0.03, 0.03, 1001)
    time[0], time[-1] = 0.0, 200.0

    def wave(t):
        return np.cos(2 * np.pi * 0.1 * t)

    harmonics = band_limited(time, wave(time), (0.02, 0.4), keep_mean=False)
    between = np.linspace(0.0, 200.0, 7771)
    np.testing.assert_allclose(values(harmonics, between), wave(between), rtol=0, atol=2e-6)


def test_derivatives_are_those_of_the_curve():
    time = np.arange(301.0)
    harmonics = band_limited(time, np.sin(0.5 * time), (0.02, 0.4), keep_mean=False)
    x, v, a = SampledHarmonics(harmonics, 1_000_000).between(100_000, 101_001, 0, 1, 2)
    # central differences of a band below 2.6 rad/s: h^2 w^3/6 = 3e-6, h^2 w^4/12 and rounding
    np.testing.assert_allclose((x[2:] - x[:-2]) / 2e-3, v[1:-1], rtol=0, atol=1e-6)
    np.testing.assert_allclose((v[2:] - v[:-2]) / 2e-3, a[1:-1], rtol=0, atol=3e-6)


def test_measured_ship_rolls_as_recorded():
    """nbp1406: port side up is positive, as here. All but the highest frequencies kept."""
    shipped = load_scene('measured').ship.model_dump()
    shipped['recorded'] |= {'passband': [0.0, 0.49], 'heave_column': None}
    scene = load_scene('measured', ship=shipped)
    file = Path(__file__).parents[3] / 'src/tauto_core/tauto_core/scene/data/nbp1406_seapath'
    table = np.loadtxt(file / 's330_motion.csv', delimiter=',', skiprows=1)
    felt = attitude(ShipMotion(scene).produce(scene.samples))
    on_rows = np.degrees(felt.roll[:: round(scene.ship.rate)])[:600]
    # the rows are up to 7 ms off the second and are rounded to 0.01 deg
    assert np.std(on_rows - table[:600, 1]) < 0.05
    assert np.mean(on_rows - table[:600, 1]) == pytest.approx(0.0, abs=0.005)


def test_heave_and_scale():
    motion = recorded_motion(
        scene := load_scene('measured'), scene.ship.recorded.model_copy(update={'scale': -2.0})
    )
    plain = recorded_motion(scene, scene.ship.recorded)
    np.testing.assert_array_equal(motion.roll.amplitude, -2.0 * plain.roll.amplitude)
    # README: a roll of RMS 0.577 deg including frequencies below the band
    roll_rms = np.degrees(np.sqrt(np.sum(plain.roll.amplitude**2) / 2.0))
    assert roll_rms == pytest.approx(0.577, abs=0.03)
    # README: heave of RMS 1.12 m
    assert np.sqrt(np.sum(plain.heave.amplitude**2) / 2.0) == pytest.approx(1.12, abs=0.03)
    assert plain.roll.mean == 0.0


def test_units_come_from_the_suffix(tmp_path):
    degrees = '\n'.join(rows())
    in_degrees = ShipMotion(csv_scene(tmp_path / 'a.csv', degrees))
    table = [
        f'{t},{float(np.radians(float(x)))!r}' for t, x in (row.split(',') for row in rows()[1:])
    ]
    radians = '\n'.join(['t_s,roll_rad', *table])
    in_radians = ShipMotion(csv_scene(tmp_path / 'b.csv', radians, roll_column='roll_rad'))
    np.testing.assert_allclose(
        in_degrees.produce(50).orientation, in_radians.produce(50).orientation, atol=1e-15
    )


def test_short_gaps_are_interpolated_and_counted(tmp_path):
    whole = rows(201, 0.5)
    with_gap = whole[:100] + whole[103:]
    scene = csv_scene(tmp_path / 'a.csv', '\n'.join(with_gap), duration=60.0)
    bridged, unbroken = (
        ShipMotion(scene),
        ShipMotion(csv_scene(tmp_path / 'b.csv', '\n'.join(whole), 60.0)),
    )
    assert bridged.metadata['gaps_interpolated'] == 1
    assert unbroken.metadata['gaps_interpolated'] == 0
    # a 10 s wave over a gap of 2 s: the spline errs by 5 (w h)^4/384 = 3 % of 1 deg at most
    np.testing.assert_allclose(
        attitude(bridged.produce(1000)).roll,
        attitude(unbroken.produce(1000)).roll,
        rtol=0,
        atol=0.03 * np.radians(1.0),
    )


def changed(index: int, row: str) -> str:
    table = rows()
    table[index] = row
    return '\n'.join(table)


REFUSED = [
    ('', {}, r'a\.csv: line 1, column t_s: is missing; the columns are none'),
    ('\n'.join(rows(3)), {}, r'has 3 samples, fewer than the 4'),
    (
        '\n'.join(rows()),
        {'roll_column': 'x_deg'},
        'x_deg: is missing; the columns are t_s, roll_deg',
    ),
    ('\n'.join(rows(header='t_s,t_s')), {'roll_column': 't_s'}, r'roll_column.*_rad or _deg'),
    ('\n'.join(rows()), {'roll_column': 'roll'}, r"roll_column = 'roll'.*_rad or _deg"),
    ('\n'.join(rows()), {'time_column': 't_ms'}, r"time_column = 't_ms'.*end in _s\."),
    (changed(5, '3.0,1.0'), {}, r'line 6: time 3 s.*repeats the time before, 3 s'),
    (changed(5, '2.5,1.0'), {}, r'line 6: time 2\.5 s.*goes back from'),
    (changed(7, '6.0,90'), {}, r'line 8: roll = 1\.5708 rad.*within ±1\.5708 rad'),
    (changed(101, '1e12,1.0'), {'max_gap': 1e13}, r'line 102: .*1e\+12 s, more than 50000000'),
    ('\n'.join(rows()[:40] + rows()[43:]), {}, r'line 41: gap of 4 s.*max_gap = 3\.0 s'),
    ('\n'.join(rows()), {'passband': [0.02, 0.5]}, r'sampled every 1 s.*ends at 0\.5 Hz'),
    ('\n'.join(rows(41)), {}, r'lasts 40 s.*needs at least 50 s'),
    ('\n'.join(rows()), {'passband': [0.1, 0.105]}, r'lasts 100 s.*needs at least 200 s'),
]


@pytest.mark.parametrize(('text', 'keys', 'message'), REFUSED)
def test_csv_refused_with_file_place_value_and_limit(tmp_path, text, keys, message):
    scene = csv_scene(tmp_path / 'a.csv', text, **keys)
    with pytest.raises(MotionDataError, match=message) as refused:
        ShipMotion(scene)
    assert str(tmp_path / 'a.csv') in str(refused.value)
    assert refused.value.exit_code == 2


def test_heave_in_another_unit_is_refused(tmp_path):
    text = '\n'.join(f'{row},{row.split(",")[0]}e2' for row in rows()).replace('t_se2', 'heave_m')
    scene = csv_scene(tmp_path / 'a.csv', text, heave_column='heave_m')
    with pytest.raises(MotionDataError, match=r'line 12: heave = 1000 m.*within ±1000 m'):
        ShipMotion(scene)


def test_the_longest_duration_that_is_named_is_accepted():
    said = r'lasts 700\.0 s, the record only 624\.003 s.*at most 624\.$'
    with pytest.raises(MotionDataError, match=said):
        ShipMotion(load_scene('measured', duration=700.0))
    assert ShipMotion(load_scene('measured', duration=624.0)).total > 624
