"""The default extent of a cheek in drawings and files."""

from __future__ import annotations

import math

from tauto_core.curves.drawing import cheeks_meet_rad
from tauto_core.machines import (
    AnyMachine,
    HangingMachine,
    NoSteadySwing,
    compile_trochlea,
    steady_swing,
)
from tauto_core.scene import Scene

MARGIN = 1.5
"""Extent over swing; a ship's motion and an escapement may increase the swing."""


def cam_extent(scene: Scene) -> float:
    """Return the largest angle of the wheel for which a scene's cheeks are drawn [rad].

    The extent is one and a half times the swing of the wheel, rounded to two digits, but neither
    beyond the range of the cam nor beyond the angle at which the two cheeks would meet. The swing
    is the angle of release or, where an escapement drives the wheel, its steady amplitude on land,
    whichever is larger.

    Args:
        scene: a scene whose machine has a trochlea.

    Raises:
        SceneError: a machine that cannot be built.
    """
    machine = compile_trochlea(scene)
    assert scene.trochlea is not None
    ends = [machine.range_rad, math.tau]
    if scene.trochlea.cam.kind != 'lever_corrected':
        curve = scene.trochlea.made_cam(scene.gravity)
        ends += [curve.drawn_rad, cheeks_meet_rad(curve)]
    swing = _swing(machine)
    if swing > 0.0:
        ends.append(float(f'{MARGIN * swing:.2g}'))
    return min(ends)


def _swing(machine: AnyMachine) -> float:
    """Return the larger of the release and of the steady amplitude [rad]."""
    released = abs(machine.release_angle)
    if isinstance(machine, HangingMachine) or machine.escapement is None:
        return released
    found = steady_swing(machine)
    return released if isinstance(found, NoSteadySwing) else max(released, found.amplitude)
