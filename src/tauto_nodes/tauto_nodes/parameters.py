"""The parameter table: declaration, validation and docs/parameters.md all come from it."""

from __future__ import annotations

import difflib
import math
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias, TypeVar

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from tauto_nodes.errors import ParameterError

Value: TypeAlias = bool | float | str | tuple[str, ...]
T = TypeVar('T')

_TYPES = {bool: 'bool', float: 'double', str: 'string', tuple: 'string[]'}
_ROS_TYPES = {
    RosParameter.Type.BOOL: 'bool',
    RosParameter.Type.INTEGER: 'integer',
    RosParameter.Type.DOUBLE: 'double',
    RosParameter.Type.STRING: 'string',
    RosParameter.Type.STRING_ARRAY: 'string[]',
}
_OF_ROS = ('use_sim_time', 'start_type_description_service')
_PREFIX_OF_ROS = 'qos_overrides.'


@dataclass(frozen=True)
class Settings:
    """What a node's parameters are set to at its start, by name, each in its type."""

    values: Mapping[str, Value]

    def text(self, name: str) -> str:
        """Return a string."""
        return _of(str, self.values[name])

    def number(self, name: str) -> float:
        """Return a double."""
        return _of(float, self.values[name])

    def flag(self, name: str) -> bool:
        """Return a bool."""
        return _of(bool, self.values[name])

    def names(self, name: str) -> tuple[str, ...]:
        """Return a string array."""
        return _of(tuple, self.values[name])

    @property
    def credits(self) -> bool:
        """Whether the node takes part in flow control."""
        return self.values.get('flow_control') == 'credits'


def _of(kind: type[T], value: object) -> T:
    assert isinstance(value, kind)
    return value


@dataclass(frozen=True)
class Parameter:
    """One parameter of a node.

    Args:
        name: as in a parameter file.
        default: its type is the parameter's type (double, bool, string or string array).
        description: what it sets.
        unit: of the value, empty where it has none.
        low, high: closed range of a double.
        choices: the strings allowed; empty: any.
        required: an empty string is refused.
        read_only: set at the start only.
    """

    name: str
    default: Value
    description: str
    unit: str = ''
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[str, ...] = ()
    required: bool = False
    read_only: bool = True

    @property
    def type(self) -> str:
        """The type's name in ROS."""
        return _TYPES[type(self.default)]

    @property
    def allowed(self) -> str:
        """The range or choices in words; empty where anything goes."""
        if self.choices:
            return ', '.join(f'`{choice}`' for choice in self.choices)
        if isinstance(self.default, float) and math.isfinite(self.low):
            return f'{self.low:g} … {self.high:g}'
        return 'not empty' if self.required else ''

    def problem(self, value: object) -> str:
        """Return why the value is refused; empty where it is not."""
        said = f'{self.name} = {value!r}'
        if isinstance(self.default, float) and isinstance(value, float):
            if not self.low <= value <= self.high:  # also false for NaN
                return f'{said}: must lie in [{self.low:g}, {self.high:g}] {self.unit}'.rstrip()
        elif self.choices and value not in self.choices:
            return f'{said}: must be one of {", ".join(self.choices)}'
        elif self.required and not value:
            return f'{said}: must be given, for example -p {self.name}:=…  ({self.description})'
        return ''


_EXECUTOR = Parameter(
    'executor',
    'events',
    "what spins the node: `events` is several times faster, `single` is rclpy's standard one",
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
_FLOW = (
    Parameter(
        'flow_control',
        'none',
        '`credits`: senders wait for receivers and nothing is lost (all nodes of the graph must '
        'have it); `none`: the graph is driven by somebody else',
        choices=('none', 'credits'),
    ),
    Parameter(
        'graph',
        ('ship_motion', 'trochlea', 'drift_estimator', 'longitude', 'recorder'),
        "with `credits`: names of all nodes of this namespace's graph; nothing is sent before "
        'all of them are there',
    ),
)
_SCENE = Parameter('scene', 'measured', 'scene file or name of a shipped scene', required=True)
_DURATION = Parameter(
    'duration',
    0.0,
    "replaces the duration of the scene; 0: the scene's own",
    unit='s',
    low=0.0,
    high=1e10,
)
_SOURCE = Parameter(
    'source',
    'scene',
    "`scene`: the inputs follow the scene's schedule from its first stamp; `foreign`: a sensor, "
    'another simulator or a bag drives the graph, which is anchored at the first stamp that comes',
    choices=('scene', 'foreign'),
)
_IMU = Parameter(
    'imu_reliability',
    'reliable',
    'what the subscription to ship/imu asks for; most sensors only offer `best_effort`',
    choices=('reliable', 'best_effort'),
)
_CLOCK = Parameter(
    'publish_clock',
    False,
    'publish /clock, at most 100 times a second; refused where somebody else publishes it',
)
_WAIT = Parameter(
    'wait',
    2.0,
    'without flow control: begin when each topic has a subscriber, but after this time anyway',
    unit='s',
    low=0.0,
    high=3600.0,
)
_STATE = (
    Parameter(
        'state_folder',
        '',
        'folder for a file with the state of the stage, restored at the next start, so that the '
        'dial goes on; empty: none. Not with `credits`',
    ),
    Parameter(
        'state_interval',
        10.0,
        'time between two writings of the state',
        unit='s',
        low=0.1,
        high=86400.0,
    ),
)
_COMMON = (_EXECUTOR, _STALE, *_FLOW)
_STAGE = (_SCENE, _DURATION, _SOURCE, *_STATE, *_COMMON)

PARAMETERS: dict[str, tuple[Parameter, ...]] = {
    'ship_motion': (
        _SCENE,
        _DURATION,
        Parameter(
            'speed',
            1.0,
            'sea time by wall time; 0: as fast as the graph can, which needs `credits`',
            unit='s/s',
            low=0.0,
            high=1e6,
            read_only=False,
        ),
        _CLOCK,
        _WAIT,
        *_COMMON,
    ),
    'trochlea': (*_STAGE, _IMU),
    'drift_estimator': _STAGE,
    'longitude': _STAGE,
    'recorder': (
        Parameter('output', '', 'folder of the bag to write', required=True),
        Parameter('force', False, 'replace a bag that is already there'),
        Parameter('topics', ('all',), 'topics to record, relative names; `all`: the topic table'),
        Parameter(
            'scene',
            '',
            'scene file or shipped name: ship/imu is left out where the scene keeps no motion; '
            'empty: every topic asked for is recorded',
        ),
        _DURATION,
        _IMU,
        Parameter(
            'flush_interval',
            1.0,
            'what came longer ago is in the file, whatever becomes of the process',
            unit='s',
            low=0.05,
            high=3600.0,
        ),
        Parameter(
            'chunk_size',
            64.0,
            'of the MCAP chunks, before compression',
            unit='KiB',
            low=1.0,
            high=65536.0,
        ),
        Parameter('compression', 'zstd', 'of the chunks', choices=('zstd', 'none')),
        Parameter('report', '', 'file for the counts per topic, as JSON; empty: the log only'),
        *_COMMON,
    ),
    'player': (
        Parameter('bag', '', 'bag to play: a folder or an .mcap file', required=True),
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
            ('scene', 'ship/imu', 'ship/fix', 'clock/observation'),
            'topics to play, as in the bag less its namespace; `all`: every topic of the bag',
        ),
        _CLOCK,
        _WAIT,
        _EXECUTOR,
        _STALE,
    ),
}


