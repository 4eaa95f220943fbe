"""The figures of paper A: Euler's two cams, what the weight costs, Sully's lever machine."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from tauto_core.curves import Hole, Involute, WeightCorrected
from tauto_core.curves.cam import Cam
from tauto_core.curves.drawing import outline
from tauto_core.curves.lever_geometry import LeverGeometry
from tauto_core.euler.sketch import (
    CURVE,
    FAINT,
    INK,
    OTHER,
    THREAD,
    bare,
    graph,
    letter,
    note,
    ring,
    sheet,
    stroke,
    turned,
)
from tauto_core.machines.isochronism import rate_s_per_day
from tauto_core.machines.threads.lever import LeverMachine
from tauto_core.machines.trochlea import Machine

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GRAVITY = 9.81
BASE_RADIUS, MASS = 0.02, 0.05
ON_ITS_DISC = 0.02
"""ε/A² = m r²/I of Q = 100 P on a disc of the cam's own radius (§XX)."""


def involute_cheeks() -> Figure:
    """Draw the wheel at rest and turned: C, the cheeks BE and BF, CT = CB, the thread's TM."""
    figure, panels = sheet(6.4, 3.9, 2)
    cam = Involute(1.0)
    for axes, angle, title in ((panels[0], 0.0, 'at rest'), (panels[1], 1.3, 'turned by 1.3 rad')):
        _wheel(axes, cam, angle, reach=2.3, disc=2.9)
        ring(axes, (0.0, 0.0), 1.0, edgecolor=FAINT, linestyle='--')
        arm = float(cam.lever_arm(angle))
        stroke(axes, (arm, 1.0), (arm, 3.9), color=THREAD)
        ring(axes, (arm, 4.15), 0.25, facecolor=THREAD, fill=True, edgecolor=THREAD)
        note(axes, (arm, 4.15), 'P', (13.0, 0.0))
        letter(axes, (0.0, 0.0), 'C', (-7.0, 5.0))
        if angle:
            stroke(axes, (0.0, 0.0), (0.0, 1.0))
            stroke(axes, (0.0, 1.0), (arm, 1.0))
            letter(axes, (0.0, 1.0), 'T', (-6.0, -7.0))
            letter(axes, (arm, 1.0), 'M', (9.0, -3.0))
            letter(axes, _placed(cam, 0.0, angle), 'B', (0.0, 8.0))
            note(axes, (0.5 * arm, 1.0), 'rθ', (0.0, -8.0), color=THREAD)
        else:
            letter(axes, (0.0, 1.0), 'B', (0.0, 8.0))
        bare(axes, title)
        axes.set_ylim(4.6, -3.1)
        axes.set_xlim(-3.1, 3.1)
    return figure


def hole_cheeks() -> Figure:
    """Draw the cam for a thread through a hole: CN = MP = t, CP = p, OM free."""
    figure, panels = sheet(6.4, 3.9, 2)
    cam = Hole(1.0, 2.0)
    for axes, angle, title in ((panels[0], 0.0, 'at rest'), (panels[1], 0.9, 'turned by 0.9 rad')):
        _wheel(axes, cam, angle, reach=1.9, disc=None)
        hole = 0.0, cam.hole_distance
        stroke(axes, _placed(cam, angle, angle), hole, color=THREAD)
        stroke(axes, hole, (0.0, 3.0), color=THREAD)
        for side in (-1.0, 1.0):
            stroke(axes, (0.07 * side, hole[1]), (0.6 * side, hole[1]), linewidth=2.0)
        letter(axes, (0.0, 0.0), 'C', (-8.0, -5.0))
        note(axes, hole, 'O', (-12.0, 9.0))
        note(axes, (0.0, 3.0), 'power', (0.0, -8.0), color=THREAD)
        if angle:
            _hole_letters(axes, cam, angle)
        else:
            letter(axes, _placed(cam, 0.0, 0.0), 'B', (-10.0, 0.0))
        bare(axes, title)
        axes.set_ylim(3.4, -1.9)
        axes.set_xlim(-2.3, 2.3)
    return figure


def _hole_letters(axes: Axes, cam: Cam, angle: float) -> None:
    """Draw the lever arm and its parallel, and the letters on both."""
    psi, p, arm = float(cam.psi(angle)), float(cam.p(angle)), float(cam.lever_arm(angle))
    lean = psi - angle
    across, along = (math.cos(lean), math.sin(lean)), (-math.sin(lean), math.cos(lean))
    n, foot = (arm * across[0], arm * across[1]), (p * along[0], p * along[1])
    touch = _placed(cam, angle, angle)
    stroke(axes, (0.0, 0.0), n)
    stroke(axes, (0.0, 0.0), foot)
    stroke(axes, foot, touch)
    stroke(axes, n, touch, color=THREAD, linestyle=':')
    letter(axes, n, 'N', (8.0, -4.0))
    letter(axes, foot, 'P', (-8.0, 3.0))
    letter(axes, touch, 'M', (10.0, 1.0))
    letter(axes, _placed(cam, 0.0, angle), 'B', (0.0, 9.0))
    note(axes, (foot[0] + 0.5 * n[0], foot[1] + 0.5 * n[1]), 't', (-3.0, -8.0), color=THREAD)


def _wheel(axes: Axes, cam: Cam, angle: float, reach: float, disc: float | None) -> None:
    """Draw both cheeks in the case, the thread's rest downwards, and the rim of the disc."""
    x, y = turned(*outline(cam, 80, reach), -angle)
    axes.plot(x, y, color=CURVE, linewidth=1.8)
    if disc:
        ring(axes, (0.0, 0.0), disc, edgecolor=FAINT)
    for end, name in ((-1, 'E'), (0, 'F')):
        place = float(x[end]), float(y[end])
        size = math.hypot(*place)
        # towards the axle, downwards on the sheet
        letter(axes, place, name, (-9.0 * place[0] / size, 9.0 * place[1] / size))


