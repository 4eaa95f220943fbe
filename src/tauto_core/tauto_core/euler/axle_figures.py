"""The figures of paper C: the axle in its support, the lengths of both modes, other supports."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from tauto_core.euler.sketch import (
    CURVE,
    FAINT,
    INK,
    THREAD,
    Point,
    bare,
    graph,
    letter,
    note,
    ring,
    sheet,
    stroke,
)
from tauto_core.machines.modes import modes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

E, C, K, GRAVITY = 0.1, 0.3, 0.15, 9.81
"""The body of the claims [m, m/s2]."""
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
        period = math.tau * math.sqrt(length / GRAVITY)
        bare(axes, title.format(1e3 * length, period))
        axes.set_xlim(-0.34, 0.34)
        axes.set_ylim(-0.58, 0.05)
    return figure


def _body(axes: Axes, axle: Point, tilt: float, color: str) -> None:
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
    graph(axes, 'e = AO − AC, m', 'length of the simple pendulum, m')
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
    _on_convex(convex)
    turns = np.linspace(-4.0, 12.0, 161)
    found = [modes(1.0 / x if abs(x) > 1e-9 else math.inf, C, K * K) for x in turns]
    pairs = np.array([sorted(each.squared_frequencies(GRAVITY)) for each in found])
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
    graph(course, '1/e, 1/m', 'ω², 1/s²')
    return figure


def _on_convex(axes: Axes) -> None:
    """Draw the body on a convex support, upright and falling off."""
    radius = 0.12
    ring(axes, (0.0, 0.0), radius, edgecolor=INK, linewidth=2.0)
    own = modes(-(radius + AXLE), C, K * K)
    for theta, color in ((0.0, FAINT), (0.5, CURVE)):
        axle = (radius + AXLE) * math.sin(theta), (radius + AXLE) * math.cos(theta)
        _body(axes, axle, theta * own.B_prime / C, color)
    letter(axes, (0.0, 0.0), 'O', (-8.0, 0.0))
    letter(axes, axle, 'C', (9.0, 6.0))
    bare(axes, f'convex: b′ = −{-1e3 * own.b_prime:.0f} mm, it falls')
