"""Paper B: its example, its one question, its reference values, and that a claim can fail."""

import math

import pytest

from tauto_core.euler import fluid_1729
from tauto_core.euler.fluid_1729 import BETA, CYLINDER, GAMMA, GLOBE, A, B, F, M, N, claims
from tauto_core.machines.sections import ImmersedBody

CLAIMS = claims()


def test_the_question_of_the_paper_is_answered_with_its_figure():
    (question,) = (claim for claim in CLAIMS if claim.question)
    assert (question.paragraph, question.verdict, question.value) == ('22', 'answered', 1.0)
    # golden B22-reverse-q0.5
    assert question.computed == pytest.approx(1.098430696839862, rel=1e-12)


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
