"""What the figures of the page of claims share: strokes, points with letters, bare axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tauto_core.samples import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, CURVE, THREAD, FAINT, OTHER = '#222222', '#1f4e8c', '#b03a2e', '#9a9a9a', '#2e7d4f'

Point = tuple[float, float]


def sheet(width: float, height: float, columns: int = 1, **options: Any) -> tuple[Figure, Any]:
    """Return a figure of a size [inch] and its panels, side by side: (columns,) of axes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout='constrained')
    return figure, figure.subplots(1, columns, squeeze=False, **options)[0]


def bare(axes: Axes, title: str = '') -> None:
    """Make a panel a drawing: equal scales, no frame."""
    axes.set_aspect('equal')
    axes.set_axis_off()
    axes.set_title(title, fontsize=9.0)


def graph(axes: Axes, across: str, up: str, title: str = '') -> None:
    """Make a panel a graph with named axes."""
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.set_title(title, fontsize=9.0)
    axes.grid(True, color='#dddddd', linewidth=0.6)
    axes.spines[['top', 'right']].set_visible(False)


def stroke(axes: Axes, start: Point, end: Point, **look: Any) -> None:
    """Draw a straight line."""
    drawn: dict[str, Any] = {'color': INK, 'linewidth': 0.9} | look
    axes.plot([start[0], end[0]], [start[1], end[1]], **drawn)


def ring(axes: Axes, centre: Point, radius: float, **look: Any) -> None:
    """Draw a circle."""
    from matplotlib.patches import Circle

    axes.add_patch(Circle(centre, radius, **({'fill': False, 'edgecolor': INK} | look)))


def letter(axes: Axes, at: Point, text: str, offset: Point = (5.0, 3.0), **look: Any) -> None:
    """Mark a point and write its letter beside it, at an offset in printer's points."""
    axes.plot(*at, 'o', markersize=2.8, color=INK, zorder=5)
    note(axes, at, text, offset, **look)


def note(axes: Axes, at: Point, text: str, offset: Point = (5.0, 3.0), **look: Any) -> None:
    """Write beside a point."""
    style: dict[str, Any] = {'fontsize': 9.0, 'ha': 'center', 'va': 'center', 'zorder': 6} | look
    axes.annotate(text, at, offset, textcoords='offset points', **style)


def turned(x: FloatArray, y: FloatArray, angle: float) -> tuple[FloatArray, FloatArray]:
    """Return points turned about the origin, from x towards y."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return cosine * x - sine * y, sine * x + cosine * y
