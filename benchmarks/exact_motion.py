"""The clock's reading at sea by DOP853 on the exact motion of the ship, without sampling.

Roll and heave at every instant are sums of cosines, with exact derivatives. A wheel with one
degree of freedom is integrated by `reference_propagator`, whose forcing they replace; the lever
and the swinging thread by the Lagrangians of tests/core/motion/thread_references.py; a suspended
case by its own linear equations (theory E3). Nothing is shared with the engine or with the
forecast but the machine's geometry and the definition of the phase (theory E4).
"""

from __future__ import annotations

import cmath
import math
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from reference_propagator import ATOL, RTOL, Reference
from scipy.integrate import solve_ivp

from tauto_core.machines import (
    AnyMachine,
    FluidPendulum,
    HangingMachine,
    LeverMachine,
    Machine,
    compile_machine,
)
from tauto_core.motion import Forcing
from tauto_core.samples import FloatArray
from tauto_core.scene import ComponentsShip, Scene, SeaShip
from tauto_core.ship.buffer import case_modes
from tauto_core.ship.motions.sea import sea_motion

STEPS_OF_CASE = 16
"""Least number of steps in a swing of the case's fast mode; the dense output errs by their eighth
power.
"""


class Felt(NamedTuple):
    """The motion that the clock feels: each angle with its first two derivatives."""

    vertical: tuple[float, float, float]
    tilt: tuple[float, float, float]  # tilt of the case
    gravity: float


class ShipAt:
    """The exact motion of a ship of harmonics, at the clock or its case's bearing (theory E1)."""

    def __init__(self, scene: Scene) -> None:
        ship = scene.ship
        if isinstance(ship, ComponentsShip):
            roll = [(c.amplitude, c.period, c.phase) for c in ship.components]
            heave = [(c.amplitude, c.period, c.phase) for c in ship.heave or ()]
        else:
            assert isinstance(ship, SeaShip)
            sea = sea_motion(scene, ship)
            roll, heave = (
                []
                if sum_ is None
                else list(zip(sum_.amplitude, sum_.period, sum_.phase, strict=True))
                for sum_ in (sea.roll, sea.heave)
            )
        self._roll, self._heave = _terms(roll, range(5)), _terms(heave, range(2, 5))
        self._height, self._gravity = ship.height, scene.gravity

    def force(self, t: float) -> tuple[FloatArray, complex, complex, complex]:
        """Return the roll's derivatives up to the fourth, and ÿ + i(g + z̈) with two of its own."""
        roll = self._roll(t)
        heave = self._heave(t)
        _, first, second, third, fourth = roll.tolist()
        bend = 1j * second - first**2
        bend_1 = 1j * third - 2.0 * first * second
        bend_2 = 1j * fourth - 2.0 * second**2 - 2.0 * first * third
        up = 1j * self._height * cmath.exp(1j * roll[0])
        turn = 1j * first
        return (
            roll,
            up * bend + 1j * (self._gravity + heave[0]),
            up * (turn * bend + bend_1) + 1j * heave[1],
            up * ((turn * turn + 1j * second) * bend + 2.0 * turn * bend_1 + bend_2)
            + 1j * heave[2],
        )

    def __call__(self, t: float) -> Felt:
        """Return what a clock fixed to the ship feels."""
        roll, force, first, second = self.force(t)
        rate = first / force
        bend = second / force - rate * rate
        return Felt(
            (cmath.phase(force / 1j), rate.imag, bend.imag),
            (float(roll[0]), float(roll[1]), float(roll[2])),
            abs(force),
        )


def _terms(
    harmonics: list[tuple[float, float, float]], orders: range
) -> Callable[[float], FloatArray]:
    """Return a function of t: the sum's derivatives of some orders."""
    a, period, phase = np.array(harmonics).reshape(-1, 3).T
    w = math.tau / period
    factors = np.array([a * w**n for n in orders])
    turned = np.array([math.tau * n / 4.0 for n in orders])[:, None]
    return lambda t: np.asarray(np.sum(factors * np.cos(w * t + phase + turned), axis=1))


class CaseAt:
    """The exact motion felt in a suspended case: its linear equations (theory E3) by DOP853.

    e θ̈ + c φ̈ + g θ = −ÿ, k² φ̈ + g c (φ − θ) = 0; the specific force points along θ and has the
    size of the contact force over the mass.
    """

    def __init__(self, scene: Scene, end_s: float) -> None:
        assert scene.suspension is not None
        hung = scene.suspension
        if hung.large_angles:
            raise ValueError('only the small angles of a case are known here')
        self._ship, self._gravity = ShipAt(scene), scene.gravity
        self._e, self._c = hung.support_radius - hung.axle_radius, hung.depth
        self._k2 = hung.gyration_radius**2
        tilt = -self._ship.force(0.0)[1].real / self._gravity
        fast = math.sqrt(case_modes(hung).squared_frequencies(scene.gravity)[1])
        self._dense = solve_ivp(
            lambda t, y: self._slopes(t, y)[0],
            (0.0, end_s),
            [tilt, tilt, 0.0, 0.0],
            'DOP853',
            dense_output=True,
            rtol=RTOL,
            atol=1e-16,
            max_step=math.tau / fast / STEPS_OF_CASE,
        ).sol

    def _slopes(self, t: float, y: FloatArray) -> tuple[list[float], complex]:
        theta, phi, theta_rate, phi_rate = y.tolist()
        force = self._ship.force(t)[1]
        phi_bend = -self._gravity * self._c * (phi - theta) / self._k2
        theta_bend = -(force.real + self._gravity * theta + self._c * phi_bend) / self._e
        return [theta_rate, phi_rate, theta_bend, phi_bend], force

    def __call__(self, t: float) -> Felt:
        """Return what a clock in the case feels."""
        y = self._dense(t)
        (theta_rate, phi_rate, theta_bend, phi_bend), force = self._slopes(t, y)
        theta, phi = float(y[0]), float(y[1])
        pressed = force.imag * math.cos(theta) - force.real * math.sin(theta)
        pressed += self._e * theta_rate**2 + self._c * phi_rate**2 * math.cos(phi - theta)
        contact = pressed / (1.0 + self._c**2 / self._k2 * math.sin(phi - theta) ** 2)
        return Felt((theta, theta_rate, theta_bend), (phi, phi_rate, phi_bend), contact)


