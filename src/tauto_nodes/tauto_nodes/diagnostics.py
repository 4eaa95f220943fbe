"""/diagnostics: one status a second from each node, named with its namespace.

A node publishes OK, WARN and ERROR; STALE is what an aggregator says of a node that is silent.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from typing import TYPE_CHECKING

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.duration import Duration
from rclpy.qos import QoSProfile

from tauto_core.samples import OBSERVATION, SCENE, SHIP_FIX

if TYPE_CHECKING:
    from tauto_nodes.member import Member

PERIOD_S = 1.0

IRREGULAR = (SCENE, OBSERVATION)
"""Topics whose silence means nothing."""

OPTIONAL = (SCENE, OBSERVATION, SHIP_FIX)
"""Topics that a graph on a live sensor may do without."""

RECENT_S = 10.0
"""Time after a counter has risen during which it causes a warning [s]."""

LAST_WORDS_S = 1

Finding = tuple[bytes, str]


def assess(member: Member, now_s: float, recent: dict[str, int] | None = None) -> Finding:
    """Return the worst level and the reasons for it.

    Args:
        member: the node whose status it is.
        now_s: steady time [s], as time.monotonic gives it.
        recent: by how much counters have risen in the last RECENT_S; None: since the start.
    """
    risen = {name: n for name, n in member.health().items() if n} if recent is None else recent
    found = list(_findings(member, now_s, risen))
    level = max((level for level, _ in found), default=DiagnosticStatus.OK)
    words = '; '.join(words for at, words in found if at == level)
    return level, words or ('finished' if member.input_over else 'under way')


def _findings(member: Member, now_s: float, risen: dict[str, int]) -> Iterator[Finding]:
    error, warn = DiagnosticStatus.ERROR, DiagnosticStatus.WARN
    if member.failure is not None:
        yield error, f'failed: {member.failure}'
    if clash := [
        t for t, source in member.inputs.items() if source.incompatible and not source.matched
    ]:
        yield error, f'incompatible QoS on {", ".join(clash)}'
    if member.input_over:
        return
    if member.trouble:
        yield error, member.trouble
    if passed := member.recent_alarm(now_s):
        yield error, passed
    yield from _missing(member, now_s)
    for topic, source in member.inputs.items():
        if source.matched > 1:
            yield warn, f'several publishers on {topic}: {", ".join(member.sources_of(topic))}'
    if len(twins := member.twins()) > 1:
        yield warn, f'{len(twins)} nodes are named {twins[0]}'
    if risen:
        counters = ', '.join(f'{name} {n}' for name, n in risen.items())
        yield warn, f'in the last {RECENT_S:g} s: {counters}'


def _missing(member: Member, now_s: float) -> Iterator[Finding]:
    """Yield what is missing: nodes, publishers, messages."""
    if member.waiting:
        yield DiagnosticStatus.WARN, f'waiting for {", ".join(member.waiting)}'
    lonely = [topic for topic, source in member.inputs.items() if not source.matched]
    if member.flow is None:
        # A recorder takes what there is; a stage can do without what is optional.
        needed = [topic for topic in lonely if topic not in OPTIONAL]
        lonely = needed if member.outputs or len(lonely) == len(member.inputs) else []
    if unsent := [topic for topic in lonely if not member.misfits(topic)]:
        yield DiagnosticStatus.WARN, f'no publisher on {", ".join(unsent)}'
    for topic in lonely:
        if others := member.misfits(topic):
            wanted = member.inputs[topic].type_name
            yield (
                DiagnosticStatus.WARN,
                f'no publisher of {wanted} on {topic}: {", ".join(others)}. Let one send {wanted}',
            )
    limit_s = member.settings.number('stale_after')
    if silent := [
        topic
        for topic, source in member.inputs.items()
        if topic not in IRREGULAR
        and source.matched
        and source.last_s is not None
        and now_s - source.last_s > limit_s
    ]:
        level = DiagnosticStatus.ERROR if member.outputs else DiagnosticStatus.WARN
        yield level, f'nothing for {limit_s:g} s on {", ".join(silent)}'


class Diagnostics:
    """Publishes a member's status once a second, and whenever it is asked to."""

    def __init__(self, member: Member) -> None:
        self._member = member
        self._past: deque[tuple[float, dict[str, int]]] = deque()
        self._publisher = member.create_publisher(
            DiagnosticArray, '/diagnostics', QoSProfile(depth=10)
        )
        # Not guarded: a node that has failed in a foreign executor goes on saying so.
        member.create_timer(PERIOD_S, self.publish, clock=member.steady)

    def publish(self) -> None:
        """Publish the status as it is now."""
        member, now_s = self._member, time.monotonic()
        health = member.health()
        level, message = assess(member, now_s, self._risen(now_s, health))
        counts = {f'{topic} received': port.received for topic, port in member.inputs.items()}
        counts |= {f'{topic} sent': port.sent for topic, port in member.outputs.items()}
        status = DiagnosticStatus(
            level=level,
            name=member.get_fully_qualified_name().lstrip('/'),
            message=message,
            values=[KeyValue(key=k, value=str(n)) for k, n in {**counts, **health}.items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = member.get_clock().now().to_msg()
        self._publisher.publish(array)

    def deliver(self) -> None:
        """Wait, for a moment, until the last status has reached who subscribes to it."""
        self._publisher.wait_for_all_acked(Duration(seconds=LAST_WORDS_S))

    def _risen(self, now_s: float, health: dict[str, int]) -> dict[str, int]:
        self._past.append((now_s, health))
        while len(self._past) > 1 and self._past[1][0] <= now_s - RECENT_S:
            self._past.popleft()
        at_s, before = self._past[0]
        if now_s - at_s < RECENT_S:
            before = {}  # not yet that old
        return {
            name: n - before.get(name, 0) for name, n in health.items() if n > before.get(name, 0)
        }
