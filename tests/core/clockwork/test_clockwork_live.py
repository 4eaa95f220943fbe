"""The trochlea on a live sensor: faults of the sensor do not disturb the dial and are reported."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core.clockwork import DialSetting, LiveTrochlea, TrochleaStage
from tauto_core.clockwork.live import MOST_HELD, Limits
from tauto_core.clockwork.trochlea import nominal_period_s
from tauto_core.machines import compile_machine
from tauto_core.navigation import DriftStage, LongitudeStage
from tauto_core.navigation.covariates import clock_model
from tauto_core.navigation.drift import RELEASE_SIGMA
from tauto_core.navigation.kalman import prior
from tauto_core.navigation.longitude import Route
from tauto_core.samples import (
    CORRECTED,
    ESTIMATE,
    JOINT_STATES,
    LONGITUDE_ERROR,
    OBSERVATION,
    READING,
    SHIP_IMU,
    ImuSamples,
    JointSamples,
    TimeSamples,
    join,
    merged,
    same,
    take,
)
from tauto_core.scene import load_scene
from tauto_core.scene.errors import PropagationError
from tauto_core.ship.imu import imu_from_roll, mounted, quaternion_of_angles

SCENE = load_scene('measured')
START_NS = 1_700_000_000 * 10**9
NATURAL_S = 0.15
"""By so much the dial of the clean run below goes wrong in half a minute, whatever the start."""


def sensor(
    seconds: float = 30.0, rate_hz: float = 50.0, first: float = 0.0, noise: float = 1.0
) -> ImuSamples:
    """A ship that rolls 0.2 rad in 8 s, with the noise of a good sensor."""
    n = round(seconds * rate_hz)
    t = first + np.arange(n) / rate_hz
    rng = np.random.default_rng(n)
    roll = 0.2 * np.sin(np.pi / 4 * t) + 1e-3 * noise * rng.standard_normal(n)
    rate = 0.05 * np.pi * np.cos(np.pi / 4 * t) + 1e-3 * noise * rng.standard_normal(n)
    forces = 9.81 * np.array([np.sin(roll), np.cos(roll)])
    stamps = START_NS + np.rint(t * 1e9).astype(np.int64)
    return imu_from_roll(
        stamps, roll, rate, *(forces + 0.02 * noise * rng.standard_normal((2, n)))
    )


def quiet(rate_hz: float, seconds: float = 120.0) -> ImuSamples:
    return sensor(seconds, rate_hz, noise=0.0)


def said_of(stage, parts: Sequence[ImuSamples]):
    """All output of a stage for its motion, by topic."""
    return merged([*(stage.feed({SHIP_IMU: part}) for part in parts), stage.finish()])


def setting_of(reading: TimeSamples) -> DialSetting:
    """The last setting of the dial that readings tell."""
    setting = DialSetting.of(str(reading.source[-1]))
    assert setting is not None
    return setting


def errors_s(reading: TimeSamples):
    return (reading.time_ref_ns - reading.stamp_ns) * 1e-9


def test_a_clean_sensor_moves_the_wheel_as_without_guards():
    """To the bit; a reading looks ahead by a straight line, through noise of 20 Hz."""
    guarded, plain = LiveTrochlea(SCENE), TrochleaStage(SCENE, anchor='first')
    early, late = (stage.feed({SHIP_IMU: sensor(rate_hz=20.0)}) for stage in (guarded, plain))
    np.testing.assert_equal(guarded.state()['stage'], plain.state())
    errors = [errors_s(one[READING])[: len(late[READING].stamp_ns)] for one in (early, late)]
    assert np.abs(errors[0] - errors[1]).max() < 2e-3
    assert set(early[READING].source) == {'dial, set 1700000000.000000000 s'}


@pytest.mark.parametrize('rate_hz', [20.0, 173.0])
def test_a_reading_comes_with_the_first_sample_past_it(rate_hz: float):
    """And agrees with a clock that waits for samples of 200 Hz on either side."""
    stage, imu = LiveTrochlea(SCENE), quiet(rate_hz, 30.0)
    fast = errors_s(
        said_of(
            TrochleaStage(load_scene(SCENE, **{'ship.rate': 200.0}), 'first'), [quiet(200.0, 30.0)]
        )[READING]
    )
    stage.feed({SHIP_IMU: take(imu, imu.stamp_ns < START_NS + 3.5e9)})
    for number in np.flatnonzero(imu.stamp_ns >= START_NS + 3.5e9).tolist():
        reading = stage.feed({SHIP_IMU: take(imu, slice(number, number + 1))}).get(READING)
        passed = imu.stamp_ns[number - 1 : number + 1] // 10**9
        assert (reading is not None) == (passed[0] < passed[1])
        if reading is not None:
            assert errors_s(reading) == pytest.approx(
                fast[passed[1] - START_NS // 10**9], abs=1e-4
            )


@pytest.mark.parametrize(('gap_us', 'first'), [(0, 500), (300, 0), (8_000, 500)])
def test_a_burst_of_late_stamps_does_not_move_the_wheel(gap_us: int, first: int):
    """0.8 s of samples have the stamps at which they were sent."""
    imu, burst = sensor(), slice(first, first + 40)
    stamps = imu.stamp_ns.copy()
    stamps[burst] = stamps[first + 40] - 1000 * gap_us * np.arange(40, 0, -1)
    stage = LiveTrochlea(SCENE)
    said = said_of(stage, [replace(imu, stamp_ns=stamps)])
    assert np.abs(said[JOINT_STATES].position).max() < 1.3
    assert np.abs(errors_s(said[READING])).max() < NATURAL_S
    assert stage.health()['dial_stops'] == 0


IMU, TWICE = sensor(rate_hz=20.0), np.sort(np.r_[0:600, 0:600:5])


def with_wrong_stamp(ahead_s: float) -> ImuSamples:
    wrong = take(IMU, slice(250, 251))
    wrong = replace(wrong, stamp_ns=wrong.stamp_ns + round(ahead_s * 1e9))
    return join([take(IMU, slice(0, 300)), wrong, take(IMU, slice(300, None))])


@pytest.mark.parametrize(
    ('dirty', 'expected'),
    [
        (with_wrong_stamp(-5.0), {'out_of_order': 1}),
        (with_wrong_stamp(1e6), {'stamps_ahead': 1}),
        (take(IMU, TWICE), {'duplicated': 120}),
    ],
)
def test_a_wrong_stamp_and_what_comes_twice_change_nothing(dirty, expected):
    stage = LiveTrochlea(SCENE)
    said, clean = said_of(stage, [dirty]), said_of(LiveTrochlea(SCENE), [IMU])
    np.testing.assert_array_equal(said[READING].time_ref_ns, clean[READING].time_ref_ns)
    assert {name: n for name, n in stage.health().items() if n} == expected


def test_stamps_that_stand_are_named_and_fill_no_memory():
    """100,000 messages. Stamps that creep by a nanosecond are tested by their number."""
    stage, imu, stamp_ns = LiveTrochlea(SCENE), sensor(20.0), START_NS
    for _ in range(100):
        stage.feed({SHIP_IMU: replace(imu, stamp_ns=np.full(1000, stamp_ns))})
    assert len(stage.state()['held']) == 1
    assert f'stand still at {stamp_ns // 10**9}.000 s' in stage.trouble
    assert stage.health()['duplicated'] == 99_999
    for k in range(MOST_HELD - 1):
        one = take(imu, slice(k % 1000, k % 1000 + 1))
        stage.feed({SHIP_IMU: replace(one, stamp_ns=np.array([stamp_ns + k + 1]))})
    assert not stage.state()['held']
    assert 'stand still' not in stage.trouble


def test_a_date_sets_an_undated_dial_anew():
    stage, imu = LiveTrochlea(SCENE), sensor(20.0)
    stage.feed({SHIP_IMU: replace(imu, stamp_ns=imu.stamp_ns - START_NS)})
    setting = DialSetting.of(str(said_of(stage, [imu])[READING].source[-1]))
    assert setting == DialSetting(START_NS, number=2)
    assert 'have a date now' in stage.news()[0]


@pytest.mark.parametrize(('rate_hz', 'within_s'), [(20.0, 4e-6), (1.0, 0.06)])
def test_a_slow_sensor_moves_the_dial_by_little_and_is_told(rate_hz: float, within_s: float):
    """Between samples the motion is interpolated. At 1 Hz a roll of 8 s has eight of them."""
    stage = LiveTrochlea(SCENE)
    slow = errors_s(said_of(stage, [quiet(rate_hz)])[READING])
    fast = errors_s(said_of(LiveTrochlea(SCENE), [quiet(50.0)])[READING])
    assert np.abs(slow - fast[: len(slow)]).max() < within_s
    assert (stage.health()['bridged_gaps'] > 100) == (rate_hz < 20.0)


@pytest.mark.parametrize('vibration_hz', [19.5, 37.0])
def test_vibration_above_the_scenes_rate_is_filtered(vibration_hz: float):
    """Of 2 m/s² at 200 Hz. Thinned without a filter it moved the dial by up to 0.2 s."""
    imu = quiet(200.0, 60.0)
    turned = math.tau * vibration_hz * (imu.stamp_ns - START_NS) * 1e-9
    force = imu.linear_acceleration + [0.0, 0.0, 2.0] * np.sin(turned + 0.3)[:, None]
    moved = said_of(LiveTrochlea(SCENE), [replace(imu, linear_acceleration=force)])
    calm = said_of(LiveTrochlea(SCENE), [imu])
    assert np.abs(errors_s(moved[READING]) - errors_s(calm[READING])).max() < 2e-3


@pytest.mark.parametrize('apart_s', [0.025, -0.5])
def test_of_two_sensors_at_once_the_first_is_believed(apart_s: float):
    """The second one's roll is 2 degrees off, and its clock is wrong."""
    imu, stage = quiet(20.0), LiveTrochlea(SCENE)
    off = mounted(imu, quaternion_of_angles(np.radians(2.0), 0.0, 0.0))
    other = replace(off, stamp_ns=imu.stamp_ns + round(apart_s * 1e9))
    each = [take(one, slice(k, k + 1)) for k in range(len(imu.stamp_ns)) for one in (imu, other)]
    mixed = errors_s(said_of(stage, [join(each)])[READING])
    alone = errors_s(said_of(LiveTrochlea(SCENE), [imu])[READING])
    n = min(len(mixed), len(alone))
    assert n > 115
    assert np.abs(mixed[:n] - alone[:n]).max() < 1e-4
    left_aside = stage.health()['out_of_order'] + stage.health()['stamps_ahead']
    # at 0.025 s it comes in between, as of a fast sensor
    assert (left_aside > 2000) == (apart_s != 0.025)


