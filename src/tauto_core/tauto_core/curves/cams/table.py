"""A cam given by numbers: a lever arm tabulated in a CSV file, or computed to rounding."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from tauto_core.curves.cam import Cam, SmoothLever, TableLever, hollow, invert_lift
from tauto_core.curves.kind import CamKind, Setting
from tauto_core.samples import FloatArray
from tauto_core.scene.data import data_path
from tauto_core.scene.errors import SceneError
from tauto_core.scene.fields import Text

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

HEADER = ('angle_rad', 'lever_arm_m')
LEAST_ROWS = 6
_FORM = f'Write the header {",".join(HEADER)} and rows of two plain numbers.'


@dataclass(frozen=True, eq=False)
class Table(Cam):
    """A cam whose lever arm is a quintic spline through tabulated points.

    t has continuous derivatives up to the fourth. For a thread through a hole, ψ = ϑ + arcsin(t/a)
    requires only |t| ≤ a. Where `radius_of_curvature` is negative the cheek cannot be cut.

    Attributes:
        source: origin of the table, for messages.
        law: the spline, from 0 to the range.
        distance: distance of the hole from the axle [m]; inf for a vertical thread.
    """

    source: str
    law: TableLever | SmoothLever = field(repr=False)
    distance: float = math.inf

    @property
    def lever(self) -> TableLever | SmoothLever:
        """The law of the lever arm as plain numbers."""
        return self.law

    @property
    def range_rad(self) -> float:
        """The last tabulated angle [rad]."""
        return float(self.law.knots[-1])

    @property
    def joints(self) -> FloatArray:
        """The inner knots of the spline [rad]."""
        return self.law.knots[1:-1]

    @property
    def hole_distance(self) -> float:
        """Distance of the hole [m]; inf for a vertical thread."""
        return self.distance

    def lever_arm(self, angle: ArrayLike) -> FloatArray:
        """Return t [m]."""
        angle = self.within(angle)
        return np.copysign(1.0, angle) * self._arm(np.abs(angle))

    def lever_rate(self, angle: ArrayLike) -> FloatArray:
        """Return dt/dϑ [m/rad]."""
        rate: FloatArray = self._rate(np.abs(self.within(angle)))
        return rate

    def lever_curvature(self, angle: ArrayLike) -> FloatArray:
        """Return d²t/dϑ² [m/rad²]."""
        angle = self.within(angle)
        return np.copysign(1.0, angle) * self._curvature(np.abs(angle))

    def lift(self, angle: ArrayLike) -> FloatArray:
        """Return h [m]."""
        lift: FloatArray = self._lift(np.abs(self.within(angle)))
        return lift

    def angle_of_lift(self, lift: ArrayLike) -> FloatArray:
        """Return the ϑ ≥ 0 of a lift [rad], for 0 ≤ h ≤ h(range)."""
        return invert_lift(self, lift)

    def _rate_gain(self, angle: FloatArray) -> FloatArray:
        gain: FloatArray = self._gain(np.abs(angle))
        return gain

    def _hanging_contact(self, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
        arm, rate = self.lever_arm(angle), self.lever_rate(angle)
        sine, cosine = np.sin(angle), np.cos(angle)
        return arm * cosine - rate * sine, arm * sine + rate * cosine

    @cached_property
    def _arm(self) -> PPoly:
        from scipy.interpolate import PPoly

        return PPoly(np.ascontiguousarray(self.law.coefficients.T[::-1]), self.law.knots)

    @cached_property
    def _rate(self) -> PPoly:
        return self._arm.derivative()

    @cached_property
    def _curvature(self) -> PPoly:
        return self._arm.derivative(2)

    @cached_property
    def _lift(self) -> PPoly:
        return self._arm.antiderivative()

    @cached_property
    def _gain(self) -> PPoly:
        return self._curvature.antiderivative()


class Fitted(Table):
    """A cam whose lever arm is an analytic function, represented by polynomials to rounding."""

    @property
    def joints(self) -> FloatArray:
        """None: the joints of the polynomials are below rounding."""
        return np.empty(0)


def load_table(path: Path, distance: float = math.inf) -> Table:
    """Read a cam from a CSV file with the header `angle_rad,lever_arm_m`.

    At least six rows; the first is 0,0, then angles strictly increase and lever arms are
    positive. The other cheek is the mirror image. The spline interpolates the rows and their
    odd continuation, so that it is smooth through rest.

    Args:
        path: the file.
        distance: distance of the hole from the axle [m]; inf for a vertical thread.

    Raises:
        SceneError: naming file, line, value and remedy.
    """
    rows = read_rows(path)
    _check_first(path, rows)
    check_rows(path, rows)
    angles, arms = np.array([row[1:] for row in rows]).T
    table = Table(path.name, _spline(path, angles, arms), distance)
    check_spline(path, table)
    return table


def read_rows(path: Path) -> list[tuple[int, float, float]]:
    """Return (line, angle, arm) of all rows; blank lines are skipped."""
    name = str(path)
    try:
        text = path.read_text(encoding='utf-8-sig')
    except (OSError, UnicodeDecodeError) as error:
        problem = f'cannot be read as text: {error}'
        raise SceneError(name, '', None, problem, 'Give a readable CSV file.') from error
    lines = csv.reader(text.splitlines())
    header = next(lines, [])
    if tuple(cell.strip() for cell in header) != HEADER:
        raise SceneError(name, 'line 1', ','.join(header), 'the header is not right', _FORM)
    rows = []
    for cells in lines:
        if not ''.join(cells).strip():
            continue
        line = lines.line_num
        if len(cells) != len(HEADER):
            problem = f'{len(cells)} columns instead of 2'
            raise SceneError(name, f'line {line}', ','.join(cells), problem, _FORM)
        angle, arm = (_number(name, line, *pair) for pair in zip(HEADER, cells, strict=True))
        rows.append((line, angle, arm))
    return rows


def _number(name: str, line: int, column: str, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SceneError(name, f'line {line}, {column}', cell, 'not a finite number', _FORM)
    return value


def check_rows(path: Path, rows: list[tuple[int, float, float]]) -> None:
    """Refuse too few rows, angles that do not increase, and arms that are not positive.

    Raises:
        SceneError: naming file, line, value and remedy.
    """
    name = str(path)
    if len(rows) < LEAST_ROWS:
        problem = f'a quintic spline needs at least {LEAST_ROWS} rows'
        raise SceneError(name, 'number of rows', len(rows), problem, 'Tabulate more angles.')
    for (_, before, _), (line, angle, arm) in pairwise(rows):
        if angle <= before:
            problem = f'angles must strictly increase, and the row before has {before!r}'
            remedy = 'Sort the rows and remove duplicates.'
            raise SceneError(name, f'line {line}, {HEADER[0]}', angle, problem, remedy)
        if arm <= 0.0:
            problem = 'the lever arm must be > 0, or nothing drives the wheel back'
            remedy = 'End the table before the arm vanishes.'
            raise SceneError(name, f'line {line}, {HEADER[1]}', arm, problem, remedy)


def _check_first(path: Path, rows: list[tuple[int, float, float]]) -> None:
    name = str(path)
    for line, *first in rows[:1]:
        if first != [0.0, 0.0]:
            remedy = 'Begin at rest; negative angles are the mirror image and are not tabulated.'
            raise SceneError(
                name, f'line {line}', tuple(first), 'the first row is not 0,0', remedy
            )


def _spline(path: Path, angles: FloatArray, arms: FloatArray) -> TableLever:
    from scipy.interpolate import PPoly, make_interp_spline

    everywhere = np.concatenate([-angles[:0:-1], angles])
    try:
        spline = make_interp_spline(everywhere, np.concatenate([-arms[:0:-1], arms]), k=5)
    except (ValueError, np.linalg.LinAlgError) as error:
        problem = f'no spline goes through these rows: {error}'
        remedy = 'Space the angles more evenly.'
        raise SceneError(str(path), '', None, problem, remedy) from error
    whole = PPoly.from_spline(spline.tck)
    knots = np.unique(whole.x[whole.x >= 0.0])
    pieces = np.searchsorted(whole.x, knots[:-1], side='right') - 1
    coefficients = np.ascontiguousarray(whole.c[::-1, pieces].T)
    return law_of_pieces(knots, coefficients)


def law_of_pieces(knots: FloatArray, coefficients: FloatArray) -> TableLever:
    """Return the odd law of a quintic spline.

    Args:
        knots: from 0 to the range [rad], shape (n + 1,).
        coefficients: the coefficients of (ϑ − knots[k])^j, shape (n, 6); rounding makes those even
            in ϑ at rest.
    """
    from scipy.interpolate import PPoly

    # zero by symmetry
    coefficients[0, ::2] = 0.0
    lifts = PPoly(np.ascontiguousarray(coefficients.T[::-1]), knots).antiderivative()(knots[:-1])
    return TableLever(knots, coefficients, lifts)


def check_spline(path: Path, table: Table) -> None:
    """Refuse a spline that is negative, or beyond the hole, between the rows."""
    name, arm = str(path), table._arm
    slope = float(table.lever_rate(0.0))
    if not slope > 0.0:
        problem = 'the spline through the rows must rise from rest'
        remedy = 'Tabulate more angles near 0.'
        raise SceneError(name, 'lever rate at 0', slope, problem, remedy)
    extremes = table._rate.roots(extrapolate=False)
    angles = np.append(extremes[np.isfinite(extremes)], table.range_rad)
    lowest, highest = (float(angles[pick(arm(angles))]) for pick in (np.argmin, np.argmax))
    if not arm(lowest) > 0.0:
        problem = f'the spline through the rows falls to this lever arm at {lowest!r} rad'
        remedy = 'Tabulate more angles near there.'
        raise SceneError(name, HEADER[1], float(arm(lowest)), problem, remedy)
    if not arm(highest) <= table.distance:
        problem = (
            f'the lever arm at {highest!r} rad is longer than the distance of the hole, '
            f'thread.distance = {table.distance!r} m'
        )
        remedy = 'End the table before that angle or move the hole away.'
        raise SceneError(name, HEADER[1], float(arm(highest)), problem, remedy)


def wrappable(path: Path, table: Table) -> Table:
    """Return a tabulated cam if a thread can wrap it.

    Raises:
        SceneError: a cheek that would be hollow.
    """
    stretch = hollow(table, table.range_rad)
    if stretch is None:
        return table
    start, end = stretch
    sooner = f'End the table before {start:.6g} rad, or let' if start > 0.0 else 'Let'
    raise SceneError(
        str(path),
        HEADER[1],
        float(table.lever_arm(start)),
        f'the cheek would be hollow from {start:.6g} to {end:.6g} rad (a radius of curvature '
        'below 0), and a thread bridges a hollow',
        f'{sooner} the lever arm bend down less there.',
    )


class TableCam(CamKind):
    """Lever arm tabulated against the wheel's angle: CSV with the columns angle_rad, lever_arm_m.

    The same lever arms make a cam for a vertical thread and another for a thread through a hole.
    """

    threads = ('vertical', 'hole')
    rank = 4
    starter = {'path': 'shipped:lever_arms/involute.csv'}

    kind: Literal['table'] = 'table'
    path: Text = Field(description='CSV file with the columns angle_rad,lever_arm_m')

    def made(self, setting: Setting) -> Table:
        """Return the cam through the rows; it is the same for any wheel and power.

        Raises:
            SceneError: naming file, line, value and remedy.
        """
        path = data_path(self.path)
        return wrappable(path, load_table(path, setting.distance))

    def files(self) -> Iterator[tuple[str, str]]:
        """Yield the file of the table."""
        yield 'trochlea.cam.path', self.path


KIND = TableCam
