"""The regressors of all three accelerations and of gravity, against closed forms and rates."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from in_pieces import integrated
from scipy.spatial.transform import Rotation

from tauto_core import samples as s
from tauto_core.machines import compile_machine, steady_swing
from tauto_core.navigation import DriftStage, drift_warnings, estimate_names
from tauto_core.navigation.covariates import coefficients, runs
from tauto_core.navigation.longitude import fix_samples
from tauto_core.navigation.regressors import Regressors, regressors
from tauto_core.scene import load_scene, parse_scene
from tauto_core.scene.errors import SceneError
from tauto_core.scene.times import DAY_S
from tauto_core.ship import ShipMotion
from tauto_core.ship.imu import imu_from_roll
from tauto_core.ship.passage import eotvos, gravity_between, normal_gravity
from tauto_core.voyage import sail

S = 1_000_000_000
G = 9.80665

# -----------------------------------------------------------------------------
# A hull: what shakes the clock, by the plane in which its thread can lean.


HEAVE = {'covariates': ['heave'], 'coefficients': {'heave': {'value': 1.0, 'sigma': 0.05}}}
HULL = {
    'kind': 'sea',
    'sea': {'spectrum': 'bretschneider', 'significant_wave_height': 2.5, 'peak_period': 9.0},
    'roll': {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': 0.7},
    'hull': {'shape': 'sloop', 'length': 34.0},
    'clock': {'forward': 5.0, 'port': 0.0},
    'height': 1.0,
    'rate': 10.0,
}


def hull_scene(heading, plane, thread, power):
    trochlea = {'inertia': 4e-4, 'release_angle': 1.0, 'plane': plane, 'thread': thread}
    trochlea |= {'cam': {'kind': 'involute', 'base_radius': 0.010}, 'power': power}
    given = {'duration': 7200.0, 'clock': {}, 'drift': HEAVE, 'gravity': G}
    return load_scene('ideal', **given, trochlea=trochlea, ship=HULL | {'heading': heading})


PLAIN = {'kind': 'vertical'}, {'kind': 'weight', 'mass': 0.16, 'massless': True}
SWINGING = {'kind': 'hanging', 'length': 1.0}, {'kind': 'weight', 'mass': 0.3}


def parts_of(imu, plane, end):
    """Mean of the static formula's parts: up and down, and sideways, by rotation matrices."""
    ship = Rotation.from_quat(imu.orientation)
    yaw = Rotation.from_euler('z', ship.as_euler('ZYX')[:, :1])
    level = (yaw.inv() * ship).apply(imu.linear_acceleration)[:end]
    aside = level[:, 1] ** 2
    if plane != 'vertical':
        aside = aside + level[:, 0] ** 2
    if plane == 'ship':
        aside = aside - imu.linear_acceleration[:end, 0] ** 2
    return -np.var(level[:, 2]) / (8.0 * G * G), np.mean(aside) / (4.0 * G * G)


@pytest.mark.parametrize('plane', ['free', 'vertical', 'ship'])
@pytest.mark.parametrize('heading', [math.pi, 0.5 * math.pi], ids=['head', 'beam'])
def test_a_hull_changes_the_rate_by_what_the_regressor_says(heading, plane):
    """Of a weight on a linear wheel; waves of 2 s and more are not much slower than its second.

    Up and down the correction is (Ω/2ω)², 1 to 3 %, so 3 % of both parts: these may cancel.
    """
    scene = hull_scene(heading, plane, *PLAIN)
    motion = ShipMotion(scene)
    imu = motion.produce(motion.total)
    found = Regressors(scene, live=False)
    found.feed({s.SHIP_IMU: imu})
    ends = scene.starts_at_ns + np.array([0, scene.duration_ns])
    (mean,) = np.diff(found.at(ends)[:, 0]) / scene.duration
    lifted, shaken = parts_of(imu, plane, scene.samples)
    # the running mean costs 1/(300 s Ω)² of the heave, its start a little more
    assert mean == pytest.approx(lifted + shaken, abs=3e-4 * (shaken - lifted))
    rate = sail(scene).clock_error_s[-1] / scene.duration
    assert rate == pytest.approx(mean, abs=0.03 * (shaken - lifted))


