"""The stages joined: the same figures from a run, its bag, and its readings alone."""

from __future__ import annotations

import math
import pickle
import re
import subprocess
import sys
import tracemalloc

import numpy as np
import pytest

from tauto_core import samples as s
from tauto_core import voyage
from tauto_core.bags import BagWriter, read_bag
from tauto_core.checks.readiness import check_scene
from tauto_core.machines.threads import HoleThread
from tauto_core.results import Summary
from tauto_core.scene import load_scene
from tauto_core.scene.errors import BagError, PropagationError, SceneError
from tauto_core.ship.motions.sea import SeaShip
from tauto_core.voyage import Pipeline, ShipSource, pipeline, replay, sail, summarise_bag


def written(folder, bag, *topics):
    """Return a bag of some topics of another."""
    with BagWriter(folder) as writer:
        writer.write({topic: bag.samples(topic) for topic in topics})
    return read_bag(folder)


@pytest.fixture(scope='module')
def measured(tmp_path_factory):
    """Two minutes of the default scene: its report and its bag."""
    out = tmp_path_factory.mktemp('voyage') / 'bag'
    scene = load_scene('measured', duration=120.0)
    return scene, sail(scene, out).result, out


def test_bag_and_replay_give_the_figures_of_the_run(measured):
    _, report, out = measured
    again = summarise_bag(out)
    assert {k: v for k, v in report.items() if k != 'wall_s'} == again
    figures = replay(read_bag(out)).result
    for part in ('clock', 'drift', 'longitude', 'duration_s'):
        assert figures[part] == report[part]


def test_a_bag_that_was_cut_short_has_its_own_length(measured):
    scene, _, out = measured
    bag = read_bag(out)
    again = replay(read_bag(out), scene.model_copy(update={'duration': 240.0}))
    length_s = again.result['duration_s']
    assert length_s == (bag.end_ns - bag.start_ns) / 1e9
    assert 120.0 < length_s < 121.0  # with the motion beyond the end


def test_the_estimate_is_held_against_dial_and_mean_rate(measured):
    _, report, _ = measured
    clock, drift = report['clock'], report['drift']
    # two minutes: the mean rate is the gain of the dial, which was set right at first
    assert drift['offset_s'] - drift['offset_error_sigmas'] * drift['offset_sigma_s'] == (
        pytest.approx(clock['error_s'], rel=1e-12)
    )
    assert drift['rate_s_per_day'] - drift['rate_error_sigmas'] * drift[
        'rate_sigma_s_per_day'
    ] == (pytest.approx(clock['error_s'] * 86_400.0 / 120.0, rel=1e-9))
    assert drift['rate_compared_s_per_day'] == clock['rate_s_per_day']
    assert drift['rate_compared_from_s'] == 0.0


def test_without_two_readings_there_is_no_true_rate(measured):
    scene, _, out = measured
    bag = read_bag(out)
    alone = Summary(scene)
    alone.feed({s.ESTIMATE: bag.samples(s.ESTIMATE)})
    assert not any(key.endswith('_sigmas') for key in alone.drift())
    alone.feed({s.READING: s.take(bag.samples(s.READING), slice(0, 1))})
    assert 'rate_error_sigmas' not in alone.drift()
    assert 'offset_error_sigmas' in alone.drift()


def test_the_rates_error_is_found_anew_from_later_readings():
    scene = load_scene('ideal', duration=14_400.0)
    stamps = scene.starts_at_ns + np.arange(scene.log_count) * scene.log_interval_ns
    noise = np.random.default_rng(1).normal(0.0, 1e6, len(stamps)).astype(np.int64)
    readings = s.TimeSamples(stamps, '', stamps + noise, s.same('', len(stamps)))
    asked, whole = Summary(scene), Summary(scene)
    whole.feed({s.READING: readings})
    found = []
    half = len(stamps) // 2
    for part in (slice(0, half), slice(half, None)):
        asked.feed({s.READING: s.take(readings, part)})
        found.append(asked.clock()['rate_standard_error_s_per_day'])
    assert found[0] > 0.0
    assert found[1] != found[0]
    assert found[1] == whole.clock()['rate_standard_error_s_per_day']