def _spoilt(fault: str) -> ImuSamples:
    """Half a minute of which two seconds, from the tenth on, cannot be used."""
    imu, bad = sensor(), slice(500, 600)
    orientation, force = imu.orientation.copy(), imu.linear_acceleration.copy()
    stamps = imu.stamp_ns.copy()
    if fault == 'not_finite':
        force[bad] = np.nan
    elif fault == 'zero_quaternion':
        orientation[bad] = 0.0
    elif fault == 'backwards':
        stamps[bad] = stamps[500] - 10**7 * np.arange(1, 101)
    else:
        kept = np.r_[0:500, 600:1500]
        return take(imu, np.isin(np.arange(1500), kept))
    return replace(imu, stamp_ns=stamps, orientation=orientation, linear_acceleration=force)


@pytest.mark.parametrize('fault', ['not_finite', 'zero_quaternion', 'backwards', 'silent'])
def test_the_dial_holds_and_goes_on_with_the_time_it_lost(fault: str):
    stage = LiveTrochlea(SCENE)
    dirty = _spoilt(fault)
    during = take(dirty, slice(0, 595 if fault != 'silent' else 500))
    first = stage.feed({SHIP_IMU: during})[READING]
    assert bool(stage.trouble) == (fault != 'silent')
    reading = said_of(stage, [take(dirty, slice(len(during.stamp_ns), None))])[READING]
    assert not stage.trouble
    # the dial stood at the last reading of the first run until the motion was back
    setting = setting_of(reading)
    assert (setting.set_ns, setting.stops) == (START_NS, 1)
    assert 2.0e9 <= setting.lost_ns < 3.1e9
    assert stage.health()['dial_stops'] == 1
    assert len(stage.news()) == 1
    all_s = np.concatenate([errors_s(first), errors_s(reading)])
    resumed = np.flatnonzero(np.diff(all_s) < -1.9)
    assert len(resumed) == 1
    after = all_s[resumed[0] + 1 :] + setting.lost_ns * 1e-9
    assert np.abs(after).max() < 2 * NATURAL_S


