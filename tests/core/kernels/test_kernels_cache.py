"""Compiled code is reused while all of its sources are unchanged, and only by its owner."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import pytest
from modules import module_of

from tauto_core.kernels import KernelCacheWarning, entries, marks, optimised
from tauto_core.kernels.machine_code import compiler_versions
from tauto_core.kernels.marks import listening

LAWS = """
from typing import NamedTuple
FACTOR = 3.0
class Law(NamedTuple):
    rate: float
    bend: float
def law(given, x):
    for _ in range(2):
        x = FACTOR * x
    return given.rate * x
"""
KERNEL = """
from tauto_core.kernels import entry
from {laws} import Law, law
SHIFT = 1.0
@entry
def run(given, x):
    return law(given, x) + SHIFT
"""


class Program:
    """Two modules, imported again as by another process."""

    def __init__(self, folder: Path) -> None:
        self.laws, self.kernel = folder / 'laws_of_a_test.py', folder / 'kernel_of_a_test.py'
        self.laws.write_text(LAWS)
        self.kernel.write_text(KERNEL.format(laws=self.laws.stem))

    def run(self, x: float = 1.0) -> tuple[float, int]:
        """Return the kernel's result, and the number of compiled kernels."""
        forget_sources()
        for path in (self.laws, self.kernel):
            module = module_of(path)
            importlib.invalidate_caches()
        self.loaded = module.run
        return self.again(x)

    def again(self, x: float = 1.0) -> tuple[float, int]:
        """The same by the same process."""
        compiled = []
        with listening(lambda name, _left: compiled.append(name)):
            found = self.loaded(sys.modules[self.laws.stem].Law(2.0, 0.5), x)
        return found, compiled.count(None)


@pytest.fixture
def program(tmp_path, monkeypatch):
    monkeypatch.setenv('TAUTO_CACHE_DIR', str(tmp_path / 'cache'))
    monkeypatch.setattr(sys, 'dont_write_bytecode', True)
    monkeypatch.setattr(entries, '_warned', set())
    yield Program(tmp_path)
    for name in ('laws_of_a_test', 'kernel_of_a_test'):
        sys.modules.pop(name, None)
    forget_sources()


def forget_sources():
    """Files are read once per process: forget them as the next process would."""
    for known in (marks._definitions, marks.source_of, marks.contents, marks.digest):
        known.cache_clear()


def kept_header() -> dict[str, Any]:
    """Return the header of the stored code."""
    kept = entries.read(next(path.name for path in entries.folder().iterdir()))
    assert kept is not None
    return kept[0]


def edit(path: Path, before: str, after: str) -> None:
    text = path.read_text()
    assert before in text
    path.write_text(text.replace(before, after))


def test_a_second_run_loads_what_the_first_has_compiled(program):
    assert program.run() == (19.0, 1)
    assert program.run() == (19.0, 0)


def test_a_change_of_any_source_compiles_anew(program):
    program.run()
    edit(program.laws, 'given.rate * x', 'given.bend * x')
    assert program.run() == (5.5, 1)
    edit(program.laws, 'FACTOR = 3.0', 'FACTOR = 2.0')
    assert program.run() == (3.0, 1)
    edit(program.laws, '    rate: float\n    bend: float', '    bend: float\n    rate: float')
    assert program.run() == (9.0, 1)
    edit(program.kernel, 'SHIFT = 1.0', 'SHIFT = 2.0')
    assert program.run() == (10.0, 1)
    assert program.run() == (10.0, 0)


def test_another_value_of_a_name_compiles_anew(program, monkeypatch):
    """The files are the same, but the value of a name is part of the code."""
    assert program.run() == (19.0, 1)
    header = kept_header()
    assert marks.is_unchanged(header['files'], header['names'])
    monkeypatch.setattr(sys.modules['laws_of_a_test'], 'FACTOR', 4.0)
    assert not marks.is_unchanged(header['files'], header['names'])


def test_a_file_cut_short_is_compiled_anew(program):
    program.run()
    (kept,) = entries.folder().iterdir()
    whole = kept.read_bytes()
    for damaged in (b'', whole[:100], whole[:-1], whole[:-1] + bytes([whole[-1] ^ 1])):
        kept.write_bytes(damaged)
        entries._warned.clear()
        with pytest.warns(KernelCacheWarning, match='made anew: one is damaged'):
            assert program.run() == (19.0, 1)
    assert kept.read_bytes()[64:65] == b'\n'


