"""The plate of a scene's cam as files: DXF for the machine, a paper template, what it costs.

All files are in millimetres.
"""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np

from tauto_core.curves.cam import Cam, Setting
from tauto_core.curves.plate import ArcPath, Plate, PlateRates, cam_plate, plate_rates
from tauto_core.files import write_output
from tauto_core.plots.machine import cam_extent
from tauto_core.scene import Scene
from tauto_core.scene.errors import Argument, UsageError
from tauto_core.wording import significant

THREAD_MM, CUTTER_MM = 0.5, 0.25
"""A thread and a cutter (the wire of a spark eroder) where none is given."""

AMPLITUDES = (0.1, 0.2, 0.5, 1.0)
"""Amplitudes at which costs are given [rad], besides that of the release."""

PAPER_MM = (210.0, 297.0)
MARGIN_MM = 15.0
CHECK_MM = 100.0
_WORDS_MM, _LINE_MM = 90.0, 5.0
_LETTERS = 88
"""Space for the words at the foot of the template, and letters in a line of 3.2 mm."""


@dataclass(frozen=True)
class ScenePlate:
    """The plate of a scene, its cam, and what it costs.

    Attributes:
        name: name of the scene.
        plate: the plate.
        cam: the cam.
        setting: the machine for which the cam is made.
        rates: what the plate does to the rate of free swings on land.
    """

    name: str
    plate: Plate
    cam: Cam
    setting: Setting
    rates: PlateRates

    def words(self, *, tool: bool = True) -> list[str]:
        """Return the dimensions and costs in words, a line each; that of the tool if drawn."""
        plate, holes = self.plate, self.plate.holes
        small = 0.2 if 0.2 in self.rates.amplitude_rad else float(self.rates.amplitude_rad[0])
        at = int(np.argmin(np.abs(self.rates.amplitude_rad - small)))
        edge, outline, deep = (
            significant(float(cost[at]), 2, signed=True)
            for cost in (self.rates.edge, self.rates.outline, self.rates.one_micrometre)
        )
        words = [
            'millimetres, 1:1; origin: the axle; +y: the thread at rest',
            f'thread {plate.cheek.thread:g} mm in a slot {plate.slot:.4g} mm wide; the cheeks act '
            f'from {plate.acts_from_rad:.4g} to {plate.reach_rad:.4g} rad',
            f'bore {2.0 * holes[0].radius:g} mm; two pin holes {2.0 * holes[1].radius:g} mm at '
            f'({holes[1].x:.5g}, {holes[1].y:.5g}) and ({holes[2].x:.5g}, {holes[2].y:.5g})',
            f'{len(plate.cheek.radius)} arcs a cheek, within {plate.tolerance:g} mm',
            f'rounded cusp: {edge} s/day at {small:g} rad; with the arcs {outline} s/day',
            f'both cheeks cut a micrometre too deep: {deep} s/day at {small:g} rad',
        ]
        if tool and plate.tool is not None:
            words.append(
                f'TOOL: centre of a cutter of {plate.cutter:g} mm, outside the plate, inside the '
                'holes'
            )
        return words

    def facts(self) -> dict[str, object]:
        """Return dimensions and costs for JSON."""
        plate = self.plate
        return {
            'scene': self.name,
            'thread_mm': plate.cheek.thread,
            'slot_mm': plate.slot,
            'cutter_mm': plate.cutter,
            'tolerance_mm': plate.tolerance,
            'arcs_a_cheek': len(plate.cheek.radius),
            'reach_rad': plate.reach_rad,
            'acts_from_rad': plate.acts_from_rad,
            'bore_mm': 2.0 * plate.holes[0].radius,
            'pins_mm': 2.0 * plate.holes[1].radius,
            'pins_at_mm': [[hole.x, hole.y] for hole in plate.holes[1:]],
            'rates': [
                {
                    'amplitude_rad': amplitude,
                    'rounded_cusp_s_per_day': edge,
                    'as_drawn_s_per_day': outline,
                    'micrometre_too_deep_s_per_day': deep,
                }
                for amplitude, edge, outline, deep in zip(
                    *(
                        column.tolist()
                        for column in (
                            self.rates.amplitude_rad,
                            self.rates.edge,
                            self.rates.outline,
                            self.rates.one_micrometre,
                        )
                    ),
                    strict=True,
                )
            ],
        }


