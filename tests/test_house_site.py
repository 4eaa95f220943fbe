"""The documentation site: it builds without a warning, and no link is broken."""

from __future__ import annotations

import functools
import json
import os
import re
import runpy
import shutil
import sys
import threading
import time
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from browser import BROWSER, Browser
from lint_prose import MADE as PAGES
from modules import module_of, run_program

import tauto_core as tauto
from tauto_core.euler.site import EDITIONS, all_claims, write_site
from tauto_core.scene.reference import scenes_page

ROOT = Path(__file__).parents[1]
MADE = ['demo.html', 'papers', *PAGES]
"""What `make docs` adds to the pages that are in the repository."""


class Page(HTMLParser):
    """The links of a page, what it loads, its anchors and its text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.anchors: set[str] = set()
        self.text = ''
        self.feed(text)

    def handle_data(self, data: str) -> None:
        self.text += data

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or '' for name, value in attrs}
        self.anchors |= {given[name] for name in ('id', 'name') if name in given}
        if tag == 'a' and 'href' in given:
            self.links.append(given['href'])
        elif tag in ('img', 'script') and 'src' in given:
            self.loads.append(given['src'])
        elif tag == 'link' and given.get('rel') in ('stylesheet', 'icon', 'preload'):
            self.loads.append(given['href'])


class Quiet(SimpleHTTPRequestHandler):
    """A server of files that prints no log."""

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002
        pass


@pytest.fixture(scope='module')
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp('site')
    shutil.copytree(ROOT / 'docs', folder / 'docs', ignore=lambda *_: MADE)
    write_site(folder / 'docs' / 'papers', all_claims())
    pages = {
        'cli': module_of(ROOT / 'docs' / 'command_line.py').command_line(),
        'parameters': module_of(ROOT / 'docs' / 'parameters.py').reference_page(),
        'scenes': scenes_page(),
        'topics': module_of(ROOT / 'docs' / 'topics.py').topic_reference(),
    }
    for name, text in pages.items():
        (folder / 'docs' / f'{name}.md').write_text(text, encoding='utf-8')
    tauto.report('measured', folder / 'docs' / 'demo.html')
    # without what the cells show: test_house_lessons runs them
    lessons = (folder / 'docs' / 'lessons').glob('*.ipynb')
    convert = (sys.executable, '-m', 'nbconvert', '--log-level', 'ERROR', '--to', 'markdown')
    run = run_program(*convert, *lessons)
    assert run.returncode == 0, run.stderr
    shutil.copy(ROOT / 'zensical.toml', folder)
    (folder / 'src').symlink_to(ROOT / 'src')
    zensical = Path(sys.executable).with_name('zensical')
    run = run_program(zensical, 'build', '--strict', cwd=folder)
    assert run.returncode == 0, run.stdout + run.stderr
    assert 'arning' not in run.stdout + run.stderr
    return folder / 'site'


@pytest.fixture(scope='module')
def site(built: Path) -> dict[Path, Page]:
    return {
        file.relative_to(built): Page(file.read_text(encoding='utf-8'))
        for file in built.rglob('*.html')
    }


def test_every_page_of_the_docs_is_a_page_of_the_site(site: dict[Path, Page]) -> None:
    written = {
        each.relative_to(ROOT / 'docs').with_suffix('.html')
        for each in [*(ROOT / 'docs').rglob('*.md'), *(ROOT / 'docs' / name for name in PAGES)]
    }
    assert written <= set(site)
    reached = {
        (file.parent / unquote(urlsplit(link).path)).as_posix()
        for file, page in site.items()
        for link in page.links
    }
    navigated = {Path(*Path(each).parts).name for each in reached}
    assert {each.name for each in written} <= navigated


def test_links_and_anchors_lead_somewhere(site: dict[Path, Page]) -> None:
    names = {file.as_posix() for file in site}
    for file, page in site.items():
        for link in page.links:
            target = urlsplit(link)
            if target.scheme or file.name == '404.html':
                continue
            there = file if not target.path else _resolved(file.parent, unquote(target.path))
            if there.suffix == '.html':
                assert there.as_posix() in names, (str(file), link)
            if target.fragment and there in site:
                assert unquote(target.fragment) in site[there].anchors, (str(file), link)


def test_the_site_asks_nothing_of_any_network(site: dict[Path, Page]) -> None:
    for file, page in site.items():
        assert not [each for each in page.loads if urlsplit(each).netloc], str(file)


def test_the_papers_are_pages_of_the_site(site: dict[Path, Page]) -> None:
    navigated = {link.removeprefix('./') for link in site[Path('index.html')].links}
    for edition in EDITIONS:
        assert f'papers/{edition.file}.html' in navigated
        anchors = site[Path('papers') / f'{edition.file}.html'].anchors
        assert {each.number for each in edition.paragraphs} <= anchors


def test_the_page_of_examples_shows_each_script(site: dict[Path, Page]) -> None:
    shown = ' '.join(site[Path('howto/python.html')].text.split())
    scripts = sorted((ROOT / 'docs' / 'examples').glob('*.py'))
    assert scripts
    for script in scripts:
        for line in script.read_text(encoding='utf-8').splitlines():
            assert ' '.join(line.split()) in shown, script.name


def test_the_reference_of_python_has_every_public_name(site: dict[Path, Page]) -> None:
    anchors = {each.rpartition('.')[2] for each in site[Path('api.html')].anchors}
    assert {name for name in tauto.__all__ if name != '__version__'} <= anchors


def test_a_browser_typesets_every_equation_of_the_theory(
    site: dict[Path, Page], built: Path, tmp_path: Path
) -> None:
    """Roots, dots and powers are those of the source, by what MathML holds."""
    if BROWSER is None:
        pytest.skip('no browser: sudo apt-get install chromium')
    pages = [file for file in site if file.parts[0] == 'theory']
    written = {
        number
        for page in (ROOT / 'docs' / 'theory').glob('*.md')
        for number in re.findall(
            r'^ {4}(\([a-z_]+\.\d+\)) ', page.read_text('utf-8'), re.MULTILINE
        )
    }
    typeset: dict[str, str] = {}
    inline: dict[str, str] = {}
    left = 0
    with Browser(tmp_path) as browser:
        for file in pages:
            browser.ask('Page.navigate', url=(built / file).as_uri())
            while browser.run('document.readyState') != 'complete':
                pass
            typeset |= browser.run(
                "Object.fromEntries([...document.querySelectorAll('.equation')].map((each) => "
                "[each.querySelector('.number').textContent, each.innerHTML]))"
            )
            inline |= browser.run(
                "Object.fromEntries([...document.querySelectorAll('.md-typeset math')]"
                ".map((each) => [each.getAttribute('alttext'), each.textContent]))"
            )
            left += browser.run("document.querySelectorAll('.language-text pre > code').length")
            words = browser.run(
                "[...document.querySelectorAll('.md-typeset em')].map((each) => each.textContent)"
            )
            assert not [each for each in words if not re.search('[A-Za-z]{3}', each)], file
        # a stop is not alone on a line: it is kept with its formula
        lone = (
            '[...document.querySelectorAll(".formula")].map(each => each.nextSibling?.data ?? "")'
        )
        assert not [each for each in browser.run(lone) if each[:1] in ('.', ',', ';', ':')]
    assert left == 0
    assert not [each for each in inline.values() if re.search('[_^]', each)]
    assert set(typeset) - {''} == written
    period = typeset['(wheel.2)']
    assert period.count('<mover') == 2
    assert '<msup><mrow><mi>ϑ</mi></mrow><mrow><mn>2</mn></mrow></msup>' in period
    assert typeset['(cams.4)'].count('<msqrt>') == 2
    # a formula in a sentence may break before a sign outside brackets
    assert {'ψ', '= θ', '+ α_c', 'ω', '= √(F t′(0)/I)'} <= set(inline)
    assert not [each for each in inline if '\\' in each]
    assert not [each for each in inline.values() if re.search('[⁰-ⁿ₀-₎ᵀᵢ²³]', each)]


def test_versions_stand_beside_each_other_with_a_switch(
    built: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The newest release is the default; one in work is listed, and is no default."""
    add = runpy.run_path(str(ROOT / 'docs' / 'versions.py'))['add']
    monkeypatch.chdir(tmp_path)
    small = tmp_path / 'small'
    small.mkdir()
    (small / 'index.html').write_text('old', encoding='utf-8')
    pages = tmp_path / 'pages'
    for name in ('0.9.0', '0.10.0', '0.11.0.dev0'):
        add(small, pages, name)
    add(built, pages, '0.9.0')  # built anew: it is replaced
    listed = json.loads((pages / 'versions.json').read_text(encoding='utf-8'))
    assert [each['version'] for each in listed] == ['0.10.0', '0.9.0', '0.11.0.dev0']
    assert [each['aliases'] for each in listed] == [['latest'], [], []]
    assert 'url=0.10.0/index.html' in (pages / 'index.html').read_text(encoding='utf-8')
    with pytest.raises(SystemExit, match=r'has no index\.html'):
        add(tmp_path / 'none', pages, '1.0.0')
    if BROWSER is None:
        pytest.skip('no browser: sudo apt-get install chromium')
    handler = functools.partial(Quiet, directory=str(pages))
    with ThreadingHTTPServer(('127.0.0.1', 0), handler) as server, Browser(tmp_path) as browser:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        there = f'http://127.0.0.1:{server.server_port}/0.9.0/theory/wheel.html'
        browser.ask('Page.navigate', url=there)
        shown = "[...document.querySelectorAll('.md-version__link')].map((each) => each.href)"
        links: list[str] = []
        limit = time.monotonic() + 300.0
        while not links and time.monotonic() < limit:
            links = browser.run(shown)
        server.shutdown()
    assert [urlsplit(link).path for link in links] == [
        f'/{name}/' for name in ('0.10.0', '0.9.0', '0.11.0.dev0')
    ]


def _resolved(folder: Path, path: str) -> Path:
    found = Path(os.path.normpath(folder / path))
    return found / 'index.html' if path.endswith('/') or found == Path() else found
