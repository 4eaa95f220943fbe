"""The route, the longitude by the clock, and the prize."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from in_pieces import feeds

from tauto_core import navigation as nav
from tauto_core import samples as s
from tauto_core.navigation.longitude import EQUATOR_M_PER_S, LiveFixes, fix_samples, wrap
from tauto_core.scene import load_scene
from tauto_core.scene.errors import EstimationError

S = 1_000_000_000


WAY = {'departure': [10.0, 20.0], 'arrival': [11.0, 21.0], 'sails_at': 20.0, 'arrives_at': 40.0}
SCENE = load_scene('ideal', duration=60.0, voyage=WAY)


def topics(stamps_s, raw_s, residual_s, sigma_s=0.5, *, latitude=0.0, longitude_deg=0.0):
    stamps = np.asarray(np.array(stamps_s) * S, np.int64)
    n = len(stamps)

    def clock(error_s):
        errors = np.rint(np.broadcast_to(error_s, n) * S).astype(np.int64)
        return s.TimeSamples(stamps, '', stamps + errors, s.same('', n))

    values = np.tile([0.0, sigma_s, 0.0, 0.0], (n, 1))
    place = (np.full(n, float(latitude)), np.full(n, float(longitude_deg)))
    return {
        s.SHIP_FIX: fix_samples(stamps, *place, np.ones((n, 3))),
        s.READING: clock(raw_s),
        s.CORRECTED: clock(residual_s),
        s.ESTIMATE: s.scalars(stamps, nav.ESTIMATE_NAMES, values),
    }


def errors_of(said, row=0):
    return dict(zip(nav.ERROR_NAMES, said[s.LONGITUDE_ERROR].position[row], strict=True))


def test_a_clock_four_seconds_fast_puts_the_ship_one_minute_west():
    said = nav.LongitudeStage(SCENE).feed(topics([1], 4.0, 2.0))
    assert errors_of(said) == {
        'raw_error_arcmin': -1.0,
        'raw_error_nmi': -1.0,
        'error_arcmin': -0.5,
        'error_nmi': -0.5,
        'sigma_nmi': 0.125,
    }
    fix = said[s.LONGITUDE_FIX]
    assert fix.longitude[0] == -0.5 / 60.0
    assert (fix.status[0], fix.position_covariance_type[0], fix.frame_id) == (0, 2, 'clock_mount')


def test_the_bits_of_a_cosine_do_not_depend_on_its_place():
    degrees = np.random.default_rng(1).uniform(-90.0, 90.0, 1001)
    for first in range(9):
        found = np.empty(len(degrees) - first)
        nav.longitude.cosines_of_degrees(degrees[first:], found)
        expected = [math.cos(math.radians(each)) for each in degrees[first:].tolist()]
        assert found.tolist() == expected


@pytest.mark.parametrize('latitude', [-66.6, 0.0, 50.79])
def test_the_east_sigma_is_the_seconds_along_the_parallel(latitude):
    """A second is 15″ of a circle of radius a cos φ, 1e-12 allows for rounding."""
    said = nav.LongitudeStage(SCENE).feed(topics([1, 2], 0.0, 0.0, 1.5, latitude=latitude))
    fix = said[s.LONGITUDE_FIX]
    second = math.radians(15.0 / 3600.0) * 6_378_137.0 * math.cos(math.radians(latitude))
    np.testing.assert_allclose(fix.position_covariance[:, 0], (1.5 * second) ** 2, rtol=1e-12)
    # 1 m² to the north and upwards, which no clock tells, and no correlations
    np.testing.assert_array_equal(fix.position_covariance[:, [4, 8]], 1.0)
    assert np.count_nonzero(fix.position_covariance) == 2 * 3
    # nautical miles of a globe with an equator of 21600 arc minutes
    miles = 1.5 * second / (2.0 * math.pi * 6_378_137.0 / 21_600.0)
    assert errors_of(said)['sigma_nmi'] == pytest.approx(miles, rel=1e-12)
    assert set(fix.status) == {0}


@pytest.mark.parametrize('lost_s', [43_204.0, 86_404.0, 10 * 86_400.0 + 4.0])
def test_the_error_of_the_longitude_is_within_half_a_turn(lost_s):
    """A dial shows the time of day: a clock that has lost a day and 4 s is 1′ out, to the east."""
    errors = errors_of(nav.LongitudeStage(SCENE).feed(topics([1], -lost_s, -lost_s)))
    expected = (0.25 * lost_s + 10_800.0) % 21_600.0 - 10_800.0
    assert [errors[name] for name in list(errors)[:4]] == [expected] * 4


def test_longitude_wraps_at_the_antimeridian():
    west = nav.LongitudeStage(SCENE).feed(topics([1], 0.0, 40.0, longitude_deg=-179.9))
    assert west[s.LONGITUDE_FIX].longitude[0] == pytest.approx(179.9 + 1.0 / 30.0, rel=1e-14)
    east = nav.LongitudeStage(SCENE).feed(topics([1], 0.0, -40.0, longitude_deg=179.9))
    assert east[s.LONGITUDE_FIX].longitude[0] == pytest.approx(-179.9 - 1.0 / 30.0, rel=1e-14)


@given(st.floats(-1e6, 1e6))
@example(-180.00000000000003)
@example(180.0)
def test_wrapped_longitudes_are_in_range_and_the_same_place(degrees):
    wrapped = wrap(np.array([degrees]))[0]
    assert -180.0 <= wrapped < 180.0
    assert math.remainder(wrapped - degrees, 360.0) == pytest.approx(0.0, abs=1e-9)
    if -180.0 <= degrees < 180.0:
        assert wrapped == degrees


def gathered(said):
    return [
        np.concatenate([np.ravel(getattr(batch[topic], field)) for batch in said if batch])
        for topic, field in (
            (s.LONGITUDE_FIX, 'stamp_ns'),
            (s.LONGITUDE_FIX, 'latitude'),
            (s.LONGITUDE_FIX, 'longitude'),
            (s.LONGITUDE_FIX, 'position_covariance'),
            (s.LONGITUDE_ERROR, 'stamp_ns'),
            (s.LONGITUDE_ERROR, 'position'),
        )
    ]


@settings(max_examples=25, deadline=None)
@given(st.data())
def test_neither_order_of_arrival_nor_chunks_nor_resuming_matter(data):
    rng = np.random.default_rng(4)
    parts = topics(np.arange(25), rng.normal(size=25), rng.normal(size=25), latitude=33.3)
    parts[s.SHIP_FIX].latitude[:] += rng.normal(size=25)
    # each topic lacks some stamp, and a fix is of the wrong kind
    parts[s.SHIP_FIX].status[9] = -1
    parts[s.READING] = s.take(parts[s.READING], np.arange(25) != 4)
    parts[s.ESTIMATE] = s.take(parts[s.ESTIMATE], np.arange(25) != 13)
    wanted = gathered([nav.LongitudeStage(SCENE).feed(parts)])
    assert len(wanted[0]) == 22
    first, second = nav.LongitudeStage(SCENE), nav.LongitudeStage(SCENE)
    pieces = data.draw(feeds(parts))
    cut = data.draw(st.integers(0, len(pieces)))
    said = [first.feed(piece) for piece in pieces[:cut]]
    second.restore(first.state())
    said += [second.feed(piece) for piece in pieces[cut:]]
    for one, other in zip(gathered(said), wanted, strict=True):
        np.testing.assert_array_equal(one, other, strict=True)
    assert second.finish() == {}
    counts = {name: n for name, n in second.health().items() if n}
    assert counts == {'fixes_invalid': 1, 'stamps_unjoined': 3}


def test_samples_out_of_order_or_without_a_place_are_counted():
    stage = nav.LongitudeStage(SCENE)
    stage.feed(topics([1, 2, 1, 3], 0.0, 0.0))
    assert stage.health()['out_of_order'] == 4
    bad = topics([4, 5, 6], 0.0, 0.0)
    bad[s.SHIP_FIX].latitude[:] = [np.nan, 90.5, 0.0]
    said = stage.feed(bad)
    assert list(said[s.LONGITUDE_FIX].stamp_ns) == [6 * S]
    counts = {name: n for name, n in stage.health().items() if n}
    assert counts == {'out_of_order': 4, 'fixes_invalid': 2, 'stamps_unjoined': 2}


def test_waiting_stamps_are_counted_at_the_end():
    stage = nav.LongitudeStage(SCENE)
    parts = topics([1, 2], 0.0, 0.0)
    del parts[s.CORRECTED]
    assert stage.feed(parts) == {}
    assert stage.finish() == {}
    assert stage.health()['stamps_unjoined'] == 2


def test_without_fixes_the_route_begins_at_the_first_reading():
    stage = nav.LongitudeStage(SCENE, expect_fix=False)
    parts = topics([1_700_000_000, 1_700_000_050], 0.0, 0.0)
    del parts[s.SHIP_FIX]
    said = stage.feed(parts)
    assert list(said[s.LONGITUDE_FIX].latitude) == [10.0, 11.0]
    assert list(said[s.LONGITUDE_FIX].longitude) == [20.0, 21.0]


def live_clock(fixes, seconds, max_age_s=10.0):
    """A live clock's longitude, second by second, with fixes (second, latitude, longitude)."""
    stage = nav.LongitudeStage(SCENE, live=LiveFixes(max_age_s))
    said, notices = [], []
    for second in range(1, seconds + 1):
        parts = topics([second], 4.0, 2.0)
        del parts[s.SHIP_FIX]
        for at, north, east in (fix for fix in fixes if fix[0] == second):
            parts[s.SHIP_FIX] = fix_samples(
                np.array([at * S]), np.array([north]), np.array([east]), np.ones((1, 3))
            )
        said.append(stage.feed(parts))
        notices.append(stage.notices)
    return stage, s.merged(said), notices