def _problems(role: str, overrides: Mapping[str, RosParameter]) -> Iterable[str]:
    table = {parameter.name: parameter for parameter in PARAMETERS[role]}
    for name, given in overrides.items():
        if name in _OF_ROS or name.startswith(_PREFIX_OF_ROS):
            continue
        if name not in table:
            near = difflib.get_close_matches(name, table, 1, 0.0)[0]
            yield f'{name}: no such parameter of {role}; the nearest is {near}'
            continue
        expected, found = table[name].type, _ROS_TYPES.get(given.type_, given.type_.name.lower())
        if expected == 'double' and found == 'integer':
            yield (
                f'{name} = {given.value}: is an integer, must be a double; '
                f'write {float(given.value)!r}'
            )
        elif expected != found:
            yield f'{name} = {given.value!r}: is of type {found}, must be {expected}'
        elif problem := table[name].problem(given.value):
            yield problem
    for parameter in table.values():
        if parameter.name not in overrides and (problem := parameter.problem(parameter.default)):
            yield problem


def _descriptor(parameter: Parameter) -> ParameterDescriptor:
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
    return descriptor


def declare(node: Node, role: str) -> Settings:
    """Declare a node's parameters and return what they are set to.

    Run-time changes of the few that allow it are checked against the table.

    Raises:
        ParameterError: unknown names, wrong types, values out of range; all of them in one text.
    """
    # The overrides hold what is undeclared too; rclpy has no public way to list them.
    problems = list(_problems(role, node._parameter_overrides))
    if problems:
        raise ParameterError(f'{node.get_fully_qualified_name()}: ' + '; '.join(problems))
    table = {parameter.name: parameter for parameter in PARAMETERS[role]}
    for parameter in table.values():
        node.declare_parameter(parameter.name, parameter.default, _descriptor(parameter))

    def check(changes: list[RosParameter]) -> SetParametersResult:
        found = [
            problem
            for change in changes
            if change.name in table and (problem := table[change.name].problem(change.value))
        ]
        return SetParametersResult(successful=not found, reason='; '.join(found))

    node.add_on_set_parameters_callback(check)
    values = {name: node.get_parameter(name).value for name in table}
    return Settings(
        MappingProxyType(
            {
                name: value if isinstance(value, bool | float | str) else tuple(value)
                for name, value in values.items()
            }
        )
    )


def _spelled(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return '[' + ', '.join(value) + ']'
    return repr(value) if isinstance(value, float) else (value or '(empty)')


def reference_page() -> str:
    """Return docs/parameters.md."""
    lines = [
        '# Parameters of the nodes',
        '',
        'Generated from `tauto_nodes/parameters.py`; a test keeps the two equal.',
        'Unknown names, wrong types and values out of range stop a node at its start, with the',
        'reason. Doubles need their point: `speed:=2.0`. Besides these, `use_sim_time` and',
        '`qos_overrides.<topic>.<publisher|subscription>.<history|depth|reliability>` are known.',
    ]
    for role, table in PARAMETERS.items():
        lines += [
            '',
            f'## {role}',
            '',
            '| name | type | default | unit | allowed | at run time | meaning |',
            '|---|---|---|---|---|---|---|',
        ]
        lines += [
            f'| `{p.name}` | {p.type} | `{_spelled(p.default)}` | {p.unit} | {p.allowed} '
            f'| {"no" if p.read_only else "yes"} | {p.description} |'
            for p in table
        ]
    return '\n'.join(lines) + '\n'
