"""The steady swing: closed forms, and half swings by DOP853."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tauto_core.machines import (
    LeverMachine,
    Machine,
    NoSteadySwing,
    SteadySwing,
    compile_machine,
    steady_swing,
)
from tauto_core.machines.drags import Drag
from tauto_core.machines.escapements import Escapement
from tauto_core.machines.parts import Imbalance, Rest
from tauto_core.scene import load_scene

HARMONIC = compile_machine(load_scene('ideal'))
HEAVY = compile_machine(load_scene('portsmouth_jamaica'))
LEVER = compile_machine(load_scene('sully_lever_at_sea'))
INERTIA, OMEGA = HARMONIC.inertia, HARMONIC.frequency
STIFFNESS = INERTIA * OMEGA**2


def clock(
    machine: Any, drag: dict[str, float], energy: float, angle: float, release=1.0, recoil=0.0
) -> Any:
    return replace(
        machine,
        drag=Drag(**drag),
        escapement=Escapement(energy=energy, angle=angle, rest=Rest(recoil=recoil)),
        release_angle=release,
    )


def settled(*args: Any) -> SteadySwing:
    found = steady_swing(clock(*args))
    assert isinstance(found, SteadySwing), found
    return found


def no_swing(*args: Any) -> str:
    found = steady_swing(clock(*args))
    assert isinstance(found, NoSteadySwing), found
    return found.why


@pytest.mark.parametrize(
    ('kind', 'size', 'loss', 'settling'),
    [
        # loss of half a swing of 1 rad, and e-folding time, to first order
        ('viscous', 2e-5, lambda c: 0.5 * math.pi * c * OMEGA, lambda c: INERTIA / c),
        ('quadratic', 1e-6, lambda c: 4 / 3 * c * OMEGA**2,
         lambda c: math.pi * INERTIA / (4 * c * OMEGA)),
        ('coulomb', 2e-4, lambda c: 2 * c, lambda c: math.pi * STIFFNESS / (2 * OMEGA * c)),
    ],
)  # fmt: skip
def test_it_settles_as_slowly_as_it_loses(kind, size, loss, settling):
    """To first order in the loss."""
    found = settled(HARMONIC, {kind: size}, loss(size), 0.0)
    assert found.amplitude == pytest.approx(1.0, abs=1e-4)
    assert found.time_constant == pytest.approx(settling(size), rel=1e-3)
    assert found.free_period == pytest.approx(math.tau / OMEGA, rel=1e-14)


def hung(machine: Any, direction: float) -> Any:
    """Return a wheel with a fifth of its stiffness as an imbalance."""
    moment = 0.2 * machine.inertia * machine.frequency**2 / machine.gravity
    return replace(machine, imbalance=Imbalance(moment, direction))


def half_swing(machine: Machine, amplitude: float) -> tuple[float, float]:
    """Return the next turning point and its time from −A, by DOP853 from event to event."""
    assert machine.drag
    assert machine.escapement
    drag, where, recoil = machine.drag, machine.escapement.angle, machine.escapement.recoil
    moment, direction = machine.imbalance or (0.0, 0.0)

    def rise(_: float, state: Any, back: float) -> tuple[float, float]:
        angle, rate = state
        arm, slope = float(machine.cam.lever_arm(angle)), float(machine.cam.lever_rate(angle))
        pushed = float(machine.pull(machine.cam.lift(angle))) * arm
        pushed += machine.carried_mass * arm * slope * rate * rate
        pushed += moment * machine.gravity * math.sin(angle + direction)
        pushed += drag.viscous * rate + drag.quadratic * rate * rate + drag.coulomb + back
        return rate, -pushed / float(machine.mass(angle))

    def reached(_: float, state: Any, _back: float) -> float:
        return float(state[0] - where)

    def turned(_: float, state: Any, _back: float) -> float:
        return float(state[1])

    reached.terminal = turned.terminal = True
    turned.direction = -1
    exact = {'method': 'DOP853', 'rtol': 1e-13, 'atol': 1e-14}
    first = solve_ivp(
        rise, (0.0, 10.0), (-amplitude, 0.0), events=reached, args=(-recoil,), **exact
    )
    angle, rate = first.y[:, -1]
    faster = math.sqrt(rate**2 + 2.0 * machine.escapement.energy / float(machine.mass(angle)))
    last = solve_ivp(rise, (0.0, 10.0), (angle, faster), events=turned, args=(recoil,), **exact)
    return float(last.y[0, -1]), float(first.t[-1] + last.t[-1])


@pytest.mark.parametrize(
    ('machine', 'drag', 'energy', 'angle', 'recoil'),
    [
        (HARMONIC, {'viscous': 5e-4, 'coulomb': 1e-4}, 6e-3, -0.3, 0.0),
        # a quality factor of 2
        (HARMONIC, {'viscous': 1.25e-3}, 8e-3, 0.1, 0.0),
        (HEAVY, {'viscous': 1e-4, 'quadratic': 1e-5, 'coulomb': 1e-4}, 1e-3, 0.3, 2e-3),
        # recoil takes more than half of the impulses
        (HEAVY, {'quadratic': 1e-5, 'coulomb': 1e-4}, 3e-3, -0.4, 2e-3),
        # an unbalanced wheel, heavy side down or up: an even well
        (hung(HARMONIC, 0.0), {'quadratic': 2e-5}, 1e-3, 0.2, 0.0),
        (hung(HEAVY, math.pi), {'viscous': 1e-4, 'coulomb': 1e-4}, 2e-3, 0.3, 2e-3),
    ],
)
def test_the_steady_swing_repeats(machine, drag, energy, angle, recoil):
    """Tolerance: DOP853's, over a quarter of a swing each."""
    this = clock(machine, drag, energy, angle, recoil=recoil)
    found = steady_swing(this)
    assert isinstance(found, SteadySwing)
    turning, time = half_swing(this, found.amplitude)
    assert turning == pytest.approx(found.amplitude, rel=1e-11)
    assert 2.0 * time == pytest.approx(found.period, rel=1e-11)


