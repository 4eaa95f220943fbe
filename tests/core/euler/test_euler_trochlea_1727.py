"""Paper A: figures that the theory tells, and that a wrong value is noticed."""

import math
import re

import pytest

from tauto_core.euler import trochlea_1727
from tauto_core.euler.edition import G
from tauto_core.euler.trochlea_1727 import claims, period

CLAIMS = claims()


def test_figures_of_the_theory():
    # A in wheel.md: Q = 100 P loses 428.26 s/day at 1 rad, and §XX has 30° and 60°
    still, *wide = (
        period(each, carried=1.0 / G) for each in (1e-3, 1.0, math.pi / 6.0, math.pi / 3.0)
    )
    lost = [86400 * (1 - still / each) for each in wide]
    assert lost[0] == pytest.approx(428.26, abs=0.02)
    (weight,) = (claim for claim in CLAIMS if '469 in swings of 60°' in claim.said)
    assert [f'{each:.0f}' for each in lost[1:]] == re.findall(r'118|469', weight.said)
    assert weight.computed == pytest.approx(wide[2] / wide[1], rel=1e-12)
    radius = next(claim for claim in CLAIMS if claim.stands == 'BC = 63 scrup.')
    assert radius.computed == pytest.approx(63.32, rel=1e-9)


def test_a_wrong_value_is_noticed(monkeypatch):
    monkeypatch.setattr(trochlea_1727, 'inertia_of_rings', lambda q, radius: q * radius**2)
    assert any(claim.verdict != claim.expected for claim in claims())