def test_machine_and_sea_are_built_once_a_run(monkeypatch):
    built = []

    def count(kind, name):
        make = getattr(kind, name)

        def counted(self, given):
            built.append(name)
            return make(self, given)

        monkeypatch.setattr(kind, name, counted)

    scene = load_scene('second_cam_at_sea', duration=10.0)  # looks at the sea to choose a rate
    count(HoleThread, 'machine')
    count(SeaShip, 'channels')
    sail(scene)
    assert sorted(built) == ['channels', 'machine']


def test_a_voyage_resumes_from_its_state_bit_for_bit():
    scene = load_scene('measured', duration=30.0)
    source, stages = ShipSource(scene), pipeline(scene)
    whole = stages.feed(source.produce(source.total))
    source, stages = ShipSource(scene), pipeline(scene)
    first = stages.feed(source.produce(251))
    state = pickle.loads(pickle.dumps((source.state(), stages.state())))
    source, stages = ShipSource(scene), pipeline(scene)
    source.restore(state[0])
    stages.restore(state[1])
    rest = stages.feed(source.produce(source.total))
    assert set(first) | set(rest) == set(whole)
    assert s.SCENE in first
    assert s.SCENE not in rest
    for topic in set(whole) - {s.SCENE}:
        joined = s.join([part[topic] for part in (first, rest) if topic in part])
        for name, value in vars(joined).items():
            if isinstance(value, np.ndarray) and value.dtype != object:
                assert value.tobytes() == getattr(whole[topic], name).tobytes(), (topic, name)


def test_the_landfall_is_judged_before_the_clock_is_checked(tmp_path):
    """Runs with and without the landfall's observation agree on the verdict, and so the bag."""
    way = {'departure': [50.0, -5.0], 'arrival': [49.9, -5.5], 'sails_at': 100.0}
    settings = {
        'log': {'interval': 10.0},
        'drift': {'observation_interval': 50.0, 'observation_sigma': 2.0},
    }
    scene = load_scene('ideal', duration=800.0, voyage={**way, 'arrives_at': 600.0}, **settings)
    report = sail(scene, tmp_path / 'bag').result
    landfall = report['longitude']
    assert landfall['at_s'] == 600.0
    [only] = landfall['landfalls']
    assert only['error_nmi'] == landfall['error_nmi']
    assert landfall['unchecked_days'] == 500.0 / 86_400.0
    ended = sail(scene.model_copy(update={'duration': 600.0})).result
    assert ended['longitude']['landfalls'] == []
    for name in ('at_s', 'error_nmi', 'sigma_nmi', 'raw_error_nmi', 'required_rate_s_per_day'):
        assert ended['longitude'][name] == landfall[name]
    # the check at 610 s shows in the estimate
    assert report['drift']['offset_sigma_s'] < 0.9 * ended['drift']['offset_sigma_s']
    assert summarise_bag(tmp_path / 'bag')['longitude'] == landfall
    assert replay(read_bag(tmp_path / 'bag')).result['longitude'] == landfall


def test_the_ideal_clock_on_land_keeps_true_time():
    """Allowed are the rounding of the nominal period, 1e-15 of a day, and a nanosecond of the
    dial.
    """
    report = sail(load_scene('ideal')).result
    assert report['propagator'] == 'harmonic'
    assert abs(report['clock']['error_s']) <= 1e-9
    assert report['longitude']['prize_pounds'] is None  # a day is no trial
    assert abs(report['longitude']['projection'][1]['raw_error_nmi']) <= 1e-7


def test_figures_agree_with_each_other(measured):
    scene, report, _ = measured
    clock, trochlea = report['clock'], report['trochlea']
    assert clock['error_s'] == pytest.approx(clock['reading_s'] - scene.duration, abs=2e-9)
    turned = trochlea['phase_rad'] / math.tau * scene.clock.nominal_period
    assert clock['reading_s'] == pytest.approx(turned, abs=2e-9)
    assert abs(trochlea['beats'] - trochlea['phase_rad'] / math.pi) <= 1
    # 15″ of longitude a second; fast is west (longitude.md)
    raw = report['longitude']['raw_error_arcmin']
    assert raw == pytest.approx(-clock['error_s'] / 4.0, abs=1e-12)


