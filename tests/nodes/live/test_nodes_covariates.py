"""The drift estimator on real nodes if the scene's rate follows the ship's motion."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from conftest import DRIFT, WARM, Bench, overrides
from rclpy.node import Node

from tauto_core.bags import encode
from tauto_core.navigation import DriftStage
from tauto_core.samples import (
    ESTIMATE,
    OBSERVATION,
    READING,
    SHIP_FIX,
    SHIP_IMU,
    SHIP_TEMPERATURE,
    Batches,
    Samples,
    join,
    take,
)
from tauto_core.scene import Scene, load_scene, parse_scene, scene_yaml
from tauto_core.scene.times import NS_PER_S
from tauto_core.voyage import sail
from tauto_nodes.live.node import port
from tauto_nodes.live.stages import DriftEstimatorNode, StateFile


def test_a_latitude_and_a_thermometer_that_never_come_are_said(
    bench: Bench, tmp_path: Path
) -> None:
    """The estimate does not wait, and the coefficients keep their priors."""
    file = tmp_path / 'scene.yaml'
    file.write_text(WARM, encoding='utf-8')
    estimator = bench.add(DriftEstimatorNode(**overrides(source='foreign', scene=str(file))))
    scene = parse_scene(WARM, 'warm')
    sensor = bench.add(Node('dial'))
    publisher = sensor.create_publisher(port(READING).message, READING, port(READING).profile)
    source = estimator.inputs[READING]
    bench.until(lambda: source.matched == 1)
    for payload in encode(READING, sail(scene).samples[READING]):
        publisher.publish(payload)
    bench.until(lambda: source.taken == scene.log_count)
    bench.until(lambda: len(estimator.notices) == 2)
    for topic, notice in zip((SHIP_FIX, SHIP_TEMPERATURE), estimator.notices, strict=True):
        assert f'on {topic}, or leave' in notice


def _spoken(scene: Scene) -> dict[str, Samples]:
    """Return motion, readings and observations of a voyage."""
    said: dict[str, list[Any]] = {SHIP_IMU: [], READING: [], OBSERVATION: []}

    def hear(batches: Batches) -> None:
        for topic in said.keys() & batches.keys():
            said[topic].append(batches[topic])

    sail(scene, watch=hear)
    return {topic: join(parts) for topic, parts in said.items()}


def test_a_restarted_estimator_keeps_coefficients(bench: Bench, tmp_path: Path) -> None:
    """Its estimate has the bits of an uninterrupted one, although one of two observations comes
    after the end.
    """
    scene = load_scene('involute_weight_at_sea', duration=60.0, drift=DRIFT)
    file = tmp_path / 'scene.yaml'
    file.write_text(scene_yaml(scene), encoding='utf-8')
    options: dict[str, Any] = {
        'source': 'foreign',
        'scene': str(file),
        'state_folder': str(tmp_path),
        'state_interval': 0.1,
    }
    topics = _spoken(scene)
    middle_ns = scene.starts_at_ns + 41 * NS_PER_S
    sensor = bench.add(Node('xsens'))
    publishers = {
        topic: sensor.create_publisher(port(topic).message, topic, port(topic).profile)
        for topic in topics
    }
    heard: list[bytes] = []
    sensor.create_subscription(port(ESTIMATE).message, ESTIMATE, heard.append, 1000, raw=True)
    alone = DriftStage(scene, expect_schedule=False)
    wanted: list[bytes] = []

    def tell(estimator: DriftEstimatorNode, topic: str, samples: Samples) -> None:
        source = estimator.inputs[topic]
        bench.until(lambda: source.matched == 1)
        payloads, taken = encode(topic, samples), source.taken
        for number, payload in enumerate(payloads):
            publishers[topic].publish(payload)
            if number % 50 == 49:
                bench.beats(sensor, 1)
        bench.until(lambda: source.taken == taken + len(payloads))
        said = alone.feed({topic: samples})
        wanted.extend(encode(ESTIMATE, said[ESTIMATE]) if ESTIMATE in said else [])
        bench.until(lambda: len(heard) == len(wanted))

    def half(estimator: DriftEstimatorNode, later: bool, *order: str) -> None:
        for topic in order:
            samples: Any = topics[topic]
            tell(estimator, topic, take(samples, (samples.stamp_ns >= middle_ns) == later))

    first = bench.add(DriftEstimatorNode(**overrides(**options)))
    half(first, False, SHIP_IMU, OBSERVATION, READING)
    reached = alone.state()['last_reading_ns']
    kept = StateFile(tmp_path, '/drift_estimator', scene)
    bench.until(lambda: (state := kept.load()) and state['last_reading_ns'] == reached)
    bench.remove(first)
    second = bench.add(DriftEstimatorNode(**overrides(**options)))
    half(second, True, SHIP_IMU, READING, OBSERVATION)
    assert len(wanted) == scene.log_count
    assert heard == wanted
    assert second.health()['observations_too_old'] == 0
