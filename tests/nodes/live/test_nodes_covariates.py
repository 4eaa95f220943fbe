"""The drift estimator on real nodes if the scene's rate follows the ship's motion."""

from __future__ import annotations

from pathlib import Path

from conftest import WARM, Bench, overrides
from rclpy.node import Node

from tauto_core.bags import encode
from tauto_core.samples import (
    READING,
    SHIP_FIX,
    SHIP_TEMPERATURE,
)
from tauto_core.scene import parse_scene
from tauto_core.voyage import sail
from tauto_nodes.live.node import port
from tauto_nodes.live.stages import DriftEstimatorNode


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
