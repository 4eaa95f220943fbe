"""A panel on the terminal while a graph sails: swing, roll, error, messages, nodes.

It is drawn from the data of the supervisor, which is not a node: the recorder's report, the
processes and their output. It sends no request to the graph.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from tauto_core.cli.terminal import is_quiet, progress_bar
from tauto_core.machines.compiling import compile_machine
from tauto_core.scene import Scene
from tauto_core.voyage import compile_kernels
from tauto_core.wording import counted, printed, span, with_sigma
from tauto_nodes.graph import NODE_NAMES, UNDER_WAY, Standing

REDRAW_S = 0.5
"""Interval at which the panel is drawn [s]: a shorter one would cost more than 1 % of a core."""

_NONE = '–'


def rows_of(standing: Standing, scene: Scene, frequency: float) -> list[tuple[str, Text]]:
    """Return the rows of the panel: a name and a line each.

    Args:
        standing: how the voyage stands.
        scene: the scene that sails.
        frequency: angular frequency of small swings [rad/s], for the amplitude.
    """
    said = standing.said
    newest = {} if said is None else said.newest
    rows = [
        ('swing', _swing(newest, frequency, is_wheel=scene.regulator is None)),
        ('roll', _degrees(newest.get('roll_rad'))),
        ('dial', _error(newest.get('dial_error_s'), None)),
        ('drift', _error(newest.get('offset_s'), newest.get('offset_sigma_s'))),
    ]
    if 'corrected_nmi' in newest:
        miles = printed(newest['corrected_nmi'], '+z.2f')
        rows.append(('longitude', f'{miles} nmi by the corrected clock'))
    topics = {} if said is None else said.topics
    lost = sum(each['lost'] for each in topics.values())
    received = sum(each['received'] for each in topics.values())
    rows.append(('messages', f'{received:,} recorded, {lost:,} lost'))
    lines = [(name, Text(line)) for name, line in rows]
    if lost:
        lines[-1][1].stylize('bold red')
    for name, how in standing.nodes.items():
        bad = 'bold red' if how.startswith('ended') else 'yellow'
        style = 'green' if how == UNDER_WAY else bad
        lines.append((name, Text(how, style)))
    if standing.complaints:
        words = f'{counted(len(standing.complaints), "complaint")}: {standing.complaints[-1]}'
        lines.append(('', Text(words, 'yellow')))
    return lines


def _swing(newest: dict[str, float], frequency: float, *, is_wheel: bool) -> str:
    if 'angle' not in newest:
        return _NONE
    angle = newest['angle']
    size = math.hypot(angle, newest['speed'] / frequency)
    words = [_degrees(angle) if is_wheel else f'{printed(angle, "+z.4f")} m']
    if 'phase' in newest:
        words.append(f'phase {math.degrees(newest["phase"]) % 360.0:.0f}°')
    width = f'{math.degrees(size):.1f}°' if is_wheel else f'{size:.4f} m'
    words.append(f'amplitude about {width}')
    if 'beats' in newest:
        words.append(f'beat {newest["beats"]:,.0f}')
    return ', '.join(words)


def _degrees(angle: float | None) -> str:
    return _NONE if angle is None else f'{printed(math.degrees(angle), "+z.2f")}°'


def _error(seconds: float | None, sigma: float | None) -> str:
    if seconds is None:
        return _NONE
    return f'{with_sigma(seconds, sigma)} s' if sigma else f'{printed(seconds, "+z.3f")} s'


def drawn(standing: Standing, scene: Scene, frequency: float) -> Group:
    """Return the panel as rich draws it, a line each row, cut at the width of the terminal."""
    began_s = scene.starts_at
    newest = {} if standing.said is None else standing.said.newest
    sailed_s = max(newest.get('stamp_s', began_s) - began_s, 0.0)
    head = f'{scene.name}: {span(sailed_s)} of {span(scene.duration)} at sea'
    bar = Table.grid(expand=True)  # which ends the line, as a bar alone does not
    bar.add_row(ProgressBar(total=1.0, completed=standing.share))
    grid = Table.grid(padding=(0, 2))
    grid.add_column(no_wrap=True, style='bold', min_width=max(map(len, NODE_NAMES)))
    grid.add_column(no_wrap=True, overflow='ellipsis', ratio=1)
    for name, line in rows_of(standing, scene, frequency):
        grid.add_row(name, line)
    title = Text(head, 'bold', no_wrap=True, overflow='ellipsis')
    return Group(title, bar, grid)


@contextmanager
def watching(scene: Scene) -> Iterator[Callable[[Standing], None]]:
    """Show the panel on stderr, if that is a terminal, for as long as the context lasts.

    First the kernels of the scene are compiled: once, and not in each node. It yields the function
    to call with how the voyage stands. The panel goes when the voyage is over, and stays where it
    fails, so that one sees which node ended. A terminal that cannot move its cursor gets what
    `progress_bar` makes of it.
    """
    with progress_bar(scene.name):
        compile_kernels(scene)
    console = Console(stderr=True)
    if not console.is_terminal or console.is_dumb_terminal or is_quiet():
        with progress_bar(scene.name) as progress:
            yield lambda standing: progress(standing.share)
        return
    frequency = float(compile_machine(scene).frequency)
    drawn_s, nodes = 0.0, dict[str, str]()
    with Live(console=console, auto_refresh=False, transient=True, redirect_stdout=False) as live:

        def tell(standing: Standing) -> None:
            nonlocal drawn_s, nodes
            now_s = time.monotonic()
            if now_s >= drawn_s + REDRAW_S or standing.nodes != nodes:
                drawn_s, nodes = now_s, dict(standing.nodes)
                live.update(drawn(standing, scene, frequency), refresh=True)

        try:
            yield tell
        except BaseException:
            live.transient = False
            raise
