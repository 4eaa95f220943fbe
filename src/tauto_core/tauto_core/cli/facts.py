"""`tauto scenes` and `tauto scene check`: what ships, and what a scene would run."""

from __future__ import annotations

import math
from importlib.resources import files
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.table import Table


def shipped_summary(name: str) -> str:
    """Return what a shipped scene is: the comment at its top, up to the first colon."""
    text = (files('tauto_core.scene') / 'shipped' / f'{name}.yaml').read_text(encoding='utf-8')
    lines = []
    for line in text.splitlines():
        if not line.startswith('#'):
            break
        lines.append(line.lstrip('# '))
    return ' '.join(lines).partition(':')[0]


def scene_facts(name_or_path: str) -> dict[str, Any]:
    """Return what a scene would run, after every check that `tauto sail` makes before it starts.

    Args:
        name_or_path: a shipped name or a YAML file.

    Raises:
        SceneError: the scene cannot be run.
        MotionDataError: its measured motion cannot be used.
    """
    from tauto_core.machines import compile_machine
    from tauto_core.scene import load_scene
    from tauto_core.scene.errors import naming
    from tauto_core.ship import ShipMotion
    from tauto_core.summary import scene_propagator
    from tauto_core.voyage import check_scene

    scene = load_scene(name_or_path)
    with naming(name_or_path, scene.name):
        check_scene(scene)
    machine = compile_machine(scene)
    edge = machine.cam.range_rad
    motion = ShipMotion(scene)
    return {
        'scene': scene.name,
        'duration_s': scene.duration,
        'propagator': scene_propagator(scene),
        'ship': scene.ship.kind,
        'motion_samples': motion.total,
        'motion_step_s': scene.step_ns * 1e-9,
        'motion_kept': scene.keeps_motion,
        'logged_samples': scene.log_count,
        'log_interval_s': scene.log_interval_ns * 1e-9,
        'small_period_s': machine.small_period,
        'nominal_period_s': scene.clock.nominal_period or machine.small_period,
        'cam': scene.trochlea.cam.kind,
        'cam_range_rad': None if math.isinf(edge) else edge,
        'release_angle_rad': machine.release_angle,
        **({'warnings': list(motion.warnings)} if motion.warnings else {}),
    }


def facts_table(facts: dict[str, Any]) -> Table:
    """Return the facts of a scene as a table."""
    from rich.table import Table

    from tauto_core.cli.tables import span

    edge = facts['cam_range_rad']
    kept = 'kept' if facts['motion_kept'] else 'not kept'
    table = Table(title=f'{facts["scene"]}: can sail', title_justify='left', show_header=False)
    table.add_row('duration', span(facts['duration_s']))
    table.add_row('propagator', facts['propagator'])
    table.add_row(
        'ship',
        f'{facts["ship"]}: {facts["motion_samples"]:,} samples, '
        f'one every {facts["motion_step_s"]:g} s, {kept} in the bag',
    )
    table.add_row(
        'log', f'{facts["logged_samples"]:,} samples, one every {facts["log_interval_s"]:g} s'
    )
    table.add_row('period of small swings', f'{facts["small_period_s"]:.9f} s')
    table.add_row('nominal period', f'{facts["nominal_period_s"]:.9f} s')
    table.add_row('cam', f'{facts["cam"]}, ' + ('no end' if edge is None else f'±{edge:.6g} rad'))
    table.add_row('released at', f'{facts["release_angle_rad"]:g} rad in the case')
    return table
