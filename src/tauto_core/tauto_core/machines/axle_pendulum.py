"""A body on a cylindrical axle that rests without friction in, on or over a curved support.

Its two normal modes (C in axle.md, Euler 1780, 12–28, 42), its energy and periods, and the body as
the regulator of a clock. `motion.axle` computes its motion at any angles.

x points down, y sideways. θ is the tilt of the normal at the contact, from the support's centre O
to the axle's centre C, and φ the tilt of the body, from C to its centre of gravity. The axle's
centre moves along an arc of radius e about O, s = eθ. The curvature 1/e is 0 on a plane and
negative on a convex support. In a cradle C is the centre of curvature of the rockers (§48–53).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import cached_property
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from tauto_core.curves.numerics import integrate
from tauto_core.machines.parts import (
    OtherRegulator,
    beside_regulator,
    wrong,
)
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import ABSENT, Problem, SceneError, TautoError, UsageError
from tauto_core.scene.sections import NonNegative, Number, Positive, Section

# -----------------------------------------------------------------------------
# The two normal modes of a link with a heavy body (C in axle.md, Euler 1780, 12–28, 42).
#
# A massless link of length e carries at its end C a body with its centre of gravity c below C and
# the radius of gyration k about it. To first order in the tilts θ of the link and φ of the body
#
#     e θ̈ + c φ̈ + g θ = 0,    k² φ̈ + g c (φ − θ) = 0.
#
# Each mode keeps time with a simple pendulum of length h or h′ and has the ratio θ : φ = c : B or
# c : B′, with
#
#     h + h′ = (k² + c² + ce)/c,    h h′ = e k²/c,    B B′ = −ce,    h = e + B,  h′ = e + B′.
#
# An axle of radius b in a smooth bearing of radius a is such a link with e = a − b, 1/e = 0 on a
# plane and e < 0 on a convex support. So is a thread that swings and winds on a wheel: e is its
# free length, c the cam's base radius, k² = I/m.

DIGITS = 60


class Modes(NamedTuple):
    """The slow and the fast mode, or the stable and the unstable one on a convex support.

    Attributes:
        h: length of the simple pendulum that keeps time with the slow mode [m], infinite on a
            plane, which makes this mode a steady drift.
        h_prime: the same for the fast mode [m], negative if that mode is unstable.
        B: tilt of the body in the slow mode, θ : φ = c : B [m].
        B_prime: the same for the fast mode [m].
    """

    h: float
    h_prime: float
    B: float
    B_prime: float

    @property
    def tilt_per_arc(self) -> tuple[float, float]:
        """φ/s in the slow and the fast mode [rad/m], s = eθ ≠ 0: B/(ce) = −1/B′, and −1/B."""
        return -1.0 / self.B_prime, -1.0 / self.B

    def coordinates_at(self, tilt: float, c: float) -> tuple[float, float]:
        """Return q and q′ of θ = c (q + q′), φ = Bq + B′q′ with θ = φ = tilt [rad], c in m."""
        gap = c * (self.B - self.B_prime)
        return tilt * (c - self.B_prime) / gap, tilt * (self.B - c) / gap

    def squared_frequencies(self, gravity: float) -> tuple[float, float]:
        """Return ω² = g/h of both modes [rad2/s2], negative if unstable, 0 for a drift."""
        fast = gravity / self.h_prime if self.h_prime else math.inf
        return gravity / self.h, fast


def modes(e: float, c: float, k_squared: float) -> Modes:
    """Return both modes, without cancellation from the knife-edge to the plane and beyond.

    Lengths are in metres. e = ±inf is a plane, e < 0 a convex support, c < 0 a centre of gravity
    above the end of the link.

    Of the two forms D² = (k² + c² − ce)² + 4c³e = (k² + c² + ce)² − 4cek² the one without a
    difference is used. The root with terms of one sign is computed, and the product of the roots
    gives the other.
    """
    # e = p/q gives a plane q = 0, and the squares of a huge length do not overflow
    p, q = (e, 1.0) if abs(e) < 1e100 else (math.copysign(1.0, e), 1.0 / abs(e))
    link = c * p
    total, offset = q * k_squared + c * (q * c + p), q * k_squared + c * (q * c - p)
    if link >= 0.0:
        root = math.hypot(offset, 2.0 * abs(c) * math.sqrt(link * q))
    else:
        root = math.hypot(total, 2.0 * math.sqrt(-link * q * k_squared))
    added = total + math.copysign(root, total)
    large, small = _over(added, 2.0 * c * q), 2.0 * p * k_squared / added
    h, h_prime = (large, small) if total >= 0.0 else (small, large)
    spread = offset + math.copysign(root, offset)
    leading, second = _over(spread, 2.0 * c * q), -2.0 * c * c * p / spread
    tilt, tilt_prime = (leading, second) if offset >= 0.0 else (second, leading)
    return Modes(h, h_prime, tilt, tilt_prime)


def _over(above: float, below: float) -> float:
    if below:
        return above / below
    return math.copysign(math.inf, above) * math.copysign(1.0, below)


def exact_lengths(e: Decimal, c: Decimal, k_squared: Decimal) -> tuple[Decimal, Decimal]:
    """Return h and h′ [m] to some 40 digits, for phases over millions of turns, from k² > 0."""
    with localcontext() as context:
        context.prec = DIGITS
        total = k_squared + c * c + c * e
        h = (total + (total * total - 4 * c * e * k_squared).sqrt()) / (2 * c)
        return h, e * k_squared / (c * h)


def answers(
    pair: Modes,
    depth: float,
    k_squared: float,
    frequency: FloatArray,
    gravity: float,
    duration_s: float,
) -> tuple[FloatArray, FloatArray]:
    """Return the amplitude ratios θ/τ and φ/τ for each wave.

    At resonance it is the amplitude reached at the end. `depth` is c [m], `k_squared` k² [m2],
    `frequency` Ω of the waves [rad/s].
    """
    square = frequency**2
    divisor = np.full_like(square, pair.h * pair.h_prime * depth)
    for mode in pair.squared_frequencies(gravity):
        divisor *= off_resonance(mode, square, duration_s)
    theta = gravity * (gravity * depth - k_squared * square) / divisor
    return theta, gravity * gravity * depth / divisor


def off_resonance(mode: float, square: FloatArray, duration_s: float) -> FloatArray:
    """Return ω² − Ω² [rad2/s2], at resonance the value that gives the amplitude at the end.

    Args:
        mode: ω² of the mode [rad2/s2].
        square: Ω² of the waves [rad2/s2].
        duration_s: duration of the growth [s].
    """
    detuning, width = mode - square, 2.0 * math.sqrt(mode) / duration_s
    return np.where(np.abs(detuning) < width, width, detuning)


class UnsteadyAxleError(TautoError):
    """An impossible axle or support, or one from which the body falls."""


@dataclass(frozen=True)
class AxlePendulum:
    """The body, its support and gravity.

    Attributes:
        curvature: 1/e of the path of the axle's centre [1/m]: positive in a hollow, 0 on a plane,
            negative on a convex support.
        depth: c of the centre of gravity below the axle's centre [m], not 0, negative above it.
        gyration_radius: k about the centre of gravity [m], > 0.
        gravity: g [m/s2], > 0.

    Raises:
        UnsteadyAxleError: a depth of 0, which has no modes.
    """

    curvature: float
    depth: float
    gyration_radius: float
    gravity: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.depth) and self.depth != 0.0):
            raise UnsteadyAxleError(
                f'depth = {self.depth!r} m: must be a finite number other than 0, or the body '
                'rests at any tilt. Let the centre of gravity hang below the axle'
            )

    @cached_property
    def modes(self) -> Modes:
        """Both normal modes (§12–28, 42)."""
        e = 1.0 / self.curvature if self.curvature else math.inf
        return modes(e, self.depth, self.gyration_radius**2)

    @property
    def growth_rate(self) -> float:
        """Growth rate of the unstable mode [1/s], √(g/|h′|) or √(g/|h|), or 0.

        h h′ = e k²/c makes one of them negative on every convex support (§45–47), and with the
        centre of gravity above the axle's centre (§49).
        """
        return math.sqrt(max(0.0, *(-w for w in self.modes.squared_frequencies(self.gravity))))

    def require_swing(self) -> None:
        """Refuse an unstable body: UnsteadyAxleError names the negative length and a remedy."""
        if self.growth_rate == 0.0:
            return
        lengths = self.modes
        name, length = ('h′', lengths.h_prime) if lengths.h > 0.0 else ('h', lengths.h)
        remedies = []
        if self.curvature < 0.0:
            remedies.append('rest the axle in a hollow of larger radius, or on a plane')
        if self.depth < 0.0:
            remedies.append(f'hang the centre of gravity {-self.depth:.6g} m below the axle')
        raise UnsteadyAxleError(
            f'{name} = {length:.6g} m is negative: the body falls from its support, '
            f'{self.growth_rate:.6g}-fold e a second, and swings only if both lengths are '
            'positive. ' + ' and '.join(remedies).capitalize()
        )


def axle_on(support_radius: float, axle_radius: float) -> float:
    """Return the curvature 1/e = 1/(a − b) of the path of an axle's centre [1/m].

    The hollow's radius a is ±inf for a plane, negative for a convex support. b ≥ 0 is the radius
    of the axle or of a cradle's rockers. UnsteadyAxleError: an axle that does not fit into its
    hollow.
    """
    if 0.0 < support_radius <= axle_radius:
        raise UnsteadyAxleError(
            f'support_radius = {support_radius!r} m: must be larger than the radius of the axle, '
            f'{axle_radius!r} m. Widen the hollow or turn the axle thinner'
        )
    return 0.0 if math.isinf(support_radius) else 1.0 / (support_radius - axle_radius)


Reals: TypeAlias = float | FloatArray


class AxleState(NamedTuple):
    """Position and velocity of the body, floats or arrays of one shape.

    Attributes:
        arc: s of the axle's centre along its path [m], in the frame of the support.
        tilt: φ of the body from the vertical [rad].
        arc_rate: ds/dt [m/s].
        tilt_rate: dφ/dt [rad/s].
    """

    arc: Reals
    tilt: Reals
    arc_rate: Reals
    tilt_rate: Reals


def small_motion(body: AxlePendulum, start: AxleState, times_s: ArrayLike) -> AxleState:
    """Return the small motion from any state, at times of any shape (§29–36, 43–47).

    With r and r′ the ratios φ/s of the modes, q = (φ − r′s)/(r − r′) and q′ = (rs − φ)/(r − r′)
    each obey q̈ = −(g/h) q. The solution is a sine, a drift on a plane, or a sinh for an unstable
    mode.
    """
    slow, fast = body.modes.tilt_per_arc
    times, split = np.asarray(times_s, np.float64), slow - fast
    s, phi = float(np.asarray(start.arc)), float(np.asarray(start.tilt))
    s1, phi1 = float(np.asarray(start.arc_rate)), float(np.asarray(start.tilt_rate))
    squares = body.modes.squared_frequencies(body.gravity)
    slow_q, first_rate = _swing(
        (phi - fast * s) / split, (phi1 - fast * s1) / split, squares[0], times
    )
    fast_q, other_rate = _swing(
        (slow * s - phi) / split, (slow * s1 - phi1) / split, squares[1], times
    )
    return AxleState(
        slow_q + fast_q,
        slow * slow_q + fast * fast_q,
        first_rate + other_rate,
        slow * first_rate + fast * other_rate,
    )


def _swing(
    value: float, rate: float, squared: float, times: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return q and its rate at the times, for q̈ = −ω²q."""
    w = math.sqrt(abs(squared))
    if w == 0.0:
        return value + rate * times, np.full(times.shape, rate)
    wave, odd = (np.cos, np.sin) if squared > 0.0 else (np.cosh, np.sinh)
    c, s = wave(w * times), odd(w * times)
    return value * c + rate / w * s, rate * c - math.copysign(w, squared) * value * s


