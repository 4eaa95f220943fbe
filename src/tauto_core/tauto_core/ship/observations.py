"""What the navigator knows of the true time (theory E7)."""

from __future__ import annotations

import numpy as np

from tauto_core.samples import NS_PER_S, IntArray, TimeSamples
from tauto_core.scene import Scene
from tauto_core.scene.times import nanoseconds
from tauto_core.ship.passage import Passage


def schedule(scene: Scene) -> IntArray:
    """Return the stamps of the observations [ns], on the log grid, strictly increasing.

    In port: every `drift.observation_interval` from the start until setting sail, both counted.
    Of each landfall: one, as `landfalls` says. A scene without a voyage is in port throughout.
    Nothing after the end of the scene.

    Raises:
        SceneError: a voyage that cannot be sailed, as `Passage` says.
    """
    return np.union1d(_in_port(scene), landfalls(scene))


def landfalls(scene: Scene) -> IntArray:
    """Return the stamps of the observations at landfalls [ns], in order, none beyond the end.

    The land is made at the first logged instant at or after the ship's passing it, and the clock
    checked at the next one: so the estimate at the landfall is what the clock told beforehand.

    Raises:
        SceneError: a voyage that cannot be sailed, as `Passage` says.
    """
    if scene.voyage is None:
        return np.empty(0, np.int64)
    interval = scene.log_interval_ns
    made = [-(-time // interval) for time in Passage(scene, scene.voyage).landfalls_ns]
    checked = [interval * (logged + 1) for logged in made]
    within = [time for time in checked if time <= scene.duration_ns]
    return scene.starts_at_ns + np.unique(np.array(within, np.int64))


def _in_port(scene: Scene) -> IntArray:
    end = scene.duration_ns
    if scene.voyage is not None:
        end = min(nanoseconds(scene.voyage.sails_at), end)
    interval = nanoseconds(scene.drift.observation_interval)
    return scene.starts_at_ns + np.arange(0, end + 1, interval, dtype=np.int64)


class Observations:
    """Observed times t_k + N(0, drift.observation_sigma).

    The k-th error of the schedule is drawn from its own generator, PCG64 seeded by (seed, k):
    it does not depend on what is asked for before it.
    """

    def __init__(self, scene: Scene) -> None:
        self._landfalls = landfalls(scene)
        self._stamps = np.union1d(_in_port(scene), self._landfalls)
        self._seed = scene.seed
        self._sigma = scene.drift.observation_sigma

    def between(self, first_ns: int, last_ns: int) -> TimeSamples:
        """Return the observations with first_ns <= stamp < last_ns, maybe none.

        `time_ref_ns` is the observed time, rounded to the nanosecond; `source` is `port` or
        `landfall`.
        """
        first, last = np.searchsorted(self._stamps, [first_ns, last_ns])
        stamps = self._stamps[first:last]
        errors = np.array([self._error_ns(k) for k in range(first, last)], np.int64)
        source = np.full(len(stamps), 'port', object)
        source[np.isin(stamps, self._landfalls)] = 'landfall'
        return TimeSamples(stamps, '', stamps + errors, source)

    def _error_ns(self, k: int) -> int:
        seeds = np.random.SeedSequence([self._seed, k])
        normal = np.random.Generator(np.random.PCG64(seeds)).standard_normal()
        return round(NS_PER_S * self._sigma * float(normal))
