"""The figures of paper B: the curve with its cusps, speeds along it, reverse half swings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tauto_core.curves.descent_curve import Cycloid
from tauto_core.curves.fluid_outline import chained, coordinates, fluid_outline
from tauto_core.curves.fluid_tautochrone import FluidTautochrone
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
    sheet,
)
from tauto_core.machines.descent import arcs, greatest_velocity_height, velocity_height
from tauto_core.machines.reverse_swing import duration_excess, quarter_ratios

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
    graph(axes, 'arc from A, m (the body moves to the left)', 'v, mm')
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
    graph(left, 'q', 'time by that of the swing forward', 'down the branch of ascent')
    left.legend(frameon=False, fontsize=8.0)
    small = q <= 0.5
    right.plot(q[small], 100.0 * (ratio[small] - 1.0), color=CURVE, linewidth=2.0, label='exact')
    right.plot(
        q[small], 100.0 * 5.0 / 12.0 * q[small] ** 2, color=FAINT, linestyle='--', label='5q²/12'
    )
    graph(right, 'q', 'half swing too long, %', 'the quarters cancel to first order')
    right.legend(frameon=False, fontsize=8.0)
    return figure