def plate_of(
    scene: Scene,
    reach_rad: float | None = None,
    *,
    thread_mm: float = THREAD_MM,
    cutter_mm: float = CUTTER_MM,
    tolerance_mm: float = 1e-5,
    bore_mm: float | None = None,
    pins_mm: float | None = None,
    pin_circle_mm: float | None = None,
    slot_mm: float | None = None,
) -> ScenePlate:
    """Return the plate of a scene's cam, and what it costs on land.

    The arguments are those of `cam_plate`; without a reach the cheeks end at `cam_extent`.

    Raises:
        UsageError: a scene without a pair of mirror-image cheeks, or as by `cam_plate`.
        SceneError: a cam that cannot be built.
    """
    trochlea = scene.trochlea
    if trochlea is None or trochlea.cam.kind == 'lever_corrected':
        raise UsageError(
            Argument('scene', scene.name, spaced=True),
            ': has no pair of mirror-image cheeks, of which a plate is made. `tauto cam` draws '
            'other curves',
        )
    cam = trochlea.made_cam(scene.g)
    reach = cam_extent(scene) if reach_rad is None else reach_rad
    if not 0.0 < reach <= cam.range_rad:
        raise UsageError(
            Argument('reach_rad', f'{reach!r} rad', spaced=True),
            f': must be > 0 and within the range of the cam, {cam.range_rad!r} rad. Give another, '
            'or leave it out',
        )
    plate = cam_plate(
        cam,
        reach,
        thread_mm=thread_mm,
        cutter_mm=cutter_mm,
        tolerance_mm=tolerance_mm,
        bore_mm=bore_mm,
        pins_mm=pins_mm,
        pin_circle_mm=pin_circle_mm,
        slot_mm=slot_mm,
    )
    asked = {*AMPLITUDES, abs(trochlea.release_angle)}
    swings = np.array(sorted(a for a in asked if plate.acts_from_rad < a <= reach) or [reach])
    setting = trochlea.thread.setting(trochlea.parts(scene.g))
    return ScenePlate(scene.name, plate, cam, setting, plate_rates(plate, cam, setting, swings))


def write_plate_dxf(path: Path, made: ScenePlate) -> None:
    """Write a plate as DXF R2010: closed polylines of arcs, circles, words; replaces the file.

    Layers: PLATE, BORE and PIN are cut; TOOL is the path of the centre of the cutter; NOTES.
    """
    from ezdxf import units
    from ezdxf.filemanagement import new

    plate = made.plate
    document = new('R2010', setup=False, units=units.MM)
    for layer, colour in (('PLATE', 7), ('BORE', 7), ('PIN', 7), ('TOOL', 1), ('NOTES', 5)):
        document.layers.add(layer, color=colour)
    space = document.modelspace()
    for layer, edge in (('PLATE', plate.outline), ('TOOL', plate.tool)):
        if edge is not None:
            points = np.column_stack(edge).tolist()
            space.add_lwpolyline(points, 'xyb', close=True, dxfattribs={'layer': layer})
    for hole in (*plate.holes, *plate.tool_holes):
        space.add_circle((hole.x, hole.y), hole.radius, dxfattribs={'layer': hole.layer})
    lowest = float(np.min(plate.outline.polygon(0.01)[1])) - plate.cutter
    for row, line in enumerate([made.name, *made.words()]):
        text = space.add_text(line, height=1.0, dxfattribs={'layer': 'NOTES'})
        text.set_placement((float(np.min(plate.outline.x)), lowest - 2.0 * (row + 1)))
    written = StringIO()
    document.write(written)
    write_output(path, document.encode(written.getvalue()))


# -----------------------------------------------------------------------------
# The paper template.


