"""The folder of a graph goes with it, at the latest when the next graph starts."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import OWN

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


@pytest.mark.usefixtures('mounts')
def test_a_report_for_which_there_is_no_room_is_told(tmp_path: Path) -> None:
    # The parameters take the only block.
    small = tmp_path / 'small'
    small.mkdir()
    voyage = ['graph', 'measured', '--duration', '20', '--speed', 'max']
    words = [sys.executable, '-m', 'tauto_core', *voyage, '--out', str(tmp_path / 'bag')]
    done = subprocess.run(
        [*OWN, 'sh', '-c', f'mount -t tmpfs -o size=4k none {small} && exec "$@"', 'sh', *words],
        env={**os.environ, 'TMPDIR': str(small)},
        capture_output=True,
        text=True,
        check=False,
        timeout=300.0,
    )
    assert done.returncode == 1, done.stderr
    assert 'report.json: the recorder could not write its report' in done.stderr
    assert 'Traceback' not in done.stderr
