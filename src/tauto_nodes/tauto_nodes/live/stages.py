"""The nodes that hold a stage of tauto_core: trochlea, drift estimator, longitude."""

from __future__ import annotations

import base64
import hashlib
import json
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

import numpy as np
from rclpy.clock import JumpThreshold
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from rclpy.time import Time
from std_srvs.srv import Trigger

from tauto_core import samples as s
from tauto_core.bags import encode
from tauto_core.clockwork import DialSetting, LiveTrochlea, TrochleaStage
from tauto_core.clockwork.live import DialRun, ShownReading
from tauto_core.files import write_whole
from tauto_core.navigation import DriftStage, LongitudeStage
from tauto_core.navigation.longitude import LiveFixes
from tauto_core.samples import (
    SHIP_IMU,
    Batches,
    FloatArray,
    ImuSamples,
    Samples,
    Stage,
    State,
    TimeSamples,
    count,
    take,
)
from tauto_core.scene import Scene, scene_yaml
from tauto_core.scene.errors import BagError
from tauto_core.scene.times import MAX_GAP_S
from tauto_core.ship.imu import MOUNT_FRAME, RollSample, mounted, quaternion_of_angles
from tauto_core.version import code
from tauto_core.voyage import compile_kernels, refused_words
from tauto_nodes import NodesError, ParameterError
from tauto_nodes.live import main_of
from tauto_nodes.live.node import Diagnostics, GraphNode, port, short
from tauto_nodes.live.parameters import NodeSettings

# -----------------------------------------------------------------------------
# The state of a stage in a file: versioned, checked, replaced in one step, read without pickle.
#
# The first line is JSON about the rest, the second the state as JSON: arrays as base64 of their
# bytes, types that JSON lacks (tuples, samples, keys that are not strings) under one-key
# objects.

VERSION = 1
FORMAT = 'tauto state'

_SAMPLES = {
    kind.__name__: kind
    for kind in (
        s.TextSamples,
        s.ImuSamples,
        s.JointSamples,
        s.TimeSamples,
        s.FixSamples,
        s.TemperatureSamples,
        DialSetting,
        DialRun,
        ShownReading,
        RollSample,
    )
}
_DTYPES = ('<f8', '<i8', '|b1', '|i1', '|u1', '<u2', '<i4')


class StateFile:
    """One node's state file, in a folder that is made if it is not there.

    `node` is the fully qualified name. A state of a stage made from another scene is refused.
    """

    def __init__(self, folder: Path, node: str, scene: Scene) -> None:
        self.path = folder / f'{node.strip("/").replace("/", ".")}.state'
        self._head = {
            'format': FORMAT,
            'version': VERSION,
            'code': code(),
            'node': node,
            'scene': hashlib.sha256(scene_yaml(scene).encode()).hexdigest(),
        }
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ParameterError(
                f'state_folder = {str(folder)!r}: cannot be made ({error.strerror}). '
                'Name another folder'
            ) from error

    def load(self) -> State | None:
        """Return the state, or `None` without a file.

        ParameterError: the file is damaged, or of another version, code, node or scene.
        """
        try:
            head, body = self.path.read_bytes().split(b'\n', 1)
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            raise self._refused(f'cannot be read ({error})') from error
        try:
            said = json.loads(head)
        except ValueError as error:
            raise self._refused('is not a state file') from error
        for name, value in self._head.items():
            found = said.get(name) if isinstance(said, dict) else None
            if found != value:
                raise self._refused(f'is of another {name} ({found} in place of {value})')
        if said.get('sha256') != hashlib.sha256(body).hexdigest():
            raise self._refused('is damaged')
        state: State = _opened(json.loads(body))
        return state

    def save(self, state: State) -> None:
        """Replace the file in one step. OSError if the file system refuses."""
        body = json.dumps(_packed(state)).encode()
        head = json.dumps({**self._head, 'sha256': hashlib.sha256(body).hexdigest()}).encode()
        write_whole(self.path, head + b'\n' + body)

    def _refused(self, why: str) -> ParameterError:
        return ParameterError(
            f'{self.path} {why}. Move it away to start with a dial that is set again, or name '
            'another state_folder'
        )


