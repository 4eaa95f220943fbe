"""Wheel, cheeks and axle of a scene as solids: STEP and STL, by the extra `cad` (build123d).

The scene gives the total moment of inertia. The rim, a brass ring of square section, adds to
cheeks, axle and a web as thick as the plate what this total takes. Frame: x and y of the plate,
z along the axle from the plane between cheeks and web. Lengths in millimetres.
"""

from __future__ import annotations

import math
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from tauto_core.curves.drawing import MM_PER_M, ArcPath, Plate
from tauto_core.curves.numerics import bisect
from tauto_core.files import OutputError, write_output
from tauto_core.plots.machine import BRASS_KG_M3, RIM_SIDE
from tauto_core.scene.errors import Argument, TautoError, UsageError, install

KG_PER_MM3 = BRASS_KG_M3 / MM_PER_M**3
THINNEST_MM, THICKNESS_MM, THICKEST_MM = 0.1, 2.0, 100.0
"""Least, default and greatest thickness of a plate."""

STUB = 5.0
"""Length of the axle on either side of cheeks and web, over its diameter."""

ROUND_MM = 1e-3
"""Sagitta of the facets of wheel and axle. The cheeks have the tolerance of the plate."""


class CadError(TautoError):
    """Solids without the extra `cad`."""


def check_solids(thickness_mm: float) -> None:
    """Check thickness and library.

    UsageError: a thickness outside THINNEST_MM to THICKEST_MM. CadError: no build123d.
    """
    if not THINNEST_MM <= thickness_mm <= THICKEST_MM:
        raise UsageError(
            Argument('thickness_mm', thickness_mm, spaced=True),
            f': must be {THINNEST_MM:g} to {THICKEST_MM:g} mm. Leave it out for the default',
        )
    try:
        version('build123d')
    except PackageNotFoundError:
        raise CadError(
            'STEP and STL need build123d, which is not installed. Run ',
            install('cad'),
            ', or leave out --step and --stl',
        ) from None


def rim_radius(plate: Plate, inertia: float, thickness_mm: float) -> float:
    """Return the mean radius of the rim [mm] for a total moment of inertia [kg m2].

    UsageError: cheeks, axle and the smallest wheel have more.
    """
    wanted = inertia * MM_PER_M**2 / KG_PER_MM3
    # ∫ (x² + y²) over the polygon, by Green's theorem
    x, y = plate.outline.polygon(ROUND_MM)
    ends = np.roll(x, -1), np.roll(y, -1)
    squares = sum(a * a + a * b + b * b for a, b in zip((x, y), ends, strict=True))
    cheeks = float(np.sum((x * ends[1] - ends[0] * y) * squares)) / 12.0

    def disc(radius: float) -> float:
        return 0.5 * math.pi * radius**4

    bore = disc(plate.holes[0].radius)
    holes = bore + sum(
        disc(hole.radius) + math.pi * (hole.radius * math.hypot(hole.x, hole.y)) ** 2
        for hole in plate.holes[1:]
    )
    axle = 2.0 * thickness_mm + 4.0 * STUB * plate.holes[0].radius
    fixed = (cheeks - holes) * thickness_mm + bore * axle

    def total(rim: float) -> float:
        side = RIM_SIDE * rim
        inner, outer = rim - 0.5 * side, rim + 0.5 * side
        ring = (disc(outer) - disc(inner)) * side
        return fixed + ring + (disc(inner) - holes) * thickness_mm

    # the plate fits inside the rim
    lower = float(np.max(np.hypot(x, y))) / (1.0 - 0.5 * RIM_SIDE)
    if total(lower) > wanted:
        raise UsageError(
            Argument('thickness_mm', f'{thickness_mm:g} mm', spaced=True),
            f': cheeks, axle and the smallest wheel about them have a moment of inertia of '
            f'{total(lower) * KG_PER_MM3 / MM_PER_M**2:.4g} kg m2 in brass, and the scene has '
            f'{inertia:.4g} kg m2. Give a thinner plate, or a smaller ',
            Argument('reach_rad'),
        )
    upper = lower
    while total(upper) < wanted:
        upper *= 2.0
    return bisect(lambda radius: total(radius) < wanted, lower, upper)[0]


