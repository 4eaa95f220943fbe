"""The forcing of a moving ship: pieces of several samples, cuts, and the same bits always."""

import math
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tauto_core.motion.forcing import LEAST_UPWARD
from tauto_core.samples import take
from tauto_core.scene import load_scene
from tauto_core.scene.errors import PropagationError
from tauto_core.ship.buffer import TURNS, MotionBuffer, SharedBuffers, samples_a_piece
from tauto_core.ship.imu import attitude, imu_samples

STEP = 50_000_000
LOG = 60 * STEP
HEIGHT, GRAVITY = 2.5, 9.81
AMPLITUDE, OMEGA = 0.1, 2 * math.pi / 8.0


def roll_at(t, order=0):
    return AMPLITUDE * OMEGA**order * np.cos(OMEGA * t + 0.4 + 0.5 * math.pi * order)


def tilt_at(t):
    """Direction of the apparent vertical in the case, from ship.md."""
    y = GRAVITY * np.sin(roll_at(t)) - HEIGHT * roll_at(t, 2)
    z = GRAVITY * np.cos(roll_at(t)) - HEIGHT * roll_at(t, 1) ** 2
    return np.arctan2(-y, z)


def motion(times):
    t = times * 1e-9
    return imu_samples(times, roll_at(t), roll_at(t, 1), roll_at(t, 2), None, HEIGHT, GRAVITY)


ARGUMENTS = {
    'apparent_vertical': True,
    'apparent_gravity': True,
    'still': False,
    'step_ns': STEP,
    'max_gap_s': 1.0,
    'stride': 4,
}


def buffer(**changed):
    return MotionBuffer(**{**ARGUMENTS, **changed})


def forcing_of(times, end=None, **changed):
    made = buffer(**changed)
    made.add(motion(times), 0)
    return made.forcing(LOG, end, final=False)


def values(rows, x):
    return np.polynomial.polynomial.polyval(x, rows.T, tensor=False)


def check_against_the_waves(spans, tolerance=1e-14):
    """Beginning, middle and end of all spans. The line's direction is roll + tilt."""
    start = spans.end_ns * 1e-9 - spans.end * spans.length_s
    for part in (0.0, 0.5, 1.0):
        x = spans.begin + part * (spans.end - spans.begin)
        t = start + x * spans.length_s
        line = roll_at(t) + tilt_at(t)
        np.testing.assert_allclose(values(spans.neutral, x), line, rtol=0, atol=tolerance)
        np.testing.assert_allclose(values(spans.tilt, x), tilt_at(t), rtol=0, atol=tolerance)


