"""A whole voyage: ship, trochlea, drift estimator, longitude and recorder on one scene.

ros2 launch tauto_nodes voyage.launch.py scene:=measured speed:=60.0 out:=bags/out/measured

The arguments are checked before anything starts. The launch ends when the recorder has everything
and has closed the bag, and with the first node that ends otherwise; its exit code is then not 0.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, SetEnvironmentVariable
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from tauto_nodes.errors import ParameterError
from tauto_nodes.launching import end_of, fast_dds_profile, voyage_problems

ARGUMENTS = {
    'scene': ('measured', 'scene file (absolute path) or name of a shipped scene'),
    'speed': ('60.0', 'sea seconds in a second; 0.0: as fast as the graph can'),
    'duration': ('0.0', "replaces the duration of the scene [s]; 0.0: the scene's own"),
    'out': ('voyage', 'folder of the bag'),
    'force': ('false', 'replace a bag that is there'),
    'namespace': ('', 'namespace of the graph'),
    'executor': ('events', 'what spins the nodes: events or single'),
    'params_file': (
        PathJoinSubstitution([FindPackageShare('tauto_nodes'), 'config', 'voyage.yaml']),
        'parameters of all nodes',
    ),
}


def _nodes(context: LaunchContext) -> list[Any]:
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    if problems := voyage_problems(given):
        raise ParameterError('; '.join(problems))
    scene = {
        'scene': given['scene'],
        'duration': float(given['duration']),
        'executor': given['executor'],
    }
    force = given['force'].lower() == 'true'
    own: dict[str, dict[str, Any]] = {
        'recorder': {'output': str(Path(given['out']).absolute()), 'force': force},
        'longitude': {},
        'drift_estimator': {},
        'trochlea': {},
        'ship_motion': {'speed': float(given['speed'])},
    }
    return [
        Node(
            package='tauto_nodes',
            executable=name,
            name=name,
            namespace=given['namespace'],
            parameters=[given['params_file'], {**scene, **own[name]}],
            output='screen',
            on_exit=lambda event, context, name=name: end_of(
                name, event, context, last='recorder'
            ),
        )
        for name in own
    ]


def generate_launch_description() -> LaunchDescription:
    """Return the graph; the parameter file makes the nodes wait for each other."""
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (default, description) in ARGUMENTS.items()
            ),
            *(SetEnvironmentVariable(name, file) for name, file in fast_dds_profile().items()),
            OpaqueFunction(function=_nodes),
        ]
    )
