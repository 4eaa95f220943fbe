"""A whole voyage: ship, trochlea, drift estimator, longitude and recorder for one scene.

ros2 launch tauto_nodes voyage.launch.py scene:=measured speed:=60.0 out:=bags/out/measured

The arguments are checked before anything starts. The launch ends when the recorder has everything
and has closed the bag, and with the first node that ends otherwise; its exit code is then not 0.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from launch import LaunchDescription

from tauto_nodes.launching import launch_description
from tauto_nodes.running import graph_middleware

DEFAULTS = {
    'scene': 'measured',
    'speed': '60.0',
    'duration': '0.0',
    'out': 'voyage',
    'force': 'false',
    'anyway': 'false',
    'namespace': '',
    'executor': 'events',
}


def _parameters(given: Mapping[str, str]) -> dict[str, dict[str, object]]:
    speed = float(given['speed'])
    common = {
        'scene': given['scene'],
        'duration': float(given['duration']),
        'packed': True,
    }
    bag = {
        'output': str(Path(given['out']).absolute()),
        'force': given['force'].lower() == 'true',
    }
    return {
        'recorder': {**common, **bag},
        'longitude': common,
        'drift_estimator': common,
        'trochlea': common,
        'ship_motion': {**common, 'speed': speed},
    }


def generate_launch_description() -> LaunchDescription:
    """Return the graph; the parameter file makes the nodes wait for each other."""
    return launch_description(
        DEFAULTS, 'voyage.yaml', _parameters, last='recorder', environment=graph_middleware
    )
