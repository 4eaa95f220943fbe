"""The data of the moving machine in a report: outlines, and the motion in several parts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tauto_core.curves import Cam
from tauto_core.machine_drawing import machine_lines
from tauto_core.machines import compile_machine
from tauto_core.record import Voyage
from tauto_core.samples import FloatArray
from tauto_core.scene import HoleThread, LeverThread, Scene, WeightPower
from tauto_core.scene.errors import UsageError
from tauto_core.seaway import PART_S, seaway

MOST_PARTS = 13
"""Number of parts of ten minutes in which a longer voyage is shown, evenly spread over it."""
_ROLL_STEP_S = 0.2
_TURNS_WITH_WHEEL = ('wheel', 'cheeks', 'axle', '')
_MM = 1000.0


def animation(voyage: Voyage) -> dict[str, Any]:
    """Return outlines and motion, ready for JSON; or the reason `why` there are none.

    The wheel stands at A cos φ: phase φ and amplitude A are interpolated between logged samples,
    which may be a minute apart, while the angle itself swings once a second.

    Returns:
        `lines`, each with `name`, `x`, `y` [mm, y upwards], `colour`, `area`, and `with`, the part
        with which it moves: `wheel`, `case` or `weight`; `parts` of the voyage, each beginning at
        `from_s` for `length_s`, with `time_s` within it, `phase_rad` and `amplitude_rad` at logged
        samples and `roll_rad` every `roll_step_s`; for the thread `end`, and `winding`
        (`angle_rad`, `x`, `y` of the contact in the wheel's frame, `rise`, all [mm]), null without
        a
        cam.
    """
    scene = voyage.scene
    try:
        lines = machine_lines(scene)
    except UsageError as error:
        return {'why': str(error)}
    if not len(voyage.angle_rad) or not len(voyage.phase_rad):
        return {'why': 'The bag does not hold the motion of the wheel.'}
    machine = compile_machine(scene)
    size = np.hypot(voyage.angle_rad, voyage.angular_velocity_rad_s / machine.frequency)
    assert scene.trochlea is not None
    weight = isinstance(scene.trochlea.power, WeightPower)
    return {
        'lines': [
            {
                'name': line.name,
                'x': _short(line.x),
                'y': _short(line.y),
                'colour': line.colour,
                'area': line.kind == 'area',
                'with': 'weight'
                if line.name == 'weight'
                else 'wheel'
                if line.name in _TURNS_WITH_WHEEL
                else 'case',
            }
            for line in lines
        ],
        'roll_step_s': _ROLL_STEP_S,
        'parts': [_part(voyage, size, from_s) for from_s in _starts(float(voyage.time_s[-1]))],
        'hangs': weight and not isinstance(scene.trochlea.thread, LeverThread),
        'fixed_end': isinstance(scene.trochlea.thread, HoleThread | LeverThread),
        'winding': _winding(scene),
    }


def _starts(end_s: float) -> FloatArray:
    """Return the beginnings of the parts [s]: one for all of the voyage, or evenly spread."""
    parts = min(max(math.ceil(end_s / PART_S), 1), MOST_PARTS)
    return np.linspace(0.0, max(end_s - PART_S, 0.0), parts)


def _part(voyage: Voyage, size: FloatArray, from_s: float) -> dict[str, Any]:
    """Return the motion of wheel and ship, beginning at the logged sample at or before a time."""
    first = max(int(np.searchsorted(voyage.time_s, from_s, side='right')) - 1, 0)
    began_s = float(voyage.time_s[first])
    last = int(np.searchsorted(voyage.time_s, began_s + PART_S, side='right'))
    shown = slice(first, max(last, first + 2))
    time_s = voyage.time_s[shown] - began_s
    length_s = float(time_s[-1])
    ship = seaway(voyage, began_s, length_s + 1.0)
    grid = np.arange(0.0, length_s + _ROLL_STEP_S, _ROLL_STEP_S)
    return {
        'from_s': round(began_s, 3),
        'length_s': round(length_s, 3),
        'time_s': _short(time_s, 3),
        'phase_rad': _short(voyage.phase_rad[shown], 4),
        'amplitude_rad': _short(size[shown], 4),
        'roll_rad': _short(np.interp(grid, ship.time_s - began_s, ship.roll_rad), 5),
    }


def _winding(scene: Scene) -> dict[str, Any] | None:
    """Return the contact of the thread with the cheek for positive angles of the wheel."""
    assert scene.trochlea is not None
    if scene.trochlea.cam.kind == 'lever_corrected':
        return None
    cam: Cam = scene.trochlea.made_cam(scene.gravity)
    angle = np.linspace(0.0, cam.drawn_rad, 101)
    x, y = cam.contact(angle)
    arm = cam.lever_arm(angle)
    rise = np.concatenate(([0.0], np.cumsum(0.5 * (arm[1:] + arm[:-1]) * np.diff(angle))))
    return {
        'angle_rad': _short(angle, 4),
        'x': _short(_MM * x),
        'y': _short(_MM * y),
        'rise': _short(_MM * rise),
    }


def _short(values: FloatArray, digits: int = 3) -> list[float]:
    rounded: list[float] = np.round(values, digits).tolist()
    return rounded
