"""Angles in 2⁻⁶⁴ turns: cosine and sine right to rounding after any number of turns."""

from decimal import Decimal

import mpmath
import numpy as np

from tauto_core.kernels import entry
from tauto_core.motion.linear import cosine_sine, oscillator, turns_at

OMEGA = Decimal('7.0710678118654752440084436210484903928483593768847')


@entry
def at_times(times, high, low, cosine, sine):
    reduced = np.empty(len(times), np.uint64)
    for i in range(len(times)):
        reduced[i] = turns_at(times[i], high, low)
    cosine_sine(reduced, cosine, sine)


def test_a_uniform_rotation_keeps_its_phase_for_a_century():
    """3e9 s, 2e10 rad; the octants all come up."""
    times = np.random.default_rng(1).integers(0, 36_525 * 86_400 * 10**9, 200)
    of = oscillator(OMEGA)
    cosine, sine = np.empty((2, len(times)))
    at_times(times, of.turns_per_ns, of.turns_per_ns_low, cosine, sine)
    with mpmath.workdps(50):
        angles = [mpmath.mpf(str(OMEGA)) * int(t) / 10**9 for t in times]
        wanted = [[float(f(x)) for x in angles] for f in (mpmath.cos, mpmath.sin)]
    np.testing.assert_allclose([cosine, sine], wanted, rtol=0, atol=3e-16)