@pytest.mark.parametrize('degrees', [(0, 0, 90), (30, -40, 100)])
def test_a_sensor_mounted_otherwise_reads_the_same(degrees):
    imu = sensor(12.0)
    mount = quaternion_of_angles(*np.radians(degrees))
    seen = mounted(imu, mount * [-1.0, -1.0, -1.0, 1.0])  # the sensor's output
    if degrees == (0, 0, 90):  # x of the sensor points to port: it feels port along x
        np.testing.assert_allclose(
            seen.linear_acceleration[:, 0], imu.linear_acceleration[:, 1], atol=1e-12
        )
    again = mounted(seen, mount)
    for name in ('orientation', 'angular_velocity', 'linear_acceleration'):
        np.testing.assert_allclose(getattr(again, name), getattr(imu, name), atol=1e-12)
    first, other = (said_of(LiveTrochlea(SCENE), [each])[READING] for each in (imu, again))
    np.testing.assert_allclose(first.time_ref_ns, other.time_ref_ns, atol=1e3)


@pytest.mark.parametrize('step_s', [-1.5, -1e6])
def test_a_step_back_of_the_stamps_is_a_break_of_unknown_length(step_s: float):
    stage, drift = LiveTrochlea(SCENE), DriftStage(SCENE, expect_schedule=False)
    longitude = LongitudeStage(SCENE, expect_fix=False)
    imu = sensor()
    stamps = imu.stamp_ns.copy()
    stamps[600:] += round(step_s * 1e9)
    said = said_of(stage, [replace(imu, stamp_ns=stamps)])
    reading = said[READING]
    setting = setting_of(reading)
    assert (setting.set_ns, setting.stops, setting.number) == (START_NS, 1, 1)
    assert setting.unsure_ns * 1e-9 == pytest.approx(-step_s, abs=0.041)
    # the dial itself goes on from its last reading
    assert np.diff(reading.time_ref_ns).min() >= 0
    assert np.diff(reading.time_ref_ns).max() < 1.3e9
    assert stage.health()['dial_settings'] == 0
    assert 'is unknown' in stage.news()[0]
    estimate = drift.feed({READING: reading})
    at = int(np.flatnonzero(np.diff(reading.stamp_ns) < 0)[0])
    before, after = estimate[ESTIMATE].position[at : at + 2, :2]
    assert abs(after[0] - before[0]) < 1.0
    assert after[1] > -step_s - 0.05
    errors = longitude.feed({READING: reading, **estimate})[LONGITUDE_ERROR]
    assert errors.stamp_ns.tolist() == reading.stamp_ns.tolist()
    singly, count = LongitudeStage(SCENE, expect_fix=False), 0
    for k in range(len(reading.stamp_ns)):
        singly.feed({READING: take(reading, slice(k, k + 1))})
        one = {t: take(s, slice(k, k + 1)) for t, s in estimate.items()}
        count += len(singly.feed(one)[LONGITUDE_ERROR].stamp_ns)
    assert count == len(reading.stamp_ns)


