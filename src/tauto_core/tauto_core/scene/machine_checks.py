"""Rules between the keys of the regulator: cam, thread and power, or body and fluid."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from tauto_core.scene.errors import ABSENT, Problem

if TYPE_CHECKING:
    from tauto_core.scene.models import Scene
    from tauto_core.scene.regulators import Escapement, FluidTautochroneRegulator, Trochlea

THREADS_OF_CAM = {
    'involute': ('vertical', 'lever', 'hanging'),
    'hole': ('hole',),
    'circular_arc': ('vertical',),
    # A lever law makes a cam for either thread; a hole only turns the normal by arcsin(t/a).
    'table': ('vertical', 'hole'),
    'weight_corrected': ('vertical', 'hole'),
    'spring_corrected': ('vertical', 'hole'),
    'lever_corrected': ('lever',),
}
# What a corrected cam corrects.
POWER_OF_CAM = {'weight_corrected': 'weight', 'spring_corrected': 'spring'}
# What lifts a weight whose inertia is part of the motion.
REAL_THREADS = ('lever', 'hanging')


def regulator_problems(scene: Scene) -> Iterator[Problem]:
    """Yield what is wrong with a scene's trochlea, or what stands in its place."""
    if scene.regulator is not None:
        yield from _in_fluid(scene, scene.regulator)
    if scene.trochlea is not None:
        yield from _machine(scene, scene.trochlea)
    if scene.escapement is not None:
        yield from _escapement(scene.escapement)
    if scene.trochlea is None and scene.regulator is None:
        yield Problem(
            'trochlea',
            ABSENT,
            'is missing, and there is no regulator in its place',
            'Write `trochlea: …`, mapping: inertia, cam, thread, power, release_angle; or '
            '`regulator: …`, mapping with `kind`.',
        )


def _in_fluid(scene: Scene, regulator: FluidTautochroneRegulator) -> Iterator[Problem]:
    given = {
        'trochlea': 'a scene has one regulator',
        'drag': 'the fluid is the drag',
        'escapement': 'nothing drives a body in a fluid',
        'suspension': "in Euler's equations curve and fluid are at rest",
    }
    for key, why in given.items():
        if getattr(scene, key, None) is not None:
            remedy = f'Leave out {key}, or take a trochlea instead of the regulator.'
            yield Problem(key, ABSENT, f'does not go with regulator: {why}', remedy)
    if scene.ship.kind != 'still':
        yield Problem(
            'ship.kind',
            scene.ship.kind,
            "does not go with regulator: in Euler's equations curve and fluid are at rest",
            'Use ship kind still.',
        )
    if regulator.release_arc == 0.0:
        yield Problem(
            'regulator.release_arc',
            0.0,
            'leaves the body at rest for ever',
            'Release it at an arc other than 0 m.',
        )


def _machine(scene: Scene, trochlea: Trochlea) -> Iterator[Problem]:
    cam, thread = trochlea.cam.kind, trochlea.thread.kind
    fitting = THREADS_OF_CAM[cam]
    if thread not in fitting:
        cams = ', '.join(kind for kind, threads in THREADS_OF_CAM.items() if thread in threads)
        yield Problem(
            'trochlea.thread.kind',
            thread,
            f'does not go with trochlea.cam.kind {cam}',
            f'Use thread kind {" or ".join(fitting)}, or a cam of kind {cams}.',
        )
    yield from _corrected(scene, trochlea)
    if thread in REAL_THREADS:
        yield from _real_thread(scene, trochlea)
    if scene.ship.kind == 'still' and trochlea.release_angle == 0.0:
        yield Problem(
            'trochlea.release_angle',
            0.0,
            'leaves the wheel at rest for ever on a ship that lies still',
            'Release it at an angle other than 0 rad.',
        )


def _corrected(scene: Scene, trochlea: Trochlea) -> Iterator[Problem]:
    """Yield what is wrong with the power of a cam that is made for one kind of it."""
    cam, power = trochlea.cam, trochlea.power
    if cam.kind not in POWER_OF_CAM or not hasattr(cam, 'period'):
        return
    weightless = power.kind == 'weight' and power.massless
    if power.kind == POWER_OF_CAM[cam.kind] and not weightless:
        return
    pull = power.mass * scene.gravity if power.kind == 'weight' else power.force
    omega = math.tau / cam.period
    rate = trochlea.inertia * omega * omega / pull
    plain = (
        f'cam {{kind: involute, base_radius: {rate:.6g}}}'
        if trochlea.thread.kind == 'vertical'
        else f'cam {{kind: hole, lever_rate: {rate:.6g}}}'
    )
    others = {
        'weight': 'a weight whose inertia counts needs cam kind weight_corrected',
        'spring': 'a spring needs cam kind spring_corrected',
        'force': f'a pull without inertia or stiffness needs {plain}',
    }
    yield Problem(
        'trochlea.power.massless' if weightless else 'trochlea.power.kind',
        True if weightless else power.kind,
        f'does not go with trochlea.cam.kind {cam.kind}, which is made for power kind '
        f'{POWER_OF_CAM[cam.kind]}',
        f'For the period of {cam.period!r} s {others["force" if weightless else power.kind]}.',
    )


def _real_thread(scene: Scene, trochlea: Trochlea) -> Iterator[Problem]:
    thread, power = trochlea.thread.kind, trochlea.power
    if power.kind != 'weight':
        yield Problem(
            'trochlea.power.kind',
            power.kind,
            f'does not go with trochlea.thread.kind {thread}, which carries a weight',
            'Use power kind weight, or thread kind vertical.',
        )
    elif power.massless:
        yield Problem(
            'trochlea.power.massless',
            True,
            f'does not go with trochlea.thread.kind {thread}, where the weight moves the thread',
            'Leave it out, or use thread kind vertical.',
        )
    frictions = {
        'drag.coulomb': 0.0 if scene.drag is None else scene.drag.coulomb,
        'escapement.rest.friction': 0.0 if scene.escapement is None else scene.escapement.friction,
    }
    for key, friction in frictions.items():
        if friction > 0.0:
            yield Problem(
                key,
                friction,
                f'does not go with trochlea.thread.kind {thread}',
                'Use viscous or quadratic drag, or thread kind vertical or hole.',
            )


def _escapement(escapement: Escapement) -> Iterator[Problem]:
    if escapement.energy == 0.0 and not escapement.work > 0.0:
        yield Problem(
            'escapement.energy',
            0.0,
            'must be greater than 0 J: nothing else drives the wheel, since recoil does so only '
            'where it is held past the middle (escapement.rest.recoil and escapement.angle '
            'greater than 0)',
            'Give the impulse an energy, or both recoil and a positive angle.',
        )
