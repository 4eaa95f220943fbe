"""The committed bags: complete, and equal to the present output of their commands."""

import hashlib
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from tauto_core.bags import check_bag, read_bag
from tauto_core.cli import main
from tauto_core.samples import SCENE
from tauto_core.scene import parse_scene

BAGS = Path(__file__).resolve().parents[2] / 'bags'
ROW = re.compile(
    r'^\| `(\w+)` \| `tauto (.+) --out bags/\1` \| `([0-9a-f]{64})` \|$', re.MULTILINE
)
GOLDEN = {
    name: (command, digest)
    for name, command, digest in ROW.findall((BAGS / 'README.md').read_text())
}


def test_every_bag_is_listed():
    folders = {path.name for path in BAGS.iterdir() if path.is_dir() and path.name != 'out'}
    assert folders == set(GOLDEN)


@pytest.mark.parametrize('name', GOLDEN)
def test_a_golden_bag_is_what_its_command_gives(name, tmp_path, monkeypatch, capsys):
    """Other processors round the last bits of sines otherwise: 1e-9 leaves room for that alone."""
    command, digest = GOLDEN[name]
    [file] = (BAGS / name).glob('*.mcap')
    assert hashlib.sha256(file.read_bytes()).hexdigest() == digest
    monkeypatch.setattr(
        'sys.argv', ['tauto', *shlex.split(command), '--out', str(tmp_path / name)]
    )
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code in (0, None)
    capsys.readouterr()
    golden, again = read_bag(BAGS / name), read_bag(tmp_path / name)
    found = check_bag(BAGS / name)
    assert (found.damage, found.faults, found.notes, found.whole) == ([], [], [], True)
    assert golden.topics == again.topics
    assert golden.counts == again.counts
    # keys that came later have their defaults in the scene of a bag that is older
    assert parse_scene(golden.scene, 'golden') == parse_scene(again.scene, 'again')
    for topic in golden.topics.keys() - {f'/{SCENE}'}:
        old, new = golden.samples(topic), again.samples(topic)
        for field, value in vars(old).items():
            other = getattr(new, field)
            if isinstance(value, np.ndarray) and value.dtype == float:
                np.testing.assert_allclose(other, value, rtol=1e-9, atol=1e-9, err_msg=topic)
            elif field == 'time_ref_ns':
                np.testing.assert_allclose(other, value, rtol=0, atol=2)
            else:
                np.testing.assert_array_equal(other, value, err_msg=topic)
