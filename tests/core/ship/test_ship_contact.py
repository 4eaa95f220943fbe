"""Contact of a suspended case between samples: values, slopes, and the cubic through them."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tauto_core.machines.axle_pendulum import AxlePendulum, AxleState, SupportMotion
from tauto_core.motion.axle import forces
from tauto_core.motion.suspended_case import AxleModes, BearingMotion, CaseMotion
from tauto_core.ship.suspension import (
    HungCase,
    first_loss,
    force_at,
    lost_at,
    pressing,
    pressing_rate,
)

CASE = HungCase(0.015, 0.1, 0.05, 9.80665)
PIECE_NS = 50_000_000
PARTS = 8
"""Of 6.25 ms: the fast mode turns 0.38 rad in each."""


def shaken(pieces, sway, lift, parts):
    """A bearing with polynomials of degree 4 that jump at their joints, g or less upwards."""
    rng = np.random.default_rng(1780)
    falls = 1.0 / np.arange(1, 6) ** 2
    up = lift * rng.normal(size=(pieces, 5)) * falls
    up[:, 0] += CASE.gravity
    begin = PIECE_NS * np.arange(pieces)
    return BearingMotion(
        begin,
        np.full(pieces, PIECE_NS),
        np.full(pieces, parts),
        sway * rng.normal(size=(pieces, 5)) * falls,
        up,
    )


def swung(bearing, tilt):
    """The case's motion at the beginning and end of each part, from rest at a tilt."""
    modes = AxleModes(*CASE)
    modes.release(-CASE.gravity * tilt, CASE.gravity)
    after = modes.advance(bearing)
    before = [
        np.concatenate([[start], column[:-1]])
        for start, column in zip((tilt, tilt, 0.0, 0.0), after[:4], strict=True)
    ]
    return CaseMotion(*[*before, after.sway, after.lift]), after


def test_the_contact_force_is_that_of_the_full_equations():
    """The reference is `machines.axle_pendulum`, which has the equations in another form."""
    rng = np.random.default_rng(1)
    theta, phi, theta_rate, phi_rate, sway, lift = rng.normal(size=(6, 50))
    body = AxlePendulum(1.0 / CASE.e, CASE.c, CASE.k, CASE.gravity)
    state = AxleState(CASE.e * theta, phi, CASE.e * theta_rate, phi_rate)
    support = SupportMotion(turn=0.0, down=-lift, lateral=sway)
    wide = (CASE.c / CASE.k) * np.sin(phi - theta)
    expected = np.asarray(forces(body, state, support).contact) * (1.0 + wide * wide)
    motion = CaseMotion(theta, phi, theta_rate, phi_rate, sway, CASE.gravity + lift)
    found = pressing(CASE, motion, motion.sway, motion.lift)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_slopes_are_those_of_the_motion():
    """Against differences of fourth order over 0.1 ms, good to some 1e-9 of the largest."""
    bearing = shaken(3, 1.0, 1.0, 500)
    _, after = swung(bearing, 0.1)
    felt = force_at(bearing, bearing.end)
    p = pressing(CASE, after, felt.sway, felt.lift)
    slope = pressing_rate(CASE, after, felt)
    at = np.arange(700, 900, 20)
    differences = (p[at - 2] - 8 * p[at - 1] + 8 * p[at + 1] - p[at + 2]) / 12e-4
    assert np.max(np.abs(differences)) > 5.0
    np.testing.assert_allclose(slope[at], differences, atol=1e-6 * np.max(np.abs(differences)))


@pytest.mark.parametrize('tilt', [0.05, 0.35])
def test_a_loss_is_found_where_the_exact_motion_has_it(tilt):
    """Against parts 64 times as fine. The cubic is wrong by 1e-3 of a swing of P."""
    coarse, fine = (shaken(40, 2.0, 5.0, parts) for parts in (PARTS, 64 * PARTS))
    _, motion = swung(fine, tilt)
    p = pressing(CASE, motion, *fine.at_ends())
    exact = float(fine.end_ns[np.argmax(p <= 0.0)] * 1e-9)
    assert np.any(p <= 0.0)
    before, after = swung(coarse, tilt)
    found = lost_at(CASE, coarse, before, after)
    # within a fine part
    assert found == pytest.approx(exact, abs=3e-4)


def test_a_dip_between_two_samples_is_seen():
    """The bearing falls with g only in the middle of a part. At both ends the body presses."""
    parts_s = PIECE_NS * 1e-9 / PARTS
    for depth in (1e-3, -1e-3):
        # g + z̈ = 1 (x − x₀)² − depth, in m/s2 over the piece
        x0 = 2.5 / PARTS
        lift = np.array([[x0 * x0 - 1e-3 * depth, -2.0 * x0, 1.0]])
        bearing = BearingMotion(
            np.zeros(1, np.int64), np.full(1, PIECE_NS), np.full(1, PARTS), np.zeros((1, 1)), lift
        )
        before, after = swung(bearing, 0.0)
        pressed = pressing(CASE, after, *bearing.at_ends())
        assert np.all(pressed > 0.0)
        found = lost_at(CASE, bearing, before, after)
        if depth < 0.0:
            assert found is None
            continue
        first = (x0 - math.sqrt(1e-3 * depth)) * PARTS * parts_s
        assert found == pytest.approx(first, abs=1e-12)


numbers = st.floats(-3.0, 3.0)


@settings(deadline=None, max_examples=25)
@given(st.lists(st.tuples(numbers, numbers, numbers, numbers), min_size=1, max_size=4))
@example([(3e-40, 0.0, -1.0, 0.0)])
def test_the_first_root_of_any_cubics(rows):
    """The reference is the cubics on a fine grid. Dips as small as rounding do not count."""
    ends, slopes = np.array(rows).T.reshape(2, 2, -1)
    x = np.linspace(0.0, 1.0, 2001)
    values = [
        a * (1 + 2 * x) * (1 - x) ** 2 + b * x * x * (3 - 2 * x)
        + s0 * x * (1 - x) ** 2 + s1 * x * x * (x - 1)
        for (a, b), (s0, s1) in zip(ends.T, slopes.T, strict=True)
    ]  # fmt: skip
    lowest = [float(np.min(each)) for each in values]
    found = first_loss(ends, slopes)
    below = [n for n, least in enumerate(lowest) if least <= -1e-5]
    if found is None:
        assert not below
        return
    stretch, share = found
    assert not below or stretch <= below[0]
    assert lowest[stretch] <= 1e-5
    before = values[stretch][x < share - 1e-3]
    assert np.all(before > -1e-5)