def _packed(value: Any) -> Any:
    """Return a value of a state as JSON can hold it."""
    match value:
        case np.generic():
            packed: Any = value.item()
        case None | bool() | int() | float() | str():
            packed = value
        case np.ndarray() if value.dtype == object:
            packed = {'objects': [_packed(one) for one in value.tolist()]}
        case np.ndarray():
            octets = base64.b64encode(np.ascontiguousarray(value).tobytes()).decode()
            packed = {'array': [value.dtype.str, list(value.shape), octets]}
        case tuple() if type(value) is tuple:
            packed = {'tuple': [_packed(one) for one in value]}
        case list():
            packed = [_packed(one) for one in value]
        case Mapping():
            packed = {'items': [[_packed(key), _packed(one)] for key, one in value.items()]}
        case _ if type(value).__name__ in _SAMPLES:
            fields = value._asdict() if isinstance(value, RollSample) else vars(value)
            packed = {'samples': [type(value).__name__, _packed(fields)]}
        case _:
            raise TypeError(f'a state holds {type(value).__name__}, which has no spelling')
    return packed


def _opened(value: Any) -> Any:
    """Return the value that `_packed` packed."""
    if isinstance(value, list):
        return [_opened(one) for one in value]
    if not isinstance(value, dict):
        return value
    ((kind, held),) = value.items()
    opened: Any
    match kind:
        case 'array':
            dtype, shape, octets = held
            if dtype not in _DTYPES:
                raise ValueError(f'an array of {dtype}')
            opened = np.frombuffer(base64.b64decode(octets), dtype).reshape(shape).copy()
        case 'objects':
            opened = np.empty(len(held), object)
            opened[:] = [_opened(one) for one in held]
        case 'tuple':
            opened = tuple(_opened(one) for one in held)
        case 'items':
            opened = {_opened(key): _opened(one) for key, one in held}
        case _:
            name, fields = held
            opened = _SAMPLES[name](**_opened(fields))
    return opened


# -----------------------------------------------------------------------------
# How a live sensor is mounted: by a parameter, by its frame, or by a static transform of tf2.


def rotation_of(text: str) -> FloatArray:
    """Return the quaternion of `imu_rotation`, in degrees (ParameterError: invalid)."""
    try:
        roll, pitch, yaw = np.radians([float(word) for word in text.replace(',', ' ').split()])
        if not np.isfinite([roll, pitch, yaw]).all():
            raise ValueError
    except ValueError:
        raise ParameterError(
            f'imu_rotation = {text!r}: must be roll, pitch and yaw in degrees, as in 0 0 90'
        ) from None
    return quaternion_of_angles(roll, pitch, yaw)


