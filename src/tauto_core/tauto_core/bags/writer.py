"""Writing bags: a rosbag2 folder with one MCAP file, as `ros2 bag` of Jazzy makes it."""

from __future__ import annotations

import json
import shutil
import warnings
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from tauto_core.bags.codec import encode
from tauto_core.bags.mcap import CHUNK_BYTES, DeclaredTopic, McapOut, Recorded, refused
from tauto_core.bags.table import TOPICS, Topic, offered_qos
from tauto_core.files import DRAFTS, one_writer, put_in_place, sync_folder, write_whole
from tauto_core.samples import Batches, count
from tauto_core.scene.errors import Argument, BagError, BagPlaceError, TautoWarning
from tauto_core.version import identity

METADATA = 'metadata.yaml'
CUT_SHORT = {'cut_short': True}
"""The metadata of a bag whose recording ended before the voyage did."""

_METADATA_VERSION = 9
_EMPTY_START_NS = 2**63 - 1
_SEQUENCE_MASK = 2**32 - 1


def check_folder(folder: Path, *, force: bool = False) -> None:
    """Refuse a folder to which a bag may not be written.

    An old bag that a killed process left aside is put back first.

    Raises:
        BagPlaceError: it exists without `force`; with `force`, it holds anything but one bag; or
            another process is writing it.
    """
    folder = _real(folder)
    try:
        if _left_aside(folder):
            with _one_writer(folder):
                _put_back(folder)
        with suppress(FileNotFoundError, NotADirectoryError), _one_writer(folder, make=False):
            pass
    except OSError as error:
        raise BagPlaceError(
            f'{folder} cannot be used ({error.strerror}); name another folder'
        ) from error
    _check_replaceable(folder, force=force)


def _real(folder: Path) -> Path:
    """Return a folder under the name beside which its drafts are written."""
    return folder.resolve() if folder.is_symlink() or not folder.name else folder


def _check_replaceable(folder: Path, *, force: bool) -> None:
    if not folder.exists():
        return
    if not force:
        raise BagPlaceError(
            f'{folder} exists already; name another folder, or say ',
            Argument('force', value=True),
            ' to replace it',
        )
    for each in (folder, _sibling(folder, '.partial'), _sibling(folder, '.replaced')):
        if not each.exists():
            continue
        if not each.is_dir():
            raise BagPlaceError(f'{each} is a file, not the folder of a bag; name another folder')
        others = sorted(entry.name for entry in each.iterdir() if not _of_bag(entry))
        if others:
            raise BagPlaceError(
                f'{each} is not only a bag: it holds {others[0]!r}, which replacing would lose; '
                'name another folder or move what is not part of the bag'
            )


@contextmanager
def _one_writer(folder: Path, *, make: bool = True) -> Iterator[None]:
    """Be the only one who writes a bag to a folder, for as long as the context lasts.

    The lock is a file beside the folder, since the folder itself is exchanged at the end.
    """
    with ExitStack() as held:
        try:
            held.enter_context(one_writer(folder.with_name(f'.{folder.name}.lock'), make=make))
        except BlockingIOError:
            raise BagPlaceError(
                f'{folder} is being written by another process; wait until it ends, or name '
                'another folder'
            ) from None
        yield


def _left_aside(folder: Path) -> bool:
    """Whether a process was killed after it had put the old bag aside, before the new one came."""
    return not folder.exists() and (_sibling(folder, '.replaced') / METADATA).is_file()


def _put_back(folder: Path) -> None:
    if not _left_aside(folder):
        return
    old = _sibling(folder, '.replaced')
    try:
        old.rename(folder)
        sync_folder(folder.parent)
    except OSError as error:
        raise BagError(
            f'{folder}: a process that was to replace it was killed, and the old bag cannot be '
            f'put back ({error.strerror}). It is whole in {old}; rename it'
        ) from error
    new = _sibling(folder, '.partial')
    warnings.warn(
        f'{folder}: a process that was to replace it was killed; the old bag is put back'
        + (f', the new one is in {new}' if new.exists() else ''),
        TautoWarning,
        stacklevel=2,
    )


