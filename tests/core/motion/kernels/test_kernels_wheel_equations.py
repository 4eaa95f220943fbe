"""The forms in which the wheel's kernels hold its equation of motion, against the printed one.

    (I + m t²) ϑ̈ + m t t′ ϑ̇² + F t = −I γ̈ − c₁θ̇ − c₂ θ̇|θ̇| − c₀ sgn θ̇ − R s

(docs/theory/machine_at_sea.md), with t = h′(ϑ) the lever arm of the machine's cam and
F = P + κh + m g_eff. The coordinate of the kernels is ϑ, its momentum (1 + μt²)ϑ̇ + γ̇; or the arc s
and ṡ + γ̇n. Their time derivatives are those of the chain rule.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from motion_cases import arc, impulse, on_land, scene_of, weight_of

from tauto_core.kernels import entry
from tauto_core.machines import Machine, compile_machine
from tauto_core.motion.collocation import Collocation
from tauto_core.motion.gauss_step import Mode, make_work
from tauto_core.motion.lanes import SIZE
from tauto_core.motion.system import ChannelAt, Inputs, Plane
from tauto_core.motion.wheel import WHEEL_NODES, disturbance_on_land, holding_torque

HEAVY = weight_of(0.15, 0.012, inertia=8e-4)
CHEEK = {**HEAVY, 'cam': arc(0.02, 0.01)}
SPRING = {'power': {'kind': 'spring', 'force': 2.0, 'stiffness': 50.0}}
DRAG = {'viscous': 3e-4, 'quadratic': 2e-4, 'coulomb': 1e-4}
RECOIL = impulse(2e-4, 0.1, friction=1e-5, recoil=5e-4)
WHEELS: dict[str, dict[str, Any]] = {
    'arc': {'trochlea': HEAVY},
    'arc, drag': {'trochlea': HEAVY, 'drag': DRAG},
    'arc, recoil': {'trochlea': HEAVY, 'drag': {'viscous': 3e-4}, 'escapement': RECOIL},
    'cheek': {'trochlea': CHEEK},
    'cheek, drag': {'trochlea': CHEEK, 'drag': DRAG},
    'spring, drag': {'trochlea': SPRING, 'drag': DRAG},
}
ON_ARC = {name for name in WHEELS if name.startswith('arc')}


@entry
def derivatives(wheel: Any, mode: Any, omega: Any, at: Any, work: Any, out: Any) -> None:
    """Fill a row for each stage: those of X and Y by the stages, by the instant, and q, q̇, q̈."""
    wheel.disturb(mode, omega, work)
    for i in range(len(out)):
        x, y = work.x[i], work.y[i]
        now = wheel.instant(mode, omega, (Plane(x, y),), at)
        drift = wheel.drift(mode, omega, at, now)
        out[i, 0] = omega[0] * y + work.d1[i]
        out[i, 1] = -omega[0] * x + work.d2[i]
        out[i, 2], out[i, 3] = drift[0].x, drift[0].y / omega[0]
        out[i, 4], out[i, 5], out[i, 6] = now.coordinate, now.speed, now.acceleration
        out[i, 7] = now.tension


@entry
def torque_that_holds(wheel: Any, mode: Any, angle: Any, at: Any) -> float:
    return holding_torque(wheel, mode, angle, at)


@entry
def disturbed(wheel: Any, mode: Any, omega: Any, work: Any) -> None:
    wheel.disturb(mode, omega, work)


def acceleration(machine: Machine, q: Any, speed: Any, at: Inputs, mode: Mode) -> Any:
    """ϑ̈ by the printed equation, and the tension of the thread."""
    t, slope = machine.cam.lever_arm(q), machine.cam.lever_rate(q)
    rate, drag, escapement = speed + at.tilt.rate, machine.drag, machine.escapement
    pull = machine.force + machine.stiffness * machine.cam.lift(q)
    pull = pull + machine.pulling_mass * at.gravity
    against = machine.inertia * at.drive.bend + pull * t
    if drag is not None:
        d = mode.direction
        against += drag.viscous * rate + drag.quadratic * d * rate * rate + drag.coulomb * d
    if escapement is not None:
        against += escapement.recoil * mode.pallet
    m = machine.carried_mass
    found = -(against + m * t * slope * speed**2) / (machine.inertia + m * t * t)
    return found, pull + m * (slope * speed**2 + t * found)


def system_of(machine: Machine) -> Any:
    """The wheel with all channels of the ship's motion, and ω."""
    sea = np.zeros((1, 2))
    gravity = sea if machine.pulling_mass else None
    forcing = replace(on_land(1, 1.0), neutral=sea, tilt=sea, gravity=gravity)
    return Collocation(machine)._model_of(forcing)


