"""Draw the picture of the README: python docs/img/sea_clock.py writes sea_clock.svg beside it.

Left, the cheeks of three machines with the thread at rest. Right, how far their clocks go wrong
in the same sea; each dial is regulated on land, at the swing it starts with.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from tauto_core.bags import read_bag
from tauto_core.curves import outline
from tauto_core.machines import compile_machine
from tauto_core.samples import READING, FloatArray
from tauto_core.scene import Scene, load_scene
from tauto_core.voyage import sail

SEA = 'involute_weight_at_sea'
MACHINES = {
    'the cheek before Euler': ('cheek_before_euler', 1.3, '#8d6e63'),
    "Euler's involute, a weight": ('involute_weight_at_sea', 1.6, '#c0392b'),
    "Euler's second cam, a force": ('second_cam_at_sea', 1.6, '#1f618d'),
}


def at_sea(name: str) -> Scene:
    """Return the sea with the trochlea of a scene in it, regulated on land."""
    trochlea = load_scene(name).trochlea.model_dump(exclude_none=True)
    scene = load_scene(SEA, name=name, trochlea=trochlea)
    period = compile_machine(scene).period(scene.trochlea.release_angle)
    return load_scene(
        SEA, name=name, trochlea=trochlea, clock={'nominal_period': period}, duration=1800.0
    )


def clock_error(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Return time [min] and clock error [s] of a voyage."""
    with TemporaryDirectory() as folder:
        sail(scene, Path(folder) / 'bag')
        reading = read_bag(Path(folder) / 'bag').samples(READING)
    minutes = (reading.stamp_ns - reading.stamp_ns[0]) / 60e9
    return minutes, (reading.time_ref_ns - reading.stamp_ns) * 1e-9


def main() -> None:
    """Draw."""
    figure = Figure(figsize=(10.0, 3.6), layout='constrained')
    *cheeks, errors = figure.subplots(1, 4, width_ratios=(1.0, 1.0, 1.0, 2.6))
    for axes, (label, (name, reach, colour)) in zip(cheeks, MACHINES.items(), strict=True):
        scene = at_sea(name)
        x, y = outline(compile_machine(scene).cam, reach_rad=reach)
        axes.plot(1e3 * x, 1e3 * y, color=colour, linewidth=2.0)
        tip = 1e3 * y[len(y) // 2]
        axes.plot([0.0, 0.0], [tip, 29.0], color='0.6', linewidth=0.8)
        axes.plot(0.0, 0.0, 'o', color='0.2', markersize=4.0)
        axes.set(aspect='equal', xlim=(-16.0, 16.0), ylim=(29.0, -3.0), xlabel='mm')
        axes.set_title(label.replace(', ', ',\n'), fontsize=9.0, color=colour)
        axes.spines[:].set_visible(False)
        axes.set_yticks([])
        minutes, error = clock_error(scene)
        errors.plot(minutes, error, color=colour, linewidth=1.2, label=label)
        print(f'{label}: {error[-1]:+.6f} s, largest {np.abs(error).max():.6f} s')
    errors.set(xlabel='minutes at sea', ylabel='clock error, s (fast is positive)')
    errors.axhline(0.0, color='0.8', linewidth=0.6, zorder=0)
    errors.spines[['top', 'right']].set_visible(False)
    errors.legend(frameon=False, fontsize=8.0)
    with mpl.rc_context({'svg.hashsalt': 'tauto'}):
        figure.savefig(Path(__file__).with_suffix('.svg'), metadata={'Date': None})


if __name__ == '__main__':
    main()
