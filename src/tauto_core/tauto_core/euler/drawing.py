"""Drawings as SVG whose colours are those of the page, and that a control can exchange.

A drawing has units of length, y upwards; strokes and letters keep their size on the page. What a
line is decides its colour, by a class of the page's style sheet: `ink`, `curve`, `thread`,
`other`, `faint`, `heavy`, and `solid` for filled areas.
"""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.samples import FloatArray

Point = tuple[float, float] | FloatArray

WIDE = 400.0
"""Width of every drawing in units of its view box."""


class Drawing:
    """Lines, circles and letters over a rectangle.

    Args:
        left: smallest x that is shown, in the drawing's units.
        right: largest x.
        low: smallest y.
        high: largest y.
        wide: width on the page; below that of the page for a figure with few lines.
    """

    def __init__(
        self, left: float, right: float, low: float, high: float, wide: float = WIDE
    ) -> None:
        self._left, self._high = left, high
        self._scale = wide / (right - left)
        self.size = wide, (high - low) * self._scale
        self._parts: list[str] = []

    def line(self, *points: Point, look: str = 'ink', closed: bool = False) -> None:
        """Draw straight lines from point to point."""
        x, y = np.array(points, np.float64).T
        self.curve(x, y, look, closed=closed)

    def curve(
        self, x: ArrayLike, y: ArrayLike, look: str = 'ink', *, closed: bool = False
    ) -> None:
        """Draw a polyline through points, two arrays of one shape (n,)."""
        pairs = zip(*self._placed(x, y), strict=True)
        path = 'M' + 'L'.join(f'{_short(u)} {_short(v)}' for u, v in pairs)
        self._parts.append(f'<path class="{look}" d="{path}{"Z" if closed else ""}"/>')

    def circle(self, centre: Point, radius: float, look: str = 'ink') -> None:
        """Draw a circle."""
        (u,), (v,) = self._placed(centre[0], centre[1])
        self._parts.append(
            f'<circle class="{look}" cx="{_short(u)}" cy="{_short(v)}" '
            f'r="{_short(radius * self._scale)}"/>'
        )

    def arc(
        self, centre: Point, radius: float, begin: float, end: float, look: str = 'ink'
    ) -> None:
        """Draw an arc of a circle between two directions [rad], from x towards y."""
        turn = np.linspace(begin, end, 2 + int(abs(end - begin) / 0.1))
        self.curve(centre[0] + radius * np.cos(turn), centre[1] + radius * np.sin(turn), look)

    def letter(self, at: Point, text: str, right: float = 7.0, up: float = 6.0) -> None:
        """Mark a point and write its letter beside it, at an offset in units of the page."""
        (u,), (v,) = self._placed(at[0], at[1])
        self._parts.append(f'<circle class="dot" cx="{_short(u)}" cy="{_short(v)}" r="2.2"/>')
        self.note(at, text, right, up, look='letter')

    def note(
        self, at: Point, text: str, right: float = 0.0, up: float = 0.0, look: str = 'note'
    ) -> None:
        """Write beside a point."""
        (u,), (v,) = self._placed(at[0], at[1])
        self._parts.append(
            f'<text class="{look}" x="{_short(u + right)}" y="{_short(v - up)}">'
            f'{escape(text)}</text>'
        )

    @property
    def markup(self) -> str:
        """The content of the `svg` element."""
        return ''.join(self._parts)

    def _placed(self, x: ArrayLike, y: ArrayLike) -> tuple[FloatArray, FloatArray]:
        across = np.atleast_1d(np.asarray(x, np.float64))
        up = np.atleast_1d(np.asarray(y, np.float64))
        return (across - self._left) * self._scale, (self._high - up) * self._scale


def svg(drawing: Drawing, title: str) -> str:
    """Return a drawing as an `svg` element with its title."""
    wide, high = map(_short, drawing.size)
    return (
        f'<svg viewBox="0 0 {wide} {high}" width="{wide}" role="img" '
        f'aria-label="{escape(title)}">'
        f'{drawing.markup}</svg>'
    )


def turned(points: Iterable[ArrayLike], angle: float) -> tuple[FloatArray, FloatArray]:
    """Return points (x, y) turned about the origin by an angle [rad], from x towards y."""
    x, y = (np.asarray(each, np.float64) for each in points)
    cosine, sine = np.cos(angle), np.sin(angle)
    return cosine * x - sine * y, sine * x + cosine * y


def _short(value: float) -> str:
    # a tenth of a unit is a quarter of a pixel on a wide page
    return f'{round(float(value), 1) + 0.0:g}'
