"""Paper C for its page: its six figures, constructed from the text.

The body is the example of the claims: e = 0.1 m, c = 0.3 m, k = 0.15 m. The formulas are for small
swings, the figures exaggerate them.
"""

from __future__ import annotations

import math

import numpy as np

from tauto_core.euler.axle_1780 import C, E, K
from tauto_core.euler.edition import Control, Drawing, G, View, read_edition
from tauto_core.machines.axle_pendulum import modes

Place = tuple[float, float]

AXLE = 0.05
"""Radius of the axle of the body of the claims [m]."""


def _below(start: Place, length: float, tilt: float) -> Place:
    """Return the point at a distance below another, tilted from the vertical."""
    return start[0] + length * math.sin(tilt), start[1] - length * math.cos(tilt)


def _body(drawing: Drawing, axle: Place, low: Place, k: float, radius: float = AXLE) -> None:
    """Draw the axle, the line to the centre of gravity, and the circle of gyration about it."""
    drawing.circle(axle, radius, 'curve')
    drawing.line(axle, low, look='curve')
    drawing.circle(low, k, 'faint')


def _meeting(axle: Place, tilt: float) -> Place:
    """Return h, the intersection of gc with the vertical."""
    return 0.0, axle[1] + axle[0] / math.tan(tilt)


def _swings(e: float, c: float, k: float) -> str:
    """Return the lengths of both modes, with the time of a swing or of an e-fold fall."""
    pair = modes(e, c, k * k)
    texts = []
    for name, length in (('*h*', pair.h), ('*h′*', pair.h_prime)):
        if math.isinf(length):
            texts.append(f'{name} is infinite, the axle drifts')
        elif length < 0.0:
            grown = math.sqrt(-length / G)
            texts.append(f'{name} = {length:.5f} m, the body falls, e-fold in {grown:.4f} s')
        else:
            swing = math.pi * math.sqrt(length / G)
            texts.append(f'{name} = {length:.5f} m, a swing takes {swing:.5f} s')
    return ', and '.join(texts) + '.'


# -----------------------------------------------------------------------------
# Table IV: the body from the front, at rest, displaced, and on a plane.


def _figure_3(c: float) -> View:
    drawing = Drawing(-0.6, 0.6, -0.68, 0.12)
    drawing.line((-0.5, -AXLE), (0.5, -AXLE), (0.5, AXLE), (-0.5, AXLE), closed=True)
    for side in (-1.0, 1.0):  # the supports
        end, middle = (0.5 * side, -AXLE), (0.44 * side, -AXLE)
        drawing.lines('heavy', (end, (0.38 * side, -AXLE)), (middle, (0.44 * side, -0.14)))
    turn = np.linspace(0.0, math.tau, 61)
    drawing.curve(0.16 * np.sin(turn), -c - 0.17 * np.cos(turn), 'curve')
    drawing.line((0.0, -AXLE), (0.0, 0.17 - c), look='curve')
    drawing.line((0.0, 0.0), (0.0, -c), look='thread')
    drawing.line((-0.3, -c), (0.3, -c), look='faint')
    drawing.letters(
        ((-0.5, -AXLE), 'A', -10.0, -6.0),
        ((0.5, -AXLE), 'A', 10.0, -6.0),
        ((-0.5, AXLE), 'B', -10.0, 6.0),
        ((0.5, AXLE), 'B', 10.0, 6.0),
        ((0.0, 0.0), 'C', 10.0, 3.0),
        ((0.0, -c), 'G', 9.0, -8.0),
        ((-0.16, -c), 'E', -10.0, 8.0),
        ((0.16, -c), 'F', 10.0, 8.0),
        ((0.0, -c - 0.17), 'D', 0.0, -11.0),
        ((-0.3, -c), 'I', -9.0, 0.0),
        ((0.3, -c), 'K', 9.0, 0.0),
    )
    square = K * K + c * c
    return View(
        drawing,
        f'*GC = c* = {c:g} m. With *k* = {K:g} m about *IK* the moment of inertia about the axis '
        f'of the axle would be *M* times {square:.4f} m².',
    )


def _figure_4(e: float, c: float, k: float) -> View:
    a = e + AXLE
    drawing = Drawing(-0.45, 0.45, -0.95, 0.06, 280.0)
    drawing.arc((0.0, 0.0), a, -0.5 * math.pi - 1.1, -0.5 * math.pi + 1.1, 'ink')
    axle, low = (0.0, -e), (0.0, -e - c)
    _body(drawing, axle, low, k)
    drawing.line((0.0, 0.0), (0.0, -0.93), look='faint')
    side = a * math.sin(1.1)
    drawing.letters(
        ((0.0, 0.0), 'O', -10.0, 4.0),
        (axle, 'C', 9.0, 3.0),
        ((0.0, -a), 'A', -9.0, -7.0),
        ((0.0, AXLE - e), 'B', 10.0, 4.0),
        (low, 'G', 9.0, -4.0),
        ((-side, -a * math.cos(1.1)), 'M', -10.0, 2.0),
        ((side, -a * math.cos(1.1)), 'N', 10.0, 2.0),
    )
    return View(drawing, f'*a* = {a:g} m, *e = a − b* = {e:g} m. {_swings(e, c, k)}')


