"""How the period depends on the amplitude."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypedDict

from tauto_core.machines.regulator import Regulator
from tauto_core.samples import SECONDS_PER_DAY
from tauto_core.scene.errors import UsageError

# 150,000 turns; beyond, the rounding of an angle shows in the clock.
LARGEST_ANGLE = 1e6


class IsochronismRow(TypedDict):
    """Period and rate at one amplitude.

    Keys:
        amplitude_rad: amplitude of the swing [rad].
        period_s: period of a full swing [s].
        rate_s_per_day: what the clock gains a day (fast is positive).
    """

    amplitude_rad: float
    period_s: float
    rate_s_per_day: float


class Isochronism(TypedDict):
    """The JSON object of `tauto isochronism`.

    Keys:
        nominal_period_s: time by which the dial advances in a full swing [s].
        rows: one per amplitude, in the order asked for.
    """

    nominal_period_s: float
    rows: list[IsochronismRow]


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
    asked = tuple(amplitudes)
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
    rows: list[IsochronismRow] = []
    for amplitude in asked:
        period = machine.period(amplitude)
        rate = rate_s_per_day(period, nominal)
        rows.append({'amplitude_rad': amplitude, 'period_s': period, 'rate_s_per_day': rate})
    return {'nominal_period_s': nominal, 'rows': rows}
