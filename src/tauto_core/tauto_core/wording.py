"""Numbers and durations as text, in the same form in every table, sentence and figure."""

from __future__ import annotations

import math


def significant(value: float | None, digits: int = 4, *, signed: bool = False) -> str:
    """Return a number with so many significant digits and grouped thousands; a dash for None.

    Numbers below 0.001 in size, and those of seven digits and more, have a power of ten.

    Args:
        value: the number.
        digits: significant digits, >= 1.
        signed: whether a positive number has a sign too.
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

    Args:
        value: the number.
        form: the format without a width, for example `+z.3f`; a z leaves no minus before a zero.
    """
    text = f'{value:{form}}'
    return f'−{text[1:]}' if text.startswith('-') else text


def span(seconds: float, digits: int = 4) -> str:
    """Return a duration [s] in its usual unit, with so many digits."""
    units = ((86_400.0, 'day'), (3_600.0, 'hour'), (60.0, 'minute'), (0.0, 'second'))
    size, unit = next(each for each in units if seconds >= 2.0 * each[0])
    return counted(float(f'{seconds / (size or 1.0):.{digits}g}'), unit)


def counted(number: float, noun: str) -> str:
    """Return a number with its noun, in the plural unless the number is one."""
    return f'{number:,g} {noun}' if number == 1 else f'{number:,g} {noun}s'
