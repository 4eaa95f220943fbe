"""The attributes that every regulator has, whatever its construction."""

from __future__ import annotations

from typing import Protocol

from tauto_core.machines.drag import Drag
from tauto_core.machines.escapement import EscapementKind


class Regulator(Protocol):
    """A wheel that swings, with any kind of thread and power."""

    @property
    def inertia(self) -> float:
        """I of the wheel about its axle [kg m2]."""
        ...

    @property
    def drag(self) -> Drag | None:
        """Drag torques against the motion in the case."""
        ...

    @property
    def escapement(self) -> EscapementKind | None:
        """The escapement."""
        ...

    @property
    def release_angle(self) -> float:
        """Angle of release of the wheel in its case, at rest at the start [rad]."""
        ...

    @property
    def frequency(self) -> float:
        """Small-amplitude angular frequency on land [rad/s]."""
        ...

    @property
    def small_period(self) -> float:
        """Small-amplitude period on land [s]."""
        ...

    @property
    def range_rad(self) -> float:
        """Largest angle, to either side, that cam and thread allow [rad]."""
        ...

    @property
    def follows_apparent_vertical(self) -> bool:
        """Whether the direction of the apparent vertical acts on it."""
        ...

    @property
    def feels_gravity(self) -> bool:
        """Whether the strength of the apparent gravity acts on it."""
        ...

    def felt_angle(self, angle: float, tilt: float) -> float:
        """Return the angle that `range_rad` bounds [rad].

        Args:
            angle: angle of the wheel in its case [rad].
            tilt: tilt of the apparent vertical in the case, β − α_c [rad].
        """
        ...

    def period(self, amplitude: float) -> float:
        """Return the period of free swings on land, without drag [s]."""
        ...

    def wider_range(self, amplitude: float) -> str:
        """Return what change would widen the range to an amplitude, as the end of a sentence.

        Args:
            amplitude: the amplitude that the range should include [rad], > 0.
        """
        ...
