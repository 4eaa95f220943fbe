"""The order of the method, in sixty digits, and that the engine is this method to rounding.

In doubles order 16 has no room: where a step is short enough for the leading term to rule, its
error is below rounding. So the same equations are solved in mpmath with steps that are short
enough, and at the length the engine uses the two must give the same state, error of the step and
all.
"""

from __future__ import annotations

import math

import numpy as np
from mpmath import mp
from stress_cases import WELLS, Row, land, machine_of

from tauto_core.machines import Machine
from tauto_core.motion.collocation import Collocation

STAGES = 8
DIGITS = 60
PHASE = 0.77
"""Where the spans begin, in rad after the release: no symmetry of the well is near."""

SPAN = 0.4
"""Their length as an angle [rad]."""


def _gauss() -> tuple[list[mp.mpf], list[mp.mpf], mp.matrix]:
    """Return nodes, weights and coefficients of eight Gauss stages."""
    near = [float(x) for x in np.polynomial.legendre.leggauss(STAGES)[0]]
    roots = [mp.findroot(lambda x: mp.legendre(STAGES, x), (x, x + 1e-9)) for x in near]
    nodes = [(root + 1) / 2 for root in roots]
    powers = mp.matrix(STAGES, STAGES)
    for i in range(STAGES):
        for k in range(STAGES):
            powers[i, k] = nodes[i] ** k
    lagrange = powers**-1

    def integral(j: int, upper: mp.mpf) -> mp.mpf:
        return mp.fsum(lagrange[k, j] * upper ** (k + 1) / (k + 1) for k in range(STAGES))

    coefficients = mp.matrix(STAGES, STAGES)
    for i in range(STAGES):
        for j in range(STAGES):
            coefficients[i, j] = integral(j, nodes[i])
    return nodes, [integral(j, mp.mpf(1)) for j in range(STAGES)], coefficients


class SpringStep:
    """Steps of the spring on a linear lever arm, in the frame that turns with omega."""

    def __init__(self, machine: Machine, omega: float) -> None:
        self._nodes, self._weights, self._coefficients = _gauss()
        self._omega = mp.mpf(omega)
        lever, inertia = mp.mpf(machine.cam.linear_rate), mp.mpf(machine.inertia)
        self._linear = mp.mpf(machine.force) * lever / inertia
        self._cubic = mp.mpf(machine.stiffness) * lever**2 / 2 / inertia

    def __call__(self, x: mp.mpf, y: mp.mpf, h: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
        """Return X and Y after a step of h [s]."""
        omega = self._omega
        cos = [mp.cos(omega * c * h) for c in self._nodes]
        sin = [mp.sin(omega * c * h) for c in self._nodes]
        k1, k2 = [mp.mpf(0)] * STAGES, [mp.mpf(0)] * STAGES
        while True:
            new1, new2 = [], []
            for i in range(STAGES):
                row = [self._coefficients[i, j] for j in range(STAGES)]
                u = x + h * mp.fdot(row, k1)
                v = y + h * mp.fdot(row, k2)
                q = cos[i] * u + sin[i] * v
                more = (omega**2 * q - self._linear * q - self._cubic * q**3) / omega
                new1.append(-sin[i] * more)
                new2.append(cos[i] * more)
            moved = max(abs(a - b) for a, b in zip(new1 + new2, k1 + k2, strict=True))
            k1, k2 = new1, new2
            if moved < mp.mpf(10) ** (8 - DIGITS):
                break
        u, v = x + h * mp.fdot(self._weights, k1), y + h * mp.fdot(self._weights, k2)
        c, s = mp.cos(omega * h), mp.sin(omega * h)
        return c * u + s * v, c * v - s * u


def _after(step: SpringStep, start: tuple[mp.mpf, mp.mpf], steps: int) -> mp.matrix:
    state, h = start, mp.mpf(SPAN) / step._omega / steps
    for _ in range(steps):
        state = step(*state, h)
    return mp.matrix(state)


def order() -> list[Row]:
    """Return the order of the method, and how far the engine is from it."""
    machine = machine_of({**WELLS['spring'], 'release_angle': 1.3})
    engine = Collocation(machine)
    engine._tolerance, engine.longest_step_s = math.inf, math.inf
    with mp.workdps(DIGITS):
        step = SpringStep(machine, engine._omega)
        start = mp.mpf(1.3) * mp.cos(PHASE), -mp.mpf(1.3) * mp.sin(PHASE)
        exact = _after(step, start, 16)
        errors = [mp.norm(_after(step, start, steps) - exact) for steps in (2, 4)]
        measured = float(mp.log(errors[0] / errors[1], 2))
        away = max(_engine_away(engine, step, angle) for angle in (0.3, 1.0, 1.9))
    setting = f'spring, at {PHASE} rad, steps of {SPAN / 2} and {SPAN / 4} rad, 60 digits'
    return [
        Row('order of the method', setting, measured, 16.1, 15.9),
        Row('engine less the method, relative', 'spring, steps of 0.3, 1.0, 1.9 rad', away, 4e-16),
    ]


def _engine_away(engine: Collocation, step: SpringStep, angle: float) -> float:
    """Return how far a step of the engine is from the method's, relative to the amplitude."""
    h = angle / engine._omega
    spans = land(h, 1)
    engine.release(spans)
    start = [mp.mpf(0.9), mp.mpf(-0.6)]
    engine._floats[:4] = float(start[0]), 0.0, float(start[1]), 0.0
    engine.advance(spans)
    x, y = step(start[0], start[1], mp.mpf(h))
    f = [mp.mpf(float(value)) for value in engine._floats[:4]]
    return float(mp.hypot(f[0] + f[1] - x, f[2] + f[3] - y) / mp.hypot(*start))
