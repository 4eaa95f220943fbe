"""The cheeks as polylines, to look at and to cut."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.curves.cam import Cam
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import UsageError


def outline(
    cam: Cam, points: int = 200, reach_rad: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return both cheeks as one polyline (x, y) in the wheel's frame [m].

    It runs from the end of the cheek at x > 0 over the common tip to the end of the other.

    Args:
        cam: the cam.
        points: points on each cheek, the tip counted, ≥ 2; the shapes are (2·points − 1,).
        reach_rad: largest angle drawn [rad], > 0 and within the range; when left out, the range
            or one turn, whichever is less.

    Raises:
        UsageError: fewer than two points.
        CamRangeError: a reach beyond the range.
    """
    if points < 2:
        raise UsageError(f'points = {points!r}: a cheek needs at least 2; ask for more')
    reach = min(cam.range_rad, math.tau) if reach_rad is None else reach_rad
    # closer together at the end, where ψ grows like a square root when a thread meets its hole
    x, y = cam.contact(reach * np.sin(np.linspace(0.0, 0.5, points) * math.pi))
    return np.concatenate([-x[:0:-1], x]), np.concatenate([y[:0:-1], y])
