"""Atomic writes, locks, bounded decompression, YAML, and figures as files."""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import re
import secrets
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tauto_core.scene.errors import Argument, TautoError, UsageError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# -----------------------------------------------------------------------------
# Files and folders are written completely or not at all, by one process at a time.

DRAFTS = '.tauto-*.draft'
"""Names of files being written. Their process locks them; unlocked files are left from a kill."""


def check_place(path: Path, argument: str) -> None:
    """Raise UsageError, with the name of the argument, if no file can be written at a path."""
    if path.is_dir():
        raise UsageError(Argument(argument, path), ': is a folder. Name a file')
    if not path.parent.is_dir():
        missing = f': there is no folder {path.parent}. Make it first'
        raise UsageError(Argument(argument, path), missing)
    if not os.access(path.parent, os.W_OK):
        closed = f': the folder {path.parent} cannot be written. Name another file'
        raise UsageError(Argument(argument, path), closed)


def write_whole(path: Path, content: bytes) -> None:
    """Write or replace a file in one step; a power cut leaves the old file or the new one.

    Links are followed. A file that is not regular (`/dev/stdout`) receives the content directly.
    Drafts of killed processes in the folder are removed. A failure is an OSError: the old file is
    still there, unless only the folder could not be synced.
    """
    if path.exists() and not path.is_file():
        path.write_bytes(content)
        return
    place = path.resolve()
    # random, since in a shared folder another user could place a link at a known name
    draft = place.with_name(DRAFTS.replace('*', secrets.token_hex(8)))
    for draft_left in place.parent.glob(DRAFTS):
        with suppress(OSError), one_writer(draft_left, make=False):
            pass
    handle = -1
    while handle < 0 or not os.fstat(handle).st_nlink:  # another process took it for a stale one
        handle = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o666)
        with suppress(OSError):  # some network file systems lock no files
            fcntl.flock(handle, fcntl.LOCK_EX)
    try:
        with open(handle, 'wb') as file:
            file.write(content)
            file.flush()
            os.fsync(handle)
            draft.replace(place)
        sync_folder(place.parent)
    finally:
        with suppress(OSError):
            draft.unlink()


def sync_folder(folder: Path) -> None:
    """Wait until the names in a folder are on the disk; a failure is an OSError."""
    try:
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except PermissionError:  # a folder that cannot be read cannot be synced
        return
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno != errno.EINVAL:  # some network file systems sync no folders
            raise
    finally:
        os.close(handle)


def exchange(a: Path, b: Path) -> None:
    """Exchange two names in one step, by Linux' renameat2(2). OSError if the system cannot."""
    renameat2 = getattr(ctypes.CDLL(None, use_errno=True), 'renameat2', None)
    folder, names = -100, (os.fsencode(a), os.fsencode(b))  # AT_FDCWD
    if renameat2 is None or renameat2(folder, names[0], folder, names[1], 2):  # RENAME_EXCHANGE
        raise OSError(ctypes.get_errno(), 'the names cannot be exchanged', str(a), None, str(b))


@contextmanager
def one_writer(lock: Path, *, make: bool = True) -> Iterator[None]:
    """Hold a lock file in a context, and remove it at the end.

    The system releases the lock when the process ends, even by a kill.

    Raises:
        BlockingIOError: another process holds the lock.
        FileNotFoundError: no such file, without `make`.
        OSError: the file cannot be locked.
    """
    flags = os.O_RDWR | os.O_NOFOLLOW | (os.O_CREAT if make else 0)
    while True:
        handle = os.open(lock, flags, 0o666)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            with suppress(FileNotFoundError):
                if os.path.samestat(os.stat(lock, follow_symlinks=False), os.fstat(handle)):
                    break
        except BaseException:
            os.close(handle)
            raise
        os.close(handle)  # its holder has removed the file meanwhile
    try:
        yield
    finally:
        with suppress(OSError):
            lock.unlink()
        os.close(handle)


# -----------------------------------------------------------------------------
# Limits of decompression.

LARGEST_PART, PLAUSIBLE = 2**29, 200
"""Most bytes of a decompressed part, and largest compression ratio above `SMALL_PART`.

Chunks of rosbag2 have 0.8 MB, of other recorders 4 MB, or one large message. Motion and pictures
shrink by 2 to 50 times.
"""
SMALL_PART = 2**24


def decompressed(compression: str, body: bytes, size: int) -> bytes:
    """Return the content of a part compressed by zstd or lz4, or uncompressed (''), of known size.

    ValueError if it is larger than stated, or implausibly large.
    """
    if size > SMALL_PART and size > min(LARGEST_PART, PLAUSIBLE * len(body)):
        raise ValueError(f'{len(body)} bytes that would become {size} are not decompressed')
    if compression == 'zstd':
        import zstandard

        try:
            # the size stated in the frame would be allocated
            if zstandard.frame_content_size(body) not in (-1, size):
                raise ValueError('it states two sizes')
            return zstandard.decompress(body, size)
        except (zstandard.ZstdError, MemoryError, OverflowError) as error:
            raise ValueError(str(error)) from None
    if compression == 'lz4':
        import lz4.frame  # type: ignore[import-untyped]

        try:
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(body, max_length=size + 1))
        except (RuntimeError, EOFError, MemoryError) as error:
            raise ValueError(str(error)) from None
    if compression:
        raise ValueError(f'compression {compression!r} instead of zstd, lz4 or no compression')
    return body


