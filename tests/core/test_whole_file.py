"""A file is written completely, or the old one remains."""

from __future__ import annotations

import errno
import fcntl
import os
import resource
import stat
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import FileIO
from pathlib import Path
from typing import Any

import pytest

from tauto_core import files
from tauto_core.bags import BagWriter, read_bag
from tauto_core.bags import write as bags_write
from tauto_core.euler.site import write_site
from tauto_core.files import (
    OutputError,
    check_place,
    one_writer,
    write_figure,
    write_output,
    write_whole,
)
from tauto_core.samples import SCENE
from tauto_core.samples import text as text_samples
from tauto_core.scene.errors import TautoError, UsageError
from tauto_core.scene.reference import new_scene, write_scene


@pytest.fixture
def no_room() -> Iterator[None]:
    """No file of this process may have more than a kilobyte. Python ignores the signal."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1024, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def draw_line(file: Path) -> None:
    from matplotlib.figure import Figure

    def drawn() -> Figure:
        figure = Figure()
        figure.add_subplot().plot([0.0, 1.0])
        return figure

    write_figure(drawn, file)


def write_bytes(file: Path) -> None:
    write_output(file, bytes(100_000))


@pytest.mark.usefixtures('no_room')
@pytest.mark.parametrize(
    ('name', 'write'),
    [('a.svg', draw_line), ('a.png', draw_line), ('a.pdf', draw_line), ('a.csv', write_bytes)],
)
def test_what_was_there_remains_where_there_is_no_room(
    tmp_path: Path, name: str, write: Callable[[Path], None]
) -> None:
    file = tmp_path / name
    file.write_text('before')
    with pytest.raises(OutputError, match=r'cannot be written: File too large'):
        write(file)
    assert file.read_text() == 'before'
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.usefixtures('no_room')
@pytest.mark.parametrize(
    ('write', 'error'),
    [
        (
            lambda folder: write_scene(str(folder / 'new.yaml'), lambda name: new_scene(name, {})),
            UsageError,
        ),
        (lambda folder: write_site(folder, []), OutputError),
    ],
    ids=['scene new', 'euler --site'],
)
def test_nothing_is_left_of_a_file_for_which_there_is_no_room(
    tmp_path: Path, write: Callable[[Path], object], error: type[TautoError]
) -> None:
    with pytest.raises(error, match=r'cannot be written: File too large'):
        write(tmp_path)
    assert not [each for each in tmp_path.rglob('*') if each.is_file()]


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / 'link').symlink_to('file')
    for content in (b'first', b'second'):
        write_whole(tmp_path / 'link', content)
        assert (tmp_path / 'file').read_bytes() == content
    assert (tmp_path / 'link').is_symlink()


def test_a_link_with_the_name_of_a_draft_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / 'theirs').write_text('theirs')
    (tmp_path / f'.{os.getpid()}.file').symlink_to('theirs')
    write_whole(tmp_path / 'file', b'ours')
    assert (tmp_path / 'theirs').read_text() == 'theirs'
    assert not (tmp_path / 'file').is_symlink()


def test_a_file_is_on_the_disk_before_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[object] = []
    sync, replace = os.fsync, os.replace

    def synced(handle: int) -> None:
        sync(handle)
        done.append('folder' if stat.S_ISDIR(os.fstat(handle).st_mode) else 'file')

    def replaced(draft: Path, place: Path) -> None:
        replace(draft, place)
        done.append('name')

    monkeypatch.setattr(os, 'fsync', synced)
    monkeypatch.setattr(os, 'replace', replaced)
    write_whole(tmp_path / 'file', b'content')
    assert done == ['file', 'name', 'folder']


def test_drafts_that_nobody_writes_go_with_the_next_file(tmp_path: Path) -> None:
    left, used = (tmp_path / files.DRAFTS.replace('*', name) for name in 'ab')
    left.write_text('killed')
    with used.open('w') as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        write_whole(tmp_path / 'file', b'new')
        assert sorted(tmp_path.iterdir()) == [used, tmp_path / 'file']


@contextmanager
def failing_at(number: int, code: int) -> Iterator[list[str]]:
    """Let call `number` of those that change a disk fail. Yield the names of all calls."""
    calls: list[str] = []

    def faulty(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def called(*given: Any, **more: Any) -> Any:
            calls.append(name)
            if len(calls) == number:
                raise OSError(code, os.strerror(code))
            return call(*given, **more)

        return called

    with pytest.MonkeyPatch.context() as patch:
        for name in ('open', 'fsync', 'replace', 'rename', 'mkdir', 'unlink', 'rmdir'):
            patch.setattr(os, name, faulty(name, getattr(os, name)))
        patch.setattr(bags_write, 'exchange', faulty('exchange', bags_write.exchange))
        methods = {name: faulty(name, getattr(FileIO, name)) for name in ('write', 'truncate')}
        patch.setattr(bags_write, 'FileIO', type('Faulty', (FileIO,), methods))
        yield calls


def write_text(place: Path, text: str) -> None:
    write_output(place, text.encode())


def write_bag(place: Path, text: str) -> None:
    with BagWriter(place, force=True) as writer:
        writer.write({SCENE: text_samples(1, text)})


def held(place: Path) -> str | None:
    return read_bag(place).scene if place.is_dir() else place.read_text()


@pytest.mark.filterwarnings('ignore::tauto_core.scene.errors.TautoWarning')
@pytest.mark.parametrize('code', [errno.EIO, errno.ENOSPC])
@pytest.mark.parametrize('write', [write_text, write_bag])
def test_a_fault_of_the_disk_at_any_call_leaves_the_old_result(
    tmp_path: Path, write: Callable[[Path, str], None], code: int
) -> None:
    """A writer ends with an error of the package, or, if it can do without, with the new one."""
    number, calls = 0, ['']
    while len(calls) >= number:
        number += 1
        place = tmp_path / f'{number}' / 'place'
        place.parent.mkdir()
        write(place, 'old')
        with failing_at(number, code) as calls:
            try:
                write(place, 'new')
                ended = 'new'
            except TautoError:
                ended = 'old'
        # a file is in its place when only its folder could not be synced
        is_replaced = write is write_text and 'replace' in calls[: number - 1]
        assert held(place) == ('new' if is_replaced else ended), calls[number - 1]
        write(place, 'next')
        assert held(place) == 'next'
        assert not list(place.parent.glob(files.DRAFTS))
    assert number > 5


HOLD = """
import sys
from pathlib import Path
from tauto_core.files import one_writer
with one_writer(Path(sys.argv[1])):
    print('held', flush=True)
    sys.stdin.read()
