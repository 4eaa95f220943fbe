"""Rows of the linear propagator, against 40-digit integrals of the polynomial itself."""

import math

import mpmath
import numpy as np
import pytest

from tauto_core.motion.linear import TURN, LinearLaw, SpanShape, responses, unique_rows

OMEGA, LENGTH_S, BEGIN, END = 6.3, 2.0, 0.125, 0.875


def integrals(coefficients, law, shape):
    """b = ∫ e^{(δ − iω)s} (p u + q u̇) ds over the span, and u, u̇, ü at its end."""
    with mpmath.workdps(40):
        u = [mpmath.mpf(c) for c in coefficients]
        slopes = [j * c / mpmath.mpf(shape.length_s) for j, c in enumerate(u)][1:]
        bends = [j * c / mpmath.mpf(shape.length_s) for j, c in enumerate(slopes)][1:]

        def at(polynomial, x):
            return mpmath.fsum(c * x**j for j, c in enumerate(polynomial))

        def f(s):
            x = shape.begin + s / mpmath.mpf(shape.length_s)
            drive = law.per_value * at(u, x) + law.per_rate * at(slopes, x)
            return mpmath.exp(mpmath.mpc(law.delta, -law.omega) * s) * drive

        b = mpmath.quad(f, mpmath.linspace(0, (shape.end - shape.begin) * shape.length_s, 9))
        ends = [at(each, mpmath.mpf(shape.end)) for each in (u, slopes, bends)]
        return np.array([float(x) for x in (b.real, b.imag, *ends)])


@pytest.mark.parametrize(
    'law', [LinearLaw(OMEGA, 0.0, OMEGA**2, 0.0), LinearLaw(OMEGA, 0.3, 39.8, 0.6)]
)
@pytest.mark.parametrize('sampled', [True, False])
def test_a_row_makes_the_integral_and_the_ends_of_a_polynomial(law, sampled):
    """Degree 9, through values and slopes at five samples, or by its coefficients."""
    coefficients = np.random.default_rng(1).normal(size=10)
    nodes = (-0.25, 0.0, 0.5, 1.0, 1.25)
    given = coefficients
    if sampled:
        u = np.polynomial.Polynomial(coefficients)
        given = np.concatenate([u(np.array(nodes)), u.deriv()(np.array(nodes)) / LENGTH_S])
    shape = SpanShape(LENGTH_S, BEGIN, END, sampled)
    made = responses(law, (shape,), nodes, 10)
    wanted = integrals(coefficients, law, shape)
    found = given @ made.rows[0]
    # rounding of ten numbers, the largest of which the samples outside the span make
    scale = np.abs(given) @ np.abs(made.rows[0, :, :5])
    assert np.all(np.abs(found[:5] - wanted) < 2e-15 * scale)
    assert not found[5:].any()
    assert made.decay[0] == pytest.approx(math.exp(-law.delta * shape.time_s), rel=1e-15)


def test_the_parts_of_a_span_make_the_span():
    """b of the whole is the sum of the parts, each turned back to the span's beginning."""
    law = LinearLaw(OMEGA, 0.3, 39.8, 0.6)
    shape = SpanShape(LENGTH_S, BEGIN, END)
    made = responses(law, (shape, SpanShape(1.0, 0.0, 1.0)), (), 6)
    parts, first = made.parts[0], made.first_part[0]
    assert parts == math.ceil(math.hypot(OMEGA, 0.3) * shape.time_s / TURN)
    rows = made.rows[first : first + parts]
    since = shape.time_s / parts * np.arange(parts)
    turned = np.exp((law.delta - 1j * law.omega) * since)[:, None] * (
        rows[..., 0] + 1j * rows[..., 1]
    )
    whole = made.rows[0, :, 0] + 1j * made.rows[0, :, 1]
    np.testing.assert_allclose(turned.sum(axis=0), whole, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(rows[-1, :, 2:], made.rows[0, :, 2:])


def test_rows_are_sorted_into_kinds():
    kind, kinds = unique_rows(
        np.array([2.0, 1.0, 2.0, 2.0, 3.0, 1.0]), np.array([0, 0, 0, 0, 0, 1])
    )
    assert kinds[0] == (2.0, 0)
    assert [kinds[k] for k in kind] == [(2, 0), (1, 0), (2, 0), (2, 0), (3, 0), (1, 1)]
    assert len(kinds) == 4
