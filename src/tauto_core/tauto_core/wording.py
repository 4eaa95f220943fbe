"""Numbers and durations as text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal

DECIMALS = {'nmi': (-2, 0), 's': (-3, -1), 's/day': (-3, 0)}
"""Powers of ten of the finest and the coarsest last place in which `figure` prints, by unit.

The finest are twenty metres, a thousandth of a second, and that a day, than which no marine
chronometer is steadier. What is computed beyond is the accuracy of the simulation, not that of a
clock; `--json` has it. An observation is good to half a second, so that the coarsest lets a reader
hold the dial against an estimate.
"""


def least(unit: str) -> float:
    """Return the least value that a `figure` of a unit can show."""
    return float(f'1e{DECIMALS[unit][0]}')


def figure(value: float | None, unit: str, *, signed: bool = False) -> str:
    """Return a figure of a clock or a longitude whose uncertainty is not known; a dash for None.

    It has three digits, less those finer and more as far as the coarsest of PLACES for its unit.
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
    """Return a value ± its standard deviation; without a deviation as `significant` does."""
    if not sigma:
        return significant(value, signed=signed)
    return f'{to_sigma(value, sigma, signed=signed)} ± {to_sigma(sigma, sigma)}'


def to_sigma(value: float, sigma: float, *, signed: bool = False) -> str:
    """Return a value down to the second significant digit of a standard deviation > 0.

    Two digits of a standard deviation are as many as are ever known of it, and the digits of the
    value behind them are noise (JCGM 100:2008, 7.2.6). The deviation itself gets its two digits.
    """
    if not (math.isfinite(value) and math.isfinite(sigma)):
        return significant(value, 2, signed=signed)
    return _to_place(value, int(f'{sigma:.1e}'.split('e')[1]) - 1, signed=signed)


def _to_place(value: float, place: int, *, signed: bool = False) -> str:
    """Return a number rounded to a power of ten; with an exponent where it would be long."""
    size = round(Decimal(abs(value)).scaleb(-place)) * Decimal(10) ** place
    sign = '' if not size else '−' if value < 0.0 else '+' if signed else ''
    if size >= _WIDEST or place < _FINEST_PLACE:
        digits = max(size.adjusted() - place, 0) if size else 0
        mantissa, exponent = f'{size:.{digits}e}'.split('e')
        return f'{sign}{mantissa}e{int(exponent)}' if size else '0'
    return f'{sign}{size:,.{max(-place, 0)}f}'


# Numbers from here on, and those with decimals beyond, have a power of ten.
_WIDEST, _FINEST_PLACE = 1e7, -6


def significant(value: float | None, digits: int = 3, *, signed: bool = False) -> str:
    """Return a number with so many significant digits and grouped thousands; a dash for None.

    Numbers below 0.001 in size, and those of seven digits and more, have a power of ten.
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
    """Return a number in a format of Python, with a minus sign in place of the hyphen.

    The format has no width, for example `+z.3f`; a z leaves no minus before a zero.
    """
    text = f'{value:{form}}'
    return f'−{text[1:]}' if text.startswith('-') else text


def span(seconds: float, digits: int = 3) -> str:
    """Return a duration [s] in its usual unit, with so many digits."""
    units = ((86_400.0, 'day'), (3_600.0, 'hour'), (60.0, 'minute'), (0.0, 'second'))
    size, unit = next(row for row in units if seconds >= 2.0 * row[0])
    return counted(float(f'{seconds / (size or 1.0):.{digits}g}'), unit)


def counted(number: float, noun: str) -> str:
    """Return a number with its noun, in the plural unless the number is one."""
    return f'{number:,g} {noun}' if number == 1 else f'{number:,g} {noun}s'


def left_out(keys: Sequence[str]) -> list[str]:
    """Return keys of a scene without a part in an answer, as a line; none where there are none."""
    return ['left out: ' + ', '.join(keys)] if keys else []


def percent(share: float) -> str:
    """Return a share as text; less than a hundredth of a per cent has no digits."""
    return '<0.01 %' if 0.0 < share < 1e-4 else f'{100.0 * share:.3g} %'


def place(latitude: float, longitude: float) -> str:
    """Return a place in whole degrees, as 48° N 7° W."""
    north, east = 'NS'[latitude < 0.0], 'EW'[longitude < 0.0]
    return f'{abs(latitude):.0f}° {north} {abs(longitude):.0f}° {east}'
