"""The place within a step at which a value that was positive falls to zero."""

from __future__ import annotations

from typing import Protocol

from tauto_core.kernels import compiled

TRIALS = 12
"""Places tried up to the last fraction, each four times as far on as the one before."""

MAX_PROBES = 200


class Watched(Protocol):
    """An object with a value within a step: a NamedTuple with this method."""

    def value(self, xi: float) -> float:
        """Return the value at the fraction xi of the step, from the stage polynomials."""


@compiled
def locate(watch: Watched, last: float, at_last: float, precision: float) -> float:
    """Return the fraction of the step at which a value falls to zero; 0 if it was never positive.

    By the Illinois form of false position (Dowell and Jarratt, BIT 11, 1971, 168). It probes no
    closer to either bound than half the precision: a value that is tiny at the beginning would
    otherwise draw the first probe there, which would be taken for a root.

    Args:
        watch: the value.
        last: a fraction at which it is no longer positive.
        at_last: its value there.
        precision: error allowed in the fraction.
    """
    a, b, fb = 0.0, last, min(at_last, 0.0)
    fa = watch.value(a)
    if not fa > 0.0:
        # A step may begin where the value has just been zero, and have it positive for a moment.
        for trial in range(1, TRIALS):
            x = last * 0.25 ** (TRIALS - trial)
            fx = watch.value(x)
            if fx > 0.0:
                a, fa = x, fx
            elif fa > 0.0:
                b, fb = x, fx
                break
    if not fa > 0.0:
        return 0.0
    kept = 0
    for _ in range(MAX_PROBES):
        x = (a * fb - b * fa) / (fb - fa)
        if b - a <= precision:
            return x
        x = min(max(x, a + 0.5 * precision), b - 0.5 * precision)
        fx = watch.value(x)
        if fx == 0.0:
            return x
        if fx > 0.0:
            a, fa = x, fx
            fb = 0.5 * fb if kept == 1 else fb
            kept = 1
        else:
            b, fb = x, fx
            fa = 0.5 * fa if kept == -1 else fa
            kept = -1
    return b