def test_a_thread_that_swings_takes_more_of_the_sway():
    """By 1/(1 - l Ω²/g)², with the ship's sway at Ω. Its damping costs (2 ζ Ω/ω)² of that."""
    period_s, length = 8.0, 1.0
    n = 20 * 1000
    stamps, none = 50_000_000 * np.arange(n), np.zeros(n)
    omega = math.tau / period_s
    sway = 0.5 * np.sin(omega * 0.05 * np.arange(n))
    grown = []
    for machine in (PLAIN, SWINGING):
        scene = hull_scene(0.0, 'vertical', *machine)
        source = Regressors(scene, live=False)
        source.feed({s.SHIP_IMU: imu_from_roll(stamps, none, none, sway, none + G)})
        (row,) = np.diff(source.at(np.array([200 * S, 1000 * S]))[:, 0])
        grown.append(row)
    assert grown[0] == pytest.approx(800.0 * 0.125 / (4.0 * G * G), rel=1e-6)
    factor = (1.0 - length * omega**2 / G) ** -2
    assert factor > 1.13
    assert grown[1] / grown[0] == pytest.approx(factor, rel=2e-3)


# -----------------------------------------------------------------------------
# Gravity by the latitude.

SOUTH = """
duration: {days}
trochlea:
  inertia: 4.0e-4
  cam: {{kind: involute, base_radius: 0.005}}
  thread: {{kind: vertical}}
  power: {{kind: weight, mass: 0.322{power}}}
  release_angle: 1.0
{more}
ship: {{kind: still}}
voyage:
  departure: [50.8, -1.1]
  arrival: [17.9, -40.0]
  sails_at: 86400.0
  arrives_at: 604800.0
drift: {{covariates: [gravity]{drift}}}
log: {{interval: 60.0}}
"""
MASSLESS = {
    'sails': DAY_S,
    'days': 8 * DAY_S,
    'power': ', massless: true',
    'more': '',
    'drift': '',
}
STATED = ', coefficients: {gravity: {value: 1.0, sigma: 0.01}}'
DRIVEN = 'drag: {viscous: 1.25e-5}\nescapement: {kind: impulse, energy: 1.23052e-4, angle: 0.0}'


def south(**changes):
    return parse_scene(SOUTH.format(**MASSLESS | changes), 'test')


def test_latitude_explains_the_loss_on_the_way_to_jamaica():
    scene = south(drift=STATED)
    voyage = sail(scene)
    estimate = voyage.samples[s.ESTIMATE]
    assert estimate.name == estimate_names(('gravity',))
    grown = estimate.position[:, estimate.name.index('gravity_integral_s')]
    arrived = np.searchsorted(voyage.time_s, 604_860.0)
    days = (voyage.time_s[-1] - voyage.time_s[arrived]) / DAY_S
    lost, said = ((each[-1] - each[arrived]) / days for each in (voyage.clock_error_s, grown))
    assert lost == pytest.approx(-115.5, abs=0.05)
    # the regressor is linear: of √(1 - 0.0027) - 1 it lacks (0.0027)²/8, 0.08 s/day
    assert said - lost == pytest.approx(0.08, abs=0.01)
    # on the way too, with Eötvös' term
    assert np.abs(voyage.clock_error_s - grown).max() < 0.09 * 7.0
    assert voyage.result.get('warnings') is None


