"""Running nodes in a process: its ROS domain, executor, signals, the exit code."""

from __future__ import annotations

import ctypes
import faulthandler
import os
import signal
import socket
import sys
import traceback
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
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
from tauto_nodes.errors import GraphError, NodesError, ParameterError, as_parameter
from tauto_nodes.member import Member
from tauto_nodes.parameters import RCLError, UnknownROSArgsError

# -----------------------------------------------------------------------------
# Where a graph lives: its ROS domain, how far it is discovered, the enclaves of its nodes.

RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
DOMAIN = 'ROS_DOMAIN_ID'

LOOPBACK = '127.0.0.1'
ANSWER_S = 1.0

_RANGES = ('LOCALHOST', 'SUBNET', 'SYSTEM_DEFAULT')
_HIGHEST_DOMAIN = 232
"""The ports of the next one lie beyond 65535."""

LAST_DOMAIN = 101
"""Largest domain whose DDS ports lie below Linux' ephemeral ports."""

_PORT_BASE = 7400
_PORTS_PER_DOMAIN = 250


def local_discovery() -> dict[str, str]:
    """Return the environment that keeps discovery on this machine; empty where one is set."""
    return {} if os.environ.get(RANGE) else {RANGE: 'LOCALHOST'}


def check_discovery() -> None:
    """Check the variables by which the nodes of a graph find each other.

    Raises:
        ParameterError: they could not, or not where the environment seems to say.
    """
    reach, number = os.environ.get(RANGE, ''), os.environ.get(DOMAIN, '')
    if reach == 'OFF':
        raise ParameterError(
            f'{RANGE} = OFF: the nodes of a graph could not find each other. Unset it, or use '
            'LOCALHOST, which keeps them on this machine'
        )
    if reach and reach not in _RANGES:
        raise ParameterError(f'{RANGE} = {reach}: must be one of {", ".join(_RANGES)}')
    if number and not (number.isdecimal() and int(number) <= _HIGHEST_DOMAIN):
        raise ParameterError(
            f'{DOMAIN} = {number}: must be a whole number from 0 to {_HIGHEST_DOMAIN}; '
            f'up to {LAST_DOMAIN} no port of it is taken by other programs'
        )


def check_loopback() -> None:
    """Check that what is sent to this machine by the loopback interface arrives.

    Raises:
        GraphError: it does not, and a graph would wait for its nodes in vain.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.settimeout(ANSWER_S)
        try:
            probe.bind((LOOPBACK, 0))
            probe.sendto(b'tauto', probe.getsockname())
            probe.recv(1)
        except OSError as error:
            raise GraphError(
                f'nothing that is sent to {LOOPBACK} arrives ({error.strerror or error}), and the '
                'nodes of a graph talk by it. Bring the loopback interface up (ip link set lo '
                'up), or let the network filter pass it'
            ) from error


def enclave_of(name: str) -> list[str]:
    """Return the ROS arguments that name a node's enclave, as in `config/sros2_policy.xml`.

    Without ROS_SECURITY_ENABLE an enclave is a name and nothing more.
    """
    return ['--enclave', f'/tauto/{name}']


@dataclass
class Domain:
    """A ROS domain reserved for this process until it is released or the process ends.

    Args:
        number: ROS_DOMAIN_ID.
        lock: the socket that holds it; None where the environment chose the domain.
    """

    number: int
    lock: socket.socket | None = None

    def release(self) -> None:
        """Give the domain back."""
        if self.lock is not None:
            self.lock.close()


def claim_domain() -> Domain:
    """Return a domain in which no participant runs and that no other graph has claimed.

    Raises:
        GraphError: all domains are taken.
    """
    numbers = range(1, LAST_DOMAIN + 1)
    start = os.getpid() % LAST_DOMAIN
    for number in (*numbers[start:], *numbers[:start]):
        lock = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            # Linux' abstract names vanish with their process.
            lock.bind(f'\0tauto-ros-domain-{number}')
        except OSError:
            lock.close()
            continue
        first = _PORT_BASE + _PORTS_PER_DOMAIN * number
        if _free((first, first + 10, first + 12, first + 14)):
            return Domain(number, lock)
        lock.close()
    raise GraphError(
        f'no ROS domain from 1 to {LAST_DOMAIN} is free; end other graphs, or set ROS_DOMAIN_ID'
    )


def _free(ports: Iterable[int]) -> bool:
    for port in ports:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(('', port))
            except OSError:
                return False
    return True


Maker: TypeAlias = Callable[[], Member]

CHECK_S = 0.02
COMPLAIN_S = 10.0
LEAVE_S = 8.0
"""Time for the middleware to let a process go [s]; `ros2 launch` kills after 10 s."""

SUPERVISOR = 'TAUTO_SUPERVISOR'
"""Environment variable: the process whose death ends the nodes."""

_LOG_FOLDER = 'log directory'
"""What rcl says of it if it cannot be made, as where the home folder cannot be written."""

_PR_SET_PDEATHSIG = 1


def die_with_supervisor() -> None:
    """Ask Linux for a SIGTERM when the supervisor dies, even by SIGKILL: no orphans."""
    supervisor = os.environ.get(SUPERVISOR)
    if supervisor is None:
        return
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(supervisor):
        raise NodesError(
            f'{SUPERVISOR} = {supervisor}: this process is gone. Start the graph anew'
        )


def executor_named(name: str) -> Any:
    """Return an executor: `events` or `single`.

    Raises:
        NodesError: this rclpy has no events executor.
    """
    if name == 'single':
        return SingleThreadedExecutor()
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError as error:
        raise NodesError(
            'executor = events: this rclpy has none; it came with 7.1.4. '
            'Update ROS, or set executor:=single'
        ) from error
    return EventsExecutor()


class _Signals:
    """Notes SIGINT and SIGTERM; rclpy's own handlers would end the context before the flush."""

    def __init__(self) -> None:
        self.came = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._note)

    def _note(self, number: int, frame: FrameType | None) -> None:
        del number, frame
        self.came = True


