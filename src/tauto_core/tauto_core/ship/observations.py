"""The navigator's observations of the true time (theory E7)."""

from __future__ import annotations

import numpy as np

from tauto_core.samples import IntArray, TimeSamples
from tauto_core.scene import Scene
from tauto_core.scene.times import NS_PER_S, nanoseconds
from tauto_core.ship.passage import Passage

PORT, LANDFALL, LUNAR = 'port', 'landfall', 'lunar'
"""Values of `TimeReference.source` for observations."""

_LUNARS, _CLOUDS = 0x6C756E61, 0x636C6F75
"""Streams of random numbers from the seed, apart from the errors of observations in port."""


def schedule(scene: Scene) -> IntArray:
    """Return the stamps of the observations [ns], on the log grid, strictly increasing.

    In port there is one every `drift.observation_interval`, from the start until setting sail,
    both included. At each landfall there is one, as `landfalls` says. At sea, where asked for,
    there are lunar distances. A scene without a voyage is in port throughout. There are none after
    the end of the scene, and none that clouds hide; landfalls are never hidden.

    Raises:
        SceneError: a voyage that cannot be sailed, as `Passage` says.
    """
    return Observations(scene).stamps


def landfalls(scene: Scene) -> IntArray:
    """Return the stamps of the observations at landfalls [ns], in order, none beyond the end.

    The land is made at the first logged instant at or after the ship's passing it, and the clock
    is checked at the next one. So the estimate at the landfall is what the clock showed before the
    check.

    Raises:
        SceneError: a voyage that cannot be sailed, as `Passage` says.
    """
    if scene.voyage is None:
        return np.empty(0, np.int64)
    interval = scene.log_interval_ns
    made = [-(-time // interval) for time in Passage(scene, scene.voyage).landfalls_ns]
    checked = [interval * (logged + 1) for logged in made]
    within = [time for time in checked if time <= scene.duration_ns]
    return scene.starts_at_ns + np.array(sorted(set(within)), np.int64)


def _in_port(scene: Scene) -> IntArray:
    end = scene.duration_ns
    if scene.voyage is not None:
        end = min(nanoseconds(scene.voyage.sails_at), end)
    interval = nanoseconds(scene.drift.observation_interval)
    return scene.starts_at_ns + np.arange(0, end + 1, interval, dtype=np.int64)


def _by_the_moon(scene: Scene) -> IntArray:
    """Return the stamps of lunar distances [ns]: multiples of their interval between the ports."""
    lunars = scene.drift.lunars
    if lunars is None or scene.voyage is None:
        return np.empty(0, np.int64)
    passage, interval = Passage(scene, scene.voyage), nanoseconds(lunars.interval)
    first = passage.sails_ns // interval + 1
    last = min(passage.arrives_ns - 1, scene.duration_ns) // interval
    return scene.starts_at_ns + interval * np.arange(first, last + 1, dtype=np.int64)


class Observations:
    """Observed times t_k + N(0, sigma), sigma that of the port or of lunar distances.

    The k-th error in port and at landfalls is drawn from its own generator, PCG64 seeded by
    (seed, k), so it does not depend on earlier calls. The error of each lunar distance, and
    whether clouds hide an observation, are drawn in the same way from separate streams.

    Attributes:
        stamps: stamps of the observations, as `schedule` says.
    """

    def __init__(self, scene: Scene) -> None:
        self._seed, drift = scene.seed, scene.drift
        made = landfalls(scene)
        known = np.union1d(_in_port(scene), made)
        lunars = np.setdiff1d(_by_the_moon(scene), known)
        errors = {
            int(stamp): (LANDFALL if stamp in made else PORT, k, drift.observation_sigma)
            for k, stamp in enumerate(known)
        }
        if drift.lunars is not None:
            sigma = drift.lunars.sigma
            errors |= {int(stamp): (LUNAR, k, sigma) for k, stamp in enumerate(lunars)}
        self._drawn = {
            stamp: errors[stamp]
            for stamp in sorted(errors)
            if errors[stamp][0] == LANDFALL or not self._hidden(stamp, drift.clouds)
        }
        self.stamps: IntArray = np.array(list(self._drawn), np.int64)

    def between(self, first_ns: int, last_ns: int) -> TimeSamples:
        """Return the observations with first_ns <= stamp < last_ns, possibly none.

        `time_ref_ns` is the observed time, rounded to the nanosecond; `source` is `port`,
        `landfall` or `lunar`.
        """
        first, last = np.searchsorted(self.stamps, [first_ns, last_ns])
        stamps = self.stamps[first:last]
        drawn = [self._drawn[int(stamp)] for stamp in stamps]
        errors = np.array([self._error_ns(*each) for each in drawn], np.int64)
        source = np.empty(len(stamps), object)
        source[:] = [each[0] for each in drawn]
        return TimeSamples(stamps, '', stamps + errors, source)

    def _error_ns(self, source: str, k: int, sigma: float) -> int:
        seeds = np.random.SeedSequence([self._seed, k])
        if source == LUNAR:
            seeds = np.random.SeedSequence(self._seed, spawn_key=(_LUNARS, k))
        normal = np.random.Generator(np.random.PCG64(seeds)).standard_normal()
        return round(NS_PER_S * sigma * float(normal))

    def _hidden(self, stamp_ns: int, share: float) -> bool:
        """Return whether clouds hide an observation at a time."""
        if share == 0.0:
            return False
        seeds = np.random.SeedSequence(self._seed, spawn_key=(_CLOUDS, *divmod(stamp_ns, 10**9)))
        return float(np.random.Generator(np.random.PCG64(seeds)).random()) < share
