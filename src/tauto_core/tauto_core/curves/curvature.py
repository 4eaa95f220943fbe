"""Whether a cam can be: a thread wraps only a convex cheek, has a thickness, and pulls back.

`possible_cam` and `possible_lever` refuse what no kind of cam may make; every machine and every
drawing passes through them.

R, the radius of curvature, must not be negative where the thread lies, or the thread would bridge
a hollow. A thread of thickness e has its centre line on the cam's curve, so the cheek is the
parallel curve e/2 inwards; where R < e/2 there is none. Every cam that is smooth through rest
has R = 0 at its tip, where a thick thread bends round the cheek's edge.
"""

from __future__ import annotations

import math

import numpy as np

from tauto_core.curves.bisection import bisect
from tauto_core.curves.cam import Cam, arm_rounding
from tauto_core.curves.lever_parts import LeverShape
from tauto_core.curves.nearest import farther
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import SceneError

_PROBES = 2000
_ROUNDING = 1e-12
_BY_DIFFERENCES = 1e-3
"""Allowance for a radius of curvature from second differences of a lever's cam, as a share of its
largest lever arm; they err by 1e-5 of it.
"""


def possible_cam(cam: Cam, kind: str) -> Cam:
    """Return a cam that wheel, thread and hole allow, whatever its kind.

    It is looked at over its range, or over a turn if that is unlimited.

    Args:
        cam: the cam.
        kind: its kind, for the error.

    Raises:
        SceneError: a lever arm that is not a number or does not drive the wheel back, one longer
            than the hole is away, or a hollow cheek.
    """
    edge = cam.range_rad if math.isfinite(cam.range_rad) else cam.drawn_rad
    if not edge > 0.0:
        raise _impossible(kind, f'has a range of {edge!r} rad', 'Give it a range above 0.')
    angles = _probes(edge, 0.0)
    arms = cam.lever_arm(angles)
    at = _first(~(arms > 0.0))
    if at is not None or not float(cam.lever_rate(0.0)) > 0.0:
        where = 'at rest' if at is None else f'at {angles[at]:.6g} rad'
        what = 'of 0 a radian' if at is None else f'of {arms[at]:.6g} m'
        problem = f'has a lever arm {what} {where}, which does not drive the wheel back'
        raise _impossible(kind, problem, 'Make the lever arm rise from rest, and end before 0.')
    # the range is rounded, and the lever arm is steep there
    allowed = cam.hole_distance + arm_rounding(angles, arms, cam.lever_rate(angles))
    at = _first(~(arms <= allowed))
    if at is not None:
        problem = (
            f'has a lever arm of {arms[at]:.6g} m at {angles[at]:.6g} rad, longer than the hole '
            f'is away, trochlea.thread.distance = {cam.hole_distance!r} m'
        )
        sooner = f'End the cam before {angles[at]:.6g} rad{farther(float(arms.max()))}.'
        raise _impossible(kind, problem, sooner)
    stretch = hollow(cam, edge)
    if stretch is not None:
        problem = (
            f'has a cheek that would be hollow from {stretch[0]:.6g} to {stretch[1]:.6g} rad (a '
            'radius of curvature below 0), and a thread bridges a hollow'
        )
        sooner = f'End the cam before {stretch[0]:.6g} rad, or let' if stretch[0] > 0.0 else 'Let'
        raise _impossible(kind, problem, f'{sooner} the lever arm bend down less there.')
    return cam


def possible_lever(shape: LeverShape, kind: str) -> LeverShape:
    """Return cam, thread and lever of Sully's machine that are possible, whatever the kind.

    Args:
        shape: the shape, looked at between its edges.
        kind: kind of the cam, for the error.

    Raises:
        SceneError: a lever arm that does not drive the wheel back, a wheel that turns back while
            the lever rises, a thread that is wound up, or a hollow cheek.
    """
    low, high = shape.edges
    if not low < 0.0 < high:
        raise _impossible(kind, f'reaches from {low!r} to {high!r}', 'Let it reach to both sides.')
    for edge in (low, high):
        tau = np.linspace(0.0, edge, _PROBES // 4 + 1)[1:]
        pose, theta_rate = shape.pose(tau), shape.rates(tau)[0]
        arms = shape.base_radius * np.abs(tau) * shape.u_per_tau(tau)
        wound = np.abs(pose.u)
        radius = arms + np.gradient(np.gradient(arms, wound), wound)
        # differences are one-sided at the ends
        radius[:2], radius[-2:] = radius[2], radius[-3]
        for bad, problem, remedy in (
            (~(arms > 0.0), 'has a lever arm that does not drive the wheel back', 'End it before'),
            (~(theta_rate > 0.0), 'turns the wheel back as the lever rises', 'End it before'),
            (
                ~(pose.free > 0.0),
                'winds up the whole thread',
                'Use a longer thread, or end before',
            ),
            (
                ~(radius >= -_BY_DIFFERENCES * arms.max()),
                'has a cheek that would be hollow, and a thread bridges a hollow,',
                'Let the lever arm bend down less, or end before',
            ),
        ):
            at = _first(bad)
            if at is not None:
                where = f'{pose.u[at]:.6g} rad of thread wound up'
                raise _impossible(kind, f'{problem} at {where}', f'{remedy} that angle.')
    return shape


def _impossible(kind: str, problem: str, remedy: str) -> SceneError:
    return SceneError('trochlea', 'trochlea.cam.kind', kind, problem, remedy)


def _first(bad: np.ndarray) -> int | None:
    """Return the index of the first that is bad; None if none is."""
    found = np.flatnonzero(bad)
    return int(found[0]) if len(found) else None


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
    angles = _probes(edge, start)
    low = _excess(cam, angles, radius)
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


def _probes(edge: float, start: float) -> FloatArray:
    """Return the angles between `start` and `edge` at which a cam is looked at [rad].

    They are closer together at both ends, where R may vanish, and go down to the tip itself.
    """
    even = start + (edge - start) * np.sin(np.linspace(0.0, 0.5 * math.pi, _PROBES)) ** 2
    angles = np.unique(np.concatenate([edge * np.logspace(-9.0, -4.0, 11), even[1:]]))
    return np.asarray(angles[angles > start])


def _excess(cam: Cam, angles: FloatArray, radius: float) -> FloatArray:
    """Return R less the radius, with an allowance for rounding where R is a small difference."""
    found = cam.radius_of_curvature(angles)
    return found - radius + _ROUNDING * cam.lever_arm(angles)


def _crossing(cam: Cam, radius: float, good: float, bad: float) -> float:
    """Return the angle at which R falls below the radius, between one above and one below."""
    return bisect(lambda at: bool(_excess(cam, np.array([at]), radius)[0] >= 0.0), good, bad)[0]
