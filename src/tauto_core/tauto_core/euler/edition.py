"""A paper by Euler, paragraph by paragraph: its claims, its argument, figures and commands."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from html import escape
from pathlib import Path
from typing import Any, Literal, TypeAlias, cast

import numpy as np
import yaml
from numpy.typing import ArrayLike

from tauto_core.euler.formulas import evaluate
from tauto_core.samples import FloatArray

# -----------------------------------------------------------------------------
# Claims. A formula is evaluated as it stands in our text, a transcription by machine, and compared
# with an independent value from quadrature, an integrated motion, or another closed form.

Paper: TypeAlias = Literal['A', 'B', 'C']
G = 9.81
"""Gravity of all examples [m/s2]."""

Verdict: TypeAlias = Literal['holds', 'corrected', 'fails', 'added', 'answered']


def plain(words: str) -> str:
    """Return a sentence without the asterisks around its formulas."""
    return words.replace('*', '')


@dataclass(frozen=True)
class Claim:
    """A claim, its formula as it stands and as it must be, and an independent value.

    Attributes:
        paper: A (E6, the trochlea), B (E13, the fluid) or C (the axle).
        paragraph: number of the paragraph, in Euler's numerals: 'XIX', '26-27'.
        claim: the claim in words. Formulas are between asterisks, as in all texts of an edition.
        stands: the formula or number in the text, letter by letter, or empty if it has none.
        value: the value of `stands`, or else of `adds`, for the example. NaN if it has no value.
        computed: the same quantity, computed independently, or `None` for a fault of letters.
        tolerance: largest difference if the claim holds, relative to `computed`, or absolute if
            that is 0.
        must: the formula as it must be, or empty if the text is right.
        must_value: the value of `must`, or `None`.
        because: why the claim fails, or how the fault is recognised.
        expected: the verdict that the tests require.
        adds: Tauto's addition: the formula for a claim in words, or a testable figure.
        euler: false for a claim that is not in the paper.
        whose: origin of a fault, and a reason: 'transcription certain' if the text has the formula
            right elsewhere or only a machine reads so, 'print likely' if it is repeated while its
            neighbours are intact, else 'open'.
        question: true for a question of the paper. If it does not hold, the answer is no.
    """

    paper: Paper
    paragraph: str
    claim: str
    stands: str
    value: float
    computed: float | None
    tolerance: float
    must: str = ''
    must_value: float | None = None
    because: str = ''
    expected: Verdict = 'holds'
    adds: str = ''
    euler: bool = True
    whose: str = ''
    question: bool = False

    @property
    def said(self) -> str:
        """The claim in plain text."""
        return plain(self.claim)

    @property
    def reason(self) -> str:
        """`because` in plain text."""
        return plain(self.because)

    @property
    def difference(self) -> float:
        """Difference of `value`, relative to `computed`, or absolute if that is 0."""
        return _difference(self.value, self.computed)

    @property
    def verdict(self) -> Verdict:
        """`holds` as it stands, `corrected` only as it must be, `added` if not in the paper, …"""
        if self.must and self.computed is None:
            return 'corrected'
        if self.difference <= self.tolerance:
            return 'holds' if self.euler else 'added'
        must = self.must_value
        if must is not None and _difference(must, self.computed) <= self.tolerance:
            return 'corrected'
        return 'answered' if self.question else 'fails'


def _difference(value: float, truth: float | None) -> float:
    if truth is None or math.isnan(value) or math.isnan(truth):
        return math.inf
    return abs(value - truth) / (abs(truth) or 1.0)


# -----------------------------------------------------------------------------
# Drawings as SVG in units of length, y upwards, with strokes and letters of fixed size. The style
# sheet of the page sets the colours, by class: `ink`, `curve`, `thread`, `other`, `faint`,
# `heavy`, and `solid` for filled areas.

Point = tuple[float, float] | FloatArray

WIDE = 400.0
"""Width of every drawing in units of its view box."""


class Drawing:
    """Lines, circles and letters over a rectangle.

    `left` to `right` and `low` to `high` are its range, `wide` its width on the page.
    """

    def __init__(
        self, left: float, right: float, low: float, high: float, wide: float = WIDE
    ) -> None:
        self._left, self._high = left, high
        self._scale = wide / (right - left)
        self.size = wide, (high - low) * self._scale
        self._parts: list[str] = []

    def line(self, *points: Point, look: str = 'ink', closed: bool = False) -> None:
        """Draw straight lines from point to point."""
        x, y = np.array(points, np.float64).T
        self.curve(x, y, look, closed=closed)

    def lines(self, look: str, *lines: Sequence[Point]) -> None:
        """Draw polylines of the same look."""
        for points in lines:
            self.line(*points, look=look)

    def curve(
        self, x: ArrayLike, y: ArrayLike, look: str = 'ink', *, closed: bool = False
    ) -> None:
        """Draw a polyline through points, two arrays of shape (n,)."""
        pairs = zip(*self._placed(x, y), strict=True)
        path = 'M' + 'L'.join(f'{_short(u)} {_short(v)}' for u, v in pairs)
        self._parts.append(f'<path class="{look}" d="{path}{"Z" if closed else ""}"/>')

    def circle(self, centre: Point, radius: float, look: str = 'ink') -> None:
        """Draw a circle."""
        (u,), (v,) = self._placed(centre[0], centre[1])
        self._parts.append(
            f'<circle class="{look}" cx="{_short(u)}" cy="{_short(v)}" '
            f'r="{_short(radius * self._scale)}"/>'
        )

    def arc(
        self, centre: Point, radius: float, begin: float, end: float, look: str = 'ink'
    ) -> None:
        """Draw an arc of a circle between two directions [rad], from x towards y."""
        turn = np.linspace(begin, end, 2 + int(abs(end - begin) / 0.1))
        self.curve(centre[0] + radius * np.cos(turn), centre[1] + radius * np.sin(turn), look)

    def letter(self, at: Point, text: str, right: float = 7.0, up: float = 6.0) -> None:
        """Mark a point and write its letter at an offset in units of the page."""
        (u,), (v,) = self._placed(at[0], at[1])
        self._parts.append(f'<circle class="dot" cx="{_short(u)}" cy="{_short(v)}" r="2.2"/>')
        self.note(at, text, right, up, look='letter')

    def letters(self, *places: tuple[Point, str, float, float]) -> None:
        """Mark points by letters, each with its offset to the right and up."""
        for place in places:
            self.letter(*place)

    def note(
        self, at: Point, text: str, right: float = 0.0, up: float = 0.0, look: str = 'note'
    ) -> None:
        """Write a text at an offset from a point."""
        (u,), (v,) = self._placed(at[0], at[1])
        self._parts.append(
            f'<text class="{look}" x="{_short(u + right)}" y="{_short(v - up)}">'
            f'{escape(text)}</text>'
        )

    @property
    def markup(self) -> str:
        """The content of the `svg` element."""
        return ''.join(self._parts)

    def _placed(self, x: ArrayLike, y: ArrayLike) -> tuple[FloatArray, FloatArray]:
        across = np.atleast_1d(np.asarray(x, np.float64))
        up = np.atleast_1d(np.asarray(y, np.float64))
        return (across - self._left) * self._scale, (self._high - up) * self._scale


def svg(drawing: Drawing, title: str) -> str:
    """Return a drawing as an `svg` element with its title."""
    wide, high = map(_short, drawing.size)
    return (
        f'<svg viewBox="0 0 {wide} {high}" width="{wide}" role="img" '
        f'aria-label="{escape(title)}">{drawing.markup}</svg>'
    )


def turned(points: Iterable[ArrayLike], angle: float) -> tuple[FloatArray, FloatArray]:
    """Return points (x, y) turned about the origin by an angle [rad], from x towards y."""
    x, y = (np.asarray(values, np.float64) for values in points)
    cosine, sine = np.cos(angle), np.sin(angle)
    return cosine * x - sine * y, sine * x + cosine * y


def _short(value: float) -> str:
    # a tenth of a unit is a quarter of a pixel on a wide page
    return f'{round(float(value), 1) + 0.0:g}'


# -----------------------------------------------------------------------------
# Paragraphs and figures.


@dataclass(frozen=True)
class Control:
    """A control of a figure.

    Attributes:
        name: the quantity and its unit, such as 'z' or 'turn, rad'.
        values: its values, in their order.
        begin: index of the first value shown.
        names: labels of the values, by default the numbers.
    """

    name: str
    values: tuple[float, ...]
    begin: int = 0
    names: tuple[str, ...] = ()

    def label(self, index: int) -> str:
        """Return the label of a value."""
        return self.names[index] if self.names else f'{self.values[index]:.4g}'


@dataclass(frozen=True)
class View:
    """A figure at some values of its controls: the drawing, and a sentence with its numbers."""

    drawing: Drawing
    says: str = ''


@dataclass(frozen=True)
class EulerFigure:
    """A figure that the paper cites, constructed from its text, with Euler's letters.

    Attributes:
        name: Euler's name, 'I' or 'Tab. IV, 3'.
        caption: the subject, and assumptions that the text does not state.
        draw: function that draws the figure for a value of each control.
        controls: the controls.
    """

    name: str
    caption: str
    draw: Callable[..., View]
    controls: tuple[Control, ...] = ()


@dataclass(frozen=True)
class Paragraph:
    """A paragraph.

    Attributes:
        number: number in Euler's numerals.
        argues: its argument, in two plain sentences.
        latin: its text, with formulas between asterisks. '‹it|tt›' is a fault and its correction.
        runs: commands that compute or sail it.
        figures: names of its figures.
        found: our result, if the paper leaves a question or gives a judgement.
        lacks: the part that no command can do, and why.
    """

    number: str
    argues: str
    latin: str
    runs: tuple[str, ...] = ()
    figures: tuple[str, ...] = ()
    found: str = ''
    lacks: str = ''


@dataclass(frozen=True)
class Edition:
    """A paper.

    Attributes:
        paper: letter of the paper.
        file: name of its page, without the suffix.
        title: Latin title.
        short: English name.
        facts: the bibliography: a label, and a fact with its source.
        figures: all figures, in their order.
        paragraphs: all paragraphs, in their order.
    """

    paper: Paper
    file: str
    title: str
    short: str
    facts: tuple[tuple[str, str], ...]
    figures: tuple[EulerFigure, ...]
    paragraphs: tuple[Paragraph, ...]

    def checked(self, claims: Sequence[Claim]) -> dict[str, list[Claim]]:
        """Return the claims by paragraph. A claim on several belongs to the first of them."""
        table: dict[str, list[Claim]] = {item.number: [] for item in self.paragraphs}
        for claim in claims:
            if claim.paper == self.paper:
                table[self.covered(claim)[0]].append(claim)
        return table

    def covered(self, claim: Claim) -> list[str]:
        """Return the numbers of a claim's paragraphs: '26-27, 29' has three."""
        numbers = [item.number for item in self.paragraphs]
        result: list[str] = []
        for part in claim.paragraph.split(','):
            ends = [numbers.index(end.strip()) for end in part.split('-')]
            result += numbers[ends[0] : ends[-1] + 1]
        return result


