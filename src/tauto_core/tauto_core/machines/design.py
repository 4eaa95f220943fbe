"""Euler's rules for designing a regulator, in both directions (1727, XIX–XXI, XXIX).

A regulator with a linear lever arm b·ϑ swings like a simple pendulum of length L = I g/(P b), so
I ω² = P b: three of period, moment of inertia, pull and lever rate determine the fourth.

The historical units are rounded. The Rhenish foot is the 139.13 Paris lines, 313.85 mm, that
Prussia fixed in 1816; older standards differ in the fourth digit. The Paris foot is that of 1766,
324.84 mm; the pound of Paris (poids de marc) is 489.5 g.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from tauto_core.scene.errors import Argument, UsageError
from tauto_core.scene.refuse import LARGEST_SIZE, LEAST_SIZE

RHENISH_FOOT_M = 0.31385
SCRUPLE_M = RHENISH_FOOT_M / 1000.0
"""Euler's scruple: a thousandth of the Rhenish foot, 0.31385 mm."""

PARIS_FOOT_M = 0.32484
PARIS_LINE_M = PARIS_FOOT_M / 144.0
"""The Paris line, 2.2558 mm."""

PARIS_POUND_KG = 0.4895

LENGTHS_M = {
    'm': 1.0,
    'mm': 1e-3,
    'scruple': SCRUPLE_M,
    'rhenish_foot': RHENISH_FOOT_M,
    'line': PARIS_LINE_M,
    'paris_foot': PARIS_FOOT_M,
}
"""Units of length in which a design may be given."""

WEIGHTS_KG = {'kg': 1.0, 'pound': PARIS_POUND_KG}
"""Units of weight besides the newton; a force is the mass times gravity."""


@dataclass(frozen=True)
class Design:
    """A regulator with a linear lever arm under a pull without inertia.

    Attributes:
        period: period of a full swing [s].
        inertia: I of the wheel [kg m2].
        pull: P in the thread [N].
        lever_rate: b, the base radius of an involute [m/rad].
    """

    period: float
    inertia: float
    pull: float
    lever_rate: float

    def pendulum_length(self, gravity: float) -> float:
        """Return L of the isochronous simple pendulum [m]."""
        return equivalent_pendulum_length(self.inertia, self.pull, self.lever_rate, gravity)


def complete(
    *,
    period: float | None = None,
    inertia: float | None = None,
    pull: float | None = None,
    lever_rate: float | None = None,
) -> Design:
    """Return the design that three of its four numbers determine: I (2π/T)² = P b.

    Args:
        period: T of a full swing [s].
        inertia: I of the wheel [kg m2].
        pull: P in the thread [N].
        lever_rate: b, the base radius of an involute [m/rad].

    Raises:
        UsageError: not exactly one is left out, or one is not between 1e-30 and 1e30.
    """
    given = {'period': period, 'inertia': inertia, 'pull': pull, 'lever_rate': lever_rate}
    missing = [name for name, value in given.items() if value is None]
    if len(missing) != 1:
        raise UsageError(
            'a design has four numbers, period, inertia, pull and base radius, of which three '
            f'give the fourth; left out: {", ".join(_WORDS[each] for each in missing) or "none"}. '
            'Leave out exactly one, as in ',
            Argument('period', 1),
            ' ',
            Argument('pull', 3),
            ' ',
            Argument('base_radius', 0.005),
        )
    for name, value in given.items():
        if value is not None:
            check_size(_WORDS[name], value)
    if period is None:
        period = math.tau * math.sqrt((inertia or 0.0) / ((pull or 0.0) * (lever_rate or 0.0)))
    stiffness = (math.tau / period) ** 2
    if inertia is None:
        inertia = (pull or 0.0) * (lever_rate or 0.0) / stiffness
    if pull is None:
        pull = inertia * stiffness / (lever_rate or 0.0)
    if lever_rate is None:
        lever_rate = inertia * stiffness / pull
    return Design(period, inertia, pull, lever_rate)


_WORDS = {
    'period': 'period',
    'inertia': 'inertia',
    'pull': 'pull',
    'lever_rate': 'base radius',
}
"""The four numbers as messages name them."""


