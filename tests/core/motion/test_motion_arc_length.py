"""The arc length as a coordinate: its functions and polynomials against mpmath, and its limit."""

from __future__ import annotations

import math
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from motion_cases import arc, moved, on_land, scene_of, weight_of

from tauto_core.machines import compile_machine
from tauto_core.motion.closed_forms import ActionAngle
from tauto_core.motion.collocation import Collocation
from tauto_core.motion.wells import (
    MAX_TERMS,
    REACH_PER_RELEASE,
    SHORTENING_SLOPE,
    angle_of,
    arc_of,
    arc_shape,
)

RATE = 0.01


def machine_of(k, release=1.0):
    """A weight on an involute with k = b√(m/I)."""
    trochlea = weight_of(2.0, RATE, release_angle=release)
    machine = compile_machine(scene_of(trochlea=trochlea))
    mass = machine.inertia * (k / RATE) ** 2
    return replace(machine, carried_mass=mass, pulling_mass=mass)


def exact_arc(angle, k):
    """s = ∫√(1 + k²ϑ²) dϑ, to the working precision."""
    x = k * angle
    return (angle * mpmath.sqrt(1 + x * x) + mpmath.asinh(x) / k) / 2


def exact_angle(arc, k):
    """The root of s(ϑ) − s, from its series ϑ = s − k²s³/6 …, by Newton's method."""
    angle = arc
    for _ in range(100):
        step = (exact_arc(angle, k) - arc) / mpmath.sqrt(1 + (k * angle) ** 2)
        angle -= step
        if abs(step) < mpmath.mpf(10) ** (10 - mpmath.mp.dps) * abs(arc):
            return angle
    raise AssertionError('no root')


@pytest.mark.parametrize(
    ('k', 'release'), [(1e-6, 1.0), (1e-3, 1.0), (0.03, 1.0), (0.1, 1.0), (0.3, 1.0), (0.5, 0.6)]
)
def test_polynomials_hold_over_their_whole_range(k, release):
    """n, ϑ/s and nt/s − b to 5e-15 of the largest of each, their fit and a rounding.

    (dn/ds)/s is the derivative of the polynomial of n: both belong to one Hamiltonian. It may lose
    2·degree² by Markov's inequality, and 2/limit by the chain rule.
    """
    machine = machine_of(k, release)
    shape = arc_shape(machine)
    assert shape is not None
    assert shape.k == pytest.approx(k, rel=1e-15)
    assert shape.terms.shape[1] <= MAX_TERMS
    with mpmath.workdps(60):
        reach = REACH_PER_RELEASE * machine.release_angle + 0.1
        assert math.isclose(shape.limit, float(exact_arc(mpmath.mpf(reach), shape.k) ** 2))
        rows = []
        for u in [1e-9, *np.linspace(0.003, 1.0, 61).tolist()]:
            limit, along = mpmath.mpf(shape.limit), mpmath.mpf(shape.k)
            arc = mpmath.sqrt(limit * u)
            angle = exact_angle(arc, along)
            n = 1 / mpmath.sqrt(1 + (along * angle) ** 2)
            slope = -(along**2) * angle / arc * n**4
            lever = machine.cam.linear_rate * (n * angle / arc - 1) / u
            rows.append([u, *map(float, (n, slope, lever, angle / arc))])
    u, *wanted = np.array(rows).T
    degree = shape.terms.shape[1] - 1
    sizes = [float(np.max(np.abs(exact))) for exact in wanted]
    sizes[SHORTENING_SLOPE] = 2.0 * degree**2 * 2.0 / shape.limit
    for terms, exact, size in zip(shape.terms, wanted, sizes, strict=True):
        found = np.polynomial.polynomial.polyval(u, terms)
        np.testing.assert_allclose(found, exact, rtol=0, atol=5e-15 * size)


def test_wells_without_a_weight_or_a_linear_lever_keep_the_angle():
    machine = machine_of(0.1)
    assert arc_shape(replace(machine, carried_mass=0.0)) is None
    cheek = weight_of(2.0, RATE, cam=arc(0.02, 0.01))
    assert arc_shape(compile_machine(scene_of(trochlea=cheek))) is None
    # a polynomial in u = s² as far as kϑ = 0.8 would be too long
    assert arc_shape(machine_of(0.5, release=1.0)) is None


@pytest.mark.parametrize('k', [1e-6, 1e-3, 0.1, 0.5, 3.0])
def test_arc_and_angle_are_inverse_over_six_hundred_orders(k):
    """Each, and both in turn, to a few roundings."""
    sizes = [1e-300, 1e-200, 1e-100, 1e-30, 1e-9, 1e-3, *np.geomspace(0.01, 1e6, 33).tolist()]
    with mpmath.workdps(400):
        for size in sizes:
            arc = arc_of(size, k)
            assert abs(arc / exact_arc(mpmath.mpf(size), mpmath.mpf(k)) - 1) < 5e-16
    with mpmath.workdps(40):
        for size in sizes:
            assert angle_of(arc_of(size, k), k) == pytest.approx(size, rel=1e-15, abs=0.0)
            assert arc_of(angle_of(size, k), k) == pytest.approx(size, rel=1e-15, abs=0.0)
            assert angle_of(-size, k) == -angle_of(size, k)
            assert arc_of(-size, k) == -arc_of(size, k)
    assert angle_of(0.0, k) == arc_of(0.0, k) == 0.0


@pytest.mark.parametrize('k', [0.1, 0.35])
def test_beyond_the_limit_the_functions_themselves_agree(k):
    """A swing of 1 rad with the polynomials of one of 0.1 rad, which end at 0.25 rad.

    Steps are within, across and beyond the limit, which the quadrature of the well does not have.
    After 45 swings both engines err by at most 1e-12 rad (measured 2e-13).
    """
    machine, small = machine_of(k), machine_of(k, release=0.1)
    engine, short = Collocation(machine), Collocation(machine)
    short._shape = arc_shape(small)
    assert short._shape.limit < 0.07 < engine._shape.limit
    forcing = on_land(640, 0.0625)
    exact = ActionAngle(machine).advance(forcing)
    for each in (engine, short):
        found = moved(each, forcing)
        np.testing.assert_allclose(found.angle, exact.angle, rtol=0, atol=1e-12)
        np.testing.assert_allclose(found.rate, exact.rate, rtol=0, atol=1e-12 * machine.frequency)
        np.testing.assert_array_equal(found.half_turns, exact.half_turns)
