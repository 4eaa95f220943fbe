"""The predicted run time and error of a voyage, and the trial runs that find the error."""

import math
from functools import lru_cache
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tauto_core.checks.cost import (
    CHUNK,
    FIRST_CHUNK,
    RELEASED_APART,
    _finer_parts,
    _Growing,
    _Ran,
    extrapolated,
    forecast,
    try_out,
    work_s,
)
from tauto_core.clockwork import TrochleaStage
from tauto_core.machines import compile_machine
from tauto_core.samples import PHASE, SHIP_IMU
from tauto_core.scene import load_scene
from tauto_core.scene.errors import ABSENT, PropagationError
from tauto_core.ship import ShipMotion
from tauto_core.voyage import sail

EXACT = {'ship.rate': 20.0, 'solver.tolerance': 2e-12}


def changed(name, *, duration, rate=None, tolerance=None):
    return load_scene(
        name, duration=duration, **{'ship.rate': rate, 'solver.tolerance': tolerance}
    )


def expected(scene):
    return forecast(scene, compile_machine(scene))


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


@pytest.mark.parametrize(
    ('name', 'tolerance'),
    [('involute_weight_at_sea', 1e-6), ('involute_weight_at_sea', 1e-10),
     ('cheek_before_euler', 1e-8)],
)  # fmt: skip
def test_the_bound_of_a_tolerance_holds_within_thirty(name, tolerance):
    duration = 60.0
    fine = readings(changed(name, duration=duration, rate=50.0, tolerance=1e-15))
    scene = changed(name, duration=duration, tolerance=tolerance)
    found, predicted = np.max(np.abs(apart_s(readings(scene), fine))), expected(scene)
    assert found <= predicted.phase_error_s <= 30.0 * max(found, 1e-14)
    assert predicted.tried_s == duration


def test_the_bound_is_that_of_its_parts():
    scene = changed('involute_weight_at_sea', duration=60.0, rate=4.0, tolerance=1e-9)
    told = expected(scene)
    parts = told.sampling_error_s, told.steps_error_s, told.rounding_error_s
    assert told.phase_error_s == pytest.approx(sum(parts), rel=1e-15)
    assert told.error_s == pytest.approx(sum(parts) + 0.5e-9, rel=1e-12)
    assert all(part > 0.0 for part in parts)


@pytest.mark.parametrize('name', ['ideal', 'globe_in_oil', 'involute_weight_at_sea'])
def test_no_bound_is_below_a_nanosecond(name):
    told = expected(load_scene(name, duration=60.0, **EXACT))
    assert told.phase_error_s < 1e-11
    assert told.error_s == 1e-9


def test_closed_forms_err_by_period_and_rounding_only():
    ideal = expected(load_scene('ideal'))
    assert ideal.phase_error_s == ideal.rounding_error_s < 1e-15
    assert (ideal.sampling_error_s, ideal.steps_error_s, ideal.tried_s) == (None, 0.0, None)
    assert ideal.shortest_wave_s is None
    oil = expected(load_scene('globe_in_oil'))
    assert oil.steps_error_s == pytest.approx(1e-14 * 600.0)


def test_in_weather_the_waves_that_are_met_fastest_decide(monkeypatch):
    """30 days of a cork at 10 Hz differ by 4.3 µs from those at 20 and at 40 Hz."""
    monkeypatch.setattr('tauto_core.checks.cost.TRIAL_RUN_S', 0.1)
    monkeypatch.setattr('tauto_core.checks.cost.LONGEST_TRIAL_S', math.inf)
    rate, found_s = 10.0, 4.30e-6
    cork = {'ship.hull': ABSENT, 'ship.heave': True, 'ship.roll.slope_coefficient': 0.7}
    passage = {'duration': 8_208_060.0, 'voyage.arrives_at': 8_208_000.0, 'gravity': 9.80665}
    passage |= dict.fromkeys(('air', 'trochlea.material', 'drag.oil'), ABSENT)
    changes = {**cork, **passage, **EXACT, 'ship.rate': rate}
    told = expected(load_scene('portsmouth_jamaica', **changes))
    assert told.decided_by['why'] == 'met fastest'
    assert 1.1 < told.shortest_wave_s < 1.4
    assert found_s <= told.error_s <= 30.0 * found_s
    assert not told.growth.is_chaotic


