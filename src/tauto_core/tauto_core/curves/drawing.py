"""The cheeks as polylines, and a cam as a workshop needs it: to scale, in millimetres."""

from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tauto_core.curves.cam import Cam, too_sharp
from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
from tauto_core.curves.cams.linear import Involute
from tauto_core.curves.fluid import DescentCurve
from tauto_core.curves.lever_geometry import MirroredLever
from tauto_core.curves.numerics import bisect
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import Argument, UsageError

# Number of angles at which cheeks are looked at.
_PROBES = 2001


class Cheeks(NamedTuple):
    """Both cheeks as they are cut, in the wheel's frame.

    Attributes:
        angle: angle of the wheel at which the thread leaves the cheek at each point [rad], shape
            (n,), increasing from above 0; at the other cheek it is the negative.
        x: x of the cheek for positive angles [m], shape (n,); the other cheek is its mirror image.
        y: y of both [m], shape (n,).
        thread_thickness: thickness of the thread for which they are cut [m].
    """

    angle: FloatArray
    x: FloatArray
    y: FloatArray
    thread_thickness: float


def cheeks(
    cam: Cam, points: int = 200, reach_rad: float | None = None, thread_thickness: float = 0.0
) -> Cheeks:
    """Return the cheeks of a cam for a thread of some thickness e ≥ 0, each of some points.

    The thread's centre line follows the cam's curve; the cheek is the parallel curve e/2 inwards.
    It begins where the curve's radius of curvature reaches e/2 (R = 0 at the tip of every cam that
    is smooth through rest): up to there the thread bends round its edge. Without a `reach_rad`
    they go as far as `cam.drawn_rad` and the thread do. UsageError: fewer than two points, a
    thickness that is none, or a cheek that no such thread can follow up to there; CamRangeError: a
    reach beyond the range.
    """
    if points < 2:
        raise UsageError(f'points = {points!r}: a cheek needs at least 2; ask for more')
    if not 0.0 <= thread_thickness < math.inf:
        raise UsageError(f'thread thickness {thread_thickness!r} m: must be ≥ 0; give another')
    reach = cam.drawn_rad if reach_rad is None else reach_rad
    cam.within(reach)
    # the first interval of angles where R is at least half the thickness
    start, end = 0.0, reach
    for low, high in too_sharp(cam, 0.5 * thread_thickness, reach):
        if low > 0.0 or thread_thickness == 0.0:
            end = low
            break
        start = high
    if end <= start:
        raise UsageError(
            f'the cheek of {cam!r} is nowhere as round as a thread of {thread_thickness!r} m '
            'needs, or hollow from its tip on. Use a thinner thread or another cam'
        )
    if end < reach and reach_rad is not None:
        # the advice, rounded to six digits, must stay below the end
        raise UsageError(
            f'beyond {end:.9g} rad the cheek of {cam!r} has a radius of curvature below half the '
            f"thread's thickness, {0.5 * thread_thickness!r} m, where no thread can follow it. "
            'Draw up to there (',
            Argument('reach_rad', f'{end * (1.0 - 1e-6):.6f}'),
            '), or use a thinner thread',
        )
    # closer together at the end, where ψ grows like a square root when a thread meets its hole
    angle = start + (end - start) * np.sin(np.linspace(0.0, 0.5, points) * math.pi)
    x, y = cam.contact(angle)
    if thread_thickness:
        psi = cam.psi(angle)
        x, y = (
            x - 0.5 * thread_thickness * np.cos(psi),
            y - 0.5 * thread_thickness * np.sin(psi),
        )
    return Cheeks(angle, x, y, thread_thickness)


