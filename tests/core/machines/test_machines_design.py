"""Euler's design rules in both directions, and the series of the period against amplitude."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core import design
from tauto_core.scene.errors import UsageError

positive = st.floats(1e-6, 1e6)


@settings(max_examples=20)
@given(positive, positive, positive)
def test_three_numbers_give_the_fourth(inertia, pull, rate):
    whole = {'inertia': inertia, 'pull': pull, 'base_radius': rate}
    found = design(**whole, gravity=9.8)
    whole['period'] = math.tau * math.sqrt(inertia / (pull * rate))
    assert found.period_s == pytest.approx(whole['period'], rel=1e-14)
    assert found.pendulum_m == pytest.approx(9.8 * inertia / (pull * rate), rel=1e-14)
    for name, key in (
        ('inertia', 'inertia_kg_m2'),
        ('pull', 'pull_n'),
        ('base_radius', 'base_radius_m'),
    ):
        three = {other: value for other, value in whole.items() if other != name}
        assert getattr(design(**three), key) == pytest.approx(whole[name], rel=1e-14)


@pytest.mark.parametrize(
    ('given', 'said'),
    [
        ({}, 'Left out: period, inertia, pull, base radius'),
        ({'period': 1.0, 'inertia': 1.0, 'pull': 1.0, 'base_radius': 1.0}, 'Left out: none'),
        ({'period': 0.0, 'inertia': 1.0, 'pull': 1.0}, 'period = 0.0'),
        ({'period': 1.0, 'inertia': math.inf, 'pull': 1.0}, 'inertia = inf'),
    ],
)
def test_designs_that_are_none(given, said):
    with pytest.raises(UsageError, match=said):
        design(**given)
