"""Whether the navigator's errors agree with his standard deviations, with a rate equation.

    .venv/bin/python benchmarks/covariate_consistency.py [--seeds 200] [--machine-seeds 60]
        [--thread-seeds 34]

A part whose number of seeds is 0 keeps its result in the file. A seed takes half a second of each
part.

`drawn`: dials whose rate is r + sum k_j x_j, with r and the k_j drawn from the navigator's prior,
three days in port and three in seas that change, all drawn anew for each seed. The motion is
measured by a sensor of 2 Hz with bias and noise. The normalised square e^T P^-1 e of the errors of
offset, rate and coefficients has mean 4, and its sum over N seeds is chi-squared with 4 N degrees
of freedom.

`machine`: the clock of `portsmouth_jamaica`, checked for twelve hours in port, then twelve at sea
without a check. The square of the offset's error over its variance has mean 1 if the prior is
right, and less if it is cautious. The error of a navigator without covariates is given for
comparison.

`thread`: the clock of `clock_hanging_thread`, for 46 hours in five seas, observed every 12 hours.
No rate equation fits it, and such a scene is refused. The errors at the end are given in sigmas
for the coefficients stated, as if it did; for the random walk of the rate that the refusal
advises, with and without the equation; and for neither.

The result is written to benchmarks/covariate_consistency.json.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2

from tauto_core.clockwork import TrochleaStage
from tauto_core.navigation import DriftStage, clock_model, prior
from tauto_core.navigation.covariates import (
    RecordedIntegrals,
    Regressors,
    fit,
    integral_names,
    runs,
)
from tauto_core.navigation.hindsight import filtered_drift
from tauto_core.navigation.kalman import ClockModel, covariance, means, predict
from tauto_core.samples import (
    CORRECTED,
    NS_PER_S,
    OBSERVATION,
    READING,
    SECONDS_PER_DAY,
    SHIP_IMU,
    FloatArray,
    ImuSamples,
    TimeSamples,
    same,
    scalars,
)
from tauto_core.scene import Scene, load_scene
from tauto_core.ship import Observations
from tauto_core.ship.imu import imu_from_roll, imu_samples
from tauto_core.ship.motions.sea import SeaShip
from tauto_core.voyage import sail

RECORD_S = 3600.0
"""The waves repeat after this time; one record of them is made for each seed."""
BIAS, NOISE = 0.05, 0.02
"""Bias and standard deviation of the noise of the accelerometer [m/s2]."""
SEAS = (
    (0.0, 0.3, 6.0, None),
    (12.0, 4.0, 11.0, 2.3),
    (24.0, 2.0, 8.0, 1.2),
    (36.0, 5.0, 12.0, 2.7),
    (46.0, 3.0, 9.0, 0.5),
)
"""From which hour, height [m], period [s] and heading [rad] of the seas of `thread`."""
COEFFICIENTS = {'heave': {'value': 1.0, 'sigma': 0.05}, 'roll': {'value': 0.01, 'sigma': 0.02}}


class Sea:
    """Waves of a seed whose height changes: roll and heave at even instants, with derivatives."""

    def __init__(self, rng: np.random.Generator, rate_hz: float, heights: FloatArray) -> None:
        number = round(RECORD_S * rate_hz)
        at = np.arange(number) / rate_hz
        waves = rng.choice(np.arange(260, 600), 24, replace=False)
        omega = 2.0 * np.pi * waves / RECORD_S
        phases = rng.uniform(0.0, 2.0 * np.pi, (2, 24))
        size = np.exp(-0.5 * ((omega - 0.7) / 0.15) ** 2)
        self.roll = self._channel(0.05, size, omega, phases[0], at)
        # 0.5 m/s2 root mean square where the height is 1
        self.heave = self._channel(0.5, size * omega**2, omega, phases[1], at)[0]
        self.at_s = np.arange(round(RECORD_S * len(heights[1:]) * rate_hz) + 1) / rate_hz
        u = (self.at_s / RECORD_S) % 1.0
        place = np.minimum((self.at_s / RECORD_S).astype(int), len(heights) - 2)
        step = heights[place + 1] - heights[place]
        self.height = heights[place] + step * u**4 * (35.0 + u * (-84.0 + u * (70.0 - 20.0 * u)))
        slope = step * 140.0 * u**3 * (1.0 - u) ** 3 / RECORD_S
        repeats = np.arange(len(self.at_s)) % number
        roll, rate, acceleration = (channel[repeats] for channel in self.roll)
        self.motion = (
            self.height * roll,
            self.height * rate + slope * roll,
            self.height * acceleration + 2.0 * slope * rate,
            self.height * self.heave[repeats],
        )

    @staticmethod
    def _channel(
        rms: float, size: FloatArray, omega: FloatArray, phase: FloatArray, at: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return a sum of waves of a given root mean square, with its first two derivatives."""
        amplitude = rms * np.sqrt(2.0) * size / np.linalg.norm(size)
        angle = np.outer(at, omega) + phase
        cosine, sine = np.cos(angle), np.sin(angle)
        return (
            cosine @ amplitude,
            -sine @ (amplitude * omega),
            -cosine @ (amplitude * omega**2),
        )


