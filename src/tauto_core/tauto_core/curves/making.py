"""From what a scene says about cam and thread to the cam."""

from __future__ import annotations

import math

from tauto_core.curves.cam import Cam
from tauto_core.curves.cams import CircularArc, Hole, Involute
from tauto_core.curves.table import load_table
from tauto_core.scene.data import data_path
from tauto_core.scene.errors import SceneError
from tauto_core.scene.models import (
    CircularArcCam,
    HangingThread,
    HoleCam,
    HoleThread,
    InvoluteCam,
    LeverThread,
    TableCam,
    Trochlea,
    VerticalThread,
)


def make_cam(trochlea: Trochlea) -> Cam:
    """Return the cam of a trochlea with the thread it is made for.

    Raises:
        SceneError: a cam and a thread that don't go together, or a table that can't be used.
    """
    match trochlea.cam, trochlea.thread:
        case InvoluteCam(base_radius=radius), VerticalThread() | LeverThread() | HangingThread():
            return Involute(radius)
        case HoleCam(lever_rate=rate), HoleThread(distance=distance):
            return Hole(rate, distance)
        case CircularArcCam(radius=radius, root_depth=depth), VerticalThread():
            return CircularArc(radius, depth)
        case TableCam(path=path), VerticalThread():
            return load_table(data_path(path), math.inf)
        case TableCam(path=path), HoleThread(distance=distance):
            return load_table(data_path(path), distance)
        case cam, thread:
            raise SceneError(
                'trochlea',
                'thread.kind',
                thread.kind,
                f'a cam of kind {cam.kind!r} is not made for this thread',
                'Put hole with hole, involute and circular_arc with vertical, table with either; '
                'lever and hanging take an involute.',
            )
