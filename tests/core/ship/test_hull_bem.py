"""Coefficients of a hull from boundary elements: panels and refusals. `test_hull` has the rest."""

import math
import sys

import numpy as np
import pytest

from tauto_core.ship import hull_bem
from tauto_core.ship.hull import HullError, Shape, hull_of_file

WIGLEY = Shape(10.0, 1.0, 0.625, 4.0 / 9.0)


def test_without_capytaine_the_error_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, 'capytaine', None)
    with pytest.raises(HullError, match=r"capytaine.*Run pip install 'tauto_core\[hull\]'"):
        hull_bem.form_mesh(WIGLEY)


def test_a_form_is_refused_before_capytaine_is_looked_for(monkeypatch):
    monkeypatch.setitem(sys.modules, 'capytaine', None)
    with pytest.raises(HullError, match=r'length = 440.0: must be in \[2, 400\] m'):
        hull_bem.form_mesh(Shape(440.0, 126.0, 50.0, 0.59))


class TestWithCapytaine:
    @pytest.fixture(autouse=True)
    def _capytaine(self):
        pytest.importorskip('capytaine')

    def write(self, path, mesh):
        """Write panels in NEMOH's format, which needs no other library."""
        lines = ['2 0']
        lines += [f'{k} {x} {y} {z}' for k, (x, y, z) in enumerate(mesh.vertices, start=1)]
        lines += ['0 0 0 0']
        lines += [' '.join(str(k + 1) for k in face) for face in mesh.faces]
        lines += ['0 0 0 0']
        path.write_text('\n'.join(lines) + '\n')

    def test_wigleys_panels_have_its_volume_and_waterplane(self):
        mesh = hull_bem.form_mesh(WIGLEY, 40, 20)
        volume = 4.0 / 9.0 * 10.0 * 1.0 * 0.625
        assert np.array(mesh.volumes) == pytest.approx(volume, rel=3e-3)
        area, flotation, across, along = hull_bem._waterplane(mesh)
        assert area == pytest.approx(2.0 / 3.0 * 10.0, rel=2e-3)
        assert abs(flotation) < 1e-12
        # integrals of y = (1 - u^2)/2 by hand: y^3 and x^2 y over the length
        assert across == pytest.approx(2.0 / 3.0 * 5.0 * 0.125 * 32.0 / 35.0, rel=5e-3)
        assert along == pytest.approx(1000.0 / 8.0 * 4.0 / 15.0, rel=5e-3)

    def test_a_coarse_hull_has_the_coefficients_of_a_hull(self, tmp_path):
        """Few panels and frequencies: hydrostatics, symmetry, Haskind's relation to 10 %."""
        shares: list[float] = []
        found = hull_bem.compute(
            hull_bem.form_mesh(WIGLEY, 14, 4),
            'Wigley',
            frequencies=np.linspace(0.6, 3.0, 8),
            headings=13,
            progress=shares.append,
        )
        assert shares[-1] == 1.0
        assert shares == sorted(shares)
        assert found.block == pytest.approx(4.0 / 9.0, rel=0.05)
        assert found.added_mass.shape == (10, 6, 6)
        assert np.abs(found.excitation[0, :, 2] - found.waterplane_area / 100.0).max() < 1e-12
        radiated = found.radiated_damping()
        for j in (1, 2, 4):
            own = found.damping[:, j, j]
            np.testing.assert_allclose(radiated[:, j, j], own, atol=0.1 * own.max())
        found.save(tmp_path / 'wigley.npz')
        assert 'capytaine' in hull_of_file((tmp_path / 'wigley.npz').read_bytes(), 'x').source

    def test_a_file_is_the_hull_wherever_its_zero_is(self, tmp_path):
        mesh = hull_bem.form_mesh(WIGLEY, 12, 4)
        self.write(tmp_path / 'ship.nemoh', mesh.translated_x(7.0))
        read = hull_bem.read_mesh(tmp_path / 'ship.nemoh')
        assert read.disp_volume == pytest.approx(mesh.disp_volume)
        assert read.vertices[:, 0].min() == pytest.approx(-5.0)

    def test_meshes_that_are_no_hull_are_refused(self, tmp_path):
        mesh = hull_bem.form_mesh(WIGLEY, 12, 4)
        cases = {
            'up.nemoh': (mesh.translated_z(3.0), 'is dry: all of it is above z = 0'),
            'side.nemoh': (mesh.translated_y(2.0), 'must have equal sides about y = 0'),
            'half.nemoh': (
                mesh.extract_faces(np.arange(mesh.nb_faces // 2)),
                'must have equal sides about y = 0. Draw both sides',
            ),
            'inwards.nemoh': (_changed(mesh, 1.0, turned=True), 'must be closed under water'),
        }
        for name, (content, words) in cases.items():
            self.write(tmp_path / name, content)
            with pytest.raises(HullError, match=words):
                hull_bem.read_mesh(tmp_path / name)
        (tmp_path / 'words.nemoh').write_text('no mesh\n')
        with pytest.raises(HullError, match='cannot be read'):
            hull_bem.read_mesh(tmp_path / 'words.nemoh')
        with pytest.raises(HullError, match='there is no such file'):
            hull_bem.read_mesh(tmp_path / 'none.nemoh')

    def test_hulls_are_refused_before_anything_is_solved(self, monkeypatch):
        mesh = hull_bem.form_mesh(WIGLEY, 14, 4)
        with pytest.raises(HullError, match='length = 440'):
            hull_bem.compute(_changed(mesh, 44.0), 'x')
        monkeypatch.setattr(hull_bem, 'MOST_PANELS', 100)
        with pytest.raises(HullError, match='must have at most 100'):
            hull_bem.compute(mesh, 'Wigley')


def _changed(mesh, size, *, turned=False):
    """Return a mesh of another size, or with its panels facing inwards."""
    import capytaine

    faces = mesh.faces[:, ::-1] if turned else mesh.faces
    return capytaine.Mesh(vertices=size * mesh.vertices, faces=faces)


def test_the_frequencies_reach_from_long_waves_to_short_ones():
    lengths = math.tau / hull_bem.FREQUENCIES**2
    assert lengths[0] == pytest.approx(70.0, rel=0.01)
    assert lengths[-1] == pytest.approx(0.27, rel=0.02)
