"""Motion along Euler's curve in closed form, against golden numbers and integrated motion."""

import math

import mpmath
import numpy as np
import pytest
from golden_numbers import entries

from tauto_core.curves import FluidTautochrone
from tauto_core.curves.fluid import ActaCurve
from tauto_core.machines.fluid_pendulum import (
    SERIES,
    arcs,
    composed_length,
    descent_time,
    duration_excess,
    end_arc,
    euler_half_swing,
    height_at_lowest,
    jacobi_amplitude,
    quarter_period,
    reverse_half_swing,
    velocity_height,
)
from tauto_core.machines.sections import ImmersedBody
from tauto_core.scene.errors import DescentError

G = 9.81
TIGHT = 1e-15
OIL = FluidTautochrone(0.75, 0.9, 1.0)


def close(actual, expected, tolerance=TIGHT):
    np.testing.assert_allclose(actual, float(expected), rtol=tolerance)


def quarter(curve):
    """Return (π/2) √(f/g): from rest anywhere to A (§15)."""
    return 0.5 * math.pi * math.sqrt(curve.pendulum_length / G)


@pytest.mark.parametrize('entry', entries('B31-34'))
def test_golden_arcs_and_speeds(entry):
    given, expected = {k: v['value'] for k, v in entry['params'].items()}, entry['expected']
    body = ImmersedBody(given['shape'], float(given['a']), 1.0, float(given['n_over_m']))
    curve, b = FluidTautochrone(body.kappa, body.gamma, float(given['f'])), float(given['b'])
    found, time = arcs(curve, b), quarter(curve)
    close(found.descent, expected['arc_descent'])
    close(found.ascent, expected['arc_ascent'])
    close(found.loss, expected['difference'])
    close(found.loss, expected['s_max_velocity'])
    close(velocity_height(curve, found.loss, b), expected['v_max'])
    close(velocity_height(curve, 0.5 * found.descent, b), expected['v_at_half_descent'])
    close(height_at_lowest(curve, found.descent), b)
    close(time, expected['descent_time_s'])
    arc, rate = euler_half_swing(curve, G, found.descent, time)
    close(-rate, expected['V_A_m_s'])
    assert abs(float(arc)) < 2e-16 * found.descent
    end, _ = euler_half_swing(curve, G, found.descent, 2.0 * time)
    close(-end, expected['arc_ascent'])
    # another way to the same time: the integral of ds/V
    close(descent_time(curve, G, found.descent), expected['descent_time_s'])


@pytest.mark.parametrize('entry', entries('B21'))
def test_golden_composed_oscillation(entry):
    given, expected = {k: float(v['value']) for k, v in entry['params'].items()}, entry['expected']
    length = composed_length(given['f'], given['h'])
    close(length, expected['L'])
    close(math.pi * math.sqrt(length / given['g']), expected['T_oscillation_s'])


@pytest.mark.parametrize('entry', entries('B22-reverse'))
@pytest.mark.parametrize('kappa', [1.0, 1e-3])
def test_golden_half_swings_backward(entry, kappa):
    q, expected = float(entry['params']['q']['value']), entry['expected']
    start = -math.log1p(-q) / kappa
    close(kappa * start, expected['start_arc_times_kappa'])
    close(1.0 + float(duration_excess(kappa, start)), expected['T_ratio'])
    close(kappa * end_arc(kappa, start), expected['end_arc_times_kappa'])
    close(math.expm1(kappa * float(end_arc(kappa, start))), expected['end_w_times_kappa'])
    # down to A, and up again, while a quarter forward takes π/2
    down, up = (float(expected[f'{each}_quarter_ratio']) for each in ('descent', 'ascent'))
    arc, _ = reverse_half_swing(kappa, 1.0, start, 0.5 * math.pi * down)
    assert abs(float(arc)) < 1e-15 * abs(start)
    close(0.5 * (down + up), expected['T_ratio'])


@pytest.mark.parametrize('entry', entries('B22-series'))
def test_golden_series_of_the_half_swing_backward(entry):
    """The last coefficient is left out of the sum and bounds the remainder."""
    expected = [float(entry['expected'][f'c{n}']) for n in range(7)]
    np.testing.assert_allclose(SERIES, [0.0, *expected[1:6]], rtol=1e-15)
    for q in (0.003, 0.01):
        excess = float(duration_excess(1.0, -math.log1p(-q)))
        left = excess - np.polynomial.polynomial.polyval(q, SERIES)
        assert left == pytest.approx(expected[6] * q**6, rel=20.0 * q, abs=1e-15)


