"""The built-in powers. A module of this folder adds a further kind.

They are a constant pull without inertia, as Euler assumes (1727, X), a hanging weight (1727, XX),
a spring without inertia, weight and spring on one thread, and a force without mass as a table of
the lift.

Euler also names condensed or rarefied air and a stretched chord (1727, V). By Boyle's law air
rarefied behind a piston of area A pulls with A (p₀ − p₁V₁/(V₁ + A h)), compressed air with
A (p₁V₁/(V₁ − A h) − p₀). A chord between two pins, drawn aside at its middle, pulls with 2 (T +
κΔl) sin of its slope.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field

from tauto_core.curves.cam import LEAST_POINTS, ForceLaw, Pull
from tauto_core.curves.materials import NamedMaterial
from tauto_core.machines.parts import PowerKind
from tauto_core.scene.errors import Problem
from tauto_core.scene.sections import Flag, NonNegative, Number, Positive

OF_SPRING = Field(
    default=None,
    description='material of the spring, a name or mapping: expansion, modulus. When left out its '
    'force does not change with temperature',
)


class ForcePower(PowerKind):
    """Constant pull without inertia."""

    words = 'a pull without inertia or stiffness'
    rank = 1
    starter = {'force': 3.158}

    kind: Literal['force'] = 'force'
    force: Positive = Field(description='pull in the thread [N]')
    material: NamedMaterial | None = OF_SPRING

    @property
    def pull(self) -> Pull:
        """The constant force."""
        return Pull(force=self.force)


class WeightPower(PowerKind):
    """Hanging weight. `massless` keeps its pull and neglects its inertia."""

    words = 'a weight whose inertia counts'
    rank = 2
    starter = {'mass': 0.322}

    kind: Literal['weight'] = 'weight'
    mass: Positive = Field(description='mass of the weight [kg]')
    massless: Flag = Field(
        default=False, description='true: the inertia of the weight is neglected'
    )

    @property
    def pull(self) -> Pull:
        """The weight, and its inertia unless that is neglected."""
        return Pull(carried_mass=0.0 if self.massless else self.mass, pulling_mass=self.mass)


class SpringPower(PowerKind):
    """Spring without inertia: pull = force + stiffness · draw, the length of thread drawn."""

    words = 'a spring'
    rank = 3
    starter = {'force': 3.158, 'stiffness': 50.0}

    kind: Literal['spring'] = 'spring'
    force: Positive = Field(description='pull at zero draw [N]')
    stiffness: NonNegative = Field(description='stiffness [N/m]')
    material: NamedMaterial | None = OF_SPRING

    @property
    def pull(self) -> Pull:
        """The force at zero draw, and the stiffness."""
        return Pull(force=self.force, stiffness=self.stiffness)

    @property
    def acts_as(self) -> str:
        """`spring`, also without stiffness."""
        return 'spring'


class WeightAndSpringPower(PowerKind):
    """Hanging weight, and a spring on the same thread: pull = mass · g + stiffness · draw."""

    words = 'a weight and a spring together'
    rank = 4
    starter = {'mass': 0.322, 'stiffness': 50.0}

    kind: Literal['weight_and_spring'] = 'weight_and_spring'
    mass: Positive = Field(description='mass of the weight [kg]')
    stiffness: Positive = Field(
        description='stiffness of the spring, which is slack at rest [N/m]'
    )
    material: NamedMaterial | None = OF_SPRING

    @property
    def pull(self) -> Pull:
        """The weight with its inertia, and the stiffness."""
        return Pull(carried_mass=self.mass, pulling_mass=self.mass, stiffness=self.stiffness)

    @property
    def acts_as(self) -> str:
        """Both. No closed form corrects them together."""
        return 'weight_and_spring'


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
        '200, with lifts that increase from 0 and forces > 0, joined by a quintic spline'
    )

    @cached_property
    def law(self) -> ForceLaw:
        """The force as a function of the lift."""
        return ForceLaw(self.points)

    @property
    def pull(self) -> Pull:
        """The force at rest, and its law."""
        return Pull(force=self.points[0][1], law=self.law)

    @property
    def acts_as(self) -> str:
        """`force_table`, even if the force is constant."""
        return 'force_table'

    def problems(self) -> Iterator[Problem]:
        """Yield lifts that do not increase from 0, and forces that do not pull."""
        start = self.points[0][0]
        if start != 0.0:
            yield Problem(
                'trochlea.power.points[0]',
                start,
                'is not the lift at rest, 0 m',
                'Begin with the force at rest: [0.0, force].',
            )
            return
        for at, ((lower, _), (lift, _)) in enumerate(pairwise(self.points), 1):
            if not lift > lower:
                yield Problem(
                    f'trochlea.power.points[{at}]',
                    lift,
                    f'is not above the lift before it, {lower!r} m',
                    'Sort the points by lift, and remove duplicates.',
                )
                return
        for at, (lift, force) in enumerate(self.points):
            if not force > 0.0:
                yield Problem(
                    f'trochlea.power.points[{at}]',
                    force,
                    f'is the force at {lift!r} m, which must be above 0 N to keep the thread taut',
                    'End the points before the force vanishes.',
                )
                return
        lift, force = self.law.least
        if not force > 0.0:
            yield Problem(
                'trochlea.power.points',
                force,
                f'is the force of the spline through the points at {lift:.6g} m, between two of '
                'them, and must be above 0 N',
                'Give more points near there.',
            )


KINDS = ForcePower, WeightPower, SpringPower, WeightAndSpringPower, ForceTablePower
