"""Roll and heave as sums of given harmonics."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field

from tauto_core.scene.errors import Problem
from tauto_core.scene.sections import NonNegative, Number, Positive, Section
from tauto_core.ship.motion_kind import Channels, ShipKind, Surroundings, sampled
from tauto_core.ship.waves import Harmonics


class Component(Section):
    """One harmonic: amplitude · cos(2π t/period + phase), t from the start of the scene."""

    amplitude: NonNegative = Field(description='amplitude, of roll [rad], of heave [m]')
    period: Positive = Field(description='period [s]')
    phase: Number = Field(default=0.0, description='phase at the start [rad]')


class ComponentsShip(ShipKind):
    """Roll, and heave where given, as sums of harmonics."""

    rank = 2
    starter = {
        'components': [
            {'amplitude': 0.08, 'period': 11.0, 'phase': 0.3},
            {'amplitude': 0.03, 'period': 8.1, 'phase': 1.9},
        ],
        'heave': [{'amplitude': 0.5, 'period': 9.0, 'phase': 0.0}],
    }

    kind: Literal['components'] = 'components'
    components: tuple[Component, ...] = Field(
        default=(), description='list of {amplitude [rad], period [s], phase [rad]} of the roll'
    )
    heave: Annotated[tuple[Component, ...], Field(min_length=1)] | None = Field(
        default=None, description='list of {amplitude [m], period [s], phase [rad]} of the heave'
    )

    @property
    def shortest_wave_s(self) -> float:
        """Shortest period given [s]; inf where there is none."""
        waves = (*self.components, *(self.heave or ()))
        return min((wave.period for wave in waves), default=math.inf)

    def channels(self, scene: Surroundings) -> Channels:
        """Return the harmonics."""
        del scene
        heave = None if self.heave is None else _harmonics(self.heave)
        metadata = {'components': len(self.components), 'heave': self.heave is not None}
        return Channels(_harmonics(self.components), heave, metadata=metadata)

    def with_roll_scaled(self, factor: float) -> Self:
        """Return the ship with all amplitudes of the roll times a factor."""
        scaled = tuple(
            each.model_copy(update={'amplitude': factor * each.amplitude})
            for each in self.components
        )
        return self.model_copy(update={'components': scaled})

    def problems(self) -> Iterator[Problem]:
        """Yield the contradictions between its keys."""
        if not self.components and self.heave is None:
            yield Problem(
                'ship.components',
                list(self.components),
                'has no component, and there is no heave: nothing moves',
                'Give at least one {amplitude, period, phase}, or use kind still.',
            )
        for name, components in (('components', self.components), ('heave', self.heave or ())):
            for index, component in enumerate(components):
                yield from sampled(f'ship.{name}[{index}].period', component.period, self.rate)
        total = math.fsum(component.amplitude for component in self.components)
        if total >= math.pi / 2:
            yield Problem(
                'ship.components',
                total,
                'is the sum of the amplitudes [rad], which must be less than π/2: the ship '
                'capsizes',
                'Give amplitudes in radians, not degrees.',
            )

    @property
    def motions(self) -> tuple[str, ...]:
        """Roll and heave, where they are given."""
        return ('roll',) * bool(self.components) + ('heave',) * bool(self.heave)


def _harmonics(components: tuple[Component, ...]) -> Harmonics:
    return Harmonics(
        np.array([c.amplitude for c in components]),
        np.array([c.period for c in components]),
        np.array([c.phase for c in components]),
    )


KIND = ComponentsShip
