"""The clock's case hung on an axle: keys and refusals. Its mechanics are in `suspension`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from pydantic import Field

from tauto_core.scene.errors import Problem
from tauto_core.scene.fields import Flag, Number, Positive, Section


class AxleSuspension(Section):
    """The clock's case hung on a cylindrical axle in a bearing of the ship (theory E3)."""

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

    def problems(self, *, still: bool) -> Iterator[Problem]:
        """Yield what is wrong between its keys.

        Args:
            still: whether the ship lies still.
        """
        if still:
            yield Problem(
                'suspension',
                self.kind,
                'has nothing to do on a ship that lies still: the case hangs at rest',
                'Leave it out, or let the ship move.',
            )
        if self.support_radius <= self.axle_radius:
            yield Problem(
                'suspension.support_radius',
                self.support_radius,
                f'must be larger than suspension.axle_radius, {self.axle_radius!r} m: on a '
                'bearing that is not hollow b′ is negative, and the case falls from it',
                f'Use for example {2.0 * self.axle_radius!r}, or a thinner axle.',
            )
        if self.depth <= 0.0:
            below = -self.depth or self.gyration_radius
            yield Problem(
                'suspension.depth',
                self.depth,
                'must be greater than 0: a case whose centre of gravity does not hang below its '
                'axle topples',
                f'Use for example {abs(below) or 0.1!r}: positive is below the axle.',
            )
        if self.gyration_radius <= 0.0:
            yield Problem(
                'suspension.gyration_radius',
                self.gyration_radius,
                'must be greater than 0: a case without extent turns in no time (b′ = 0)',
                f'Use for example {0.5 * abs(self.depth) or 0.05!r}.',
            )
