"""The claims of paper B, *Curva tautochrona in fluido* (1729), in the order of the paper.

Printed formulas are evaluated as they stand, in Euler's letters: m and n the densities of body and
fluid, a the diameter of the globe or the height of the cylinder, f and h the pendulum lengths of
descent and ascent, e = f/2, b the height of fall of the speed at A. The example is that of
`fluid_checks`; `computed` comes from quadrature and integrated motion.
"""

from __future__ import annotations

from tauto_core.euler.claim import Claim
from tauto_core.euler.fluid_curve_claims import curve_claims
from tauto_core.euler.fluid_motion_claims import motion_claims
from tauto_core.euler.fluid_series_claims import series_claims
from tauto_core.euler.fluid_shape_claims import shape_claims


def claims() -> list[Claim]:
    """Return the claims of paper B in its order, each misprint after the claim that it is in."""
    return [*curve_claims(), *series_claims(), *shape_claims(), *motion_claims()]
