"""Rows of the stress table against exact answers: on land, at sea, order of the method, drift.

Every row compares the engine with a closed form, with mpmath, or with SciPy's DOP853.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from mpmath import mp
from scipy.special import ellipe, ellipeinc
from stress_cases import (
    FORCE,
    HOLE_CAM,
    INERTIA,
    LEVER_RATE,
    WELLS,
    Row,
    exponent,
    land,
    machine_of,
    phase_error,
    rolling,
    sail,
    scene_of,
    states,
    weight,
)

from tauto_core.machines import Machine
from tauto_core.motion import events
from tauto_core.motion.closed_forms import ActionAngle
from tauto_core.motion.collocation import Collocation
from tauto_core.motion.stepping import TOLERANCE
from tauto_core.samples import JOINT_STATES, PHASE, FloatArray
from tauto_core.scene import Scene
from tauto_core.scene.errors import PropagationError
from tauto_core.ship.motions import ComponentsShip

# -----------------------------------------------------------------------------
# On land: reversal, amplitudes, mass, drag, escapement.

SWINGS = 100
STIFFNESS = FORCE * LEVER_RATE
OMEGA = math.sqrt(STIFFNESS / INERTIA)
CRITICAL = 2.0 * INERTIA * OMEGA


def _laid_out(machine: Machine, engine: Collocation, count: int) -> int:
    """Return the quantity that grows as steps shorten: their number, or that between two kinks.

    Between kinks steps are equal, so several tolerances may lead to the same number.
    """
    if not machine.cam.kinked:
        return count
    half_swing_s = 0.5 * machine.period(machine.release_angle)
    beyond_s = events.OVERSHOOT / (math.pi / half_swing_s)
    return math.ceil((half_swing_s + beyond_s) / engine.longest_step_s - events.SPARE)


def _error_after(machine: Machine, tolerance: float, swings: int) -> tuple[float, int, int]:
    """Return the relative distance from the quadrature's motion, the steps, and `_laid_out`."""
    engine = Collocation(machine, tolerance)
    # whole nanoseconds, as the closed form needs
    step = math.floor(engine.longest_step_s * 1e9) * 1e-9
    # a generic phase
    count = round((swings + 0.37) * machine.period(machine.release_angle) / step)
    spans = land(step, count, count)
    engine.release(spans)
    found = engine.advance(spans)
    exact = ActionAngle(machine).advance(spans)
    away = math.hypot(
        float(found.angle[0] - exact.angle[0]),
        float(found.rate[0] - exact.rate[0]) / machine.frequency,
    )
    steps = count << int(engine._state['level'])
    return away / abs(machine.release_angle), steps, _laid_out(machine, engine, steps)


def tolerances(finest: int = 15) -> list[Row]:
    """Return how the error depends on the tolerance, from 1e-4 to 1e-15."""
    rows = []
    for name, well in WELLS.items():
        machine = machine_of(well)
        asked = [10.0**-k for k in range(4, finest + 1)]
        found = [_error_after(machine, tolerance, SWINGS) for tolerance in asked]
        used = [e / (n * tol) for (e, n, _), tol in zip(found, asked, strict=True) if e > 1e-11]
        # over two decades, since at one tolerance the error may happen to pass through zero
        pairs = zip(found, found[2:], strict=False)
        stuck = [b / a for (a, _, few), (b, _, more) in pairs if b > 1e-11 and more > few]
        setting = f'{name}, {SWINGS} swings'
        rows += [
            Row('error per step against the tolerance, largest', setting, max(used), 1.0),
            Row('error left after two decades of tolerance, most', setting, max(stuck), 1.0),
            Row(f'error at tolerance 1e-{finest}', setting, found[-1][0], 1e-11),
        ]
    return rows


def _late(machine: Machine, swings: int = SWINGS) -> tuple[float, float]:
    """Return the relative error of the period after so many swings, and its limit.

    The truth is the quadrature; the limit is the tolerance per step, added up. At the return to
    the top theta' = -theta'' dt; theta'' there is -V'/M.
    """
    amplitude = machine.release_angle
    engine = Collocation(machine)
    period = machine.period(amplitude)
    count = math.ceil(swings * period / engine.longest_step_s)
    spans = land(swings * period / count, count, count)
    engine.release(spans)
    rate = float(engine.advance(spans).rate[0])
    torque = machine.pull(machine.cam.lift(amplitude)) * machine.cam.lever_arm(amplitude)
    late = abs(rate / float(torque / machine.mass(amplitude))) / (swings * period)
    steps = count << int(engine._state['level'])
    return late, steps * TOLERANCE / (swings * math.tau)


