"""Ports: a topic's message class and quality of service, from the topic table of the bags."""

from __future__ import annotations

import difflib
import sys
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.qos import (
    QoSDurabilityPolicy,
    QoSHistoryPolicy,
    QoSProfile,
    QoSReliabilityPolicy,
)
from rclpy.qos_overriding_options import QoSOverridingOptions

from tauto_core import samples as s
from tauto_core.bags import TOPICS
from tauto_nodes.errors import NodesError, ParameterError
from tauto_nodes.flow import PACKED_TIMES
from tauto_nodes.parameter_files import shared_names
from tauto_nodes.parameters import QOS_PREFIX
from tauto_nodes.rclpy_private import overrides_of

MIN_DEPTH = 1000
"""Least KEEP_LAST depth under flow control: above what may be in flight (flow.WINDOW)."""

INFINITE_NS = 2**63 - 1
"""The value that rmw reports for a time without limit."""

CREDIT_QOS = QoSProfile(depth=100)
END_QOS = QoSProfile(depth=32, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
PACK_QOS = QoSProfile(depth=MIN_DEPTH * PACKED_TIMES)


@dataclass(frozen=True)
class Port:
    """One side of a topic.

    Args:
        name: relative or absolute topic name.
        message: the rclpy message class.
        profile: quality of service, before overrides.
    """

    name: str
    message: Any
    profile: QoSProfile

    @property
    def is_latched(self) -> bool:
        """Whether late subscribers get the last message."""
        return bool(self.profile.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL)


def message_class(ros_type: str) -> Any:
    """Return the class of a type named like `sensor_msgs/msg/Imu`.

    Raises:
        NodesError: its package is not installed.
    """
    package, _, name = ros_type.partition('/msg/')
    try:
        return getattr(import_module(f'{package}.msg'), name)
    except (ImportError, AttributeError) as error:
        raise NodesError(
            f'message type {ros_type}: not installed here. Install the ROS package {package}, '
            'or leave its topics out'
        ) from error


def type_name(message: Any) -> str:
    """Return the name of the type that `message_class` finds."""
    return f'{message.__module__.partition(".")[0]}/msg/{message.__name__}'


def port(topic: str, imu_reliability: str = 'reliable') -> Port:
    """Return the port of a topic of the table; `imu_reliability` matters for ship/imu only."""
    entry = TOPICS[topic]
    best_effort = topic == s.SHIP_IMU and imu_reliability == 'best_effort'
    reliability = (
        QoSReliabilityPolicy.BEST_EFFORT if best_effort else QoSReliabilityPolicy.RELIABLE
    )
    durability = (
        QoSDurabilityPolicy.TRANSIENT_LOCAL if entry.latched else QoSDurabilityPolicy.VOLATILE
    )
    profile = QoSProfile(depth=entry.depth, reliability=reliability, durability=durability)
    return Port(topic, message_class(entry.ros_type), profile)


def can_match(offered: QoSProfile, requested: QoSProfile) -> bool:
    """Return whether a subscription that asks for `requested` can match one of our publishers.

    Ours offer no deadline and no liveliness lease. rclpy's own check takes the infinite times
    that a discovered subscription reports for finite ones.
    """
    reliable = QoSReliabilityPolicy.RELIABLE
    latched = QoSDurabilityPolicy.TRANSIENT_LOCAL
    return (
        (offered.reliability == reliable or requested.reliability != reliable)
        and (offered.durability == latched or requested.durability != latched)
        and requested.deadline.nanoseconds in (0, INFINITE_NS)
        and requested.liveliness_lease_duration.nanoseconds in (0, INFINITE_NS)
    )


def overriding(controlled: bool) -> QoSOverridingOptions:
    """Return the options that let parameters override history, depth and reliability.

    With flow control, overrides under which messages could be lost are refused.
    """

    def check(profile: QoSProfile) -> SetParametersResult:
        latched = profile.durability == QoSDurabilityPolicy.TRANSIENT_LOCAL
        shallow = (
            profile.history == QoSHistoryPolicy.KEEP_LAST
            and profile.depth < MIN_DEPTH
            and not latched
        )
        lossy = profile.reliability != QoSReliabilityPolicy.RELIABLE
        if not controlled or not (shallow or lossy):
            return SetParametersResult(successful=True)
        return SetParametersResult(
            successful=False,
            reason=f'depth = {profile.depth}, reliability = {profile.reliability.name.lower()}: '
            f'flow_control = credits needs reliable and a depth of at least {MIN_DEPTH}',
        )

    return QoSOverridingOptions.with_default_policies(callback=check)


def refuse_unknown_qos(node: Node) -> None:
    """See that each `qos_overrides` key is one of a publisher or subscription of this node.

    Call it when these have been made: rclpy declares the keys of each, and ignores all others.

    Raises:
        ParameterError: which key none of them has, and the nearest that there is.
    """
    asked = [name for name in overrides_of(node) if name.startswith(QOS_PREFIX)]
    shared = shared_names(node.get_fully_qualified_name(), sys.argv)
    known = list(node.get_parameters_by_prefix(QOS_PREFIX.rstrip('.')))
    problems = []
    for name in asked:
        if node.has_parameter(name) or name in shared:
            continue
        nearest = difflib.get_close_matches(name.removeprefix(QOS_PREFIX), known, 1, 0.0)
        there = f'the nearest is {QOS_PREFIX}{nearest[0]}' if nearest else 'it has none'
        problems.append(f'{name}: no publisher or subscription of this node has it; {there}')
    if problems:
        raise ParameterError(f'{node.get_fully_qualified_name()}: ' + '; '.join(problems))
