"""The pictures of a voyage: contents, thinning, files, and the motion that they show."""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke, refused

import tauto_core as tauto
from tauto_core.curves.numerics import trapezoid
from tauto_core.plots.chart import draw
from tauto_core.plots.contents import MOST_POINTS, PICTURES, TAPER_S, chart, seaway, thinned
from tauto_core.samples import READING, TimeSamples

SEAS = (
    {'significant_wave_height': 1.0, 'peak_period': 6.0, 'heading': 1.5708},
    {'significant_wave_height': 1.0, 'peak_period': 6.0, 'heading': 4.7124},
    {'significant_wave_height': 5.0, 'peak_period': 11.0, 'heading': 2.0},
)
SHIP = {
    'kind': 'sea',
    'weather': {
        'kind': 'states',
        'components': 16,
        'states': [{'at': 60.0 * at, **sea} for at, sea in zip((0, 20, 35), SEAS, strict=True)],
    },
    'rao': None,
    'roll': {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': 0.7},
    'heave': True,
    'rate': 10.0,
}
VOYAGE = {
    'departure': [0.0, 0.0],
    'waypoints': [{'place': [0.0, 0.05], 'landfall': True}],
    'arrival': [0.0, 0.1],
    'sails_at': 600.0,
    'arrives_at': 2400.0,
}


ROLL = ('plot', 'second_cam_at_sea', 'roll')


@pytest.fixture(scope='module')
def stormy() -> tauto.Voyage:
    """Return fifty minutes with departure, landfall, storm and arrival."""
    air = {'kind': 'constant', 'celsius': 12.0, 'diurnal': 3.0}
    changes = {'ship': SHIP, 'voyage': VOYAGE, 'air': air, 'log': {'motion': False}}
    return tauto.sail('second_cam_at_sea', duration=3000.0, **changes)


@pytest.fixture(scope='module')
def rolling() -> tauto.Voyage:
    return tauto.sail('second_cam_at_sea', duration=900.0)


def test_thinning_keeps_every_extreme() -> None:
    rng = np.random.default_rng(1714)
    x = np.arange(100_000.0)
    y = rng.normal(size=len(x))
    y[[31_415, 92_653]] = 50.0, -50.0
    at, kept = thinned(x, y)
    assert len(at) <= MOST_POINTS
    assert (np.diff(at) > 0.0).all()
    assert {50.0, -50.0} <= set(kept.tolist())
    assert (at[0], at[-1]) == (x[0], x[-1])
    # all values that are shown were there, at their places
    assert (y[at.astype(int)] == kept).all()
    short = thinned(x[:10], y[:10])
    assert short[0].tolist() == x[:10].tolist()


@pytest.mark.parametrize('what', sorted(PICTURES))
def test_each_picture_has_axes_with_units_and_finite_lines(
    stormy: tauto.Voyage, what: str
) -> None:
    found = chart(stormy, what)
    assert found.title
    for panel in found.panels:
        for label in (panel.x_label, panel.y_label):
            assert '[' in label or 'deviation' in label, label
        assert any(len(line.x) for line in panel.lines)
        for line in panel.lines:
            assert len(line.x) == len(line.y) <= MOST_POINTS + 1
            for values in (line.x, line.y, line.high):
                assert values is None or np.isfinite(values).all(), (what, line.name)


@pytest.mark.parametrize(
    ('what', 'middle', 'sigma'),
    [
        ('error', 'estimated_error_s', 'estimated_error_sigma_s'),
        ('rate', 'estimated_mean_rate_s_per_day', 'estimated_mean_rate_sigma_s_per_day'),
        ('drift', None, 'estimated_error_sigma_s'),
        ('longitude', 'longitude_error_nmi', 'longitude_sigma_nmi'),
    ],
)
def test_a_band_reaches_a_sigma_to_both_sides(
    stormy: tauto.Voyage, what: str, middle: str | None, sigma: str
) -> None:
    (band,) = (line for line in chart(stormy, what).lines if line.kind == 'band')
    assert band.high is not None
    minutes = stormy.time_s / 60.0
    half = np.interp(band.x, minutes, getattr(stormy, sigma))
    about = 0.0 if middle is None else np.interp(band.x, minutes, getattr(stormy, middle))
    np.testing.assert_allclose(band.y, about - half, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(band.high, about + half, rtol=1e-12, atol=1e-12)
    assert float(half.min()) > 0.0


def test_events_are_marked_on_every_chart_over_time(stormy: tauto.Voyage) -> None:
    """Departure at 10 minutes, landfall half way, a storm, and arrival at 40."""
    for what in ('error', 'rate', 'drift', 'longitude', 'amplitude', 'weather'):
        named = [(mark.x, mark.name) for mark in chart(stormy, what).marks if mark.name]
        assert [name for _, name in named] == ['sails', 'landfall', 'storm', 'arrives'], what
        np.testing.assert_allclose([x for x, _ in named], [10.0, 25.0, 35.0, 40.0], rtol=1e-6)
    dotted = [mark.x for mark in chart(stormy, 'error').marks if not mark.name]
    assert dotted == [20.0]
    assert 'Dotted: the sea has changed.' in chart(stormy, 'error').note


def test_rate_changes_at_departure_not_before(stormy: tauto.Voyage) -> None:
    """The dial goes right in port, and loses 140 s/day from the landfall to the arrival."""
    reading = stormy.samples[READING]
    assert isinstance(reading, TimeSamples)
    lost_s = -140.0 / 86400.0 * np.clip(stormy.time_s - 600.0, 0.0, 1800.0)
    wrong = replace(reading, time_ref_ns=reading.stamp_ns + np.round(1e9 * lost_s).astype(int))
    changed = replace(stormy, samples={**stormy.samples, READING: wrong})
    line = next(each for each in chart(changed, 'rate').lines if each.name.startswith('dial'))
    begin, end, rate = line.x[::2], line.x[1::2], line.y[::2]
    assert (line.y[1::2] == rate).all()
    assert (begin[0], end[-1]) == (0.0, 50.0)
    assert (begin[1:] == end[:-1]).all()
    assert {10.0, 20.0, 25.0, 35.0, 40.0} <= set(begin.tolist())
    # a rounded nanosecond in a piece of two minutes
    expected = np.where((begin >= 10.0) & (end <= 40.0), -140.0, 0.0)
    np.testing.assert_allclose(rate, expected, atol=1e-9 / 100.0 * 86400.0)


def test_by_default_the_roughest_part_is_shown_and_named(stormy: tauto.Voyage) -> None:
    """The storm has its height at 35 of 50 minutes. Before, the sea is a fifth as high."""
    for what in ('roll', 'spectrum'):
        assert chart(stormy, what).panels[-1].note.startswith('The ten minutes about the highest')
        assert '30 to 40 minutes' in chart(stormy, what).panels[-1].note
    shown = chart(stormy, 'roll')
    assert shown.x_label == 'time since 30 minutes [minutes]'
    asked = chart(stormy, 'roll', 1800.0, 2400.0)
    np.testing.assert_array_equal(shown.lines[0].y, asked.lines[0].y)
    # the motion builds up with the sea
    calm = chart(stormy, 'roll', 0.0, 600.0)
    for part in (0, 1):
        sizes = [np.std(each.panels[part].lines[0].y) for each in (calm, shown)]
        assert sizes[1] > 2.0 * sizes[0]


def test_a_part_is_asked_for_by_its_beginning_its_end_or_both(stormy: tauto.Voyage) -> None:
    for given, minutes in (
        ((300.0, 420.0), (5.0, 7.0)),
        ((300.0, None), (5.0, 15.0)),
        ((None, 900.0), (5.0, 15.0)),
        ((2700.0, None), (45.0, 50.0)),
    ):
        found = chart(stormy, 'roll', *given)
        begin, end = minutes
        assert f'{begin:g} to {end:g} minutes' in found.panels[-1].note
        time = found.lines[0].x
        shown = (end - begin) * (60.0 if 'minutes' not in found.x_label.split('[')[1] else 1.0)
        # the step of the motion is a tenth of a second
        np.testing.assert_allclose([time[0], time[-1]], [0.0, shown], atol=0.11)


def test_roughest_part_has_the_largest_logged_motion() -> None:
    """Two harmonics of nearly one period beat: the greatest roll is half a beat from the end."""
    one = {'amplitude': 0.05, 'period': 9.0}
    beat = [one, {**one, 'period': 9.027, 'phase': 3.1416}]
    ship = {'kind': 'components', 'components': beat, 'height': 0.0}
    voyage = tauto.sail('second_cam_at_sea', duration=3000.0, ship=ship)
    found = chart(voyage, 'roll')
    assert found.panels[-1].note.startswith('The roughest ten minutes')
    middle = float(found.x_label.split()[2]) + 5.0
    # the beat lasts 9 · 9.027/0.027 s = 50.15 minutes
    assert middle == pytest.approx(25.07, abs=0.5)


def test_the_weather_is_that_of_the_scene(stormy: tauto.Voyage) -> None:
    height, period, heading = chart(stormy, 'weather').panels
    labels = [panel.y_label for panel in (height, period, heading)]
    assert labels == ['significant height [m]', 'peak period [s]', 'heading [°]']
    (line,) = height.lines
    assert (line.x[0], line.x[-1]) == (0.0, 50.0)
    # half way between two seas the squares of their heights have equal parts
    half_way = np.hypot(1.0, 5.0) / np.sqrt(2.0)
    for minutes, metres in ((0.0, 1.0), (20.0, 1.0), (27.5, half_way), (35.0, 5.0), (50.0, 5.0)):
        assert np.interp(minutes, line.x, line.y) == pytest.approx(metres, rel=1e-9)
    assert period.lines[0].x.tolist() == heading.lines[0].x.tolist() == [0.0, 20.0, 35.0]
    assert period.lines[0].y.tolist() == [6.0, 6.0, 11.0]
    np.testing.assert_allclose(heading.lines[0].y, [90.0, -90.0, np.degrees(2.0)], atol=1e-3)


def test_the_temperature_is_that_of_the_clock() -> None:
    air = {'kind': 'constant', 'celsius': 12.0, 'diurnal': 3.0, 'box_hours': 1.0}
    changes = {'ship.kind': 'still', 'log.interval': 60.0, 'air': air}
    warm = tauto.sail('ideal', duration=86400.0, **changes)
    (line,) = chart(warm, 'temperature').lines
    assert (line.x[0], line.x[-1]) == (0.0, 24.0)
    half = 3.0 / np.hypot(1.0, 2.0 * np.pi / 24.0)
    assert (line.y.min(), line.y.max()) == pytest.approx((12.0 - half, 12.0 + half), abs=1e-3)


def test_many_changes_of_the_weather_are_counted_and_not_marked() -> None:
    seas = [{'at': 700.0 * k, **SEAS[k % 2]} for k in range(12)]
    ship = SHIP | {'weather': {'kind': 'states', 'states': seas, 'components': 2}}
    many = tauto.sail('second_cam_at_sea', duration=7800.0, ship=ship, log={'motion': False})
    found = chart(many, 'error')
    assert found.marks == []
    assert 'The sea changes 11 times' in found.note


def test_chart_of_the_error_has_the_dial_and_no_events(rolling: tauto.Voyage) -> None:
    shown = chart(rolling, 'error')
    dial = next(line for line in shown.lines if line.name == 'dial')
    assert (dial.x[-1], dial.y[-1]) == (15.0, rolling.clock_error_s[-1])  # minutes
    assert shown.marks == []
    assert 'sea' not in shown.note


def test_the_amplitude_of_a_free_swing_is_that_of_its_release() -> None:
    """A pendulum without drag keeps its energy, whatever the shape of its well."""
    free = tauto.sail('involute_weight_at_sea', duration=60.0, ship={'kind': 'still'})
    [line] = chart(free, 'amplitude').lines
    np.testing.assert_allclose(line.y, 1.0, rtol=1e-9)


def test_a_known_roll_has_its_peak_where_it_is() -> None:
    """One harmonic of 9 s and 0.05 rad: the peak is at 1/9 Hz, a bin of 1/120 Hz about it."""
    ship = {'kind': 'components', 'components': [{'amplitude': 0.05, 'period': 9.0}]}
    voyage = tauto.sail('second_cam_at_sea', duration=900.0, ship=ship)
    [roll] = chart(voyage, 'spectrum', 0.0, 900.0).lines
    assert roll.x[int(np.argmax(roll.y))] == pytest.approx(1.0 / 9.0, abs=1.0 / 120.0)
    # the area is half the square of the amplitude in degrees
    area = trapezoid(roll.y, roll.x)
    assert area == pytest.approx(0.5 * np.degrees(0.05) ** 2, rel=0.05)


def test_files_are_what_their_suffix_says_and_the_same_each_time(
    rolling: tauto.Voyage, tmp_path: Path
) -> None:
    """SVG has searchable text, and PNG two dots per CSS pixel, at 6.4 inches."""
    for suffix, begins in (('svg', b'<?xml'), ('png', b'\x89PNG'), ('pdf', b'%PDF')):
        files = [tmp_path / f'{name}.{suffix}' for name in 'ab']
        for file in files:
            rolling.plot('error', file)
        first, second = (file.read_bytes() for file in files)
        assert first.startswith(begins)
        assert first == second
    words = ' '.join(ET.parse(tmp_path / 'a.svg').getroot().itertext())
    for each in ('second_cam_at_sea: error of the clock', 'reading − true time [s]', 'dial'):
        assert each in words
    png = (tmp_path / 'a.png').read_bytes()
    assert struct.unpack('>II', png[16:24])[0] == int(6.4 * 2 * 96)
    assert b'second_cam_at_sea: error' in png


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        (
            (*ROLL, '--duration', '300', '--from', '240', '--to', '6 min', '-o', 'no.svg'),
            'from 240 to 360 s: is not a part of the voyage',
        ),
        ((*ROLL[:2], 'error', '--from', '0', '--to', '60'), 'error: shows the whole voyage'),
        (('plot', 'ideal', 'error', '-o', 'no/x.png'), 'there is no folder no'),
        (('plot', 'globe_in_oil', 'cam', '--duration', '10'), 'has no trochlea'),
        (('plot', 'ideal', 'weather'), 'weather: ideal has no sea that changes'),
        (('plot', 'ideal', 'temperature'), 'temperature: ideal has no air'),
    ],
)
def test_what_cannot_be_drawn_is_refused(words: tuple[str, ...], said: str) -> None:
    assert said in refused(*words)


