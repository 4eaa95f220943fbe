"""The dial, and the trochlea as a stage: ship motion in, wheel, phase and reading out."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np

from tauto_core.machines import (
    AnyMachine,
    LeverMachine,
    Machine,
    OtherRegulator,
    SteadySwing,
    compile_machine,
    rate_s_per_day,
    steady_swing,
)
from tauto_core.machines.compiling import amplitude_of, nearest_period, recoil_energy, swing_energy
from tauto_core.machines.heat import Heat
from tauto_core.motion import Forcing, Motion, asked_tolerance, make_propagator, steps_in
from tauto_core.motion.forcing import Temperatures
from tauto_core.samples import (
    JOINT_STATES,
    PHASE,
    READING,
    SHIP_IMU,
    SHIP_TEMPERATURE,
    SLACK,
    Batches,
    FloatArray,
    HungImu,
    ImuSamples,
    IntArray,
    JointSamples,
    Samples,
    SpatialImu,
    State,
    Stateful,
    TemperatureSamples,
    TimeSamples,
    same,
    scalars,
)
from tauto_core.scene import Scene
from tauto_core.scene.errors import PropagationError
from tauto_core.scene.times import DAY_S, MAX_GAP_S, NS_PER_S
from tauto_core.ship.airs import BoxTemperature
from tauto_core.ship.buffer import (
    BufferInCommon,
    MotionBuffer,
    SharedBuffers,
    samples_a_piece,
    sensed_step_ns,
)
from tauto_core.ship.imu import Sensed, message, parted, screen
from tauto_core.wording import significant

if TYPE_CHECKING:
    from tauto_core.motion.slack import Tautening
    from tauto_core.ship.suspension import CaseInCommon, Suspension

# -----------------------------------------------------------------------------
# The reading of the dial. Whole half turns and the fraction are kept apart.


def dial_ns(half_turns: IntArray, fraction: FloatArray, nominal_period_s: float) -> IntArray:
    """Return the reading [ns] since the dial was set: nominal_period · φ / 2π.

    The phase φ is π (half_turns + fraction), 0 ≤ fraction < 1. The whole part is computed with
    integers: long runs lose no resolution (theory/reading.md).
    """
    half_period = 0.5 * nominal_period_s * NS_PER_S
    full = math.floor(half_period)
    part = half_period - full
    # With blocks of 2²⁰ half turns the product with the rest is exact to far below 1 ns.
    blocks, remainder = np.divmod(half_turns, 2**20)
    block_ns = part * 2**20
    whole_block = math.floor(block_ns)
    small = blocks * (block_ns - whole_block) + remainder * part + fraction * half_period
    return np.asarray(
        half_turns * full + blocks * whole_block + np.rint(small).astype(np.int64), np.int64
    )


def at_departure(
    scene: Scene, machine: AnyMachine | OtherRegulator
) -> AnyMachine | OtherRegulator:
    """Return the machine at the temperature of the clock at the start of the scene."""
    if scene.air is None or isinstance(machine, OtherRegulator):
        return machine
    return machine.at_celsius(float(BoxTemperature(scene).at(np.zeros(1, np.int64))[0]))


STALE_S_PER_DAY = 60.0
"""Rate on land above which a stated nominal period is perhaps another machine's [s/day]."""


def nominal_period_s(scene: Scene, machine: AnyMachine | OtherRegulator) -> float:
    """Return the time by which the dial advances in a full swing [s].

    If the scene does not state it, the dial is right at the start, in its gravity and temperature.
    """
    return scene.clock.nominal_period or regulated_period_s(at_departure(scene, machine))


def regulated_period_s(machine: AnyMachine | OtherRegulator) -> float:
    """Return the period of the steady swing, or of small swings if there is no steady one [s]."""
    return _steady_period_s(machine) or machine.small_period


def _steady_period_s(machine: AnyMachine | OtherRegulator) -> float | None:
    swing = steady_swing(machine) if isinstance(machine, Machine | LeverMachine) else None
    return swing.period if isinstance(swing, SteadySwing) else None


