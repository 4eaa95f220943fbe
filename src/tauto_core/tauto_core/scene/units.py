"""Numbers with a unit in words, such as `5 mm` or `60 deg`.

The description of a key declares its unit in brackets, such as `[m]` or `[kg m2]`. A text of a
number and a unit is converted to it. A unit of another kind is refused.

    in_unit('5 mm', 'm')      # 0.005
    in_unit('12 kn', 'm/s')   # 6.173333333333334
    in_unit('5 min', 'm')     # '5 min', which `misfit` explains

Conversions are exact up to the last rounding: `9.3 mm` is the number 0.0093, and degrees are
converted as by `math.radians`. No NumPy, no pydantic.

Sources: NIST SP 811, appendix B, for the international foot (0.3048 m) and pound (0.45359237 kg)
of 1959 and the nautical mile (1852 m) of 1929. The Rhenish foot has 139.13 Paris lines, 313.85 mm
(Prussia, 1816). Older standards differ in the fourth digit. The Paris foot is 324.84 mm (1766),
the pound of Paris (poids de marc) 489.5 g.
"""

from __future__ import annotations

import difflib
import math
import re
from contextlib import suppress
from fractions import Fraction
from functools import cache
from typing import NamedTuple

from tauto_core.scene.errors import Argument, UsageError

RHENISH_FOOT_M = 0.31385
PARIS_FOOT_M = 0.32484
PARIS_POUND_KG = 0.4895


class Unit(NamedTuple):
    """A unit, as a factor to SI units and radians.

    Attributes:
        scale: the factor, without powers of π/180.
        powers: of metre, kilogram, second, kelvin and radian.
        degrees: power of π/180 in the factor.
        zero: zero point of a temperature scale [K], otherwise 0.
    """

    scale: Fraction
    powers: tuple[int, int, int, int, int]
    degrees: int = 0
    zero: Fraction = Fraction(0)

    def to(self, power: int) -> Unit:
        """Return a power of the unit."""
        powers = tuple(power * p for p in self.powers)
        return Unit(self.scale**power, powers, power * self.degrees)  # type: ignore[arg-type]

    def by(self, unit: Unit) -> Unit:
        """Return the product of two units."""
        powers = tuple(map(sum, zip(self.powers, unit.powers, strict=True)))
        degrees = self.degrees + unit.degrees
        return Unit(self.scale * unit.scale, powers, degrees)  # type: ignore[arg-type]


_KINDS = {
    (1, 0, 0, 0, 0): 'length',
    (0, 1, 0, 0, 0): 'mass',
    (0, 0, 1, 0, 0): 'time',
    (0, 0, 0, 1, 0): 'temperature',
    (0, 0, 0, 0, 1): 'angle',
    (0, 0, -1, 0, 0): 'frequency',
    (1, 0, -1, 0, 0): 'speed',
    (1, 0, -2, 0, 0): 'acceleration',
    (1, 1, -2, 0, 0): 'force',
    (2, 1, -2, 0, 0): 'energy or torque',
    (2, 0, 0, 0, 0): 'area',
}


