"""Sully's lever machine against 50-digit references and its own definition."""

import numpy as np
import pytest
from golden_numbers import GOLDEN

from tauto_core.curves.lever_geometry import LeverGeometry
from tauto_core.machines import LeverMachine, isochronism
from tauto_core.scene.errors import CamRangeError, UsageError

ENTRIES = {each['id']: each for each in GOLDEN if each['id'].startswith('A5-lever')}
TOLERANCE = 1e-13


def numbers(entry):
    return {name: float(each['value'].split(',')[0]) for name, each in entry['params'].items()}


def machine_of(entry):
    p = numbers(entry)
    geometry = LeverGeometry(p['r'], p['AB'], p['thread_free_length'])
    return LeverMachine(p['I'], p['m'], p['AD'], 0.0, geometry, p['g'], None, None, 1.0)


SULLY = machine_of(ENTRIES['A5-lever-period-0.5'])


@pytest.mark.parametrize('name', [name for name in ENTRIES if 'geom' in name])
def test_the_geometry_is_that_of_fifty_digits(name):
    entry = ENTRIES[name]
    machine, angle = machine_of(entry), numbers(entry)['theta']
    pose = machine.geometry.pose(machine.geometry.tau_of(np.array(angle)))
    found = {
        'delta_thread_inclination': pose.delta,
        'beta_lever': machine.beta(angle),
        'dbeta_dtheta': machine.ratio(angle),
        'Meff': machine.mass_at(angle),
        'V': machine.potential(angle),
    }
    assert found.keys() == entry['expected'].keys()
    for key, value in found.items():
        known = float(entry['expected'][key])
        assert float(value) == pytest.approx(known, rel=TOLERANCE, abs=0.0), key


@pytest.mark.parametrize('name', [name for name in ENTRIES if 'period' in name])
def test_the_period_is_that_of_fifty_digits(name):
    entry = ENTRIES[name]
    machine, start = machine_of(entry), numbers(entry)['theta_start']
    found = {
        'T_s': machine.period(start),
        'T_small_s': machine.small_period,
        'T_ratio': machine.period(start) / machine.small_period,
        'theta_other_turning': machine.far_turning(start),
    }
    assert found.keys() == entry['expected'].keys()
    for key, value in found.items():
        known = float(entry['expected'][key])
        assert value == pytest.approx(known, rel=TOLERANCE, abs=0.0), key


GEOMETRIES = [
    LeverGeometry(0.02, 0.1, 0.3),
    LeverGeometry(0.02, 1.0, 0.03),
    LeverGeometry(0.1, 0.01, 0.3),
]


@pytest.mark.parametrize('geometry', GEOMETRIES)
def test_thread_and_lever_meet(geometry):
    """The point B by the thread is the point B by the lever, its differences are the slopes."""
    tau = np.linspace(*geometry.edges, 101)
    u, beta, delta, free = geometry.pose(tau)
    r, arm, depth = geometry.base_radius, geometry.arm, geometry.depth
    of_thread = (
        r * u * np.cos(delta) + (r + free) * np.sin(delta),
        r * u * np.sin(delta) - (r + free) * np.cos(delta),
    )
    of_lever = arm * np.cos(beta) - arm, arm * np.sin(beta) - depth
    np.testing.assert_allclose(of_thread, of_lever, rtol=0, atol=8e-16 * (depth + arm))
    theta, step = geometry.theta(tau[1:-1]), 1e-4
    around = [geometry.pose(geometry.tau_of(theta + n * step)).beta for n in (-2, -1, 1, 2)]
    first = (around[0] - 8 * around[1] + 8 * around[2] - around[3]) / (12 * step)
    found, second = geometry.slopes(geometry.tau_of(theta))
    size = np.max(np.abs(found))
    inside = np.abs(theta) < 0.8 * min(-geometry.theta(tau[0]), geometry.theta(tau[-1]))
    # fourth-order differences of steps of 1e-4, away from a dead point
    np.testing.assert_allclose(found[inside], first[inside], rtol=0, atol=1e-8 * size)
    slopes = [geometry.slopes(geometry.tau_of(theta + n * step))[0] for n in (-2, -1, 1, 2)]
    bend = (slopes[0] - 8 * slopes[1] + 8 * slopes[2] - slopes[3]) / (12 * step)
    size = np.max(np.abs(second))
    np.testing.assert_allclose(second[inside], bend[inside], rtol=0, atol=1e-6 * size)


def test_the_arc_is_the_integral_of_the_root_of_the_inertia():
    """Simpson's rule on 2000 panels errs below 1e-12 here."""
    for angle in (-2.5, -1.0, 1e-9, 0.7, 2.4):
        grid = np.linspace(0.0, angle, 2001)
        root = np.sqrt(SULLY.mass_at(grid))
        simpson = np.sum(root[:-1:2] + 4 * root[1::2] + root[2::2]) * angle / 6000.0
        assert float(SULLY.arc(angle)) == pytest.approx(simpson, rel=1e-11)


def test_a_minute_swing_keeps_its_digits():
    """β ≈ r (1 + r/l₀) θ²/(2 AB), to the relative size of θ."""
    shape = SULLY.geometry
    for angle in (1e-3, 1e-6, 1e-12):
        expected = shape.base_radius * shape.depth / shape.length / shape.arm * angle**2 / 2
        assert float(SULLY.beta(angle)) == pytest.approx(expected, rel=10 * angle + 1e-15)
    # the period departs by 0.03 A² of itself
    assert SULLY.period(1e-6) == pytest.approx(SULLY.small_period, rel=1e-13)
    assert SULLY.period(0.0) == SULLY.small_period


def test_beyond_the_geometry_is_refused():
    low, high = SULLY.sides
    assert SULLY.range_rad == min(-low, high)
    pose = SULLY.geometry.pose(np.array(SULLY.geometry.edges))
    least = np.minimum(np.cos(pose.beta), np.cos(pose.beta - pose.delta))
    np.testing.assert_allclose(least, 0.1, rtol=1e-12)
    with pytest.raises(CamRangeError, match=r'2\.6 rad is beyond the lever geometry'):
        SULLY.period(2.6)
    # this side is longer, but the swing goes further on the other
    with pytest.raises(CamRangeError, match=r'a swing from -3\.1 rad goes beyond'):
        SULLY.period(-3.1)
    with pytest.raises(UsageError, match='range of the machine'):
        isochronism(SULLY, [2.6])
    # the thread's end: a tenth of it is left
    short = LeverGeometry(0.02, 1.0, 0.03)
    free = short.pose(np.array(short.edges)).free
    np.testing.assert_allclose(free, 0.003, rtol=1e-9)


def test_the_lever_always_falls_fast_enough():
    """β″ > 0 in twenty geometries of lengths from 3 mm to 1 m: no free swing is slack."""
    rng = np.random.default_rng(1726)
    for lengths in 10.0 ** rng.uniform(-2.5, 0.0, (20, 3)):
        geometry = LeverGeometry(*lengths.tolist())
        bend = geometry.slopes(np.linspace(*geometry.edges, 201))[1]
        assert np.min(bend) > 0.0
