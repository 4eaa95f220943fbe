"""Noise of the dial: its covariance, and the same bits in any pieces."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core.clockwork import TrochleaStage
from tauto_core.clockwork.trochlea import NOISE_BLOCK, DialNoise
from tauto_core.samples import READING
from tauto_core.scene import load_scene
from tauto_core.ship import ShipMotion

DAY = 86_400.0
NOISE = {'white_fm': 0.3, 'random_walk_fm': 2.0}


def noisy(duration=40.0, interval=1.0, seed=1726, clock=None):
    return load_scene(
        'ideal',
        duration=duration,
        seed=seed,
        clock=NOISE if clock is None else clock,
        log={'interval': interval},
        drift={'observation_interval': duration},
    )


def test_a_step_has_the_covariance_of_the_exact_discretisation():
    # half an hour: the walk's share of the phase is as large as the white noise's
    tau, steps = 1800.0, 40_000
    scene = noisy(duration=tau * 4, interval=tau, clock={'white_fm': 0.3, 'random_walk_fm': 80.0})
    x, y = DialNoise(scene).advance(steps)
    own = np.diff(x) - tau * y[:-1], np.diff(y)
    q1, q2 = 0.3**2 / DAY, (80.0 / DAY) ** 2 / DAY
    q = np.array(
        [[q1 * tau + q2 * tau**3 / 3.0, q2 * tau**2 / 2.0], [q2 * tau**2 / 2.0, q2 * tau]]
    )
    found = np.cov(own)
    # sampling error of a covariance: sqrt((q_ii q_jj + q_ij^2)/n), five of them
    spread = np.sqrt((np.outer(np.diag(q), np.diag(q)) + q**2) / steps)
    assert (np.abs(found - q) < 5.0 * spread).all()
    # the terms that a wrong discretisation would leave out are far larger
    assert q[0, 1] > 50.0 * spread[0, 1]
    assert q2 * tau**3 / 12.0 > 20.0 * spread[0, 0]
    # steps do not know of each other
    for a in own:
        assert abs(np.corrcoef(a[:-1], a[1:])[0, 1]) < 5.0 / np.sqrt(steps)


def test_noise_is_added_to_the_reading_and_to_nothing_else():
    imu = ShipMotion(noisy()).produce(10**6)
    plain, noise = (
        TrochleaStage(scene).feed({'ship/imu': imu})
        for scene in (
            noisy(clock={'nominal_period': 1.0}),
            noisy(clock={'nominal_period': 1.0} | NOISE),
        )
    )
    added = noise[READING].time_ref_ns - plain[READING].time_ref_ns
    np.testing.assert_array_equal(added, DialNoise(noisy()).offsets_ns(np.arange(41)))
    assert added[0] == 0
    assert np.unique(added).size == 41
    for topic in plain.keys() - {READING}:
        np.testing.assert_array_equal(plain[topic].position, noise[topic].position)


def test_seeds_give_other_clocks():
    one, other = (DialNoise(noisy(seed=seed)).offsets_ns(np.arange(9)) for seed in (1, 2))
    assert not (one[1:] == other[1:]).any()


@settings(max_examples=25, deadline=None)
@given(st.sets(st.integers(1, 3 * NOISE_BLOCK), min_size=1, max_size=8))
def test_neither_pieces_nor_gaps_nor_blocks_change_the_noise(asked):
    whole = DialNoise(noisy()).offsets_ns(np.arange(3 * NOISE_BLOCK + 1))
    noise, order = DialNoise(noisy()), np.array(sorted(asked))
    for part in np.array_split(order, 3):
        if len(part):
            np.testing.assert_array_equal(noise.offsets_ns(part), whole[part])
            resumed = DialNoise(noisy())
            resumed.restore(noise.state())
            noise = resumed


def test_a_scene_without_noise_has_none_in_its_state():
    stage = TrochleaStage(load_scene('ideal', clock={'white_fm': 0.0}))
    assert stage.state()['noise'] is None
