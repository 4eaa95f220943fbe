"""Euler's design rules in both directions, and the series of the period against amplitude."""

import json
import math
from fractions import Fraction
from pathlib import Path

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linear_cam_periods import (
    spring_period_excess,
    spring_period_series,
    weight_period_excess,
    weight_period_series,
)

from tauto_core.curves import Involute
from tauto_core.machines import Machine
from tauto_core.machines.design import (
    PARIS_LINE_M,
    SCRUPLE_M,
    complete,
    disc_inertia,
    length_of_period,
    length_of_thick_disc,
    radius_of_disc,
    weight_of_disc,
)
from tauto_core.scene.errors import UsageError
from tauto_core.scene.units import RHENISH_FOOT_M

GOLDEN = {
    entry['id']: entry
    for entry in json.loads((Path(__file__).parents[1] / 'golden.json').read_text())['entries']
}
positive = st.floats(1e-6, 1e6)


def params(name):
    return {key: float(item['value']) for key, item in GOLDEN[name]['params'].items()}


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


@pytest.mark.parametrize('name', [name for name in GOLDEN if name.startswith('A19-21-L')])
def test_large_disc_as_printed(name):
    given = params(name)
    length = length_of_thick_disc(given['Q'], given['a'], given['P'], given['r'])
    expected = float(GOLDEN[name]['expected']['L_if_Q_is_weight_of_small_disc'])
    assert length == pytest.approx(expected, rel=1e-14, abs=0.0)


def test_units():
    """The Prussian foot of 1816 is 139.13 Paris lines."""
    assert pytest.approx(139.13 * PARIS_LINE_M, rel=2e-5) == RHENISH_FOOT_M
    assert pytest.approx(0.31385e-3, rel=1e-15) == SCRUPLE_M
    assert pytest.approx(2.2558e-3, rel=2e-5) == PARIS_LINE_M


WEIGHTS = [name for name in GOLDEN if name.startswith('A20-weight-inertia')]


@pytest.mark.parametrize('name', WEIGHTS)
def test_excess_of_a_weight(name):
    given, expected = params(name), GOLDEN[name]['expected']
    eps = 2 * given['P_over_Q'] * (given['r'] / given['disc_radius'] * given['A']) ** 2
    assert eps == pytest.approx(float(expected['eps']), rel=1e-15, abs=0.0)
    excess = weight_period_excess(eps)
    assert excess == pytest.approx(float(expected['excess']), rel=1e-13, abs=0.0)
    if eps < 0.25:
        series = [float(term) * eps**n for n, term in enumerate(weight_period_series(20))]
        by_series = math.fsum(series[1:])
        assert by_series == pytest.approx(float(expected['excess']), rel=1e-13, abs=0.0)


def test_series_of_a_weight_is_the_printed_one():
    assert weight_period_series(4) == [
        1,
        *(Fraction(*term) for term in ((1, 4), (-3, 64), (5, 256), (-175, 16384))),
    ]


@pytest.mark.parametrize('order', [1, 2, 3, 5])
@pytest.mark.parametrize(
    ('series', 'excess'),
    [(weight_period_series, weight_period_excess), (spring_period_series, spring_period_excess)],
)
def test_order_of_the_series(series, excess, order):
    """Halving the argument divides the error by 2^(order + 1)."""
    with mpmath.workdps(40):
        errors = []
        for x in (mpmath.mpf(2) ** -10, mpmath.mpf(2) ** -11):
            if series is weight_period_series:
                exact = 2 / mpmath.pi * mpmath.ellipe(-x)
            else:
                exact = 2 / mpmath.pi * mpmath.ellipk(x / (2 * (1 + x))) / mpmath.sqrt(1 + x)
            terms = [mpmath.mpf(c.numerator) / c.denominator for c in series(order)]
            errors.append(exact - sum(c * x**n for n, c in enumerate(terms)))
            assert excess(float(x)) == pytest.approx(float(exact - 1), rel=1e-14)
        assert mpmath.log(errors[0] / errors[1], 2) == pytest.approx(order + 1, abs=2e-3)


@pytest.mark.parametrize('eta', [1e-12, 0.0499, 0.0501, 0.7, 30.0])
def test_excess_of_a_spring_is_the_machine(eta):
    rate, force, amplitude = 0.01, 2.0, 1.5
    stiffness = 2 * force * eta / (rate * amplitude**2)
    machine = Machine(
        4e-4, 0.0, 0.0, force, stiffness, 9.81, Involute(rate), False, None, None, 0.1
    )
    ratio = machine.period(amplitude) / machine.small_period
    assert spring_period_excess(eta) == pytest.approx(ratio - 1, rel=2e-14, abs=2e-15)