@pytest.mark.parametrize(('step_s', 'rate_hz'), [(-0.25, 100.0), (-0.9, 20.0)])
def test_a_short_step_back_widens_the_estimate(step_s, rate_hz):
    stage, drift = LiveTrochlea(SCENE), DriftStage(SCENE, expect_schedule=False)
    imu = sensor(rate_hz=rate_hz)
    stamps = imu.stamp_ns + np.where(
        np.arange(len(imu.stamp_ns)) < 12.3 * rate_hz, 0, step_s * 1e9
    )
    reading = said_of(stage, [replace(imu, stamp_ns=stamps.astype(np.int64))])[READING]
    setting = setting_of(reading)
    # the stamp of the last kept sample is up to a step of the scene, 0.05 s, before the step
    assert setting.unsure_ns * 1e-9 == pytest.approx(-step_s, abs=0.06)
    variance = drift.feed({READING: reading})[ESTIMATE].position[:, 1] ** 2
    released = (RELEASE_SIGMA * nominal_period_s(SCENE, compile_machine(SCENE))) ** 2
    grown = (setting.unsure_ns * 1e-9) ** 2 + released
    assert np.diff(variance).max() == pytest.approx(grown, rel=0.01)


@pytest.mark.parametrize('late_s', [0.95, 1.05, 30.0])
def test_a_late_block_is_left_aside_however_long_it_is(late_s: float):
    imu = sensor(90.0)
    n = round(late_s * 50)
    order = np.r_[0:500, 500 + n : 500 + 2 * n, 500 : 500 + n, 500 + 2 * n : len(imu.stamp_ns)]
    stage = LiveTrochlea(SCENE)
    reading = said_of(stage, [take(imu, order)])[READING]
    setting = setting_of(reading)
    assert (setting.set_ns, setting.number, setting.unsure_ns) == (START_NS, 1, 0)
    assert np.diff(reading.stamp_ns).min() > 0
    assert abs(errors_s(reading)[-1] + setting.lost_ns * 1e-9) < 1.0
    assert setting.lost_ns <= (late_s + 3.1) * 1e9
    assert stage.health()['out_of_order'] > 0