@cache
def unit_table() -> dict[str, Unit]:
    """Return all units by name, with prefixes and plurals."""
    kinds = {kind: powers for powers, kind in _KINDS.items()}
    table: dict[str, Unit] = {}
    for kind, units in {
        'length': 'm 1, ft 0.3048, in 0.0254, yd 0.9144, fathom 1.8288, nmi 1852, '
        f'rhenish_foot {RHENISH_FOOT_M}, paris_foot {PARIS_FOOT_M}',
        'mass': f'g 1e-3, t 1e3, lb 0.45359237, oz 0.028349523125, paris_pound {PARIS_POUND_KG}',
        'time': 's 1, min 60, h 3600, d 86400, week 604800',
        'temperature': 'K 1',
        'angle': 'rad 1',
        'frequency': 'Hz 1',
        'force': 'N 1',
        'energy or torque': 'J 1',
    }.items():
        for name, size in (item.split() for item in units.split(', ')):
            table[name] = Unit(Fraction(size), kinds[kind])
    table |= {
        'scruple': Unit(Fraction(str(RHENISH_FOOT_M)) / 1000, kinds['length']),
        'paris_inch': Unit(Fraction(str(PARIS_FOOT_M)) / 12, kinds['length']),
        'paris_line': Unit(Fraction(str(PARIS_FOOT_M)) / 144, kinds['length']),
        'kn': Unit(Fraction(1852, 3600), kinds['speed']),
        'turn': Unit(Fraction(360), kinds['angle'], 1),
        'deg': Unit(Fraction(1), kinds['angle'], 1),
        'arcmin': Unit(Fraction(1, 60), kinds['angle'], 1),
        'arcsec': Unit(Fraction(1, 3600), kinds['angle'], 1),
        'degC': Unit(Fraction(1), kinds['temperature'], 0, Fraction('273.15')),
        'degF': Unit(Fraction(5, 9), kinds['temperature'], 0, Fraction('459.67') * 5 / 9),
    }
    for prefix, power in {'n': -9, 'u': -6, 'µ': -6, 'm': -3, 'c': -2, 'k': 3}.items():
        factor = Fraction(f'1e{power}')
        for name in ('m', 'g', 's', 'rad', 'Hz', 'N', 'J'):
            # for sailors nm is the nautical mile. Centi is used with metres only
            if prefix + name != 'nm' and (prefix != 'c' or name == 'm'):
                table[prefix + name] = Unit(factor * table[name].scale, table[name].powers)
    for name, aliases in {
        'm': 'metre metres meter meters',
        'ft': 'foot feet',
        'in': 'inch inches',
        'yd': 'yard yards',
        'fathom': 'fathoms',
        'g': 'gram grams',
        'kg': 'kilogram kilograms',
        'lb': 'lbs',
        's': 'second seconds sec',
        'min': 'minute minutes',
        'h': 'hour hours hr',
        'd': 'day days',
        'week': 'weeks',
        'kn': 'kt knot knots',
        'rad': 'radian radians',
        'turn': 'turns',
        'deg': 'degree degrees °',
        'degC': '°C celsius',
        'degF': '°F fahrenheit',
        'K': 'kelvin',
    }.items():
        table |= dict.fromkeys(aliases.split(), table[name])
    return table


NUMBER = r'[-+−]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]{1,3})?'
"""The number in front of a unit, as a regular expression."""
_MEASURE = rf'({NUMBER})\s*([^\s0-9.,].{{0,30}})'
_BEGINNINGS = frozenset('+-−.0123456789')
_FACTOR = r'([A-Za-zµμ°][A-Za-zµμ°_]*)(?:\^|\*\*)?([-+]?[1-9])?'
# longest text that is read
_LONGEST = 80


@cache
def unit_of(text: str) -> Unit | None:
    """Return a unit such as `m`, `kg m2`, `m/s2` or `1/K`, or None for other text."""
    text = text.replace('²', '2').replace('³', '3').replace('μ', 'µ')
    table = unit_table()
    if text in table:
        return table[text]
    product, *divisors = text.split('/')
    result = Unit(Fraction(1), (0, 0, 0, 0, 0))
    for sign, part in ((1, product), *((-1, divisor) for divisor in divisors)):
        factors = re.split(r'\s*[·*]\s*|\s+', part.strip().replace('**', '^'))
        if sign < 0 and len(factors) > 1:
            return None  # m/s kg is ambiguous
        for factor in factors:
            if factor == '1' and sign > 0 and len(factors) == 1 and divisors:
                continue
            match = re.fullmatch(_FACTOR, factor)
            unit = table.get(match[1]) if match else None
            if match is None or unit is None or unit.zero:
                return None
            result = result.by(unit.to(sign * int(match[2] or 1)))
    return result


@cache
def declared(description: str | None) -> str | None:
    """Return the unit in brackets in the description of a key or an option, if any."""
    for text in re.findall(r'\[([^\[\]]+)\]', description or ''):
        if unit_of(text) is not None:
            return str(text)
    return 'deg' if 'in degrees' in (description or '') else None


def unit_in(value: object) -> str:
    """Return the unit of a text such as `5 mm`, '' for anything else."""
    text = value.strip()[: _LONGEST + 1] if isinstance(value, str) else ''
    # most texts are words: compile no expression for them
    match = re.fullmatch(_MEASURE, text) if text[:1] in _BEGINNINGS else None
    return match[2] if match else ''


def in_words(value: object) -> bool:
    """Return whether a value looks like a number with a unit, or is a list with one."""
    if isinstance(value, list | tuple) and not {str, list, tuple}.isdisjoint(map(type, value)):
        return any(map(in_words, value))
    return unit_in(value) != ''


def in_unit(value: object, unit: str) -> object:
    """Return a text with a number and a unit as a number in `unit`, also in lists.

    Other values are returned unchanged.
    """
    if isinstance(value, str):
        number = _number(value, unit)
        return value if number is None else number
    if isinstance(value, list | tuple) and in_words(value):
        return [in_unit(item, unit) for item in value]
    return value


