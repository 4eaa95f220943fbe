"""The verdict on a claim: its rule, and what every claim of the papers gets."""

import math
import re
from dataclasses import replace

import pytest

from tauto_core.euler import Claim
from tauto_core.euler.page import all_claims

CLAIMS = all_claims()


@pytest.mark.parametrize('claim', CLAIMS, ids=lambda c: f'{c.paper}{c.paragraph}: {c.claim}')
def test_every_claim_gets_its_expected_verdict(claim):
    assert claim.verdict == claim.expected != 'fails'
    assert bool(claim.because) == (claim.verdict in {'corrected', 'answered'})
    assert bool(claim.must) == (claim.verdict == 'corrected')
    # a correction agrees far better than the print
    if claim.must and claim.computed:
        assert abs(claim.must_value - claim.computed) < 3e-6 * abs(claim.computed)


def _claim(value, must=None, **more):
    return Claim('A', 'XX', 'a length', 'L', value, 2.0, 1e-12, 'M', must, **more)


def test_a_value_within_the_tolerance_holds():
    assert _claim(2.0 * (1.0 + 5e-13)).verdict == 'holds'
    assert _claim(2.0 * (1.0 + 5e-12)).verdict == 'fails'


def test_a_value_that_only_its_correction_gives_is_corrected():
    assert _claim(3.0, 2.0).verdict == 'corrected'
    assert _claim(3.0, 2.1).verdict == 'fails'


def test_what_cannot_be_evaluated_does_not_hold():
    assert _claim(math.nan).verdict == 'fails'
    assert _claim(math.nan, 2.0).verdict == 'corrected'
    # a computation that went wrong corrects nothing
    assert replace(_claim(3.0, 2.0), computed=math.nan).verdict == 'fails'


def test_fault_of_letters_has_no_value_question_is_answered():
    words = Claim('A', 'V', 'the thread', 'CD', math.nan, None, 1e-12, 'CB')
    assert (words.verdict, words.difference) == ('corrected', math.inf)
    assert _claim(2.1, question=True).verdict == 'answered'
    assert _claim(2.0, question=True).verdict == 'holds'


def test_every_correction_says_whose_the_fault_is():
    labels = re.compile('(transcription certain|print likely: .+|open(: .+)?)$')
    for claim in CLAIMS:
        assert bool(labels.match(claim.whose)) == bool(claim.must), claim.said


def test_a_difference_from_zero_is_absolute():
    claim = Claim('C', '38', 'nothing', '0', 1e-13, 0.0, 1e-12)
    assert claim.difference == 1e-13
    assert claim.verdict == 'holds'


def test_claim_not_in_the_paper_is_added_or_fails():
    assert _claim(2.0, euler=False).verdict == 'added'
    assert _claim(2.1, euler=False).verdict == 'fails'
