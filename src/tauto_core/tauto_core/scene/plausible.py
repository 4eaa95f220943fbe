"""Warnings for numbers that are possible but probably in the wrong unit; the worst are refused.

The bounds are about an order of magnitude outside the shipped scenes, the machines of Sully,
Harrison and Euler, watches (a balance of 1e-9 kg m2 that swings by 5 rad) and tower clocks.
Machine, gravity and ship beyond the largest of them are not sailed unless that is asked for: what
they do was never tried, and may take minutes. Smaller ones are safe, and so are a passage, a log
or observations of any size: these are warned of. Numbers that double precision cannot compute
with are refused elsewhere (`magnitudes`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from tauto_core.scene.errors import Problem
from tauto_core.wording import span

if TYPE_CHECKING:
    from tauto_core.scene.models import Scene

DAY_S = 86_400.0
_LENGTH = (('millimetres', 1e-3), ('centimetres', 1e-2), ('inches', 0.0254), ('feet', 0.3048))
_MASS = (('grams', 1e-3), ('pounds', 0.45359237))
_TIME = (('milliseconds', 1e-3), ('minutes', 60.0), ('hours', 3600.0), ('days', DAY_S))
_ANGLE = (('degrees', math.pi / 180.0),)
_INERTIA = (('kg cm2', 1e-4), ('kg mm2', 1e-6), ('g cm2', 1e-7))
_FORCE = (('millinewtons', 1e-3), ('grams-force', 9.80665e-3))
_RATE = (('samples a minute', 1.0 / 60.0),)


class _Sizes(NamedTuple):
    """The range of a key in existing machines and voyages; 0 is always allowed."""

    key: str
    least: float
    most: float
    unit: str
    slips: tuple[tuple[str, float], ...]


_SIZES = tuple(
    _Sizes(re.escape(key).replace(r'\*', r'[^.]*'), least, most, unit, slips)
    for key, least, most, unit, slips in (
        ('duration', 10.0, 400.0 * DAY_S, 's', _TIME),
        ('gravity', 1.0, 30.0, 'm/s2', (('cm/s2', 1e-2), ('feet/s2', 0.3048))),
        ('trochlea.inertia', 1e-10, 1.0, 'kg m2', _INERTIA),
        ('trochlea.cam.base_radius', 1e-4, 0.5, 'm', _LENGTH),
        ('trochlea.cam.lever_rate', 1e-4, 0.5, 'm/rad', _LENGTH),
        ('trochlea.cam.radius', 2e-4, 1.0, 'm', _LENGTH),
        ('trochlea.cam.root_depth', 1e-4, 0.5, 'm', _LENGTH),
        ('trochlea.cam.period', 0.05, 20.0, 's', _TIME),
        ('trochlea.thread.distance', 2e-3, 5.0, 'm', _LENGTH),
        ('trochlea.thread.arm', 2e-3, 5.0, 'm', _LENGTH),
        ('trochlea.thread.weight_arm', 2e-3, 5.0, 'm', _LENGTH),
        ('trochlea.thread.length', 5e-3, 20.0, 'm', _LENGTH),
        ('trochlea.thread.inertia', 0.0, 10.0, 'kg m2', _INERTIA),
        ('trochlea.power.mass', 1e-4, 50.0, 'kg', _MASS),
        ('trochlea.power.force', 1e-4, 500.0, 'N', _FORCE),
        ('trochlea.power.stiffness', 0.0, 1e4, 'N/m', (('mN/m', 1e-3),)),
        ('trochlea.release_angle', 0.0, 2.0 * math.pi, 'rad', _ANGLE),
        ('regulator.diameter', 1e-3, 2.0, 'm', _LENGTH),
        ('regulator.body_density', 100.0, 23_000.0, 'kg/m3', (('g/cm3', 1e3),)),
        ('regulator.fluid_density', 0.1, 14_000.0, 'kg/m3', (('g/cm3', 1e3),)),
        ('regulator.pendulum_length', 1e-3, 100.0, 'm', _LENGTH),
        ('regulator.release_arc', 0.0, 100.0, 'm', _LENGTH),
        ('escapement.energy', 1e-11, 0.1, 'J', (('millijoules', 1e-3), ('microjoules', 1e-6))),
        ('escapement.angle', 0.0, math.pi, 'rad', _ANGLE),
        ('ship.rate', 0.5, 2000.0, 'Hz', _RATE),
        ('ship.height', 0.0, 100.0, 'm', _LENGTH),
        ('ship.components[*].amplitude', 0.0, 1.2, 'rad', _ANGLE),
        ('ship.components[*].period', 0.5, 300.0, 's', _TIME),
        ('ship.heave[*].amplitude', 0.0, 20.0, 'm', _LENGTH),
        ('ship.heave[*].period', 0.5, 300.0, 's', _TIME),
        ('ship.sea.significant_wave_height', 0.01, 25.0, 'm', _LENGTH),
        ('ship.sea.peak_period', 1.0, 40.0, 's', _TIME),
        ('ship.roll.natural_period', 1.0, 60.0, 's', _TIME),
        ('ship.roll.damping_ratio', 1e-3, 1.0, '', (('per cent', 1e-2),)),
        ('ship.roll.slope_coefficient', 0.0, 5.0, '', (('per cent', 1e-2),)),
        ('ship.speed', 0.0, 25.0, 'm/s', (('km/h', 1.0 / 3.6), ('knots', 1852.0 / 3600.0))),
        ('suspension.support_radius', 1e-4, 1.0, 'm', _LENGTH),
        ('suspension.axle_radius', 1e-5, 0.5, 'm', _LENGTH),
        ('suspension.depth', 0.0, 5.0, 'm', _LENGTH),
        ('suspension.gyration_radius', 0.0, 5.0, 'm', _LENGTH),
        ('clock.nominal_period', 0.05, 20.0, 's', _TIME),
        ('voyage.speed', 0.1, 25.0, 'm/s', (('km/h', 1.0 / 3.6), ('knots', 1852.0 / 3600.0))),
        ('drift.observation_sigma', 0.0, 3600.0, 's', _TIME),
        ('log.interval', 1e-3, 7.0 * DAY_S, 's', _TIME),
    )
)


_REFUSED = ('gravity', 'trochlea', 'regulator', 'escapement', 'suspension', 'ship', 'clock')
"""Sections of which no number may be larger than any known."""
_WARNED_OF = 'ship.rate'
"""A key in them that only says how the motion is sampled."""


def beyond_known(scene: Scene) -> list[Problem]:
    """Return the numbers of machine, gravity and ship that are larger than any known."""
    found = []
    for key, value, sizes in _odd(scene):
        larger = abs(value) > sizes.most and key != _WARNED_OF
        if larger and key.partition('.')[0] in _REFUSED:
            said, meant = _comparison(value, sizes), _meant(key, value, sizes)
            found.append(Problem(key, value, said, meant))
    return found


def implausible(scene: Scene) -> list[str]:
    """Return a warning for each number of a scene that is probably in the wrong unit.

    Each names the key, its value, the size it is compared with, and the value in the unit that was
    probably meant.
    """
    return [
        f'{key} = {value:g}: {_comparison(value, sizes)}. {_meant(key, value, sizes)}'
        for key, value, sizes in _odd(scene)
    ]


def _odd(scene: Scene) -> Iterator[tuple[str, float, _Sizes]]:
    """Yield key and value of each number outside the range that is known of it, and that range."""
    for key, value in _numbers('', scene.model_dump(exclude_none=True)):
        sizes = next((each for each in _SIZES if re.fullmatch(each.key, key)), None)
        if sizes is not None and value and not sizes.least <= abs(value) <= sizes.most:
            yield key, value, sizes


def _numbers(path: str, content: object) -> Iterator[tuple[str, float]]:
    if isinstance(content, dict):
        for name, value in content.items():
            yield from _numbers(f'{path}.{name}' if path else str(name), value)
    elif isinstance(content, list | tuple):
        for place, value in enumerate(content):
            yield from _numbers(f'{path}[{place}]', value)
    elif isinstance(content, float):
        yield path, content


def _comparison(value: float, sizes: _Sizes) -> str:
    beyond = abs(value) > sizes.most
    limit = sizes.most if beyond else sizes.least
    said = f'{_turns(value, sizes)}{"more" if beyond else "less"} than {_size(limit, sizes.unit)}'
    return f'{said}, the {"most" if beyond else "least"} that any known machine or voyage has'


def _meant(key: str, value: float, sizes: _Sizes) -> str:
    """Return what was probably meant, as a sentence."""
    name = key.rpartition('.')[2]
    meant = [
        f'in {unit}, write {name}: {value * size:.4g}'
        for unit, size in sizes.slips
        if sizes.least <= abs(value * size) <= sizes.most
    ]
    return f'If it is {"; ".join(meant)}.' if meant else f'Its unit is {sizes.unit or 1}.'


def _turns(value: float, sizes: _Sizes) -> str:
    """Return the size in a more familiar unit, as turns or days, if that helps."""
    if sizes.unit == 'rad' and abs(value) > math.tau:
        return f'{abs(value) / math.tau:.2g} turns, '
    if sizes.unit == 's' and abs(value) >= 2.0 * DAY_S:
        return f'{span(abs(value))}, '
    return ''


def _size(limit: float, unit: str) -> str:
    if unit == 's' and limit >= 60.0:
        return span(limit)
    return f'{limit:.3g}{" " if unit else ""}{unit}'