def test_a_drag_that_no_step_resolves_is_advised_against_on_land():
    given = {'ship': {'kind': 'still'}, 'duration': 60.0, 'drag.quadratic': 1e20}
    still = load_scene('hanging_thread_at_sea', **given)
    with pytest.raises(PropagationError, match=r'Reduce the drag, .*n a moving ship, raise'):
        sail(still)


@pytest.mark.parametrize('name', ['ideal', 'sully_lever_at_sea', 'hanging_thread_at_sea'])
def test_an_overdamping_drag_is_refused_with_its_limit(name):
    with pytest.raises(SceneError, match='it creeps') as caught:
        check_scene(load_scene(name, **{'drag.viscous': 1e3}))
    assert caught.value.key == 'drag.viscous'
    most = float(re.search(r'at most (\S+) N m s', caught.value.remedy)[1])
    check_scene(load_scene(name, **{'drag.viscous': 0.99 * most}))


def test_the_roll_at_the_start_counts_for_the_release():
    """A weight's thread hangs along the apparent vertical: 0.5 rad of roll and 1.2 of release."""
    roll = {'amplitude': 0.5, 'period': 9.0, 'phase': math.pi}
    given = {
        'ship': {'kind': 'components', 'components': [roll], 'height': 0.0},
        'trochlea.cam': {'kind': 'circular_arc', 'radius': 0.02, 'root_depth': 0.01},
        'trochlea.thread': {'kind': 'vertical'},
        'trochlea.power': {'kind': 'weight', 'mass': 0.2},
    }
    check_scene(load_scene('measured', **given, **{'trochlea.release_angle': math.pi - 0.51}))
    beyond = {'trochlea.release_angle': -math.pi + 0.49}
    with pytest.raises(SceneError, match='with the roll at the start the cam feels') as caught:
        check_scene(load_scene('measured', **given, **beyond))
    assert caught.value.key == 'trochlea.release_angle'


@pytest.mark.parametrize(
    ('changes', 'key', 'said'),
    [
        ({'clock': {'nominal_period': 1e10}}, 'clock.nominal_period', r'1e\+10 s on the dial'),
        ({'clock': {'nominal_period': 1e7}}, 'clock.nominal_period', r'reach 5\.99958e\+09 s'),
        ({'clock': {}, 'gravity': 1e-25}, 'trochlea', r's on the dial.*2147483647 s'),
    ],
)
def test_a_dial_that_leaves_the_times_of_ros_is_refused(changes, key, said):
    with pytest.raises(SceneError, match=said) as caught:
        check_scene(load_scene('measured', **changes))
    assert caught.value.key == key


def test_samples_that_cannot_be_integrated_end_the_voyage():
    """A height of 1e308 m times the roll's acceleration overflows. A checked scene has less."""
    ship = {'kind': 'components', 'components': [{'amplitude': 1.5, 'period': 1.0}]}
    trochlea = load_scene('ideal').trochlea.model_dump()
    checked = load_scene('measured', duration=5.0, ship=ship, trochlea=trochlea)
    scene = checked.model_copy(update={'ship': checked.ship.model_copy(update={'height': 1e308})})
    with (
        np.errstate(over='ignore', invalid='ignore'),
        pytest.raises(PropagationError, match='not_finite'),
    ):
        sail(scene, anyway=True)


def test_a_replay_says_what_it_does_without(measured, tmp_path):
    _, _, out = measured
    bag = read_bag(out)
    bare = written(tmp_path / 'bare', bag, s.SCENE, s.READING)
    observed, fixed = replay(bare).result['warnings']
    assert 'no topic clock/observation' in observed
    assert 'no topic ship/fix' in fixed
    assert replay(read_bag(out)).result['warnings'] == []


def test_a_bag_without_scene_needs_one(measured, tmp_path):
    scene, report, out = measured
    bag = read_bag(out)
    bare = written(tmp_path / 'bare', bag, s.READING)
    with pytest.raises(BagError, match='scene=SCENE'):
        replay(bare)
    assert replay(bare, scene=scene).result['clock'] == report['clock']
    with pytest.raises(BagError, match='clock/reading'):
        replay(written(tmp_path / 'empty', bag, s.SHIP_FIX), scene=scene)


