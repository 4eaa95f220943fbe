"""Small machines and runs for the propagators' tests."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import numpy as np
import yaml

from tauto_core.clockwork import TrochleaStage
from tauto_core.machines import (
    AnyMachine,
    LeverMachine,
    Machine,
    SteadySwing,
    compile_machine,
    steady_swing,
)
from tauto_core.motion import Forcing
from tauto_core.motion.forcing import Motion
from tauto_core.samples import JOINT_STATES, PHASE, Batches
from tauto_core.scene import Scene, parse_scene
from tauto_core.ship import ShipMotion
from tauto_core.ship.buffer import MotionBuffer

INERTIA, LEVER_RATE, FORCE = 4.0e-4, 0.01, 2.0
OMEGA = float(np.sqrt(FORCE * LEVER_RATE / INERTIA))

VERTICAL = {'kind': 'vertical'}


def weight_of(mass: float, base_radius: float, **more: Any) -> dict[str, Any]:
    """Return a weight on the vertical thread of an involute."""
    cam, power = involute(base_radius), {'kind': 'weight', 'mass': mass}
    return {'cam': cam, 'thread': VERTICAL, 'power': power} | more


def involute(base_radius: float) -> dict[str, Any]:
    """Return the cam."""
    return {'kind': 'involute', 'base_radius': base_radius}


def arc(radius: float, root_depth: float) -> dict[str, Any]:
    """Return a cheek along an arc of a circle."""
    return {'kind': 'circular_arc', 'radius': radius, 'root_depth': root_depth}


def impulse(energy: float, angle: float = 0.0, **rest: float) -> dict[str, Any]:
    """Return an escapement."""
    given = {'kind': 'impulse', 'energy': energy, 'angle': angle}
    return {**given, 'rest': rest} if rest else given


def waves(*cosines: tuple[float, ...]) -> list[dict[str, float]]:
    """Return roll or heave: amplitude, period and phase of each wave."""
    names = 'amplitude', 'period', 'phase'
    return [dict(zip(names, each, strict=False)) for each in cosines]


def rolling(*cosines: tuple[float, ...], **more: Any) -> dict[str, Any]:
    """Return a ship that rolls."""
    return {'kind': 'components', 'components': waves(*cosines), **more}


WEIGHT = weight_of(0.15, 0.012, inertia=8e-3)
SEA = rolling((0.15, 8.2, 1.0), (0.04, 6.3, -0.5), heave=waves((0.6, 10.2, 0.7)), height=2.5)

TIED = {'kind': 'lever', 'arm': 0.1, 'weight_arm': 0.15, 'length': 0.3}
LEVER_WHEEL = {'cam': involute(0.02), 'power': {'kind': 'weight', 'mass': 0.05}}
LEVER = {**LEVER_WHEEL, 'thread': TIED}
LONG_THREAD = weight_of(0.322, 0.005, thread={'kind': 'hanging', 'length': 1.5})
STIFF = {'kind': 'weight_and_spring', 'mass': 0.322, 'stiffness': 300.0}
"""Weight and spring of the long thread."""

TOO_SMALL_TO_MATTER = {'viscous': 1e-300, 'quadratic': 1e-300}
"""Drag that sends a machine through the general engine, all through the same kernel."""


def scene_of(**sections: Any) -> Scene:
    """Return Euler's second cam with a force, with sections replaced or added."""
    base: dict[str, Any] = {
        'name': 'test',
        'duration': 60.0,
        'trochlea': {
            'inertia': INERTIA,
            'cam': {'kind': 'hole', 'lever_rate': LEVER_RATE},
            'thread': {'kind': 'hole', 'distance': 0.08},
            'power': {'kind': 'force', 'force': FORCE},
            'release_angle': 1.0,
        },
        'ship': {'kind': 'still'},
        'log': {'interval': 0.05},
        'solver': {'tolerance': 2e-12},
    }
    trochlea = {**base['trochlea'], **sections.pop('trochlea', {})}
    return parse_scene(yaml.safe_dump({**base, **sections, 'trochlea': trochlea}), 'test')


def regulator_scene(
    regulator: dict[str, Any], duration: float, log: float, ship: dict[str, Any] | None = None
) -> Scene:
    """Return the scene of a regulator that is no trochlea."""
    content = {
        'name': 'test',
        'duration': duration,
        'regulator': regulator,
        'ship': ship or {'kind': 'still'},
        'log': {'interval': log},
        'drift': {'observation_interval': duration},
    }
    return parse_scene(yaml.safe_dump(content), 'test')


