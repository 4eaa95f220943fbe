"""Are the ± honest? Errors over many seeds, compared with the sigmas and intervals stated.

    .venv/bin/python benchmarks/honest_sigmas.py PART [--seeds N] [--out FILE] [OPTION …]

PART is one of

    covariates   the navigator with a rate equation, into covariate_consistency.json
    estimator    the navigator on shipped scenes, into estimator_consistency.json
    projection   the distance projected for 42 days, into projection_consistency.json
    stability    the intervals of `replay --stability`, into stability_coverage.json

The options of a part are listed by `honest_sigmas.py PART --help`.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
from scipy.stats import chi2
from whole_run import covariance, filtered_drift, means

from tauto_core.navigation import clock_model, prior
from tauto_core.navigation.covariates import expected_walk_per_s
from tauto_core.navigation.kalman import ClockModel, Estimate, predict
from tauto_core.navigation.regressors import RecordedIntegrals, Regressors, integral_names
from tauto_core.navigation.stability import stability
from tauto_core.navigation.verdict import TOO_SHORT
from tauto_core.samples import (
    OBSERVATION,
    READING,
    SHIP_IMU,
    FloatArray,
    TimeSamples,
    same,
    scalars,
)
from tauto_core.scene import Scene, load_scene, shipped_scenes
from tauto_core.scene.times import DAY_S, NS_PER_S
from tauto_core.ship import Observations
from tauto_core.ship.imu import imu_from_roll
from tauto_core.voyage import sail

Given = argparse.Namespace


def consistency(squares: list[float], degrees: int) -> dict[str, Any]:
    """Return the mean of normalised squares over seeds, and the band that holds 95 % of it."""
    low, high = chi2.ppf([0.025, 0.975], degrees * len(squares)) / len(squares)
    mean = float(np.mean(squares))
    return {
        'nees': round(mean, 3),
        'band': [round(float(low), 3), round(float(high), 3)],
        'within': bool(low < mean < high),
    }


def at_the_end(
    reading: TimeSamples,
    observation: TimeSamples,
    model: ClockModel,
    motion: RecordedIntegrals | None = None,
) -> Estimate[FloatArray]:
    """Return the estimate at the last reading."""
    way = filtered_drift(reading, observation, model, motion)
    last = way.states._make(column[-1:] for column in way.states)
    end = reading.stamp_ns[-1:]
    gained = () if motion is None else tuple((motion.at(end) - way.integrals_s[-1:]).T)
    since = int(way.stamp_ns[-1])
    under_way_s = model.under_way_s(since, int(end[0]))
    return predict(last, (end - since) / NS_PER_S, model, gained, under_way_s)


# -----------------------------------------------------------------------------
# Covariates: whether the navigator's errors agree with the sigmas of a rate equation.
#
# A dial has the rate r + sum k_j x_j, with r and the k_j drawn from the navigator's prior: three
# days in port and three in seas that change, all drawn anew for each seed. A sensor of 2 Hz with
# bias and noise measures the motion. The normalised square e^T P^-1 e of the errors of offset,
# rate and coefficients has mean 4, and its sum over N seeds is chi-squared with 4 N degrees of
# freedom.

RECORD_S = 3600.0
"""The waves repeat after this time; one record of them is made for each seed."""
BIAS, NOISE = 0.05, 0.02
"""Bias and standard deviation of the noise of the accelerometer [m/s2]."""
COEFFICIENTS = {'heave': {'value': 1.0, 'sigma': 0.05}, 'roll': {'value': 0.01, 'sigma': 0.02}}


def changing_sea(
    rng: np.random.Generator, rate_hz: float, heights: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return instants [s], roll, its rate and heave'' of waves whose height changes each hour."""
    number = round(RECORD_S * rate_hz)
    waves = rng.choice(np.arange(260, 600), 24, replace=False)
    omega = 2.0 * np.pi * waves / RECORD_S
    phases = rng.uniform(0.0, 2.0 * np.pi, (2, 24))
    size = np.exp(-0.5 * ((omega - 0.7) / 0.15) ** 2)
    rolled, heaved = (np.outer(np.arange(number) / rate_hz, omega) + phase for phase in phases)

    def scaled(rms: float, sizes: FloatArray) -> FloatArray:
        return np.asarray(rms * np.sqrt(2.0) * sizes / np.linalg.norm(sizes))

    amplitude = scaled(0.05, size)
    at_s = np.arange(round(RECORD_S * len(heights[1:]) * rate_hz) + 1) / rate_hz
    u = (at_s / RECORD_S) % 1.0
    place = np.minimum((at_s / RECORD_S).astype(int), len(heights) - 2)
    step = heights[place + 1] - heights[place]
    height = heights[place] + step * u**4 * (35.0 + u * (-84.0 + u * (70.0 - 20.0 * u)))
    slope = step * 140.0 * u**3 * (1.0 - u) ** 3 / RECORD_S
    repeats = np.arange(len(at_s)) % number
    roll = (np.cos(rolled) @ amplitude)[repeats]
    rate = (-np.sin(rolled) @ (amplitude * omega))[repeats]
    # 0.5 m/s2 root mean square if the height is 1
    heave = (np.cos(heaved) @ scaled(0.5, size * omega**2))[repeats]
    return at_s, height * roll, height * rate + slope * roll, height * heave


