"""Reading bags: a rosbag2 folder or a bare MCAP file, by any recorder, complete or truncated."""

from __future__ import annotations

import heapq
import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tauto_core.bags.codec import decode_as, joined
from tauto_core.bags.mcap import Channel, McapFile, Stored, open_mcap
from tauto_core.bags.table import MESSAGE_TYPES, STRING, TOPICS
from tauto_core.bags.writer import METADATA
from tauto_core.samples import SCENE, Batches, IntArray, Samples, TextSamples
from tauto_core.scene.errors import BagError, BagPlaceError

PART = 100_000


class Message(NamedTuple):
    """A recorded message: full topic name, ROS type, log time [ns], CDR payload."""

    topic: str
    ros_type: str
    stamp_ns: int
    payload: bytes


@dataclass(frozen=True)
class Bag:
    """A bag opened for reading; messages stay in the files until they are asked for.

    A topic is named in full (`/clock_a/ship/imu`) or by its relative name (`ship/imu`). A relative
    name stands for the one topic of the bag that ends with it, or that is in `namespace` if given.
    """

    path: Path
    files: tuple[McapFile, ...]
    namespace: str | None
    """Namespace of the topics of the table (`''`: the root); `None` where they have none or
    several.
    """
    notes: tuple[str, ...] = ()

    @property
    def topics(self) -> dict[str, str]:
        """ROS type of each topic, by full name."""
        return {topic: types[0] for topic, types in self._types().items()}

    @property
    def counts(self) -> dict[str, int]:
        """Number of messages of each topic, by full name."""
        counts: dict[str, int] = {}
        for file in self.files:
            for number, channel in file.channels.items():
                counts[channel.topic] = counts.get(channel.topic, 0) + file.counts.get(number, 0)
        return counts

    @property
    def start_ns(self) -> int | None:
        """Earliest log time [ns]; `None` if there is no message."""
        return min((span.start_ns for file in self.files for span in file.spans), default=None)

    @property
    def end_ns(self) -> int | None:
        """Latest log time [ns]; `None` if there is no message."""
        return max((span.end_ns for file in self.files for span in file.spans), default=None)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Descriptions of what could not be read, and what is therefore missing.

        Damage within a chunk is found when its messages are read, and reported from then on.
        """
        return self.notes + tuple(warning for file in self.files for warning in file.warnings)

    @cached_property
    def scenes(self) -> TextSamples | None:
        """The messages of the `scene` topic, read once; `None` where the bag has none."""
        matches = self._matches(SCENE)
        if not matches or (len(matches) == 1 and self.topics[matches[0]] != STRING.name):
            return None
        samples = self.samples(SCENE)
        return samples if isinstance(samples, TextSamples) and len(samples.data) else None

    @property
    def scene(self) -> str | None:
        """The text of the `scene` topic, its last message; `None` where the bag has none."""
        return None if self.scenes is None else str(self.scenes.data[-1])

    def __contains__(self, topic: str) -> bool:
        """Whether the bag has the topic."""
        return bool(self._matches(topic))

    def samples(self, topic: str) -> Samples:
        """Return all messages of a topic as one batch, in the order of the recording.

        Raises:
            BagError: no such topic, several that match, another message type than in the table, a
                type that is not in the table, payloads that do not decode.
        """
        return self.batches([topic])[topic]

    def batches(self, topics: Collection[str]) -> Batches:
        """Return all messages of several topics, one batch a topic, in one pass over the files.

        Raises:
            BagError: as `samples`.
        """
        read: dict[str, list[Samples]] = {topic: [] for topic in topics}
        for topic, part in self.parts(topics):
            read[topic].append(part)
        return {
            topic: self._joined(topic, parts or [self._decode(topic, [], [])])
            for topic, parts in read.items()
        }

    def parts(self, topics: Collection[str], size: int = PART) -> Iterator[tuple[str, Samples]]:
        """Yield topics as batches of at most `size` samples, for bags larger than the memory.

        The batches of one topic come in the order of the recording.

        Raises:
            BagError: as `samples`.
        """
        waiting: dict[str, tuple[list[int], list[bytes]]] = {topic: ([], []) for topic in topics}
        for topic, stored in self._stored(topics):
            stamps, payloads = waiting[topic]
            stamps.append(stored.stamp_ns)
            payloads.append(stored.payload)
            if len(stamps) == size:
                waiting[topic] = [], []
                yield topic, self._decode(topic, payloads, stamps)
        for topic, (stamps, payloads) in waiting.items():
            if stamps:
                yield topic, self._decode(topic, payloads, stamps)

    def payloads(self, topic: str) -> tuple[IntArray, list[bytes]]:
        """Return log times and CDR payloads of a topic, in the order of the recording.

        Raises:
            BagError: no such topic, several that match, another message type than in the table.
        """
        stored = [message for _, message in self._stored([topic])]
        stamps = np.array([message.stamp_ns for message in stored], np.int64)
        return stamps, [message.payload for message in stored]

    def messages(self, topics: Collection[str] | None = None) -> Iterator[Message]:
        """Yield the messages of all topics, or of some, in the order of their log times.

        Only spans that overlap in time are held in memory. Messages of equal time keep the file's
        order.

        Args:
            topics: as for `samples`; all when left out.

        Raises:
            BagError: no such topic, or several that match.
        """
        wanted = None if topics is None else {self.find(topic) for topic in topics}
        spans = sorted(
            (span.start_ns, index, span)
            for index, file in enumerate(self.files)
            for span in file.spans
        )
        waiting: list[tuple[int, int, int, int, Message]] = []
        for start_ns, index, span in spans:
            while waiting and waiting[0][0] < start_ns:
                yield heapq.heappop(waiting)[-1]
            file = self.files[index]
            with file.path.open('rb') as stream:
                for number, stored in enumerate(file.messages(span, stream)):
                    channel = file.channels.get(stored.channel)
                    if channel and (wanted is None or channel.topic in wanted):
                        message = _message(channel, stored)
                        key = (stored.stamp_ns, index, span.offset, number)
                        heapq.heappush(waiting, (*key, message))
        while waiting:
            yield heapq.heappop(waiting)[-1]

    def find(self, topic: str) -> str:
        """Return the full name of a topic.

        Raises:
            BagError: the bag has no such topic, or several that match.
        """
        matches = self._matches(topic)
        if len(matches) == 1:
            return matches[0]
        if matches:
            raise BagError(
                f'{self.path}: {topic} may be {" or ".join(matches)}; name one namespace'
            )
        held = ', '.join(self.topics) or 'none'
        raise BagError(f'{self.path}: there is no topic {topic}; its topics are: {held}')

    def _matches(self, topic: str) -> list[str]:
        topics = self._types()
        if topic.startswith('/'):
            return [topic] if topic in topics else []
        if self.namespace is not None and topic in TOPICS:
            full = '/'.join(['', *self.namespace.split('/'), topic]).replace('//', '/')
            return [found for found in topics if f'/{found.lstrip("/")}' == full]
        return [found for found in topics if f'/{found.lstrip("/")}'.endswith(f'/{topic}')]

    def _types(self) -> dict[str, list[str]]:
        types: dict[str, list[str]] = {}
        for file in self.files:
            for channel in file.channels.values():
                known = types.setdefault(channel.topic, [])
                if channel.ros_type not in known:
                    known.append(channel.ros_type)
        return types

    def _stored(self, topics: Collection[str]) -> Iterator[tuple[str, Stored]]:
        """Yield messages with their topics, file after file; refuse another type or encoding."""
        wanted = {self.find(topic): topic for topic in topics}
        for full, topic in wanted.items():
            ros_type = TOPICS[topic].ros_type if topic in TOPICS else self.topics[full]
            self.check_type(full, ros_type)
        for file in self.files:
            topic_of = {
                number: wanted[channel.topic]
                for number, channel in file.channels.items()
                if channel.topic in wanted
            }
            with file.path.open('rb') as stream:
                for span in file.spans:
                    if span.channels is not None and span.channels.isdisjoint(topic_of):
                        continue
                    for stored in file.messages(span, stream, topic_of):
                        yield topic_of[stored.channel], stored

    def check_type(self, full: str, wanted: str) -> None:
        """Refuse a topic, given by its full name, that is not all of one type in CDR.

        Raises:
            BagError: another type than wanted, or another encoding.
        """
        for found in self._types()[full]:
            if found != wanted:
                raise BagError(
                    f'{self.path}: {full} holds {found or "messages without a type"}, but '
                    f'must hold {wanted}; remap that topic or name another bag'
                )
        for file in self.files:
            for channel in file.channels.values():
                if channel.topic == full and channel.encoding != 'cdr':
                    raise BagError(
                        f'{self.path}: {full} is encoded as {channel.encoding!r}, but ROS 2 '
                        "messages are 'cdr'; record it with ROS 2"
                    )

    def _joined(self, topic: str, parts: list[Samples]) -> Samples:
        full = self.find(topic)
        return joined(self.topics[full], f'{self.path}: {full}', parts)

    def _decode(self, topic: str, payloads: list[bytes], stamps: list[int]) -> Samples:
        full = self.find(topic)
        ros_type = self.topics[full]
        if ros_type not in MESSAGE_TYPES:
            raise BagError(
                f'{self.path}: {full} holds {ros_type or "messages without a type"}; what can be '
                f'decoded is {", ".join(MESSAGE_TYPES)}'
            )
        origin = f'{self.path}: {full}'
        return decode_as(ros_type, origin, payloads, np.array(stamps, np.int64))


def read_bag(path: Path | str, *, namespace: str | None = None) -> Bag:
    """Open a bag.

    Args:
        path: a rosbag2 folder, with or without its metadata, or an MCAP file.
        namespace: namespace of the topics of the table; when left out, the one in which they are
            found.

    Raises:
        BagError: nothing there, not MCAP, compressed file by file, no topic of the table in
            the namespace.
    """
    path = Path(path)
    notes: list[str] = []
    files = tuple(open_mcap(file) for file in find_files(path, notes))
    bag = Bag(path, files, None, tuple(notes))
    places = sorted(
        {
            full[: -len(name) - 1].strip('/')
            for full, ros_type in bag.topics.items()
            for name, topic in TOPICS.items()
            if f'/{full.lstrip("/")}'.endswith(f'/{name}') and ros_type == topic.ros_type
        }
    )
    if namespace is not None and namespace.strip('/') not in places:
        held = ', '.join(f'/{place}' for place in places) or 'none'
        raise BagError(f'{path}: there is no namespace {namespace!r}; its namespaces are: {held}')
    if namespace is None and len(places) == 1:
        namespace = places[0]
    return Bag(path, files, None if namespace is None else namespace.strip('/'), tuple(notes))


def find_files(path: Path, notes: list[str]) -> list[Path]:
    """Return the MCAP files of a bag in the order of recording; note missing ones."""
    if not path.exists():
        raise BagPlaceError(f'{path} does not exist; name a rosbag2 folder or an .mcap file')
    if not path.is_dir():
        return [path]
    found = sorted(path.glob('*.mcap'), key=by_number)
    if (path / METADATA).exists():
        listed = _listed_files(path / METADATA)
        lost = [file.name for file in listed if not file.exists()]
        if found and len(lost) == len(listed):
            raise BagError(
                f'{path} has other .mcap files than its {METADATA} names ({", ".join(lost)}); '
                f'give them these names again, or say `tauto bag recover {path}`'
            )
        notes += [f'{path}: {name}, named by {METADATA}, is missing' for name in lost]
        found = [file for file in listed if file.exists()]
    elif found:
        notes.append(f'{path}: it has no {METADATA}: the recording did not end by itself')
    if not found:
        raise BagError(
            f'{path} holds no .mcap file; name a rosbag2 folder with MCAP storage, or convert it '
            'with `ros2 bag convert`'
        )
    return found


def _listed_files(metadata: Path) -> list[Path]:
    import yaml

    try:
        content: Any = yaml.safe_load(metadata.read_text('utf-8'))
        information = content['rosbag2_bagfile_information']
        names = [str(name) for name in information['relative_file_paths']]
        storage = information.get('storage_identifier', 'mcap')
        mode = str(information.get('compression_mode') or '').lower()
    except (OSError, ValueError, KeyError, TypeError, AttributeError, yaml.YAMLError) as error:
        raise BagError(
            f'{metadata} cannot be understood ({error}); name the .mcap file beside it'
        ) from None
    if storage != 'mcap' or mode in {'file', 'message'}:
        what = f'{storage} storage' if storage != 'mcap' else f'compression by {mode}'
        raise BagError(
            f'{metadata.parent} has {what}, but MCAP with chunk compression can be read; convert '
            'it with `ros2 bag convert`'
        )
    return [metadata.parent / Path(name).name for name in names]


def by_number(file: Path) -> tuple[int, str]:
    """Return a sorting key that puts `bag_2.mcap` before `bag_10.mcap`."""
    number = re.search(r'_(\d+)$', file.stem)
    return (int(number[1]) if number else -1, file.name)


def _message(channel: Channel, stored: Stored) -> Message:
    return Message(channel.topic, channel.ros_type, stored.stamp_ns, stored.payload)