@pytest.mark.parametrize('more', ['', DRIVEN], ids=['free', 'driven'])
def test_the_prior_is_that_of_the_machine_as_it_stands(more):
    """Its steady swing at other gravities, by quadrature. A free wheel keeps its action instead.

    On the involute a weight of mass is slower the wider it swings. If drag or action make the
    swing wider as gravity falls, k is 1.005 of the rate at that amplitude (rate.md).
    """
    scene = south(power='', more=more)
    swing = steady_swing(compile_machine(scene))
    scene = scene.model_copy(
        update={'clock': scene.clock.model_copy(update={'nominal_period': swing.period})}
    )
    (found,) = runs(scene)
    assert found.name == 'gravity'
    for step, k in found.at.items():
        heavier = {'voyage': None, 'gravity': scene.g * (1.0 + step)}
        period = steady_swing(compile_machine(scene.model_copy(update=heavier))).period
        wanted = (swing.period / period - 1.0) / (0.5 * step)
        if not more:  # at equal action A² goes as 1/ω, and the rate as 1 - A²/200
            wanted += 0.005
        assert k == pytest.approx(wanted, abs=5e-4)
    assert found.coefficient.value == pytest.approx(1.005, abs=5e-4)
    assert 0.01 < found.coefficient.sigma < 0.011


def test_a_force_feels_no_gravity():
    force = load_scene('clock_second_cam_force', drift={'covariates': ['gravity']})
    (found,) = runs(force)
    assert list(found.at.values()) == pytest.approx([0.0, 0.0], abs=1e-9)


def test_gravity_between_fixes_is_that_of_place_and_way():
    latitude, longitude = np.array([10.0, 10.01, 10.02]), np.array([179.98, 179.99, -179.99])
    gravity, lifted = gravity_between(np.array([300.0, 600.0]), latitude, longitude)
    np.testing.assert_allclose(gravity, normal_gravity(np.radians(latitude)), rtol=1e-15)
    # metres of a minute of arc on the ellipsoid at 10°: 1,843.2 along the meridian (Bowditch)
    north = 0.6 * 1843.2 / np.array([300.0, 600.0])
    east = np.array([0.01, 0.02]) * np.pi / 180.0 * 6_378_137.0 * np.cos(np.radians(10.01))
    east /= np.array([300.0, 600.0])
    wanted = eotvos(np.radians([10.005, 10.015]), east, north)
    np.testing.assert_allclose(lifted, wanted, rtol=2e-3)


def topics():
    scene = south(days=2 * DAY_S, drift=STATED)
    samples = sail(scene).samples
    return scene, {topic: samples[topic] for topic in (s.READING, s.OBSERVATION, s.SHIP_FIX)}


SCENE, TOPICS = topics()


@settings(max_examples=20, deadline=None)
@given(st.lists(st.integers(0, 2881), max_size=6), st.booleans(), st.integers(0, 6))
def test_batches_and_resuming_do_not_change_the_integral(cuts, live, resumed):
    fixes = TOPICS[s.SHIP_FIX]
    stamps = fixes.stamp_ns[:-1:3] + 7 * S
    make = partial(regressors, SCENE, live=live)
    whole = make()
    whole.feed({s.SHIP_FIX: fixes})
    found = integrated(make, s.SHIP_FIX, fixes, stamps, cuts, resumed)
    np.testing.assert_array_equal(found, whole.at(stamps))


def last(stage, feeds):
    said = [batches for feed in feeds if (batches := stage.feed(feed))]
    said += [batches] if (batches := stage.finish()) else []
    return said[-1][s.ESTIMATE]


