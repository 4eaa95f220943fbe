"""Voyages from bags: the report of a recorded one, or the navigator's part estimated anew."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any, cast

from tauto_core.answer import answer
from tauto_core.bags import Bag, is_cut_short, read_bag
from tauto_core.navigation import DriftStage, LongitudeStage, drift_warnings
from tauto_core.navigation.drift import merged
from tauto_core.navigation.regressors import RecordedIntegrals, integral_names
from tauto_core.samples import (
    CORRECTED,
    ESTIMATE,
    JOINT_STATES,
    LONGITUDE_ERROR,
    LONGITUDE_FIX,
    NS_PER_S,
    OBSERVATION,
    PHASE,
    READING,
    SCENE,
    SHIP_FIX,
    SHIP_IMU,
    Batches,
    JointSamples,
    TimeSamples,
)
from tauto_core.scene import Scene, parse_scene
from tauto_core.scene.errors import BagError
from tauto_core.summary import Summary
from tauto_core.voyage import Pipeline, report, sea_of


def bag_scene(bag: Bag, scene: Scene | None = None) -> Scene:
    """Return the scene of a bag, or the one given instead.

    Raises:
        BagError: the bag has none and none is given.
    """
    if scene is not None:
        return scene
    if bag.scene is None:
        raise BagError(
            f'{bag.path}: no topic {SCENE!r}, so the bag does not say what it holds. Give the '
            'scene it belongs to (--scene SCENE)'
        )
    return parse_scene(bag.scene, f'{bag.path}:{SCENE}')


def summarise_bag(path: Path) -> dict[str, Any]:
    """Return the report of a recorded voyage: the result of `sail`, without the wall time.

    Raises:
        BagError: not a bag, or without a scene.
    """
    bag = read_bag(path)
    scene = bag_scene(bag)
    summary = Summary(scene)
    said = (JOINT_STATES, PHASE, ESTIMATE, LONGITUDE_FIX, LONGITUDE_ERROR)
    for topics in ((OBSERVATION, READING), said):  # the summary needs these two first
        for topic, part in bag.parts([topic for topic in topics if topic in bag]):
            summary.feed({topic: part})
    return {**report(scene, summary), 'bag': str(path)}


def _missing(bag: Bag, wanted: Sequence[str]) -> list[str]:
    """Return warnings about the topics that are not in a bag."""
    without = {
        OBSERVATION: 'the drift is what the scene assumes beforehand',
        SHIP_FIX: 'the ship is taken to lie where the scene begins',
        SHIP_IMU: 'nor has drift/estimate the integrals of drift.covariates, so the ship is taken '
        'to lie still',
    }
    return [
        f'{bag.path}: there is no topic {topic}: {so}'
        for topic, so in without.items()
        if topic not in bag and topic in (*wanted, SHIP_FIX)
    ]


def _damage(bag: Bag) -> list[str]:
    """Return what is damaged or missing in a bag that was read; nothing of a whole one."""
    ended = 'it says cut_short: its recording ended before the voyage did'
    return [*bag.warnings, *([f'{bag.path}: {ended}'] if is_cut_short(bag.path) else [])]


def _recorded_motion(recorded: Batches, scene: Scene) -> RecordedIntegrals | None:
    """Return the integrals of a scene's covariates from a bag; None if it has none.

    They are exact even where the motion itself is logged thinly.
    """
    covariates, estimate = scene.drift.covariates, recorded.get(ESTIMATE)
    if not covariates or not isinstance(estimate, JointSamples):
        return None
    named = set(integral_names(covariates)) <= set(estimate.name)
    return RecordedIntegrals(estimate, covariates) if named else None


def replay(
    bag: Bag,
    *,
    scene: Scene | None = None,
    smooth: bool = False,
    stable: bool = False,
    topics: Collection[str] = (),
    watch: Callable[[Batches], None] | None = None,
) -> dict[str, Any]:
    """Estimate drift and longitude again from a bag's readings and observations alone.

    Args:
        bag: a bag with `clock/reading`, `clock/observation` and, for distances, `ship/fix`.
        scene: replaces the bag's own, and is needed where it has none.
        smooth: also estimate the drift from all observations in hindsight (`hindsight`).
        stable: also estimate the stability of the clock (`stability_of`).
        topics: topics that are not computed again, for `watch` as far as the bag has them.
        watch: called with the samples of `topics`, and with all others that were read or computed.

    Returns:
        `scene`, the `answer` in a sentence, `sea` for a ship in one, `clock`, `drift`,
        `longitude`, `duration_s` (the scene's, if it was sailed to its end; otherwise the bag's),
        and the bag's `start_s`, message `counts`, `damage` and `warnings`, which begin with it;
        where asked for, `smoothed` and `stability`.

    Raises:
        BagError: no readings, or no scene.
        EstimationError: readings whose stability cannot be estimated.
    """
    found = bag_scene(bag, scene)
    wanted = [READING, OBSERVATION, SHIP_FIX, *topics]
    if found.drift.covariates:
        wanted.append(ESTIMATE if ESTIMATE in bag else SHIP_IMU)
    recorded = bag.batches([topic for topic in wanted if topic == READING or topic in bag])
    motion = _recorded_motion(recorded, found)
    drift = DriftStage(found, expect_schedule=False, motion=motion)
    stages = Pipeline([drift, LongitudeStage(found, expect_fix=SHIP_FIX in bag)])
    inputs = [topic for topic in dict.fromkeys((*drift.inputs, SHIP_FIX)) if topic in bag]
    if SHIP_IMU in inputs and SHIP_IMU not in recorded:  # estimates without the integrals
        recorded |= bag.batches([SHIP_IMU])
    summary = Summary(found)
    said = stages.feed({topic: recorded[topic] for topic in inputs})
    held = stages.finish()
    if watch is not None:
        others = [topic for topic in topics if topic in recorded and topic not in said]
        watch({topic: recorded[topic] for topic in others})
    for batches in (said, held):
        summary.feed(batches)
        if watch is not None:
            watch(batches)
    figures = {
        'clock': summary.clock(),
        'drift': summary.drift(),
        'longitude': summary.longitude(),
    }
    damage = _damage(bag)
    return {
        'scene': found.name,
        'answer': answer({**figures, 'damage': damage}),
        'bag': str(bag.path),
        **sea_of(found),
        **figures,
        **(_smoothed(merged([said, held]), found) if smooth else {}),
        **(_stability(said) if stable else {}),
        'start_s': (bag.start_ns or 0) / NS_PER_S,
        'duration_s': _length_s(bag, found, cast(TimeSamples, recorded[READING])),
        'counts': bag.counts,
        'damage': damage,
        'warnings': [
            *damage,
            *_missing(bag, drift.inputs),
            *drift_warnings(stages.health(), found),
        ],
    }


def _length_s(bag: Bag, scene: Scene, reading: TimeSamples) -> float:
    """Return the length of a bag [s]: the scene's, where the scene was sailed to its end.

    Motion is recorded for some steps beyond it, from which the clock is interpolated.
    """
    start_ns, end_ns = bag.start_ns or 0, bag.end_ns or 0
    read_to_ns = int(reading.stamp_ns[-1]) if len(reading.stamp_ns) else end_ns
    if (start_ns, read_to_ns) == (scene.starts_at_ns, scene.starts_at_ns + scene.duration_ns):
        return scene.duration
    return (end_ns - start_ns) / NS_PER_S


def _smoothed(said: Batches, scene: Scene) -> dict[str, Any]:
    from tauto_core.navigation.hindsight import hindsight

    reading, observation, corrected = (
        cast(TimeSamples, said.get(topic)) for topic in (READING, OBSERVATION, CORRECTED)
    )
    estimate = cast(JointSamples, said[ESTIMATE])
    return {'smoothed': hindsight(reading, observation, corrected, estimate, scene)}


def _stability(said: Batches) -> dict[str, Any]:
    from tauto_core.navigation.stability import stability_of

    return {'stability': stability_of(cast(TimeSamples, said[READING]))}
