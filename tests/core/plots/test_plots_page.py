"""The page of a report: self-contained, and as shown by a browser."""

from __future__ import annotations

import base64
import json
import math
import re
from collections.abc import Iterator
from functools import cache
from html import unescape
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from browser import BROWSER, Browser

import tauto_core as tauto
from tauto_core.machines import LeverMachine, compile_machine
from tauto_core.plots.chart import Chart, Line, Mark
from tauto_core.plots.contents import chart
from tauto_core.plots.page import INK, animation, chart_svg, report_html, write_report

LARGEST_BYTES = 1_500_000
TAB, ENTER, RIGHT, END, HOME = 9, 13, 39, 35, 36


@cache
def sailed(name: str) -> tauto.Voyage:
    """Return a minute of a shipped scene."""
    return tauto.sail(name, duration=60.0)


@cache
def report(name: str) -> str:
    """Return the page of that minute."""
    return report_html(sailed(name), f'tauto report {name}')


@pytest.fixture(scope='module')
def voyage() -> tauto.Voyage:
    return tauto.sail('second_cam_at_sea', duration=120.0)


@pytest.fixture(scope='module')
def page(voyage: tauto.Voyage, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp('report') / 'report.html'
    voyage.report(file)
    return file


def test_the_page_holds_all_it_needs(page: Path) -> None:
    text = page.read_text(encoding='utf-8')
    assert not re.search(r'<[^>]*\s(?:src|href|data)=', text)
    assert page.stat().st_size < LARGEST_BYTES
    for words in (
        f'voyage.report(&#x27;{page}&#x27;)',
        'lever_rate: 0.01',
        'llvmlite ',
        '<h2>The ship in the sea, and its clock</h2>',
        '<svg id="ship-view"',
        '"track":null',  # it stays in the open sea
    ):
        assert words in text, words
    assert '<section id="map">' not in text


@pytest.mark.parametrize(
    ('name', 'heading', 'work'),
    [
        ('globe_in_oil', 'The body on its curve', "A body on Euler's curve of 1729 in a fluid"),
        ('ideal', 'The clock', "Sully's clock of 1726 with Euler's second cam of 1727"),
    ],
)
def test_a_clock_on_land_is_shown_without_ship_and_sea(name: str, heading: str, work: str) -> None:
    answer = sailed(name).answer
    text = report(name)
    body = text[text.index('<main>') : text.index('</main>')]
    assert f'<h2>{heading}</h2>' in body
    assert not re.search(r'\b(?:sea|water|waves|ship)\b', re.sub(r'<script.*?</script>', '', body))
    shown = unescape(text)
    first, _, more = answer.partition('. ')
    assert f'<h1 class="answer">{first}.</h1>\n<p class="more">{more}</p>' in shown
    assert f'{work}, simulated by Tauto.' in shown
    assert ('the navigator measured the rate' in shown) is ('rated and' in answer)
    if name == 'globe_in_oil':
        assert '<section id="machine">' in text
        assert 'cam: globe_in_oil has no trochlea' in text


def test_the_animation_stands_where_the_wheel_stood(voyage: tauto.Voyage) -> None:
    """A cos φ against the logged angle. The swing on the second cam and the roll are sines.

    They agree to the size of the forced oscillation by the roll.
    """
    part = animation(voyage)
    angle = np.array(part['amplitude_rad']) * np.cos(np.array(part['phase_rad']))
    assert np.abs(angle - voyage.angle_rad).max() < 1e-3 + 0.05
    assert np.corrcoef(angle, voyage.angle_rad)[0, 1] > 0.998
    assert (part['from_s'], part['length_s']) == (0.0, 120.0)
    json.dumps(part, allow_nan=False)


def test_a_chart_has_the_colours_of_the_page_alone(voyage: tauto.Voyage) -> None:
    """Marks and clips of two charts have different names, and no style holds for the page."""
    drawn = [chart_svg(chart(voyage, what), 6.4) for what in ('error', 'roll')]
    for text in drawn:
        ElementTree.fromstring(text)
        assert not re.search('#[0-9a-f]{6}|<style|<metadata', text)
        assert set(re.findall(r'var\(--(\w+)\)', text)) <= set(INK['dark'])
    assert 'var(--orange)' in drawn[0]
    names = [set(re.findall(r' id="([^"]+)"', text)) for text in drawn]
    assert names[0]
    assert not names[0] & names[1]


def test_names_of_marks_stand_above_the_frame_and_apart() -> None:
    """A storm 9.7 days after sailing and 7.3 before landfall, of 76, needs a row of its own."""
    days = np.array([0.0, 76.0])
    at = {'landfall': 31.0, 'arrives': 76.0, 'sails': 14.0, 'storm': 19.7}
    marks = [Mark(x, name) for name, x in at.items()]
    of = Chart('', 'days', 's', [Line('', days, days)], marks=[*marks, Mark(3.0)])
    assert [[mark.x for mark in row] for row in of.name_rows] == [[14.0, 31.0, 76.0], [19.7]]


def test_a_body_in_a_fluid_moves_on_its_curve() -> None:
    """At each reading it is on the curve at the logged arc."""
    globe = sailed('globe_in_oil')
    found = animation(globe)
    arc = np.array(found['amplitude_rad']) * np.cos(np.array(found['phase_rad']))
    assert (arc[0], globe.angle_rad[0]) == pytest.approx((0.4, 0.4), abs=1e-4)
    table = {key: np.array(values) for key, values in found['curve'].items()}
    assert table['arc_m'].min() <= globe.angle_rad.min()
    assert table['arc_m'].max() >= globe.angle_rad.max()
    # the table's own chords, in mm, are as long as its arcs, but for their curvature
    chords = np.hypot(np.diff(table['x']), np.diff(table['y']))
    np.testing.assert_allclose(chords, 1000.0 * np.diff(table['arc_m']), rtol=0.01)
    assert {line['with'] for line in found['lines']} == {'ship', 'body'}


def test_a_lever_moves_as_the_geometry_says() -> None:
    """β from virtual work: T(θ) t dθ = m g AD cos β dβ, so dβ/dθ is the machine's ratio."""
    found = animation(sailed('sully_lever_at_sea'))
    machine = compile_machine(tauto.load('sully_lever_at_sea'))
    assert isinstance(machine, LeverMachine)
    angle, beta = (np.array(found['lever'][key]) for key in ('angle_rad', 'beta_rad'))
    for at in (-1.0, 0.3, 1.0):
        slope = np.interp(at, 0.5 * (angle[1:] + angle[:-1]), np.diff(beta) / np.diff(angle))
        assert slope == pytest.approx(float(machine.ratio(at)), abs=2e-3)
    named = {line['name'] for line in found['lines'] if line['with'] == 'lever'}
    assert named == {'lever', 'weight'}
    assert (found['lever']['x'], found['lever']['y']) == pytest.approx((-100.0, -320.0))


def test_case_and_thread_follow_the_apparent_vertical() -> None:
    """On a ship that only rolls, about the bearing, that is the true one: the case hangs still."""
    ship = {'kind': 'components', 'height': 0.0, 'components': [{'amplitude': 0.1, 'period': 9.0}]}
    hung = animation(tauto.sail('suspended_weight_at_sea', duration=60.0, ship=ship))
    assert np.abs(hung['roll_rad']).max() == pytest.approx(0.1, abs=1e-3)
    assert np.abs(hung['plumb_rad']).max() < 1e-5
    assert hung['pivot'] == [0.0, 100.0]
    carriers = {line['name']: line['with'] for line in hung['lines'] if line['name']}
    assert (carriers['bearing'], carriers['axle of the case']) == ('ship', 'case')
    # three metres above the roll axis y'' = 3 w2 roll to port, and the mast leans against the roll
    above = tauto.sail('suspended_weight_at_sea', duration=60.0, ship=ship | {'height': 3.0})
    part = animation(above)
    leans = -3.0 * (2.0 * np.pi / 9.0) ** 2 / 9.80665 * np.array(part['roll_rad'])
    np.testing.assert_allclose(part['plumb_rad'], leans, atol=2e-4)
    fixed = animation(tauto.sail('measured', duration=20.0))
    assert (fixed['pivot'], fixed['hangs'], hung['hangs']) == (None, True, False)
    assert {'roll_rad', 'plumb_rad'} <= set(fixed)


def test_of_a_long_voyage_the_roughest_ten_minutes_are_shown() -> None:
    """With the phase and the roll that the voyage has there."""
    long = tauto.sail('second_cam_at_sea', duration=3000.0)
    part = animation(long)
    assert (part['which'], part['length_s']) == ('the roughest ten minutes', 600.0)
    first = int(np.searchsorted(long.time_s, part['from_s']))
    assert part['phase_rad'][60] == pytest.approx(long.phase_rad[first + 60], abs=1e-4)
    assert part['roll_rad'][240] == pytest.approx(long.roll_rad[first + 60], abs=1e-4)
    size = np.square(long.roll_rad)
    mean = [float(np.mean(size[at : at + 600])) for at in range(0, len(size) - 600, 100)]
    assert float(np.mean(size[first : first + 600])) > 0.95 * max(mean)


@pytest.fixture(scope='module')
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    if BROWSER is None:
        pytest.skip('no browser: sudo apt-get install chromium')
    with Browser(tmp_path_factory.mktemp('profile')) as found:
        yield found


@pytest.mark.parametrize(('width', 'dark'), [(380, True), (1600, False)])
def test_a_browser_shows_it(browser: Browser, page: Path, width: int, *, dark: bool) -> None:
    browser.show(page, width, dark=dark)
    assert browser.run('innerWidth') == width
    assert browser.run('document.documentElement.scrollWidth') <= width
    assert browser.run("document.querySelectorAll('.chart svg').length") >= 10
    ink = browser.run('getComputedStyle(document.body).color')
    assert ink == ('rgb(237, 237, 237)' if dark else 'rgb(27, 27, 27)')
    of_charts = browser.run(
        "[...document.querySelectorAll('#error path')].map((e) => getComputedStyle(e).stroke)"
    )
    blue = INK['dark' if dark else 'light']['blue']
    assert f'rgb({", ".join(str(int(blue[k : k + 2], 16)) for k in (1, 3, 5))})' in of_charts
    size = browser.run(
        "Math.min(...[...document.querySelectorAll('p, td, button, li')].map("
        '(e) => parseFloat(getComputedStyle(e).fontSize)))'
    )
    assert size >= 12.0
    assert browser.faults == []


def test_the_map_has_coasts_names_and_the_ship(browser: Browser, tmp_path: Path) -> None:
    """In Portsmouth."""
    harbour = {'departure': [50.79, -1.11], 'arrival': [50.4, -1.5], 'sails_at': 600.0}
    lies = tauto.sail(
        'second_cam_at_sea', duration=120.0, voyage={**harbour, 'arrives_at': 7200.0}
    )
    write_report(lies, tmp_path / 'lies.html', 'tauto report')
    assert '"fill: var(--land)' in (tmp_path / 'lies.html').read_text('utf-8')
    # the letters of the map, and the marks of port and ship
    named = (
        "[...document.querySelectorAll('#map text')].filter((e) => e.textContent === 'Portsmouth')"
    )
    for width in (380, 1600):
        browser.show(tmp_path / 'lies.html', width, dark=False)
        assert browser.run(f'{named}.length') == 1
        (left, bottom), (x, y), size = browser.run(
            f'(() => {{ const name = {named}[0].getBoundingClientRect(), mark = '
            "document.querySelector('#mark-green').getBoundingClientRect(); return [[name.left, "
            'name.bottom], [mark.x + mark.width / 2, mark.y + mark.height / 2], name.height]; })()'
        )
        # the name stands 4 points to the right of its place and 5 above, in letters of 8.5 points
        assert 0.0 < left - x < size
        assert abs(y - bottom) < size
        assert size >= 7.0
        assert browser.faults == []


def test_each_picture_has_words(page: Path, browser: Browser) -> None:
    browser.show(page, 800, dark=False)
    silent = browser.run(
        "[...document.querySelectorAll('svg')].filter((e) => "
        "!(e.closest('[role=img]')?.getAttribute('aria-label') ?? '').trim()).length"
    )
    assert silent == 0
    words = browser.run("document.querySelector('#error [role=img]').getAttribute('aria-label')")
    assert words.startswith('Error of the clock. reading − true time [s] against time [minutes].')
    assert 'dial: ' in words


def test_ten_tabs_lead_to_the_bottom(browser: Browser, page: Path) -> None:
    browser.show(page, 1600, dark=False)
    reached = []
    for _ in range(20):
        browser.press('Tab', TAB)
        reached.append(browser.run('document.activeElement.tagName'))
        if reached[-1] == 'BODY':
            break
    assert reached.count('SUMMARY') == 5
    assert reached[-2:] == ['SUMMARY', 'BODY']
    assert len(reached) - 1 <= 10


def test_it_prints_on_three_pages(browser: Browser, page: Path) -> None:
    browser.show(page, 1200, dark=True)
    printed = base64.b64decode(browser.ask('Page.printToPDF', preferCSSPageSize=True)['data'])
    assert len(re.findall(rb'/Type\s*/Page\b(?!s)', printed)) <= 3


def test_ship_and_dials_move_as_the_voyage_did(
    browser: Browser, voyage: tauto.Voyage, page: Path
) -> None:
    """At a time of the slider: the roll of the hull, and the angles of the hands."""
    browser.show(page, 800, dark=False)
    assert browser.run("document.getElementById('play').textContent") == 'Pause'
    browser.run("document.getElementById('play').click()")
    at = 90
    slider = "document.getElementById('time')"
    browser.run(f"{slider}.value = {at}; {slider}.dispatchEvent(new Event('input'))")

    def turned(name: str) -> float:
        found = browser.run(f"document.getElementById('{name}').getAttribute('transform')")
        return float(re.search(r'rotate\(([-\d.]+)', found)[1])

    assert turned('ship-hull') == pytest.approx(-math.degrees(voyage.roll_rad[at]), abs=0.02)
    true_s = voyage.start_ns * 1e-9 + at
    for name, seconds in (('true', true_s), ('dial', true_s + voyage.clock_error_s[at])):
        for hand, turn in (('second', 60.0), ('minute', 3600.0), ('hour', 43200.0)):
            away = turned(f'{name}-{hand}') - 360.0 * (seconds % turn) / turn
            assert math.remainder(away, 360.0) == pytest.approx(0.0, abs=0.02)
    assert browser.faults == []


def test_the_keyboard_moves_and_plays_it(browser: Browser, page: Path) -> None:
    """An arrow moves by a hundredth. End and Enter work, too."""
    browser.show(page, 1600, dark=False)
    wheel = "document.getElementById('wheel').getAttribute('transform')"
    now = "document.getElementById('now').textContent"
    browser.run("document.getElementById('play').click()")
    browser.run("document.getElementById('time').focus()")
    browser.press('Home', HOME)
    before = browser.run(wheel)
    browser.press('ArrowRight', RIGHT)
    assert browser.run(now) == '1.2 s'
    browser.press('ArrowRight', RIGHT)
    assert browser.run(now) == '2.4 s'
    assert browser.run(wheel) != before
    browser.press('End', END)
    assert browser.run(now) == '120.0 s'
    browser.run("document.getElementById('play').focus()")
    assert browser.run("document.getElementById('play').textContent") == 'Play'
    browser.press('Enter', ENTER, '\r')
    assert browser.run("document.getElementById('play').textContent") == 'Pause'
    assert browser.faults == []


@pytest.mark.parametrize('name', ['axle_at_sea', 'globe_in_oil', 'sully_lever_at_sea'])
def test_every_kind_of_clock_moves(browser: Browser, tmp_path: Path, name: str) -> None:
    """A body on an axle and one in a fluid have no thread, and the slider moves them all."""
    (tmp_path / 'moved.html').write_text(report(name), encoding='utf-8')
    browser.show(tmp_path / 'moved.html', 1000, dark=False)
    browser.run(
        "(() => { document.querySelector('#play').click(); const time = "
        "document.getElementById('time'); time.value = 30; time.dispatchEvent(new Event('input'))"
        '; return 0; })()'
    )
    assert browser.run("document.getElementById('now').textContent") == '30.0 s'
    turned = browser.run(
        "[...document.querySelectorAll('#machine-view g')].map((e) => e.getAttribute('transform'))"
    )
    assert any(turned)
    if name == 'sully_lever_at_sea':
        # the lever has left its level
        assert abs(float(turned[5].rpartition('rotate(')[2].split()[0])) > 0.1
        # the thread, on its cheek and then straight, keeps its 300 mm
        points = browser.run(
            "document.querySelector('#machine-view > polyline').getAttribute('points')"
        )
        on = [complex(*map(float, each.split(','))) for each in points.split()]
        assert sum(map(abs, np.diff(on))) == pytest.approx(300.0, abs=0.2)
    assert browser.faults == []
