"""The stability of a clock as a figure."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tauto_core.figure_file import write_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FREQUENCY = {
    'allan': ('Allan', '#c1121f', 'o'),
    'modified': ('modified Allan', '#003f88', 's'),
    'hadamard': ('Hadamard', '#2a9d5c', '^'),
}
_TIME = {'time': ('time', '#7b2cbf', 'D')}


def draw(stability: Mapping[str, Any], title: str, path: Path) -> None:
    """Draw deviations against τ, with their confidence intervals; replaces the file.

    Args:
        stability: what `stability_of` returns.
        title: title of the figure.
        path: name of the file, ending in .svg, .png or .pdf.

    Raises:
        FigureError: the file cannot be written.
        UsageError: see `figure_file.check_plot`.
    """
    write_figure(lambda: stability_figure(stability, title), path)


def stability_figure(stability: Mapping[str, Any], title: str) -> Figure:
    """Return the figure: deviations of frequency on the left, of time on the right."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.6, 4.0), layout='constrained')
    left, right = figure.subplots(1, 2)
    _panel(left, stability['rows'], _FREQUENCY, 'deviation of relative frequency')
    _panel(right, stability['rows'], _TIME, 'time deviation [s]')
    left.legend(frameon=False)
    percent = 100.0 * stability['confidence']
    figure.suptitle(
        f'{title}: stability from {stability["samples"]:,} readings, bars hold {percent:g} %',
        fontsize=11.0,
    )
    return figure


def _panel(
    axes: Axes,
    rows: list[Mapping[str, Any]],
    kinds: Mapping[str, tuple[str, str, str]],
    label: str,
) -> None:
    taus = [row['tau_s'] for row in rows]
    for kind, (name, color, marker) in kinds.items():
        values = [row[kind] for row in rows]
        bars = (
            [row[kind] - row[f'{kind}_low'] for row in rows],
            [row[f'{kind}_high'] - row[kind] for row in rows],
        )
        axes.errorbar(
            taus,
            values,
            yerr=bars,
            color=color,
            marker=marker,
            markersize=4.5,
            capsize=2.5,
            linewidth=1.2,
            label=name,
        )
    axes.set_xscale('log')
    axes.set_yscale('log')
    axes.set_xlabel('averaging time τ [s]')
    axes.set_ylabel(label)
    axes.grid(color='#dddddd', linewidth=0.5)
    axes.set_axisbelow(True)
    for side in ('top', 'right'):
        axes.spines[side].set_visible(False)