# -----------------------------------------------------------------------------
# YAML 1.2, for all YAML from outside the package: scenes, draws, the metadata of bags.
#
# PyYAML reads the scalars of YAML 1.1. So only its events are used, and scalars follow the core
# schema of YAML 1.2 (section 10.3.2): `1e-4` is a number, `yes`, `12:30` and `2001-99-99` are
# strings. Duplicate keys, anchors and unknown tags are refused, since each hides a mistake, and
# texts that would take much time or memory to read.

YAML_TAG = 'tag:yaml.org,2002:'
SCALARS: dict[str, tuple[re.Pattern[str], str]] = {
    'null': (re.compile(r'~|null|Null|NULL|'), '~nN'),
    'bool': (re.compile(r'true|True|TRUE|false|False|FALSE'), 'tTfF'),
    'int': (re.compile(r'[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+'), '-+0123456789'),
    'float': (
        re.compile(
            r'[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?'
            r'|[-+]?\.(?:inf|Inf|INF)|\.nan|\.NaN|\.NAN'
        ),
        '-+.0123456789',
    ),
}
"""Pattern and possible first characters of each kind of scalar, except strings."""

LARGEST_YAML = 2**24
"""Most characters of a text; the metadata of a bag with 10,000 topics have a third of this."""
_DEEPEST = 20
_MOST_VALUES = 100_000
# Python refuses to convert numbers of more than 4,300 digits.
_LONGEST_NUMBER = 400


class YamlError(ValueError):
    """A YAML text that is not read: the problem with its line and column, and a remedy."""

    def __init__(self, at: Any, problem: str, remedy: str) -> None:
        """Take a problem at a node or event, or of the whole text (None)."""
        mark = at and at.start_mark
        where = f'line {mark.line + 1}, column {mark.column + 1}: ' if mark else ''
        self.problem, self.remedy = where + problem, remedy
        super().__init__(self.problem)


def read_yaml(text: str, *, any_key: bool = False) -> Any:
    """Return the value of a YAML text of one document: plain dicts, lists and scalars.

    With `any_key` numbers may be keys and are read as strings.

    Raises:
        YamlError: not such YAML, or more than `LARGEST_YAML` characters, 100,000 values or 20
            levels.
    """
    import yaml

    if len(text) > LARGEST_YAML:
        raise YamlError(None, f'has more than {LARGEST_YAML} characters', 'Name another file.')
    try:
        # libyaml refuses the surrogates that stand for bytes in file names
        is_slow = len(text) < 100_000 and '\\ud' in text.lower()
        loader = yaml.SafeLoader if is_slow else getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
        return _Document(yaml.parse(text, Loader=loader), any_key=any_key).value
    except UnicodeError as error:
        what = getattr(error, 'reason', error)
        raise YamlError(None, f'YAML syntax: {what}', 'Correct the YAML there.') from None
    except yaml.YAMLError as error:
        mark = getattr(error, 'problem_mark', None)
        what = getattr(error, 'problem', None) or getattr(error, 'reason', None) or 'not YAML'
        why = ', '.join(filter(None, (getattr(error, 'context', None), what)))
        where = '' if mark is None else f', line {mark.line + 1}, column {mark.column + 1}'
        raise YamlError(None, f'YAML syntax{where}: {why}', 'Correct the YAML there.') from None


