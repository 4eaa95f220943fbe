"""What others build on, held against golden files: `tests/outside/`.

Public names, the JSON of every command, topics, the folder of a fleet, and the arrays of a voyage.
(The schema of scenes has a test of its own.) Whatever else the packages hold may change.

A change that is meant is written anew, and told in the CHANGELOG:

    python -m tests.test_outside
"""

from __future__ import annotations

import inspect
import json
import math
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import tauto_core
from tauto_core.bags.table import TOPICS
from tauto_core.cli.app import app

GOLDEN = Path(__file__).parent / 'outside'
BAGS = Path(__file__).parents[1] / 'bags'
COMMANDS: dict[str, tuple[str, ...]] = {
    'sail': ('sail', 'measured', '--duration', '60'),
    'sail_voyage': ('sail', 'clock_second_cam_force', '--duration', '3600'),
    'sail_fluid': ('sail', 'globe_in_oil', '--duration', '30'),
    'sail_hung': ('sail', 'hanging_thread_at_sea', '--duration', '60'),
    'replay': ('replay', str(BAGS / 'cheek_1min')),
    'scenes': ('scenes',),
    'isochronism': ('isochronism', 'cheek_before_euler', '--amplitudes', '0.2,0.6,1'),
    'axle': (
        *('axle', '--depth', '0.3', '--gyration-radius', '0.15', '--push-spin', '0.1'),
        *('--support', 'concave', '--support-radius', '0.12', '--duration', '0.2'),
    ),
    'altitudes': (
        *('altitudes', '--altitudes', '33.75,52.48,62.56'),
        *('--times', '0,2 h,4 h', '--latitude', '47'),
    ),
    'isochronism_fluid': ('isochronism', 'globe_in_oil', '--amplitudes', '0.1,0.2'),
    'design': ('design', '--period', '1', '--inertia', '4e-4', '--pull', '2.9'),
    'cam': ('cam', 'measured'),
    'plate': ('plate', 'measured'),
    'hull': ('hull', '--shape', 'deptford'),
    'compare': (
        *('compare', 'ideal', 'cheek_before_euler', '--ship-of', 'ideal'),
        *('--duration', '120', '--jobs', '1'),
    ),
    'logbook': ('logbook', str(Path(__file__).parent / 'outside' / 'logbook.csv')),
    'budget': ('budget', 'involute_weight_at_sea', '--duration', '60', '--jobs', '1'),
    'fleet': ('fleet', 'measured', '--ships', '3', '--duration', '60', '--jobs', '1'),
    'euler': ('euler',),
    'scene_check': ('scene', 'check', 'measured'),
    'scene_check_refused': ('scene', 'check', 'ideal', '--set', 'ship.kind=submarine'),
    'bag_check': ('bag', 'check', str(BAGS / 'cheek_1min')),
}
# Times, places and versions differ from machine to machine, and so does a forecast of the time.
VOLATILE = {
    *('wall_s', 'run_s', 'takes', 'expected', 'version'),
    *('path', 'scene_path', 'bag', 'folder'),
}


def said(arguments: tuple[str, ...]) -> dict[str, Any]:
    """Return the JSON that a command prints, and its exit code."""
    result = CliRunner().invoke(app, [*arguments, '--json'])
    lines = result.stdout.strip()
    return {'exit_code': result.exit_code, 'json': steady(json.loads(lines)) if lines else None}


def steady(value: Any) -> Any:
    """Return a JSON value without what differs from machine to machine."""
    if isinstance(value, dict):
        return {key: steady(one) for key, one in value.items() if key not in VOLATILE}
    if isinstance(value, list):
        return [steady(one) for one in value]
    return value


def differences(new: Any, golden: Any, at: str = '') -> list[str]:
    """Return the differences of two values beyond 1e-6, since processors round differently."""
    if isinstance(new, dict) and isinstance(golden, dict):
        found = [f'{at}.{key}: only one has it' for key in new.keys() ^ golden.keys()]
        if not found and list(new) != list(golden):
            found = [f'{at}: another order of keys']
        for key in new.keys() & golden.keys():
            found += differences(new[key], golden[key], f'{at}.{key}')
        return found
    if isinstance(new, list) and isinstance(golden, list) and len(new) == len(golden):
        pairs = enumerate(zip(new, golden, strict=True))
        return [text for k, (a, b) in pairs for text in differences(a, b, f'{at}[{k}]')]
    if type(new) is type(golden) is float:
        same = math.isclose(new, golden, rel_tol=1e-6, abs_tol=1e-9)
    else:
        same = type(new) is type(golden) and new == golden
    return [] if same else [f'{at}: {new!r}, golden {golden!r}']


def names() -> dict[str, Any]:
    """Return the names of Python, command line and topics, and the arrays of a voyage."""
    from typer.main import get_command

    voyage = tauto_core.sail('ideal', duration=60.0)
    root = get_command(app)

    def options(command: Any) -> Any:
        if hasattr(command, 'commands'):
            return {name: options(one) for name, one in sorted(command.commands.items())}
        return sorted(option for one in command.params for option in one.opts)

    return {
        'tauto_core': {
            name: str(inspect.signature(public)) if inspect.isfunction(public) else ''
            for name in sorted(tauto_core.__all__)
            for public in [getattr(tauto_core, name)]
        },
        'commands': options(root),
        'topics': {name: repr(topic) for name, topic in sorted(TOPICS.items())},
        'samples': {
            name: {
                field: str(getattr(values, 'dtype', values))
                for field, values in vars(batch).items()
            }
            for name, batch in voyage.samples.items()
        },
    }


def fleet_folder(folder: Path) -> dict[str, Any]:
    """Return the files of a fleet's folder, and the columns of its rows."""
    from pyarrow import parquet

    arguments = ['fleet', 'measured', '--ships', '2', '--duration', '60', '--jobs', '1']
    assert CliRunner().invoke(app, [*arguments, '--out', str(folder)]).exit_code == 0
    table = parquet.read_table(folder / 'ships.parquet')
    return {
        'files': sorted(path.name for path in folder.iterdir()),
        'columns': {field.name: str(field.type) for field in table.schema},
    }


def golden(name: str) -> Any:
    return json.loads((GOLDEN / f'{name}.json').read_text())


@pytest.mark.parametrize('name', COMMANDS)
def test_json_of_each_command_is_the_golden_one(name: str) -> None:
    assert not differences(said(COMMANDS[name]), golden(name))


def test_public_names_are_the_golden_ones() -> None:
    assert not differences(names(), golden('names'))


def test_a_fleets_folder_has_the_golden_files_and_columns(tmp_path: Path) -> None:
    assert not differences(fleet_folder(tmp_path / 'fleet'), golden('fleet_folder'))


def test_every_command_with_json_has_a_golden_file() -> None:
    def with_json(options: Any, path: tuple[str, ...] = ()) -> set[str]:
        if isinstance(options, dict):
            parts = options.items()
            return {one for name, part in parts for one in with_json(part, (*path, name))}
        return {'_'.join(path)} if '--json' in options else set()

    # `graph` needs ROS and prints what `sail` does (tests/nodes). `bag recover` a damaged bag.
    assert with_json(golden('names')['commands']) <= {*COMMANDS, 'graph', 'bag_recover'}


if __name__ == '__main__':
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as place:
        found = {name: said(arguments) for name, arguments in COMMANDS.items()}
        found |= {'names': names(), 'fleet_folder': fleet_folder(Path(place) / 'fleet')}
    for stem, content in found.items():
        (GOLDEN / f'{stem}.json').write_text(json.dumps(content, indent=1) + '\n')
