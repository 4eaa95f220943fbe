"""Checks of the pages' text that run no program: `make lint` runs them, the tests do not."""

from __future__ import annotations

import ast
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DOCS = ROOT / 'docs'
MADE = {f'{name}.md' for name in ('cli', 'parameters', 'scenes', 'topics')}
"""Pages of docs that `make docs` makes; of notebooks it makes those of lessons."""
PAGES = [
    ROOT / 'README.md',
    *(
        each
        for each in sorted(DOCS.rglob('*.md'))
        if each.name not in MADE and each.parent.name != 'lessons'
    ),
]
PROSE = [*PAGES, *(ROOT / f'{name}.md' for name in ('CONTRIBUTING', 'CHANGELOG', 'SECURITY'))]
WIDTH = 120
LARGEST_PICTURE = 400_000
WORDS = {
    # figure: (most today, goal)
    'README.md': (600, 600),
    'CONTRIBUTING.md': (600, 600),
    'docs': (42_850, 45_000),
}
"""Words of the pages that are kept. A limit is lowered when a figure has fallen."""

HABITS = {
    # words that a translated sentence repeats: (most in 1,000 of src, of the pages)
    r'\b(that|those) of\b': (0.3, 0.3),
    r'\bwhere\b': (0.5, 1.0),
    r', so that\b': (0.2, 0.2),
    r'\bwhat (an?|the|it|he|they|its|is|was|are|were|has|had|can|does|did|no)\b': (0.1, 0.5),
    r'\b(nothing|none|nobody)\b': (0.6, 0.6),
    r';': (3.0, 3.0),
    r'\b(she|her)\b': (0.1, 0.1),
}
"""The rates of skyfield, httpx and diffrax are the goals; equations say *where*, dates *none*."""


def text_of(page: Path) -> str:
    return page.read_text(encoding='utf-8')


def test_prose_wraps_at_one_width() -> None:
    """Tables, code, HTML, headings, pictures and a line of one link may be wider."""
    wide = []
    for page in PROSE:
        text = re.sub(r'^ *(```+).*?^ *\1', '', text_of(page), flags=re.M | re.S)
        for line in text.splitlines():
            if not line.startswith(('|', '    ', '  <', '<', '#', '![')):
                words = re.sub(r'`[^`]*`|\[[^\]]*\]\([^)]*\)', 'whole', line).split()
                wide += [(page.name, line)] if len(line) > WIDTH and len(words) >= 3 else []
    assert not wide


def test_pictures_are_light() -> None:
    """Who reads a page should not wait for it, and a repository keeps every picture for ever."""
    sizes = {each: each.stat().st_size for each in (DOCS / 'img').rglob('*.*')}
    assert len(sizes) > 10
    assert not {each for each, size in sizes.items() if size > LARGEST_PICTURE}


def test_links_lead_somewhere() -> None:
    for page in PAGES:
        for target in re.findall(r'\]\(([^)#]+)', text_of(page)):
            place = (page.parent / target).resolve()
            made = place.parent == DOCS and place.name in MADE
            assert made or target.startswith('https://') or place.exists(), (page, target)


def test_links_lead_from_the_first_page_to_every_other() -> None:
    """Through any number of pages; the navigation of the site has each of them."""
    navigation = text_of(ROOT / 'zensical.toml')
    reached = {DOCS / 'index.md'}
    new = set(reached)
    while new:
        new = {
            (page.parent / target).resolve()
            for page in new
            for target in re.findall(r'\]\(([^)#]+\.md)', text_of(page))
        }
        new = {page for page in new if page in PAGES} - reached
        reached |= new
    assert set(PAGES[1:]) <= reached
    for page in [*PAGES[1:], *(DOCS / name for name in MADE)]:
        assert f'"{page.relative_to(DOCS)}"' in navigation


