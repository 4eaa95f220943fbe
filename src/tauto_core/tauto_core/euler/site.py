"""All claims, and the papers as interactive pages, one self-contained HTML file each.

A page holds the drawings of its figures for all values of their controls. Its script only
exchanges drawings. It uses no network. Numbers are rounded to seven digits, for the same text on
every machine.
"""

from __future__ import annotations

import itertools
import json
import math
import re
from collections import Counter
from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template
from textwrap import dedent

from tauto_core.euler import (
    axle_1780,
    axle_edition,
    fluid_1729,
    fluid_edition,
    trochlea_1727,
    trochlea_edition,
)
from tauto_core.euler.edition import Claim, Edition, EulerFigure, Paragraph, plain, svg
from tauto_core.euler.formulas import mathml
from tauto_core.files import OutputError, write_output

EDITIONS: tuple[Edition, ...] = (
    trochlea_edition.EDITION,
    fluid_edition.EDITION,
    axle_edition.EDITION,
)
"""The papers paragraph by paragraph."""
SHOWN_ABOVE = 1e-9
"""Smallest difference printed in digits. A smaller one is printed as a bound."""

_HEAD = dedent("""\
    Written by <code>tauto euler --site</code>. Each paragraph is summarised in two sentences.
    The formulas stand as in our text of the paper, a transcription by machine from scans without
    the plates. The Latin is that text, without running heads and with its formulas in one line.
    Behind <del>a fault</del> is <ins>[the correction]</ins>.
    The figures are constructed from the text, with Euler’s letters.
    “Computed” is the same quantity, found independently by quadrature, by integrating the motion
    or by another closed form. Only scans, which were not compared, could show which faults of the
    text are in the print. Examples are in SI units unless a claim says otherwise.""")
_VERDICTS = {
    'holds': 'holds',
    'corrected': 'holds once corrected',
    'fails': 'does not hold',
    'added': 'not in the paper',
    'answered': 'answered',
}


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


