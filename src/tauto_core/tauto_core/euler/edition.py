"""A paper of Euler's, paragraph by paragraph: its argument, figures and commands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from tauto_core.euler.claim import Claim, Paper
from tauto_core.euler.drawing import Drawing


@dataclass(frozen=True)
class Control:
    """A control of a figure.

    Attributes:
        name: the quantity and its unit, such as 'z' or 'turn, rad'.
        values: the values it takes, in their order.
        begin: index of the value that is shown first.
        names: a label for each value; empty: the value itself.
    """

    name: str
    values: tuple[float, ...]
    begin: int = 0
    names: tuple[str, ...] = ()

    def label(self, index: int) -> str:
        """Return how a value is written."""
        return self.names[index] if self.names else f'{self.values[index]:.4g}'


@dataclass(frozen=True)
class Shown:
    """A figure at certain values of its controls: the drawing, and its numbers."""

    drawing: Drawing
    says: str = ''


@dataclass(frozen=True)
class EulerFigure:
    """A figure that the paper cites, constructed from its text, with Euler's letters.

    Attributes:
        name: Euler's: 'I', or 'Tab. IV, 3'.
        caption: the subject, and assumptions that the text does not state.
        draw: the figure for a value of each control.
        controls: its controls; empty where it has none.
    """

    name: str
    caption: str
    draw: Callable[..., Shown]
    controls: tuple[Control, ...] = ()


@dataclass(frozen=True)
class Paragraph:
    """A paragraph.

    Attributes:
        number: Euler's, in his numerals.
        argues: its argument, in two plain sentences.
        runs: commands that compute or sail it.
        figures: names of the figures that are shown beside it.
        found: the result where the paper leaves a question or gives a judgement.
        lacks: the part that no command can do, and why; empty where there is none.
    """

    number: str
    argues: str
    runs: tuple[str, ...] = ()
    figures: tuple[str, ...] = ()
    found: str = ''
    lacks: str = ''


@dataclass(frozen=True)
class Edition:
    """A paper.

    Attributes:
        paper: its letter, as in the claims.
        file: name of its page, without the suffix.
        title: in Latin, as in the text.
        short: its name here.
        facts: the bibliography: a label, and a fact with its source.
        figures: all that the paper cites, in their order.
        paragraphs: all of them, in their order.
    """

    paper: Paper
    file: str
    title: str
    short: str
    facts: tuple[tuple[str, str], ...]
    figures: tuple[EulerFigure, ...]
    paragraphs: tuple[Paragraph, ...]

    def checked(self, claims: Sequence[Claim]) -> dict[str, list[Claim]]:
        """Return the claims on this paper by the number of the paragraph beside which they stand.

        A claim on several paragraphs stands beside the first: XXII-XXIX beside XXII.
        """
        beside: dict[str, list[Claim]] = {each.number: [] for each in self.paragraphs}
        for claim in claims:
            if claim.paper == self.paper:
                beside[self.covered(claim)[0]].append(claim)
        return beside

    def covered(self, claim: Claim) -> list[str]:
        """Return the numbers of the paragraphs that a claim is on: '26-27, 29' has three."""
        numbers = [each.number for each in self.paragraphs]
        found: list[str] = []
        for part in claim.paragraph.split(','):
            ends = [numbers.index(each.strip()) for each in part.split('-')]
            found += numbers[ends[0] : ends[-1] + 1]
        return found
