"""The projection of a short run: by hand, against the filter's own prediction, over seeds."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tauto_core.machines import compile_machine
from tauto_core.navigation import ClockModel, RateError, forgets_its_start, projection
from tauto_core.scene import load_scene
from tauto_core.voyage import sail

QUIET = ClockModel(0.5, 1e-4, white_fm_s=0.0, random_walk_fm_per_s=0.0)
KNOWN = {'rate_s_per_day': 0.75, 'rate_sigma_s_per_day': 0.5}


def sure(scatter: float) -> RateError:
    """Return a standard error that a run of no length has given."""
    return RateError(scatter, 0.0)


def test_a_rate_of_a_second_a_day_is_a_quarter_of_a_mile_a_day_on_the_equator() -> None:
    """The sun passes 15 arc minutes in a minute: 1 s/day for 42 days are 42 s, 10.5 miles."""
    found = projection(1.0, sure(0.25), KNOWN, QUIET, 0.0)
    six_weeks, jamaica = found['projection']
    assert found['not_projected'] is None
    assert (six_weeks['days'], jamaica['days']) == (42.0, 81.0)
    assert six_weeks['raw_error_nmi'] == pytest.approx(-10.5)
    assert six_weeks['error_nmi'] == pytest.approx(-0.25 * 10.5)
    assert six_weeks['raw_sigma_nmi'] == pytest.approx(0.25 * 10.5)
    assert jamaica['raw_error_nmi'] == pytest.approx(-81.0 / 4.0)
    at_sixty = projection(1.0, sure(0.25), KNOWN, QUIET, -60.0)['projection'][0]
    assert at_sixty['raw_error_nmi'] == pytest.approx(-10.5 / 2.0)


def test_the_corrected_clock_is_as_uncertain_as_the_run_in_which_it_was_rated() -> None:
    """The estimate errs by 0.5 s/day from a mean rate that errs by 0.25."""
    six_weeks = projection(1.0, sure(0.25), KNOWN, QUIET, 0.0)['projection'][0]
    assert six_weeks['sigma_nmi'] == pytest.approx(math.hypot(0.5, 0.25) * 10.5)


def test_a_rate_scatters_on_the_voyage_as_it_did_in_the_run() -> None:
    """A run as long as the voyage: the rates of both scatter alike, and their difference by √2."""
    found = projection(1.0, RateError(0.25, 42.0 * 86_400.0), KNOWN, QUIET, 0.0)['projection'][0]
    assert found['raw_sigma_nmi'] == pytest.approx(2.0**0.5 * 0.25 * 10.5)


def test_a_clock_that_is_known_exactly_still_gathers_noise() -> None:
    """White noise of the frequency: the phase walks by √(q₁ T), here 0.1 s √42. A random walk of
    the dial's rate by q₂ gives √(q₂ T³/3), and as much again where the mean rate is that of a run
    as long as the voyage, at whose end the rate has left it.
    """
    noisy = ClockModel(0.5, 1e-4, white_fm_s=0.1**2 / 86_400.0, random_walk_fm_per_s=0.0)
    known = {'rate_s_per_day': 0.0, 'rate_sigma_s_per_day': 0.0}
    found = projection(0.0, sure(0.0), known, noisy, 0.0)['projection'][0]
    assert found['sigma_nmi'] == pytest.approx(0.25 * 0.1 * 42.0**0.5)
    assert found['raw_sigma_nmi'] == 0.0
    walk = (0.1 / 86_400.0) ** 2 / 86_400.0
    for length_s, times in ((0.0, 1.0), (42.0 * 86_400.0, 2.0)):
        run = RateError(0.0, length_s)
        found = projection(0.0, run, known, noisy, 0.0, walk)['projection'][0]
        expected = 0.25 * 0.1 * (times * 42.0**3 / 3.0) ** 0.5
        assert found['raw_sigma_nmi'] == pytest.approx(expected)


@pytest.mark.parametrize(
    ('rate', 'scatter', 'said'),
    [
        (1_028.0, 1.0, None),
        (1_029.0, 1.0, 'the dial cannot be projected: after 42 days it is wrong by 43,218 s'),
        (-1_029.0, 1.0, 'the dial cannot be projected: after 42 days it is wrong by 43,218 s'),
        (0.0, 1_028.0, None),
        (0.0, 1_029.0, 'the dial cannot be projected from so short a run: after 42 days its ± is'),
    ],
)
def test_no_projection_goes_beyond_half_a_turn(rate: float, scatter: float, said: str) -> None:
    """Half a day, 43,200 s, in 42 days are 1028.6 s/day, wherever on the globe."""
    for latitude in (0.0, 60.0):
        found = projection(rate, sure(scatter), KNOWN, QUIET, latitude)
        first = found['projection'][0]
        assert (first['raw_error_nmi'] is None) == (said is not None)
        assert (first['raw_sigma_nmi'] is None) == (said is not None)
        assert found['projection'][1]['raw_error_nmi'] is None  # 81 days, wrong by more
        assert (said or 'after 81 days') in found['not_projected']


def test_an_unregulated_dial_is_left_out_and_its_corrected_clock_projected() -> None:
    rated = {'rate_s_per_day': -2_511.0, 'rate_sigma_s_per_day': 0.5}
    found = projection(-2_511.0, sure(0.0), rated, QUIET, 0.0)
    assert [row['raw_error_nmi'] for row in found['projection']] == [None, None]
    assert found['projection'][0]['sigma_nmi'] == pytest.approx(0.5 * 10.5)
    assert 'corrected' not in found['not_projected']


def test_without_the_error_of_the_rate_nothing_is_projected_and_the_reason_said() -> None:
    unknown = RateError(None, 3_600.0, 'cannot be projected: the swing dies away')
    assert projection(1.0, unknown, KNOWN, QUIET, 0.0) == {
        'projection': [],
        'not_projected': 'cannot be projected: the swing dies away',
    }


def why(name: str, length_s: float = 3_600.0, sigma: float | None = 1.0, **changed: Any) -> str:
    scene = load_scene(name).model_copy(update=changed)
    error = forgets_its_start(scene, compile_machine(scene), RateError(sigma, length_s))
    assert (error.standard_error_s_per_day is None) == bool(error.why_unknown or sigma is None)
    return error.why_unknown


@pytest.mark.parametrize(
    ('scene', 'reason'),
    [
        ('involute_weight_at_sea', 'nothing damps the wheel, on whose amplitude the rate depends'),
        ('hanging_thread_at_sea', 'nothing holds the swing of the thread'),
        ('clock_own_cam_weight', 'nothing damps the swing of the case, on which the rate depends'),
        ('second_cam_at_sea', ''),
        ('clock_second_cam_force', ''),
        ('sully_lever_at_sea', ''),
        ('portsmouth_jamaica', ''),
        ('ideal', ''),
        ('globe_in_oil', ''),
    ],
)
def test_a_rate_that_never_forgets_how_its_swing_began_is_not_known(
    scene: str, reason: str
) -> None:
    """Over 30 seeds the rates of the first three scatter by 5 to 13 times what runs show; an
    isochronous wheel has nothing to forget, and a held one forgets in a minute.
    """
    assert why(scene).startswith(f'cannot be projected: {reason}' if reason else '')
    assert bool(why(scene, sigma=None)) == bool(reason)


def test_on_land_a_swing_that_nothing_damps_goes_on_as_it_is() -> None:
    assert not why('involute_weight_at_sea', ship=load_scene('ideal').ship)


def test_what_the_amplitude_changes_by_less_than_the_rate_is_known_may_be_kept() -> None:
    """A tenth of the amplitude is 82 s/day on the involute."""
    assert why('involute_weight_at_sea', sigma=81.0)
    assert not why('involute_weight_at_sea', sigma=83.0)


def test_a_held_swing_is_forgotten_in_ten_time_constants() -> None:
    """2 J/c is 80 s for the amplitude, J/c 40 s for the energy."""
    assert why('sully_lever_at_sea', 399.0) == (
        'cannot be projected from so short a run: its rate depends on the amplitude, which takes '
        '6.7 minutes to settle. Sail longer'
    )
    assert not why('sully_lever_at_sea', 401.0)


def test_a_clock_that_will_stop_is_not_projected() -> None:
    assert 'the swing dies away' in why('sully_lever_at_sea', escapement=None)


def test_over_thirty_seeds_the_projected_errors_scatter_by_what_is_stated() -> None:
    """A scene whose rate depends on the seed and is projected. Jitter of the reading is most of
    it, so the ratio is expected near 1/√2.
    """
    found = [sail(load_scene('second_cam_at_sea', seed=k)).result['longitude'] for k in range(30)]
    first = [each['projection'][0] for each in found]
    errors = np.array([row['raw_error_nmi'] for row in first])
    stated = np.sqrt(np.mean([row['raw_sigma_nmi'] ** 2 for row in first]))
    assert 0.5 < np.std(errors, ddof=1) / stated < 2.0


def test_a_voyage_that_cannot_be_projected_says_so_and_has_no_standard_error() -> None:
    report = sail(load_scene('involute_weight_at_sea', duration=600.0)).result
    assert report['longitude']['projection'] == []
    assert 'nothing damps the wheel' in report['longitude']['not_projected']
    assert report['clock']['rate_standard_error_s_per_day'] is None