class SupportMotion(NamedTuple):
    """Motion of the support: it turns by ρ about an accelerated axis.

    The axis is the place of the axle's centre at s = 0.
    Floats or arrays of one shape. Angles are right-handed from x (down) towards y (sideways).

    Attributes:
        turn, turn_rate, turn_acceleration: ρ [rad], ρ̇ [rad/s], ρ̈ [rad/s2].
        down, lateral: acceleration of the axis [m/s2].
    """

    turn: Reals = 0.0
    turn_rate: Reals = 0.0
    turn_acceleration: Reals = 0.0
    down: Reals = 0.0
    lateral: Reals = 0.0


STILL = SupportMotion()


@dataclass(frozen=True)
class AxleContact:
    """The contact of the axle with its support.

    Attributes:
        radius: b of the axle, or of a cradle's rockers [m], ≥ 0. Without friction it matters only
            through the curvature of the path.
        rolls: whether the axle rolls without slipping, with the friction that this takes.
        friction: force along the support over the contact force during sliding, positive if it
            pushes the body towards +s.
    """

    radius: float = 0.0
    rolls: bool = False
    friction: float = 0.0


SMOOTH = AxleContact()


def plane_period(body: AxlePendulum, amplitude: float) -> float:
    """Return the period of swings of any size on a plane, T = 4 ∫ dφ/φ̇ [s] (C in axle.md).

    The centre of gravity moves on a vertical line: (k² + c² sin²φ) φ̇² = 2gc (cos φ − cos A), 0 <
    A < π. With sin(φ/2) = sin(A/2) sin u the integrand is smooth. UnsteadyAxleError: another
    support, an unstable body, an amplitude out of range.
    """
    body.require_swing()
    if body.curvature != 0.0 or not 0.0 < amplitude < math.pi:
        raise UnsteadyAxleError(
            f'curvature = {body.curvature!r}, amplitude = {amplitude!r}: only a plane gives a '
            'period at any size, of swings below π rad. Give curvature 0 and an amplitude below π'
        )
    c, k, top = body.depth, body.gyration_radius, math.sin(0.5 * amplitude)

    def integrand(u: FloatArray) -> FloatArray:
        sine = top * np.sin(u)
        cosine = np.sqrt((1.0 - sine) * (1.0 + sine))
        return np.hypot(k, 2.0 * c * sine * cosine) / cosine

    quarter = integrate(integrand, np.zeros(1), np.full(1, 0.5 * math.pi))
    return 4.0 * float(quarter[0]) / math.sqrt(body.gravity * c)


