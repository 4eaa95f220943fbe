"""The time step of the motion that the clock feels, which a suspended case makes finer."""

from __future__ import annotations

import math

from tauto_core.machines.axle_pendulum import Modes, modes
from tauto_core.samples import NS_PER_S
from tauto_core.scene import AxleSuspension, Scene
from tauto_core.scene.errors import SceneError

LARGEST_TURN = 0.4
"""Largest phase of the fast mode between two samples [rad]; the interpolation error is then below
3e-8 of the amplitude of that mode.
"""

LARGEST_SLOW_TURN = 0.05
"""Largest phase of the slow mode between two samples where angles may be large [rad]. A swing of
1 rad has overtones, which then put the wheel off by 1e-9 of its swing; at 0.1 rad it is 1e-6.
"""

MOST_PARTS = 64
"""Largest number of parts into which a step of the ship's motion is divided."""


def case_modes(hung: AxleSuspension) -> Modes:
    """Return both modes of a suspended case."""
    e = hung.support_radius - hung.axle_radius
    return modes(e, hung.depth, hung.gyration_radius**2)


def felt_parts(scene: Scene) -> int:
    """Return the number of equal parts into which a step of ship/imu is divided for the clock.

    1 without a suspension; otherwise the least number that divides the step into whole nanoseconds
    and keeps the turn of the fast mode within LARGEST_TURN, and where angles may be large that of
    the slow mode within LARGEST_SLOW_TURN.

    Raises:
        SceneError: a mode is too fast for that.
    """
    hung = scene.suspension
    if hung is None:
        return 1
    step_s = scene.step_ns / NS_PER_S
    squares = case_modes(hung).squared_frequencies(scene.gravity)
    slow, fast = (math.sqrt(square) for square in squares)
    needed_hz = fast / LARGEST_TURN
    if hung.large_angles:
        needed_hz = max(needed_hz, slow / LARGEST_SLOW_TURN)
    for parts in range(max(math.ceil(needed_hz * step_s), 1), MOST_PARTS + 1):
        if scene.step_ns % parts == 0:
            return parts
    if needed_hz > fast / LARGEST_TURN and needed_hz * step_s > MOST_PARTS:
        raise _swings_too_fast(scene, slow, needed_hz)
    raise _too_fast(scene, hung, fast, step_s)


def felt_step_ns(scene: Scene) -> int:
    """Return the time between samples of the motion that the clock feels [ns]."""
    return scene.step_ns // felt_parts(scene)


def _swings_too_fast(scene: Scene, slow: float, needed_hz: float) -> SceneError:
    return SceneError(
        scene.name,
        'ship.rate',
        scene.ship.rate,
        f'is too low for wide swings of the case, whose slow mode turns {slow:.6g} rad/s',
        f'Use a rate of at least {needed_hz / MOST_PARTS:.6g} Hz, or set suspension.large_angles '
        'to false.',
    )


def _too_fast(scene: Scene, hung: AxleSuspension, fast: float, step_s: float) -> SceneError:
    limit = LARGEST_TURN * MOST_PARTS / step_s
    if fast <= limit:
        return SceneError(
            scene.name,
            'ship.rate',
            scene.ship.rate,
            f'cannot be divided finely enough for the suspension, whose fast mode turns '
            f'{fast:.6g} rad/s: a step of {scene.step_ns} ns has no divisor that fits',
            'Use a rate whose step is a round number of nanoseconds, for example 20.0 Hz.',
        )
    e, c = hung.support_radius - hung.axle_radius, hung.depth
    b = scene.gravity / limit**2
    wider = math.sqrt(c * b * (c + e - b) / (e - b)) if b < e else math.inf
    remedy = (
        f'Use a gyration_radius of at least {wider:.6g} m, or ' if wider < math.inf else 'Use '
    )
    return SceneError(
        scene.name,
        'suspension.gyration_radius',
        hung.gyration_radius,
        f'makes the fast mode of the case turn {fast:.6g} rad/s (b′ = '
        f'{case_modes(hung).b_prime:.6g} m); at {scene.ship.rate!r} Hz the limit is {limit:.6g}',
        f'{remedy}a ship.rate of {fast / limit * scene.ship.rate:.6g} Hz or more.',
    )