def _period_rows(name: str, cases: dict[str, dict[str, Any]]) -> list[Row]:
    rows = []
    for case, well in cases.items():
        late, allowed = _late(machine_of(well))
        words = f'{name}: period, relative error over {SWINGS} swings'
        rows.append(Row(words, case, late, allowed))
    return rows


def amplitudes() -> list[Row]:
    """Return errors of the period from 1e-9 rad to within 1e-9 of the edge of the cam."""
    edges = {'arc': math.pi, 'spring': 8.0, 'weight': 50.0}
    cases = {}
    for name, edge in edges.items():
        for part in (1e-9, 1e-3, 0.5, 1.0 - 1e-9):
            angle = max(part * edge, 1e-9)
            where = f'{angle:.3g} rad' if part < 0.6 else f'{edge:.4g} rad less 1e-9 of it'
            cases[f'{name}, {where}'] = {**WELLS[name], 'release_angle': angle}
    return _period_rows('amplitude', cases)


def mass_ratios() -> list[Row]:
    """Return errors of the period for m r^2/I from 0 to 10, and for very large values."""
    ratios = (1e-12, 1e-6, 0.01, 0.1, 1.0, 10.0, 1e4)
    cases = {f'm r2/I = {ratio:g}, 1 rad': weight(ratio) for ratio in ratios}
    massless = weight(1.0)
    massless['power'] = {**massless['power'], 'massless': True}
    cases['m r2/I = 0 (massless), 1 rad'] = massless
    return _period_rows('mass', cases)


def springs_and_holes() -> list[Row]:
    """Return errors of the period for springs and holes at both ends of the possible range."""

    def well(stiffness: float, distance: float) -> dict[str, Any]:
        return {
            'cam': HOLE_CAM,
            'thread': {'kind': 'hole', 'distance': distance},
            'power': {'kind': 'spring', 'force': FORCE, 'stiffness': stiffness},
        }

    cases = {f'stiffness {k:g} N/m, 1 rad': well(k, 0.08) for k in (0.0, 1e-9, 1.0, 1e3, 1e6)}
    for distance in (LEVER_RATE * (1.0 + 1e-9), 0.02, 1e3):
        cases[f'hole at {distance:.10g} m, 1 rad'] = well(5.0, distance)
    return _period_rows('spring and hole', cases)


def _damped(ratio: float, times: FloatArray) -> FloatArray:
    """Return theta of the viscously damped oscillator released at 1 rad, at rest."""
    rate = ratio * OMEGA
    if ratio < 1.0:
        w = math.sqrt(OMEGA**2 - rate**2)
        return np.exp(-rate * times) * (np.cos(w * times) + rate / w * np.sin(w * times))
    if ratio == 1.0:
        return np.exp(-rate * times) * (1.0 + rate * times)
    fast = -(rate + math.sqrt(rate**2 - OMEGA**2))
    slow = OMEGA**2 / fast
    return (slow * np.exp(fast * times) - fast * np.exp(slow * times)) / (slow - fast)


def drag() -> list[Row]:
    """Return errors against closed forms from negligible to overdamped, and the motion left."""
    rows = []
    for ratio in (1e-12, 1e-6, 1e-2, 0.9, 1.5, 10.0, 1e2, 1e3, 1e4):
        machine = machine_of(drag={'viscous': ratio * CRITICAL})
        engine = Collocation(machine)
        spans = land(0.05, 1200)
        engine.release(spans)
        found = engine.advance(spans)
        away = float(np.max(np.abs(found.angle - _damped(ratio, 0.05 * np.arange(1, 1201)))))
        setting = f'viscous drag {ratio:g} of critical, 60 s'
        rows.append(Row('largest error of the angle [rad]', setting, away, 1e-11))
        if ratio > 1.0:
            rows.append(
                Row('beats of an overdamped wheel', setting, float(found.beats[-1]), 0.0, 0.0)
            )
    return rows + _standing()


def _standing() -> list[Row]:
    """Return the motion left where friction holds the wheel, or drag stops it."""
    rows = []
    for name, loss in {
        'coulomb, 1.1 of the torque at release': {'coulomb': 1.1 * STIFFNESS},
        'coulomb, 0.3 of it': {'coulomb': 0.3 * STIFFNESS},
    }.items():
        said = sail(scene_of(drag=loss))
        rate = float(np.max(np.abs(said[JOINT_STATES].velocity[-10:])))
        beats = said[PHASE].position[:, 3]
        rows += [
            Row('rate of a wheel that stands [rad/s]', name, rate, 0.0, 0.0),
            Row('beats in the last 10 s', name, float(beats[-1] - beats[-11]), 0.0, 0.0),
        ]
    said = sail(scene_of(drag={'quadratic': 1e3 * INERTIA}))
    wrong = sum(int(np.sum(~np.isfinite(said[topic].position))) for topic in (JOINT_STATES, PHASE))
    return [*rows, Row('numbers that are not finite', 'quadratic drag, 1e3 I', float(wrong), 0.0)]


