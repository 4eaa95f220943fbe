"""The plate of a scene's cam as files: DXF for the machine, a paper template; its cost.

All files are in millimetres.
"""

from __future__ import annotations

import math
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
# Space for the words at the foot of the template, and letters in a line of 3.2 mm.
_WORDS_MM, _LINE_MM = 90.0, 5.0
_LETTERS = 88

OVERLAP_MM, _FOOT_MM = 10.0, 24.0
"""How far the parts of a larger template overlap, and space for the line at the foot of each."""

MOST_SHEETS = 100


@dataclass(frozen=True)
class ScenePlate:
    """The plate of a scene, its cam, and its cost in rate.

    Attributes:
        name: name of the scene.
        plate: the plate.
        cam: the cam.
        setting: the machine for which the cam is made.
        rates: the effect of the plate on the rate of free swings on land.
        files: the files written of it.
    """

    name: str
    plate: Plate
    cam: Cam
    setting: Setting
    rates: PlateRates
    files: tuple[Path, ...] = ()

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
    """Return the plate of a scene's cam, and its cost in rate on land.

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
# The paper template: one sheet, or a plan and a sheet for each part.


def write_template(path: Path, made: ScenePlate) -> list[Path]:
    """Write a plate to scale on A4, with a line to check the print; return the files.

    A plate that does not fit on a sheet has a sheet for each part beside the file, `NAME_A1.svg`
    and so on by row and column, which overlap; the file itself is the plan of them, with the
    words. Files are replaced.

    UsageError: a plate that needs more than `MOST_SHEETS`, before anything is written.
    """
    plate = made.plate
    x, y = plate.outline.polygon(1e-3)
    width, height = float(np.ptp(x)), float(np.ptp(y))
    middle = 0.5 * float(np.max(x) + np.min(x)), 0.5 * float(np.max(y) + np.min(y))
    # the thread at rest, from beyond the plate on
    top = float(np.max(y)) + 3.0
    thread = f'<path d="M0 {-top:.4f}v-8m-1.2 2.4l1.2 -2.4l1.2 2.4"/>'
    drawn = '\n'.join([*_lines(plate), '<g stroke="#1f77b4" stroke-width="0.1">'])
    drawn = f'{drawn}\n{chr(10).join([*_crosses(plate), thread])}\n</g>'
    room = (PAPER_MM[0] - 2.0 * MARGIN_MM, PAPER_MM[1] - 2.0 * MARGIN_MM - _WORDS_MM)
    ruler = PAPER_MM[1] - MARGIN_MM - _WORDS_MM + 14.0
    words = [
        line
        for text in made.words(tool=False)
        for line in textwrap.wrap(text, _LETTERS, subsequent_indent='  ')
    ]
    texts = [(ruler + 16.0 + _LINE_MM * row, line) for row, line in enumerate(words)]
    heading = f'{made.name}: the plate of the cam, 1:1'
    center = (0.5 * PAPER_MM[0], MARGIN_MM + 0.5 * room[1])
    if width <= room[0] and height <= room[1]:
        print_it = 'Print at 100 %. The arrow points along the thread at rest.'
        body = _placed(drawn, middle, center)
        page = _sheet(heading, [(MARGIN_MM + 10.0, print_it), *texts], body, ruler)
        write_output(path, page.encode())
        return [path]
    part = (room[0], PAPER_MM[1] - 2.0 * MARGIN_MM - _FOOT_MM)
    columns, rows = (
        math.ceil((size + 8.0 - OVERLAP_MM) / (whole - OVERLAP_MM))
        for size, whole in zip((width, height + 24.0), part, strict=True)
    )
    if columns * rows > MOST_SHEETS:
        raise UsageError(
            Argument('template', path, spaced=True),
            f': the plate of {width:.4g} × {height:.4g} mm needs {columns * rows:,} sheets of A4, '
            f'and {MOST_SHEETS} are the most. Give a smaller ',
            Argument('reach_rad'),
            ', or have the DXF printed',
        )
    sheets = [(row, column) for row in range(rows) for column in range(columns)]
    files = {sheet: path.with_name(f'{path.stem}_{_name(*sheet)}.svg') for sheet in sheets}
    advance = tuple(whole - OVERLAP_MM for whole in part)
    for row, column in sheets:
        # the middle of this part, from that of all of them; y points down on paper
        right = (column - 0.5 * (columns - 1)) * advance[0]
        down = (row - 0.5 * (rows - 1)) * advance[1]
        at = (0.5 * PAPER_MM[0] - right, MARGIN_MM + 0.5 * part[1] - down)
        body = (
            f'<clipPath id="part"><rect x="{MARGIN_MM:g}" y="{MARGIN_MM:g}" width="{part[0]:g}" '
            f'height="{part[1]:g}"/></clipPath>\n'
            f'<g clip-path="url(#part)">\n{_placed(drawn, middle, at)}\n</g>\n'
            f'{_joins(part, (row, column), (rows, columns))}'
        )
        foot = PAPER_MM[1] - MARGIN_MM - _FOOT_MM + 8.0
        said = (
            f'{made.name}, sheet {files[row, column].stem}; the last is {files[sheets[-1]].stem}. '
            'Print at 100 %. Crosses of the same letter lie upon each other.'
        )
        page = _sheet('', [(foot + 11.0, said)], body, foot)
        write_output(files[row, column], page.encode())
    # the plan: all parts on one sheet, smaller
    scale = min(
        room[0] / (columns * advance[0] + OVERLAP_MM),
        (room[1] - 16.0) / (rows * advance[1] + OVERLAP_MM),
    )
    frames = [
        f'<rect x="{(column - 0.5 * columns) * advance[0] - 0.5 * OVERLAP_MM:.3f}" '
        f'y="{(row - 0.5 * rows) * advance[1] - 0.5 * OVERLAP_MM:.3f}" width="{part[0]:g}" '
        f'height="{part[1]:g}" stroke="#888" stroke-width="{0.2 / scale:.3f}"/>'
        f'<text x="{(column + 0.5 - 0.5 * columns) * advance[0]:.3f}" '
        f'y="{(row + 0.5 - 0.5 * rows) * advance[1]:.3f}" font-family="sans-serif" '
        f'font-size="{6.0 / scale:.3f}" text-anchor="middle" fill="#888" stroke="none">'
        f'{_name(row, column)}</text>'
        for row, column in sheets
    ]
    small = (
        f'<g transform="translate({center[0]} {center[1] + 8.0}) scale({scale:.6f})" '
        f'stroke-width="{0.15 / scale:.4f}">\n{chr(10).join(frames)}\n'
        f'{_placed(drawn, middle, (0.0, 0.0))}\n</g>'
    )
    first, last = files[sheets[0]].name, files[sheets[-1]].name
    plan = f'Plan of {len(sheets)} sheets, {first} to {last}; the plate is 1:1 on those.'
    heading = f'{made.name}: the plate of the cam, {width:.4g} × {height:.4g} mm'
    page = _sheet(heading, [(MARGIN_MM + 10.0, plan), *texts], small, ruler)
    write_output(path, page.encode())
    return [path, *files.values()]


def _name(row: int, column: int) -> str:
    """Return the name of a part: its row by letter, its column by number."""
    return f'{chr(ord("A") + row)}{column + 1}'


def _lines(plate: Plate) -> list[str]:
    """Return the edges of a plate as SVG in millimetres, y downwards."""
    return [
        f'<path id="PLATE" d="{_svg_path(plate.outline)}"/>',
        *(
            f'<circle class="{hole.layer}" cx="{hole.x:.6f}" cy="{-hole.y:.6f}" '
            f'r="{hole.radius:.6f}"/>'
            for hole in plate.holes
        ),
    ]


def _crosses(plate: Plate) -> list[str]:
    """Return the crosses of the middles of holes."""
    return [
        f'<path d="M{hole.x - arm:.4f} {-hole.y:.4f}h{2.0 * arm:.4f}'
        f'M{hole.x:.4f} {-hole.y - arm:.4f}v{2.0 * arm:.4f}"/>'
        for hole in plate.holes
        for arm in [1.6 * hole.radius]
    ]


def _placed(drawn: str, middle: tuple[float, float], at: tuple[float, float]) -> str:
    """Return a drawing whose middle, y upwards, lies at a place on the paper."""
    across, down = at[0] - middle[0], at[1] + middle[1]
    return f'<g transform="translate({across:.6f} {down:.6f})">\n{drawn}\n</g>'


def _joins(part: tuple[float, float], sheet: tuple[int, int], count: tuple[int, int]) -> str:
    """Return the middles of the overlaps with other parts, each with two crosses by letter."""
    left, top = MARGIN_MM, MARGIN_MM
    right, bottom = left + part[0], top + part[1]
    half = 0.5 * OVERLAP_MM
    marks: list[str] = []
    for along, here in enumerate(sheet):
        for side in (-1, 1):
            if not 0 <= here + side < count[along]:
                continue
            # a join of columns is a line down the sheet, one of rows a line across
            edge = (bottom, right)[along] - half if side > 0 else (top, left)[along] + half
            ends = ((left, right), (top, bottom))[along]
            line = f'M{left} {edge}H{right}' if along == 0 else f'M{edge} {top}V{bottom}'
            marks.append(f'<path d="{line}" stroke-dasharray="3 2"/>')
            before = here + min(side, 0)
            for share in (0.25, 0.75):
                there = ends[0] + share * (ends[1] - ends[0])
                x, y = (there, edge) if along == 0 else (edge, there)
                letter = 'abcdefghijklmnopqrstuvwxyz'[(2 * before + (share > 0.5)) % 26]
                marks.append(
                    f'<path class="JOIN" d="M{x - 4} {y}h8M{x} {y - 4}v8"/><circle cx="{x}" '
                    f'cy="{y}" r="2"/><text x="{x + 3}" y="{y - 1.5}" font-family="sans-serif" '
                    f'font-size="3.2" fill="#1f77b4" stroke="none">{letter}</text>'
                )
    return f'<g stroke="#1f77b4">{"".join(marks)}</g>'


def _sheet(heading: str, texts: list[tuple[float, str]], body: str, ruler: float) -> str:
    """Return a sheet of A4 with a heading, lines at heights [mm], a body, and a line to check."""
    begin = 0.5 * (PAPER_MM[0] - CHECK_MM)
    ticks = ''.join(
        f'M{begin + at} {ruler}v{-4 if at % 50 == 0 else -2.5 if at % 10 == 0 else -1.5}'
        for at in range(0, int(CHECK_MM) + 1, 5)
    )
    lines = [f'<text x="{MARGIN_MM}" y="{y}">{escape(line)}</text>' for y, line in texts]
    return f"""<svg xmlns="http://www.w3.org/2000/svg" width="{PAPER_MM[0]:g}mm" \
height="{PAPER_MM[1]:g}mm" viewBox="0 0 {PAPER_MM[0]:g} {PAPER_MM[1]:g}">
<title>{escape(heading or texts[0][1])}</title>
<rect width="100%" height="100%" fill="white"/>
<g font-family="sans-serif" font-size="3.2" fill="black">
<text x="{MARGIN_MM}" y="{MARGIN_MM + 4.0}" font-size="5">{escape(heading)}</text>
<text x="{0.5 * PAPER_MM[0]}" y="{ruler + 6.0}" text-anchor="middle">{CHECK_MM:g} mm: measure \
this line before cutting</text>
{chr(10).join(lines)}
</g>
<g fill="none" stroke="black" stroke-width="0.15">
<path id="CHECK" d="M{begin} {ruler}h{CHECK_MM:g}"/>
<path d="{ticks}"/>
{body}
</g>
</svg>
"""


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
