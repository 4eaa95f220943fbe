"""Numerical stability: the rows of `make stress` that are quick."""

import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).resolve().parents[3] / 'benchmarks'


@pytest.fixture(scope='module', autouse=True)
def stress_modules():
    """The modules of the table, which import each other by name."""
    sys.path.insert(0, str(BENCHMARKS))
    yield
    sys.path.remove(str(BENCHMARKS))


def broken(rows):
    assert rows
    return [f'{row.name} ({row.setting}): {row.measured}' for row in rows if not row.holds]


def test_the_orders_are_sixteen_and_thirty_two_and_the_engine_is_the_method():
    from stress_motion import order

    assert not broken(order())


def test_swings_forward_and_back_end_at_the_release():
    from stress_motion import reversal

    assert not broken(reversal(swings=100))


def test_energy_and_phase_of_an_isochronous_well_walk_at_rounding_level():
    """Three runs of 2e4 oscillations: enough lags for the exponent within 0.15 of a half."""
    from stress_motion import isochronous

    assert not broken(isochronous(2e4, 3))


def test_impulses_that_are_too_strong_end_at_the_edge_of_the_cam():
    from stress_motion import escapement

    assert not broken(escapement())


def test_roll_at_resonance_and_at_commensurable_frequencies_has_its_exact_answer():
    from stress_motion import resonance

    assert not broken(resonance())