def test_a_live_clock_without_a_fix_has_no_place():
    _, said, notices = live_clock([], 3)
    assert not len(said[s.LONGITUDE_FIX].stamp_ns)
    assert 'no fix has come' in notices[-1][0]
    assert errors_of(said)['error_arcmin'] == -0.5
    assert math.isnan(errors_of(said)['error_nmi'])


def test_the_sigma_of_a_place_grows_with_the_age_of_its_fix():
    _, said, notices = live_clock([(2, 60.0, 5.0), (20, 60.0, 5.0)], 20)
    place = said[s.LONGITUDE_FIX]
    assert (place.stamp_ns // S).tolist() == [*range(2, 13), 20]
    # a chronometer is no satellite
    assert set(place.status) == {-1}
    east_m = EQUATOR_M_PER_S * math.cos(math.radians(60.0)) * 0.5
    age_s = np.array([*range(11), 0.0])
    np.testing.assert_allclose(place.position_covariance[:, 0], east_m**2 + (50.0 * age_s) ** 2)
    np.testing.assert_allclose(place.position_covariance[:, 4], 1.0 + (50.0 * age_s) ** 2)
    assert [bool(each) for each in notices] == [True] + [False] * 11 + [True] * 7 + [False]
    assert '11 s old' in notices[12][0]


@pytest.mark.parametrize(
    ('place', 'seconds', 'fault', 'count'),
    [
        ((50.0, 135.0), 5, 'fixes_out_of_reach', 5),
        ((50.01, -5.0), 5, 'fixes_out_of_reach', 5),
        ((50.0, -5.001), 5, '', 0),
        ((0.0, 0.0), 90, 'fixes_at_0_0', 90),
        ((50.0, 135.0), 90, 'fixes_moved', 1),
    ],
)
def test_a_place_out_of_reach_is_refused_until_it_persists(place, seconds, fault, count):
    """50 m/s are 0.0005 degrees a second. A blunder begins at 10 s, and a minute makes a place."""
    fixes = [(t, *(place if 10 <= t < 10 + seconds else (50.0, -5.0))) for t in range(1, 120)]
    stage, said, _ = live_clock(fixes, 120, max_age_s=100.0)
    assert stage.health()[fault or 'fixes_moved'] == count
    fix = said[s.LONGITUDE_FIX]
    is_there = (fix.latitude == place[0]) & (np.abs(fix.longitude + 0.5 / 60 - place[1]) < 1e-9)
    taken = np.flatnonzero(is_there) + 1
    first = {'fixes_moved': 70, '': 10}.get(fault)
    assert (int(taken[0]) if len(taken) else None) == first


def test_foreign_fixes_hold_until_the_next():
    stage = nav.LongitudeStage(SCENE, expect_fix=False)
    latitudes = []
    for step in range(6):
        parts = topics([200 + step], 0.0, 0.0)
        del parts[s.SHIP_FIX]
        if step in (2, 4):
            parts[s.SHIP_FIX] = topics([199.5 + step], 0.0, 0.0, latitude=40.0 + step)[s.SHIP_FIX]
        latitudes += stage.feed(parts)[s.LONGITUDE_FIX].latitude.tolist()
    assert latitudes == [10.0, 10.0, 42.0, 42.0, 44.0, 44.0]


def test_foreign_topics_hold_no_more_than_stated(monkeypatch):
    monkeypatch.setattr(nav.longitude, 'HELD', 5)
    stage = nav.LongitudeStage(SCENE, expect_fix=False)
    whole = topics(np.arange(20), 0.0, 0.0)
    assert len(stage.feed(whole)[s.LONGITUDE_FIX].stamp_ns) == 20
    stage.feed({s.READING: topics(np.arange(20, 40), 0.0, 0.0)[s.READING]})
    stage.feed({s.SHIP_FIX: topics(np.arange(20, 40), 0.0, 0.0)[s.SHIP_FIX]})
    held = stage.state()['held']
    assert [len(held[topic].stamp_ns) for topic in (s.READING, s.SHIP_FIX)] == [5, 5]
    assert stage.health()['stamps_unjoined'] == 15


def test_an_estimate_without_sigma_is_refused_by_name():
    parts = topics([1], 0.0, 0.0)
    parts[s.ESTIMATE] = s.scalars(parts[s.ESTIMATE].stamp_ns, ('offset_s',), np.zeros((1, 1)))
    with pytest.raises(EstimationError, match='offset_sigma_s is missing'):
        nav.LongitudeStage(SCENE).feed(parts)


def test_tally_keeps_the_last_and_the_worst():
    tally = nav.LongitudeTally()
    assert tally.result() is None
    said = nav.LongitudeStage(SCENE).feed(
        topics([1, 2, 3], [9.0, 9.0, 200.0], [4.0, -200.0, 140.0])
    )
    errors = said[s.LONGITUDE_ERROR]
    tally.feed({s.LONGITUDE_ERROR: s.take(errors, slice(0, 2))})
    assert tally.result()['worst_error_nmi'] == 50.0
    tally.feed({s.LONGITUDE_ERROR: s.take(errors, slice(2, 2))})
    tally.feed({s.LONGITUDE_ERROR: s.take(errors, slice(2, 3))})
    assert tally.result() == {
        'at_s': 2.0,
        'raw_error_arcmin': -50.0,
        'raw_error_nmi': -50.0,
        'error_arcmin': -35.0,
        'error_nmi': -35.0,
        'sigma_nmi': 0.125,
        'latitude_deg': None,
        'prize_pounds': None,
        'raw_prize_pounds': None,
        'unchecked_days': 2.0 / 86_400.0,
        'required_rate_s_per_day': None,
        'landfalls': [],
        'worst_since_s': 0.0,
        'worst_error_nmi': 50.0,
        'worst_at_s': 1.0,
        'worst_prize_pounds': None,
        'worst_raw_error_nmi': 50.0,
        'worst_raw_at_s': 2.0,
        'worst_raw_prize_pounds': None,
    }
    joined = nav.LongitudeTally()
    joined.feed({s.LONGITUDE_ERROR: s.join([errors])})
    assert joined.result() == tally.result()


def observed(*marks):
    stamps = np.array([round(at * S) for at, _ in marks], np.int64)
    return s.TimeSamples(stamps, '', stamps, np.array([source for _, source in marks], object))


def fed_in_chunks(said, marks, size):
    """Return the tally of chunks, each with the observations up to its end."""
    tally, told = nav.LongitudeTally(), 0
    errors, fix = said[s.LONGITUDE_ERROR], said[s.LONGITUDE_FIX]
    for first in range(0, len(errors.stamp_ns), size):
        part = s.take(errors, slice(first, first + size))
        reached = sum(at * S <= part.stamp_ns[-1] for at, _ in marks)
        batches = {s.OBSERVATION: observed(*marks[told:reached]), s.LONGITUDE_ERROR: part}
        told = reached
        tally.feed(batches | {s.LONGITUDE_FIX: s.take(fix, slice(first, first + size))})
    return tally.result()


def test_landfalls_are_judged_by_what_the_clock_told_before():
    days = np.arange(0, 100.0, 0.25)
    raw = 2.0 * days
    # the estimate is put right by the observations at 20 and 81.25 days
    corrected = np.where(days < 20.0, days, np.where(days < 81.25, days - 20.0, 0.0))
    said = nav.LongitudeStage(SCENE).feed(topics(86_400 * days, raw, corrected, latitude=60.0))
    marks = [(0.0, 'port'), (20.0, 'landfall'), (81.25, 'landfall')]
    marks = [(86_400.0 * day, source) for day, source in marks]
    found = fed_in_chunks(said, marks, 1000)
    madeira, jamaica = found['landfalls']
    assert (madeira['at_s'] / 86_400.0, jamaica['at_s'] / 86_400.0) == (19.75, 81.0)
    # a quarter of a mile a second, half of it at 60 degrees
    assert madeira['error_nmi'] == pytest.approx(-19.75 / 8.0)
    assert jamaica['error_nmi'] == pytest.approx(-61.0 / 8.0)
    assert jamaica['raw_error_nmi'] == pytest.approx(-162.0 / 8.0)
    assert found['error_nmi'] == jamaica['error_nmi']
    assert found['prize_pounds'] == found['raw_prize_pounds'] == 20_000
    assert found['worst_prize_pounds'] == 20_000
    # Madeira is no trial: it was less than six weeks from port
    assert madeira['prize_pounds'] is madeira['required_rate_s_per_day'] is None
    assert (madeira['unchecked_days'], jamaica['unchecked_days']) == (19.75, 61.0)
    # 30 miles are 240 s at 60 degrees
    assert jamaica['required_rate_s_per_day'] == pytest.approx(240.0 / 61.0)
    assert found['worst_at_s'] == jamaica['at_s']
    assert found['worst_raw_error_nmi'] == pytest.approx(2.0 * 99.75 / 8.0)
    # lunar distances are no check of the clock where the longitude is known
    at_sea = sorted([*marks, (86_400.0 * 10.0, 'lunar'), (86_400.0 * 60.0, 'lunar')])
    assert fed_in_chunks(said, at_sea, 1000) == found
    for size in (1, 7, 80, 81):
        assert fed_in_chunks(said, marks, size) == found


def test_the_worst_moment_is_at_sea():
    """The errors of the first two days are of a clock that is not rated yet."""
    days = np.arange(0, 10.0, 0.5)
    error = np.where(days < 2.0, 400.0, 40.0 * days)
    said = nav.LongitudeStage(SCENE).feed(topics(86_400 * days, -error, error))
    marks = [(86_400.0 * day, 'port') for day in (0.0, 1.0, 2.0)]
    found = fed_in_chunks(said, marks, 1000)
    assert found['worst_error_nmi'] == found['worst_raw_error_nmi'] == 95.0
    assert found['worst_at_s'] == found['worst_raw_at_s'] == 9.5 * 86_400
    assert found['worst_since_s'] == 2.0 * 86_400
    # at sea from 2 days on, at that instant already
    ended = (
        s.take(said[s.LONGITUDE_ERROR], slice(0, 5)),
        s.take(said[s.LONGITUDE_FIX], slice(0, 5)),
    )
    short = dict(zip((s.LONGITUDE_ERROR, s.LONGITUDE_FIX), ended, strict=True))
    assert fed_in_chunks(short, marks, 1000)['worst_error_nmi'] == 20.0
    for size in (1, 3, 4, 5):
        assert fed_in_chunks(said, marks, size) == found
    # observed for the last time after the last reading
    marks = [*marks, (86_400.0 * 11.0, 'port')]
    tally = nav.LongitudeTally()
    tally.feed({s.OBSERVATION: observed(*marks), s.LONGITUDE_ERROR: said[s.LONGITUDE_ERROR]})
    found = tally.result()
    assert found['worst_at_s'] == found['worst_since_s'] == 9.5 * 86_400


def test_a_landfall_nothing_is_known_of_beforehand_is_not_judged():
    said = nav.LongitudeStage(SCENE).feed(topics([5, 6], 4.0, 0.0))
    late = nav.LongitudeTally()
    late.feed(said)
    late.feed({s.OBSERVATION: observed((6.0, 'landfall'))})
    assert late.result()['landfalls'] == []
    early = fed_in_chunks(said, [(5.0, 'landfall')], 2)
    assert early['landfalls'] == []
    assert early['at_s'] == 1.0
    assert early['unchecked_days'] == pytest.approx(1.0 / 86_400.0)


def test_the_act_requires_three_seconds_a_day():
    """Half a degree, 120 s, after six weeks: 2.86 s/day on the equator (domain.md 3)."""
    assert nav.required_rate_s_per_day(42.0, 0.0) == pytest.approx(120.0 / 42.0, rel=1e-15)
    assert nav.required_rate_s_per_day(42.0, -60.0) == pytest.approx(240.0 / 42.0, rel=1e-15)
    with pytest.raises(EstimationError, match=r'days = 0\.0'):
        nav.required_rate_s_per_day(0.0, 0.0)


@pytest.mark.parametrize(
    ('distance_nmi', 'pounds'),
    [
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
    assert nav.prize_pounds(distance_nmi) == pounds


@pytest.mark.parametrize('distance_nmi', [math.nan, -1.0])
def test_the_act_does_not_judge_what_is_no_distance(distance_nmi):
    with pytest.raises(EstimationError, match=str(distance_nmi)):
        nav.prize_pounds(distance_nmi)


# -----------------------------------------------------------------------------
# The route against published geodesics and the sphere.

DAY = 86_400


def route_of(**voyage):
    given = {'starts_at': 100.0, 'duration': 100.0 * DAY, 'drift': {'observation_interval': DAY}}
    return nav.Route(load_scene('ideal', **given, **({'voyage': voyage} if voyage else {})))


def stamps(*days):
    return np.array([(100 + round(day * DAY)) * S for day in days], np.int64)


def test_length_is_the_published_one():
    """Wellington to Salamanca, example of the documentation of geographiclib."""
    departure, arrival, length_m = (-41.32, 174.81), (40.96, -5.50), 19959679.267
    ends = {'departure': list(departure), 'arrival': list(arrival)}
    route = route_of(**ends, sails_at=14.0 * DAY, arrives_at=95.0 * DAY)
    assert route.length_m == pytest.approx(length_m, abs=1e-3)
    # the ship waits, sails and stays
    fix = route.fixes(stamps(0, 14, 95, 99))
    np.testing.assert_allclose(fix.latitude, np.repeat([departure[0], arrival[0]], 2))
    np.testing.assert_allclose(fix.longitude, np.repeat([departure[1], arrival[1]], 2))


def test_without_a_voyage_the_ship_lies_where_a_minute_is_a_mile():
    fix = route_of().fixes(stamps(0, 50))
    np.testing.assert_array_equal(fix.latitude, 0.0)
    np.testing.assert_array_equal(fix.longitude, 0.0)
    assert (fix.frame_id, set(fix.status), set(fix.position_covariance_type)) == (
        'clock_mount',
        {0},
        {2},
    )
    np.testing.assert_array_equal(fix.position_covariance, np.tile(np.eye(3).ravel(), (2, 1)))
