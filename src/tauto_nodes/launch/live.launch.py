"""The clock on a live sensor (or another simulator, or `ros2 bag play`) that publishes ship/imu.

ros2 launch tauto_nodes live.launch.py scene:=measured imu:=/xsens/imu out:=voyage

The arguments are checked before anything starts. A node that dies is started again and goes on
from its state. One that refuses to start ends the launch, with an exit code that is not 0. For a
sensor on another machine set ROS_AUTOMATIC_DISCOVERY_RANGE.
"""

from __future__ import annotations

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import PathJoinSubstitution, ThisLaunchFileDir
from launch_ros.substitutions import FindPackageShare

PARAMETERS = PathJoinSubstitution([FindPackageShare('tauto_nodes'), 'config', 'foreign_imu.yaml'])
ARGUMENTS = {
    'scene': ('measured', 'scene file (absolute path) or name of a built-in scene'),
    'imu': ('ship/imu', 'topic of the sensor, sensor_msgs/Imu'),
    'imu_reliability': ('best_effort', 'reliability of the sensor: best_effort or reliable'),
    'imu_rotation': (
        '',
        'roll, pitch and yaw of the sensor, in degrees, as in 0 0 90. Empty: as the clock, or by '
        'tf2',
    ),
    'observation': ('clock/observation', 'topic of the true time, sensor_msgs/TimeReference'),
    'fix': ('ship/fix', 'topic of the place, sensor_msgs/NavSatFix'),
    'out': ('', 'folder of the bag. Empty: no bag'),
    'topics': ('', 'further topics of the bag, as in /imu/mag /battery'),
    'anyway': ('false', 'also use machines and ships beyond all known ones'),
    'state_folder': (
        'default',
        'folder for the states of the stages. Default: one for each scene, in tauto_states of '
        'ROS_HOME (~/.ros) or of TAUTO_FOLDER. `none`: no state',
    ),
    'use_sim_time': ('false', 'take the time from /clock, as from a simulator'),
    'markers': ('true', 'draw ship and clock for RViz and Foxglove, while one subscribes'),
    'namespace': ('', 'namespace of the nodes'),
    'executor': ('events', 'executor of the nodes: events or single'),
    'params_file': (PARAMETERS, 'parameters of all nodes'),
}


def generate_launch_description() -> LaunchDescription:
    """Return the nodes of the clock, without the sensor."""
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=value, description=words)
                for name, (value, words) in ARGUMENTS.items()
            ),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource([ThisLaunchFileDir(), '/nodes.launch.py']),
                launch_arguments={'kind': 'live', 'known': ' '.join(ARGUMENTS)}.items(),
            ),
        ]
    )
