"""Sully's lever with its own cam: the thread, the cam and the period."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Chebyshev

from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
from tauto_core.curves.cams.synthesised import PowerTrain, synthesise

# the machine of golden A5: r 20 mm, l0 300 mm, AB 100 mm, AD 150 mm, 50 g, with its small period
INERTIA, TORQUE, TURNED = 4e-4, 0.05 * 9.81 * 0.15, 0.05 * 0.15**2
OMEGA = math.sqrt(TORQUE / 0.1 * 0.02 * (1 + 0.02 / 0.3) / INERTIA)
CAM = CorrectedLeverGeometry(INERTIA, OMEGA, TORQUE, TURNED, 0.1, 0.3)


def fit(function, edges, terms=80):
    return Chebyshev.interpolate(function, terms, domain=edges)


EDGES = [0.85 * edge for edge in CAM.edges]
TAU = np.linspace(*EDGES, 12)


def test_against_the_general_synthesis():
    train = PowerTrain(
        pull=lambda b: TORQUE * np.cos(b),
        place=lambda v: np.arcsin(np.minimum(v / TORQUE, 1.0)),
        mass=lambda b: np.full_like(b, TURNED),
        largest=0.999 * TORQUE,
    )
    found = synthesise(INERTIA, OMEGA, train)
    assert (CAM.base_radius, CAM.depth) == pytest.approx((0.02, 0.32), rel=1e-14)
    theta = np.array([1e-6, 0.01, 0.3, 1.0, 1.8])
    arc, tau = found.arc(theta), CAM.tau_of(theta)
    np.testing.assert_allclose(CAM.theta(tau), theta, rtol=1e-15)
    np.testing.assert_allclose(CAM.slopes(tau)[0], found.ratio(arc), rtol=1e-14)
    np.testing.assert_allclose(CAM.pose(tau).beta, found.place(arc), rtol=1e-14)
    np.testing.assert_allclose(CAM.pose(CAM.tau_of(-theta)).beta, found.place(arc), rtol=1e-14)


def test_the_thread_reaches_from_the_cam_to_the_lever():
    """By points of the cheek alone: it is tangent, passes through B and keeps its length."""
    pose, (x, y) = CAM.pose(TAU), CAM.contact(TAU)
    theta = CAM.theta(TAU)
    # into the case: mirrored, +y down, then turned with the wheel
    case_x, case_y = np.cos(theta) * x + np.sin(theta) * y, np.sin(theta) * x - np.cos(theta) * y
    b_x = -0.1 + 0.1 * np.cos(pose.beta)
    b_y = -CAM.depth + 0.1 * np.sin(pose.beta)
    free = np.hypot(b_x - case_x, b_y - case_y)
    np.testing.assert_allclose(free, pose.free, rtol=1e-12)
    along = (b_x - case_x) / free, (b_y - case_y) / free
    np.testing.assert_allclose(along[0], np.sin(pose.delta), atol=1e-13)
    fits = [fit(lambda tau, i=i: CAM.contact(tau)[i], EDGES) for i in range(2)]
    dx, dy = (each.deriv()(TAU) for each in fits)
    speed = np.hypot(dx, dy)
    u = pose.u
    np.testing.assert_allclose((dx * np.cos(u) + dy * np.sin(u)) / speed, 0.0, atol=1e-8)
    for side in (EDGES[0], EDGES[1]):
        ends = sorted([0.0, side])
        length = fit(lambda tau: np.hypot(*(each.deriv()(tau) for each in fits)), ends, 200)
        wound = abs(length.integ()(side) - length.integ()(0.0))
        total = wound + CAM.pose(np.array([side])).free[0]
        # the fits' derivatives, the tip among them
        assert total == pytest.approx(0.3, rel=1e-8)


def test_cheeks_are_convex_and_their_radius_is_the_points():
    fits = [fit(lambda tau, i=i: CAM.contact(tau)[i], EDGES) for i in range(2)]
    dx, dy, ddx, ddy = (each.deriv(n)(TAU) for n in (1, 2) for each in fits)
    radius = (dx * dx + dy * dy) ** 1.5 / np.abs(dx * ddy - dy * ddx)
    found = CAM.radius_of_curvature(TAU)
    assert np.all(found > 0.0)
    np.testing.assert_allclose(found, radius, rtol=1e-6)
    assert abs(float(CAM.radius_of_curvature(np.array([1e-12]))[0])) < 1e-12
    # the sides differ
    left, right = CAM.radius_of_curvature(np.array([0.4, -0.4]))
    assert abs(left / right - 1) > 0.05


sizes = st.floats(0.5, 2.0)


@settings(max_examples=10, deadline=None, derandomize=True)
@given(sizes, sizes, sizes, sizes, st.floats(0.1, 1.0))
def test_any_lever_keeps_its_period(inertia, arm, torque, turned, part):
    """The reference is a quadrature over θ of √(M/(2(E − V))), good to 1e-11."""
    cam = CorrectedLeverGeometry(
        inertia * INERTIA, 0.7 * OMEGA, torque * TORQUE, turned * TURNED, 0.1 * arm, 0.3
    )
    top = part * cam.edges[1]
    energy = cam.weight_torque * 2 * top**2 / (1 + top**4)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    angle = 0.25 * math.pi * (nodes + 1)
    # V = E sin²v: the speed's zero at the turning point goes out
    sine = energy * np.sin(angle) ** 2 / cam.weight_torque
    tau = np.sqrt(np.tan(0.5 * np.arcsin(sine)))
    pose, (slope, _) = cam.pose(tau), cam.slopes(tau)
    mass = cam.inertia + cam.turned_inertia * slope**2
    force = cam.weight_torque * np.cos(pose.beta) * slope
    rate = np.sqrt(2 * energy * mass) * np.sin(angle) / force
    quarter_s = 0.25 * math.pi * float(weights @ rate)
    assert 4 * quarter_s == pytest.approx(math.tau / cam.frequency, rel=1e-11)


def test_edges():
    low, high = CAM.edges
    beyond = CAM.pose(np.array([low - 1e-3, high + 1e-3]))
    # here the thread is nearly used up
    np.testing.assert_allclose(CAM.pose(np.array([low, high])).free, 0.03, rtol=1e-9)
    assert np.all(beyond.free < 0.03)
    # a heavy lever cannot swing so fast: the range ends as ρ diverges
    heavy = replace(CAM, turned_inertia=40 * TURNED)
    assert heavy.edges[1] < 0.2 * high
    assert np.isnan(heavy.theta(np.array([0.9])))[0]
    assert np.isnan(heavy.pose(np.array([0.9])).free)[0]


def test_a_cam_that_ends_where_the_thread_lies_level():
    """The search for its end comes upon δ = π/2 itself, a pole of tan δ."""
    cam = CorrectedLeverGeometry(
        0.00037191386067335114, 4.4293872708872835, 0.006538581953352763, 1.327128005244895e-05,
        0.010317415791880004, 0.00820910980476584,
    )  # fmt: skip
    assert np.all(np.isfinite(cam.theta(np.array(cam.edges))))
