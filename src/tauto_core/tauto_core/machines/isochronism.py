"""How the period depends on the amplitude."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields

import numpy as np

from tauto_core.machines.regulator import Regulator
from tauto_core.samples import SECONDS_PER_DAY, FloatArray
from tauto_core.scene.errors import UsageError
from tauto_core.wording import printed

# 150,000 turns; beyond, the rounding of an angle shows in the clock.
LARGEST_ANGLE = 1e6

# Periods are computed to 1e-12, but a table ends where a reader can do nothing with more: the rate
# at a thousandth of a second a day, than which no marine chronometer is steadier, and the period
# at the nanosecond, a tenth of that in a day and the last digit of a stamp. `--json` has all.
PERIOD = '.9f'
_COLUMNS = {
    'amplitude_rad': ('amplitude rad', 14, '.6g'),
    'amplitude_m': ('amplitude m', 14, '.6g'),
    'descent_s': ('descent s', 13, PERIOD),
    'period_s': ('period s', 13, PERIOD),
    'rate_s_per_day': ('rate s/day', 13, '+z,.3f'),
}
"""Heading, width and format of each column."""


@dataclass(frozen=True, eq=False)
class SwingTable:
    """Figures of free swings at several amplitudes; `str` gives them as a table.

    Attributes:
        nominal_period_s: time by which the dial advances in a full swing [s].
    """

    nominal_period_s: float

    def columns(self) -> dict[str, FloatArray]:
        """Return the arrays, by name."""
        return {each.name: getattr(self, each.name) for each in fields(self)[1:]}

    def __str__(self) -> str:
        table = []
        for name, column in self.columns().items():
            heading, width, form = _COLUMNS[name]
            cells = [heading, *(printed(value, form) for value in column.tolist())]
            table.append([f'{cell:>{width}}' for cell in cells])
        lines = ('  '.join(row) for row in zip(*table, strict=True))
        return '\n'.join([f'nominal period {self.nominal_period_s:{PERIOD}} s', *lines])


@dataclass(frozen=True, eq=False)
class Isochronism(SwingTable):
    """Period and rate of free swings on land at several amplitudes; `str` gives a table.

    Attributes:
        nominal_period_s: time by which the dial advances in a full swing [s].
        amplitude_rad: amplitude of the swing, (n,) [rad].
        period_s: period of a full swing, (n,) [s].
        rate_s_per_day: what the clock gains a day, (n,) [s/day]; fast is positive.
    """

    amplitude_rad: FloatArray
    period_s: FloatArray
    rate_s_per_day: FloatArray


def rate_s_per_day(period_s: float, nominal_period_s: float) -> float:
    """Return what a clock gains in a day of true time, 86400 (T₀ − T)/T [s/day].

    Args:
        period_s: T, of a full swing in true time [s], > 0.
        nominal_period_s: T₀, time by which the dial advances in a full swing [s], > 0.
    """
    return SECONDS_PER_DAY * (nominal_period_s - period_s) / period_s


def isochronism(
    machine: Regulator, amplitudes: Iterable[float], nominal_period_s: float | None = None
) -> Isochronism:
    """Return period and rate of free swings on land at several amplitudes.

    Args:
        machine: the machine; its drag and escapement are ignored.
        amplitudes: [rad], each > 0, within the machine's range and at most 1e6.
        nominal_period_s: time by which the dial advances in a full swing; the small-amplitude
            period when left out.

    Raises:
        UsageError: no amplitude, or one out of range, before anything is computed.
        SlackThreadError: a swing in which the thread goes slack.
    """
    asked = [float(amplitude) for amplitude in amplitudes]
    edge = min(machine.range_rad, LARGEST_ANGLE)
    if not asked:
        raise UsageError('amplitudes: none given; give at least one, in radians')
    for amplitude in asked:
        if not 0.0 < amplitude <= edge:
            raise UsageError(
                f'amplitude {amplitude!r} rad: must be > 0 and within the range of the machine, '
                f'{edge!r} rad; give another'
            )
    nominal = machine.small_period if nominal_period_s is None else nominal_period_s
    period = np.array([machine.period(amplitude) for amplitude in asked])
    rate = np.array([rate_s_per_day(each, nominal) for each in period.tolist()])
    return Isochronism(nominal, np.array(asked), period, rate)
