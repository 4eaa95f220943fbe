"""The parameters of the nodes: types, limits, one table, files, their page of the docs."""

from __future__ import annotations

import difflib
import math
import os
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias

import yaml
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from rclpy.subscription import Subscription

from tauto_core.scene import Scene, load_scene, shipped_scenes
from tauto_nodes import ParameterError

# -----------------------------------------------------------------------------
# All uses of rclpy outside of its public interface.
#
# Tried with rclpy 7.1.6 (Jazzy).

RCLError = rclpy_implementation.RCLError
"""What rcl refuses: `rclpy.exceptions` does not export it."""

UnknownROSArgsError = rclpy_implementation.UnknownROSArgsError


def overrides_of(node: Node) -> Mapping[str, RosParameter]:
    """Return the parameters that command line, files and caller set, undeclared ones included.

    `Node` lists them publicly only after it has declared all of them, without our table.
    """
    overrides: Mapping[str, RosParameter] = node._parameter_overrides
    return overrides


def take_raw(subscription: Subscription) -> tuple[bytes, Mapping[str, Any]] | None:
    """Return the next serialised message of a subscription's queue and its info, or `None`.

    An executor takes one message a wait, and there is no public way to take the others.
    """
    with subscription.handle:
        taken: tuple[bytes, Mapping[str, Any]] | None = subscription.handle.take_message(
            subscription.msg_type, True
        )
    return taken


# -----------------------------------------------------------------------------
# One parameter of a node: its type, its limits, and the message for a value that is refused.

ParameterValue: TypeAlias = bool | float | str | tuple[str, ...]

_TYPES = {bool: 'bool', float: 'double', str: 'string', tuple: 'string[]'}

FOLDER_VARIABLE = 'TAUTO_FOLDER'
"""Environment variable: nodes read and write by their parameters in this folder only."""


@dataclass(frozen=True)
class Parameter:
    """One parameter of a node.

    Args:
        name: as in a parameter file.
        default: its type is the parameter's type (double, bool, string or string array).
        description: its meaning.
        unit: unit of the value, or empty.
        low, high: closed range of a double.
        choices: the allowed strings, if they are limited.
        required: an empty string is refused.
        is_path: it names a file or folder, which must be in TAUTO_FOLDER if that is set.
        read_only: set at the start only.
    """

    name: str
    default: ParameterValue
    description: str
    unit: str = ''
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[str, ...] = ()
    required: bool = False
    is_path: bool = False
    read_only: bool = True

    @property
    def type(self) -> str:
        """The type's name in ROS."""
        return _TYPES[type(self.default)]

    @property
    def allowed(self) -> str:
        """The range or choices in words, or an empty text."""
        if self.choices:
            return ', '.join(f'`{choice}`' for choice in self.choices)
        if isinstance(self.default, float) and math.isfinite(self.low):
            return f'{self.low:g} … {self.high:g}'
        return 'not empty' if self.required else ''

    def problem(self, value: object) -> str:
        """Return why the value is refused, or an empty text."""
        said = f'{self.name} = {value!r}'
        if isinstance(self.default, float) and isinstance(value, float):
            if not self.low <= value <= self.high:  # also false for NaN
                return f'{said}: must lie in [{self.low:g}, {self.high:g}] {self.unit}'.rstrip()
        elif self.choices and value not in self.choices:
            return f'{said}: must be one of {", ".join(self.choices)}'
        elif self.required and not value:
            return f'{said}: must be given, for example -p {self.name}:=…  ({self.description})'
        folder = os.environ.get(FOLDER_VARIABLE)
        if not (folder and self.is_path and value) or value in shipped_scenes():
            return ''
        if Path(str(value)).resolve().is_relative_to(Path(folder).resolve()):
            return ''
        return f'{said}: is outside of {FOLDER_VARIABLE} = {folder}. Name a place in it'


# -----------------------------------------------------------------------------
# Parameter files: write a graph's, and find the section of all nodes in others.


def write_parameters(
    folder: Path, namespace: str, own: Mapping[str, Mapping[str, object]]
) -> Path:
    """Write a file with the parameters of a graph's nodes, `own` by name. Return its path."""
    space = f'/{namespace.strip("/")}'.rstrip('/')
    # No object comes twice: the parser of ROS takes no YAML aliases.
    content = {f'{space}/{node}': {'ros__parameters': {**held}} for node, held in own.items()}
    file = folder / 'parameters.yaml'
    file.write_text(yaml.safe_dump(content), 'utf-8')
    return file


_ROS_TYPES = {
    RosParameter.Type.BOOL: 'bool',
    RosParameter.Type.INTEGER: 'integer',
    RosParameter.Type.DOUBLE: 'double',
    RosParameter.Type.STRING: 'string',
    RosParameter.Type.STRING_ARRAY: 'string[]',
}
_OF_ROS = ('use_sim_time', 'start_type_description_service')
QOS_PREFIX = 'qos_overrides.'


