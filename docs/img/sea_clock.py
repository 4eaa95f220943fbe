"""Draw the pictures of the README: python docs/img/sea_clock.py writes sea_clock*.svg beside it.

Left, the machine. In the middle, on land: rate against amplitude, of the circular cheek and of
Euler's cam, both under the same weight without inertia. Right, at sea: the error of three clocks
in the same sea, each regulated on land at the swing it starts with.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import tauto_core as tauto
from tauto_core.plots.chart import Chart, draw_on
from tauto_core.plots.contents import thinned
from tauto_core.plots.machine import draw_machine
from tauto_core.scene import Scene

SEA = 'involute_weight_at_sea'
WEIGHT = {'kind': 'weight', 'mass': 0.322}
CHEEK = {'kind': 'circular_arc', 'radius': 0.02, 'root_depth': 0.0028}
COLOURS = ('#a07a6c', '#e0701a', '#2e8fce')
INKS = {'': '#1b1b1b', '_dark': '#ededed'}
NEAREST_RAD, WIDEST_RAD = 0.7, 1.3


def clock(cam: dict[str, Any] | None = None, **changes: object) -> Scene:
    """Return the machine of the sea scene with parts exchanged, regulated on land at 1 rad."""
    trochlea = tauto.load(SEA).trochlea.model_dump() | ({'cam': cam} if cam else {}) | changes
    (period,) = tauto.isochronism(SEA, [1.0], trochlea=trochlea).period_s.tolist()
    return tauto.load(SEA, trochlea=trochlea, clock={'nominal_period': period}, duration=1800.0)


def on_land(axes: Axes) -> None:
    """Draw rate against amplitude; a weight without inertia shows what the cam alone does."""
    light = {'power': {**WEIGHT, 'massless': True}}
    amplitudes = np.linspace(NEAREST_RAD, WIDEST_RAD, 25)
    for label, cam, colour in (
        ('circular cheek', CHEEK, COLOURS[0]),
        ("Euler's cam", None, COLOURS[1]),
    ):
        found = tauto.isochronism(clock(cam, **light), amplitudes)
        axes.plot(amplitudes, found.rate_s_per_day, color=colour, linewidth=1.8, label=label)
    axes.set(xlabel='amplitude [rad]', ylabel='rate [s/day]', title='On land: what Euler gained')
    axes.legend(frameon=False)


def at_sea(axes: Axes) -> None:
    """Draw the error of three clocks in the same sea."""
    second = tauto.load('second_cam_at_sea').trochlea.model_dump()
    clocks = {
        'weight, circular cheek': clock(CHEEK),
        "weight, Euler's involute": clock(),
        "force, Euler's second cam": clock(**second),
    }
    for (label, scene), colour in zip(clocks.items(), COLOURS, strict=True):
        voyage = tauto.sail(scene)
        error = voyage.clock_error_s
        minutes, shown = thinned(voyage.time_s / 60.0, error, 500)
        axes.plot(minutes, shown, color=colour, linewidth=1.4, label=label)
        print(f'{label}: {error[-1]:+.6f} s, largest {np.abs(error).max():.6f} s')
    axes.set(
        xlabel='time at sea [minutes]',
        ylabel='error [s], fast is positive',
        title='At sea: a weight and a force',
    )
    axes.legend(frameon=False)


def main() -> None:
    """Draw, once on white and once on black."""
    for name, ink in INKS.items():
        colours = dict.fromkeys(
            ('text.color', 'axes.labelcolor', 'axes.edgecolor', 'xtick.color', 'ytick.color'), ink
        )
        with mpl.rc_context({'svg.hashsalt': 'tauto', 'font.size': 11.0, **colours}):
            figure = Figure(figsize=(11.0, 4.2), layout='constrained')
            machine, land, sea = figure.subplots(1, 3, width_ratios=(0.8, 1.0, 1.2))
            lines = draw_machine(tauto.load(SEA)).parts
            draw_on(machine, Chart('', 'mm', '', lines, equal=True))
            machine.set(title='The machine', yticks=[])
            machine.spines[:].set_visible(False)
            machine.legend(
                frameon=False,
                fontsize=9.0,
                loc='upper center',
                bbox_to_anchor=(0.5, -0.13),
                ncols=3,
            )
            machine.set_aspect('equal', adjustable='box')
            machine.set(xlim=(-76.0, 76.0), ylim=(-156.0, 76.0))
            on_land(land)
            at_sea(sea)
            for axes in (land, sea):
                axes.spines[['top', 'right']].set_visible(False)
                axes.axhline(0.0, color='#888888', linewidth=0.6, zorder=0)
            file = Path(__file__).with_name(f'sea_clock{name}.svg')
            figure.savefig(file, metadata={'Date': None}, transparent=True)


if __name__ == '__main__':
    main()
