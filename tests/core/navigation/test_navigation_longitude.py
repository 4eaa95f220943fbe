"""Longitude: signs by hand, joins, wrapping, covariance, the tally and the prize."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tauto_core.navigation import (
    ERROR_NAMES,
    ESTIMATE_NAMES,
    LongitudeStage,
    LongitudeTally,
    longitude,
    prize_pounds,
)
from tauto_core.navigation.longitude import wrap_degrees
from tauto_core.navigation.route import fix_samples
from tauto_core.samples import (
    CORRECTED,
    ESTIMATE,
    LONGITUDE_ERROR,
    LONGITUDE_FIX,
    READING,
    SHIP_FIX,
    TimeSamples,
    join,
    same,
    scalars,
    take,
)
from tauto_core.scene import parse_scene
from tauto_core.scene.errors import EstimationError

S = 1_000_000_000
SCENE = parse_scene(
    """
duration: 60.0
trochlea:
  inertia: 4.0e-4
  cam: {kind: involute, base_radius: 0.010}
  thread: {kind: vertical}
  power: {kind: force, force: 2.0}
  release_angle: 1.0
voyage: {departure: [10.0, 20.0], arrival: [11.0, 21.0], sails_at: 20.0, arrives_at: 40.0}
""",
    'test',
)


def topics(stamps_s, raw_s, residual_s, sigma_s=0.5, *, latitude=0.0, longitude_deg=0.0):
    stamps = np.asarray(np.array(stamps_s) * S, np.int64)
    n = len(stamps)

    def clock(error_s):
        errors = np.rint(np.broadcast_to(error_s, n) * S).astype(np.int64)
        return TimeSamples(stamps, '', stamps + errors, same('', n))

    values = np.tile([0.0, sigma_s, 0.0, 0.0], (n, 1))
    place = (np.full(n, float(latitude)), np.full(n, float(longitude_deg)))
    return {
        SHIP_FIX: fix_samples(stamps, *place, np.ones((n, 3))),
        READING: clock(raw_s),
        CORRECTED: clock(residual_s),
        ESTIMATE: scalars(stamps, ESTIMATE_NAMES, values),
    }


def errors_of(said, row=0):
    return dict(zip(ERROR_NAMES, said[LONGITUDE_ERROR].position[row], strict=True))


def test_a_clock_four_seconds_fast_puts_the_ship_one_minute_west():
    said = LongitudeStage(SCENE).feed(topics([1], 4.0, 2.0))
    assert errors_of(said) == {
        'raw_error_arcmin': -1.0,
        'raw_error_nmi': -1.0,
        'error_arcmin': -0.5,
        'error_nmi': -0.5,
        'sigma_nmi': 0.125,
    }
    fix = said[LONGITUDE_FIX]
    assert fix.longitude[0] == -0.5 / 60.0
    assert (fix.status[0], fix.position_covariance_type[0], fix.frame_id) == (0, 2, 'clock_mount')


def test_harrisons_h4_at_jamaica():
    # 5.1 s slow: 1.275' too far east, 1.21 nautical miles at 18 degrees north (domain.md 3)
    said = LongitudeStage(SCENE).feed(
        topics([1], -5.1, -5.1, 0.0, latitude=18.0, longitude_deg=-76.8)
    )
    errors = errors_of(said)
    assert errors['error_arcmin'] == pytest.approx(1.275, rel=1e-12)
    assert errors['error_nmi'] == pytest.approx(1.21, abs=0.005)
    assert said[LONGITUDE_FIX].longitude[0] > -76.8
    assert said[LONGITUDE_FIX].latitude[0] == 18.0


def test_east_variance_is_the_clocks():
    said = LongitudeStage(SCENE).feed(topics([1], 0.0, 0.0, 2.0, latitude=60.0))
    covariance = said[LONGITUDE_FIX].position_covariance[0].reshape(3, 3)
    # 463.8 m/s on the equator (domain.md 4), half of it at 60 degrees, to four digits
    assert math.sqrt(covariance[0, 0]) == pytest.approx(463.8, rel=1e-4)
    assert covariance[1, 1] == covariance[2, 2] == 1.0
    assert np.count_nonzero(covariance) == 3


def test_longitude_wraps_at_the_antimeridian():
    west = LongitudeStage(SCENE).feed(topics([1], 0.0, 40.0, longitude_deg=-179.9))
    assert west[LONGITUDE_FIX].longitude[0] == pytest.approx(179.9 + 1.0 / 30.0, rel=1e-14)
    east = LongitudeStage(SCENE).feed(topics([1], 0.0, -40.0, longitude_deg=179.9))
    assert east[LONGITUDE_FIX].longitude[0] == pytest.approx(-179.9 - 1.0 / 30.0, rel=1e-14)


@given(st.floats(-1e6, 1e6))
@example(-180.00000000000003)
@example(180.0)
def test_wrapped_longitudes_are_in_range_and_the_same_place(degrees):
    wrapped = wrap_degrees(np.array([degrees]))[0]
    assert -180.0 <= wrapped < 180.0
    assert math.remainder(wrapped - degrees, 360.0) == pytest.approx(0.0, abs=1e-9)
    if -180.0 <= degrees < 180.0:
        assert wrapped == degrees


@st.composite
def feeds(draw, parts):
    queues = {}
    for topic, samples in parts.items():
        n = len(samples.stamp_ns)
        edges = [0, *sorted(draw(st.lists(st.integers(0, n), max_size=6))), n]
        queues[topic] = [take(samples, slice(a, b)) for a, b in pairwise(edges)]
    order = draw(st.permutations([t for t, queue in queues.items() for _ in queue]))
    return [{topic: queues[topic].pop(0)} for topic in order]


def gathered(said):
    return [
        np.concatenate([np.ravel(getattr(batch[topic], field)) for batch in said if batch])
        for topic, field in (
            (LONGITUDE_FIX, 'stamp_ns'),
            (LONGITUDE_FIX, 'latitude'),
            (LONGITUDE_FIX, 'longitude'),
            (LONGITUDE_FIX, 'position_covariance'),
            (LONGITUDE_ERROR, 'stamp_ns'),
            (LONGITUDE_ERROR, 'position'),
        )
    ]


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_neither_order_of_arrival_nor_chunks_nor_resuming_matter(data):
    rng = np.random.default_rng(4)
    parts = topics(np.arange(25), rng.normal(size=25), rng.normal(size=25), latitude=33.3)
    parts[SHIP_FIX].latitude[:] += rng.normal(size=25)
    # each topic lacks some stamp, and a fix is of the wrong kind
    parts[SHIP_FIX].status[9] = -1
    parts[READING] = take(parts[READING], np.arange(25) != 4)
    parts[ESTIMATE] = take(parts[ESTIMATE], np.arange(25) != 13)
    wanted = gathered([LongitudeStage(SCENE).feed(parts)])
    assert len(wanted[0]) == 22
    first, second = LongitudeStage(SCENE), LongitudeStage(SCENE)
    pieces = data.draw(feeds(parts))
    cut = data.draw(st.integers(0, len(pieces)))
    said = [first.feed(piece) for piece in pieces[:cut]]
    second.restore(first.state())
    said += [second.feed(piece) for piece in pieces[cut:]]
    for one, other in zip(gathered(said), wanted, strict=True):
        np.testing.assert_array_equal(one, other, strict=True)
    assert second.finish() == {}
    assert second.health() == {'out_of_order': 0, 'fixes_invalid': 1, 'stamps_unjoined': 3}


def test_samples_out_of_order_or_without_a_place_are_counted():
    stage = LongitudeStage(SCENE)
    stage.feed(topics([1, 2, 1, 3], 0.0, 0.0))
    assert stage.health()['out_of_order'] == 4
    bad = topics([4, 5, 6], 0.0, 0.0)
    bad[SHIP_FIX].latitude[:] = [np.nan, 90.5, 0.0]
    said = stage.feed(bad)
    assert list(said[LONGITUDE_FIX].stamp_ns) == [6 * S]
    assert stage.health() == {'out_of_order': 4, 'fixes_invalid': 2, 'stamps_unjoined': 2}


def test_waiting_stamps_are_counted_at_the_end():
    stage = LongitudeStage(SCENE)
    parts = topics([1, 2], 0.0, 0.0)
    del parts[CORRECTED]
    assert stage.feed(parts) == {}
    assert stage.finish() == {}
    assert stage.health()['stamps_unjoined'] == 2


def test_without_fixes_the_scenes_route_counts_from_the_first_reading():
    stage = LongitudeStage(SCENE, expect_fix=False)
    parts = topics([1_700_000_000, 1_700_000_050], 0.0, 0.0)
    del parts[SHIP_FIX]
    said = stage.feed(parts)
    assert list(said[LONGITUDE_FIX].latitude) == [10.0, 11.0]
    assert list(said[LONGITUDE_FIX].longitude) == [20.0, 21.0]


def test_foreign_fixes_hold_until_the_next():
    stage = LongitudeStage(SCENE, expect_fix=False)
    latitudes = []
    for step in range(6):
        parts = topics([200 + step], 0.0, 0.0)
        del parts[SHIP_FIX]
        if step in (2, 4):
            parts[SHIP_FIX] = topics([199.5 + step], 0.0, 0.0, latitude=40.0 + step)[SHIP_FIX]
        latitudes += stage.feed(parts)[LONGITUDE_FIX].latitude.tolist()
    assert latitudes == [10.0, 10.0, 42.0, 42.0, 44.0, 44.0]


def test_foreign_topics_hold_no_more_than_stated(monkeypatch):
    monkeypatch.setattr(longitude, 'HELD', 5)
    stage = LongitudeStage(SCENE, expect_fix=False)
    whole = topics(np.arange(20), 0.0, 0.0)
    assert len(stage.feed(whole)[LONGITUDE_FIX].stamp_ns) == 20
    stage.feed({READING: topics(np.arange(20, 40), 0.0, 0.0)[READING]})
    stage.feed({SHIP_FIX: topics(np.arange(20, 40), 0.0, 0.0)[SHIP_FIX]})
    held = stage.state()['held']
    assert [len(held[topic].stamp_ns) for topic in (READING, SHIP_FIX)] == [5, 5]
    assert stage.health()['stamps_unjoined'] == 15


def test_an_estimate_without_sigma_is_refused_by_name():
    parts = topics([1], 0.0, 0.0)
    parts[ESTIMATE] = scalars(parts[ESTIMATE].stamp_ns, ('offset_s',), np.zeros((1, 1)))
    with pytest.raises(EstimationError, match='offset_sigma_s is missing'):
        LongitudeStage(SCENE).feed(parts)


def test_tally_keeps_the_last_and_the_worst():
    tally = LongitudeTally()
    assert tally.result() is None
    said = LongitudeStage(SCENE).feed(topics([1, 2, 3], [9.0, 9.0, 200.0], [4.0, -200.0, 140.0]))
    errors = said[LONGITUDE_ERROR]
    tally.feed(take(errors, slice(0, 2)))
    assert tally.result()['prize_pounds'] == 10_000
    tally.feed(take(errors, slice(2, 2)))
    tally.feed(take(errors, slice(2, 3)))
    assert tally.result() == {
        'raw_error_arcmin': -50.0,
        'raw_error_nmi': -50.0,
        'error_arcmin': -35.0,
        'error_nmi': -35.0,
        'sigma_nmi': 0.125,
        'worst_error_nmi': 50.0,
        'prize_pounds': 15_000,
    }
    joined = LongitudeTally()
    joined.feed(join([errors]))
    assert joined.result() == tally.result()


@pytest.mark.parametrize(
    ('distance_nmi', 'pounds'),
    [
        (0.0, 20_000),
        (30.0, 20_000),
        (math.nextafter(30.0, 31.0), 15_000),
        (40.0, 15_000),
        (math.nextafter(40.0, 41.0), 10_000),
        (60.0, 10_000),
        (math.nextafter(60.0, 61.0), 0),
        (math.inf, 0),
    ],
)
def test_the_act_pays_by_distance(distance_nmi, pounds):
    assert prize_pounds(distance_nmi) == pounds


@pytest.mark.parametrize('distance_nmi', [math.nan, -1.0])
def test_the_act_does_not_judge_what_is_no_distance(distance_nmi):
    with pytest.raises(EstimationError, match=str(distance_nmi)):
        prize_pounds(distance_nmi)