def rolling_length(body: AxlePendulum, radius: float) -> float:
    """Return the length of the simple pendulum of small swings of an axle that rolls [m].

    (k² + (c − b)²)/(c + b²/e), which is a knife-edge for b = 0. It is negative if the body falls,
    and infinite if it rests at any tilt.
    """
    inertia = body.gyration_radius**2 + (body.depth - radius) ** 2
    return _over(inertia, body.depth + body.curvature * radius * radius)


def rolling_period(body: AxlePendulum, radius: float, amplitude: float) -> float:
    """Return the period of swings of any size of an axle that rolls, T = 4 ∫ dφ/φ̇ [s].

    It turns about its contact: (k² + b² + c² − 2bc cos δ) φ̇² = 2(V(A) − V(φ)), δ = φ(1 + b/e),
    V = ge(1 − cos(bφ/e)) + gc(1 − cos φ). With φ = A sin u the integrand is smooth.
    UnsteadyAxleError: an amplitude outside 0 < A < π, or one from which it does not swing.
    """
    b, c, k, bent = radius, body.depth, body.gyration_radius, body.curvature * radius

    def fallen(u: FloatArray) -> FloatArray:
        """Return (V(A) − V(φ))/(g (A − φ))."""
        middle, away = 0.5 * amplitude * (1.0 + np.sin(u)), 0.5 * amplitude * (1.0 - np.sin(u))
        hung = c * np.sin(middle) * np.sinc(away / np.pi)
        return hung + b * np.sin(bent * middle) * np.sinc(bent * away / np.pi)

    places = np.linspace(0.0, 0.5 * math.pi, 200)
    if not (0.0 < amplitude < math.pi and np.all(fallen(places) > 0.0)):
        raise UnsteadyAxleError(
            f'amplitude = {amplitude!r} rad: must be above 0 and less than π, and the body must '
            'swing back from it. Give a smaller one, or hang the centre of gravity deeper'
        )

    def integrand(u: FloatArray) -> FloatArray:
        cosine = np.cos((1.0 + bent) * amplitude * np.sin(u))
        mass = k * k + b * b + c * c - 2.0 * b * c * cosine
        # A cos u over the root of A − φ = A cos²u/(1 + sin u)
        return np.sqrt(0.5 * mass * amplitude * (1.0 + np.sin(u)) / fallen(u))

    quarter = integrate(integrand, np.zeros(1), np.full(1, 0.5 * math.pi))
    return 4.0 * float(quarter[0]) / math.sqrt(body.gravity)


