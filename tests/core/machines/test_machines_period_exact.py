"""Periods to 1e-14 in wells far from harmonic, up to the cam's edge, against 32 digits of mpmath.

The reference integrates T = 4 ∫ √(M/(2(V(A) − V(ϑ)))) dϑ in x, ϑ = A (1 − x²), with lever arm and
lift written out; the digits compensate the cancellation in V(A) − V(ϑ) near the turning point. Its
nodes and weights are doubles, so it is accurate to about 3e-16. The tolerance is the stated 1e-14.
"""

import math
from bisect import bisect
from functools import reduce
from itertools import accumulate, pairwise

import mpmath
import numpy as np
import pytest
from mpmath import mpf
from numpy.polynomial import Polynomial

from tauto_core.curves import CircularArc, Hole, Table, TableLever
from tauto_core.curves.numerics import integrate
from tauto_core.machines import Machine, QuadratureError

INERTIA, GRAVITY = 4e-4, 9.81
PROMISED = 1e-14
NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)


def machine(cam, *, force=0.0, mass=0.0, stiffness=0.0):
    return Machine(
        INERTIA, mass, mass, force, stiffness, GRAVITY, cam, False, None, None, release_angle=0.1
    )


def period_in_digits(well, arm, lift, amplitude, cuts=()):
    """Return T of a well [s], of a lever arm t and lift h as functions of mpf."""
    with mpmath.workdps(32):
        inertia, mass, stiffness = mpf(well.inertia), mpf(well.carried_mass), mpf(well.stiffness)
        pull = mpf(well.force) + mpf(well.pulling_mass) * mpf(well.gravity)
        top = mpf(amplitude)

        highest = lift(top)

        def integrand(x):
            angle = top * (1 - x * x)
            height = lift(angle)
            left = (highest - height) * (pull + stiffness * (highest + height) / 2)
            return x * mpmath.sqrt((inertia + mass * arm(angle) ** 2) / (2 * left))

        inner = [mpmath.sqrt(1 - mpf(cut) / top) for cut in cuts if cut < top]
        # towards ϑ = 0 the well may change within a millionth of the swing
        grades = [1 - mpf(2) ** -k for k in (1, 4, 8, 12, 16, 20, 24)]
        edges = sorted({mpf(0), mpf(1), *inner, *grades})
        total = mpf(0)
        for a, b in pairwise(edges):
            values = [integrand(a + (b - a) * (1 + mpf(x)) / 2) for x in NODES]
            total += (b - a) / 2 * mpmath.fdot(values, map(mpf, WEIGHTS))
        return 8 * top * total


def off(period, exact):
    """Return the relative error of a period."""
    return abs(float((mpf(period) - exact) / exact))


POWERS = {
    'force': {'force': 2.0},
    'weight': {'mass': 0.2},
    'heavy weight': {'mass': 5.0},
    'weight and spring': {'mass': 0.2, 'stiffness': 50.0},
    'spring': {'force': 2.0, 'stiffness': 50.0},
    'bare spring': {'force': 1e-3, 'stiffness': 1e4},
}


@pytest.mark.parametrize('share', [0.3, 1.0 - 1e-9, 1.0])
@pytest.mark.parametrize('power', POWERS.values(), ids=POWERS.keys())
@pytest.mark.parametrize('radius_depth', [(0.02, 0.01), (0.02, 1e-4), (1e-3, 0.05)])
def test_circular_arc(radius_depth, power, share):
    """The lever arm of the third arc falls to a twenty-fifth of its largest value at the edge."""
    cam = CircularArc(*radius_depth)
    well, amplitude = machine(cam, **power), share * cam.range_rad
    radius, depth = map(mpf, radius_depth)

    def arm(angle):
        return depth * mpmath.sin(angle) + radius * (1 - mpmath.cos(angle))

    def lift(angle):
        return depth * (1 - mpmath.cos(angle)) + radius * (angle - mpmath.sin(angle))

    exact = period_in_digits(well, arm, lift, amplitude)
    assert off(well.period(amplitude), exact) < PROMISED


