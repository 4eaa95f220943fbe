"""The motion of the ship in compiled code: at an instant, and at the nodes of a step.

Of the piece of forcing that a span lies in, `set_piece` lays the polynomials of all channels and
of their time derivatives side by side, a power of x in each row from PIECE on: so all of them
are evaluated at once.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from tauto_core.kernels import compiled, inlined, overload
from tauto_core.motion.lanes import SIZE, filled, fma, lane, load, pointer, store, width
from tauto_core.motion.turning import D1, D2, FIRST, FRACTIONS, OUTSIDE, PIECE, X, Y
from tauto_core.samples import FloatArray

LINE, LINE_RATE, LINE_BEND, TILT, TILT_RATE, TILT_BEND, GRAVITY = range(7)
"""Columns of a piece, and rows at the nodes: γ, γ̇, γ̈, τ, τ̇, τ̈ and the apparent gravity."""

ROWS = 7
X_ROW, Y_ROW, D1_ROW, D2_ROW = FIRST + X, FIRST + Y, FIRST + D1, FIRST + D2
OUTSIDE_ROW = FIRST + OUTSIDE
"""Rows of `work` in the one plane of the wheel (turning.row)."""


class Pieces(NamedTuple):
    """Pieces of forcing, as coefficients of x^j in rows; a channel is None where it is absent.

    Attributes:
        length_s: length of each piece [s].
        line, tilt, gravity: γ, τ and g_eff.
    """

    length_s: FloatArray
    line: FloatArray | None
    tilt: FloatArray | None
    gravity: FloatArray | None


class Place(NamedTuple):
    """Where a step is.

    Attributes:
        length: length of its piece of forcing [s].
        terms: powers in use.
        begin: place where the step begins, in x of the piece.
        size: size of the step, in x.
    """

    length: float
    terms: int
    begin: float
    size: float


class Channel(NamedTuple):
    """A channel at an instant, and its first two time derivatives."""

    value: float
    rate: float
    bend: float


class Outside(NamedTuple):
    """The motion of the ship at an instant; zeros where a channel is absent.

    Attributes:
        line: γ, the neutral line; the apparent vertical for a thread that follows it.
        tilt: τ of that line in the case.
        gravity: the apparent one [m/s2].
    """

    line: Channel
    tilt: Channel
    gravity: float


class Felt(NamedTuple):
    """Which channels there are: True or None, known when compiling."""

    line: bool | None
    tilt: bool | None
    gravity: bool | None


@compiled
def _terms(channel: Any) -> int:
    return 0 if channel is None else channel.shape[1]


@inlined
def _set_channel(channel: Any, k: int, first: int, per_s: float, terms: int, work: Any) -> None:
    """Fill three columns with a channel and its first two time derivatives."""
    if channel is None:
        return
    own, size = channel.shape[1], width(work)
    above = above_rate = 0.0
    for j in range(terms - 1, -1, -1):
        number = channel[k, j] if j < own else 0.0
        rate, bend = (j + 1) * per_s * above, (j + 1) * per_s * above_rate
        place = (PIECE + j) * size + first
        work[place], work[place + 1], work[place + 2] = number, rate, bend
        above, above_rate = number, rate


@inlined
def _set_gravity(gravity: Any, k: int, terms: int, work: Any) -> None:
    if gravity is None:
        return
    own, size = gravity.shape[1], width(work)
    for j in range(terms):
        work[(PIECE + j) * size + GRAVITY] = gravity[k, j] if j < own else 0.0


@compiled
def set_piece(pieces: Pieces, k: int, tilted: bool, work: Any) -> tuple[float, int]:
    """Lay out piece k, at most `turning.TERMS` powers; return its length [s] and its powers.

    Args:
        pieces: the pieces of forcing; absent channels stay zero.
        k: number of the piece.
        tilted: whether τ is asked for; otherwise it stays unchanged.
        work: the array `work` of turning.
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
def outside_at(terms: int, x: float, work: Any) -> Outside:
    """Return the motion of the ship at x of the piece laid out."""
    # a row may be longer than its columns are
    rows, each = pointer(work), width(work) // SIZE
    even, odd, square = filled(rows, 0.0), filled(rows, 0.0), x * x
    for j in range(terms - 2, -1, -2):
        odd = fma(odd, square, load(rows, (PIECE + j + 1) * each))
        even = fma(even, square, load(rows, (PIECE + j) * each))
    all_ = fma(odd, x, even)
    return Outside(
        Channel(lane(all_, LINE), lane(all_, LINE_RATE), lane(all_, LINE_BEND)),
        Channel(lane(all_, TILT), lane(all_, TILT_RATE), lane(all_, TILT_BEND)),
        lane(all_, GRAVITY),
    )


@inlined
def nodes_of(place: Place, work: Any) -> Any:
    """Return x at the nodes of a step."""
    return load(work, FRACTIONS) * place.size + place.begin


@inlined
def column(which: int, terms: int, x: Any, work: Any) -> Any:
    """Return a column of the piece at lanes of x."""
    value, size = filled(work, 0.0), width(work)
    for j in range(terms - 1, -1, -1):
        value = fma(value, x, work[(PIECE + j) * size + which])
    return value


@inlined
def difference(first: int, second: int, terms: int, x: Any, work: Any) -> Any:
    """Return the first column of the piece less the second at lanes of x."""
    value, size = filled(work, 0.0), width(work)
    for j in range(terms - 1, -1, -1):
        place = (PIECE + j) * size
        value = fma(value, x, work[place + first] - work[place + second])
    return value


@inlined
def _columns(first: int, terms: int, x: Any, work: Any) -> Any:
    """Return two columns side by side at lanes of x."""
    one, two, size = filled(work, 0.0), filled(work, 0.0), width(work)
    for j in range(terms - 1, -1, -1):
        place = (PIECE + j) * size + first
        one, two = fma(one, x, work[place]), fma(two, x, work[place + 1])
    return one, two


@compiled
def forcing_at_nodes(felt: Felt, drag: bool, place: Place, work: Any) -> None:
    """Fill the rows from OUTSIDE_ROW on with γ̇, γ̈, τ̇ and g at the nodes of a step.

    Args:
        felt: the channels that there are.
        drag: whether τ̇ is felt.
        place: the place of the step.
        work: the array `work` of turning.
    """
    x = nodes_of(place, work)
    if felt.line is not None:
        rate, bend = _columns(LINE_RATE, place.terms, x, work)
        store(work, OUTSIDE_ROW + LINE_RATE, rate)
        store(work, OUTSIDE_ROW + LINE_BEND, bend)
    if drag and felt.tilt is not None:
        store(work, OUTSIDE_ROW + TILT_RATE, column(TILT_RATE, place.terms, x, work))
    if felt.gravity is not None:
        store(work, OUTSIDE_ROW + GRAVITY, column(GRAVITY, place.terms, x, work))


def node_row(channel: Any, work: Any, row: int) -> Any:
    """Return a row of the nodes, 0 where its channel is absent."""
    raise TypeError('node_row runs in compiled code only')


@overload(node_row)
def _node_row(channel: Any, work: Any, row: Any) -> Any:
    if channel is None:
        return lambda channel, work, row: 0.0
    return lambda channel, work, row: load(work, row)