def _number(text: str, unit: str) -> float | None:
    """Return the number in a unit, or None if the text has no unit of this kind."""
    match = re.fullmatch(_MEASURE, text.strip()[: _LONGEST + 1])
    source, wanted = unit_of(match[2]) if match else None, unit_of(unit)
    if match is None or source is None or wanted is None or source.powers != wanted.powers:
        return None
    if source.zero and not wanted.zero:
        return None  # a temperature is not a difference of temperatures
    size = Fraction(match[1].replace('−', '-')) * source.scale + source.zero - wanted.zero
    try:
        number = float(size / wanted.scale)
    except OverflowError:
        return None
    return number * math.radians(1.0) ** (source.degrees - wanted.degrees)


def misfit(value: str, unit: str) -> tuple[str, str] | None:
    """Return why `in_unit` did not convert a text, and the remedy.

    None if the text is not a number with a unit.
    """
    if not unit:
        known = unit_of(unit_in(value)) is not None
        return ('must be a number without a unit', '') if known else None
    point = value.replace(',', '.', 1)
    if point != value:
        with suppress(ValueError):
            measure(point, unit)
            return 'has a decimal comma', f'Write {point}.'
    match, wanted = re.fullmatch(_MEASURE, value.strip()[: _LONGEST + 1]), unit_of(unit)
    if match is None or wanted is None:
        return None
    source, kind, fit = unit_of(match[2]), _KINDS.get(wanted.powers, 'number'), fitting(wanted)
    if wanted.powers == (0, 0, 0, 1, 0) and not wanted.zero:
        kind, fit = 'difference of temperatures', ['K']
    remedy = f'Units that fit: {", ".join(dict.fromkeys([unit, *fit]))}.'
    if source is None:
        matches = difflib.get_close_matches(match[2], fit, 1, cutoff=0.5)
        guess = f'; did you mean {matches[0]}?' if matches else ''
        return f'{match[2]!r} is not a known unit{guess}', remedy
    if source.powers == wanted.powers and not source.zero:
        return f'is too large for a number in {unit}', remedy
    what = _KINDS.get(source.powers, f'number in {match[2]}')
    return f'must be {_a(kind)} [{unit}], not {_a(what)}', remedy


def measure(value: float | str, unit: str) -> float:
    """Return a number in a unit, given as a number, or as text with or without a unit.

    Raises:
        ValueError: other text, or a unit of another kind, with the remedy.
    """
    try:
        return float(value)
    except ValueError:
        number = in_unit(value, unit)
    if isinstance(number, float):
        return number
    in_brackets = f' [{unit}]' if unit else ''
    problem, remedy = misfit(str(value), unit) or (f'must be a number{in_brackets}', '')
    raise ValueError(f'{problem}. {remedy}'.rstrip('. '))


def quantity(value: float | str, unit: str, *named: str | Argument) -> float:
    """Return `measure`, or raise UsageError with the name of the argument."""
    try:
        return measure(value, unit)
    except ValueError as error:
        raise UsageError(*named, f': {error}') from None


# units named in messages and in the reference
_COMMON = (
    *('mm', 'cm', 'm', 'km', 'in', 'ft', 'fathom', 'nmi', 'paris_line', 'paris_inch'),
    *('paris_foot', 'scruple', 'rhenish_foot', 'g', 'kg', 'lb', 'oz', 'paris_pound', 'ms', 's'),
    *('min', 'h', 'd', 'week', 'rad', 'mrad', 'deg', 'arcmin', 'arcsec', 'turn', 'degC', 'degF'),
    *('K', 'm/s', 'km/h', 'kn', 'm/s2', 'mHz', 'Hz', 'mN', 'N', 'mJ', 'J', 'N m', 'kg m2'),
    *('g cm2', 'N/m', 'N/mm', 'kg/m3', 'g/cm3', 'm/rad', 'mm/deg', 'rad/m', 'rad/s', 'deg/s'),
    *('s/d', 'min/week'),
)


def fitting(wanted: Unit | None) -> list[str]:
    """Return the common units of the same kind."""
    units = ((name, unit_of(name)) for name in _COMMON)
    return [name for name, unit in units if unit and wanted and unit.powers == wanted.powers]


def units_table() -> str:
    """Return the common units by kind as a Markdown table."""
    kinds = (fitting(unit) for unit in map(unit_of, _COMMON))
    rows = dict.fromkeys(', '.join(f'`{name}`' for name in names) for names in kinds)
    return '\n'.join(['| units |', '|---|', *(f'| {row} |' for row in rows)])


def _a(noun: str) -> str:
    return f'{"an" if noun[0] in "aeiou" else "a"} {noun}'
