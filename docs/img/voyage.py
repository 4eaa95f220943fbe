"""Draw the moving picture of the README: python docs/img/voyage.py [BAG].

It sails portsmouth_jamaica, or reads a bag of it, and writes voyage.svg and voyage_dark.svg
beside this file: the ship in the storm with her machine, the dial at true noon, and the map, on
which the ship and the places where she is believed drift apart. The 76 days take six seconds; the
ship rolls at twice her speed, the wheel swings at its own. Where SVG does not move, the picture
shows the end.
"""

from __future__ import annotations

import math
import sys
from html import escape
from itertools import groupby
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

import tauto_core as tauto
from tauto_core.plots.chart import Chart
from tauto_core.plots.contents import chart, seaway, window
from tauto_core.plots.machine import draw_machine
from tauto_core.plots.page import SHIP_HEIGHT, SHIP_WIDTH, dial, ship, variables
from tauto_core.samples import FloatArray
from tauto_core.scene.times import DAY_S
from tauto_core.ship.coast import land
from tauto_core.wording import counted

LENGTH_S = 6.0
HELD = 0.12
"""Share of the loop for which the end is held."""
SPEED = 2.0
"""Speed at which the ship moves."""
WATER = 175.0
"""Height of still water in the picture of the ship, from above; she rolls about its middle."""
WAVE = 4.0
"""Units to a metre of heave."""
FRAMES = 48
WIDTH, HEIGHT = 800.0, 400.0
COUNTED = 16
"""Number of times at which days and miles are written."""
LENS = (268.0, 62.0, 50.0)
"""Place and radius of the magnified machine."""

STYLE = """
text { font: 22px system-ui, sans-serif; fill: var(--ink); }
.track { stroke-width: 4; stroke-linejoin: round; }
.band { opacity: .22; }
.place { fill: var(--paper); stroke: var(--ink); stroke-width: 2.5; }
.place-name { font-weight: 600; paint-order: stroke; stroke: var(--paper); stroke-width: 5px; }
.water { fill: var(--water); }
.miles { font-weight: 600; paint-order: stroke; stroke: var(--paper); stroke-width: 5px; }
"""


def animate(name: str, values: list[str], *, kind: str = '', more: str = '') -> str:
    """Return the animation of an attribute over the loop, at equal intervals.

    kind: that of a transformation. more: further attributes of the animation.
    """
    element = 'animateTransform' if kind else 'animate'
    typed = f' type="{kind}"' if kind else ''
    return (
        f'<{element} attributeName="{name}"{typed} dur="{LENGTH_S}s" repeatCount="indefinite" '
        f'values="{";".join(values)}" {more}/>'
    )


def days(values: FloatArray) -> FloatArray:
    """Return values of the voyage at each frame; the last is held."""
    at = np.minimum(np.linspace(0.0, 1.0 / (1.0 - HELD), FRAMES + 1), 1.0)
    found: FloatArray = np.interp(at, np.linspace(0.0, 1.0, len(values)), values)
    return found


