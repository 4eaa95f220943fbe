"""Several clocks through the same sea, side by side."""

from tauto_core.comparison.entries import CLOCKS, SHARED, Cases, Entry, make_entries
from tauto_core.comparison.figure import draw
from tauto_core.comparison.running import Comparison, Row, Stop, compare

__all__ = [
    'CLOCKS',
    'SHARED',
    'Cases',
    'Comparison',
    'Entry',
    'Row',
    'Stop',
    'compare',
    'draw',
    'make_entries',
]
