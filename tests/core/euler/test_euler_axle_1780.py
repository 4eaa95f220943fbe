"""Every claim of paper C gets the expected verdict."""

import math
import re
from copy import deepcopy

import pytest

from tauto_core.euler import edition
from tauto_core.euler.axle_1780 import claims
from tauto_core.euler.edition import read_text

CLAIMS = claims()


@pytest.mark.parametrize('claim', CLAIMS, ids=lambda claim: f'{claim.paragraph}: {claim.claim}')
def test_the_verdict_is_the_expected_one(claim):
    assert claim.paper == 'C'
    assert claim.verdict == claim.expected
    assert math.isfinite(claim.computed)
    assert (claim.expected == 'corrected') == bool(claim.because) == bool(claim.must)
    assert (claim.expected == 'corrected') == (claim.must_value is not None)


def test_they_stand_in_the_order_of_the_paper():
    first = [int(re.match(r'\d+', claim.paragraph).group()) for claim in CLAIMS]
    assert first == sorted(first)


def test_every_formula_that_needs_a_correction_is_there():
    """Those of `physics.md`, and k² for k⁴ (45, 53), g′ (21) and sin for arc sin (20)."""
    assert [claim.paragraph for claim in CLAIMS if claim.expected == 'corrected'] == [
        '5', '15', '17-20', '18-21', '19', '20', '20', '21', '23', '23', '32', '36', '37', '44',
        '45', '45', '53', '53',
    ]  # fmt: skip


def test_the_formula_without_c_gives_the_negative_length_it_was_caught_by():
    (slow,) = [claim for claim in CLAIMS if claim.stands.startswith('b = ekk/(kk + cf − √')]
    assert slow.value == pytest.approx(-0.0150, abs=5e-5)
    assert slow.computed == pytest.approx(0.458647575161926656834875439639, rel=1e-14)


def test_a_push_is_divided_by_the_formula_beside_it():
    """§32 for e, c, k = 0.1, 0.3, 0.15 m, n = 0.01 m/s, ν = 0.02 rad/s, by hand in 30 digits."""
    slow, fast = [claim for claim in CLAIMS if claim.claim.startswith('the push, divided')]
    assert slow.value == pytest.approx(0.0704348895, abs=1e-10)
    assert fast.value == pytest.approx(0.0628984439, abs=1e-10)


def test_an_evaluated_formula_that_is_wrong_is_seen(monkeypatch):
    """With a k of 1 % more in the formulas than in the body."""
    text = deepcopy(read_text('axle'))
    text['letters']['k'] *= 1.01
    monkeypatch.setattr(edition, 'read_text', lambda _: text)
    spoilt = [claim.paragraph for claim in claims() if claim.verdict != claim.expected]
    assert set(spoilt) >= {'41', '42', '43', '45'}
