"""Numbers and durations as text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal

DECIMALS = {'nmi': (-2, 0), 's': (-3, -1), 's/day': (-3, 0)}
"""Powers of ten of the finest and the coarsest last decimal that `figure` prints, by unit.

No marine chronometer is steadier than 0.001 s/day. Finer digits are in `--json`. The coarsest, 0.1
s, lets a reader compare the dial with an observation, which is good to half a second.
"""


def least(unit: str) -> float:
    """Return the least value that `figure` shows in a unit."""
    return float(f'1e{DECIMALS[unit][0]}')


def figure(value: float | None, unit: str, *, signed: bool = False) -> str:
    """Return a figure of a clock or a longitude without uncertainty, a dash for None.

    It has three significant digits, its last decimal within `DECIMALS`.
    """
    if value is None:
        return '–'
    if value == 0.0 or not math.isfinite(value) or abs(value) >= _WIDEST:
        return significant(value, signed=signed)
    if abs(value) < least(unit):
        return f'<{least(unit):g}'
    finest, coarsest = DECIMALS[unit]
    place = math.floor(math.log10(abs(value))) - 2
    return _to_place(value, min(max(place, finest), coarsest), signed=signed)


def with_sigma(value: float, sigma: float | None, *, signed: bool = True) -> str:
    """Return a value ± its standard deviation; without one see `significant`."""
    if not sigma:
        return significant(value, signed=signed)
    return f'{to_sigma(value, sigma, signed=signed)} ± {to_sigma(sigma, sigma)}'


def to_sigma(value: float, sigma: float, *, signed: bool = False) -> str:
    """Return a value down to the second significant digit of a standard deviation > 0.

    Further digits are noise (JCGM 100:2008, 7.2.6).
    """
    if not (math.isfinite(value) and math.isfinite(sigma)):
        return significant(value, 2, signed=signed)
    return _to_place(value, int(f'{sigma:.1e}'.split('e')[1]) - 1, signed=signed)


def _to_place(value: float, place: int, *, signed: bool = False) -> str:
    """Return a number rounded to a power of ten, with an exponent if it is long."""
    size = round(Decimal(abs(value)).scaleb(-place)) * Decimal(10) ** place
    sign = '' if not size else '−' if value < 0.0 else '+' if signed else ''
    if size >= _WIDEST or place < _FINEST_PLACE:
        digits = max(size.adjusted() - place, 0) if size else 0
        mantissa, exponent = f'{size:.{digits}e}'.split('e')
        return f'{sign}{mantissa}e{int(exponent)}' if size else '0'
    return f'{sign}{size:,.{max(-place, 0)}f}'


# Larger numbers, and finer last decimals, are written with an exponent.
_WIDEST, _FINEST_PLACE = 1e7, -6


def significant(value: float | None, digits: int = 3, *, signed: bool = False) -> str:
    """Return a number with `digits` significant digits and grouped thousands, a dash for None.

    Numbers below 0.001 in size, and from 1e7, are written with an exponent.
    """
    if value is None:
        return '–'
    if value == 0.0:
        return '0'
    if not math.isfinite(value):
        return f'{value:g}'
    sign = '−' if value < 0.0 else '+' if signed else ''
    mantissa, exponent = f'{abs(value):.{digits - 1}e}'.split('e')
    power = int(exponent)
    if not -3 <= power < 7:
        return f'{sign}{mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa}e{power}'
    return f'{sign}{float(mantissa + "e" + exponent):,.{max(digits - 1 - power, 0)}f}'


def printed(value: float, form: str) -> str:
    """Return a number in a Python format without a width, with a minus sign for the hyphen."""
    text = f'{value:{form}}'
    return f'−{text[1:]}' if text.startswith('-') else text


def span(seconds: float, digits: int = 3) -> str:
    """Return a duration [s] in days, hours, minutes or seconds, at least two of them."""
    units = ((86_400.0, 'day'), (3_600.0, 'hour'), (60.0, 'minute'), (0.0, 'second'))
    size, unit = next(row for row in units if seconds >= 2.0 * row[0])
    return counted(float(f'{seconds / (size or 1.0):.{digits}g}'), unit)


def counted(number: float, noun: str) -> str:
    """Return a number with its noun in singular or plural."""
    return f'{number:,g} {noun}' if number == 1 else f'{number:,g} {noun}s'


def left_out(keys: Sequence[str]) -> list[str]:
    """Return the line about keys of a scene that are not used, if any."""
    return ['left out: ' + ', '.join(keys)] if keys else []


def percent(share: float) -> str:
    """Return a share in per cent, at least `<0.01 %`."""
    return '<0.01 %' if 0.0 < share < 1e-4 else f'{100.0 * share:.3g} %'


def place(latitude: float, longitude: float) -> str:
    """Return a place in whole degrees, such as 48° N 7° W."""
    north, east = 'NS'[latitude < 0.0], 'EW'[longitude < 0.0]
    return f'{abs(latitude):.0f}° {north} {abs(longitude):.0f}° {east}'
