"""From what a scene says about cam and thread to the cam."""

from __future__ import annotations

import math
from pathlib import Path

from tauto_core.curves.cam import Cam
from tauto_core.curves.cams import CircularArc, Hole, Involute
from tauto_core.curves.corrected import SpringCorrected, WeightCorrected
from tauto_core.curves.curvature import hollow
from tauto_core.curves.nearest import nearest
from tauto_core.curves.table import Table, load_table
from tauto_core.scene.data import data_path
from tauto_core.scene.errors import SceneError
from tauto_core.scene.regulators import (
    CircularArcCam,
    HangingThread,
    HoleCam,
    HoleThread,
    InvoluteCam,
    LeverThread,
    SpringCorrectedCam,
    SpringPower,
    TableCam,
    Trochlea,
    VerticalThread,
    WeightCorrectedCam,
    WeightPower,
)


def make_cam(trochlea: Trochlea, gravity: float) -> Cam:
    """Return the cam of a trochlea with the thread it is made for.

    Args:
        trochlea: of the scene; inertia and power count for the cams that are made for them.
        gravity: of the scene [m/s2].

    Raises:
        SceneError: a cam, a thread and a power that don't go together, a cheek that no thread
            can wrap, or a table that can't be used.
    """
    thread = trochlea.thread
    distance = thread.distance if isinstance(thread, HoleThread) else math.inf
    match trochlea.cam, thread, trochlea.power:
        case (
            InvoluteCam(base_radius=radius),
            VerticalThread() | LeverThread() | HangingThread(),
            _,
        ):
            return Involute(radius)
        case HoleCam(lever_rate=rate), HoleThread(), _:
            return Hole(rate, distance)
        case CircularArcCam(radius=radius, root_depth=depth), VerticalThread(), _:
            return CircularArc(radius, depth)
        case TableCam(path=path), VerticalThread() | HoleThread(), _:
            return _tabulated(data_path(path), distance)
        case (
            WeightCorrectedCam(period=period),
            VerticalThread() | HoleThread(),
            WeightPower(mass=mass, massless=False),
        ):
            rate = _lever_rate(trochlea, period, mass * gravity)
            return WeightCorrected(rate, mass / trochlea.inertia, distance)
        case SpringCorrectedCam(), VerticalThread() | HoleThread(), SpringPower():
            return _spring_corrected(trochlea, trochlea.cam, trochlea.power, distance)
        case cam, thread, power:
            raise SceneError(
                'trochlea',
                'thread.kind',
                thread.kind,
                f'a cam of kind {cam.kind!r} is not made for this thread and power {power.kind!r}',
                'Put hole with hole, involute and circular_arc with vertical, table, '
                'weight_corrected and spring_corrected with either; weight_corrected goes with a '
                'weight that has inertia, spring_corrected with a spring; lever and hanging take '
                'an involute, lever lever_corrected too.',
            )


def _tabulated(path: Path, distance: float) -> Table:
    """Return a tabulated cam that a thread can wrap, with the hole at a distance [m]."""
    table = load_table(path, distance)
    stretch = hollow(table, table.range_rad)
    if stretch is None:
        return table
    start, end = stretch
    sooner = f'End the table before {start:.6g} rad, or let' if start > 0.0 else 'Let'
    raise SceneError(
        str(path),
        'lever_arm_m',
        float(table.lever_arm(start)),
        f'the cheek would be hollow from {start:.6g} to {end:.6g} rad (a radius of curvature '
        'below 0), and a thread bridges a hollow',
        f'{sooner} the lever arm bend down less there.',
    )


def _lever_rate(trochlea: Trochlea, period: float, pull: float) -> float:
    """Return t'(0) = I ω²/P [m/rad]."""
    omega = math.tau / period
    rate = trochlea.inertia * omega * omega / pull
    if not 0.0 < rate < math.inf:
        raise SceneError(
            'trochlea',
            'trochlea.cam.period',
            period,
            f'asks for a lever arm of {rate!r} m a radian at rest',
            'Give a period in seconds that wheel and power can keep, for example 1.0.',
        )
    return rate


def _spring_corrected(
    trochlea: Trochlea, wanted: SpringCorrectedCam, power: SpringPower, distance: float
) -> SpringCorrected:
    def cam(period: float, stiffness: float) -> SpringCorrected:
        rate = _lever_rate(trochlea, period, power.force)
        return SpringCorrected(rate, stiffness / power.force, distance)

    made = cam(wanted.period, power.stiffness)
    stretch = hollow(made)
    if stretch is None:
        return made
    softest = nearest(
        power.stiffness, 0.5, lambda value: hollow(cam(wanted.period, value)) is None
    )
    slowest = nearest(
        wanted.period, 2.0, lambda value: hollow(cam(value, power.stiffness)) is None
    )
    nearer = '' if math.isinf(distance) else ', or bring the hole nearer'
    raise SceneError(
        'trochlea',
        'trochlea.power.stiffness',
        power.stiffness,
        f'the cheek of spring_corrected would be hollow from {stretch[0]:.6g} to '
        f'{stretch[1]:.6g} rad, and a thread bridges a hollow',
        f'Use a stiffness of at most {softest:.4g} N/m, or a period of at least {slowest:.4g} '
        f's{nearer}.',
    )
