"""Every claim of paper B: its verdict, the completeness of the list, and that a claim can fail."""

import math
from collections import Counter

import pytest

from tauto_core.euler import fluid_1729
from tauto_core.euler.fluid_1729 import BETA, CYLINDER, GAMMA, GLOBE, A, B, F, M, N, claims
from tauto_core.machines.sections import ImmersedBody

CLAIMS = claims()
# formulas that do not stand as they must be, in the paragraph in which each is met first
CORRECTED = {
    '12': 1, '14': 1, '15': 1, '16': 2, '17, 26': 1, '20-21': 1, '21': 1, '23': 1, '23, 28': 1,
    '23, 31': 1, '24': 3, '25': 1, '26': 2, '27': 4, '28': 2, '29': 2, '30': 3, '31': 1, '32': 4,
    '33': 2, '34': 3, '35': 1,
}  # fmt: skip


@pytest.mark.parametrize('claim', CLAIMS, ids=lambda c: f'{c.paragraph}: {c.claim}')
def test_the_verdict_is_the_expected_one(claim):
    assert claim.paper == 'B'
    assert claim.verdict == claim.expected
    assert bool(claim.because) == (claim.verdict in {'corrected', 'fails'})
    assert bool(claim.must) == (claim.verdict == 'corrected')


def test_every_formula_that_needs_a_correction_is_there():
    assert Counter(c.paragraph for c in CLAIMS if c.verdict == 'corrected') == CORRECTED


def test_the_claims_follow_the_paper():
    first = [int(claim.paragraph.split('-')[0].split(',')[0]) for claim in CLAIMS]
    assert first == sorted(first)
    assert set(first) == {2, *range(12, 36)}


def test_only_the_open_remark_fails_with_its_figures():
    failing = [claim for claim in CLAIMS if claim.verdict == 'fails']
    assert [claim.paragraph for claim in failing] == ['22']
    assert failing[0].value == 1.0
    # golden B22-reverse-q0.5
    assert failing[0].computed == pytest.approx(1.098430696839862, rel=1e-12)


def test_the_example_is_a_globe_of_a_tenth_in_its_letters():
    globe, cylinder = (ImmersedBody(shape, A, M, N) for shape in ('globe', 'cylinder'))
    assert (pytest.approx(globe.kappa), pytest.approx(globe.gamma)) == (GLOBE, GAMMA)
    assert pytest.approx(cylinder.kappa) == CYLINDER
    assert GAMMA * GLOBE * F == BETA


def test_the_checks_are_those_of_the_golden_machine():
    """The slope and height at half the cusp, golden B16-30-curve-g-nm0.1-a0.05-f1-s0.5."""
    s = 0.343875443518019837878410865842
    assert fluid_1729.slope(s) == pytest.approx(0.435878386006634751, rel=1e-13)
    assert fluid_1729.height(s) == pytest.approx(0.0717260798340021306, rel=1e-13)
    assert fluid_1729.speed_height(0.0) == B


def test_a_claim_on_another_curve_is_seen(monkeypatch):
    """With the curve for a body 1 % lighter most claims no longer hold."""
    monkeypatch.setattr(fluid_1729, 'GAMMA', 0.99 * GAMMA)
    spoilt = [c for c in fluid_1729.claims() if c.verdict != c.expected]
    assert len(spoilt) > 40


def test_the_quadrature_of_any_fall_does_not_depend_on_the_fall(monkeypatch):
    for fall in (1e-6, 2.0):
        monkeypatch.setattr(fluid_1729, 'B', fall)
        assert fluid_1729._time_of_any_fall() == pytest.approx(math.pi, rel=1e-12)
