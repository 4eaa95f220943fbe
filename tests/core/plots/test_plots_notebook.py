"""Results in notebooks: the answer in words, and a picture."""

from __future__ import annotations

import re
from base64 import b64decode
from html import unescape
from io import BytesIO

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from PIL import Image

import tauto_core as tauto
from tauto_core.plots.chart import COLOURS, Chart, Line, draw
from tauto_core.plots.picture import picture_html

MOST = 80_000
"""Characters that a result may have: a notebook of fifty stays below the 4 MB of a screen."""


def picture(html: str) -> Image.Image:
    """Return the one image of a page."""
    [content] = re.findall(r'src="data:image/png;base64,([^"]+)"', html)
    return Image.open(BytesIO(b64decode(content)))


@pytest.fixture(scope='module')
def voyage() -> tauto.Voyage:
    return tauto.sail('involute_weight_at_sea', duration=3600.0)


def test_a_voyage_is_its_answer_and_its_error(voyage: tauto.Voyage) -> None:
    shown = voyage._repr_html_()
    assert voyage.answer in unescape(shown)
    assert picture(shown).size == (921, 576)
    assert len(shown) < MOST


def test_a_picture_is_shown_and_still_a_figure() -> None:
    drawn = tauto.plot(tauto.sail('measured', duration=60.0), 'error')
    assert isinstance(drawn, Figure)
    shown = drawn._repr_html_()
    assert 'alt="Error of the clock. reading − true time [s] against time' in shown


def test_a_map_with_long_coasts_is_small_and_keeps_its_colours() -> None:
    """Across the Atlantic the coasts have 12,000 points, 400 kB of SVG."""
    longitude, latitude = np.array([-1.0, -17.0, -61.0, -77.0]), np.array([51.0, 33.0, 17.0, 18.0])
    lines = [
        Line('the ship', longitude, latitude, 'green'),
        Line('by the dial', longitude + 20.0, latitude, 'blue'),
    ]
    shown = picture_html(draw(Chart('Map', 'east', 'north', lines, is_map=True), 'x'))
    assert len(shown) < 60_000
    seen = np.asarray(picture(shown).convert('RGB')).reshape(-1, 3).astype(int)
    for name in ('green', 'blue'):
        asked = np.array(to_rgb(COLOURS[name])) * 255.0
        near = np.max(np.abs(seen - asked), axis=1) < 12.0
        assert np.count_nonzero(near) > 300


def test_a_comparison_is_a_sentence_and_a_row_for_each_case() -> None:
    found = tauto.compare('clock_cheek_weight', 'clock_own_cam_weight', duration=600.0, jobs=1)
    assert found.answer.startswith('After 10 minutes in the same sea the dial of clock_own_cam')
    shown = found._repr_html_()
    assert found.answer in unescape(shown)
    cells = [re.findall('<td>(.*?)</td>', row) for row in shown.split('<tr>')[2:]]
    names = ('clock_cheek_weight', 'clock_own_cam_weight')
    assert [row[:2] for row in cells] == [[n, how] for n in names for how in ('fixed', 'hung')]
    assert cells[0][2].startswith('−') == (found.rows[0].rate_s_per_day < 0.0)


def test_a_clock_that_stopped_says_why() -> None:
    found = tauto.compare(  # each impulse so strong that the swing reaches the end of the cam
        'clock_cheek_weight', suspension='without', duration=60.0, jobs=1, escapement__energy=2e-3
    )
    [row] = found.rows
    assert row.stopped is not None
    assert row.stopped.why in found._repr_html_().replace('&#x27;', "'")
    assert found.answer.endswith('no clock goes.')


def test_fleet_is_its_answer_and_the_errors_of_its_ships() -> None:
    found = tauto.fleet('second_cam_at_sea', ships=3, duration=60.0, jobs=1)
    assert found.answers.answer in repr(found)
    shown = found._repr_html_()
    assert found.answers.answer in unescape(shown)
    assert len(shown) < MOST