def _spin(nodes: Sequence[Member], signals: _Signals) -> None:
    executor = executor_named(nodes[0].settings.text('executor'))
    stop: Any = Future()

    def check() -> None:
        done = signals.came or any(node.failure or node.over for node in nodes)
        if done and not stop.done():
            stop.set_result(None)

    nodes[0].create_timer(CHECK_S, check, clock=Clock(clock_type=ClockType.STEADY_TIME))
    for node in nodes:
        executor.add_node(node)
    while not stop.done():
        # A bare spin() of the events executor busy-loops; a finite wait does not.
        try:
            executor.spin_until_future_complete(stop, 3600.0)
        except ValueError as error:
            # Our own callbacks are guarded: rclpy raises it for a time before 0 on /clock. Each
            # one told would soon fill a pipe that nobody reads, and hold the node.
            nodes[0].get_logger().error(
                f'messages are left aside: rclpy: {error}', throttle_duration_sec=COMPLAIN_S
            )


def _finish(nodes: Sequence[Member]) -> None:
    """End the nodes' own work: what they hold is written and sent."""
    for node in nodes:
        try:
            node.close()
        except Exception as error:
            node.fail(error)
        if node.failure is not None and node.diagnostics is not None:
            node.diagnostics.deliver()


def _leave(nodes: Sequence[Member]) -> None:
    """Leave the graph, or end the process with exit code 1 after LEAVE_S, saying where it stood.

    Fast DDS as the wheels have it never returns from the deletion of a participant if a peer is
    heard to come or go at that moment (its issue 6513): it waits with an invalid time, in a loop
    that keeps the lock for which the other thread waits. The interpreter's lock is held, too, so
    that neither a Python thread nor a signal handler could run; this watchdog needs no lock.
    """
    faulthandler.dump_traceback_later(LEAVE_S, exit=True)
    for node in nodes:
        node.destroy_node()
    try_shutdown()
    faulthandler.cancel_dump_traceback_later()


def _exit_code(nodes: Sequence[Member], refusal: Exception | None) -> int:
    """Return the exit code, after the reason of a failure was written to stderr."""
    failures = [('tauto_nodes', refusal), *((node.role, node.failure) for node in nodes)]
    for who, error in failures:
        if isinstance(error, TautoError):
            sys.stderr.write(f'{who}: {spelled(error.message, as_parameter)}\n')
            return error.exit_code
        if error is not None:
            traceback.print_exception(error)
            return 1
    return max(node.exit_code for node in nodes)


def _refuse_what_ros_ignores(args: Sequence[str]) -> None:
    if unknown := remove_ros_args(['', *args])[1:]:
        raise ParameterError(
            f'unknown argument {unknown[0]}; parameters go after --ros-args, as -p name:=value'
        )


def run(makers: Sequence[Maker], args: Sequence[str] | None = None) -> int:
    """Make the nodes, spin until they end or a signal comes, close them; return the exit code.

    Args:
        makers: node classes, all run in this process.
        args: command line, sys.argv where None.
    """
    open_closed_streams()
    signals = _Signals()
    faulthandler.enable()
    nodes: list[Member] = []
    refusal: Exception | None = None
    try:
        die_with_supervisor()
        os.environ.update(local_discovery())
        _refuse_what_ros_ignores(sys.argv[1:] if args is None else args)
        rclpy.init(
            args=None if args is None else list(args),
            signal_handler_options=SignalHandlerOptions.NO,
        )
        for maker in makers:
            nodes.append(maker())
        _spin(nodes, signals)
    except (RCLError, UnknownROSArgsError) as error:
        unwritable = _LOG_FOLDER in str(error)
        remedy = '. Set ROS_LOG_DIR to a folder that can be written' if unwritable else ''
        refusal = ParameterError(f'command line, parameter file or environment: {error}{remedy}')
    except Exception as error:
        refusal = error
    _finish(nodes)
    code = _exit_code(nodes, refusal)
    _leave(nodes)
    return code


def main_of(*makers: Maker) -> Callable[[], None]:
    """Return the `main` of an executable."""

    def main() -> None:
        sys.exit(run(makers))

    return main
