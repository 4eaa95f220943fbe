"""The motions of a ship in waves from the coefficients of a hull (hull.md)."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tauto_core.curves.numerics import trapezoid
from tauto_core.scene.times import STANDARD_GRAVITY
from tauto_core.ship import hull as hulls
from tauto_core.ship.hull import (
    SHAPES,
    ClockPlace,
    Hull,
    HullError,
    hull_of_file,
    named_hull,
    rate_by_place,
)
from tauto_core.ship.sea import bretschneider, roll_answer
from tauto_core.ship.sections import Roll, cutoff_for
from tauto_core.ship.waves import Encounter, Harmonics

HEADINGS = (0.0, 0.4, 0.5 * math.pi, 2.2, math.pi, -1.0, 5.5)


def standard_sea(omega):
    return bretschneider(omega, 2.5, 9.0)


@pytest.fixture(scope='module')
def deptford():
    return named_hull('deptford')


@pytest.fixture(scope='module')
def ship(deptford):
    """The ship of the table in hull.md: centre of gravity in the waterline."""
    return Hull(deptford, 11.0, 0.08, centre_of_gravity=0.0)


@pytest.fixture(scope='module', params=SHAPES)
def any_ship(request):
    hull = named_hull(request.param)
    return Hull(hull, 3.1 * math.sqrt(hull.beam), 0.08)


def unit(ship):
    """Return sqrt(g/L) [rad/s]."""
    return math.sqrt(ship.gravity / ship.coefficients.length)


@pytest.mark.parametrize('heading', HEADINGS)
def test_a_long_wave_moves_the_ship_with_its_surface(any_ship, heading):
    """But for the panels: their sum is 1.5 % off in pitch, 4 % in roll, a small difference."""
    omega = unit(any_ship) * np.array([0.02])
    found = any_ship.response(omega, heading).motions[0]
    slope = -1j * omega[0] ** 2 / any_ship.gravity
    assert found[2] == pytest.approx(1.0, abs=1e-3)
    assert found[3] == pytest.approx(slope * math.sin(heading), abs=0.05 * abs(slope))
    assert found[4] == pytest.approx(-slope * math.cos(heading), abs=0.03 * abs(slope))
    # water moves in circles, and the ship with it
    assert found[0] == pytest.approx(-1j * math.cos(heading), abs=0.015)
    assert found[1] == pytest.approx(-1j * math.sin(heading), abs=0.015)


def test_a_short_wave_leaves_the_ship_at_rest(any_ship):
    omega = unit(any_ship) * np.array([4.8, 10.0, 40.0, 400.0])
    for heading in HEADINGS:
        size = np.abs(any_ship.response(omega, heading).accelerations(ClockPlace())).max(axis=1)
        assert size[2] < 0.5 * size[0] + 1e-12 * size.max()
        assert size[3] < 0.02 * max(size[0], 1e-3)


def test_the_response_does_not_jump_where_the_table_ends(any_ship):
    hull = any_ship.coefficients
    for edge in (hull.frequency[1], hull.frequency[-1]):
        omega = unit(any_ship) * edge * np.array([1.0 - 1e-7, 1.0 + 1e-7])
        for heading in HEADINGS:
            before, after = any_ship.response(omega, heading).motions
            np.testing.assert_allclose(after, before, atol=1e-5 * np.abs(before).max())


def test_both_sides_are_mirror_images(ship):
    omega = unit(ship) * np.linspace(0.2, 6.0, 25)
    mirror = np.array([1, -1, 1, -1, 1, -1])
    for heading, speed in ((0.3, 0.0), (1.2, 2.0), (2.9, 4.0)):
        port = ship.response(omega, heading, speed).motions
        starboard = ship.response(omega, -heading, speed).motions
        np.testing.assert_allclose(starboard, port * mirror, atol=1e-13)
        np.testing.assert_allclose(
            ship.response(omega, heading + math.tau, speed).motions, port, atol=1e-10
        )


def test_a_place_forward_sinks_as_the_bow_does(ship):
    response = ship.response(np.array([0.7]), math.pi)
    x, y, z = response.displacement(ClockPlace(10.0, 0.0, 2.0))[0]
    surge, _, heave, _, pitch, _ = response.motions[0]
    assert z == pytest.approx(heave - 10.0 * pitch)
    assert x == pytest.approx(surge + 2.0 * pitch)
    assert abs(y) < 1e-12
    roll, yaw, sway = (ship.response(np.array([0.7]), 1.0).motions[0, j] for j in (3, 5, 1))
    turned = ship.response(np.array([0.7]), 1.0).displacement(ClockPlace(10.0, 3.0, 2.0))[0]
    assert turned[1] == pytest.approx(sway + 10.0 * yaw - 2.0 * roll)


# fmt: off
TABLE = (  # heading, forward, up, heave, athwart, fore and aft, vertical, freely, pitching
    (180, 0.0, 0.0, -10.6, 0.0, 11.7, -10.6, 1.1, -19.2),
    (180, 5.0, 1.0, -19.5, 0.0, 9.1, -19.5, -10.4, -37.7),
    (180, 12.0, 3.0, -53.8, 0.0, 7.0, -53.8, -46.8, -91.0),
    (135, 5.0, 1.0, -27.9, 8.5, 6.3, -19.4, -13.1, -34.4),
    (90, 0.0, 0.0, -38.8, 26.3, 0.0, -12.4, -12.4, -12.4),
    (90, 12.0, 3.0, -38.8, 30.7, 0.0, -8.1, -8.1, -8.1),
)
# fmt: on


@pytest.mark.parametrize('row', TABLE)
def test_the_rate_of_a_weight_by_heading_and_place(ship, row):
    """Within 5 %, or 0.6 s/day: so far the two programs agree."""
    degrees, forward, up, *wanted = row
    [found] = rate_by_place(
        ship, standard_sea, headings=[math.radians(degrees)], places=[ClockPlace(forward, 0.0, up)]
    )
    parts = (found.heave, found.athwart, found.fore_and_aft)
    totals = (found.kept_vertical, found.leaning_freely, found.pitching)
    for value, other in zip((*parts, *totals), wanted, strict=True):
        assert value == pytest.approx(other, rel=0.05, abs=0.6)


def test_the_speed_terms_bring_159_to_179_seconds(ship, monkeypatch):
    """12 m forward at 5 knots into the sea (hull.md)."""
    knots = 5.0 * 1852.0 / 3600.0

    def heave():
        [found] = rate_by_place(
            *(ship, standard_sea),
            headings=[math.pi],
            places=[ClockPlace(12.0, 0.0, 3.0)],
            speed=knots,
        )
        return found.heave

    assert heave() == pytest.approx(-179.0, abs=1.0)
    with_terms = Hull._fluid
    monkeypatch.setattr(Hull, '_fluid', lambda self, w, _drift: with_terms(self, w, np.zeros(1)))
    assert heave() == pytest.approx(-159.0, abs=1.0)


def test_weights_change_the_rate_as_hull_md_says(deptford):
    """k_yy 0.22, 0.25, 0.28 L in head seas, z_G -1, 1 m in beam seas (hull.md)."""
    place = [ClockPlace(12.0, 0.0, 3.0)]
    for k_yy, wanted in ((0.22, -36.0), (0.25, -54.0), (0.28, -76.0)):
        ship = Hull(deptford, 11.0, 0.08, centre_of_gravity=0.0, k_yy=k_yy * 44.0)
        [found] = rate_by_place(ship, standard_sea, headings=[math.pi], places=place)
        assert found.heave == pytest.approx(wanted, abs=1.0)
    for z_g, wanted in ((-1.0, 46.0), (1.0, 22.0)):
        ship = Hull(deptford, 11.0, 0.08, centre_of_gravity=z_g)
        [found] = rate_by_place(ship, standard_sea, headings=[0.5 * math.pi], places=place)
        assert found.athwart == pytest.approx(wanted, abs=1.0)


@pytest.mark.parametrize(('period', 'height'), [(5.0, 1.0), (12.0, 4.0)])
@pytest.mark.parametrize('degrees', [0, 110, 180])
def test_the_default_cutoff_doubled_changes_no_rate(any_ship, degrees, period, height):
    """1 % of the rate in each plane, or 0.2 % of its parts, scaled to the energy of the sea."""
    length = any_ship.coefficients.length
    places = [ClockPlace(), ClockPlace(0.27 * length, 0.0, 0.07 * length)]
    most, rates = cutoff_for(length, period), []
    for cut in (most, 2.0 * most):
        omega = math.tau / period * np.geomspace(0.5, cut, 4000)
        found = rate_by_place(
            *(any_ship, lambda at: bretschneider(at, height, period)),
            headings=[math.radians(degrees)],
            places=places,
            omega=omega,
        )
        energy = trapezoid(bretschneider(omega, height, period), omega)
        rates.append([(each, height**2 / 16.0 / energy) for each in found])
    for (less, scale), (more, rescale) in zip(*rates, strict=True):
        parts = abs(more.heave) + more.athwart + more.fore_and_aft
        for plane in ('kept_vertical', 'leaning_freely', 'pitching'):
            rate = rescale * getattr(more, plane)
            assert scale * getattr(less, plane) == pytest.approx(rate, rel=0.01, abs=2e-3 * parts)


def test_a_shape_scales_by_froude(deptford):
    """Twice as long in waves twice as long: the same motion, half the angle, exactly."""
    small, large = (Hull(deptford.scaled(x), 11.0 * math.sqrt(x / 44.0), 0.08) for x in (44, 88))
    assert large.coefficients.volume == 8.0 * small.coefficients.volume
    omega = np.linspace(0.2, 2.6, 20)
    for heading in HEADINGS:
        one = small.response(omega, heading, 2.0)
        other = large.response(omega / math.sqrt(2.0), heading, 2.0 * math.sqrt(2.0))
        scale = np.array([1, 1, 1, 2, 2, 2])
        np.testing.assert_allclose(other.motions * scale, one.motions, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(
            *(2.0 * other.accelerations(ClockPlace(2.0, 1.0, 1.0)),),
            one.accelerations(ClockPlace(1.0, 0.5, 0.5)),
            rtol=1e-9,
            atol=1e-12,
        )


def test_the_roll_period_gives_the_centre_of_gravity(any_ship):
    hull = any_ship.coefficients
    metacentre = hull.second_moments[0] / hull.volume + hull.buoyancy[1]
    assert any_ship.z_g == pytest.approx(metacentre - any_ship.gm, rel=1e-12)
    # the roll peaks at its period
    omega = np.linspace(0.5, 2.0, 3001) * math.tau / any_ship.roll_period
    weak = replace(any_ship, roll_damping_ratio=0.01)
    slope = omega**2 / weak.gravity
    roll = np.abs(weak.response(omega, 0.5 * math.pi).motions[:, 3]) / slope
    assert math.tau / omega[np.argmax(roll)] == pytest.approx(any_ship.roll_period, rel=0.03)


@pytest.mark.parametrize('name', SHAPES)
def test_damping_obeys_haskinds_relation_and_gives_no_energy(name):
    """Within 3.5 %, the error of the panels. Negative is only their noise, 1e-3 of the largest."""
    hull = named_hull(name)
    largest = np.sqrt(np.diagonal(hull.damping, axis1=1, axis2=2).max(axis=0))
    assert np.linalg.eigvalsh(hull.damping / np.outer(largest, largest)).min() > -1e-3
    radiated = hull.radiated_damping()
    for j in range(6):
        own, other = hull.damping[:, j, j], radiated[:, j, j]
        np.testing.assert_allclose(other, own, atol=0.035 * own.max())
        kept = own > 0.3 * own.max()
        np.testing.assert_allclose(other[kept], own[kept], rtol=0.035)


@pytest.mark.parametrize('heading', [0.5 * math.pi, 1.5 * math.pi])
def test_long_waves_roll_the_ship_as_the_roll_equation(deptford, heading):
    """Signs and phases of sea.md, with a slope coefficient of nearly 1."""
    ship = Hull(deptford, 11.0, 0.08)
    omega = np.array([0.15, 0.2, 0.25])
    waves = Harmonics(np.ones(3), math.tau / omega, np.array([0.3, 1.0, 5.0]))
    encounter = Encounter(0.0, heading, STANDARD_GRAVITY)
    roll = Roll(natural_period=11.0, damping_ratio=0.08, slope_coefficient=1.0)
    wanted = roll_answer(waves, roll, encounter)
    factors = ship.response(omega, heading).motions[:, 3]
    found = encounter.answer(waves, np.abs(factors), np.angle(factors))
    np.testing.assert_allclose(np.exp(1j * (found.phase - wanted.phase)), 1.0, atol=0.01)
    np.testing.assert_allclose(found.amplitude, wanted.amplitude, rtol=0.1)


def test_a_sum_of_waves_has_the_mean_squares_of_the_spectrum(ship):
    """Accelerations by the harmonics of each place have the mean squares of the integral."""
    random = np.random.default_rng(3)
    edges = np.linspace(0.3, 3.0, 1201)
    omega = edges[:-1] + np.diff(edges) * random.random(1200)
    amplitude = np.sqrt(2.0 * standard_sea(omega) * np.diff(edges))
    waves = Harmonics(amplitude, math.tau / omega, math.tau * random.random(1200))
    place, heading, speed = ClockPlace(5.0, 1.0, 2.0), 2.5, 2.0
    encounter = Encounter(speed, heading, STANDARD_GRAVITY)
    factors = ship.response(omega, heading, speed).displacement(place)
    [rate] = rate_by_place(ship, standard_sea, headings=[heading], places=[place], speed=speed)
    scale = 86_400.0 / STANDARD_GRAVITY**2 * np.array([1 / 4, 1 / 4, -1 / 8])
    wanted = (rate.fore_and_aft, rate.athwart, rate.heave)
    for column in range(3):
        factor = factors[:, column]
        moved = encounter.answer(waves, amplitude * np.abs(factor), np.angle(factor))
        mean_square = 0.5 * np.sum((moved.amplitude * moved.angular_frequency**2) ** 2)
        assert scale[column] * mean_square == pytest.approx(wanted[column], rel=0.02)


def test_motions_are_bounded_at_zero_encounter_frequency(ship):
    """In following seas omega_e passes zero: motions stay bounded, accelerations vanish."""
    speed = 5.0
    still = STANDARD_GRAVITY / speed
    omega = still * np.array([0.5, 0.9, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.1, 2.0])
    response = ship.response(omega, 0.0, speed)
    assert np.all(np.isfinite(response.motions))
    assert np.all(np.abs(response.accelerations(ClockPlace(12.0, 0.0, 3.0))[2:5]) < 1e-8)
    assert np.abs(response.motions[:, :3]).max() < 2.0
    before, after = response.motions[2], response.motions[4]
    # whichever way the wave creeps
    np.testing.assert_allclose(after, before, atol=1e-6)
    edge = STANDARD_GRAVITY / speed * (1.0 - hulls.LEAST_ENCOUNTER)
    before, after = ship.response(edge * np.array([1.0 - 1e-7, 1.0 + 1e-7]), 0.0, speed).motions
    np.testing.assert_allclose(after, before, atol=1e-4)


def test_heave_is_static_at_zero_encounter_frequency(ship):
    """C X = F, apart from the force of radiated waves."""
    hull, speed = ship.coefficients, 5.0
    omega = np.array([STANDARD_GRAVITY / speed])
    heave = ship.response(omega, 0.0, speed).motions[0, 2]
    force = ship._force(omega / unit(ship), 0.0)[0, 2]
    static = force.conj() * hull.length**2 / hull.waterplane_area
    assert heave == pytest.approx(static, rel=0.02)


def test_overtaken_waves_are_damped_as_well(ship):
    """Beyond omega_e = 0 damping takes energy too: at the roll's resonance more means less."""
    omega = np.linspace(2.7, 3.0, 50)
    weak, strong = (
        np.abs(
            replace(ship, roll_damping_ratio=ratio).response(omega, 0.6, 5.0).motions[:, 3]
        ).max()
        for ratio in (0.04, 0.16)
    )
    assert np.all(ship.response(omega, 0.6, 5.0).encounter < 0.0)
    assert strong < 0.6 * weak


