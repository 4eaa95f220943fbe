"""Euler's design rules in both directions, and the series of the period against amplitude."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tauto_core.machines.design import (
    complete,
    disc_inertia,
    length_of_period,
    radius_of_disc,
    units,
    weight_of_disc,
)
from tauto_core.scene.errors import UsageError
from tauto_core.scene.units import RHENISH_FOOT_M

positive = st.floats(1e-6, 1e6)


@given(positive, positive, positive)
def test_three_numbers_give_the_fourth(inertia, pull, rate):
    whole = complete(inertia=inertia, pull=pull, lever_rate=rate)
    assert whole.period == pytest.approx(math.tau * math.sqrt(inertia / (pull * rate)), rel=1e-14)
    for name in ('inertia', 'pull', 'lever_rate'):
        three = {k: getattr(whole, k) for k in ('period', 'inertia', 'pull', 'lever_rate')}
        del three[name]
        assert getattr(complete(**three), name) == pytest.approx(getattr(whole, name), rel=1e-14)
    assert length_of_period(whole.period, 9.8) == pytest.approx(
        whole.pendulum_length(9.8), rel=1e-14
    )


@pytest.mark.parametrize(
    ('given', 'said'),
    [
        ({}, 'left out: period, inertia, pull, base radius'),
        ({'period': 1.0, 'inertia': 1.0, 'pull': 1.0, 'lever_rate': 1.0}, 'left out: none'),
        ({'period': 0.0, 'inertia': 1.0, 'pull': 1.0}, 'period = 0.0'),
        ({'period': 1.0, 'inertia': math.inf, 'pull': 1.0}, 'inertia = inf'),
    ],
)
def test_designs_that_are_none(given, said):
    with pytest.raises(UsageError, match=said):
        complete(**given)


def test_discs():
    inertia = disc_inertia(3.0, 0.04, 9.81)
    assert weight_of_disc(inertia, 0.04, 9.81) == pytest.approx(3.0, rel=1e-15)
    assert radius_of_disc(inertia, 3.0, 9.81) == pytest.approx(0.04, rel=1e-15)


def test_units():
    """The Prussian foot of 1816 is 139.13 Paris lines."""
    assert units('line', 'N', 9.8)[0] * 139.13 == pytest.approx(RHENISH_FOOT_M, rel=2e-5)
    assert units('scruple', 'pound', 10.0) == pytest.approx((0.31385e-3, 4.895), rel=1e-15)
    assert units('line', 'g', 10.0) == pytest.approx((2.2558e-3, 0.01), rel=2e-5)