def test_stamps_that_go_back_reset_the_dial_on_request():
    stage = LiveTrochlea(SCENE, reset_on_time_jump=True)
    bag = sensor(12.0)
    reading = said_of(stage, [bag, bag])[READING]
    back = int(np.flatnonzero(np.diff(reading.stamp_ns) < 0)[0])
    assert reading.stamp_ns[back + 1] == reading.time_ref_ns[back + 1] == START_NS
    assert stage.health()['dial_settings'] == 1
    assert 'went back' in stage.news()[0]
    # a later setting, by the stamps, is another one
    later = replace(bag, stamp_ns=bag.stamp_ns - 10**9)
    again = said_of(stage, [later])[READING]
    assert DialSetting.of(again.source[-1]) == DialSetting(START_NS - 10**9, number=3)


@pytest.mark.parametrize(('moved_s', 'side'), [(60.0, 'after'), (-60.0, 'before')])
def test_a_stopped_dial_reports_the_gap_of_the_stamps(moved_s: float, side: str):
    stage = LiveTrochlea(SCENE)
    stage.feed({SHIP_IMU: sensor(12.0)})
    moved = sensor(0.5, first=12.0 + moved_s)
    stage.feed({SHIP_IMU: moved})
    assert stage.trouble.startswith('the dial stands still: ')
    assert stage.trouble.endswith(f' s {side} it')
    stage.feed({SHIP_IMU: replace(moved, angular_velocity=np.nan * moved.angular_velocity)})
    assert stage.trouble.startswith('the dial stands still: ')


def test_a_swing_that_no_machine_can_have_is_not_read():
    limits = Limits(SCENE)
    limits.feel(sensor(2.0))
    stamps = START_NS + 10**9 * np.arange(3)

    def wheel(*angles: float) -> JointSamples:
        column = np.array(angles)[:, None]
        return JointSamples(stamps[: len(angles)], '', ('wheel',), column, 0 * column, 0 * column)

    limits.check(wheel(1.0, 1.2, 1.1), START_NS)
    for angles in ([6.5], [1.0, 5.0], [1.0, np.nan]):
        limits.begin()
        limits.feel(sensor(2.0))
        with pytest.raises(PropagationError, match='can be'):
            limits.check(wheel(*angles), START_NS)


def test_a_run_that_fails_is_given_up_and_the_next_one_declared():
    """For a second the measured force points the other way and the thread goes slack."""
    imu = sensor()
    force = imu.linear_acceleration.copy()
    force[500:550] = [0.0, 0.0, -20.0]
    stage = LiveTrochlea(load_scene(SCENE, **{'trochlea.slack': 'stop'}))
    reading = said_of(stage, [replace(imu, linear_acceleration=force)])[READING]
    assert stage.health()['runs_failed'] >= 1
    assert 'slack' in stage.news()[0]
    setting = setting_of(reading)
    assert setting.stops == 1
    assert abs(errors_s(reading)[-1] + setting.lost_ns * 1e-9) < 2 * NATURAL_S


