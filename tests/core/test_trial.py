"""The predicted error of a scene bounds the actual one by independent programs, within thirty."""

import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from tauto_core.scene import load_scene, parse_scene, scene_yaml
from tauto_core.scene.errors import PropagationError
from tauto_core.trial import Dial, extrapolated, try_out
from tauto_core.voyage import sail

BENCHMARKS = Path(__file__).resolve().parents[2] / 'benchmarks'
DIAL = Dial(nominal_s=1.0, rounding_s=1e-15)


@pytest.fixture(scope='module', autouse=True)
def stress_modules():
    """The modules of the stress table, which import each other by name."""
    sys.path.insert(0, str(BENCHMARKS))
    yield
    sys.path.remove(str(BENCHMARKS))


@pytest.mark.parametrize(
    ('kind', 'rate'),
    [
        ('force', 1.0),
        ('weight', 2.0),
        ('weight, drag, escapement', 1.0),
        ('lever', 2.0),
        ('hanging thread', 2.0),
        ('hung, force', 4.0),
    ],
)
def test_the_error_predicted_bounds_the_error_found_within_a_factor_of_thirty(kind, rate):
    """The scenes are some of the hundred of `make stress`, shortened, at rates at which the
    error is that of sampling.
    """
    from stress_forecast import FACTOR, TOLD_S, compared, drawn

    (scene,) = drawn(1, (kind,), (rate,))
    scene = scene.model_copy(update={'duration': 8.0})
    found = compared(scene)
    assert found.found_s > 10.0 * TOLD_S
    assert found.found_s <= found.predicted_s <= FACTOR * found.found_s


TIMES = np.arange(1025) * 10.0
TRIED_S, END_S = 10_240.0, 102_400.0


def bound(error):
    return extrapolated(TIMES, error, END_S, 1e-15)


def test_errors_grow_on_as_they_did():
    """A bounded error stays; one that grows as √t, t or t² grows on as it did."""
    assert bound(1e-9 * np.sin(TIMES)) == pytest.approx(1e-9, rel=0.1)
    assert bound(1e-13 * TIMES) == pytest.approx(1e-13 * END_S, rel=1e-9)
    for power in (0.5, 2.0):
        assert bound(1e-15 * TIMES**power) >= 0.99e-15 * END_S**power
    assert bound(1e-17 * TIMES**2) == pytest.approx(1e-17 * END_S**2, rel=1e-6)


def test_a_slow_drift_under_a_bounded_error_is_seen():
    found = bound(1e-9 * np.sin(TIMES) + 1e-14 * TIMES)
    assert found >= 1e-14 * END_S
    assert found == pytest.approx(2e-9, rel=0.2)


def test_exponential_growth_is_carried_on_to_what_cannot_be_predicted():
    error = 1e-14 * np.exp(TIMES / 1000.0)
    whole = 1e-14 * np.exp(12_000.0 / 1000.0)
    assert extrapolated(TIMES, error, 12_000.0, 1e-15) == pytest.approx(whole, rel=0.1)
    assert bound(error) == END_S


def test_what_starts_within_rounding_does_not_count_as_growth():
    error = np.where(TIMES > 0.5 * TRIED_S, 1e-15, 1e-19)
    assert bound(error) < 1e-13


def test_a_trial_that_lasts_as_long_as_the_scene_extrapolates_nothing():
    error = 1e-12 * TIMES
    assert extrapolated(TIMES, error, TRIED_S, 1e-15) == error[-1]
    assert extrapolated(TIMES[:1], error[:1], END_S, 1e-15) == 0.0


def changed(name, duration, **ship):
    content = yaml.safe_load(scene_yaml(load_scene(name, duration=duration)))
    content['ship'] |= ship
    return parse_scene(yaml.safe_dump(content), name)


def test_a_shorter_trial_bounds_what_the_whole_would():
    scene = changed('second_cam_at_sea', 1200.0, rate=2.0)
    part, whole = (try_out(scene, DIAL, each, None) for each in (75.0, 1200.0))
    assert (part.tried_s, whole.tried_s) == (75.0, 1200.0)
    assert 0.33 * whole.sampling_s < part.sampling_s < 30.0 * whole.sampling_s


def test_a_step_without_divisors_is_not_tried_finer():
    """A step of a second less 63 ns is a prime number of nanoseconds."""
    prime_ns = 999_999_937
    scene = changed('second_cam_at_sea', 4.0)
    ship = scene.ship.model_copy(update={'rate': 1e9 / prime_ns})
    log = scene.log.model_copy(update={'interval': prime_ns * 1e-9})
    odd = scene.model_copy(update={'ship': ship, 'log': log, 'duration': 4 * prime_ns * 1e-9})
    assert odd.step_ns == prime_ns
    assert try_out(odd, DIAL, 4.0, None).sampling_s is None


def test_a_motion_that_ends_early_is_tried_up_to_its_end():
    """Released where the thread slackens within the first swings, which a trial does not judge."""
    scene = changed('involute_weight_at_sea', 60.0)
    heave = [{'amplitude': 40.0, 'period': 9.0, 'phase': 2.0}]
    rolling = {'kind': 'components', 'components': [], 'heave': heave, 'rate': 20.0}
    content = yaml.safe_load(scene_yaml(scene)) | {'ship': rolling}
    violent = parse_scene(yaml.safe_dump(content), 'violent')
    with pytest.raises(PropagationError, match='thread') as ended:
        sail(violent)
    assert 2.0 < ended.value.time_s < 60.0
    assert 0.0 < try_out(violent, DIAL, 60.0, 2e-12).sampling_s < 1e-6
