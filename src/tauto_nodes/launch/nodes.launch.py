"""The nodes of voyage.launch.py and live.launch.py, which include this file.

`ros2` belongs to the system's Python, which may lack Tauto's packages. So launch files do not
import Tauto: the program `launch_plan`, in the Python of the nodes, checks the arguments and names
the nodes to start.
"""

from __future__ import annotations

import atexit
import json
import os
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from launch import LaunchDescription
from launch.actions import LogInfo, OpaqueFunction, SetEnvironmentVariable, Shutdown
from launch_ros.actions import Node
from launch_ros.substitutions import ExecutableInPackage

STOP_S, KILL_S = '60', '600'
"""Time that a node has after SIGINT until SIGTERM, and after that until SIGKILL [s]. Launch's own
is 5 s. A recorder that is killed before it has closed its bag leaves it without metadata, and on a
busy machine that takes minutes. Launch does not see whether a node still gets on."""

AGAIN_S = 1.0
"""Time after which a node that died is started again [s]."""

REFUSED = 2
"""Exit code of a node that would refuse to start the next time, too."""


def _nodes(context: Any) -> list[Any]:
    """Return the nodes to start. RuntimeError with the reason of a refusal."""
    given = {name: str(value) for name, value in context.launch_configurations.items()}
    known = given['known'].split()
    # From a mapping of parameters launch_ros makes a temporary file for each node, and leaves it.
    made = tempfile.TemporaryDirectory(prefix='tauto_graph_', dir=os.environ.get('TAUTO_FOLDER'))
    atexit.register(made.cleanup)
    folder = Path(made.name)
    asked = {
        'kind': given['kind'],
        'given': {name: given[name] for name in known},
        'typed': list(context.argv),
        'folder': str(folder),
        'supervisor': os.getpid(),
    }
    program = ExecutableInPackage('launch_plan', 'tauto_nodes').perform(context)
    check = subprocess.run(
        [program], input=json.dumps(asked), capture_output=True, text=True, check=False
    )
    if check.returncode:
        raise RuntimeError(check.stderr.strip())
    plan = json.loads(check.stdout.splitlines()[-1])
    started = [
        Node(
            package='tauto_nodes',
            executable=name,
            name=name,
            namespace=given['namespace'],
            parameters=[given['params_file'], str(folder / 'parameters.yaml')],
            ros_arguments=['--enclave', f'/tauto/{name}'],
            remappings=list(plan['remappings'].items()),
            output='screen',
            respawn=given['kind'] == 'live',
            respawn_delay=AGAIN_S,
            sigterm_timeout=STOP_S,
            sigkill_timeout=KILL_S,
            on_exit=_ended(name, given),
        )
        for name in plan['nodes']
    ]
    return [
        *(SetEnvironmentVariable(name, value) for name, value in plan['environment'].items()),
        *started,
    ]


def _ended(name: str, given: dict[str, str]) -> Callable[[Any, Any], list[Any]]:
    """Return the action for a node that has ended.

    A live node is started again, unless it has finished or refuses to start. The good end
    of a voyage's recorder is the end of the voyage. If a node ends early, launch ends
    the others, and itself with 1. A voyage goes on without `markers`.
    """

    def on_exit(event: Any, context: Any) -> list[Any]:
        code = event.returncode
        if context.is_shutdown or name == 'markers':
            return []
        if given['kind'] == 'live' and code not in (0, REFUSED):
            return [LogInfo(msg=f'node {name} ended with exit code {code}: it is started again')]
        if given['kind'] == 'voyage' and name == 'recorder' and code == 0:
            return [Shutdown(reason='the voyage is over')]
        raise RuntimeError(f'node {name} ended with exit code {code} before its time')

    return on_exit


def generate_launch_description() -> LaunchDescription:
    """Return the check of the arguments and the nodes."""
    return LaunchDescription([OpaqueFunction(function=_nodes)])
