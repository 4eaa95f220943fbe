"""From a scene to the machine in it."""

from __future__ import annotations

from typing import TypeAlias

from tauto_core.curves import make_cam
from tauto_core.machines.hanging import HangingMachine
from tauto_core.machines.lever import LeverMachine
from tauto_core.machines.lever_geometry import LeverGeometry
from tauto_core.machines.trochlea import Machine
from tauto_core.scene.errors import SceneError
from tauto_core.scene.models import (
    ForcePower,
    HangingThread,
    InvoluteCam,
    LeverThread,
    Scene,
    SpringPower,
    StillShip,
    VerticalThread,
    WeightPower,
)

AnyMachine: TypeAlias = Machine | LeverMachine | HangingMachine


def compile_machine(scene: Scene) -> AnyMachine:
    """Return the trochlea of a scene in numbers.

    The release is checked here where it fixes the angle at the cam: on a still ship, and at sea
    if the thread's neutral line turns with the case. A thread that follows the apparent vertical
    at sea is left to those who know the motion.

    Raises:
        SceneError: a cam, thread or table that can't be used, or a release beyond the cam.
    """
    machine = _of_thread(scene)
    # an angle that the tilt of the apparent vertical does not change
    fixed = machine.felt_angle(0.0, 1.0) == 0.0
    if isinstance(scene.ship, StillShip) or fixed:
        _check_release(scene, machine)
    return machine


def _of_thread(scene: Scene) -> AnyMachine:
    trochlea = scene.trochlea
    match trochlea.thread, trochlea.cam, trochlea.power:
        case LeverThread() as thread, InvoluteCam(base_radius=radius), WeightPower(mass=mass):
            return LeverMachine(
                inertia=trochlea.inertia,
                mass=mass,
                weight_arm=thread.weight_arm,
                lever_inertia=thread.inertia,
                geometry=LeverGeometry(radius, thread.arm, thread.length),
                gravity=scene.gravity,
                drag=scene.drag,
                escapement=scene.escapement,
                release_angle=trochlea.release_angle,
            )
        case HangingThread(length=length), InvoluteCam(base_radius=radius), WeightPower(mass=mass):
            return HangingMachine(
                inertia=trochlea.inertia,
                mass=mass,
                base_radius=radius,
                length=length,
                gravity=scene.gravity,
                drag=scene.drag,
                escapement=scene.escapement,
                release_angle=trochlea.release_angle,
            )
        case _:
            return compile_ideal(scene)


def compile_ideal(scene: Scene) -> Machine:
    """Return the trochlea of a scene whose thread is ideal, vertical or through a hole.

    The release is not checked.

    Raises:
        SceneError: a cam, thread or table that can't be used.
    """
    trochlea = scene.trochlea
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
        cam=make_cam(trochlea),
        follows_apparent_vertical=pulling > 0.0 and isinstance(trochlea.thread, VerticalThread),
        drag=scene.drag,
        escapement=scene.escapement,
        release_angle=trochlea.release_angle,
    )


def _check_release(scene: Scene, machine: AnyMachine) -> None:
    edge = machine.range_rad
    if abs(machine.release_angle) <= edge:
        return
    if isinstance(machine, Machine):
        limit, remedy = 'the cam, whose range is', 'give the cam a wider range'
    else:
        limit, remedy = 'what the thread allows,', 'give it a longer thread'
    raise SceneError(
        scene.name,
        'trochlea.release_angle',
        machine.release_angle,
        f'beyond {limit} ±{edge!r} rad',
        f'Release the wheel nearer to rest or {remedy}.',
    )