def escapement() -> list[Row]:
    """Return the error of the instant at which too strong impulses drive the cam to its edge.

    Without drag each beat adds 2E/(I omega^2) to the square of the amplitude.
    """
    energy, edge = 2e-2, 8.0
    gain = 2.0 * energy / (INERTIA * OMEGA**2)
    beats = math.floor((edge**2 - 1.0) / gain) + 1
    amplitude = math.sqrt(1.0 + beats * gain)
    exact = ((beats - 0.5) * math.pi + math.asin(edge / amplitude)) / OMEGA
    found = math.nan
    try:
        sail(scene_of(escapement={'kind': 'impulse', 'energy': energy}))
    except PropagationError as error:
        found = error.time_s if 'edge of the cam' in str(error) else math.nan
    setting = 'impulses of 20 mJ, no drag: the error names the instant'
    return [Row('time of the edge of the cam, error [s]', setting, abs(found - exact), 1e-8)]


# -----------------------------------------------------------------------------
# At sea: strong roll, resonance, sampling rates, mass ratios.
#
# A force on a linear lever has an exact response to a sum of cosines. A weight is compared with
# DOP853 at 1e-13 on the exact motion of the ship.

GENERAL = {'quadratic': 1e-300}
"""A negligible drag, with which the general engine runs instead of the closed form."""


def _forced(scene: Scene, times: FloatArray) -> FloatArray:
    """Return theta of theta'' + omega^2 theta = -roll'', released at rest in the case.

    From rest the response to cos wt is (cos wt - cos omega t)/(omega^2 - w^2), and that to sin wt
    is similar. As products of the mean and half the difference of the two frequencies they also
    hold at resonance.
    """
    angle = scene.trochlea.release_angle * np.cos(OMEGA * times)
    assert isinstance(scene.ship, ComponentsShip)
    for part in scene.ship.components:
        w = math.tau / part.period
        half, mean = 0.5 * (OMEGA - w), 0.5 * (OMEGA + w)
        # the response to cos(wt), and to sin(wt), from rest
        beat = 0.5 * times * np.sinc(half * times / math.pi)
        cosine = beat * np.sin(mean * times) / mean
        sine = np.sin(OMEGA * times) / OMEGA - times * np.cos(mean * times) * np.sinc(
            half * times / math.pi
        )
        sine /= 2.0 * mean
        gain = part.amplitude * w * w
        angle += gain * (math.cos(part.phase) * cosine - math.sin(part.phase) * sine)
    return np.asarray(angle)


def _away(scene: Scene) -> float:
    """Return the largest error in a run [rad]: of the angle, or with a weight of the phase."""
    if scene.trochlea.power.kind == 'weight':
        return float(np.max(np.abs(phase_error(scene))))
    joints = sail(scene)[JOINT_STATES]
    times = (joints.stamp_ns - scene.starts_at_ns) * 1e-9
    return float(np.max(np.abs(joints.position[:, 0] - _forced(scene, times))))


HEAVY = {**weight(0.05), 'inertia': 8e-3}
HEAVY['power'] = {'kind': 'weight', 'mass': 4.0}
"""A slower wheel, since DOP853 loses less on fewer swings."""


def strong_roll() -> list[Row]:
    """Return errors under roll of up to 60 degrees."""
    rows = []
    for degrees in (1.0, 20.0, 40.0, 60.0):
        roll = (math.radians(degrees), 9.0, 0.4)
        name = 'roll, largest error in 60 s [rad]'
        for kind, drag in (('forced harmonic', None), ('collocation', GENERAL)):
            scene = scene_of(ship=rolling(roll), drag=drag)
            rows.append(Row(name, f'force, {kind}, {degrees:g} degrees', _away(scene), 1e-10))
        ship = rolling(roll, height=3.0, heave=[{'amplitude': 0.5, 'period': 10.2, 'phase': 0.7}])
        scene = scene_of(HEAVY, ship=ship)
        rows.append(Row(name, f'weight 3 m up, heave, {degrees:g} degrees', _away(scene), 1e-8))
    return rows


def resonance() -> list[Row]:
    """Return errors where roll and wheel have equal or commensurable frequencies."""
    own = math.tau / OMEGA
    cases = {
        'equal': 1.0,
        'equal but for 1e-9': 1.0 + 1e-9,
        'twice as slow': 2.0,
        'twice as fast': 0.5,
        'three to two': 1.5,
        'nine to one': 9.0,
    }
    rows = []
    for name, ratio in cases.items():
        ship = rolling((0.01 * ratio * ratio, own * ratio, 0.4))
        for kind, drag in (('forced harmonic', None), ('collocation', GENERAL)):
            away = _away(scene_of(ship=ship, drag=drag))
            setting = f'roll {name}, force, {kind}, 60 s at 20 Hz'
            rows.append(Row('resonance, largest error [rad]', setting, away, 1e-8))
    return rows