def test_a_picture_is_called_by_its_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bag, scene = tmp_path / 'bag_1.5', tmp_path / 'sea.yaml'
    tauto.sail('ideal', duration=60.0, out=bag)
    tauto.new_scene(scene)
    monkeypatch.chdir(bag)
    for source in ('.', '../sea.yaml', 'ideal'):
        assert invoke('plot', source, 'cam').exit_code == 0
    names = {file.name for file in bag.glob('*.svg')}
    assert names == {'bag_1.5_cam.svg', 'sea_cam.svg', 'ideal_cam.svg'}


def test_a_picture_of_a_scene_alone_needs_no_voyage(tmp_path: Path) -> None:
    """Eighty-one days at sea take most of a minute."""
    for what in ('weather', 'machine', 'cam'):
        run = invoke('plot', 'portsmouth_jamaica', what, '-o', tmp_path / f'{what}.svg')
        assert run.exit_code == 0, run.stderr
        assert run.stderr == f'tauto: wrote {tmp_path / what}.svg\n'


def test_no_words_of_a_picture_lie_on_others(stormy: tauto.Voyage) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    for what in ('error', 'weather', 'machine', 'roll'):
        figure = draw(chart(stormy, what), 'a scene with a rather long name')
        FigureCanvasAgg(figure).draw()
        texts = [
            text for axes in figure.axes for text in (*axes.texts, axes.title, axes._left_title)
        ]
        boxes = [text.get_window_extent() for text in texts if text.get_text()]
        for number, box in enumerate(boxes):
            assert box.x1 <= figure.bbox.x1, what
            assert not any(box.overlaps(other) for other in boxes[:number]), what


