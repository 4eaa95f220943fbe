"""The trochlea as a stage: ship motion in, wheel, phase and reading out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from tauto_core.clockwork.dial import DIAL, dial_ns
from tauto_core.machines import AnyMachine, FluidPendulum, compile_machine
from tauto_core.motion import Motion, make_propagator, steps_in
from tauto_core.samples import (
    JOINT_STATES,
    PHASE,
    READING,
    SHIP_IMU,
    Batches,
    FloatArray,
    ImuSamples,
    IntArray,
    JointSamples,
    PlanarImu,
    Samples,
    State,
    TimeSamples,
    same,
)
from tauto_core.scene import Scene
from tauto_core.scene.errors import PropagationError
from tauto_core.scene.times import MAX_GAP_S
from tauto_core.ship.buffer import MotionBuffer, felt_step_ns, samples_a_piece
from tauto_core.ship.imu import screen

if TYPE_CHECKING:
    from tauto_core.clockwork.dial_noise import DialNoise
    from tauto_core.ship.suspension import Suspension

WHEEL_NAMES = ('wheel',)
BODY_NAMES = ('body',)
PHASE_NAMES = ('phase', 'half_turns', 'half_turn_fraction', 'beats')
WHEEL_FRAME = 'clock_case'


class TrochleaStage:
    """The regulator and its dial, driven by the stamps of `ship/imu`.

    Steps begin at samples, and span several where these are evenly spaced. They wait for the
    neighbours that interpolation needs (up to four samples), and end at samples and logged
    instants. Bad samples are counted and left out (`screen`). Where the scene has a suspension,
    the clock feels the motion of its case, four samples later.

    Args:
        scene: the scene to simulate; its motion comes through `feed`.
        anchor: 'scene': the first stamp must be `starts_at`, and the run ends with the scene.
            'first': time starts at the first stamp, and the run has no end.
        machine: the regulator of the scene, if it has been built already.

    Raises:
        SceneError: the machine cannot be built, or its suspension.
    """

    inputs: ClassVar[tuple[str, ...]] = (SHIP_IMU,)
    outputs: ClassVar[tuple[str, ...]] = (JOINT_STATES, PHASE, READING)

    def __init__(
        self,
        scene: Scene,
        anchor: Literal['scene', 'first'] = 'scene',
        machine: AnyMachine | FluidPendulum | None = None,
    ) -> None:
        self._scene = scene
        self._anchor = anchor
        self._still = scene.lies_still
        self._machine = compile_machine(scene) if machine is None else machine
        tolerance = scene.solver.tolerance if scene.solver else None
        self._propagator = make_propagator(self._machine, still=self._still, tolerance=tolerance)
        self._nominal_s = scene.clock.nominal_period or self._machine.small_period
        self._buffer = MotionBuffer(
            apparent_vertical=self._machine.follows_apparent_vertical,
            apparent_gravity=self._machine.feels_gravity,
            still=self._still,
            step_ns=felt_step_ns(scene),
            max_gap_s=None if self._still else MAX_GAP_S,
            stride=samples_a_piece(scene, steps_in(self._propagator)),
            smooth=anchor == 'scene' and scene.ship.is_computed,
            by_samples=self._propagator.name == 'forced_harmonic',
        )
        self._suspension: Suspension | None = None
        if scene.suspension is not None:
            from tauto_core.ship.suspension import Suspension

            self._suspension = Suspension(scene, max_gap_s=MAX_GAP_S)
        self._noise: DialNoise | None = None
        if scene.clock.is_noisy:
            from tauto_core.clockwork.dial_noise import DialNoise

            self._noise = DialNoise(scene)
        self._log_ns = scene.log_interval_ns
        self._end_ns = scene.duration_ns if anchor == 'scene' else None
        self._origin_ns: int | None = None
        self._last_stamp: int | None = None
        self._released = False
        self._refused: dict[str, int] = {}

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Take motion samples; return the samples that are known by now.

        Raises:
            PropagationError: slack thread, edge of the cam, a case that leaves its bearing, a
                gap in the motion, a start that is not the scene's.
        """
        imu = batches.get(SHIP_IMU)
        if not isinstance(imu, ImuSamples | PlanarImu) or not len(imu.stamp_ns):
            return {}
        if isinstance(imu, ImuSamples):
            imu = self._screened(imu)
        if not len(imu.stamp_ns):
            return {}
        if self._origin_ns is None:
            self._begin(int(imu.stamp_ns[0]))
        self._last_stamp = int(imu.stamp_ns[-1])
        origin_ns = self._origin_ns or 0
        if self._suspension is None:
            self._buffer.add(imu, origin_ns)
        else:
            self._feel(self._suspension.feed(imu, origin_ns))
        return self._advance(final=False)

    def _screened(self, imu: ImuSamples) -> ImuSamples:
        """Return the samples that can be integrated; count the others."""
        imu, refused = screen(imu, self._last_stamp, compiled=not self._still)
        for name, number in refused.items():
            self._refused[name] = self._refused.get(name, 0) + number
        return imu

    def finish(self) -> Batches:
        """Return the remaining samples, interpolated with one-sided windows."""
        if self._suspension is not None:
            self._feel(self._suspension.finish(self._origin_ns or 0))
        return self._advance(final=True)

    def _feel(self, case: ImuSamples | None) -> None:
        """Take the readings of a sensor in the suspended case."""
        if case is not None:
            self._buffer.add(case, self._origin_ns or 0)

    def _begin(self, first_ns: int) -> None:
        starts_at = self._scene.starts_at_ns
        if self._anchor == 'scene' and first_ns != starts_at:
            raise PropagationError(
                f'the first motion sample is stamped {first_ns} ns, the scene starts at '
                f'{starts_at} ns. Send the motion from its start, or let its first stamp '
                'be the start: source:=foreign for every node, LiveTrochlea in Python',
                (first_ns - starts_at) * 1e-9,
            )
        self._origin_ns = first_ns

    def _advance(self, *, final: bool) -> Batches:
        forcing = self._buffer.forcing(self._log_ns, self._end_ns, final=final)
        if forcing is None:
            return {}
        parts: list[tuple[IntArray, Motion]] = []
        if not self._released:
            self._released = True
            parts.append((np.zeros(1, np.int64), self._propagator.release(forcing)))
        parts.append((forcing.end_ns[forcing.logged], self._propagator.advance(forcing)))
        times = np.concatenate([times for times, _ in parts])
        motions = [motion for _, motion in parts]
        return self._messages(times + (self._origin_ns or 0), motions) if len(times) else {}

    def _reading_ns(
        self, stamps: IntArray, half_turns: IntArray, fraction: FloatArray
    ) -> IntArray:
        """Return the readings of the dial, with its noise if the scene has any."""
        origin_ns = self._origin_ns or 0
        reading = origin_ns + dial_ns(half_turns, fraction, self._nominal_s)
        if self._noise is None:
            return reading
        return reading + self._noise.offsets_ns((stamps - origin_ns) // self._log_ns)

    def _messages(self, stamps: IntArray, motions: list[Motion]) -> Batches:
        def column(name: str) -> np.ndarray:
            return np.concatenate([getattr(motion, name) for motion in motions])

        half_turns, fraction = column('half_turns'), column('fraction')
        phase_rate = column('phase_rate')
        zero = np.zeros(len(stamps))
        phase = np.stack(
            [np.pi * (half_turns + fraction), half_turns, fraction, column('beats')], axis=1
        )
        speeds = np.stack([phase_rate, zero, phase_rate / np.pi, zero], axis=1)
        reading = self._reading_ns(stamps, half_turns, fraction)
        return {
            JOINT_STATES: JointSamples(
                stamps,
                WHEEL_FRAME,
                BODY_NAMES if isinstance(self._machine, FluidPendulum) else WHEEL_NAMES,
                column('angle')[:, None],
                column('rate')[:, None],
                column('torque')[:, None],
            ),
            PHASE: JointSamples(
                stamps, WHEEL_FRAME, PHASE_NAMES, phase, speeds, np.empty((len(stamps), 0))
            ),
            READING: TimeSamples(stamps, WHEEL_FRAME, reading, same(DIAL, len(stamps))),
        }

    def state(self) -> State:
        """Return all that the next output depends on."""
        return {
            'origin_ns': self._origin_ns,
            'last_stamp': self._last_stamp,
            'released': self._released,
            'refused': dict(self._refused),
            'buffer': self._buffer.state(),
            'propagator': self._propagator.state(),
            **({'suspension': self._suspension.state()} if self._suspension else {}),
            **({'noise': self._noise.state()} if self._noise else {}),
        }

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._origin_ns = state['origin_ns']
        self._last_stamp = state['last_stamp']
        self._released = state['released']
        self._refused = dict(state['refused'])
        self._buffer.restore(state['buffer'])
        self._propagator.restore(state['propagator'])
        if self._suspension is not None:
            self._suspension.restore(state['suspension'])
        if self._noise is not None:
            self._noise.restore(state['noise'])

    def health(self) -> dict[str, int]:
        """Return the numbers of samples refused, by reason, or left out, and of gaps bridged."""
        first = self._suspension or self._buffer
        return {**self._refused, 'crowded': first.crowded, 'bridged_gaps': first.bridged}
