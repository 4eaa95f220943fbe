"""How well a thread or case that hangs on the ship follows the apparent vertical, predicted.

A thread that swings and a case on its axle are both a link with a body (theory C), and obey
e θ̈ + c φ̈ + g θ = g τ, k² φ̈ + g c (φ − θ) = 0 where the apparent vertical tilts by τ. For a wave
of frequency Ω

    θ/τ = g (g c − k² Ω²)/D,    φ/τ = g² c/D,    D = e k² (Ω² − ω²)(Ω² − ω′²),

which is 1 while Ω is far below both frequencies ω, ω′ of the modes, and grows without bound at
resonance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tauto_core.machines import AnyMachine, FluidPendulum, HangingMachine, Machine
from tauto_core.machines.axle_pendulum import Modes
from tauto_core.samples import FloatArray
from tauto_core.scene import Scene
from tauto_core.ship.felt_step import case_modes
from tauto_core.voyage_cost import Waves, scene_waves

LARGEST_DEPARTURE = 1.0
"""Departure over the tilt of the apparent vertical, above which the link swings wider than the
apparent vertical itself.
"""
LARGEST_STRETCH = 0.02
"""Largest relative change of the period of small swings by a swinging thread."""
NEAR_PERIOD = 0.05
"""Relative difference of two periods below which they are in resonance."""


@dataclass(frozen=True)
class Following:
    """The response of a link that hangs on the ship.

    Attributes:
        periods_s: periods of its modes, the slower first [s].
        departure_rad: rms of its departure from the apparent vertical [rad].
        departure: the same over the rms tilt of the apparent vertical; None where that does not
            tilt, or the motion is measured.
        resonates_with: `wheel`, `waves`, both or neither.
    """

    periods_s: tuple[float, ...]
    departure_rad: float | None
    departure: float | None
    resonates_with: tuple[str, ...]


def lengths_between(
    scene: Scene, machine: AnyMachine | FluidPendulum
) -> tuple[float, float | None] | None:
    """Return g/ω² and g/Ω² [m], between which an ideal vertical thread is a fair model.

    ω is the wheel's frequency on an ideal thread. Ω⁴ is the mean over the waves, weighted by the
    tilt of the apparent vertical; the second length is None as for `Following.departure`.

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
    """Return how a thread that swings follows the apparent vertical by its inclination θ.

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
    """Return how a suspended case follows the apparent vertical by its tilt φ.

    Args:
        scene: the scene of the machine.
        machine: the machine whose wheel the case may drive.

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
    """Return θ/τ and φ/τ for each wave; at resonance the size that they reach in the duration.

    Args:
        own: modes of the link.
        depth: c [m].
        k_squared: k² [m2].
        frequency: Ω of the waves [rad/s].
        gravity: g [m/s2].
        duration_s: duration of the waves [s].
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
    """Return the rms of a value over the waves, weighted by their tilts; None without tilts."""
    size = float(np.linalg.norm(waves.sway))
    return float(np.linalg.norm(waves.sway * value)) / size if size else None
