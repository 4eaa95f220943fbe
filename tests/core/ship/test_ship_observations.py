"""Times and errors of the navigator's observations."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core.scene import Scene, SceneError, load_scene
from tauto_core.ship import Observations, schedule

S = 1_000_000_000
PORTS = {'departure': [50.37, -4.14], 'arrival': [17.93, -76.84]}


def scene_of(duration=1000.0, interval=100.0, sigma=0.5, seed=7, voyage=None, **drift) -> Scene:
    keys = {'duration': duration, 'seed': seed, 'starts_at': 50.0, 'log': {'interval': 10.0}}
    drift |= {'observation_interval': interval, 'observation_sigma': sigma}
    return load_scene('ideal', **keys, drift=drift, voyage=voyage and {**PORTS, **voyage})


@pytest.mark.parametrize(
    ('voyage', 'expected'),
    [
        (None, [0, 100, 200, 300, 400, 500, 600, 700, 800, 900, 1000]),
        ({'sails_at': 200.0, 'arrives_at': 600.0}, [0, 100, 200, 610]),
        ({'sails_at': 199.9, 'arrives_at': 607.3}, [0, 100, 620]),
        ({'sails_at': 0.0, 'arrives_at': 990.0}, [0, 1000]),
        ({'sails_at': 200.0, 'arrives_at': 981.0}, [0, 100, 200, 1000]),
        ({'sails_at': 200.0, 'arrives_at': 990.1}, [0, 100, 200]),
        ({'sails_at': 5000.0, 'arrives_at': 9000.0}, [100 * k for k in range(11)]),
        ({'sails_at': 203.0, 'arrives_at': 204.0}, [0, 100, 200, 220]),
        ({'sails_at': 213.0, 'arrives_at': 214.0}, [0, 100, 200, 230]),
    ],
)
def test_schedule(voyage, expected):
    stamps = schedule(scene_of(voyage=voyage))
    assert stamps.tolist() == [(50 + t) * S for t in expected]
    assert stamps.dtype == np.int64


def test_source_tells_landfall_from_port():
    scene = scene_of(voyage={'sails_at': 200.0, 'arrives_at': 607.3})
    seen = Observations(scene).between(0, 10**18)
    assert seen.source.tolist() == ['port', 'port', 'port', 'landfall']
    assert seen.stamp_ns.tolist() == schedule(scene).tolist()


def test_first_is_counted_and_last_is_not():
    observations = Observations(scene_of())
    assert observations.between(150 * S, 350 * S).stamp_ns.tolist() == [150 * S, 250 * S]
    assert observations.between(151 * S, 250 * S).stamp_ns.tolist() == []


@pytest.mark.parametrize(
    ('source', 'sigma', 'scene'),
    [
        ('port', 0.3, lambda: scene_of(duration=40_000.0, interval=10.0, sigma=0.3)),
        ('lunar', 30.0, lambda: at_sea(lunars={'interval': 20.0, 'sigma': 30.0})),
    ],
)
def test_errors_are_normal_with_the_sigma_of_their_source(source, sigma, scene):
    """Some thousand seeded draws: mean within 4 sigma/sqrt(n), variance within 4 sqrt(2/n)."""
    seen = Observations(scene()).between(0, 10**18)
    errors = (seen.time_ref_ns - seen.stamp_ns)[seen.source == source] / S / sigma
    n = len(errors)
    assert n > 1900
    assert abs(errors.mean()) < 4.0 / np.sqrt(n)
    assert abs(errors.var() - 1.0) < 4.0 * np.sqrt(2.0 / n)
    # successive errors are independent
    assert abs(np.mean(errors[1:] * errors[:-1])) < 4.0 / np.sqrt(n)


def test_kth_error_depends_on_seed_and_k_alone():
    def errors(scene):
        seen = Observations(scene).between(0, 10**18)
        return seen.time_ref_ns - seen.stamp_ns

    first = errors(scene_of())
    np.testing.assert_array_equal(errors(scene_of(interval=50.0))[:11], first)
    np.testing.assert_allclose(errors(scene_of(sigma=5.0)), 10.0 * first, rtol=0, atol=6)
    assert not np.isin(errors(scene_of(seed=8)), first).any()


@settings(max_examples=10, deadline=None)
@given(cuts=st.lists(st.integers(0, 1200), max_size=5))
def test_asking_in_parts_gives_the_same(cuts):
    observations = Observations(scene_of())
    whole = observations.between(0, 2000 * S)
    ends = [0, *sorted(cuts), 2000]
    parts = [Observations(scene_of()).between(a * S, b * S) for a, b in pairwise(ends)]
    for name in ('stamp_ns', 'time_ref_ns', 'source'):
        joined = np.concatenate([getattr(part, name) for part in parts])
        np.testing.assert_array_equal(joined, getattr(whole, name))


VOYAGE = {'sails_at': 200.0, 'arrives_at': 40_000.0}


def at_sea(seed: int = 7, **drift: Any) -> Scene:
    return scene_of(40_100.0, seed=seed, voyage=VOYAGE, **drift)


def test_lunar_distances_are_taken_between_the_ports_alone():
    scene = at_sea(lunars={'interval': 1000.0, 'sigma': 30.0})
    seen = Observations(scene).between(0, 10**18)
    lunars = seen.stamp_ns[seen.source == 'lunar']
    assert lunars.tolist() == [(50 + 1000 * k) * S for k in range(1, 40)]
    plain = Observations(at_sea()).between(0, 10**18)
    others = seen.source != 'lunar'
    np.testing.assert_array_equal(seen.stamp_ns[others], plain.stamp_ns)
    np.testing.assert_array_equal(seen.time_ref_ns[others], plain.time_ref_ns)
    assert seen.stamp_ns.tolist() == schedule(scene).tolist()


def test_clouds_hide_their_share_and_change_nothing_else():
    """Of 1989 observations: within 4 sigma of a binomial. Land is seen under them."""
    lunars = {'interval': 20.0}
    clear = Observations(at_sea(lunars=lunars)).between(0, 10**18)
    clouded = Observations(at_sea(lunars=lunars, clouds=0.4)).between(0, 10**18)
    seen = np.isin(clear.stamp_ns, clouded.stamp_ns)
    assert len(clouded.stamp_ns) == seen.sum()
    np.testing.assert_array_equal(clear.time_ref_ns[seen], clouded.time_ref_ns)
    n = len(seen)
    assert abs(seen.mean() - 0.6) < 4.0 * np.sqrt(0.24 / n)
    assert clouded.source[-1] == 'landfall'
    other = Observations(at_sea(lunars=lunars, clouds=0.4, seed=8)).between(0, 10**18)
    assert set(other.stamp_ns.tolist()) != set(clouded.stamp_ns.tolist())
    overcast = Observations(at_sea(lunars=lunars, clouds=1.0)).between(0, 10**18)
    assert overcast.source.tolist() == ['landfall']


@pytest.mark.parametrize(
    ('drift', 'said'),
    [
        ({'lunars': {'interval': 15.0}}, 'drift.lunars.interval = 15.0: is not a whole'),
        ({'lunars': {'sigma': 0.0}}, 'drift.lunars.sigma = 0.0: must be at least'),
        ({'clouds': 1.1}, 'drift.clouds = 1.1: must be at most 1'),
        ({'lunars': {}, 'voyage': None}, 'drift.lunars: needs a voyage'),
    ],
)
def test_what_cannot_be_observed_is_refused(drift, said):
    with pytest.raises(SceneError, match=said):
        scene_of(40_100.0, **{'voyage': VOYAGE, **drift})