"""


def test_a_lock_has_one_holder_and_goes_with_its_process(tmp_path: Path) -> None:
    lock = tmp_path / 'lock'
    with subprocess.Popen(
        [sys.executable, '-c', HOLD, lock],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == 'held\n'
        with pytest.raises(BlockingIOError), one_writer(lock):
            pass
        holder.kill()
    assert lock.exists()
    with one_writer(lock):
        assert lock.exists()
    assert not list(tmp_path.iterdir())


def test_a_lock_that_its_holder_removed_meanwhile_is_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lock, flock, made = tmp_path / 'lock', fcntl.flock, []

    def removed_first(handle: int, how: int) -> None:
        flock(handle, how)
        made.append(os.fstat(handle).st_ino)
        if len(made) == 1:
            lock.unlink()

    monkeypatch.setattr(fcntl, 'flock', removed_first)
    with one_writer(lock):
        assert len(made) == 2
        assert lock.stat().st_ino == made[1]


def test_a_pipe_receives_the_content(tmp_path: Path) -> None:
    pipe = tmp_path / 'pipe'
    os.mkfifo(pipe)
    reading = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_whole(pipe, b'content')
    assert os.read(reading, 99) == b'content'
    os.close(reading)
    assert stat.S_ISFIFO(pipe.stat().st_mode)


@pytest.mark.parametrize(('place', 'said'), [('', 'is a folder'), ('no/file', 'is no folder')])
def test_a_place_for_no_file_is_refused_at_once(tmp_path: Path, place: str, said: str) -> None:
    with pytest.raises(UsageError, match=f'out=.*{said}'):
        check_place(tmp_path / place, 'out')


def test_a_folder_that_may_not_be_written_is_refused_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # the superuser may write to any folder
    monkeypatch.setattr(os, 'access', lambda place, _mode: place != tmp_path)
    with pytest.raises(UsageError, match=r'out=.* cannot be written'):
        check_place(tmp_path / 'file', 'out')
