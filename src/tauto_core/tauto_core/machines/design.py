"""Euler's rules for designing a regulator, in both directions (1727, XIX–XXI, XXIX).

A regulator with a linear lever arm b·ϑ swings like a simple pendulum of length L = I g/(P b), or
I ω² = P b: three of period, moment of inertia, pull and lever rate determine the fourth. A uniform
disc of the weight Q and the radius a has I = Q a²/(2g) (XXI). As base circle it has Q b = 2 P L
(XIX, XX).

The historical units are rounded, with sources in `scene/units.py`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from tauto_core.curves.drawing import MM_PER_M, too_small
from tauto_core.scene.errors import Argument, UsageError
from tauto_core.scene.refuse import LARGEST_SIZE, LEAST_SIZE
from tauto_core.scene.units import fitting, in_unit, measure, unit_of


def _check_size(value: float, named: str | Argument) -> None:
    """Refuse a quantity outside the limits of a design, in any unit."""
    if not LEAST_SIZE <= value <= LARGEST_SIZE:
        raise UsageError(
            named, f': must be > 0, from {LEAST_SIZE:g} to {LARGEST_SIZE:g}. Check its unit'
        )


@dataclass(frozen=True)
class WheelDesign:
    """A wheel and its cam, with the wheel's disc if it is one.

    Attributes:
        period_s: period of a full swing [s].
        pendulum_m: length of the simple pendulum that swings with it [m].
        inertia_kg_m2: moment of inertia of the wheel [kg m2].
        disc_weight_n: weight of the disc [N], if the wheel is one.
        disc_radius_m: radius of the disc [m], if any.
        pull_n: pull in the thread [N], without inertia.
        base_radius_m: base radius of the involute, a hole's rate [m].
        gravity_m_s2: acceleration of gravity [m/s2].
        too_small: warning about holes of its plate (`curves.drawing.too_small`).
    """

    period_s: float
    pendulum_m: float
    inertia_kg_m2: float
    disc_weight_n: float | None
    disc_radius_m: float | None
    pull_n: float
    base_radius_m: float
    gravity_m_s2: float
    too_small: str = ''


def wheel_design(
    sizes: Mapping[str, float | str | None],
    *,
    disc_is_base: bool,
    gravity: float,
    tool_mm: float,
) -> WheelDesign:
    """Return the design with three given sizes (`tauto.design`).

    Args:
        sizes: period, pendulum, inertia, disc_weight, disc_radius, pull and base_radius, see
            `size_in_si`.
        disc_is_base: whether the radius of the disc is the base radius (XX).
        gravity: acceleration of gravity [m/s2].
        tool_mm: diameter of the smallest tool [mm].

    Raises:
        UsageError: not exactly one size is missing, one is given twice, a number is not between
            1e-30 and 1e30, or an unknown unit.
    """
    _check_size(gravity, Argument('gravity', repr(gravity), spaced=True))
    units = {'period': 's', 'inertia': 'kg m2', 'disc_weight': 'N', 'pull': 'N'}
    si: dict[str, float | None] = dict.fromkeys(sizes)
    for name, value in sizes.items():
        if value is not None:
            si[name] = size = size_in_si(name, value, units.get(name, 'm'), gravity)
            _check_size(size, Argument(name, repr(size), spaced=True))
    for name, twin in (
        ('period', 'pendulum'),
        ('inertia', 'disc_weight'),
        ('inertia', 'disc_radius'),
    ):
        if si[name] is not None and si[twin] is not None:
            raise UsageError(
                Argument(name), ' and ', Argument(twin), ' say the same thing twice. Leave one out'
            )
    period, length, moment, weight, radius, force, base = si.values()
    square = (math.tau / period) ** 2 if period else gravity / length if length else None
    if disc_is_base:
        if radius is not None or moment is not None:
            raise UsageError(
                Argument('disc_is_base', value=True),
                ' makes the radius of the disc the base radius. Leave out ',
                Argument('disc_radius'),
                ' and ',
                Argument('inertia'),
            )
        four = _four(weight, base, force and 2.0 * force, square and gravity / square)
        if not four:
            raise UsageError(
                'with ',
                Argument('disc_is_base', value=True),
                ' three of ',
                Argument('period'),
                ' (or ',
                Argument('pendulum'),
                '), ',
                Argument('disc_weight'),
                ', ',
                Argument('pull'),
                ' and ',
                Argument('base_radius'),
                ' give the fourth. Leave out exactly one',
            )
        weight, base, double, length = four
        force, square, radius = 0.5 * double, gravity / length, base
        moment = weight * radius * radius / (2.0 * gravity)
    else:
        if weight is not None and radius is not None:
            moment = weight * radius * radius / (2.0 * gravity)
            _check_size(moment, f'inertia = {moment!r}')
        named = {'period': square, 'inertia': moment, 'pull': force, 'base radius': base}
        missing = [name for name, value in named.items() if value is None]
        four = _four(moment, square, force, base)
        if not four:
            raise UsageError(
                'a design has four numbers, period, inertia, pull and base radius, of which three '
                f'give the fourth. Left out: {", ".join(missing) or "none"}. '
                'Leave out exactly one, as in ',
                Argument('period', 1),
                ' ',
                Argument('pull', 3),
                ' ',
                Argument('base_radius', 0.005),
            )
        moment, square, force, base = four
    if weight is not None:
        # keep a given or computed radius to the last bit
        radius = radius or math.sqrt(2.0 * gravity * moment / weight)
    elif radius is not None:
        weight = 2.0 * gravity * moment / (radius * radius)
    return WheelDesign(
        period or math.tau / math.sqrt(square),
        gravity / square,
        moment,
        weight,
        radius,
        force,
        base,
        gravity,
        too_small(MM_PER_M * base, force, gravity, tool_mm),
    )


def _four(*terms: float | None) -> list[float]:
    """Return all four of a b = c d if exactly one is None, else an empty list."""
    if terms.count(None) != 1:
        return []
    at = terms.index(None)
    partner, *across = (terms[k] or 0.0 for k in (at ^ 1, *((2, 3) if at < 2 else (0, 1))))
    return [math.prod(across) / partner if term is None else term for term in terms]


def size_in_si(name: str, value: float | str, unit: str, gravity: float) -> float:
    """Return a size in an SI unit. A text has its unit, such as `5 mm`; a weight also `50 g`."""
    mass = in_unit(value, 'kg') if unit == 'N' and isinstance(value, str) else None
    if isinstance(mass, float):
        return mass * gravity
    try:
        return measure(value, unit)
    except ValueError as error:
        masses = f', {", ".join(fitting(unit_of("kg")))}' if unit == 'N' else ''
        raise UsageError(Argument(name, repr(value), spaced=True), f': {error}{masses}') from None
