"""Valid scenes: times, defaults, threads, numbers."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from tauto_core.scene import Scene, SceneError, parse_scene, scene_yaml
from tauto_core.scene.times import nanoseconds
from tauto_core.ship.motions import StillShip

TROCHLEA = """
trochlea:
  inertia: 4e-4
  cam: {cam}
  thread: {thread}
  power: {power}
  release_angle: 1
"""
SHORTEST = 'duration: 10\n' + TROCHLEA.format(
    cam='{kind: involute, base_radius: 1.0E-2}',
    thread='{kind: vertical}',
    power='{kind: force, force: +2}',
)

THREADS = {'vertical': '{kind: vertical}', 'hole': '{kind: hole, distance: 0.1}'}


def accepts(trochlea: str) -> bool:
    try:
        parse_scene('duration: 10\n' + trochlea, 's')
    except SceneError as error:
        if error.key != 'trochlea.thread.kind':
            raise
        return False
    return True


def test_what_is_left_out_is_not_simulated() -> None:
    scene = parse_scene(SHORTEST, 'short')
    assert scene.drag is None
    assert scene.escapement is None
    assert scene.voyage is None
    assert scene.ship == StillShip()
    assert scene.trochlea.inertia == 0.0004
    assert scene.g == 9.80665


def test_recoil_past_the_middle_drives_without_an_impulse() -> None:
    """4 R α in a swing; at the middle or before it the impulse must have an energy."""
    text = 'escapement: {{energy: 0.0, angle: {}, rest: {{recoil: {}}}}}\n'
    scene = parse_scene(SHORTEST + text.format(0.2, 1e-3), 's')
    assert scene.escapement is not None
    assert scene.escapement.work == pytest.approx(8e-4, rel=1e-15)
    assert parse_scene(scene_yaml(scene), 'bag') == scene
    for angle, recoil in ((0.0, 1e-3), (-0.2, 1e-3), (0.2, 0.0)):
        with pytest.raises(SceneError, match=r'escapement\.energy = 0\.0: must be greater than 0'):
            parse_scene(SHORTEST + text.format(angle, recoil), 's')


def test_a_scene_without_a_solver_is_written_without_one() -> None:
    """The text of bags written before there was a solver section stays as it was."""
    scene = parse_scene(SHORTEST, 's')
    assert scene.solver is None
    assert 'solver' not in scene_yaml(scene)


def test_a_moving_ship_steps_with_its_rate() -> None:
    scene = parse_scene(
        SHORTEST
        + 'ship: {kind: components, rate: 12.5, components: [{amplitude: 0.1, period: 9}]}'
        '\nlog: {interval: 0.4}\nstarts_at: 0.1\n',
        's',
    )
    assert scene.step_ns == 80_000_000
    assert scene.starts_at_ns == 100_000_000
    assert scene.duration_ns == 10_000_000_000
    assert (scene.samples, scene.log_count) == (126, 26)


@pytest.mark.parametrize(
    ('duration', 'log', 'kept'),
    [
        (86400, '{}', True),
        (86401, '{}', False),
        (86401, '{motion: true}', True),
        (10, '{motion: false}', False),
    ],
)
def test_motion_is_kept_up_to_a_day_unless_said(duration: int, log: str, kept: bool) -> None:
    scene = parse_scene(SHORTEST.replace('10', str(duration), 1) + f'log: {log}', 's')
    assert scene.keeps_motion is kept


@given(st.integers(0, 2**31 * 10**9), st.integers(0, 9))
def test_nanoseconds_are_those_of_the_decimal(ns: int, digits: int) -> None:
    """The shortest decimal of a double holds 15 digits exactly. Fewer are asked for here."""
    ns = ns // 10**digits * 10**digits
    written = Fraction(ns, 10**9)
    if len(str(ns).rstrip('0')) <= 15:
        assert nanoseconds(float(written)) == ns


@pytest.mark.parametrize(
    'power', ['force, force: 2', 'weight, mass: 0.2', 'spring, force: 2, stiffness: 5']
)
@pytest.mark.parametrize(
    ('cam', 'threads'),
    [
        ('{kind: involute, base_radius: 0.01}', {'vertical'}),
        ('{kind: hole, lever_rate: 0.01}', {'hole'}),
        ('{kind: circular_arc, radius: 0.02, root_depth: 0.01}', {'vertical'}),
        ('{kind: table, path: cam.csv}', {'vertical', 'hole'}),
    ],
)
def test_each_cam_goes_with_its_threads_under_any_power(cam, threads, power):
    accepted = {
        kind
        for kind, thread in THREADS.items()
        if accepts(TROCHLEA.format(cam=cam, thread=thread, power='{kind: ' + power + '}'))
    }
    assert accepted == threads


def test_yaml_numbers_are_those_of_yaml_1_2() -> None:
    """Core schema, section 10.3.2: 1e1 is a number, 010 decimal, yes and 1:30 are text."""
    text = SHORTEST.replace('duration: 10', 'duration: 1e1') + 'seed: 010\n'
    assert parse_scene(text, 's').duration == 10.0
    assert parse_scene(text, 's').seed == 10
    assert parse_scene(SHORTEST + 'seed: 0x1F\n', 's').seed == 31
    assert parse_scene(SHORTEST + 'seed: 0o17\n', 's').seed == 15
    for name in ('yes', '1:30', '2026-11-21', 'off'):
        assert parse_scene(SHORTEST + f'name: {name}\n', 's').name == name


def test_scenes_are_frozen_and_checked_from_python_too() -> None:
    scene = parse_scene(SHORTEST, 's')
    with pytest.raises(ValidationError):
        scene.duration = 5.0
    with pytest.raises(ValidationError, match='whole number of log intervals'):
        Scene(duration=0.5, trochlea=scene.trochlea)
    assert hash(scene) == hash(parse_scene(SHORTEST, 's'))