def test_pipeline_reports_the_counters_of_its_stages():
    scene = load_scene('measured', duration=10.0)
    source, stages = ShipSource(scene), pipeline(scene)
    batch = source.produce(50)
    stages.feed(batch)
    stages.feed({s.SHIP_IMU: batch[s.SHIP_IMU]})
    assert stages.health() == {'duplicated': 1, 'out_of_order': 49}
    assert isinstance(stages, Pipeline)


def peak_bytes(hours, out):
    scene = load_scene('second_cam_at_sea', duration=3600.0 * hours, log={'motion': False})
    tracemalloc.start()
    try:
        sail(scene, out, force=True, keep=False)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_memory_does_not_grow_with_the_duration(tmp_path, monkeypatch):
    """2700 s more: keeping the motion would add 4.7 MB, logging a sample a second 800 kB."""
    monkeypatch.setattr(voyage, 'CHUNK', 2048)
    out = tmp_path / 'bag'
    sail(load_scene('second_cam_at_sea', duration=10.0))  # compiles and fills the caches
    short, long = peak_bytes(0.25, out), peak_bytes(1.0, out)
    assert long < short + 150_000


def test_a_replay_needs_no_motion_to_know_what_the_motion_added(tmp_path):
    """drift/estimate has the integrals, so the filter is exact from a bag without motion."""
    coefficients = {
        'heave': {'value': 1.0, 'sigma': 0.05},
        'roll': {'value': 0.01, 'sigma': 0.02},
    }
    drift: dict[str, object] = {
        'observation_interval': 30.0,
        'observation_sigma': 0.001,
        'gate': 1e9,
    }
    drift |= {'covariates': ['heave', 'roll'], 'coefficients': coefficients}
    log = {'interval': 5.0, 'motion': False}
    scene = load_scene('involute_weight_at_sea', duration=120.0, drift=drift, log=log)
    report = sail(scene, tmp_path / 'thin').result
    assert s.SHIP_IMU not in read_bag(tmp_path / 'thin')
    told = replay(read_bag(tmp_path / 'thin')).result
    assert told['drift'] == report['drift']
    assert not told['warnings']
    full = load_scene('involute_weight_at_sea', duration=120.0, drift=drift)
    assert sail(full, tmp_path / 'full').result['drift']['heave_integral_s'] == pytest.approx(
        report['drift']['heave_integral_s'], rel=1e-12
    )
    # a bag of readings and motion alone
    bag = read_bag(tmp_path / 'full')
    bare = written(tmp_path / 'bare', bag, s.SCENE, s.READING, s.SHIP_IMU, s.OBSERVATION)
    again = replay(bare).result['drift']
    assert again['heave_integral_s'] == pytest.approx(
        report['drift']['heave_integral_s'], rel=1e-9
    )
    blind = replay(written(tmp_path / 'blind', bag, s.SCENE, s.READING, s.OBSERVATION)).result
    assert blind['drift']['heave_integral_s'] == 0.0
    assert any('no topic ship/imu' in words for words in blind['warnings'])


# -----------------------------------------------------------------------------
# Kernels are compiled before a scene runs if others wait for its messages.

PROGRAM = """
from tauto_core.kernels import listening
from tauto_core.scene import load_scene
from tauto_core.voyage import compile_kernels, sail
scene, compiled = load_scene('involute_weight_at_sea', duration=600.0), []
with listening(lambda kernel, _left: compiled.append(kernel)):
    compile_kernels(scene)
    before = compiled.count(None)
    sail(scene, watch=lambda _: None)
print(before, compiled.count(None))
"""


def test_a_voyage_compiles_nothing_that_was_not_compiled_before(tmp_path, monkeypatch):
    monkeypatch.setenv('TAUTO_CACHE_DIR', str(tmp_path))
    run = subprocess.run(
        [sys.executable, '-c', PROGRAM], capture_output=True, text=True, check=True
    )
    before, after = map(int, run.stdout.split())
    assert before > 8
    assert after == before
