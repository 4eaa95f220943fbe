"""Rows of the stress table on the step of the engine: reversal in time, order of the method."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from mpmath import mp
from stress_cases import WELLS, Row, land, machine_of

from tauto_core.machines import Machine
from tauto_core.motion.collocation import Collocation
from tauto_core.motion.gauss_step import make_work
from tauto_core.motion.wheel import WHEEL_NODES
from tauto_core.samples import FloatArray

# -----------------------------------------------------------------------------
# On land, forth and back in time.


def _state(engine: Collocation) -> FloatArray:
    (plane,) = engine._state['planes']
    return np.array([plane['x'] + plane['x_rest'], plane['y'] + plane['y_rest']])


KINKED_REVERSAL = 3e-11
"""Limit for a thousand swings, each over two kinks [rad]. Both kinks round in the same way, by
about 1e-17 of the state. On land that adds up, and the phase error grows with the square of the
swings.
"""


def reversal(swings: int = 1000) -> list[Row]:
    """Return the wheel's distance from its release after swings forth and back in time."""
    rows = []
    for name, well in WELLS.items():
        machine = machine_of(well)
        engine = Collocation(machine)
        step = engine.longest_step_s
        # the method is symmetric, but the choice of smaller steps is not
        engine._tolerance = engine._tolerance._replace(step=math.inf)
        spans = land(step, round(swings * machine.period(1.0) / step))
        engine.release(spans)
        start = _state(engine)
        engine.advance(spans)
        for part in ('y', 'y_rest'):
            engine._state['planes'][part] *= -1.0
        engine.advance(spans)
        away = float(np.max(np.abs(_state(engine) - start * [1.0, -1.0])))
        rows.append(
            Row(
                'time reversal, distance from the release [rad]',
                f'{name}, {swings} swings',
                away,
                KINKED_REVERSAL if machine.cam.kinked else 1e-11,
            )
        )
    return rows


# -----------------------------------------------------------------------------
# The order of the method, in many digits, and that the engine equals this method to rounding.
#
# Orders 16 and 32 cannot be observed in doubles: where a step is short enough for the leading term
# of the error to dominate, that error is below rounding. So the same equations are solved in
# mpmath with sufficiently short steps. At the step length of the engine both must give the same
# state, including the error of the step.

SPANS_FROM_RAD = 0.77
"""Beginning of the spans, in rad after the release, away from any symmetry of the well."""


@dataclass(frozen=True)
class Method:
    """A number of stages, and the setting in which its order shows.

    Attributes:
        stages: S, of order 2S.
        digits: number of digits of the arithmetic.
        span: length of the spans as an angle [rad]; done in 2, 4 and, for the truth, 16 steps.
        steps: angles at which the engine is compared [rad].
    """

    stages: int
    digits: int
    span: float
    steps: tuple[float, ...]


METHODS = Method(8, 60, 0.4, (0.3, 1.0, 1.9)), Method(16, 130, 0.2, (1.0, 2.5, 4.0))


def _gauss(stages: int) -> tuple[list[mp.mpf], list[mp.mpf], mp.matrix]:
    """Return nodes, weights and coefficients of so many Gauss stages."""
    near = [float(x) for x in np.polynomial.legendre.leggauss(stages)[0]]
    roots = [mp.findroot(lambda x: mp.legendre(stages, x), (x, x + 1e-9)) for x in near]
    nodes = [(root + 1) / 2 for root in roots]
    powers = mp.matrix(stages, stages)
    for i in range(stages):
        for k in range(stages):
            powers[i, k] = nodes[i] ** k
    lagrange = powers**-1

    def integral(j: int, upper: mp.mpf) -> mp.mpf:
        return mp.fsum(lagrange[k, j] * upper ** (k + 1) / (k + 1) for k in range(stages))

    coefficients = mp.matrix(stages, stages)
    for i in range(stages):
        for j in range(stages):
            coefficients[i, j] = integral(j, nodes[i])
    return nodes, [integral(j, mp.mpf(1)) for j in range(stages)], coefficients


