"""The figures of the page of claims: constructed from the text, with Euler's letters, as files."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tauto_core.curves import Hole, Involute, WeightCorrected
from tauto_core.curves.cam import Cam
from tauto_core.curves.drawing import outline
from tauto_core.curves.fluid import Cycloid, FluidTautochrone, chained, coordinates, fluid_outline
from tauto_core.curves.lever_geometry import LeverGeometry
from tauto_core.euler.edition import G, Paper, read_text, turned
from tauto_core.files import LOOK, write_whole
from tauto_core.machines.axle_pendulum import modes
from tauto_core.machines.compiling import rate_s_per_day
from tauto_core.machines.fluid_pendulum import (
    arcs,
    duration_excess,
    greatest_velocity_height,
    quarter_ratios,
    velocity_height,
)
from tauto_core.machines.threads.lever import LeverMachine
from tauto_core.machines.trochlea import Machine

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# -----------------------------------------------------------------------------
# Parts of the figures of the page of claims: strokes, points with letters, bare axes.

INK, CURVE, THREAD, FAINT, OTHER = '#222222', '#1f4e8c', '#b03a2e', '#9a9a9a', '#2e7d4f'

_Point = tuple[float, float]


def sheet(width: float, height: float, columns: int = 1, **options: Any) -> tuple[Figure, Any]:
    """Return a figure of a size [inch] and its panels, side by side: (columns,) of axes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout='constrained')
    return figure, figure.subplots(1, columns, squeeze=False, **options)[0]


def bare(axes: Axes, title: str = '') -> None:
    """Make a panel a drawing: equal scales, no frame."""
    axes.set_aspect('equal')
    axes.set_axis_off()
    axes.set_title(title, fontsize=9.0)


def named_axes(axes: Axes, across: str, up: str, title: str = '') -> None:
    """Make a panel a graph with named axes."""
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.set_title(title, fontsize=9.0)
    axes.grid(True, color='#dddddd', linewidth=0.6)
    axes.spines[['top', 'right']].set_visible(False)


def stroke(axes: Axes, start: _Point, end: _Point, **look: Any) -> None:
    """Draw a straight line."""
    drawn: dict[str, Any] = {'color': INK, 'linewidth': 0.9} | look
    axes.plot([start[0], end[0]], [start[1], end[1]], **drawn)


def ring(axes: Axes, centre: _Point, radius: float, **look: Any) -> None:
    """Draw a circle."""
    from matplotlib.patches import Circle

    axes.add_patch(Circle(centre, radius, **({'fill': False, 'edgecolor': INK} | look)))


def letter(axes: Axes, at: _Point, text: str, offset: _Point = (5.0, 3.0), **look: Any) -> None:
    """Mark a point and write its letter beside it, at an offset in printer's points."""
    axes.plot(*at, 'o', markersize=2.8, color=INK, zorder=5)
    note(axes, at, text, offset, **look)


def note(axes: Axes, at: _Point, text: str, offset: _Point = (5.0, 3.0), **look: Any) -> None:
    """Write beside a point."""
    style: dict[str, Any] = {'fontsize': 9.0, 'ha': 'center', 'va': 'center', 'zorder': 6} | look
    axes.annotate(text, at, offset, textcoords='offset points', **style)