# Without a hull the sea shakes the free wheel so that its motion is chaotic.
CORK = {
    'kind': 'sea',
    'sea': {'spectrum': 'bretschneider', 'significant_wave_height': 2.5, 'peak_period': 9.0},
    'roll': {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': 0.7},
    'heave': True,
    'height': 3.0,
    'rate': 20.0,
}
HALF_A_DAY = {
    'duration': 43_200.0,
    'log.motion': False,
    'drift.observation_interval': 3600.0,
    'ship': CORK,
}


def test_chaos_is_bounded_by_the_growth_that_was_measured(monkeypatch):
    monkeypatch.setattr('tauto_core.checks.cost.TRIAL_RUN_S', 0.4)
    scene = load_scene('involute_weight_at_sea', **HALF_A_DAY, **{'log.interval': 60.0})
    told = expected(scene)
    assert told.growth.is_chaotic
    assert 3000.0 < 1.0 / told.growth.per_s < 9000.0
    finer = {'log.interval': 60.0, 'ship': {**CORK, 'rate': 40.0}, 'solver.tolerance': 1e-12}
    fine = load_scene('involute_weight_at_sea', **HALF_A_DAY | finer)
    found = 1.005 * np.max(np.abs(apart_s(readings(scene), readings(fine))))
    assert found <= told.error_s <= 1e3 * found


def test_an_unbounded_error_has_the_time_of_its_bound(monkeypatch):
    monkeypatch.setattr('tauto_core.checks.cost.TRIAL_RUN_S', 0.2)
    week = {'duration': 604_800.0, 'log.motion': False, 'log.interval': 60.0, 'ship': CORK}
    told = expected(load_scene('involute_weight_at_sea', **week))
    assert told.error_s is None
    assert 20.0 < told.bounded_until_s / 3600.0 < 40.0


SLIP = {'trochlea.cam.base_radius': 5.0}
"""Millimetres for metres: the steps are far shorter than those laid out."""


def own_clock(monkeypatch, tick_s):
    """A clock of the test's own ticks once for a chunk of any length, and at the end."""
    ticks = map(tick_s.__mul__, count())
    clock = SimpleNamespace(thread_time=lambda: next(ticks))
    monkeypatch.setattr('tauto_core.checks.cost.time', clock)


def test_trials_that_cost_too_much_are_cut(monkeypatch):
    """Sailing ten minutes of it took 30 s of processor time, in 3.5 million steps."""
    own_clock(monkeypatch, 0.1)
    monkeypatch.setattr('tauto_core.checks.cost.LONGEST_TRIAL_S', 1.0)
    monkeypatch.setattr('tauto_core.checks.cost.COMPILING_S', 0.0)
    shares: list[float] = []
    scene = load_scene('measured', **SLIP)
    told = forecast(scene, compile_machine(scene), shares.append)
    assert told.was_cut
    assert told.tried_s < 0.5 * scene.duration
    assert shares == [1.0]
    assert 10.0 < told.run_s < 90.0


def test_measured_motion_is_taken_as_it_is_within_its_pass_band():
    told = expected(load_scene('measured', duration=60.0, **EXACT))
    assert 0.0 < told.sampling_error_s < 1e-11
    assert told.shortest_wave_s is None


@pytest.mark.parametrize(
    ('name', 'duration'),
    [('ideal', 864_000.0), ('globe_in_oil', 3600.0), ('axle_at_sea', 600.0), ('measured', 600.0)],
)
def test_the_run_time_scales_the_cost_of_the_beginning(monkeypatch, name, duration):
    own_clock(monkeypatch, 0.01)
    scene = load_scene(name, duration=duration)
    per_chunk = 0.01 * scene.samples / CHUNK, 0.01 * scene.samples / FIRST_CHUNK
    assert per_chunk[0] <= expected(scene).run_s <= 3.0 * per_chunk[1]


BENCHMARKS = Path(__file__).resolve().parents[3] / 'benchmarks'
DIAL = (1.0, 1e-15)
"""Period and rounding of the dial [s]."""


@pytest.mark.parametrize(
    ('kind', 'rate'),
    [('force', 1.0), ('weight', 2.0), ('hanging thread', 2.0), ('driven pendulum', 2.0),
     ('hung, driven hanging thread', 4.0)],
)  # fmt: skip
def test_the_bound_holds_within_a_factor_of_thirty(monkeypatch, kind, rate):
    """Scenes of `make stress`, shortened, at rates for which sampling makes the error."""
    monkeypatch.syspath_prepend(str(BENCHMARKS))
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
    """A bounded error stays, one that grows as √t, t or t² grows on as it did."""
    assert bound(1e-9 * np.sin(TIMES)) == pytest.approx(1e-9, rel=0.1)
    assert bound(1e-13 * TIMES) == pytest.approx(1e-13 * END_S, rel=1e-9)
    for power in (0.5, 2.0):
        assert bound(1e-15 * TIMES**power) >= 0.99e-15 * END_S**power
    assert bound(1e-17 * TIMES**2) == pytest.approx(1e-17 * END_S**2, rel=1e-6)


def test_a_slow_drift_under_a_bounded_error_is_seen():
    found = bound(1e-9 * np.sin(TIMES) + 1e-14 * TIMES)
    assert found >= 1e-14 * END_S
    assert found == pytest.approx(2e-9, rel=0.2)


def grown(logs):
    """The growth of a distance with these logarithms at `TIMES`."""
    apart = RELEASED_APART / math.pi * np.exp(logs)
    one = np.stack([np.zeros_like(apart), apart], axis=1)
    scene = load_scene('ideal', duration=TRIED_S, **{'log.interval': 10.0})
    return _Growing.of(_Ran(one, 0, False), _Ran(np.zeros_like(one), 0, False), scene)


def test_exponential_growth_is_told_from_powers_of_time():
    for power in (0.25, 1.0, 3.0):
        found = grown(power * np.log1p(TIMES)).found
        assert not found.is_chaotic
        assert found.grows == (power >= 1.0)
    assert not grown(np.full_like(TIMES, 3.0)).found.grows
    found = grown(TIMES / 1000.0).found
    assert found.is_chaotic
    assert 1.0 / found.per_s == pytest.approx(1000.0, rel=1e-6)
    assert found.per_s_sigma < 1e-9


def test_chaos_is_extrapolated_from_small_distances():
    """From 1e-11 rad to 0.1 rad a distance grows by e^23 and no more."""
    growing = grown(TIMES / 400.0)
    assert growing.found.followed_s == pytest.approx(400.0 * math.log(1e10), rel=0.01)
    assert math.log(growing.size_at(2.0 * TRIED_S)) == pytest.approx(2.0 * TRIED_S / 400.0)
    assert growing.time_of(math.exp(10.0), END_S) == pytest.approx(4000.0, abs=10.0)
    assert growing.time_of(math.exp(30.0), END_S) == pytest.approx(12_000.0, rel=1e-3)
    assert growing.time_of(math.exp(30.0), 11_000.0) is None


def test_scatter_of_the_growth_hastens_what_is_carried_on():
    steady, uneven = (grown(TIMES / 1000.0 + each) for each in (0.0, np.floor(TIMES / 3000.0)))
    assert uneven.found.per_s_sigma > 1e-4
    quickest = uneven.found.per_s + 2.0 * uneven.found.per_s_sigma
    both = [math.log(uneven.size_at(each)) for each in (TRIED_S, TRIED_S + 1000.0)]
    assert both[1] - both[0] == pytest.approx(1000.0 * quickest)
    assert steady.size_at(END_S) < uneven.size_at(END_S)


def test_what_starts_within_rounding_does_not_count_as_growth():
    error = np.where(TIMES > 0.5 * TRIED_S, 1e-15, 1e-19)
    assert bound(error) < 1e-13


def test_a_trial_of_the_whole_scene_is_not_extrapolated():
    error = 1e-12 * TIMES
    assert extrapolated(TIMES, error, TRIED_S, 1e-15) == error[-1]
    assert extrapolated(TIMES[:1], error[:1], END_S, 1e-15) == 0.0


def with_ship(name, duration, **ship):
    """The scene in a ship without a hull, which moves in waves of two seconds, too."""
    scene = load_scene(name, duration=duration)
    sea = scene.ship.sea.model_dump(exclude={'cutoff'}, exclude_unset=True)
    return load_scene(scene, ship=CORK | {'sea': sea} | ship)


def test_a_shorter_trial_bounds_what_the_whole_would():
    scene = with_ship('second_cam_at_sea', 1200.0, rate=2.0)
    part, whole = (try_out(scene, *DIAL, each, None) for each in (75.0, 1200.0))
    assert (part.tried_s, whole.tried_s) == (75.0, 1200.0)
    assert 0.33 * whole.sampling_error_s < part.sampling_error_s < 30.0 * whole.sampling_error_s


def test_a_long_log_interval_does_not_lengthen_the_trial():
    keys = dict.fromkeys(('duration', 'log.interval', 'drift.observation_interval'), 86_400.0)
    scene = load_scene('second_cam_at_sea', **keys)
    found = try_out(scene, *DIAL, 600.0, None)
    assert found.tried_s == pytest.approx(600.0, rel=0.05)
    assert found.sampling_error_s > 0.0


def test_the_bound_covers_the_jumps_of_a_case_in_rough_pivots():
    """When dry friction turns round, the force at the clock jumps, which samples round off."""
    hung = {'kind': 'gimbals', 'depth': 0.05, 'gyration_radius': 0.12, 'friction_angle': 0.02}
    rolls = {'amplitude': 0.1, 'period': 8.0, 'phase': 0.3}, {'amplitude': 0.05, 'period': 5.1}
    ship = {'kind': 'components', 'components': list(rolls), 'height': 3.0}
    keys = {'suspension': hung, 'log.interval': 0.5, 'solver.tolerance': 1e-9}

    def at_hz(rate):
        return load_scene(
            'involute_weight_at_sea', duration=15.0, ship=ship | {'rate': rate}, **keys
        )

    coarse = at_hz(4.0)
    found_s = np.max(np.abs(apart_s(readings(coarse), readings(at_hz(1000.0)))))
    assert 0.01 < found_s < expected(coarse).error_s < 30.0 * found_s


PRIME_NS = 15_383_227
"""A prime number of nanoseconds."""


@pytest.mark.parametrize(
    ('factor', 'parts'),
    [(1, None), (2, 2), (3, 3), (4, 4), (6, 6), (25, 5), (64, 4), (61, 61), (62, 31), (65, 5)],
)
def test_a_finer_run_has_steps_of_whole_nanoseconds(factor, parts):
    scene, step_ns = with_ship('second_cam_at_sea', 4.0), factor * PRIME_NS
    odd = scene.model_copy(update={'ship': scene.ship.model_copy(update={'rate': 1e9 / step_ns})})
    assert odd.step_ns == step_ns
    assert _finer_parts(odd) == parts


def test_a_step_without_divisors_has_no_bound():
    scene = with_ship('second_cam_at_sea', 4.0)
    ship = scene.ship.model_copy(update={'rate': 1e9 / PRIME_NS})
    log = scene.log.model_copy(update={'interval': PRIME_NS * 1e-9})
    odd = scene.model_copy(update={'ship': ship, 'log': log, 'duration': 4 * PRIME_NS * 1e-9})
    assert try_out(odd, *DIAL, 4.0, None).sampling_error_s is None


def test_a_motion_that_ends_early_is_tried_up_to_its_end():
    """The thread slackens within the first swings, which a trial does not judge."""
    heave = [{'amplitude': 40.0, 'period': 9.0, 'phase': 2.0}]
    ship = {'kind': 'components', 'components': [], 'heave': heave, 'rate': 20.0}
    keys = {'ship': ship, 'trochlea.slack': 'stop'}
    violent = load_scene('involute_weight_at_sea', duration=60.0, **keys)
    with pytest.raises(PropagationError, match='thread') as ended:
        sail(violent, anyway=True)
    assert 2.0 < ended.value.time_s < 60.0
    assert 0.0 < try_out(violent, *DIAL, 60.0, 2e-12).sampling_error_s < 1e-6


def test_work_counts_a_case_an_axle_and_the_duration():
    """It gives trials their length and ensembles their processes, on every machine alike."""
    cork = load_scene('involute_weight_at_sea')
    hung = {'kind': 'gimbals', 'depth': 0.05, 'gyration_radius': 0.12}
    assert work_s(load_scene(cork, suspension=hung)) > 2.0 * work_s(cork)
    assert work_s(load_scene('axle_at_sea', duration=cork.duration)) > 100.0 * work_s(cork)
    twice = load_scene('involute_weight_at_sea', duration=2.0 * cork.duration)
    assert work_s(twice) == pytest.approx(2.0 * work_s(cork), rel=1e-3)
