"""`tauto euler --page`: a table of the claims of each paper, with its figures."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner

from tauto_core.cli.app import app
from tauto_core.euler.edition import Claim
from tauto_core.euler.page import EDITIONS, PageError, all_claims, claims_page, write_page
from tauto_core.euler.site import write_site

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


def test_every_figure_is_there_and_is_svg(written: Path) -> None:
    files = list(_figures(written))
    assert len(files) == sum(len(edition.figures) for edition in EDITIONS)
    assert sorted(files) == sorted((written / 'figures').iterdir())
    for file in files:
        assert ElementTree.parse(file).getroot().tag == '{http://www.w3.org/2000/svg}svg'
    assert sum(file.stat().st_size for file in files) < 300_000


def test_every_claim_has_a_row_in_the_section_of_its_paper() -> None:
    claims = all_claims()
    sections = claims_page(claims).split('\n## ')[1:]
    rows = [re.findall(r'^\| (?!§|--).*$', section, re.MULTILINE) for section in sections]
    assert [section[:2] for section in sections] == ['A.', 'B.', 'C.']
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


@pytest.mark.parametrize('write', [write_page, write_site])
def test_a_folder_that_cannot_be_made_is_named(
    write: Callable[[Path, list[Claim]], None], tmp_path: Path
) -> None:
    taken = tmp_path / 'taken'
    taken.write_text('')
    with pytest.raises(PageError, match=r'taken.*cannot be written.*Name another folder'):
        write(taken, [])