# -----------------------------------------------------------------------------
# The figures of paper A: Euler's two cams, the cost of the weight, Sully's lever machine.

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
    x, y = turned(outline(cam, 80, reach), -angle)
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
    x, y = turned(cam.contact(angle), -wheel)
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
        # a wheel of `part` times the inertia of §XX
        inertia = part * MASS * BASE_RADIUS**2 / ON_ITS_DISC
        machine = Machine(inertia, MASS, MASS, 0.0, 0.0, G, cam, True, None, None, 0.1)
        loss = [-rate_s_per_day(machine.period(float(a)), machine.small_period) for a in angles]
        left.plot(angles, loss, label=name, **look)
    named_axes(left, 'amplitude, rad', 'loses, s/day', 'a weight of Q/100 (§XX)')
    left.legend(frameon=False, fontsize=8.0)
    wide = np.linspace(0.0, 5.2, 80)
    right.plot(wide, own.lever_arm(wide) / BASE_RADIUS, color=CURVE, linewidth=2.0)
    right.plot(wide, wide, color=THREAD)
    right.axvline(own.range_rad, color=FAINT, linestyle='--')
    note(right, (own.range_rad, 0.6), 'range', (-6.0, 0.0), ha='right', color=INK)
    note(right, (4.2, 6.3), 'its own cam', (-8.0, 0.0), ha='right', color=CURVE)
    note(right, (4.2, 4.2), 'involute', (6.0, -9.0), ha='left', color=THREAD)
    named_axes(right, 'angle of the wheel, rad', 'lever arm / BC', 'lever arms, disc of BC')
    return figure


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
    machine = LeverMachine(4.0e-4, MASS, 0.15, 0.0, shape, G, None, None, 1.0)
    angles = np.linspace(0.02, 2.0, 50)
    excess = [100.0 * (machine.period(float(a)) / machine.small_period - 1.0) for a in angles]
    panels[2].plot(angles, excess, color=CURVE)
    named_axes(panels[2], 'amplitude, rad', 'period above that of small swings, %', 'its period')
    return figure


def _lever_drawn(axes: Axes, shape: LeverGeometry, angle: float) -> None:
    pose = shape.pose(shape.tau_of(np.array([angle])))
    u, beta, delta, free = (float(part[0]) for part in pose)
    r, fulcrum = shape.base_radius, np.array([-shape.arm, -shape.depth])
    along = np.array([math.sin(delta), -math.cos(delta)])
    touch = r * u * np.array([math.cos(delta), math.sin(delta)]) + r * along
    x, y = turned(outline(Involute(r), 80, 2.6), -angle)
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


# -----------------------------------------------------------------------------
# The figures of paper B: the curve with its cusps, speeds along it, reverse half swings.

KAPPA, GAMMA, LENGTH = 0.75, 0.9, 1.0
"""A globe of 5 cm with a tenth of its density in the fluid, f = 1 m: β = 0.675."""
AT_LOWEST = 0.12
"""b, the height of fall of the speed at A [m]."""


def curve_in_fluid() -> Figure:
    """Draw MAN from cusp to cusp, its mirrored continuation, and the cycloid of the same f."""
    figure, (axes,) = sheet(7.2, 2.2)
    curve = FluidTautochrone(KAPPA, GAMMA, LENGTH)
    ends = curve.ascent_cusp, curve.descent_cusp
    share = np.sin(np.linspace(-0.5, 0.5, 81) * np.pi)
    arc = np.where(share < 0.0, -ends[0], ends[1]) * share
    right = np.array([chained(curve, float(s), 1) for s in arc]).T
    # from cusp to cusp all arcs are congruent: the one on the left is the same as on the right
    width = 2.0 * abs(right[1][0] - right[1][-1])
    for shift in (0.0, -width):
        axes.plot(right[1] + shift, right[0], color=CURVE, linewidth=1.2, linestyle='--')
    x, y = coordinates(curve, arc)
    axes.plot(y, x, color=CURVE, linewidth=2.0)
    axes.plot(*fluid_outline(Cycloid(KAPPA, GAMMA, LENGTH), 81), color=THREAD, linewidth=1.0)
    letter(axes, (0.0, 0.0), 'A', (0.0, -9.0))
    letter(axes, (y[-1], x[-1]), 'B', (0.0, 9.0))
    letter(axes, (y[0], x[0]), 'C', (0.0, 9.0))
    # on the branches, a part of the way to their cusps
    letter(axes, (float(y[57]), float(x[57])), 'M', (8.0, -6.0))
    letter(axes, (float(y[24]), float(x[24])), 'N', (-8.0, -7.0))
    letter(axes, (float(right[1][0]), float(right[0][0])), 'D', (0.0, 9.0))
    letter(axes, (float(right[1][-1]) - width, float(right[0][-1])), 'E', (0.0, 9.0))
    note(axes, (0.0, 0.4), 'cycloid', (0.0, 0.0), color=THREAD)
    bare(axes)
    return figure


