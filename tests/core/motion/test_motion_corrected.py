"""The corrected cams are isochronous: in closed form, in steps, and by another integrator."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from motion_cases import angles, moved, phases, rolling, scene_of, spans_to, waves
from reference_propagator import Reference, by_reference

from tauto_core.machines import compile_machine
from tauto_core.motion import make_propagator, propagator_name

VERTICAL = {'kind': 'vertical'}
WEIGHT = {
    'cam': {'kind': 'weight_corrected', 'period': 2.0},
    'power': {'kind': 'weight', 'mass': 0.05},
}
SPRING = {
    'cam': {'kind': 'spring_corrected', 'period': 1.0},
    'power': {'kind': 'spring', 'force': 2.0, 'stiffness': 50.0},
}
MACHINES: dict[str, dict[str, Any]] = {
    'weight, vertical': {**WEIGHT, 'thread': VERTICAL},
    'weight, hole': {**WEIGHT, 'thread': {'kind': 'hole', 'distance': 0.2}},
    'spring, vertical': {**SPRING, 'thread': VERTICAL},
    'spring, hole': {**SPRING, 'thread': {'kind': 'hole', 'distance': 0.05}},
}
every_machine = pytest.mark.parametrize('trochlea', MACHINES.values(), ids=MACHINES.keys())


def machine_of(trochlea, release):
    return compile_machine(scene_of(trochlea={**trochlea, 'release_angle': release}))


def largest(trochlea):
    """0.999 of the range, of one without end six turns."""
    edge = machine_of(trochlea, 0.1).cam.range_rad
    return 0.999 * min(edge, 12 * math.pi)


@every_machine
@pytest.mark.parametrize('part', [1e-9, 0.5, 1.0])
def test_period_is_the_wanted_one(trochlea, part):
    """Quadrature of the mechanism, from next to rest to 0.999 of the range: all to rounding."""
    machine = machine_of(trochlea, 0.1)
    wanted = trochlea['cam']['period']
    assert machine.small_period == pytest.approx(wanted, rel=1e-15)
    assert machine.period(part * largest(trochlea)) == pytest.approx(wanted, rel=2e-15)


@every_machine
def test_closed_form_is_the_motion(trochlea):
    amplitude = 0.9 * largest(trochlea)
    machine = machine_of(trochlea, amplitude)
    engine = make_propagator(machine, still=True)
    assert engine.name == 'harmonic'
    seconds = np.linspace(0.0, 0.7 * trochlea['cam']['period'], 9)[1:]
    times = np.round(seconds * 1e9).astype(np.int64)
    spans = spans_to(times)
    found, exact = engine.advance(spans), moved(Reference(machine), spans)
    np.testing.assert_allclose(found.angle, exact.angle, atol=1e-11 * amplitude)
    np.testing.assert_allclose(found.rate, exact.rate, atol=1e-10 * amplitude)
    largest_torque = np.max(np.abs(exact.torque))
    np.testing.assert_allclose(found.torque, exact.torque, atol=1e-10 * largest_torque)
    # the phase is uniform
    turned = times * 1e-9 * 2.0 / trochlea['cam']['period']
    np.testing.assert_allclose(found.half_turns + found.fraction, turned, atol=1e-14 * len(times))


ROLL: dict[str, Any] = {'ship': rolling((0.1, 9.0, 0.4), heave=waves((0.4, 7.3)))}


@pytest.mark.parametrize('name', ['spring, vertical', 'spring, hole'])
def test_spring_at_sea_is_linear(name):
    """I ψ̈ + k (ψ − α_c) = 0: the exact step of forced_harmonic, against another integrator."""
    scene = scene_of(trochlea={**MACHINES[name], 'release_angle': 2.5}, duration=2.0, **ROLL)
    machine = compile_machine(scene)
    assert propagator_name(machine, still=False) == 'forced_harmonic'
    _, angle, rate = angles(scene)
    with by_reference():
        _, expected, expected_rate = angles(scene)
    np.testing.assert_allclose(angle, expected, atol=1e-10)
    np.testing.assert_allclose(rate, expected_rate, atol=1e-9)
    # as Euler's second cam with a force of the same period: the same bits of phase
    plain = {
        'cam': {'kind': 'hole', 'lever_rate': machine.cam.rate},
        'power': {'kind': 'force', 'force': 2.0},
    }
    other = scene_of(
        trochlea={**plain, 'release_angle': 2.5, 'thread': {'kind': 'hole', 'distance': 0.05}},
        duration=2.0,
        **ROLL,
    )
    np.testing.assert_array_equal(phases(scene), phases(other))


def test_a_cam_made_for_another_weight_is_not_isochronous():

    machine = machine_of(MACHINES['weight, vertical'], 3.0)
    heavier = replace(machine, carried_mass=0.06)
    assert not heavier.is_harmonic
    assert heavier.period(3.0) != pytest.approx(heavier.small_period, rel=1e-3)
    # whatever gravity: a bead on a cycloid
    elsewhere = replace(machine, gravity=1.6)
    assert elsewhere.is_harmonic
    assert elsewhere.period(8.0) == pytest.approx(elsewhere.small_period, rel=2e-15)
