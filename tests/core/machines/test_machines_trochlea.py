"""The machine's functions, its construction from a scene, design formulas, isochronism."""

import math
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from golden_numbers import GOLDEN, entries, numbers
from numpy.polynomial.legendre import leggauss

import tauto_core as tauto
from tauto_core.curves import CircularArc, Hole, Involute, Table, TableLever
from tauto_core.machines import Machine, compile_machine, isochronism, rate_s_per_day
from tauto_core.scene.errors import UsageError

NAMED = {entry['id']: entry for entry in GOLDEN}
TABLE = Table(
    'two pieces',
    TableLever(
        np.array([0.0, 1.0, 2.0]),
        # C4 at 1: the fifth derivative alone jumps
        np.array([[0, 0.01, 0, 0.001, 0, 1e-4], [0.0111, 0.0135, 0.004, 0.002, 5e-4, -1e-4]]),
        np.array([0.0, 0.01 / 2 + 0.001 / 4 + 1e-4 / 6]),
    ),
)
CAMS = {
    'involute': Involute(0.01),
    'hole': Hole(0.01, 0.08),
    'arc': CircularArc(0.02, 0.01),
    'table': TABLE,
}
every_cam = pytest.mark.parametrize('cam', CAMS.values(), ids=CAMS.keys())


def machine(cam, mass=0.3):
    return Machine(4e-4, mass, 0.2, 1.5, 30.0, 9.81, cam, False, None, None, 0.1)


def gauss(function, angle, joints=(1.0,)):
    """∫ function from 0 to the angle, 60 points on each side of the joint."""
    nodes, weights = leggauss(60)
    edges = [0.0, *(joint for joint in joints if joint < angle), angle]
    total = 0.0
    for a, b in pairwise(edges):
        total += (b - a) / 2 * np.sum(weights * function((a + b) / 2 + (b - a) / 2 * nodes))
    return total


@every_cam
def test_potential_is_the_work_of_the_pull(cam):
    regulator = machine(cam)
    for angle in (0.01, 0.8, 1.7):
        work = gauss(lambda s: regulator.pull(cam.lift(s)) * cam.lever_arm(s), angle)
        assert regulator.potential(angle) == pytest.approx(work, rel=1e-13)
        assert regulator.potential(-angle) == regulator.potential(angle)
    curvature = (1.5 + 0.2 * 9.81) * float(cam.lever_rate(0.0))
    assert regulator.frequency == pytest.approx(math.sqrt(curvature / 4e-4), rel=1e-15)


@every_cam
@pytest.mark.parametrize('mass', [0.0, 1e-9, 0.3, 1e3])
def test_arc(cam, mass):
    regulator = machine(cam, mass)
    angle = np.array([0.0, 1e-9, 0.4, 1.0, 1.9])
    expected = [
        gauss(lambda s: np.sqrt(4e-4 + mass * cam.lever_arm(s) ** 2), each) for each in angle
    ]
    # 60 points leave 1e-12 as √M nearly vanishes near rest (mass 1000)
    np.testing.assert_allclose(regulator.arc(angle), expected, rtol=1e-11)
    np.testing.assert_array_equal(regulator.arc(-angle), -regulator.arc(angle))
    # chunk invariance: the same bits alone as in company
    np.testing.assert_array_equal([regulator.arc(each) for each in angle], regulator.arc(angle))
    np.testing.assert_allclose(regulator.mass(angle), 4e-4 + mass * cam.lever_arm(angle) ** 2)


@pytest.mark.parametrize('angle', [1e-12, 1e-5, 0.3, 20.0])
def test_arc_of_a_linear_arm_keeps_its_digits(angle):
    with mpmath.workdps(40):
        i, x = mpmath.mpf(4e-4), mpmath.mpf(angle)
        k = mpmath.mpf(0.01) * mpmath.sqrt(mpmath.mpf(0.3) / i)
        root = x * mpmath.sqrt(1 + (k * x) ** 2)
        expected = float(mpmath.sqrt(i) / 2 * (root + mpmath.asinh(k * x) / k))
    assert machine(Involute(0.01)).arc(angle) == pytest.approx(expected, rel=1e-15)


def scene(ship=None, **changes):
    parts = {
        'inertia': 4e-4,
        'cam': {'kind': 'involute', 'base_radius': 0.01},
        'thread': {'kind': 'vertical'},
        'power': FORCE,
        'release_angle': 1.0,
    }
    return tauto.load('ideal', gravity=9.8, ship=ship, trochlea=parts | changes)


HOLE = {'cam': {'kind': 'hole', 'lever_rate': 0.01}, 'thread': {'kind': 'hole', 'distance': 0.08}}
ARC = {'cam': {'kind': 'circular_arc', 'radius': 0.02, 'root_depth': 0.01}}
FORCE = {'kind': 'force', 'force': 2.0}
SPRING = {'kind': 'spring', 'force': 2.0, 'stiffness': 5.0}
WEIGHT = {'kind': 'weight', 'mass': 0.2}
BOTH = {'kind': 'weight_and_spring', 'mass': 0.2, 'stiffness': 5.0}
MASSLESS = {'kind': 'weight', 'mass': 0.2, 'massless': True}


