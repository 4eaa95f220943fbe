"""The verdict on a claim: its rule, and what every claim of the papers gets."""

import math
import re
from dataclasses import replace

import pytest

from tauto_core.euler import Claim
from tauto_core.euler.site import all_claims

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


@pytest.mark.parametrize(
    ('claim', 'verdict'),
    [
        (_claim(2.0 * (1.0 + 5e-13)), 'holds'),
        (_claim(2.0 * (1.0 + 5e-12)), 'fails'),
        (_claim(3.0, 2.0), 'corrected'),
        (_claim(3.0, 2.1), 'fails'),
        (_claim(math.nan), 'fails'),
        (_claim(math.nan, 2.0), 'corrected'),
        (replace(_claim(3.0, 2.0), computed=math.nan), 'fails'),
        (replace(_claim(math.nan), computed=None), 'corrected'),
        (_claim(2.1, question=True), 'answered'),
        (_claim(2.0, question=True), 'holds'),
        (_claim(2.0, euler=False), 'added'),
        (_claim(2.1, euler=False), 'fails'),
        # a difference from 0 is absolute
        (replace(_claim(1e-13), computed=0.0), 'holds'),
        (replace(_claim(1e-11), computed=0.0), 'fails'),
    ],
)
def test_verdict_on_a_claim(claim, verdict):
    assert claim.verdict == verdict


def test_every_correction_has_the_origin_of_its_fault():
    labels = re.compile('(transcription certain|print likely: .+|open(: .+)?)$')
    for claim in CLAIMS:
        assert bool(labels.match(claim.whose)) == bool(claim.must), claim.said