@dataclass(frozen=True)
class NodeSettings:
    """The values of a node's parameters at its start, by name, each in its type."""

    values: Mapping[str, ParameterValue]

    def __getitem__(self, name: str) -> Any:
        """Return the value of a parameter, in the type of its default."""
        return self.values[name]

    def scene(self) -> Scene:
        """Load the scene that the parameters `scene` and `duration` name (SceneError: invalid)."""
        duration = self['duration']
        return load_scene(self['scene'], **({'duration': duration} if duration > 0.0 else {}))

    @property
    def credits(self) -> bool:
        """Whether the node takes part in flow control."""
        return self.values.get('flow_control') == 'credits'

    @property
    def packed(self) -> bool:
        """Whether nodes of the graph send each other many messages in one."""
        return self.credits and self.values.get('packed') is True


_EXECUTOR = Parameter(
    'executor',
    'events',
    "executor of the node: `events` is several times faster, `single` is rclpy's standard one",
    choices=('events', 'single'),
)
_STALE = Parameter(
    'stale_after',
    5.0,
    'an input that has been silent this long is reported as stale in /diagnostics',
    unit='s',
    low=0.1,
    high=86400.0,
)
_SCENE = Parameter(
    'scene', 'measured', 'scene file or name of a built-in scene', required=True, is_path=True
)
_DURATION = Parameter(
    'duration',
    0.0,
    "replaces the duration of the scene (0: the scene's own)",
    unit='s',
    low=0.0,
    high=1e10,
)
_IMU = Parameter(
    'imu_reliability',
    'reliable',
    'reliability that the subscription to ship/imu requests. Most sensors only offer '
    '`best_effort`',
    choices=('reliable', 'best_effort'),
)
_MOUNT = Parameter(
    'imu_rotation',
    '',
    "mounting of the sensor: roll, pitch and yaw of its axes in the clock's axes, in degrees "
    "(`'0 0 90'`: its x points to port). If empty, its frame must be clock_mount, or have a "
    'static transform of tf2 to it. With a foreign source',
)
_FIX_SPEED = Parameter(
    'fix_max_speed',
    50.0,
    'with a foreign source: largest speed of the ship. A fix out of its reach is refused until '
    'such fixes persist for a minute, and the sigma of a place grows by it with age',
    unit='m/s',
    low=0.1,
    high=1000.0,
)
_CLOCK = Parameter(
    'publish_clock',
    False,
    'publish /clock, at most 100 times a second. Refused if another node publishes it',
)
_WAIT = Parameter(
    'wait',
    2.0,
    'without flow control: begin when each topic has a subscriber, but after this time anyway',
    unit='s',
    low=0.0,
    high=3600.0,
)
_COMMON = (
    _EXECUTOR,
    _STALE,
    Parameter(
        'flow_control',
        'none',
        '`credits`: senders wait for receivers, and no message is lost (all nodes of the graph '
        'must have it). `none`: another program drives the graph',
        choices=('none', 'credits'),
    ),
    Parameter(
        'graph',
        ('ship_motion', 'trochlea', 'drift_estimator', 'longitude', 'recorder'),
        "with `credits`: names of all nodes of this namespace's graph, which wait for each other",
    ),
    Parameter(
        'packed',
        False,
        'with `credits`: nodes of the graph send each other many messages in one, on hidden '
        'topics. The topics themselves serve other subscribers. The same on all nodes',
    ),
)
_STAGE = (
    _SCENE,
    _DURATION,
    Parameter(
        'source',
        'scene',
        "`scene`: the inputs follow the scene's schedule from its first stamp. `foreign`: a "
        'sensor, another simulator or a bag drives the graph, which is anchored at the first '
        'stamp that comes',
        choices=('scene', 'foreign'),
    ),
    Parameter(
        'state_folder',
        '',
        'folder for the state of the stage, which continues from it at its next start (empty: no '
        'state). Not with `credits`. live.launch.py names one',
        is_path=True,
    ),
    Parameter(
        'state_interval',
        10.0,
        'time between two writings of the state. An observation is written at once',
        unit='s',
        low=0.1,
        high=86400.0,
    ),
    *_COMMON,
)

