"""The dial: its reading in whole half turns and a fraction, its noise, and its setting."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np

from tauto_core.machines import AnyMachine, InPlaceOfWheel
from tauto_core.samples import FloatArray, IntArray, State
from tauto_core.scene import Scene
from tauto_core.scene.times import NS_PER_S
from tauto_core.ship.air import BoxTemperature

# -----------------------------------------------------------------------------
# The reading of the dial, with whole half turns and the fraction kept apart.


def dial_ns(half_turns: IntArray, fraction: FloatArray, nominal_period_s: float) -> IntArray:
    """Return the reading [ns] since the dial was set: nominal_period · φ / 2π.

    The phase φ is π (half_turns + fraction), 0 ≤ fraction < 1. The whole part is counted in
    integers, so long runs lose no resolution (theory/reading.md, E4).
    """
    half_period = 0.5 * nominal_period_s * NS_PER_S
    whole = math.floor(half_period)
    rest = half_period - whole
    # Blocks of 2²⁰ half turns keep the product with the rest exact to far below 1 ns.
    blocks, left = np.divmod(half_turns, 2**20)
    block_ns = rest * 2**20
    whole_block = math.floor(block_ns)
    small = blocks * (block_ns - whole_block) + left * rest + fraction * half_period
    return np.asarray(
        half_turns * whole + blocks * whole_block + np.rint(small).astype(np.int64), np.int64
    )


def at_departure(
    scene: Scene, machine: AnyMachine | InPlaceOfWheel
) -> AnyMachine | InPlaceOfWheel:
    """Return the machine at the temperature of the clock at the start of the scene."""
    if scene.air is None or isinstance(machine, InPlaceOfWheel):
        return machine
    return machine.at_celsius(float(BoxTemperature(scene).at(np.zeros(1, np.int64))[0]))


def nominal_period_s(scene: Scene, machine: AnyMachine | InPlaceOfWheel) -> float:
    """Return the time by which the dial advances in a full swing [s].

    Where the scene does not state it the dial is regulated for small swings of the machine in the
    gravity and at the temperature of the start.
    """
    return scene.clock.nominal_period or at_departure(scene, machine).small_period


# -----------------------------------------------------------------------------
# Noise of the dial: white and random-walk frequency noise, in exact discrete form
# (theory/reading.md, E8).

NOISE_BLOCK = 4096
"""Number of log indices drawn from one generator; the result depends on it."""

STREAM = 0x6469616C
"""Number of this stream of random numbers from the scene's seed ("dial" in ASCII)."""