FAULTY = join(
    [
        take(sensor(), slice(0, 30)),
        replace(take(sensor(), slice(10, 40)), stamp_ns=START_NS + 6 * 10**8 + np.arange(30)),
        take(sensor(), slice(40, 300)),
        take(sensor(), slice(290, 295)),
        take(sensor(), slice(420, 700)),
        replace(take(sensor(), slice(0, 200)), stamp_ns=sensor().stamp_ns[:200] + 10**15),
        take(sensor(), slice(0, 300)),
    ]
)


@settings(max_examples=5, deadline=None)
@given(cuts=st.lists(st.integers(0, len(FAULTY.stamp_ns)), max_size=6), resumed=st.booleans())
def test_splits_and_resuming_of_faulty_motion_keep_the_bits(cuts, resumed):
    bounds = [0, *sorted(cuts), len(FAULTY.stamp_ns)]
    stage, parts = LiveTrochlea(SCENE), []
    for begin, end in pairwise(bounds):
        if resumed:
            saved = stage.state()
            stage = LiveTrochlea(SCENE)
            stage.restore(saved)
        if end > begin:
            parts.append(stage.feed({SHIP_IMU: take(FAULTY, slice(begin, end))}))
    parts.append(stage.finish())
    whole = LiveTrochlea(SCENE)
    expected = said_of(whole, [FAULTY])
    for topic, samples in expected.items():
        got = join([part[topic] for part in parts if topic in part])
        for name, value in vars(samples).items():
            if isinstance(value, np.ndarray):
                assert value.tolist() == getattr(got, name).tolist(), (topic, name)
    assert stage.health() == whole.health()


def readings(stamps, errors, setting: DialSetting) -> TimeSamples:
    return TimeSamples(stamps, '', stamps + errors, same(setting.source(), len(stamps)))


def test_a_stop_moves_and_widens_the_estimate():
    drift = DriftStage(SCENE, expect_schedule=False)
    stamps = START_NS + 10**9 * np.arange(100)
    set_right, stopped = DialSetting(START_NS), DialSetting(START_NS, 7 * 10**9, 1)
    drift.feed({READING: readings(stamps, 0, set_right)})
    after = stamps + 106 * 10**9
    drift.feed({READING: readings(stamps[:1] + 100 * 10**9, 0, set_right)})
    said = drift.feed({READING: readings(after, -7 * 10**9, stopped)})
    estimate, corrected = said[ESTIMATE], said[CORRECTED]
    assert estimate.position[0, 0] == pytest.approx(-7.0, abs=0.01)
    # ten sigmas of a sight when it was set, a rate that is not known, and one release
    rate = SCENE.drift.prior_rate_sigma / 86400.0 * 106.0
    sigma = np.hypot(np.hypot(10.0 * SCENE.drift.observation_sigma, rate), 0.6)
    assert estimate.position[0, 1] == pytest.approx(sigma, rel=0.01)
    assert np.abs(corrected.time_ref_ns - after).max() < 10**8
    # observed to have lost but 6.5 s: believed at once, since the state is open
    seen = TimeSamples(after[50:51], '', after[50:51] - 5 * 10**8, same('sextant', 1))
    later = after[-1] + 10**9 * np.arange(1, 3)
    said = drift.feed({OBSERVATION: seen, READING: readings(later, -7 * 10**9, stopped)})
    assert said[ESTIMATE].position[-1, 0] == pytest.approx(-6.5, abs=0.1)
    assert drift.health()['dial_stops'] == 1
    resumed = DriftStage(SCENE, expect_schedule=False)
    resumed.restore(drift.state())
    more = {READING: readings(later + 2 * 10**9, -7 * 10**9, stopped)}
    a, b = drift.feed(more)[ESTIMATE], resumed.feed(more)[ESTIMATE]
    assert a.position.tobytes() == b.position.tobytes()


