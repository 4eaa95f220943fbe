"""Cams given by numbers: a lever arm computed to rounding, tabulated in a CSV file, or measured.

A spline through measured points follows their errors. Its radius of curvature, t + t'' on a
vertical thread, magnifies them: a convex piece would come out hollow. The cam is therefore the
smoothest spline within the tolerance of every point: FITPACK's smoothing spline (Dierckx 1993,
*Curve and Surface Fitting with Splines*, ch. 5). It has as few knots as an allowed sum of squares
S needs, and S is halved until all points are within the tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from pydantic import Field

from tauto_core.curves.cam import Cam, CamKind, Setting, SmoothLever, TableLever
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import SceneError
from tauto_core.scene.sections import OneLine, Positive
from tauto_core.scene.tables import Column, Columns, data_path, read_table

if TYPE_CHECKING:
    from scipy.interpolate import BSpline, PPoly

TABLE_COLUMNS = ('angle_rad', 'lever_arm_m')
LEAST_ROWS = 6
_MOST_ROWS = 500
# Largest number of halvings of S, beginning with all points off by the tolerance. After them the
# points are interpolated.
_TRIALS = 32
# Largest tolerance as a share of the longest arm: a larger one would ignore the measurement.
_LARGEST_SHARE = 0.5
_FORM = f'Write the header {",".join(TABLE_COLUMNS)} and rows of two plain numbers.'


class ArmSplines(NamedTuple):
    """t, t', t'' and h of a tabulated cam."""

    arm: PPoly
    rate: PPoly
    bend: PPoly
    lift: PPoly


