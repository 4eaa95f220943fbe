"""Ports: publishers and subscriptions for serialised messages, their quality of service and state.

Messages travel as the bytes that tauto_core.bags encodes and decodes: rclpy never builds a
message object, so a payload in the graph is the payload in the bag.
"""

from __future__ import annotations

import difflib
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, NamedTuple, cast

import numpy as np
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
from tauto_core.bags import TOPICS, decode
from tauto_core.navigation import ESTIMATE_NAMES
from tauto_core.scene.errors import BagError
from tauto_core.scene.times import NS_PER_S
from tauto_nodes import NodesError, ParameterError
from tauto_nodes.flow import PACKED_TIMES, pack
from tauto_nodes.parameters import QOS_PREFIX, overrides_of, shared_names

MIN_DEPTH = 1000
"""Least KEEP_LAST depth under flow control: above what may be in flight (flow.WINDOW)."""

CREDIT_QOS = QoSProfile(depth=100)
END_QOS = QoSProfile(depth=32, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
PACK_QOS = QoSProfile(depth=MIN_DEPTH * PACKED_TIMES)


@dataclass(frozen=True)
class TopicPort:
    """One side of a topic: its relative or absolute name, the rclpy message class, and the quality
    of service before overrides.
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


def port(topic: str, imu_reliability: str = 'reliable') -> TopicPort:
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
    return TopicPort(topic, message_class(entry.ros_type), profile)


def can_match(offered: QoSProfile, requested: QoSProfile) -> bool:
    """Return whether a subscription that asks for `requested` can match one of our publishers.

    Ours offer no deadline and no liveliness lease. rclpy's own check takes the infinite times
    that a discovered subscription reports for finite ones.
    """
    without_limit_ns = (0, 2**63 - 1)  # the second is what rmw reports
    reliable = QoSReliabilityPolicy.RELIABLE
    latched = QoSDurabilityPolicy.TRANSIENT_LOCAL
    return (
        (offered.reliability == reliable or requested.reliability != reliable)
        and (offered.durability == latched or requested.durability != latched)
        and requested.deadline.nanoseconds in without_limit_ns
        and requested.liveliness_lease_duration.nanoseconds in without_limit_ns
    )


def overriding(controlled: bool) -> QoSOverridingOptions:
    """Return the options that let parameters override history, depth and reliability.

    With flow control, overrides under which messages could be lost are refused.
    """

    def check(profile: QoSProfile) -> SetParametersResult:
        shallow = (
            profile.history == QoSHistoryPolicy.KEEP_LAST
            and profile.depth < MIN_DEPTH
            and profile.durability != QoSDurabilityPolicy.TRANSIENT_LOCAL
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
    ParameterError says which key none of them has, and the nearest that there is.
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


class Times(NamedTuple):
    """When a message was received and sent [ns], by the clock of the system."""

    received_ns: int
    sent_ns: int

    @staticmethod
    def told(info: Mapping[str, Any] | None) -> Times:
        """Return the times that the middleware reports, or now for both where it reports none."""
        if info is None:
            now_ns = time.time_ns()
            return Times(now_ns, now_ns)
        return Times(info['received_timestamp'] or time.time_ns(), info['source_timestamp'])


@dataclass
class Input:
    """State of one subscription.

    `type_name`: of the messages it takes; `last_s`: when a message or a publisher came last [s];
    `times` of the `pending` messages, where the node keeps them. On a topic that `is_shared` many
    may publish, and silence means nothing.
    """

    type_name: str
    is_shared: bool = False
    subscription: Any = None
    received: int = 0
    taken: int = 0
    last_s: float | None = None
    matched: int = 0
    incompatible: int = 0
    pending: list[bytes] = field(default_factory=list)
    times: list[Times] = field(default_factory=list)


@dataclass
class Output:
    """State of one publisher.

    `carrier`: of packs, where the graph has them, of its `run`; the topic itself then carries what
    others subscribe to, `watchers` in number, of whom those have been `named` that may lose some.
    `matched` counts the subscribers within the graph.
    """

    publisher: Any
    carrier: Any = None
    run: int = 0
    is_latched: bool = False
    watchers: int = 0
    sent: int = 0
    matched: int = 0
    incompatible: int = 0
    named: set[str] = field(default_factory=set)
    queue: deque[bytes] = field(default_factory=deque)

    @property
    def link(self) -> Any:
        """What carries the messages to the nodes of the graph."""
        return self.carrier or self.publisher

    @property
    def watched(self) -> bool:
        """Whether somebody takes single messages: beside a graph with packs, or anybody."""
        return bool(self.watchers if self.carrier is not None else self.matched)

    def publish(self, payloads: Sequence[bytes]) -> None:
        """Send messages, packed where the graph has packs."""
        if self.carrier is not None:
            for octets in pack(payloads, self.run):
                self.carrier.publish(octets)
        if self.carrier is None or self.watchers or self.is_latched:
            for payload in payloads:
                self.publisher.publish(payload)
        self.sent += len(payloads)


def node_of(info: Any) -> str:
    """Return the full name of the node that a publisher belongs to."""
    # rmw's name for a node that it has not heard of yet, or that has none.
    if info.node_name == '_NODE_NAME_UNKNOWN_':
        return 'a node not yet known by name'
    return f'{info.node_namespace.rstrip("/")}/{info.node_name}'


# -----------------------------------------------------------------------------
# From serialised messages to samples; invalid messages are counted and ignored.
#
# Anybody may publish anything on a topic. A message that cannot be decoded, belongs to another
# frame, or has wrong names or NaN neither ends a node nor hides its neighbours. The fate of a
# message does not depend on the others that came with it.


FRAME_NS = 10 * NS_PER_S
"""Time of messages in a new frame alone, as after a driver's restart, after which it is taken."""


class Intake:
    """Decodes the messages of one topic of the table.

    `note` is called with a reason and its description, once for each message that is ignored.
    Messages in another frame than before are ignored until they alone have come for `FRAME_NS`;
    meanwhile `trouble` says so.
    """

    def __init__(self, topic: str, note: Callable[[str, str], None]) -> None:
        self._topic, self._note = topic, note
        self._kind: tuple[str, tuple[str, ...], tuple[int, ...]] | None = None
        self._other: tuple[str, int] | None = None
        self.trouble = ''
        # Names with which the scalars must begin; for other topics the first message decides.
        self._required = ESTIMATE_NAMES if topic == s.ESTIMATE else None

    def samples(self, payloads: Sequence[bytes]) -> tuple[s.Samples | None, list[bytes]]:
        """Return the samples of the usable messages, None if there are none, and these messages.

        Messages without a header are stamped 0.
        """
        try:
            whole = self._decoded(payloads)
            if not any(self._faults(whole)):
                self._other, self.trouble = None, ''
                return whole, list(payloads)
        except BagError:
            pass  # one by one it is found which of them cannot be decoded
        good: list[tuple[s.Samples, bytes]] = []
        for payload in payloads:
            try:
                sample = self._decoded([payload])
                fault = next(self._faults(sample), None)
                if fault is not None and fault[0] == 'other_frame':
                    fault = self._waited(sample, fault)
                elif fault is None:
                    self._other, self.trouble = None, ''
            except BagError as error:
                fault = 'undecodable', str(error)
            if fault is None:
                good.append((sample, payload))
            else:
                self._note(fault[0], f'a message is left aside: {fault[1]}')
        if not good:
            return None, []
        return s.join([cast(s.TimeSamples, one) for one, _ in good]), [raw for _, raw in good]

    def _waited(self, sample: Any, fault: tuple[str, str]) -> tuple[str, str] | None:
        """Return the fault of a message in another frame; None once that frame is taken."""
        frame, stamp_ns = sample.frame_id, int(sample.stamp_ns[0])
        if self._other is None or self._other[0] != frame:
            self._other = frame, stamp_ns
        if stamp_ns - self._other[1] >= FRAME_NS:
            self._kind = self._other = None
            self.trouble = ''
            return next(self._faults(sample), None)
        self.trouble = f'{self._topic}: {fault[1]}; such messages are left aside'
        return fault

    def _decoded(self, payloads: Sequence[bytes]) -> s.Samples:
        samples = decode(self._topic, payloads, np.zeros(len(payloads), np.int64))
        if s.count(samples) != len(payloads):
            raise BagError(f'{self._topic}: {len(payloads)} messages, other samples')
        return samples

    def _faults(self, samples: s.Samples) -> Iterator[tuple[str, str]]:
        """Yield what is wrong with samples, in a word and in full."""
        if isinstance(samples, s.TextSamples | s.SpatialImu):
            return
        if samples.stamp_ns.min() < 0:
            yield 'out_of_range', f'stamped {samples.stamp_ns.min() * 1e-9:.6g} s, before 0'
        names: tuple[str, ...] = ()
        widths: tuple[int, ...] = ()
        if isinstance(samples, s.JointSamples):
            names = samples.name
            numbers = (samples.position, samples.velocity, samples.effort)
            widths = tuple(number.shape[1] for number in numbers)
            if not all(np.isfinite(number).all() for number in numbers):
                yield 'not_finite', 'one of its numbers is none'
        if self._required is not None and names[: len(self._required)] != self._required:
            yield 'other_names', f'names {names}, which do not begin with {self._required}'
        if self._kind is None:
            self._kind = samples.frame_id, names, widths
        frame, first_names, first_widths = self._kind
        if frame != samples.frame_id:
            yield 'other_frame', f'frame {samples.frame_id!r}, not {frame!r} as before'
        if first_names != names:
            yield 'other_names', f'names {names}, not {first_names} as before'
        if first_widths != widths:
            yield 'other_widths', f'arrays of {widths} numbers, not {first_widths} as before'