_MOTIONS = ('slow mode', 'fast mode', 'push n at G')
PUSH = 0.8
"""Velocity n of the centre of gravity after a push without rotation [m/s]."""
_TIMES = tuple(round(0.04 * k, 2) for k in range(1, 36))


def _angles(motion: int, seconds: float) -> tuple[float, float]:
    """Return θ and Φ of a motion from equilibrium at a time [rad]."""
    pair = modes(E, C, K * K)
    slow, fast = (math.sqrt(G / length) for length in (pair.h, pair.h_prime))
    if motion == 0:
        rates = 0.35 * slow / C, 0.0
    elif motion == 1:
        rates = 0.0, 0.6 * fast / C
    else:
        # dΦ/dt = 0 and e dθ/dt = n
        rate = PUSH / (E * C * (1.0 - pair.B / pair.B_prime))
        rates = rate, -rate * pair.B / pair.B_prime
    z = rates[0] / slow * math.sin(slow * seconds), rates[1] / fast * math.sin(fast * seconds)
    return C * (z[0] + z[1]), pair.B * z[0] + pair.B_prime * z[1]


def _figure_5(motion: float, seconds: float) -> View:
    theta, phi = _angles(int(motion), seconds)
    a = E + AXLE
    drawing = Drawing(-0.38, 0.38, -0.62, 0.16, 300.0)
    drawing.arc((0.0, 0.0), a, -0.5 * math.pi - 1.3, -0.5 * math.pi + 1.3, 'ink')
    axle, touch = _below((0.0, 0.0), E, theta), _below((0.0, 0.0), a, theta)
    low = _below(axle, C, phi)
    _body(drawing, axle, low, K)
    drawing.line((0.0, 0.15), (0.0, -0.6), look='faint')
    drawing.lines('thin', ((0.0, 0.0), touch), ((0.0, low[1]), low), ((0.0, axle[1]), axle))
    # the letters of the vertical are on the side opposite to the axle
    side = math.copysign(1.0, theta)
    drawing.letters(
        ((0.0, 0.0), 'O', -10.0 * side, 4.0),
        ((0.0, -a), 'A', -9.0 * side, -8.0),
        ((0.0, -E), 'C', -10.0 * side, -6.0),
        ((0.0, low[1]), 'p', -math.copysign(9.0, phi), -4.0),
        ((0.0, axle[1]), 'q', -9.0 * side, 9.0),
        (axle, 'c', 10.0 * side, 3.0),
        (touch, 'a', -8.0 * side, 9.0),
        (low, 'g', math.copysign(10.0, phi), -5.0),
    )
    if abs(phi) > 0.02 and -0.55 < (h := _meeting(axle, phi))[1] < 0.12:
        drawing.line(axle, h, look='faint')
        drawing.letter(h, 'h', -9.0 * side, -9.0)
    return View(
        drawing,
        f'{_MOTIONS[int(motion)]}, {seconds:.2f} s from equilibrium: *θ = AOa* = {theta:.5f}, '
        f'*Φ = Ahg* = {phi:.5f}, *x = Op* = {-low[1]:.4f} m, *y = pg* = {low[0]:.4f} m.',
    )


def _figure_6(phi: float, c: float, k: float) -> View:
    drawing = Drawing(-0.45, 0.45, -0.65, 0.12, 320.0)
    drawing.line((-0.42, -AXLE), (0.42, -AXLE), look='heavy')
    axle = -c * math.sin(phi), 0.0
    low = _below(axle, c, phi)
    _body(drawing, axle, low, k)
    drawing.line((0.0, 0.1), (0.0, -0.63), look='faint')
    drawing.letters(
        ((0.0, -AXLE), 'A', 8.0, -9.0),
        ((-0.42, -AXLE), 'M', -1.0, -11.0),
        ((0.42, -AXLE), 'N', 1.0, -11.0),
        (low, 'g', 10.0, 0.0),
        (axle, 'c', -9.0, 7.0),
        ((axle[0], -AXLE), 'a', -9.0, -8.0),
    )
    h = k * k / c
    return View(
        drawing,
        f'The axle is at {axle[0]:.4f} m = *−c sin Φ*, *g* in its vertical. A swing takes '
        f'{math.pi * math.sqrt(h / G):.5f} s, as of a pendulum *kk/c* = {h:.5f} m.',
    )


# -----------------------------------------------------------------------------
# Table V: the convex support and the cradle.


