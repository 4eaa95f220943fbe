"""The suspension of the case: ship's motion in, readings of a sensor in the case out."""

import math
import pickle
from dataclasses import replace

import mpmath
import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from tauto_core.checks.cost import forecast
from tauto_core.checks.readiness import check_scene
from tauto_core.clockwork import TrochleaStage
from tauto_core.machines import compile_machine
from tauto_core.machines.axle_pendulum import AxlePendulum, AxleState, SupportMotion, modes
from tauto_core.motion.axle import forces
from tauto_core.samples import READING, SHIP_IMU, ImuSamples, join, take
from tauto_core.scene import SceneError, load_scene, scene_yaml
from tauto_core.scene.errors import PropagationError
from tauto_core.ship import ShipMotion
from tauto_core.ship.buffer import sensed_parts, sensed_step_ns
from tauto_core.ship.imu import imu_from_roll
from tauto_core.ship.suspension import Suspension
from tauto_core.voyage import sail

NAME = 'suspended_weight_at_sea'
RATE = {'ship.rate': 20.0}
CONTENT = yaml.safe_load(scene_yaml(load_scene(NAME, **RATE)))
HUNG = CONTENT['suspension']
E = HUNG['support_radius'] - HUNG['axle_radius']
C, K, G = HUNG['depth'], HUNG['gyration_radius'], CONTENT['gravity']
OWN = modes(E, C, K * K)
SLOW, FAST = (math.sqrt(square) for square in OWN.squared_frequencies(G))


def scene_of(**changes):
    """The shipped scene with changes of suspension, ship and the whole."""
    asked = {key.replace('__', '.'): value for key, value in changes.items()}
    return load_scene(NAME, **RATE | {'duration': 60.0} | asked)


def rolling(components, *, rate=20.0, height=3.0, heave=None, **changes):
    ship = {'kind': 'components', 'components': components, 'rate': rate, 'height': height}
    return scene_of(ship=ship | ({'heave': heave} if heave else {}), **changes)


def motion_of(scene) -> ImuSamples:
    ship = ShipMotion(scene)
    return ship.produce(ship.total)


def in_the_case(scene, imu=None):
    """Times [s] and motion of the case: φ, φ̇, θ, N/M."""
    hung = Suspension(scene, max_gap_s=1.0)
    imu = motion_of(scene) if imu is None else imu
    said = [hung.feed(imu, scene.starts_at_ns), hung.finish(scene.starts_at_ns)]
    case = join([part for part in said if part is not None])
    times = (case.stamp_ns - scene.starts_at_ns) * 1e-9
    return times, case.tilt, case.rate, case.tilt + case.lean, case.pull


def shaken(frequency, size, *, rate, seconds):
    """A ship that does not roll and is moved to port and back: ÿ = size · cos Ωt."""
    times = np.arange(round(seconds * rate) + 9) / rate
    stamps = CONTENT_START + np.round(times * 1e9).astype(np.int64)
    zero = np.zeros(len(times))
    return imu_from_roll(stamps, zero, zero, size * np.cos(frequency * times), zero + G)


CONTENT_START = round(CONTENT['starts_at'] * 1e9)


def response(frequency, size, times):
    """θ and φ of the case at rest at first, in 40 digits, each mode away from resonance."""
    with mpmath.workdps(40):
        c, frequency, size = mpmath.mpf(C), mpmath.mpf(frequency), mpmath.mpf(size)
        e, k2, g = mpmath.mpf(HUNG['support_radius']) - mpmath.mpf(HUNG['axle_radius']), 0, 0
        k2, g = mpmath.mpf(K) ** 2, mpmath.mpf(G)
        total, rest = k2 + c * c + c * e, k2 + c * c - c * e
        root = mpmath.sqrt(total**2 - 4 * c * e * k2)
        ratios = [(rest + root) / (2 * c), (rest - root) / (2 * c)]
        tilt = -size / g
        theta, phi = [], []
        for t in times:
            sums = [mpmath.mpf(0), mpmath.mpf(0)]
            for ratio, other in (ratios, ratios[::-1]):
                square, start = g / (e + ratio), tilt * (c - other) / (c * (ratio - other))
                forced = -size / (ratio * (ratio - other)) / (square - frequency**2)
                free = mpmath.cos(mpmath.sqrt(square) * t)
                q = forced * mpmath.cos(frequency * t) + (start - forced) * free
                sums = [sums[0] + c * q, sums[1] + ratio * q]
            theta.append(float(sums[0]))
            phi.append(float(sums[1]))
        return np.array(theta), np.array(phi)


