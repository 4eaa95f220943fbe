"""The clock's case hung on a cylindrical axle in a bearing of the ship (theory/suspension.md)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import Field

from tauto_core.machines.axle_pendulum import Modes, answers, modes
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import Problem
from tauto_core.scene.sections import Flag, Number, Positive
from tauto_core.ship.sections import SuspensionKind

if TYPE_CHECKING:
    from tauto_core.motion.suspended_case import CaseSwing


class AxleSuspension(SuspensionKind):
    """The clock's case hung on a cylindrical axle in the ship's bearing (E3 in suspension.md)."""

    rank = 1
    starter: ClassVar[Mapping[str, float]] = {
        'support_radius': 0.02,
        'axle_radius': 0.005,
        'depth': 0.1,
        'gyration_radius': 0.05,
    }

    kind: Literal['axle'] = 'axle'
    support_radius: Positive = Field(description='radius of the hollow bearing [m]')
    axle_radius: Positive = Field(description='radius of the axle that lies in it [m]')
    depth: Number = Field(
        description="depth of the case's centre of gravity, where the clock "
        "is, below the axle's centre [m]"
    )
    gyration_radius: Number = Field(
        description='radius of gyration of the case about its centre of gravity [m]'
    )
    large_angles: Flag = Field(
        default=False, description='true: equations for any angle; false: for small angles'
    )

    @property
    def link(self) -> float:  # type: ignore[override]
        """e, the support's radius less the axle's [m]."""
        return self.support_radius - self.axle_radius

    @cached_property
    def modes(self) -> Modes:
        """Both modes of the case."""
        return modes(self.link, self.depth, self.gyration_radius**2)

    def frequencies(self, gravity: float) -> tuple[float, ...]:
        """Return ω of both modes."""
        slow, fast = self.modes.squared_frequencies(gravity)
        return math.sqrt(slow), math.sqrt(fast)

    def answer(self, frequency: FloatArray, gravity: float, duration_s: float) -> FloatArray:
        """Return φ/τ for waves of frequency Ω, and at resonance as far as they get."""
        squared = self.gyration_radius**2
        return answers(self.modes, self.depth, squared, frequency, gravity, duration_s)[1]

    def swing(self, gravity: float, tolerance: float | None) -> CaseSwing:
        """Return the propagator of the case, at small angles or at any."""
        from tauto_core.motion.suspended_case import AxleModes, AxleSwing

        shape = self.link, self.depth, self.gyration_radius, gravity
        return AxleSwing(*shape, tolerance=tolerance) if self.large_angles else AxleModes(*shape)

    def wider(self, frequency: float, gravity: float) -> float:
        """Return the gyration_radius with which the fast mode has a frequency [rad/s], or inf."""
        b, c, e = gravity / frequency**2, self.depth, self.link
        return math.sqrt(c * b * (c + e - b) / (e - b)) if b < e else math.inf

    def problems(self, *, still: bool) -> Iterator[Problem]:
        """Yield the contradictions between its keys."""
        if self.support_radius <= self.axle_radius:
            yield Problem(
                'suspension.support_radius',
                self.support_radius,
                f'must be larger than suspension.axle_radius, {self.axle_radius!r} m: on a '
                'bearing that is not hollow b′ is negative, and the case falls from it',
                f'Use for example {2.0 * self.axle_radius!r}, or a thinner axle.',
            )
        yield from super().problems(still=still)


KIND = AxleSuspension
