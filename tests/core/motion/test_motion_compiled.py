"""The cache of compiled kernels follows all that they are made from."""

from __future__ import annotations

import importlib.util
import sys

import pytest

from tauto_core.motion import compiled

MODULE = """
from tauto_core.motion.compiled import entry


@entry
def doubled(x):
    return 2.0 * x
"""


@pytest.fixture
def sources(tmp_path, monkeypatch):
    """Two followed files of our own; the true stamp comes back afterwards."""
    files = tmp_path / 'kernels.py', tmp_path / 'levers.py'
    for file in files:
        file.write_text('first\n')
    monkeypatch.setattr(compiled, '_FOLLOWED', files)
    compiled._sources.cache_clear()
    yield files
    monkeypatch.undo()
    compiled._sources.cache_clear()


def stamp():
    compiled._sources.cache_clear()
    return compiled._sources()


def test_a_change_of_any_followed_source_changes_the_stamp(sources):
    seen = {stamp()}
    assert stamp() in seen
    for n, file in enumerate(sources):
        file.write_text('second\n')
        seen.add(stamp())
        assert len(seen) == n + 2
    for file in sources:
        file.write_text('first\n')
    assert stamp() in seen


def test_every_module_of_the_package_and_the_levers_are_followed():
    names = {path.name for path in compiled._FOLLOWED}
    assert {'lanes.py', 'turning.py', 'wells.py', 'gauss.py', 'levers.py'} <= names
    assert all(path.is_file() for path in compiled._FOLLOWED)


def test_the_stamp_is_in_the_index_of_the_cache(sources, tmp_path):
    before = stamp()
    kernel = fresh(tmp_path)
    assert before in kernel._cache._cache_file._source_stamp
    sources[0].write_text('second\n')
    after = stamp()
    assert after != before
    assert after in fresh(tmp_path)._cache._cache_file._source_stamp


def fresh(folder):
    """The kernel of a module as a new process would import it."""
    path = folder / 'kernel_of_the_cache_test.py'
    if not path.exists():
        path.write_text(MODULE)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    try:
        spec.loader.exec_module(module)
    finally:
        del sys.modules[path.stem]
    return module.doubled


def test_kernels_are_loaded_until_a_source_changes(sources, tmp_path):
    def hits_and_misses():
        kernel = fresh(tmp_path)
        assert kernel(21.0) == 42.0
        return sum(kernel.stats.cache_hits.values()), sum(kernel.stats.cache_misses.values())

    assert hits_and_misses() == (0, 1)
    assert hits_and_misses() == (1, 0)
    sources[1].write_text('second\n')
    stamp()
    assert hits_and_misses() == (0, 1)
