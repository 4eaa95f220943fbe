"""The commands from the command line: stdout, stderr and exit codes."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import invoke, refused

from tauto_core import voyage
from tauto_core.cli.shown import shipped_summary
from tauto_core.scene import load_scene, shipped_scenes

SLOW_MODULES = ('numpy', 'scipy', 'llvmlite', 'rosbags', 'mcap', 'matplotlib', 'rclpy')
BAGS = Path(__file__).parents[2] / 'bags'
MINUTE = ('sail', 'cheek_before_euler', '--duration', '60')
OFF_THE_CAM = """\
duration: 10.0
trochlea:
  inertia: 4.0e-4
  cam: {kind: circular_arc, radius: 0.020, root_depth: 0.010}
  thread: {kind: vertical}
  power: {kind: weight, mass: 0.3}
  release_angle: 3.1
ship: {kind: components, components: [{amplitude: 0.3, period: 9.0, phase: 0.0}], height: 0.0}
"""


def python(program: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, '-c', program]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def imported_by(*arguments: str) -> set[str]:
    """Return the modules that a command leaves imported in a fresh process."""
    program = (
        'import sys\n'
        'from tauto_core.cli import main\n'
        f'sys.argv = {["tauto", *arguments]!r}\n'
        'try:\n    main()\nexcept SystemExit as end:\n    assert not end.code, end.code\n'
        'print("\\n" + " ".join(sys.modules))'
    )
    run = python(program)
    assert run.returncode == 0, run.stderr
    return set(run.stdout.splitlines()[-1].split())


@pytest.mark.parametrize('arguments', [('--help',), ('sail', '--help'), ('graph', '--help')])
def test_help_of_core_imports_nothing_slow(arguments: tuple[str, ...]) -> None:
    if arguments[0] == 'graph':
        pytest.importorskip('tauto_nodes', reason='the nodes are not installed')
    slow = SLOW_MODULES if arguments[0] != 'graph' else ('rclpy', 'llvmlite')
    slow = (*slow, 'pydantic') if arguments == ('--help',) else slow
    assert not imported_by(*arguments) & set(slow)


@pytest.mark.parametrize(
    'arguments', [('cam', 'ideal'), ('isochronism', 'measured', '--amplitudes', '0.1,1')]
)
def test_what_needs_no_kernel_imports_no_compiler(arguments: tuple[str, ...]) -> None:
    slow = {*SLOW_MODULES[1:], 'pandas', 'hypothesis', 'mpmath'}
    assert not imported_by(*arguments) & slow


def test_scenes_lists_each_shipped_scene_with_what_it_is() -> None:
    lines = invoke('scenes').stdout.splitlines()
    assert [line.split()[0] for line in lines] == shipped_scenes()
    summaries = {name: shipped_summary(name) for name in shipped_scenes()}
    assert json.loads(invoke('scenes', '--json').stdout)['scenes'] == summaries
    assert min(map(len, summaries.values())) > 10


def test_lists_fit_a_terminal_of_80_columns() -> None:
    assert max(map(len, invoke('scenes').stdout.splitlines())) <= 80
    for words in (('--help',), ('scene', '--help'), ('bag', '--help')):
        said = invoke(*words).stdout
        assert 'Commands:' in said
        assert '...' not in said.partition('Commands:')[2], said


@pytest.mark.parametrize('arguments', [('nonsense',), ('sail',), ('sail', 'ideal', '--nonsense')])
def test_a_bad_command_line_exits_2(arguments: tuple[str, ...]) -> None:
    assert 'Usage' in refused(*arguments)


def test_an_unexpected_exception_keeps_its_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    def fault(*_: object, **__: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(voyage, 'sail', fault)
    assert isinstance(invoke(*MINUTE).exception, ZeroDivisionError)


@pytest.mark.parametrize(('number', 'replaces'), [(signal.SIGINT, False), (signal.SIGTERM, True)])
def test_a_voyage_that_is_stopped_keeps_a_readable_bag(
    tmp_path: Path, number: signal.Signals, replaces: bool
) -> None:
    bag = tmp_path / 'bag'
    options = ['--force'] if replaces else []
    if replaces:
        voyage.sail(load_scene('ideal', duration=60.0), bag)
    program = (
        'import os, signal, sys\n'
        # a shell that starts the tests in the background lets them ignore SIGINT
        'signal.signal(signal.SIGINT, signal.default_int_handler)\n'
        'from tauto_core import voyage\n'
        'from tauto_core.cli import main\n'
        'feed = voyage.Pipeline.feed\n'
        'def once(self, batches):\n'
        '    said = feed(self, batches)\n'
        '    voyage.Pipeline.feed = stopped\n'
        '    return said\n'
        'def stopped(self, batches):\n'
        f'    os.kill(os.getpid(), {int(number)})\n'
        '    return feed(self, batches)\n'
        'voyage.Pipeline.feed = once\n'
        'voyage.CHUNK = 200\n'
        f'sys.argv = ["tauto", *{MINUTE!r}, "--out", {str(bag)!r}, *{options}]\n'
        'sys.argv += ["--set", "ship.rate=20.0"]\n'
        'main()\n'
    )
    run = python(program)
    assert run.returncode == 128 + number, run.stderr
    assert 'Traceback' not in run.stderr
    held = tmp_path / 'bag.partial' if replaces else bag
    assert f'tauto: {held} holds the part that was written' in run.stderr
    replayed = json.loads(invoke('replay', held, '--json').stdout)
    # the first 200 of 1205 samples, 10 s, less what interpolation awaits
    assert 5 <= replayed['counts']['/clock/reading'] <= 10
    # no damage, not even of the metadata
    assert replayed['warnings'] == [
        f'{held}: it says cut_short: its recording ended before the voyage did'
    ]


def test_an_interrupt_while_it_starts_ends_without_a_traceback() -> None:
    program = (
        'import os, signal, sys\n'
        'class Interrupt:\n'
        '    def find_spec(self, name, path=None, target=None):\n'
        '        if name == "typer":\n'
        '            os.kill(os.getpid(), signal.SIGINT)\n'
        'sys.meta_path.insert(0, Interrupt())\n'
        'signal.signal(signal.SIGINT, signal.default_int_handler)\n'
        'from tauto_core.cli import main\n'
        'main()\n'
    )
    run = python(program)
    assert run.returncode == -signal.SIGINT
    assert run.stdout == run.stderr == ''


def test_an_interrupt_lost_in_a_callback_ends_a_command() -> None:
    program = (
        'import os, signal, sys, time, weakref\n'
        'from tauto_core.cli import main\n'
        'from tauto_core.cli import shown\n'
        'signal.signal(signal.SIGINT, signal.default_int_handler)\n'
        'class Lock:\n    pass\n'
        'def lose(_):\n    os.kill(os.getpid(), signal.SIGINT)\n'
        'def summary(name):\n'
        '    lock = Lock()\n'
        '    kept = weakref.ref(lock, lose)\n'
        '    del lock\n'
        '    time.sleep(60.0)\n'
        'shown.shipped_summary = summary\n'
        'sys.argv = ["tauto", "scenes"]\n'
        'main()\n'
    )
    run = python(program)
    assert (run.returncode, run.stderr) == (128 + signal.SIGINT, 'tauto: interrupted\n')


def test_errors_after_loading_name_the_file(tmp_path: Path) -> None:
    scene = tmp_path / 'mine.yaml'
    text = OFF_THE_CAM.replace('weight, mass', 'force, force').replace('3.1', '3.2')
    scene.write_text(f'name: other\n{text}')
    for command in (('sail',), ('scene', 'check'), ('isochronism', '--amplitudes', '1')):
        said = refused(*command, scene)
        assert said.startswith(f'tauto: {scene}: trochlea.release_angle = 3.2')


def test_measured_motion_that_breaks_off_is_reported(tmp_path: Path) -> None:
    whole = (BAGS / 'measured_2min' / 'measured_2min_0.mcap').read_bytes()
    (tmp_path / 'cut.mcap').write_bytes(whole[: len(whole) // 2])
    recorded = '{path: cut.mcap, topic: ship/imu}'
    scene = tmp_path / 'mine.yaml'
    head = OFF_THE_CAM.replace('3.1', '1.0').partition('ship:')[0]
    scene.write_text(f'{head}ship: {{kind: recorded, recorded: {recorded}}}\n')
    result = invoke('scene', 'check', scene, '--json')
    assert result.exit_code == 0, result.stderr
    (warning,) = json.loads(result.stdout)['warnings']
    assert 'cut.mcap' in warning
    assert 'it has no end' in warning
    assert warning in result.stderr


def test_the_version_and_the_short_help() -> None:
    from tauto_core.version import code, version

    assert invoke('--version').stdout == f'tauto {version()} (code {code()})\n'
    for words in (('-h',), ('sail', '-h'), ('scene', 'check', '-h')):
        assert invoke(*words).stdout.startswith('Usage: ')


def test_quiet_keeps_warnings_to_itself_wherever_it_stands(tmp_path: Path) -> None:
    scene = tmp_path / 'slip.yaml'
    text = OFF_THE_CAM.replace('0.020', '0.2').replace('release_angle: 3.1', 'release_angle: 0.5')
    scene.write_text(text.replace('mass: 0.3', 'mass: 60.0'), encoding='utf-8')
    words = ['sail', str(scene), '--anyway', '--duration', '20']
    assert 'trochlea.power.mass = 60' in invoke(*words).stderr
    quiet = invoke(*words[:4], '--quiet', *words[4:])
    assert quiet.exit_code == 0
    assert quiet.stderr == ''
    assert quiet.stdout.startswith('slip: 20 seconds')
    assert 'no_such_bag' in invoke('replay', 'no_such_bag', '-q').stderr


def test_null_removes_a_key_that_may_be_absent() -> None:
    scene = load_scene('cheek_before_euler')
    assert scene.escapement is not None
    bare = json.loads(invoke(*MINUTE, '--set', 'escapement=null', '--json').stdout)
    without = scene.model_copy(update={'escapement': None, 'duration': 60.0})
    assert bare['trochlea'] == voyage.sail(without).result['trochlea']
    # absent already, and absent by default
    for key in ('suspension', 'drift.gate'):
        assert invoke(*MINUTE, '--set', f'{key}=null').exit_code == 0


@pytest.mark.parametrize(
    ('setting', 'words'),
    [
        ('seed', 'has no KEY='),
        ('=3', 'has no KEY='),
        ('seed=', 'has no value'),
        ("seed=''", 'must be a whole number'),
        ('duration=5', 'duration is given twice'),
        ('trochlea.cam=null', 'trochlea.cam: is missing'),
        ('trochlea.cam.base_radiu=~', 'trochlea.cam.base_radiu: is not a key of'),
        ('voyage.departure=[50.8', "'voyage.departure=[50.8, -1.1]'"),
        ('trochlea.release_angle=0,3', 'Write 0.3.'),
    ],
)
def test_a_wrong_setting_is_refused_before_the_start(
    setting: str, words: str, tmp_path: Path
) -> None:
    assert words in refused(*MINUTE, '--set', setting, '--out', tmp_path / 'bag')
    assert not (tmp_path / 'bag').exists()


def test_a_bag_was_sailed_already() -> None:
    said = refused('plot', BAGS / 'cheek_1min', 'error', '--set', 'seed=2')
    assert 'seed: applies to a scene, not to a bag' in said
