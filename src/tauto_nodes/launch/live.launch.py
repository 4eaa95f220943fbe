"""The clock on a live sensor (or another simulator, or `ros2 bag play`) that publishes ship/imu.

ros2 launch tauto_nodes live.launch.py scene:=measured imu:=/xsens/imu out:=voyage

The arguments are checked before anything starts. The launch ends with the first node that ends;
its exit code is then not 0. For a sensor on another machine set ROS_AUTOMATIC_DISCOVERY_RANGE.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from launch import LaunchDescription

from tauto_nodes.launching import launch_description, state_folder

DEFAULTS = {
    'scene': 'measured',
    'imu': 'ship/imu',
    'imu_reliability': 'best_effort',
    'imu_rotation': '',
    'out': '',
    'anyway': 'false',
    'state_folder': 'default',
    'namespace': '',
    'executor': 'events',
}


def _parameters(given: Mapping[str, str]) -> dict[str, dict[str, object]]:
    sensor = {'imu_reliability': given['imu_reliability']}
    mounted = {**sensor, 'imu_rotation': given['imu_rotation']}
    stage = {'scene': given['scene'], 'state_folder': state_folder(given)}
    nodes: dict[str, dict[str, object]] = {
        'longitude': {**stage},
        'drift_estimator': {**stage, **mounted},
        'trochlea': {**stage, **mounted},
    }
    if given['out']:
        nodes['recorder'] = {'output': str(Path(given['out']).absolute()), **sensor}
    return nodes


def generate_launch_description() -> LaunchDescription:
    """Return the nodes of the clock; the sensor is not among them."""
    return launch_description(DEFAULTS, 'foreign_imu.yaml', _parameters)
