"""Whether a cheek can be cut: a thread wraps only a convex curve, and has a thickness.

R, the radius of curvature, must not be negative where the thread lies, or the thread would bridge
a hollow. A thread of thickness e has its centre line on the cam's curve, so the cheek is the
parallel curve e/2 inwards; where R < e/2 there is none. Every cam that is smooth through rest
has R = 0 at its tip, where a thick thread bends round the cheek's edge.
"""

from __future__ import annotations

import math

import numpy as np

from tauto_core.curves.bisection import bisect
from tauto_core.curves.cam import Cam
from tauto_core.samples import FloatArray

_PROBES = 2000
_ROUNDING = 1e-12


def hollow(cam: Cam, reach_rad: float | None = None) -> tuple[float, float] | None:
    """Return the first interval of angles [rad] where R < 0; None where there is none.

    Args:
        cam: the cam.
        reach_rad: largest angle; `cam.drawn_rad` when left out.
    """
    return _below(cam, 0.0, cam.drawn_rad if reach_rad is None else reach_rad)


def too_sharp(
    cam: Cam, radius: float, reach_rad: float | None = None
) -> list[tuple[float, float]]:
    """Return the intervals of angles [rad] where R is less than a radius.

    Args:
        cam: the cam.
        radius: half the thickness of the thread [m]; 0 finds hollows.
        reach_rad: as for `hollow`.
    """
    edge = cam.drawn_rad if reach_rad is None else reach_rad
    found: list[tuple[float, float]] = []
    start = 0.0
    while start < edge and (stretch := _below(cam, radius, edge, start)) is not None:
        found.append(stretch)
        start = stretch[1]
    return found


def _below(cam: Cam, radius: float, edge: float, start: float = 0.0) -> tuple[float, float] | None:
    """Return the first interval beyond `start` where R is below a radius."""
    # closer together at both ends, where R may vanish, and down to the tip itself
    even = start + (edge - start) * np.sin(np.linspace(0.0, 0.5 * math.pi, _PROBES)) ** 2
    tip = edge * np.logspace(-9.0, -4.0, 11)
    angles = np.unique(np.concatenate([tip, even[1:]]))
    low = _excess(cam, angles[angles > start], radius)
    angles = angles[angles > start]
    bad = np.flatnonzero(low < 0.0)
    if not len(bad):
        return None
    first = int(bad[0])
    good = np.flatnonzero(low[first:] >= 0.0)
    begin = start if first == 0 else _crossing(cam, radius, angles[first - 1], angles[first])
    if not len(good):
        return begin, edge
    last = first + int(good[0])
    return begin, _crossing(cam, radius, angles[last], angles[last - 1])


def _excess(cam: Cam, angles: FloatArray, radius: float) -> FloatArray:
    """Return R less the radius, with an allowance for rounding where R is a small difference."""
    found = cam.radius_of_curvature(angles)
    return found - radius + _ROUNDING * cam.lever_arm(angles)


def _crossing(cam: Cam, radius: float, good: float, bad: float) -> float:
    """Return the angle at which R falls below the radius, between one above and one below."""
    return bisect(lambda at: bool(_excess(cam, np.array([at]), radius)[0] >= 0.0), good, bad)[0]
