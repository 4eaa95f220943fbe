"""Every claim of paper C gets the expected verdict."""

import math
import re

import pytest

from tauto_core.euler.axle_1780 import claims

CLAIMS = claims()


@pytest.mark.parametrize('claim', CLAIMS, ids=lambda claim: f'{claim.paragraph}: {claim.printed}')
def test_the_verdict_is_the_expected_one(claim):
    assert claim.paper == 'C'
    assert claim.verdict == claim.expected
    assert math.isfinite(claim.computed)
    assert (claim.expected == 'holds') == (claim.because == '')
    assert (claim.expected == 'misprint') == (claim.corrected_value is not None)


def test_they_stand_in_the_order_of_the_paper():
    first = [int(re.match(r'\d+', claim.paragraph).group()) for claim in CLAIMS]
    assert first == sorted(first)


def test_every_correction_of_the_print_is_there():
    """Counted are the paragraphs in the table of corrections, and the lines of each."""
    misprints = [claim.paragraph for claim in CLAIMS if claim.expected == 'misprint']
    assert misprints == [
        '5', '15', '17-21', '17-21', '19', '20', '22-23', '22-23', '32', '36', '37', '39', '44',
        '45', '46', '52', '53',
    ]  # fmt: skip


def test_the_formula_without_c_gives_the_negative_length_it_was_caught_by():
    (slow,) = [claim for claim in CLAIMS if claim.printed.startswith('b = ekk/(kk + cf − √')]
    assert slow.printed_value == pytest.approx(-0.0150, abs=5e-5)
    assert slow.computed == pytest.approx(0.458647575161926656834875439639, rel=1e-14)
