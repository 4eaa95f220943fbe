"""Wheel, cheeks and axle as solids, measured by trimesh. Needs the extra `cad`."""

from __future__ import annotations

import math
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tauto_core.curves.drawing import Plate
from tauto_core.plots.cutting import plate_of
from tauto_core.plots.solids import CadError, check_solids, rim_radius, write_solids
from tauto_core.scene import load_scene
from tauto_core.scene.errors import UsageError

BRASS = 8500e-9  # kg/mm³
INERTIA = 4e-4


@pytest.fixture(scope='module')
def made() -> Plate:
    return plate_of(load_scene('measured'))


@pytest.fixture(scope='module')
def meshes(made: Plate, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    pytest.importorskip('build123d', reason="the extra 'cad' is not installed")
    trimesh = pytest.importorskip('trimesh', reason="the extra 'cad' is not installed")
    folder = tmp_path_factory.mktemp('solids')
    files = write_solids(made, 'measured', INERTIA, 2.0, folder / 'all.step', folder / 'stl')
    assert {file.name for file in files} == {'all.step', 'axle.stl', 'cheeks.stl', 'wheel.stl'}
    return {file.stem: trimesh.load(file) for file in files if file.suffix == '.stl'}


def test_the_meshes_are_closed_and_have_the_inertia_of_the_scene(meshes: dict[str, Any]) -> None:
    assert all(mesh.is_watertight for mesh in meshes.values())
    assert all(mesh.volume > 0.0 for mesh in meshes.values())
    inertia = 0.0
    for mesh in meshes.values():
        mesh.density = BRASS
        about = mesh.moment_inertia[2, 2]
        x, y, _ = mesh.center_mass
        inertia += 1e-6 * (about + mesh.mass * (x * x + y * y))
    # facets of a micrometre's sagitta lose 4·1e-3/60 of the rim
    assert inertia == pytest.approx(INERTIA, rel=2e-4)


def test_the_lever_arm_rebuilt_from_the_stl(meshes: dict[str, Any], made: Plate) -> None:
    """Within the tolerance of the outline, of the facets, and STL's 24 bits."""
    points = meshes['cheeks'].vertices
    # the part that the thread can touch from the slot
    left = points[(points[:, 0] < 0.0) & (points[:, 1] > 4.0), :2]
    angle = np.linspace(made.acts_from_rad, 1.49, 500)
    arm = 0.25 + np.array([np.max(left @ [math.cos(a), math.sin(a)]) for a in angle])
    wrong = arm - 5.0 * angle
    assert np.max(np.abs(wrong)) < 2.5 * made.tolerance


def test_the_step_file_holds_three_named_solids(
    meshes: dict[str, Any], made: Plate, tmp_path: Path
) -> None:
    build123d = pytest.importorskip('build123d')
    file = tmp_path / 'all.step'
    write_solids(made, 'measured', INERTIA, 2.0, file, None)
    read = build123d.import_step(file)
    solids = {child.label: child for child in read.children}
    assert sorted(solids) == ['axle', 'cheeks', 'wheel']
    for name, solid in solids.items():
        assert solid.volume == pytest.approx(meshes[name].volume, rel=1e-3)
    # the plate is 2 mm thick, on the web
    box = solids['cheeks'].bounding_box()
    np.testing.assert_allclose([box.min.Z, box.max.Z], [0.0, 2.0], atol=1e-6)


def test_a_wheel_lighter_than_its_cheeks_is_refused(made: Plate) -> None:
    with pytest.raises(UsageError, match=r'thickness_mm = 20 mm: .* the scene has 1e-07 kg m2'):
        rim_radius(made, 1e-7, 20.0)


@pytest.mark.parametrize('thickness', [0.0, math.nan, 200.0])
def test_an_absurd_thickness_is_refused(thickness: float) -> None:
    with pytest.raises(UsageError, match=r'thickness_mm = .*: must be 0\.1 to 100 mm'):
        check_solids(thickness)


def test_without_the_extra_nothing_is_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> str:
        raise PackageNotFoundError(name)

    monkeypatch.setattr('tauto_core.plots.solids.version', missing)
    with pytest.raises(CadError, match=r"build123d.*pip install 'tauto_core\[cad\]'"):
        check_solids(2.0)
