"""The claims of paper A: each gets the expected verdict, from independent evidence."""

import math

import pytest

from tauto_core.euler import trochlea_1727
from tauto_core.euler.trochlea_1727 import claims

CLAIMS = claims()
NUMERALS = {'I': 1, 'V': 5, 'X': 10, 'L': 50}


def number(numeral):
    values = [NUMERALS[letter] for letter in numeral]
    signs = [1 if a >= b else -1 for a, b in zip(values, [*values[1:], 0], strict=True)]
    return sum(sign * value for sign, value in zip(signs, values, strict=True))


@pytest.mark.parametrize('claim', CLAIMS, ids=lambda claim: f'{claim.paragraph} {claim.claim}')
def test_verdict(claim):
    assert claim.paper == 'A'
    assert claim.verdict == claim.expected
    if claim.expected in {'holds', 'added'}:
        assert claim.because == ''
        assert claim.must_value is None
    else:
        assert claim.because
    if claim.expected == 'corrected':
        assert claim.must
        # the correction agrees far better than the print
        assert abs(claim.must_value - claim.computed) < 1e-6 * abs(claim.computed)


def test_paragraphs_in_order():
    first = [number(claim.paragraph.split('-')[0]) for claim in CLAIMS]
    assert first == sorted(first)
    assert set(first) >= {
        7,
        8,
        10,
        12,
        20,
        21,
        30,
    }


def test_every_formula_that_needs_a_correction_is_there():
    """The paragraphs are VII, XIII, XVIII twice, XIX, XXI, XXVI twice and XXVII."""
    corrected = [claim.paragraph for claim in CLAIMS if claim.expected == 'corrected']
    assert corrected == ['VII', 'XIII', 'XVIII', 'XVIII', 'XIX', 'XXI', 'XXVI', 'XXVI', 'XXVII']
    lost = [claim for claim in CLAIMS if math.isnan(claim.value)]
    assert len(lost) == 6


def test_figures_that_the_theory_tells():
    (weight,) = (claim for claim in CLAIMS if claim.expected == 'fails')
    # A in wheel.md: Q = 100 P loses 428.26 s/day at 1 rad
    assert 86400 * (1 - 1 / weight.computed) == pytest.approx(428.26, abs=0.02)
    radius = next(claim for claim in CLAIMS if claim.stands == 'BC = 63 scrup.')
    assert radius.computed == pytest.approx(63.32, rel=1e-9)


def test_a_wrong_value_is_noticed(monkeypatch):
    monkeypatch.setattr(trochlea_1727, 'inertia_of_rings', lambda q, radius: q * radius**2)
    assert any(claim.verdict != claim.expected for claim in claims())
