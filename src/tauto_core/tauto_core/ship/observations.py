"""What the navigator knows of the true time (theory E7)."""

from __future__ import annotations

import numpy as np

from tauto_core.samples import NS_PER_S, IntArray, TimeSamples
from tauto_core.scene import Scene
from tauto_core.scene.times import nanoseconds


def schedule(scene: Scene) -> IntArray:
    """Return the stamps of the observations [ns], on the log grid, strictly increasing.

    In port: every `drift.observation_interval` from the start until setting sail, both counted.
    At landfall: `voyage.arrives_at`, rounded down to the log grid. A scene without a voyage is
    in port throughout. Nothing after the end of the scene.
    """
    return scene.starts_at_ns + _from_start(scene)


def _from_start(scene: Scene) -> IntArray:
    interval = nanoseconds(scene.drift.observation_interval)
    end = scene.duration_ns
    if scene.voyage is None:
        return np.arange(0, end + 1, interval, dtype=np.int64)
    in_port = min(nanoseconds(scene.voyage.sails_at), end)
    times = np.arange(0, in_port + 1, interval, dtype=np.int64)
    landfall = _landfall(scene)
    if times[-1] < landfall <= end:
        times = np.append(times, landfall)
    return times


def _landfall(scene: Scene) -> int:
    """Return the time of landfall from the start [ns], on the log grid; -1 without a voyage."""
    if scene.voyage is None:
        return -1
    arrives_at = nanoseconds(scene.voyage.arrives_at)
    return arrives_at - arrives_at % scene.log_interval_ns


class Observations:
    """Observed times t_k + N(0, drift.observation_sigma).

    The k-th error of the schedule is drawn from its own generator, PCG64 seeded by (seed, k):
    it does not depend on what is asked for before it.
    """

    def __init__(self, scene: Scene) -> None:
        self._stamps = schedule(scene)
        self._seed = scene.seed
        self._sigma = scene.drift.observation_sigma
        self._landfall = scene.starts_at_ns + _landfall(scene)

    def between(self, first_ns: int, last_ns: int) -> TimeSamples:
        """Return the observations with first_ns <= stamp < last_ns, maybe none.

        `time_ref_ns` is the observed time, rounded to the nanosecond; `source` is `port` or
        `landfall`.
        """
        first, last = np.searchsorted(self._stamps, [first_ns, last_ns])
        stamps = self._stamps[first:last]
        errors = np.array([self._error_ns(k) for k in range(first, last)], np.int64)
        source = np.full(len(stamps), 'port', object)
        source[stamps == self._landfall] = 'landfall'
        return TimeSamples(stamps, '', stamps + errors, source)

    def _error_ns(self, k: int) -> int:
        seeds = np.random.SeedSequence([self._seed, k])
        normal = np.random.Generator(np.random.PCG64(seeds)).standard_normal()
        return round(NS_PER_S * self._sigma * float(normal))
