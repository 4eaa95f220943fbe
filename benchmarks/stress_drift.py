"""Drift of energy and rate over very many oscillations, at rounding level.

Steps of tolerance 1e-15 put the truncation error below rounding. The rest of it, and of the fit of
the well, is a constant rate, which adds up. So growth is measured by differences that a constant
rate does not affect, as in an Allan deviation: first differences of the energy and second
differences of the phase over a lag, root mean square over the run and over all runs.

In an isochronous well both grow as a random walk, like n^0.5. Where the period depends on the
amplitude, a random walk of the energy changes the rate, and the phase must grow like n^1.5 in any
program (D. Brouwer, On the accumulation of errors in numerical integration, Astron. J. 46, 1937).
"""

from __future__ import annotations

import math

import numpy as np
from mpmath import mp
from scipy.special import ellipe, ellipeinc
from stress_cases import Row, exponent, machine_of, states, weight

from tauto_core.machines import Machine
from tauto_core.motion.wheel import Collocation
from tauto_core.samples import FloatArray

TOLERANCE = 1e-15
RATIO = 0.01
EVERY = 2000

FAST = 1.01
"""The frame of the isochronous well rotates faster than the wheel; else nothing is integrated."""


def _energy_of_weight(machine: Machine, state: FloatArray) -> FloatArray:
    """Return (omega^2 q^2 + p^2)/2 with q(s) by Newton's method, in long doubles."""
    arm = np.longdouble(machine.cam.linear_rate)
    square = np.longdouble(machine.carried_mass) / np.longdouble(machine.inertia) * arm * arm
    k = np.sqrt(square)
    s, p = state[:, 0], state[:, 1]
    q = s.copy()
    for _ in range(8):
        root = np.sqrt(1.0 + square * q * q)
        q -= (0.5 * (q * root + np.arcsinh(k * q) / k) - s) / root
    pull = np.longdouble(machine.pulling_mass) * np.longdouble(machine.gravity)
    return np.asarray(0.5 * (pull * arm / np.longdouble(machine.inertia) * q * q + p * p))


def _energy_of_force(machine: Machine, state: FloatArray) -> FloatArray:
    return np.asarray(0.5 * (_square_of_omega(machine) * state[:, 0] ** 2 + state[:, 1] ** 2))


def _square_of_omega(machine: Machine) -> np.longdouble:
    arm = np.longdouble(machine.cam.linear_rate)
    return np.longdouble(machine.force) * arm / np.longdouble(machine.inertia)


def _turns_of_weight(machine: Machine, state: FloatArray) -> FloatArray:
    """Return the phase in turns: theta = A sin u, omega t = E(u | -eps), eps = m r^2 A^2/I."""
    eps = _eps(machine)
    arc, speed = state.astype(float).T
    angle = np.array([_angle(machine, float(s)) for s in arc])
    u = np.arctan2(angle, speed / machine.frequency)
    return np.asarray(ellipeinc(u, -eps) / (4.0 * ellipe(-eps)))


def _angle(machine: Machine, arc: float) -> float:
    from tauto_core.motion.wells import angle_of

    return angle_of(arc, math.sqrt(_eps(machine)) / abs(machine.release_angle))


def _eps(machine: Machine) -> float:
    arm = float(machine.cam.lever_arm(machine.release_angle))
    return machine.carried_mass * arm * arm / machine.inertia


def _turns_of_force(machine: Machine, state: FloatArray) -> FloatArray:
    """Return the phase in turns, in long doubles: a double-precision arctan2 is corrected."""
    x, y = state[:, 0], state[:, 1] / np.sqrt(_square_of_omega(machine))
    return np.asarray(np.arctan2(x, y) / (2.0 * np.arccos(np.longdouble(-1.0))))


def _phase_errors(machine: Machine, step_s: float, turns: FloatArray, every: int) -> FloatArray:
    """Return the phase in excess of the exact one [rad], followed over whole turns."""
    with mp.workdps(40):
        pull = mp.mpf(machine.force) + mp.mpf(machine.pulling_mass) * mp.mpf(machine.gravity)
        lever = mp.mpf(machine.cam.linear_rate)
        eps = mp.mpf(machine.carried_mass) / mp.mpf(machine.inertia)
        eps *= (lever * mp.mpf(machine.release_angle)) ** 2
        period = 4 * mp.sqrt(mp.mpf(machine.inertia) / (pull * lever)) * mp.ellipe(-eps)
        unit = int(mp.nint(mp.frac(every * mp.mpf(step_s) / period) * 2**96))
    # whole turns in integers, so that only the remainder is rounded
    parts = [(k * unit) % 2**96 for k in range(1, len(turns) + 1)]
    exact = np.array([np.longdouble(part >> 32) * np.longdouble(2.0**-64) for part in parts])
    late = turns - (exact + np.longdouble(0.25))
    return math.tau * (late - np.round(late)).astype(float)