def test_a_place_that_never_comes_leaves_the_prior_and_is_said():
    live = DriftStage(SCENE, expect_schedule=False)
    assert s.SHIP_FIX in live.inputs
    assert live.notices == []
    estimate = last(live, [{topic: TOPICS[topic] for topic in (s.OBSERVATION, s.READING)}])
    assert len(estimate.stamp_ns)
    named = dict(zip(estimate.name, estimate.position[-1].tolist(), strict=True))
    assert (named['gravity_coefficient'], named['gravity_coefficient_sigma']) == (1.0, 0.01)
    assert named['gravity_integral_s'] == 0.0
    (notice,) = live.notices
    assert 'Publish sensor_msgs/NavSatFix on ship/fix, or leave gravity out' in notice
    assert drift_warnings(live.health(), SCENE) == [notice]
    # when it comes, the notice goes
    live.feed({s.SHIP_FIX: TOPICS[s.SHIP_FIX]})
    more = s.take(TOPICS[s.READING], slice(-1, None))
    more.stamp_ns[:] += 60 * S
    live.feed({s.READING: more})
    live.finish()
    assert live.notices == []


def test_bad_fixes_are_left_out_and_time_may_begin_again():
    fixes = TOPICS[s.SHIP_FIX]
    nowhere = fix_samples(
        fixes.stamp_ns, fixes.latitude + 0.0, fixes.longitude, np.ones((len(fixes.stamp_ns), 3))
    )
    nowhere.latitude[5], nowhere.status[7], nowhere.latitude[9] = math.nan, -1, 85.0
    nowhere.latitude[11] = nowhere.longitude[11] = 0.0
    source, whole = (regressors(SCENE, live=True) for _ in range(2))
    source.feed({s.SHIP_FIX: nowhere})
    whole.feed({s.SHIP_FIX: fixes})
    counts = {name: n for name, n in source.health().items() if n}
    assert counts == {'latitude_refused': 4, 'fixes_out_of_reach': 1, 'fixes_at_0_0': 1}
    end = fixes.stamp_ns[-1:]
    reached = source.at(end)
    np.testing.assert_allclose(reached, whole.at(end), rtol=1e-9)
    source.feed({s.SHIP_FIX: s.take(fixes, slice(0, 100))})
    again = source.at(fixes.stamp_ns[[0, 99]])
    np.testing.assert_array_equal(again[0], reached[0])


def test_gravity_that_is_a_number_is_no_covariate():
    with pytest.raises(SceneError, match='names gravity, which is') as caught:
        parse_scene(SOUTH.format(**MASSLESS) + 'gravity: 9.8\n', 'test')
    assert caught.value.key == 'drift.covariates'


# -----------------------------------------------------------------------------
# The temperature of the box.

WARM = SOUTH.replace('[gravity]{drift}', '[temperature_squared, temperature]{drift}') + (
    'air: {{kind: route, at: [{{waypoint: 0, celsius: 6.0}}, {{waypoint: 1, celsius: 26.0}}], '
    'diurnal: 4.0}}\n'
)
KNOWN = (
    ', coefficients: {temperature: {value: -1.2e-4, sigma: 1.0e-5}, '
    'temperature_squared: {value: 1.0e-7, sigma: 1.0e-8}}'
)


def test_temperature_is_linear_between_samples():
    scene = parse_scene(WARM.format(**MASSLESS | {'drift': KNOWN}), 'test')
    samples = sail(scene).samples
    estimate, felt = samples[s.ESTIMATE], samples[s.SHIP_TEMPERATURE]
    warmer = np.interp(estimate.stamp_ns, felt.stamp_ns, felt.temperature - felt.temperature[0])
    assert warmer[-1] > 15.0
    # Simpson's rule is exact for the square of a line
    middle = 0.5 * (warmer[1:] + warmer[:-1])
    for name, power in (('temperature', 1), ('temperature_squared', 2)):
        parts = 10.0 * (warmer[1:] ** power + 4.0 * middle**power + warmer[:-1] ** power)
        grown = estimate.position[:, estimate.name.index(f'{name}_integral_s')]
        np.testing.assert_allclose(grown[1:], np.cumsum(parts), rtol=1e-9, atol=1e-6)
    named = dict(zip(estimate.name, estimate.position[0].tolist(), strict=True))
    assert named['temperature_coefficient'] == -1.2e-4
    # in kelvin, or never: refused and said
    live = DriftStage(scene, expect_schedule=False)
    kelvin = replace(felt, temperature=felt.temperature + 273.15)
    live.feed({s.SHIP_TEMPERATURE: kelvin})
    assert live.health()['temperature_refused'] == len(felt.stamp_ns)
    live.feed({s.READING: samples[s.READING]})
    (notice,) = live.notices
    assert 'Publish sensor_msgs/Temperature on ship/temperature' in notice