def _sibling(folder: Path, suffix: str) -> Path:
    return folder.with_name(folder.name + suffix)


class BagWriter:
    """A bag being written; a context manager.

    The folder contains `<name>_0.mcap` (profile ros2, CDR, zstd chunks of 64 KiB) and, once the
    MCAP file is complete, `metadata.yaml`. Log time and publish time of a message are its stamp,
    sequence numbers count from 1 in each topic, and nothing depends on the wall clock.

    An existing bag is replaced only when the new one is complete and on the disk; until then the
    new one is written to the sibling `<name>.partial`. The two are exchanged in one step; where
    the system cannot, the old one is `<name>.replaced` in between. If an exception leaves the
    `with` block, the part that was written is finished where it is (`path`), so that it can be
    read, and an old bag is not changed; a note on the exception says so. No other process can
    write a bag to the same folder meanwhile.

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
        self._chunk_bytes, self._compression = chunk_bytes, compression
        check_folder(Path(folder), force=force)
        self._folder, self._force = _real(Path(folder)), force
        self._prefix = '/'.join(['', *namespace.strip('/').split('/')]).rstrip('/') + '/'
        self._replaces = False
        self._held = ExitStack()
        self._channels: dict[str, int] = {}
        self._declared: dict[str, DeclaredTopic] = {}
        self._custom = {'tauto_core': identity()}
        self.counts: dict[str, int] = {}
        """Messages written, by relative topic, in the order of their first message."""
        self.path = self._folder
        """The folder that holds the messages."""

    @property
    def bytes_written(self) -> int:
        """Size of the file so far; up to one chunk of messages is still in memory."""
        return self._file.end

    def __enter__(self) -> Self:
        with ExitStack() as held:
            try:
                self._folder.parent.mkdir(parents=True, exist_ok=True)
                held.enter_context(_one_writer(self._folder))
                self._make_folder()
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
            self._held = held.pop_all()
        return self

    def _make_folder(self) -> None:
        """Make the folder to write in, now that nobody else writes there."""
        _put_back(self._folder)
        _check_replaceable(self._folder, force=self._force)
        self._replaces = self._folder.exists()
        if self._replaces:
            self.path = _sibling(self._folder, '.partial')
            for left in (self.path, _sibling(self._folder, '.replaced')):
                if left.exists():
                    shutil.rmtree(left)
                    warnings.warn(
                        f'{left}: was left by a process that did not end in good order, and is '
                        'removed',
                        TautoWarning,
                        stacklevel=3,
                    )
        self.path.mkdir()

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
        # in the MCAP file and in metadata.yaml, in YAML with its quotes and folded lines
        told = sum(len(name) + len(fact.encode()) for name, fact in self._custom.items())
        self._file.described_bytes = 3 * told

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
        with self._held:
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
        file = self.path / METADATA
        text = yaml.safe_dump({'rosbag2_bagfile_information': information}, sort_keys=False)
        try:
            write_whole(file, text.encode())
            sync_folder(self.path.parent)
        except OSError as error:
            raise refused(file, error) from error

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
        try:
            old = put_in_place(self.path, self._folder, _sibling(self._folder, '.replaced'))
        except OSError as error:
            raise BagError(
                f'{self._folder} cannot be replaced ({error.strerror}); the new bag is whole in '
                f'{self.path}, the old one in {self._folder}'
            ) from error
        self.path = self._folder
        try:
            shutil.rmtree(old)
        except OSError as error:
            raise BagError(
                f'{self._folder} is replaced, but {old} with the old bag cannot be removed '
                f'({error.strerror}); remove it'
            ) from error


def _of_bag(entry: Path) -> bool:
    """Whether a directory entry belongs to a bag."""
    names = (METADATA, f'{METADATA}.tmp', '*.mcap', DRAFTS)  # .tmp: of Tauto 0.2.0
    return any(map(entry.match, names)) and not entry.is_dir()


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