@pytest.mark.parametrize('breaks_s', [[600], [600, 86_400, 60, 3600]])
def test_errors_after_breaks_are_as_large_as_the_estimator_says(breaks_s):
    """The root mean square of 200 normal numbers strays from 1 by 0.05: three times that."""
    model, errors = clock_model(SCENE), []
    set_within_s = np.sqrt(prior(model).xx)
    release_s = RELEASE_SIGMA * nominal_period_s(SCENE, compile_machine(SCENE))
    for seed in range(200):
        rng = np.random.default_rng(seed)
        drift, setting = DriftStage(SCENE, expect_schedule=False), DialSetting(START_NS)
        rate, dial_s = rng.normal(0.0, model.prior_rate_sigma), rng.normal(0.0, set_within_s)
        at_s = np.arange(0.0, 301.0, 100.0)
        for break_s in [0, *breaks_s]:
            if break_s:
                lost_ns = setting.lost_ns + break_s * 10**9
                setting = replace(setting, lost_ns=lost_ns, stops=setting.stops + 1)
                dial_s += release_s * rng.normal() - break_s
                at_s = at_s + 300.0 + break_s
            ran_s = rate * (at_s - at_s[0])
            stamps = START_NS + np.rint(at_s * 1e9).astype(np.int64)
            shown = np.rint((dial_s + ran_s) * 1e9).astype(np.int64)
            sky = stamps[2:3] + round(rng.normal(0.0, 0.2) * 1e9)
            seen = TimeSamples(stamps[2:3], '', sky, same('gps', 1))
            drift.feed({READING: take(told := readings(stamps, shown, setting), slice(0, 3))})
            said = drift.feed({READING: take(told, slice(3, 4)), OBSERVATION: seen})
            dial_s += ran_s[-1]
        offset, offset_sigma, per_day, rate_sigma = said[ESTIMATE].position[-1]
        errors.append(((offset - dial_s) / offset_sigma, (per_day - rate * 86_400.0) / rate_sigma))
    assert np.sqrt(np.mean(np.square(errors), axis=0)) == pytest.approx(1.0, abs=0.15)


def test_each_source_of_time_has_its_sigma():
    stamps = START_NS + 10**9 * np.arange(200)
    still = readings(stamps, 0, DialSetting(START_NS))
    settings_s = {'drift.observation_sigma': 0.5, 'drift.lunars': {'sigma': 60.0}}
    scene = load_scene('measured', **settings_s)
    sigmas = {}
    for source in ('sextant', 'lunar', 'gps', 'gnss', 'sundial', ''):
        drift = DriftStage(scene, expect_schedule=False)
        sky = TimeSamples(stamps[:1], '', stamps[:1], same(source, 1))
        said = drift.feed({OBSERVATION: sky, READING: still})
        sigmas[source] = said[ESTIMATE].position[0, 1]
        refused = drift.health()['observations_unknown']
        assert refused == len(drift.notices) == (source == 'sundial')
    prior = 10.0 * scene.drift.observation_sigma
    expected = {'sextant': 0.5, 'lunar': 60.0, 'gps': 0.2, 'gnss': 0.2, 'sundial': np.inf, '': 0.5}
    for source, sigma in expected.items():
        known = 1.0 / np.hypot(1.0 / prior, 1.0 / sigma)
        assert sigmas[source] == pytest.approx(known, rel=1e-6), source
    finer = load_scene('measured', **{'drift.gnss_sigma': 0.01})
    assert clock_model(finer).sigma_of('gnss') == 0.01


@pytest.mark.parametrize(
    'true_s',
    [lambda _: 0.0, lambda at: at - 1024 * 604_800.0, lambda at: at + 11 * 365.25 * 86_400.0],
    ids=['no fix', 'an earlier era', 'a wrong clock'],
)
def test_an_impossible_time_of_a_receiver_is_refused(true_s):
    drift = DriftStage(SCENE, expect_schedule=False)
    stamps = START_NS + 10**9 * np.arange(2000)
    seen = stamps[100::300]
    true = np.array([round(true_s(stamp * 1e-9) * 1e9) for stamp in seen.tolist()])
    sky = TimeSamples(seen, '', true, same('gps', len(seen)))
    said = drift.feed({READING: readings(stamps, 0, DialSetting(START_NS)), OBSERVATION: sky})
    assert drift.health()['observations_years_off'] == len(seen)
    assert len(drift.notices) == 1
    assert np.all(said[ESTIMATE].position[:, 0] == 0.0)


