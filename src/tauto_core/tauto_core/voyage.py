"""The stages joined: a whole voyage offline."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import numpy as np

from tauto_core.answer import answer
from tauto_core.bags import BagWriter
from tauto_core.clockwork import TrochleaStage
from tauto_core.kernels import optimised
from tauto_core.machines import AnyMachine, FluidPendulum
from tauto_core.navigation import DriftStage, LongitudeStage, Route, drift_warnings
from tauto_core.readiness import check_known, check_scene, oddities
from tauto_core.samples import (
    NS_PER_S,
    OBSERVATION,
    SCENE,
    SHIP_FIX,
    SHIP_IMU,
    Batches,
    Samples,
    Stage,
    State,
    join,
    text,
)
from tauto_core.scene import Scene, scene_yaml
from tauto_core.scene.errors import PropagationError, TautoError, naming
from tauto_core.ship import REFUSALS, Observations, ShipMotion, bag_metadata
from tauto_core.summary import Summary

CHUNK = 65_536
"""Number of motion samples processed at once; the result does not depend on it."""

QUIET_CHUNK = 2 * CHUNK
"""The same where the motion is not needed as messages: a fifth less time for a linear machine."""

SAILED_TO_COMPILE_S = 20.0
"""Length of a voyage that calls all its kernels, those for long pieces of forcing included [s]."""


class ShipSource:
    """All that comes from the ship, in order of its stamps: scene, motion, position, observations.

    Args:
        scene: the scene to simulate.
        motion: the motion of its ship from the start, if it has been built already.
        says_scene: whether the scene's text comes first.
        as_messages: whether the motion is needed as messages, besides the clock.
    """

    outputs = (SCENE, SHIP_IMU, SHIP_FIX, OBSERVATION)

    def __init__(
        self,
        scene: Scene,
        motion: ShipMotion | None = None,
        *,
        says_scene: bool = True,
        as_messages: bool = True,
    ) -> None:
        self._scene, self._says_scene = scene, says_scene
        self._starts_at_ns, self._duration_ns = scene.starts_at_ns, scene.duration_ns
        self._step_ns, self._log_ns = scene.step_ns, scene.log_interval_ns
        self._motion = ShipMotion(scene) if motion is None else motion
        self._observations = Observations(scene)
        self._route = Route(scene)
        self._produced, self._as_messages = 0, as_messages

    @property
    def total(self) -> int:
        """Number of motion samples in all, including those beyond the end."""
        return self._motion.total

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about measured motion."""
        return self._motion.warnings

    @property
    def produced(self) -> int:
        """Number of motion samples produced so far."""
        return self._produced

    def produce(self, count: int) -> Batches:
        """Return the next `count` motion samples and the other samples up to their stamps."""
        starts_at, interval = self._starts_at_ns, self._log_ns
        imu = self._motion.produce(count) if self._as_messages else self._motion.sense(count)
        if not len(imu.stamp_ns):
            return {}
        first, last = self._produced, self._produced + len(imu.stamp_ns)
        self._produced = last
        batches: Batches = {SHIP_IMU: imu}
        if first == 0 and self._says_scene:
            batches[SCENE] = text(starts_at, scene_yaml(self._scene))
        begin, end = first * self._step_ns, min(last * self._step_ns, self._duration_ns + 1)
        logs = np.arange(-(-begin // interval), -(-end // interval))
        if len(logs):
            batches[SHIP_FIX] = self._route.fixes(starts_at + logs * interval)
        if begin < end:
            seen = self._observations.between(starts_at + begin, starts_at + end)
            if len(seen.stamp_ns):
                batches[OBSERVATION] = seen
        return batches

    def state(self) -> State:
        """Return the state of the source."""
        return {'produced': self._produced, 'motion': self._motion.state()}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._produced = state['produced']
        self._motion.restore(state['motion'])


class Pipeline:
    """Stages in their order: the output of one is fed to all that follow.

    Args:
        stages: in the order of the flow.
    """

    def __init__(self, stages: Sequence[Stage]) -> None:
        self._stages = list(stages)

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Return the input and all outputs of the stages."""
        return self._run(dict(batches), final=False)

    def finish(self) -> Batches:
        """Return all that the stages held back."""
        return self._run({}, final=True)

    def _run(self, known: Batches, *, final: bool) -> Batches:
        for stage in self._stages:
            wanted = {topic: known[topic] for topic in stage.inputs if topic in known}
            said = [stage.feed(wanted)] if wanted else []
            said += [stage.finish()] if final else []
            for batches in said:
                for topic, samples in batches.items():
                    known[topic] = _append(known.get(topic), samples)
        return known

    def state(self) -> State:
        """Return the states of all stages."""
        return {'stages': [stage.state() for stage in self._stages]}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        for stage, saved in zip(self._stages, state['stages'], strict=True):
            stage.restore(saved)

    def health(self) -> dict[str, int]:
        """Return the counters of all stages that are not zero."""
        merged: dict[str, int] = {}
        for stage in self._stages:
            merged.update({name: n for name, n in stage.health().items() if n})
        return merged


def _append(known: Samples | None, new: Samples) -> Samples:
    return new if known is None else join([known, new])  # type: ignore[type-var]


def pipeline(scene: Scene, machine: AnyMachine | FluidPendulum | None = None) -> Pipeline:
    """Return the stages of a scene: trochlea, drift, longitude.

    Args:
        scene: the scene to simulate.
        machine: the regulator of the scene, if it has been built already.
    """
    trochlea = TrochleaStage(scene, machine=machine)
    return Pipeline([trochlea, DriftStage(scene), LongitudeStage(scene)])


def sail(
    scene: Scene,
    out: Path | None = None,
    *,
    origin: str | None = None,
    force: bool = False,
    anyway: bool = False,
    progress: Callable[[float], None] | None = None,
    watch: Callable[[Batches], None] | None = None,
) -> dict[str, Any]:
    """Sail a scene offline; return the object that `tauto sail --json` prints.

    It has `sea` only for a ship in a sea. It has `warnings` only where a number is probably in the
    wrong unit, measured motion could not be read to its end, waves were left out, or observations
    disagreed with the clock by more than `drift.gate`.

    Args:
        scene: the scene to simulate.
        out: folder of the bag to write; None: no bag.
        origin: file or name that the user gave, for errors; None: the scene's name.
        force: replace a bag that is there.
        anyway: sail machines and ships beyond all that are known, too.
        progress: called with the fraction done, from 0 to 1.
        watch: called with all samples on any topic, batch after batch.

    Raises:
        TautoError: bad scene, no place for the bag, or an event that ends the motion.
    """
    started = time.perf_counter()
    with naming(origin or scene.name, scene.name):
        if not anyway:
            check_known(scene)
        machine, motion = check_scene(scene)
    heard = out is not None or watch is not None
    kept = (
        bool(scene.drift.covariates)
        or watch is not None
        or (out is not None and scene.keeps_motion)
    )
    source = ShipSource(scene, motion, says_scene=heard, as_messages=kept)
    stages = pipeline(scene, machine)
    summary = Summary(scene, machine)
    with ExitStack() as stack:
        bag = stack.enter_context(BagWriter(out, force=force)) if out is not None else None
        if bag is not None:
            bag.describe(bag_metadata(scene))
        for batches in _voyage(source, stages, CHUNK if kept else QUIET_CHUNK):
            if words := refused_words(stages.health()):
                raise PropagationError(words, source.produced * scene.step_ns / NS_PER_S)
            summary.feed(batches)
            if watch is not None:
                watch(batches)
            if bag is not None:
                bag.write(_kept(scene, batches))
            if progress is not None:
                progress(source.produced / source.total)
    warnings = [*oddities(scene), *source.warnings, *drift_warnings(stages.health(), scene)]
    return {
        **report(scene, summary),
        'wall_s': time.perf_counter() - started,
        'bag': None if out is None else str(out),
        **({'warnings': warnings} if warnings else {}),
    }


def compile_kernels(scene: Scene) -> None:
    """Compile the kernels of a scene's ship and clock, unless they are compiled already.

    The first seconds are run and their output is dropped. Errors are left to the voyage itself,
    which reports them with their time. The kernels are optimised at once, since a node under way
    cannot wait for that.
    """
    source, stages = ShipSource(scene), pipeline(scene)
    samples = math.ceil(SAILED_TO_COMPILE_S * NS_PER_S / scene.step_ns)
    with optimised(), suppress(TautoError):
        stages.feed(source.produce(samples))
        stages.finish()


def _voyage(source: ShipSource, stages: Pipeline, chunk: int) -> Iterator[Batches]:
    while source.produced < source.total:
        yield stages.feed(source.produce(chunk))
    yield stages.finish()


def refused_words(health: Mapping[str, int]) -> str:
    """Return which samples of the scene's own ship the stages have refused; empty: none.

    Args:
        health: counters of the stages.
    """
    refused = [f'{n} {reason}' for reason in REFUSALS if (n := health.get(reason, 0))]
    if not refused:
        return ''
    return (
        f'samples of the ship that cannot be integrated: {", ".join(refused)}. Check the size of '
        'its motion, its height and gravity'
    )


def _kept(scene: Scene, batches: Batches) -> Batches:
    """Return the samples that the log keeps."""
    if scene.keeps_motion:
        return batches
    return {topic: samples for topic, samples in batches.items() if topic != SHIP_IMU}


def report(scene: Scene, summary: Summary) -> dict[str, Any]:
    """Return what a summary says of a voyage, as `sail` reports it."""
    figures = {
        'trochlea': summary.trochlea(),
        'clock': summary.clock(),
        'drift': summary.drift(),
        'longitude': summary.longitude(),
    }
    return {
        'scene': scene.name,
        'answer': answer(figures),
        'duration_s': scene.duration,
        'propagator': summary.propagator,
        **sea_of(scene),
        **figures,
    }


def sea_of(scene: Scene) -> dict[str, Any]:
    """Return the `sea` of a report; nothing for a ship in none."""
    ship = scene.ship
    return {ship.reported_as: ship.metadata(scene)} if ship.reported_as else {}