def test_equations_are_numbered_by_page_and_cited_where_they_are() -> None:
    theory = DOCS / 'theory'
    numbers: set[str] = set()
    for page in re.findall(r'\]\((\w+\.md)\)', text_of(theory / 'index.md')):
        lines = [line for line in text_of(theory / page).splitlines() if re.match(r' {4}\S', line)]
        for number, line in enumerate(lines, start=1):
            assert line.startswith(f'    ({page[:-3]}.{number}) '), (page, line)
            numbers.add(f'{page[:-3]}.{number}')
    assert len(numbers) > 50
    stems = '|'.join(sorted({number.partition('.')[0] for number in numbers}))
    sources = [*(ROOT / 'src').rglob('*.py'), *(ROOT / 'tests').rglob('*.py'), *PAGES]
    cited = {
        (each.name, number)
        for each in sources
        for number in re.findall(rf'\(((?:{stems})\.\d+)[) ]', text_of(each))
    }
    assert len(cited) > 50
    assert not {each for each in cited if each[1] not in numbers}


def test_formulas_in_sentences_are_marked_for_the_site() -> None:
    """Between two asterisks, by which docs/site.js knows them; Greek letters give them away."""
    marked = r'`[^`]*`|\*\*.*?\*\*|\*(?:\\\*|[^*])+\*'
    for page in sorted((DOCS / 'theory').glob('*.md')):
        prose = re.sub(r'^(?:    |#).*$', '', text_of(page), flags=re.MULTILINE)
        bare = re.findall(r'.*[α-ωϑΓ-Ω].*', re.sub(marked, '', prose, flags=re.DOTALL))
        assert not bare, (page, bare)


def test_every_make_target_of_the_pages_exists() -> None:
    makefile = text_of(ROOT / 'Makefile')
    for page in PAGES:
        for target in re.findall(r'(?:^    |`)make ([a-z]+)\b', text_of(page), re.MULTILINE):
            assert re.search(f'^{target}:', makefile, re.MULTILINE), (page.name, target)


@pytest.mark.parametrize('figure', WORDS)
def test_no_more_words_than_a_reader_has_patience_for(figure: str) -> None:
    pages = PAGES[1:] if figure == 'docs' else [ROOT / figure]
    counted = sum(len(text_of(page).split()) for page in pages)
    most, goal = WORDS[figure]
    assert counted <= most, (
        f'{counted} words in {figure}: at most {most} today, {goal} is the goal'
    )


def prose_of_source(path: Path) -> Iterator[str]:
    """Yield docstrings, comments and messages; an X stands for a value in a message."""
    parts: set[int] = set()
    for node in ast.walk(ast.parse(text_of(path))):  # a message comes before its parts
        if isinstance(node, ast.JoinedStr):
            parts |= {id(part) for part in ast.walk(node)}
            yield ''.join(
                str(part.value) if isinstance(part, ast.Constant) else 'X' for part in node.values
            )
        elif isinstance(node, ast.Constant) and id(node) not in parts:
            yield node.value if isinstance(node.value, str) else ''
    with path.open('rb') as file:
        for token in tokenize.tokenize(file.readline):
            if token.type == tokenize.COMMENT:
                yield token.string


@pytest.fixture(scope='module')
def prose() -> tuple[str, str]:
    """The prose of src and of the pages."""
    sources = sorted((ROOT / 'src').rglob('*.py'))
    texts = [text for path in sources for text in prose_of_source(path) if len(text.split()) > 3]
    pages = [re.sub(r'^    .*|^\|.*', '', text_of(page), flags=re.M) for page in PAGES]
    source, page = (re.sub(r'`[^`]*`|<[^>]*>', 'X', ' '.join(one)) for one in (texts, pages))
    return source, page


@pytest.mark.parametrize('habit', HABITS)
def test_sentences_say_who_does_what(prose: tuple[str, str], habit: str) -> None:
    for text, most in zip(prose, HABITS[habit], strict=True):
        rate = 1000.0 * len(re.findall(habit, text, re.IGNORECASE)) / len(text.split())
        assert rate <= most, f'{habit}: {rate:.2f} in 1,000 words'


def test_the_name_of_a_test_has_at_most_60_characters() -> None:
    names = {
        name
        for file in (ROOT / 'tests').rglob('*.py')
        for name in re.findall(r'def (test_\w+)', text_of(file))
    }
    assert len(names) > 1000
    assert not {name for name in names if len(name) > 60}
