"""Nodes on a boat, and a process of nodes: discovery, executor, signals, exit code."""

from __future__ import annotations

import ctypes
import faulthandler
import os
import signal
import sys
import traceback
from collections.abc import Callable, Sequence
from types import FrameType
from typing import Any, TypeAlias

import rclpy
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import remove_ros_args, try_shutdown

from tauto_core.cli.terminal import open_closed_streams
from tauto_core.scene.errors import TautoError, spelled
from tauto_nodes import NodesError, ParameterError, as_parameter
from tauto_nodes.live.node import GraphNode
from tauto_nodes.live.parameters import RCLError, UnknownROSArgsError

# -----------------------------------------------------------------------------
# How nodes find each other.

RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
DOMAIN = 'ROS_DOMAIN_ID'

_RANGES = ('LOCALHOST', 'SUBNET', 'SYSTEM_DEFAULT')

LAST_DOMAIN = 101
"""Largest domain with DDS ports below Linux' ephemeral ports."""


def local_discovery() -> dict[str, str]:
    """Return the environment that keeps discovery on this machine. It is empty if one is set."""
    return {} if os.environ.get(RANGE) else {RANGE: 'LOCALHOST'}


def check_discovery() -> None:
    """Check the variables by which the nodes of a graph find each other.

    It raises ParameterError if they could not, or if the variables contradict each other.
    """
    reach, number = os.environ.get(RANGE, ''), os.environ.get(DOMAIN, '')
    if reach == 'OFF':
        raise ParameterError(
            f'{RANGE} = OFF: the nodes of a graph could not find each other. Unset it, or use '
            'LOCALHOST, which keeps them on this machine'
        )
    if reach and reach not in _RANGES:
        raise ParameterError(f'{RANGE} = {reach}: must be one of {", ".join(_RANGES)}')
    if number and not (number.isdecimal() and int(number) <= 232):
        raise ParameterError(
            f'{DOMAIN} = {number}: must be a whole number from 0 to 232, the last with ports. '
            f'Up to {LAST_DOMAIN} its ports are free of other programs'
        )


# -----------------------------------------------------------------------------
# One process: its nodes from their start to its exit code.

Maker: TypeAlias = Callable[[], GraphNode]

LEAVE_S = 8.0
"""Time in which the middleware must let a process go [s]. `ros2 launch` kills after 10 s."""

SUPERVISOR = 'TAUTO_SUPERVISOR'
"""Environment variable with the process: the nodes end when it dies."""


def die_with_supervisor() -> None:
    """Ask Linux for a SIGTERM when the supervisor dies, even by SIGKILL: no orphans."""
    supervisor = os.environ.get(SUPERVISOR)
    if supervisor is None:
        return
    ctypes.CDLL(None, use_errno=True).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG
    if os.getppid() != int(supervisor):
        raise NodesError(
            f'{SUPERVISOR} = {supervisor}: this process is gone. Start the graph anew'
        )


def executor_named(name: str) -> Any:
    """Return the executor `events` (rclpy 7.1.4 and later) or `single`."""
    if name == 'single':
        return SingleThreadedExecutor()
    from rclpy.experimental.events_executor import EventsExecutor

    return EventsExecutor()


class Signals:
    """Notes SIGINT and SIGTERM from now on. `came` is the first one, or 0.

    As a context manager it puts the former handlers back.
    """

    def __init__(self) -> None:
        self.came = 0
        numbers = (signal.SIGINT, signal.SIGTERM)
        self._before = {number: signal.signal(number, self.note) for number in numbers}

    def note(self, number: int, _: FrameType | None) -> None:
        """Handle a signal."""
        self.came = self.came or number

    def __enter__(self) -> Signals:
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)