def observed(scene: Scene) -> TimeSamples:
    """Return the observations of a scene."""
    return Observations(scene).between(0, 2**62)


def way_of(
    scene: Scene, imu: ImuSamples, reading: TimeSamples, seen: TimeSamples
) -> tuple[Any, ClockModel]:
    """Return the estimate at the last reading, and its model."""
    model, regressors = clock_model(scene), Regressors(scene, live=False)
    regressors.feed({SHIP_IMU: imu})
    integrals = regressors.at(reading.stamp_ns)
    known = scalars(reading.stamp_ns, integral_names(model.names), integrals)
    motion = RecordedIntegrals(known, model.names)
    way = filtered_drift(reading, seen, model, motion)
    last = way.states._make(column[-1:] for column in way.states)
    end = reading.stamp_ns[-1:]
    gained = tuple((motion.at(end) - way.integrals_s[-1:]).T)
    return predict(last, (end - way.stamp_ns[-1]) / NS_PER_S, model, gained), model


def drawn(seed: int) -> float:
    """Return e^T P^-1 e of offset, rate and coefficients of a dial that is drawn."""
    rng = np.random.default_rng(seed)
    hours = 144
    heights = np.exp(rng.normal(0.0, 0.5, hours // 12 + 1))
    heights[:6] *= 0.15
    heights = np.interp(np.arange(hours + 1) / 12.0, np.arange(len(heights)), heights)
    sea = Sea(rng, 4.0, heights)
    scene = load_scene(
        'involute_weight_at_sea',
        duration=hours * 3600.0,
        seed=seed,
        ship={
            **load_scene('involute_weight_at_sea').ship.model_dump(exclude_none=True),
            'rate': 2.0,
        },
        log={'interval': 600.0},
        drift={
            'observation_interval': 21600.0,
            'prior_rate_sigma': 10.0,
            'gate': 1e9,
            'covariates': ['heave', 'roll'],
            'coefficients': COEFFICIENTS,
        },
    )
    model = clock_model(scene)
    start = prior(model)
    k = rng.normal([c.value for c in model.coefficients], [c.sigma for c in model.coefficients])
    offset, rate = rng.normal(0.0, np.sqrt([start.xx, start.yy]))
    roll, _, _, heave = sea.motion
    x = np.column_stack((-0.125 * (heave / scene.gravity) ** 2, roll * roll))
    grown = np.zeros((len(x), 2))
    np.cumsum(0.125 * (x[1:] + x[:-1]), axis=0, out=grown[1:])
    every = 2400
    at = sea.at_s[::every]
    walk, tau = np.zeros((len(at), 2)), 600.0
    q1, q2 = model.white_fm_s, model.random_walk_fm_per_s
    n1, n2 = rng.normal(size=(2, len(at)))
    walk[0] = offset, rate
    for i in range(1, len(at)):
        wander = np.sqrt(q2 * tau) * n2[i]
        here = np.sqrt(q1 * tau + q2 * tau**3 / 12.0) * n1[i] + 0.5 * tau * wander
        walk[i] = walk[i - 1] + [tau * walk[i - 1, 1] + here, wander]
    error = walk[:, 0] + grown[::every] @ k
    stamps = scene.starts_at_ns + np.rint(at * NS_PER_S).astype(np.int64)
    dial = stamps + np.rint(error * NS_PER_S).astype(np.int64)
    reading = TimeSamples(stamps, '', dial, same('dial', len(stamps)))
    pull = scene.gravity + heave + BIAS + NOISE * rng.normal(size=len(heave))
    imu = imu_from_roll(
        scene.starts_at_ns + np.rint(sea.at_s[::2] * NS_PER_S).astype(np.int64),
        roll[::2],
        sea.motion[1][::2],
        (pull * np.sin(roll))[::2],
        (pull * np.cos(roll))[::2],
    )
    now, model = way_of(scene, imu, reading, observed(scene))
    at_names = [0, 1, 3, 4]
    # the sensor's noise acts as a constant rate, which belongs to the true rate
    told = walk[-1, 1] + k[0] * NOISE**2 / (8.0 * scene.gravity**2)
    truth = np.array([error[-1], told, *k])
    units = np.array([1.0, SECONDS_PER_DAY, 1.0, 1.0])
    wrong = units * (means(now, model.names)[0, at_names] - truth)
    p = covariance(now, model.names)[0][np.ix_(at_names, at_names)] * np.outer(units, units)
    return float(wrong @ np.linalg.solve(p, wrong))


class Machine:
    """The clock of a shipped scene in port and at sea, run many times."""

    def __init__(self) -> None:
        ship = load_scene('portsmouth_jamaica').ship
        drift = {'observation_interval': 3600.0, 'observation_sigma': 0.1}
        common: dict[str, Any] = {
            'duration': 86400.0,
            'ship': ship.model_dump(exclude_none=True),
            'voyage': None,
            'log': {'interval': 60.0},
        }
        self.plain = load_scene('portsmouth_jamaica', **common, drift=drift)
        self.scene = load_scene(
            'portsmouth_jamaica', **common, drift={**drift, 'covariates': ['heave', 'roll']}
        )
        self._stage = TrochleaStage(self.scene)
        self._fresh = self._stage.state()

    def errors(self, seed: int) -> tuple[float, float, float]:
        """Return the corrected error at the end [s], its sigma, and that without covariates."""
        rng = np.random.default_rng(seed)
        heights = np.repeat([0.3, *np.exp(rng.normal(0.2, 0.4, 4))], [13, 3, 3, 3, 4])[:26]
        sea = Sea(rng, 10.0, heights)
        stamps = self.scene.starts_at_ns + np.rint(sea.at_s * NS_PER_S).astype(np.int64)
        roll, rate, acceleration, heave = sea.motion
        height, gravity = self.scene.ship.height, self.scene.gravity
        imu = imu_samples(stamps, roll, rate, acceleration, heave, height, gravity)
        self._stage.restore(self._fresh)
        reading = self._stage.feed({SHIP_IMU: imu})[READING]
        assert isinstance(reading, TimeSamples)
        seen = observed(self.scene.model_copy(update={'seed': seed}))
        port = seen.stamp_ns <= self.scene.starts_at_ns + 12 * 3600 * NS_PER_S
        seen = TimeSamples(seen.stamp_ns[port], '', seen.time_ref_ns[port], seen.source[port])
        now, _ = way_of(self.scene, imu, reading, seen)
        dial = float(reading.time_ref_ns[-1] - reading.stamp_ns[-1]) / NS_PER_S
        stage = DriftStage(self.plain, expect_schedule=False)
        alone = stage.feed({READING: reading, OBSERVATION: seen})[CORRECTED]
        assert isinstance(alone, TimeSamples)
        without = float(alone.time_ref_ns[-1] - alone.stamp_ns[-1]) / NS_PER_S
        return dial - float(now.x[0]), float(np.sqrt(now.xx[0])), without


def thread(seeds: int) -> dict[str, Any]:
    """Return errors at the end in sigmas of a clock with a swinging thread in five seas."""
    shipped = load_scene('clock_hanging_thread').ship
    assert isinstance(shipped, SeaShip)
    assert shipped.roll is not None
    states = [
        {
            'at': 3600.0 * at,
            'significant_wave_height': height,
            'peak_period': period,
            **({} if heading is None else {'heading': heading}),
        }
        for at, height, period, heading in SEAS
    ]
    common: dict[str, Any] = {
        'duration': 46 * 3600.0,
        'log': {'interval': 60.0, 'motion': False},
        'ship': {
            'kind': 'sea',
            'rate': 5.0,
            'heave': True,
            'speed': 1.3,
            'roll': shipped.roll.model_dump(),
            'weather': {'kind': 'states', 'states': states},
        },
    }
    seen = {'observation_interval': 12 * 3600.0, 'observation_sigma': 0.5}
    equation = {'covariates': ['heave', 'roll']}

    def scene_with(drift: dict[str, Any], seed: int = 0) -> Scene:
        scene = load_scene('clock_hanging_thread', **common, seed=seed, drift={**seen, **drift})
        return scene.model_copy(update={'suspension': None, 'voyage': None})

    scene = scene_with(equation)
    tried = tuple(each.coefficient for each in runs(scene))
    fitted = fit(scene, tried)
    stated = {each.name: {'value': each.value, 'sigma': each.sigma} for each in tried}
    walk = {'random_walk_fm': fitted.advised}
    assumed = {
        'equation_stated': {**equation, 'coefficients': stated},
        'equation_and_walk': {**equation, **walk},
        'walk': walk,
        'neither': {},
    }
    result: dict[str, Any] = {
        'seeds': seeds,
        'departure_sigmas': round(fitted.sigmas, 2),
        'random_walk_fm': fitted.advised,
    }
    for name, drift in assumed.items():
        found = []
        for seed in range(5000, 5000 + seeds):
            sailed = sail(scene_with(drift, seed)).result['drift']
            sigma = sailed['offset_sigma_s']
            found.append((sailed['offset_error_sigmas'], sailed['rate_error_sigmas'], sigma))
        offset, rate, sigma_s = np.array(found).T
        result[name] = {
            'offset_rms_sigmas': round(float(np.sqrt(np.mean(offset**2))), 2),
            'beyond_three': round(float(np.mean(np.abs(offset) > 3.0)), 3),
            'rate_rms_sigmas': round(float(np.sqrt(np.mean(rate**2))), 2),
            'error_rms_s': round(float(np.sqrt(np.mean((offset * sigma_s) ** 2))), 2),
            'sigma_s': round(float(np.mean(sigma_s)), 2),
        }
    return result


def main() -> None:
    """Print the figures, and write them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seeds', type=int, default=200)
    parser.add_argument('--machine-seeds', type=int, default=60)
    parser.add_argument('--thread-seeds', type=int, default=34)
    parser.add_argument('--out', type=Path, default=Path(__file__).with_suffix('.json'))
    given = parser.parse_args()
    result: dict[str, Any] = json.loads(given.out.read_text('utf-8')) if given.out.exists() else {}
    if given.seeds:
        found = [drawn(seed) for seed in range(given.seeds)]
        low, high = chi2.ppf([0.025, 0.975], 4 * given.seeds) / given.seeds
        mean = float(np.mean(found))
        result['drawn'] = {
            'seeds': given.seeds,
            'nees': round(mean, 3),
            'band': [round(float(low), 3), round(float(high), 3)],
            'within': bool(low < mean < high),
        }
        print(result['drawn'], flush=True)
    if given.machine_seeds:
        machine = Machine()
        rows = np.array([machine.errors(seed) for seed in range(given.machine_seeds)])
        wrong, sigma, without = rows.T
        result['machine'] = {
            'seeds': given.machine_seeds,
            'coefficients': [list(each) for each in clock_model(machine.scene).coefficients],
            'nees': round(float(np.mean((wrong / sigma) ** 2)), 3),
            'error_s': [round(float(np.mean(wrong)), 3), round(float(np.std(wrong)), 3)],
            'sigma_s': round(float(np.mean(sigma)), 3),
            'error_without_s': [
                round(float(np.mean(without)), 3),
                round(float(np.std(without)), 3),
            ],
        }
        print(result['machine'], flush=True)
    if given.thread_seeds:
        result['thread'] = thread(given.thread_seeds)
        print(result['thread'], flush=True)
    given.out.write_text(json.dumps(result, indent=1) + '\n', encoding='utf-8')


if __name__ == '__main__':
    main()