def test_a_temperature_needs_air():
    airless = WARM[: WARM.index('air:')].format(**MASSLESS | {'drift': KNOWN})
    with pytest.raises(SceneError, match='and the scene has no air'):
        parse_scene(airless, 'test')


# -----------------------------------------------------------------------------
# Priors of temperature, by the machine when warmer and colder.

BOX = """
duration: {duration}
trochlea:
  inertia: 4.0e-4
  {heat}
  cam: {{kind: {cam}}}
  thread: {{kind: {thread}}}
  power: {{kind: {power}}}
  release_angle: {angle}
{more}
ship: {{kind: still}}
gravity: 9.80665
voyage:
  departure: [50.8, -1.1]
  arrival: [50.0, -2.0]
  sails_at: 21600.0
  arrives_at: 86400.0
air: {{kind: route, at: [{{waypoint: 0, celsius: {cold}}}, {{waypoint: 1, celsius: {warm}}}],
  diurnal: 0.0, box_hours: 1.0}}
drift: {{covariates: [{names}]}}
log: {{interval: 60.0}}
"""
SMALL = {
    'duration': 3600.0,
    'heat': 'material: brass',
    'cam': 'hole, lever_rate: 0.005',
    'thread': 'hole, distance: 0.08',
    'power': 'force, force: 3.0, material: steel',
    'angle': 0.1,
    'more': '',
    'cold': 20.0,
    'warm': 20.0,
    'names': 'temperature',
}
WEIGHT = {'cam': 'involute, base_radius: 0.005', 'thread': 'vertical'}
LIGHT = WEIGHT | {'power': 'weight, mass: 0.322, massless: true'}
THINS = math.log(1.0 / 0.965)
OILED = WEIGHT | {
    'heat': '',
    'power': 'weight, mass: 0.322',
    'angle': 1.0,
    'more': DRIVEN.replace('1.25e-5', f'1.25e-5, oil: {{thins_per_kelvin: {THINS!r}}}'),
}


def boxed(**changes):
    return parse_scene(BOX.format(**SMALL | changes), 'test')


@pytest.mark.parametrize(
    ('changes', 'wanted', 'within'),
    [
        ({}, -10.69, 0.005),
        ({'heat': 'material: steel'}, -10.37, 0.005),
        (LIGHT, -0.816, 0.001),
        # 3.5 % less drag costs 15.6 s/day. The secants to both sides are as sinh is to the chord
        (OILED, -15.6 * math.sinh(5.0 * THINS) / 5.0 / (1.0 / 0.965 - 1.0), 0.1),
    ],
    ids=['steel spring and brass', 'steel', 'brass and weight', 'oil'],
)
def test_the_prior_of_temperature_is_that_of_the_whole_machine(changes, wanted, within):
    """Figures of docs/theory/heat.md [s/day/K]."""
    (found,) = coefficients(boxed(**changes))
    assert found.value * DAY_S == pytest.approx(wanted, abs=within)
    assert found.sigma >= 0.1 * abs(found.value)


def test_what_feels_no_heat_or_is_compensated_has_a_small_prior():
    (cold,) = coefficients(boxed(**LIGHT | {'heat': ''}))
    assert (cold.value, cold.sigma) == (0.0, 1e-6)
    kept = boxed(
        heat='material: brass\n  compensation: {takes: -10.69, leaves: -0.002}',
        names='temperature, temperature_squared',
    )
    linear, square = coefficients(kept)
    assert abs(linear.value) * DAY_S < 0.01
    assert linear.sigma == pytest.approx(1e-6, rel=0.1)
    # the rest, the spring's own, and the product of heat and compensation
    wanted = -0.002 - 0.00046 - 10.69**2 / DAY_S
    assert square.value * DAY_S == pytest.approx(wanted, abs=1e-5)


