"""`tauto euler --site`: self-contained pages, at any width, by hand and by keyboard."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from browser import BROWSER, Browser
from typer.testing import CliRunner

from tauto_core.cli.app import app
from tauto_core.euler.page import EDITIONS

TRANSLATIONS = 'http://www.17centurymaths.com/contents/eulercontents.html'
SVG = 'http://www.w3.org/2000/svg'


@pytest.fixture(scope='module')
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp('site') / 'made' / 'papers'
    result = CliRunner().invoke(app, ['euler', '--site', str(folder)])
    assert result.exit_code == 0, result.stderr
    assert result.stdout == ''
    assert f'wrote {folder}\n' in result.stderr
    return folder


def test_pages_need_nothing_but_themselves(written: Path) -> None:
    files = sorted(written.iterdir())
    assert [file.stem for file in files] == sorted(edition.file for edition in EDITIONS)
    for file in files:
        text = file.read_text(encoding='utf-8')
        assert len(text) < 1_000_000
        assert not re.search(r'\b(?:src|srcset)=|url\(|@import', text)
        links = set(re.findall(r'href="([^"#]*)', text)) - {'', TRANSLATIONS}
        assert links <= {f'{edition.file}.html' for edition in EDITIONS}
        assert set(re.findall(r'https?://[^\s"<]+', text)) <= {TRANSLATIONS, SVG}
        # paper C has no translation that we know
        assert (TRANSLATIONS in text) == (file.stem != 'axle')
        (edition,) = (each for each in EDITIONS if each.file == file.stem)
        assert text.count('<p lang="la">') == len(edition.paragraphs)
        assert not re.search('[‹›]', text)
        assert text.count('<del>') == text.count('<ins>') > 40
        # the letters in the words under a figure are formulas, at every value of its controls
        said = re.findall(r'<p class="says"[^>]*>(.*?)</p>', text)
        assert any('<math>' in each for each in said)
        assert not [each for each in said if '*' in each]
        assert '"says":["<math>' in text


def test_pages_are_the_same_each_time(written: Path, tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ['euler', '--site', str(tmp_path)])
    assert result.exit_code == 0, result.stderr
    for file in written.iterdir():
        assert (tmp_path / file.name).read_bytes() == file.read_bytes()


@pytest.mark.skipif(BROWSER is None, reason='needs Chromium')
def test_pages_are_read_at_any_width_and_moved_by_the_keyboard(
    written: Path, tmp_path: Path
) -> None:
    with Browser(tmp_path / 'profile') as browser:
        for edition in EDITIONS:
            page = written / f'{edition.file}.html'
            for width, dark in ((380, True), (1600, False)):
                browser.show(page, width, dark=dark, drawn='true')
                assert browser.run('document.documentElement.scrollWidth') <= width
                # the formulas are set: a fraction is higher than its line
                bars = 'Math.min(...[...document.querySelectorAll("math > mfrac")].map('
                assert browser.run(f'{bars}each => each.getBoundingClientRect().height))') > 20
                ink, paper = (
                    browser.run(f'getComputedStyle(document.body).{name}')
                    for name in ('color', 'backgroundColor')
                )
                bright = [sum(map(int, re.findall(r'\d+', each)[:3])) for each in (ink, paper)]
                assert (bright[0] > bright[1]) == dark
            for figure in edition.figures:
                name = re.sub(r'[^A-Za-z0-9]', '-', f'figure-{figure.name}')
                place = f'document.getElementById("{name}")'
                look = f'{place}.querySelector("svg").innerHTML + {place}.innerText'
                for k, control in enumerate(figure.controls):
                    before = browser.run(look)
                    browser.run(f'document.getElementById("{name}-{k}").focus()')
                    back = control.begin == len(control.values) - 1
                    browser.press('ArrowLeft' if back else 'ArrowRight', 37 if back else 39)
                    after = browser.run(look)
                    assert after != before, (figure.name, control.name)
                    at = control.begin + (-1 if back else 1)
                    shown = f'{place}.querySelectorAll("output")[{k}].textContent'
                    assert browser.run(shown) == control.label(at)
            assert browser.faults == []
