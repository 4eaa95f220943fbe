"""Refusals of commands: key and value, limit, remedy, before anything is written.

Python calls say the same with the names of arguments (tests/core/test_api.py).
"""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import invoke

REFUSALS = {
    'sail no_such_scene': (
        'no_such_scene: | there is no such file or built-in scene. | Check its path and name. '
        '`tauto scenes` lists the built-in scenes.'
    ),
    'sail ideal --duration 0': (
        'ideal: duration = 0.0: | must be greater than 0.0 (duration is given, | Write `duration: '
        '…`'
    ),
    'sail ideal --set out=1': '--set out: | an argument of the command. | See its -h',
    'fleet ideal --set scene=1': '--set scene: | an argument of the command. | See its -h',
    'budget ideal --set anyway=1': '--set anyway: | an argument of the command. | See its -h',
    'cam ideal --set csv=1': '--set csv: | an argument of the command. | See its -h',
    'plot ideal error --set what=1': '--set what: | an argument of the command. | See its -h',
    'report ideal --set source=1': '--set source: | an argument of the command. | See its -h',
    'scene check ideal --set progress=1': (
        '--set progress: | an argument of the command. | See its -h'
    ),
    'fleet ideal --set no.such=false': "ideal: no = {'such': False}: | is not a key | Keys here",
    'isochronism globe_in_oil --amplitudes 0.7': (
        'amplitude 0.7 m: | must be > 0 and at most the arc of the cusp, 0.6536771821322 | Use a '
        'smaller one'
    ),
    'isochronism sully_lever_at_sea --amplitudes 3': (
        'amplitude 3.0 rad: | must be > 0 and within the range of the machine, | Use a smaller one'
    ),
    'design --gravity 0': '--gravity = 0.0: | must be > 0, from 1e-30 to 1e+30. | Check its unit',
    # their squares would overflow or vanish
    'design --period 1e-300 --inertia 1 --pull 1': (
        '--period = 1e-300: | must be > 0, from 1e-30 to 1e+30. | Check its unit'
    ),
    'design --disc-weight 1e30 --disc-radius 1e9 --period 1 --pull 1': (
        'inertia = 5.09858106488 | must be > 0, from 1e-30 to 1e+30. | Check its unit'
    ),
    'design --disc-is-base --disc-radius 1': (
        '--disc-is-base | makes the radius of the disc the base radius. | Leave out --disc-radius '
        'and --inertia'
    ),
    'cam ideal --points 1': (
        '--points = 1: | must be 2 to 1000000 on each cheek. | Leave it out for the default'
    ),
    'cam cheek_before_euler --reach 4': (
        '--reach = 4.0 rad: | must be > 0 and within the range of the cam, 3.141592653589793 rad. '
        '| Leave it out for the default'
    ),
    'cam globe_in_oil --reach 1': '--reach = 1.0 rad: | belongs to a cam | Leave it out',
    'cam ideal --dxf cam.dxf --thread -1': (
        '--thread = -1.0: | must be ≥ 0 mm. | Give the thickness of the thread, or leave it out'
    ),
    'cam ideal --dxf cam.dxf --thread 0.5 --reach 8': (
        '--thread = 0.5 mm: | beyond 7.99999993 rad the cheek | Draw up to there (--reach '
        '7.999992), or use a thinner thread'
    ),
    'sail jamaica': (
        'jamaica: | there is no such file or built-in scene. | Did you mean portsmouth_jamaica?'
    ),
    'compare ideal --ship-of nothing': (
        'nothing: | there is no such file or built-in scene. | Check its path and name. `tauto '
        'scenes` lists the built-in scenes.'
    ),
    'compare ideal measured': (
        'measured | does not make the passage of ideal: duration = 600.0 against 86400.0; '
        'ship.kind = recorded against still; only measured has ship.recorded; only measured has '
        'voyage; | take one passage for all with --ship-of ideal'
    ),
    'compare ideal --roll 5,1x': "--roll = '1x': | 'x' is not a known unit. | Units that fit: deg",
    'compare ideal --roll=-10': (
        '--roll -10: | must be between 0 and 45 degrees, twice the root mean square of the roll. '
        '| Write for example 0,10,20'
    ),
    'compare ideal --suspension with': (
        '--suspension with: | ideal has no suspension. | or use --suspension both'
    ),
    'compare ideal --plot nowhere/figure.png': (
        '--plot nowhere/figure.png: | there is no folder nowhere. | Make it first'
    ),
    'fleet ideal --ships 0 --out rows': (
        '--ships 0: | must be between 1 and 100,000. | Use for example 200'
    ),
    'fleet ideal --jobs 0 --out rows': '--jobs 0: | must be at least 1. | Use for example 2',
    'fleet ideal --vary none.yaml --out rows': (
        'none.yaml: | cannot be read: | Name a YAML file with --vary'
    ),
    'fleet ideal --plot a.gif --out rows': (
        '--plot a.gif: | must end in .svg, .png or .pdf. | Name another file'
    ),
    'hull': 'no hull is given. | Give --shape (one of sloop, | --mesh FILE, or --length',
    'hull --length 44': '--length: | needs --beam, --draught and --block. | Give all four',
    'hull --shape sloops': "shape = 'sloops': | must be one of sloop, | Did you mean sloop?",
    'hull --shape sloop --beam 8': (
        '--shape sloop: | fixes the proportions. | Leave out --mesh, --beam, --draught and '
        '--block, or --shape'
    ),
    'hull --mesh a.stl --length 8': (
        '--mesh a.stl: | has its own sizes. | Leave out --length, or --mesh'
    ),
    'hull --shape sloop --speed 9': (
        'speed = 9.0: | must be in [0, 4.24] m/s for a hull of 29.4 m | Sail slower, or a longer '
        'hull'
    ),
    'hull --shape sloop --length 440': (
        'length = 440.0: | must be in [2, 400] m. | did you mean 44?'
    ),
    'hull --shape sloop --roll-damping 8': (
        '--roll-damping = 8.0: | must lie in [0, 1). | Leave it out'
    ),
    'hull --shape sloop --roll-period 0': (
        '--roll-period = 0.0: | must be above 0 s. | Leave it out'
    ),
    'hull --shape sloop --out mine.txt': '--out mine.txt: | must end in .npz. | Name another file',
    'hull --shape sloop --out no/mine.npz': (
        '--out no/mine.npz: | there is no folder no. | Make it first'
    ),
    'scene new --cam involute --thread hole -o a.yaml': (
        '--cam involute and --thread hole: | do not go together. | or --thread vertical or lever '
        'or hanging'
    ),
}


@pytest.mark.parametrize('command', REFUSALS)
def test_refusals_name_key_and_value_the_limit_and_a_remedy(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    run = invoke(*command.split())
    assert run.exit_code == 2
    assert run.stdout == ''
    said = run.stderr.splitlines()[-1]  # `cam` first says how far it draws
    what, limit, remedy = REFUSALS[command].split(' | ')
    assert said.startswith(f'tauto: {what}')
    assert 0 < said.find(limit) < said.rfind(remedy)
    assert not any(tmp_path.iterdir())