@pytest.mark.parametrize('what', ['link', 'pipe', 'group', 'others', 'large', 'owner'])
def test_an_entry_that_another_user_may_have_put_is_not_run(program, what):
    """In a private folder. Two kernels give one warning."""
    program.run()
    (kept,) = entries.folder().iterdir()
    if what in {'link', 'pipe'}:
        kept.rename(program.laws.with_name('elsewhere'))
        os.mkfifo(kept) if what == 'pipe' else kept.symlink_to(program.laws.with_name('elsewhere'))
    elif what == 'owner' and os.getuid():
        pytest.skip('only root gives a file to another user')
    elif what == 'owner':
        os.chown(kept, 65534, 65534)
    elif what == 'large':
        os.truncate(kept, entries.LARGEST_ENTRY + 1)
    else:
        kept.chmod(0o620 if what == 'group' else 0o602)
    why = 'symbolic link' if what == 'link' else 'no plain file that only you own and may write'
    with pytest.warns(KernelCacheWarning, match=why) as said:
        assert [program.run(), program.run()] == [(19.0, 1), (19.0, 0)]
    assert len(said) == 1
    assert kept.stat(follow_symlinks=False).st_mode & 0o777 == 0o600


def test_the_folder_and_its_files_are_the_users_alone(program):
    program.run()
    folder = entries.folder()
    assert folder.stat().st_mode & 0o777 == 0o700
    assert [path.stat().st_mode & 0o777 for path in folder.iterdir()] == [0o600]


def test_a_folder_that_others_may_write_is_not_used(program):
    program.run()
    entries.folder().chmod(0o777)
    with pytest.warns(
        KernelCacheWarning, match='others may write there. Set TAUTO_CACHE_DIR'
    ) as said:
        assert program.run() == (19.0, 1)
    assert len(said) == 1


def test_an_unwritable_folder_gives_one_warning_with_its_remedy(program, monkeypatch):
    place = program.laws.parent / 'a_file'
    place.write_text('')
    monkeypatch.setenv('TAUTO_CACHE_DIR', str(place))
    with pytest.warns(
        KernelCacheWarning, match='cannot be kept in .*a_file: .*Set TAUTO_CACHE_DIR'
    ):
        assert program.run() == (19.0, 1)
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        assert program.run() == (19.0, 1)


def test_a_user_without_a_home_folder_compiles_each_time(program, monkeypatch):
    def no_home():
        raise RuntimeError('Could not determine home directory.')

    monkeypatch.delenv('TAUTO_CACHE_DIR')
    monkeypatch.delenv('XDG_CACHE_HOME', raising=False)
    monkeypatch.setattr(Path, 'home', no_home)
    with pytest.warns(KernelCacheWarning, match='no home folder. Set TAUTO_CACHE_DIR'):
        assert program.run() == (19.0, 1)
    assert program.run() == (19.0, 1)


def test_another_processor_or_version_has_code_of_its_own(program, monkeypatch):
    program.run()
    changed = ('another', *compiler_versions())
    monkeypatch.setattr('tauto_core.kernels.machine_code.compiler_versions', lambda: changed)
    assert program.run() == (19.0, 1)
    assert len(list(entries.folder().iterdir())) == 2


def test_two_processes_at_once_leave_one_whole_file(program):
    code = (
        f'import sys; sys.path.insert(0, {str(program.laws.parent)!r}); '
        'from kernel_of_a_test import run; from laws_of_a_test import Law; '
        'print(run(Law(2.0, 0.5), 1.0))'
    )
    both = [
        subprocess.Popen([sys.executable, '-B', '-c', code], stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    assert [process.communicate()[0] for process in both] == ['19.0\n', '19.0\n']
    assert len(list(entries.folder().iterdir())) == 1
    assert program.run() == (19.0, 0)


def test_the_default_place_of_the_cache(monkeypatch):
    monkeypatch.delenv('TAUTO_CACHE_DIR', raising=False)
    monkeypatch.setenv('XDG_CACHE_HOME', '/somewhere')
    assert entries.folder() == Path('/somewhere/tauto')
    monkeypatch.delenv('XDG_CACHE_HOME')
    assert entries.folder() == Path.home() / '.cache' / 'tauto'


def test_the_compiler_itself_is_a_source(program, monkeypatch):
    program.run()
    header = kept_header()
    own = {Path(path).name for path in header['files'] if '/kernels/' in path}
    assert {'translation.py', 'operations.py', 'values.py'} <= own
    other = dict.fromkeys(header['files'], 'another')
    assert not marks.is_unchanged(other, header['names'])


def test_code_that_has_run_for_a_while_is_optimised_once(program, monkeypatch):
    assert [program.run(), program.again()] == [(19.0, 1), (19.0, 0)]
    monkeypatch.setattr(entries, 'OPTIMISED_AFTER_S', 0.0)
    assert [program.again(), program.again()] == [(19.0, 1), (19.0, 0)]
    assert len(list(entries.folder().iterdir())) == 2


def test_another_run_prefers_optimised_code(program, monkeypatch):
    with optimised():
        assert program.run() == (19.0, 1)
    monkeypatch.setattr(entries, 'OPTIMISED_AFTER_S', 0.0)
    assert [program.run(), program.again()] == [(19.0, 0), (19.0, 0)]
    assert len(list(entries.folder().iterdir())) == 1


def test_under_optimised_quick_code_is_optimised_at_once(program):
    program.run()
    with optimised():
        assert [program.again(), program.again()] == [(19.0, 1), (19.0, 0)]
    assert program.again() == (19.0, 0)
