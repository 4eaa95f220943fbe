"""`tauto bag check` and `tauto bag recover`: exit codes, messages and JSON."""

from __future__ import annotations

import json
from pathlib import Path

from typer.testing import CliRunner, Result

from tauto_core.cli.app import app

GOLDEN = Path(__file__).resolve().parents[2] / 'bags' / 'cheek_1min'


def tauto(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def torn(folder: Path) -> Path:
    folder.mkdir()
    [file] = GOLDEN.glob('*.mcap')
    (folder / file.name).write_bytes(file.read_bytes()[:90_000])
    return folder


def test_the_exit_code_tells_whole_damaged_and_absent(tmp_path: Path) -> None:
    whole = tauto('bag', 'check', GOLDEN)
    assert (whole.exit_code, whole.stdout) == (
        0,
        f'{GOLDEN} is whole: 1,695 messages on 11 topics\n',
    )
    bag = torn(tmp_path / 'bag')
    damaged = tauto('bag', 'check', bag)
    assert damaged.exit_code == 1
    assert f'`tauto bag recover {bag}`' in damaged.stdout
    absent = tauto('bag', 'check', tmp_path / 'nowhere')
    assert absent.exit_code == 2
    assert 'does not exist' in absent.stderr


def test_what_is_recovered_is_checked_and_replayed(tmp_path: Path) -> None:
    bag = torn(tmp_path / 'bag')
    assert tauto('bag', 'recover', bag, '--out', GOLDEN).exit_code == 2
    made = tauto('bag', 'recover', bag, '--out', tmp_path / 'new', '--json')
    assert made.exit_code == 0, made.stderr
    told = json.loads(made.stdout)
    assert told['recovered'] == str(tmp_path / 'new')
    assert any('was cut at byte 90000' in lost for lost in told['lost'])
    checked = tauto('bag', 'check', tmp_path / 'new', '--json')
    assert checked.exit_code == 1
    found = json.loads(checked.stdout)
    assert (found['damage'], found['faults'], found['cut_short']) == ([], [], True)
    assert found['topics'] == told['topics']
    assert tauto('replay', tmp_path / 'new', '--json').exit_code == 0
    again = tauto('bag', 'recover', bag)
    assert again.stdout.endswith(' s\n')
    assert (tmp_path / 'bag_recovered').is_dir()
