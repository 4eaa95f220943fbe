"""`tauto euler --page`: the page in docs/ equals the output of the command, figures included."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner

from tauto_core.cli.app import app
from tauto_core.euler.edition import Claim
from tauto_core.euler.page import EDITIONS, PageError, all_claims, claims_page, write_page

DOCS = Path(__file__).resolve().parents[2] / 'docs'
CLAIM = Claim('A', 'I', 'a | b', 'x * y', 1.0, 1.0 + 3e-13, 1e-12)


@pytest.fixture(scope='module')
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp('page') / 'made' / 'docs'
    result = CliRunner().invoke(app, ['euler', '--page', str(folder)])
    assert result.exit_code == 0, result.stderr
    assert result.stdout == ''
    assert f'wrote {folder}' in result.stderr
    return folder


def _figures(folder: Path) -> Iterator[Path]:
    text = (folder / 'euler.md').read_text(encoding='utf-8')
    for name in re.findall(r'!\[.*?\]\((.*?)\)', text):
        yield folder / name


def test_the_page_in_docs_is_the_one_that_the_command_writes(written: Path) -> None:
    made = (written / 'euler.md').read_text(encoding='utf-8')
    assert made == (DOCS / 'euler.md').read_text(encoding='utf-8'), 'run `tauto euler --page docs`'


def test_every_figure_is_there_and_is_svg(written: Path) -> None:
    for folder in (written, DOCS):
        files = list(_figures(folder))
        assert len(files) == sum(len(edition.figures) for edition in EDITIONS)
        assert sorted(files) == sorted((folder / 'figures').iterdir())
        for file in files:
            assert ElementTree.parse(file).getroot().tag == '{http://www.w3.org/2000/svg}svg'
        assert sum(file.stat().st_size for file in files) < 300_000


def test_every_claim_has_a_row_in_the_section_of_its_paper() -> None:
    claims = all_claims()
    *sections, runs = claims_page(claims).split('\n## ')[1:]
    rows = [re.findall(r'^\| (?!§|--).*$', section, re.MULTILINE) for section in sections]
    assert [section[:2] for section in sections] == ['A.', 'B.', 'C.']
    assert runs.startswith('Commands for each paragraph')
    assert [len(each) for each in rows] == [sum(c.paper == p for c in claims) for p in 'ABC']
    for claim, row in zip(claims, [row for each in rows for row in each], strict=True):
        assert row.startswith(f'| {claim.paragraph} |')
        assert claim.verdict in row
        assert len(re.findall(r'(?<!\\)\|', row)) == 10


@pytest.mark.parametrize(
    ('claim', 'off_by'),
    [
        # two machines that round otherwise give the same text
        (CLAIM, '< 1e-12'),
        (replace(CLAIM, computed=1.0 + 7e-14), '< 1e-12'),
        (replace(CLAIM, value=1.0051, tolerance=1e-2), '5.1e-03'),
        (replace(CLAIM, value=1.0, computed=1.0, tolerance=0.0), '0'),
        (replace(CLAIM, value=float('nan')), '—'),
    ],
)
def test_differences_hide_rounding(claim: Claim, off_by: str) -> None:
    row = claims_page([claim]).split('|---|\n')[1].splitlines()[0]
    assert row.split(' | ')[6] == off_by
    assert row.startswith(r'| I | a \| b | *x \* y*')


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    taken = tmp_path / 'taken'
    taken.write_text('')
    with pytest.raises(PageError, match=r'taken.*cannot be written.*Name another folder'):
        write_page(taken, [CLAIM])


def test_every_paragraph_is_in_a_row_that_names_what_runs_it() -> None:
    runs = claims_page([]).split('\n## Commands')[1]
    for edition, section in zip(EDITIONS, runs.split('\n### ')[1:], strict=True):
        numbers = [each.number for each in edition.paragraphs]
        row = r'^\| (\w+)(?:–(\w+))? \| (.*) \| .* \| (.*) \|$'
        rows = re.findall(row, section, re.MULTILINE)
        assert rows[0][0] == numbers[0]
        for (first, last, commands, lacks), following in pairwise([*rows, ('', '', '', '')]):
            place = numbers.index(last or first)
            assert numbers[place + 1 : place + 2] == ([following[0]] if following[0] else [])
            assert commands.startswith('`tauto ') or lacks


def test_a_row_counts_the_claims_on_its_paragraphs() -> None:
    """XXII to XXIX have two kinds of claim; those on several paragraphs count in each row."""
    runs = claims_page(all_claims()).split('\n## Commands')[1]
    counts = re.findall(r'^\| (\w+)(?:–\w+)? \| .* \| (.*) \| .* \|$', runs, re.MULTILINE)
    found = dict(counts)
    own = [claim for claim in all_claims() if claim.paper == 'A']
    assert found['XX'] == _counted([claim for claim in own if claim.paragraph == 'XX'])
    within = [claim for claim in own if re.match(r'XXII-', claim.paragraph)]
    assert within
    for number in ('XXII', 'XXV'):
        assert found[number] != '–'


def _counted(claims: list[Claim]) -> str:
    counts = Counter(claim.verdict for claim in claims)
    assert counts == {'holds': 2, 'added': 1}
    return '2 hold, 1 added'