def foretold(scene: Scene) -> SteadySwing:
    """Return the steady swing of a scene's clock."""
    machine = compile_machine(scene)
    assert isinstance(machine, Machine | LeverMachine)
    swing = steady_swing(machine)
    assert isinstance(swing, SteadySwing)
    return swing


SWINGS = 20


def released_steady(swing: SteadySwing, **sections: Any) -> Scene:
    """Return a clock released in its steady swing, logged once a swing, to the nanosecond."""
    interval = round(swing.period, 9)
    duration = round(SWINGS * interval, 9)
    trochlea = {**sections.pop('trochlea', {}), 'release_angle': swing.amplitude}
    times = {'log': {'interval': interval}, 'drift': {'observation_interval': duration}}
    return scene_of(trochlea=trochlea, duration=duration, **times, **sections)


def run(scene: Scene) -> Batches:
    """Return the output of the trochlea in a scene."""
    ship, stage = ShipMotion(scene), TrochleaStage(scene)
    return stage.feed({'ship/imu': ship.produce(ship.total)})


def angles(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times from the start [s], θ [rad] and θ̇ [rad/s] at the logged instants."""
    joints = run(scene)[JOINT_STATES]
    times = (joints.stamp_ns - scene.starts_at_ns) * 1e-9
    return times, joints.position[:, 0], joints.velocity[:, 0]


def phases(scene: Scene) -> np.ndarray:
    """Return phase, half turns, fraction and beats at the logged instants."""
    return run(scene)[PHASE].position


def at_rest_at_sea(spans: Forcing, machine: Machine) -> Forcing:
    """Return spans on land, for a weight on a motionless ship at sea: it shares those kernels."""
    if not machine.feels_gravity:
        return spans
    nothing = np.zeros((len(spans.length_s), 1))
    tilts = machine.follows_apparent_vertical
    return replace(
        spans,
        neutral=nothing,
        tilt=nothing if tilts else None,
        gravity=np.full_like(nothing, machine.gravity),
    )


def on_land(count: int, step_s: float, every: int = 1) -> Forcing:
    """Return spans of one length on land, every so many of them logged."""
    index = np.arange(1, count + 1)
    ends = np.round(index * step_s * 1e9).astype(np.int64)
    lengths = np.full(count, step_s)
    return Forcing(lengths, np.zeros(count), np.ones(count), ends, index % every == 0)


def spans_to(times_ns: Any) -> Forcing:
    """Return one span to each time, on land."""
    times = np.asarray(times_ns, np.int64)
    n = len(times)
    lengths = np.diff(times, prepend=0) * 1e-9
    return Forcing(lengths, np.zeros(n), np.ones(n), times, np.ones(n, np.bool_))


def sampled(scene: Scene, machine: AnyMachine | None = None, stride: int = 2) -> Forcing:
    """Return the polynomials of a scene's ship over pieces of `stride` samples.

    With a machine only the channels that it needs.
    """
    ship = ShipMotion(scene)
    buffer = MotionBuffer(
        apparent_vertical=machine is None or machine.follows_apparent_vertical,
        apparent_gravity=machine is None or machine.feels_gravity,
        still=False,
        step_ns=scene.step_ns,
        max_gap_s=1.0,
        stride=stride,
    )
    buffer.add(ship.produce(ship.total), scene.starts_at_ns)
    forcing = buffer.forcing(scene.log_interval_ns, scene.duration_ns, final=True)
    assert forcing is not None
    return forcing


def moved(engine: Any, forcing: Forcing) -> Motion:
    """Return the motion over a forcing, from a release on."""
    engine.release(forcing)
    motion: Motion = engine.advance(forcing)
    return motion


def moved_in_chunks(make: Callable[[], Any], forcing: Forcing, spans: int) -> Motion:
    """Return the motion over chunks of so many spans, each by an engine restored from a state."""
    engine, parts = make(), []
    engine.release(forcing.part(0, spans))
    for begin in range(0, len(forcing.begin), spans):
        state, engine = engine.state(), make()
        engine.restore(state)
        parts.append(engine.advance(forcing.part(begin, begin + spans)))
    return Motion(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Motion)))


def assert_same_bits(found: Motion, wanted: Motion) -> None:
    """Compare all columns of two motions."""
    for field in fields(Motion):
        np.testing.assert_array_equal(getattr(found, field.name), getattr(wanted, field.name))


def assert_same_swing(found: Motion, wanted: Motion, atol: float) -> None:
    """Compare the angles of two motions to a tolerance [rad], and their counts."""
    np.testing.assert_allclose(found.angle, wanted.angle, rtol=0.0, atol=atol)
    np.testing.assert_array_equal(found.half_turns, wanted.half_turns)
    np.testing.assert_array_equal(found.beats, wanted.beats)
