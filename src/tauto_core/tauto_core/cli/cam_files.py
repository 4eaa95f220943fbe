"""Files of a cam: points as CSV, drawings to scale as SVG and DXF, all in millimetres."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO, StringIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tauto_core.files import write_whole
from tauto_core.scene.errors import TautoError

if TYPE_CHECKING:
    from tauto_core.curves.drawing import Cheeks, Drawing
    from tauto_core.machines.lever_cheeks import Cheek

MM_PER_M = 1000.0
MM_PER_INCH = 25.4
POINTS_PER_MM = 72.0 / MM_PER_INCH
MARGIN_MM = 5.0
COLUMNS = ('x_mm', 'y_mm', 'angle_rad')


class OutputError(TautoError):
    """A file that cannot be written."""


@contextmanager
def _written(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        words = f'{path}: cannot be written: {error.strerror}. Name another file'
        raise OutputError(words) from None


def write_points(path: Path, cut: Cheeks) -> None:
    """Write both cheeks as x_mm, y_mm, angle_rad, from the end of one to the end of the other.

    At positive angles the thread leaves the cheek on the left of the drawing. A tip that both
    share is one row.
    """
    x, y, angle = (MM_PER_M * cut.x).tolist(), (MM_PER_M * cut.y).tolist(), cut.angle.tolist()
    shared = 1 if x[0] == 0.0 else 0
    mirrored = [(-a, b, -c) for a, b, c in zip(x, y, angle, strict=True)][shared:]
    rows: Sequence[tuple[float, ...]] = [
        *reversed(mirrored),
        *zip(x, y, angle, strict=True),
    ]
    write_rows(path, COLUMNS, rows)


def write_sides(path: Path, left: Cheek, right: Cheek) -> None:
    """Write two cheeks that are not mirror images, from the end of the right to that of the left.

    A tip that both share is written once.
    """
    common = left.angle[0] == right.angle[0]
    columns = [
        (MM_PER_M * np.concatenate([second[::-1], first[int(common) :]])).tolist()
        for first, second in ((left.x, right.x), (left.y, right.y))
    ]
    angles = np.concatenate([right.angle[::-1], left.angle[int(common) :]]).tolist()
    write_rows(path, COLUMNS, zip(*columns, angles, strict=True))


def write_rows(path: Path, header: Sequence[str], rows: Iterable[Sequence[float]]) -> None:
    """Write numbers in full under a header."""
    lines = [','.join(header), *(','.join(map(repr, row)) for row in rows)]
    with _written(path):
        write_whole(path, ('\n'.join(lines) + '\n').encode())


def write_svg(path: Path, drawing: Drawing) -> None:
    """Write a drawing to scale, in millimetres on paper."""
    import matplotlib as mpl
    from matplotlib.figure import Figure
    from matplotlib.patches import Circle

    from tauto_core.curves.drawing import CUT, TEXT_MM

    left, low, right, top = _page(drawing)
    figure = Figure(figsize=((right - left) / MM_PER_INCH, (top - low) / MM_PER_INCH))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(left, right), ylim=(low, top))
    axes.set_axis_off()
    pen = drawing.text_mm / TEXT_MM
    for line in drawing.lines:
        cut = line.layer in CUT
        axes.plot(
            line.x,
            line.y,
            color='black' if cut else 'tab:blue',
            linewidth=pen * (0.5 if cut else 0.3),
            gid=line.layer,
        )
    for each in drawing.circles:
        ring = Circle(
            (each.x, each.y), each.radius, fill=False, linewidth=0.3 * pen, gid=each.layer
        )
        ring.set_edgecolor('tab:blue')
        axes.add_patch(ring)
    for note in drawing.notes:
        axes.text(note.x, note.y, note.text, fontsize=drawing.text_mm * POINTS_PER_MM)
    # the same scene must give the same file
    drawn = BytesIO()
    with mpl.rc_context({'svg.hashsalt': drawing.title}):
        figure.savefig(drawn, format='svg', metadata={'Title': drawing.title, 'Date': None})
    with _written(path):
        write_whole(path, drawn.getvalue())


def _page(drawing: Drawing) -> tuple[float, float, float, float]:
    """Return left, bottom, right and top of the paper [mm]."""
    from tauto_core.curves.drawing import LETTER

    left, low, right, top = drawing.box
    longest = max(note.x + LETTER * drawing.text_mm * len(note.text) for note in drawing.notes)
    return (
        left - MARGIN_MM,
        low - MARGIN_MM,
        max(right, longest) + MARGIN_MM,
        top + MARGIN_MM,
    )


def write_dxf(path: Path, drawing: Drawing) -> None:
    """Write a drawing as DXF R2010 in millimetres, a layer for each kind of line."""
    from ezdxf import units
    from ezdxf.filemanagement import new

    from tauto_core.curves.drawing import CUT

    document = new('R2010', setup=False, units=units.MM)
    layers = [line.layer for line in drawing.lines]
    layers += [each.layer for each in drawing.circles] + [note.layer for note in drawing.notes]
    for layer in dict.fromkeys(layers):
        document.layers.add(layer, color=7 if layer in CUT else 5)
    space = document.modelspace()
    for line in drawing.lines:
        points = zip(line.x.tolist(), line.y.tolist(), strict=True)
        space.add_lwpolyline(points, dxfattribs={'layer': line.layer})
    for each in drawing.circles:
        space.add_circle((each.x, each.y), each.radius, dxfattribs={'layer': each.layer})
    for note in drawing.notes:
        text = space.add_text(note.text, height=drawing.text_mm, dxfattribs={'layer': note.layer})
        text.set_placement((note.x, note.y))
    written = StringIO()
    document.write(written)
    with _written(path):
        write_whole(path, document.encode(written.getvalue()))