RATE_LIMITS = {2.0: 2e-5, 5.0: 1e-9, **dict.fromkeys((10.0, 20.0, 50.0, 200.0, 1000.0), 1e-11)}
"""Error of the interpolation for a roll of 6 and 8 s; of degree 7, it falls with the rate."""


def rates() -> list[Row]:
    """Return errors against the exact roll from 2 to 1000 samples a second."""
    rows = []
    for rate, limit in RATE_LIMITS.items():
        ship = rolling((0.15, 8.0, 0.4), (0.05, 6.0, -1.0), rate=rate)
        name = 'sampling, largest error in 60 s [rad]'
        for kind, drag in (('forced harmonic', None), ('collocation', GENERAL)):
            away = _away(scene_of(ship=ship, drag=drag))
            rows.append(Row(name, f'force, {kind}, {rate:g} Hz', away, limit))
        scene = scene_of(HEAVY, ship={**ship, 'height': 3.0})
        rows.append(Row(name, f'weight 3 m up, {rate:g} Hz', _away(scene), 100.0 * limit))
    return rows


def ratios() -> list[Row]:
    """Return errors for m r^2/I from 1e-6 to 10 under roll and heave."""
    rows = []
    for ratio in (1e-6, 0.01, 1.0, 10.0):
        heave = [{'amplitude': 0.3, 'period': 10.2, 'phase': 0.7}]
        ship = rolling((0.1, 8.0, 0.4), height=3.0, heave=heave)
        # omega^2 = g (m r^2/I)/r; with this lever all have small swings of 5 rad/s
        lever = ratio * 9.80665 / 25.0
        mass = 8e-3 * ratio / lever**2
        well = {
            'cam': {'kind': 'involute', 'base_radius': lever},
            'thread': {'kind': 'vertical'},
            'power': {'kind': 'weight', 'mass': mass},
            'inertia': 8e-3,
        }
        scene = scene_of(well, ship=ship, duration=20.0)
        setting = f'weight at sea, m r2/I = {ratio:g}, 20 s'
        rows.append(Row('largest error of the phase [rad]', setting, _away(scene), 1e-10))
    return rows


# -----------------------------------------------------------------------------
# Drift of energy and rate over very many oscillations, at rounding level.
#
# Steps of tolerance 1e-15 put the truncation error below rounding. The rest of it, and of the fit
# of the well, is a constant rate, which adds up. So growth is measured by differences that a
# constant rate does not affect, as in an Allan deviation: first differences of the energy and
# second differences of the phase over a lag, root mean square over the run and over all runs.
#
# In an isochronous well both grow as a random walk, like n^0.5. Where the period depends on the
# amplitude, a random walk of the energy changes the rate, and the phase must grow like n^1.5 in
# any program (D. Brouwer, On the accumulation of errors in numerical integration, Astron. J. 46,
# 1937).

DRIFT_TOLERANCE = 1e-15
LIGHT = 0.01
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
    machine = machine_of(weight(LIGHT))
    engine = Collocation(machine, DRIFT_TOLERANCE)
    step = engine.longest_step_s
    per_log = EVERY * step / machine.period(machine.release_angle)
    found = states(engine, step, math.ceil(oscillations / per_log), EVERY)
    energies = _relative(_energy_of_weight(machine, found))
    phases = _phase_errors(machine, step, _turns_of_weight(machine, found), EVERY)
    setting = f'weight on the involute, m r2/I = {LIGHT}, 1 rad, {oscillations:.0e} oscillations'
    tenth = len(phases) // 10
    changed = (phases[-1] - phases[-1 - tenth]) - (phases[tenth] - phases[0])
    turned = math.tau * oscillations
    return [
        Row('energy, largest relative error', setting, float(np.max(np.abs(energies))), 1e-12),
        Row('rate, last tenth less first', setting, abs(changed) / turned * 10, 1e-13),
        Row('rate less the exact one', setting, abs(float(phases[-1])) / turned, 1e-14),
        Row('energy error grows as n to the', setting, _of_long_lags([energies], 1), 1.05),
        Row('phase error grows as n to the', setting, _of_long_lags([phases], 2), 1.9, 1.2),
    ]


def isochronous(oscillations: float, runs: int) -> list[Row]:
    """Return energy and growth of the phase error in a harmonic well, over several runs."""
    energies, phases = [], []
    every = EVERY // 20
    for amplitude in np.linspace(0.3, 1.7, runs):
        machine = machine_of({'release_angle': float(amplitude)})
        engine = Collocation(machine, DRIFT_TOLERANCE)
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
