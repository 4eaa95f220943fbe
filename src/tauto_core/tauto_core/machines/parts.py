"""The parts of a regulator: the bases of all drags, escapements and powers, and its facts."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, NamedTuple, Protocol

import numpy as np
from pydantic import Field, Strict

from tauto_core.curves.cam import Pull
from tauto_core.curves.numerics import gauss_rule
from tauto_core.machines.heat import OILS, NamedOil
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import ABSENT, Problem, UsageError
from tauto_core.scene.sections import Kind, NonNegative, Number, Section
from tauto_core.scene.times import DAY_S
from tauto_core.wording import left_out, printed

# -----------------------------------------------------------------------------
# Problems of a scene's parts.


def wrong(*checks: tuple[object, str, object, str, str]) -> Iterator[Problem]:
    """Yield the problems of checks: condition, key, value, problem and remedy."""
    for is_there, key, value, problem, remedy in checks:
        if is_there:
            yield Problem(key, value, problem, remedy)


def beside_regulator(sections: Mapping[str, object], why: Mapping[str, str]) -> Iterator[Problem]:
    """Yield the sections that a regulator in place of a wheel excludes."""
    return wrong(
        *(
            (
                section is not None,
                key,
                ABSENT,
                f'does not go with regulator: {why[key]}',
                f'Leave out {key}, or take a trochlea instead of the regulator.',
            )
            for key, section in sections.items()
        )
    )


# -----------------------------------------------------------------------------
# The base of regulators that stand in place of a wheel.


class OtherRegulator(ABC):
    """A regulator without a trochlea, drive and temperature dependence."""

    drag: ClassVar[None] = None
    escapement: ClassVar[None] = None
    propagator: ClassVar[str]
    """Name of its propagator."""
    follows_apparent_vertical: ClassVar[bool] = False
    feels_gravity: ClassVar[bool] = False

    @property
    @abstractmethod
    def frequency(self) -> float:
        """Angular frequency of small swings [rad/s]."""

    @property
    @abstractmethod
    def propagator_reason(self) -> str:
        """Why it has this propagator, as a clause."""

    @property
    @abstractmethod
    def largest_start(self) -> float:
        """Amplitude at the start, in the unit of its coordinate."""

    @property
    def small_period(self) -> float:
        """Period of small swings [s]."""
        return math.tau / self.frequency

    def swing_energy(self, place: FloatArray, rate: FloatArray) -> FloatArray:
        """Return the energy of small swings [J], (n,), or inf without a mass."""
        return np.full_like(place, np.inf)


# -----------------------------------------------------------------------------
# How the period depends on the amplitude.

# Periods are computed to 1e-12. A table prints the rate to 1e-3 s/day, finer than the steadiest
# marine chronometer, and the period to a nanosecond, a tenth of that. `--json` has all digits.
PERIOD = '.9f'
# Heading, width and format of each column.
_COLUMNS = {
    'amplitude_rad': ('amplitude rad', 14, '.6g'),
    'amplitude_m': ('amplitude m', 14, '.6g'),
    'descent_s': ('descent s', 13, PERIOD),
    'half_swing_s': ('half swing s', 13, PERIOD),
    'period_s': ('period s', 13, PERIOD),
    'rate_s_per_day': ('rate s/day', 13, '+z,.3f'),
}


@dataclass(frozen=True, eq=False)
class AmplitudeTable:
    """Figures of free swings at several amplitudes, a table as `str`.

    Attributes:
        nominal_period_s: time by which the dial advances in a full swing [s].
        keys_left_out: sections of the scene that do not affect the figures.
        warnings: warnings about a dial that is set for another machine.
    """

    nominal_period_s: float
    keys_left_out: tuple[str, ...] = field(default=(), kw_only=True)
    warnings: tuple[str, ...] = field(default=(), kw_only=True)

    def columns(self) -> dict[str, FloatArray]:
        """Return the arrays, by name."""
        return {name: getattr(self, name) for name in _COLUMNS if hasattr(self, name)}

    def __str__(self) -> str:
        table = []
        for name, column in self.columns().items():
            heading, width, form = _COLUMNS[name]
            cells = [heading, *(printed(value, form) for value in column.tolist())]
            table.append([f'{cell:>{width}}' for cell in cells])
        lines = ('  '.join(row) for row in zip(*table, strict=True))
        head = f'nominal period {self.nominal_period_s:{PERIOD}} s'
        return '\n'.join([head, *lines, *left_out(self.keys_left_out), *self.warnings])


@dataclass(frozen=True, eq=False)
class Isochronism(AmplitudeTable):
    """Period and rate of free swings on land at n amplitudes, a table as `str`.

    `rate_s_per_day` is the gain of the clock, positive if it is fast.
    """

    amplitude_rad: FloatArray
    period_s: FloatArray
    rate_s_per_day: FloatArray


def rate_s_per_day(period_s: float, nominal_period_s: float) -> float:
    """Return the gain of a clock in a day of true time, 86400 (T₀ − T)/T [s/day].

    T is the true period of a full swing, T₀ the time by which the dial advances in it [s].
    """
    return DAY_S * (nominal_period_s - period_s) / period_s


def checked_amplitudes(
    amplitudes: Iterable[float], edge: float, unit: str, words: str, limit: str
) -> list[float]:
    """Return the amplitudes. UsageError: without one in 0 < A ≤ edge."""
    sizes = [float(amplitude) for amplitude in amplitudes]
    if not sizes:
        raise UsageError(f'amplitudes: none given. Give at least one, {words}')
    for amplitude in sizes:
        if not 0.0 < amplitude <= edge:
            raise UsageError(
                f'amplitude {amplitude!r} {unit}: must be > 0 and {limit}, {edge!r} {unit}. '
                'Use a smaller one'
            )
    return sizes


# -----------------------------------------------------------------------------
# The base of all kinds of drag.

DRAGS = 'tauto_core.machines.drags'


class DragLaw(Protocol):
    """A torque against the motion, over the wheel's inertia I: a NamedTuple of plain numbers.

    Its method is compiled: docs/kernels.md describes the language.
    """

    def torque(self, rate: Any, direction: float) -> Any:
        """Return the torque over I [rad/s2], 0 at rest and odd in θ̇.

        Args:
            rate: θ̇ [rad/s]: a number, an array, or lanes of numbers at the nodes of a step.
            direction: sign of θ̇ during the step, ±1. At the ends of the step θ̇ may overshoot 0
                a little. Write direction · θ̇ for |θ̇| to keep the law smooth there.
        """


class DragKind(Kind):
    """Torque against the motion of the wheel in its case: c₁θ̇ + c₂θ̇|θ̇| + c₀ sgn θ̇ + law.

    Each kind is a module of `machines/drags`, with its own keys and its `law`.
    """

    kind: str
    viscous: NonNegative = Field(default=0.0, description='c₁ [N m s]')
    quadratic: NonNegative = Field(default=0.0, description='c₂ [N m s2]')
    coulomb: NonNegative = Field(default=0.0, description='c₀ [N m]')
    oil: NamedOil | None = Field(
        default=None,
        description=f'{", ".join(sorted(OILS))}, or mapping: thins_per_kelvin. It changes c₁ with '
        'temperature, which otherwise stays the same',
    )
    thickens_per_month: Annotated[float, Strict(), Field(ge=0.0, le=10.0)] = Field(
        default=0.0, description='relative growth of c₁ per month as the oil ages, 0 to 10'
    )

    def law(self, inertia: float) -> DragLaw | None:
        """Return this kind's own torque over I, if any.

        Args:
            inertia: I of the wheel [kg m2].
        """
        return None

    def thinned(self, factor: float) -> DragKind:
        """Return the drag with c₁ times a factor."""
        return self.model_copy(update={'viscous': self.viscous * factor})

    @property
    def is_linear(self) -> bool:
        """Whether the torque is c₁θ̇ alone, which has closed forms."""
        return not (self.quadratic or self.coulomb) and self.law(1.0) is None

    @property
    def is_zero(self) -> bool:
        """Whether the torque is 0."""
        return self.is_linear and not self.viscous

    def torque(self, rate: FloatArray) -> FloatArray:
        """Return the torque against the motion at θ̇ ≥ 0 [N m]."""
        torque = self.viscous * rate + self.quadratic * rate * rate + self.coulomb
        law = self.law(1.0)
        return torque if law is None else torque + law.torque(rate, 1.0)

    def damping(self, rate: float) -> float:
        """Return P′/θ̇ₘ [N m s], P the mean power dissipated in a harmonic swing.

        P = c₁θ̇ₘ²/2 + 4c₂θ̇ₘ³/3π + 2c₀θ̇ₘ/π + the law's part by quadrature.

        Args:
            rate: θ̇ₘ, the greatest angular velocity of the swing [rad/s].
        """
        analytic = self.viscous + 4.0 / math.pi * self.quadratic * rate
        analytic += 2.0 / math.pi * self.coulomb / rate
        law = self.law(1.0)
        if law is None:
            return analytic
        nodes, weights = gauss_rule()
        sine = np.sin(0.25 * math.pi * (1.0 + nodes))

        def power(greatest: float) -> float:
            along = greatest * sine
            return float(0.5 * weights @ (law.torque(along, 1.0) * along))

        # the difference errs by about the square of this, and by rounding over this
        nearby = 1e-4 * rate
        return analytic + (power(rate + nearby) - power(rate - nearby)) / (2.0 * nearby * rate)

    def with_friction(self, friction: float) -> DragKind:
        """Return the drag with additional friction [N m]."""
        return self.model_copy(update={'coulomb': self.coulomb + friction})


# -----------------------------------------------------------------------------
# The base of all kinds of escapement.

ESCAPEMENTS = 'tauto_core.machines.escapements'


class Rest(Section):
    """Friction and recoil of the tooth on a pallet between impulses (escapement.md)."""

    friction: NonNegative = Field(
        default=0.0, description='friction torque against the motion [N m]'
    )
    recoil: NonNegative = Field(
        default=0.0,
        description='constant torque against the direction of the last impulse, '
        'until the next [N m]',
    )


class ImpulseDecline(NamedTuple):
    """The decline of the impulses while the spring or weight that drives them runs down.

    Impulse k has the energy·(1 + fall·(½ − u)), u = (k mod n + ½)/n. The mean of the n impulses
    of a winding is the energy itself.

    Attributes:
        fall: fall of the energy from the first to the last impulse of a winding, over its mean.
        impulses: number n of impulses between two windings.
    """

    fall: float
    impulses: int

    def strength(self, count: int) -> float:
        """Return the next impulse's energy relative to the mean, after `count` impulses."""
        return 1.0 + self.fall * (0.5 - (count % self.impulses + 0.5) / self.impulses)