def write_template(path: Path, made: ScenePlate) -> None:
    """Write a plate to scale on a sheet of A4, with a line to check the print; replaces the file.

    UsageError: a plate that does not fit on the sheet, before anything is written.
    """
    plate = made.plate
    x, y = plate.outline.polygon(1e-3)
    width, height = float(np.ptp(x)), float(np.ptp(y))
    room = (PAPER_MM[0] - 2.0 * MARGIN_MM, PAPER_MM[1] - 2.0 * MARGIN_MM - _WORDS_MM)
    if width > room[0] or height > room[1]:
        raise UsageError(
            Argument('template', path, spaced=True),
            f': the plate of {width:.4g} × {height:.4g} mm does not fit on a sheet of A4, which '
            f'has room for {room[0]:g} × {room[1]:g} mm. Give a smaller ',
            Argument('reach_rad'),
            ', or have the DXF printed',
        )
    # the plate in the middle of its room; y points down on paper
    across = 0.5 * PAPER_MM[0] - 0.5 * float(np.max(x) + np.min(x))
    down = MARGIN_MM + 0.5 * room[1] + 0.5 * float(np.max(y) + np.min(y))
    drawn = [
        f'<path id="PLATE" d="{_svg_path(plate.outline)}"/>',
        *(
            f'<circle class="{hole.layer}" cx="{hole.x:.6f}" cy="{-hole.y:.6f}" '
            f'r="{hole.radius:.6f}"/>'
            for hole in plate.holes
        ),
    ]
    marks = [
        f'<path d="M{hole.x - arm:.4f} {-hole.y:.4f}h{2.0 * arm:.4f}'
        f'M{hole.x:.4f} {-hole.y - arm:.4f}v{2.0 * arm:.4f}"/>'
        for hole in plate.holes
        for arm in [1.6 * hole.radius]
    ]
    # the thread at rest, from beyond the plate on
    top = float(np.max(y)) + 3.0
    marks.append(f'<path d="M0 {-top:.4f}v-8m-1.2 2.4l1.2 -2.4l1.2 2.4"/>')
    ruler = PAPER_MM[1] - MARGIN_MM - _WORDS_MM + 14.0
    begin = 0.5 * (PAPER_MM[0] - CHECK_MM)
    ticks = ''.join(
        f'M{begin + at} {ruler}v{-4 if at % 50 == 0 else -2.5 if at % 10 == 0 else -1.5}'
        for at in range(0, int(CHECK_MM) + 1, 5)
    )
    words = [
        line
        for text in made.words(tool=False)
        for line in textwrap.wrap(text, _LETTERS, subsequent_indent='  ')
    ]
    lines = [
        f'<text x="{MARGIN_MM}" y="{ruler + 16.0 + _LINE_MM * row}">{escape(line)}</text>'
        for row, line in enumerate(words)
    ]
    page = f"""<svg xmlns="http://www.w3.org/2000/svg" width="{PAPER_MM[0]:g}mm" \
height="{PAPER_MM[1]:g}mm" viewBox="0 0 {PAPER_MM[0]:g} {PAPER_MM[1]:g}">
<title>{escape(made.name)}: the plate of the cam, 1:1</title>
<rect width="100%" height="100%" fill="white"/>
<g font-family="sans-serif" font-size="3.2" fill="black">
<text x="{MARGIN_MM}" y="{MARGIN_MM + 4.0}" font-size="5">{escape(made.name)}: the plate of the \
cam, 1:1</text>
<text x="{MARGIN_MM}" y="{MARGIN_MM + 10.0}">Print at 100 %. The arrow points along the thread \
at rest.</text>
<text x="{0.5 * PAPER_MM[0]}" y="{ruler + 6.0}" text-anchor="middle">{CHECK_MM:g} mm: measure \
this line before cutting</text>
{chr(10).join(lines)}
</g>
<g fill="none" stroke="black" stroke-width="0.15">
<path id="CHECK" d="M{begin} {ruler}h{CHECK_MM:g}"/>
<path d="{ticks}"/>
<g transform="translate({across:.6f} {down:.6f})">
{chr(10).join(drawn)}
<g stroke="#1f77b4" stroke-width="0.1">
{chr(10).join(marks)}
</g>
</g>
</g>
</svg>
"""
    write_output(path, page.encode())


def _svg_path(edge: ArcPath) -> str:
    """Return a closed path of arcs and lines, y upwards turned to y downwards."""
    parts = [f'M{edge.x[0]:.6f} {-edge.y[0]:.6f}']
    ends = np.roll(edge.x, -1), np.roll(edge.y, -1)
    chords = np.hypot(ends[0] - edge.x, ends[1] - edge.y)
    for x, y, chord, bulge in zip(*ends, chords, edge.bulge, strict=True):
        if bulge == 0.0:
            parts.append(f'L{x:.6f} {-y:.6f}')
            continue
        radius = 0.25 * chord * (1.0 / abs(bulge) + abs(bulge))
        # no arc turns by more than half a turn; with y downwards a left turn is SVG's flag 0
        parts.append(f'A{radius:.6f} {radius:.6f} 0 0 {int(bulge < 0.0)} {x:.6f} {-y:.6f}')
    return ''.join(parts) + 'Z'
