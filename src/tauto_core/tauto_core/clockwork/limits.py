"""Motions of the regulator that no machine can have; readings from them are refused."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.machines import FluidPendulum, compile_machine
from tauto_core.samples import NS_PER_S, ImuSamples, JointSamples, State
from tauto_core.scene import Scene
from tauto_core.scene.errors import PropagationError
from tauto_core.ship.imu import attitude

MOST_RELEASES = math.tau
"""Largest amplitude that is accepted, as a multiple of the release: a whole turn for a release of
1 rad.
"""

GROWTH_MARGIN = 2.0
"""Allowance for impulses and for swings that are not harmonic."""
GROWTH_RELEASES = 0.25
"""Growth from one reading to the next that is always accepted, as a share of the release."""


class Limits:
    """Checks the amplitude A = √(θ² + (θ̇/ω)²) and its growth from reading to reading.

    A harmonic wheel whose neutral line is inclined by γ obeys θ̈ = −ω² (θ − γ), so dA/dt ≤ ω |γ|.
    More growth than this, with the largest inclination that the sensor has shown, would violate
    the conservation of energy.

    Args:
        scene: the scene of the machine.
    """

    def __init__(self, scene: Scene) -> None:
        machine = compile_machine(scene)
        self._frequency = math.tau / machine.small_period
        self._moves = not scene.lies_still
        if isinstance(machine, FluidPendulum):
            self._release, self._moves = abs(machine.release_arc), False
        else:
            self._release = max(1.0, abs(machine.release_angle))
        self.begin()

    def begin(self) -> None:
        """Begin a run: the first reading may have any amplitude up to the largest."""
        self._stamp_ns: int | None = None
        self._amplitude = 0.0
        self._felt_ns, self._tilt = np.empty(0, np.int64), np.zeros(1)

    def feel(self, imu: ImuSamples) -> None:
        """Take the next motion samples; a reading is never checked against later ones."""
        motion = attitude(imu)
        tilt = np.maximum(np.abs(motion.roll), np.abs(np.arctan2(motion.force_y, motion.force_z)))
        self._felt_ns = np.concatenate([self._felt_ns, imu.stamp_ns])
        self._tilt = np.maximum.accumulate(np.concatenate([self._tilt, tilt]))

    def check(self, wheel: JointSamples, origin_ns: int) -> None:
        """Take the next readings of a run.

        Args:
            wheel: at least one sample of `trochlea/joint_states`.
            origin_ns: stamp of the start of the run.

        Raises:
            PropagationError: an impossible motion.
        """
        size = np.hypot(wheel.position[:, 0], wheel.velocity[:, 0] / self._frequency)
        most = MOST_RELEASES * self._release
        allowed = np.full(len(size), most)
        known = self._stamp_ns is not None
        felt = np.searchsorted(self._felt_ns, wheel.stamp_ns, 'right')
        tilt = self._tilt[felt]
        if self._moves:
            stamps = np.concatenate([[self._stamp_ns or 0], wheel.stamp_ns])
            before = np.concatenate([[self._amplitude], size[:-1]])
            elapsed_s = np.diff(stamps) / NS_PER_S
            growth = GROWTH_MARGIN * tilt * (1.0 + self._frequency * elapsed_s)
            growth += GROWTH_RELEASES * self._release
            rows = slice(0 if known else 1, None)
            allowed[rows] = np.minimum(most, (before + growth)[rows])
        wrong = np.flatnonzero(~(size <= allowed))  # also true for NaN
        if len(wrong):
            at = int(wrong[0])
            raise PropagationError(
                f'the wheel swings to {size[at]:.6g}, at most {allowed[at]:.6g} can be (released '
                f'at {self._release:.6g}, motion inclined by up to {tilt[at]:.6g} rad). Check the '
                'stamps of ship/imu and the rate of the scene',
                (int(wheel.stamp_ns[at]) - origin_ns) / NS_PER_S,
            )
        self._stamp_ns, self._amplitude = int(wheel.stamp_ns[-1]), float(size[-1])
        self._felt_ns, self._tilt = self._felt_ns[felt[-1] :], self._tilt[felt[-1] :]

    def state(self) -> State:
        """Return the last reading, and the motion since."""
        return {
            'stamp_ns': self._stamp_ns,
            'amplitude': self._amplitude,
            'felt_ns': self._felt_ns,
            'tilt': self._tilt,
        }

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._stamp_ns, self._amplitude = state['stamp_ns'], state['amplitude']
        self._felt_ns, self._tilt = state['felt_ns'], state['tilt']
