"""The clock on a live sensor (or another simulator, or `ros2 bag play`) that publishes ship/imu.

ros2 launch tauto_nodes live.launch.py scene:=measured imu:=/xsens/imu out:=voyage

The launch ends with the first node that ends; its exit code is then not 0.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from tauto_nodes.errors import ParameterError
from tauto_nodes.launching import end_of, live_problems

ARGUMENTS = {
    'scene': ('measured', 'scene file (absolute path) or name of a shipped scene'),
    'imu': ('ship/imu', 'topic of the sensor, sensor_msgs/Imu'),
    'imu_reliability': ('best_effort', 'what the sensor offers: best_effort or reliable'),
    'out': ('', 'folder of a bag; empty: nothing is recorded'),
    'state_folder': ('', 'folder for the states of the stages; empty: none is saved'),
    'namespace': ('', 'namespace of the clock'),
    'executor': ('events', 'what spins the nodes: events or single'),
    'params_file': (
        PathJoinSubstitution([FindPackageShare('tauto_nodes'), 'config', 'foreign_imu.yaml']),
        'parameters of all nodes',
    ),
}


def _nodes(context: LaunchContext) -> list[Any]:
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    if problems := live_problems(given):
        raise ParameterError('; '.join(problems))
    sensor = {'imu_reliability': given['imu_reliability']}
    stage = {'scene': given['scene'], 'state_folder': given['state_folder']}
    own: dict[str, dict[str, Any]] = {
        'longitude': stage,
        'drift_estimator': stage,
        'trochlea': {**stage, **sensor},
    }
    if given['out']:
        own['recorder'] = {'output': str(Path(given['out']).absolute()), **sensor}
    return [
        Node(
            package='tauto_nodes',
            executable=name,
            name=name,
            namespace=given['namespace'],
            parameters=[given['params_file'], {'executor': given['executor'], **own[name]}],
            remappings=[('ship/imu', given['imu'])] if given['imu'] != 'ship/imu' else [],
            output='screen',
            on_exit=lambda event, context, name=name: end_of(name, event, context, last=''),
        )
        for name in own
    ]


def generate_launch_description() -> LaunchDescription:
    """Return the clock; the sensor is somebody else's."""
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (default, description) in ARGUMENTS.items()
            ),
            OpaqueFunction(function=_nodes),
        ]
    )
