"""A live clock on a faulty sensor: what gaps, bias, noise and 200 Hz do to the dial."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
from stress_cases import Row

from tauto_core.clockwork import DialSetting, LiveTrochlea
from tauto_core.navigation import DriftStage
from tauto_core.samples import ESTIMATE, READING, SHIP_IMU, ImuSamples, TimeSamples, join, take
from tauto_core.scene import Scene, load_scene
from tauto_core.scene.times import DAY_S, NS_PER_S, STANDARD_GRAVITY
from tauto_core.ship import ShipMotion

MINUTES = 10.0


def _sea(scene: Scene) -> ImuSamples:
    """Return what an ideal sensor on the ship of a scene says, spatial and complete."""
    return ShipMotion(scene).produce(scene.samples + scene.samples_beyond_end)


def _read(scene: Scene, parts: Iterator[ImuSamples]) -> tuple[TimeSamples, LiveTrochlea]:
    """Return the readings of a live clock, and the clock."""
    stage = LiveTrochlea(scene)
    said = [stage.feed({SHIP_IMU: part}) for part in parts] + [stage.finish()]
    reading = join([each[READING] for each in said if READING in each])
    assert isinstance(reading, TimeSamples)
    return reading, stage


def _error_s(reading: TimeSamples) -> float:
    return float(reading.time_ref_ns[-1] - reading.stamp_ns[-1]) / NS_PER_S


def gaps() -> Iterator[Row]:
    """A short gap is bridged; a long one is declared, and costs the estimate one release."""
    scene = load_scene('measured', duration=60.0 * MINUTES)
    imu = _sea(scene)
    clean, _ = _read(scene, iter([imu]))
    for gap_s in (0.9, 5.0, 60.0):
        begin = np.searchsorted(imu.stamp_ns, imu.stamp_ns[0] + 200 * NS_PER_S)
        end = np.searchsorted(imu.stamp_ns, imu.stamp_ns[begin] + round(gap_s * NS_PER_S))
        parts = take(imu, slice(0, int(begin))), take(imu, slice(int(end), None))
        reading, stage = _read(scene, iter(parts))
        stops = stage.health()['dial_stops']
        name = f'gap of {gap_s:g} s'
        yield Row(name, 'stops of the dial', stops, float(gap_s > 1.0), float(gap_s > 1.0))
        if gap_s < 1.0:
            # interpolated over a tenth of a wave of 9 s
            moved = _error_s(reading) - _error_s(clean)
            yield Row(name, 'change of the dial [s]', abs(moved), 0.01)
            continue
        setting = DialSetting.of(str(reading.source[-1]))
        assert setting is not None
        lost_s = setting.lost_ns / NS_PER_S
        # the wheel swings freely for up to a second beyond the last sample before it counts
        yield Row(name, 'declared as lost [s]', lost_s, gap_s + 1.1, gap_s - 0.1)
        drift = DriftStage(scene, expect_schedule=False)
        estimate = drift.feed({READING: reading})[ESTIMATE]
        last = dict(zip(estimate.name, estimate.position[-1].tolist(), strict=True))
        off = abs(_error_s(reading) - last['offset_s']) / last['offset_sigma_s']
        yield Row(name, 'error of the estimate [σ]', off, 3.0)


def bias_and_noise() -> Iterator[Row]:
    """A bias along z is gravity to a weight: half of its share of g, in rate."""
    scene = load_scene('involute_weight_at_sea', duration=60.0 * MINUTES)
    imu = _sea(scene)
    clean, _ = _read(scene, iter([imu]))
    days = 60.0 * MINUTES / DAY_S
    for milli_g in (1.0, 5.0):
        bias = np.array([0.0, 0.0, 1e-3 * milli_g * STANDARD_GRAVITY])
        force = imu.linear_acceleration + bias
        reading, stage = _read(scene, iter([replace(imu, linear_acceleration=force)]))
        rate = (_error_s(reading) - _error_s(clean)) / days
        expected = 0.5e-3 * milli_g * DAY_S
        name = f'bias of {milli_g:g} mg along z'
        yield Row(name, 'rate over that of half its share of g', rate / expected, 1.1, 0.9)
        yield Row(name, 'stops of the dial', stage.health()['dial_stops'], 0.0)


def fast() -> Iterator[Row]:
    """200 Hz with noise and lost samples for ten minutes: parts do not matter, nothing stops."""
    scene = load_scene('involute_weight_at_sea', duration=60.0 * MINUTES, **{'ship.rate': 20.0})
    imu = _sea(load_scene(scene.name, duration=60.0 * MINUTES, **{'ship.rate': 200.0}))
    clean, _ = _read(scene, iter([imu]))
    random = np.random.default_rng(1726)
    kept = random.uniform(size=len(imu.stamp_ns)) > 0.01
    noisy = take(imu, kept)
    shape = noisy.linear_acceleration.shape
    noisy = replace(
        noisy,
        linear_acceleration=noisy.linear_acceleration + 0.05 * random.standard_normal(shape),
    )
    whole, stage = _read(scene, iter([noisy]))
    cuts = np.cumsum(random.integers(1, 50, len(noisy.stamp_ns)))
    cuts = [0, *cuts[cuts < len(noisy.stamp_ns)].tolist(), len(noisy.stamp_ns)]
    split, _ = _read(scene, (take(noisy, slice(*pair)) for pair in pairwise(cuts)))
    name = '200 Hz, ten minutes, 1 % lost, 0.05 m/s2'
    apart = int(np.count_nonzero(whole.time_ref_ns != split.time_ref_ns))
    yield Row(name, 'readings that depend on the parts', apart, 0.0)
    yield Row(name, 'readings', len(whole.stamp_ns), 601.0, 600.0)
    yield Row(name, 'stops of the dial', stage.health()['dial_stops'], 0.0)
    moved = abs(_error_s(whole) - _error_s(clean)) * DAY_S / (60.0 * MINUTES)
    # of four seeds the largest was 85
    yield Row(name, 'change of rate by the noise [s/day]', moved, 200.0)


def live() -> list[Row]:
    """Return the rows of all cases."""
    return [*gaps(), *bias_and_noise(), *fast()]
