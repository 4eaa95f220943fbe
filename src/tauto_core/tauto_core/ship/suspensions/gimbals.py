"""The clock's case in gimbals: a pendulum on pivots fixed in the ship (theory/suspension.md)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from numpy.typing import NDArray
from pydantic import Field, Strict

from tauto_core.machines.axle_pendulum import off_resonance
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import Problem
from tauto_core.scene.sections import NonNegative, Number
from tauto_core.ship.sections import SuspensionKind

if TYPE_CHECKING:
    from tauto_core.motion.suspended_case import CaseSwing

LARGEST_FRICTION = 0.5
"""Largest tilt at which friction may hold a case that counts as hung [rad]."""


class GimbalsSuspension(SuspensionKind):
    """The clock's case in gimbals: a pendulum on pivots fixed in the ship (G5 in suspension.md).

    The inner ring turns about the axis of the roll; the outer one keeps that axis level fore and
    aft, without friction.
    """

    rank = 2
    starter: ClassVar[Mapping[str, float]] = {
        'depth': 0.05,
        'gyration_radius': 0.12,
        'damping_ratio': 0.05,
    }

    plane = 'vertical'
    large_angles: ClassVar[bool] = True  # type: ignore[misc]

    kind: Literal['gimbals'] = 'gimbals'
    depth: Number = Field(
        description="depth of the case's centre of gravity, where the clock is, below the pivots "
        '[m]'
    )
    gyration_radius: Number = Field(
        description='radius of gyration of the case about its centre of gravity [m]'
    )
    damping_ratio: NonNegative = Field(
        default=0.0,
        description='damping of its small swings in pivots that rub in proportion to the speed, '
        'over the critical one',
    )
    friction_angle: Annotated[float, Strict(), Field(ge=0.0, le=LARGEST_FRICTION)] = Field(
        default=0.0,
        description='tilt up to which the dry friction of the pivots holds the case on a ship at '
        'rest [rad], at most 0.5',
    )

    @property
    def is_damped(self) -> bool:  # type: ignore[override]
        """Whether its pivots rub."""
        return self.damping_ratio > 0.0 or self.sticks

    @property
    def sticks(self) -> bool:  # type: ignore[override]
        """Whether its pivots rub dry."""
        return self.friction_angle > 0.0

    @property
    def pull(self) -> float:
        """l/(k² + l²), by which gravity and the ship's accelerations turn the case [1/m]."""
        return self.depth / (self.gyration_radius**2 + self.depth**2)

    def frequencies(self, gravity: float) -> tuple[float, ...]:
        """Return ω_c of its small swings."""
        return (math.sqrt(gravity * self.pull),)

    def answer(self, frequency: FloatArray, gravity: float, duration_s: float) -> NDArray[Any]:
        """Return φ/τ of small swings, complex, and at resonance as far as it gets.

        Dry friction is left out, and the roll, against which the pivots rub.
        """
        square = gravity * self.pull
        damped = 2.0 * self.damping_ratio * math.sqrt(square) * frequency
        return square / (off_resonance(square, frequency**2, duration_s) + 1j * damped)

    def swing(self, gravity: float, tolerance: float | None) -> CaseSwing:
        """Return the propagator of the case."""
        from tauto_core.motion.suspended_case import GimbalsSwing

        square = gravity * self.pull
        return GimbalsSwing(
            self.pull,
            gravity,
            damping=2.0 * self.damping_ratio * math.sqrt(square),
            friction=square * math.sin(self.friction_angle),
            tolerance=tolerance,
        )

    def wider(self, frequency: float, gravity: float) -> float:
        """Return the gyration_radius with which its swing has a frequency [rad/s], or inf."""
        square = gravity * self.depth / frequency**2 - self.depth**2
        return math.sqrt(square) if square > 0.0 else math.inf

    def problems(self, *, still: bool) -> Iterator[Problem]:
        """Yield the contradictions between its keys."""
        if self.damping_ratio > 1.0:
            yield Problem(
                'suspension.damping_ratio',
                self.damping_ratio,
                'must be at most 1, above which the case creeps back and goes with the ship',
                'Use for example 0.1; if 10 per cent are meant, write 0.1.',
            )
        yield from super().problems(still=still)


KIND = GimbalsSuspension
