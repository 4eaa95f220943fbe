"""Rows of the stress table on land: reversal, order, amplitudes, mass, drag, escapement."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from stress_cases import (
    FORCE,
    HOLE_CAM,
    INERTIA,
    LEVER_RATE,
    WELLS,
    Row,
    land,
    machine_of,
    sail,
    scene_of,
    weight,
)

from tauto_core.machines import Machine
from tauto_core.motion import events
from tauto_core.motion.closed_forms import ActionAngle
from tauto_core.motion.stepping import TOLERANCE
from tauto_core.motion.wheel import Collocation
from tauto_core.samples import JOINT_STATES, PHASE, FloatArray
from tauto_core.scene.errors import PropagationError

SWINGS = 100
STIFFNESS = FORCE * LEVER_RATE
OMEGA = math.sqrt(STIFFNESS / INERTIA)
CRITICAL = 2.0 * INERTIA * OMEGA


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
        spans = land(step, round(swings * machine.period(1.0) / step), 1)
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


def _laid_out(machine: Machine, engine: Collocation, count: int) -> int:
    """Return the quantity that grows as steps shorten: their number, or that between two kinks.

    Between kinks steps are equal, so several tolerances may lead to the same number.
    """
    if not machine.cam.kinked:
        return count
    half_swing_s = 0.5 * machine.period(machine.release_angle)
    beyond_s = events.BEYOND / (math.pi / half_swing_s)
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
        if ratio >= 1e2:
            solved = float(engine._state['newton'])
            rows.append(Row("steps by Newton's method", setting, solved, math.inf, 1.0))
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
