"""Euler's curves as geometry: cams for the trochlea."""

from tauto_core.curves.cam import Cam
from tauto_core.curves.cams import CircularArc, Hole, Involute
from tauto_core.curves.corrected import SpringCorrected, WeightCorrected
from tauto_core.curves.descent_curve import Cycloid, DescentCurve, SymmetricCurve
from tauto_core.curves.drawing import Cheeks, cheeks, outline
from tauto_core.curves.fluid_outline import fluid_outline
from tauto_core.curves.fluid_tautochrone import FluidTautochrone
from tauto_core.curves.levers import (
    ArcLever,
    Lever,
    LinearLever,
    SmoothLever,
    SpringLever,
    TableLever,
)
from tauto_core.curves.making import make_cam
from tauto_core.curves.table import Fitted, Table, load_table

__all__ = [
    'ArcLever',
    'Cam',
    'Cheeks',
    'CircularArc',
    'Cycloid',
    'DescentCurve',
    'Fitted',
    'FluidTautochrone',
    'Hole',
    'Involute',
    'Lever',
    'LinearLever',
    'SmoothLever',
    'SpringCorrected',
    'SpringLever',
    'SymmetricCurve',
    'Table',
    'TableLever',
    'WeightCorrected',
    'cheeks',
    'fluid_outline',
    'load_table',
    'make_cam',
    'outline',
]
