"""A claim of one of the papers, and how it is judged.

The formula is evaluated as it stands in the text that we have, a transcription by machine, and
compared with a value computed independently: by quadrature, by integrating the motion, or by
another closed form.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

Paper: TypeAlias = Literal['A', 'B', 'C']
G = 9.81
"""Gravity of all examples [m/s2]."""

Verdict: TypeAlias = Literal['holds', 'corrected', 'fails', 'added']


@dataclass(frozen=True)
class Claim:
    """A claim, its formula as it stands and as it must be, and a value computed independently.

    Attributes:
        paper: A: E6, the trochlea; B: E13, the fluid; C: the axle.
        paragraph: Euler's, in his numerals: 'XIX', '26-27'.
        claim: the claim, in a line of words.
        stands: the formula or number as it stands in the text, letter by letter; empty where the
            text states it in words, or omits it.
        value: the value for the example of `stands`, or of `adds` where that is empty; NaN where
            it cannot be evaluated.
        computed: the same quantity, computed independently of it.
        tolerance: largest difference of the two if the claim holds, relative to `computed`,
            absolute where that is 0.
        must: the formula as it must be; empty where it is right as it stands.
        must_value: its value; None where there is no correction.
        because: why it fails, or how the fault is recognised; empty where it holds.
        expected: the verdict that the tests require.
        adds: what Tauto adds: the formula for a claim in words, or a figure that makes one
            testable.
        euler: false for a claim that is not in the paper.
    """

    paper: Paper
    paragraph: str
    claim: str
    stands: str
    value: float
    computed: float
    tolerance: float
    must: str = ''
    must_value: float | None = None
    because: str = ''
    expected: Verdict = 'holds'
    adds: str = ''
    euler: bool = True

    @property
    def difference(self) -> float:
        """Difference of `value`, relative to `computed`, absolute where that is 0."""
        return _difference(self.value, self.computed)

    @property
    def verdict(self) -> Verdict:
        """`holds` as it stands, `corrected` if only as it must be, `added` if not Euler's."""
        if self.difference <= self.tolerance:
            return 'holds' if self.euler else 'added'
        must = self.must_value
        if must is not None and _difference(must, self.computed) <= self.tolerance:
            return 'corrected'
        return 'fails'


def _difference(value: float, truth: float) -> float:
    if math.isnan(value):
        return math.inf
    return abs(value - truth) / (abs(truth) or 1.0)
