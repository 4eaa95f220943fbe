"""Makes a new bag from what can be read of one whose recording was cut short."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tauto_core.bags.mcap_file import Channel
from tauto_core.bags.mcap_out import DeclaredTopic
from tauto_core.bags.soundness import Soundness, check_bag
from tauto_core.bags.table import MESSAGE_TYPES
from tauto_core.bags.writer import CUT_SHORT, BagWriter, check_folder, definition_of
from tauto_core.scene.errors import BagError, BagPlaceError


@dataclass(frozen=True)
class Recovered:
    """The result of a recovery.

    Args:
        path: folder of the new bag.
        counts: its messages, by full topic name.
        start_ns, end_ns: their first and last log time [ns].
        lost: descriptions of what was damaged, and is left out or was made anew.
        missing: number of messages that a valid index counts and that cannot be read; messages
            after a truncation are not counted anywhere.
    """

    path: Path
    counts: dict[str, int]
    start_ns: int
    end_ns: int
    lost: tuple[str, ...]
    missing: int


def recover_bag(path: Path, out: Path | None = None) -> Recovered:
    """Write a new bag with every message that can be read, as it was recorded.

    The original is only read. Messages keep their bytes, order, log and publish times and
    sequence numbers; a split bag becomes one file. The new bag is marked `cut_short` unless the
    recording is known to have ended normally.

    Args:
        path: path of the damaged bag, a folder or an .mcap file.
        out: folder of the new bag, which must not exist; when left out, beside the old one with
            `_recovered` appended to its name.

    Raises:
        BagPlaceError: nothing at `path`; `out` exists or lies in the bag itself.
        BagError: nothing is damaged, no message can be read, or the file system refuses.
    """
    found = check_bag(path)
    if not found.damage:
        raise BagError(
            f'{path}: its files are whole, so there is nothing to recover'
            + (f' (`tauto bag check` says what else: {found.faults[0]})' if found.faults else '')
        )
    absolute = path.resolve()
    name = absolute.stem if absolute.is_file() else absolute.name
    out = out or absolute.with_name(f'{name}_recovered')
    if absolute.is_dir() and out.resolve().is_relative_to(absolute):
        raise BagPlaceError(f'{out} lies in the bag that is recovered; name another folder')
    check_folder(out)
    start_ns, end_ns = found.bag.start_ns, found.bag.end_ns
    if start_ns is None or end_ns is None:
        raise BagError(
            f'{path}: no message can be read ({found.damage[0]}), so nothing can be recovered'
        )
    counts = _write(found, out)
    return Recovered(
        out,
        counts,
        start_ns,
        end_ns,
        tuple(found.damage),
        max(found.counted - sum(counts.values()), 0),
    )


def _write(found: Soundness, out: Path) -> dict[str, int]:
    with BagWriter(out) as writer:
        keys: dict[str, str] = {}
        for file in found.bag.files:
            with file.path.open('rb') as stream:
                for span in file.spans:
                    for message in file.recorded(span, stream):
                        channel = file.channels.get(message.channel)
                        if channel is None:
                            continue
                        key = f'{channel.topic} {channel.ros_type}'
                        if key not in keys:
                            keys[key] = channel.topic
                            writer.declare(key, _declared(channel))
                        writer.copy(key, message)
        writer.describe(found.custom)
        if not all(file.ended for file in found.bag.files):
            writer.describe(CUT_SHORT)
    return {keys[key]: number for key, number in writer.counts.items()}


def _declared(channel: Channel) -> DeclaredTopic:
    known = channel.ros_type in MESSAGE_TYPES
    type_hash = channel.metadata.get('topic_type_hash', '')
    return DeclaredTopic(
        channel.topic,
        channel.ros_type,
        channel.definition,
        channel.metadata.get('offered_qos_profiles', ''),
        type_hash or (definition_of(channel.ros_type)[1] if known else ''),
        channel.encoding,
        channel.definition_encoding,
    )
