"""Sully's own lever: its thread on an arc, its tail weight and the side of its fulcrum.

The references follow from the length of the thread. DOP853 gives the motion, mpmath the period.
"""

import math

import mpmath
import numpy as np
import pytest
from motion_cases import (
    LEVER_WHEEL,
    SEA,
    TIED,
    moved,
    on_land,
    phases,
    rolling,
    sampled,
    scene_of,
)
from thread_references import HELD, LeverReference, swing

from tauto_core.curves.cams.lever_corrected import CorrectedArcLeverGeometry
from tauto_core.curves.lever_geometry import ArcLeverGeometry
from tauto_core.machines import compile_machine
from tauto_core.motion.real_threads import RealThreads
from tauto_core.scene import load_scene
from tauto_core.scene.errors import SceneError

ARC = {'kind': 'lever', 'arc': 0.1, 'weight_arm': 0.15, 'length': 0.3}
TAIL = {'tail': {'mass': 0.03, 'distance': 0.08}, 'inertia': 2e-4}
PORT = {'fulcrum': 'port'}


def trochlea(thread, **more):
    return {**LEVER_WHEEL, 'thread': thread, **more}


CASES = {
    'arc, tail weight, drag, escapement, to port': (ARC | TAIL | PORT, HELD),
    'tied, fulcrum to port, tail weight': (TIED | TAIL | PORT, {}),
}


@pytest.mark.parametrize('name', CASES)
def test_at_sea_against_dop853_on_the_same_samples(name):
    """With the tolerances of `test_motion_real_threads`."""
    thread, more = CASES[name]
    scene = scene_of(
        trochlea=trochlea(thread), ship=SEA, duration=9.0, log={'interval': 0.3}, **more
    )
    machine = compile_machine(scene)
    moment, turned = 0.05 * 0.15 - 0.03 * 0.08, 0.05 * 0.15**2 + 0.03 * 0.08**2 + 2e-4
    side = -1.0 if 'fulcrum' in thread else 1.0
    reference = LeverReference(machine, side, arc='arc' in thread, given=(moment, turned))
    forcing = sampled(scene)
    found, exact = moved(RealThreads(machine), forcing), swing(reference, forcing)
    np.testing.assert_allclose(found.angle, exact[:, 0], rtol=0, atol=2e-11)
    np.testing.assert_allclose(found.rate, exact[:, 1], rtol=0, atol=2e-10)
    assert np.ptp(found.angle) > 1.0


# T/T₀ at 0.5, 1 and 1.5 rad: threads.md; two of the tied lever to port are not given there
PERIODS = {
    'tied': (TIED, (1.00754, 1.02994, 1.06793)),
    'arc': (ARC, (1.00806, 1.03308, 1.07831)),
    'tied, to port': (TIED | PORT, (None, 1.02972, 1.06611)),
    'arc, to port': (ARC | PORT, (None, 1.03312, 1.07843)),
}


@pytest.mark.parametrize('name', PERIODS)
def test_the_periods_are_those_known_to_five_digits(name):
    thread, known = PERIODS[name]
    machine = compile_machine(scene_of(trochlea=trochlea(thread)))
    for amplitude, ratio in zip((0.5, 1.0, 1.5), known, strict=True):
        if ratio is not None:
            assert round(machine.period(amplitude) / machine.small_period, 5) == ratio


@pytest.mark.parametrize('side', [1, -1])
def test_the_period_agrees_to_thirteen_digits(side):
    """T = 2 ∫√(M/2(E − V)) dθ between the turning points, over u = angle of a half circle."""
    thread = ARC | TAIL | (PORT if side < 0 else {})
    machine = compile_machine(scene_of(trochlea=trochlea(thread)))
    mp = mpmath.mp.clone()
    mp.dps = 30
    r, rho, length = mp.mpf(0.02), mp.mpf(0.1), mp.mpf(0.3)
    depth, weight, small = r + length, mp.mpf(0.05), mp.mpf(0.03)
    moment = weight * mp.mpf(0.15) - small * mp.mpf(0.08)
    turned = weight * mp.mpf(0.15) ** 2 + small * mp.mpf(0.08) ** 2 + mp.mpf(2e-4)
    torque, inertia = moment * mp.mpf(machine.gravity), mp.mpf(machine.inertia)

    def u(delta):
        return (rho * (1 - mp.cos(delta)) - depth * mp.sin(delta)) / r

    def beta(delta):
        rest = delta - mp.sin(delta) - depth * (1 - mp.cos(delta)) / rho
        return r * u(delta) ** 2 / (2 * rho) + rest

    ends = [mp.findroot(lambda d: u(d) + d - side, -side * 0.07)]
    energy = torque * mp.sin(beta(ends[0]))
    ends.append(mp.findroot(lambda d: torque * mp.sin(beta(d)) - energy, side * 0.07))
    middle, half = (ends[0] + ends[1]) / 2, (ends[0] - ends[1]) / 2

    def slowness(x):
        delta = middle + half * mp.cos(x)
        free = depth * mp.cos(delta) - rho * mp.sin(delta) - r
        mass = inertia + turned * (r * u(delta) / rho) ** 2
        left = energy - torque * mp.sin(beta(delta))
        return mp.sqrt(mass / (2 * left)) * free / r * abs(half) * mp.sin(x)

    # the ends of the quadrature are not evaluated
    period = 2 * mp.quad(slowness, mp.linspace(0, mp.pi, 5))
    assert machine.period(1.0) == pytest.approx(float(period), rel=1e-13)