@dataclass(frozen=True, eq=False)
class Table(Cam):
    """A cam with a quintic spline through tabulated points as lever arm.

    t has continuous derivatives up to the fourth. For a thread through a hole, ψ = ϑ + arcsin(t/a)
    requires only |t| ≤ a.

    Attributes:
        source: origin of the table, for messages.
        law: the spline, from 0 to the range.
        distance: distance of the hole from the axle [m], inf for a vertical thread.
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

    @cached_property
    def splines(self) -> ArmSplines:
        """The law and the functions derived from it, of |ϑ|."""
        from scipy.interpolate import PPoly

        arm = PPoly(np.ascontiguousarray(self.law.coefficients.T[::-1]), self.law.knots)
        return ArmSplines(arm, arm.derivative(), arm.derivative(2), arm.antiderivative())

    def _arm(self, x: FloatArray) -> FloatArray:
        return np.asarray(self.splines.arm(x))

    def _rate(self, x: FloatArray) -> FloatArray:
        return np.asarray(self.splines.rate(x))

    def _bend(self, x: FloatArray) -> FloatArray:
        return np.asarray(self.splines.bend(x))

    def _lift(self, x: FloatArray) -> FloatArray:
        return np.asarray(self.splines.lift(x))


class Fitted(Table):
    """A cam with an analytic lever arm, given by polynomials to rounding."""

    @property
    def joints(self) -> FloatArray:
        """An empty array: the joints of the polynomials are below rounding."""
        return np.empty(0)


def load_table(path: Path, distance: float = math.inf) -> Table:
    """Read a cam from a CSV file with the header `angle_rad,lever_arm_m`.

    It has at least six rows: first 0,0, then strictly increasing angles and positive lever arms.
    The other cheek is the mirror image. The spline interpolates the rows and their odd
    continuation, smoothly through rest. SceneError, with file, line and value: an unusable row.
    """
    from scipy.interpolate import PPoly, make_interp_spline

    table = _read_rows(path, at_rest=True)
    angles, arms = (table[column] for column in TABLE_COLUMNS)
    everywhere = np.concatenate([-angles[:0:-1], angles])
    try:
        spline = make_interp_spline(everywhere, np.concatenate([-arms[:0:-1], arms]), k=5)
    except (ValueError, np.linalg.LinAlgError) as error:
        raise SceneError(
            str(path),
            '',
            None,
            f'no spline goes through these rows: {error}',
            'Space the angles more evenly.',
        ) from error
    ppoly = PPoly.from_spline(spline.tck)
    knots = np.unique(ppoly.x[ppoly.x >= 0.0])
    pieces = np.searchsorted(ppoly.x, knots[:-1], side='right') - 1
    law = _law_of_pieces(knots, np.ascontiguousarray(ppoly.c[::-1, pieces].T))
    return Table(path.name, law, distance)


def _read_rows(path: Path, *, at_rest: bool) -> Columns:
    """Return the rows of a file, with the first at rest, or without one at rest.

    SceneError: see `read_table`, too few rows, angles that do not increase, arms that are not > 0.
    """
    angle, arm = TABLE_COLUMNS
    sort = 'Sort the rows and remove duplicates.'
    rising = Column(angle, unit='rad', rising='greater than the angle before', remedy=sort)
    table = read_table(str(path), (rising, Column(arm, unit='m')), remedy=_FORM)
    has_rest = table[angle][0] == 0.0 and table[arm][0] == 0.0
    if at_rest and not has_rest:
        raise SceneError(
            str(path),
            table.where(0),
            (float(table[angle][0]), float(table[arm][0])),
            'the first row is not 0,0',
            'Begin at rest, without the negative angles of the mirror image.',
        )
    if has_rest and not at_rest:
        table = table.rows(np.arange(1, len(table)))  # the point at rest is part of every cam
    if len(table) < LEAST_ROWS:
        raise SceneError(
            str(path),
            'number of rows',
            len(table),
            f'a quintic spline needs at least {LEAST_ROWS} rows',
            'Tabulate more angles.',
        )
    bad = np.flatnonzero(table[arm] <= 0.0)[int(at_rest) :]
    if len(bad):
        raise table.refusal(
            int(bad[0]),
            arm,
            'the lever arm must be > 0 to drive the wheel back',
            'End the table before the arm vanishes.',
        )
    return table


def _law_of_pieces(knots: FloatArray, coefficients: FloatArray) -> TableLever:
    """Return the odd law of a quintic spline from (n, 6) coefficients of (ϑ − knot)^j."""
    from scipy.interpolate import PPoly

    # even terms at rest are rounding
    coefficients[0, ::2] = 0.0
    lifts = PPoly(np.ascontiguousarray(coefficients.T[::-1]), knots).antiderivative()(knots[:-1])
    return TableLever(knots, coefficients, lifts)


def smoothed(angles: FloatArray, arms: FloatArray, tolerance: float) -> TableLever:
    """Return the smoothest odd quintic spline within a tolerance [m] of all points.

    The n ≥ 6 angles are > 0 and strictly increase.
    """
    from scipy.interpolate import PPoly

    x = np.concatenate([-angles[::-1], [0.0], angles])
    y = np.concatenate([-arms[::-1], [0.0], arms])

    def within(exponent: int) -> BSpline | None:
        spline = _fitted(x, y, tolerance, len(x) * 2.0**-exponent)
        if spline is None:
            return None
        odd = 0.5 * (spline(angles) - spline(-angles))
        return spline if np.all(np.abs(odd - arms) <= tolerance) else None

    best, rough, smooth = within(0), 0, _TRIALS
    while best is None and smooth - rough > 1:
        middle = (rough + smooth) // 2
        trial = within(middle)
        rough, smooth = (middle, smooth) if trial is None else (rough, middle)
    if best is None:
        best = within(smooth) or _fitted(x, y, tolerance, 0.0)
    assert best is not None  # interpolation always succeeds
    # (s(ϑ) − s(−ϑ))/2 piece by piece from 0: FITPACK's knots are not symmetric
    ppoly = PPoly.from_spline(best.tck)
    ends = np.unique(ppoly.x)
    knots = np.unique(np.concatenate([[0.0], np.abs(ends)]))
    # knots that mirror each other are equal to rounding
    distinct = np.diff(knots) > 1e-12 * knots[-1]
    knots = np.append(knots[:-1][distinct], knots[-1])
    rows = []
    for begin, right in pairwise(knots.tolist()):
        middle = 0.5 * (begin + right)
        piece, image = _piece(ppoly, middle, begin, 1.0), _piece(ppoly, -middle, -begin, -1.0)
        odd = 0.5 * (piece - image)
        rows.append(np.pad(odd.coef, (0, 6 - len(odd.coef))))
    return _law_of_pieces(knots, np.array(rows))


def _fitted(x: FloatArray, y: FloatArray, tolerance: float, squares: float) -> BSpline | None:
    """Return FITPACK's spline for a sum of squares, scaled by the tolerance, if any."""
    from scipy.interpolate import BSpline, splrep

    weights = np.full_like(x, 1.0 / tolerance)
    tck, _, code, _ = splrep(x, y, w=weights, k=5, s=squares, full_output=1, quiet=1)
    return None if code > 0 else BSpline(*tck)


