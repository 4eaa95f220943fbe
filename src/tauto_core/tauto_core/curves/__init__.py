"""Euler's curves as geometry: cams for the trochlea.

Modules that few scenes need, such as the curves of the second paper, are loaded at their first
use.
"""

from typing import TYPE_CHECKING

from tauto_core.curves.cam import (
    ArcLever,
    Cam,
    LeverArm,
    LinearLever,
    SmoothLever,
    SpringLever,
    TableLever,
)
from tauto_core.curves.cams.circular_arc import CircularArc
from tauto_core.curves.cams.corrected import SpringCorrected, WeightCorrected
from tauto_core.curves.cams.linear import Hole, Involute
from tauto_core.curves.cams.table import Fitted, Table, load_table
from tauto_core.first_use import loaded_from

if TYPE_CHECKING:
    from tauto_core.curves.drawing import Cheek, cheek, outline
    from tauto_core.curves.fluid import Cycloid, DescentCurve, FluidTautochrone, SymmetricCurve

__all__ = [
    'ArcLever',
    'Cam',
    'Cheek',
    'CircularArc',
    'Cycloid',
    'DescentCurve',
    'Fitted',
    'FluidTautochrone',
    'Hole',
    'Involute',
    'LeverArm',
    'LinearLever',
    'SmoothLever',
    'SpringCorrected',
    'SpringLever',
    'SymmetricCurve',
    'Table',
    'TableLever',
    'WeightCorrected',
    'cheek',
    'load_table',
    'outline',
]

__getattr__ = loaded_from(
    __name__,
    {
        'Cheek': 'drawing',
        'Cycloid': 'fluid',
        'DescentCurve': 'fluid',
        'FluidTautochrone': 'fluid',
        'SymmetricCurve': 'fluid',
        'cheek': 'drawing',
        'outline': 'drawing',
    },
)
