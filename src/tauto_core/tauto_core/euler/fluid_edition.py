"""Paper B for its page: its five figures, constructed from the text.

The examples have κ = 3n/8ma of a globe, γ = (m − n)/m = 0.9, lengths in metres.
"""

from __future__ import annotations

import math

import numpy as np

from tauto_core.curves.fluid import FluidTautochrone, abscissa, chained, coordinates
from tauto_core.euler.edition import Control, Drawing, G, View, read_edition
from tauto_core.machines.fluid_pendulum import (
    composed_length,
    descent_time,
    height_at_lowest,
    velocity_height,
)
from tauto_core.samples import FloatArray

GAMMA = 0.9
_KAPPAS = Control('κ, 1/m', (0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9), begin=5)
_ALONG = np.sin(np.linspace(0.0, 0.5 * math.pi, 41))
# Arc of the release in the first figure [m].
_START = 0.55


def _branch(curve: FluidTautochrone, end: float) -> tuple[FloatArray, FloatArray]:
    """Return abscissas and heights of the curve from A to an arc [m]."""
    height, level = coordinates(curve, end * _ALONG)
    return level, height


def _figure_1(kappa: float, part: float) -> View:
    curve = FluidTautochrone(kappa, GAMMA, 1.0)
    arc = part * _START
    b = height_at_lowest(curve, _START)
    drawing = Drawing(-0.12, 0.62, -0.07, 0.42)
    x, y = _branch(curve, 0.65)
    drawing.curve(x, y, 'curve')
    (height, near_height), (level, near_level) = coordinates(curve, np.array([arc, 1.12 * arc]))
    (top,), (start,) = coordinates(curve, np.array([_START]))
    drawing.lines('ink', ((0.0, 0.0), (0.0, 0.4)), ((0.0, height), (level, height)))
    drawing.line((0.0, near_height), (near_level, near_height), look='thin')
    drawing.letters(
        ((0.0, 0.0), 'A', -4.0, -12.0),
        ((0.0, height), 'P', -10.0, -2.0),
        ((0.0, near_height), 'p', -10.0, 3.0),
        ((level, height), 'M', 10.0, -5.0),
        ((near_level, near_height), 'm', 2.0, 11.0),
        ((start, top), 'E', -2.0, 12.0),
        ((float(x[-1]), float(y[-1])), 'C', 10.0, 2.0),
    )
    v = float(velocity_height(curve, arc, b))
    seconds = descent_time(curve, G, arc)
    return View(
        drawing,
        f'*AM = s* = {arc:.3f} m, *AP = x* = {height:.4f} m. From *E* the globe passes *M* with '
        f'*v* = {1e3 * v:.2f} mm and *A* with *b* = {1e3 * b:.2f} mm. From rest at *M* it needs '
        f'{seconds:.6f} s to *A*.',
    )


def _figure_2(descent: float, ascent: float) -> View:
    down, up = (FluidTautochrone(0.75, GAMMA, f) for f in (descent, ascent))
    drawing = Drawing(-0.82, 0.82, -0.08, 0.78)
    # both branches to their cusps, within the sheet
    right, high = _branch(down, min(down.descent_cusp, 0.8))
    across, steep = _branch(up, max(up.ascent_cusp, -0.8))
    drawing.line((0.0, 0.0), (0.0, 0.7), look='thin')
    drawing.curve(right, high, 'curve')
    drawing.curve(across, steep, 'other')
    arc = 0.6 * down.descent_cusp
    # the arc of the ascent from b at A (§34)
    lowest = height_at_lowest(down, arc)
    reach = math.log1p(up.kappa * math.sqrt(2.0 * lowest * ascent)) / up.kappa
    (x,), (y,) = coordinates(down, np.array([arc]))
    (u,), (w,) = coordinates(up, np.array([-reach]))
    drawing.lines('ink', ((0.0, x), (y, x)), ((0.0, u), (w, u)))
    drawing.letters(
        ((0.0, 0.0), 'A', -2.0, -12.0),
        ((0.0, x), 'P', -9.0, 3.0),
        ((y, x), 'M', 10.0, -5.0),
        ((0.0, u), 'Q', 9.0, 3.0),
        ((w, u), 'N', -10.0, -5.0),
    )
    length = composed_length(descent, ascent)
    return View(
        drawing,
        f'*f* = {descent:g} m, *h* = {ascent:g} m: a half swing takes as long as one of a '
        f'pendulum of {length:.5f} m, {math.pi * math.sqrt(length / G):.5f} s, from any start. '
        f'From *AM* = {arc:.4f} m the globe gets to *AN* = {reach:.5f} m.',
    )


