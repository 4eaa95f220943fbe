"""From a scene to the machine in it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeAlias

from tauto_core.curves import make_cam
from tauto_core.machines.lever import LeverMachine
from tauto_core.machines.lever_corrected import CorrectedLeverGeometry
from tauto_core.machines.lever_geometry import LeverGeometry
from tauto_core.machines.trochlea import Machine
from tauto_core.scene.errors import ABSENT, SceneError, naming
from tauto_core.scene.models import Scene
from tauto_core.scene.regulators import (
    Cam,
    Drag,
    ForcePower,
    HangingThread,
    InvoluteCam,
    LeverCorrectedCam,
    LeverThread,
    SpringPower,
    Trochlea,
    VerticalThread,
    WeightPower,
)
from tauto_core.scene.ships import StillShip

if TYPE_CHECKING:
    from tauto_core.machines.fluid_pendulum import FluidPendulum
    from tauto_core.machines.hanging import HangingMachine

AnyMachine: TypeAlias = 'Machine | LeverMachine | HangingMachine'


def compile_machine(scene: Scene) -> AnyMachine | FluidPendulum:
    """Return the regulator of a scene in numbers: its trochlea, or the body in its fluid.

    Raises:
        SceneError: a machine that cannot be built, or a release beyond its range.
    """
    if scene.regulator is not None:
        from tauto_core.machines.fluid_pendulum import compile_fluid_pendulum

        return compile_fluid_pendulum(scene, scene.regulator)
    return compile_trochlea(scene)


def compile_trochlea(scene: Scene) -> AnyMachine:
    """Return the trochlea of a scene in numbers, whatever its thread.

    The release is checked here where it fixes the angle at the cam: on a still ship, and at sea
    if the thread's neutral line turns with the case. A thread that follows the apparent vertical
    at sea is left to those who know the motion.

    Raises:
        SceneError: a machine that cannot be built, or a release beyond its range.
    """
    machine = _of_thread(scene)
    # an angle that the tilt of the apparent vertical does not change
    fixed = machine.felt_angle(0.0, 1.0) == 0.0
    if isinstance(scene.ship, StillShip) or fixed:
        _check_release(scene, machine)
    return machine


def _drag(scene: Scene) -> Drag | None:
    """Return the drag, and with it the friction of the teeth that rest."""
    friction = 0.0 if scene.escapement is None else scene.escapement.friction
    if friction == 0.0:
        return scene.drag
    drag = scene.drag or Drag()
    return Drag(viscous=drag.viscous, quadratic=drag.quadratic, coulomb=drag.coulomb + friction)


def _trochlea(scene: Scene) -> Trochlea:
    if scene.trochlea is None:
        raise SceneError(scene.name, 'trochlea', ABSENT, 'is missing', 'Give one, or a regulator.')
    return scene.trochlea


def _of_thread(scene: Scene) -> AnyMachine:
    trochlea = _trochlea(scene)
    match trochlea.thread, trochlea.cam, trochlea.power:
        case LeverThread() as thread, cam, WeightPower(mass=mass):
            return LeverMachine(
                inertia=trochlea.inertia,
                mass=mass,
                weight_arm=thread.weight_arm,
                lever_inertia=thread.inertia,
                geometry=_lever_geometry(scene, trochlea, thread, cam, mass),
                gravity=scene.gravity,
                drag=_drag(scene),
                escapement=scene.escapement,
                release_angle=trochlea.release_angle,
            )
        case HangingThread(length=length), InvoluteCam(base_radius=radius), WeightPower(mass=mass):
            from tauto_core.machines.hanging import HangingMachine

            return HangingMachine(
                inertia=trochlea.inertia,
                mass=mass,
                base_radius=radius,
                length=length,
                gravity=scene.gravity,
                drag=_drag(scene),
                escapement=scene.escapement,
                release_angle=trochlea.release_angle,
            )
        case _:
            return compile_ideal(scene)


def _lever_geometry(
    scene: Scene, trochlea: Trochlea, thread: LeverThread, cam: Cam, mass: float
) -> LeverGeometry | CorrectedLeverGeometry:
    match cam:
        case InvoluteCam(base_radius=radius):
            return LeverGeometry(radius, thread.arm, thread.length)
        case LeverCorrectedCam(period=period):
            return CorrectedLeverGeometry(
                inertia=trochlea.inertia,
                frequency=math.tau / period,
                weight_torque=mass * scene.gravity * thread.weight_arm,
                turned_inertia=mass * thread.weight_arm**2 + thread.inertia,
                arm=thread.arm,
                length=thread.length,
            )
        case _:
            raise SceneError(
                scene.name,
                'trochlea.cam.kind',
                cam.kind,
                'does not go with a lever',
                'Use cam kind involute or lever_corrected.',
            )


def compile_ideal(scene: Scene) -> Machine:
    """Return the trochlea of a scene whose thread is ideal, vertical or through a hole.

    The release is not checked.

    Raises:
        SceneError: a cam, thread or table that can't be used.
    """
    trochlea = _trochlea(scene)
    with naming(scene.name, 'trochlea'):
        cam = make_cam(trochlea, scene.gravity)
    carried = pulling = force = stiffness = 0.0
    match trochlea.power:
        case ForcePower():
            force = trochlea.power.force
        case SpringPower():
            force, stiffness = trochlea.power.force, trochlea.power.stiffness
        case WeightPower():
            pulling = trochlea.power.mass
            carried = 0.0 if trochlea.power.massless else pulling
    return Machine(
        inertia=trochlea.inertia,
        carried_mass=carried,
        pulling_mass=pulling,
        force=force,
        stiffness=stiffness,
        gravity=scene.gravity,
        cam=cam,
        follows_apparent_vertical=pulling > 0.0 and isinstance(trochlea.thread, VerticalThread),
        drag=_drag(scene),
        escapement=scene.escapement,
        release_angle=trochlea.release_angle,
    )


def _check_release(scene: Scene, machine: AnyMachine) -> None:
    edge = machine.range_rad
    if abs(machine.release_angle) <= edge:
        return
    from tauto_core.machines.remedies import wider_range

    limit = (
        'the cam, whose range is' if isinstance(machine, Machine) else 'what the thread allows,'
    )
    raise SceneError(
        scene.name,
        'trochlea.release_angle',
        machine.release_angle,
        f'beyond {limit} ±{edge!r} rad',
        f'Release the wheel nearer to rest{wider_range(machine, abs(machine.release_angle))}.',
    )
