"""The drift stage: joins, order of arrival, chunks, resuming, refusals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from in_pieces import feeds, split, times

from tauto_core import samples as s
from tauto_core.navigation import ESTIMATE_NAMES, DriftStage, drift
from tauto_core.navigation.kalman import Estimate
from tauto_core.scene import load_scene
from tauto_core.ship.source import Observations, schedule

S = 1_000_000_000


def scene_of(duration=60.0, states=2):
    drift = {'observation_interval': 7.0, 'prior_rate_sigma': 10.0, 'states': states, 'gate': 1e9}
    given = {'duration': duration, 'starts_at': 100.0, 'log': {'interval': 1.0}}
    return load_scene('ideal', **given, drift=drift)


def readings_of(scene, rate_s=0.003):
    at = scene.starts_at + np.arange(scene.log_count)
    return times(at, rate_s * (at - scene.starts_at) + 0.01 * np.sin(at))


def observations_of(scene):
    return Observations(scene).between(0, 10**18)


def run(stage, feeds):
    said = [stage.feed(batches) for batches in feeds]
    said.append(stage.finish())
    return {
        topic: s.join(found)
        for topic in stage.outputs
        if (found := [batches[topic] for batches in said if topic in batches])
    }


def assert_same(one, other):
    assert one.keys() == other.keys()
    for topic in one:
        np.testing.assert_array_equal(one[topic].stamp_ns, other[topic].stamp_ns, strict=True)
    np.testing.assert_array_equal(
        one[s.ESTIMATE].position, other[s.ESTIMATE].position, strict=True
    )
    np.testing.assert_array_equal(one[s.CORRECTED].time_ref_ns, other[s.CORRECTED].time_ref_ns)


SCENES = {states: scene_of(states=states) for states in (2, 3)}


@settings(max_examples=80, deadline=None)
@given(st.data(), st.sampled_from([2, 3]))
def test_neither_order_of_arrival_nor_chunks_nor_resuming_matter(data, states):
    scene = SCENES[states]
    topics = {s.READING: readings_of(scene), s.OBSERVATION: observations_of(scene)}
    whole = run(DriftStage(scene), [topics])
    pieces = data.draw(feeds(topics))
    assert_same(run(DriftStage(scene), pieces), whole)
    cut = data.draw(st.integers(0, len(pieces)))
    first, second = DriftStage(scene), DriftStage(scene)
    said = [first.feed(piece) for piece in pieces[:cut]]
    second.restore(first.state())
    later = run(second, pieces[cut:]) if len(pieces) > cut else second.finish()
    said.append(later)
    resumed = {t: s.join([part[t] for part in said if t in part]) for t in DriftStage.outputs}
    assert_same(resumed, whole)
    assert not any(second.health().values())


def test_an_observation_counts_from_its_own_stamp_on():
    scene = scene_of()
    said = run(DriftStage(scene), [{s.READING: times([100, 101, 107, 108], 2.0)}])
    # never observed: the prior
    np.testing.assert_array_equal(said[s.ESTIMATE].position[:, 0], 0.0)
    seen = run(
        DriftStage(scene),
        [{s.READING: times([100, 106, 107, 108], 2.0), s.OBSERVATION: times([100, 107])}],
    )
    offset, sigma = seen[s.ESTIMATE].position[:, :2].T
    # a setting of 10 sigmas has 1/101 of the weight: 100/101 of the observed 2 s at once
    assert offset[0] == pytest.approx(200.0 / 101.0, rel=1e-15)
    assert sigma[0] == pytest.approx(0.5 * np.sqrt(100.0 / 101.0), rel=1e-15)
    assert offset[1] == offset[0]
    assert sigma[1] > sigma[0]
    assert offset[2] > offset[1]
    assert sigma[2] < sigma[1]
    assert seen[s.ESTIMATE].name == ESTIMATE_NAMES
    assert (
        list(seen[s.CORRECTED].time_ref_ns - seen[s.CORRECTED].stamp_ns)[:2]
        == [round(2 * S / 101)] * 2
    )
    assert set(seen[s.CORRECTED].source) == {'corrected'}


def test_a_variance_that_rounding_made_negative_is_no_certainty():
    x, y, d, xx, xy, xd, yy, yd, dd = (np.array([v]) for v in (1, 0, 0, -1, 0, 0, 4, 0, 0))
    now = Estimate(x, y, d, xx, xy, xd, yy, yd, dd)
    assert drift.estimate_values(now, ()).tolist() == [[1.0, np.inf, 0.0, 2.0 * 86400.0]]


def test_readings_wait_for_the_scheduled_observation():
    scene = scene_of()
    assert list(schedule(scene)[:3]) == [100 * S, 107 * S, 114 * S]
    stage = DriftStage(scene)
    assert stage.feed({s.READING: times([100, 101, 107, 108])}) == {}
    first = stage.feed({s.OBSERVATION: times([100])})
    assert list(first[s.ESTIMATE].stamp_ns) == [100 * S, 101 * S]
    # the one at 107 s is lost: the next one releases
    rest = stage.feed({s.OBSERVATION: times([114])})
    assert list(rest[s.CORRECTED].stamp_ns) == [107 * S, 108 * S]
    assert stage.finish() == {}
    health = stage.health()
    assert (health['observations_missing'], health['observations_unmatched']) == (1, 1)


def test_observations_that_do_not_belong_are_refused_and_counted():
    scene = scene_of()
    wanted = [{s.READING: readings_of(scene), s.OBSERVATION: observations_of(scene)}]
    stage = DriftStage(scene)
    foreign = times([103.0, 100.0, 100.0, 107.0, 99.0], 50.0)
    first, rest = s.take(foreign, slice(0, 1)), s.take(foreign, slice(2, None))
    mixed = s.join([first, observations_of(scene), rest])
    assert_same(
        run(stage, [{s.READING: readings_of(scene), s.OBSERVATION: mixed}]),
        run(DriftStage(scene), wanted),
    )
    health = stage.health()
    assert health['observations_unscheduled'] == 1
    assert health['observations_out_of_order'] == 3
    assert health['observations_missing'] == 0


def test_readings_out_of_order_are_refused_and_counted():
    scene = scene_of()
    stage = DriftStage(scene, expect_schedule=False)
    said = run(stage, [{s.READING: times([100, 102, 101, 102])}, {s.READING: times([99, 103])}])
    assert list(said[s.ESTIMATE].stamp_ns) == [100 * S, 102 * S, 103 * S]
    assert stage.health()['readings_out_of_order'] == 3


def test_foreign_observations_count_when_they_come():
    scene = scene_of()
    stage = DriftStage(scene, expect_schedule=False)
    # Unix time: the estimate starts at the first reading, not at the scene's start
    start = 1_700_000_000
    early = stage.feed({s.READING: times([start, start + 10], [0.0, 4.0])})
    assert early[s.ESTIMATE].position[1, 3] == pytest.approx(10.0, rel=1e-3)
    # late: half way between the readings, where the line gives 2 s
    late = stage.feed({s.OBSERVATION: times([start + 5])})
    assert late == {}
    after = stage.feed({s.READING: times([start + 20], [8.0])})
    offset = after[s.ESTIMATE].position[0, 0]
    # a setting of 10 sigmas has 1/101 of the weight
    assert offset == pytest.approx(200.0 / 101.0, rel=1e-4)
    # of the future: waits, and the reading at its own stamp uses it
    stage.feed({s.OBSERVATION: times([start + 30])})
    before = stage.feed({s.READING: times([start + 29], [12.0])})
    assert before[s.ESTIMATE].position[0, 0] == pytest.approx(offset, abs=1e-3)
    at = stage.feed({s.READING: times([start + 30], [12.0])})
    assert at[s.ESTIMATE].position[0, 0] > 3.0
    assert not any(stage.health().values())


def test_foreign_observations_older_than_the_history_are_refused(monkeypatch):
    monkeypatch.setattr(drift, 'HISTORY', 3)
    stage = DriftStage(scene_of(), expect_schedule=False)
    stage.feed({s.OBSERVATION: times([99])})
    stage.feed({s.READING: times(np.arange(100, 110))})
    stage.feed({s.OBSERVATION: times([106.5], 1.0)})
    assert stage.health()['observations_too_old'] == 2
    stage.feed({s.OBSERVATION: times([107.5], 1.0)})
    said = stage.feed({s.READING: times([110])})
    assert said[s.ESTIMATE].position[0, 0] == pytest.approx(-100.0 / 101.0, rel=1e-4)
    assert stage.health()['observations_too_old'] == 2
    assert len(stage.state()['stamp']) == 3


def test_a_missing_reading_is_bridged_by_its_neighbours():
    scene = scene_of(duration=14.0)
    exact = [{s.READING: times(np.arange(100, 115), 3.0), s.OBSERVATION: times([100, 107, 114])}]
    gap = [{s.READING: times([100, 106, 108, 114], 3.0), s.OBSERVATION: times([100, 107, 114])}]
    whole, bridged = run(DriftStage(scene), exact), run(DriftStage(scene), gap)
    np.testing.assert_array_equal(
        bridged[s.ESTIMATE].position, whole[s.ESTIMATE].position[[0, 6, 8, 14]]
    )


def test_foreign_observations_of_the_past_are_put_in_their_place():
    scene = scene_of()
    readings = readings_of(scene)
    first, second = split(readings, [40])
    seen = observations_of(scene)
    order = [0, 1, 3, 5, 2, 4]
    stage = DriftStage(scene, expect_schedule=False)
    stage.feed({s.READING: first})
    for k in order:
        stage.feed({s.OBSERVATION: s.take(seen, slice(k, k + 1))})
    said = stage.feed({s.READING: second})
    known = s.take(seen, slice(0, 6))
    in_order = DriftStage(scene, expect_schedule=False)
    wanted = run(in_order, [{s.READING: readings, s.OBSERVATION: known}])
    late = {topic: s.take(samples, slice(40, None)) for topic, samples in wanted.items()}
    assert_same(said, late)
    assert stage.health()['observations_delayed'] == 2
    # what came once is not believed twice
    stage.feed({s.OBSERVATION: s.take(seen, slice(2, 4))})
    assert stage.health()['observations_repeated'] == 2


def test_foreign_observations_of_a_later_day_are_refused():
    stage = DriftStage(scene_of(), expect_schedule=False)
    # the clock is unknown yet: it may belong to what comes
    stage.feed({s.OBSERVATION: times([300_000])})
    stage.feed({s.READING: times([100, 101])})
    stage.feed({s.OBSERVATION: times([101 + 86_400, 102 + 86_400, 1_700_000_000])})
    assert stage.health()['observations_from_future'] == 2
    stage.finish()
    assert stage.health()['observations_unmatched'] == 2
