"""A whole voyage: ship, trochlea, drift estimator, longitude and recorder for one scene.

ros2 launch tauto_nodes voyage.launch.py scene:=measured speed:=60.0 out:=bags/out/measured

The arguments are checked before anything starts. The launch ends when the recorder has everything
and has closed the bag, and with the first node that ends otherwise. Its exit code is then not 0.
"""

from __future__ import annotations

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import PathJoinSubstitution, ThisLaunchFileDir
from launch_ros.substitutions import FindPackageShare

PARAMETERS = PathJoinSubstitution([FindPackageShare('tauto_nodes'), 'config', 'voyage.yaml'])
ARGUMENTS = {
    'scene': ('measured', 'scene file (absolute path) or name of a built-in scene'),
    'speed': ('60.0', 'sea seconds in a second, or 0.0: as fast as the graph can'),
    'duration': ('0.0', "replaces the duration of the scene [s], or 0.0: the scene's own"),
    'out': ('voyage', 'folder of the bag'),
    'force': ('false', 'replace a bag that is there'),
    'anyway': ('false', 'sail machines and ships beyond all that are known, too'),
    'publish_clock': ('false', 'publish the time at sea on /clock'),
    'markers': ('true', 'draw ship and clock for RViz and Foxglove, while somebody looks'),
    'namespace': ('', 'namespace of the nodes'),
    'executor': ('events', 'executor of the nodes: events or single'),
    'params_file': (PARAMETERS, 'parameters of all nodes'),
}


def generate_launch_description() -> LaunchDescription:
    """Return the graph. The parameter file makes the nodes wait for each other."""
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=value, description=words)
                for name, (value, words) in ARGUMENTS.items()
            ),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource([ThisLaunchFileDir(), '/nodes.launch.py']),
                launch_arguments={'kind': 'voyage', 'known': ' '.join(ARGUMENTS)}.items(),
            ),
        ]
    )
