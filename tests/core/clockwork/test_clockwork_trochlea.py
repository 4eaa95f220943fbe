"""The trochlea stage: chunk invariance, save and resume, refusals, motion from elsewhere."""

import copy
import pickle
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core.clockwork import TrochleaStage, dial_ns
from tauto_core.samples import PHASE, READING, join, merged, take
from tauto_core.scene import load_scene
from tauto_core.scene.errors import PropagationError
from tauto_core.ship import ShipMotion

HUNG = load_scene('suspended_weight_at_sea', duration=20.0)
SCENES = {
    'weight': load_scene('involute_weight_at_sea', duration=40.0),
    'measured': load_scene('measured', duration=40.0),
    'kinked': load_scene('cheek_before_euler', duration=20.0),
    'ideal': load_scene('ideal', duration=240.0),
    'noisy dial': load_scene(
        'ideal', duration=240.0, clock={'white_fm': 0.3, 'random_walk_fm': 2.0}
    ),
    "weight's own cam, suspended": load_scene(
        HUNG, **{'trochlea.cam': {'kind': 'weight_corrected', 'period': 2.0}}
    ),
    'thread that swings, suspended': load_scene(
        HUNG, **{'trochlea.thread': {'kind': 'hanging', 'length': 1.0}}
    ),
    'globe in oil': load_scene('globe_in_oil', duration=240.0),
}


def imu_of(scene):
    ship = ShipMotion(scene)
    return ship.produce(ship.total)


def same_bits(a, b):
    assert a.keys() == b.keys()
    for topic in a:
        for name, value in vars(a[topic]).items():
            other = getattr(b[topic], name)
            if isinstance(value, np.ndarray) and value.dtype != object:
                assert value.tobytes() == other.tobytes(), (topic, name)
            elif isinstance(value, np.ndarray):
                assert value.tolist() == other.tolist()
            else:
                assert value == other


@pytest.mark.parametrize('name', SCENES)
def test_any_split_and_any_resumption_give_the_same_bits(name):
    """Stages are copies of one that was not fed, since laying out the steps takes long."""
    scene = SCENES[name]
    new = TrochleaStage(scene)
    imu, whole_stage = imu_of(scene), TrochleaStage(scene)
    whole = merged([whole_stage.feed({'ship/imu': imu}), whole_stage.finish()])
    assert len(whole[READING].stamp_ns) == scene.log_count
    n = len(imu.stamp_ns)

    @given(data=st.data())
    @settings(max_examples=8, deadline=None)
    def in_parts(data):
        cuts = sorted(data.draw(st.lists(st.integers(0, n), max_size=6)))
        stage, parts = copy.deepcopy(new), []
        for begin, end in zip([0, *cuts], [*cuts, n], strict=True):
            parts.append(stage.feed({'ship/imu': take(imu, slice(begin, end))}))
            if data.draw(st.booleans()):
                state = pickle.loads(pickle.dumps(stage.state()))
                stage = copy.deepcopy(new)
                stage.restore(state)
        parts.append(stage.finish())
        same_bits(whole, merged(parts))

    in_parts()


def test_bad_samples_are_counted_and_change_nothing():
    scene = SCENES['weight']
    imu = imu_of(scene)
    bad = take(imu, slice(50, 53))
    bad = replace(
        bad,
        stamp_ns=bad.stamp_ns + np.array([0, 1_000_000, 2_000_000]),
        orientation=np.array([[0, 0, 0, 0], [np.nan, 0, 0, 1], [0, 0, 0, 1.0]]),
    )
    bad_force = bad.linear_acceleration.copy()
    bad_force[2, 1] = np.inf
    bad = replace(bad, linear_acceleration=bad_force)
    dirty = join(
        [take(imu, slice(0, 53)), bad, take(imu, slice(40, 60)), take(imu, slice(60, None))]
    )
    clean, stage = TrochleaStage(scene), TrochleaStage(scene)
    expected = clean.feed({'ship/imu': imu})
    same_bits(expected, stage.feed({'ship/imu': dirty}))
    counts = {name: n for name, n in stage.health().items() if n}
    assert counts == {'zero_quaternion': 1, 'not_finite': 2, 'duplicated': 1, 'out_of_order': 12}


