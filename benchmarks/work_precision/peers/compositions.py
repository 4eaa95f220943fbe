"""Plain symplectic compositions in numba: Störmer–Verlet, Yoshida's sixth and eighth order.

In the arc of the well, q = s/sqrt(I), even the machine with its varying inertia is a unit mass in
a time-dependent potential, so the schemes are explicit for problems a to d. They are not offered
for e, whose impulses fall inside their fixed steps. Nor are they for f: two angles whose inertia
depends on their difference cannot be split into drifts and kicks.

Yoshida, Phys. Lett. A 150 (1990) 262; coefficients to 20 digits from Hairer, Lubich, Wanner,
Geometric Numerical Integration (2006), V.3.2 (orders 6 and 8 with 7 and 15 stages).
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from benchmarks.work_precision.equations.sea import constants_of, sea_from, stretches, vertical
from benchmarks.work_precision.peer import Outcome
from benchmarks.work_precision.peers.scipy_ivp import release_of
from benchmarks.work_precision.problems import CaseProblem, Numbers, Problem, Sea
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import UsageError

STRETCH_S = 3600.0


@dataclass(frozen=True)
class Scheme:
    """A symmetric composition of Verlet steps.

    Attributes:
        order: order of the error.
        outer: parts of a step before the middle one, which is the rest to 1.
        rates: steps per second to try.
    """

    order: int
    outer: tuple[float, ...]
    rates: tuple[int, ...]

    @property
    def parts(self) -> FloatArray:
        """All parts, shape (k,)."""
        half = np.array(self.outer)
        return np.concatenate([half, [1.0 - 2.0 * math.fsum(self.outer)], half[::-1]])


SCHEMES = {
    'verlet': Scheme(2, (), (64, 256, 1024, 4096, 16384)),
    'yoshida6': Scheme(
        6,
        (0.78451361047755726382, 0.23557321335935813368, -1.17767998417887100695),
        (16, 32, 64, 128, 256),
    ),
    'yoshida8': Scheme(
        8,
        (
            0.74167036435061295345,
            -0.40910082580003159400,
            0.19075471029623837995,
            -0.57386247111608226666,
            0.29906418130365592384,
            0.33462491824529818378,
            0.31529309239676659663,
        ),
        (8, 16, 32, 64, 128),
    ),
}


class Symplectic:
    """A composition at a fixed step; settings are steps per second.

    Args:
        name: a key of `SCHEMES`.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self._scheme = SCHEMES[name]

    def version(self) -> str:
        """Return the version of numba, which compiles it."""
        import numba

        return f'numba {numba.__version__}'

    def settings(self, problem: Problem) -> tuple[str, ...]:
        """Return steps a second, coarse to fine; none with impulses and for the case."""
        if isinstance(problem, CaseProblem) or problem.numbers.impulse_energy:
            return ()
        return tuple(f'{rate}/s' for rate in self._scheme.rates)

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem with so many steps a second.

        Raises:
            UsageError: the case, which no composition splits.
        """
        from benchmarks.work_precision.equations.wheel_kernels import compose

        if isinstance(problem, CaseProblem):
            raise UsageError(
                f'{self.name}: the angles of problem {problem.key!r} do not split into drifts '
                'and kicks. Choose a problem of a to d'
            )
        began = time.perf_counter()
        numbers, rate = problem.numbers, int(setting.removesuffix('/s'))
        linear, parts = not numbers.mass, self._scheme.parts
        drifts = 0.5 * (np.append(parts, 0.0) + np.append(0.0, parts))
        table, turn = sea_tables(numbers.sea, drifts, 1.0 / rate, 1 if linear else 5)
        constants, state = constants_of(numbers), arc_state(numbers)
        arguments = (drifts, parts, table, turn, constants)
        compose(state.copy(), 1.0, rate, *arguments, sea_from(numbers.sea, 0.0), linear)
        ready = time.perf_counter()
        for start, length in stretches(duration_s, STRETCH_S):
            sea = sea_from(numbers.sea, start)
            compose(state, length, round(length * rate), *arguments, sea, linear)
        run_s = time.perf_counter() - ready
        angle, speed = wheel_of_arc(numbers, duration_s, state)
        return Outcome(duration_s, angle, speed, run_s, ready - began)


def sea_tables(
    sea: Sea | None, drifts: FloatArray, step_s: float, orders: int
) -> tuple[FloatArray, FloatArray]:
    """Return what turns the sea's phasors at a step's start into roll at its kicks.

    Args:
        sea: None on land.
        drifts: parts of a step, shape (k + 1,).
        step_s: [s].
        orders: of derivatives from 0 on: 1 or 5.

    Returns:
        (2 n, orders k): rows for cosines, then sines; and cos, sin of omega step, (2, n).
    """
    kicks = len(drifts) - 1
    if sea is None:
        return np.empty((0, orders * kicks)), np.empty((2, 0))
    omega, order = sea.omega[:, None, None], np.arange(orders)
    at = np.cumsum(drifts)[:-1, None] * step_s
    angle = omega * at + 0.5 * np.pi * order
    size = sea.amplitude[:, None, None] * omega**order
    table = np.concatenate([size * np.cos(angle), -size * np.sin(angle)])
    turn = np.stack([np.cos(sea.omega * step_s), np.sin(sea.omega * step_s)])
    return np.ascontiguousarray(table.reshape(-1, orders * kicks)), turn


def arc_state(numbers: Numbers) -> FloatArray:
    """Return (q, q') at release: psi of the linear machine, else the arc s/sqrt(I)."""
    from benchmarks.work_precision.equations.wheel_kernels import arc_of

    if not numbers.mass:
        return release_of(numbers)
    at, k = vertical(numbers, 0.0), _stretching(numbers)
    x = float(numbers.release_angle - at.lean)
    return np.array([arc_of(x, k), -math.hypot(1.0, k * x) * at.lean_rate])


def wheel_of_arc(numbers: Numbers, time_s: float, state: FloatArray) -> tuple[float, float]:
    """Return theta [rad] and theta' [rad/s] of (q, q') at a time from the start [s]."""
    from benchmarks.work_precision.equations.wheel_kernels import angle_of_arc

    at = vertical(numbers, time_s)
    if not numbers.mass:
        return float(state[0] - at.roll), float(state[1] - at.roll_rate)
    k = _stretching(numbers)
    x = angle_of_arc(state[0], k)
    return float(x + at.lean), float(state[1] / math.hypot(1.0, k * x) + at.lean_rate)


def _stretching(numbers: Numbers) -> float:
    """Return k = b sqrt(m/I), by which the arc departs from the angle."""
    return numbers.lever_rate * math.sqrt(numbers.mass / numbers.inertia)
