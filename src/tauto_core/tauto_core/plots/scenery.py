"""Map, ship and dials of a voyage as SVG, for the page of a voyage and the moving picture.

Each function returns a fragment. Colours are CSS variables (`--land`, `--ink`, `--blue`, …), so a
page or a picture chooses them for light and dark. What moves has an id or a class.
"""

from __future__ import annotations

import math
from html import escape

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.plots.chart import Chart
from tauto_core.samples import FloatArray
from tauto_core.ship.coast import MapFrame, land

INK = {
    'light': {
        'ink': '#1b1b1b',
        'soft': '#595959',
        'paper': '#ffffff',
        'rule': '#d0d0d0',
        'land': '#e4dfd3',
        'sea': '#eaf2f7',
        'water': '#b9d6e6',
        'blue': '#0072b2',
        'orange': '#c05200',
        'green': '#00785a',
        'grey': '#767676',
        'wood': '#8a6a48',
        'sail': '#f6f1e4',
    },
    'dark': {
        'ink': '#ededed',
        'soft': '#b4b4b4',
        'paper': '#141414',
        'rule': '#444444',
        'land': '#3a382f',
        'sea': '#17222a',
        'water': '#25475a',
        'blue': '#56b4e9',
        'orange': '#e69f00',
        'green': '#2fcf9f',
        'grey': '#9a9a9a',
        'wood': '#a98760',
        'sail': '#cfc9b8',
    },
}
"""Colours of a picture on white and on black paper; the palette of Okabe and Ito."""


def variables(scheme: str) -> str:
    """Return the colours as CSS variables."""
    return ' '.join(f'--{name}: {colour};' for name, colour in INK[scheme].items())


# -----------------------------------------------------------------------------
# The map

# Steps of land to a unit of the picture; coasts are whole numbers of them.
_FINE = 10.0