class SpringStep:
    """Steps of the spring on a linear lever arm, in the frame that rotates with omega."""

    def __init__(self, machine: Machine, omega: float, stages: int) -> None:
        self._stages = stages
        self._nodes, self._weights, self._coefficients = _gauss(stages)
        self._omega = mp.mpf(omega)
        lever, inertia = mp.mpf(machine.cam.linear_rate), mp.mpf(machine.inertia)
        self._linear = mp.mpf(machine.force) * lever / inertia
        self._cubic = mp.mpf(machine.stiffness) * lever**2 / 2 / inertia

    def __call__(self, x: mp.mpf, y: mp.mpf, h: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
        """Return X and Y after a step of h [s]."""
        omega = self._omega
        cos = [mp.cos(omega * c * h) for c in self._nodes]
        sin = [mp.sin(omega * c * h) for c in self._nodes]
        stages = range(self._stages)
        k1, k2 = [mp.mpf(0) for _ in stages], [mp.mpf(0) for _ in stages]
        while True:
            new1, new2 = [], []
            for i in stages:
                row = [self._coefficients[i, j] for j in stages]
                u = x + h * mp.fdot(row, k1)
                v = y + h * mp.fdot(row, k2)
                q = cos[i] * u + sin[i] * v
                more = (omega**2 * q - self._linear * q - self._cubic * q**3) / omega
                new1.append(-sin[i] * more)
                new2.append(cos[i] * more)
            moved = max(abs(a - b) for a, b in zip(new1 + new2, k1 + k2, strict=True))
            k1, k2 = new1, new2
            if moved < mp.mpf(10) ** (8 - mp.dps):
                break
        u, v = x + h * mp.fdot(self._weights, k1), y + h * mp.fdot(self._weights, k2)
        c, s = mp.cos(omega * h), mp.sin(omega * h)
        return c * u + s * v, c * v - s * u


def _after(step: SpringStep, start: tuple[mp.mpf, mp.mpf], span: float, steps: int) -> mp.matrix:
    state, h = start, mp.mpf(span) / step._omega / steps
    for _ in range(steps):
        state = step(*state, h)
    return mp.matrix(state)


def order() -> list[Row]:
    """Return the orders of the methods, and the distance of the engine from them."""
    return [row for method in METHODS for row in _order(method)]


def _order(method: Method) -> list[Row]:
    machine = machine_of({**WELLS['spring'], 'release_angle': 1.3})
    engine = Collocation(machine)
    engine._work = make_work(1, WHEEL_NODES, method.stages)
    engine._tolerance = engine._tolerance._replace(step=math.inf)
    engine.longest_step_s = math.inf
    with mp.workdps(method.digits):
        step = SpringStep(machine, engine._omega, method.stages)
        start = mp.mpf(1.3) * mp.cos(SPANS_FROM_RAD), -mp.mpf(1.3) * mp.sin(SPANS_FROM_RAD)
        exact = _after(step, start, method.span, 16)
        ends = (_after(step, start, method.span, steps) for steps in (2, 4))
        errors = [mp.norm(end - exact) for end in ends]
        measured = float(mp.log(errors[0] / errors[1], 2))
        away = max(_engine_away(engine, step, angle) for angle in method.steps)
    stages, high = method.stages, 2.0 * method.stages
    steps = f'steps of {method.span / 2} and {method.span / 4} rad, {method.digits} digits'
    setting = f'spring, {stages} stages, at {SPANS_FROM_RAD} rad, {steps}'
    compared = ', '.join(map(str, method.steps))
    return [
        Row('order of the method', setting, measured, high + 0.1, high - 0.1),
        Row(
            'engine less the method, relative',
            f'spring, {stages} stages, steps of {compared} rad',
            away,
            4e-16,
        ),
    ]


def _engine_away(engine: Collocation, step: SpringStep, angle: float) -> float:
    """Return the distance of a step of the engine from the method's, relative to the amplitude."""
    h = angle / engine._omega
    spans = land(h, 1)
    engine.release(spans)
    start = [mp.mpf(0.9), mp.mpf(-0.6)]
    engine._state['planes'][0] = float(start[0]), 0.0, float(start[1]), 0.0
    engine.advance(spans)
    x, y = step(start[0], start[1], mp.mpf(h))
    f = [mp.mpf(float(value)) for value in engine._state['planes'][0]]
    return float(mp.hypot(f[0] + f[1] - x, f[2] + f[3] - y) / mp.hypot(*start))
