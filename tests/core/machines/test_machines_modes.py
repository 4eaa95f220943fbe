"""The two modes against 50-digit numbers of an independent program, and in limiting cases."""

import math
from decimal import Decimal

import mpmath
import numpy as np
import pytest
from golden_numbers import entries, numbers
from hypothesis import given
from hypothesis import strategies as st

from tauto_core.machines.axle_pendulum import exact_lengths, modes

TIGHT = 1e-14


# large swings belong to the axle pendulum
LINKS = [each for each in entries('C42', 'C45', 'C53', 'C38') if 'large' not in each.id]


def close(actual, expected):
    np.testing.assert_allclose(actual, expected, rtol=TIGHT, atol=1e-300)


def link(given_):
    return given_.get('e_or_minus_i', given_.get('e', -given_.get('i', 0.0)))


@pytest.mark.parametrize('entry', LINKS)
def test_golden_modes(entry):
    given_, expected = numbers(entry)
    found = modes(link(given_), given_['c'], given_['k'] ** 2)
    gravity = given_.get('G', 1.0)
    slow, fast = found.squared_frequencies(gravity)
    ratios = found.tilt_per_arc
    said = {
        'b': found.h,
        'b_prime': found.h_prime,
        'B': found.B,
        'B_prime': found.B_prime,
        'T_b_s': math.tau / math.sqrt(slow) if slow > 0.0 else math.inf,
        'T_bprime_s': math.tau / math.sqrt(fast) if fast > 0.0 else math.nan,
        'T_small_s': math.tau / math.sqrt(fast) if fast > 0.0 else math.nan,
        'growth_rate_per_s': math.sqrt(-fast) if fast < 0.0 else math.nan,
        's_over_phi': 1.0 / ratios[1],
        'phi_over_s_b': ratios[0],
        'phi_over_s_bprime': ratios[1],
    }
    if given_['k'] > 0.0 and 'product_over_ek2c' in expected:
        said['product_over_ek2c'] = (
            found.h * found.h_prime * given_['c'] / (link(given_) * given_['k'] ** 2)
        )
    elif given_['k'] == 0.0:
        assert expected.pop('product_over_ek2c') == 1.0
    close([said[key] for key in expected], list(expected.values()))


def exact(e, c, k_squared):
    """b, b′, B, B′ by the plain formulas in 120 digits."""
    e, c, k_squared = mpmath.mpf(e), mpmath.mpf(c), mpmath.mpf(k_squared)
    total, rest = k_squared + c * c + c * e, k_squared + c * c - c * e
    root = mpmath.sqrt(total * total - 4 * c * e * k_squared)
    return [(part + way * root) / (2 * c) for part in (total, rest) for way in (1, -1)]


signs = st.sampled_from([-1.0, 1.0])


@given(st.floats(-9, 12), signs, st.floats(-6, 2), signs, st.floats(-9, 2))
def test_no_machine_cancels(e, e_sign, c, c_sign, k):
    """If both lengths are nearly equal they change with the machine's numbers by 1/gap."""
    e, c, k_squared = e_sign * 10.0**e, c_sign * 10.0**c, 10.0 ** (2 * k)
    found = modes(e, c, k_squared)
    with mpmath.workdps(120):
        b, b_prime, tilt, tilt_prime = exact(e, c, k_squared)
        gap = abs((b - b_prime) / (abs(b) + abs(b_prime)))
        limit = 1e-15 * (4.0 + float(1 / gap))
        assert abs(found.h / b - 1) < limit
        assert abs(found.h_prime / b_prime - 1) < limit
        assert abs(found.B / tilt - 1) < limit
        assert abs(found.B_prime / tilt_prime - 1) < limit


def test_plane_is_between_hollow_and_convex():
    """As 1/e passes through zero, b grows beyond bounds and comes back as the smaller length."""
    plane, back = modes(math.inf, 0.3, 0.0225), modes(-math.inf, 0.3, 0.0225)
    assert (plane.h, plane.h_prime, plane.B, plane.B_prime) == (math.inf, 0.075, 0.3, -math.inf)
    assert (back.h, back.h_prime, back.B, back.B_prime) == (0.075, -math.inf, math.inf, 0.3)
    assert plane.squared_frequencies(9.81)[0] == 0.0
    hollow, convex = modes(1e15, 0.3, 0.0225), modes(-1e15, 0.3, 0.0225)
    close([hollow.h_prime, hollow.B, convex.h, convex.B_prime], [0.075, 0.3, 0.075, 0.3])
    assert hollow.h > 1e14
    assert convex.h_prime < -1e14
    assert modes(math.inf, -0.3, 0.0225).h_prime == math.inf


def test_knife_edge_and_point_mass():
    edge = modes(0.0, 0.3, 0.0225)
    close([edge.h, edge.h_prime, edge.B], [(0.0225 + 0.09) / 0.3, 0.0, 0.375])
    point = modes(0.2, 0.3, 0.0)
    close([point.h, point.h_prime, point.B, point.B_prime], [0.5, 0.0, 0.3, -0.2])
    assert point.squared_frequencies(9.81)[1] == math.inf


def test_exact_lengths_are_those_of_120_digits():
    b, b_prime = exact_lengths(Decimal('0.015'), Decimal('0.1'), Decimal('0.0025'))
    with mpmath.workdps(120):
        wanted = exact('0.015', '0.1', '0.0025')
        assert abs(mpmath.mpf(str(b)) / wanted[0] - 1) < mpmath.mpf(10) ** -50
        assert abs(mpmath.mpf(str(b_prime)) / wanted[1] - 1) < mpmath.mpf(10) ** -50
