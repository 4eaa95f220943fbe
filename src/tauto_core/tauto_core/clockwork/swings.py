"""The amplitude of the wheel and whether it still swings, from the topics alone."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np

from tauto_core.clockwork.trochlea import PHASE_NAMES
from tauto_core.machines import AnyMachine, FluidPendulum, compile_machine
from tauto_core.machines.compiling import amplitude_of, nearest_period, recoil_energy, swing_energy
from tauto_core.samples import (
    JOINT_STATES,
    NS_PER_S,
    PHASE,
    FloatArray,
    JointSamples,
    Samples,
)
from tauto_core.scene import Scene
from tauto_core.wording import significant

LAST_SWINGS = 100
"""Number of logged samples at the end whose mean energy gives the amplitude."""

SILENCE_PERIODS = 2.0
"""Number of periods, at the amplitude reached, without a beat, or with too little energy, after
which a clock counts as stopped. A swing beats twice a period.
"""

THERMAL_ENERGY_J = 1.380649e-23 * 293.0
"""Mean energy of a wheel that only the warmth of a room moves, k_B T [J]; the swing of a clock
with less has died away.
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
        self._short_ns: int | None = None
        self._beats = 0.0

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take batches of `trochlea/joint_states` and `trochlea/phase`, in order within each."""
        wheel, phase = batches.get(JOINT_STATES), batches.get(PHASE)
        if isinstance(phase, JointSamples) and len(phase.stamp_ns):
            self._feed_phase(phase)
        if isinstance(wheel, JointSamples) and len(wheel.stamp_ns) and self._machine is not None:
            self._feed_wheel(self._machine, wheel)

    def result(self) -> dict[str, float | str | None]:
        """Return the figures; none for a body in a fluid, or if no sample came.

        Keys: `amplitude_rad` of the last swings; `stopped_s`, time from the start of the last
        logged instant at which the clock still went, and `stopped_why`, the reason as a clause.
        These two are None if it still goes.
        """
        machine = self._machine
        if machine is None or not len(self._angle):
            return {}
        energy = swing_energy(machine, self._angle, self._rate)
        energy = energy + recoil_energy(machine, self._angle, self._rate)
        amplitude = amplitude_of(machine, float(np.mean(energy)))
        stopped_s, why = self._stopped(machine, amplitude)
        return {'amplitude_rad': amplitude, 'stopped_s': stopped_s, 'stopped_why': why}

    @cached_property
    def _machine(self) -> AnyMachine | None:
        machine = self._built or compile_machine(self._scene)
        return None if isinstance(machine, FluidPendulum) else machine

    @cached_property
    def _needed(self) -> float:
        """Energy of the smallest swing with which a clock goes [J].

        It reaches the impulse on either side, and exceeds the thermal energy.
        """
        escapement = self._scene.escapement
        if self._machine is None or escapement is None:
            return THERMAL_ENERGY_J
        sides = np.array([escapement.angle, -escapement.angle])
        return max(
            float(np.min(swing_energy(self._machine, sides, np.zeros(2)))), THERMAL_ENERGY_J
        )

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
        if swing_energy(machine, angle[-1:], rate[-1:])[0] >= self._needed:
            self._reach_ns, self._short_ns = int(wheel.stamp_ns[-1]), None
        else:
            far = np.flatnonzero(swing_energy(machine, angle, rate) >= self._needed)
            if len(far):
                self._reach_ns = int(wheel.stamp_ns[far[-1]])
            if len(far) or self._short_ns is None:
                self._short_ns = int(wheel.stamp_ns[far[-1] + 1 if len(far) else 0])
        self._angle = np.concatenate([self._angle, angle])[-LAST_SWINGS:]
        self._rate = np.concatenate([self._rate, rate])[-LAST_SWINGS:]
        self._last_ns = max(self._last_ns, int(wheel.stamp_ns[-1]))

    def _begin(self, first_ns: int) -> None:
        self._first_ns = self._last_ns = self._beat_ns = self._reach_ns = first_ns

    def _stopped(self, machine: AnyMachine, amplitude: float) -> tuple[float | None, str | None]:
        """Return when the clock stopped, from the start [s], and why; None if it still goes.

        A period is that at the amplitude reached: on a wide swing of a heavy weight it may be many
        times that of small swings.
        """
        allowed_s = SILENCE_PERIODS * nearest_period(machine, amplitude)
        ends: list[tuple[int, str]] = []
        if (self._last_ns - self._beat_ns) / NS_PER_S > allowed_s:
            ends.append((self._beat_ns, 'from then on the wheel did not pass the middle'))
        # The counter shows a beat wherever it lies between two logged instants. The energy is
        # known at logged instants alone, so that a single one with too little proves nothing.
        short_ns = self._last_ns if self._short_ns is None else self._short_ns
        if (self._last_ns - short_ns) / NS_PER_S > allowed_s:
            why = 'its swing had died away'
            escapement = self._scene.escapement
            if escapement is not None and self._needed > THERMAL_ENERGY_J:
                angle = significant(escapement.angle)
                why = f'its swing had become too small to reach the impulse, at {angle} rad'
            ends.append((self._reach_ns, why))
        if not ends:
            return None, None
        went_ns, why = min(ends)
        return (went_ns - (self._first_ns or 0)) / NS_PER_S, why
