"""A force without mass that depends on the lift as a table says.

Euler names condensed or rarefied air and a stretched chord among the powers (1727, V). Air that is
drawn thin behind a piston of area A in a cylinder pulls with A (p₀ − p₁V₁/(V₁ + A h)); air that is
pressed together with A (p₁V₁/(V₁ − A h) − p₀), by Boyle's law. A chord between two pins, drawn
aside at its middle, pulls with 2 (T + κΔl) sin of its slope.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field

from tauto_core.curves.cam import Pull
from tauto_core.curves.force_law import LEAST_POINTS, ForceLaw, as_law
from tauto_core.machines.parts import PowerKind
from tauto_core.scene.errors import Problem
from tauto_core.scene.sections import NonNegative, Number

KEY = 'trochlea.power.points'


class ForceTablePower(PowerKind):
    """Force without inertia through points of lift and force (Euler 1727, V): air, a chord."""

    words = 'a force given by points'
    rank = 5
    starter = {
        'points': [
            [0.0, 3.2],
            [0.004, 3.9],
            [0.008, 4.68],
            [0.012, 5.55],
            [0.016, 6.53],
            [0.02, 7.64],
        ]
    }

    kind: Literal['force_table'] = 'force_table'
    points: Annotated[
        tuple[tuple[NonNegative, Number], ...], Field(min_length=LEAST_POINTS, max_length=200)
    ] = Field(
        description='pairs of lift, the length of thread drawn from rest [m], and force [N], 6 to '
        '200; lifts increase from 0, forces are > 0; a quintic spline goes through them'
    )

    @cached_property
    def law(self) -> ForceLaw:
        """The force as a function of the lift."""
        return as_law(self.points)

    @property
    def pull(self) -> Pull:
        """The force at rest, and its law."""
        return Pull(force=self.points[0][1], law=self.law)

    @property
    def acts_as(self) -> str:
        """`force_table`, also where the force is constant."""
        return 'force_table'

    def problems(self) -> Iterator[Problem]:
        """Yield lifts that do not increase from 0, and forces that do not pull."""
        first = self.points[0][0]
        if first != 0.0:
            yield Problem(
                f'{KEY}[0]',
                first,
                'is not the lift at rest, 0 m',
                'Begin with the force at rest: [0.0, force].',
            )
            return
        for at, ((before, _), (lift, _)) in enumerate(pairwise(self.points), 1):
            if not lift > before:
                yield Problem(
                    f'{KEY}[{at}]',
                    lift,
                    f'is not above the lift before it, {before!r} m',
                    'Sort the points by lift, and remove duplicates.',
                )
                return
        for at, (lift, force) in enumerate(self.points):
            if not force > 0.0:
                yield Problem(
                    f'{KEY}[{at}]',
                    force,
                    f'is the force at {lift!r} m, which must be above 0 N to keep the thread taut',
                    'End the points before the force vanishes.',
                )
                return
        lift, force = self.law.least
        if not force > 0.0:
            yield Problem(
                KEY,
                force,
                f'is the force of the spline through the points at {lift:.6g} m, between two of '
                'them; it must be above 0 N',
                'Give more points near there.',
            )


KIND = ForceTablePower
