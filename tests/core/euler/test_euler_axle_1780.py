"""Claims of paper C against figures found by hand, and that a wrong formula is seen."""

from copy import deepcopy

import pytest

from tauto_core.euler import edition
from tauto_core.euler.axle_1780 import claims
from tauto_core.euler.edition import read_text

CLAIMS = claims()


def test_formula_without_c_gives_a_negative_length():
    (slow,) = [claim for claim in CLAIMS if claim.stands.startswith('h = ekk/(kk + cf − √')]
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
