"""Trial runs of a machine in small waves, against Mathieu's equation and other closed forms."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from tauto_core.navigation import clock_model, covariates
from tauto_core.navigation.covariates import (
    FITS,
    HEAVE,
    HEAVE_PERIODS_S,
    ROLL_PERIODS_S,
    SEA_S,
    Fit,
    fit,
    runs,
)
from tauto_core.navigation.kalman import ClockModel
from tauto_core.scene import parse_scene
from tauto_core.scene.errors import SceneError
from tauto_core.scene.sections import walk_per_s

SCENE = """
duration: 600.0
trochlea:
  inertia: 4.0e-4
  cam: {cam}
  thread: {thread}
  power: {power}
  release_angle: 1.0
ship:
  kind: sea
  sea: {{spectrum: bretschneider, significant_wave_height: 2.5, peak_period: 9.0}}
  roll: {{natural_period: 11.0, damping_ratio: 0.08, slope_coefficient: 0.7}}
  heave: true
  height: 3.0
  rate: 10.0
drift: {{observation_interval: 60.0, covariates: [{covariates}]{more}}}
log: {{interval: 1.0}}
"""
LINEAR = {
    'cam': '{kind: involute, base_radius: 0.010}',
    'thread': '{kind: vertical}',
    'power': '{kind: weight, mass: 0.16, massless: true}',
}
SECOND_CAM = {
    'cam': '{kind: hole, lever_rate: 0.010}',
    'thread': '{kind: hole, distance: 0.080}',
    'power': '{kind: force, force: 2.0}',
}
HANGING = {
    'cam': '{kind: involute, base_radius: 0.005}',
    'thread': '{kind: hanging, length: 1.0}',
    'power': '{kind: weight, mass: 0.322}',
}


def scene_of(machine, covariates='heave, roll', more=''):
    return parse_scene(SCENE.format(**machine, covariates=covariates, more=more), 'test')


def slow():
    """A ship whose motion is sampled twice a second."""
    return scene_of(SECOND_CAM).ship.model_copy(update={'rate': 2.0})


def mathieu(wave_s, swing_s):
    """Change of the frequency by that of a slow heave, -ε²/16, of y'' + ω²(1 + ε cos Ωt) y = 0.

    Characteristic exponent of Mathieu's equation, Abramowitz & Stegun 20.3.15.
    """
    a = (2.0 * wave_s / swing_s) ** 2
    q = 0.5 * a * HEAVE

    def left(nu):
        square = nu * nu
        fourth = (5.0 * square + 7.0) * q**4 / (32.0 * (square - 1.0) ** 3 * (square - 4.0))
        return square + q * q / (2.0 * (square - 1.0)) + fourth - a

    nu = brentq(left, 0.9 * math.sqrt(a), 1.1 * math.sqrt(a), xtol=1e-13)
    return (nu / math.sqrt(a) - 1.0) / (-(HEAVE**2) / 16.0)


def test_a_weight_on_a_linear_lever_is_mathieus():
    swing_s = math.tau * math.sqrt(4.0e-4 / (0.16 * 9.80665 * 0.010))
    heave, roll = runs(scene_of(LINEAR))
    assert tuple(heave.at_periods) == HEAVE_PERIODS_S
    for period_s, found in heave.at_periods.items():
        # a reading is told to a nanosecond, and the run is 46 waves long
        assert found == pytest.approx(mathieu(period_s, swing_s), rel=1e-4)
    # more than 1: the correction for waves that are not slow is (Ω/2ω)²
    mean = sum(mathieu(each, swing_s) for each in HEAVE_PERIODS_S) / len(HEAVE_PERIODS_S)
    assert heave.coefficient.value == pytest.approx(mean, rel=1e-4)
    assert 0.05 < heave.coefficient.sigma < 0.06
    assert tuple(roll.at_periods) == ROLL_PERIODS_S
    for period_s, found in roll.at_periods.items():
        # the sway at the clock adds <y''²>/(4 g²), met twice a wave: another (Ω/ω)²
        sway = 3.0 * (math.tau / period_s) ** 2 / 9.80665
        assert found == pytest.approx(0.25 * sway * sway, rel=0.05)


def test_a_force_does_not_feel_the_sea():
    for found in runs(scene_of(SECOND_CAM)):
        assert list(found.at_periods.values()) == pytest.approx(
            [0.0] * len(found.at_periods), abs=1e-9
        )


def test_what_a_scene_states_is_not_tried():
    more = ', coefficients: {roll: {value: 0.25, sigma: 0.125}}'
    scene = scene_of(LINEAR, more=more)
    assert [found.name for found in runs(scene)] == ['heave']
    heave, roll = clock_model(scene).coefficients
    assert roll == ('roll', 0.25, 0.125)
    assert heave.value == pytest.approx(1.02, abs=0.02)


def test_waves_that_the_motion_does_not_show_are_not_tried():
    (heave,) = runs(scene_of(SECOND_CAM, 'heave').model_copy(update={'ship': slow()}))
    assert tuple(heave.at_periods) == (6.0, 9.0)


@pytest.mark.parametrize(
    ('covariates', 'more', 'words'),
    [
        ('heave, heave', '', 'names heave twice'),
        ('roll', ', coefficients: {heave: {value: 1.0, sigma: 0.1}}', 'does not name heave'),
        ('pitch', '', "'heave' or 'roll'"),
        ('heave', ', coefficients: {heave: {value: 1.0, sigma: 0.0}}', 'sigma'),
    ],
)
def test_impossible_covariates_are_refused_by_name(covariates, more, words):
    with pytest.raises(SceneError, match=words):
        scene_of(LINEAR, covariates, more)


@pytest.mark.parametrize('machine', [LINEAR, SECOND_CAM], ids=['weight', 'force'])
def test_an_equation_that_explains_the_rate_departs_by_less_than_its_priors(machine):
    scene = scene_of(machine)
    found = fit(scene, tuple(each.coefficient for each in runs(scene)))
    assert found.sigmas < 0.5
    assert len(clock_model(scene).coefficients) == 2


def test_a_clock_that_no_rate_equation_fits_is_refused_with_what_covers_it():
    """The sea swings the thread, which no regressor sees."""
    with pytest.raises(SceneError, match='no rate equation fits this machine') as caught:
        clock_model(scene_of(HANGING))
    assert caught.value.key == 'drift.covariates'
    key, _, advised = caught.value.remedy.rstrip('.').rpartition(': ')
    assert key.endswith('drift.random_walk_fm')
    # with the random walk that the refusal names the scene is accepted and expects it
    walking = scene_of(HANGING, more=f', random_walk_fm: {float(advised)}')
    assert clock_model(walking).random_walk_fm_per_s == walk_per_s(float(advised))
    # a little less is refused as before
    with pytest.raises(SceneError, match='no rate equation'):
        clock_model(scene_of(HANGING, more=f', random_walk_fm: {0.9 * float(advised)}'))


def test_stated_coefficients_are_not_tested():
    more = ', coefficients: {heave: {value: 1.0, sigma: 0.05}, roll: {value: 0.0, sigma: 0.1}}'
    assert len(clock_model(scene_of(HANGING, more=more)).coefficients) == 2


def test_the_departure_is_in_sigmas_of_the_priors():
    scene = scene_of(LINEAR, 'heave')
    (tried,) = (each.coefficient for each in runs(scene))
    # a wrong coefficient departs by its error over its sigma, whatever the seas
    wrong = tried._replace(value=tried.value + 4.0 * tried.sigma)
    assert fit(scene, (wrong,)).sigmas == pytest.approx(4.0, abs=0.3)
    assert FITS < 4.0


def test_the_walk_is_the_one_that_bends_the_error_as_much(monkeypatch):
    """An error c t² bends by 2 c τ² in two times τ; a walk of density q by √(2/3 q τ³)."""

    class Bent:
        def __init__(self, _scene, length_s):
            self.at_s = np.linspace(0.0, length_s, 181)

        def error_s(self, ship, _seed=0):
            return 3.0 + ship.is_random * 1e-9 * self.at_s**2

    monkeypatch.setattr(covariates, '_Run', Bent)
    covariates._fit.cache_clear()
    tau_s = 0.5 * SEA_S
    q = (2.0 * 1e-9 * tau_s**2) ** 2 / (2.0 / 3.0 * tau_s**3)
    found = fit(scene_of(HANGING), ())
    covariates._fit.cache_clear()
    assert found.random_walk_fm == pytest.approx(86_400.0 * math.sqrt(q * 86_400.0), rel=1e-9)


def test_white_noise_that_bends_the_error_as_much_is_expected_too():
    tau_days, found = 0.5 * SEA_S / 86_400.0, Fit(9.0, 100.0)
    enough = 100.0 * tau_days / math.sqrt(3.0)
    for white_fm, expected in ((1.01 * enough, True), (0.99 * enough, False)):
        model = ClockModel(0.5, 1e-2, white_fm_s=white_fm**2 / 86_400.0)
        assert found.is_expected(model) is expected
        assert found.is_expected(model, factor=1.1)


@pytest.mark.parametrize(
    ('found', 'said'), [(124.7, 130.0), (25.0, 25.0), (2402.8, 2500.0), (0.0171, 0.018)]
)
def test_a_random_walk_is_advised_in_two_digits_and_never_too_small(found, said):
    assert Fit(9.0, found).advised == pytest.approx(said, rel=1e-12)
    assert Fit(9.0, found).advised >= found