def outline(
    cam: Cam, points: int = 200, reach_rad: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return both cheeks as one polyline (x, y) in the wheel's frame [m], for a thin thread.

    It runs from the end of the cheek at x > 0 over the common tip to the end of the other, with
    2·points − 1 points. Reach and errors are those of `cheeks`.
    """
    _, x, y, _ = cheeks(cam, points, reach_rad)
    return np.concatenate([-x[:0:-1], x]), np.concatenate([y[:0:-1], y])


def cheeks_meet_rad(cam: Cam) -> float:
    """Return the angle at which the two mirror-image cheeks meet again beyond their tip [rad].

    There the contact point of the thread returns to the line x = 0. Longer cheeks would cross each
    other and could not be cut from one plate. For an involute tan ϑ = ϑ, ϑ = 4.493 rad. It is inf
    where they do not meet up to `cam.drawn_rad`.
    """
    angles = np.linspace(0.0, cam.drawn_rad, _PROBES)
    # at positive angles the thread lies on the cheek at x < 0
    apart = cam.contact(angles)[0] < 0.0
    meets = np.flatnonzero(apart[:-1] & ~apart[1:])
    if not len(meets):
        return math.inf
    first = int(meets[0])
    return bisect(
        lambda at: bool(cam.contact(at)[0] < 0.0), float(angles[first]), float(angles[first + 1])
    )[0]


# -----------------------------------------------------------------------------
# The cheeks of a lever's own cam, which differ from each other.


class LeverCheek(NamedTuple):
    """One cheek, in the wheel's frame, beginning at the tip; arrays of shape (n,).

    Attributes:
        angle: angle of the wheel at which the thread leaves the cheek [rad].
        x: x of the cheek [m].
        y: y of the cheek [m].
    """

    angle: FloatArray
    x: FloatArray
    y: FloatArray


def lever_cheek(
    shape: CorrectedLeverGeometry | MirroredLever,
    end: float,
    points: int,
    thread_thickness: float = 0.0,
) -> LeverCheek:
    """Return one cheek of a lever's cam up to τ = end, as `cheeks` does for an ideal thread.

    The thread's centre line follows the cam, so the cheek is the parallel curve e/2 inwards. It
    begins where the radius of curvature reaches e/2; up to there the thread bends round its edge.
    UsageError: a cheek that such a thread cannot follow up to there.
    """
    half, start = 0.5 * thread_thickness, 0.0
    if half:
        looked = np.linspace(0.0, end, _PROBES - 1)
        radius = shape.radius_of_curvature(looked)
        sharp = np.flatnonzero(radius < half)
        last = int(sharp[-1]) if len(sharp) else 0
        if last == len(looked) - 1 or not np.array_equal(sharp, np.arange(last + 1)):
            reach = float(shape.theta(looked[-1:])[0])
            raise UsageError(
                f'thread thickness {2.0 * half!r} m: up to {reach:.6g} rad the cheek is not '
                'everywhere beyond its tip as round as half of it; its greatest '
                f'radius of curvature is {float(np.max(radius)):.6g} m. Use a thinner thread or a '
                'shorter ',
                Argument('reach_rad'),
            )
        sharp_at, round_at = float(looked[last]), float(looked[last + 1])
        start, _ = bisect(
            lambda at: bool(shape.radius_of_curvature(np.array([at]))[0] >= half),
            round_at,
            sharp_at,
        )
    tau = np.linspace(start, end, points)
    (x, y), angle = shape.contact(tau), shape.theta(tau)
    if half:
        u, inwards = shape.pose(tau).u, -half * float(np.sign(end))
        x, y = x + inwards * np.cos(u), y + inwards * np.sin(u)
    return LeverCheek(angle, x, y)


# -----------------------------------------------------------------------------
# A cam as a workshop needs it: to scale in millimetres, with all that must be known to cut it.

MM_PER_M = 1000.0
TEXT_MM, TEXT_OF_WIDTH = 2.5, 0.014
"""Height of letters: the smallest, and its share of the width of a wide drawing."""

LETTER, LINE = 0.62, 1.6
"""Largest width of a letter, and distance of lines, over the height of letters."""

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
class Polyline:
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
class CamDrawing:
    """A drawing in the wheel's frame [mm]: origin at the axle, +y along the thread at rest.

    Attributes:
        title: title of the drawing.
        lines: polylines, the cheeks first.
        circles: axle, base circle, hole.
        notes: dimensions in words, from the top down, no wider than the drawing or 75 mm.
        text_mm: height of letters.
    """

    title: str
    lines: tuple[Polyline, ...]
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


def draw_cam(cam: Cam, cut: Cheeks, title: str) -> CamDrawing:
    """Return the drawing of a cam: cheeks, thread at rest, axle, circles, dimensions."""
    x, y = MM_PER_M * cut.x, MM_PER_M * cut.y
    rate = MM_PER_M * float(cam.lever_rate(0.0))
    tip, below = MM_PER_M * float(cam.p(0.0)), float(np.max(y)) + _GAP_MM
    hole = MM_PER_M * cam.hole_distance
    end = hole if math.isfinite(hole) else max(below, 2.0 * tip)
    circles = [Circle(AXLE, 0.0, 0.0, _AXLE_MM), Circle(BASE_CIRCLE, 0.0, 0.0, rate)]
    if math.isfinite(hole):
        circles.append(Circle(HOLE, 0.0, hole, max(0.5 * MM_PER_M * cut.thread_thickness, 0.5)))
    lines = [
        Polyline(CHEEK_LEFT, x, y),
        Polyline(CHEEK_RIGHT, -x, y),
        Polyline(THREAD, np.zeros(2), np.array([tip, end])),
    ]
    return _explained(title, lines, circles, dimensions(cam, cut))


def draw_uneven(
    left: tuple[FloatArray, FloatArray],
    right: tuple[FloatArray, FloatArray],
    rate: float,
    title: str,
    words: list[str],
) -> CamDrawing:
    """Return the drawing of cheeks that are not mirror images of each other.

    `left` is the cheek for positive angles, beginning at the tip; `rate` the lever arm per radian
    at rest [mm].
    """
    top = max(float(np.max(left[1])), float(np.max(right[1]))) + _GAP_MM
    lines = [
        Polyline(CHEEK_LEFT, *left),
        Polyline(CHEEK_RIGHT, *right),
        Polyline(THREAD, np.zeros(2), np.array([rate, top])),
    ]
    circles = [Circle(AXLE, 0.0, 0.0, _AXLE_MM), Circle(BASE_CIRCLE, 0.0, 0.0, rate)]
    return _explained(title, lines, circles, words)


def draw_in_fluid(
    curve: DescentCurve, outline: tuple[FloatArray, FloatArray], title: str
) -> CamDrawing:
    """Return the drawing of a curve in a fluid, its lowest point and dimensions.

    The outline is in millimetres, origin at the lowest point, +y upwards.
    """
    ascent = curve.ascent_cusp
    words = [
        'millimetres, 1:1; origin: the lowest point; +y: upwards; descents begin on the right',
        f'pendulum in vacuum {MM_PER_M * curve.pendulum_length:.6g} mm; kappa {curve.kappa:.6g} '
        f'1/m; gamma {curve.gamma:.6g}',
        f'arc of descent to its cusp {MM_PER_M * curve.descent_cusp:.6g} mm; of ascent '
        + (f'{MM_PER_M * abs(ascent):.6g} mm' if math.isfinite(ascent) else 'without end'),
    ]
    return _explained(
        title, [Polyline(CURVE, *outline)], [Circle(AXLE, 0.0, 0.0, _AXLE_MM)], words
    )


def _explained(
    title: str, lines: list[Polyline], circles: list[Circle], dimensions: list[str]
) -> CamDrawing:
    """Return a drawing with a scale bar, and its dimensions in words below."""
    left, low, right, _ = CamDrawing(title, tuple(lines), tuple(circles), ()).box
    width = right - left
    text_mm = max(TEXT_MM, TEXT_OF_WIDTH * width)
    bar = max((each for each in _BARS_MM if each <= 0.5 * width), default=_BARS_MM[0])
    place = low - _GAP_MM
    ticks = np.array([1.0, -1.0, 0.0, 0.0, 1.0, -1.0]) * text_mm / TEXT_MM
    along = np.array([0.0, 0.0, 0.0, bar, bar, bar])
    scale = Polyline(SCALE, left + along, place + ticks)
    # the text beside a small cam is 75 mm wide
    letters = int(max(width, 75.0) / (LETTER * text_mm))
    words = [
        line
        for text in (f'{bar:g} mm', title, *dimensions)
        for line in textwrap.wrap(text, letters, subsequent_indent='  ', break_on_hyphens=False)
    ]
    notes = [
        Note(NOTES, left, place - LINE * text_mm * (n + 1.25), text)
        for n, text in enumerate(words)
    ]
    return CamDrawing(title, (*lines, scale), tuple(circles), tuple(notes), text_mm)


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
