"""A response amplitude operator with any motions, at all headings and speeds (sea.md)."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tauto_core.curves.numerics import trapezoid
from tauto_core.samples import FloatArray
from tauto_core.scene import Scene, load_scene
from tauto_core.scene.errors import SceneError
from tauto_core.ship import ShipMotion
from tauto_core.ship.hull import Hull, named_hull
from tauto_core.ship.motions.sea import sea_motion
from tauto_core.ship.sea import bretschneider, operator_answer
from tauto_core.ship.sections import MOTIONS, Rao
from tauto_core.ship.waves import Encounter, Harmonics

G = 9.80665
SIX = 'shipped:supply_rao/supply_six.csv'
ROLL_AND_HEAVE = 'shipped:supply_rao/supply_rao.csv'
SEA = {'spectrum': 'bretschneider', 'significant_wave_height': 2.5, 'peak_period': 9.0}


def scene(rao: dict[str, Any] | None = None, **keys: object) -> Scene:
    ship = {'kind': 'sea', 'sea': SEA, 'rao': rao or {'path': SIX}, **keys}
    return load_scene('ideal', duration=600.0, ship=ship)


def operator(**keys: object) -> Rao:
    found = scene(**keys).ship.rao
    assert isinstance(found, Rao)
    return found


def waves(omega: FloatArray) -> Harmonics:
    return Harmonics(np.ones(len(omega)), 2.0 * math.pi / omega, np.zeros(len(omega)))


@pytest.mark.parametrize('degrees', [0, 30, 90, 155, 180, 215, 300])
def test_long_waves_move_the_supply_vessel_as_they_move_water(degrees: int) -> None:
    """Orbits of the surface, −i, and its slope, i k. By the README roll has 1.6 of it."""
    heading = math.radians(degrees)
    omega = np.array([0.1])
    found = operator_answer(waves(omega), operator(), Encounter(0.0, heading, G), heave=False)
    got = {name: complex(each[0]) for name, each in found.motions.items()}
    k, along, across = omega[0] ** 2 / G, math.cos(heading), math.sin(heading)
    assert got['heave'] == pytest.approx(1.0, abs=2e-3)
    assert got['surge'] == pytest.approx(-1j * along, abs=0.015)
    assert got['sway'] == pytest.approx(-1j * across, abs=0.03)
    assert got['pitch'] == pytest.approx(1.03j * k * along, abs=0.03 * k)
    assert got['roll'] == pytest.approx(-1.62j * k * across, abs=0.03 * k)
    # a slender ship turns with the orbits athwart: d/dx of -i sin β e^{-ikx cos β}
    assert got['yaw'] == pytest.approx(-k * along * across, abs=0.1 * k)
    assert (found.above, found.below) == (0.0, 1.0)


@pytest.mark.parametrize(
    ('degrees', 'heave', 'other', 'at'), [(90, -22.9, 14.3, 1), (180, -2.9, 4.3, 0)]
)
def test_the_rate_of_a_weight_in_the_supply_vessel(degrees, heave, other, at):
    """The figures of hull.md, from the same data by another program: s/day, amidships."""
    omega = 2.0 * math.pi / 9.0 * np.geomspace(0.5, 4.5, 4000)
    course = Encounter(0.0, math.radians(degrees), G)
    found = operator_answer(waves(omega), operator(), course, heave=False)
    omega = found.waves.angular_frequency
    square = bretschneider(omega, 2.5, 9.0) * omega**4 * 86_400.0 / G**2

    def part(name: str) -> float:
        return trapezoid(square * np.abs(found.motions[name]) ** 2, omega)

    # 4.5 times the peak frequency against 4 there: negligible energy between
    assert -part('heave') / 8.0 == pytest.approx(heave, abs=0.2)
    assert part(MOTIONS[at]) / 4.0 == pytest.approx(other, abs=0.1)


def table_of(hull: Hull, path: Path, headings: list[float], speeds: list[float]) -> str:
    """Write the operators of a hull to a file."""
    omega = np.arange(0.05, 3.5, 0.01)
    parts = ','.join(f'{name}_re,{name}_im' for name in MOTIONS)
    rows = [f'speed_mps,heading_deg,omega_radps,{parts}']
    for speed in speeds:
        for heading in headings:
            motions = hull.response(omega, math.radians(heading), speed).motions
            rows += [
                f'{speed},{heading},{w!r},' + ','.join(f'{x.real!r},{x.imag!r}' for x in row)
                for w, row in zip(omega.tolist(), motions.tolist(), strict=True)
            ]
    path.write_text('\n'.join(rows) + '\n')
    return str(path)


@pytest.mark.parametrize(
    ('speeds', 'speed', 'degrees', 'within'),
    [
        ([0.0], 0.0, 135.0, 1e-3),
        ([0.0], 0.0, 230.0, 1e-3),
        # halfway between two speeds and headings, linear
        ([2.0, 3.0], 2.5, 125.0, 0.06),
        ([2.0, 3.0], 3.0, 310.0, 1e-3),
        # in following seas of 5 s and less the ship overtakes the waves
        ([5.0], 5.0, 20.0, 1e-3),
    ],
)
def test_an_operator_of_a_hull_moves_a_ship_as_the_hull_does(
    tmp_path: Path, speeds: list[float], speed: float, degrees: float, within: float
) -> None:
    """All readings of the IMU, with Akima between values 0.01 rad/s apart."""
    hull = Hull(named_hull('deptford'), 11.0, 0.2)
    beside = sorted(
        {10.0 * f(min(degrees, 360.0 - degrees) / 10.0) for f in (math.floor, math.ceil)}
    )
    headings = beside if within > 0.02 else [min(degrees, 360.0 - degrees)]
    path = table_of(hull, tmp_path / 'x.csv', headings, speeds)
    keys = {
        'heading': math.radians(degrees),
        'speed': speed,
        'clock': {'forward': 12.0, 'port': -2.0},
        'height': 3.0,
    }
    roll = {'natural_period': 11.0, 'damping_ratio': 0.2}
    sea = {'kind': 'sea', 'sea': {**SEA, 'cutoff': 4.0}}
    ours, theirs = (
        ShipMotion(load_scene('ideal', duration=600.0, ship={**sea, **keys, **ship})).produce(4000)
        for ship in ({'rao': {'path': path}}, {'hull': 'deptford', 'roll': roll})
    )
    for name in ('linear_acceleration', 'angular_velocity'):
        found, wanted = getattr(ours, name), getattr(theirs, name)
        middle = wanted.mean(axis=0)
        assert np.std(found - wanted) < within * np.std(wanted - middle)


def test_motions_missing_in_a_file_are_zero(tmp_path: Path) -> None:
    rows = ['heading_deg,omega_radps,pitch_re,pitch_im', '180,0.1,0,0.001', '180,3,0,0']
    (tmp_path / 'x.csv').write_text('\n'.join(rows) + '\n')
    ready = scene({'path': str(tmp_path / 'x.csv'), 'heading': math.pi}, clock={'forward': 10.0})
    six = sea_motion(ready, ready.ship).six
    assert six is not None
    assert ready.ship.motions == ('pitch',)
    # what pitches lifts the bow: minus x θ
    np.testing.assert_allclose(six.heave.amplitude, 10.0 * six.pitch.amplitude, rtol=1e-12)
    assert not six.roll.amplitude.any()
    assert np.isfinite(ShipMotion(ready).produce(100).linear_acceleration).all()


def test_roll_and_heave_alone_are_sailed_as_one_heading_is() -> None:
    """The whole operator at a heading of the file, and this heading of it alone."""
    ours = scene({'path': ROLL_AND_HEAVE}, heading=math.radians(130.0), heave=True)
    theirs = scene({'path': ROLL_AND_HEAVE, 'heading': math.radians(130.0)}, heave=True)
    for each in ('orientation', 'linear_acceleration'):
        found, wanted = (getattr(ShipMotion(s).produce(500), each) for s in (ours, theirs))
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12)


def passage(rao: dict[str, Any], **keys: object) -> Scene:
    ready = load_scene('portsmouth_jamaica')
    ship = ready.ship.model_dump(mode='json', exclude_none=True)
    del ship['roll'], ship['hull']
    return load_scene('portsmouth_jamaica', ship={**ship, 'rao': rao, **keys}, duration=3e6)


@pytest.mark.parametrize('rao', [{'path': SIX}, {'path': ROLL_AND_HEAVE, 'heading': 1.75}])
def test_a_passage_by_an_operator_reports_waves_left_out(rao: dict[str, Any]) -> None:
    motion = ShipMotion(passage(rao))
    [warning] = motion.warnings
    assert '% of the energy of the waves is above the frequencies of ship.rao' in warning
    assert np.isfinite(motion.produce(1000).linear_acceleration).all()


def test_a_leg_that_turns_out_of_the_operator_is_named(tmp_path: Path) -> None:
    path = table_of(
        Hull(named_hull('deptford'), 11.0, 0.1), tmp_path / 'x.csv', [80.0, 100.0], [0.0]
    )
    said = r'on the leg from voyage\.\S+ to voyage\.\S+: heading is .*° off .* covers 80° to 100°'
    with pytest.raises(SceneError, match=said) as caught:
        ShipMotion(passage({'path': path}))
    assert caught.value.key.startswith('ship.weather.')
    with pytest.raises(SceneError, match=r'speed must be in \[0, 1\.\d* ?\S*\] m/s.*Froude'):
        ShipMotion(passage({'path': path, 'heading': 1.5, 'length': 2.0}))


@pytest.mark.parametrize(
    ('rao', 'keys', 'key', 'said'),
    [
        ({}, {'heading': 0.3}, 'ship.heading', r'17\.19° off following seas.*80° to 100°'),
        ({}, {'heading': math.tau - 0.3}, 'ship.heading', r'17\.19° off following seas'),
        ({'length': 44.0}, {'speed': 6.0}, 'ship.speed', 'Froude number of 0.25'),
        ({'length': 44.0}, {'clock': {'forward': 23.0}}, 'ship.clock.forward', 'outside the ship'),
        ({}, {'clock': {'port': -101.0}}, 'ship.clock.port', 'outside the ship'),
        ({'length': 440.0}, {}, 'ship.rao.length', '400'),
        ({}, {'heading': 1.5, 'speed': 2.5}, 'ship.speed', r'in \[0, 2\] m/s, the speeds of'),
    ],
)
def test_refused(tmp_path, rao, keys, key, said):
    speeds = [0.0] if keys.get('speed') != 2.5 else [0.0, 2.0]
    path = table_of(
        Hull(named_hull('deptford'), 11.0, 0.1), tmp_path / 'x.csv', [80.0, 100.0], speeds
    )
    with pytest.raises(SceneError, match=said) as caught:
        ShipMotion(scene({'path': path, **rao}, **keys))
    assert caught.value.key == key
