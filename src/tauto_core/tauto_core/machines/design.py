"""Euler's rules for designing a regulator, in both directions (1727, XIX–XXI, XXIX).

A regulator with a linear lever arm b·ϑ swings like a simple pendulum of length L = I g/(P b), so
I ω² = P b: three of period, moment of inertia, pull and lever rate determine the fourth.

The historical units are rounded; `scene/units.py` has their sources.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from tauto_core.curves.drawing import MM_PER_M, too_small
from tauto_core.scene.errors import Argument, UsageError
from tauto_core.scene.refuse import LARGEST_SIZE, LEAST_SIZE
from tauto_core.scene.units import fitting, in_unit, measure, unit_of

_OLD = {'line': 'paris_line', 'pound': 'paris_pound'}
"""Units by the names that Sully and Euler give them."""


@dataclass(frozen=True)
class Design:
    """A regulator with a linear lever arm b·ϑ under a pull P without inertia, in SI units."""

    period: float
    inertia: float
    pull: float
    lever_rate: float

    def pendulum_length(self, gravity: float) -> float:
        """Return L of the isochronous simple pendulum [m]."""
        return equivalent_pendulum_length(self.inertia, self.pull, self.lever_rate, gravity)


def complete(
    *,
    period: float | None = None,
    inertia: float | None = None,
    pull: float | None = None,
    lever_rate: float | None = None,
) -> Design:
    """Return the design that three of its four numbers determine: I (2π/T)² = P b, in SI units.

    UsageError: not exactly one is left out, or one is not between 1e-30 and 1e30.
    """
    given = {'period': period, 'inertia': inertia, 'pull': pull, 'lever_rate': lever_rate}
    missing = [name for name, value in given.items() if value is None]
    if len(missing) != 1:
        raise UsageError(
            'a design has four numbers, period, inertia, pull and base radius, of which three '
            f'give the fourth; left out: {", ".join(_WORDS[each] for each in missing) or "none"}. '
            'Leave out exactly one, as in ',
            Argument('period', 1),
            ' ',
            Argument('pull', 3),
            ' ',
            Argument('base_radius', 0.005),
        )
    for name, value in given.items():
        if value is not None:
            _check_size(value, f'{_WORDS[name]} = {value!r}')
    if period is None:
        period = math.tau * math.sqrt((inertia or 0.0) / ((pull or 0.0) * (lever_rate or 0.0)))
    stiffness = (math.tau / period) ** 2
    if inertia is None:
        inertia = (pull or 0.0) * (lever_rate or 0.0) / stiffness
    if pull is None:
        pull = inertia * stiffness / (lever_rate or 0.0)
    if lever_rate is None:
        lever_rate = inertia * stiffness / pull
    return Design(period, inertia, pull, lever_rate)


# The four numbers as messages name them.
_WORDS = {'period': 'period', 'inertia': 'inertia', 'pull': 'pull', 'lever_rate': 'base radius'}


def _check_size(value: float, named: str | Argument) -> None:
    """Refuse a quantity outside the limits of a design, in any unit."""
    if not LEAST_SIZE <= value <= LARGEST_SIZE:
        raise UsageError(
            named, f': must be > 0, from {LEAST_SIZE:g} to {LARGEST_SIZE:g}. Give another'
        )


@dataclass(frozen=True)
class WheelDesign:
    """A wheel and its cam, with the disc that the wheel is made of if it is one.

    Attributes:
        period_s: period of a full swing [s].
        pendulum_m: length of the simple pendulum that swings with it [m].
        inertia_kg_m2: moment of inertia of the wheel [kg m2].
        disc_weight_n: weight of the disc [N]; None where the wheel is not said to be a disc.
        disc_radius_m: radius of the disc [m]; likewise.
        pull_n: pull in the thread [N], without inertia.
        base_radius_m: base radius of the involute, a hole's rate [m].
        gravity_m_s2: acceleration of gravity [m/s2].
        too_small: the holes of its plate that no tool makes, and the cure; see
            `curves.drawing.too_small`.
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


def units(length_unit: str, weight_unit: str, gravity: float) -> tuple[float, float]:
    """Return the units of a design in metres and newtons; UsageError for one that is not known."""

    def size(argument: str, given: str, *asked: str) -> tuple[float, str]:
        for unit in asked:
            found = in_unit(f'1 {_OLD.get(given, given)}', unit)
            if isinstance(found, float):
                return found, unit
        fit = ', '.join(name for unit in asked for name in fitting(unit_of(unit)))
        raise UsageError(Argument(argument, repr(given), spaced=True), f': use one of {fit}')

    metres, (weight, of) = (
        size('length_unit', length_unit, 'm')[0],
        size('weight_unit', weight_unit, 'N', 'kg'),
    )
    return metres, weight * (gravity if of == 'kg' else 1.0)


