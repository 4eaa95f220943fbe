"""Writing bags: a rosbag2 folder with one MCAP file, as `ros2 bag` of Jazzy makes it."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from tauto_core.bags.codec import encode
from tauto_core.bags.mcap_file import Recorded
from tauto_core.bags.mcap_out import CHUNK_BYTES, DeclaredTopic, McapOut, refused
from tauto_core.bags.table import TOPICS, Topic, offered_qos
from tauto_core.samples import Batches, count
from tauto_core.scene.errors import BagError, BagPlaceError
from tauto_core.version import identity

METADATA = 'metadata.yaml'
CUT_SHORT = {'cut_short': True}
"""The metadata of a bag whose recording ended before the voyage did."""

_METADATA_VERSION = 9
_EMPTY_START_NS = 2**63 - 1
_SEQUENCE_MASK = 2**32 - 1


def check_folder(folder: Path, *, force: bool = False) -> None:
    """Refuse a folder to which a bag may not be written.

    Raises:
        BagPlaceError: it exists without `force`; with `force`, it holds anything but one bag.
    """
    if not folder.exists():
        return
    if not force:
        raise BagPlaceError(
            f'{folder} exists already; name another folder, or say --force to replace it'
        )
    if not folder.is_dir():
        raise BagPlaceError(f'{folder} is a file, not the folder of a bag; name another folder')
    others = sorted(entry.name for entry in folder.iterdir() if not _of_bag(entry))
    if others:
        raise BagPlaceError(
            f'{folder} is not only a bag: it holds {others[0]!r}, which replacing would lose; '
            'name another folder or move what is not part of the bag'
        )


class BagWriter:
    """A bag being written; a context manager.

    The folder contains `<name>_0.mcap` (profile ros2, CDR, zstd chunks of 64 KiB) and, once the
    MCAP file is complete, `metadata.yaml`. Log time and publish time of a message are its stamp,
    sequence numbers count from 1 in each topic, and nothing depends on the wall clock.

    An existing bag is replaced only when the new one is complete; until then the new one is
    written to the sibling `<name>.partial`. If an exception leaves the `with` block, the part that
    was written is finished where it is (`path`), so that it can be read, and an old bag is not
    changed; a note on the exception says so.

    Args:
        folder: the bag's folder; its parents are made.
        force: replace a bag that is there.
        namespace: namespace of the topics, for example `clock_a`; empty for the root.
        chunk_bytes: size, before compression, at which a chunk is written.
        compression: compression of the chunks, `zstd` or `none`.

    Raises:
        BagError: the folder may not be written to (see `check_folder`); in use, also an unknown
            topic, a stamp before zero, and any error of the file system, such as a full disk.
    """

    def __init__(
        self,
        folder: Path,
        *,
        force: bool = False,
        namespace: str = '',
        chunk_bytes: int = CHUNK_BYTES,
        compression: str = 'zstd',
    ) -> None:
        folder = Path(folder)
        self._chunk_bytes, self._compression = chunk_bytes, compression
        check_folder(folder, force=force)
        self._folder = folder.resolve() if folder.is_symlink() or not folder.name else folder
        self._prefix = '/'.join(['', *namespace.strip('/').split('/')]).rstrip('/') + '/'
        self._replaces = folder.exists()
        self._channels: dict[str, int] = {}
        self._declared: dict[str, DeclaredTopic] = {}
        self._custom = {'tauto_core': identity()}
        self.counts: dict[str, int] = {}
        """Messages written, by relative topic, in the order of their first message."""
        self.path = self._sibling('.partial') if self._replaces else self._folder
        """The folder that holds the messages."""
        if self._replaces:
            check_folder(self.path, force=True)
            check_folder(self._sibling('.replaced'), force=True)

    @property
    def bytes_written(self) -> int:
        """Size of the file so far; up to one chunk of messages is still in memory."""
        return self._file.end

    def __enter__(self) -> Self:
        try:
            if self._replaces:
                shutil.rmtree(self.path, ignore_errors=True)
            self.path.mkdir(parents=True)
        except OSError as error:
            raise BagError(
                f'{self.path} cannot be made ({error.strerror}); name another folder'
            ) from error
        self._file = McapOut(
            self.path / f'{self._folder.name}_0.mcap',
            f'tauto_core {identity()}',
            chunk_bytes=self._chunk_bytes,
            compression=self._compression,
        )
        return self

    def write(self, batches: Batches) -> None:
        """Write batches by relative topic, their samples merged in the order of the stamps."""
        topics = [name for name in TOPICS if name in batches and count(batches[name])]
        for name in batches:
            _topic(name)
        payloads = [payload for name in topics for payload in encode(name, batches[name])]
        if not payloads:
            return
        stamps = np.concatenate([batches[name].stamp_ns for name in topics])
        owners = np.repeat(np.arange(len(topics)), [count(batches[name]) for name in topics])
        for index in np.argsort(stamps, kind='stable').tolist():
            self.write_raw(topics[owners[index]], payloads[index], int(stamps[index]))

    def describe(self, facts: Mapping[str, object]) -> None:
        """Add to the bag's metadata (`custom_data`): numbers and lists are written as JSON.

        Args:
            facts: values by name; they replace earlier ones of the same name.
        """
        self._custom |= {
            name: fact if isinstance(fact, str) else json.dumps(fact)
            for name, fact in facts.items()
        }

    def declare(self, key: str, declared: DeclaredTopic) -> None:
        """Add a topic that need not be in the table, under a key for `copy`."""
        self.counts[key] = 0
        self._declared[key] = declared
        self._channels[key] = self._file.add_channel(declared)

    def write_raw(self, topic: str, payload: bytes, stamp_ns: int) -> None:
        """Write one serialised message.

        Args:
            topic: relative name, a key of `TOPICS`.
            payload: CDR of the topic's type.
            stamp_ns: stamp in its header, or that of the start if it has no header; >= 0.
        """
        if topic not in self._channels:
            self.declare(topic, _declared(self._prefix, _topic(topic)))
        if stamp_ns < 0:
            raise BagError(f'{topic}: stamp {stamp_ns} ns lies before 0; choose a later starts_at')
        number = self.counts[topic] + 1
        channel = self._channels[topic]
        self._file.add_message(channel, number & _SEQUENCE_MASK, stamp_ns, payload)
        self.counts[topic] = number

    def copy(self, key: str, message: Recorded) -> None:
        """Write a message of another bag unchanged, on a topic that was declared."""
        _, sequence, stamp_ns, publish_ns, payload = message
        self._file.add_message(self._channels[key], sequence, stamp_ns, payload, publish_ns)
        self.counts[key] += 1

    def flush(self) -> None:
        """Write what is still in memory, so that a killed process loses nothing before it."""
        self._file.flush()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        failure = error
        if error is not None:
            self.describe(CUT_SHORT)
        try:
            self._finish()
        except BagError as full:
            self.describe(CUT_SHORT)
            failure = error or full
            self._file.give_up()
            with suppress(BagError):
                self._finish()
        finally:
            self._file.close()
        if error is not None and self.counts:
            error.add_note(f'{self.path} holds what was written until then')
        if error is None and failure is not None:
            raise failure
        if error is None and self._replaces:
            self._swap()

    def _finish(self) -> None:
        """Complete the MCAP file, then write the metadata, completely or not at all."""
        import yaml

        self._file.flush()
        stored = self._file.counts
        self.counts = {name: stored[channel] for name, channel in self._channels.items()}
        information = self._metadata()
        self._file.finish(yaml.safe_dump(information, sort_keys=False))
        temporary = self.path / f'{METADATA}.tmp'
        try:
            temporary.write_text(
                yaml.safe_dump({'rosbag2_bagfile_information': information}, sort_keys=False),
                'utf-8',
            )
            temporary.replace(self.path / METADATA)
        except OSError as error:
            raise refused(temporary, error) from error

    def _metadata(self) -> dict[str, Any]:
        import yaml

        return {
            'version': _METADATA_VERSION,
            'storage_identifier': 'mcap',
            **self._span(),
            'topics_with_message_count': [
                {
                    'topic_metadata': {
                        'name': declared.name,
                        'type': declared.ros_type,
                        'serialization_format': declared.encoding,
                        'offered_qos_profiles': yaml.safe_load(declared.qos) or [],
                        'type_description_hash': declared.type_hash,
                    },
                    'message_count': self.counts[key],
                }
                for key, declared in self._declared.items()
            ],
            'compression_format': '',
            'compression_mode': '',
            'relative_file_paths': [self._file.path.name],
            'files': [{'path': self._file.path.name, **self._span()}],
            'custom_data': self._custom or None,
            'ros_distro': 'jazzy',
        }

    def _span(self) -> dict[str, Any]:
        first_ns, last_ns = self._file.span_ns or (_EMPTY_START_NS, _EMPTY_START_NS)
        return {
            'duration': {'nanoseconds': last_ns - first_ns},
            'starting_time': {'nanoseconds_since_epoch': first_ns},
            'message_count': sum(self.counts.values()),
        }

    def _swap(self) -> None:
        """Put the complete bag in the place of the old one."""
        old = self._sibling('.replaced')
        try:
            shutil.rmtree(old, ignore_errors=True)
            self._folder.rename(old)
            self.path.rename(self._folder)
            shutil.rmtree(old)
        except OSError as error:
            raise BagError(
                f'{self._folder} cannot be replaced ({error.strerror}); the new bag is whole in '
                f'{self.path}, the old one in {old if old.exists() else self._folder}'
            ) from error
        self.path = self._folder

    def _sibling(self, suffix: str) -> Path:
        return self._folder.with_name(self._folder.name + suffix)


def _of_bag(entry: Path) -> bool:
    """Whether a directory entry belongs to a bag."""
    named = entry.name in {METADATA, f'{METADATA}.tmp'} or entry.suffix == '.mcap'
    return named and not entry.is_dir()


def _topic(name: str) -> Topic:
    if name not in TOPICS:
        raise BagError(f'topic {name!r} is not in the table; it holds {", ".join(TOPICS)}')
    return TOPICS[name]


def _declared(prefix: str, topic: Topic) -> DeclaredTopic:
    import yaml

    text, type_hash = definition_of(topic.ros_type)
    qos = yaml.safe_dump(offered_qos(topic), sort_keys=False).strip()
    return DeclaredTopic(prefix + topic.name, topic.ros_type, text.encode(), qos, type_hash)


@cache
def definition_of(ros_type: str) -> tuple[str, str]:
    """Return the text of a message definition with its dependencies, and its RIHS01 hash."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    text, _ = store.generate_msgdef(ros_type, ros_version=2)
    return text, store.hash_rihs01(ros_type)
