"""A private ROS domain for each test process, and nodes that run during the test."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import repeat
from typing import IO, Any, ClassVar

import numpy as np
import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from numpy.typing import NDArray
from rcl_interfaces.msg import Log
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import try_shutdown

from tauto_core.bags import encode
from tauto_core.samples import (
    PHASE,
    READING,
    SHIP_IMU,
    Batches,
    ImuSamples,
    Samples,
    State,
    TimeSamples,
    count,
    join,
    same,
    scalars,
    take,
)
from tauto_core.ship.imu import imu_from_roll
from tauto_nodes.live import executor_named
from tauto_nodes.live.node import TICK_S, port
from tauto_nodes.live.player import SourceNode
from tauto_nodes.simulation import claim_domain

with warnings.catch_warnings():
    # rclpy imports it with the first node, and its lark the deprecated sre_parse.
    warnings.simplefilter('ignore', DeprecationWarning)
    import rosidl_generator_py  # noqa: F401


@pytest.fixture(scope='session', autouse=True)
def ros_domain() -> Iterator[int]:
    """Keep this process and its children in a domain of their own, on this machine."""
    domain = claim_domain()
    os.environ['ROS_DOMAIN_ID'] = str(domain.number)
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    # Fast DDS reads its profile once, for the first participant of a process. That of a graph in
    # this process must not hold for the nodes of later tests, which are not on the loopback alone.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    Node('first').destroy_node()
    rclpy.shutdown()
    yield domain.number
    domain.lock.close()


DRIFT = {
    'observation_interval': 20.0,
    'observation_sigma': 0.5,
    'covariates': ['heave', 'roll'],
    'coefficients': {
        'heave': {'value': 1.0, 'sigma': 0.05},
        'roll': {'value': 0.01, 'sigma': 0.02},
    },
}


WARM = """
name: warm
duration: 1800.0
starts_at: 1.0e9
trochlea:
  inertia: 4.0e-4
  material: brass
  cam: {kind: involute, base_radius: 0.005}
  thread: {kind: vertical}
  power: {kind: weight, mass: 0.322}
  release_angle: 1.0
ship: {kind: still}
voyage: {departure: [50.8, -1.1], arrival: [50.7, -1.2], sails_at: 60.0, arrives_at: 1740.0}
air: {kind: constant, celsius: 12.0, diurnal: 8.0, box_hours: 0.1}
drift:
  observation_interval: 60.0
  covariates: [temperature_squared, gravity, temperature]
  coefficients: {gravity: {value: 1.0, sigma: 0.01}}
log: {interval: 10.0}
"""

FOREIGN: dict[str, Any] = {'source': 'foreign', 'scene': 'measured'}
START_NS = 1_700_000_000 * 10**9

PATIENCE_S = 300.0
"""How long a condition may take on a busy machine [s]: a test that waits in vain fails then."""

OWN = ['unshare', '--map-root-user', '--mount']
"""Runs a command in mounts of its own."""


@pytest.fixture
def mounts() -> None:
    """Skip a test if this user may mount nothing."""
    if subprocess.run([*OWN, 'true'], capture_output=True, check=False).returncode != 0:
        pytest.skip('this user may mount nothing')


def until(condition: Callable[[], object], limit_s: float = PATIENCE_S) -> None:
    """Poll until the condition holds. Fail after the limit."""
    deadline_s = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < deadline_s, 'the condition did not come true in time'
        time.sleep(0.02)


def start(
    node: str, *arguments: str, stdout: int | IO[str] = subprocess.PIPE
) -> subprocess.Popen[str]:
    """Start a node in a process of its own."""
    return subprocess.Popen(
        [sys.executable, '-m', 'tauto_nodes', node, *arguments],
        stdout=stdout,
        stderr=subprocess.STDOUT,
        text=True,
    )


class Bench:
    """Nodes of this process on one executor, spun until a condition holds."""

    def __init__(self, executor: str = 'events') -> None:
        self._executor: Any = executor_named(executor)
        self._nodes: list[Node] = []

    def add(self, *nodes: Any) -> Any:
        """Run these nodes, too. Return the first."""
        for node in nodes:
            self._nodes.append(node)
            self._executor.add_node(node)
        return nodes[0]

    def remove(self, node: Any) -> None:
        """End a node as a power cut would, without messages or a saved state."""
        self._nodes.remove(node)
        self._executor.remove_node(node)
        node.destroy_node()

    def until(self, condition: Callable[[], object]) -> None:
        """Spin until the condition holds. Fail after PATIENCE_S."""
        deadline_s = time.monotonic() + PATIENCE_S
        while not condition():
            for node in self._nodes:
                failure = getattr(node, 'failure', None)
                if failure is not None:
                    raise failure
            assert time.monotonic() < deadline_s, 'the condition did not come true in time'
            self._executor.spin_until_future_complete(Future(), 0.01)

    def beats(self, node: Node, count: int) -> None:
        """Spin until the node has had the time for so many of its ticks."""
        ticked: list[None] = []
        timer = node.create_timer(TICK_S, lambda: ticked.append(None))
        self.until(lambda: len(ticked) >= count)
        node.destroy_timer(timer)

    def close(self) -> None:
        """End all nodes."""
        self._executor.shutdown()
        for node in self._nodes:
            node.destroy_node()


@pytest.fixture
def ros() -> Iterator[Callable[[Sequence[str]], None]]:
    """Yield the function that starts ROS with arguments. Shut ROS down after the test."""

    def start(arguments: Sequence[str] = ()) -> None:
        args = ['--ros-args', *arguments] if arguments else []
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)

    yield start
    # A node in a cycle stays in the domain, and the next test's nodes would match it.
    gc.collect()
    try_shutdown()


@pytest.fixture
def bench(ros: Callable[[Sequence[str]], None]) -> Iterator[Bench]:
    """Yield a bench in a fresh context without arguments."""
    ros(())
    made = Bench()
    yield made
    made.close()


def overrides(**values: Any) -> dict[str, Any]:
    """Return the node option that sets these parameters."""
    return {
        'parameter_overrides': [
            Parameter(name, value=list(value) if isinstance(value, tuple) else value)
            for name, value in values.items()
        ]
    }


def imu(stamps_ns: NDArray[np.int64]) -> ImuSamples:
    """Return motion samples with their number as angular velocity about x."""
    n = len(stamps_ns)
    return ImuSamples(
        stamps_ns,
        'clock_mount',
        np.tile([0.0, 0.0, 0.0, 1.0], (n, 1)),
        np.zeros((n, 9)),
        np.stack([np.arange(n, dtype=float), np.zeros(n), np.zeros(n)], axis=1),
        np.zeros((n, 9)),
        np.tile([0.0, 0.0, 9.8], (n, 1)),
        np.zeros((n, 9)),
    )


def still_sensor(seconds: float, first_s: float = 0.0, rate_hz: int = 20) -> ImuSamples:
    """Return the samples of a sensor on a ship at rest."""
    n = round(rate_hz * seconds)
    stamps = START_NS + round(first_s * 1e9) + 10**9 // rate_hz * np.arange(n)
    none = np.zeros(n)
    return imu_from_roll(stamps, none, none, none, none + 9.81)


class Heard:
    """The statuses of /diagnostics by node, and what went to /rosout."""

    def __init__(self, node: Node) -> None:
        self.status: dict[str, DiagnosticStatus] = {}
        self.log: list[str] = []
        depth = QoSProfile(depth=100)
        node.create_subscription(DiagnosticArray, '/diagnostics', self._hear, depth)
        node.create_subscription(Log, '/rosout', lambda m: self.log.append(m.msg), depth)

    def _hear(self, array: DiagnosticArray) -> None:
        self.status |= {status.name: status for status in array.status}

    def says(self, node: str, level: bytes, words: str) -> bool:
        """Whether the node's latest status has this level and these words."""
        status = self.status.get(node)
        return status is not None and status.level == level and words in status.message