def _spin(nodes: Sequence[GraphNode], signals: Signals) -> None:
    stop: Any = Future()

    def check() -> None:
        over = any(node.failure or node.over for node in nodes)
        done = over or (signals.came and not any(node.waits_on_shutdown() for node in nodes))
        if done and not stop.done():
            stop.set_result(None)

    nodes[0].create_timer(0.2, check, clock=Clock(clock_type=ClockType.STEADY_TIME))
    # Closed here: rclpy's own, destroyed after the context, prints a traceback.
    with executor_named(nodes[0].settings['executor']) as executor:
        for node in nodes:
            executor.add_node(node)
        while not stop.done():
            # A bare spin() of the events executor busy-loops. A finite wait does not.
            try:
                executor.spin_until_future_complete(stop, 3600.0)
            except ValueError as error:
                # Our own callbacks are guarded: rclpy raises it for a time before 0 on /clock.
                # Each message would soon fill a pipe without a reader, and block the node.
                nodes[0].get_logger().error(
                    f'messages are left aside: rclpy: {error}', throttle_duration_sec=10.0
                )


def _leave(nodes: Sequence[GraphNode]) -> None:
    """Leave the graph, or end the process with exit code 1 and its stack after LEAVE_S.

    Fast DDS, as in the wheels, never returns from the deletion of a participant if a peer comes or
    goes at that moment (its issue 6513): it waits with an invalid time and keeps the lock that the
    other thread needs. It holds the interpreter's lock, too, which stops Python threads and signal
    handlers. This watchdog needs no lock.
    """
    faulthandler.dump_traceback_later(LEAVE_S, exit=True)
    for node in nodes:
        node.destroy_node()
    try_shutdown()
    faulthandler.cancel_dump_traceback_later()


def run_nodes(makers: Sequence[Maker], args: Sequence[str] | None = None) -> int:
    """Make the nodes, spin until they end or a signal comes, close them. Return the exit code.

    `makers` are node classes, all run in this process. `args` is the command line (None:
    sys.argv).
    """
    open_closed_streams()
    # rclpy's own handlers would end the context before the flush. Ours are not put back: a signal
    # that comes late must not change the exit code.
    signals = Signals()
    faulthandler.enable()
    nodes: list[GraphNode] = []
    refusal: Exception | None = None
    try:
        die_with_supervisor()
        os.environ.update(local_discovery())
        typed = sys.argv[1:] if args is None else args
        if unknown := remove_ros_args(['', *typed])[1:]:  # ROS ignores them
            raise ParameterError(
                f'unknown argument {unknown[0]}. Parameters go after --ros-args, as -p name:=value'
            )
        rclpy.init(
            args=None if args is None else list(args),
            signal_handler_options=SignalHandlerOptions.NO,
        )
        for maker in makers:
            nodes.append(maker())
        _spin(nodes, signals)
    except (RCLError, UnknownROSArgsError) as error:
        # rcl's message, for example if the home folder cannot be written
        unwritable = 'log directory' in str(error)
        remedy = '. Set ROS_LOG_DIR to a folder that can be written' if unwritable else ''
        refusal = ParameterError(f'command line, parameter file or environment: {error}{remedy}')
    except Exception as error:
        refusal = error
    for node in nodes:  # their remaining messages are written and sent
        try:
            node.close()
        except Exception as error:
            node.fail(error)
        if node.failure is not None and node.diagnostics is not None:
            node.diagnostics.deliver()
    code = max((node.exit_code for node in nodes), default=0)
    failures = [('tauto_nodes', refusal), *((node.role, node.failure) for node in nodes)]
    who, failure = next((each for each in failures if each[1] is not None), ('', None))
    if isinstance(failure, TautoError):
        sys.stderr.write(f'{who}: {spelled(failure.message, as_parameter)}\n')
        code = failure.exit_code
    elif failure is not None:
        traceback.print_exception(failure)
        code = 1
    _leave(nodes)
    return code


def main_of(*makers: Maker) -> Callable[[], None]:
    """Return the function that an executable calls: it runs nodes of these classes."""

    def main() -> None:
        sys.exit(run_nodes(makers))

    return main
