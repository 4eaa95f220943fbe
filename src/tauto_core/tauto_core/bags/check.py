"""Check whether a bag is complete. Recover the readable part of a damaged one."""

from __future__ import annotations

import json
import struct
from collections import defaultdict
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tauto_core.bags.codec import decode_as
from tauto_core.bags.read import (
    LATEST_NS,
    MESSAGE,
    MESSAGE_HEAD,
    METADATA,
    RECORD,
    Bag,
    Hole,
    McapFile,
    by_number,
    find_files,
    open_mcap,
    records_in,
)
from tauto_core.bags.table import MESSAGE_TYPES
from tauto_core.bags.write import (
    CUT_SHORT,
    QOS,
    TYPE_HASH,
    BagWriter,
    check_folder,
)
from tauto_core.files import LARGEST_YAML, YamlError, decompressed, read_yaml
from tauto_core.samples import SCENE
from tauto_core.scene.errors import Argument, ArgumentText, BagError, BagPlaceError
from tauto_core.scene.tables import read_data

if TYPE_CHECKING:
    from mcap.records import Chunk

# Messages of a topic that are held before they are decoded.
_PART = 10_000
_by_time = attrgetter('from_ns', 'topic')
HOLES = 'holes'
"""Metadata of a recovered bag: lists of topic, number of lost messages, and the log times of the
first and the last [ns].
"""


@dataclass
class BagReport:
    """The findings about a bag.

    `recover` repairs `damage`: ends, chunks, indices, metadata. `faults` are in the recorded
    content: messages that do not decode, stamps that go back. `marks` come from the bag's own
    metadata: it was cut short, or has holes. `notes` are harmless.
    """

    bag: Bag
    damage: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    custom: dict[str, Any] = field(default_factory=dict)
    """The metadata's `custom_data`, from metadata.yaml and from the MCAP files."""
    counted: int = 0
    """Number of messages according to valid indices, without files that have no index."""

    @property
    def cut_short(self) -> bool:
        """Whether the bag says that its recording ended before the voyage did."""
        return 'cut_short' in _marks(self.custom)

    @property
    def marks(self) -> list[str]:
        """Missing or doubtful messages by the metadata, as sentences."""
        return _sentences(self.bag.path, _marks(self.custom))

    @property
    def whole(self) -> bool:
        """Whether the bag is complete and correct."""
        return not (self.damage or self.faults or self.marks)


def marks_of(bag: Bag) -> tuple[dict[str, Any], list[str]]:
    """Return the metadata about missing or doubtful messages, and the same as sentences.

    Its recording was cut short, or it was recovered from a damaged one and has holes.
    """
    marks = _marks(_custom(bag.path, list(bag.files)))
    return marks, _sentences(bag.path, marks)


def _marks(custom: Mapping[str, Any]) -> dict[str, Any]:
    is_short = str(custom.get('cut_short', '')).lower() == 'true'
    holes = {HOLES: holes_in(custom)} if HOLES in custom else {}
    return (CUT_SHORT if is_short else {}) | holes


def _sentences(path: Path, marks: Mapping[str, Any]) -> list[str]:
    short = ['cut_short: its recording ended before the voyage did'] * ('cut_short' in marks)
    return [f'{path}: it says {mark}' for mark in (*short, *marks.get(HOLES, ()))]


def holes_in(custom: Mapping[str, Any]) -> list[Hole]:
    """Return the holes that metadata list, or one of unknown size if they are not a list."""
    try:
        listed = [
            Hole(str(topic), int(number), int(from_ns), int(to_ns))
            for topic, number, from_ns, to_ns in json.loads(custom.get(HOLES, '[]'))
        ]
        if all(0 <= number <= LATEST_NS for hole in listed for number in hole[1:]):
            return sorted(listed, key=_by_time)
    except (ValueError, TypeError, OverflowError, RecursionError):
        pass
    return [Hole('', 0, 0, 0)]


