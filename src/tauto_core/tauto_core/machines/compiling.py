"""The machine of a scene as numbers, its period against amplitude, its amplitude."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Protocol, TypeAlias, cast

import numpy as np

from tauto_core.curves.numerics import QuadratureError, root_of
from tauto_core.machines.axle_pendulum import AxleClock, AxleRegulator
from tauto_core.machines.parts import (
    DragKind,
    EscapementKind,
    Isochronism,
    OtherRegulator,
    checked_amplitudes,
    rate_s_per_day,
)
from tauto_core.machines.sections import FluidTautochroneRegulator, Trochlea
from tauto_core.machines.threads.hanging import HangingMachine, SwingError
from tauto_core.machines.threads.lever import LeverMachine
from tauto_core.machines.trochlea import Machine, SlackThreadError
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import ABSENT, CamRangeError, SceneError, naming

if TYPE_CHECKING:
    from tauto_core.machines.fluid_pendulum import DescentIsochronism


AnyMachine: TypeAlias = Machine | LeverMachine | HangingMachine


def isochronism(
    machine: AnyMachine | AxleClock,
    amplitudes: Iterable[float],
    nominal_period_s: float | None = None,
) -> Isochronism:
    """Return period and rate of free swings on land, without drag and escapement.

    Amplitudes [rad] are > 0, within the machine's range and at most 1e6. The nominal period, by
    which the dial advances in a full swing, defaults to the small-amplitude one. UsageError: no
    amplitude, or one out of range. SlackThreadError: a swing in which the thread goes slack.
    """
    # an angle of 150,000 turns is rounded enough to affect the clock
    edge = min(machine.range_rad, 1e6)
    sizes = checked_amplitudes(
        amplitudes, edge, 'rad', 'in radians', 'within the range of the machine'
    )
    nominal = machine.small_period if nominal_period_s is None else nominal_period_s
    period = np.array([machine.period(amplitude) for amplitude in sizes])
    rate = np.array([rate_s_per_day(seconds, nominal) for seconds in period.tolist()])
    return Isochronism(nominal, np.array(sizes), period, rate)


class SceneParts(Protocol):
    """The parts of a scene from which a machine is made."""

    @property
    def name(self) -> str:
        """Name of the scene, for error messages."""

    @property
    def g(self) -> float:
        """Acceleration of gravity at the start [m/s2]."""

    @property
    def trochlea(self) -> Trochlea | None:
        """The wheel with its cam, thread and power."""

    @property
    def regulator(self) -> AxleRegulator | FluidTautochroneRegulator | None:
        """The oscillator in place of a trochlea."""

    @property
    def drag(self) -> DragKind | None:
        """Torques against the motion in the case."""

    @property
    def escapement(self) -> EscapementKind | None:
        """Impulses."""

    @property
    def air(self) -> object | None:
        """The air. Without it the clock stays at the temperature of its parameters."""

    @property
    def lies_still(self) -> bool:
        """Whether the ship does not move."""


def compile_machine(scene: SceneParts) -> AnyMachine | OtherRegulator:
    """Return the regulator of a scene as numbers: its trochlea, or its `regulator`.

    SceneError: a machine that cannot be built, or a release beyond its range.
    """
    if scene.regulator is not None:
        return scene.regulator.machine(scene.name, scene.g)
    return compile_trochlea(scene)


def compile_trochlea(scene: SceneParts) -> AnyMachine:
    """Return the trochlea of a scene as numbers, with any kind of thread.

    The release is checked here if it alone determines the angle of the cam: on a still ship, or
    if the thread's neutral line turns with the case. If the thread follows the apparent vertical
    at sea, it is checked with the ship's motion. SceneError: a machine that cannot be built, or a
    release beyond its range.
    """
    if scene.trochlea is None:
        raise SceneError(scene.name, 'trochlea', ABSENT, 'is missing', 'Give one, or a regulator.')
    trochlea = scene.trochlea
    with naming(scene.name, 'trochlea'):
        parts = trochlea.parts(scene.g, scene.drag, scene.escapement)
        machine = cast(AnyMachine, trochlea.thread.machine(parts))
    if trochlea.slack == 'stop':
        machine = replace(machine, stops_when_slack=True)
    if scene.air is None:
        machine = replace(machine, heat=replace(machine.heat, varies=False))
    # else the tilt of the apparent vertical changes the angle
    is_known = scene.lies_still or machine.sensed_angle(0.0, 1.0) == 0.0
    released = machine.release_angle
    if is_known and not abs(released) <= (edge := machine.range_rad):
        raise SceneError(
            scene.name,
            'trochlea.release_angle',
            released,
            f'is beyond {machine.limited_by} ±{edge!r} rad',
            f'Release the wheel nearer to rest{machine.widening}.',
        )
    return machine


def free_swings(
    machine: AnyMachine | OtherRegulator, amplitudes: Iterable[float], nominal_period_s: float
) -> Isochronism | DescentIsochronism:
    """Return period and rate of free swings on land, at amplitudes in [rad], or [m] in a fluid.

    UsageError: see `isochronism` and `descent_isochronism`.
    """
    if isinstance(machine, AxleClock) or not isinstance(machine, OtherRegulator):
        return isochronism(machine, amplitudes, nominal_period_s)
    from tauto_core.machines.fluid_pendulum import FluidPendulum, descent_isochronism

    return descent_isochronism(cast(FluidPendulum, machine), amplitudes, nominal_period_s)


# -----------------------------------------------------------------------------
# The amplitude of a wheel, from its angle and rate at any instant.

_ROUNDING = 4.0 * np.finfo(float).eps


def swing_energy(
    machine: AnyMachine | OtherRegulator, angle: FloatArray, rate: FloatArray
) -> FloatArray:
    """Return the energy V(θ) + ½ M θ̇² of a swing on land [J], (n,), from angles and rates, (n,).

    A hanging thread has its energy of small swings. Angles are clipped to the range.
    """
    if isinstance(machine, OtherRegulator):
        return machine.swing_energy(angle, rate)
    if isinstance(machine, HangingMachine):
        small = (machine.frequency * angle) ** 2 + rate * rate
        return np.asarray(0.5 * machine.inertia * small)
    if isinstance(machine, LeverMachine):
        angle = np.clip(angle, *machine.sides)
        return machine.potential(angle) + 0.5 * machine.mass_at(angle) * rate * rate
    angle = np.clip(angle, -machine.range_rad, machine.range_rad)
    return machine.potential(angle) + 0.5 * machine.mass(angle) * rate * rate


def recoil_energy(machine: AnyMachine, angle: FloatArray, rate: FloatArray) -> FloatArray:
    """Return R s θ [J], (n,), the recoil's part of the conserved energy (escapement.md).

    The sign s of the last impulse assumes that the swing reaches both impulses: sgn θ̇ beyond the
    angle of the impulse, −sgn θ̇ before it.
    """
    escapement = machine.escapement
    if escapement is None or escapement.recoil == 0.0:
        return np.zeros_like(angle)
    way = np.where(rate < 0.0, -1.0, 1.0)
    struck = np.where(way * angle > escapement.angle, way, -way)
    return escapement.recoil * struck * angle


def amplitude_of(machine: AnyMachine, energy: float) -> float:
    """Return the amplitude A on land [rad] of a swing of the energy V(A) + R A [J].

    The energy is `swing_energy` plus `recoil_energy`, at least 0. A is at most the end of the
    range. For a lever it is the turning point on the positive side.
    """
    energy = max(energy, 0.0)
    if isinstance(machine, HangingMachine):
        free = math.sqrt(2.0 * energy / machine.inertia) / machine.frequency
    else:
        free = machine.angle_of_potential(energy)
    recoil = 0.0 if machine.escapement is None else machine.escapement.recoil

    def above(amplitude: float) -> float:
        at_rest = swing_energy(machine, np.array([amplitude]), np.zeros(1))
        return float(at_rest[0]) + recoil * amplitude - energy

    if recoil == 0.0 or above(free) <= 0.0:
        return free
    return root_of(above, 0.0, free, _ROUNDING * free)


def nearest_period(machine: AnyMachine, amplitude: float) -> float:
    """Return the period on land of free swings of an amplitude [s], or of a smaller one.

    Some amplitudes exist only at sea. The amplitude is then halved until a swing exists. Half the
    amplitude has at least half the period, since a period grows at most in proportion to the
    amplitude, when only the weight has inertia.
    """
    while amplitude > 0.0:
        try:
            return machine.period(amplitude)
        except (CamRangeError, SlackThreadError, SwingError, QuadratureError):
            amplitude *= 0.5
    return machine.small_period