def test_a_free_wheel_keeps_its_action_as_it_warms():
    scene = boxed(**WEIGHT | {'power': 'weight, mass: 0.322', 'angle': 1.0})
    (found,) = runs(scene)
    machine = compile_machine(scene)
    # A² goes as 1/Iω, and the rate as 1 - 0.0201 A²/4: at constant amplitude it lost 0.82
    first, warm = (machine.at_celsius(at) for at in (20.0, 25.0))
    at_same = first.period(1.0) / warm.period(1.0) - 1.0
    lighter = (warm.inertia * warm.frequency) / (first.inertia * first.frequency) - 1.0
    by_action = found.at[5.0] * 5.0 - at_same
    assert by_action == pytest.approx(0.25 * 0.0201 * lighter, rel=0.03)


@pytest.mark.parametrize(
    ('thread', 'radius', 'mass'),
    [
        ('lever, arm: 0.1, weight_arm: 0.15, length: 0.3', 0.02, 0.05),
        ('hanging, length: 0.2', 0.005, 0.322),
    ],
)
def test_threads_that_move_their_weight_feel_heat_too(thread, radius, mass):
    """Small swings against the frequency of the warmer machine. The swinging thread is run."""
    cam, power = f'involute, base_radius: {radius}', f'weight, mass: {mass}'
    scene = boxed(thread=thread, cam=cam, power=power, angle=0.1)
    (found,) = runs(scene)
    machine = compile_machine(scene)
    for step, k in found.at.items():
        wanted = machine.small_period / machine.at_celsius(20.0 + step).small_period - 1.0
        assert k * step == pytest.approx(wanted, rel=1e-3)
        assert k * DAY_S < -0.6


@pytest.mark.parametrize('names', ['temperature', 'temperature_squared, temperature'])
@pytest.mark.parametrize('changes', [{}, OILED], ids=['spring', 'oil'])
def test_a_voyage_that_warms_by_20_kelvin_is_within_the_priors(changes, names):
    """The whole run against Σ k X: within σ, and with the square within a tenth of that."""
    changes = changes | {'cold': 6.0, 'warm': 26.0, 'names': names, 'duration': 108_000.0}
    if 'oil' in changes.get('more', ''):
        changes |= {'more': DRIVEN.replace('1.25e-5', '1.25e-5, oil: olive')}
    voyage = sail(scene := boxed(**changes))
    estimate, known = voyage.samples[s.ESTIMATE], coefficients(scene)
    columns = [estimate.name.index(f'{each.name}_integral_s') for each in known]
    grown = estimate.position[:, columns]
    calm = np.searchsorted(voyage.time_s, 21_000.0)
    rate = voyage.clock_error_s[calm] / voyage.time_s[calm]
    error = voyage.clock_error_s[-1] - rate * voyage.time_s[-1]
    left = error - float(grown[-1] @ [each.value for each in known])
    sigma = math.hypot(*(grown[-1] * [each.sigma for each in known]))
    assert error < -100.0
    assert abs(left) < (sigma if len(known) == 1 else 0.1 * sigma)


def test_a_clock_that_stops_in_the_cold_is_refused():
    thick = OILED['more'].replace(repr(THINS), '0.2').replace('angle: 0.0', 'angle: 0.3')
    thick = {'more': thick, 'duration': 108_000.0, 'warm': -10.0}
    with pytest.raises(SceneError, match=r'by running the machine: at -9\.\d+ °C the clock stops'):
        coefficients(boxed(**OILED | thick))