@pytest.mark.parametrize(
    ('changes', 'numbers', 'follows'),
    [
        # carried mass, pulling mass, force, stiffness, and γ = β or α_c (table of
        # machine_at_sea.md)
        ({'power': FORCE}, (0.0, 0.0, 2.0, 0.0), False),
        ({'power': SPRING}, (0.0, 0.0, 2.0, 5.0), False),
        ({'power': WEIGHT}, (0.2, 0.2, 0.0, 0.0), True),
        ({'power': MASSLESS}, (0.0, 0.2, 0.0, 0.0), True),
        ({'power': BOTH}, (0.2, 0.2, 0.0, 5.0), True),
        (HOLE | {'power': FORCE}, (0.0, 0.0, 2.0, 0.0), False),
        (HOLE | {'power': SPRING}, (0.0, 0.0, 2.0, 5.0), False),
        (HOLE | {'power': WEIGHT}, (0.2, 0.2, 0.0, 0.0), False),
        (HOLE | {'power': MASSLESS}, (0.0, 0.2, 0.0, 0.0), False),
    ],
)
def test_machine_of_a_scene(changes, numbers, follows):
    regulator = compile_machine(scene(**changes))
    got = (regulator.carried_mass, regulator.pulling_mass, regulator.force, regulator.stiffness)
    assert got == numbers
    assert regulator.follows_apparent_vertical is follows
    assert (regulator.inertia, regulator.gravity, regulator.release_angle) == (4e-4, 9.8, 1.0)
    assert regulator.cam == (Hole(0.01, 0.08) if 'cam' in changes else Involute(0.01))


ROLLING = {'kind': 'components', 'components': [{'amplitude': 0.1, 'period': 9.0}]}


def test_release_at_the_edge_and_where_the_sea_decides():
    compile_machine(scene(**HOLE, release_angle=8.0))
    # γ = β: roll at the start may bring the cam back into its range
    compile_machine(scene(**ARC, release_angle=3.2, power=WEIGHT, ship=ROLLING))


@pytest.mark.parametrize('entry', entries('A19-21-L'))
def test_pendulum_length_of_a_disc(entry):
    given, expected = numbers(entry)
    g, pull, r = given['g'], given['P'], given['r']
    sizes = {'pull': pull, 'base_radius': r, 'gravity': g}
    found = tauto.design(disc_weight=given['Q'], disc_radius=given['a'], **sizes)
    inertia, length = found.inertia_kg_m2, found.pendulum_m
    assert length == pytest.approx(expected['L_m'], rel=1e-14, abs=0.0)
    assert found.period_s / 2 == pytest.approx(expected['half_period_s'], rel=1e-14, abs=0.0)
    # the machine of that design beats as that pendulum
    regulator = Machine(inertia, 0.0, 0.0, pull, 0.0, g, Involute(r), False, None, None, 0.1)
    assert regulator.period(1.0) / 2 == pytest.approx(expected['half_period_s'], rel=1e-14)
    if r == given['a']:
        of_disc = {'disc_weight': given['Q'], 'disc_is_base': True, 'pendulum': length}
        found = tauto.design(**of_disc, pull=pull, gravity=g)
        assert found.base_radius_m == pytest.approx(r, rel=1e-14)


def test_base_circle_of_paragraph_20():
    _, expected = numbers(NAMED['A20-BC'])
    euler = {'disc_weight': 100.0, 'pull': 1.0, 'disc_is_base': True}
    radius = tauto.design(**euler, pendulum=3166.0).base_radius_m
    assert radius == pytest.approx(expected['BC_scruple'], rel=1e-14)
    # the printed 63 scruples make a shorter pendulum
    back = tauto.design(**euler, base_radius=63.0).pendulum_m
    assert back == pytest.approx(expected['AO_back'], rel=1e-14)


@pytest.mark.parametrize('amplitude', [0.0, -1.0, math.nan, math.inf, 1e300, 1.001e6])
def test_amplitudes_that_no_thread_is_wound_to(amplitude):
    endless = machine(Involute(0.01), mass=0.1)
    assert isochronism(endless, [1e6]).amplitude_rad.tolist() == [1e6]
    with pytest.raises(UsageError, match=r'range of the machine, 1000000\.0 rad'):
        isochronism(endless, [amplitude])


def test_isochronism():
    regulator = compile_machine(scene(**HOLE, power=SPRING))
    table = isochronism(regulator, [1.0, 0.1])
    assert table.nominal_period_s == regulator.small_period
    assert table.amplitude_rad.tolist() == [1.0, 0.1]
    assert table.period_s[1] == regulator.period(0.1)
    # machine_at_sea.md: a spring of 5 N/m gains 404 s/day at 1 rad (to the digits given)
    assert table.rate_s_per_day[0] == pytest.approx(404.0, abs=0.5)
    slow = isochronism(regulator, [0.1], nominal_period_s=1.0)
    assert slow.nominal_period_s == 1.0
    assert slow.rate_s_per_day[0] == rate_s_per_day(regulator.period(0.1), 1.0)