def write_solids(
    plate: Plate,
    name: str,
    inertia: float,
    thickness_mm: float,
    step: Path | None,
    stl: Path | None,
) -> list[Path]:
    """Write wheel, cheeks and axle as one STEP file and as STL files in a folder.

    Existing files are replaced. Errors: see `rim_radius`. OutputError: a file that cannot be
    written.
    """
    parts = _solids(plate, rim_radius(plate, inertia, thickness_mm), thickness_mm)
    from build123d import Compound, export_step, export_stl

    written: list[tuple[Path, bytes]] = []
    with TemporaryDirectory() as folder:
        if step is not None:
            for label, part in parts.items():
                part.label = label
            assembly = Path(folder) / 'whole.step'
            export_step(Compound(label=name, children=list(parts.values())), assembly)
            written.append((step, assembly.read_bytes()))
        if stl is not None:
            for label, part in parts.items():
                # build123d's tolerance is relative to the size of an edge, and only the sagitta of
                # facets counts here
                relative = (
                    plate.tolerance / float(np.max(np.abs(np.diff(plate.cheek.vertex))))
                    if label == 'cheeks'
                    else ROUND_MM / part.bounding_box().diagonal
                )
                export_stl(part, Path(folder) / label, tolerance=relative, angular_tolerance=1.0)
                written.append((stl / f'{label}.stl', (Path(folder) / label).read_bytes()))
    if stl is not None:
        try:
            stl.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(
                Argument('stl', stl), f': cannot be made a folder: {error.strerror}. Name another'
            ) from None
    for file, content in written:
        write_output(file, content)
    return [file for file, _ in written]


def _solids(plate: Plate, rim_mm: float, thickness_mm: float) -> dict[str, Any]:
    """Return the solids by name."""
    from build123d import Cylinder, Edge, Face, Pos, Solid, Vector, Wire

    def ring(radius: float) -> Any:
        return Wire(Edge.make_circle(radius))

    def extruded(edge: Any, holes: list[Any], low: float, high: float) -> Any:
        face = Face(edge, holes).moved(Pos(0.0, 0.0, low))
        return Solid.extrude(face, Vector(0.0, 0.0, high - low))

    holes = [ring(hole.radius).moved(Pos(hole.x, hole.y, 0.0)) for hole in plate.holes]
    cheeks = extruded(_wire(plate.outline), holes, 0.0, thickness_mm)
    half = 0.5 * RIM_SIDE * rim_mm
    inner, outer, middle = rim_mm - half, rim_mm + half, -0.5 * thickness_mm
    web = extruded(ring(inner), holes, -thickness_mm, 0.0)
    rim = extruded(ring(outer), [ring(inner)], middle - half, middle + half)
    radius = plate.holes[0].radius
    axle = Cylinder(radius, 2.0 * thickness_mm + 4.0 * STUB * radius)
    return {'wheel': web + rim, 'cheeks': cheeks, 'axle': axle}


def _wire(edge: ArcPath) -> Any:
    """Return a closed path as a wire of arcs and lines."""
    from build123d import Edge, Wire

    points = edge.x + 1j * edge.y
    edges = []
    for start, end, bulge in zip(points, np.roll(points, -1), edge.bulge, strict=True):
        ends = [(point.real, point.imag, 0.0) for point in (start, end)]
        if bulge == 0.0:
            edges.append(Edge.make_line(*ends))
            continue
        # the sagitta is the bulge times half the chord, on the right of a left turn
        middle = 0.5 * (start + end) - 0.5j * bulge * (end - start)
        edges.append(Edge.make_three_point_arc(ends[0], (middle.real, middle.imag, 0.0), ends[1]))
    return Wire(edges)
