"""The machine of a scene as outlines: wheel, axle, cheeks, thread, weight, case [mm].

The origin is the axle and y points upwards; the wheel is at rest. Dimensions that a scene does not
give (rim, weight, case) are drawn in proportion.
"""

from __future__ import annotations

import math

import numpy as np

from tauto_core.chart import Line
from tauto_core.curves import cheeks
from tauto_core.samples import FloatArray
from tauto_core.scene import (
    ForcePower,
    HangingThread,
    HoleThread,
    LeverThread,
    Scene,
    WeightPower,
)
from tauto_core.scene.errors import UsageError

MM = 1000.0
_CIRCLE = np.linspace(0.0, math.tau, 121)


def cam_lines(scene: Scene) -> list[Line]:
    """Return both cheeks, the thread at rest and the axle.

    Raises:
        UsageError: the scene has no trochlea.
    """
    left, right, tip = _cheeks(scene)
    return [
        _area('cheeks', left, 'blue'),
        _area('', right, 'blue'),
        _path('thread at rest', [(0.0, tip), (0.0, 3.0 * tip)], 'grey'),
        _area('axle', _circle(0.0, 0.0, 0.04 * abs(tip)), 'grey'),
    ]


def machine_lines(scene: Scene) -> list[Line]:
    """Return wheel, axle, cheeks, thread, weight or spring, and the case.

    Raises:
        UsageError: the scene has no trochlea.
    """
    left, right, tip = _cheeks(scene)
    assert scene.trochlea is not None
    thread, power = scene.trochlea.thread, scene.trochlea.power
    rim = 1.25 * max(float(np.abs(side).max()) for side in (left, right))
    length = _thread_mm(scene, rim)
    lines = [
        _path('wheel', _circle(0.0, 0.0, rim).T, 'grey'),
        _path('', [(-rim, 0.0), (rim, 0.0)], 'grey'),
        _area('cheeks', left, 'blue'),
        _area('', right, 'blue'),
        _path('thread', [(0.0, tip), (0.0, -length)], 'orange'),
        _area('axle', _circle(0.0, 0.0, 0.05 * rim), 'grey'),
    ]
    end = -length
    if isinstance(thread, LeverThread):
        arm, far = MM * thread.arm, MM * thread.weight_arm
        lines.append(_path('lever', [(-arm, -length), (far - arm, -length)], 'green'))
        lines.append(_area('fulcrum', _circle(-arm, -length, 0.05 * rim), 'green'))
        lines += _weight(far - arm, -length, 0.35 * rim)
        end -= 0.8 * rim
    elif isinstance(thread, HoleThread):
        half = 0.08 * rim
        for side in (-1.0, 1.0):
            lines.append(
                _path('hole' * (side > 0.0), [(side * half, end), (side * rim, end)], 'green')
            )
        end = -length - 0.8 * rim
        lines.append(_path('pull', [(0.0, -length), (0.0, end)], 'orange'))
    elif isinstance(power, WeightPower):
        lines += _weight(0.0, -length, 0.35 * rim)
        end -= 0.8 * rim
    else:
        name = 'pull' if isinstance(power, ForcePower) else 'spring'
        lines.append(_path(name, _zigzag(-length, 0.25 * rim, 0.9 * rim), 'green'))
        end -= 0.9 * rim
    side = 1.25 * rim
    wide = side
    if isinstance(thread, LeverThread):
        wide = max(side, MM * max(thread.arm, thread.weight_arm - thread.arm) + 0.5 * rim)
    low = end - 0.2 * rim
    box = [(-wide, low), (wide, low), (wide, side), (-wide, side), (-wide, low)]
    return [_path('case', box, 'grey'), *lines]


def _cheeks(scene: Scene) -> tuple[FloatArray, FloatArray, float]:
    """Return the closed outlines of both cheeks, (2, n) [mm], and the height of their tip."""
    if scene.trochlea is None:
        raise UsageError(
            f'{scene.name}: has no trochlea, so there is no cam or machine to draw. Draw error, '
            'amplitude or phase'
        )
    if scene.trochlea.cam.kind == 'lever_corrected':
        left, right = _lever_cheeks(scene)
    else:
        curve = scene.trochlea.made_cam(scene.gravity)
        cut = cheeks(curve, 200, min(curve.drawn_rad, 1.6))
        right = MM * np.array([cut.x, -cut.y])
        left = right * np.array([[-1.0], [1.0]])
    tip = float(right[1, 0])
    closed = [np.column_stack((side, [[0.0], [0.0]], side[:, :1])) for side in (left, right)]
    return closed[0], closed[1], tip


def _lever_cheeks(scene: Scene) -> tuple[FloatArray, FloatArray]:
    from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
    from tauto_core.machines import LeverMachine, compile_machine
    from tauto_core.machines.lever_cheeks import cheek

    machine = compile_machine(scene)
    assert isinstance(machine, LeverMachine)
    assert isinstance(machine.geometry, CorrectedLeverGeometry)
    shape = machine.geometry
    ends = shape.tau_of(np.array([-1.0, 1.0]) * min(machine.range_rad, 1.6)).tolist()
    right, left = (cheek(shape, end, 200, 0.0) for end in ends)
    return MM * np.array([left.x, -left.y]), MM * np.array([right.x, -right.y])


def _thread_mm(scene: Scene, rim: float) -> float:
    """Return the depth of the thread's end below the axle, limited to keep the picture clear."""
    assert scene.trochlea is not None
    thread = scene.trochlea.thread
    if isinstance(thread, HoleThread):
        return MM * float(thread.distance)
    if isinstance(thread, HangingThread | LeverThread):
        return min(MM * float(thread.length), 8.0 * rim)
    return 3.0 * rim


def _weight(x: float, top: float, half: float) -> list[Line]:
    corners = [(-0.5, 0.0), (0.5, 0.0), (1.0, -2.0), (-1.0, -2.0), (-0.5, 0.0)]
    outline = np.array([(x + half * a, top + half * b) for a, b in corners]).T
    return [_area('weight', outline, 'orange')]


def _zigzag(top: float, half: float, height: float) -> list[tuple[float, float]]:
    turns = 8
    middle = [((half if k % 2 else -half), top - height * (k + 0.5) / turns) for k in range(turns)]
    return [(0.0, top), *middle, (0.0, top - height)]


def _circle(x: float, y: float, radius: float) -> FloatArray:
    return np.array([x + radius * np.cos(_CIRCLE), y + radius * np.sin(_CIRCLE)])


def _area(name: str, outline: FloatArray, colour: str) -> Line:
    return Line(name, outline[0], outline[1], colour, 'area')  # type: ignore[arg-type]


def _path(name: str, points: object, colour: str) -> Line:
    x, y = np.asarray(points, float).T
    return Line(name, x, y, colour)  # type: ignore[arg-type]