def rolling(voyage: tauto.Voyage) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return times, roll [rad] and heave [m] of a piece of the storm that ends as it begins."""
    moved = seaway(voyage, window(voyage, None, None).from_s)
    step_s = float(moved.time_s[1] - moved.time_s[0])
    count = round(SPEED * LENGTH_S / step_s)
    state = np.array(
        [
            moved.roll_rad / np.std(moved.roll_rad),
            moved.heave_m / np.std(moved.heave_m),
            np.gradient(moved.roll_rad) / np.std(np.gradient(moved.roll_rad)),
            np.gradient(moved.heave_m) / np.std(np.gradient(moved.heave_m)),
        ]
    )
    gap = np.sum(np.square(state[:, count:] - state[:, :-count]), axis=0)
    # a piece in which she does move
    swept = np.array([np.ptp(moved.roll_rad[k : k + count]) for k in range(len(gap))])
    gap[swept < np.quantile(swept, 0.7)] = math.inf
    first = int(np.argmin(gap))
    shown = slice(first, first + count + 1)
    share = np.linspace(0.0, 1.0, count + 1)

    def closed(values: FloatArray) -> FloatArray:
        part = values[shown]
        found: FloatArray = part - share * (part[-1] - part[0])
        return found

    return share, closed(moved.roll_rad), closed(moved.heave_m)


def at_sea(voyage: tauto.Voyage) -> str:
    """Return the ship in the storm, and the machine in a lens beside her."""
    share, roll, heave = rolling(voyage)
    frames = np.linspace(0.0, 1.0, FRAMES + 1)
    moving = ship()
    turned, risen = np.degrees(np.interp(frames, share, roll)), np.interp(frames, share, heave)
    hull = animate(
        'transform',
        [f'{-turn:.2f} {0.5 * SHIP_WIDTH:g} {WATER:g}' for turn in turned.tolist()],
        kind='rotate',
    ) + animate(
        'transform',
        [f'0 {-WAVE * rise:.2f}' for rise in risen.tolist()],
        kind='translate',
        more='additive="sum"',
    )
    moving = moving.replace('<g id="ship-hull">', f'<g>{hull}', 1)
    x = np.linspace(0.0, SHIP_WIDTH, 25)
    for near, name in enumerate(('water-far', 'water-near')):
        shapes = []
        for now in frames.tolist():
            # a wave takes a loop for its way from one side to the other
            late = (x / SHIP_WIDTH - 0.5 - 0.3 * (1 - near)) % 1.0
            y = WATER + 14.0 * near - 6.0 - WAVE * np.interp((now - late) % 1.0, share, heave)
            points = [f'{a:.0f},{b:.1f}' for a, b in zip(x.tolist(), y.tolist(), strict=True)]
            shapes.append(f'M0,260L{" ".join(points)}L{SHIP_WIDTH:g},260Z')
        moving = moving.replace(
            f'<path id="{name}" class="water"', f'<path d="{shapes[0]}" class="water"', 1
        )
        before, _, after = moving.partition(f'<path d="{shapes[0]}" class="water"')
        opacity, _, after = after.partition('/>')
        moving = (
            f'{before}<path d="{shapes[0]}" class="water"{opacity}>'
            f'{animate("d", shapes)}</path>{after}'
        )
    return f'<svg width="{SHIP_WIDTH}" height="{SHIP_HEIGHT}">{moving}{lens(voyage)}</svg>'


def lens(voyage: tauto.Voyage) -> str:
    """Return the machine at rest in a lens, its wheel swinging."""
    x, y, radius = LENS
    drawn = draw_machine(voyage.scene)
    parts = [part for part in drawn.parts if part.name != 'case']
    low, high = min(part.y.min() for part in parts), max(part.y.max() for part in parts)
    size = 1.75 * radius / (high - low)
    middle = 0.5 * (low + high)
    groups: dict[bool, list[str]] = {True: [], False: []}
    for part in parts:
        every = slice(None, None, max(len(part.x) // 60, 1))
        points = ' '.join(
            f'{size * a:.1f},{-size * (b - middle):.1f}'
            for a, b in zip(part.x[every].tolist(), part.y[every].tolist(), strict=True)
        )
        area, colour = part.kind == 'area', f'var(--{part.colour})'
        groups[part.moves_with == 'wheel'].append(
            f'<poly{"gon" if area else "line"} points="{points}" stroke="{colour}" '
            f'fill="{colour if area else "none"}" fill-opacity="0.5"/>'
        )
    swing = np.degrees(
        np.cos(np.linspace(0.0, math.tau * round(LENGTH_S), 8 * round(LENGTH_S) + 1))
    )
    axle = size * middle
    wheel = animate(
        'transform', [f'{each:.1f} 0 {axle:.1f}' for each in swing.tolist()], kind='rotate'
    )
    return (
        f'<path d="M{x - radius},{y + 20} L168,160 L{x - 18},{y + radius - 4}" opacity="0.35" '
        f'fill="var(--paper)"/><circle cx="{x}" cy="{y}" r="{radius}" fill="var(--paper)" '
        f'stroke="var(--ink)" stroke-width="1.5"/><g transform="translate({x} {y})">'
        f'{"".join(groups[False])}<g>{wheel}{"".join(groups[True])}</g></g>'
    )


def noon(voyage: tauto.Voyage) -> str:
    """Return true noon, and what the dial shows then."""
    error_s = days(voyage.clock_error_s[:-2])
    late = dial('dial', '', 'blue')
    for hand, turn_s in (('hour', 43_200.0), ('minute', 3_600.0)):
        turned = [f'{360.0 * each / turn_s:.1f}' for each in error_s.tolist()]
        end = f'<g id="dial-{hand}" transform="rotate({turned[-1]})">'
        late = late.replace(
            f'<g id="dial-{hand}">', end + animate('transform', turned, kind='rotate')
        )
    shown = ''
    for x, face, words in ((88, dial('true', '', 'green'), 'true noon'), (232, late, 'the dial')):
        plain = face.replace('<g id="dial-second">', '<g display="none">').replace(
            '<g id="true-second">', '<g display="none">'
        )
        shown += f'<g transform="translate({x} 316)">{plain}</g>'
        shown += f'<text x="{x}" y="392" text-anchor="middle">{words}</text>'
    return shown


class MapView:
    """The map of a voyage as SVG, `width` units wide and `width / ratio` high."""

    def __init__(self, of: Chart, width: float, ratio: float) -> None:
        self.chart, self.frame = of, of.frame(ratio)
        self.width, self.height = width, width / ratio

    def place(self, longitude: ArrayLike, latitude: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return places [°] in units of the picture, y downwards."""
        west, south, east, north = self.frame
        x = (np.asarray(longitude) - west) / (east - west) * self.width
        return x, (north - np.asarray(latitude)) / (north - south) * self.height

    def path(self, longitude: FloatArray, latitude: FloatArray) -> str:
        """Return a line as path data, rounded to a tenth of a unit."""
        places = zip(*(part.tolist() for part in self.place(longitude, latitude)), strict=True)
        return 'M' + ' '.join(at for at, _ in groupby(f'{x:.1f},{y:.1f}' for x, y in places))

    def ground(self) -> str:
        """Return sea and land."""
        coast = ''.join(self.path(*outline) + 'z' for outline in land(self.frame))
        return (
            f'<rect width="{self.width:.1f}" height="{self.height:.1f}" fill="var(--sea)"/>'
            f'<path d="{coast}" fill="var(--land)" fill-rule="evenodd" stroke="var(--grey)" '
            'stroke-width="0.5"/>'
        )

    def names(self) -> str:
        """Return the named places as rings, with the names on the side with more room."""
        drawn = ''
        for name, longitude, latitude in self.chart.names:
            x, y = (float(value) for value in self.place(longitude, latitude))
            side, anchor = (-10.0, 'end') if x > 0.75 * self.width else (10.0, 'start')
            drawn += (
                f'<circle class="place" cx="{x:.1f}" cy="{y:.1f}" r="5"/>'
                f'<text class="place-name" x="{x + side:.1f}" y="{y - 9.0:.1f}" '
                f'text-anchor="{anchor}">{escape(name)}</text>'
            )
        return drawn


