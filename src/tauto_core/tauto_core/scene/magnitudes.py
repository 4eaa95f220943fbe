"""Limits within which double precision can compute a machine and the motion of a ship."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tauto_core.scene.errors import Problem

# Squares of ratios of three such numbers neither overflow nor underflow.
LEAST_SIZE, LARGEST_SIZE = 1e-30, 1e30
# 150,000 turns of thread; beyond, the rounding of an angle shows in the clock.
LARGEST_ANGLE = 1e6

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
        if key == 'trochlea.release_angle' and size > LARGEST_ANGLE:
            yield Problem(
                key,
                value,
                f'must be at most {LARGEST_ANGLE:g} rad in size: nobody winds a thread so far',
                f'Release the wheel at {LARGEST_ANGLE:g} rad or nearer to rest.',
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


def _numbers(path: str, content: object) -> Iterator[tuple[str, float]]:
    if isinstance(content, Mapping):
        for name, value in content.items():
            yield from _numbers(f'{path}.{name}' if path else name, value)
    elif isinstance(content, tuple):
        for index, value in enumerate(content):
            yield from _numbers(f'{path}[{index}]', value)
    elif isinstance(content, float):
        yield path, content