def test_a_run_that_does_not_start_at_the_start_is_refused():
    scene = SCENES['weight']
    with pytest.raises(PropagationError, match='the scene starts at'):
        TrochleaStage(scene).feed({'ship/imu': take(imu_of(scene), slice(1, None))})


def test_jitter_of_foreign_motion_does_not_move_the_dial():
    """Jitter of ±5 ms enlarges the remainder of order 8 by five: still below 1e-13 rad."""
    scene = load_scene('second_cam_at_sea', duration=60.0, **{'ship.rate': 20.0})
    imu = imu_of(scene)
    shift = 12_345_678_901
    regular = TrochleaStage(scene, anchor='first')
    said = merged(
        [regular.feed({'ship/imu': replace(imu, stamp_ns=imu.stamp_ns + shift)}), regular.finish()]
    )
    own = TrochleaStage(scene).feed({'ship/imu': imu})
    assert said[READING].stamp_ns[0] == scene.starts_at_ns + shift
    of_zero = replace(imu, stamp_ns=imu.stamp_ns - imu.stamp_ns[0])
    by_zero = TrochleaStage(scene, anchor='first').feed({'ship/imu': of_zero})
    np.testing.assert_array_equal(
        by_zero[PHASE].position, said[PHASE].position[: len(by_zero[PHASE].position)]
    )
    # a scene's own motion is known to be smooth, and fitted with wider windows at the start
    np.testing.assert_allclose(
        said[PHASE].position[: scene.log_count], own[PHASE].position, rtol=0, atol=1e-13
    )
    fine = load_scene(scene, **{'ship.rate': 200.0})
    dense = imu_of(fine)
    rng = np.random.default_rng(5)
    keep = np.arange(0, len(dense.stamp_ns) - 20, 10) + rng.integers(
        -1, 2, (len(dense.stamp_ns) - 20 + 9) // 10
    )
    keep[0] = 0
    which = np.zeros(len(dense.stamp_ns), bool)
    which[keep] = True
    jittered = TrochleaStage(scene, anchor='first')
    out = merged([jittered.feed({'ship/imu': take(dense, which)}), jittered.finish()])
    n = min(len(out[PHASE].position), len(own[PHASE].position))
    assert n > 55
    np.testing.assert_allclose(
        out[PHASE].position[:n, 0], own[PHASE].position[:n, 0], rtol=0, atol=1e-9
    )


def test_samples_that_crowd_are_left_out_and_counted():
    """Interpolated through four samples 0.1 ms apart, rounding alone gives 1e-7 rad."""
    scene = load_scene('involute_weight_at_sea', duration=20.0)
    fine = load_scene(scene, duration=21.0, **{'ship.rate': 1e4})
    dense = imu_of(fine)
    ticks = np.arange(0, len(dense.stamp_ns) - 4, 500)
    bursts = np.union1d(ticks, (ticks[5::7, None] + np.arange(1, 4)).ravel())
    one_by_one, at_once = TrochleaStage(scene), TrochleaStage(scene)
    found = at_once.feed({'ship/imu': take(dense, bursts)})
    split = [
        one_by_one.feed({'ship/imu': take(dense, part)}) for part in np.array_split(bursts, 97)
    ]
    same_bits(found, merged(split))
    clean = TrochleaStage(scene).feed({'ship/imu': take(dense, ticks)})
    same_bits(found, clean)
    assert at_once.health()['crowded'] == one_by_one.health()['crowded'] == 3 * len(ticks[5::7])


def test_dial_counts_whole_half_turns_in_integers():
    """The reference is exact fractions, with a nominal period of 1 + 2^-20 s over 600 days."""
    half = np.array([0, 1, 2, 103_680_001])
    fraction = np.array([0.0, 0.5, 0.25, 0.125])
    nominal = 1 + 2.0**-20
    expected = [
        round((Fraction(int(h)) + Fraction(f)) * Fraction(nominal) / 2 * 10**9)
        for h, f in zip(half, fraction, strict=True)
    ]
    np.testing.assert_array_equal(dial_ns(half, fraction, nominal), expected)
