"""The place of a body within a half swing in a fluid, and the sequence of half swings.

A law gives two things for the half swing from rest at a signed arc: its duration and its end, and
the body's place at a time within it. On Euler's curve both have closed forms (`machines.descent`,
`machines.reverse_swing`); on a symmetric one both come from quadrature (`machines.half_swing`).
Durations and ends are smooth functions of the start, held as Chebyshev series, since a voyage has
millions of half swings, and the place within is needed in few of them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from tauto_core.curves.fluid_tautochrone import FluidTautochrone
from tauto_core.machines import FluidPendulum
from tauto_core.machines.descent import half_swing
from tauto_core.machines.half_swing import far_end, grid_for, place
from tauto_core.machines.reverse_swing import reverse_half_swing
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import PropagationError

LARGEST_DEGREE = 512
SMALLEST_DEGREE = 8
TAIL = 2.0**-48
"""Size of the last three coefficients at which a series counts as complete."""

_NUMBERS = 2**20
"""Numbers held at once to compute places within half swings."""


class Course(NamedTuple):
    """A half swing as a function of its start."""

    excess: float
    """Duration divided by π/ω, less 1."""
    end: float
    """Signed arc where it ends [m]."""


class SwingTable:
    """Duration and end of all half swings on one branch, from the widest down to nothing.

    Args:
        swing: duration excess and signed end of the half swing from a signed arc.
        widest: signed arc of the widest half swing [m].

    Raises:
        PropagationError: no series of degree 512 describes them.
    """

    def __init__(self, swing: Callable[[float], tuple[float, float]], widest: float) -> None:
        self._widest = widest
        degree = SMALLEST_DEGREE
        while degree <= LARGEST_DEGREE:
            nodes = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
            starts = widest * 0.5 * (1.0 + nodes)
            found = np.array([swing(start) for start in starts.tolist()])
            values = np.stack([found[:, 0], -found[:, 1] / starts], axis=1)
            series = chebyshev.chebfit(nodes, values, degree)
            if np.max(np.abs(series[-3:])) <= TAIL:
                self._excess, self._ratio = (_trimmed(series[:, column]) for column in range(2))
                return
            degree *= 2
        raise PropagationError(
            f'half swings from {widest:.6g} m take more than {LARGEST_DEGREE} Chebyshev '
            'coefficients: the fluid resists too strongly. Release the body nearer to A, or use a '
            'larger or denser body or a lighter fluid',
            0.0,
        )

    def __call__(self, start: float) -> Course:
        """Return the course of the half swing from rest at a signed arc [m]."""
        x = 2.0 * (start / self._widest) - 1.0
        return Course(_sum(self._excess, x), -start * _sum(self._ratio, x))


class EulerLaw:
    """Half swings on Euler's curve, in closed form both ways.

    Args:
        machine: on Euler's curve.
        curve: the curve of the machine.
    """

    def __init__(self, machine: FluidPendulum, curve: FluidTautochrone) -> None:
        self._machine, self._curve = machine, curve
        start = machine.release_arc
        _, end = machine.swing(start)
        self._tables = {widest > 0.0: SwingTable(machine.swing, widest) for widest in (start, end)}

    def course(self, start: float) -> Course:
        """Return the course of the half swing from rest at a signed arc [m]."""
        return self._tables[start > 0.0](start)

    def place(self, start: FloatArray, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return signed arc [m] and its rate [m/s] at times [s] since rest at signed arcs."""
        arc, rate = np.empty_like(start), np.empty_like(start)
        forth, gravity = start > 0.0, self._machine.gravity
        arc[forth], rate[forth] = half_swing(self._curve, gravity, start[forth], time[forth])
        back = ~forth
        arc[back], rate[back] = reverse_half_swing(
            self._curve.kappa, self._machine.frequency, -start[back], time[back]
        )
        return arc, rate


class SymmetricLaw:
    """Half swings on a curve whose branches are alike, by quadrature.

    Args:
        machine: on such a curve.
    """

    def __init__(self, machine: FluidPendulum) -> None:
        self._machine, self._curve = machine, machine.curve
        widest = abs(machine.release_arc)
        self._table = SwingTable(machine.swing, widest)
        self._grid = grid_for(self._curve, widest, far_end(self._curve, widest))

    def course(self, start: float) -> Course:
        """Return the course of the half swing from rest at a signed arc [m]."""
        excess, end = self._table(abs(start))
        return Course(excess, end if start > 0.0 else -end)

    def place(self, start: FloatArray, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return signed arc [m] and its rate [m/s] at times [s] since rest at signed arcs."""
        size, sign = np.abs(start), np.sign(start)
        end = np.array([-self._table(each).end for each in size.tolist()])
        arc, rate = np.empty_like(start), np.empty_like(start)
        grid = self._grid
        rows = max(1, _NUMBERS // (grid.nodes * max(grid.nodes, 24 * grid.panels)))
        for first in range(0, len(start), rows):
            part = slice(first, first + rows)
            arc[part], rate[part] = place(
                self._curve, self._machine.gravity, size[part], end[part], time[part], grid
            )
        return sign * arc, sign * rate


def swing_law(machine: FluidPendulum) -> EulerLaw | SymmetricLaw:
    """Return the law of a machine's half swings."""
    if isinstance(machine.curve, FluidTautochrone):
        return EulerLaw(machine, machine.curve)
    return SymmetricLaw(machine)


def _trimmed(series: FloatArray) -> list[float]:
    """Return the coefficients down to the last that counts, highest first."""
    kept: list[float] = chebyshev.chebtrim(series, 2.0**-56).tolist()
    return kept[::-1]


def _sum(series: list[float], x: float) -> float:
    """Return a Chebyshev series by Clenshaw's recurrence."""
    last = before = 0.0
    for coefficient in series[:-1]:
        last, before = 2.0 * x * last - before + coefficient, last
    return x * last - before + series[-1]