@pytest.mark.parametrize(
    ('frequency', 'size', 'rate', 'seconds', 'close'),
    [
        (0.7, 0.4, 20.0, 60.0, 1e-13),
        (2.5, 0.4, 20.0, 60.0, 2e-13),
        # a millionth from the slow mode: the swing grows for a minute to 0.3 rad
        (SLOW * (1 + 1e-6), 0.03, 200.0, 30.0, 2e-13),
        # and from the fast one, with a small share of the bearing
        (FAST * (1 - 1e-6), 0.02, 1000.0, 10.0, 2e-13),
    ],
)
def test_harmonic_sway_is_answered_in_closed_form(frequency, size, rate, seconds, close):
    """Interpolation of the sway errs by 2.4e-4 (Ωh)¹⁰ of it at the most: below 1e-13 here."""
    scene = scene_of(ship__rate=rate)
    times, phi, _, theta, _ = in_the_case(
        scene, shaken(frequency, size, rate=rate, seconds=seconds)
    )
    some = np.unique(np.linspace(0, len(times) - 40, 60).astype(int))
    wanted = response(frequency, size, times[some])
    assert 1e-3 < np.max(np.abs(wanted)) < 0.5
    np.testing.assert_allclose([theta[some], phi[some]], wanted, rtol=0, atol=close)


def test_full_equations_follow_dop853_on_a_rolling_support():
    """The support turns too, but its centre counts. Interpolation at 50 Hz leaves 1e-11 rad."""
    rolls, heaves, height = [(0.25, 6.1, 0.4), (0.1, 3.3, 1.0)], [(0.4, 5.3, 0.2)], -4.0
    names = 'amplitude', 'period', 'phase'
    scene = rolling(
        [dict(zip(names, wave, strict=True)) for wave in rolls],
        heave=[dict(zip(names, wave, strict=True)) for wave in heaves],
        rate=50.0,
        height=height,
        duration=4.0,
        suspension__large_angles=True,
    )

    def waves(components, t):
        found = np.zeros(3)
        for size, period, phase in components:
            w = math.tau / period
            x = w * t + phase
            found += [size * math.cos(x), -size * w * math.sin(x), -size * w * w * math.cos(x)]
        return found

    body = AxlePendulum(1.0 / E, C, K, G)

    def support(t):
        rho, rate, bend = waves(rolls, t)
        # the case hangs E − height below the axis of the ship
        x, y = (E - height) * math.cos(rho), (E - height) * math.sin(rho)
        down = -waves(heaves, t)[2] - bend * y - rate * rate * x
        return SupportMotion(rho, rate, bend, down, bend * x - rate * rate * y)

    def right(t, y):
        now = forces(body, AxleState(*y), support(t))
        return [y[2], y[3], float(now.arc_acceleration), float(now.tilt_acceleration)]

    times, phi, phi_rate, theta, contact = in_the_case(scene)
    rho, rate, _ = waves(rolls, 0.0)
    start = [E * (theta[0] - rho), phi[0], -E * rate, 0.0]
    at = np.searchsorted(times, [1.0, 2.0, 4.0])
    found = solve_ivp(
        right, (0, 4), start, method='DOP853', rtol=1e-13, atol=1e-15, t_eval=times[at]
    )
    for n, y in zip(at, found.y.T, strict=True):
        assert abs(phi[n]) > 1e-4
        assert phi[n] == pytest.approx(y[1], abs=2e-10)
        assert phi_rate[n] == pytest.approx(y[3], abs=2e-9)
        assert theta[n] == pytest.approx(waves(rolls, times[n])[0] + y[0] / E, abs=2e-10)
        pressed = float(forces(body, AxleState(*y), support(times[n])).contact)
        assert contact[n] == pytest.approx(pressed, abs=1e-8)


