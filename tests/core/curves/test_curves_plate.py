"""The plate of a cam: its costs against closed forms, its outline, its refusals."""

import math

import numpy as np
import pytest

from tauto_core.curves import Cam, CircularArc, Hole, Involute, SpringCorrected, WeightCorrected
from tauto_core.curves.cam import Pull, Setting
from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
from tauto_core.curves.drawing import (
    CheekArcs,
    Circle,
    Plate,
    cam_plate,
    cheek,
    lever_arm_as_cut,
    lever_cheek,
    plate_rates,
)
from tauto_core.scene.errors import UsageError

FORCE = Setting(4e-4, Pull(force=3.0), 9.81)
CAMS: tuple[Cam, ...] = (
    Involute(0.005),
    Hole(0.01, 0.08),
    CircularArc(0.02, 0.01),
    WeightCorrected(0.005, 0.05),
)


@pytest.mark.parametrize('cam', CAMS, ids=lambda cam: type(cam).__name__)
def test_a_thread_takes_half_its_thickness_off_the_cheek(cam: Cam) -> None:
    """Along the normal, from the first curve as round as that."""
    found = cheek(cam, 41, 1.5, 4e-4)
    psi, (x, y) = cam.psi(found.angle), cam.contact(found.angle)
    np.testing.assert_allclose((x - found.x) * np.cos(psi) + (y - found.y) * np.sin(psi), 2e-4)
    np.testing.assert_allclose(np.hypot(x - found.x, y - found.y), 2e-4)
    if not cam.kinked:
        assert float(cam.radius_of_curvature(found.angle[0])) == pytest.approx(2e-4, rel=1e-9)


def test_each_cheek_of_a_lever_is_cut_back_likewise() -> None:
    shape = CorrectedLeverGeometry(4e-4, 6.0, 0.0736, 1.1e-3, 0.1, 0.3)
    for end in (-0.5, 0.5):
        found = lever_cheek(shape, end, 41, 4e-4)
        tau = shape.tau_of(found.angle)
        x, y = shape.contact(tau)
        u = shape.pose(tau).u
        normal = np.sign(end) * ((x - found.x) * np.cos(u) + (y - found.y) * np.sin(u))
        np.testing.assert_allclose(normal, 2e-4, rtol=1e-9)
        assert float(shape.radius_of_curvature(tau[:1])[0]) == pytest.approx(2e-4, rel=1e-6)


def test_the_cusp_costs_what_its_expansion_says() -> None:
    """Up to θ₀ = e/2r the thread bends round the edge, δt = r (x − sin x), x = θ₀ − θ.

    To first order δω/ω = 2/(π r A²) ∫ δt θ dθ/√(A² − θ²) = θ₀⁵/(60 π A³), with relative errors of
    θ₀² and (θ₀/A)². 0.018 s/day at 0.2 rad is the published figure of 0.5 mm on 5 mm.
    """
    plate = cam_plate(Involute(0.005), 1.5, thread_mm=0.5)
    swings = np.array([0.2, 0.5, 1.0])
    found = plate_rates(plate, Involute(0.005), FORCE, swings).edge
    np.testing.assert_allclose(found, 86400.0 * 0.05**5 / (60.0 * math.pi * swings**3), rtol=0.05)
    assert found[0] == pytest.approx(0.018, abs=5e-4)


@pytest.mark.parametrize(
    'setting',
    [FORCE, Setting(4e-4, Pull(0.2, 0.2), 9.81), Setting(4e-4, Pull(0.0, 0.0, 2.0, 30.0), 9.81)],
    ids=['force', 'weight', 'spring'],
)
def test_a_micrometre_costs_what_the_exact_period_says(setting: Setting) -> None:
    """Against the energy integral by adaptive quadrature, of both lever arms."""
    from scipy.integrate import quad

    def period(loss: float, amplitude: float) -> float:
        force, pull = setting.pull.at_rest(setting.gravity), setting.pull

        def integrand(phase: float) -> float:
            # θ = A sin φ, A − θ = 2 A sin²(¼π − ½φ) without cancellation
            near = 2.0 * amplitude * math.sin(0.25 * math.pi - 0.5 * phase) ** 2
            angle = amplitude - near
            lift = 0.0025 * angle**2 - loss * angle
            drop = near * (0.0025 * (amplitude + angle) - loss)
            energy = drop * (force + 0.5 * pull.stiffness * (2.0 * lift + drop))
            arm = 0.005 * angle - loss
            mass = setting.inertia + pull.carried_mass * arm * arm
            return math.sqrt(0.5 * mass / energy) * amplitude * math.cos(phase)

        return 4.0 * quad(integrand, 0.0, 0.5 * math.pi - 1e-9, epsabs=0.0, epsrel=1e-12)[0]

    plate = cam_plate(Involute(0.005), 1.5, thread_mm=0.5)
    found = plate_rates(plate, Involute(0.005), setting, np.array([0.2, 1.0])).one_micrometre
    # the integral lacks its last nanoradian, which both periods do
    wanted = [86400.0 * (period(0.0, a) / period(1e-6, a) - 1.0) for a in (0.2, 1.0)]
    np.testing.assert_allclose(found, wanted, rtol=1e-5)