@pytest.mark.parametrize('fulcrum', ['starboard', 'port'])
def test_the_corrected_cam_makes_every_swing_take_a_second(fulcrum):
    """It returns to the release each second, and the thread's length is the same at every angle.

    The cheek's arc is ∫ R du, to the error of the trapezoidal rule.
    """
    thread = ARC | TAIL | {'fulcrum': fulcrum}
    cam = {'kind': 'lever_corrected', 'period': 1.0}
    machine = compile_machine(scene_of(trochlea=trochlea(thread, cam=cam)))
    assert machine.small_period == pytest.approx(1.0, rel=1e-14)
    for amplitude in (0.3, 1.0, -1.1):
        assert machine.period(amplitude) == pytest.approx(1.0, rel=1e-13)
    shape = machine.geometry
    shape = shape if fulcrum == 'starboard' else shape.linkage
    assert isinstance(shape, CorrectedArcLeverGeometry)
    for end in shape.edges:
        tau = np.linspace(0.0, end, 16001)
        u, beta, delta, free = shape.pose(tau)
        radius = shape.radius_of_curvature(tau)
        # R at the tip has the other sign on the other side
        radius[0] = 2.0 * radius[1] - radius[2]
        on_cam = np.concatenate(
            [[0.0], np.cumsum(0.5 * (radius[1:] + radius[:-1]) * np.abs(np.diff(u)))]
        )
        whole = on_cam + free + shape.arm * (delta - beta)
        np.testing.assert_allclose(whole, shape.length, rtol=0, atol=2e-8)
        # the line of the thread touches the arc of the lever
        touched = -shape.arm * np.cos(delta) - shape.depth * np.sin(delta) + shape.arm
        np.testing.assert_allclose(shape.lever_arm(tau), touched, rtol=0, atol=1e-16)
    angle = moved(RealThreads(machine), on_land(40, 0.25)).angle
    np.testing.assert_allclose(angle[3::4], machine.release_angle, rtol=0, atol=1e-11)


@pytest.mark.parametrize(
    ('radius', 'arc', 'length'),
    [(0.02, 0.1, 0.3), (0.005, 0.2, 1.0), (0.1, 0.01, 0.3), (0.02, 1.0, 0.03)],
)
def test_thread_and_arc_meet(radius, arc, length):
    """The line of the thread is ρ from the fulcrum, and the thread keeps its length."""
    shape = ArcLeverGeometry(radius, arc, length)
    tau = np.linspace(*shape.edges, 201)
    u, beta, delta, free = shape.pose(tau)
    touched = radius * u - (-arc * np.cos(delta) - (radius + length) * np.sin(delta))
    np.testing.assert_allclose(touched, arc, rtol=0, atol=1e-15 * (1.0 + length / arc))
    whole = 0.5 * radius * u * u + free + arc * (delta - beta)
    np.testing.assert_allclose(whole, length, rtol=0, atol=4e-15 * (arc + length))
    assert np.all(np.diff(shape.theta(tau)) > 0.0)
    # a minute swing keeps its digits
    small = np.array([1e-9, -1e-9])
    ratio = math.sqrt(4.0 * arc * length / (radius * (radius + length)))
    np.testing.assert_allclose(shape.theta(small), small * ratio, rtol=1e-7)


def test_a_heeled_lever_loses_as_the_root_of_the_cosine():
    """Small swings of a level lever without gimbals, about the same rest (threads.md)."""
    heel = math.radians(10.0)
    scene = scene_of(
        trochlea=trochlea(ARC, release_angle=1e-3),
        ship=rolling((heel, 1e9, 0.0)),
        duration=960.0,
        log={'interval': 480.0},
    )
    small = compile_machine(scene).small_period
    rate = (phases(scene)[-1, 0] / math.tau * small / 960.0 - 1.0) * 86400.0
    assert rate == pytest.approx((math.sqrt(math.cos(heel)) - 1.0) * 86400.0, abs=0.1)
    assert rate == pytest.approx(-659.0, abs=1.1)


@pytest.mark.parametrize(
    ('thread', 'said'),
    [
        (TIED | ARC, r'trochlea\.thread\.arc = 0\.1: does not go with trochlea\.thread\.arm'),
        (
            {'kind': 'lever', 'weight_arm': 0.15, 'length': 0.3},
            r'trochlea\.thread\.arm: is missing, and so is arc\. Give arm',
        ),
        (
            ARC | {'tail': {'mass': 0.1, 'distance': 0.08}},
            r'trochlea\.thread\.tail\.mass = 0\.1: .* outweighs .* less than 0\.09375 kg',
        ),
        (ARC | {'fulcrum': 'left'}, r"trochlea\.thread\.fulcrum = 'left'"),
    ],
)
def test_an_impossible_lever_is_refused(thread, said):
    with pytest.raises(SceneError, match=said):
        scene_of(trochlea=trochlea(thread))


def test_the_coach_of_1724_loses_as_its_scene_says():
    """2.6 s on the road as assumed, 0.6 s with half of its motion."""
    scene = load_scene('coach_1724')
    small = compile_machine(scene).small_period
    for share, lost in ((1.0, 2.6), (0.5, 0.6)):
        ship = scene.ship.model_copy(
            update={
                name: tuple(
                    each.model_copy(update={'amplitude': share * each.amplitude})
                    for each in getattr(scene.ship, name)
                )
                for name in ('components', 'heave')
            }
        )
        turned = phases(scene.model_copy(update={'ship': ship}))[-1, 0] / math.tau
        assert scene.duration - turned * small == pytest.approx(lost, abs=0.05)
