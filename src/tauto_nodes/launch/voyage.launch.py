"""A whole voyage: ship, trochlea, drift estimator, longitude and recorder on one scene.

ros2 launch tauto_nodes voyage.launch.py scene:=measured speed:=60.0 out:=bags/out/measured
The launch ends when the recorder has everything and has closed the bag.
"""

from __future__ import annotations

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, Shutdown
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

ARGUMENTS = {
    'scene': ('measured', 'scene file (absolute path) or name of a shipped scene'),
    'speed': ('60.0', 'sea seconds in a second; 0.0: as fast as the graph can'),
    'out': ('voyage', 'folder of the bag'),
    'force': ('false', 'replace a bag that is there'),
    'namespace': ('', 'namespace of the graph'),
}


def _node(name: str, own: dict[str, object], **options: object) -> Node:
    config = PathJoinSubstitution([FindPackageShare('tauto_nodes'), 'config', 'voyage.yaml'])
    scene = ParameterValue(LaunchConfiguration('scene'), value_type=str)
    return Node(
        package='tauto_nodes',
        executable=name,
        name=name,
        namespace=LaunchConfiguration('namespace'),
        parameters=[config, {'scene': scene, **own}],
        output='screen',
        **options,
    )


def generate_launch_description() -> LaunchDescription:
    """Return the graph; the parameter file makes the nodes wait for each other."""
    speed = ParameterValue(LaunchConfiguration('speed'), value_type=float)
    recording = {
        'output': ParameterValue(LaunchConfiguration('out'), value_type=str),
        'force': ParameterValue(LaunchConfiguration('force'), value_type=bool),
    }
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (default, description) in ARGUMENTS.items()
            ),
            _node('recorder', recording, on_exit=Shutdown(reason='the voyage is over')),
            _node('longitude', {}),
            _node('drift_estimator', {}),
            _node('trochlea', {}),
            _node('ship_motion', {'speed': speed}),
        ]
    )