def growth(series: list[FloatArray], order: int) -> tuple[FloatArray, FloatArray]:
    """Return lags, in samples, and the root mean square of first or second differences."""
    lags, sizes = [], []
    lag = 1
    while 4 * order * lag <= len(series[0]):
        parts = [s[lag:] - s[:-lag] for s in series]
        if order == 2:
            parts = [p[lag:] - p[:-lag] for p in parts]
        lags.append(lag)
        sizes.append(math.sqrt(float(np.mean([np.mean(p * p) for p in parts]))))
        lag *= 2
    return np.array(lags, float), np.array(sizes)


def _of_long_lags(series: list[FloatArray], order: int) -> float:
    """Return the exponent of the growth beyond a thousand swings; below, rounding hides it."""
    lags, sizes = growth(series, order)
    return exponent(lags[2:], sizes[2:])


def _relative(energies: FloatArray) -> FloatArray:
    return np.asarray((energies / energies[0] - 1.0).astype(float))


def weight_driven(oscillations: float) -> list[Row]:
    """Return energy, rate and growth of the weight on the involute, over one long run."""
    machine = machine_of(weight(RATIO))
    engine = Collocation(machine, TOLERANCE)
    step = engine.longest_step_s
    per_log = EVERY * step / machine.period(machine.release_angle)
    found = states(engine, step, math.ceil(oscillations / per_log), EVERY)
    energies = _relative(_energy_of_weight(machine, found))
    phases = _phase_errors(machine, step, _turns_of_weight(machine, found), EVERY)
    setting = f'weight on the involute, m r2/I = {RATIO}, 1 rad, {oscillations:.0e} oscillations'
    tenth = len(phases) // 10
    changed = (phases[-1] - phases[-1 - tenth]) - (phases[tenth] - phases[0])
    turned = math.tau * oscillations
    rows = [
        Row('energy, largest relative error', setting, float(np.max(np.abs(energies))), 1e-12),
        Row('rate, last tenth less first', setting, abs(changed) / turned * 10, 1e-13),
        Row('rate less the exact one', setting, abs(float(phases[-1])) / turned, 1e-14),
        Row('energy error grows as n to the', setting, _of_long_lags([energies], 1), 1.05),
        Row('phase error grows as n to the', setting, _of_long_lags([phases], 2), 1.9, 1.2),
    ]
    decades = [10**k for k in range(4, 9) if 10**k <= oscillations]
    for decade in decades:
        at = min(round(decade / per_log), len(phases)) - 1
        name = f'energy, relative error after {decade:.0e}'
        rows.append(Row(name, setting, abs(float(energies[at])), 1e-12))
    return rows


def isochronous(oscillations: float, runs: int) -> list[Row]:
    """Return energy and growth of the phase error in a harmonic well, over several runs."""
    energies, phases = [], []
    every = EVERY // 20
    for amplitude in np.linspace(0.3, 1.7, runs):
        machine = machine_of({'release_angle': float(amplitude)})
        engine = Collocation(machine, TOLERANCE)
        engine._omega *= FAST
        step = engine.longest_step_s = 0.7 / engine._omega
        logs = math.ceil(oscillations * machine.small_period / step / every)
        found = states(engine, step, logs, every)
        energies.append(_relative(_energy_of_force(machine, found)))
        phases.append(_phase_errors(machine, step, _turns_of_force(machine, found), every))
    setting = f'isochronous well, {runs} runs of {oscillations:.0e} oscillations'
    worst = max(float(np.max(np.abs(e))) for e in energies)
    return [
        Row('energy, largest relative error', setting, worst, 1e-12),
        Row('energy error grows as n to the', setting, exponent(*growth(energies, 1)), 1.05),
        Row('phase error grows as n to the', setting, exponent(*growth(phases, 2)), 0.7, 0.4),
    ]