@pytest.mark.parametrize('share', [1e-9, 0.3, 1.0 - 1e-9, 1.0])
@pytest.mark.parametrize('stiffness', [50.0, 1e4, 1e7])
def test_stiff_spring_on_a_linear_arm(stiffness, share):
    """Duffing's oscillator, T = 4 K(m)/√(α + βA²), nearly a pure quartic at the edge."""
    cam = Hole(0.01, 0.08)
    well, amplitude = machine(cam, force=1e-3, stiffness=stiffness), share * cam.range_rad
    with mpmath.workdps(32):
        alpha = mpf(1e-3) * mpf(0.01) / mpf(INERTIA)
        beta = mpf(stiffness) * (mpf(0.01) * mpf(amplitude)) ** 2 / (2 * mpf(INERTIA))
        modulus = beta / (2 * (alpha + beta))
        exact = 4 * mpmath.ellipk(modulus) / mpmath.sqrt(alpha + beta)
    assert off(well.period(amplitude), exact) < PROMISED


def horner(coefficients, x):
    """Return Σ c_j x^j."""
    return reduce(lambda value, c: value * x + c, reversed(coefficients))


# lever arms Σ c_j ϑ^j: bending, falling to a tenth of its highest, nearly flat in the middle
LAWS = {
    'bending': ([0.0, 0.01, 0.0, 0.001, 0.0, -1e-4], 2.0),
    'falling': ([0.0, 0.1, 0.0, -0.055, 0.0, 0.0078], 2.2),
    'flat': ([0.0, 1e-5, 0.0, 0.01], 3.0),
}


@pytest.mark.parametrize('share', [0.6, 1.0 - 1e-9, 1.0])
@pytest.mark.parametrize('power', ['force', 'weight', 'bare spring'])
@pytest.mark.parametrize('law', LAWS.values(), ids=LAWS.keys())
def test_table(law, power, share):
    coefficients, edge = law
    knots = np.linspace(0.0, edge, 5)
    whole = Polynomial(coefficients)
    rows = np.array(
        [[whole.deriv(j)(k) / math.factorial(j) if j else whole(k) for j in range(6)]
         for k in knots[:-1]]
    )  # fmt: skip
    cam = Table('law', TableLever(knots, rows, whole.integ()(knots[:-1])))
    powers = POWERS[power] if power != 'weight' else {'mass': 1e-3}
    well, amplitude = machine(cam, **powers), share * edge

    def arm(angle):
        row = bisect(knots[1:-1].tolist(), angle)
        x = angle - mpf(knots[row])
        return horner(arms[row], x)

    def lift(angle):
        row = bisect(knots[1:-1].tolist(), angle)
        return below[row] + horner(lifts[row], angle - mpf(knots[row]))

    with mpmath.workdps(32):
        arms = [[mpf(c) for c in row] for row in rows]
        lifts = [[mpf(0), *(c / (j + 1) for j, c in enumerate(row))] for row in arms]
        spans = [mpf(b) - mpf(a) for a, b in pairwise(knots)]
        below = [mpf(0), *accumulate(map(horner, lifts, spans))]

    exact = period_in_digits(well, arm, lift, amplitude, cuts=knots[1:-1].tolist())
    assert off(well.period(amplitude), exact) < PROMISED


def test_integrals_of_thin_layers():
    """∫ 1/(δ² + x²) from 0 to 1 is atan(1/δ)/δ, whatever integrals are computed with it."""
    for delta in (1e-3, 1e-6, 1e-9):

        def layer(x, width=delta):
            return 1 / (width * width + x * x)

        alone = integrate(layer, np.zeros(1), np.ones(1))
        np.testing.assert_allclose(alone, math.atan(1 / delta) / delta, rtol=2e-15)
        three = integrate(layer, np.array([0.5, 0.0, 0.2]), np.ones(3))
        assert three[1] == alone[0]


@pytest.mark.parametrize(
    'rough',
    [
        lambda x: 1 / np.abs(x - 1 / 3),
        lambda x: np.full_like(x, np.nan),
        lambda x: np.sin(1e9 * x * x),
    ],
    ids=['pole', 'nan', 'noise'],
)
def test_integrals_that_do_not_settle_are_refused(rough):
    with pytest.raises(QuadratureError, match='does not settle'):
        integrate(rough, np.array([0.0, 0.0]), np.array([1.0, 0.5]))
