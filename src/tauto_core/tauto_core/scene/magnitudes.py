"""Limits within which double precision can compute a machine and the motion of a ship."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from tauto_core.scene.errors import Problem

# Squares of ratios of three such numbers neither overflow nor underflow.
LEAST_SIZE, LARGEST_SIZE = 1e-30, 1e30
# No fusee has a thread that goes round more than about ten times. A release in degrees is beyond.
LARGEST_TURNS = 10

SECTIONS = ('gravity', 'trochlea', 'regulator', 'drag', 'escapement', 'ship', 'suspension')
# Numbers that are only added to larger ones may be as small as they like.
_MAY_VANISH = frozenset(
    (
        'trochlea.release_angle',
        'trochlea.thread.inertia',
        'trochlea.power.stiffness',
        'regulator.release_arc',
        'regulator.fluid_density',
        'regulator.added_mass',
        'drag.viscous',
        'drag.quadratic',
        'drag.coulomb',
        'escapement.angle',
        'escapement.energy',
        'escapement.rest.friction',
        'escapement.rest.recoil',
    )
)
# Numbers of a ship that may not, by their names: divisors, and what spectra are scaled by.
_OF_SHIPS = frozenset(
    ('rate', 'period', 'frequency', 'natural_period', 'peak_period', 'significant_wave_height')
)


def out_of_proportion(content: Mapping[str, object]) -> Iterator[Problem]:
    """Yield the numbers of machine and ship, other than 0, that are outside these limits.

    Args:
        content: keys and values of the `SECTIONS` of a scene.
    """
    for key, value in _numbers('', content):
        size = abs(value)
        if key == 'trochlea.release_angle' and size > LARGEST_TURNS * math.tau:
            yield Problem(
                key,
                value,
                f'must be at most {LARGEST_TURNS * math.tau:.4g} rad in size, {LARGEST_TURNS} '
                'turns: no thread winds farther',
                'Angles are in radians, 90° = 1.571' + _if_degrees(value),
            )
        elif size > LARGEST_SIZE:
            yield Problem(
                key,
                value,
                f'must be at most {LARGEST_SIZE:g} in size, or what follows overflows',
                'Check its unit.',
            )
        elif 0.0 < size < LEAST_SIZE and not _may_vanish(key):
            yield Problem(
                key,
                value,
                f'must be at least {LEAST_SIZE:g} in size, or what follows vanishes',
                'Check its unit.',
            )


def _may_vanish(key: str) -> bool:
    if key.startswith('ship.'):
        return key.rpartition('.')[2].partition('[')[0] not in _OF_SHIPS
    return key in _MAY_VANISH


def _if_degrees(value: float) -> str:
    """Return the release in radians if degrees were meant, as the end of a sentence."""
    if abs(value) > 360.0:
        return '.'
    return f': if {value:g} is in degrees, write release_angle: {math.radians(value):.4g}.'


def _numbers(path: str, content: object) -> Iterator[tuple[str, float]]:
    if isinstance(content, Mapping):
        for name, value in content.items():
            yield from _numbers(f'{path}.{name}' if path else name, value)
    elif isinstance(content, tuple):
        for index, value in enumerate(content):
            yield from _numbers(f'{path}[{index}]', value)
    elif isinstance(content, float):
        yield path, content