PARAMETERS: dict[str, tuple[Parameter, ...]] = {
    'ship_motion': (
        _SCENE,
        _DURATION,
        Parameter(
            'speed',
            1.0,
            'sea time by wall time (0: as fast as the graph can, with `credits`)',
            unit='s/s',
            low=0.0,
            high=1e6,
            read_only=False,
        ),
        _CLOCK,
        _WAIT,
        *_COMMON,
    ),
    'trochlea': (
        *_STAGE,
        _IMU,
        _MOUNT,
        Parameter(
            'reset_on_time_jump',
            False,
            'with a foreign source: set the dial again if the stamps of ship/imu go back for '
            'good, not only if /clock goes back under `use_sim_time`',
        ),
    ),
    'drift_estimator': (*_STAGE, _IMU, _MOUNT, _FIX_SPEED),
    'longitude': (
        *_STAGE,
        Parameter(
            'fix_max_age',
            10.0,
            'with a foreign source: age of the last fix from which on the place is unknown',
            unit='s',
            low=0.1,
            high=86400.0,
        ),
        _FIX_SPEED,
    ),
    'recorder': (
        Parameter('output', '', 'folder of the bag to write', required=True, is_path=True),
        Parameter('force', False, 'replace a bag that is already there'),
        Parameter('beside', False, 'if there is a bag already, write NAME_2, NAME_3, …'),
        Parameter(
            'topics',
            ('all',),
            'topics to record, relative names. `all`: the topic table and, without `credits`, '
            '/diagnostics and /tf_static. Without `credits` absolute names add other topics',
        ),
        Parameter(
            'scene',
            '',
            'scene file or built-in name: ship/imu is omitted if the scene keeps no motion, and '
            'without `credits` the bag begins with the scene, for `tauto replay`. Empty: record '
            'all topics that are asked for',
            is_path=True,
        ),
        _DURATION,
        _IMU,
        Parameter(
            'flush_interval',
            1.0,
            'messages older than this are in the file, even if the process is killed',
            unit='s',
            low=0.05,
            high=3600.0,
        ),
        Parameter(
            'chunk_size',
            512.0,
            'of the MCAP chunks, before compression. A flush ends a chunk earlier',
            unit='KiB',
            low=1.0,
            high=65536.0,
        ),
        Parameter('compression', 'zstd', 'of the chunks', choices=('zstd', 'none')),
        Parameter(
            'report',
            '',
            'file for the counts per topic, as JSON, in a graph also under way (empty: log only)',
            is_path=True,
        ),
        *_COMMON,
    ),
    'markers': (
        _SCENE,
        _DURATION,
        _IMU,
        Parameter('rate', 20.0, 'drawings a second, at most', unit='Hz', low=0.1, high=100.0),
        Parameter(
            'magnify',
            20.0,
            'how much larger than life the clock is drawn. The ship is 30 m long',
            low=1e-3,
            high=1e6,
        ),
        _EXECUTOR,
        _STALE,
    ),
    'player': (
        Parameter(
            'bag', '', 'bag to play: a folder or an .mcap file', required=True, is_path=True
        ),
        Parameter(
            'rate',
            1.0,
            'time in the bag by wall time',
            unit='s/s',
            low=1e-3,
            high=1e6,
            read_only=False,
        ),
        Parameter(
            'topics',
            ('scene', 'ship/imu', 'ship/fix', 'ship/temperature', 'clock/observation'),
            'topics to play, as in the bag less its namespace. `all`: every topic of the bag',
        ),
        _CLOCK,
        _WAIT,
        _EXECUTOR,
        _STALE,
    ),
}


def _problems(role: str, overrides: Mapping[str, RosParameter]) -> Iterable[str]:
    table = {parameter.name: parameter for parameter in PARAMETERS[role]}
    anywhere = {p.name for parameters in PARAMETERS.values() for p in parameters}.union(_OF_ROS)
    for name, given in overrides.items():
        if name not in table:
            # a section /** of a parameter file is for all nodes
            if name not in anywhere and not name.startswith(QOS_PREFIX):
                near = difflib.get_close_matches(name, table, 1, 0.0)[0]
                yield f'{name}: no such parameter of {role}. The nearest is {near}'
            continue
        expected, found = table[name].type, _ROS_TYPES.get(given.type_, given.type_.name.lower())
        if expected != found:
            remedy = (
                f'. Write {given.value}.0' if (expected, found) == ('double', 'integer') else ''
            )
            yield f'{name} = {given.value!r}: is of type {found}, must be {expected}{remedy}'
        elif problem := table[name].problem(given.value):
            yield problem
    for parameter in table.values():
        if parameter.name not in overrides and (problem := parameter.problem(parameter.default)):
            yield problem


def declare(node: Node, role: str) -> NodeSettings:
    """Declare a node's parameters and return their values.

    Changes at run time are checked against the table. One ParameterError names all parameters
    that no node has, wrong types and values out of range. Those of other nodes are ignored.
    """
    if problems := list(_problems(role, overrides_of(node))):
        raise ParameterError(f'{node.get_fully_qualified_name()}: ' + '; '.join(problems))
    table = {parameter.name: parameter for parameter in PARAMETERS[role]}
    for parameter in table.values():
        unit = f' [{parameter.unit}]' if parameter.unit else ''
        descriptor = ParameterDescriptor(
            name=parameter.name,
            description=parameter.description + unit,
            additional_constraints=parameter.allowed,
            read_only=parameter.read_only,
        )
        if isinstance(parameter.default, float) and math.isfinite(parameter.low):
            high = min(parameter.high, sys.float_info.max)
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=parameter.low, to_value=high, step=0.0)
            ]
        node.declare_parameter(parameter.name, parameter.default, descriptor)

    def check(changes: list[RosParameter]) -> SetParametersResult:
        found = [
            problem
            for change in changes
            if change.name in table and (problem := table[change.name].problem(change.value))
        ]
        return SetParametersResult(successful=not found, reason='; '.join(found))

    node.add_on_set_parameters_callback(check)
    held = {name: node.get_parameter(name).value for name in table}
    values = {k: v if isinstance(v, bool | float | str) else tuple(v) for k, v in held.items()}
    return NodeSettings(MappingProxyType(values))