def test_a_file_holds_the_hull(tmp_path, deptford):
    deptford.save(tmp_path / 'mine.npz')
    read = hull_of_file((tmp_path / 'mine.npz').read_bytes(), 'mine.npz')
    assert (read.name, read.source, read.volume) == (
        deptford.name,
        deptford.source,
        deptford.volume,
    )
    for table in ('frequency', 'added_mass', 'damping', 'excitation'):
        np.testing.assert_array_equal(getattr(read, table), getattr(deptford, table))
    before = (tmp_path / 'mine.npz').read_bytes()
    read.save(tmp_path / 'mine.npz')
    assert (tmp_path / 'mine.npz').read_bytes() == before


@pytest.mark.parametrize('name', SHAPES)
def test_a_shipped_table_is_that_of_its_shape(name):
    shape, hull = SHAPES[name], named_hull(name)
    assert (hull.length, hull.beam, hull.draught) == pytest.approx(
        (shape.length, shape.beam, shape.draught)
    )
    assert hull.block == pytest.approx(shape.block, rel=0.01)
    p, _ = shape.exponents()
    area = p / (p + 1.0) * shape.length * shape.beam
    assert hull.waterplane_area == pytest.approx(area, rel=0.01)


@pytest.mark.parametrize(
    ('content', 'words'),
    [
        (b'', 'it is not an .npz file'),
        (b'PK\x03\x04 and then nothing', 'it is not an .npz file, or it is damaged'),
        (b'heading,roll\n1,2\n', 'it is not an .npz file, or it is damaged'),
        ({'format': 1, 'name': 'x'}, 'lacks source, sizes'),
        ({'format': 2}, 'has the format 2; this version reads 1'),
        ({'sizes': [1.0, 2.0]}, 'is not a hull'),
        ({'frequency': [0.0, 0.2, 0.1]}, 'must have the shape'),
        ({'damping': np.full((32, 6, 6), np.nan)}, 'must be finite'),
        ({'excitation': np.zeros((32, 2, 6), complex)}, '7 headings are needed'),
    ],
)
def test_a_file_that_is_no_hull_is_refused(tmp_path, deptford, content, words):
    path = tmp_path / 'bad.npz'
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        deptford.save(path)
        held = dict(np.load(path))
        held = content if 'name' in content else held | content
        np.savez(path, **held)
    with pytest.raises(HullError, match=words):
        hull_of_file(path.read_bytes(), str(path))


