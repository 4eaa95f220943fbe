"""What the ship does at the nodes of a step, as far as the wheel feels it."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from tauto_core.kernels import compiled, inlined
from tauto_core.motion.lanes import Lanes, load, store
from tauto_core.motion.outside import (
    GRAVITY,
    LINE_RATE,
    TILT_RATE,
    Place,
    column,
    columns,
    nodes_of,
)
from tauto_core.motion.work import Work
from tauto_core.samples import FloatArray

NODES = 'line_rate', 'line_bend', 'tilt_rate', 'gravity'
"""Rows of γ̇, γ̈, τ̇ and g_eff at the nodes."""


class Nodes(Protocol):
    """The rows NODES of `work.nodes`; those of absent channels are not set."""

    line_rate: FloatArray
    line_bend: FloatArray
    tilt_rate: FloatArray
    gravity: FloatArray


class Felt(NamedTuple):
    """Which channels of the ship's motion act: True, or None, which is known when compiling."""

    line: bool | None
    tilt: bool | None
    gravity: bool | None


@compiled
def fill_nodes(felt: Felt, drag: bool, place: Place, work: Work) -> None:
    """Fill the rows of the channels there are; τ̇ only if it is felt."""
    x, terms, nodes = nodes_of(place, work), place.terms, work.nodes
    if felt.line is not None:
        rate, bend = columns(LINE_RATE, terms, x, work)
        store(nodes.line_rate, 0, rate)
        store(nodes.line_bend, 0, bend)
    if drag and felt.tilt is not None:
        store(nodes.tilt_rate, 0, column(TILT_RATE, terms, x, work))
    if felt.gravity is not None:
        store(nodes.gravity, 0, column(GRAVITY, terms, x, work))


@inlined
def row_or_zero(channel: bool | None, row: FloatArray) -> Lanes:
    """Return a row of the nodes; 0 where its channel is absent."""
    return 0.0 if channel is None else load(row)
