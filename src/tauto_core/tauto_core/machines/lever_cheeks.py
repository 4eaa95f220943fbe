"""The cheeks of a lever's own cam as polylines, cut back for the thickness of the thread."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
from tauto_core.curves.numerics import bisect
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import Argument, UsageError

_PROBES = 2000


class Cheek(NamedTuple):
    """One cheek, in the wheel's frame, beginning at the tip; arrays of shape (n,).

    Attributes:
        angle: angle of the wheel at which the thread leaves the cheek [rad].
        x: x of the cheek [m].
        y: y of the cheek [m].
    """

    angle: FloatArray
    x: FloatArray
    y: FloatArray


def cheek(
    shape: CorrectedLeverGeometry, end: float, points: int, thread_thickness: float = 0.0
) -> Cheek:
    """Return one cheek of a lever's cam, as `curves.drawing.cheeks` does for an ideal thread.

    The thread's centre line follows the cam, so the cheek is the parallel curve e/2 inwards. It
    begins where the radius of curvature reaches e/2; up to there the thread bends round its edge.

    Args:
        shape: the shape of the cam.
        end: τ up to which it is drawn, < 0 for negative angles.
        points: number of points, ≥ 2.
        thread_thickness: e [m], ≥ 0.

    Raises:
        UsageError: a cheek that such a thread cannot follow up to there.
    """
    half = 0.5 * thread_thickness
    start = _start(shape, end, half) if half else 0.0
    tau = np.linspace(start, end, points)
    (x, y), angle = shape.contact(tau), shape.theta(tau)
    if half:
        u, inwards = shape.pose(tau).u, -half * float(np.sign(end))
        x, y = x + inwards * np.cos(u), y + inwards * np.sin(u)
    return Cheek(angle, x, y)


def _start(shape: CorrectedLeverGeometry, end: float, radius: float) -> float:
    """Return the τ beyond which R is at least a given radius."""
    tau = np.linspace(0.0, end, _PROBES)
    sharp = np.flatnonzero(shape.radius_of_curvature(tau) < radius)
    last = int(sharp[-1]) if len(sharp) else 0
    if last == len(tau) - 1 or not np.array_equal(sharp, np.arange(last + 1)):
        greatest = float(np.max(shape.radius_of_curvature(tau)))
        reach = float(shape.theta(tau[-1:])[0])
        raise UsageError(
            f'thread thickness {2.0 * radius!r} m: up to {reach:.6g} rad the cheek is not '
            'everywhere beyond its tip as round as half of it; its greatest '
            f'radius of curvature is {greatest:.6g} m. Use a thinner thread or a shorter ',
            Argument('reach_rad'),
        )
    sharp_at, round_at = float(tau[last]), float(tau[last + 1])
    return bisect(
        lambda at: bool(shape.radius_of_curvature(np.array([at]))[0] >= radius), round_at, sharp_at
    )[0]