def drawn(seed: int) -> float:
    """Return e^T P^-1 e of offset, rate and coefficients of a dial that is drawn."""
    rng = np.random.default_rng(seed)
    hours = 144
    heights = np.exp(rng.normal(0.0, 0.5, hours // 12 + 1))
    heights[:6] *= 0.15
    heights = np.interp(np.arange(hours + 1) / 12.0, np.arange(len(heights)), heights)
    at_s, roll, roll_rate, heave = changing_sea(rng, 4.0, heights)
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
    x = np.column_stack((-0.125 * (heave / scene.g) ** 2, roll * roll))
    grown = np.zeros((len(x), 2))
    np.cumsum(0.125 * (x[1:] + x[:-1]), axis=0, out=grown[1:])
    every = 2400
    at = at_s[::every]
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
    pull = scene.g + heave + BIAS + NOISE * rng.normal(size=len(heave))
    imu = imu_from_roll(
        scene.starts_at_ns + np.rint(at_s[::2] * NS_PER_S).astype(np.int64),
        roll[::2],
        roll_rate[::2],
        (pull * np.sin(roll))[::2],
        (pull * np.cos(roll))[::2],
    )
    regressors = Regressors(scene, live=False)
    regressors.feed({SHIP_IMU: imu})
    known = scalars(stamps, integral_names(model.names), regressors.at(stamps))
    seen = Observations(scene).between(0, 2**62)
    now = at_the_end(reading, seen, model, RecordedIntegrals(known, model.names))
    at_names = [0, 1, 3, 4]
    # the sensor's noise acts as a constant rate, which belongs to the true rate
    told = walk[-1, 1] + k[0] * NOISE**2 / (8.0 * scene.g**2)
    truth = np.array([error[-1], told, *k])
    units = np.array([1.0, DAY_S, 1.0, 1.0])
    wrong = units * (means(now, model.names)[0, at_names] - truth)
    p = covariance(now, model.names)[0][np.ix_(at_names, at_names)] * np.outer(units, units)
    return float(wrong @ np.linalg.solve(p, wrong))


def covariates(given: Given) -> dict[str, Any]:
    """Print and return the figures."""
    found = [drawn(seed) for seed in range(given.seeds)]
    result = {'drawn': {'seeds': given.seeds, **consistency(found, 4)}}
    print(result['drawn'], flush=True)
    return result


# -----------------------------------------------------------------------------
# Estimator: whether the errors agree with the sigmas on shipped scenes.
#
# Each seed draws the errors of the observations anew and, in a sea, the waves through which the
# clock is sailed. At the end the estimate of offset and rate is compared with the error of the
# dial and its mean rate. The normalised error squared e^T P^-1 e has mean 2, and its sum over N
# seeds is chi-squared with 2 N degrees of freedom (Bar-Shalom, Li and Kirubarajan, Estimation with
# Applications to Tracking and Navigation, 2001, 5.4). For offset or rate alone the mean is 1.
# Where the rate is expected to walk at random, its departure from its mean is part of the
# variance.

SCENES = (
    'measured',
    'involute_weight_at_sea',
    'buoy_44004_supply',
    'hanging_thread_at_sea',
)


def sailed(scene: Scene) -> tuple[TimeSamples, TimeSamples]:
    """Return the readings and the observations of a voyage."""
    samples = sail(scene).samples
    return cast(TimeSamples, samples[READING]), cast(TimeSamples, samples[OBSERVATION])


def errors(scene: Scene) -> tuple[FloatArray, FloatArray, float]:
    """Return errors of offset [s] and rate [1] at the end, their covariance, the mean rate [1]."""
    reading, observation = sailed(scene)
    model = clock_model(scene)
    now = at_the_end(reading, observation, model)
    first_ns, end_ns = int(reading.stamp_ns[0]), int(reading.stamp_ns[-1])
    error_s = (reading.time_ref_ns - reading.stamp_ns) / NS_PER_S
    rate = float((error_s[-1] - error_s[0]) / ((end_ns - first_ns) / NS_PER_S))
    wrong = np.array([now.x[0] - error_s[-1], now.y[0] - rate])
    wandered = expected_walk_per_s(scene) * (end_ns - first_ns) / NS_PER_S / 3.0
    return wrong, covariance(now, ())[0, :2, :2] + np.diag([0.0, wandered]), rate


def of_estimator(name: str, seeds: int, prior: float | None) -> dict[str, Any]:
    """Return the mean normalised errors squared of a scene, and their 95 % band."""
    joint, alone, rates, sigmas = [], [], [], []
    for seed in range(seeds):
        scene = load_scene(name, seed=seed)
        if prior is not None:
            assumed = scene.drift.model_copy(update={'prior_rate_sigma': prior})
            scene = scene.model_copy(update={'drift': assumed})
        wrong, covariance, rate = errors(scene)
        joint.append(wrong @ np.linalg.solve(covariance, wrong))
        alone.append(wrong**2 / np.diag(covariance))
        rates.append(DAY_S * rate)
        sigmas.append(DAY_S * np.sqrt(covariance[1, 1]))
    offset, speed = np.mean(alone, axis=0)
    return {
        'scene': name,
        **consistency(joint, 2),
        'offset': round(float(offset), 3),
        'rate': round(float(speed), 3),
        'true_rate_s_per_day': [round(min(rates), 2), round(max(rates), 2)],
        'rate_sigma_s_per_day': round(float(np.mean(sigmas)), 2),
    }


def estimator(given: Given) -> dict[str, Any]:
    """Print a line for each scene; return them."""
    rows = []
    for name in given.scene or SCENES:
        rows.append(of_estimator(name, given.seeds, given.prior))
        print(rows[-1], flush=True)
    return {'seeds': given.seeds, 'prior_rate_sigma': given.prior or 'default', 'rows': rows}


# -----------------------------------------------------------------------------
# Projection: whether its ± is what seeds scatter by.
#
# Each seed draws the waves and the errors of the observations anew. Of the seeds whose run is
# projected, the errors after 42 days are compared with their standard deviations: of the dial from
# the mean over the seeds, which is what the seeds have in common; of the corrected clock its error
# if the dial had that rate. `ratio` is the standard deviation over the seeds over the root mean
# square of those stated, and has to lie in 0.5–2; it is None where fewer than two seeds are
# projected. A reason that lies in the machine holds for all seeds, so one is tried.
# `portsmouth_jamaica` is left out: it takes minutes a seed, and is a trial, which is not
# projected.

LEFT_OUT = ('portsmouth_jamaica',)


def of_projection(name: str, seeds: int) -> dict[str, Any]:
    """Return scatter, stated standard deviations and their ratio of a scene, and why not."""
    first, refused = [], Counter[str]()
    for seed in range(seeds):
        found = sail(load_scene(name, seed=seed)).result['longitude']
        first += [row for row in found['projection'][:1] if None not in row.values()]
        if reason := found['not_projected']:
            refused[reason.partition(', ')[0]] += 1
            if not reason.startswith(TOO_SHORT):
                break
    result: dict[str, Any] = {'scene': name, 'projected': len(first), 'refused': dict(refused)}
    if len(first) < 2:
        return {**result, 'ratio': None, 'corrected_ratio': None}
    dial, corrected = (np.array([row[f'{key}error_nmi'] for row in first]) for key in ('raw_', ''))
    stated = [
        float(np.sqrt(np.mean([row[f'{key}sigma_nmi'] ** 2 for row in first])))
        for key in ('raw_', '')
    ]
    mean = float(np.mean(dial))
    wrong = corrected - dial + mean
    scatter = float(np.std(dial, ddof=1)), float(np.sqrt(np.mean(wrong**2)))
    return {
        **result,
        'mean_nmi': mean,
        'scatter_nmi': scatter[0],
        'stated_nmi': stated[0],
        'ratio': scatter[0] / stated[0],
        'corrected_scatter_nmi': scatter[1],
        'corrected_stated_nmi': stated[1],
        'corrected_ratio': scatter[1] / stated[1],
    }


def projection(given: Given) -> dict[str, Any]:
    """Print a line for each scene; return them."""
    at_sea = [name for name in shipped_scenes() if load_scene(name).ship.kind == 'sea']
    rows = []
    for name in given.scene or [each for each in at_sea if each not in LEFT_OUT]:
        rows.append(of_projection(name, given.seeds))
        print(rows[-1], flush=True)
    return {'seeds': given.seeds, 'rows': rows}


# -----------------------------------------------------------------------------
# Stability: how often the 95 % intervals contain the true deviation.
#
# Seeded noise of exactly known spectrum is analysed by `stability`, and each interval is compared
# with the theoretical deviation: for all deviations, averaging times and kinds of noise, some
# lengths of record, and clocks of one kind at short and another at long times. With 500 runs a
# share of 95 % is known to ±1.0 % (one sigma).

LENGTHS = (65, 129, 513, 2049)
DEVIATIONS = ('allan', 'modified', 'time', 'hadamard')
PURE: tuple[dict[int, float], ...] = tuple({alpha: 1.0} for alpha in (2, 1, 0, -1, -2))
MIXED: tuple[dict[int, float], ...] = ({2: 1.0, 0: 0.1}, {0: 1.0, -2: 0.03}, {1: 1.0, -1: 0.1})


def coverage(parts: dict[int, float], count: int, runs: int, seed: int) -> list[dict[str, Any]]:
    """Return a row for each averaging time: the share of intervals that contain the truth."""
    sys.path.append(str(Path(__file__).resolve().parents[1] / 'tests' / 'core' / 'navigation'))
    from power_law_noise import NAMES, deviation, mixed

    random = np.random.default_rng([seed, count, *(alpha + 9 for alpha in parts)])
    held: dict[str, Any] = dict.fromkeys(DEVIATIONS, 0.0)
    named: Any = 0.0
    factors: list[int] = []
    for _ in range(runs):
        found = stability(mixed(parts, count, random), 1.0)
        factors = found['tau_s'].astype(int).tolist()
        for kind in DEVIATIONS:
            true = np.array([deviation(kind, parts, factor) for factor in factors])
            low, high = found[f'{kind}_low'], found[f'{kind}_high']
            held[kind] = held[kind] + ((low < true) & (true < high))
        named = named + np.isin(found['noise'], [NAMES[alpha] for alpha in parts])
    name = ' + '.join(f'{a:g} {NAMES[alpha]}' for alpha, a in parts.items())
    return [
        {
            'noise': name,
            'readings': count,
            'factor': factor,
            **{kind: round(100.0 * held[kind][place] / runs, 1) for kind in DEVIATIONS},
            'named': round(100.0 * named[place] / runs, 1),
        }
        for place, factor in enumerate(factors)
    ]


def stability_intervals(given: Given) -> dict[str, Any]:
    """Print and return the table, and name the shares outside 93 to 97 %."""
    rows: list[dict[str, Any]] = []
    print(f'{"noise":40} {"N":>5} {"m":>4}', *(f'{kind:>9}' for kind in (*DEVIATIONS, 'named')))
    for parts in PURE + MIXED:
        for count in LENGTHS:
            for row in coverage(parts, count, given.runs, seed=1726):
                rows.append({'pure': len(parts) == 1, **row})
                shares = (f'{row[kind]:9.1f}' for kind in (*DEVIATIONS, 'named'))
                print(f'{row["noise"]:40} {count:5} {row["factor"]:4}', *shares, flush=True)
    for pure in (True, False):
        shares = np.array(
            [row[kind] for row in rows if row['pure'] is pure for kind in DEVIATIONS]
        )
        within = float(np.mean((shares >= 93.0) & (shares <= 97.0)))
        print(
            f'{"one kind" if pure else "two kinds"}: {shares.min():.1f} to {shares.max():.1f} %, '
            f'mean {shares.mean():.2f} %; {100.0 * within:.0f} % of them within 93 to 97 %'
        )
    return {'runs': given.runs, 'confidence': 95.0, 'rows': rows}


PARTS: dict[str, tuple[Callable[[Given], dict[str, Any]], str]] = {
    'covariates': (covariates, 'covariate_consistency.json'),
    'estimator': (estimator, 'estimator_consistency.json'),
    'projection': (projection, 'projection_consistency.json'),
    'stability': (stability_intervals, 'stability_coverage.json'),
}
"""Of each part what it calls, and the file of its results."""


def main() -> None:
    """Run a part, and write what it returns."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parts = parser.add_subparsers(dest='part', required=True)
    option = {name: parts.add_parser(name).add_argument for name in PARTS}
    for name, seeds in (('covariates', 200), ('estimator', 200), ('projection', 30)):
        option[name]('--seeds', type=int, default=seeds)
    option['estimator']('--prior', type=float, help='prior_rate_sigma [s/day], for the default')
    for name in ('estimator', 'projection'):
        option[name]('--scene', action='append', help='instead of the default', default=[])
    option['stability']('--runs', type=int, default=500)
    for name, (_, file) in PARTS.items():
        option[name]('--out', type=Path, default=Path(__file__).with_name(file))
    given = parser.parse_args()
    result = json.dumps(PARTS[given.part][0](given), indent=1, ensure_ascii=False)
    given.out.write_text(result + '\n', encoding='utf-8')


if __name__ == '__main__':
    main()
