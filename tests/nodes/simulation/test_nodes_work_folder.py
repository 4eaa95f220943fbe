"""The folder of a graph goes with it, at the latest when the next graph starts."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tauto_nodes import GraphError
from tauto_nodes.live import FOLDER_PREFIX
from tauto_nodes.simulation import work_folder

HOLD = """
import sys, time
from tauto_nodes.simulation import work_folder
with work_folder(sys.argv[1]) as folder:
    (folder / 'report.json').write_text('{}')
    print(folder, flush=True)
    time.sleep(3600.0)
"""


def test_what_a_killed_graph_left_goes_with_the_next_start(tmp_path: Path) -> None:
    other = tmp_path / f'{FOLDER_PREFIX}of_somebody'
    other.mkdir()
    command = [sys.executable, '-c', HOLD, str(tmp_path)]
    with (
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as killed,
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as living,
    ):
        left, used = (Path(p.stdout.readline().strip()) for p in (killed, living) if p.stdout)
        killed.kill()
        killed.wait()
        assert (left / 'report.json').is_file()
        with work_folder(str(tmp_path)) as folder:
            assert set(tmp_path.iterdir()) == {other, used, folder}
        assert set(tmp_path.iterdir()) == {other, used}
        living.kill()


def test_a_place_that_cannot_be_written_is_named() -> None:
    with (
        pytest.raises(GraphError, match='/proc: no folder can be made there'),
        work_folder('/proc'),
    ):
        pass