@pytest.mark.parametrize('start', [1e-9, 0.5, 8.0, 30.0])
def test_a_half_swing_backward_keeps_its_digits(start):
    """W = W₂ − (W₂ + q) sn²(K − u) in 60 digits. The rounding grows as e^{κs₁/2}."""
    with mpmath.workdps(60):
        s = mpmath.mpf(start)
        q, left = -mpmath.expm1(-s), mpmath.exp(-s)
        third = (0.5 + left + mpmath.sqrt((0.5 + left) * (1.5 + 3 * q))) / 2
        second = q * (0.5 + left) / third
        m = (second + q) / (second + third)
        pace, whole = mpmath.sqrt((second + third) / 6), mpmath.ellipk(m)
        times = [float(part * whole / pace) for part in (0.001, 0.1, 0.3, 0.49, 0.51, 0.8, 0.99)]
        expected = [
            mpmath.log1p(second - (second + q) * mpmath.ellipfun('sn', whole - pace * t, m=m) ** 2)
            for t in times
        ]
    arc, _ = reverse_half_swing(1.0, 1.0, np.full(7, start), np.array(times))
    np.testing.assert_allclose(
        arc,
        [float(each) for each in expected],
        atol=2e-15 * min(start, 1.0) * math.exp(0.5 * start),
    )


def test_each_start_of_the_acta_needs_its_own_curve():
    """The reference is the table for κ = 0.4, f = 1, S = 0.5 (theory, fluid)."""
    curve = ActaCurve(0.4, 1.0, 1.0, 0.5)
    quarter = 0.5 * math.pi / math.sqrt(G)
    ratios = [descent_time(curve, G, s) / quarter for s in (0.1, 0.25, 0.4, 0.5)]
    np.testing.assert_allclose(ratios, [0.6769, 0.8563, 0.9504, 1.0], atol=5e-5)
    assert ratios[-1] == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize('ratio', [1e-12, 1e-9, 1e-3, 0.1, 0.5, 0.9])
@pytest.mark.parametrize('shape', ['globe', 'cylinder'])
def test_descents_take_the_same_time_from_anywhere_in_any_medium(ratio, shape):
    body = ImmersedBody(shape, 0.02, 8000.0, 8000.0 * ratio)
    curve = FluidTautochrone(body.kappa, body.gamma, 1.0)
    starts = np.array([1e-3, 0.1, 0.5, 0.99, 1.0]) * curve.descent_cusp
    times = [descent_time(curve, G, start) for start in starts.tolist()]
    np.testing.assert_allclose(times, quarter(curve), rtol=1e-14)


def test_a_body_in_its_fluid():
    globe = ImmersedBody('globe', 0.05, 2.0, 0.2)
    assert (globe.kappa, globe.gamma) == (pytest.approx(0.75), pytest.approx(0.9))
    assert globe.sunk_mass == pytest.approx(1.8 * math.pi * 0.05**3 / 6.0)
    cylinder = ImmersedBody('cylinder', 0.05, 2.0, 0.2)
    assert cylinder.kappa == pytest.approx(1.0)
    assert cylinder.sunk_mass == pytest.approx(1.8 * math.pi * 0.025**2 * 0.05)
    # half of the fluid displaced goes along: inertia 2.1 in place of 2
    heavier = ImmersedBody('globe', 0.05, 2.0, 0.2, 0.5)
    assert heavier.kappa / globe.kappa == pytest.approx(2.0 / 2.1)
    assert heavier.gamma / globe.gamma == pytest.approx(2.0 / 2.1)


@pytest.mark.parametrize(
    ('make', 'named'),
    [
        (lambda: ImmersedBody('globe', 0.05, 2.0, 2.0), 'fluid_density = 2.0 .* 2.0 kg/m3'),
        (lambda: arcs(OIL, 0.9), 'at_lowest = 0.9 m: .* less than 0.888'),
        (lambda: arcs(OIL, 0.2), 'beyond the cusp at 0.687'),
        (lambda: velocity_height(OIL, 0.1, -1.0), 'at_lowest = -1.0'),
        (lambda: euler_half_swing(OIL, G, -0.1, 0.0), 'start = -0.1 m'),
        (lambda: euler_half_swing(OIL, G, 0.7, 0.0), 'start = 0.7 m'),
        (lambda: end_arc(1.0, 0.0), 'start = 0.0 m'),
        (lambda: descent_time(OIL, G, 0.7), 'start = 0.7 m'),
    ],
)
def test_what_cannot_be_is_refused_with_its_limit(make, named):
    with pytest.raises(DescentError, match=named):
        make()


@pytest.mark.parametrize('complement', [1.0, 1.0 - 1e-12, 0.5, 1e-3, 1e-9, 1e-15])
def test_elliptic_functions_keep_their_digits_up_to_the_edge(complement):
    """Towards K cos φ is small, and a rounding of φ is multiplied by tan φ."""
    with mpmath.workdps(40):
        m = 1 - mpmath.mpf(complement)
        whole = mpmath.ellipk(m)
        assert float(quarter_period(np.array([complement]))[0] / whole) == pytest.approx(
            1, abs=5e-16
        )
        for part in (0.01, 0.2, 0.5, 0.9):
            u = part * float(whole)
            phi = float(jacobi_amplitude(np.array([u]), np.array([complement]))[0])
            assert math.sin(phi) == pytest.approx(float(mpmath.ellipfun('sn', u, m=m)), rel=1e-15)
            loose = 1e-15 + 4e-16 * math.tan(phi)
            assert math.cos(phi) == pytest.approx(float(mpmath.ellipfun('cn', u, m=m)), rel=loose)
