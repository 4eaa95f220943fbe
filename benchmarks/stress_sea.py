"""Rows of the stress table at sea: strong roll, resonance, sampling rates, mass ratios.

A force on a linear lever has an exact response to a sum of cosines. A weight is compared with
DOP853 at 1e-13 on the exact roll and apparent vertical, without sampling.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
from scipy.integrate import solve_ivp
from stress_cases import FORCE, INERTIA, LEVER_RATE, Row, rolling, sail, scene_of, weight

from tauto_core.machines import compile_machine
from tauto_core.samples import JOINT_STATES, FloatArray
from tauto_core.scene import ComponentsShip, Scene

OMEGA = math.sqrt(FORCE * LEVER_RATE / INERTIA)
GENERAL = {'quadratic': 1e-300}
"""A negligible drag, with which the general engine runs instead of the closed form."""


def _ship(scene: Scene) -> ComponentsShip:
    assert isinstance(scene.ship, ComponentsShip)
    return scene.ship


def _forced(scene: Scene, times: FloatArray) -> FloatArray:
    """Return theta of theta'' + omega^2 theta = -roll'', released at rest in the case.

    From rest the response to cos wt is (cos wt - cos omega t)/(omega^2 - w^2), and that to sin wt
    is similar. As products of the mean and half the difference of the two frequencies they also
    hold at resonance.
    """
    angle = scene.trochlea.release_angle * np.cos(OMEGA * times)
    for part in _ship(scene).components:
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


def _felt(scene: Scene, time: float) -> tuple[float, float, float, float, float]:
    """Return roll, its rate, the apparent vertical, its rate, and the apparent gravity."""
    ship = _ship(scene)
    roll = [0.0] * 4
    heave = [0.0] * 4
    for parts, sums in ((ship.components, roll), (ship.heave or (), heave)):
        for part in parts:
            w = math.tau / part.period
            for k in range(4):
                angle = w * time + part.phase + 0.5 * math.pi * k
                sums[k] += part.amplitude * w**k * math.cos(angle)
    turning = ship.height * cmath.exp(1j * roll[0])
    force = turning * 1j * (1j * roll[2] - roll[1] ** 2) + 1j * (scene.gravity + heave[2])
    jerk = turning * 1j * (1j * roll[3] - 3 * roll[1] * roll[2] - 1j * roll[1] ** 3)
    jerk += 1j * heave[3]
    return roll[0], roll[1], cmath.phase(force / 1j), (jerk / force).imag, abs(force)


def _carried(scene: Scene, times: FloatArray) -> FloatArray:
    """Return theta of a weight on the involute, by DOP853 in x and p = M x' + I gamma'."""
    machine = compile_machine(scene)
    inertia, mass = machine.inertia, machine.carried_mass
    lever = float(machine.cam.lever_rate(0.0))

    def motion(time: float, state: FloatArray) -> list[float]:
        _, _, _, turning, gravity = _felt(scene, time)
        x = float(state[0])
        rate = (float(state[1]) - inertia * turning) / (inertia + mass * (lever * x) ** 2)
        return [rate, mass * lever * x * (lever * rate * rate - gravity)]

    roll, roll_rate, line, line_rate, _ = _felt(scene, 0.0)
    x = machine.release_angle + roll - line
    whole = inertia + mass * (lever * x) ** 2
    start = [x, whole * (roll_rate - line_rate) + inertia * line_rate]
    found = solve_ivp(
        motion, (0.0, times[-1]), start, 'DOP853', times, rtol=1e-13, atol=1e-16, max_step=0.02
    )
    tilt = np.array([_felt(scene, float(t)) for t in times])
    return np.asarray(found.y[0] + tilt[:, 2] - tilt[:, 0])


def _away(scene: Scene) -> float:
    """Return the largest error of the angle in a run [rad]."""
    joints = sail(scene)[JOINT_STATES]
    times = (joints.stamp_ns - scene.starts_at_ns) * 1e-9
    exact = _forced if scene.trochlea.power.kind == 'force' else _carried
    return float(np.max(np.abs(joints.position[:, 0] - exact(scene, times))))


HEAVY = {**weight(0.05), 'inertia': 8e-3}
HEAVY['power'] = {'kind': 'weight', 'mass': 4.0}
"""A slower wheel, since DOP853 loses less on fewer swings."""


def strong_roll() -> list[Row]:
    """Return errors under roll of up to 60 degrees."""
    rows = []
    for degrees in (1.0, 20.0, 40.0, 60.0):
        roll = (math.radians(degrees), 9.0, 0.4)
        name = 'roll, largest error of the angle in 60 s [rad]'
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
            rows.append(Row('resonance, largest error of the angle [rad]', setting, away, 1e-8))
    return rows


RATE_LIMITS = {2.0: 2e-5, 5.0: 1e-9, **dict.fromkeys((10.0, 20.0, 50.0, 200.0, 1000.0), 1e-11)}
"""Error of the interpolation for a roll of 6 and 8 s; of degree 7, it falls with the rate."""


def rates() -> list[Row]:
    """Return errors against the exact roll from 2 to 1000 samples a second."""
    rows = []
    for rate, limit in RATE_LIMITS.items():
        ship = rolling((0.15, 8.0, 0.4), (0.05, 6.0, -1.0), rate=rate)
        name = 'sampling, largest error of the angle in 60 s [rad]'
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
        rows.append(Row('largest error of the angle [rad]', setting, _away(scene), 1e-10))
    return rows
