"""Where a graph lives: its ROS domain, how far it is discovered, the enclaves of its nodes."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterable
from dataclasses import dataclass

from tauto_nodes.errors import GraphError, ParameterError

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