@pytest.mark.parametrize(
    ('refused', 'words'),
    [
        (lambda hull: ship_of(hull, roll_period=0.0), 'roll_period = 0.0: must be above 0 s'),
        (lambda hull: ship_of(hull, roll_period=2.0), 'roll_period = 2.0: .*rolls in some 11 s'),
        (lambda hull: ship_of(hull, roll_damping_ratio=8.0), r'ratio = 8.0: must be in \[0, 1\)'),
        (lambda hull: ship_of(hull, k_yy=50.0), r'k_yy = 50.0: must be in \[4.4, 26.4\] m'),
        (lambda hull: ship_of(hull, k_xx=0.38), r'k_xx = 0.38: must be in \[1.26, 7.56\] m'),
        (lambda hull: ship_of(hull, centre_of_gravity=30.0), '= 30.0: puts the centre of gravity'),
        (lambda hull: ship_of(hull).check_speed(6.0), r'= 6.0: must be in \[0, 5.19\] m/s .*0.25'),
        (lambda hull: ship_of(hull).check_speed(math.nan), 'speed = nan'),
        (lambda hull: at_place(hull, 23.0, 0.0, 0.0), r'd = 23.0: must be in \[-22, 22\] m'),
        (lambda hull: at_place(hull, 0.0, -7.0, 0.0), 'clock.port = -7.0'),
        (lambda hull: at_place(hull, 0.0, 0.0, -6.0), 'clock.up = -6.0'),
        (lambda _: named_hull('sloups'), r'one of sloop, deptford.* Did you mean sloop'),
        (
            lambda _: hulls.check_proportions(440.0, 126.0, 5.0),
            r'must be in \[2, 400\] m.*mean 44',
        ),
        (lambda _: hulls.check_proportions(44.0, 5.0, 12.6), '12.6: must not exceed the beam, 5'),
        (lambda _: hulls.check_proportions(44.0, 30.0, 5.0), '= 30.0: must be between a 20th and'),
        (lambda _: hulls.check_proportions(44.0, 12.6, 0.1), '= 0.1: must be at least a 20th'),
        (lambda _: hulls.check_proportions(math.nan, 12.6, 5.0), r'nan: must be in \[2, 400\] m'),
        (lambda _: form(5.9).exponents(), r'block = 5.9: must be in \[0.3, 0.96\]'),
        (lambda _: form(0.6, 0.5).exponents(), r'waterplane = 0.5: must be in \[0.612, 0.99\]'),
    ],
)
def test_what_no_ship_has_is_refused_by_value_and_limit(deptford, refused, words):
    with pytest.raises(HullError, match=words):
        refused(deptford)


def ship_of(hull, roll_period=11.0, roll_damping_ratio=0.08, **keys):
    return Hull(hull, roll_period, roll_damping_ratio, **keys)


def at_place(hull, *place):
    places = [ClockPlace(*place)]
    return rate_by_place(ship_of(hull), standard_sea, headings=[0.0], places=places)


def form(block, waterplane=None):
    return hulls.Shape(44.0, 12.6, 5.0, block, waterplane)


@pytest.mark.parametrize('block', [0.3, 0.5, 0.96])
def test_the_default_waterplane_is_within_its_limits(block):
    p, q = form(block).exponents()
    assert p / (p + 1.0) * q / (q + 1.0) == pytest.approx(block)


def test_a_form_of_two_and_two_is_wigleys():
    assert hulls.Shape(10.0, 1.0, 0.625, 4.0 / 9.0).exponents() == pytest.approx((2.0, 2.0))