def check_bag(path: Path) -> BagReport:
    """Read all of a bag and return its faults.

    A missing bag is a BagPlaceError, a bag without MCAP files a BagError.
    """
    damage: list[str] = []
    refusals: list[BagError] = []
    files: list[McapFile] = []
    try:
        paths = find_files(path, damage)
    except BagPlaceError:
        raise
    except BagError as error:
        paths = sorted(path.glob('*.mcap'), key=by_number)
        if not paths:
            raise
        damage.append(str(error))
    for file in paths:
        try:
            files.append(open_mcap(file, walk=True))
        except BagError as error:
            refusals.append(error)
    if not files:
        raise refusals[0]
    report = BagReport(Bag(path, tuple(files), None))
    report.damage = [*damage, *map(str, refusals)]
    report.custom = _custom(path, files)
    for walked in files:
        report.damage += walked.warnings
        report.damage += [f'{walked.path}: {hole}' for hole in sorted(walked.holes, key=_by_time)]
    for walked in files:
        _check_file(report, walked)
    _check_metadata(report)
    _check_content(report)
    return report


def _custom(path: Path, files: list[McapFile]) -> dict[str, Any]:
    """Return the `custom_data` of the files' own metadata and of metadata.yaml.

    Unreadable metadata of a file are a warning about it. An unreadable metadata.yaml is left out,
    since `find_files` refuses it.
    """
    custom: dict[str, Any] = {}
    for file in files:
        try:
            custom |= _mapping(read_yaml(file.description, any_key=True), 'custom_data')
        except YamlError as error:
            file.warn(f'its metadata cannot be understood ({error})')
    with suppress(OSError, ValueError):
        custom |= _mapping(_information_beside(path / METADATA), 'custom_data')
    return custom


def _mapping(content: object, key: str = '') -> dict[str, Any]:
    """Return a mapping, or the one at a key of it. Anything else counts as empty."""
    if key:
        content = _mapping(content).get(key)
    return content if isinstance(content, dict) else {}


def _information_beside(metadata: Path) -> dict[str, Any]:
    text = read_data(metadata, LARGEST_YAML).decode('utf-8', 'replace')
    return _mapping(read_yaml(text, any_key=True), 'rosbag2_bagfile_information')


def _check_file(report: BagReport, walked: McapFile) -> None:
    """Compare a file's index with its content, and let the mcap library read it."""
    from mcap.exceptions import McapError
    from mcap.records import Chunk, MessageIndex
    from mcap.stream_reader import StreamReader

    opened = open_mcap(walked.path)
    report.damage += [warning for warning in opened.warnings if warning not in report.damage]
    if not opened.indexed:
        if not (walked.warnings or opened.warnings):
            report.damage.append(f'{walked.path}: it has no complete index')
        return
    report.counted += sum(opened.counts.values())
    contents = _contents(walked)
    report.damage += [
        f'{walked.path}: the {what} of its index are not those it holds'
        for what, names in _contents(opened).items()
        if names != contents[what]
    ]
    wrong = 0
    try:
        with walked.path.open('rb') as stream:
            # the library reads as other programs do, independently of `McapFile`
            limit = walked.path.stat().st_size  # of a record: more would be allocated
            reader = StreamReader(
                stream, emit_chunks=True, validate_crcs=True, record_size_limit=limit
            )
            places: dict[int, set[tuple[int, int]]] = {}
            for record in reader.records:
                if isinstance(record, Chunk):
                    places = _places(record)
                elif isinstance(record, MessageIndex):
                    wrong += len(places.get(record.channel_id, set()) ^ set(record.records))
    except (McapError, ValueError, struct.error, EOFError, MemoryError) as error:
        if not walked.warnings:
            report.damage.append(f'{walked.path}: the mcap library refuses it ({error})')
    if wrong and not walked.warnings:
        report.damage.append(
            f'{walked.path}: {wrong} entries of its message indices point at no such message'
        )


def _places(chunk: Chunk) -> dict[int, set[tuple[int, int]]]:
    """Return log time [ns] and offset of each message of a chunk, by channel."""
    places: dict[int, set[tuple[int, int]]] = defaultdict(set)
    octets = decompressed(chunk.compression, chunk.data, chunk.uncompressed_size)
    for opcode, begin, end in records_in(octets):
        if opcode == MESSAGE and end - begin >= MESSAGE_HEAD.size:
            channel, _, stamp_ns, _ = MESSAGE_HEAD.unpack_from(octets, begin)
            places[channel].add((stamp_ns, begin - RECORD.size))
    return places


