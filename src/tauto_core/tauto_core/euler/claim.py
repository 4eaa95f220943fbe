"""A claim of one of the papers, and how it is judged.

The printed formula is evaluated as it stands and compared with a value computed independently: by
quadrature, by integrating the motion, or by another closed form.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

Paper: TypeAlias = Literal['A', 'B', 'C']
Verdict: TypeAlias = Literal['holds', 'misprint', 'fails']


@dataclass(frozen=True)
class Claim:
    """A claim, the value of what is printed, and a value computed independently.

    Attributes:
        paper: A: E6, the trochlea; B: E13, the fluid; C: the axle.
        paragraph: Euler's, in his numerals: 'XIX', '26-27'.
        claim: what is claimed, in a line of words.
        printed: the formula or number as printed.
        printed_value: its value for the example; NaN where it cannot be evaluated.
        computed: the same quantity, computed independently of it.
        tolerance: largest difference of the two if the claim holds, relative to `computed`,
            absolute where that is 0.
        corrected: the formula as it should read; empty where the print is right.
        corrected_value: its value; None where there is no correction.
        because: why it fails, or how the misprint is recognised; empty where it holds.
        expected: the verdict that the tests require.
    """

    paper: Paper
    paragraph: str
    claim: str
    printed: str
    printed_value: float
    computed: float
    tolerance: float
    corrected: str = ''
    corrected_value: float | None = None
    because: str = ''
    expected: Verdict = 'holds'

    @property
    def difference(self) -> float:
        """Difference of the printed value, relative to `computed`, absolute where that is 0."""
        return _difference(self.printed_value, self.computed)

    @property
    def verdict(self) -> Verdict:
        """`holds` if the print agrees, `misprint` if only its correction does, else `fails`."""
        if self.difference <= self.tolerance:
            return 'holds'
        corrected = self.corrected_value
        if corrected is not None and _difference(corrected, self.computed) <= self.tolerance:
            return 'misprint'
        return 'fails'


def _difference(value: float, truth: float) -> float:
    if math.isnan(value):
        return math.inf
    return abs(value - truth) / (abs(truth) or 1.0)