def on_first_day(
    scene: Scene, machine: AnyMachine | OtherRegulator
) -> AnyMachine | OtherRegulator:
    """Return the machine at the mean temperature of the first day."""
    if scene.air is None or isinstance(machine, OtherRegulator):
        return machine
    first_day = np.arange(0, math.ceil(DAY_S * NS_PER_S / scene.log_interval_ns))
    return machine.at_celsius(float(BoxTemperature(scene).at(first_day).mean()))


def stale_dial(scene: Scene, machine: AnyMachine | OtherRegulator) -> list[str]:
    """Return a warning if a stated nominal period is not the machine's.

    It must differ by more than `STALE_S_PER_DAY` from both the steady swing and small swings.
    """
    stated_s, machine_now = scene.clock.nominal_period, on_first_day(scene, machine)
    own_s = None if stated_s is None else _steady_period_s(machine_now)
    if stated_s is None or own_s is None:
        return []
    rate = rate_s_per_day(own_s, stated_s)
    if min(abs(rate), abs(rate_s_per_day(machine_now.small_period, stated_s))) <= STALE_S_PER_DAY:
        return []
    gains = 'gains' if rate > 0.0 else 'loses'
    return [
        f'clock.nominal_period = {stated_s:.9g}: the steady swing takes {own_s:.9g} s, so the '
        f'dial {gains} {abs(rate):,.0f} s a day. Leave it out to regulate the dial.'
    ]


# -----------------------------------------------------------------------------
# Noise of the dial: white and random-walk frequency noise, in exact discrete form
# (theory/reading.md).

NOISE_BLOCK = 4096
"""Number of log indices drawn from one generator. The result depends on it."""

STREAM = 0x6469616C
"""Number of the dial's random stream, from the scene's seed ("dial" in ASCII)."""


