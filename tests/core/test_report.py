"""The page of a report: whole in itself, and as a browser shows it."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import tauto_core as tauto
from tauto_core.animation import animation
from tauto_core.report import write_report

BROWSER = shutil.which('chromium') or shutil.which('chromium-browser')
LARGEST_BYTES = 5_000_000
PROBE = """
<script>
const faults = [];
addEventListener('error', (event) => faults.push(event.message));
console.error = (...words) => faults.push(words.join(' '));
addEventListener('load', () => setTimeout(() => {
  const wheel = document.getElementById('wheel'), slider = document.getElementById('time');
  const before = wheel.getAttribute('transform');
  slider.value = 0.5;
  slider.dispatchEvent(new Event('input'));
  const after = wheel.getAttribute('transform');
  slider.focus();
  const play = document.getElementById('play');
  play.click();
  const found = {faults, before, after, now: document.getElementById('now').textContent,
    focused: document.activeElement.id, playing: play.textContent,
    wide: document.documentElement.scrollWidth, window: innerWidth,
    drawn: document.querySelectorAll('.bk-Figure, [data-root-id]').length,
    ink: getComputedStyle(document.body).color,
    axis: [...Bokeh.documents[0]._all_models.values()].find((m) => m.type === 'LinearAxis')
      .axis_label_text_color};
  const said = document.createElement('pre');
  said.id = 'probe';
  said.textContent = JSON.stringify(found);
  document.body.appendChild(said);
}, 500));
</script>
"""


@pytest.fixture(scope='module')
def voyage() -> tauto.Voyage:
    return tauto.sail('second_cam_at_sea', duration=120.0)


@pytest.fixture(scope='module')
def page(voyage: tauto.Voyage, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp('report') / 'report.html'
    write_report(voyage, file, 'tauto report second_cam_at_sea')
    return file


class Links(HTMLParser):
    """What a page asks for."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, _tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found += [value or '' for name, value in attrs if name in ('src', 'href', 'data')]


def test_the_page_holds_all_it_needs(page: Path, voyage: tauto.Voyage) -> None:
    text = page.read_text(encoding='utf-8')
    links = Links()
    links.feed(text)
    assert links.found == []
    assert 'cdn.bokeh' not in re.sub(r'<script type="text/javascript">.*?</script>', '', text)
    assert page.stat().st_size < LARGEST_BYTES
    for words in (
        voyage.answer,
        'tauto report second_cam_at_sea',
        'lever_rate: 0.01',
        'llvmlite ',
    ):
        assert words in text, words


def test_the_animation_stands_where_the_wheel_stood(voyage: tauto.Voyage) -> None:
    """A cos φ against the logged angle; a force on the second cam swings in a sine, its roll too.

    What the roll adds to the swing is a forced oscillation of another frequency, so the two agree
    to the size of that, not to rounding.
    """
    found = animation(voyage)
    angle = np.array(found['amplitude_rad']) * np.cos(np.array(found['phase_rad']))
    assert np.abs(angle - voyage.angle_rad).max() < 1e-3 + 0.05
    assert np.corrcoef(angle, voyage.angle_rad)[0, 1] > 0.999
    assert found['length_s'] == 120.0
    json.dumps(found, allow_nan=False)


def test_a_body_in_a_fluid_has_no_wheel_to_move(tmp_path: Path) -> None:
    globe = tauto.sail('globe_in_oil', duration=60.0)
    assert 'no trochlea' in animation(globe)['why']
    write_report(globe, tmp_path / 'globe.html', 'tauto report globe_in_oil')
    assert 'No cam: ' in (tmp_path / 'globe.html').read_text(encoding='utf-8')


@pytest.mark.skipif(BROWSER is None, reason='no browser: sudo apt-get install chromium')
@pytest.mark.parametrize(('width', 'dark'), [(500, True), (1600, False)])
def test_a_browser_shows_it(page: Path, tmp_path: Path, width: int, dark: bool) -> None:
    probed = tmp_path / 'probed.html'
    text = page.read_text(encoding='utf-8')
    probed.write_text(text.replace('<head>', '<head>' + PROBE, 1), encoding='utf-8')
    assert BROWSER is not None
    run = subprocess.run(
        [
            *(BROWSER, '--headless=new', '--no-sandbox', '--disable-gpu', '--dump-dom'),
            f'--user-data-dir={tmp_path / "profile"}',
            f'--window-size={width},1200',
            f'--blink-settings=preferredColorScheme={0 if dark else 1}',
            *('--host-resolver-rules=MAP * ~NOTFOUND', '--virtual-time-budget=20000'),
            probed.as_uri(),
        ],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    said = re.search(r'<pre id="probe">(.*?)</pre>', run.stdout, re.DOTALL)
    assert said is not None, run.stderr[-2000:]
    found = json.loads(said[1].replace('&lt;', '<').replace('&gt;', '>').replace('&amp;', '&'))
    assert found['faults'] == []
    assert found['before'] != found['after']
    assert found['now'] == '0.5 s'
    assert (found['focused'], found['playing']) == ('time', 'Pause')
    assert found['drawn'] >= 10
    assert found['wide'] <= found['window']
    assert found['ink'] == ('rgb(237, 237, 237)' if dark else 'rgb(27, 27, 27)')
    assert found['axis'] == ('#ededed' if dark else '#1b1b1b')