class DialNoise:
    """Noise that is added to the reading: phase x [s] and relative rate y over log intervals τ.

    x' = x + τ y + w₁, y' = y + w₂; w₁ and w₂ are normal with the covariance

        | q1 τ + q2 τ³/3   q2 τ²/2 |
        | q2 τ²/2          q2 τ    |

    of the integrals over τ of ẋ = y + white noise (q1), ẏ = white noise (q2): Zucca and Tavella,
    Metrologia 42 (2005) 289. x = y = 0 at log index 0, when the dial is set. The two normal
    numbers of an index are a function of the seed and the index alone.

    Args:
        scene: its `clock.white_fm`, `clock.random_walk_fm`, `log.interval` and `seed`.
    """

    def __init__(self, scene: Scene) -> None:
        self._seed = scene.seed
        tau = scene.log_interval_ns / NS_PER_S
        q1, q2 = scene.clock.white_fm_s, scene.clock.random_walk_fm_per_s
        self._tau = tau
        # w₁ is half of τ w₂ and an independent part of the variance q1 τ + q2 τ³ (1/3 − 1/4)
        self._own_sigma = math.sqrt(q1 * tau + q2 * tau**3 / 12.0)
        self._rate_sigma = math.sqrt(q2 * tau)
        self._index, self._x, self._y = 0, 0.0, 0.0
        self._block, self._normals = -1, np.empty((0, 2))

    def offsets_ns(self, index: IntArray) -> IntArray:
        """Return the noise of the readings [ns] at rising log indices, from the last one on."""
        first = self._index
        x, _ = self.advance(int(index[-1]))
        return np.rint(NS_PER_S * x[index - first]).astype(np.int64)

    def advance(self, last: int) -> tuple[FloatArray, FloatArray]:
        """Return x [s] and y from the index reached to `last`, both included."""
        first, parts = self._index + 1, [np.empty((0, 2))]
        for block in range(first // NOISE_BLOCK, last // NOISE_BLOCK + 1) if first <= last else ():
            if block != self._block:
                seeds = np.random.SeedSequence(self._seed, spawn_key=(STREAM, block))
                generator = np.random.Generator(np.random.PCG64(seeds))
                self._block, self._normals = block, generator.standard_normal((NOISE_BLOCK, 2))
            begin, end = max(first - block * NOISE_BLOCK, 0), last + 1 - block * NOISE_BLOCK
            parts.append(self._normals[begin:end])
        normal = np.concatenate(parts)
        steps = self._rate_sigma * normal[:, 1]
        y = np.cumsum(np.concatenate(([self._y], steps)))
        own = self._own_sigma * normal[:, 0] + (0.5 * self._tau) * steps
        x = np.cumsum(np.concatenate(([self._x], self._tau * y[:-1] + own)))
        self._index, self._x, self._y = last, float(x[-1]), float(y[-1])
        return x, y

    def state(self) -> State:
        """Return index, phase and rate reached."""
        return {'index': self._index, 'x': self._x, 'y': self._y}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._index, self._x, self._y = state['index'], state['x'], state['y']


# -----------------------------------------------------------------------------
# The description of a dial on a live sensor: when it was set, and how much it has lost.

DIAL = 'dial'

_TIME = r'(-?\d+)\.(\d{9})'
_PATTERN = re.compile(
    rf'{DIAL}, set {_TIME} s(?:, setting (\d+))?(?:, lost {_TIME} s in (\d+) stops)?'
    rf'(?:, unsure by {_TIME} s)?'
)


@dataclass(frozen=True)
class DialSetting:
    """The setting of a dial, and for how long it has stood still since.

    Args:
        set_ns: true time at which it was set to that time [ns].
        lost_ns: time for which it has stood still [ns].
        stops: number of times that it has stood still.
        number: number of the setting, from 1.
        unsure_ns: total time by which its stamps have stepped back [ns]; the duration of these
            breaks is unknown.
    """

    set_ns: int
    lost_ns: int = 0
    stops: int = 0
    number: int = 1
    unsure_ns: int = 0

    def is_same_as(self, other: DialSetting) -> bool:
        """Return whether the dial has not been set in between; it may have stood still."""
        return (self.set_ns, self.number) == (other.set_ns, other.number)

    def again(self, set_ns: int) -> DialSetting:
        """Return the next setting, at this true time."""
        return DialSetting(set_ns, number=self.number + 1)

    def source(self) -> str:
        """Return the text of `TimeReference.source`."""
        lost = f', lost {_spelled(self.lost_ns)} s in {self.stops} stops' if self.stops else ''
        again = f', setting {self.number}' if self.number > 1 else ''
        unsure = f', unsure by {_spelled(self.unsure_ns)} s' if self.unsure_ns else ''
        return f'{DIAL}, set {_spelled(self.set_ns)} s{again}{lost}{unsure}'

    @staticmethod
    def of(source: str) -> DialSetting | None:
        """Return the setting that a source describes; None if it describes none."""
        found = _PATTERN.fullmatch(source)
        if found is None:
            return None
        set_s, set_ns, number, lost_s, lost_ns, stops, *unsure = found.groups('0')
        lost, count = _ns(lost_s, lost_ns), int(stops)
        return DialSetting(_ns(set_s, set_ns), lost, count, int(number) or 1, _ns(*unsure))


def _spelled(time_ns: int) -> str:
    seconds, rest = divmod(abs(time_ns), NS_PER_S)
    return f'{"-" if time_ns < 0 else ""}{seconds}.{rest:09d}'


def _ns(seconds: str, rest: str) -> int:
    size = int(seconds.lstrip('-')) * NS_PER_S + int(rest)
    return -size if seconds.startswith('-') else size
