"""Claims of paper B on the series of the curve, §24–25."""

from __future__ import annotations

from tauto_core.euler import fluid_checks as check
from tauto_core.euler.claim import Claim
from tauto_core.euler.fluid_checks import (
    CLOSE,
    GAMMA,
    GLOBE,
    NOTHING,
    A,
    F,
    M,
    N,
    S,
    holds,
    misprint,
)

# what the three terms leave out begins with κ³s³/60
_SHORT = 0.01
_LEFT_OUT = (GLOBE * _SHORT) ** 3 / 50.0


def series_claims() -> list[Claim]:
    """Return the claims of §24–25."""
    return [*_series(), *_signs_of_the_series()]


def _series() -> list[Claim]:
    x, u = check.height(_SHORT), check.height(-_SHORT)
    first, second, third = _terms()
    right, ascent = first + second + third, first - second + third
    return [
        holds(
            '24',
            'series of the descent, k = 3n/8m',
            's²/2 + ks³/6a + k²s⁴/24a² + … = (1 − 8k/3) f x',
            right,
            x,
            _LEFT_OUT,
        ),
        holds(
            '24',
            'series of the ascent',
            't²/2 − kt³/6a + k²t⁴/24a² − … = (1 − 8k/3) f u',
            ascent,
            u,
            _LEFT_OUT,
        ),
    ]


def _terms() -> tuple[float, float, float]:
    """Return the first three terms of the series of the height, at a short arc [m]."""
    k = 3.0 * N / (8.0 * M)
    gain = (1.0 - 8.0 * k / 3.0) * F
    s = _SHORT
    return s**2 / (2.0 * gain), k * s**3 / (6.0 * A * gain), k**2 * s**4 / (24.0 * A**2 * gain)


def _signs_of_the_series() -> list[Claim]:
    x, u = check.height(_SHORT), check.height(-_SHORT)
    first, second, third = _terms()
    right, ascent = first + second + third, first - second + third
    k = 3.0 * N / (8.0 * M)
    gain = (1.0 - 8.0 * k / 3.0) * F
    return [
        misprint(
            '24',
            'its second term',
            ('k³s²/(a·1·2·3)', first + k**3 * _SHORT**2 / (6.0 * A * gain) + third),
            x,
            ('ks³/(1·2·3·a)', right),
            'the exponents have changed places',
            _LEFT_OUT,
        ),
        misprint(
            '24',
            'how the series continues',
            ('− etc', NOTHING),
            x,
            ('+ etc on the descent', right),
            'all terms of the exponential are positive',
            _LEFT_OUT,
        ),
        misprint(
            '24',
            'second term of the ascent',
            ('kf²', first - k * F**2 / (6.0 * A * gain) + third),
            u,
            ('kt³', ascent),
            'f is no arc, and the term must be of third order',
            _LEFT_OUT,
        ),
        holds(
            '25',
            'both branches become cycloids as 3n/8ma tends to 0',
            'x = s²/2f, γ left as it is',
            S * S / (2.0 * GAMMA * F),
            check.height(S, kappa=1e-11),
            CLOSE,
        ),
    ]
