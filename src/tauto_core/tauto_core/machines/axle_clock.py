"""A body on a cylindrical axle as the regulator of a clock (Euler 1780).

`motion.axle` has its law and computes its motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tauto_core.machines.axle_pendulum import (
    AxleContact,
    AxlePendulum,
    UnsteadyAxleError,
    plane_period,
    rolling_length,
    rolling_period,
)
from tauto_core.machines.compiling import Isochronism, checked_amplitudes, rate_s_per_day
from tauto_core.machines.parts import InPlaceOfWheel
from tauto_core.scene.errors import UsageError


@dataclass(frozen=True)
class AxleClock(InPlaceOfWheel):
    """A body on an axle, as numbers.

    Attributes:
        body: the body, the curvature of the path of its axle's centre, and gravity.
        radius: b₀ of the axle, or of a cradle's rockers [m].
        contact: 'smooth', 'rolling' or 'coulomb'.
        friction: μ, largest force along the support over the contact force; of 'coulomb'.
        mass: M [kg].
        arc, tilt: s [m] and φ [rad] of the start, in the ship.
        arc_rate, tilt_rate: their rates at the start [m/s, rad/s].
    """

    body: AxlePendulum
    radius: float
    contact: Literal['smooth', 'rolling', 'coulomb']
    friction: float
    mass: float
    arc: float
    tilt: float
    arc_rate: float
    tilt_rate: float

    propagator = 'axle'
    follows_apparent_vertical = True
    feels_gravity = True

    def require_swing(self) -> None:
        """Refuse a body that falls from its support: UnsteadyAxleError says how, and a remedy."""
        if self.contact == 'smooth':
            self.body.require_swing()
        elif not 0.0 < self.lengths[0] < math.inf:
            raise UnsteadyAxleError(
                f'the length of its small swings is {self.lengths[0]:.6g} m: rolling, the body '
                'falls from its support; to swing, c + b₀²/e must be positive. Hang the centre '
                'of gravity deeper, or turn a convex support wider'
            )

    @property
    def touch(self) -> AxleContact:
        """The contact as it rolls, or without friction."""
        return AxleContact(self.radius, self.contact != 'smooth')

    @property
    def why_so(self) -> str:
        """Why it is moved in steps."""
        return 'its exact equations, in steps of 16 stages that are iterated to rounding'

    @property
    def largest_start(self) -> float:
        """Amplitude of a small swing with the tilts and rates of the start [rad], at least 1."""
        tilts = abs(self.tilt) + abs(self.body.curvature * self.arc)
        rates = abs(self.tilt_rate) + abs(self.arc_rate / self.body.depth)
        return max(1.0, tilts + rates / self.frequency)

    @property
    def lengths(self) -> tuple[float, ...]:
        """Lengths of the simple pendulums that keep time with small swings [m], the slow first.

        A steady drift on a plane has none; an unstable mode has a negative one.
        """
        if self.contact != 'smooth':
            return (rolling_length(self.body, self.radius),)
        both = self.body.modes.b, self.body.modes.b_prime
        return tuple(length for length in both if math.isfinite(length))

    @property
    def frequency(self) -> float:
        """ω of small swings, of the slow mode where there are two [rad/s]; 0 if it falls."""
        return math.sqrt(max(self.body.gravity / self.lengths[0], 0.0))

    @property
    def fastest(self) -> float:
        """ω of the fast mode, or the rate at which an unstable one grows [rad/s]."""
        return math.sqrt(self.body.gravity / min(map(abs, self.lengths)))

    def period(self, amplitude: float) -> float:
        """Return the period of a free swing on a support at rest [s].

        UsageError: two modes, which together are not periodic; UnsteadyAxleError: an amplitude
        from which the body does not swing back.
        """
        if self.contact == 'smooth':
            if self.body.curvature != 0.0:
                raise UsageError(
                    'a body on a smooth hollow has two modes, and its wide swings no period. Use '
                    'contact rolling or a plane, or see its motion with tauto axle'
                )
            return plane_period(self.body, amplitude)
        return rolling_period(self.body, self.radius, amplitude)

    def isochronism(
        self, amplitudes: list[float], nominal_period_s: float | None = None
    ) -> Isochronism:
        """Return period and rate of free swings at several amplitudes [rad], as of a wheel.

        Friction that lets the axle slip is ignored. Errors as of `period`, and UsageError: no
        amplitude, or one out of range.
        """
        asked = checked_amplitudes(
            amplitudes, math.nextafter(math.pi, 0.0), 'rad', 'in radians', 'less than a half turn'
        )
        nominal = self.small_period if nominal_period_s is None else nominal_period_s
        period = np.array([self.period(amplitude) for amplitude in asked])
        rate = np.array([rate_s_per_day(each, nominal) for each in period.tolist()])
        return Isochronism(nominal, np.array(asked), period, rate)