def at_map(voyage: tauto.Voyage) -> str:
    """Return the map with tracks that grow, and the miles between."""
    drawn = chart(voyage, 'map')
    view = MapView(drawn, WIDTH - SHIP_WIDTH, (WIDTH - SHIP_WIDTH) / HEIGHT)
    moving = ''
    for line in drawn.lines:
        if line.kind != 'line':
            continue
        x, y = view.place(line.x, line.y)
        run = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
        grown = [f'{1.0 - each / run[-1]:.4f}' for each in days(run).tolist()]
        moving += (
            f'<path class="track" d="{view.path(line.x, line.y)}" fill="none" pathLength="1" '
            f'stroke="var(--{line.colour})" stroke-dasharray="1">'
            f'{animate("stroke-dashoffset", grown)}</path>'
        )
        places = [
            f'{a:.1f} {b:.1f}' for a, b in zip(days(x).tolist(), days(y).tolist(), strict=True)
        ]
        moving += (
            f'<circle r="9" fill="var(--{line.colour})" stroke="var(--paper)" stroke-width="2" '
            f'transform="translate({places[-1]})">'
            f'{animate("transform", places, kind="translate")}</circle>'
        )
    time_s, miles = voyage.time_s, voyage.raw_longitude_error_nmi
    at = np.linspace(0.0, 1.0, COUNTED)
    words = ''
    for k, share in enumerate(at.tolist()):
        day, off = (
            float(days(each)[round(share * FRAMES)]) for each in (time_s / DAY_S, np.abs(miles))
        )
        seen = ['0'] * COUNTED
        seen[k] = '1'
        base = '1' if k == COUNTED - 1 else '0'
        shown = animate('opacity', seen, more='calcMode="discrete"')
        words += (
            f'<text class="miles" x="{WIDTH - SHIP_WIDTH - 12:g}" y="388" text-anchor="end" '
            f'opacity="{base}">day {day:.0f}: {counted(round(off), "mile")} off'
            f'{shown}</text>'
        )
    box = f'x="{SHIP_WIDTH:g}" width="{view.width:g}" height="{view.height:g}"'
    return f'<svg {box}>{view.ground()}{moving}{view.names()}{words}</svg>'


def picture(voyage: tauto.Voyage, scheme: str) -> str:
    """Return the moving picture on white or black paper."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img">'
        f'<title>Portsmouth to Jamaica: {voyage.answer}</title>'
        f'<style>:root {{ {variables(scheme)} }}{STYLE}</style>'
        f'<rect width="{WIDTH:g}" height="{HEIGHT:g}" fill="var(--paper)"/>'
        f'{at_sea(voyage)}{noon(voyage)}{at_map(voyage)}</svg>\n'
    )


if __name__ == '__main__':
    sailed = tauto.replay(sys.argv[1]) if len(sys.argv) > 1 else tauto.sail('portsmouth_jamaica')
    for suffix, scheme in (('', 'light'), ('_dark', 'dark')):
        file = Path(__file__).with_name(f'voyage{suffix}.svg')
        file.write_text(picture(sailed, scheme), encoding='utf-8')
