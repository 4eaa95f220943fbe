"""The kernels of a scene are compiled before it runs, where others wait for its messages."""

from __future__ import annotations

import subprocess
import sys

import pytest

PROGRAM = """
from tauto_core.kernels import listening
from tauto_core.scene import load_scene
from tauto_core.voyage import compile_kernels, sail
scene, compiled = load_scene({scene!r}, duration=600.0), []
with listening(lambda kernel, _left: compiled.append(kernel)):
    compile_kernels(scene)
    before = compiled.count(None)
    sail(scene, watch=lambda _: None)
print(before, compiled.count(None))
"""


@pytest.mark.parametrize('scene', ['second_cam_at_sea', 'involute_weight_at_sea'])
def test_a_voyage_compiles_nothing_that_was_not_compiled_before(scene, tmp_path, monkeypatch):
    monkeypatch.setenv('TAUTO_CACHE_DIR', str(tmp_path))
    run = subprocess.run(
        [sys.executable, '-c', PROGRAM.format(scene=scene)],
        capture_output=True,
        text=True,
        check=True,
    )
    before, after = map(int, run.stdout.split())
    assert before > 8
    assert after == before
