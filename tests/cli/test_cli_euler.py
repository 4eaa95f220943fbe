"""`tauto euler`: the claims as text and JSON, the exit code, and a page for each paper."""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from browser import BROWSER, Browser
from command_line import invoke, refused, run

from tauto_core.euler import fluid_1729
from tauto_core.euler.edition import Claim
from tauto_core.euler.site import EDITIONS, all_claims, off_by, write_site
from tauto_core.files import OutputError

TRANSLATIONS = 'http://www.17centurymaths.com/contents/eulercontents.html'
CLAIM = Claim('A', 'I', 'a | b', 'x * y', 1.0, 1.0 + 3e-13, 1e-12)


def test_json_holds_every_claim_in_order() -> None:
    printed = json.loads(run('euler', '--json'))['claims']
    claims = all_claims()
    assert [each['claim'] for each in printed] == [claim.said for claim in claims]
    assert [each['paper'] for each in printed] == sorted(each['paper'] for each in printed)
    for each, claim in zip(printed, claims, strict=True):
        assert (each['verdict'], each['computed']) == (claim.expected, claim.computed)
        assert (each['value'] is None) == math.isnan(claim.value)
        assert (each['stands'] is None) <= (each['adds'] is not None)


def test_the_words_keep_corrections_and_reasons(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('COLUMNS', '70')
    result = run('euler')
    assert max(map(len, result.splitlines())) <= 70
    text = ' '.join(result.split())
    count = Counter(claim.verdict for claim in all_claims())
    assert f'claims: {count["holds"]} hold as they stand, {count["corrected"]} once cor' in text
    for claim in all_claims():
        for words in (claim.said, claim.reason, claim.must):
            assert ' '.join(words.split()) in text
    assert 'B §23, 31' in text


def test_a_claim_with_another_verdict_is_exit_code_1(monkeypatch: pytest.MonkeyPatch) -> None:
    good = fluid_1729.claims()
    spoilt = [replace(good[0], computed=good[0].computed * 1.01), *good[1:]]
    monkeypatch.setattr(fluid_1729, 'claims', lambda: spoilt)
    result = invoke('euler', '--json')
    assert result.exit_code == 1
    assert len(json.loads(result.stdout)['claims']) == len(all_claims())
    assert 'tauto: B §2-5' in result.stderr
    assert 'should be holds' in result.stderr


@pytest.mark.parametrize(
    ('claim', 'difference'),
    [
        # two machines that round otherwise give the same text
        (CLAIM, '< 1e-12'),
        (replace(CLAIM, computed=1.0 + 7e-14), '< 1e-12'),
        (replace(CLAIM, value=1.0051, tolerance=1e-2), '5.1e-03'),
        (replace(CLAIM, value=1.0, computed=1.0, tolerance=0.0), '0'),
    ],
)
def test_differences_hide_rounding(claim: Claim, difference: str) -> None:
    assert off_by(claim) == difference


def test_what_cannot_be_written_is_refused(tmp_path: Path) -> None:
    taken = tmp_path / 'taken'
    taken.write_text('')
    with pytest.raises(OutputError, match=r'taken: File exists. Name another folder'):
        write_site(taken, [])
    assert 'Use --site' in refused('euler', '--page', str(tmp_path))


@pytest.fixture(scope='module')
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp('site') / 'made' / 'papers'
    result = invoke('euler', '--site', str(folder))
    assert (result.exit_code, result.stdout) == (0, ''), result.stderr
    assert f'wrote {folder}\n' in result.stderr
    return folder


def test_pages_need_nothing_but_themselves_and_hold_every_claim(site: Path) -> None:
    claims = all_claims()
    assert sorted(each.stem for each in site.iterdir()) == sorted(each.file for each in EDITIONS)
    for edition in EDITIONS:
        text = (site / f'{edition.file}.html').read_text(encoding='utf-8')
        assert len(text) < 1_000_000
        assert not re.search(r'\b(?:src|srcset)=|url\(|@import', text)
        links = set(re.findall(r'href="([^"#]*)', text)) - {'', TRANSLATIONS}
        assert links <= {f'{each.file}.html' for each in EDITIONS}
        assert set(re.findall(r'https?://[^\s"<]+', text)) <= {TRANSLATIONS}
        # paper C has no translation that we know
        assert (TRANSLATIONS in text) == (edition.file != 'axle')
        assert text.count('<p lang="la">') == len(edition.paragraphs)
        assert not re.search('[‹›]', text)
        assert text.count('<del>') == text.count('<ins>') > 40
        # the letters in the words under a figure are formulas, at every value of its controls
        said = re.findall(r'<p class="says"[^>]*>(.*?)</p>', text)
        assert any('<math>' in each for each in said)
        assert not [each for each in said if '*' in each]
        assert '"says":["<math>' in text
        # every claim stands there with its verdict, and the table counts them
        count = Counter(claim.verdict for claim in claims if claim.paper == edition.paper)
        assert Counter(re.findall(r'<div class="claim (\w+)">', text)) == count
        assert f'<dt>holds ({count["holds"]})</dt><dd><a href="#' in text


@pytest.mark.skipif(BROWSER is None, reason='needs Chromium')
def test_pages_are_read_at_any_width_and_moved_by_the_keyboard(site: Path, tmp_path: Path) -> None:
    with Browser(tmp_path / 'profile') as browser:
        for edition in EDITIONS:
            page = site / f'{edition.file}.html'
            for width, dark in ((380, True), (1600, False)):
                browser.show(page, width, dark=dark)
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
                    assert browser.run(look) != before, (figure.name, control.name)
                    shown = f'{place}.querySelectorAll("output")[{k}].textContent'
                    at = control.begin + (-1 if back else 1)
                    assert browser.run(shown) == control.label(at)
            assert browser.faults == []