def _figure_3(kappa: float) -> View:
    curve = FluidTautochrone(kappa, GAMMA, 1.0)
    drawing = Drawing(-0.12, 1.25, -0.07, 0.86)
    arc = np.linspace(0.0, 1.2, 60)
    height = curve.height(arc)
    mask = height <= 0.8
    drawing.curve(arc[mask], height[mask], 'curve')
    cusp = curve.descent_cusp
    top = float(curve.height(cusp))
    drawing.line((cusp - 0.12, top - 0.12), (cusp + 0.1, top + 0.1), look='other')
    middle = 0.6 * cusp
    low = float(curve.height(middle))
    drawing.lines('ink', ((0.0, 0.0), (0.0, 0.8)), ((0.0, low), (middle, low)))
    drawing.letters(
        ((0.0, 0.0), 'A', -4.0, -11.0),
        ((0.0, low), 'P', -10.0, 2.0),
        ((middle, low), 'M', 10.0, -5.0),
        ((float(arc[mask][-1]), float(height[mask][-1])), 'B', 11.0, 2.0),
    )
    drawing.note((cusp, top), 'ds = dx', 28.0, -8.0)
    return View(
        drawing,
        f'*ds = dx* at *s* = {cusp:.5f} m, *x* = {top:.5f} m: there the tautochrone stands '
        'upright, and turns back.',
    )


def _figure_4(ascent: float) -> View:
    curve, down = (FluidTautochrone(0.75, GAMMA, f) for f in (ascent, 1.0))
    drawing = Drawing(-0.12, 1.9, -0.1, 1.25)
    for branch, sign, look in ((down, 1.0, 'faint'), (curve, -1.0, 'curve')):
        arc = np.linspace(0.0, 1.85, 90)
        height = branch.height(sign * arc)
        mask = height <= 1.2
        drawing.curve(arc[mask], height[mask], look)
    arc_n = 0.5
    low = float(curve.height(-arc_n))
    drawing.lines('ink', ((0.0, 0.0), (0.0, 1.2)), ((0.0, low), (arc_n, low)))
    drawing.letters(
        ((0.0, 0.0), 'A', -4.0, -11.0),
        ((0.0, low), 'Q', -10.0, 2.0),
        ((arc_n, low), 'N', 10.0, -5.0),
    )
    drawing.note((0.95, 1.1), 'descent', -22.0, 0.0)
    cusp = -curve.ascent_cusp
    if math.isinf(cusp):
        return View(
            drawing,
            f'*h* = {ascent:g} m: *3(m − n)nh* is at least *8mma*, *β* = {curve.beta:.4f}. The '
            'curve never gets as steep as *dt = du*, so the ascent has no point of return.',
        )
    top, twin = float(curve.height(-cusp)), float(curve.height(curve.descent_cusp))
    if top < 1.2:
        drawing.line((cusp - 0.15, top - 0.15), (cusp + 0.12, top + 0.12), look='other')
        drawing.note((cusp, top), 'dt = du', 30.0, -8.0)
    return View(
        drawing,
        f'*h* = {ascent:g} m, *β = γκh* = {curve.beta:.4f}: *dt = du* at *t* = {cusp:.5f} m, *u* '
        f'= {top:.5f} m. On the descent of *f = h* it is at *x* = {twin:.5f} m.',
    )


def _figure_5(kappa: float) -> View:
    curve = FluidTautochrone(kappa, GAMMA, 1.0)
    ends = curve.ascent_cusp, curve.descent_cusp
    share = np.sin(np.linspace(-0.5, 0.5, 61) * np.pi)
    arc = np.where(share < 0.0, -ends[0], ends[1]) * share
    chain = np.array([chained(curve, float(s), 1) for s in arc]).T
    x, y = coordinates(curve, arc)
    width = 2.0 * abs(chain[1][0] - chain[1][-1])
    drawing = Drawing(-4.0, 3.0, -0.25, 1.75)
    for shift in (0.0, -width):
        drawing.curve(chain[1] + shift, chain[0], 'faint')
    drawing.curve(y, x, 'curve')
    drawing.letters(
        ((0.0, 0.0), 'A', 0.0, -12.0),
        ((float(y[-1]), float(x[-1])), 'B', 0.0, 11.0),
        ((float(y[0]), float(x[0])), 'C', 0.0, 11.0),
        ((float(chain[1][0]), float(chain[0][0])), 'D', -4.0, 11.0),
        ((float(chain[1][-1]) - width, float(chain[0][-1])), 'E', 4.0, 11.0),
    )
    across = float(abscissa(curve, ends[1]) - abscissa(curve, ends[0]))
    return View(
        drawing,
        f'*B* is {float(x[-1]):.4f} m and *C* {float(x[0]):.4f} m high. *BD* and *CE* are as wide '
        f'as *BC*, {across:.4f} m.',
    )


_LENGTHS = (0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1)
EDITION = read_edition(
    'B',
    'fluid',
    {
        '1': (_figure_1, _KAPPAS, Control('AM : AE', (0.2, 0.35, 0.5, 0.65, 0.8, 0.95), begin=3)),
        '2': (_figure_2, Control('f, m', _LENGTHS, begin=6), Control('h, m', _LENGTHS, begin=3)),
        '3': (_figure_3, _KAPPAS),
        '4': (
            _figure_4,
            Control('h, m', (0.2, 0.4, 0.6, 0.8, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.7, 2.0), begin=4),
        ),
        '5': (_figure_5, _KAPPAS),
    },
)
