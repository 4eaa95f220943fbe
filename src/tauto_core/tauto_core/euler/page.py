"""All claims, their summary, and the page: tables of the claims, with Euler's figures.

Numbers are rounded to seven digits, for the same text on every machine.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from textwrap import wrap

from tauto_core.euler import (
    axle_1780,
    axle_edition,
    fluid_1729,
    fluid_edition,
    trochlea_1727,
    trochlea_edition,
)
from tauto_core.euler.edition import Claim, Edition, EulerFigure, svg
from tauto_core.files import write_whole
from tauto_core.scene.errors import TautoError

# -----------------------------------------------------------------------------
# The claims and the page of all three papers.


def all_claims() -> list[Claim]:
    """Return the claims of all papers, in the order of paper and paragraph."""
    return [*trochlea_1727.claims(), *fluid_1729.claims(), *axle_1780.claims()]


def summary(claims: Sequence[Claim]) -> str:
    """Return the number of claims by verdict, and the limits of such a count."""
    count = Counter(claim.verdict for claim in claims)
    return (
        f'{len(claims)} claims: {count["holds"]} hold as they stand, {count["corrected"]} once '
        f'corrected, {count["fails"]} do not hold, {count["answered"]} is a question answered no; '
        f'{count["added"]} are additions of Tauto and hold. The text is a transcription by '
        'machine: which of its faults are in the print, only scans can tell, and none were '
        'compared'
    )


EDITIONS: tuple[Edition, ...] = (
    trochlea_edition.EDITION,
    fluid_edition.EDITION,
    axle_edition.EDITION,
)
"""The papers paragraph by paragraph."""
SHOWN_ABOVE = 1e-9
"""Smallest difference printed in digits. A smaller one is printed as a bound."""

_HEAD = """# Euler's papers, claim by claim

Written by `tauto euler --page docs`. Do not edit it. Our text of each paper is a transcription by
machine. *As it stands* is the formula or number of that text, letter by letter, with its value for
an example after the arrow, or empty if the claim is in words. *As it must be* is the formula that
agrees with the computed value. *Tauto adds* a formula to a claim in words, or a testable figure,
with its value. The column *computed* has the same quantity, independent of these formulas: by
quadrature, by integrating the motion, or by another closed form. *Off by* is the difference of
value and computed value, relative to the latter, or absolute if that is 0.

A claim *holds* if the two agree. It is *corrected* if only the formula as it must be agrees, or if
a letter or a word is wrong that has no value. It *fails* if the claim itself is wrong. A question
of the paper is *answered*. A claim that is not in the paper is *added*. The column *whose fault*
judges the corrections. The transcription is certain if the text has the formula right elsewhere,
or if only a machine reads so. The print, and perhaps Euler, is likely if a fault is repeated while
its neighbours are intact. All others are open until scans are compared.

The rows are the results of the papers and the faults of our text, without many intermediate steps
that hold. `tauto euler --site DIR` writes each paper as an interactive page, with each paragraph
in two sentences and in Latin, and the commands that show its point. Examples are in SI units
unless a claim says otherwise. Euler writes *xx* for *x²*, and in paper B *l* for the natural
logarithm and *c* for its base. The lengths of both pendulums in paper C are *h* and *h′* here, but
*b* and *b′* in our text except in §53 (see §20).

