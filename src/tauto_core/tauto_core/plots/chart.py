"""A picture independent of the renderer: lines, bands and points on axes with units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tauto_core.samples import FloatArray

Colour = Literal['blue', 'orange', 'green', 'grey']


@dataclass(frozen=True)
class Line:
    """A line, a band between two lines, points, or bars.

    Attributes:
        name: in the legend; empty for none.
        x: (n,), in the unit of the axis.
        y: (n,), for a band the lower edge.
        colour: by role: blue the dial or the machine, orange estimates, green the ship, grey given
            values.
        kind: how it is drawn; an area is a closed line with its inside filled.
        high: upper edge of a band or end of a bar, (n,).
    """

    name: str
    x: FloatArray
    y: FloatArray
    colour: Colour = 'blue'
    kind: Literal['line', 'band', 'points', 'bars', 'area'] = 'line'
    high: FloatArray | None = None


@dataclass(frozen=True)
class Mark:
    """An instant at which something happens, drawn as an upright line across a chart.

    Attributes:
        x: in the unit of the axis.
        name: written above the line; empty for a faint dotted line that the note explains.
    """

    x: float
    name: str = ''


@dataclass(frozen=True)
class Chart:
    """A picture with two axes, and the charts below it that share its x axis.

    Attributes:
        title: title of the picture.
        x_label: the x label, with the unit.
        y_label: the y label, with the unit.
        lines: from the back to the front.
        log_x, log_y: whether an axis is logarithmic.
        equal: whether both axes have one scale.
        note: further information for the reader; may be empty.
        marks: instants that are marked.
        y_ticks: whether the y axis has numbers; a drawing with a break in it has none.
        below: the next chart below, on the same x axis.
    """

    title: str
    x_label: str
    y_label: str
    lines: Sequence[Line]
    log_x: bool = False
    log_y: bool = False
    equal: bool = False
    note: str = ''
    marks: Sequence[Mark] = ()
    y_ticks: bool = True
    below: Chart | None = None

    @property
    def panels(self) -> list[Chart]:
        """The chart and all below it, from top to bottom."""
        return [self, *(self.below.panels if self.below else ())]

    def y_limits(self) -> tuple[float, float] | None:
        """Return the range that shows the lines, and the bands as wide as they are at the end.

        None where the renderer may choose: on logarithmic and equal axes.
        """
        if self.log_y or self.equal or not any(line.kind == 'band' for line in self.lines):
            return None
        ends = [line.y for line in self.lines if line.kind != 'band' and len(line.y)]
        ends += [
            np.array([line.y[-1], line.high[-1]])
            for line in self.lines
            if line.kind == 'band' and line.high is not None and len(line.y)
        ]
        low, high = min(float(y.min()) for y in ends), max(float(y.max()) for y in ends)
        margin = 0.05 * (high - low) or 1e-9
        return low - margin, high + margin