# -----------------------------------------------------------------------------
# The body as the regulator of a clock, as numbers and as the section of a scene.


@dataclass(frozen=True)
class AxleClock(OtherRegulator):
    """A body on an axle, as numbers.

    Attributes:
        body: the body, with the curvature of its path, and gravity.
        radius: b of the axle, or of a cradle's rockers [m].
        contact: 'smooth', 'rolling' or 'coulomb'.
        friction: μ of 'coulomb', largest force along the support over the contact force.
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
    range_rad = math.nextafter(math.pi, 0.0)

    def require_swing(self) -> None:
        """Refuse a body that falls from its support: UnsteadyAxleError, with a remedy."""
        if self.contact == 'smooth':
            self.body.require_swing()
        elif not 0.0 < self.lengths[0] < math.inf:
            raise UnsteadyAxleError(
                f'the length of its small swings is {self.lengths[0]:.6g} m: rolling, the body '
                'falls from its support unless c + b²/e is positive. Hang the centre of gravity '
                'deeper, or turn a convex support wider'
            )

    @property
    def touch(self) -> AxleContact:
        """The contact, rolling or without friction."""
        return AxleContact(self.radius, self.contact != 'smooth')

    @property
    def propagator_reason(self) -> str:
        """Why it moves in steps."""
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

        A steady drift on a plane is left out. An unstable mode has a negative length.
        """
        if self.contact != 'smooth':
            return (rolling_length(self.body, self.radius),)
        pair = self.body.modes.h, self.body.modes.h_prime
        return tuple(length for length in pair if math.isfinite(length))

    @property
    def frequency(self) -> float:
        """ω of small swings, of the slow mode if there are two [rad/s], or 0 if it falls."""
        return math.sqrt(max(self.body.gravity / self.lengths[0], 0.0))

    @property
    def fastest(self) -> float:
        """ω of the fast mode, or the growth rate of an unstable one [rad/s]."""
        return math.sqrt(self.body.gravity / min(map(abs, self.lengths)))

    def period(self, amplitude: float) -> float:
        """Return the period of a free swing on a support at rest [s].

        UsageError: two modes, which together are not periodic. UnsteadyAxleError: an amplitude
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


class AxleRegulator(Section):
    """A body that swings on a cylindrical axle, without a trochlea (Euler 1780).

    The axle is in a hollow, on a plane or on a convex support. A cradle stands on rockers instead.
    The first dissertation leaves friction to the second.
    """

    kind: Literal['axle'] = Field(description='axle')
    support: Literal['concave', 'plane', 'convex', 'cradle'] = Field(
        description='concave, plane, convex, or cradle: a body on rockers, on a plane or in a '
        'hollow'
    )
    support_radius: Positive | None = Field(
        default=None,
        description='radius of a concave or convex support, or of the hollow in '
        'which a cradle stands [m], a plane when left out',
    )
    axle_radius: NonNegative = Field(
        default=0.0, description='radius of the axle, or of the rockers of a cradle [m]'
    )
    depth: Number = Field(
        description='depth of the centre of gravity below the centre of the axle or rockers [m], '
        'negative above it'
    )
    gyration_radius: Positive = Field(
        description='radius of gyration of the body about its centre of gravity [m]'
    )
    mass: Positive = Field(default=1.0, description='mass of the body [kg], only for its torque')
    contact: Literal['smooth', 'rolling', 'coulomb'] = Field(
        default='smooth',
        description='smooth (no friction), rolling (without slipping) or coulomb (rolling if '
        'friction suffices, otherwise sliding)',
    )
    friction: Positive | None = Field(
        default=None, description='coefficient of friction of contact coulomb'
    )
    release_tilt: Number = Field(
        default=0.0, description='tilt of the body in the ship at the start [rad]'
    )
    release_arc: Number | None = Field(
        default=None,
        description="arc of a smooth axle's centre from its place at rest at the start [m]. When "
        'left out the release excites only the regular mode',
    )
    push_speed: Number | None = Field(
        default=None,
        description='speed of the centre of gravity, athwart, at the start [m/s]. When left out '
        "the axle's centre is not pushed",
    )
    push_spin: Number = Field(
        default=0.0, description='angular velocity of the body at the start [rad/s]'
    )

    def problems(
        self, sections: Mapping[str, object], ship: str, *, still: bool
    ) -> Iterator[Problem]:
        """Yield its problems, and the sections that it excludes."""
        yield from beside_regulator(
            sections,
            {
                'trochlea': 'a scene has one regulator',
                'drag': 'only its support acts on the body',
                'escapement': 'a body on an axle has no escapement',
                'suspension': 'its support is fixed to the ship',
            },
        )
        curved, slips = self.support in ('concave', 'convex'), self.friction is not None
        contact = f'does not go with regulator.contact {self.contact}'
        yield from wrong(
            (
                (self.support_radius is None) == curved and self.support != 'cradle',
                'regulator.support_radius',
                ABSENT if curved else self.support_radius,
                'is missing' if curved else 'does not go with regulator.support plane',
                'Give the radius of the support [m].'
                if curved
                else 'Leave it out, or use support concave or convex.',
            ),
            (
                self.support == 'cradle' and self.axle_radius == 0.0,
                'regulator.axle_radius',
                self.axle_radius,
                'is the radius of the rockers of a cradle, and must be above 0',
                'Give the radius of the rockers [m].',
            ),
            (
                slips != (self.contact == 'coulomb'),
                'regulator.friction',
                self.friction if slips else ABSENT,
                contact if slips else 'is missing with regulator.contact coulomb',
                'Leave it out, or use contact coulomb.'
                if slips
                else 'Give a coefficient of friction, such as 0.2.',
            ),
            *(
                (
                    value is not None and self.contact in contacts,
                    f'regulator.{key}',
                    value,
                    f'{contact}: an axle that rolls moves as the body turns',
                    'Leave it out, or use contact smooth.',
                )
                for key, value, contacts in (
                    ('release_arc', self.release_arc, ('rolling', 'coulomb')),
                    ('push_speed', self.push_speed, ('rolling',)),
                )
            ),
            (
                still
                and not (
                    self.release_tilt or self.release_arc or self.push_speed or self.push_spin
                ),
                'regulator.release_tilt',
                self.release_tilt,
                'leaves the body at rest for ever on a still ship',
                'Release it at a tilt other than 0 rad, or give a push_spin.',
            ),
        )

    @property
    def released_at(self) -> float:
        """Tilt of the release [rad]."""
        return self.release_tilt

    def machine(self, name: str, gravity: float) -> AxleClock:
        """Return the regulator of a named scene as numbers. SceneError: it falls."""
        try:
            clock = self.clock(gravity)
            clock.require_swing()
        except UnsteadyAxleError as error:
            raise SceneError(
                name,
                'regulator.support',
                self.support,
                f'makes no clock: {error}',
                'Change the body or its support. `tauto axle` shows how it falls.',
            ) from None
        return clock

    def clock(self, gravity: float) -> AxleClock:
        """Return the body as numbers, even if it falls.

        UnsteadyAxleError: an axle that does not fit into its hollow, or a body without modes.
        """
        radius = math.inf if self.support_radius is None else self.support_radius
        if self.support == 'convex':
            radius = -radius
        curvature = axle_on(radius, self.axle_radius)
        body = AxlePendulum(curvature, self.depth, self.gyration_radius, gravity)
        tilt, spin = self.release_tilt, self.push_spin
        arc, sliding = -self.axle_radius * tilt, -self.axle_radius * spin
        if self.contact == 'smooth':
            # on a plane the centre of gravity stays on its vertical, also above the axle (§38)
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