def _piece(ppoly: PPoly, at: float, start: float, way: float) -> Polynomial:
    """Return the piece that contains an angle, as a polynomial in h of start + way·h."""
    x, c = ppoly.x, ppoly.c
    k = int(np.clip(np.searchsorted(x, at, side='right') - 1, 0, len(x) - 2))
    piece: Polynomial = Polynomial(c[::-1, k])(Polynomial([start - x[k], way]))
    return piece


class TableCam(CamKind):
    """Lever arm tabulated against the wheel's angle: CSV with the columns angle_rad, lever_arm_m.

    The same lever arms make a cam for a vertical thread and another for a thread through a hole.
    """

    threads = ('vertical', 'hole')
    rank = 4
    starter = {'path': 'shipped:lever_arms/involute.csv'}

    kind: Literal['table'] = 'table'
    path: OneLine = Field(description='CSV file with the columns angle_rad,lever_arm_m')

    def made(self, setting: Setting) -> Table:
        """Return the cam through the rows, the same for any wheel and power.

        SceneError, with file, line and value: an unusable row.
        """
        return load_table(data_path(self.path), setting.distance)

    def files(self) -> Iterator[tuple[str, str]]:
        """Yield the file of the table."""
        yield 'trochlea.cam.path', self.path


class MeasuredCam(CamKind):
    """Lever arm measured on a real cam: a smooth curve within a tolerance of the points.

    CSV with the columns angle_rad, lever_arm_m and at least six rows of increasing angles > 0. The
    other cheek is assumed to be the mirror image. A tolerance below the errors of the points gives
    a hollow cheek, which is refused.
    """

    threads = ('vertical', 'hole')
    if_hollow = 'use a larger tolerance, or measure those angles again'
    rank = 8
    starter = {'path': 'shipped:lever_arms/measured.csv', 'tolerance': 2e-5}

    kind: Literal['measured'] = 'measured'
    path: OneLine = Field(description='CSV file with the columns angle_rad,lever_arm_m')
    tolerance: Positive = Field(
        description='largest difference between the smoothed lever arm and any point [m]'
    )

    def made(self, setting: Setting) -> Table:
        """Return the smoothed cam, the same for any wheel and power.

        SceneError, with file, line and value: unusable rows.
        """
        path = data_path(self.path)
        rows = _read_rows(path, at_rest=False)
        angles, arms = (rows[column] for column in TABLE_COLUMNS)
        if len(rows) > _MOST_ROWS:
            raise SceneError(
                str(path),
                'number of rows',
                len(rows),
                f'more than {_MOST_ROWS} points take minutes to smooth',
                'Take the means of neighbouring points.',
            )
        if angles[0] <= 0.0:
            raise rows.refusal(
                0,
                TABLE_COLUMNS[0],
                'a point at rest or on the other cheek does not belong to this one',
                'Give the points of one cheek, at angles greater than 0.',
            )
        largest = _LARGEST_SHARE * float(arms.max())
        if self.tolerance > largest:
            raise SceneError(
                'trochlea',
                'trochlea.cam.tolerance',
                self.tolerance,
                f'must be at most half of the longest lever arm, {largest:.6g} m',
                'Give the error of the measurement, in metres.',
            )

        return Table(path.name, smoothed(angles, arms, self.tolerance), setting.distance)

    def files(self) -> Iterator[tuple[str, str]]:
        """Yield the file of the points."""
        yield 'trochlea.cam.path', self.path


KINDS = TableCam, MeasuredCam