def publisher_of(node: Node, topic: str) -> Any:
    """Return the node's publisher of a topic of the table."""
    return node.create_publisher(port(topic).message, topic, port(topic).profile)


def publish(publisher: Any, samples: ImuSamples) -> None:
    """Publish motion samples at once."""
    for payload in encode(SHIP_IMU, samples):
        publisher.publish(payload)


def send(publisher: Any, imu: ImuSamples, bench: Bench, trochlea: Any) -> None:
    """Publish samples, at most a hundred ahead of the node."""
    source = trochlea.inputs[SHIP_IMU]
    for payload in encode(SHIP_IMU, imu):
        publisher.publish(payload)
        sent[0] += 1
        bench.until(lambda: source.received > sent[0] - 100)
    bench.until(lambda: source.taken == sent[0])


sent = [0]


def with_sensor(bench: Bench, *nodes: Any) -> tuple[Any, Heard]:
    """Run nodes and a sensor. Return its publisher, once matched, and its ears."""
    sensor = bench.add(Node('xsens'), *nodes)
    heard, publisher = Heard(sensor), publisher_of(sensor, SHIP_IMU)
    bench.until(lambda: nodes[0].inputs[SHIP_IMU].matched)
    sent[0] = 0
    return publisher, heard


class Echo:
    """A stage that answers each motion sample with two topics, holding back the last one."""

    inputs: ClassVar[tuple[str, ...]] = (SHIP_IMU,)
    outputs: ClassVar[tuple[str, ...]] = (READING, PHASE)

    def __init__(self) -> None:
        self._held: ImuSamples | None = None
        self.fed: list[int] = []

    def feed(self, batches: Mapping[str, Samples]) -> Batches:
        """Answer all samples but the last."""
        new = batches[SHIP_IMU]
        assert isinstance(new, ImuSamples)
        self.fed.append(count(new))
        known = new if self._held is None else join([self._held, new])
        self._held = take(known, slice(count(known) - 1, None))
        return self._say(take(known, slice(0, count(known) - 1)))

    def finish(self) -> Batches:
        """Answer the last sample."""
        return self._say(self._held) if self._held is not None else {}

    def _say(self, samples: ImuSamples) -> Batches:
        stamps = samples.stamp_ns
        return {
            READING: TimeSamples(stamps, '', stamps + 1, same('dial', len(stamps))),
            PHASE: scalars(stamps, ('phase',), samples.angular_velocity[:, :1]),
        }

    def state(self) -> State:
        """Return the held sample."""
        return {'held': self._held}

    def restore(self, state: State) -> None:
        """Take a held sample."""
        self._held = state['held']

    def health(self) -> dict[str, int]:
        """Nothing can go wrong."""
        return {}


class TestSource(SourceNode):
    """A ship that sends n motion samples, a millisecond of sea time apart, as fast as it can."""

    __test__ = False

    def __init__(self, n: int, *, speed: float = 0.0, **parameters: Any) -> None:
        super().__init__('ship_motion', 'speed', **overrides(speed=speed, **parameters))
        stamps = 10**9 + 10**6 * np.arange(n, dtype=np.int64)
        self.connect([], [port(SHIP_IMU)])
        payloads = encode(SHIP_IMU, imu(stamps))
        self.start(zip(stamps.tolist(), repeat(SHIP_IMU), payloads, strict=False))