def speed_along_arc() -> Figure:
    """Draw v along a half swing, with the arc of the greatest speed before A."""
    figure, (axes,) = sheet(6.4, 3.3)
    curve = FluidTautochrone(KAPPA, GAMMA, LENGTH)
    found = arcs(curve, AT_LOWEST)
    s = np.linspace(-found.ascent, found.descent, 160)
    axes.plot(s, 1e3 * velocity_height(curve, s, AT_LOWEST), color=CURVE, linewidth=2.0)
    free = FluidTautochrone(0.0, GAMMA, LENGTH)
    reach = arcs(free, AT_LOWEST).ascent
    t = np.linspace(-reach, reach, 160)
    axes.plot(t, 1e3 * velocity_height(free, t, AT_LOWEST), color=THREAD, linewidth=1.0)
    top = 1e3 * greatest_velocity_height(curve, AT_LOWEST)
    axes.vlines([0.0, found.loss], 0.0, [1e3 * AT_LOWEST, top], color=FAINT, linestyle='--')
    letter(axes, (0.0, 1e3 * AT_LOWEST), 'b', (8.0, -10.0))
    letter(
        axes,
        (found.loss, top),
        f'fastest, {1e3 * found.loss:.0f} mm before A',
        (8.0, 8.0),
        ha='left',
    )
    note(
        axes,
        (-0.16, 1e3 * AT_LOWEST),
        'without resistance',
        (-22.0, 4.0),
        ha='right',
        color=THREAD,
    )
    note(axes, (0.0, 22.0), 'A', (7.0, 0.0))
    for place, name, size in (
        (0.325, 'descent', found.descent),
        (-0.2, 'ascent', found.ascent),
    ):
        note(axes, (place, 14.0), f'arc of {name}\n{1e3 * size:.0f} mm', (0.0, 0.0), fontsize=8.5)
    named_axes(axes, 'arc from A, m (the body moves to the left)', 'v, mm')
    axes.set_ylim(0.0, 1.15 * top)
    axes.set_xlim(-0.7, 0.75)
    return figure


def backward_swing() -> Figure:
    """Draw the time of the reverse half swing and of its quarters against q = 1 − e^{−κs}."""
    figure, (left, right) = sheet(7.2, 3.1, 2)
    q = np.concatenate([np.linspace(0.004, 0.9, 80), 1.0 - np.geomspace(0.1, 0.01, 30)[1:]])
    start = -np.log1p(-q)
    ratio = 1.0 + duration_excess(1.0, start)
    down, up = np.array([quarter_ratios(1.0, float(s)) for s in start]).T
    left.plot(q, down, color=THREAD, label='quarter down NA')
    left.plot(q, ratio, color=CURVE, linewidth=2.0, label='half swing')
    left.plot(q, up, color=OTHER, label='quarter up AM')
    left.axhline(1.0, color=INK, linewidth=0.8)
    named_axes(left, 'q', 'time by that of the swing forward', 'down the branch of ascent')
    left.legend(frameon=False, fontsize=8.0)
    small = q <= 0.5
    right.plot(q[small], 100.0 * (ratio[small] - 1.0), color=CURVE, linewidth=2.0, label='exact')
    right.plot(
        q[small], 100.0 * 5.0 / 12.0 * q[small] ** 2, color=FAINT, linestyle='--', label='5q²/12'
    )
    named_axes(right, 'q', 'half swing too long, %', 'the quarters cancel to first order')
    right.legend(frameon=False, fontsize=8.0)
    return figure


# -----------------------------------------------------------------------------
# The figures of paper C: the axle in its support, the lengths of both modes, other supports.

E, C, K = 0.1, 0.3, 0.15
"""The body of the claims [m]."""
AXLE = 0.05
"""Radius of the axle [m]; Euler's AC, with the support's AO = e + AC."""


