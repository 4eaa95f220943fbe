"""What is expected of a scene, against what is then found."""

import math
from fractions import Fraction
from functools import lru_cache

import numpy as np
import pytest
import yaml
from numpy.polynomial import Polynomial

from tauto_core.clockwork import TrochleaStage
from tauto_core.machines import compile_machine
from tauto_core.samples import PHASE, SHIP_IMU
from tauto_core.scene import load_scene, parse_scene, scene_yaml
from tauto_core.ship import ShipMotion
from tauto_core.ship.interpolation import Pieces, polynomials
from tauto_core.voyage_cost import forecast, remainder


def changed(name, *, duration, rate=None, tolerance=None):
    content = yaml.safe_load(scene_yaml(load_scene(name, duration=duration)))
    if rate is not None:
        content['ship']['rate'] = rate
    if tolerance is not None:
        content['solver'] = {'tolerance': tolerance}
    return parse_scene(yaml.safe_dump(content), name)


def expected(scene):
    return forecast(scene, compile_machine(scene), ShipMotion(scene))


@lru_cache
def readings(scene):
    """Return half turns and their fraction at the logged instants."""
    stage, motion = TrochleaStage(scene), ShipMotion(scene)
    said = [stage.feed({SHIP_IMU: motion.produce(motion.total)}), stage.finish()]
    phase = np.concatenate([part[PHASE].position for part in said if PHASE in part])
    return phase[:, 1], phase[:, 2]


def apart_s(one, other):
    """Difference of two readings of a dial with a period of 1 s."""
    return 0.5 * ((one[0] - other[0]) + (one[1] - other[1]))


@pytest.mark.parametrize('name', ['involute_weight_at_sea', 'second_cam_at_sea'])
def test_the_sampling_error_is_that_between_coarse_and_fine_samples(name):
    """A factor of ten either way: the estimate leaves out phases and the start's bare side."""
    duration = 120.0
    fine = readings(changed(name, duration=duration, rate=50.0, tolerance=1e-15))
    for rate in (4.0, 5.0):
        scene = changed(name, duration=duration, rate=rate, tolerance=1e-15)
        found = np.std(apart_s(readings(scene), fine))
        assert 0.1 < found / expected(scene).steady_error_s < 10.0


@pytest.mark.parametrize('tolerance', [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize('name', ['involute_weight_at_sea', 'cheek_before_euler'])
def test_the_tolerance_bounds_the_growing_error(name, tolerance):
    duration = 120.0
    fine = readings(changed(name, duration=duration, tolerance=1e-15))
    scene = changed(name, duration=duration, tolerance=tolerance)
    found = np.max(np.abs(apart_s(readings(scene), fine))) / duration * 86_400.0
    # 2e-16 of a reading is what doubles can tell
    assert found <= expected(scene).growing_error_s_per_day + 2e-16 / duration * 86_400.0


@pytest.mark.parametrize('slopes', [False, True])
@pytest.mark.parametrize('samples', [1, 3])
def test_the_remainder_is_that_of_the_polynomials(samples, slopes):
    """Waves of 4 to 6 rad a sample by tenths, of all phases, fitted by the ship's own pieces."""
    count = 40
    stamps = np.arange(count, dtype=np.int64) * 10**9
    pieces = Pieces(np.array([16]), np.array([16 + samples]), np.array([True]))
    x = np.linspace(0.0, 1.0, 65)
    for turn in (0.4, 0.6):
        worst = 0.0
        for phase in np.linspace(0.0, math.pi, 16):
            wave = np.cos(turn * np.arange(count) + phase)
            rates = -turn * np.sin(turn * np.arange(count) + phase) if slopes else None
            (c,) = polynomials(stamps, wave, rates, pieces, stride=samples, offset=0)
            exact = np.cos(turn * (16 + samples * x) + phase)
            worst = max(worst, np.max(np.abs(Polynomial(c)(x) - exact)))
        bound = float(remainder(np.array(turn), samples, slopes=slopes))
        # a wave's derivative is not at its largest over the whole window
        assert 0.3 * bound < worst <= 1.01 * bound + 1e-15


def test_the_remainder_of_a_single_sample_is_that_of_the_interpolation():
    """In the middle (Ωh)⁸ (3/4)⁴/8! for roll, (Ωh)¹⁰ (945/32)²/10! for force."""
    roll = Fraction(3, 4) ** 4 / math.factorial(8)
    force = Fraction(945, 32) ** 2 / math.factorial(10)
    turn = np.array([0.5, 1.0])
    np.testing.assert_allclose(remainder(turn, 1, slopes=True), float(roll) * turn**8, 1e-14)
    np.testing.assert_allclose(remainder(turn, 1, slopes=False), float(force) * turn**10, 1e-14)


def test_closed_forms_do_not_drift_and_measured_motion_has_no_truth():
    ideal = expected(load_scene('ideal'))
    assert ideal.growing_error_s_per_day == 0.0
    assert ideal.steady_error_s < 1e-16
    assert ideal.shortest_wave_s is None
    assert expected(load_scene('measured')).steady_error_s is None


def test_cost_goes_with_what_is_done():
    day, week = (expected(load_scene('portsmouth_jamaica', duration=n * 86_400.0)) for n in (1, 7))
    start = expected(load_scene('portsmouth_jamaica', duration=60.0)).run_s
    assert (week.run_s - start) / (day.run_s - start) == pytest.approx(7.0, rel=0.01)
    assert expected(load_scene('ideal', duration=8_640_000.0)).run_s < day.run_s
