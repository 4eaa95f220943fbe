"""Forced harmonic: spans by samples, mixed spans, the phase after a century."""

from __future__ import annotations

import math
import random
import sys
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from motion_cases import FORCE, INERTIA, LEVER_RATE, OMEGA, on_land, rolling, scene_of, spans_to

from tauto_core.clockwork import TrochleaStage
from tauto_core.machines import compile_machine
from tauto_core.motion import Forcing
from tauto_core.motion.forced_harmonic import ForcedHarmonic
from tauto_core.motion.forcing import Polynomials, Window
from tauto_core.samples import JOINT_STATES, PHASE, SHIP_IMU, take
from tauto_core.scene import Scene
from tauto_core.ship import ShipMotion

AMPLITUDE, WAVE, EPS = 0.1, 2 * math.pi / 7.0, 0.4


def line(t, order=0):
    return AMPLITUDE * WAVE**order * np.cos(WAVE * t + EPS + 0.5 * math.pi * order)


def swing(t, angle, rate, delta):
    """θ and θ̇ from those at t = 0, over `line`: ψ̈ + 2δψ̇ + ω₀²ψ = ω₀²α + 2δα̇, ψ = θ + α."""
    s, iw = -delta + 1j * math.sqrt(OMEGA**2 - delta**2), 1j * WAVE
    gain = (OMEGA**2 + 2 * delta * iw) / (OMEGA**2 - WAVE**2 + 2 * delta * iw)
    forced = AMPLITUDE * np.exp(1j * EPS) * gain
    psi = angle + line(0.0) - forced.real
    speed = rate + line(0.0, 1) - (forced * iw).real
    # ψ = Re(c e^{st}) with Re c and Re(cs) given
    c = complex(psi, (psi * s.real - speed) / s.imag)
    free, wave = c * np.exp(s * t), forced * np.exp(iw * t)
    return (free + wave).real - line(t), (free * s + wave * iw).real - line(t, 1)


def sampled_spans(stride, step_s, cuts):
    """Spans of one piece with samples of `line`. Time zero is the beginning of the first."""
    length = stride * step_s
    nodes = np.arange(-1, stride + 2) / stride
    t = (nodes - cuts[0]) * length
    n = len(cuts) - 1
    begin, end = np.array(cuts[:-1]), np.array(cuts[1:])
    return Forcing(
        np.full(n, length),
        begin,
        end,
        np.rint((end - cuts[0]) * length * 1e9).astype(np.int64),
        np.ones(n, np.bool_),
        window=Window(
            tuple(nodes),
            Polynomials(line(t), line(t, 1), np.zeros(n, int), np.empty((0, 2 * len(t)))),
        ),
    )


def released_into(spans, angle, viscous):
    """Release a wheel at rest in the case at the first span's beginning, and advance it."""
    drag = {'viscous': viscous} if viscous else None
    machine = compile_machine(scene_of(trochlea={'release_angle': angle}, drag=drag))
    engine = ForcedHarmonic(machine)
    engine.release(replace(on_land(1, 1.0), neutral=np.array([[line(0.0), line(0.0, 1)]])))
    return engine.advance(spans)


@pytest.mark.parametrize('viscous', [0.0, 1e-4])
@pytest.mark.parametrize('angle', [1.0, 0.02], ids=['calm', 'in parts'])
@pytest.mark.parametrize(('stride', 'step_s'), [(1, 0.05), (3, 0.2), (8, 0.5)])
def test_a_step_from_samples_is_the_exact_solution(stride, step_s, angle, viscous):
    """The remainder of the interpolation is below 1e-16, the rest is rounding."""
    for cuts in ((0.0, 1.0), (0.0, 0.25, 1.0), (0.3125, 0.875)):
        spans = sampled_spans(stride, step_s, cuts)
        motion = released_into(spans, angle, viscous)
        theta, rate = swing(spans.end_ns * 1e-9, angle, 0.0, viscous / (2 * INERTIA))
        # 1 ns of time is 1e-8 rad: cuts fall on whole nanoseconds
        np.testing.assert_allclose(motion.angle, theta, rtol=0, atol=5e-15)
        np.testing.assert_allclose(motion.rate, rate, rtol=0, atol=5e-14)