def channels(random: Any, machine: Machine) -> Inputs:
    line, tilt = (ChannelAt(*random.normal(0.0, 0.3, 3)) for _ in range(2))
    return Inputs(line, tilt, 9.8 + random.normal() if machine.pulling_mass else 0.0)


@pytest.mark.parametrize('name', WHEELS)
def test_stages_and_instants_obey_the_printed_equation(name):
    machine = compile_machine(scene_of(**WHEELS[name]))
    wheel, omega = system_of(machine)
    assert (wheel.shape is not None) == (name in ON_ARC)
    random = np.random.default_rng(5)
    work, out = make_work(1, WHEEL_NODES), np.empty((SIZE, 8))
    mu = machine.carried_mass / machine.inertia
    for _ in range(20):
        at = channels(random, machine)
        line, tilt = at.drive, at.tilt
        mode = Mode(*random.choice([-1.0, 1.0], 3))
        q = np.abs(random.uniform(0.02, 1.2, SIZE))
        # a kinked cam is continued from the side that is felt; the plain law is that of this side
        q = q * mode.side if machine.cam.kinked else q * random.choice([-1.0, 1.0], SIZE)
        speed = random.normal(0.0, 3.0, SIZE)
        bend, tension = acceleration(machine, q, speed, at, mode)
        t, slope = machine.cam.lever_arm(q), machine.cam.lever_rate(q)
        if wheel.shape is not None:
            root = np.sqrt(1.0 + mu * t * t)
            growth = mu * t * slope / root * speed
            x, w = machine.arc(q) / math.sqrt(machine.inertia), root * speed + line.rate / root
            x_rate = root * speed
            w_rate = root * bend + growth * speed + line.bend / root - line.rate * growth / root**2
        else:
            mass = 1.0 + mu * t * t
            x, w, x_rate = q, mass * speed + line.rate, speed
            w_rate = mass * bend + 2.0 * mu * t * slope * speed**2 + line.bend
        work['x'], work['y'] = x, w / omega[0]
        nodes = work['nodes']
        nodes['line_rate'], nodes['line_bend'] = line.rate, line.bend
        nodes['tilt_rate'], nodes['gravity'] = tilt.rate, at.gravity
        derivatives(wheel, mode, omega, at, work, out)
        close = {'rtol': 2e-13, 'atol': 2e-12}
        for first in (0, 2):
            np.testing.assert_allclose(out[:, first], x_rate, **close)
            np.testing.assert_allclose(out[:, first + 1], w_rate / omega[0], **close)
        np.testing.assert_allclose(out[:, 4:7].T, [q, speed, bend], **close)
        np.testing.assert_allclose(out[:, 7], tension / machine.inertia, rtol=1e-12)


@pytest.mark.parametrize('name', WHEELS)
def test_the_holding_torque_keeps_a_wheel_at_rest_in_the_case(name):
    """With ϑ̇ = −τ̇ and θ̇ = 0, so that only the recoil drags, it lifts ϑ̈ to −τ̈."""
    machine = compile_machine(scene_of(**WHEELS[name]))
    wheel, _ = system_of(machine)
    random = np.random.default_rng(6)
    for _ in range(20):
        at = channels(random, machine)
        tilt = at.tilt
        side, pallet = random.choice([-1.0, 1.0], 2)
        q = side * random.uniform(0.02, 1.2)
        mode = Mode(side, 0.0, pallet)
        bend, _ = acceleration(machine, q, -tilt.rate, at, mode)
        missing = machine.mass(q) / machine.inertia * (-tilt.bend - bend)
        found = torque_that_holds(wheel, mode, float(q + tilt.value), at)
        assert found == pytest.approx(missing, rel=2e-13, abs=2e-12)


@pytest.mark.parametrize('name', ['arc', 'cheek', 'spring', 'spring, viscous'])
def test_trial_steps_on_land_are_disturbed_as_steps_are(name):
    drag = {'drag': {'viscous': 3e-4}} if 'viscous' in name else {}
    kinds = {'arc': HEAVY, 'cheek': CHEEK, 'spring': SPRING}
    machine = compile_machine(scene_of(trochlea=kinds[name.split(',')[0]], **drag))
    wheel, omega = system_of(machine)
    random = np.random.default_rng(7)
    work = make_work(1, WHEEL_NODES)
    work['nodes']['gravity'] = machine.gravity
    for side in (1.0, -1.0):
        work['x'], work['y'] = side * random.uniform(0.02, 1.2, SIZE), random.normal(0, 1, SIZE)
        disturbed(wheel, Mode(side, side, side), omega, work)
        found = disturbance_on_land(machine, wheel.shape, omega[0], work['x'][0], work['y'][0])
        np.testing.assert_allclose(found[0], work['d1'][0], rtol=2e-13, atol=2e-12)
        np.testing.assert_allclose(found[1], work['d2'][0], rtol=2e-13, atol=2e-12)
