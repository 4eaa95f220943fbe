"""Coefficients of a hull from boundary elements, by capytaine (hull.md).

capytaine (M. Ancellin, F. Dias, J. Open Source Softw. 4, 2019, 1341, the extra `hull`) solves for
radiated and scattered waves with sources on panels of the wetted surface.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from tauto_core.samples import FloatArray
from tauto_core.scene.errors import install
from tauto_core.scene.tables import why_unreadable, words_of
from tauto_core.scene.times import STANDARD_GRAVITY
from tauto_core.ship.hull import (
    SHAPES,
    SHAPES_FOLDER,
    HullCoefficients,
    HullError,
    Shape,
    check_proportions,
)

FREQUENCIES: FloatArray = np.linspace(0.3, 4.8, 31)
"""omega sqrt(L/g): waves from 70 lengths down to a quarter of one."""
HEADINGS = 19
"""Headings from following to head seas, every 10 degrees."""
LENGTHWAYS, DOWN = 32, 8
"""Panels of a parametric form on one side."""
SHIPPED = 44, 12
"""Panels on one side of the shipped shapes."""
MOST_PANELS = 3000
_DOFS = ('Surge', 'Sway', 'Heave', 'Roll', 'Pitch', 'Yaw')


def solver() -> Any:
    """Return capytaine.

    Raises:
        HullError: it is not installed.
    """
    try:
        import capytaine
    except ImportError:
        raise HullError(
            'capytaine',
            'not installed',
            'computes the coefficients of a hull',
            f'Run {install("hull")}, or sail one of the shapes that come with Tauto.',
        ) from None
    capytaine.set_logging('ERROR')
    return capytaine


def form_mesh(shape: Shape, lengthways: int = LENGTHWAYS, down: int = DOWN) -> Any:
    """Return the panels of a parametric form under water, both sides.

    `lengthways` panels from stern to stem, `down` panels from the waterline to the keel.

    Raises:
        HullError: a form out of range, or capytaine is not installed.
    """
    p, q = shape.exponents()
    capytaine = solver()
    x = np.linspace(-1.0, 1.0, lengthways + 1)
    z = -np.linspace(0.0, 1.0, down + 1)
    y = (1.0 - np.abs(x[:, None]) ** p) * (1.0 - np.abs(z) ** q)
    corner = np.arange(y.size).reshape(y.shape)
    fore_and_aft, depth = np.broadcast_arrays(x[:, None], z)
    side = np.stack([fore_and_aft, y, depth], axis=-1).reshape(-1, 3)
    side = side * [0.5 * shape.length, 0.5 * shape.beam, shape.draught]
    panels = np.stack(
        [corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]], axis=-1
    ).reshape(-1, 4)
    mirrored = side * [1.0, -1.0, 1.0]
    return capytaine.Mesh(
        vertices=np.concatenate([side, mirrored]),
        faces=np.concatenate([panels, panels[:, ::-1] + len(side)]),
    )


def read_mesh(path: Path) -> Any:
    """Return the panels of a file: x forward, y to port, z up from the waterline [m].

    capytaine reads .nemoh, .gdf, .pnl, .stl, .msh and others. The part above the waterline is cut
    off, and the middle of the waterline becomes x = 0.

    Raises:
        HullError: the file is missing or not a mesh, or the hull is open, dry or asymmetric.
    """
    capytaine = solver()
    if not path.is_file():
        raise HullError('mesh', str(path), 'there is no such file', 'Name a file of a mesh.')
    if reason := why_unreadable(path):
        raise HullError('mesh', str(path), reason, 'Name a file of a mesh.')
    try:
        mesh = capytaine.load_mesh(str(path)).merged().immersed_part()
    except Exception as error:  # each format's reader has its own errors
        problem = f'cannot be read: {words_of(error)}'
        raise HullError('mesh', str(path), problem, 'Give a mesh that capytaine reads.') from None
    if mesh.nb_faces == 0:
        problem = 'is dry: all of it is above z = 0'
        raise HullError('mesh', str(path), problem, 'Put the waterline at z = 0.')
    if min(mesh.volumes) <= 0.0 or max(mesh.volumes) > 1.05 * min(mesh.volumes):
        across, along, down = mesh.volumes
        problem = (
            'must be closed under water with all panels facing outwards: its volume by x, y and '
            f'z is {across:.4g}, {along:.4g} and {down:.4g} m3'
        )
        raise HullError('mesh', str(path), problem, 'Mend the mesh, and draw both sides.')
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    beam = high[1] - low[1]
    if abs(high[1] + low[1]) > 0.01 * beam or abs(mesh.center_of_buoyancy[1]) > 0.01 * beam:
        problem = 'must have equal sides about y = 0'
        raise HullError('mesh', str(path), problem, 'Draw both sides: x forward, y to port.')
    return mesh.translated_x(-0.5 * (high[0] + low[0]))


def compute(
    mesh: Any,
    name: str,
    *,
    progress: Callable[[float], None] | None = None,
    frequencies: FloatArray = FREQUENCIES,
    headings: int = HEADINGS,
    lid: bool = True,
) -> HullCoefficients:
    """Return the coefficients of a hull under water.

    A lid on the water inside the hull suppresses irregular frequencies, at which sources on the
    hull alone have no unique solution.

    Args:
        mesh: panels under water, both sides, as `form_mesh` and `read_mesh` return them.
        name: the name of the hull.
        progress: called with the finished part, 0 to 1.
        frequencies: omega sqrt(L/g), increasing.
        headings: number of headings over [0, pi].
        lid: whether there is a lid.

    Raises:
        HullError: proportions out of range, or more panels than `MOST_PANELS`.
    """
    capytaine = solver()
    length, beam, draught = np.ptp(mesh.vertices, axis=0).tolist()
    check_proportions(length, beam, draught)
    cover = None
    if lid:  # half of it, mirrored, since the panels of a whole one are not symmetric
        side = mesh.generate_lid().clipped(origin=(0.0, 0.0, 0.0), normal=(0.0, -1.0, 0.0))
        cover = side.join_meshes(side.mirrored('xOz'))
    panels = mesh.nb_faces + (cover.nb_faces if cover is not None else 0)
    if panels > MOST_PANELS:
        raise HullError(
            'mesh',
            f'{panels} panels',
            f'must have at most {MOST_PANELS}: memory grows with their square',
            f'Make a coarser mesh; {2 * LENGTHWAYS * DOWN} panels are enough for a fair hull.',
        )
    origin = (0.0, 0.0, 0.0)
    body = capytaine.FloatingBody(
        mesh,
        dofs=capytaine.rigid_body_dofs(rotation_center=origin),
        center_of_mass=origin,
        lid_mesh=cover,
    )
    water = {'body': body, 'water_depth': np.inf, 'g': STANDARD_GRAVITY, 'rho': 1.0}
    unit = math.sqrt(STANDARD_GRAVITY / length)
    n = len(frequencies)
    mass, damping = np.zeros((n + 2, 6, 6)), np.zeros((n + 1, 6, 6))
    force = np.zeros((n + 1, headings, 6), np.complex128)
    engine = capytaine.BEMSolver()
    beta = np.linspace(0.0, np.pi, headings)

    for row, omega in enumerate([0.0, *(unit * frequencies), np.inf]):
        for k, dof in enumerate(_DOFS):
            radiated = capytaine.RadiationProblem(omega=omega, radiating_dof=dof, **water)
            result = engine.solve(radiated)
            mass[row, :, k] = [result.added_mass[dof] for dof in _DOFS]
            if 0 < row <= n:
                damping[row, :, k] = [result.radiation_damping[dof] for dof in _DOFS]
        for column, direction in enumerate(beta if 0 < row <= n else ()):
            wave = capytaine.DiffractionProblem(omega=omega, wave_direction=direction, **water)
            pushed = capytaine.bem.airy_waves.froude_krylov_force(wave)
            scattered = engine.solve(wave).forces
            force[row, column] = [scattered[dof] + pushed[dof] for dof in _DOFS]
        if progress is not None:
            progress((row + 1) / (n + 2))
    lever = np.array([0, 0, 0, 1, 1, 1])
    powers = length ** np.add.outer(lever, lever)
    centre = mesh.center_of_buoyancy
    area, flotation, across, along = _waterplane(mesh)
    force[0, :, 2], force[0, :, 4] = area / length**2, -area * flotation / length**3
    force[1:] /= STANDARD_GRAVITY * length ** (2 + lever)
    # by symmetry forces athwart vanish in following and head seas
    force[:, [0, -1], 1::2] = 0.0
    return HullCoefficients(
        name=name,
        source=f'capytaine {version("capytaine")}, {mesh.nb_faces} panels'
        + (f' and a lid of {cover.nb_faces}' if cover is not None else ''),
        length=length,
        beam=beam,
        draught=draught,
        volume=float(mesh.disp_volume),
        buoyancy=(float(centre[0]), float(centre[2])),
        waterplane_area=area,
        flotation=flotation,
        second_moments=(across, along),
        frequency=np.concatenate([[0.0], frequencies]),
        added_mass=_even(mass / (length**3 * powers)),
        damping=_even(damping / (length**3 * unit * powers)),
        excitation=force,
    )


def _even(matrices: FloatArray) -> FloatArray:
    """Return symmetric matrices, zero between motions that a symmetric hull does not couple."""
    is_zero = np.add.outer(np.arange(6), np.arange(6)) % 2 == 1
    return np.asarray(np.where(is_zero, 0.0, 0.5 * (matrices + matrices.swapaxes(1, 2))))


def _waterplane(mesh: Any) -> tuple[float, float, float, float]:
    """Return area, centre along x, and second moments about x and y of the waterplane.

    By Gauss' theorem the integral of f(x, y) over the waterplane equals the integral of -f n_z
    over the wetted surface under it, with the outward normal n.
    """
    x, y, _ = mesh.faces_centers.T
    share = -mesh.faces_normals[:, 2] * mesh.faces_areas
    area = float(np.sum(share))
    # second moments of the panels about their own centres, by their corners
    corners = mesh.vertices[mesh.faces]
    spread = np.mean((corners - mesh.faces_centers[:, None, :]) ** 2, axis=1) / 3.0
    flotation = float(np.sum(share * x)) / area
    across = float(np.sum(share * (y**2 + spread[:, 1])))
    along = float(np.sum(share * (x**2 + spread[:, 0])))
    return area, flotation, across, along


def main(names: list[str]) -> None:
    """Make the tables of the shipped shapes again, of the named ones or of all."""
    for name in names or list(SHAPES):
        hull = compute(form_mesh(SHAPES[name], *SHIPPED), name)
        hull.save(SHAPES_FOLDER / f'{name}.npz')
        sys.stdout.write(f'{name}: {hull.source}\n')


if __name__ == '__main__':
    main(sys.argv[1:])
