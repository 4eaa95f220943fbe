"""Waves met by a ship under way, against the waves of a fixed sea at the ship's position."""

import math
from typing import Any

import numpy as np
import pytest

from tauto_core.scene import SceneError, load_scene
from tauto_core.ship import ShipMotion
from tauto_core.ship.motions.sea import sea_motion
from tauto_core.ship.sea import Answer, elevation, operator_answer, roll_answer
from tauto_core.ship.sections import Rao, Roll, Sea
from tauto_core.ship.waves import Encounter, Harmonics

G = 9.80665
SEA = Sea(spectrum='jonswap', significant_wave_height=3.0, peak_period=8.0)
ROLL = Roll(natural_period=11.0, damping_ratio=0.08, slope_coefficient=0.7)
OPERATOR = 'shipped:supply_rao/supply_rao.csv'
# The last overtakes its waves: g/(2 pi) 4 s is 6.2 m/s, and 12 m/s cos 0.5 is 10.5.
COURSES = [
    Encounter(0.0, 0.5 * math.pi, G),
    Encounter(7.0, math.pi, G),
    Encounter(5.0, 1.9, G),
    Encounter(8.0, 5.2, G),
    Encounter(12.0, 0.5, G),
]
T = np.linspace(0.0, 300.0, 150)[:, None]


def waves() -> Harmonics:
    return elevation(SEA, 5)


def at(harmonics: Harmonics, order: int = 0) -> np.ndarray:
    w = harmonics.angular_frequency
    turned = w * T + harmonics.phase + 0.5 * np.pi * order
    return np.sum(harmonics.amplitude * w**order * np.cos(turned), axis=1)


def angles(course: Encounter) -> np.ndarray:
    """Return omega t - k x + eps at the ship, x = V t along its bow."""
    w = waves().angular_frequency
    along = w**2 / G * math.cos(course.heading)
    return w * T - along * (course.speed * T) + waves().phase


