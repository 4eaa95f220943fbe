"""The projection of a short run, by hand and against the filter's own prediction."""

from __future__ import annotations

import pytest

from tauto_core.navigation import ClockModel, projection


def run(rate: float, scatter: float | None = None) -> dict[str, float | None]:
    return {'rate_s_per_day': rate, 'rate_standard_error_s_per_day': scatter}


def test_a_rate_of_a_second_a_day_is_a_quarter_of_a_mile_a_day_on_the_equator() -> None:
    """The sun passes 15 arc minutes in a minute: 1 s/day for 42 days are 42 s, 10.5 miles."""
    quiet = ClockModel(0.5, 1e-4, white_fm_s=0.0, random_walk_fm_per_s=0.0)
    known = {'rate_s_per_day': 0.75, 'rate_sigma_s_per_day': 0.5}
    six_weeks, jamaica = projection(run(1.0, 0.25), known, quiet, 0.0)
    assert (six_weeks['days'], jamaica['days']) == (42.0, 81.0)
    assert six_weeks['raw_error_nmi'] == pytest.approx(-10.5)
    assert six_weeks['error_nmi'] == pytest.approx(-0.25 * 10.5)
    assert six_weeks['sigma_nmi'] == pytest.approx(0.5 * 10.5)
    assert six_weeks['raw_sigma_nmi'] == pytest.approx(0.25 * 10.5)
    assert jamaica['raw_error_nmi'] == pytest.approx(-81.0 / 4.0)
    at_sixty = projection(run(1.0), known, quiet, -60.0)
    assert at_sixty[0]['raw_sigma_nmi'] is None
    assert at_sixty[0]['raw_error_nmi'] == pytest.approx(-10.5 / 2.0)
    assert at_sixty[0]['sigma_nmi'] == pytest.approx(0.25 * 10.5)


def test_a_clock_that_is_known_exactly_still_gathers_noise() -> None:
    """White noise of the frequency: the phase walks by √(q₁ T), here 0.1 s √42."""
    noisy = ClockModel(0.5, 1e-4, white_fm_s=0.1**2 / 86_400.0, random_walk_fm_per_s=0.0)
    known = {'rate_s_per_day': 0.0, 'rate_sigma_s_per_day': 0.0}
    assert projection(run(0.0), known, noisy, 0.0)[0]['sigma_nmi'] == pytest.approx(
        0.25 * 0.1 * 42.0**0.5
    )