@pytest.mark.parametrize('large', [False, True])
def test_a_bearing_at_the_roll_axis_leaves_the_case_alone(large):
    """Without friction a ship that turns about the axle leaves it: (ship.1) has no force."""
    waves = [{'amplitude': 0.5, 'period': 7.0, 'phase': 0.4}]
    scene = rolling(waves, height=0.0, suspension__large_angles=large)
    _, phi, phi_rate, theta, contact = in_the_case(scene)
    np.testing.assert_allclose([phi, theta], 0.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(phi_rate, 0.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(contact, G, rtol=1e-14)


def test_signs_of_a_heel_and_of_a_push_to_port():
    """Heeled and at rest, the case hangs upright. Pushed to port, it lags to starboard."""
    times = np.arange(40)
    stamps = CONTENT_START + times * 50_000_000
    heel, zero = np.full(40, 0.3), np.zeros(40)
    heeled = imu_from_roll(stamps, heel, zero, G * np.sin(heel), G * np.cos(heel))
    _, phi, _, theta, contact = in_the_case(scene_of(), heeled)
    np.testing.assert_allclose([phi, theta, contact - G], 0.0, rtol=0, atol=1e-13)
    pushed = imu_from_roll(stamps, zero, zero, zero + 0.5, zero + G)
    _, phi, phi_rate, theta, contact = in_the_case(scene_of(suspension__large_angles=True), pushed)
    hanging = -math.atan2(0.5, G)
    np.testing.assert_allclose([phi, theta], hanging, rtol=0, atol=1e-14)
    np.testing.assert_allclose(phi_rate, 0.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(contact, math.hypot(0.5, G), rtol=1e-14)


def same_bits(one, other):
    for name, value in vars(one).items():
        if isinstance(value, np.ndarray):
            assert value.tobytes() == getattr(other, name).tobytes(), name


LARGE = {'suspension__large_angles': True}
WAVE = {'amplitude': 0.25, 'period': 4.3, 'phase': 1.0}
GIMBALS = {'kind': 'gimbals', 'depth': 0.05, 'gyration_radius': 0.12, 'damping_ratio': 0.05}
STICKING = {
    'suspension': GIMBALS | {'friction_angle': 0.08},
    'ship': {'kind': 'components', 'components': [WAVE], 'rate': 20.0},
}


@pytest.mark.parametrize('changes', [{}, LARGE, STICKING], ids=('small', 'large', 'gimbals'))
@given(data=st.data())
@settings(max_examples=5, deadline=None)
def test_any_split_and_any_resumption_give_the_same_bits(changes, data):
    scene = scene_of(duration=10.0, **changes)
    imu = motion_of(scene)
    hung, origin = Suspension(scene, max_gap_s=1.0), scene.starts_at_ns
    whole = join([hung.feed(imu, origin), hung.finish(origin)])
    n = len(imu.stamp_ns)
    cuts = sorted(data.draw(st.lists(st.integers(0, n), max_size=6)))
    hung, parts = Suspension(scene, max_gap_s=1.0), []
    for begin, end in zip([0, *cuts], [*cuts, n], strict=True):
        parts.append(hung.feed(take(imu, slice(begin, end)), origin))
        if data.draw(st.booleans()):
            state = pickle.loads(pickle.dumps(hung.state()))
            hung = Suspension(scene, max_gap_s=1.0)
            hung.restore(state)
    parts.append(hung.finish(origin))
    same_bits(whole, join([part for part in parts if part is not None]))


@pytest.mark.parametrize('changes', [{}, LARGE], ids=('small', 'large'))
def test_the_clock_in_the_case_gets_all_samples_and_resumes(changes):
    """The samples beyond the end suffice, so the graph and the offline run give the same."""
    scene = scene_of(duration=20.0, **changes)
    imu = motion_of(scene)
    whole = TrochleaStage(scene)
    wanted = whole.feed({SHIP_IMU: imu})
    assert whole.finish() == {}
    assert len(wanted[READING].stamp_ns) == scene.log_count
    stage, parts = TrochleaStage(scene), []
    for begin, end in ((0, 7), (7, 190), (190, 191), (191, len(imu.stamp_ns))):
        parts.append(stage.feed({SHIP_IMU: take(imu, slice(begin, end))}))
        state = pickle.loads(pickle.dumps(stage.state()))
        if begin == 190:
            stage = TrochleaStage(scene)
        stage.restore(state)
    for topic, samples in wanted.items():
        same_bits(samples, join([part[topic] for part in parts if topic in part]))


def test_the_case_is_sampled_as_its_fast_mode_needs():
    scene = load_scene(NAME, **RATE)
    assert (sensed_parts(scene), sensed_step_ns(scene)) == (8, 6_250_000)
    assert FAST * sensed_step_ns(scene) * 1e-9 < 0.4
    assert sensed_parts(load_scene('involute_weight_at_sea')) == 1
    assert scene.samples_beyond_end == 8
    assert load_scene('involute_weight_at_sea').samples_beyond_end == 4
    assert load_scene('ideal').samples_beyond_end == 0
    slow = scene_of(
        suspension__support_radius=3.0, suspension__gyration_radius=0.5, ship__rate=1000.0
    )
    assert sensed_parts(slow) == 1


def test_a_coarse_accuracy_takes_a_third_of_the_samples(monkeypatch):
    """In the sea that the clock feels most, against the samples that the default would take."""
    name, asked = 'clock_own_cam_weight', 1e-3
    changes = {'solver.accuracy': asked, 'duration': 1800.0, 'voyage.sails_at': 0.0}
    default, finer, coarse = (
        load_scene(name, **{'solver.accuracy': a}) for a in (1e-6, 9e-4, asked)
    )
    *_, fast = coarse.suspension.frequencies(coarse.g)
    assert 0.4 < fast * sensed_step_ns(coarse) * 1e-9 < 1.2
    assert fast * max(sensed_step_ns(default), sensed_step_ns(finer)) * 1e-9 < 0.4
    read = [sail(load_scene(name, **changes)).samples[READING].time_ref_ns]
    monkeypatch.setattr('tauto_core.ship.sampling.LARGEST_COARSE_TURN', 0.4)
    assert sensed_parts(coarse) == 5
    read.append(sail(load_scene(name, **changes)).samples[READING].time_ref_ns)
    apart_s = np.max(np.abs(read[0] - read[1])) * 1e-9
    # half an hour may err as much as a day
    assert 0.0 < apart_s < 0.01 * asked


def test_a_rate_too_low_for_wide_swings_names_one_that_works():
    quick = {'suspension__support_radius': 0.07, 'suspension__gyration_radius': 0.05}
    changes = quick | {'suspension__depth': 0.05, 'suspension__large_angles': True}
    with pytest.raises(SceneError, match='too low for wide swings') as caught:
        sensed_parts(scene_of(ship__rate=2.0, **changes))
    assert caught.value.key == 'ship.rate'
    words = caught.value.remedy.split()
    least = float(words[words.index('least') + 1])
    assert 3.0 > least > 2.0
    assert sensed_parts(scene_of(ship__rate=4.0, **changes)) <= 64


def test_a_fast_mode_too_fast_to_sample_is_refused_with_a_rate():
    scene = scene_of(suspension__gyration_radius=1e-3)
    for start in (check_scene, TrochleaStage, sensed_parts):
        with pytest.raises(SceneError, match='Use a larger one, or a') as caught:
            start(scene)
        assert caught.value.key == 'suspension.gyration_radius'
    assert 100.0 < float(caught.value.remedy.split()[-4]) < 125.0
    check_scene(scene_of(suspension__gyration_radius=1e-3, ship__rate=125.0))
    # 15 625 000 ns has 50 and 100 among its divisors, but no value between
    odd = scene_of(ship__rate=64.0, suspension__gyration_radius=1.785e-3)
    with pytest.raises(SceneError, match='no divisor') as caught:
        check_scene(odd)
    assert caught.value.key == 'ship.rate'


@pytest.mark.parametrize(
    ('changes', 'key', 'said'),
    [
        ({'ship': {'kind': 'still'}}, 'suspension', 'ship at rest'),
        ({'suspension__support_radius': 0.005}, 'suspension.support_radius', 'fall from it'),
        ({'suspension__support_radius': 0.004}, 'suspension.support_radius', '0.01'),
        ({'suspension__depth': -0.1}, 'suspension.depth', 'must be greater than 0'),
        ({'suspension__gyration_radius': 0.0}, 'suspension.gyration_radius', 'greater than 0'),
        ({'suspension__kind': 'gimbal'}, 'suspension.kind', 'axle, gimbals'),
    ],
)
def test_cases_that_cannot_hang_are_refused(changes, key, said):
    with pytest.raises(SceneError) as caught:
        scene_of(**changes)
    assert caught.value.key == key
    assert said in str(caught.value)


def test_a_swing_too_wide_for_small_angles_is_said_with_its_time():
    imu = shaken(SLOW, 0.3, rate=200.0, seconds=20.0)
    with pytest.raises(PropagationError, match='large_angles') as caught:
        in_the_case(scene_of(ship__rate=200.0), imu)
    share = OWN.h * C / (OWN.B * (OWN.B - OWN.B_prime))
    # in resonance the swing grows by share · Ω/2 of the static tilt a second
    assert caught.value.time_s == pytest.approx(0.5 * G / 0.3 / (share * SLOW / 2), rel=0.2)


def test_lifting_off_is_said_at_small_angles_too():
    w, size = math.tau / 1.2, 0.5
    heave = {'amplitude': size, 'period': 1.2}
    with pytest.raises(PropagationError, match='lifted off') as caught:
        in_the_case(rolling([], heave=[heave | {'phase': math.pi}], duration=5.0))
    # g + aω² cos ωt = 0, between two samples. Interpolation of the heave errs by 1e-9 of it
    lost = math.acos(-G / (size * w * w)) / w
    assert caught.value.time_s == pytest.approx(lost, abs=1e-8)
    with pytest.raises(PropagationError, match='lifted off') as caught:
        in_the_case(rolling([], heave=[heave], duration=5.0))
    assert caught.value.time_s == 0.0


def test_a_loss_of_contact_does_not_depend_on_batches():
    """During a swing, which makes the end of the previous batch matter."""
    wave = {'amplitude': 1.2 * G / (math.tau / 1.2) ** 2, 'period': 1.2, 'phase': 1.0}
    scene = rolling([{'amplitude': 0.05, 'period': 3.0}], heave=[wave], duration=2.0)
    times = []
    for run in (in_the_case, one_by_one):
        with pytest.raises(PropagationError, match='lifted off') as caught:
            run(scene)
        times.append(caught.value.time_s)
    assert times[0] == times[1] > 0.1


def one_by_one(scene):
    """Feed a suspension sample by sample, saved and resumed between."""
    imu, hung = motion_of(scene), Suspension(scene, max_gap_s=1.0)
    for n in range(len(imu.stamp_ns)):
        state = hung.state()
        hung = Suspension(scene, max_gap_s=1.0)
        hung.restore(state)
        hung.feed(take(imu, slice(n, n + 1)), scene.starts_at_ns)


def test_the_forecast_of_a_suspended_clock_counts_its_case():
    scene = load_scene(NAME, duration=120.0)
    free = scene.model_copy(update={'suspension': None})
    hung, fixed = (forecast(ready, compile_machine(ready)) for ready in (scene, free))
    assert hung.shortest_wave_s == pytest.approx(math.tau / FAST, rel=1e-12)
    assert hung.run_s > fixed.run_s
    assert 0.0 < hung.error_s < 1e-6


def test_samples_are_screened_before_they_reach_the_case():
    """A sample that is not finite is counted and left out, and the case swings on."""
    scene = scene_of(duration=10.0)
    imu = motion_of(scene)
    force = imu.linear_acceleration.copy()
    force[100, 1] = np.nan
    stage = TrochleaStage(scene)
    stage.feed({SHIP_IMU: replace(imu, linear_acceleration=force)})
    counts = {name: number for name, number in stage.health().items() if number}
    assert counts == {'not_finite': 1, 'bridged_gaps': 1}
