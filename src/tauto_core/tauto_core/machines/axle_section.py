"""The regulator of a scene that is a body on a cylindrical axle (Euler 1780)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Literal

from pydantic import Field

from tauto_core.scene.errors import ABSENT, Problem, SceneError
from tauto_core.scene.sections import NonNegative, Number, Positive, Section

if TYPE_CHECKING:
    from tauto_core.machines.axle_clock import AxleClock


class AxleRegulator(Section):
    """A body that swings on a cylindrical axle, without a trochlea (Euler 1780).

    The axle lies in a hollow, on a plane or on a convex support; a cradle stands on rockers in its
    place. The first dissertation leaves friction out, which the second was to treat.
    """

    kind: Literal['axle'] = Field(description='axle')
    support: Literal['concave', 'plane', 'convex', 'cradle'] = Field(
        description='concave, plane, convex, or cradle: a body on rockers, on a plane or in a '
        'hollow'
    )
    support_radius: Positive | None = Field(
        default=None,
        description='radius of a concave or convex support, or of the hollow in '
        'which a cradle stands [m]; a plane when left out',
    )
    axle_radius: NonNegative = Field(
        default=0.0, description='radius of the axle, or of the rockers of a cradle [m]'
    )
    depth: Number = Field(
        description="depth of the centre of gravity below the axle's centre, or that of the "
        'rockers [m]; negative above it'
    )
    gyration_radius: Positive = Field(
        description='radius of gyration of the body about its centre of gravity [m]'
    )
    mass: Positive = Field(default=1.0, description='mass of the body [kg]; only for its torque')
    contact: Literal['smooth', 'rolling', 'coulomb'] = Field(
        default='smooth',
        description='smooth: no friction; rolling: the axle rolls without slipping; coulomb: it '
        'rolls where friction suffices, and slides elsewhere',
    )
    friction: Positive | None = Field(
        default=None, description='coefficient of friction; with contact coulomb'
    )
    release_tilt: Number = Field(
        default=0.0, description='tilt of the body in the ship at the start [rad]'
    )
    release_arc: Number | None = Field(
        default=None,
        description="arc of a smooth axle's centre from its place at rest at the start [m]; when "
        'left out that of the regular motion with this tilt, without the other mode',
    )
    push_speed: Number | None = Field(
        default=None,
        description='speed of the centre of gravity, athwart, at the start [m/s]; when left out '
        "the axle's centre is not pushed",
    )
    push_spin: Number = Field(
        default=0.0, description='angular velocity of the body at the start [rad/s]'
    )

    def problems(
        self, others: Mapping[str, object], ship: str, *, still: bool
    ) -> Iterator[Problem]:
        """Yield its problems, and the sections that cannot stand beside it."""
        del ship
        why = {
            'trochlea': 'a scene has one regulator',
            'drag': 'nothing but its support acts on the body',
            'escapement': 'nothing drives a body on an axle',
            'suspension': 'its support is fixed to the ship',
        }
        for key, section in others.items():
            if section is not None:
                remedy = f'Leave out {key}, or take a trochlea instead of the regulator.'
                yield Problem(key, ABSENT, f'does not go with regulator: {why[key]}', remedy)
        curved = self.support in ('concave', 'convex')
        if (self.support_radius is None) == curved and self.support != 'cradle':
            yield Problem(
                'regulator.support_radius',
                ABSENT if curved else self.support_radius,
                'is missing' if curved else 'does not go with regulator.support plane',
                'Give the radius of the support [m].'
                if curved
                else 'Leave it out, or use support concave or convex.',
            )
        if self.support == 'cradle' and self.axle_radius == 0.0:
            yield Problem(
                'regulator.axle_radius',
                self.axle_radius,
                'is the radius of the rockers of a cradle, and must be above 0',
                'Give the radius of the rockers [m].',
            )
        if (self.friction is None) == (self.contact == 'coulomb'):
            missing = self.friction is None
            yield Problem(
                'regulator.friction',
                ABSENT if self.friction is None else self.friction,
                'is missing with regulator.contact coulomb'
                if missing
                else f'does not go with regulator.contact {self.contact}',
                'Give a coefficient of friction, such as 0.2.'
                if missing
                else 'Leave it out, or use contact coulomb.',
            )
        for key in ('release_arc', 'push_speed'):
            value = getattr(self, key)
            if value is not None and (
                self.contact == 'rolling' or (self.contact == 'coulomb' and key == 'release_arc')
            ):
                yield Problem(
                    f'regulator.{key}',
                    value,
                    f'does not go with regulator.contact {self.contact}: an axle that rolls moves '
                    'as the body turns',
                    'Leave it out, or use contact smooth.',
                )
        if still and not (
            self.release_tilt or self.release_arc or self.push_speed or self.push_spin
        ):
            yield Problem(
                'regulator.release_tilt',
                self.release_tilt,
                'leaves the body at rest for ever on a ship that lies still',
                'Release it at a tilt other than 0 rad, or give a push_spin.',
            )

    @property
    def released_at(self) -> float:
        """Tilt of the release [rad]."""
        return self.release_tilt

    def machine(self, name: str, gravity: float) -> AxleClock:
        """Return the regulator of a named scene as numbers; SceneError: it falls."""
        from tauto_core.machines.axle_pendulum import UnsteadyAxleError

        try:
            clock = self.clock(gravity)
            clock.require_swing()
        except UnsteadyAxleError as error:
            raise SceneError(
                name,
                'regulator.support',
                self.support,
                f'makes no clock: {error}',
                'Change the body or its support; `tauto axle` shows how it falls.',
            ) from None
        return clock

    def clock(self, gravity: float) -> AxleClock:
        """Return the body as numbers, even if it falls.

        UnsteadyAxleError: an axle that does not fit into its hollow, or a body without modes.
        """
        from tauto_core.machines.axle_clock import AxleClock
        from tauto_core.machines.axle_pendulum import AxlePendulum, axle_on

        radius = math.inf if self.support_radius is None else self.support_radius
        if self.support == 'convex':
            radius = -radius
        curvature = axle_on(radius, self.axle_radius)
        body = AxlePendulum(curvature, self.depth, self.gyration_radius, gravity)
        tilt, spin = self.release_tilt, self.push_spin
        arc, sliding = -self.axle_radius * tilt, -self.axle_radius * spin
        if self.contact == 'smooth':
            # on a plane the centre of gravity keeps to its vertical, also above the axle (§38)
            on_plane = curvature == 0.0
            regular = -self.depth * tilt if on_plane else tilt / body.modes.tilt_per_arc[0]
            arc = regular if self.release_arc is None else self.release_arc
            sliding = 0.0
        if self.push_speed is not None:
            turned = self.push_speed - self.depth * spin * math.cos(tilt)
            sliding = turned / math.cos(curvature * arc)
        friction = self.friction or 0.0
        return AxleClock(
            body, self.axle_radius, self.contact, friction, self.mass, arc, tilt, sliding, spin
        )