@pytest.mark.parametrize('course', COURSES, ids=str)
def test_the_elevation_is_that_of_the_sea_where_the_ship_is(course):
    expected = np.sum(waves().amplitude * np.cos(angles(course)), axis=1)
    # rounding of angles of some thousand radians
    np.testing.assert_allclose(at(course.met(waves())), expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize('course', COURSES, ids=str)
def test_roll_under_way_solves_its_equation(course):
    """The slope to port at the ship, d/dy of a cos(omega t - k (x cos mu + y sin mu))."""
    w = waves().angular_frequency
    across = w**2 / G * math.sin(course.heading)
    slope = np.sum(waves().amplitude * across * np.sin(angles(course)), axis=1)
    natural = 2.0 * np.pi / 11.0
    roll = roll_answer(waves(), ROLL, course)
    terms = at(roll, 2), 2.0 * 0.08 * natural * at(roll, 1), natural**2 * at(roll)
    # rounding of angles of some hundred radians at rest, of some thousand under way
    close = 1e-12 if course.speed else 1e-14
    np.testing.assert_allclose(sum(terms), natural**2 * 0.7 * slope, rtol=0, atol=close)


def answer(found: Answer, name: str, course: Encounter) -> Harmonics:
    factor = found.motions[name]
    amplitude = found.waves.amplitude * np.abs(factor)
    return course.answer(found.waves, amplitude, np.angle(factor))


def operator_of_the_equation(heading: float) -> Rao:
    """Return the response of the roll equation for a ship at rest, on a dense grid."""
    w = np.geomspace(0.005, 12.0, 6000)
    natural = 2.0 * np.pi / 11.0
    own = natural**2 * 0.7 / (natural**2 - w**2 + 2j * 0.08 * natural * w)
    answer = -1j * w**2 / G * math.sin(heading) * own
    return Rao(
        source='equation',
        heading=heading,
        angular_frequency=tuple(w),
        roll_real=tuple(answer.real),
        roll_imaginary=tuple(answer.imag),
    )


@pytest.mark.parametrize('course', COURSES, ids=str)
def test_an_operator_answers_as_the_equation_that_it_is_of(course):
    """The operator is of a ship at rest: under way both take the slope at the encounter."""
    rao = operator_of_the_equation(course.heading)
    found = operator_answer(waves(), rao, course, heave=False)
    expected = at(roll_answer(waves(), ROLL, course))
    assert (found.above, found.below) == (0.0, 0.0)
    # Akima between 6000 values. The rolls reach some hundredths of a radian
    np.testing.assert_allclose(at(answer(found, 'roll', course)), expected, rtol=0, atol=1e-6)
    # head seas roll no ship
    assert np.abs(expected).max() > 1e-3 or course.heading == math.pi


def test_heave_is_read_at_the_frequency_of_the_wave():
    """A hull that halves the response to short waves does so at any speed."""
    w = np.geomspace(0.05, 12.0, 3000)
    none = tuple(0.0 * w)
    rao = Rao(
        source='hull',
        heading=math.pi,
        angular_frequency=tuple(w),
        roll_real=none,
        roll_imaginary=none,
        heave_real=tuple(1.0 / (1.0 + w**2)),
        heave_imaginary=none,
    )
    for speed in (0.0, 6.0):
        course = Encounter(speed, math.pi, G)
        heave = answer(operator_answer(waves(), rao, course, heave=True), 'heave', course)
        omega = waves().angular_frequency
        np.testing.assert_allclose(
            heave.amplitude, waves().amplitude / (1.0 + omega**2), rtol=1e-6
        )
        np.testing.assert_allclose(2.0 * np.pi / heave.period, course.frequency(omega), rtol=1e-13)


def ship(**keys: object) -> dict[str, Any]:
    sea = {'spectrum': 'bretschneider', 'significant_wave_height': 2.0, 'peak_period': 10.0}
    rao = {'path': OPERATOR, 'heading': 2.5}
    return {'kind': 'sea', 'sea': sea, 'rao': rao, **keys}


def test_waves_beyond_the_operator_are_left_out_and_reported():
    for speed in (4.0, 10.0):
        scene = load_scene('ideal', ship=ship(speed=speed), duration=60.0)
        motion = sea_motion(scene, scene.ship)
        course = Encounter(speed, scene.ship.relative_heading, scene.g)
        met = course.met(elevation(scene.ship.sea, scene.seed))
        shorter = met.angular_frequency > scene.ship.rao.angular_frequency[-1]
        share = np.sum(met.amplitude[shorter] ** 2) / np.sum(met.amplitude**2)
        assert motion.unanswered == pytest.approx((share, 0.0), rel=1e-12)
        assert len(motion.roll.period) == np.count_nonzero(~shorter)
        [warning] = ShipMotion(scene).warnings
        assert f'{100.0 * share:.2g} % of the energy of the waves is above' in warning
        assert 'taken not to move the ship' in warning
    assert ShipMotion(load_scene('ideal', ship=ship(), duration=60.0)).warnings == ()


def test_a_sea_beyond_the_operator_leaves_the_ship_at_rest():
    sea = {'spectrum': 'bretschneider', 'significant_wave_height': 0.1, 'peak_period': 0.9}
    scene = load_scene('ideal', ship=ship(sea=sea, heave=True), duration=60.0)
    motion = ShipMotion(scene)
    assert motion.warnings[0].startswith('1e+02 % of the energy')
    assert not np.diff(motion.produce(100).linear_acceleration, axis=0).any()


def test_waves_beyond_the_operator_move_the_ship_statically():
    """In following seas, at encounter frequencies around 0: the heel is static."""
    rao = operator_of_the_equation(0.7)
    inside = np.array(rao.angular_frequency) > 0.25
    cut = {
        key: tuple(np.array(getattr(rao, key))[inside])
        for key in ('angular_frequency', 'roll_real', 'roll_imaginary')
    }
    course = Encounter(12.0, 0.7, G)
    found = operator_answer(waves(), rao.model_copy(update=cut), course, heave=False)
    longer = np.abs(course.frequency(waves().angular_frequency)) < 0.25
    share = np.sum(waves().amplitude[longer] ** 2) / np.sum(waves().amplitude ** 2)
    assert 0.1 < share == pytest.approx(found.below, rel=1e-9)
    static = 0.7 * waves().angular_frequency ** 2 / G * math.sin(0.7)
    # at 0.25 rad/s the roll is 1.22 of the static one, which has a natural frequency of 0.57
    size = np.abs(found.motions['roll'][longer]) / static[longer]
    np.testing.assert_allclose(size, 1.23, atol=0.02)


def test_waves_too_short_for_the_rate_are_refused():
    roll = {'natural_period': 11.0, 'damping_ratio': 0.1, 'slope_coefficient': 0.7}
    keys = {'rao': None, 'roll': roll, 'heading': math.pi, 'speed': 20.0, 'rate': 2.0}
    slow = {k: v for k, v in ship(**keys).items() if v is not None}
    with pytest.raises(SceneError, match=r'met at 20 m/s, have 2\.4\d* Hz.*Raise ship\.rate'):
        ShipMotion(load_scene('ideal', ship=slow))
    at_rest = {**slow, 'speed': 0.0}
    ShipMotion(load_scene('ideal', ship=at_rest))
    short = {**at_rest, 'rate': 4.0, 'sea': {**slow['sea'], 'peak_period': 2.0}}
    with pytest.raises(SceneError, match=r'peak_period = 2\.0.*2 Hz.*ship\.rate.*above 4 Hz'):
        ShipMotion(load_scene('ideal', ship=short))
