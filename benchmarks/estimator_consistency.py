"""Whether the navigator's errors agree with his standard deviations: shipped scenes, many seeds.

    .venv/bin/python benchmarks/estimator_consistency.py [--seeds 200] [--prior RATE]

Each seed draws the errors of the observations anew and, in a sea, the waves through which the
clock is sailed. At the end the estimate of offset and rate is compared with the error of the dial
and its mean rate. The normalised error squared e^T P^-1 e has mean 2, and its sum over N seeds is
chi-squared with 2 N degrees of freedom (Bar-Shalom, Li and Kirubarajan, Estimation with
Applications to Tracking and Navigation, 2001, 5.4). For offset or rate alone the mean is 1. Where
the rate is expected to walk at random, its departure from its mean is part of the variance.
The result is written to benchmarks/estimator_consistency.json.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any, cast

import numpy as np
from scipy.stats import chi2

from tauto_core.navigation import clock_model
from tauto_core.navigation.covariates import expected_walk_per_s
from tauto_core.navigation.hindsight import filtered_drift
from tauto_core.navigation.kalman import Estimate, predict
from tauto_core.samples import (
    NS_PER_S,
    OBSERVATION,
    READING,
    SECONDS_PER_DAY,
    FloatArray,
    TimeSamples,
)
from tauto_core.scene import Scene, load_scene
from tauto_core.voyage import sail

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
    way = filtered_drift(reading, observation, model)
    last = Estimate(*(float(column[-1]) for column in way.states))
    first_ns, end_ns = int(reading.stamp_ns[0]), int(reading.stamp_ns[-1])
    now = predict(last, (end_ns - int(way.stamp_ns[-1])) / NS_PER_S, model)
    error_s = (reading.time_ref_ns - reading.stamp_ns) / NS_PER_S
    rate = float((error_s[-1] - error_s[0]) / ((end_ns - first_ns) / NS_PER_S))
    wrong = np.array([now.x - error_s[-1], now.y - rate])
    wandered = expected_walk_per_s(scene) * (end_ns - first_ns) / NS_PER_S / 3.0
    return wrong, np.array([[now.xx, now.xy], [now.xy, now.yy + wandered]]), rate


def consistency(name: str, seeds: int, prior: float | None) -> dict[str, Any]:
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
        rates.append(SECONDS_PER_DAY * rate)
        sigmas.append(SECONDS_PER_DAY * np.sqrt(covariance[1, 1]))
    low, high = chi2.ppf([0.025, 0.975], 2 * seeds) / seeds
    offset, speed = np.mean(alone, axis=0)
    mean = float(np.mean(joint))
    return {
        'scene': name,
        'nees': round(mean, 3),
        'band': [round(float(low), 3), round(float(high), 3)],
        'within': bool(low < mean < high),
        'offset': round(float(offset), 3),
        'rate': round(float(speed), 3),
        'true_rate_s_per_day': [round(min(rates), 2), round(max(rates), 2)],
        'rate_sigma_s_per_day': round(float(np.mean(sigmas)), 2),
    }


def main() -> None:
    """Print a line for each scene, and write them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seeds', type=int, default=200)
    parser.add_argument('--prior', type=float, help='prior_rate_sigma [s/day], for the default')
    parser.add_argument('--scene', action='append', help='instead of the four', default=[])
    parser.add_argument('--out', type=Path, default=Path(__file__).with_suffix('.json'))
    given = parser.parse_args()
    rows = []
    for name in given.scene or SCENES:
        rows.append(consistency(name, given.seeds, given.prior))
        print(rows[-1], flush=True)
    result = {'seeds': given.seeds, 'prior_rate_sigma': given.prior or 'default', 'rows': rows}
    given.out.write_text(json.dumps(result, indent=1) + '\n', encoding='utf-8')


if __name__ == '__main__':
    main()
