"""Several clocks through the same sea, side by side."""

from tauto_core.comparison.figure import draw
from tauto_core.comparison.running import (
    CLOCKS,
    SHARED,
    Cases,
    Comparison,
    Entry,
    Row,
    Stop,
    compare,
    make_entries,
)

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