@cache
def read_text(file: str) -> dict[str, Any]:
    """Return the text of a paper from `<file>.yaml` in this folder."""
    text = yaml.safe_load(Path(__file__).with_name(f'{file}.yaml').read_text('utf-8'))
    return cast(dict[str, Any], text)


def letters_of(
    file: str,
    example: Mapping[str, float | str] | None = None,
    computed: Mapping[str, float] | None = None,
) -> dict[str, float]:
    """Return the values of the letters of a paper's example, and the computed ones.

    `example` replaces letters. Letters given by formulas follow the new values.
    """
    stated = read_text(file)['letters']
    letters = dict(computed or {})
    for name, value in stated.items():
        letters[name] = _number(value, letters)
    changed: dict[str, float] = {}
    for name, value in (example or {}).items():
        changed[name] = _number(value, letters | changed)
    letters |= changed
    for name, value in stated.items():
        if changed and name not in changed:
            letters[name] = _number(value, letters)
    return letters


def _number(value: float | str, letters: Mapping[str, float], of: str = '') -> float:
    """Return a number given by its value, its name, or its formula."""
    if isinstance(value, str):
        return letters[value] if value in letters else evaluate(value, letters, of)
    return float(value)


def read_claims(paper: Paper, file: str, computed: Mapping[str, float]) -> list[Claim]:
    """Return the claims of `<file>.yaml`, in the order of the paper.

    The formulas `stands`, `must` and `adds` are evaluated with the letters of the example and of
    `with`. If `of` names a letter, they are solved for it. `value` or `must_value` give another
    formula to evaluate, `adds`, or `none` for a claim without a value.

    `computed` are the independent values, by their names in the file.
    """
    text = read_text(file)
    claims = []
    for paragraph in text['paragraphs']:
        for entry in paragraph.get('claims', ()):
            stands, must, adds = (entry.get(key, '') for key in ('stands', 'must', 'adds'))
            letters = letters_of(file, entry.get('with'), computed)
            named = {'none': math.nan, 'adds': adds}
            value, must_value = (
                _number(named.get(formula, formula), letters, entry.get('of', ''))
                if formula != '' and 'computed' in entry
                else None
                for formula in (entry.get('value', stands or adds), entry.get('must_value', must))
            )
            euler = entry.get('euler', True)
            claims.append(
                Claim(
                    paper,
                    entry.get('paragraphs', paragraph['number']),
                    entry['claim'],
                    stands,
                    math.nan if value is None else value,
                    _number(entry['computed'], letters) if 'computed' in entry else None,
                    float(entry.get('tolerance', text['tolerance'])),
                    must,
                    must_value,
                    entry.get('because', ''),
                    entry.get('expected', 'corrected' if must else 'holds' if euler else 'added'),
                    adds,
                    euler,
                    entry.get('whose', ''),
                    entry.get('question', False),
                )
            )
    return claims


def read_edition(
    paper: Paper,
    file: str,
    figures: Mapping[str, tuple[Callable[..., View], *tuple[Control, ...]]],
) -> Edition:
    """Return a paper with its text from `<file>.yaml`.

    `figures` has the function that draws each figure and its controls, by Euler's name.
    """
    text = read_text(file)
    paragraphs: list[dict[str, Any]] = [
        {k: tuple(v) if isinstance(v, list) else v for k, v in entry.items() if k != 'claims'}
        for entry in text['paragraphs']
    ]
    return Edition(
        paper,
        file,
        text['title'],
        text['short'],
        tuple(text['facts'].items()),
        tuple(
            EulerFigure(name, text['captions'][name], draw, tuple(controls))
            for name, (draw, *controls) in figures.items()
        ),
        tuple(Paragraph(**fields) for fields in paragraphs),
    )