def _contents(file: McapFile) -> dict[str, object]:
    # rosbag2 declares topics that never had a message in the index alone
    # of definitions the hash, which each has once however many topics share it
    topics = {
        number: channel._replace(definition=b'%d' % hash(channel.definition))
        for number, channel in file.channels.items()
    }
    return {
        'counts': +file.counts,
        'topics': {channel: topics.get(channel) for channel in +file.counts},
        'chunks': {span[:4] for span in file.spans if span.chunk},
    }


def _check_metadata(report: BagReport) -> None:
    """Compare metadata.yaml with the files."""
    path = report.bag.path / METADATA
    if not path.is_file():
        return
    try:
        metadata = _information_beside(path)
    except (OSError, ValueError):  # `find_files` says so
        return
    start_ns, end_ns = report.bag.start_ns, report.bag.end_ns
    actual: dict[str, Any] = {'message_count': sum(report.bag.counts.values())}
    if start_ns is not None and end_ns is not None:
        actual['starting_time'] = {'nanoseconds_since_epoch': start_ns}
        actual['duration'] = {'nanoseconds': end_ns - start_ns}
    for what, value in actual.items():
        if metadata.get(what) != value:
            report.damage.append(
                f'{path}: {what} = {str(metadata.get(what))[:80]}, but the files hold {value}'
            )
    try:
        topics = {
            row['topic_metadata']['name']: (row['topic_metadata']['type'], row['message_count'])
            for row in metadata['topics_with_message_count']
        }
    except (KeyError, TypeError):
        report.damage.append(f'{path}: its topics cannot be understood')
        return
    counts = report.bag.counts
    for topic, ros_type in report.bag.topics.items():
        meta = topics.pop(topic, ('nothing', 0))
        if meta != (ros_type, counts[topic]):
            report.damage.append(
                f'{path}: {topic} is {str(meta[0])[:80]} with {str(meta[1])[:80]} messages, but '
                f'the files hold {ros_type} with {counts[topic]}'
            )
    report.damage += [
        f'{path}: {str(topic)[:80]} with {str(number)[:80]} messages is not in the files'
        for topic, (_, number) in topics.items()
        if number
    ]


@dataclass
class _Reading:
    """A topic while its bag is read: messages not yet decoded, and faults found."""

    origin: str
    ros_type: str
    payloads: list[bytes] = field(default_factory=list)
    stamps_ns: list[int] = field(default_factory=list)
    newest_ns: int = 0
    steps_back: int = 0
    fault: str = ''

    def judge(self) -> None:
        """Decode the gathered messages, and count the log times that go back."""
        stamps_ns = np.array(self.stamps_ns, np.int64)
        self.steps_back += int(np.sum(np.diff(stamps_ns, prepend=self.newest_ns) < 0))
        self.newest_ns = self.stamps_ns[-1]
        if not self.fault and self.ros_type in MESSAGE_TYPES:
            try:
                decode_as(self.ros_type, self.origin, self.payloads, stamps_ns)
            except BagError as error:
                self.fault = str(error)
        self.payloads, self.stamps_ns = [], []