def _figure_v_1(i: float, c: float, k: float) -> View:
    pair = modes(-i, c, k * k)
    radius = i - AXLE
    theta = 0.45
    drawing = Drawing(-0.5, 0.5, -0.55, 0.36, 320.0)
    # O is at the origin, the axle above it
    drawing.arc((0.0, 0.0), radius, 0.1, math.pi - 0.1, 'ink')
    origin = (0.0, i)
    axle = i * math.sin(theta), i * math.cos(theta)
    touch = radius * math.sin(theta), radius * math.cos(theta)
    tilt = theta * pair.B_prime / c
    low = _below(axle, c, tilt)
    drawing.circle(origin, AXLE, 'faint')
    _body(drawing, axle, low, k)
    drawing.line((0.0, 0.35), (0.0, -0.52), look='faint')
    drawing.line((0.0, 0.0), axle, look='thin')
    drawing.letters(
        ((0.0, 0.0), 'O', -10.0, -4.0),
        (origin, 'C', -10.0, 6.0),
        ((0.0, radius), 'A', -9.0, -8.0),
        ((-radius * math.cos(0.1), radius * math.sin(0.1)), 'M', -10.0, 3.0),
        ((radius * math.cos(0.1), radius * math.sin(0.1)), 'N', 11.0, 3.0),
        (axle, 'c', 9.0, 7.0),
        (touch, 'a', -7.0, -9.0),
        (low, 'g', 10.0, -4.0),
    )
    return View(drawing, f'*OC = i* = {i:g} m. {_swings(-i, c, k)}')


ROCKER = 0.5
"""Radius of the rockers of the cradle [m]."""


def _figure_v_2(e: float, c: float, k: float) -> View:
    pair = modes(e, c, k * k)
    ratio = (pair.B if pair.h > 0.0 else pair.B_prime) / c
    theta = min(0.22, 0.5 / abs(ratio))
    a = e + ROCKER
    drawing = Drawing(-1.0, 1.0, -1.75, 0.12, 320.0)
    drawing.arc((0.0, 0.0), a, -0.5 * math.pi - 0.6, -0.5 * math.pi + 0.6, 'ink')
    axle, touch = _below((0.0, 0.0), e, theta), _below((0.0, 0.0), a, theta)
    tilt = theta * ratio
    low = _below(axle, c, tilt)
    drawing.circle(axle, ROCKER, 'thin')
    # the rockers, up to the cradle's edge
    drawing.arc(axle, ROCKER, -0.5 * math.pi + tilt - 1.2, -0.5 * math.pi + tilt + 1.2, 'curve')
    drawing.line(*(_below(axle, ROCKER, tilt + side) for side in (-1.2, 1.2)), look='curve')
    drawing.circle(low, k, 'faint')
    drawing.line(axle, low, look='curve')
    drawing.line((0.0, 0.05), (0.0, -1.7), look='faint')
    drawing.line((0.0, 0.0), touch, look='thin')
    h = _meeting(axle, tilt)
    if -1.7 < h[1] < 0.1:
        drawing.line(axle, h, look='faint')
        drawing.letter(h, 'h', -9.0, -2.0)
    drawing.letters(
        ((0.0, 0.0), 'O', -10.0, -2.0),
        ((0.0, -e), 'C', -10.0, 4.0),
        ((0.0, -e - c), 'G', 9.0, 7.0),
        ((0.0, -a), 'A', -9.0, -9.0),
        (_below((0.0, 0.0), a, -0.6), 'M', -10.0, 3.0),
        (_below((0.0, 0.0), a, 0.6), 'N', 10.0, 3.0),
        (axle, 'c', 10.0, 6.0),
        (low, 'g', 10.0, -3.0),
        (touch, 'a', 9.0, -9.0),
    )
    return View(drawing, f'*OC = e* = {e:g} m. {_swings(e, c, k)}')


_C = Control('c, m', (0.1, 0.2, 0.3, 0.4), begin=2)
_K = Control('k, m', (0.05, 0.1, 0.15, 0.2), begin=2)
EDITION = read_edition(
    'C',
    'axle',
    {
        'Tab. IV, 3': (_figure_3, _C),
        'Tab. IV, 4': (_figure_4, Control('e, m', (0.01, 0.03, 0.1, 0.2, 0.3), begin=2), _C, _K),
        'Tab. IV, 5': (
            _figure_5,
            Control('motion', (0.0, 1.0, 2.0), begin=0, names=_MOTIONS),
            Control('time, s', _TIMES, begin=7),
        ),
        'Tab. IV, 6': (
            _figure_6,
            Control('Φ, rad', tuple(round(0.15 * k, 2) for k in range(-4, 5)), begin=6),
            Control('c, m', (0.2, 0.3, 0.4), begin=1),
            Control('k, m', (0.05, 0.1, 0.15), begin=2),
        ),
        'Tab. V, 1': (_figure_v_1, Control('i, m', (0.15, 0.2, 0.25), begin=1), _C, _K),
        'Tab. V, 2': (
            _figure_v_2,
            Control('e, m', (0.4, 0.7, 1.0), begin=1),
            Control('c, m', (-0.1, 0.1, 0.2, 0.3), begin=2),
            Control('k, m', (0.2, 0.3, 0.4), begin=1),
        ),
    },
)
