"""Cams made for any power train: against closed forms, and the period at every amplitude."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core.curves import SpringCorrected, WeightCorrected
from tauto_core.curves.cams.synthesised import (
    PowerTrain,
    SynthesisError,
    synthesise,
    synthesised_cam,
)
from tauto_core.machines import Machine

INERTIA, OMEGA = 4e-4, math.pi


def train(force, stiffness, mass):
    """A spring of pull P + κy that carries a mass, which feels no gravity of its own."""
    return PowerTrain(
        pull=lambda y: force + stiffness * y,
        place=lambda v: 2 * v / (force + np.sqrt(force**2 + 2 * stiffness * v)),
        mass=lambda y: np.full_like(y, mass),
    )


def test_weight_against_its_closed_form():
    found = synthesise(INERTIA, OMEGA, train(0.05 * 9.81, 0.0, 0.05))
    cam = WeightCorrected(INERTIA * OMEGA**2 / (0.05 * 9.81), 0.05 / INERTIA)
    assert found.angle_range == pytest.approx(float(cam.angle_of_slope(1e150)), rel=1e-14)
    angle = np.array([1e-9, 1e-3, 0.1, 1.0, 4.0, 8.0, 8.7])
    arc = found.arc(angle)
    np.testing.assert_allclose(found.angle(arc), angle, rtol=1e-15)
    np.testing.assert_allclose(found.place(arc), cam.lift(angle), rtol=2e-15)
    np.testing.assert_allclose(found.ratio(arc), cam.lever_arm(angle), rtol=1e-14)


def test_spring_against_its_closed_form():
    found = synthesise(INERTIA, OMEGA, train(2.0, 50.0, 0.0))
    cam = SpringCorrected(INERTIA * OMEGA**2 / 2.0, 25.0)
    assert found.angle_range == math.inf
    angle = np.array([1e-9, 0.1, 3.0, 50.0])
    np.testing.assert_allclose(found.ratio(found.arc(angle)), cam.lever_arm(angle), rtol=2e-15)
    made = synthesised_cam(found, edge=3.0)
    assert made.joints.size == 0
    angle = np.linspace(1e-6, 3.0, 40)
    for name in ('lever_arm', 'lever_rate', 'lift', 'radius_of_curvature'):
        expected = getattr(cam, name)(angle)
        # two derivatives of a fit to rounding lose digits
        np.testing.assert_allclose(getattr(made, name)(angle), expected, rtol=1e-10)


log = st.floats(-1.0, 1.0)


@settings(max_examples=4, deadline=None, derandomize=True)
@given(log, log, st.floats(0.0, 0.3), st.floats(-3.0, 0.5), st.floats(0.02, 0.98))
def test_any_machine_keeps_its_period(inertia, force, softness, mass, part):
    """By quadrature, to 1e-11. bκ/P < 1/3 keeps the cheek convex near the tip."""
    i, p = 4e-4 * 10**inertia, 2.0 * 10**force
    rate = i * OMEGA**2 / p
    kappa, m = softness * p / rate, 10**mass * i / rate**2 * 0.01
    found = synthesise(i, OMEGA, train(p, kappa, m))
    edge = 0.98 * min(found.angle_range, 6.0)
    cam = synthesised_cam(found, edge=edge)
    well = Machine(i, m, 0.0, p, kappa, 9.81, cam, False, None, None, 0.1)
    periods = [well.period(a) for a in (1e-3 * edge, part * edge, 0.999 * edge)]
    np.testing.assert_allclose(periods, math.tau / OMEGA, rtol=1e-11)


def test_refusals():
    with pytest.raises(SynthesisError, match='slower by itself'):
        # a pull that starts from 0: the train is a pendulum of its own, too slow
        synthesise(
            INERTIA,
            OMEGA,
            PowerTrain(
                lambda y: 0.1 * y, lambda v: np.sqrt(20 * v), lambda y: np.full_like(y, 1.0)
            ),
        )
    with pytest.raises(SynthesisError, match='all of the speed'):
        synthesised_cam(synthesise(INERTIA, OMEGA, train(0.5, 0.0, 0.05)), edge=20.0)
    with pytest.raises(SynthesisError, match='finite'):
        synthesised_cam(synthesise(INERTIA, OMEGA, train(0.2, 100.0, 0.0)))