def test_without_drag_and_drive_it_is_the_released_swing():
    found = steady_swing(replace(HEAVY, drag=None, escapement=None, release_angle=-0.7))
    assert isinstance(found, SteadySwing)
    assert (found.amplitude, found.time_constant) == (0.7, math.inf)
    assert found.period == found.free_period == HEAVY.period(0.7)
    short_of_it = replace(HEAVY, drag=None, escapement=Escapement(energy=1e-6, angle=-0.8))
    assert steady_swing(replace(short_of_it, release_angle=-0.7)) == found


def test_what_has_no_steady_swing_says_why():
    friction, drag = {'coulomb': 1e-3}, {'viscous': 1e-6}
    assert 'dies away' in steady_swing(replace(HARMONIC, drag=Drag(**drag))).why
    forever = replace(HARMONIC, escapement=Escapement(energy=1e-6), drag=Drag())
    assert 'grows for ever' in steady_swing(forever).why
    # 4 c₀ A = 3.6 mJ from a swing of 0.9 rad
    too_little = no_swing(HARMONIC, friction, 1e-3, 0.9)
    assert 'gives 0.002 J in a swing, less than the 0.0036 J' in too_little
    assert 'released at 0.3 rad it does not swing beyond the 0.4 rad' in no_swing(
        HARMONIC, friction, 1e-3, -0.4, 0.3
    )
    # E = 2 c₀ A: at 0.1 rad the thread's torque k A does not overcome c₀
    held = {'coulomb': 0.2 * STIFFNESS}
    assert 'brings the wheel to rest' in no_swing(HARMONIC, held, 0.04 * STIFFNESS, 0.0)
    assert 'end of its range' in no_swing(HARMONIC, drag, 1e-2, 0.0)
    assert 'end of its range' in no_swing(LEVER, drag, 1e-2, 0.0)
    # π c₁ ω A² grows without end, and so the swing of an involute settles wherever it must
    assert settled(HEAVY, {'viscous': 1e-6}, 1e-2, 0.0).amplitude > 20.0


