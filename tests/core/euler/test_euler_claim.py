"""The rule for the verdict on a claim."""

import math

from tauto_core.euler import Claim


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


def test_a_difference_from_zero_is_absolute():
    claim = Claim('C', '38', 'nothing', '0', 1e-13, 0.0, 1e-12)
    assert claim.difference == 1e-13
    assert claim.verdict == 'holds'


def test_what_is_not_eulers_is_added_where_it_holds_and_fails_where_not():
    assert _claim(2.0, euler=False).verdict == 'added'
    assert _claim(2.1, euler=False).verdict == 'fails'
