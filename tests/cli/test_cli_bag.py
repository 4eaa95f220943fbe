"""`tauto bag check` and `tauto bag recover`: exit codes, messages and JSON."""

from __future__ import annotations

import json
from pathlib import Path

from command_line import invoke, refused, run

GOLDEN = Path(__file__).resolve().parents[2] / 'bags' / 'cheek_1min'


def torn(folder: Path) -> Path:
    folder.mkdir()
    [file] = GOLDEN.glob('*.mcap')
    (folder / file.name).write_bytes(file.read_bytes()[:90_000])
    return folder


def test_the_exit_code_tells_whole_damaged_and_absent(tmp_path: Path) -> None:
    assert run('bag', 'check', GOLDEN) == f'{GOLDEN} is whole: 1,695 messages on 11 topics\n'
    bag = torn(tmp_path / 'bag')
    damaged = invoke('bag', 'check', bag)
    assert damaged.exit_code == 1
    assert f'`tauto bag recover {bag}`' in damaged.stdout
    assert 'does not exist' in refused('bag', 'check', tmp_path / 'nowhere')


def test_what_is_recovered_is_checked_and_replayed(tmp_path: Path) -> None:
    bag = torn(tmp_path / 'bag')
    assert invoke('bag', 'recover', bag, '--out', GOLDEN).exit_code == 2
    told = json.loads(run('bag', 'recover', bag, '--out', tmp_path / 'new', '--json'))
    assert told['recovered'] == str(tmp_path / 'new')
    assert any('was cut at byte 90000' in lost for lost in told['lost'])
    checked = invoke('bag', 'check', tmp_path / 'new', '--json')
    assert checked.exit_code == 1
    found = json.loads(checked.stdout)
    assert (found['damage'], found['faults'], found['cut_short']) == ([], [], True)
    assert found['topics'] == told['topics']
    assert invoke('replay', tmp_path / 'new', '--json').exit_code == 0
    again = invoke('bag', 'recover', bag)
    assert again.stdout.endswith(' s\n')
    assert (tmp_path / 'bag_recovered').is_dir()
