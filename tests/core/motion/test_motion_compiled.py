"""The cache of compiled kernels follows all that they are made from."""

from __future__ import annotations

import importlib.util
import sys

import pytest

from tauto_core.motion import compiled

MODULE = """
from tauto_core.motion.compiled import {decorator}


@{decorator}{call}
def doubled(x):
    return 2.0 * x
"""
KINDS = {
    '_ENGINE': MODULE.format(decorator='entry', call=''),
    '_LANES': MODULE.format(decorator='on_lanes', call="(error_model='numpy')"),
}


@pytest.fixture(params=KINDS)
def kind(request):
    """Which sources are followed."""
    return request.param


@pytest.fixture
def sources(tmp_path, monkeypatch, kind):
    """Two followed files of our own; the true stamp comes back afterwards."""
    files = tmp_path / 'kernels.py', tmp_path / 'levers.py'
    for file in files:
        file.write_text('first\n')
    monkeypatch.setattr(compiled, kind, files)
    yield files
    compiled._hash.cache_clear()


def stamp(kind):
    compiled._hash.cache_clear()
    return compiled._hash(getattr(compiled, kind))


def test_a_change_of_any_followed_source_changes_the_stamp(sources, kind):
    seen = {stamp(kind)}
    assert stamp(kind) in seen
    for n, file in enumerate(sources):
        file.write_text('second\n')
        seen.add(stamp(kind))
        assert len(seen) == n + 2
    for file in sources:
        file.write_text('first\n')
    assert stamp(kind) in seen


def test_every_module_of_the_package_and_the_levers_are_followed():
    names = {path.name for path in compiled._ENGINE}
    assert {'lanes.py', 'turning.py', 'wells.py', 'gauss.py', 'levers.py'} <= names
    assert all(path.is_file() for path in (*compiled._ENGINE, *compiled._LANES))
    assert {path.name for path in compiled._LANES} == {'lanes.py', 'compiled.py'}


def test_the_stamp_is_in_the_index_of_the_cache(sources, kind, tmp_path):
    before = stamp(kind)
    kernel = fresh(kind, tmp_path)
    assert before in kernel._cache._cache_file._source_stamp
    sources[0].write_text('second\n')
    after = stamp(kind)
    assert after != before
    assert after in fresh(kind, tmp_path)._cache._cache_file._source_stamp


def fresh(kind, folder):
    """The kernel of a module as a new process would import it."""
    path = folder / 'kernel_of_the_cache_test.py'
    if not path.exists():
        path.write_text(KINDS[kind])
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    try:
        spec.loader.exec_module(module)
    finally:
        del sys.modules[path.stem]
    return module.doubled


def test_kernels_are_loaded_until_a_source_changes(sources, kind, tmp_path):
    def hits_and_misses():
        kernel = fresh(kind, tmp_path)
        assert kernel(21.0) == 42.0
        return sum(kernel.stats.cache_hits.values()), sum(kernel.stats.cache_misses.values())

    assert hits_and_misses() == (0, 1)
    assert hits_and_misses() == (1, 0)
    sources[1].write_text('second\n')
    stamp(kind)
    assert hits_and_misses() == (0, 1)
