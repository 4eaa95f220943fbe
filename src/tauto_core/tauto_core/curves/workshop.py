"""A cam as a workshop needs it: to scale in millimetres, with all that must be known to cut it."""

from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass

import numpy as np

from tauto_core.curves.cam import Cam
from tauto_core.curves.cams.involute import Involute
from tauto_core.curves.descent_curve import DescentCurve
from tauto_core.curves.drawing import Cheeks
from tauto_core.samples import FloatArray

MM_PER_M = 1000.0
TEXT_MM, TEXT_OF_WIDTH = 2.5, 0.014
"""Height of letters: the smallest, and its share of the width of a wide drawing."""

LETTER, LINE = 0.62, 1.6
"""Largest width of a letter, and distance of lines, over the height of letters."""

LEAST_WIDTH_MM = 75.0
"""Least width of lines of text, for small cams."""

CHEEK_LEFT, CHEEK_RIGHT = 'CHEEK_LEFT', 'CHEEK_RIGHT'
THREAD, AXLE, BASE_CIRCLE, HOLE = 'THREAD', 'AXLE', 'BASE_CIRCLE', 'HOLE'
SCALE, NOTES = 'SCALE', 'NOTES'
CURVE = 'CURVE'
CUT = (CHEEK_LEFT, CHEEK_RIGHT, CURVE)
"""Layers that are cut; all others are for information."""

_AXLE_MM = 1.0
_GAP_MM = 4.0
_BARS_MM = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)


@dataclass(frozen=True)
class Line:
    """An open polyline [mm]."""

    layer: str
    x: FloatArray
    y: FloatArray


@dataclass(frozen=True)
class Circle:
    """A circle [mm]."""

    layer: str
    x: float
    y: float
    radius: float


@dataclass(frozen=True)
class Note:
    """A line of text; (x, y) is where its base line begins [mm]."""

    layer: str
    x: float
    y: float
    text: str


