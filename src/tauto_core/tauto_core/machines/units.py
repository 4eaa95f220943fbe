"""Units of the papers' time, in SI.

All are rounded: the Rhenish foot is the 139.13 Paris lines, 313.85 mm, that Prussia fixed in 1816,
and older standards differ in the fourth digit; the Paris foot is that of 1766, 324.84 mm; the
pound of Paris (poids de marc) is 489.5 g.
"""

from __future__ import annotations

RHENISH_FOOT_M = 0.31385
SCRUPLE_M = RHENISH_FOOT_M / 1000.0
"""Euler's scruple: a thousandth of the Rhenish foot, 0.31385 mm."""

PARIS_FOOT_M = 0.32484
PARIS_LINE_M = PARIS_FOOT_M / 144.0
"""2.2558 mm."""

PARIS_POUND_KG = 0.4895

LENGTHS_M = {
    'm': 1.0,
    'mm': 1e-3,
    'scruple': SCRUPLE_M,
    'rhenish_foot': RHENISH_FOOT_M,
    'line': PARIS_LINE_M,
    'paris_foot': PARIS_FOOT_M,
}
"""Units of length a design may be given in."""

WEIGHTS_KG = {'kg': 1.0, 'pound': PARIS_POUND_KG}
"""Units of weight besides the newton; as forces they are multiplied by gravity."""