{summary}
"""
_COLUMNS = (
    '| § | claim | as it stands | as it must be | Tauto adds | computed | off by | verdict '
    '| whose fault |\n|---|---|---|---|---|---|---|---|---|'
)


class PageError(TautoError):
    """A page that cannot be written."""


def write_pages(folder: Path, pages: Iterable[tuple[str, str]]) -> None:
    """Write pages by their names into a folder, and replace existing files.

    Raises:
        PageError: a page cannot be written.
    """
    try:
        for name, text in pages:
            file = folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            write_whole(file, text.encode())
    except OSError as error:
        raise PageError(
            f'{error.filename or folder}: cannot be written: {error.strerror}. Name another folder'
        ) from None


def write_page(folder: Path, claims: Sequence[Claim]) -> None:
    """Write `euler.md` and `figures/*.svg` into a folder, as `write_pages` does."""

    def pages() -> Iterator[tuple[str, str]]:
        yield 'euler.md', claims_page(claims)
        for edition in EDITIONS:
            for figure in edition.figures:
                begin = (control.values[control.begin] for control in figure.controls)
                drawn = svg(figure.draw(*begin).drawing, figure.name, alone=True)
                yield f'figures/{_file(edition, figure)}.svg', drawn

    write_pages(folder, pages())


def claims_page(claims: Sequence[Claim]) -> str:
    """Return the page as Markdown: a section for each paper, with its figures and claims."""
    parts = [_HEAD.format(summary='\n'.join(wrap(summary(claims) + '.', 99)))]
    for edition in EDITIONS:
        parts.append(f'## {edition.paper}. {edition.short} (*{edition.title}*)\n')
        for figure in edition.figures:
            number = next(
                part.number for part in edition.paragraphs if figure.name in part.figures
            )
            text = _sentence(f'§{number}, Fig. {figure.name}: {figure.caption}')
            name = _file(edition, figure)
            parts.append(f'![{name}](figures/{name}.svg)\n\n' + '\n'.join(wrap(text, 120)) + '\n')
        rows = [claim for claim in claims if claim.paper == edition.paper]
        parts.append('\n'.join([_COLUMNS, *map(_row, rows)]) + '\n')
    return '\n'.join(parts)


def _file(edition: Edition, figure: EulerFigure) -> str:
    name = ''.join(letter if letter.isalnum() else '_' for letter in figure.name.lower())
    return re.sub('_+', '_', f'{edition.paper.lower()}_{name}')


def off_by(claim: Claim) -> str:
    """Return a difference as text, or its bound if it is below `SHOWN_ABOVE`."""
    if math.isinf(claim.difference):
        return '—'
    if claim.difference <= SHOWN_ABOVE:
        return f'< {min(claim.tolerance, SHOWN_ABOVE):.0e}' if claim.tolerance else '0'
    return f'{claim.difference:.1e}'


def _row(claim: Claim) -> str:
    value = f' → {seven_digits(claim.value)}' if math.isfinite(claim.value) else ''
    cells = (
        claim.paragraph,
        _sentence(claim.claim),
        _formula(claim.stands) + (value if claim.stands else ''),
        _formula(claim.must),
        _formula(claim.adds) + ('' if claim.stands else value),
        '' if claim.computed is None else seven_digits(claim.computed),
        off_by(claim),
        (claim.verdict if claim.verdict == 'holds' else f'**{claim.verdict}**')
        + (f': {_sentence(claim.because)}' if claim.because else ''),
        _sentence(claim.whose),
    )
    return f'| {" | ".join(cells)} |'


def seven_digits(value: float) -> str:
    """Return a value in seven digits."""
    return typeset(f'{value:.7g}')


def typeset(text: str) -> str:
    """Return text with minus signs for the hyphens of negative numbers, but not of powers."""
    return re.sub(r'(?<!e)-(?=\d)', '−', text)


def _formula(text: str) -> str:
    """Return a formula as Markdown, marked for docs/site.js."""
    return f'*{_safe(text)}*' if text else ''


def _sentence(words: str) -> str:
    """Return a sentence as Markdown, with its formulas marked."""
    pieces = words.split('*')
    return ''.join(_formula(piece) if k % 2 else _safe(piece) for k, piece in enumerate(pieces))


def _safe(text: str) -> str:
    for sign in '\\|*_`':
        text = text.replace(sign, '\\' + sign)
    # an entity, since not every reader of Markdown knows '\<'
    return text.replace('<', '&lt;')
