"""The pictures of a voyage: contents, thinning, and files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import tauto_core as tauto
from tauto_core.charts import MOST_POINTS, PICTURES, chart, thinned
from tauto_core.cli.app import app
from tauto_core.cli.show import title_of


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
    rolling: tauto.Voyage, what: str
) -> None:
    found = chart(rolling, what)
    assert found.title
    for label in (found.x_label, found.y_label):
        unit = '[' in label or '°' in label or 'deviation' in label or label == 'density'
        assert unit, label
    for line in found.lines:
        assert len(line.x) == len(line.y) <= MOST_POINTS + 1
        for values in (line.x, line.y, line.high):
            assert values is None or np.isfinite(values).all(), (what, line.name)


def test_the_error_that_is_drawn_is_that_of_the_dial(rolling: tauto.Voyage) -> None:
    dial = next(line for line in chart(rolling, 'error').lines if line.name == 'dial')
    assert dial.x[-1] == 15.0  # minutes
    assert dial.y[-1] == rolling.clock_error_s[-1]


def test_the_amplitude_of_a_free_swing_is_that_of_its_release() -> None:
    """A pendulum without drag keeps its energy, whatever the shape of its well."""
    free = tauto.sail('involute_weight_at_sea', duration=60.0, ship={'kind': 'still'})
    [line] = chart(free, 'amplitude').lines
    np.testing.assert_allclose(line.y, 1.0, rtol=1e-9)


def test_a_known_roll_has_its_peak_where_it_is() -> None:
    """One harmonic of 9 s and 0.05 rad: the peak lies at 1/9 Hz, a bin of 1/120 Hz about it."""
    ship = {'kind': 'components', 'components': [{'amplitude': 0.05, 'period': 9.0}]}
    voyage = tauto.sail('second_cam_at_sea', duration=900.0, ship=ship)
    roll = next(line for line in chart(voyage, 'spectrum').lines if line.name.startswith('roll'))
    assert roll.x[int(np.argmax(roll.y))] == pytest.approx(1.0 / 9.0, abs=1.0 / 120.0)
    # the area is half the square of the amplitude in degrees
    area = float(np.trapezoid(roll.y, roll.x))
    assert area == pytest.approx(0.5 * np.degrees(0.05) ** 2, rel=0.05)


def test_a_picture_becomes_a_file_named_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ['plot', 'second_cam_at_sea', 'machine', '--duration', '60']
    run = CliRunner().invoke(app, words)
    assert run.exit_code == 0, run.stderr
    assert 'wrote second_cam_at_sea_machine.svg' in run.stderr
    assert Path('second_cam_at_sea_machine.svg').read_text(encoding='utf-8').startswith('<?xml')


@pytest.mark.parametrize(('suffix', 'begins'), [('png', b'\x89PNG'), ('pdf', b'%PDF')])
def test_a_file_is_what_its_suffix_says_and_the_same_each_time(
    rolling: tauto.Voyage, tmp_path: Path, suffix: str, begins: bytes
) -> None:
    files = [tmp_path / f'{name}.{suffix}' for name in 'ab']
    for file in files:
        rolling.plot('cam', file)
    first, second = (file.read_bytes() for file in files)
    assert first.startswith(begins)
    assert first == second


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        (('plot', 'ideal', 'sound'), "'sound': is not a picture. Choose one of error"),
        (('plot', 'ideal', 'error', '-o', 'x.jpg'), '--out x.jpg: must end in'),
        (('plot', 'ideal', 'error', '-o', 'no/x.png'), 'there is no folder no'),
        (('plot', 'globe_in_oil', 'machine', '--duration', '10'), 'has no trochlea'),
        (('report', 'ideal', '-o', 'x.pdf'), '--out x.pdf: must end in .html'),
    ],
)
def test_what_cannot_be_drawn_is_refused(words: tuple[str, ...], said: str) -> None:
    run = CliRunner().invoke(app, list(words))
    assert run.exit_code == 2
    assert said in run.stderr


@pytest.mark.parametrize(
    ('source', 'name'),
    [
        ('.', 'voyage_1.5'),
        ('../voyage_1.5', 'voyage_1.5'),
        ('sea.yaml', 'sea'),
        ('ideal', 'ideal'),
    ],
)
def test_a_picture_is_called_by_what_it_shows(
    source: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / 'voyage_1.5'
    folder.mkdir()
    monkeypatch.chdir(folder)
    assert title_of(source) == name