def write_site(folder: Path, claims: Sequence[Claim]) -> None:
    """Write a page for each paper into a folder, and replace existing files.

    Raises:
        OutputError: a page cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f'{folder}: {error.strerror}. Name another folder') from None
    for paper in EDITIONS:
        write_output(folder / f'{paper.file}.html', paper_page(paper, claims).encode())


def paper_page(edition: Edition, claims: Sequence[Claim]) -> str:
    """Return the page of a paper as HTML."""
    checked = edition.checked(claims)
    figures = {figure.name: figure for figure in edition.figures}
    frames = {}
    for figure in edition.figures:
        # the drawings for all values of the controls, of which the last changes first
        every = itertools.product(*(control.values for control in figure.controls))
        views = [figure.draw(*values) for values in every if values]
        if views:
            frames[_id(figure)] = {
                'values': [[c.label(k) for k in range(len(c.values))] for c in figure.controls],
                'drawn': [view.drawing.markup for view in views],
                'says': [_sentence(typeset(view.says)) for view in views],
            }
    template = Template(Path(__file__).with_name('site_page.html').read_text(encoding='utf-8'))
    return template.substitute(
        short=escape(edition.short),
        title=escape(edition.title),
        head=_HEAD,
        papers=''.join(
            f'<span aria-current="page">{escape(paper.short)}</span>'
            if paper is edition
            else f'<a href="{paper.file}.html">{escape(paper.short)}</a>'
            for paper in EDITIONS
        ),
        verdicts=''.join(
            f'<dt>{words} ({len(places)})</dt><dd>'
            + ', '.join(f'<a href="#{place}">§{place}</a>' for place in dict.fromkeys(places))
            + '</dd>'
            for verdict, words in _VERDICTS.items()
            if (places := [p for p, has in checked.items() for c in has if c.verdict == verdict])
        ),
        facts=''.join(
            f'<dt>{escape(name)}</dt><dd>'
            + re.sub(r'https?://[^\s,;)]+', r'<a href="\g<0>">\g<0></a>', escape(text))
            + '</dd>'
            for name, text in edition.facts
        ),
        contents=''.join(
            f'<li><a href="#{item.number}">{item.number}</a></li>' for item in edition.paragraphs
        ),
        paragraphs='\n'.join(
            _paragraph(item, [figures[name] for name in item.figures], checked[item.number])
            for item in edition.paragraphs
        ),
        # a script element ends at the first '</'
        figures=json.dumps(frames, ensure_ascii=False, separators=(',', ':')).replace(
            '</', '<\\/'
        ),
    )


def _paragraph(
    paragraph: Paragraph, figures: Sequence[EulerFigure], claims: Sequence[Claim]
) -> str:
    # a line may end between words, not within an option
    runs = ''
    for run in paragraph.runs:
        words = ' '.join(f'<span>{escape(word)}</span>' for word in run.split())
        runs += f'<li><code>{words}</code></li>'
    return (
        f'<section class="paragraph{" with-figure" if figures else ""}" id="{paragraph.number}">'
        f'<div><h2>§{paragraph.number}</h2><p>{_sentence(paragraph.argues)}</p>'
        f'<details><summary>Latin</summary><p lang="la">{_latin(paragraph.latin)}</p></details>'
        f'{"".join(map(_claim, claims))}'
        f'{f"<h3>Result</h3><p>{_sentence(paragraph.found)}</p>" if paragraph.found else ""}'
        f'{f"<h3>Run it</h3><ul class=runs>{runs}</ul>" if runs else ""}'
        f'{f"<p class=lacks>{_sentence(paragraph.lacks)}</p>" if paragraph.lacks else ""}</div>'
        f'{"".join(map(_figure, figures))}</section>'
    )


def _claim(claim: Claim) -> str:
    value = f' →\u00a0{seven_digits(claim.value)}' if math.isfinite(claim.value) else ''
    rows = [
        ('as it stands', claim.stands, value),
        ('as it must be', claim.must, ''),
        ('Tauto adds', claim.adds, '' if claim.stands else value),
    ]
    formulas = ''.join(
        f'<dt>{name}</dt><dd>{mathml(formula)}{escape(value)}</dd>'
        for name, formula, value in rows
        if formula
    )
    because = f': {_sentence(claim.because)}' if claim.because else ''
    stands = 'as it stands ' if claim.must else ''
    off = '' if math.isinf(claim.difference) else f'; {stands}off by {escape(off_by(claim))}'
    if claim.computed is not None:
        formulas += f'<dt>computed</dt><dd>{seven_digits(claim.computed)}{off}</dd>'
    whose = f'. Whose fault: {_sentence(claim.whose)}' if claim.whose else ''
    return (
        f'<div class="claim {claim.verdict}"><p>{_sentence(claim.claim)}</p>'
        f'<dl class="formulas">{formulas}</dl>'
        f'<p><span class="verdict">{_VERDICTS[claim.verdict]}</span>{because}{whose}</p></div>'
    )


def _figure(figure: EulerFigure) -> str:
    called = figure.name if figure.name.startswith('Tab.') else f'Fig. {figure.name}'
    view = figure.draw(*(control.values[control.begin] for control in figure.controls))
    name = _id(figure)
    controls = ''.join(
        f'<div class="control"><label for="{name}-{k}">{escape(control.name)}</label>'
        f'<input type="range" id="{name}-{k}" min="0" max="{len(control.values) - 1}" '
        f'value="{control.begin}" disabled>'
        f'<output for="{name}-{k}">{escape(control.label(control.begin))}</output></div>'
        for k, control in enumerate(figure.controls)
    )
    return (
        f'<figure id="{name}">{svg(view.drawing, f"{called}: {plain(figure.caption)}")}'
        f'{controls}<p class="says" aria-live="polite">{_sentence(typeset(view.says))}</p>'
        f'<figcaption>{called}, constructed from the text. {_sentence(figure.caption)}'
        f'</figcaption></figure>'
    )


def _sentence(words: str) -> str:
    pieces = words.split('*')
    parts = (mathml(bit, flat=True) if k % 2 else escape(bit) for k, bit in enumerate(pieces))
    return ''.join(parts)


def _latin(text: str) -> str:
    """Return a text as HTML, with each fault's correction behind it."""
    # a sentence, a formula as it stands, and as it must be
    pieces = re.split(r'‹(\*.*?\*)\|(\*.*?\*)›', text)
    html = ''
    for k, piece in enumerate(map(_sentence, pieces)):
        tag = (None, '<del>{}</del>', ' <ins>[{}]</ins>')[k % 3]
        marked = re.sub(r'‹(.*?)\|(.*?)›', r'<del>\1</del> <ins>[\2]</ins>', piece)
        html += tag.format(piece) if tag else marked
    return html


def _id(figure: EulerFigure) -> str:
    return 'figure-' + ''.join(letter if letter.isalnum() else '-' for letter in figure.name)


def off_by(claim: Claim) -> str:
    """Return a difference as text, or its bound if it is below `SHOWN_ABOVE`."""
    if math.isinf(claim.difference):
        return '—'
    if claim.difference <= SHOWN_ABOVE:
        return f'< {min(claim.tolerance, SHOWN_ABOVE):.0e}' if claim.tolerance else '0'
    return f'{claim.difference:.1e}'


def seven_digits(value: float) -> str:
    """Return a value in seven digits."""
    return typeset(f'{value:.7g}')


def typeset(text: str) -> str:
    """Return text with minus signs for the hyphens of negative numbers, but not of powers."""
    return re.sub(r'(?<!e)-(?=\d)', '−', text)