def exact_phase(scene: Scene) -> FloatArray:
    """Return the phase at the logged instants after the first, less that at the start [rad].

    Whole turns are not counted; the phase lies within one.
    """
    machine = compile_machine(scene)
    assert not isinstance(machine, FluidPendulum)
    end_s = scene.duration
    felt = lru_cache(maxsize=4)(
        ShipAt(scene) if scene.suspension is None else CaseAt(scene, end_s)
    )
    times = np.arange(1, scene.log_count) * (scene.log_interval_ns * 1e-9)
    if isinstance(machine, Machine):
        return _of_one_degree(machine, felt, times)
    return _of_thread(machine, felt, times)


class _ExactReference(Reference):
    """DOP853 on the exact motion instead of polynomials."""

    def __init__(self, machine: Machine, felt: Callable[[float], Felt]) -> None:
        super().__init__(machine)
        self._felt = felt

    def _channel(self, rows: FloatArray | None, t: float) -> tuple[float, float, float]:
        forcing = self._forcing
        span = float(forcing.length_s[self._k])
        felt = self._felt(float(forcing.end_ns[self._k]) * 1e-9 - span + t)
        follows = self._machine.follows_apparent_vertical
        if rows is not None and rows is forcing.gravity:
            return felt.gravity, math.nan, math.nan
        if rows is not None and rows is forcing.neutral:
            return felt.vertical if follows else felt.tilt
        if rows is None or not follows:
            return 0.0, 0.0, 0.0
        vertical, tilt = felt.vertical, felt.tilt
        return vertical[0] - tilt[0], vertical[1] - tilt[1], vertical[2] - tilt[2]


def _of_one_degree(
    machine: Machine, felt: Callable[[float], Felt], times: FloatArray
) -> FloatArray:
    n, ends_ns = len(times), np.round(times * 1e9).astype(np.int64)
    follows = machine.follows_apparent_vertical
    names = [] if not follows else ['tilt']
    names += ['gravity'] if machine.feels_gravity else []
    forcing = Forcing(
        length_s=np.diff(times, prepend=0.0),
        begin=np.zeros(n),
        end=np.ones(n),
        end_ns=ends_ns,
        logged=np.ones(n, np.bool_),
        neutral=np.zeros((n, 1)),
        **{name: np.zeros((n, 1)) for name in names},
    )
    exact = _ExactReference(machine, felt)
    exact.release(forcing)
    motion = exact.advance(forcing)
    return math.pi * (motion.half_turns % 2 + motion.fraction)


class _Outside:
    """The functions that the references of threads need, t from the start."""

    channels, begin, length = True, 0.0, 1.0

    def __init__(self, felt: Callable[[float], Felt]) -> None:
        self._felt = felt
        self.slopes = (lambda x: felt(x).vertical[1],)

    def __call__(self, t: float) -> tuple[float, float, float, float]:
        """Return β, β − α, α̇ and g_eff."""
        felt = self._felt(t)
        return felt.vertical[0], felt.vertical[0] - felt.tilt[0], felt.tilt[1], felt.gravity


def _of_thread(
    machine: AnyMachine, felt: Callable[[float], Felt], times: FloatArray
) -> FloatArray:
    """The references of threads have no events: no escapement, no drag with a kink."""
    from thread_references import HangingReference, LeverReference

    lever = isinstance(machine, LeverMachine)
    reference = LeverReference(machine) if lever else HangingReference(machine)
    outside, y, begin = _Outside(felt), None, 0.0
    y = reference.start(outside)
    rows = []
    for end in [0.0, *times.tolist()]:
        if end > 0.0:
            found = solve_ivp(
                reference.slopes,
                (begin, end),
                y,
                'DOP853',
                args=(outside, (0.0, 0.0)),
                rtol=RTOL,
                atol=ATOL,
                max_step=0.05,
            )
            y, begin = found.y[:, -1], end
        if isinstance(machine, HangingMachine):
            rows.append((y[0] - y[1], y[2] - y[3]))
            continue
        angle, rate = np.array([reference.angle(y, outside, end)]).T
        rows.append(
            (float(machine.arc(angle)[0]), float((np.sqrt(machine.mass_at(angle)) * rate)[0]))
        )
    x, speed = np.array(rows).T
    phase = np.arctan2(0.0 - speed / machine.frequency, x)
    return np.asarray((phase[1:] - phase[0]) % math.tau)


THREADS = Path(__file__).resolve().parents[1] / 'tests' / 'core' / 'motion'
if str(THREADS) not in sys.path:
    sys.path.append(str(THREADS))
