"""From a scene to the machine in it."""

from __future__ import annotations

from tauto_core.curves import make_cam
from tauto_core.machines.fluid_pendulum import FluidPendulum, compile_fluid_pendulum
from tauto_core.machines.remedies import wider_range
from tauto_core.machines.trochlea import Machine
from tauto_core.scene.errors import ABSENT, SceneError, naming
from tauto_core.scene.models import (
    ForcePower,
    Scene,
    SpringPower,
    StillShip,
    Trochlea,
    VerticalThread,
    WeightPower,
)


def compile_machine(scene: Scene) -> Machine | FluidPendulum:
    """Return the regulator of a scene in numbers: its trochlea, or the body in its fluid.

    Raises:
        SceneError: a machine that cannot be built, or a release beyond its range.
    """
    if scene.regulator is not None:
        return compile_fluid_pendulum(scene, scene.regulator)
    if scene.trochlea is not None:
        return _compile_trochlea(scene, scene.trochlea)
    raise SceneError(scene.name, 'trochlea', ABSENT, 'is missing', 'Give trochlea or regulator.')


def _compile_trochlea(scene: Scene, trochlea: Trochlea) -> Machine:
    """Return the trochlea of a scene in numbers.

    The release is checked here where it fixes the angle at the cam: on a still ship, and at sea
    if the thread's neutral line turns with the case. A thread that follows the apparent vertical
    at sea is left to those who know the motion.

    Raises:
        SceneError: a cam, thread or table that can't be used, or a release beyond the cam.
    """
    carried = pulling = force = stiffness = 0.0
    match trochlea.power:
        case ForcePower():
            force = trochlea.power.force
        case SpringPower():
            force, stiffness = trochlea.power.force, trochlea.power.stiffness
        case WeightPower():
            pulling = trochlea.power.mass
            carried = 0.0 if trochlea.power.massless else pulling
    with naming(scene.name, 'trochlea'):
        cam = make_cam(trochlea, scene.gravity)
    machine = Machine(
        inertia=trochlea.inertia,
        carried_mass=carried,
        pulling_mass=pulling,
        force=force,
        stiffness=stiffness,
        gravity=scene.gravity,
        cam=cam,
        follows_apparent_vertical=pulling > 0.0 and isinstance(trochlea.thread, VerticalThread),
        drag=scene.drag,
        escapement=scene.escapement,
        release_angle=trochlea.release_angle,
    )
    if isinstance(scene.ship, StillShip) or not machine.follows_apparent_vertical:
        _check_release(scene, machine)
    return machine


def _check_release(scene: Scene, machine: Machine) -> None:
    edge = machine.cam.range_rad
    if not abs(machine.release_angle) <= edge:
        raise SceneError(
            scene.name,
            'trochlea.release_angle',
            machine.release_angle,
            f'beyond the cam, whose range is ±{edge!r} rad',
            f'Release the wheel nearer to rest{wider_range(machine)}.',
        )
