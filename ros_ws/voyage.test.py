"""Launch the voyage, wait for the clock, stop it in the middle: `launch_test voyage.test.py`.

For a machine with ROS 2 Jazzy; pytest does not collect it.
"""

from __future__ import annotations

import json
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any

import launch_testing.actions
import launch_testing.asserts
import pytest
import rclpy
from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare
from sensor_msgs.msg import TimeReference

BAG = Path(tempfile.mkdtemp()) / 'voyage'
READINGS = 10
DEADLINE_S = 60.0


@pytest.mark.launch_test
def generate_test_description() -> LaunchDescription:
    """Return the voyage at a pace that does not end before the test does."""
    file = PathJoinSubstitution(
        [FindPackageShare('tauto_nodes'), 'launch', 'voyage.launch.py'],
    )
    voyage = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(file),
        launch_arguments={'scene': 'measured', 'speed': '5.0', 'out': str(BAG)}.items(),
    )
    return LaunchDescription([voyage, launch_testing.actions.ReadyToTest()])


class AtSea(unittest.TestCase):
    """While the nodes run."""

    def test_the_clock_is_read(self) -> None:
        """Wait for readings on the topic."""
        readings: list[TimeReference] = []
        rclpy.init()
        node = rclpy.create_node('reader')
        try:
            node.create_subscription(TimeReference, 'clock/reading', readings.append, 100)
            deadline = time.monotonic() + DEADLINE_S
            while len(readings) < READINGS and time.monotonic() < deadline:
                rclpy.spin_once(node, timeout_sec=0.5)
        finally:
            node.destroy_node()
            rclpy.try_shutdown()
        assert len(readings) >= READINGS
        assert {reading.source for reading in readings} == {'dial'}


@launch_testing.post_shutdown_test()
class InPort(unittest.TestCase):
    """After all nodes were told to stop."""

    def test_every_node_ends_well(self, proc_info: Any) -> None:
        """Expect exit code 0 of all."""
        launch_testing.asserts.assertExitCodes(proc_info)

    def test_the_bag_holds_what_was_sailed(self) -> None:
        """Read the bag as a navigator would."""
        command = ['ros2', 'run', 'tauto_core', 'tauto', 'replay', str(BAG), '--json']
        run = subprocess.run(command, capture_output=True, text=True, check=True)
        counts = json.loads(run.stdout)['counts']
        assert counts['/clock/reading'] >= READINGS