def check_size(name: str, value: float) -> None:
    """Refuse a quantity outside the limits of a design.

    Args:
        name: name of the quantity, for the message.
        value: in any unit.

    Raises:
        UsageError: not between 1e-30 and 1e30.
    """
    if not LEAST_SIZE <= value <= LARGEST_SIZE:
        raise UsageError(
            f'{name} = {value!r}: must be > 0, from {LEAST_SIZE:g} to {LARGEST_SIZE:g}. '
            'Give another'
        )


def disc_inertia(weight: float, radius: float, gravity: float) -> float:
    """Return I = Q a²/(2g) of a homogeneous disc [kg m2].

    Args:
        weight: Q of the disc [N].
        radius: a of the disc [m].
        gravity: g [m/s2], > 0.
    """
    return weight * radius * radius / (2.0 * gravity)


def disc_weight(inertia: float, radius: float, gravity: float) -> float:
    """Return Q = 2 g I/a² of a homogeneous disc [N].

    Args:
        inertia: I [kg m2].
        radius: a of the disc [m], > 0.
        gravity: g [m/s2].
    """
    return 2.0 * gravity * inertia / (radius * radius)


def disc_radius(inertia: float, weight: float, gravity: float) -> float:
    """Return a = √(2 g I/Q) of a homogeneous disc [m].

    Args:
        inertia: I [kg m2].
        weight: Q of the disc [N], > 0.
        gravity: g [m/s2].
    """
    return math.sqrt(2.0 * gravity * inertia / weight)


def equivalent_pendulum_length(
    inertia: float, pull: float, lever_rate: float, gravity: float
) -> float:
    """Return L = I g/(P b) of the isochronous simple pendulum [m].

    For a disc of weight Q and radius a, and an involute of base radius r, it is Q a²/(2 P r)
    (§XXI), and Q r/(2P) where the base circle is the disc (§XIX).

    Args:
        inertia: I of the wheel [kg m2].
        pull: P in the thread [N], > 0.
        lever_rate: b, the base radius of an involute [m/rad], > 0.
        gravity: g [m/s2].
    """
    return inertia * gravity / (pull * lever_rate)


def lever_rate_for(inertia: float, pull: float, length: float, gravity: float) -> float:
    """Return b = I g/(P L) [m/rad]: the base radius that gives a pendulum length (§XX).

    Args:
        inertia: I of the wheel [kg m2].
        pull: P in the thread [N], > 0.
        length: L of the isochronous simple pendulum [m], > 0.
        gravity: g [m/s2].
    """
    return inertia * gravity / (pull * length)


def base_radius_of_disc(weight: float, pull: float, length: float) -> float:
    """Return r = 2 P L/Q [m], where the base circle is the disc itself (§XX).

    Args:
        weight: Q of the disc [N], > 0.
        pull: P in the thread [N].
        length: L of the isochronous simple pendulum [m].
    """
    return 2.0 * pull * length / weight


def length_of_thick_disc(weight: float, radius: float, pull: float, base_radius: float) -> float:
    """Return L = Q a⁴ r/(2 P) with a in units of r [m]: §XXI as printed.

    Q is then the weight of a disc of radius r and of the thickness of the larger one.

    Args:
        weight: Q of the small disc [N].
        radius: radius of the large disc [m].
        pull: P in the thread [N], > 0.
        base_radius: r [m], > 0.
    """
    return weight * (radius / base_radius) ** 4 * base_radius / (2.0 * pull)


def length_of_period(period: float, gravity: float) -> float:
    """Return L = g (T/2π)² [m] of the simple pendulum with this full period.

    Args:
        period: T [s].
        gravity: g [m/s2].
    """
    return gravity * (period / math.tau) ** 2


def half_period(length: float, gravity: float) -> float:
    """Return π √(L/g) [s]: one oscillation in the papers' sense, half a period.

    Args:
        length: L of the simple pendulum [m].
        gravity: g [m/s2], > 0.
    """
    return math.pi * math.sqrt(length / gravity)