@pytest.mark.parametrize('tolerance', [1e-3, 1e-5])
@pytest.mark.parametrize('cam', CAMS, ids=lambda cam: type(cam).__name__)
def test_the_lever_arm_as_cut_is_within_the_tolerance(cam: Cam, tolerance: float) -> None:
    plate = cam_plate(cam, 1.5, thread_mm=0.4, cutter_mm=0.25, tolerance_mm=tolerance)
    angle = np.linspace(plate.acts_from_rad, 1.5, 5001)[:-1]
    wrong = 1e3 * np.abs(lever_arm_as_cut(plate, cam, angle) - cam.lever_arm(angle))
    # a hole turns an error of the support function by the factor 1/(1 − p/s) into one of the arm
    limit = 1.01 * tolerance * (1.3 if isinstance(cam, Hole) else 1.0)
    assert np.max(wrong) <= limit


@pytest.mark.parametrize('cam', CAMS, ids=lambda cam: type(cam).__name__)
def test_the_cutter_is_half_its_width_from_the_plate(cam: Cam) -> None:
    plate = cam_plate(cam, 1.5, thread_mm=0.4, cutter_mm=0.3)
    assert plate.tool is not None
    path = np.array(plate.tool.polygon(1e-5))[:, ::7]
    edge = np.array(plate.outline.polygon(1e-5))
    start = edge[0] + 1j * edge[1]
    side = np.roll(start, -1) - start
    apart = []
    for point in path[0] + 1j * path[1]:
        along = np.clip(((point - start) * side.conj()).real / np.abs(side) ** 2, 0.0, 1.0)
        apart.append(np.min(np.abs(point - start - along * side)))
    np.testing.assert_allclose(apart, 0.15, atol=3e-5)
    turns = np.sum(np.angle(np.roll(path[0] + 1j * path[1], -1) / (path[0] + 1j * path[1])))
    assert turns == pytest.approx(math.tau)
    assert [hole.radius for hole in plate.tool_holes] == pytest.approx(
        [hole.radius - 0.15 for hole in plate.holes]
    )


def made(**changes: float | None) -> Plate:
    asked = {'reach_rad': 1.5, 'thread_mm': 0.5, **changes}
    return cam_plate(Involute(0.005), **asked)


@pytest.mark.parametrize(
    ('changes', 'words'),
    [
        ({'cutter_mm': 0.6}, r'cutter_mm = 0\.6 mm: .*radius of 0\.3 mm .* 0\.2499 mm.*0\.5 mm'),
        ({'cutter_mm': -1.0}, r'cutter_mm = -1\.0: must be ≥ 0 mm'),
        ({'cutter_mm': 0.4, 'pins_mm': 0.3}, r'does not cut a hole of 0\.3 mm.*larger pins_mm='),
        ({'bore_mm': 9.0}, r'bore_mm = 9 mm: .*room for 4\.5 mm'),
        ({'bore_mm': 0.0}, r'bore_mm = 0\.0: must be > 0 mm'),
        (
            {'pin_circle_mm': 12.0},
            r'pins_mm = 1\.5 mm: .*\(-10\.39, -6\).*another place: pins_mm=',
        ),
        ({'pin_circle_mm': 9.0, 'pins_mm': 1.5}, r'pins_mm = 1\.5 mm: .*room for 0 mm'),
        ({'slot_mm': 4.0}, r'bore_mm = 2\.5 mm: .*would not leave 0\.2 mm'),
        ({'thread_mm': 0.0}, r'thread_mm = 0\.0: must be > 0 mm'),
        ({'thread_mm': math.nan}, r'thread_mm = nan: must be > 0 mm'),
        ({'tolerance_mm': 0.0}, r'tolerance_mm = 0\.0: must be 1e-06 to 1 mm'),
        ({'reach_rad': 4.6}, r'reach_rad = 4\.6 rad: the cheeks cross at 4\.49341 rad'),
    ],
)
def test_what_cannot_be_cut_is_refused(changes: dict[str, float], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        made(**changes)


def test_the_remedies_of_the_refusals_work() -> None:
    assert made(cutter_mm=0.5).cutter == 0.5
    assert made(bore_mm=4.4, pin_circle_mm=5.0).holes[0].radius == 2.2
    assert made(reach_rad=4.49).reach_rad == 4.49


def test_a_circle_is_flattened_within_the_sagitta() -> None:
    x, y = Circle('BORE', 0.0, 0.0, 2.0).path.polygon(1e-6)
    np.testing.assert_allclose(np.hypot(x, y), 2.0, rtol=1e-14)
    middle = 0.5 * np.hypot(x + np.roll(x, -1), y + np.roll(y, -1))
    assert 0.0 < 2.0 - np.min(middle) <= 1e-6


def test_a_circular_cheek_is_as_many_arcs_as_a_biarc_has() -> None:
    plate = cam_plate(CircularArc(0.02, 0.01), 1.0, thread_mm=0.4)
    assert isinstance(plate.cheek, CheekArcs)
    np.testing.assert_allclose(plate.cheek.radius, [19.8, 19.8], rtol=1e-9)
    np.testing.assert_allclose(plate.cheek.centre, [-20.0 + 10.0j] * 2, atol=1e-8)


def test_a_thread_that_no_cheek_can_guide_is_refused() -> None:
    assert cheek(Involute(0.01), 10, 7.0, 0.5e-3).angle[-1] == 7.0
    with pytest.raises(UsageError, match='nowhere as round'):
        cheek(CircularArc(0.02, 0.01), thread_thickness=0.05)
    with pytest.raises(UsageError, match='hollow from its tip'):
        cheek(SpringCorrected(0.01, 200.0))