def _check_content(report: BagReport) -> None:
    bag = report.bag
    topics = {
        topic: _Reading(f'{bag.path}: {topic}', ros_type) for topic, ros_type in bag.topics.items()
    }
    for topic, reading in topics.items():
        if reading.ros_type not in MESSAGE_TYPES:
            report.notes.append(f'{topic}: {reading.ros_type or "no type"} is not decoded here')
            continue
        try:
            bag.check_type(topic, reading.ros_type)
        except BagError as error:
            reading.fault = str(error)
    for file in bag.files:
        with file.path.open('rb') as stream:
            for span in file.spans:
                for message in file.messages(span, stream, file.channels):
                    reading = topics[file.channels[message.channel].topic]
                    reading.payloads.append(message.payload)
                    reading.stamps_ns.append(message.stamp_ns)
                    if len(reading.payloads) == _PART:
                        reading.judge()
    for reading in topics.values():
        if reading.payloads:
            reading.judge()
    report.faults += [reading.fault for reading in topics.values() if reading.fault]
    late = {topic: reading for topic, reading in topics.items() if reading.steps_back}
    text = ' times a log time is before the one before it'
    # rosbag2 notes the time of receipt, and on /rosout the times of several nodes cross
    typed = [reading for reading in late.values() if reading.ros_type in MESSAGE_TYPES]
    report.faults += [f'{item.origin}: {item.steps_back}{text}' for item in typed]
    report.notes += [
        f'{topic}: {item.steps_back}{text}' for topic, item in late.items() if item not in typed
    ]
    if not any(f'/{topic.lstrip("/")}'.endswith(f'/{SCENE}') for topic in bag.topics):
        needs = ArgumentText(f'there is no {SCENE}: a replay needs ', Argument('scene'))
        report.notes.append(needs)


# -----------------------------------------------------------------------------
# Makes a new bag from the readable part of a damaged one.


@dataclass(frozen=True)
class Recovered:
    """The result of a recovery.

    Attributes:
        path: folder of the new bag.
        counts: its messages, by full topic name.
        start_ns: their first log time [ns].
        end_ns: their last log time [ns].
        lost: descriptions of damaged parts that are left out or were made again.
        missing: number of unreadable messages that a valid index counts. Messages after a
            truncation are not counted anywhere.
    """

    path: Path
    counts: dict[str, int]
    start_ns: int
    end_ns: int
    lost: tuple[str, ...]
    missing: int


def recover_bag(path: Path, out: Path | None = None) -> Recovered:
    """Write a new bag with every message that can be read, as it was recorded.

    The original, a folder or an .mcap file, is only read. Messages keep their bytes, order, log
    and publish times and sequence numbers. A split bag becomes one file. The new bag is marked
    `cut_short` unless the recording is known to have ended normally, and lists the lost messages
    (`holes`). Without `out` it has the old name and `_recovered`.

    Raises:
        BagPlaceError: there is no bag, or `out` exists or is in the bag itself.
        BagError: the bag is not damaged, no message can be read, or the file system refuses.
    """
    report = check_bag(path)
    if not report.damage:
        raise BagError(
            f'{path}: its files are whole and need no recovery'
            + (f' (`tauto bag check` says what else: {report.faults[0]})' if report.faults else '')
        )
    absolute = path.resolve()
    name = absolute.stem if absolute.is_file() else absolute.name
    out = out or absolute.with_name(f'{name}_recovered')
    if absolute.is_dir() and out.resolve().is_relative_to(absolute):
        raise BagPlaceError(f'{out} is in the bag that is recovered. Name another folder')
    check_folder(out)
    start_ns, end_ns = report.bag.start_ns, report.bag.end_ns
    if start_ns is None or end_ns is None:
        raise BagError(f'{path}: no message can be read ({report.damage[0]}) or recovered')
    keys: dict[str, str] = {}
    with BagWriter(out) as writer:
        for file in report.bag.files:
            with file.path.open('rb') as stream:
                for span in file.spans:
                    for message in file.messages(span, stream):
                        channel = file.channels.get(message.channel)
                        if channel is None:
                            continue
                        # several files may have one topic with different types
                        key = f'{channel.topic} {channel.ros_type}'
                        if key not in keys:
                            keys[key] = channel.topic
                            metadata = {QOS: '', TYPE_HASH: '', **channel.metadata}
                            writer.declare(key, channel._replace(metadata=metadata))
                        writer.copy(key, message)
        writer.describe(report.custom)
        holes = holes_in(report.custom)
        for file in report.bag.files:
            holes += file.holes
        if holes:
            writer.describe({HOLES: sorted(holes, key=_by_time)})
        if not all(file.ended for file in report.bag.files):
            writer.describe(CUT_SHORT)
    counts = {keys[key]: number for key, number in writer.counts.items()}
    return Recovered(
        out,
        counts,
        start_ns,
        end_ns,
        tuple(report.damage),
        max(report.counted - sum(counts.values()), 0),
    )