class DialNoise(Stateful):
    """Noise that is added to the reading: phase x [s] and relative rate y over log intervals τ.

    x' = x + τ y + w₁ and y' = y + w₂. The noises w₁ and w₂ are normal with the covariance

        | q1 τ + q2 τ³/3   q2 τ²/2 |
        | q2 τ²/2          q2 τ    |

    of the integrals over τ of ẋ = y + white noise (q1), ẏ = white noise (q2): Zucca and Tavella,
    Metrologia 42 (2005) 289. x = y = 0 at log index 0, when the dial is set. The normal numbers of
    an index depend only on the seed and the index.

    Args:
        scene: its `clock.white_fm`, `clock.random_walk_fm`, `log.interval` and `seed`.
    """

    state_names = ('index', 'x', 'y')

    def __init__(self, scene: Scene) -> None:
        self._seed = scene.seed
        tau = scene.log_interval_ns / NS_PER_S
        q1, q2 = scene.clock.white_fm_s, scene.clock.random_walk_fm_per_s
        self._tau = tau
        # w₁ is half of τ w₂ and an independent part of the variance q1 τ + q2 τ³ (1/3 − 1/4)
        self._own_sigma = math.sqrt(q1 * tau + q2 * tau**3 / 12.0)
        self._rate_sigma = math.sqrt(q2 * tau)
        self._index, self._x, self._y = 0, 0.0, 0.0
        self._block, self._normals = -1, np.empty((0, 2))

    def offsets_ns(self, index: IntArray) -> IntArray:
        """Return the noise of the readings [ns] at rising log indices, from the last one on."""
        begin = self._index
        x, _ = self.advance(int(index[-1]))
        return np.rint(NS_PER_S * x[index - begin]).astype(np.int64)

    def advance(self, top: int) -> tuple[FloatArray, FloatArray]:
        """Return x [s] and y from the current index to `top`, both included."""
        start, parts = self._index + 1, [np.empty((0, 2))]
        for block in range(start // NOISE_BLOCK, top // NOISE_BLOCK + 1) if start <= top else ():
            if block != self._block:
                seeds = np.random.SeedSequence(self._seed, spawn_key=(STREAM, block))
                generator = np.random.Generator(np.random.PCG64(seeds))
                self._block, self._normals = block, generator.standard_normal((NOISE_BLOCK, 2))
            begin, end = max(start - block * NOISE_BLOCK, 0), top + 1 - block * NOISE_BLOCK
            parts.append(self._normals[begin:end])
        normal = np.concatenate(parts)
        steps = self._rate_sigma * normal[:, 1]
        y = np.cumsum(np.concatenate(([self._y], steps)))
        phase_noise = self._own_sigma * normal[:, 0] + (0.5 * self._tau) * steps
        x = np.cumsum(np.concatenate(([self._x], self._tau * y[:-1] + phase_noise)))
        self._index, self._x, self._y = top, float(x[-1]), float(y[-1])
        return x, y


# -----------------------------------------------------------------------------
# The description of a dial on a live sensor: when it was set, and how much it has lost.

DIAL = 'dial'

_TIME = r'(-?\d+)\.(\d{9})'
_PATTERN = re.compile(
    rf'{DIAL}, set {_TIME} s(?:, setting (\d+))?(?:, lost {_TIME} s in (\d+) stops)?'
    rf'(?:, unsure by {_TIME} s)?'
)


@dataclass(frozen=True)
class DialSetting:
    """The setting of a dial, and for how long it has stood still since.

    Args:
        set_ns: true time at which it was set to this time [ns].
        lost_ns: time for which it has stood still [ns].
        stops: number of times that it has stood still.
        number: number of the setting, from 1.
        unsure_ns: sum of the steps back of its stamps, after breaks of unknown duration [ns].
    """

    set_ns: int
    lost_ns: int = 0
    stops: int = 0
    number: int = 1
    unsure_ns: int = 0

    def is_same_as(self, setting: DialSetting) -> bool:
        """Return whether the dial has not been set in between. It may have stood still."""
        return (self.set_ns, self.number) == (setting.set_ns, setting.number)

    def source(self) -> str:
        """Return the text of `TimeReference.source`."""
        lost = f', lost {_spelled(self.lost_ns)} s in {self.stops} stops' if self.stops else ''
        number = f', setting {self.number}' if self.number > 1 else ''
        unsure = f', unsure by {_spelled(self.unsure_ns)} s' if self.unsure_ns else ''
        return f'{DIAL}, set {_spelled(self.set_ns)} s{number}{lost}{unsure}'

    @staticmethod
    def of(source: str) -> DialSetting | None:
        """Return the setting that a source describes, or `None`."""
        match = _PATTERN.fullmatch(source)
        if match is None:
            return None
        set_s, set_ns, number, lost_s, lost_ns, stops, *unsure = match.groups('0')
        lost, count = _ns(lost_s, lost_ns), int(stops)
        return DialSetting(_ns(set_s, set_ns), lost, count, int(number) or 1, _ns(*unsure))


def _spelled(time_ns: int) -> str:
    seconds, fraction = divmod(abs(time_ns), NS_PER_S)
    return f'{"-" if time_ns < 0 else ""}{seconds}.{fraction:09d}'


def _ns(seconds: str, fraction: str) -> int:
    size = int(seconds.lstrip('-')) * NS_PER_S + int(fraction)
    return -size if seconds.startswith('-') else size


# -----------------------------------------------------------------------------
# The stage.

WHEEL_NAMES = ('wheel',)
BODY_NAMES = ('body',)
NOTHING_YET = -(2**63)
"""Stamp of the last temperature before the first one."""

MOST_CELSIUS = 100.0
"""Largest absolute temperature of a clock [°C]."""

PHASE_NAMES = ('phase', 'half_turns', 'half_turn_fraction', 'beats')
SLACK_NAMES = ('slacks', 'slack_s', 'lost_joule')
WHEEL_FRAME = 'clock_case'


class Warmth(Stateful):
    """The known temperatures of the clock at the logged instants, as long as they are needed.

    Args:
        heat: how the machine changes.
        log_ns: time between logged instants [ns].
    """

    state_names = ('known_ns', 'first', 'celsius')

    def __init__(self, heat: Heat, log_ns: int) -> None:
        self.varies = heat.varies and heat.feels_temperature
        self.known_ns = NOTHING_YET
        self._log_ns, self._at_celsius = log_ns, heat.at_celsius
        self._celsius, self._first = np.empty(0), 0

    def add(self, samples: TemperatureSamples) -> None:
        """Take the temperatures of the next logged instants.

        Raises:
            PropagationError: a stamp that is not one log interval after the last, or an
                impossible temperature.
        """
        if not len(samples.stamp_ns):
            return
        first_ns = int(samples.stamp_ns[0])
        expected_ns = first_ns if self.known_ns == NOTHING_YET else self.known_ns + self._log_ns
        stamps = expected_ns + self._log_ns * np.arange(len(samples.stamp_ns))
        wrong = (samples.stamp_ns != stamps) | ~(np.abs(samples.temperature) < MOST_CELSIUS)
        if np.any(wrong):
            at = int(np.argmax(wrong))
            raise PropagationError(
                f'ship/temperature has {samples.temperature[at]:.6g} °C at {samples.stamp_ns[at]} '
                f'ns. The next logged instant is {stamps[at]} ns, and temperatures are within '
                f'±{MOST_CELSIUS:g} °C. Send one for each logged instant, in °C',
                float((stamps[at] - first_ns) * 1e-9),
            )
        self._celsius = np.concatenate([self._celsius, samples.temperature])
        self.known_ns = int(stamps[-1])

    def over(self, forcing: Forcing) -> Temperatures:
        """Return the temperatures over the spans, and drop earlier ones."""
        logs = (forcing.end_ns - 1) // self._log_ns
        begin, end = int(logs[0]), int(logs[-1])
        if self.varies:
            self._celsius, self._first = self._celsius[begin - self._first :], begin
            ends = self._celsius[: end - begin + 2]
        else:
            ends = np.full(end - begin + 2, self._at_celsius)
        log_s = self._log_ns * 1e-9
        end_s = np.asarray((forcing.end_ns - logs * self._log_ns) * 1e-9, np.float64)
        return Temperatures(
            celsius=np.stack([ends[:-1], ends[1:]], axis=1),
            begin_s=np.asarray(np.arange(begin, end + 1) * log_s, np.float64),
            interval_s=log_s,
            interval=logs - begin,
            place=(end_s - forcing.end * forcing.length_s) / log_s,
        )


class TrochleaStage(Stateful):
    """The regulator and its dial, driven by the stamps of `ship/imu`.

    Steps begin at samples, and span several of them if these are evenly spaced. They wait for the
    neighbours that interpolation needs (up to four samples), and end at samples and logged
    instants. Bad samples are counted and left out (`screen`). With a suspension the clock moves
    with its case, four samples later.

    Args:
        scene: the scene to simulate. Its motion comes through `feed`.
        anchor: 'scene': the first stamp must be `starts_at`, and the run ends with the scene.
            'first': time starts at the first stamp, and the run has no end.
        machine: the regulator of the scene, if it has been built already.
        buffers: shared by the clocks that are fed in the same sea in turn, if there are others.

    Attributes:
        nominal_s: time by which the dial advances in a full swing [s].

    Raises:
        SceneError: the machine or its suspension cannot be built.
    """

    state_names = (
        'origin_ns', 'last_stamp', 'released', 'refused', 'slacks', 'taut_ns', 'buffer',
        'propagator', 'suspension', 'noise', 'warmth',
    )  # fmt: skip
    outputs: ClassVar[tuple[str, ...]] = (JOINT_STATES, PHASE, SLACK, READING)

    def __init__(
        self,
        scene: Scene,
        anchor: Literal['scene', 'first'] = 'scene',
        machine: AnyMachine | OtherRegulator | None = None,
        buffers: SharedBuffers | None = None,
    ) -> None:
        self._scene = scene
        self._anchor = anchor
        self._still = scene.lies_still
        self._machine = compile_machine(scene) if machine is None else machine
        heat = None if isinstance(self._machine, OtherRegulator) else self._machine.heat
        self._warmth = Warmth(heat, scene.log_interval_ns) if heat and heat.acts else None
        tolerance = asked_tolerance(
            self._machine,
            accuracy=scene.accuracy,
            tolerance=scene.solver.tolerance if scene.solver else None,
        )
        self._propagator = make_propagator(self._machine, still=self._still, tolerance=tolerance)
        self.nominal_s = nominal_period_s(scene, self._machine)
        max_gap_s = None if self._still else max(MAX_GAP_S, 1.5 * scene.step_ns / NS_PER_S)
        stride = samples_a_piece(scene, steps_in(self._propagator))
        smooth = anchor == 'scene' and scene.ship.is_computed
        self._suspension: Suspension | CaseInCommon | None = None
        settings: dict[str, Any] = {
            'apparent_vertical': self._machine.follows_apparent_vertical,
            'apparent_gravity': self._machine.feels_gravity,
            'plane': 'ship' if scene.trochlea is None else scene.trochlea.thread_plane,
            'still': self._still,
            'step_ns': sensed_step_ns(scene),
            'max_gap_s': max_gap_s,
            'stride': stride,
            'smooth': smooth,
            'by_samples': self._propagator.name == 'forced_harmonic',
            'unbalanced': getattr(self._machine, 'imbalance', None) is not None,
        }
        if scene.suspension is not None:
            from tauto_core.ship.suspension import CaseInCommon, Suspension
        if buffers is None:
            self._buffer: MotionBuffer | BufferInCommon = MotionBuffer(**settings)
            if scene.suspension is not None:
                self._suspension = Suspension(scene, max_gap_s=MAX_GAP_S)
        else:
            waits = self._warmth is not None and self._warmth.varies
            parts: tuple[object, ...] = waits, scene.log_interval_ns, scene.duration_ns, anchor
            if scene.suspension is not None:
                case = CaseInCommon(scene, buffers, parts, max_gap_s=MAX_GAP_S)
                self._suspension, parts = case, case.key
            self._buffer = buffers.buffer(parts, **settings)
        self._noise = DialNoise(scene) if scene.clock.is_noisy else None
        self._log_ns = scene.log_interval_ns
        self._end_ns = scene.duration_ns if anchor == 'scene' else None
        self._origin_ns: int | None = None
        self._last_stamp: int | None = None
        self._waiting: list[Sensed] = []
        self._released = False
        self._refused: dict[str, int] = {}
        self._slacks = self._taut_ns = 0

    @property
    def inputs(self) -> tuple[str, ...]:
        """The motion, and the temperature if the machine depends on it."""
        varies = self._warmth is not None and self._warmth.varies
        return (SHIP_IMU, SHIP_TEMPERATURE) if varies else (SHIP_IMU,)

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Take motion samples and return the samples that are known by now.

        Raises:
            PropagationError: slack thread, edge of the cam, a case that leaves its bearing, a
                gap in the motion, a start other than the scene's, or temperatures at other times
                than the logged instants.
        """
        warmth, samples = self._warmth, batches.get(SHIP_TEMPERATURE)
        if warmth is not None and isinstance(samples, TemperatureSamples):
            warmth.add(samples)
        imu = batches.get(SHIP_IMU)
        if not isinstance(imu, ImuSamples | SpatialImu) or not len(imu.stamp_ns):
            return self._move(None) if self._waiting else {}
        if isinstance(imu, ImuSamples):
            imu, refused = screen(imu, self._last_stamp)
            for name, number in refused.items():
                self._refused[name] = self._refused.get(name, 0) + number
        if not len(imu.stamp_ns):
            return {}
        if self._origin_ns is None:
            first_ns, starts_at = int(imu.stamp_ns[0]), self._scene.starts_at_ns
            if self._anchor == 'scene' and first_ns != starts_at:
                missed_s = (first_ns - starts_at) * 1e-9
                late = (
                    f', and the swing depends on all of the {missed_s:g} s between. Start the '
                    'ship last, or let it wait'
                )
                raise PropagationError(
                    f'the first motion sample is stamped {first_ns} ns, the scene starts at '
                    f'{starts_at} ns{late if missed_s > 0.0 else ""}. Send the motion from its '
                    'start, or let its first stamp be the start: source:=foreign for every node, '
                    'LiveTrochlea in Python',
                    missed_s,
                )
            self._origin_ns = first_ns
        self._last_stamp = int(imu.stamp_ns[-1])
        return self._move(imu)

    def _move(self, imu: Sensed | None) -> Batches:
        """Advance over more motion, as far as the temperature is known."""
        parts, origin_ns = [] if imu is None else [imu], self._origin_ns or 0
        if self._warmth is not None and self._warmth.varies:
            pending, parts, self._waiting = [*self._waiting, *parts], [], []
            for part in pending:
                count = int(np.searchsorted(part.stamp_ns, self._warmth.known_ns, 'right'))
                if 0 < count < len(part.stamp_ns):
                    head, tail = parted(part, count)
                    parts.append(head)
                    self._waiting.append(tail)
                else:
                    (parts if count else self._waiting).append(part)
        if not parts:
            return {}
        for part in parts:
            if self._suspension is None:
                self._buffer.add(part, origin_ns)
            else:
                self._feel(self._suspension.feed(part, origin_ns))
        return self._advance(final=False)

    def finish(self) -> Batches:
        """Return the remaining samples, interpolated with one-sided windows.

        Raises:
            PropagationError: the temperature ends before the motion.
        """
        if self._waiting:
            late_s = (int(self._waiting[0].stamp_ns[0]) - (self._origin_ns or 0)) * 1e-9
            raise PropagationError(
                'ship/temperature ends before ship/imu does. Send a temperature for each logged '
                'instant, up to the first after the motion',
                late_s,
            )
        if self._suspension is not None:
            self._feel(self._suspension.finish(self._origin_ns or 0))
        return self._advance(final=True)

    def _feel(self, case: HungImu | None) -> None:
        if case is not None:
            self._buffer.add(case, self._origin_ns or 0)

    def _advance(self, *, final: bool) -> Batches:
        forcing = self._buffer.forcing(self._log_ns, self._end_ns, final=final)
        if forcing is None:
            return {}
        if self._warmth is not None:
            forcing = replace(forcing, temperatures=self._warmth.over(forcing))
        parts: list[tuple[IntArray, Motion]] = []
        if not self._released:
            self._released = True
            parts.append((np.zeros(1, np.int64), self._propagator.release(forcing)))
        parts.append((forcing.end_ns[forcing.logged], self._propagator.advance(forcing)))
        times = np.concatenate([times for times, _ in parts])
        motions = [motion for _, motion in parts]
        batches = self._messages(times + (self._origin_ns or 0), motions) if len(times) else {}
        tautened: Callable[[], list[Tautening]] = getattr(self._propagator, 'tautened', list)
        stamps, rows = [], []
        for slack_time in tautened():
            stamp_ns = (self._origin_ns or 0) + round(slack_time.time_s * NS_PER_S)
            self._taut_ns = max(stamp_ns, self._taut_ns + 1)
            self._slacks += 1
            stamps.append(self._taut_ns)
            rows.append((self._slacks, slack_time.slack_s, slack_time.lost_joule))
        if not rows:
            return batches
        slack = scalars(np.array(stamps), SLACK_NAMES, np.array(rows, np.float64))
        return {**batches, SLACK: slack}

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
        origin_ns = self._origin_ns or 0
        reading = origin_ns + dial_ns(half_turns, fraction, self.nominal_s)
        if self._noise is not None:
            reading = reading + self._noise.offsets_ns((stamps - origin_ns) // self._log_ns)
        return {
            JOINT_STATES: JointSamples(
                stamps,
                WHEEL_FRAME,
                BODY_NAMES if isinstance(self._machine, OtherRegulator) else WHEEL_NAMES,
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
        """Return everything that the next output depends on."""
        return {**super().state(), 'waiting': [message(part) for part in self._waiting]}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        super().restore(state)
        self._waiting = list(state['waiting'])

    def health(self) -> dict[str, int]:
        """Return the numbers of refused samples by reason, omitted ones, bridged gaps, slacks."""
        stage = self._suspension or self._buffer
        slacks = {'slacks': self._slacks} if self._slacks else {}
        return {**self._refused, 'crowded': stage.crowded, 'bridged_gaps': stage.bridged, **slacks}


# -----------------------------------------------------------------------------
# The amplitude of the wheel, and whether it still swings, from the topics alone.

LAST_SWINGS = 100
"""Number of logged samples at the end of which the mean energy gives the amplitude."""

SILENCE_PERIODS = 2.0
"""Number of periods, at the last amplitude, without a beat or with too little energy after which a
clock has stopped. A swing beats twice a period.
"""

BODY_REST_PERIODS = 4.0
"""Number of small-swing periods after which a body in place of a wheel has stopped, if its phase
is constant to the bit or its energy less than the thermal one. Missing beats prove little: on a
ship that rolls farther than the body swings, it passes the middle only as often as the ship rolls.
"""

THERMAL_ENERGY_J = 1.380649e-23 * 293.0
"""Mean thermal energy of a wheel in a room, k_B T [J]. A swing with less energy has died away."""


class SwingTally:
    """Amplitude at the end, and the time at which the clock stopped, over all batches fed.

    It takes the wheel's motion in its case as if the case were still. If the swing follows the
    apparent vertical, a tilt τ of that adds ⟨τ²⟩ to the amplitude squared.
    """

    def __init__(self, scene: Scene, machine: AnyMachine | OtherRegulator | None = None) -> None:
        self._scene, self._built = scene, machine
        self._angle, self._rate = np.empty(0), np.empty(0)
        self._first_ns: int | None = None
        self._last_ns = self._beat_ns = self._reach_ns = 0
        self._short_ns: int | None = None
        self._beats = 0.0
        self._phase, self._moved_ns = math.nan, 0

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take batches of `trochlea/joint_states` and `trochlea/phase`, in order within each."""
        wheel, phase = batches.get(JOINT_STATES), batches.get(PHASE)
        if isinstance(phase, JointSamples) and len(phase.stamp_ns):
            beats: FloatArray = phase.position[:, phase.name.index(PHASE_NAMES[3])]
            if self._first_ns is None:
                self._begin(int(phase.stamp_ns[0]))
            beats_at = np.flatnonzero(np.diff(beats, prepend=self._beats) > 0.0)
            if len(beats_at):
                self._beat_ns = int(phase.stamp_ns[beats_at[-1]])
            self._beats = float(beats[-1])
            changes = np.flatnonzero(np.diff(phase.position[:, 0], prepend=self._phase))
            if len(changes):
                self._moved_ns = int(phase.stamp_ns[changes[-1]])
            self._phase = float(phase.position[-1, 0])
            self._last_ns = max(self._last_ns, int(phase.stamp_ns[-1]))
        machine = self._machine
        if isinstance(wheel, JointSamples) and len(wheel.stamp_ns):
            angle, rate = wheel.position[:, 0], wheel.velocity[:, 0]
            if self._first_ns is None:
                self._begin(int(wheel.stamp_ns[0]))
            if swing_energy(machine, angle[-1:], rate[-1:])[0] >= self._needed:
                self._reach_ns, self._short_ns = int(wheel.stamp_ns[-1]), None
            else:
                reaches = np.flatnonzero(swing_energy(machine, angle, rate) >= self._needed)
                if len(reaches):
                    self._reach_ns = int(wheel.stamp_ns[reaches[-1]])
                if len(reaches) or self._short_ns is None:
                    self._short_ns = int(wheel.stamp_ns[reaches[-1] + 1 if len(reaches) else 0])
            self._angle = np.concatenate([self._angle, angle])[-LAST_SWINGS:]
            self._rate = np.concatenate([self._rate, rate])[-LAST_SWINGS:]
            self._last_ns = max(self._last_ns, int(wheel.stamp_ns[-1]))

    def result(self) -> dict[str, float | str | None]:
        """Return the figures, an empty mapping without samples.

        `amplitude_rad` belongs to the last swings of a wheel. `stopped_s` is the time from the
        start of the last logged instant at which the clock ran, and `stopped_why` a clause with
        the reason. Both are `None` if it still runs.
        """
        machine = self._machine
        if isinstance(machine, OtherRegulator):
            least_ns = self._last_ns - BODY_REST_PERIODS * machine.small_period * NS_PER_S
            middle = self._beat_ns, 'from then on the body did not pass the middle'
            faint = self._reach_ns, 'its swing had died away'
            stopped_s, why = self._since_start(
                [middle] * (self._moved_ns < least_ns) + [faint] * (self._reach_ns < least_ns)
            )
            return {} if self._first_ns is None else {'stopped_s': stopped_s, 'stopped_why': why}
        if not len(self._angle):
            return {}
        energy = swing_energy(machine, self._angle, self._rate)
        energy = energy + recoil_energy(machine, self._angle, self._rate)
        amplitude = amplitude_of(machine, float(np.mean(energy)))
        stopped_s, why = self._stopped(machine, amplitude)
        return {'amplitude_rad': amplitude, 'stopped_s': stopped_s, 'stopped_why': why}

    @cached_property
    def _machine(self) -> AnyMachine | OtherRegulator:
        return self._built or compile_machine(self._scene)

    @cached_property
    def _needed(self) -> float:
        """Least energy of a swing that runs a clock: it reaches the impulse on both sides [J]."""
        escapement = self._scene.escapement
        if isinstance(self._machine, OtherRegulator) or escapement is None:
            return THERMAL_ENERGY_J
        sides = np.array([escapement.angle, -escapement.angle])
        return max(
            float(np.min(swing_energy(self._machine, sides, np.zeros(2)))), THERMAL_ENERGY_J
        )

    def _begin(self, first_ns: int) -> None:
        self._first_ns = self._last_ns = self._beat_ns = self._reach_ns = first_ns

    def _stopped(self, machine: AnyMachine, amplitude: float) -> tuple[float | None, str | None]:
        """Return when the clock stopped, from the start [s], and why, or `None` twice."""
        allowed_s = SILENCE_PERIODS * nearest_period(machine, amplitude)
        ends: list[tuple[int, str]] = []
        if (self._last_ns - self._beat_ns) / NS_PER_S > allowed_s:
            ends.append((self._beat_ns, 'from then on the wheel did not pass the middle'))
        # The counter shows a beat anywhere between two logged instants. The energy is known at
        # logged instants only, so a single one with too little proves little.
        short_ns = self._last_ns if self._short_ns is None else self._short_ns
        if (self._last_ns - short_ns) / NS_PER_S > allowed_s:
            why = 'its swing had died away'
            escapement = self._scene.escapement
            if escapement is not None and self._needed > THERMAL_ENERGY_J:
                angle = significant(escapement.angle)
                why = f'its swing had become too small to reach the impulse, at {angle} rad'
            ends.append((self._reach_ns, why))
        return self._since_start(ends)

    def _since_start(self, ends: list[tuple[int, str]]) -> tuple[float | None, str | None]:
        """Return the first of several ends, from the start [s], and why, or `None` twice."""
        if not ends:
            return None, None
        went_ns, why = min(ends)
        return (went_ns - (self._first_ns or 0)) / NS_PER_S, why