def test_a_source_that_is_wrong_for_good_stays_a_warning():
    """GPS time for UTC, 18 s, from the fourth of nine observations on, and a stop after that."""
    scene = load_scene('measured', **{'drift.observation_interval': 1000.0})
    drift, setting = DriftStage(scene, expect_schedule=False), DialSetting(START_NS)
    stamps = START_NS + 10**9 * np.arange(9000)
    seen = stamps[500::1000]
    wrong = seen + 18 * 10**9 * (np.arange(9) >= 3)
    sky = TimeSamples(seen, '', wrong, same('sextant', 9))
    drift.feed({READING: readings(stamps, 0, setting), OBSERVATION: sky})
    drift.feed({READING: readings(stamps[-1:] + 10**9, 0, setting)})
    assert drift.health()['observations_gated'] == 2
    assert any('had to be believed' in line for line in drift.notices)
    stopped = DialSetting(START_NS, 5 * 10**9, 1)
    drift.feed({READING: readings(stamps[-1:] + 7 * 10**9, -5 * 10**9, stopped)})
    assert any('had to be believed' in line for line in drift.notices)


def test_an_estimate_begins_when_the_dial_was_set():
    """Two days before, with 67 s lost: all that the reading says, and the prior of the rate."""
    elapsed_s, lost_s = 172_800, 67
    setting = DialSetting(START_NS, lost_s * 10**9, 2)
    stamps = START_NS + (elapsed_s + np.arange(3)) * 10**9
    drift = DriftStage(SCENE, expect_schedule=False)
    reading = readings(stamps, -(lost_s + 150) * 10**9, setting)
    said = drift.feed({READING: reading})
    offset, sigma, rate, rate_sigma = said[ESTIMATE].position[0]
    assert (offset, rate) == (-lost_s, 0.0)
    prior = SCENE.drift.prior_rate_sigma
    assert rate_sigma == pytest.approx(prior, rel=1e-6)
    assert sigma == pytest.approx(np.hypot(prior * 2.0, 5.0), rel=1e-3)
    assert abs(offset + lost_s + 150) < 3.0 * sigma
    assert 'began in mid-voyage, 172800 s after' in drift.notices[0]
    sky = TimeSamples(stamps[1:2], '', stamps[1:2], same('port', 1))
    drift.feed({OBSERVATION: sky, READING: replace(reading, stamp_ns=stamps + 3 * 10**9)})
    assert not drift.notices


def test_estimate_and_longitude_restart_with_the_dial():
    drift = DriftStage(SCENE, expect_schedule=False)
    longitude = LongitudeStage(SCENE, expect_fix=False)
    stamps = START_NS + 10**9 * np.arange(50)
    first = readings(stamps, 3 * 10**9, DialSetting(START_NS))
    again = readings(stamps - 10**12, 0, DialSetting(START_NS - 10**12))
    looped = readings(stamps - 10**12, 0, DialSetting(START_NS - 10**12, number=2))
    for reading in (first, again, looped):
        said = drift.feed({READING: reading})
        # the estimate may come later than the next reading
        out = longitude.feed({READING: reading})
        out = longitude.feed(said)
        assert len(out[LONGITUDE_ERROR].stamp_ns) == 50
    np.testing.assert_allclose(said[ESTIMATE].position[:, 0], 0.0, atol=1e-12)
    assert drift.health()['dial_settings'] == longitude.health()['dial_settings'] == 2


def test_a_fix_from_the_future_does_not_block_those_that_follow():
    longitude = LongitudeStage(SCENE, expect_fix=False)
    stamps = START_NS + 10**9 * np.arange(5)
    fixes = Route(SCENE).fixes(stamps - START_NS + SCENE.starts_at_ns)
    wild = replace(take(fixes, slice(0, 1)), stamp_ns=stamps[:1] + 10**15)
    longitude.feed({'ship/fix': wild})
    longitude.feed({READING: readings(stamps, 0, DialSetting(START_NS))})
    longitude.feed({'ship/fix': replace(fixes, stamp_ns=stamps)})
    longitude.feed({'ship/fix': wild})
    assert longitude.health()['fixes_from_future'] == 1
    assert longitude.health()['out_of_order'] == 0