@pytest.mark.parametrize('stride', [1, 4, 5, 8])
def test_even_samples_make_long_pieces(stride):
    spans = forcing_of(np.arange(400) * STEP, stride=stride)
    samples = np.rint(spans.length_s / (STEP * 1e-9)).astype(int)
    starts = np.concatenate([[0], np.cumsum(samples)[:-1]])
    long = samples == stride
    if stride > 1:
        assert np.all(starts[long] % stride == 0)
        # single at the start, and if a logged instant falls inside
        inside = (starts // stride * stride // 60) != (
            (starts // stride * stride + stride - 1) // 60
        )
        logged_inside = inside & (60 % stride != 0)
        np.testing.assert_array_equal(
            long, (starts >= 4) & ~logged_inside & (starts % stride == 0)
        )
    assert np.all(spans.begin == 0.0)
    assert np.all(spans.end == 1.0)
    np.testing.assert_array_equal(spans.end_ns[spans.logged], np.arange(1, 7) * LOG)
    check_against_the_waves(spans)


@pytest.mark.parametrize('slopes', [False, True])
def test_smooth_motion_is_fitted_with_long_pieces_from_the_start(slopes):
    """The first piece is the worst: its window is one-sided, but wider than a single's."""
    times = np.arange(400) * 5 * STEP
    arguments = {'stride': 4, 'step_ns': 5 * STEP}
    if slopes:
        arguments |= {'apparent_vertical': False, 'apparent_gravity': False}
    single, smooth = (forcing_of(times, smooth=each, **arguments) for each in (False, True))
    assert single.length_s[0] == pytest.approx(5 * STEP * 1e-9)
    assert smooth.length_s[0] == pytest.approx(4 * 5 * STEP * 1e-9)
    wrong = []
    for spans in (single, smooth):
        at = spans.end_ns * 1e-9 - spans.length_s * 0.9
        line = roll_at(at) if slopes else roll_at(at) + tilt_at(at)
        wrong.append(np.abs(values(spans.neutral, 0.1) - line)[at < 1.0])
    assert np.max(wrong[1]) < 0.5 * np.max(wrong[0])


def test_one_late_sample_leaves_single_pieces_around_it():
    times = np.arange(200) * STEP
    times[101] += 1_000_000
    spans = forcing_of(times)
    # windows of [100, 104] and its neighbours reach from 92 to 108
    first = np.searchsorted(times, spans.end_ns - np.rint(spans.length_s * 1e9).astype(int) - 10)
    last = np.searchsorted(times, spans.end_ns)
    single = last - first == 1
    np.testing.assert_array_equal(first[single & (first >= 4)], np.arange(96, 108))
    check_against_the_waves(spans, 1e-13)


def test_logged_instants_and_the_end_between_samples_cut_pieces():
    """With samples every 48 ms and logs every 3 s the cuts fall between samples."""
    times = np.arange(400) * 48_000_000
    end = 17_000_000_001
    spans = forcing_of(times, end=end)
    assert spans.end_ns[-1] == end
    np.testing.assert_array_equal(spans.end_ns[spans.logged], np.arange(1, 6) * LOG)
    cut = (spans.end < 1.0) | (spans.begin > 0.0)
    assert 5 <= np.count_nonzero(cut) <= 12
    np.testing.assert_allclose(spans.length_s[cut], 0.048, rtol=1e-15)
    assert np.max(spans.length_s) == pytest.approx(4 * 0.048)
    check_against_the_waves(spans)


@pytest.mark.parametrize('stride', [1, 2, 4, 5])
def test_a_logged_sample_waits_for_four_more_at_most(stride):
    made = buffer(stride=stride)
    seen: dict[Any, Any] = {}
    for k in range(400):
        made.add(motion(np.array([k * STEP])), 0)
        spans = made.forcing(LOG, None, final=False)
        if spans is not None:
            seen |= dict.fromkeys(spans.end_ns[spans.logged].tolist(), k)
    assert [k - time // STEP for time, k in seen.items()] == [4] * 6


def joined(parts, name):
    arrays = [getattr(part, name) for part in parts if part is not None]
    return np.concatenate(arrays)


def uneven_times():
    times = np.arange(300) * STEP
    times[90:] += 30_000_000
    times[200:] += 700_000_000
    times[250] -= 1
    return times


@given(data=st.data(), stride=st.integers(1, 8))
@settings(max_examples=8, deadline=None)
def test_any_split_and_resumption_give_the_same_bits(data, stride):
    imu = motion(uneven_times())
    whole = buffer(stride=stride)
    whole.add(imu, 0)
    expected = [whole.forcing(LOG, None, final=False), whole.forcing(LOG, None, final=True)]
    cuts = sorted(data.draw(st.lists(st.integers(0, 300), max_size=8)))
    made, parts = buffer(stride=stride), []
    for begin, end in zip([0, *cuts], [*cuts, 300], strict=True):
        if end > begin:
            made.add(take(imu, slice(begin, end)), 0)
        parts.append(made.forcing(LOG, None, final=False))
        state = pickle.loads(pickle.dumps(made.state()))
        made = buffer(stride=stride)
        made.restore(state)
    parts.append(made.forcing(LOG, None, final=True))
    for name in ('length_s', 'begin', 'end', 'end_ns', 'logged', 'neutral', 'gravity', 'tilt'):
        assert joined(parts, name).tobytes() == joined(expected, name).tobytes(), name
    assert made.bridged == whole.bridged == 2
    assert joined(parts, 'end_ns')[-1] == uneven_times()[-1]


def test_forcing_before_a_gap_comes_before_its_error():
    times = np.arange(100) * STEP
    times[60:] += 2_000_000_000
    made = buffer()
    made.add(motion(times), 0)
    assert made.forcing(LOG, None, final=False).end_ns[-1] == 59 * STEP
    with pytest.raises(
        PropagationError, match=r'no ship motion for 2\.05 s; at most 1 s'
    ) as error:
        made.forcing(LOG, None, final=False)
    assert error.value.time_s == pytest.approx(59 * 0.05)


def test_downward_force_is_negative_and_smooth():
    """The pull passes through zero, and its direction leans on steadily."""
    times = np.arange(60) * STEP
    imu = motion(times)
    force = np.zeros((60, 3))
    force[:, 2] = 2.0 - 0.05 * np.arange(60)
    force[:, 1] = 0.1 * force[:, 2]
    imu = replace(imu, linear_acceleration=force)
    made = buffer()
    made.add(imu, 0)
    spans = made.forcing(LOG, None, final=False)
    upward = 2.0 - spans.end_ns * 1e-9
    gravity, tilt = values(spans.gravity, 1.0), values(spans.tilt, spans.end)
    follows = upward > LEAST_UPWARD + 1e-9
    exact = math.hypot(1.0, 0.1) * upward[follows]
    np.testing.assert_allclose(gravity[follows], exact, rtol=0, atol=1e-13)
    np.testing.assert_allclose(tilt[follows], -math.atan(0.1), rtol=0, atol=1e-13)
    apart = np.abs(upward) > 1e-9
    assert (np.sign(gravity[apart]) == np.sign(upward[apart])).all()
    assert (upward < -0.5).any()
    # the lean follows the thread's own side of the case: never more than 0.1/0.5 of the force
    assert np.abs(np.tan(tilt)).max() <= 0.1 / 0.5 * np.abs(upward).max()
    assert np.abs(np.diff(tilt) / np.diff(upward)).max() < 0.3  # without it by pi in one sample


def test_a_ship_that_pitches_and_yaws_rolls_as_attitude_says():
    """Roll, half turns unwrapped, and its rate are those at which the pieces begin."""
    times, t = np.arange(60) * STEP, np.arange(60) * 0.05
    angles = np.stack([2.0 * t, 0.4 * np.sin(t), 3.0 + 0.5 * t], axis=1)
    velocity = np.random.default_rng(2).normal(size=(60, 3))
    quaternions = Rotation.from_euler('ZYX', angles).as_quat()
    imu = replace(motion(times), orientation=quaternions, angular_velocity=velocity)
    made = buffer(apparent_vertical=False, apparent_gravity=False, stride=1)
    made.add(imu, 0)
    spans = made.forcing(LOG, None, final=True)
    felt = attitude(imu)
    roll, rate = np.unwrap(felt.roll)[:-1], felt.roll_rate[:-1]
    np.testing.assert_allclose(spans.neutral[:, 0], roll, rtol=0, atol=1e-14)
    found = spans.neutral[:, 1] / spans.length_s
    # one-sided pieces take their rate from a polynomial through all four
    np.testing.assert_allclose(found, rate, rtol=0, atol=1e-10)


def test_a_turn_is_kept_through_batches_of_small_rolls():
    times, t = np.arange(120) * STEP, np.arange(120) * 0.05
    roll = np.where(t < 3.0, -math.tau * t / 3.0, 0.2 * np.sin(t) - 0.2 * math.sin(3.0) - math.tau)
    zero = np.zeros(120)
    imu = imu_samples(times, roll, zero, zero, None, HEIGHT, GRAVITY)
    made, found = buffer(apparent_vertical=False, apparent_gravity=False, stride=1), []
    for first in range(0, 120, 10):
        made.add(take(imu, slice(first, first + 10)), 0)
        spans = made.forcing(LOG, None, final=first == 110)
        found.extend(spans.neutral[:, 0])
    # rolls of a turn are off by a unit in the last place, one-sided pieces by some more
    np.testing.assert_allclose(found, roll[:-1], rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ('interval', 'longest_s', 'wanted'),
    [
        (60.0, math.inf, 8),
        (60.0, 0.4, 8),
        (60.0, 0.3, 6),  # one step of 0.3 s instead of two of 0.2 s
        (60.0, 0.2, 8),
        (0.7, 0.4, 7),
        (0.7, 0.3, 7),  # of 14 samples there are no six
        (0.55, 0.4, 1),
        (0.5, 0.3, 5),
        (0.05, 0.4, 1),
    ],
)
def test_pieces_span_what_logs_and_steps_divide(interval, longest_s, wanted):
    name = 'involute_weight_at_sea'
    scene = load_scene(name, duration=interval * 60, **{'ship.rate': 20.0})
    changed = scene.model_copy(update={'log': scene.log.model_copy(update={'interval': interval})})

    def steps_in(length_s):
        return max(1, math.ceil(length_s / longest_s - 1e-9))

    assert samples_a_piece(changed, steps_in) == wanted
    if longest_s == math.inf:
        assert samples_a_piece(changed) == wanted


def test_shared_buffers_have_the_forcing_of_one_alone():
    """The first one computes it. A clock too far behind is refused."""
    times, shared, alone = np.arange(0, 400 * STEP, STEP), SharedBuffers(), buffer()
    first, second = (shared.buffer('same', **ARGUMENTS) for _ in range(2))
    other = shared.buffer('same', **{**ARGUMENTS, 'stride': 2})
    for part in np.split(times, [100, 150, 390]):
        order = (first, second) if part[0] else (second, first)
        for each in (alone, *order, other):
            each.add(motion(part), 0)
        forced = [each.forcing(LOG, None, final=False) for each in (alone, *order)]
        for found in forced[1:]:
            assert np.array_equal(found.end_ns, forced[0].end_ns)
            assert np.array_equal(found.neutral, forced[0].neutral)
            assert np.array_equal(found.gravity, forced[0].gravity)
        assert len(other.forcing(LOG, None, final=False).end_ns) > len(forced[0].end_ns)
    for _ in range(TURNS + 1):
        first.forcing(LOG, None, final=False)
    with pytest.raises(RuntimeError, match='behind'):
        second.forcing(LOG, None, final=False)
