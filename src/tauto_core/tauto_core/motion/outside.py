"""The motion of the ship in compiled code: at an instant, and at the nodes of a step.

The forcing consists of pieces, in each of which every channel is a polynomial of x, 0 to 1. For
the piece of a span, `set_piece` lays the polynomials of all channels and of their time derivatives
side by side, the coefficients of a power of x in each row of `work.piece`: one pass of Horner's
scheme then evaluates them all.
"""

from __future__ import annotations

from typing import NamedTuple

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.gauss_step import Work
from tauto_core.motion.lanes import Lanes, filled, fma, lane, load, width
from tauto_core.samples import FloatArray

LINE, LINE_RATE, LINE_BEND, TILT, TILT_RATE, TILT_BEND, GRAVITY = range(7)
"""Columns of a piece: γ, γ̇, γ̈, τ, τ̇, τ̈ and the apparent gravity."""


class Pieces(NamedTuple):
    """Pieces of forcing; a channel is None where it is absent.

    Attributes:
        length_s: length of each piece [s], (n,).
        line, tilt, gravity: γ [rad], τ [rad] and g_eff [m/s2]: coefficients of x^j, (n, powers).
    """

    length_s: FloatArray
    line: FloatArray | None
    tilt: FloatArray | None
    gravity: FloatArray | None


class Place(NamedTuple):
    """Where a step is.

    Attributes:
        length: length of its piece of forcing [s].
        terms: number of powers in use.
        begin: where the step begins, in x of the piece.
        size: length of the step, in x: size · length seconds.
    """

    length: float
    terms: int
    begin: float
    size: float


class Channel(NamedTuple):
    """A channel at an instant: its value, and its first and second time derivative."""

    value: float
    rate: float
    bend: float


class Outside(NamedTuple):
    """The motion of the ship at an instant; zeros where a channel is absent.

    Attributes:
        line: γ, the direction of the thread's neutral line [rad] (`Forcing.neutral`).
        tilt: τ, the angle of that line in the case [rad].
        gravity: g_eff, the apparent gravity [m/s2].
    """

    line: Channel
    tilt: Channel
    gravity: float


@compiled
def _terms(channel: FloatArray | None) -> int:
    """Return the number of powers of a channel."""
    return 0 if channel is None else channel.shape[1]


@inlined
def _set_channel(
    channel: FloatArray | None, k: int, first: int, per_s: float, terms: int, work: Work
) -> None:
    """Fill three columns with a channel and its first two time derivatives."""
    if channel is None:
        return
    own, size = channel.shape[1], width(work.piece)
    above = above_rate = 0.0
    for j in range(terms - 1, -1, -1):
        coefficient = channel[k, j] if j < own else 0.0
        rate, bend = (j + 1) * per_s * above, (j + 1) * per_s * above_rate
        place = j * size + first
        work.piece[place], work.piece[place + 1], work.piece[place + 2] = coefficient, rate, bend
        above, above_rate = coefficient, rate


@inlined
def _set_gravity(gravity: FloatArray | None, k: int, terms: int, work: Work) -> None:
    """Fill the column of the apparent gravity."""
    if gravity is None:
        return
    own, size = gravity.shape[1], width(work.piece)
    for j in range(terms):
        work.piece[j * size + GRAVITY] = gravity[k, j] if j < own else 0.0


@compiled
def set_piece(pieces: Pieces, k: int, tilted: bool, work: Work) -> tuple[float, int]:
    """Lay out piece k, of at most `work.TERMS` powers; return its length [s] and its powers.

    The number of powers is made even, since `outside_at` takes two at a time.

    Args:
        pieces: of the forcing; the columns of absent channels stay zero.
        k: number of the piece.
        tilted: whether τ will be asked for; otherwise its columns are left as they are.
        work: its `piece` is filled.
    """
    line, tilt, gravity = pieces.line, pieces.tilt, pieces.gravity
    per_s = 1.0 / pieces.length_s[k]
    terms = max(_terms(line), _terms(tilt), _terms(gravity))
    terms += terms % 2
    _set_channel(line, k, LINE, per_s, terms, work)
    if tilted:
        _set_channel(tilt, k, TILT, per_s, terms, work)
    _set_gravity(gravity, k, terms, work)
    return pieces.length_s[k], terms


@compiled
def outside_at(terms: int, x: float, work: Work) -> Outside:
    """Return what the ship does at x of the piece laid out.

    Even and odd powers are summed apart, so that half as many operations wait for one another.
    """
    even, odd, square = filled(work.piece, 0.0), filled(work.piece, 0.0), x * x
    for j in range(terms - 2, -1, -2):
        odd = fma(odd, square, load(work.piece, j + 1))
        even = fma(even, square, load(work.piece, j))
    all_ = fma(odd, x, even)
    return Outside(
        Channel(lane(all_, LINE), lane(all_, LINE_RATE), lane(all_, LINE_BEND)),
        Channel(lane(all_, TILT), lane(all_, TILT_RATE), lane(all_, TILT_BEND)),
        lane(all_, GRAVITY),
    )


@inlined
def nodes_of(place: Place, work: Work) -> Lanes:
    """Return x at the nodes of a step."""
    return load(work.fractions) * place.size + place.begin


@inlined
def column(which: int, terms: int, x: Lanes, work: Work) -> Lanes:
    """Return a column of the piece at lanes of x."""
    value, size = filled(x, 0.0), width(work.piece)
    for j in range(terms - 1, -1, -1):
        value = fma(value, x, work.piece[j * size + which])
    return value


@inlined
def columns(first: int, terms: int, x: Lanes, work: Work) -> tuple[Lanes, Lanes]:
    """Return a column and the next one, side by side, at lanes of x."""
    one, two, size = filled(x, 0.0), filled(x, 0.0), width(work.piece)
    for j in range(terms - 1, -1, -1):
        place = j * size + first
        one, two = fma(one, x, work.piece[place]), fma(two, x, work.piece[place + 1])
    return one, two


@inlined
def difference(first: int, second: int, terms: int, x: Lanes, work: Work) -> Lanes:
    """Return the first column of the piece less the second at lanes of x."""
    value, size = filled(x, 0.0), width(work.piece)
    for j in range(terms - 1, -1, -1):
        place = j * size
        value = fma(value, x, work.piece[place + first] - work.piece[place + second])
    return value
