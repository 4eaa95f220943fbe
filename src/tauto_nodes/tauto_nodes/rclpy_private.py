"""What the nodes need of rclpy and its public interface does not offer, all in one place.

Tried with rclpy 7.1.6 (Jazzy).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter
from rclpy.subscription import Subscription

RCLError = rclpy_implementation.RCLError
"""What rcl refuses: `rclpy.exceptions` does not export it."""

UnknownROSArgsError = rclpy_implementation.UnknownROSArgsError


def overrides_of(node: Node) -> Mapping[str, RosParameter]:
    """Return the parameters that command line, files and caller set, undeclared ones included.

    `Node` lists them publicly only after it has declared all of them, without our table.
    """
    overrides: Mapping[str, RosParameter] = node._parameter_overrides
    return overrides


def take_raw(subscription: Subscription) -> bytes | None:
    """Return the next serialised message of a subscription's queue; None where it is empty.

    An executor takes one message a wait, and there is no public way to take the others.
    """
    with subscription.handle:
        taken: Any = subscription.handle.take_message(subscription.msg_type, True)
    return None if taken is None else taken[0]
