"""The dial: its reading in whole half turns and a fraction, and its setting."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np

from tauto_core.samples import NS_PER_S, FloatArray, IntArray

# -----------------------------------------------------------------------------
# The reading of the dial, with whole half turns and the fraction kept apart.


def dial_ns(half_turns: IntArray, fraction: FloatArray, nominal_period_s: float) -> IntArray:
    """Return the reading [ns] since the dial was set: nominal_period · φ / 2π (theory E4).

    The whole part is counted in integers, so long runs lose no resolution.

    Args:
        half_turns: whole half turns of the phase, (n,).
        fraction: the remaining fraction, 0 ≤ fraction < 1, (n,).
        nominal_period_s: time by which the dial advances in a full turn of the phase [s].
    """
    half_period = 0.5 * nominal_period_s * NS_PER_S
    whole = math.floor(half_period)
    rest = half_period - whole
    # Blocks of 2^20 half turns keep the product with the rest exact to far below 1 ns.
    blocks, left = np.divmod(half_turns, 2**20)
    block_ns = rest * 2**20
    whole_block = math.floor(block_ns)
    small = blocks * (block_ns - whole_block) + left * rest + fraction * half_period
    return np.asarray(
        half_turns * whole + blocks * whole_block + np.rint(small).astype(np.int64), np.int64
    )


# -----------------------------------------------------------------------------
# The description of a dial on a live sensor: when it was set, and how much it has lost.

DIAL = 'dial'

_TIME = r'(-?\d+)\.(\d{9})'
_PATTERN = re.compile(
    rf'{DIAL}, set {_TIME} s(?:, setting (\d+))?(?:, lost {_TIME} s in (\d+) stops)?'
)


@dataclass(frozen=True)
class DialSetting:
    """The setting of a dial, and for how long it has stood still since.

    Args:
        set_ns: true time at which it was set to that time [ns].
        lost_ns: time for which it has stood still [ns].
        stops: number of times that it has stood still.
        number: number of the setting, from 1.
    """

    set_ns: int
    lost_ns: int = 0
    stops: int = 0
    number: int = 1

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
        return f'{DIAL}, set {_spelled(self.set_ns)} s{again}{lost}'

    @staticmethod
    def of(source: str) -> DialSetting | None:
        """Return the setting that a source describes; None if it describes none."""
        found = _PATTERN.fullmatch(source)
        if found is None:
            return None
        set_s, set_ns, number, lost_s, lost_ns, stops = found.groups('0')
        return DialSetting(_ns(set_s, set_ns), _ns(lost_s, lost_ns), int(stops), int(number) or 1)


def _spelled(time_ns: int) -> str:
    seconds, rest = divmod(abs(time_ns), NS_PER_S)
    return f'{"-" if time_ns < 0 else ""}{seconds}.{rest:09d}'


def _ns(seconds: str, rest: str) -> int:
    size = int(seconds.lstrip('-')) * NS_PER_S + int(rest)
    return -size if seconds.startswith('-') else size
