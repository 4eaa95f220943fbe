"""How well what hangs on the ship follows the apparent vertical, predicted before a run.

A thread that swings and a case on its axle are one link with a body (theory C), answered by
e θ̈ + c φ̈ + g θ = g τ, k² φ̈ + g c (φ − θ) = 0 where the apparent vertical tilts by τ. To a wave
of frequency Ω

    θ/τ = g (g c − k² Ω²)/D,    φ/τ = g² c/D,    D = e k² (Ω² − ω²)(Ω² − ω′²),

which is 1 while Ω is far below both of the link's own frequencies ω, ω′, and grows without end
where it meets one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tauto_core.machines import AnyMachine, FluidPendulum, HangingMachine, Machine
from tauto_core.machines.modes import Modes
from tauto_core.samples import FloatArray
from tauto_core.scene import Scene
from tauto_core.ship.felt_step import case_modes
from tauto_core.voyage_cost import Waves, scene_waves

LARGEST_DEPARTURE = 1.0
"""Departure, as a share of the tilt of the apparent vertical, beyond which what hangs swings wider
than what it follows.
"""
LARGEST_STRETCH = 0.02
"""Share by which a swinging thread may change the period of small swings."""
NEAR_PERIOD = 0.05
"""Two periods that differ by less than this share drive each other."""


@dataclass(frozen=True)
class Following:
    """A link that hangs on the ship.

    Attributes:
        periods_s: periods of its own small swings, the slower first [s].
        departure_rad: rms of its departure from the apparent vertical [rad].
        departure: the same by the rms of the apparent vertical's tilt; None where that keeps
            upright, or the motion is measured.
        resonates_with: `wheel`, `waves`, both or neither.
    """

    periods_s: tuple[float, ...]
    departure_rad: float | None
    departure: float | None
    resonates_with: tuple[str, ...]


def lengths_between(
    scene: Scene, machine: AnyMachine | FluidPendulum
) -> tuple[float, float | None] | None:
    """Return g/ω² and g/Ω² [m], between which a thread is as good as an ideal vertical one.

    ω is the wheel's frequency on an ideal thread and Ω⁴ the mean over the waves in the apparent
    vertical; None for Ω as for `Following.departure`.

    Returns:
        None for a machine whose thread carries no weight that can swing.
    """
    if isinstance(machine, Machine | HangingMachine) and machine.follows_apparent_vertical:
        waves = scene_waves(scene)
        square = _share(waves, waves.frequency**2)
        longest = scene.gravity / square if square else None
        return scene.gravity / _ideal_frequency(machine) ** 2, longest
    return None


def thread_following(scene: Scene, machine: HangingMachine) -> Following:
    """Return how a thread that swings keeps to the apparent vertical: θ, its inclination.

    Args:
        scene: the scene of the machine.
        machine: the machine whose thread it is.
    """
    k_squared = machine.inertia / machine.mass
    waves = scene_waves(scene)
    answer, _ = answers(
        machine.modes,
        machine.base_radius,
        k_squared,
        waves.frequency,
        scene.gravity,
        scene.duration,
    )
    stretch = machine.small_period * _ideal_frequency(machine) / math.tau - 1.0
    period = math.tau / machine.thread_frequency
    return _following(waves, answer, (period,), wheel=abs(stretch) > LARGEST_STRETCH)


def case_following(scene: Scene, machine: AnyMachine) -> Following | None:
    """Return how a suspended case keeps to the apparent vertical: φ, its tilt.

    Args:
        scene: the scene of the machine.
        machine: the machine whose wheel the case may shake.

    Returns:
        None without a suspension.
    """
    hung = scene.suspension
    if hung is None:
        return None
    own, waves = case_modes(hung), scene_waves(scene)
    _, answer = answers(
        own, hung.depth, hung.gyration_radius**2, waves.frequency, scene.gravity, scene.duration
    )
    slow, fast = own.squared_frequencies(scene.gravity)
    periods = math.tau / math.sqrt(slow), math.tau / math.sqrt(fast)
    wheel = any(abs(period / machine.small_period - 1.0) < NEAR_PERIOD for period in periods)
    return _following(waves, answer, periods, wheel=wheel)


def _following(
    waves: Waves, answer: FloatArray, periods: tuple[float, ...], *, wheel: bool
) -> Following:
    departure, size = _share(waves, answer - 1.0), float(np.linalg.norm(waves.sway))
    too_far = departure is not None and departure > LARGEST_DEPARTURE
    return Following(
        periods,
        None if departure is None else departure * size / math.sqrt(2.0),
        departure,
        ('wheel',) * wheel + ('waves',) * too_far,
    )


def _ideal_frequency(machine: Machine | HangingMachine) -> float:
    """Return the frequency of small swings on an ideal vertical thread [rad/s]."""
    if isinstance(machine, Machine):
        return machine.frequency
    pull = machine.mass * machine.gravity
    return math.sqrt(pull * machine.base_radius / machine.inertia)


def answers(
    own: Modes,
    depth: float,
    k_squared: float,
    frequency: FloatArray,
    gravity: float,
    duration_s: float,
) -> tuple[FloatArray, FloatArray]:
    """Return θ/τ and φ/τ for each wave; in resonance what the duration lets them grow to.

    Args:
        own: modes of the link.
        depth: c [m].
        k_squared: k² [m2].
        frequency: Ω of the waves [rad/s].
        gravity: g [m/s2].
        duration_s: for which the waves last [s].
    """
    square = frequency**2
    divisor = np.full_like(square, own.b * own.b_prime * depth)
    for mode in own.squared_frequencies(gravity):
        apart = mode - square
        least = 2.0 * math.sqrt(mode) / duration_s
        divisor *= np.where(np.abs(apart) < least, least, apart)
    theta = gravity * (gravity * depth - k_squared * square) / divisor
    return theta, gravity * gravity * depth / divisor


def _share(waves: Waves, value: FloatArray) -> float | None:
    """Return the rms of a value over the tilts of the apparent vertical; None where none tilts."""
    size = float(np.linalg.norm(waves.sway))
    return float(np.linalg.norm(waves.sway * value)) / size if size else None
