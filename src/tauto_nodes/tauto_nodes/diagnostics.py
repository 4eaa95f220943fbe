"""/diagnostics: one status a second from each node, named with its namespace."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from itertools import chain
from typing import TYPE_CHECKING

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.qos import QoSProfile

from tauto_core.samples import OBSERVATION, SCENE

if TYPE_CHECKING:
    from tauto_nodes.member import Input, Member, Output

PERIOD_S = 1.0

IRREGULAR = (SCENE, OBSERVATION)
"""Topics whose silence means nothing."""


def assess(member: Member, now_s: float) -> tuple[bytes, str]:
    """Return the level and the reason for it, the worst first.

    Args:
        now_s: steady time [s], as time.monotonic gives it.
    """
    return next(iter(_findings(member, now_s)), (DiagnosticStatus.OK, 'under way'))


def _findings(member: Member, now_s: float) -> Iterator[tuple[bytes, str]]:
    ports: Iterable[tuple[str, Input | Output]] = chain(
        member.inputs.items(), member.outputs.items()
    )
    if clash := [topic for topic, port in ports if port.incompatible]:
        yield DiagnosticStatus.ERROR, f'incompatible QoS on {", ".join(clash)}'
    if member.input_over:
        yield DiagnosticStatus.OK, 'finished'
    if member.waiting:
        yield DiagnosticStatus.WARN, f'waiting for {", ".join(member.waiting)}'
    if lonely := [topic for topic, source in member.inputs.items() if not source.matched]:
        yield DiagnosticStatus.WARN, f'no publisher on {", ".join(lonely)}'
    limit_s = member.settings.number('stale_after')
    if stale := [
        topic
        for topic, source in member.inputs.items()
        if topic not in IRREGULAR and source.last_s is not None and now_s - source.last_s > limit_s
    ]:
        yield DiagnosticStatus.STALE, f'nothing for {limit_s:g} s on {", ".join(stale)}'
    if any(member.health().values()):
        yield DiagnosticStatus.WARN, 'input refused or bridged; see the counters'


class Diagnostics:
    """Publishes a member's status once a second."""

    def __init__(self, member: Member) -> None:
        self._member = member
        self._publisher = member.create_publisher(
            DiagnosticArray, '/diagnostics', QoSProfile(depth=10)
        )
        member.create_timer(PERIOD_S, member.guard(self._publish), clock=member.steady)

    def _publish(self) -> None:
        member = self._member
        level, message = assess(member, time.monotonic())
        counts = {f'{topic} received': port.received for topic, port in member.inputs.items()}
        counts |= {f'{topic} sent': port.sent for topic, port in member.outputs.items()}
        values = [KeyValue(key=k, value=str(n)) for k, n in {**counts, **member.health()}.items()]
        status = DiagnosticStatus(
            level=level,
            name=member.get_fully_qualified_name().lstrip('/'),
            message=message,
            values=values,
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = member.get_clock().now().to_msg()
        self._publisher.publish(array)