def uneven(imu):
    """Samples with a gap, and a stretch of half the rate."""
    kept = np.ones(len(imu.stamp_ns), np.bool_)
    kept[[400, 401, 402]] = False
    kept[900:1100:2] = False
    return take(imu, kept)


@pytest.mark.parametrize('change', [lambda imu: imu, uneven], ids=['even', 'uneven'])
@pytest.mark.parametrize('release', [1.0, 0.03])
def test_samples_and_fitted_polynomials_make_the_same_motion(change, release):
    """The two ways share neither the fit nor the rows."""
    ship = rolling((0.1, 8.0, 0.3), (0.05, 5.0, 1.0), height=0.0, rate=10.0)
    scene = scene_of(
        ship=ship, trochlea={'release_angle': release}, duration=160.0, log={'interval': 0.8}
    )
    said = []
    for by_samples in (True, False):
        motion, stage = ShipMotion(scene), TrochleaStage(scene)
        stage._buffer._by_samples = by_samples
        said.append(stage.feed({SHIP_IMU: change(motion.produce(motion.total))}))
    for topic in (JOINT_STATES, PHASE):
        np.testing.assert_allclose(
            said[0][topic].position, said[1][topic].position, rtol=0, atol=1e-12
        )
        np.testing.assert_allclose(
            said[0][topic].velocity, said[1][topic].velocity, rtol=0, atol=1e-10
        )


def test_the_frame_is_exact_after_a_century():
    """After 3e9 s, 2e10 rad, only the cosine and Y are rounded: a float phase errs by 2e-6 rad."""
    times = np.array([1, 10**9 + 7, 86_400 * 10**11 + 3, 36_525 * 86_400 * 10**9 + 11])
    engine = ForcedHarmonic(compile_machine(scene_of()))
    still = spans_to(times)
    engine.release(still)
    motion = engine.advance(still)
    with mpmath.workdps(50):
        omega = mpmath.sqrt(mpmath.mpf(FORCE) * mpmath.mpf(LEVER_RATE) / mpmath.mpf(INERTIA))
        exact = [float(mpmath.cos(omega * mpmath.mpf(int(t)) / 10**9)) for t in times]
    np.testing.assert_allclose(motion.angle, exact, rtol=0, atol=4e-16)


SECOND = 4.0 * np.pi**2 * INERTIA / LEVER_RATE
"""Pull under which the wheel swings once a second [N]."""


def released_in(
    rolls: list[dict[str, float]],
    angle: float,
    duration: float,
    *,
    rate: float = 20.0,
    interval: float = 1.0,
) -> Scene:
    """Return a second's wheel that is released at an angle on a ship that rolls."""
    return scene_of(
        trochlea={'release_angle': angle, 'power': {'kind': 'force', 'force': SECOND}},
        ship={'kind': 'components', 'rate': rate, 'components': rolls},
        duration=duration,
        log={'interval': interval},
        drift={'observation_interval': duration},
    )


def passed(rolls: list[dict[str, float]], angle: float, duration: float) -> tuple[int, int]:
    """Return upward and all passages of zero in closed form, from extremum to extremum.

    θ̈ + ω²θ = −α̈ of the roll α. Between two extrema θ passes zero at most once. An extremum within
    1e-12 rad of zero is a touch.
    """
    omega = math.sqrt(SECOND * LEVER_RATE / INERTIA)
    t = np.arange(0.0, duration + 1e-9, 2e-3)

    def theta(t: np.ndarray, order: int) -> np.ndarray:
        turned = order * 0.5 * np.pi
        found, start, speed = np.zeros_like(t), angle, 0.0
        for roll in rolls:
            w, f = 2.0 * np.pi / roll['period'], roll['phase']
            size = roll['amplitude'] * w * w / (omega * omega - w * w)
            found = found + size * w**order * np.cos(w * t + f + turned)
            start, speed = start - size * np.cos(f), speed + size * w * np.sin(f)
        free = start * np.cos(omega * t + turned) + speed / omega * np.sin(omega * t + turned)
        return np.asarray(found + omega**order * free)

    rate = theta(t, 1)
    turns = np.flatnonzero(rate[1:-1] * rate[2:] < 0.0) + 1
    low, high, sign = t[turns], t[turns + 1], np.sign(rate[turns])
    for _ in range(50):
        middle = 0.5 * (low + high)
        before = np.sign(theta(middle, 1)) == sign
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    values = np.concatenate([[angle], theta(0.5 * (low + high), 0), theta(t[-1:], 0)])
    values = values[np.abs(values) > 1e-12]
    signs = np.sign(values)
    return int(np.count_nonzero(np.diff(signs) > 0)), int(np.count_nonzero(np.diff(signs)))


