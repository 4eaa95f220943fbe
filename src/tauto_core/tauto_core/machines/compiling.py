"""The machine of a scene, as numbers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Protocol, TypeAlias, cast

from tauto_core.machines.drag import Drag
from tauto_core.machines.escapement import EscapementKind
from tauto_core.machines.fluid_regulator import (
    FluidTautochroneRegulator,
    compile_fluid_pendulum,
)
from tauto_core.machines.isochronism import Isochronism, isochronism
from tauto_core.machines.sections import Trochlea
from tauto_core.machines.threads.hanging import HangingMachine
from tauto_core.machines.threads.lever import LeverMachine
from tauto_core.machines.trochlea import Machine
from tauto_core.scene.errors import ABSENT, SceneError, naming

if TYPE_CHECKING:
    from tauto_core.machines.fluid_pendulum import DescentIsochronism, FluidPendulum

AnyMachine: TypeAlias = Machine | LeverMachine | HangingMachine


class Parts(Protocol):
    """The parts of a scene from which a machine is made."""

    @property
    def name(self) -> str:
        """Name of the scene, for error messages."""
        ...

    @property
    def gravity(self) -> float:
        """g [m/s2]."""
        ...

    @property
    def trochlea(self) -> Trochlea | None:
        """The wheel with its cam, thread and power."""
        ...

    @property
    def regulator(self) -> FluidTautochroneRegulator | None:
        """The oscillator in place of a trochlea."""
        ...

    @property
    def drag(self) -> Drag | None:
        """Torques against the motion in the case."""
        ...

    @property
    def escapement(self) -> EscapementKind | None:
        """Impulses."""
        ...

    @property
    def lies_still(self) -> bool:
        """Whether the ship does not move."""
        ...


def compile_machine(scene: Parts) -> AnyMachine | FluidPendulum:
    """Return the regulator of a scene as numbers: its trochlea, or the body in its fluid.

    Raises:
        SceneError: a machine that cannot be built, or a release beyond its range.
    """
    if scene.regulator is not None:
        return compile_fluid_pendulum(scene.name, scene.gravity, scene.regulator)
    return compile_trochlea(scene)


def compile_trochlea(scene: Parts) -> AnyMachine:
    """Return the trochlea of a scene as numbers, with any kind of thread.

    The release is checked here where it alone determines the angle of the cam: on a still ship,
    and at sea if the thread's neutral line turns with the case. For a thread that follows the
    apparent vertical it is checked when the motion is known.

    Raises:
        SceneError: a machine that cannot be built, or a release beyond its range.
    """
    trochlea = _trochlea(scene)
    with naming(scene.name, 'trochlea'):
        parts = trochlea.parts(scene.gravity, scene.drag, scene.escapement)
        machine = cast(AnyMachine, trochlea.thread.machine(parts))
    # the tilt of the apparent vertical does not change the angle
    if scene.lies_still or machine.felt_angle(0.0, 1.0) == 0.0:
        _check_release(scene.name, machine)
    return machine


def free_swings(
    scene: Parts, amplitudes: Iterable[float], nominal_period_s: float | None = None
) -> Isochronism | DescentIsochronism:
    """Return period and rate of free swings of a scene's regulator on land.

    Args:
        scene: the scene; its drag and escapement are ignored.
        amplitudes: [rad]; of a body in a fluid arcs [m].
        nominal_period_s: as for `isochronism`.

    Raises:
        SceneError: a machine that cannot be built.
        UsageError: see `isochronism` and `descent_isochronism`.
    """
    if scene.regulator is None:
        return isochronism(compile_trochlea(scene), amplitudes, nominal_period_s)
    from tauto_core.machines.fluid_pendulum import descent_isochronism

    pendulum = compile_fluid_pendulum(scene.name, scene.gravity, scene.regulator)
    return descent_isochronism(pendulum, amplitudes, nominal_period_s)


def compile_ideal(scene: Parts) -> Machine:
    """Return the trochlea of a scene as if its thread were ideal, vertical or through a hole.

    The release is not checked.

    Raises:
        SceneError: a cam, thread or table that cannot be used.
    """
    trochlea = _trochlea(scene)
    with naming(scene.name, 'trochlea'):
        return trochlea.thread.ideal(trochlea.parts(scene.gravity, scene.drag, scene.escapement))


def _trochlea(scene: Parts) -> Trochlea:
    if scene.trochlea is None:
        raise SceneError(scene.name, 'trochlea', ABSENT, 'is missing', 'Give one, or a regulator.')
    return scene.trochlea


def _check_release(name: str, machine: AnyMachine) -> None:
    edge = machine.range_rad
    if abs(machine.release_angle) <= edge:
        return
    raise SceneError(
        name,
        'trochlea.release_angle',
        machine.release_angle,
        f'beyond {machine.limited_by} ±{edge!r} rad',
        f'Release the wheel nearer to rest{machine.wider_range(abs(machine.release_angle))}.',
    )