def _placed(cam: Cam, angle: float, wheel: float) -> tuple[float, float]:
    """Return the cheek's point of an angle in the case, the wheel being turned."""
    x, y = turned(*cam.contact(angle), -wheel)
    return float(x), float(y)


def weight_period() -> Figure:
    """Draw what a clock loses against the amplitude, and the lever arm of the cam that does not.

    Q = 100 P, on a disc of the cam's own radius (§XX) and of five times that (§XXI).
    """
    figure, (left, right) = sheet(7.2, 3.2, 2)
    angles = np.linspace(0.05, 3.0, 60)
    own = WeightCorrected(BASE_RADIUS, ON_ITS_DISC / BASE_RADIUS**2)
    for cam, part, look, name in (
        (Involute(BASE_RADIUS), 1.0, {'color': THREAD}, 'involute, disc of radius BC'),
        (Involute(BASE_RADIUS), 25.0, {'color': OTHER}, 'involute, disc of 5 BC'),
        (own, 1.0, {'color': CURVE, 'linewidth': 2.0}, "the weight's own cam, disc of BC"),
    ):
        machine = _weight_machine(cam, part)
        loss = [-rate_s_per_day(machine.period(float(a)), machine.small_period) for a in angles]
        left.plot(angles, loss, label=name, **look)
    graph(left, 'amplitude, rad', 'loses, s/day', 'a weight of Q/100 (§XX)')
    left.legend(frameon=False, fontsize=8.0)
    wide = np.linspace(0.0, 5.2, 80)
    right.plot(wide, own.lever_arm(wide) / BASE_RADIUS, color=CURVE, linewidth=2.0)
    right.plot(wide, wide, color=THREAD)
    right.axvline(own.range_rad, color=FAINT, linestyle='--')
    note(right, (own.range_rad, 0.6), 'range', (-6.0, 0.0), ha='right', color=INK)
    note(right, (4.2, 6.3), 'its own cam', (-8.0, 0.0), ha='right', color=CURVE)
    note(right, (4.2, 4.2), 'involute', (6.0, -9.0), ha='left', color=THREAD)
    graph(right, 'angle of the wheel, rad', 'lever arm / BC', 'lever arms, disc of BC')
    return figure


def _weight_machine(cam: Cam, part: float) -> Machine:
    """Return a wheel of `part` times the inertia of §XX under a weight."""
    inertia = part * MASS * BASE_RADIUS**2 / ON_ITS_DISC
    return Machine(inertia, MASS, MASS, 0.0, 0.0, GRAVITY, cam, True, None, None, 0.1)


def lever_machine() -> Figure:
    """Draw Sully's machine (§V) at rest and turned both ways, and its period."""
    figure, panels = sheet(8.2, 3.7, 3, width_ratios=[1.0, 1.0, 1.25])
    shape = LeverGeometry(BASE_RADIUS, 0.1, 0.3)
    for axes, angle, title in (
        (panels[0], 0.0, 'at rest'),
        (panels[1], 2.0, 'turned by 2 rad'),
    ):
        _lever_drawn(axes, shape, angle)
        bare(axes, title)
        axes.set_xlim(-0.125, 0.085)
        axes.set_ylim(-0.355, 0.067)
    machine = LeverMachine(4.0e-4, MASS, 0.15, 0.0, shape, GRAVITY, None, None, 1.0)
    angles = np.linspace(0.02, 2.0, 50)
    excess = [100.0 * (machine.period(float(a)) / machine.small_period - 1.0) for a in angles]
    panels[2].plot(angles, excess, color=CURVE)
    graph(panels[2], 'amplitude, rad', 'period above that of small swings, %', 'its period')
    return figure


def _lever_drawn(axes: Axes, shape: LeverGeometry, angle: float) -> None:
    pose = shape.pose(shape.tau_of(np.array([angle])))
    u, beta, delta, free = (float(part[0]) for part in pose)
    r, fulcrum = shape.base_radius, np.array([-shape.arm, -shape.depth])
    along = np.array([math.sin(delta), -math.cos(delta)])
    touch = r * u * np.array([math.cos(delta), math.sin(delta)]) + r * along
    x, y = turned(*outline(Involute(r), 80, 2.6), -angle)
    axes.plot(x, -y, color=CURVE, linewidth=1.8)
    ring(axes, (0.0, 0.0), 0.064, edgecolor=FAINT)
    tied = touch + free * along
    weight = fulcrum + 0.15 * np.array([math.cos(beta), math.sin(beta)])
    stroke(axes, tuple(touch), tuple(tied), color=THREAD)
    stroke(axes, tuple(fulcrum), tuple(weight), linewidth=2.0)
    axes.plot(fulcrum[0], fulcrum[1] - 0.009, '^', color=INK, markersize=7.0)
    ring(axes, tuple(weight), 0.011, facecolor=INK, fill=True)
    letter(axes, (0.0, 0.0), 'C', (-7.0, 5.0))
    letter(axes, tuple(tied), 'B', (-8.0, 7.0))
    note(axes, tuple(fulcrum), 'A', (-2.0, 10.0))
    note(axes, tuple(weight), 'D', (2.0, 13.0))
    if angle:
        letter(axes, tuple(touch), 'M', (9.0, -4.0))