class Train(Section):
    """A driving train that weakens between windings."""

    fall: Annotated[float, Strict(), Field(ge=0.0, le=1.0)] = Field(
        description='fall of the driving energy from one winding to just before the next, '
        'relative to its mean, 0 to 1'
    )
    impulses: Annotated[int, Strict(), Field(ge=1, le=10**9)] = Field(
        description='impulses of the escapement between two windings, 1 to 1e9'
    )


class EscapementKind(Kind):
    """Impulse once a beat, at angle · sgn θ̇ (positive: after the middle).

    Each kind is a module of `machines/escapements` with a `KIND`.
    """

    kind: str
    energy: NonNegative = Field(
        description='energy given each beat [J], 0 only if recoil drives the wheel'
    )
    angle: Number = Field(
        default=0.0,
        description='angle of the wheel in its case at the '
        'impulse [rad], positive after the middle',
    )
    rest: Rest | None = Field(default=None, description='mapping: friction, recoil')

    @property
    def ebb(self) -> ImpulseDecline | None:
        """Decline of the impulses between windings, if any."""
        return None

    @property
    def recoil(self) -> float:
        """Constant torque against the direction of the last impulse, until the next [N m]."""
        return 0.0 if self.rest is None else self.rest.recoil

    @property
    def friction(self) -> float:
        """Friction torque against the motion [N m]."""
        return 0.0 if self.rest is None else self.rest.friction

    @property
    def work(self) -> float:
        """Mean energy given in a full swing [J]: two impulses and the loop of the recoil."""
        return 2.0 * self.energy + 4.0 * self.recoil * self.angle

    def problems(self) -> Iterator[Problem]:
        """Yield the contradictions between its keys."""
        return wrong(
            (
                self.energy == 0.0 and not self.work > 0.0,
                'escapement.energy',
                0.0,
                'must be greater than 0 J unless recoil drives the wheel, which needs '
                'escapement.rest.recoil and escapement.angle greater than 0',
                'Give the impulse an energy, or both recoil and a positive angle.',
            )
        )


# -----------------------------------------------------------------------------
# The base of all kinds of power.

POWERS = 'tauto_core.machines.powers'


class PowerKind(Kind):
    """The pull of the thread. Each kind is a module of `machines/powers` with a `KIND`.

    Attributes:
        words: name of the power in messages.
    """

    words: ClassVar[str]

    kind: str

    @property
    @abstractmethod
    def pull(self) -> Pull:
        """The pull in the thread."""

    def problems(self) -> Iterator[Problem]:
        """Yield the contradictions between its keys."""
        return iter(())

    @property
    def acts_as(self) -> str:
        """The effect that a cam has to correct: `weight`, `spring`, or `force` for no effect."""
        pull = self.pull
        if pull.carried_mass:
            return 'weight'
        return 'spring' if pull.stiffness else 'force'


class Imbalance(NamedTuple):
    """A wheel whose centre of mass is off its axle.

    Its torque is −m d g_eff sin(ψ − β + φ₀), ψ the wheel's absolute angle and β the direction of
    the apparent vertical (machine_at_sea.4).

    Attributes:
        moment: m d, mass of the wheel times the distance [kg m].
        direction: φ₀, direction of the centre of mass from straight down, at rest [rad].
    """

    moment: float
    direction: float
