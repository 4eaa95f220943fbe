"""Limits within which double precision can compute a machine."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tauto_core.scene.errors import Problem

# Squares of ratios of three such numbers neither overflow nor underflow.
LEAST_SIZE, LARGEST_SIZE = 1e-30, 1e30
# 150,000 turns of thread; beyond, the rounding of an angle shows in the clock.
LARGEST_ANGLE = 1e6

SECTIONS = ('gravity', 'trochlea', 'regulator', 'drag', 'escapement', 'suspension')
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


def out_of_proportion(content: Mapping[str, object]) -> Iterator[Problem]:
    """Yield the numbers of the machine, other than 0, that are outside these limits.

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
        elif 0.0 < size < LEAST_SIZE and key not in _MAY_VANISH:
            yield Problem(
                key,
                value,
                f'must be at least {LEAST_SIZE:g} in size, or what follows vanishes',
                'Check its unit.',
            )


def _numbers(path: str, content: object) -> Iterator[tuple[str, float]]:
    if isinstance(content, Mapping):
        for name, value in content.items():
            yield from _numbers(f'{path}.{name}' if path else name, value)
    elif isinstance(content, float):
        yield path, content