def counted_of(scene: Scene) -> tuple[int, int]:
    """Return the turns and beats of a run."""
    ship, stage = ShipMotion(scene), TrochleaStage(scene)
    said = stage.feed({'ship/imu': ship.produce(ship.total)})
    wheel = stage.state()['propagator']['wheel']
    phase = said[PHASE].position[-1]
    # the phase says the same as the counter, up to the turn that has begun
    assert -1.0 <= phase[0] / (2.0 * np.pi) - wheel['turns'] <= 1.0
    assert phase[3] == wheel['beats']
    return int(wheel['turns']), int(wheel['beats'])


def mirrored(rolls: list[dict[str, float]]) -> list[dict[str, float]]:
    return [{**roll, 'phase': roll['phase'] + np.pi} for roll in rolls]


@pytest.mark.parametrize(
    ('period', 'interval', 'logged'), [(9.0, 1.0, 180), (4.5, 1.0, 180), (7.3, 0.7, 257)]
)
@pytest.mark.parametrize('mirror', [False, True])
def test_a_wheel_that_touches_zero_does_not_pass_it(period, interval, logged, mirror):
    """After a whole number of both periods it is at rest in the middle again, as at the release.

    Steps end there, and the motion is logged, or both happen elsewhere.
    """
    rolls = [{'amplitude': 0.1, 'period': period, 'phase': 0.4}]
    rolls = mirrored(rolls) if mirror else rolls
    duration = round(interval * logged, 9)
    scene = released_in(rolls, 0.0, duration, interval=interval)
    assert counted_of(scene) == passed(rolls, 0.0, duration)


@pytest.mark.parametrize('seed', range(8))
def test_small_releases_pass_zero_as_the_closed_form_says(seed):
    """Half of them at 0, with a near touch at each return to the middle, and mirror images."""
    draw = random.Random(seed)
    rolls = [
        {
            'amplitude': round(draw.uniform(0.02, 0.1), 4),
            'period': round(draw.uniform(4.0, 14.0), 3),
            'phase': round(draw.uniform(0.0, 6.28), 3),
        }
        for _ in range(draw.choice([1, 1, 2, 3, 4]))
    ]
    angle = draw.choice([0.0, 0.0, draw.uniform(-0.01, 0.01), draw.uniform(-0.003, 0.003)])
    rate = draw.choice([5.0, 10.0, 20.0])
    for side, waves in ((1.0, rolls), (-1.0, mirrored(rolls))):
        found = counted_of(released_in(waves, side * angle, 120.0, rate=rate))
        assert found == passed(waves, side * angle, 120.0)


@pytest.mark.parametrize(
    ('step_s', 'angle'), [(0.1, -0.37), (0.1, -0.33), (0.1, 0.3), (0.05, 0.13), (0.05, 0.39)]
)
def test_passages_between_samples_of_a_fast_roll_are_counted(step_s, angle, monkeypatch):
    """Two samples a wave, all at its crests: between them the wheel passes zero to and fro."""
    monkeypatch.setattr(sys.modules[__name__], 'WAVE', 0.999 * math.pi / step_s)
    monkeypatch.setattr(sys.modules[__name__], 'EPS', 0.0)
    motion = released_into(sampled_spans(8, step_s, (0.0, 1.0)), angle, 0.0)
    theta = swing(np.linspace(0.0, 8.0 * step_s, 20_001), angle, 0.0, 0.0)[0]
    assert motion.beats[-1] == np.count_nonzero(np.diff(theta < 0.0))