class _Document:
    """The value of a single document, from the events of a parser."""

    def __init__(self, events: Iterator[Any], *, any_key: bool) -> None:
        from yaml import events as kinds

        self._events, self._any_key, self._kinds, self._number = events, any_key, kinds, 0
        next(events)  # the start of the stream
        self.value: Any = None
        if isinstance(next(events), kinds.DocumentStartEvent):
            self.value = self._node(next(events), 0)
            next(events)  # its end
            event = next(events)
            if not isinstance(event, kinds.StreamEndEvent):
                raise YamlError(event, 'another document begins', 'Keep one document.')

    def _node(self, event: Any, depth: int) -> Any:
        """Read and return the value that begins with an event."""
        kinds, tag = self._kinds, getattr(event, 'tag', None)
        self._number += 1
        if isinstance(event, kinds.AliasEvent) or event.anchor:
            raise YamlError(event, 'anchors and aliases are not read', 'Write the value out.')
        if self._number > _MOST_VALUES:
            problem = f'has more than {_MOST_VALUES:,} values'
            raise YamlError(event, problem, 'Put numbers into a file of their own.')
        if isinstance(event, kinds.ScalarEvent):
            return _scalar(event)
        if depth == _DEEPEST:
            problem = f'is nested more than {_DEEPEST} deep'
            raise YamlError(event, problem, 'A scene is at most five levels deep.')
        is_list = isinstance(event, kinds.SequenceStartEvent)
        if tag not in (None, '!', YAML_TAG + ('seq' if is_list else 'map')):
            raise YamlError(event, f'the tag {tag} is not read', 'Leave the tag out.')
        items: list[Any] = []
        content: dict[str, Any] = {}
        while not isinstance(event := next(self._events), kinds.CollectionEndEvent):
            if is_list:
                items.append(self._node(event, depth + 1))
                continue
            key = self._key(event, content)
            content[key] = self._node(next(self._events), depth + 1)
        return items if is_list else content

    def _key(self, event: Any, mapping: dict[str, Any]) -> str:
        is_scalar = isinstance(event, self._kinds.ScalarEvent)
        value = _scalar(event) if is_scalar else None
        if not isinstance(value, str) and not (is_scalar and self._any_key):
            remedy = 'Use the names of the scene reference.'
            prior = mapping[next(reversed(mapping))] if mapping else ''
            # such as 322 in `{mass: 0,322}`
            if type(value) is int and type(prior) is int:
                remedy = (
                    f'Write {prior}.{event.value} with a decimal point if {prior},{event.value} '
                    'is meant.'
                )
            raise YamlError(event, 'a key must be a word', remedy)
        key: str = event.value
        if key in mapping:
            raise YamlError(event, f'the key {key[:80]!r} comes twice', 'Keep one of them.')
        return key


def _scalar(event: Any) -> str | int | float | bool | None:
    text: str = event.value
    kind = (event.tag or '').removeprefix(YAML_TAG)
    if not kind and event.implicit[0]:  # plain, without quotes or tag
        for name, (pattern, first_characters) in SCALARS.items():
            if text[:1] in first_characters and pattern.fullmatch(text):
                kind = name
                break
    if kind in ('', '!', 'str'):
        return text
    if kind not in SCALARS:
        raise YamlError(event, f'the tag {event.tag[:80]} is not read', 'Leave the tag out.')
    if not SCALARS[kind][0].fullmatch(text) or len(text) > _LONGEST_NUMBER:
        problem = f'{text[:40]!r} cannot be read as {kind}'
        raise YamlError(event, problem, 'Write a plain value.')
    if kind in ('null', 'bool'):
        return {'null': None, 'bool': text.lower() == 'true'}[kind]
    if kind == 'int':
        # In base 0 Python refuses a leading zero; YAML 1.2 reads it as decimal.
        return int(text, {'0o': 8, '0x': 16}.get(text[:2], 10))
    return float(re.sub(r'^([-+]?)\.(inf|nan)$', r'\1\2', text.lower()))


# -----------------------------------------------------------------------------
# Figures as files: the same figure gives the same bytes.

DOTS_AN_INCH = 192
"""Twice the 96 of a CSS pixel, for the screens of laptops and telephones."""
# text stays text, to be searched and read aloud
LOOK: dict[Any, Any] = {'svg.hashsalt': 'tauto', 'font.size': 9.0, 'svg.fonttype': 'none'}
# Metadata that would differ from run to run.
_NO_DATE: dict[str, dict[str, Any]] = {
    '.svg': {'Date': None},
    '.png': {'Software': None},
    '.pdf': {'CreationDate': None},
}


class OutputError(TautoError):
    """A file that cannot be written, or a figure that cannot be drawn."""


def write_output(path: Path, content: bytes) -> None:
    """Write a file as `write_whole` does, or raise OutputError."""
    try:
        write_whole(path, content)
    except OSError as error:
        problem = f'{path}: cannot be written: {error.strerror}. Name another file'
        raise OutputError(problem) from None


def check_plot(path: Path, argument: str = 'plot') -> None:
    """Raise UsageError unless a path ends in .svg, .png or .pdf and can be written."""
    if path.suffix not in _NO_DATE:
        wrong = ': must end in .svg, .png or .pdf. Name another file'
        raise UsageError(Argument(argument, path), wrong)
    check_place(path, argument)


def write_figure(draw: Callable[[], Figure], path: Path, argument: str = 'plot') -> None:
    """Draw a figure and write it to an SVG, PNG or PDF file, replacing the file.

    Raises:
        UsageError: see `check_plot`.
        OutputError: the file cannot be written.
    """
    import matplotlib as mpl

    check_plot(path, argument)
    drawn = BytesIO()
    with mpl.rc_context(LOOK):
        figure = draw()
        titles = [axes.get_title(loc) for axes in figure.axes for loc in ('left', 'center')]
        title = next(filter(None, titles), None)
        figure.savefig(
            drawn,
            format=path.suffix[1:],
            dpi=DOTS_AN_INCH,
            metadata={'Title': title, **_NO_DATE[path.suffix]} if title else _NO_DATE[path.suffix],
        )
    write_output(path, drawn.getvalue())
