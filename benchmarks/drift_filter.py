"""Observations per second through the drift filter, in one process on one core.

    .venv/bin/python benchmarks/drift_filter.py

Each figure is the best of five runs over 100,000 daily observations, in CPU seconds, so that other
work of the machine matters little.
"""

from __future__ import annotations

import time

import numpy as np

from tauto_core.navigation import ClockModel, Known, filter_phases, prior
from tauto_core.navigation.drift import Track
from tauto_core.samples import NS_PER_S, SECONDS_PER_DAY

COUNT, ONE_BY_ONE, RUNS = 100_000, 10_000, 5


def main() -> None:
    """Print a line for each number of states."""
    day_ns = round(SECONDS_PER_DAY) * NS_PER_S
    stamps = [day_ns * (k + 1) for k in range(COUNT)]
    phases = np.random.default_rng(1).normal(0.0, 0.5, COUNT).tolist()
    for states in (2, 3):
        model = ClockModel(0.5, 10.0 / SECONDS_PER_DAY, states, gate=5.0)
        start = Known(0, prior(model))
        many, single = [], []
        for _ in range(RUNS):
            began = time.process_time()
            filter_phases(start, stamps, phases, model)
            many.append(COUNT / (time.process_time() - began))
            track = Track(start, model)
            began = time.process_time()
            for k in range(ONE_BY_ONE):
                track.use([stamps[k]], [phases[k]])
            single.append(ONE_BY_ONE / (time.process_time() - began))
        print(
            f'{states} states: {max(many):,.0f} observations a second on arrays, '
            f'{max(single):,.0f} one at a time'
        )


if __name__ == '__main__':
    main()