def both_modes() -> Figure:
    """Draw both normal modes at the two ends of their swing: θ : φ = c : B and c : B′."""
    figure, panels = sheet(6.4, 3.5, 2)
    own = modes(E, C, K * K)
    for axes, theta, ratio, length, title in (
        (panels[0], 0.35, own.B, own.b, 'slow mode: b = {:.1f} mm, {:.3f} s'),
        (panels[1], 0.7, own.B_prime, own.b_prime, 'fast mode: b′ = {:.1f} mm, {:.3f} s'),
    ):
        support = E + AXLE
        turn = np.linspace(-1.25, 1.25, 60)
        axes.plot(support * np.sin(turn), -support * np.cos(turn), color=INK, linewidth=2.0)
        for side, color in ((-1.0, FAINT), (1.0, CURVE)):
            tilt, phi = side * theta, side * theta * ratio / C
            axle = E * math.sin(tilt), -E * math.cos(tilt)
            _body(axes, axle, phi, color)
            stroke(axes, (0.0, 0.0), axle, linestyle='--', color=color)
        low = axle[0] + C * math.sin(phi), axle[1] - C * math.cos(phi)
        letter(axes, (0.0, 0.0), 'O', (0.0, 9.0))
        letter(axes, axle, 'C', (8.0, 6.0))
        touch = support * math.sin(tilt), -support * math.cos(tilt)
        letter(axes, touch, 'A', (10.0, -5.0))
        letter(axes, low, 'G', (9.0, -3.0))
        period = math.tau * math.sqrt(length / G)
        bare(axes, title.format(1e3 * length, period))
        axes.set_xlim(-0.34, 0.34)
        axes.set_ylim(-0.58, 0.05)
    return figure


def _body(axes: Axes, axle: _Point, tilt: float, color: str) -> None:
    """Draw the axle, the line to the centre of gravity and the circle of gyration about it."""
    low = axle[0] + C * math.sin(tilt), axle[1] - C * math.cos(tilt)
    ring(axes, axle, AXLE, edgecolor=color, linewidth=1.6)
    stroke(axes, axle, low, color=color, linewidth=1.6)
    ring(axes, low, K, edgecolor=color, linewidth=1.0)


def mode_lengths() -> Figure:
    """Draw b and b′ against e with their limits on a knife-edge and on a plane."""
    figure, (axes,) = sheet(6.0, 3.6)
    e = np.geomspace(1e-3, 1e2, 120)
    found = [modes(float(each), C, K * K) for each in e]
    axes.loglog(e, [each.b for each in found], color=CURVE, linewidth=2.0)
    axes.loglog(e, [each.b_prime for each in found], color=THREAD, linewidth=2.0)
    axes.loglog(e, e + C, color=FAINT, linestyle='--', linewidth=1.0, zorder=1)
    axes.axhline(C + K * K / C, color=FAINT, linestyle=':', linewidth=1.0, zorder=1)
    axes.axhline(K * K / C, color=FAINT, linestyle='--', linewidth=1.0, zorder=1)
    for height, text, offset in (
        (C + K * K / C, 'c + k²/c', (0.0, 6.0)),
        (K * K / C, 'k²/c', (0.0, 6.0)),
    ):
        note(axes, (1.3e-3, height), text, offset, ha='left')
    note(axes, (20.0, 20.0 + C), 'e + c', (-6.0, 8.0), ha='right')
    note(axes, (20.0, 20.0), 'b', (6.0, -10.0), color=CURVE)
    note(axes, (8e-3, modes(8e-3, C, K * K).b_prime), 'b′', (6.0, -10.0), color=THREAD)
    named_axes(axes, 'e = AO − AC, m', 'length of the simple pendulum, m')
    return figure


