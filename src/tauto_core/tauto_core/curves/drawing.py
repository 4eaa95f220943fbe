"""The cheeks as polylines, for drawing and cutting."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tauto_core.curves.bisection import bisect
from tauto_core.curves.cam import Cam
from tauto_core.curves.curvature import too_sharp
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import UsageError

_PROBES = 2001
"""Number of angles at which the cheeks are checked for a place where they meet."""


class Cheeks(NamedTuple):
    """Both cheeks as they are cut, in the wheel's frame.

    Attributes:
        angle: angle of the wheel at which the thread leaves the cheek at each point [rad], shape
            (n,), increasing from above 0; at the other cheek it is the negative.
        x: x of the cheek for positive angles [m], shape (n,); the other cheek is its mirror image.
        y: y of both [m], shape (n,).
        thread_thickness: thickness of the thread for which they are cut [m].
    """

    angle: FloatArray
    x: FloatArray
    y: FloatArray
    thread_thickness: float


def cheeks(
    cam: Cam, points: int = 200, reach_rad: float | None = None, thread_thickness: float = 0.0
) -> Cheeks:
    """Return the cheeks of a cam for a thread of some thickness e.

    The thread's centre line follows the cam's curve; the cheek is the parallel curve e/2 inwards.
    It begins where the curve's radius of curvature reaches e/2 (R = 0 at the tip of every cam
    that is smooth through rest): up to there the thread bends round its edge.

    Args:
        cam: the cam.
        points: on each cheek, ≥ 2.
        reach_rad: largest angle drawn [rad], > 0 and within the range; when left out, as far as
            `cam.drawn_rad` and the thread go.
        thread_thickness: e [m], ≥ 0.

    Raises:
        UsageError: fewer than two points, a thickness that is none, or a cheek that no such
            thread can follow up to there.
        CamRangeError: a reach beyond the range.
    """
    if points < 2:
        raise UsageError(f'points = {points!r}: a cheek needs at least 2; ask for more')
    if not 0.0 <= thread_thickness < math.inf:
        raise UsageError(f'thread thickness {thread_thickness!r} m: must be ≥ 0; give another')
    reach = cam.drawn_rad if reach_rad is None else reach_rad
    cam.within(reach)
    start, end = _followed(cam, 0.5 * thread_thickness, reach)
    if end <= start or (end < reach and reach_rad is not None):
        raise _not_followed(cam, thread_thickness, start, end)
    # closer together at the end, where ψ grows like a square root when a thread meets its hole
    angle = start + (end - start) * np.sin(np.linspace(0.0, 0.5, points) * math.pi)
    x, y = cam.contact(angle)
    if thread_thickness:
        psi = cam.psi(angle)
        x, y = (
            x - 0.5 * thread_thickness * np.cos(psi),
            y - 0.5 * thread_thickness * np.sin(psi),
        )
    return Cheeks(angle, x, y, thread_thickness)


def outline(
    cam: Cam, points: int = 200, reach_rad: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return both cheeks as one polyline (x, y) in the wheel's frame [m], for a thin thread.

    It runs from the end of the cheek at x > 0 over the common tip to the end of the other.

    Args:
        cam: the cam.
        points: points on each cheek, the tip counted, ≥ 2; the shapes are (2·points − 1,).
        reach_rad: as for `cheeks`.

    Raises:
        UsageError: as `cheeks`.
        CamRangeError: a reach beyond the range.
    """
    _, x, y, _ = cheeks(cam, points, reach_rad)
    return np.concatenate([-x[:0:-1], x]), np.concatenate([y[:0:-1], y])


def cheeks_meet_rad(cam: Cam) -> float:
    """Return the angle at which the two mirror-image cheeks meet again beyond their tip [rad].

    There the contact point of the thread returns to the line x = 0. Longer cheeks would cross each
    other and could not be cut from one plate. For an involute tan ϑ = ϑ, ϑ = 4.493 rad.

    Args:
        cam: the cam, considered up to `cam.drawn_rad`.

    Returns:
        The smallest such angle; inf where the cheeks do not meet.
    """
    angles = np.linspace(0.0, cam.drawn_rad, _PROBES)
    # at positive angles the thread lies on the cheek at x < 0
    apart = cam.contact(angles)[0] < 0.0
    meets = np.flatnonzero(apart[:-1] & ~apart[1:])
    if not len(meets):
        return math.inf
    first = int(meets[0])
    return bisect(
        lambda at: bool(cam.contact(at)[0] < 0.0), float(angles[first]), float(angles[first + 1])
    )[0]


def _followed(cam: Cam, radius: float, reach: float) -> tuple[float, float]:
    """Return the first interval of angles where R is at least a radius."""
    start = 0.0
    for low, high in too_sharp(cam, radius, reach):
        if low > 0.0:
            return start, low
        if radius == 0.0:
            # hollow from its tip on
            return 0.0, 0.0
        start = high
    return start, reach


def _not_followed(cam: Cam, thickness: float, start: float, end: float) -> UsageError:
    if end <= start:
        return UsageError(
            f'the cheek of {cam!r} is nowhere as round as a thread of {thickness!r} m needs, or '
            'hollow from its tip on. Use a thinner thread or another cam'
        )
    return UsageError(
        f'beyond {end:.9g} rad the cheek of {cam!r} has a radius of curvature below half the '
        f"thread's thickness, {0.5 * thickness!r} m, where no thread can follow it. Draw up to "
        f'there (--reach {end * (1.0 - 1e-6):.6f}), or use a thinner thread'
    )