@dataclass(frozen=True)
class Drawing:
    """A drawing in the wheel's frame [mm]: origin at the axle, +y along the thread at rest.

    Attributes:
        title: title of the drawing.
        lines: polylines, the cheeks first.
        circles: axle, base circle, hole.
        notes: dimensions in words, from the top down, no wider than the drawing or 75 mm.
        text_mm: height of letters.
    """

    title: str
    lines: tuple[Line, ...]
    circles: tuple[Circle, ...]
    notes: tuple[Note, ...]
    text_mm: float = TEXT_MM

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Left, bottom, right and top of the drawing without the length of the text [mm]."""
        x = [np.min(line.x) for line in self.lines] + [c.x - c.radius for c in self.circles]
        right = [np.max(line.x) for line in self.lines] + [c.x + c.radius for c in self.circles]
        y = [np.min(line.y) for line in self.lines] + [c.y - c.radius for c in self.circles]
        top = [np.max(line.y) for line in self.lines] + [c.y + c.radius for c in self.circles]
        low = [note.y for note in self.notes]
        return float(min(x)), float(min(y + low)), float(max(right)), float(max(top))


def draw(cam: Cam, cut: Cheeks, title: str) -> Drawing:
    """Return the drawing of a cam: cheeks, thread at rest, axle, circles, dimensions.

    Args:
        cam: the cam.
        cut: its cheeks.
        title: title, for example the scene's name.
    """
    x, y = MM_PER_M * cut.x, MM_PER_M * cut.y
    rate = MM_PER_M * float(cam.lever_rate(0.0))
    tip, below = MM_PER_M * float(cam.p(0.0)), float(np.max(y)) + _GAP_MM
    hole = MM_PER_M * cam.hole_distance
    end = hole if math.isfinite(hole) else max(below, 2.0 * tip)
    circles = [Circle(AXLE, 0.0, 0.0, _AXLE_MM), Circle(BASE_CIRCLE, 0.0, 0.0, rate)]
    if math.isfinite(hole):
        circles.append(Circle(HOLE, 0.0, hole, max(0.5 * MM_PER_M * cut.thread_thickness, 0.5)))
    lines = [
        Line(CHEEK_LEFT, x, y),
        Line(CHEEK_RIGHT, -x, y),
        Line(THREAD, np.zeros(2), np.array([tip, end])),
    ]
    return _explained(title, lines, circles, dimensions(cam, cut))


def draw_uneven(
    left: tuple[FloatArray, FloatArray],
    right: tuple[FloatArray, FloatArray],
    rate: float,
    title: str,
    words: list[str],
) -> Drawing:
    """Return the drawing of cheeks that are not mirror images of each other.

    Args:
        left: (x, y) of the cheek for positive angles, beginning at the tip [mm].
        right: the same for the other cheek.
        rate: lever arm per radian at rest [mm].
        title: title, for example the scene's name.
        words: dimensions, one line each.
    """
    top = max(float(np.max(left[1])), float(np.max(right[1]))) + _GAP_MM
    lines = [
        Line(CHEEK_LEFT, *left),
        Line(CHEEK_RIGHT, *right),
        Line(THREAD, np.zeros(2), np.array([rate, top])),
    ]
    circles = [Circle(AXLE, 0.0, 0.0, _AXLE_MM), Circle(BASE_CIRCLE, 0.0, 0.0, rate)]
    return _explained(title, lines, circles, words)


def draw_in_fluid(
    curve: DescentCurve, outline: tuple[FloatArray, FloatArray], title: str
) -> Drawing:
    """Return the drawing of a curve in a fluid: the curve, its lowest point, dimensions.

    Args:
        curve: the curve.
        outline: (x, y) of its points [mm], origin at the lowest, +y upwards.
        title: title, for example the scene's name.
    """
    ascent = curve.ascent_cusp
    words = [
        'millimetres, 1:1; origin: the lowest point; +y: upwards; descents begin on the right',
        f'pendulum in vacuum {MM_PER_M * curve.pendulum_length:.6g} mm; kappa {curve.kappa:.6g} '
        f'1/m; gamma {curve.gamma:.6g}',
        f'arc of descent to its cusp {MM_PER_M * curve.descent_cusp:.6g} mm; of ascent '
        + (f'{MM_PER_M * abs(ascent):.6g} mm' if math.isfinite(ascent) else 'without end'),
    ]
    return _explained(title, [Line(CURVE, *outline)], [Circle(AXLE, 0.0, 0.0, _AXLE_MM)], words)


def _explained(
    title: str, lines: list[Line], circles: list[Circle], dimensions: list[str]
) -> Drawing:
    """Return a drawing with a scale bar, and its dimensions in words below."""
    left, low, right, _ = Drawing(title, tuple(lines), tuple(circles), ()).box
    width = right - left
    text_mm = max(TEXT_MM, TEXT_OF_WIDTH * width)
    bar = max((each for each in _BARS_MM if each <= 0.5 * width), default=_BARS_MM[0])
    place = low - _GAP_MM
    ticks = np.array([1.0, -1.0, 0.0, 0.0, 1.0, -1.0]) * text_mm / TEXT_MM
    along = np.array([0.0, 0.0, 0.0, bar, bar, bar])
    scale = Line(SCALE, left + along, place + ticks)
    letters = int(max(width, LEAST_WIDTH_MM) / (LETTER * text_mm))
    words = [
        line for text in (f'{bar:g} mm', title, *dimensions) for line in _wrapped(text, letters)
    ]
    notes = [
        Note(NOTES, left, place - LINE * text_mm * (n + 1.25), text)
        for n, text in enumerate(words)
    ]
    return Drawing(title, (*lines, scale), tuple(circles), tuple(notes), text_mm)


def _wrapped(text: str, letters: int) -> list[str]:
    """Return a text in lines, those after the first indented."""
    return textwrap.wrap(text, letters, subsequent_indent='  ', break_on_hyphens=False)


def dimensions(cam: Cam, cut: Cheeks) -> list[str]:
    """Return the dimensions that are needed to cut and mount the cheeks, one line each."""
    rate = MM_PER_M * float(cam.lever_rate(0.0))
    thickness = MM_PER_M * cut.thread_thickness
    range_rad = cam.range_rad
    name = 'base radius' if isinstance(cam, Involute) else 'lever arm a radian, at rest'
    reach = f'{cut.angle[-1]:.6g} rad'
    widest = MM_PER_M * float(cam.lever_arm(cut.angle[-1]))
    words = [
        'millimetres, 1:1; origin: the axle; +y: the thread at rest; cut CHEEK_LEFT, CHEEK_RIGHT',
        f'{name} {rate:.6g} mm; lever arm at {reach}: {widest:.6g} mm',
        f'range of the cam {"without end" if math.isinf(range_rad) else f"{range_rad:.6g} rad"}; '
        f'drawn up to {reach}',
        f'length of thread wound at {reach}: {MM_PER_M * float(cam.arc_length(cut.angle[-1])):.6g}'
        ' mm',
        'thread '
        + (
            f'through a hole {MM_PER_M * cam.hole_distance:.6g} mm from the axle'
            if math.isfinite(cam.hole_distance)
            else 'vertical'
        ),
    ]
    if thickness:
        words.append(
            f'cheeks cut back by half the thread, {thickness:.6g} mm thick; they act from '
            f'{cut.angle[0]:.6g} rad on'
        )
    else:
        words.append('for a thin thread: nothing is taken off for its thickness')
    return words