def other_supports() -> Figure:
    """Draw the plane and the convex support, and ω² = g/b through both."""
    figure, panels = sheet(8.4, 3.3, 3, width_ratios=[1.0, 1.0, 1.4])
    plane, convex, course = panels
    stroke(plane, (-0.24, -AXLE), (0.24, -AXLE), linewidth=2.0)
    for side, color in ((-1.0, FAINT), (1.0, CURVE)):
        phi = 0.5 * side
        axle = -C * math.sin(phi), 0.0
        _body(plane, axle, phi, color)
    low = 0.0, -C * math.cos(0.5)
    stroke(plane, (0.0, 0.08), (0.0, -0.52), linestyle='--', color=FAINT)
    letter(plane, axle, 'C', (0.0, 8.0))
    letter(plane, low, 'G', (9.0, 2.0))
    bare(plane, 'plane: G keeps to its vertical')
    # upright, and falling off
    radius = 0.12
    ring(convex, (0.0, 0.0), radius, edgecolor=INK, linewidth=2.0)
    own = modes(-(radius + AXLE), C, K * K)
    for theta, color in ((0.0, FAINT), (0.5, CURVE)):
        axle = (radius + AXLE) * math.sin(theta), (radius + AXLE) * math.cos(theta)
        _body(convex, axle, theta * own.B_prime / C, color)
    letter(convex, (0.0, 0.0), 'O', (-8.0, 0.0))
    letter(convex, axle, 'C', (9.0, 6.0))
    bare(convex, f'convex: b′ = −{-1e3 * own.b_prime:.0f} mm, it falls')
    turns = np.linspace(-4.0, 12.0, 161)
    found = [modes(1.0 / x if abs(x) > 1e-9 else math.inf, C, K * K) for x in turns]
    pairs = np.array([sorted(each.squared_frequencies(G)) for each in found])
    course.plot(turns, pairs[:, 1], color=THREAD, linewidth=2.0)
    course.plot(turns, pairs[:, 0], color=CURVE, linewidth=2.0)
    course.axhline(0.0, color=INK, linewidth=0.8)
    course.axvspan(-4.0, 0.0, color='#f3e3e1', linewidth=0.0)
    note(course, (-2.0, 260.0), 'convex:\none falls', (0.0, 0.0), fontsize=8.5)
    note(course, (6.0, 260.0), 'hollow:\nboth swing', (0.0, 0.0), fontsize=8.5)
    note(course, (9.0, float(pairs[130, 1])), 'g/b′', (-14.0, 4.0), color=THREAD)
    note(course, (9.0, float(pairs[130, 0])), 'g/b', (0.0, 8.0), color=CURVE)
    # on a plane b is infinite; on convex supports b′ is the negative one
    note(course, (-2.0, float(pairs[20, 1])), 'g/b', (-8.0, 9.0), color=THREAD)
    note(course, (-2.0, float(pairs[20, 0])), 'g/b′', (12.0, -8.0), color=CURVE)
    named_axes(course, '1/e, 1/m', 'ω², 1/s²')
    return figure


@dataclass(frozen=True)
class EngravedPlate:
    """A figure of the page: its file's name, paper, caption (paragraph and content), drawing."""

    name: str
    paper: Paper
    caption: str
    draw: Callable[[], Figure]


_DRAWN: dict[tuple[Paper, str], dict[str, Callable[[], Figure]]] = {
    ('A', 'trochlea'): {
        'a_involute': involute_cheeks,
        'a_hole': hole_cheeks,
        'a_period': weight_period,
        'a_lever': lever_machine,
    },
    ('B', 'fluid'): {
        'b_curve': curve_in_fluid,
        'b_speed': speed_along_arc,
        'b_backward': backward_swing,
    },
    ('C', 'axle'): {
        'c_modes': both_modes,
        'c_lengths': mode_lengths,
        'c_supports': other_supports,
    },
}
PLATES = tuple(
    EngravedPlate(name, paper, read_text(file)['plates'][name], draw)
    for (paper, file), drawn in _DRAWN.items()
    for name, draw in drawn.items()
)
"""The figures in the order of the papers."""


def write_plates(folder: Path) -> list[Path]:
    """Write every figure as SVG, the same bytes each time; return the files."""
    import matplotlib as mpl

    files = []
    for plate in PLATES:
        file = folder / f'{plate.name}.svg'
        with mpl.rc_context(LOOK):
            drawn = BytesIO()
            plate.draw().savefig(drawn, format='svg', metadata={'Date': None})
        write_whole(file, drawn.getvalue())
        files.append(file)
    return files
