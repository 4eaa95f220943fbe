"""The place of a simulated voyage: a ROS domain of its own, its middleware, its work folder."""

from __future__ import annotations

import os
import socket
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rclpy.utilities import get_rmw_implementation_identifier

from tauto_nodes import GraphError
from tauto_nodes.live import (
    DOMAIN,
    LAST_DOMAIN,
    RANGE,
    check_discovery,
    local_discovery,
)


@dataclass
class Domain:
    """A ROS domain reserved for this process until its lock is closed or the process ends.

    `number` is the ROS_DOMAIN_ID, `lock` the socket that holds it.
    """

    number: int
    lock: socket.socket


def _claimed(name: str) -> socket.socket | None:
    """Return a socket that reserves a name on this machine, or `None` if it is taken."""
    lock = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        lock.bind(f'\0tauto-ros-domain-{name}')  # an abstract name of Linux
    except OSError:
        lock.close()
        return None
    return lock


def claim_place(number: int, namespace: str) -> Domain:
    """Return a namespace of a domain in which no other graph on this machine sails."""
    place = f'/{namespace.strip("/")}'
    if lock := _claimed(f'{number}{place}'):
        return Domain(number, lock)
    raise GraphError(
        f'another graph of the namespace {place} sails in this domain, {number}, and it goes on. '
        'Wait for its end, or give this one a namespace or a ROS_DOMAIN_ID of its own'
    )


def claim_domain() -> Domain:
    """Return a domain in which no participant runs and that no other graph has claimed.

    It raises GraphError if all are taken.
    """
    numbers = range(1, LAST_DOMAIN + 1)
    start = os.getpid() % LAST_DOMAIN
    for number in (*numbers[start:], *numbers[:start]):
        if (lock := _claimed(f'{number}')) is None:
            continue
        first = 7400 + 250 * number  # as DDS numbers its ports
        try:
            for port in (first, first + 10, first + 12, first + 14):
                with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
                    probe.bind(('', port))
        except OSError:
            lock.close()
            continue
        return Domain(number, lock)
    raise GraphError(
        f'no ROS domain from 1 to {LAST_DOMAIN} is free. End other graphs, or set ROS_DOMAIN_ID'
    )


# -----------------------------------------------------------------------------
# A graph stays on this machine by the middleware and the environment of its nodes.

PROFILES = ('FASTDDS_DEFAULT_PROFILES_FILE', 'FASTRTPS_DEFAULT_PROFILES_FILE')
"""Environment variables that name a profile of Fast DDS, of 3 and of 2."""

FROM_PROFILE = 'RMW_FASTRTPS_USE_QOS_FROM_XML'
"""Environment variable: rmw leaves the memory policy to the profile."""

LOCALHOST_ONLY = 'ROS_LOCALHOST_ONLY'
"""The older variable for the range. If it is 1, rcl ignores the range."""


def graph_middleware() -> dict[str, str]:
    """Return the environment that keeps our graph on this machine, with our profile.

    A profile, range of discovery, peers or middleware in the environment are kept. The range of
    `fastdds_loopback.xml` is in the file.
    """
    given = local_discovery()
    if any(os.environ.get(name) for name in PROFILES):
        return given
    profile = 'fastdds.xml'
    ranged = os.environ.get(RANGE, '') not in ('', 'LOCALHOST')
    here = not ranged and not os.environ.get('ROS_STATIC_PEERS')
    if here and get_rmw_implementation_identifier().startswith('rmw_fastrtps'):
        profile = 'fastdds_loopback.xml'
        given = {RANGE: 'SYSTEM_DEFAULT', LOCALHOST_ONLY: ''}
    return given | {PROFILES[1]: str(Path(__file__).with_name(profile)), FROM_PROFILE: '1'}


@contextmanager
def graph_environment(namespace: str = '') -> Iterator[dict[str, str]]:
    """Set this process' ROS environment and yield it for the children.

    Discovery stays on this machine, the domain is a free one, and Fast DDS gets our profile
    (`fastdds_loopback.xml`), unless the environment says otherwise. A domain that the environment
    names is for one graph a namespace: another one on this machine is a GraphError.
    """
    check_discovery()
    given = graph_middleware()
    number = os.environ.get(DOMAIN)
    domain = claim_place(int(number), namespace) if number else claim_domain()
    given[DOMAIN] = str(domain.number)
    before = {name: os.environ.get(name) for name in given}
    os.environ.update(given)
    try:
        yield dict(os.environ)
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
        domain.lock.close()


def work_folder(parent: str | None) -> tempfile.TemporaryDirectory[str]:
    """Make a folder in `parent`, or among the system's temporary files. GraphError: it cannot be.

    It is removed at the end of its context.
    """
    place = parent or tempfile.gettempdir()
    try:
        return tempfile.TemporaryDirectory(prefix='tauto_graph_', dir=place)
    except OSError as error:
        raise GraphError(
            f'{place}: no folder can be made there ({error.strerror}), and a graph keeps its '
            'parameters in one. Make room, or set TMPDIR to another place'
        ) from error