class MapView:
    """A map as a picture `width` units wide, as high as the frame of its chart asks for.

    Args:
        chart: one with `is_map`.
        width, ratio: width, and width over height.
    """

    def __init__(self, chart: Chart, width: float, ratio: float) -> None:
        self.chart = chart
        self.frame: MapFrame = chart.frame(ratio)
        self.width, self.height = width, width / ratio

    def place(self, longitude: ArrayLike, latitude: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return places [°] in units of the picture, y downwards."""
        west, south, east, north = self.frame
        x = (np.asarray(longitude) - west) / (east - west) * self.width
        y = (north - np.asarray(latitude)) / (north - south) * self.height
        return x, y

    def path(self, longitude: FloatArray, latitude: FloatArray) -> str:
        """Return a line as the data of a path, to a tenth of a unit."""
        x, y = self.place(longitude, latitude)
        points = [f'{a:.1f},{b:.1f}' for a, b in zip(x.tolist(), y.tolist(), strict=True)]
        kept = [point for k, point in enumerate(points) if k == 0 or point != points[k - 1]]
        return 'M' + ' '.join(kept)

    def ground(self) -> str:
        """Return sea, land, and lines of longitude and latitude with their degrees."""
        outlines = []
        for outline in land(self.frame):
            steps = np.round(_FINE * np.array(self.place(*outline))).astype(int)
            moves = np.diff(steps, axis=1)
            moves = moves[:, np.any(moves != 0, axis=0)]
            tail = ' '.join(f'{dx},{dy}' for dx, dy in moves.T.tolist())
            if tail:
                outlines.append(f'M{steps[0, 0]},{steps[1, 0]}l{tail}z')
        lines, words = [], []
        west, south, east, north = self.frame
        # the greatest of 1, 2, 5 or 10 times a power of ten that gives five lines or more
        most = max(east - west, north - south) / 5.0
        power = 10.0 ** math.floor(math.log10(most))
        round_steps = (each * power for each in (10.0, 5.0, 2.0, 1.0))
        step = next(each for each in round_steps if each <= most * 1.0001)
        for at in np.arange(math.ceil(west / step), math.floor(east / step) + 1) * step:
            x = float(self.place(at, south)[0])
            lines.append(f'M{x:.1f},0V{self.height:.1f}')
            words.append(_degrees(x + 4.0, self.height - 6.0, at, 'E', 'W'))
        for at in np.arange(math.ceil(south / step), math.floor(north / step) + 1) * step:
            y = float(self.place(west, at)[1])
            lines.append(f'M0,{y:.1f}H{self.width:.1f}')
            words.append(_degrees(6.0, y - 5.0, at, 'N', 'S'))
        box = f'width="{self.width:.1f}" height="{self.height:.1f}"'
        return (
            f'<rect {box} fill="var(--sea)"/>'
            f'<path d="{"".join(outlines)}" transform="scale({1.0 / _FINE})" fill="var(--land)" '
            'fill-rule="evenodd" stroke="var(--grey)" stroke-width="5"/>'
            f'<path d="{"".join(lines)}" stroke="var(--rule)" stroke-width="0.7" fill="none" '
            f'opacity="0.6"/><g class="degrees">{"".join(words)}</g>'
        )

    def tracks(self) -> str:
        """Return the lines of the chart: bands, then tracks."""
        drawn = []
        for line in self.chart.lines:
            data = self.path(line.x, line.y)
            if line.kind == 'band':
                drawn.append(f'<path class="band" d="{data}z" fill="var(--{line.colour})"/>')
            elif line.kind == 'line':
                drawn.append(
                    f'<path class="track {line.colour}" d="{data}" fill="none" '
                    f'stroke="var(--{line.colour})"/>'
                )
        return ''.join(drawn)

    def names(self) -> str:
        """Return the named places, each as a ring with its name on the side with more room."""
        drawn = []
        for name, longitude, latitude in self.chart.names:
            x, y = (float(each) for each in self.place(longitude, latitude))
            side, anchor = (-10.0, 'end') if x > 0.75 * self.width else (10.0, 'start')
            drawn.append(
                f'<circle class="place" cx="{x:.1f}" cy="{y:.1f}" r="5"/>'
                f'<text class="place-name" x="{x + side:.1f}" y="{y - 9.0:.1f}" '
                f'text-anchor="{anchor}">{escape(name)}</text>'
            )
        return ''.join(drawn)


def _degrees(x: float, y: float, at: float, plus: str, minus: str) -> str:
    turned = math.remainder(at, 360.0)
    side = plus if turned > 0.0 else minus if turned < 0.0 else ''
    return f'<text x="{x:.1f}" y="{y:.1f}">{abs(turned):.6g}° {side}</text>'


# -----------------------------------------------------------------------------
# The ship, seen from ahead, and the face of a clock

SHIP_WIDTH = 320.0
"""Width of the picture of the ship."""
SHIP_HEIGHT = 260.0
_CLOCK_AT = (160.0, 168.0)


def ship() -> str:
    """Return ship and sea, seen from ahead; `id` ship-hull turns and rises, water is redrawn.

    The hull is a midship section with wales and deck, a mast with two yards and sails, and the box
    of the clock amidships.
    """
    x, y = _CLOCK_AT
    hull = 'M108,152 C106,188 126,212 160,216 C194,212 214,188 212,152 L206,146 L114,146 Z'
    return (
        f'<rect width="{SHIP_WIDTH}" height="{SHIP_HEIGHT}" fill="var(--sea)"/>'
        '<path id="water-far" class="water" opacity="0.45"/>'
        '<g id="ship-hull">'
        '<path d="M160,146 V18" stroke="var(--wood)" stroke-width="5"/>'
        '<path d="M112,58 Q160,66 208,58 L202,96 Q160,106 118,96 Z" fill="var(--sail)" '
        'stroke="var(--soft)"/>'
        '<path d="M128,26 Q160,32 192,26 L188,52 Q160,59 132,52 Z" fill="var(--sail)" '
        'stroke="var(--soft)"/>'
        '<path d="M106,57 H214 M124,25 H196" stroke="var(--wood)" stroke-width="3.5"/>'
        '<path d="M160,24 L112,148 M160,24 L208,148" stroke="var(--soft)" stroke-width="0.8"/>'
        '<path d="M160,18 q12,-3 22,2 q-10,5 -22,4 Z" fill="var(--orange)"/>'
        f'<path d="{hull}" fill="var(--wood)" stroke="var(--ink)" stroke-width="1.5"/>'
        '<path d="M109,163 Q160,171 211,163 M112,178 Q160,187 208,178" fill="none" '
        'stroke="var(--ink)" stroke-width="0.8" opacity="0.6"/>'
        f'<circle cx="{x}" cy="{y}" r="12" fill="var(--paper)" stroke="var(--ink)" '
        'stroke-width="1.5"/>'
        f'<path d="M{x},{y} v-8 M{x},{y} h5" stroke="var(--blue)" stroke-width="2" '
        'stroke-linecap="round"/></g>'
        '<path id="water-near" class="water" opacity="0.8"/>'
    )


def dial(name: str, label: str, colour: str) -> str:
    """Return the face of a clock about (0, 0), of radius 46, with hands at noon.

    The hands are the groups `{name}-hour`, `{name}-minute` and `{name}-second`; they turn about
    the middle.
    """
    ticks = []
    for k in range(60):
        turn, inner = math.radians(6.0 * k), 38.0 if k % 5 == 0 else 41.5
        s, c = math.sin(turn), -math.cos(turn)
        ticks.append(f'M{inner * s:.1f},{inner * c:.1f}L{44.0 * s:.1f},{44.0 * c:.1f}')
    hands = ''.join(
        f'<g id="{name}-{hand}"><path d="M0,{tail}V{-length}" stroke="{stroke}" '
        f'stroke-width="{width}" stroke-linecap="round"/></g>'
        for hand, tail, length, width, stroke in (
            ('hour', 0, 22, 4.5, 'var(--ink)'),
            ('minute', 0, 34, 3.0, 'var(--ink)'),
            ('second', 8, 40, 1.2, f'var(--{colour})'),
        )
    )
    return (
        f'<circle r="46" fill="var(--paper)" stroke="var(--{colour})" stroke-width="3"/>'
        f'<path d="{"".join(ticks)}" stroke="var(--soft)" stroke-width="1" fill="none"/>'
        f'{hands}<circle r="3" fill="var(--ink)"/>'
        f'<text class="dial-label" y="62" text-anchor="middle">{escape(label)}</text>'
    )
