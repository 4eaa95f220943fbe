"""The data of the moving machine in a report: outlines, and the motion in several parts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tauto_core.curves import Cam, DescentCurve
from tauto_core.curves.fluid import coordinates
from tauto_core.machine_drawing import Drawing, draw_machine
from tauto_core.machines import FluidPendulum, LeverMachine, compile_machine
from tauto_core.record import Voyage
from tauto_core.samples import FloatArray
from tauto_core.scene import HoleThread, LeverThread, Scene
from tauto_core.seaway import PART_S, seaway

MOST_PARTS = 13
"""Number of parts of ten minutes in which a longer voyage is shown, evenly spread over it."""
_ROLL_STEP_S = 0.2
_MM = 1000.0


def animation(voyage: Voyage) -> dict[str, Any]:
    """Return outlines and motion, ready for JSON; or the reason `why` there are none.

    The wheel stands at A cos φ: phase φ and amplitude A are interpolated between logged samples,
    which may be a minute apart, while the angle itself swings once a second. So does a body on a
    curve in a fluid with its arc.

    Returns:
        `lines`, each with `name`, `x`, `y` [mm, y upwards], `colour`, `area`, and `with`, the part
        with which it moves (`machine_drawing.Carrier`); `note` on these; `parts` of the voyage,
        each beginning at `from_s` for `length_s`, with `time_s` within it, `phase_rad` and
        `amplitude_rad` at logged samples, and every `roll_step_s` `roll_rad` and `plumb_rad`, the
        apparent vertical, to which a suspended case keeps and a thread with a weight. For a thread
        `hangs`, whether it keeps to that alone, `fixed_end`, and `winding` (`angle_rad`, `x`, `y`
        of the contact in the wheel's frame, `rise`, all [mm]), null without a cam; `pivot`, the
        place [mm] about which a suspended case turns, or null; `lever` (`x`, `y` of the fulcrum,
        its angle `beta_rad` at `angle_rad` of the wheel), or null; `curve` in a fluid (`x`, `y`
        [mm] at `arc_m`), or null.
    """
    scene = voyage.scene
    if not len(voyage.angle_rad) or not len(voyage.phase_rad):
        return {'why': 'The bag does not hold the motion of the machine.'}
    machine = compile_machine(scene)
    size = np.hypot(voyage.angle_rad, voyage.angular_velocity_rad_s / machine.frequency)
    drawn, hung, trochlea = draw_machine(scene), scene.suspension, scene.trochlea
    thread = None if trochlea is None else trochlea.thread
    weight = trochlea is not None and trochlea.power.pull.pulling_mass > 0.0
    fixed_end = isinstance(thread, HoleThread | LeverThread)
    return {
        'lines': [
            {
                'name': part.name,
                'x': _short(part.x),
                'y': _short(part.y),
                'colour': part.colour,
                'area': part.kind == 'area',
                'with': part.moves_with,
            }
            for part in drawn.parts
        ],
        'note': drawn.note,
        'roll_step_s': _ROLL_STEP_S,
        'parts': [_part(voyage, size, from_s) for from_s in _starts(float(voyage.time_s[-1]))],
        'hangs': weight and not fixed_end and hung is None,
        'fixed_end': fixed_end,
        'winding': _winding(scene),
        'pivot': None if hung is None else [0.0, _MM * hung.depth],
        'lever': _lever(machine, drawn) if isinstance(machine, LeverMachine) else None,
        'curve': _curve(machine.curve) if isinstance(machine, FluidPendulum) else None,
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
    tilts = {'roll_rad': ship.roll_rad, 'plumb_rad': ship.plumb_rad}
    return {
        'from_s': round(began_s, 3),
        'length_s': round(length_s, 3),
        'time_s': _short(time_s, 3),
        'phase_rad': _short(voyage.phase_rad[shown], 4),
        'amplitude_rad': _short(size[shown], 4),
        **{
            name: _short(np.interp(grid, ship.time_s - began_s, values), 5)
            for name, values in tilts.items()
        },
    }


def _winding(scene: Scene) -> dict[str, Any] | None:
    """Return the contact of the thread with the cheek for positive angles of the wheel."""
    if scene.trochlea is None or scene.trochlea.cam.kind == 'lever_corrected':
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


def _lever(machine: LeverMachine, drawn: Drawing) -> dict[str, Any]:
    """Return the fulcrum, as low as the end of the thread is drawn, and the angle of the lever."""
    (thread,) = (part for part in drawn.parts if part.name == 'thread')
    low, high = (0.999 * side for side in machine.sides)
    angle = np.linspace(low, high, 201)
    return {
        'x': -_MM * machine.geometry.arm,
        'y': float(thread.y[-1]),
        'angle_rad': _short(angle, 4),
        'beta_rad': _short(machine.beta(angle), 5),
    }


def _curve(curve: DescentCurve) -> dict[str, Any]:
    """Return the places of the body on its curve, as far as its release could be."""
    cusp = curve.descent_cusp
    arc = np.linspace(-min(-curve.ascent_cusp, cusp), cusp, 201)
    height, level = coordinates(curve, arc)
    return {'arc_m': _short(arc, 5), 'x': _short(_MM * level), 'y': _short(_MM * height)}


def _short(values: FloatArray, digits: int = 3) -> list[float]:
    rounded: list[float] = np.round(values, digits).tolist()
    return rounded
