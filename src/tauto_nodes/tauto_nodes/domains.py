"""Where a graph lives: its ROS domain, how far it is discovered, the enclaves of its nodes."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterable
from dataclasses import dataclass

from tauto_nodes.errors import GraphError

RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'

LAST_DOMAIN = 101
"""Largest domain whose DDS ports lie below Linux' ephemeral ports."""

_PORT_BASE = 7400
_PORTS_PER_DOMAIN = 250


def local_discovery() -> dict[str, str]:
    """Return the environment that keeps discovery on this machine; empty where one is set."""
    return {} if os.environ.get(RANGE) else {RANGE: 'LOCALHOST'}


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
