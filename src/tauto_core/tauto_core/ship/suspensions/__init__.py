"""The kinds of suspension of the clock's case (theory/suspension.md).

Their mechanics are in `motion.suspended_case`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from numpy.typing import NDArray
from pydantic import Field, Strict

from tauto_core.machines.axle_pendulum import Modes, answers, modes, off_resonance
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import Problem
from tauto_core.scene.sections import Flag, Kind, Positive

if TYPE_CHECKING:
    from tauto_core.motion.suspended_case import CaseSwing


# -----------------------------------------------------------------------------
# The base of all suspensions.

FOLDER = 'tauto_core.ship.suspensions'


class SuspensionKind(Kind):
    """The clock's case hung in the ship, a kind of `ship/suspensions`.

    Attributes:
        link: length e of the link between ship and case [m], 0 if the case turns about a point of
            the ship.
        is_damped: whether the swing of the case is damped.
        sticks: whether dry friction holds the case in the ship at times.
        plane: the plane in which the case holds a thread, `None` for the trochlea's.
    """

    link: ClassVar[float] = 0.0
    is_damped: ClassVar[bool] = False
    sticks: ClassVar[bool] = False
    plane: ClassVar[Literal['vertical'] | None] = None
    kind: str
    if TYPE_CHECKING:  # each kind has them, in its own order
        depth: float
        gyration_radius: float
        large_angles: bool

    @property
    def is_linear(self) -> bool:
        """Whether the case swings by linear equations, independent of the clock."""
        return not self.large_angles

    def frequencies(self, gravity: float) -> tuple[float, ...]:
        """Return ω of each mode of the free case, the slower first [rad/s]."""
        raise NotImplementedError

    def answer(self, frequency: FloatArray, gravity: float, duration_s: float) -> NDArray[Any]:
        """Return the amplitude ratio φ/τ in waves of frequency Ω [rad/s].

        At resonance it is the amplitude reached by the end of the duration [s].
        """
        raise NotImplementedError

    def swing(self, gravity: float, tolerance: float | None) -> CaseSwing:
        """Return the law that moves the case. Imports kernels."""
        raise NotImplementedError

    def problems(self, *, still: bool) -> Iterator[Problem]:
        """Yield the contradictions between its keys, for a ship that is `still` or moves."""
        if still:
            problem = 'is not for a ship at rest, on which the case hangs still'
            yield Problem('suspension', self.kind, problem, 'Leave it out, or let the ship move.')


# -----------------------------------------------------------------------------
# A cylindrical axle in a bearing of the ship.


class AxleSuspension(SuspensionKind):
    """The clock's case hung on a cylindrical axle in the ship's bearing (suspension.md)."""

    rank = 1
    starter: ClassVar[Mapping[str, float]] = {
        'support_radius': 0.02,
        'axle_radius': 0.005,
        'depth': 0.1,
        'gyration_radius': 0.05,
    }

    kind: Literal['axle'] = 'axle'
    support_radius: Positive = Field(description='radius of the hollow bearing [m]')
    axle_radius: Positive = Field(description='radius of the axle in it [m]')
    depth: Positive = Field(
        description="depth of the case's centre of gravity, where the clock "
        "is, below the axle's centre [m]"
    )
    gyration_radius: Positive = Field(
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
        """Return φ/τ for waves of frequency Ω, limited at resonance by the duration."""
        squared = self.gyration_radius**2
        return answers(self.modes, self.depth, squared, frequency, gravity, duration_s)[1]

    def swing(self, gravity: float, tolerance: float | None) -> CaseSwing:
        """Return the propagator of the case, at small angles or at any."""
        from tauto_core.motion.suspended_case import AxleModes, AxleSwing

        shape = self.link, self.depth, self.gyration_radius, gravity
        return AxleSwing(*shape, tolerance=tolerance) if self.large_angles else AxleModes(*shape)

    def problems(self, *, still: bool) -> Iterator[Problem]:
        """Yield the contradictions between its keys."""
        if self.support_radius <= self.axle_radius:
            yield Problem(
                'suspension.support_radius',
                self.support_radius,
                f'must be larger than suspension.axle_radius, {self.axle_radius!r} m: the bearing '
                'would not be hollow, and the case would fall from it',
                f'Use for example {2.0 * self.axle_radius!r}, or a thinner axle.',
            )
        yield from super().problems(still=still)


# -----------------------------------------------------------------------------
# Gimbals: a pendulum on pivots fixed in the ship.

LARGEST_FRICTION = 0.5
"""Largest tilt at which friction may hold a hung case [rad]."""


class GimbalsSuspension(SuspensionKind):
    """The clock's case in gimbals: a pendulum on pivots fixed in the ship (suspension.md).

    The inner ring turns about the roll axis. The outer one keeps that axis level fore and aft,
    without friction.
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
    depth: Positive = Field(
        description="depth of the case's centre of gravity, where the clock is, below the pivots "
        '[m]'
    )
    gyration_radius: Positive = Field(
        description='radius of gyration of the case about its centre of gravity [m]'
    )
    damping_ratio: Annotated[float, Strict(), Field(ge=0.0, le=1.0)] = Field(
        default=0.0,
        description='damping ratio of its small swings by viscous friction in the pivots, 0 to 1',
    )
    friction_angle: Annotated[float, Strict(), Field(ge=0.0, le=LARGEST_FRICTION)] = Field(
        default=0.0,
        description='largest tilt at which the dry friction of the pivots holds the case on a '
        'ship at rest [rad], at most 0.5',
    )

    @property
    def is_damped(self) -> bool:  # type: ignore[override]
        """Whether the pivots have friction."""
        return self.damping_ratio > 0.0 or self.sticks

    @property
    def sticks(self) -> bool:  # type: ignore[override]
        """Whether the pivots have dry friction."""
        return self.friction_angle > 0.0

    @property
    def pull(self) -> float:
        """l/(k² + l²), by which gravity and the ship's accelerations turn the case [1/m]."""
        return self.depth / (self.gyration_radius**2 + self.depth**2)

    def frequencies(self, gravity: float) -> tuple[float, ...]:
        """Return ω_c of its small swings."""
        return (math.sqrt(gravity * self.pull),)

    def answer(self, frequency: FloatArray, gravity: float, duration_s: float) -> NDArray[Any]:
        """Return φ/τ of small swings, complex, limited at resonance by the duration.

        Dry friction is left out, and so is the roll against which the pivots rub.
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


KINDS = (AxleSuspension, GimbalsSuspension)