# -----------------------------------------------------------------------------
# Roll and heave for the pictures, against a motion in closed form.

COMPONENTS_SHIP = {
    'kind': 'components',
    'rate': 20.0,
    'height': 0.0,
    'components': [{'amplitude': 0.1, 'period': 11.0}],
    'heave': [{'amplitude': 1.5, 'period': 8.0}, {'amplitude': 0.4, 'period': 5.0, 'phase': 1.0}],
}


@pytest.fixture(scope='module', params=[True, False], ids=['kept', 'made anew'])
def voyage(request: pytest.FixtureRequest) -> tauto.Voyage:
    log = {'interval': 1.0, 'motion': request.param}
    return tauto.sail('second_cam_at_sea', ship=COMPONENTS_SHIP, log=log, duration=1500.0)


def test_heave_is_the_acceleration_integrated_twice(voyage: tauto.Voyage) -> None:
    """Fading and what leaks below the lowest frequency leave 3 % of the larger wave."""
    found = seaway(voyage, 300.0, 600.0)
    assert found.time_s[0] == pytest.approx(300.0, abs=0.051)
    assert found.time_s[-1] == pytest.approx(900.0, abs=0.1)
    t = found.time_s
    heave = 1.5 * np.cos(2 * np.pi * t / 8.0) + 0.4 * np.cos(2 * np.pi * t / 5.0 + 1.0)
    inside = slice(int(TAPER_S * 20.0), -int(TAPER_S * 20.0))
    np.testing.assert_allclose(found.heave_m[inside], heave[inside], atol=0.045)
    np.testing.assert_allclose(found.roll_rad, 0.1 * np.cos(2 * np.pi * t / 11.0), atol=1e-9)


def test_a_ship_that_lies_still_has_no_heave() -> None:
    found = seaway(tauto.sail('ideal', duration=60.0))
    assert np.all(found.heave_m == 0.0)
