"""The amplitude of the wheel and whether it still swings, from the topics alone."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np

from tauto_core.clockwork.trochlea import PHASE_NAMES
from tauto_core.machines import AnyMachine, FluidPendulum, compile_machine
from tauto_core.machines.amplitude import amplitude_of, recoil_energy, swing_energy
from tauto_core.samples import (
    JOINT_STATES,
    NS_PER_S,
    PHASE,
    FloatArray,
    JointSamples,
    Samples,
)
from tauto_core.scene import Scene

LAST_SWINGS = 100
"""Number of logged samples at the end whose mean energy gives the amplitude."""

SILENCE_PERIODS = 2.0
"""Number of periods of small swings without a beat, or without an impulse, after which a clock
counts as stopped.
"""


class SwingTally:
    """Amplitude at the end, and the time at which the clock stopped, over all batches fed.

    At sea the wheel's motion in its case is treated as if the case lay still. So where the swing
    follows the apparent vertical, a tilt τ of the apparent vertical adds ⟨τ²⟩ to its square.

    Args:
        scene: the scene of the clock.
        machine: the regulator of the scene, if it has been built already.
    """

    def __init__(self, scene: Scene, machine: AnyMachine | FluidPendulum | None = None) -> None:
        self._scene, self._built = scene, machine
        self._angle, self._rate = np.empty(0), np.empty(0)
        self._first_ns: int | None = None
        self._last_ns = self._beat_ns = self._reach_ns = 0
        self._beats = 0.0

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take batches of `trochlea/joint_states` and `trochlea/phase`, in order within each."""
        wheel, phase = batches.get(JOINT_STATES), batches.get(PHASE)
        if isinstance(phase, JointSamples) and len(phase.stamp_ns):
            self._feed_phase(phase)
        if isinstance(wheel, JointSamples) and len(wheel.stamp_ns) and self._machine is not None:
            self._feed_wheel(self._machine, wheel)

    def result(self) -> dict[str, float | None]:
        """Return the figures; none for a body in a fluid, or if no sample came.

        Keys: `amplitude_rad` of the last swings; `stopped_s`, time from the start of the last
        logged instant at which the clock still went, None if it still goes.
        """
        machine = self._machine
        if machine is None or not len(self._angle):
            return {}
        energy = swing_energy(machine, self._angle, self._rate)
        energy = energy + recoil_energy(machine, self._angle, self._rate)
        return {
            'amplitude_rad': amplitude_of(machine, float(np.mean(energy))),
            'stopped_s': self._stopped(machine),
        }

    @cached_property
    def _machine(self) -> AnyMachine | None:
        machine = self._built or compile_machine(self._scene)
        return None if isinstance(machine, FluidPendulum) else machine

    @cached_property
    def _needed(self) -> float:
        """Energy of the smallest swing that reaches the impulse on either side [J]."""
        escapement = self._scene.escapement
        if self._machine is None or escapement is None or escapement.angle == 0.0:
            return 0.0
        sides = np.array([escapement.angle, -escapement.angle])
        return float(np.min(swing_energy(self._machine, sides, np.zeros(2))))

    def _feed_phase(self, phase: JointSamples) -> None:
        beats: FloatArray = phase.position[:, phase.name.index(PHASE_NAMES[3])]
        if self._first_ns is None:
            self._begin(int(phase.stamp_ns[0]))
        more = np.flatnonzero(np.diff(beats, prepend=self._beats) > 0.0)
        if len(more):
            self._beat_ns = int(phase.stamp_ns[more[-1]])
        self._beats = float(beats[-1])
        self._last_ns = max(self._last_ns, int(phase.stamp_ns[-1]))

    def _feed_wheel(self, machine: AnyMachine, wheel: JointSamples) -> None:
        angle, rate = wheel.position[:, 0], wheel.velocity[:, 0]
        if self._first_ns is None:
            self._begin(int(wheel.stamp_ns[0]))
        if self._needed > 0.0:
            far = np.flatnonzero(swing_energy(machine, angle, rate) >= self._needed)
            if len(far):
                self._reach_ns = int(wheel.stamp_ns[far[-1]])
        else:
            self._reach_ns = int(wheel.stamp_ns[-1])
        self._angle = np.concatenate([self._angle, angle])[-LAST_SWINGS:]
        self._rate = np.concatenate([self._rate, rate])[-LAST_SWINGS:]
        self._last_ns = max(self._last_ns, int(wheel.stamp_ns[-1]))

    def _begin(self, first_ns: int) -> None:
        self._first_ns = self._last_ns = self._beat_ns = self._reach_ns = first_ns

    def _stopped(self, machine: AnyMachine) -> float | None:
        went_ns = min(self._beat_ns, self._reach_ns)
        silent_s = (self._last_ns - went_ns) / NS_PER_S
        if silent_s <= SILENCE_PERIODS * machine.small_period:
            return None
        return (went_ns - (self._first_ns or 0)) / NS_PER_S