class StaticTransforms:
    """The static transforms of tf2 that a node has heard. ImportError: tf2_ros is missing.

    /tf is not used: a sensor in a moving frame is not mounted on the clock.
    """

    def __init__(self, node: Node) -> None:
        from tf2_msgs.msg import TFMessage
        from tf2_ros import Buffer, TransformException

        self._buffer: Any = Buffer()
        self._unknown: type[Exception] = TransformException
        latched = QoSProfile(depth=100, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(TFMessage, '/tf_static', self._hear, latched)

    def _hear(self, message: Any) -> None:
        for one in message.transforms:
            self._buffer.set_transform_static(one, SHIP_IMU)

    def to_clock(self, frame: str) -> FloatArray | None:
        """Return the rotation of vectors from a frame to the clock's, or `None` if unknown."""
        try:
            found = self._buffer.lookup_transform(MOUNT_FRAME, frame, Time())
        except self._unknown:
            return None
        q = found.transform.rotation
        return np.array([q.x, q.y, q.z, q.w])


class Mounting:
    """Turns the samples of a sensor into the axes of the clock.

    All of them have one frame (`Intake`). If `imu_rotation` is empty that must be `clock_mount`,
    or have a static transform to it. Other samples are ignored, and `trouble` names their frame.
    """

    def __init__(self, node: Node, imu_rotation: str) -> None:
        self._node = node
        self._mount = rotation_of(imu_rotation) if imu_rotation else None
        self._transforms: StaticTransforms | None = None
        self.trouble = ''

    def applied(self, samples: ImuSamples) -> ImuSamples | None:
        """Return the samples in the axes of the clock, or `None` if the mounting is unknown."""
        frame = samples.frame_id
        if self._mount is None and frame != MOUNT_FRAME:
            if self._transforms is None:
                with suppress(ImportError):
                    self._transforms = StaticTransforms(self._node)
            if self._transforms is not None:
                self._mount = self._transforms.to_clock(frame)
            if self._mount is None:
                asked = (
                    'tf2 has no static transform from it'
                    if self._transforms is not None
                    else 'tf2_ros is not installed here'
                )
                words = (
                    f'{SHIP_IMU}: frame {short(frame)} is not {MOUNT_FRAME} (x forward, y to '
                    f'port, z up), and {asked}. Its messages are ignored. Give the mounting of '
                    'the sensor: imu_rotation'
                )
                if not self.trouble:
                    self._node.get_logger().error(words)
                self.trouble = words
                return None
            self.trouble = ''
            self._node.get_logger().info(f'{SHIP_IMU}: frame {short(frame)} is turned by tf2')
        return samples if self._mount is None else mounted(samples, self._mount)


# -----------------------------------------------------------------------------
# A node that runs a stage.

ACK_S = 0.5
"""Time for a subscriber to acknowledge a topic's last messages [s]."""


class StageNode(GraphNode):
    """Subscribes to the stage's inputs and publishes its outputs, driven by stamps alone.

    Without flow control it flushes at shutdown and when `~/finish` (std_srvs/Trigger) is called.
    With a `state_folder` it saves its state instead, and continues from it at its next start.
    `build` makes the stage from the settings.
    """

    def __init__(
        self, role: str, build: Callable[[NodeSettings], Stage], **node_options: Any
    ) -> None:
        super().__init__(role, **node_options)
        self._file: StateFile | None = None
        folder, saved = self.settings['state_folder'], None
        if folder and self.settings.credits:
            raise ParameterError(
                f'state_folder = {folder!r}: with flow_control = credits a graph runs as a whole '
                'or not at all. Leave it out'
            )
        if folder:
            name = self.get_fully_qualified_name()
            self._file = StateFile(Path(folder), name, self.settings.scene())
            saved = self._file.load()
        self.stage = build(self.settings)
        if self._file is not None and saved is not None:
            self.stage.restore(saved)
            self.get_logger().info(f'goes on from the state in {self._file.path}')
        self._mounting: Mounting | None = None
        if self.settings['source'] == 'foreign':
            rotation = str(self.settings.values.get('imu_rotation', ''))
            self._mounting = Mounting(self, rotation)
        self._saved_s = time.monotonic()
        self._changed = self._noticed = False
        reliability = str(self.settings.values.get('imu_reliability', 'reliable'))
        self.connect(
            [port(topic, reliability) for topic in self.stage.inputs],
            [port(topic) for topic in self.stage.outputs],
        )
        self.create_service(Trigger, '~/finish', self._finish)
        self.diagnostics = Diagnostics(self)

    def take(self, payloads: Mapping[str, Sequence[bytes]]) -> None:
        """Feed the stage with the messages that arrived and send its results."""
        batches = {}
        for topic, raw in payloads.items():
            samples, _ = self.decoded(topic, raw)
            if isinstance(samples, s.ImuSamples) and self._mounting is not None:
                samples = self._mounting.applied(samples)
            if samples is not None:
                batches[topic] = samples
        if batches:
            self._send(self.stage.feed(batches))
            if self.flow is not None and (words := refused_words(self.stage.health())):
                raise NodesError(words)
            self._changed = True
            if s.OBSERVATION in batches:  # observations are rare and cannot be repeated
                self._save()
        notices = self.notices
        for line in notices if not self._noticed else ():
            self.get_logger().warning(line)
        self._noticed = bool(notices)
        for line in getattr(self.stage, 'news', list)():
            self.get_logger().error(line)
            self.alarm(line)

    @property
    def notices(self) -> list[str]:
        """The inputs that the stage lacks at present."""
        return list(getattr(self.stage, 'notices', ()))

    @property
    def trouble(self) -> str:
        """The reason why the stage does not publish, or an empty text."""
        mounting = self._mounting.trouble if self._mounting is not None else ''
        return super().trouble or mounting or str(getattr(self.stage, 'trouble', ''))

    def at_end(self) -> None:
        """Send the last results of the stage, and remove its state."""
        self._send(self.stage.finish())
        if self._file is not None:
            self._file.path.unlink(missing_ok=True)

    def tick(self) -> None:
        """Save the state when it is due."""
        due_s = self._saved_s + self.settings['state_interval']
        if self._changed and time.monotonic() >= due_s:
            self._save()

    def close(self) -> None:
        """Save the state, or flush unless an end marker has done it."""
        if self.flow is not None or self.failure is not None or self.input_over:
            return
        if self._file is None:
            self.end_input()
        else:
            self.work()
            self._save()
        for output in self.outputs.values():  # the recorder stops at the same time
            if output.sent and output.publisher.get_subscription_count():
                output.publisher.wait_for_all_acked(Duration(seconds=ACK_S))

    def _save(self) -> None:
        if self._file is None:
            return
        self._saved_s, self._changed = time.monotonic(), False
        try:
            self._file.save(self.stage.state())
        except OSError as error:
            self.alarm(f'{self._file.path} cannot be written ({error.strerror})')

    def health(self) -> dict[str, int]:
        """Return the stage's counters."""
        return {**super().health(), **self.stage.health()}

    def _send(self, batches: Batches) -> None:
        for topic, samples in batches.items():
            if count(samples):
                self.send(topic, self._encoded(topic, samples))

    def _encoded(self, topic: str, samples: Samples) -> list[bytes]:
        """Return the messages. Samples that do not fit into a message are omitted and counted."""
        try:
            return encode(topic, samples)
        except BagError as error:
            if count(samples) == 1:
                self.note(topic, 'unsayable', str(error))
                return []
            each = (
                take(cast(TimeSamples, samples), slice(k, k + 1)) for k in range(count(samples))
            )
            return [payload for one in each for payload in self._encoded(topic, one)]

    def _finish(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if self.flow is not None:
            response.success = False
            response.message = 'flow_control = credits: the end marker of the source finishes'
            return response
        try:
            self.end_input()
        except Exception as error:
            self.fail(error)
        response.success = self.failure is None
        response.message = str(self.failure or 'flushed. Later messages are ignored')
        return response


# -----------------------------------------------------------------------------
# The three stages.


def _trochlea(settings: NodeSettings) -> Stage:
    scene = settings.scene()
    # Before there is a subscription: while kernels compile, its queue would overflow.
    compile_kernels(scene)
    if settings['source'] != 'foreign':
        return TrochleaStage(scene)
    return LiveTrochlea(scene, settings['reset_on_time_jump'])


class TrochleaNode(StageNode):
    """From ship/imu to trochlea/joint_states, trochlea/phase and clock/reading."""

    def __init__(self, **node_options: Any) -> None:
        super().__init__('trochlea', _trochlea, **node_options)
        if isinstance(live := self.stage, LiveTrochlea):
            self.create_service(Trigger, '~/reset', self._reset)
            # fires under use_sim_time alone: the system's clock does not report jumps
            self._jumps = self.get_clock().create_jump_callback(
                JumpThreshold(
                    min_forward=None,
                    min_backward=Duration(seconds=-MAX_GAP_S),
                    on_clock_change=False,
                ),
                post_callback=lambda _: live.time_went_back(),
            )

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        cast(LiveTrochlea, self.stage).reset()
        response.success = True
        response.message = 'the dial is set anew at the next good sample of ship/imu'
        return response


class DriftEstimatorNode(StageNode):
    """From clock/reading and clock/observation to drift/estimate and clock/corrected.

    With covariates it takes ship/imu or ship/fix, too.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__(
            'drift_estimator',
            lambda own: DriftStage(
                own.scene(),
                expect_schedule=own['source'] == 'scene',
                fixes=LiveFixes(max_speed=own['fix_max_speed']),
            ),
            **node_options,
        )


class LongitudeNode(StageNode):
    """From ship/fix, clock/reading, clock/corrected and drift/estimate to longitude/…."""

    def __init__(self, **node_options: Any) -> None:
        super().__init__(
            'longitude',
            lambda own: LongitudeStage(
                own.scene(),
                live=LiveFixes(own['fix_max_age'], own['fix_max_speed'])
                if own['source'] == 'foreign'
                else None,
            ),
            **node_options,
        )


trochlea = main_of(TrochleaNode)
drift_estimator = main_of(DriftEstimatorNode)
longitude = main_of(LongitudeNode)
