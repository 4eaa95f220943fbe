"""Branches of a curve in a fluid, and the companion of a given one, in other arithmetic."""

from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from tauto_core.curves.branches import (
    CircularDescent,
    Companion,
    Quarter,
    ThroughPoints,
    joined_companion,
)
from tauto_core.curves.fluid import Cycloid, FluidTautochrone
from tauto_core.curves.numerics import trapezoid
from tauto_core.scene.errors import DescentError

KAPPA, GAMMA = 0.75, 0.9
LEVEL = np.linspace(0.125, 1.0, 8)
POINTS = np.stack([LEVEL, 0.5 * LEVEL**2 + 0.1 * LEVEL**3], axis=1)
CYCLOID, CIRCLE = Cycloid(KAPPA, GAMMA, 1.0), CircularDescent(KAPPA, GAMMA, 1.0 / GAMMA)
DRAWN = ThroughPoints(KAPPA, GAMMA, POINTS)


def companion_slope(slope: Any, length: float, arc: float) -> tuple[float, float]:
    """Return t and du/dt opposite the arc s of the descent, by Abel's condition in 30 digits."""
    with mp.workdps(30):
        kappa, gamma, s = mpf(KAPPA), mpf(GAMMA), mpf(arc)
        tau = gamma * mp.quad(lambda x: mp.exp(-2 * kappa * x) * slope(x), [0, s])
        z = (1 - mp.exp(-kappa * s)) / kappa
        t = mp.log(1 + kappa * (2 * mp.sqrt(2 * mpf(length) * tau) - z)) / kappa
        rise = mp.sqrt(2 * length / tau) - mp.exp(kappa * s) / (gamma * slope(s))
        return float(t), float(mp.exp(-kappa * t) / (gamma * rise))


@pytest.mark.parametrize(
    ('given', 'slope', 'length'),
    [
        (CYCLOID, lambda s: s / mpf(GAMMA), 1.0),
        (CYCLOID, lambda s: s / mpf(GAMMA), 0.5),
        (CIRCLE, mp.sin, 1.0),
    ],
)
def test_the_companion_is_that_of_abels_condition(given: Any, slope: Any, length: float) -> None:
    found = Companion(given, 'ascent', length)
    for share in (0.02, 0.3, 0.7, 0.98):
        arc, rise = companion_slope(slope, length, share * found.given_end)
        assert float(found.slope(arc)) == pytest.approx(rise, rel=2e-13)


def test_it_ends_where_it_stands_upright() -> None:
    """du/dt = 1 at these arcs of the given branch, by `mpmath.findroot` in 30 digits."""
    for given, length, end in (
        (CIRCLE, 1.0, 0.925401951066286832),
        (CYCLOID, 0.5, 0.366118812972933647),
    ):
        found = Companion(given, 'ascent', length)
        assert found.given_end == pytest.approx(end, rel=1e-13)
        assert float(found.slope(found.end)) == pytest.approx(1.0, rel=1e-12)


def test_of_the_descent_of_euler_it_is_his_ascent() -> None:
    """§19–21: descent and ascent of pendulums f and h are companions, L = ((√f + √h)/2)²."""
    f, h = 1.0, 0.64
    descent, ascent = (FluidTautochrone(KAPPA, GAMMA, each) for each in (f, h))
    length = (0.5 * (f**0.5 + h**0.5)) ** 2
    found: Any = Companion(descent, 'ascent', length)
    arcs = np.linspace(0.01, 0.99, 9) * found.end
    np.testing.assert_allclose(found.slope(arcs), -ascent.slope(-arcs), rtol=1e-13)
    np.testing.assert_allclose(found.slope_rate(arcs), ascent.slope_rate(-arcs), rtol=1e-12)
    np.testing.assert_allclose(found.height(arcs), ascent.height(-arcs), rtol=1e-13)


@pytest.mark.parametrize('given', [CYCLOID, CIRCLE, DRAWN], ids=['cycloid', 'circle', 'points'])
def test_the_companion_of_a_companion_is_the_given_branch(given: Any) -> None:
    found: Any = Companion(given, 'ascent', 1.0)
    again = Companion(found, 'descent', 1.0)
    arcs = np.linspace(0.01, 0.99, 9) * again.end
    np.testing.assert_allclose(again.slope(arcs), given.slope(arcs), rtol=1e-10)


def test_no_companion_exists_for_half_the_time() -> None:
    with pytest.raises(DescentError, match=r'Give more than 0\.25 m'):
        Companion(CYCLOID, 'ascent', 0.25)
    assert Companion(CYCLOID, 'ascent', 0.2501).end > 0.0


def test_a_curve_through_points_passes_them() -> None:
    s = np.linspace(0.0, DRAWN.descent_cusp, 200)
    level = np.array([trapezoid(np.sqrt(1.0 - DRAWN.slope(s[: n + 1]) ** 2), s[: n + 1])
                      for n in range(len(s))])  # fmt: skip
    height = np.interp(LEVEL, level, DRAWN.height(s))
    np.testing.assert_allclose(height, POINTS[:, 1], atol=1e-5)
    assert float(DRAWN.height(DRAWN.descent_cusp)) == pytest.approx(0.6, rel=1e-12)
    # 1/(γ x″) of y²/2 + y³/10 at 0. The mirrored spline has no third derivative there
    assert DRAWN.pendulum_length == pytest.approx(1.0 / GAMMA, rel=0.03)


def test_points_that_lead_nowhere_are_refused() -> None:
    with pytest.raises(DescentError, match='does not rise at'):
        ThroughPoints(KAPPA, GAMMA, np.array([[0.1, 0.02], [0.2, 0.01], [0.3, 0.05]]))
    with pytest.raises(DescentError, match='increasing order'):
        ThroughPoints(KAPPA, GAMMA, POINTS[::-1])


def test_a_branch_knows_its_arc_potential_and_speed() -> None:
    """On the cycloid τ = (1 − (1 + 2κs) e^{−2κs})/(4κ²f), and Euler's z = √(2f) r elsewhere."""
    fall = Quarter(
        CYCLOID.slope, KAPPA, GAMMA, falling=True, reach=0.9, joints=np.array([0.2, 0.5])
    )
    s = np.linspace(0.05, 0.9, 7)
    tau = (1.0 - (1.0 + 2.0 * KAPPA * s) * np.exp(-2.0 * KAPPA * s)) / (4.0 * KAPPA**2)
    np.testing.assert_allclose(fall.root(s), np.sqrt(tau), rtol=1e-13)
    np.testing.assert_allclose(fall.arc(np.sqrt(tau)), s, rtol=1e-13)
    euler = FluidTautochrone(KAPPA, GAMMA, 1.7)
    own = Quarter(euler.slope, KAPPA, GAMMA, falling=True, reach=0.5, joints=np.empty(0))
    np.testing.assert_allclose(own.spread(np.array([1e-3, 0.1, 0.2])), np.sqrt(3.4), rtol=1e-13)


def test_arcs_of_the_joined_curve_have_the_sign_of_their_branch() -> None:
    for side in ('descent', 'ascent'):
        joined = joined_companion(CIRCLE, side, 1.0)
        arcs = np.array([0.5 * joined.ascent_cusp, -0.0, 0.5 * joined.descent_cusp])
        assert (np.sign(joined.slope(arcs)) == [-1.0, 0.0, 1.0]).all()
        given = arcs[2 if side == 'descent' else 0]
        assert float(joined.slope(given)) == pytest.approx(np.sin(given), rel=1e-15)
