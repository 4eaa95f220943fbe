"""The trochlea on a live sensor: the dial stops where the motion is lost.

Where the motion breaks off for more than `MAX_GAP_S`, jumps, or makes the wheel do what no wheel
can, the run ends at its last reading. The next good motion releases the wheel again, and the dial
continues from where it stood. So it loses the time in between, which each reading states
(`source`, DialSetting). Where the stamps themselves have gone back, since sim time was reset or a
bag begins again, the dial is set anew.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, cast

import numpy as np

from tauto_core.clockwork.dial_setting import DialSetting
from tauto_core.clockwork.limits import Limits
from tauto_core.clockwork.trochlea import TrochleaStage
from tauto_core.samples import (
    JOINT_STATES,
    NS_PER_S,
    READING,
    SHIP_IMU,
    Batches,
    ImuSamples,
    JointSamples,
    Samples,
    State,
    TimeSamples,
    join,
    same,
    take,
)
from tauto_core.scene import Scene
from tauto_core.scene.errors import PropagationError
from tauto_core.scene.times import MAX_GAP_S
from tauto_core.ship.continuity import Continuity
from tauto_core.ship.imu import REFUSALS, content_reasons


class LiveTrochlea:
    """A TrochleaStage for motion with stamps of its own: anchored at the first stamp.

    Args:
        scene: the scene to simulate; its motion comes through `feed`.

    Raises:
        SceneError: the machine cannot be built, or its suspension.
    """

    inputs: ClassVar[tuple[str, ...]] = TrochleaStage.inputs
    outputs: ClassVar[tuple[str, ...]] = TrochleaStage.outputs

    def __init__(self, scene: Scene) -> None:
        still = scene.lies_still
        gap_ns = round(MAX_GAP_S * NS_PER_S)
        self._continuity = Continuity(scene.step_ns, max(gap_ns, 2 * scene.step_ns * still))
        self._stage = TrochleaStage(scene, anchor='first')
        self._fresh = self._stage.state()
        self._limits = Limits(scene)
        self._run: _RunState | None = None
        self._shown: _Shown | None = None
        self._refused = dict.fromkeys(REFUSALS, 0)
        self._counts = {'dial_stops': 0, 'dial_settings': 0, 'runs_failed': 0}
        self._trouble = ''
        self._news: list[str] = []

    @property
    def trouble(self) -> str:
        """Why the dial stands still at present; empty if it goes."""
        if ahead_s := self._continuity.holds_s:
            side = 'after' if ahead_s > 0.0 else 'before'
            return (
                'the dial stands still: what comes on ship/imu does not continue the last good '
                f'sample; its stamps lie {abs(ahead_s):.6g} s {side} it'
            )
        return self._trouble

    def news(self) -> list[str]:
        """Return a description of what has happened to the dial since the last call."""
        news, self._news = self._news, []
        return news

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Take motion samples; return the samples that are known by now."""
        imu = batches.get(SHIP_IMU)
        if not isinstance(imu, ImuSamples) or not len(imu.stamp_ns):
            return {}
        before, heard = self.state(), len(self._news)
        said: list[Batches] = []
        try:
            self._take(imu, said)
        except PropagationError as error:
            del self._news[heard:]
            if len(imu.stamp_ns) > 1:  # all samples before the one that fails are used
                self.restore(before)
                ones = [take(imu, slice(k, k + 1)) for k in range(len(imu.stamp_ns))]
                return _joined([self.feed({SHIP_IMU: one}) for one in ones])
            self._fail(str(error))
        return _joined(said)

    def finish(self) -> Batches:
        """Return the remaining samples, interpolated with one-sided windows."""
        said: list[Batches] = []
        try:
            if self._run is not None:
                self._believe(self._stage.finish(), said)
        except PropagationError as error:
            self._fail(str(error))
        return _joined(said)

    def _take(self, imu: ImuSamples, said: list[Batches]) -> None:
        reasons = content_reasons(imu)
        if reasons.any():
            totals = np.bincount(reasons, minlength=1 + len(REFUSALS))
            for name, number in zip(REFUSALS, totals[1:].tolist(), strict=True):
                self._refused[name] += number
            imu = take(imu, reasons == 0)
        for part in self._continuity.feed(imu):
            if part.begins:
                # a run without any reading is forgotten
                if self._run is not None and self._run.said:
                    self._believe(self._stage.finish(), said)
                self._begin(int(part.imu.stamp_ns[0]))
            self._limits.feel(part.imu)
            self._believe(self._stage.feed({SHIP_IMU: part.imu}), said)
        refused = REFUSALS[reasons[-1] - 1] if reasons[-1] else ''
        self._trouble = (
            refused and f'the dial stands still: what comes on ship/imu cannot be used ({refused})'
        )

    def _begin(self, origin_ns: int) -> None:
        """Release the wheel again, and account for the time since the last reading."""
        self._stage.restore(self._fresh)
        self._limits.begin()
        shown = self._shown
        if shown is None or origin_ns <= shown.stamp_ns:
            setting = shown.setting.again(origin_ns) if shown else DialSetting(origin_ns)
            self._run = _RunState(setting, origin_ns, origin_ns)
            if shown is not None:
                back_s = (shown.stamp_ns - origin_ns) / NS_PER_S
                self._counts['dial_settings'] += 1
                self._news.append(
                    f'the stamps of ship/imu went back by {back_s:.6g} s: the dial is set anew, '
                    f'to {origin_ns / NS_PER_S:.3f} s'
                )
            return
        lost_ns, known = origin_ns - shown.stamp_ns, shown.setting
        setting = replace(known, lost_ns=known.lost_ns + lost_ns, stops=known.stops + 1)
        self._run = _RunState(setting, origin_ns, shown.dial_ns)
        self._counts['dial_stops'] += 1
        self._news.append(
            f'ship/imu goes on after a break: the dial stood still for {lost_ns / NS_PER_S:.6g} '
            f's, until {origin_ns / NS_PER_S:.3f} s; in all {setting.lost_ns / NS_PER_S:.6g} s'
        )

    def _fail(self, why: str) -> None:
        """Abandon a run; the next sample begins another."""
        self._run = None
        self._trouble = why
        self._counts['runs_failed'] += 1
        self._news.append(f'the dial stopped: {why}')
        self._continuity.restart()

    def _believe(self, batches: Batches, said: list[Batches]) -> None:
        """Check the output of the stage, and return it with the readings of this dial."""
        run, wheel = self._run, batches.get(JOINT_STATES)
        if run is None or not isinstance(wheel, JointSamples) or not len(wheel.stamp_ns):
            return
        self._limits.check(wheel, run.origin_ns)
        reading = cast(TimeSamples, batches[READING])
        dial = reading.time_ref_ns + (run.base_ns - run.origin_ns)
        source = same(run.setting.source(), len(dial))
        said.append({**batches, READING: replace(reading, time_ref_ns=dial, source=source)})
        self._run = replace(run, said=True)
        self._shown = _Shown(int(reading.stamp_ns[-1]), int(dial[-1]), run.setting)

    def state(self) -> State:
        """Return all that the next output depends on."""
        run, shown = self._run, self._shown
        return {
            'stage': self._stage.state(),
            'continuity': self._continuity.state(),
            'limits': self._limits.state(),
            'run': run and {**vars(run), 'setting': run.setting.source()},
            'shown': shown and {**vars(shown), 'setting': shown.setting.source()},
            'refused': dict(self._refused),
            'counts': dict(self._counts),
            'trouble': self._trouble,
        }

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._stage.restore(state['stage'])
        self._continuity.restore(state['continuity'])
        self._limits.restore(state['limits'])
        run, shown = state['run'], state['shown']
        self._run = run and _RunState(**{**run, 'setting': DialSetting.of(run['setting'])})
        self._shown = shown and _Shown(**{**shown, 'setting': DialSetting.of(shown['setting'])})
        self._refused, self._counts = dict(state['refused']), dict(state['counts'])
        self._trouble = state['trouble']

    def health(self) -> dict[str, int]:
        """Return counters of samples refused or left out, gaps bridged, and stops of the dial."""
        return {**self._refused, **self._continuity.counts, **self._counts}


@dataclass(frozen=True)
class _RunState:
    """A run: setting of the dial, start of the run, reading of the dial there."""

    setting: DialSetting
    origin_ns: int
    base_ns: int
    said: bool = False


@dataclass(frozen=True)
class _Shown:
    """The last reading."""

    stamp_ns: int
    dial_ns: int
    setting: DialSetting


def _joined(said: list[Batches]) -> Batches:
    topics = dict.fromkeys(topic for batches in said for topic in batches)
    return {
        topic: join([cast(TimeSamples, batches[topic]) for batches in said if topic in batches])
        for topic in topics
    }