def test_recoil_that_does_not_drive_says_why():
    viscous = {'viscous': 1e-5}
    assert 'recoil that begins before the middle takes 0.0012 J' in no_swing(
        HARMONIC, viscous, 5e-4, -0.3, 1.0, 1e-3
    )
    assert 'grows for ever' in no_swing(HARMONIC, {}, 0.0, 0.3, 1.0, 1e-3)
    # R = 1e-3 N m holds the wheel at R/k, and 0.3 rad is not reached from 0.1
    assert 'does not swing beyond the 0.3 rad' in no_swing(HARMONIC, {}, 1e-3, 0.3, 0.1, 1e-3)
    # kα²/2 − kθ²/2 = R (θ + α): just enough without drag
    enough = 0.5 * STIFFNESS * (0.3 - 0.1)
    assert 'grows for ever' in no_swing(HARMONIC, {}, 1e-3, 0.3, 0.1, 1.001 * enough)
    short = no_swing(HARMONIC, {}, 1e-3, 0.3, -0.1, 0.999 * enough)
    assert 'does not swing beyond' in short
    assert 'does not swing beyond' in no_swing(HARMONIC, viscous, 1e-3, 0.3, 0.1, 1.001 * enough)
    assert settled(HARMONIC, viscous, 1e-3, 0.3, 0.1, 2.0 * enough).amplitude > 0.3


def test_the_lever_swings_between_two_different_angles():
    """Two impulses give c ∫ θ̇² dt of both half swings, to first order: Q is in the thousands."""
    drag, energy, nodes, angle = 1e-6, 2e-6, 400, 0.3
    found = settled(LEVER, {'viscous': drag}, energy, angle)
    phase, lost = (np.arange(nodes) + 0.5) * math.pi / nodes, 0.0
    for turning in (found.amplitude, LEVER.far_turning(found.amplitude)):
        assert isinstance(LEVER, LeverMachine)
        tau, slowness = LEVER.swing(turning, phase)
        ratio = LEVER.geometry.slopes(tau)[0]
        mass = LEVER.inertia + LEVER.turned_inertia * ratio**2
        square = 2.0 * float(LEVER.potential(turning)) / mass * np.sin(phase) ** 2
        lost += drag * float(np.sum(square * slowness)) * math.pi / nodes
    assert lost == pytest.approx(2.0 * energy, rel=2e-3)


def test_an_unbalanced_wheel_swings_between_two_different_angles():
    """To and fro by DOP853: the method errs by the square of the loss."""
    wrong, machine, direction, angle = [], HARMONIC, 0.7, 0.2
    for part in (1.0, 0.5):
        this = clock(hung(machine, direction), {'viscous': part * 1e-5}, part * 1e-4, angle)
        found = steady_swing(this)
        assert isinstance(found, SteadySwing)
        amplitude, time = found.amplitude, 0.0
        # the mirror image, with its sides exchanged
        turned = replace(this, imbalance=this.imbalance._replace(direction=-direction))
        for wheel in (turned, this):
            # from −A, that is from A of the mirror image
            amplitude, half = half_swing(wheel, amplitude)
            time += half
        assert found.free_period == pytest.approx(this.period(found.amplitude), rel=1e-13)
        wrong.append((amplitude - found.amplitude, time - found.period))
    # from one turning point the energy misses by a part of the loss, which falls e-fold slowly
    assert abs(wrong[0][0]) < 2e-5
    assert abs(wrong[0][1]) < 2e-5
    for full, halved in zip(*wrong, strict=True):
        assert abs(halved) < 0.35 * abs(full) + 1e-9