def wheel_design(
    sizes: Mapping[str, float | str | None],
    *,
    disc_is_base: bool,
    length_unit: str,
    weight_unit: str,
    gravity: float,
    tool_mm: float,
) -> WheelDesign:
    """Return the design of which three sizes are given; see `tauto.design`.

    A text has a unit, as `5 mm`; that of a weight may be one of mass.

    Args:
        sizes: period, pendulum, inertia, disc_weight, disc_radius, pull and base_radius; None:
            not given.
        disc_is_base: the radius of the disc is the base radius (XX).
        length_unit: unit of lengths.
        weight_unit: unit of weights and the pull, of force or of mass.
        gravity: acceleration of gravity [m/s2].
        tool_mm: diameter of the smallest tool [mm].

    Raises:
        UsageError: not exactly one is left out, one is given twice, a number is not between 1e-30
            and 1e30, or a unit is not known.
    """
    _check_size(gravity, Argument('gravity', repr(gravity), spaced=True))
    metres, newtons = units(length_unit, weight_unit, gravity)
    units_of = {
        'period': ('s', 1.0),
        'pendulum': ('m', metres),
        'inertia': ('kg m2', 1.0),
        'disc_weight': ('N', newtons),
        'disc_radius': ('m', metres),
        'pull': ('N', newtons),
        'base_radius': ('m', metres),
    }
    known: dict[str, float | None] = dict.fromkeys(units_of)
    for name, (unit, size) in units_of.items():
        value = sizes[name]
        if value is not None:
            number, scale = _number(name, value, unit, size, gravity)
            _check_size(number, Argument(name, repr(number), spaced=True))
            known[name] = number * scale
    for name, other in (
        ('period', 'pendulum'),
        ('inertia', 'disc_weight'),
        ('inertia', 'disc_radius'),
    ):
        if known[name] is not None and known[other] is not None:
            raise UsageError(
                Argument(name),
                ' and ',
                Argument(other),
                ' say the same thing twice. Leave one out',
            )
    length, moment = known['pendulum'], known['inertia']
    time = known['period'] if length is None else 2.0 * half_period(length, gravity)
    weight, radius = known['disc_weight'], known['disc_radius']
    force, base = known['pull'], known['base_radius']
    if disc_is_base:
        if radius is not None or moment is not None:
            raise UsageError(
                Argument('disc_is_base', value=True),
                ' makes the radius of the disc the base radius. Leave out ',
                Argument('disc_radius'),
                ' and ',
                Argument('inertia'),
            )
        weight, force, base = _disc_is_base(time, weight, force, base, gravity)
        time, radius = None, base
    if weight is not None and radius is not None:
        moment = disc_inertia(weight, radius, gravity)
    found = complete(period=time, inertia=moment, pull=force, lever_rate=base)
    if weight is not None:
        # a radius that was given or found before stays as it is, to the last bit
        radius = radius or radius_of_disc(found.inertia, weight, gravity)
    elif radius is not None:
        weight = weight_of_disc(found.inertia, radius, gravity)
    return WheelDesign(
        found.period,
        found.pendulum_length(gravity),
        found.inertia,
        weight,
        radius,
        found.pull,
        found.lever_rate,
        gravity,
        too_small(MM_PER_M * found.lever_rate, found.pull, gravity, tool_mm),
    )


def _number(
    name: str, value: float | str, unit: str, size: float, gravity: float
) -> tuple[float, float]:
    """Return a number and its unit in SI units: `size`, where the value has no unit in words."""
    try:
        return float(value), size
    except ValueError:
        pass
    # a weight may be given by its mass, such as `50 g`
    mass = in_unit(value, 'kg')
    if unit == 'N' and isinstance(mass, float):
        return mass, gravity
    try:
        return measure(value, unit), 1.0
    except ValueError as error:
        masses = f', {", ".join(fitting(unit_of("kg")))}' if unit == 'N' else ''
        raise UsageError(Argument(name, repr(value), spaced=True), f': {error}{masses}') from None


def _disc_is_base(
    period: float | None,
    weight: float | None,
    pull: float | None,
    base: float | None,
    gravity: float,
) -> tuple[float, float, float]:
    """Return Q, P and r of L = Q r/(2P), where one of L, Q, P, r was left out."""
    length = None if period is None else length_of_period(period, gravity)
    match length, weight, pull, base:
        case None, float(), float(), float():
            return weight, pull, base
        case float(), None, float(), float():
            return 2.0 * pull * length / base, pull, base
        case float(), float(), None, float():
            return weight, weight * base / (2.0 * length), base
        case float(), float(), float(), None:
            return weight, pull, base_radius_of_disc(weight, pull, length)
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


def disc_inertia(weight: float, radius: float, gravity: float) -> float:
    """Return I = Q a²/(2g) of a homogeneous disc of the weight Q [kg m2]."""
    return weight * radius * radius / (2.0 * gravity)


def weight_of_disc(inertia: float, radius: float, gravity: float) -> float:
    """Return Q = 2 g I/a² of a homogeneous disc [N]."""
    return 2.0 * gravity * inertia / (radius * radius)


def radius_of_disc(inertia: float, weight: float, gravity: float) -> float:
    """Return a = √(2 g I/Q) of a homogeneous disc of the weight Q [m]."""
    return math.sqrt(2.0 * gravity * inertia / weight)


def equivalent_pendulum_length(
    inertia: float, pull: float, lever_rate: float, gravity: float
) -> float:
    """Return L = I g/(P b) of the isochronous simple pendulum [m].

    For a disc of weight Q and radius a, and an involute of base radius r = b, it is Q a²/(2 P r)
    (§XXI), and Q r/(2P) where the base circle is the disc (§XIX).
    """
    return inertia * gravity / (pull * lever_rate)


def base_radius_of_disc(weight: float, pull: float, length: float) -> float:
    """Return r = 2 P L/Q [m], where the base circle is the disc itself, of weight Q (§XX)."""
    return 2.0 * pull * length / weight


def length_of_period(period: float, gravity: float) -> float:
    """Return L = g (T/2π)² [m] of the simple pendulum with the full period T."""
    return gravity * (period / math.tau) ** 2


def half_period(length: float, gravity: float) -> float:
    """Return π √(L/g) [s]: one oscillation in the papers' sense, half a period."""
    return math.pi * math.sqrt(length / gravity)
