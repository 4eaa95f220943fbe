"""A cam given by points measured on a real piece, smoothed within a stated tolerance.

A spline through measured points follows their errors. Its radius of curvature, t + t'' on a
vertical thread, magnifies them, so that a convex piece would come out hollow. The cam is therefore
the smoothest spline that passes within the tolerance of every point: FITPACK's smoothing spline
(Dierckx 1993, *Curve and Surface Fitting with Splines*, ch. 5). It has as few knots as an allowed
sum of squares S needs; S is halved until no point is farther off than the tolerance.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.polynomial import Polynomial
from pydantic import Field

from tauto_core.curves.cam import TableLever
from tauto_core.curves.cams.table import (
    HEADER,
    Table,
    check_rows,
    check_spline,
    law_of_pieces,
    read_rows,
    wrappable,
)
from tauto_core.curves.kind import CamKind, Setting
from tauto_core.curves.numerics import nearest_if_any
from tauto_core.samples import FloatArray
from tauto_core.scene.data import data_path
from tauto_core.scene.errors import SceneError
from tauto_core.scene.fields import Positive, Text

if TYPE_CHECKING:
    from scipy.interpolate import BSpline, PPoly

_TERMS = 6
MOST_ROWS = 500
_HALVINGS = 32
"""Largest number of halvings of S, beginning where all points are off by the tolerance; after them
the points are interpolated.
"""
_LARGEST_SHARE = 0.5
"""Largest tolerance as a share of the longest arm: a larger one would ignore the measurement."""


def smoothed(angles: FloatArray, arms: FloatArray, tolerance: float) -> TableLever:
    """Return the smoothest odd quintic spline within a tolerance of all points.

    Args:
        angles: ϑ > 0, strictly increasing [rad], shape (n,), n ≥ 6.
        arms: t measured there [m], shape (n,).
        tolerance: largest difference of the spline from any point [m], > 0.
    """
    x = np.concatenate([-angles[::-1], [0.0], angles])
    y = np.concatenate([-arms[::-1], [0.0], arms])

    def within(exponent: int) -> BSpline | None:
        spline = _fitted(x, y, tolerance, len(x) * 2.0**-exponent)
        if spline is None:
            return None
        odd = 0.5 * (spline(angles) - spline(-angles))
        return spline if np.all(np.abs(odd - arms) <= tolerance) else None

    found, rough, smooth = within(0), 0, _HALVINGS
    while found is None and smooth - rough > 1:
        middle = (rough + smooth) // 2
        tried = within(middle)
        rough, smooth = (middle, smooth) if tried is None else (rough, middle)
    if found is None:
        found = within(smooth) or _fitted(x, y, tolerance, 0.0)
    assert found is not None  # interpolation always succeeds
    return _odd_part(found)


def _fitted(x: FloatArray, y: FloatArray, tolerance: float, squares: float) -> BSpline | None:
    """Return FITPACK's spline for a sum of squares, scaled by the tolerance; None if it fails."""
    from scipy.interpolate import BSpline, splrep

    weights = np.full_like(x, 1.0 / tolerance)
    tck, _, code, _ = splrep(x, y, w=weights, k=5, s=squares, full_output=1, quiet=1)
    return None if code > 0 else BSpline(*tck)


def _odd_part(spline: BSpline) -> TableLever:
    """Return (s(ϑ) − s(−ϑ))/2 piece by piece from 0, since FITPACK's knots are not symmetric."""
    from scipy.interpolate import PPoly

    whole = PPoly.from_spline(spline.tck)
    ends = np.unique(whole.x)
    knots = np.unique(np.concatenate([[0.0], np.abs(ends)]))
    # knots that mirror each other are equal to rounding
    apart = np.diff(knots) > 1e-12 * knots[-1]
    knots = np.append(knots[:-1][apart], knots[-1])
    rows = []
    for left, right in pairwise(knots.tolist()):
        middle = 0.5 * (left + right)
        here, there = _piece(whole, middle, left, 1.0), _piece(whole, -middle, -left, -1.0)
        odd = 0.5 * (here - there)
        rows.append(np.pad(odd.coef, (0, _TERMS - len(odd.coef))))
    return law_of_pieces(knots, np.array(rows))


def _piece(whole: PPoly, at: float, start: float, way: float) -> Polynomial:
    """Return the piece that contains an angle, as a polynomial in h of start + way·h."""
    x, c = whole.x, whole.c
    k = int(np.clip(np.searchsorted(x, at, side='right') - 1, 0, len(x) - 2))
    found: Polynomial = Polynomial(c[::-1, k])(Polynomial([start - x[k], way]))
    return found


class MeasuredCam(CamKind):
    """Lever arm measured on a real cam: a smooth curve that passes the points within a tolerance.

    CSV with the columns angle_rad, lever_arm_m and at least six rows of increasing angles > 0; the
    other cheek is assumed to be the mirror image. A tolerance that is too small for the errors of
    the points gives a hollow cheek, which no thread can wrap. It is refused, and the error names
    the smallest that works.
    """

    threads = ('vertical', 'hole')
    rank = 8
    starter = {'path': 'shipped:lever_arms/measured.csv', 'tolerance': 2e-5}

    kind: Literal['measured'] = 'measured'
    path: Text = Field(description='CSV file with the columns angle_rad,lever_arm_m')
    tolerance: Positive = Field(
        description='largest difference between the smoothed lever arm and any point [m]'
    )

    def made(self, setting: Setting) -> Table:
        """Return the smoothed cam; it is the same for any wheel and power.

        Raises:
            SceneError: naming file, line, value and remedy; or a tolerance with which no thread
                can wrap the cheek.
        """
        path = data_path(self.path)
        rows = read_rows(path)
        if rows and rows[0][1:] == (0.0, 0.0):
            rows = rows[1:]  # the point at rest is part of every cam
        check_rows(path, rows)
        if len(rows) > MOST_ROWS:
            problem = f'more than {MOST_ROWS} points take minutes to smooth'
            remedy = 'Take the means of neighbouring points.'
            raise SceneError(str(path), 'number of rows', len(rows), problem, remedy)
        line, angle, _ = rows[0]
        if angle <= 0.0:
            problem = 'a point at rest or on the other cheek says nothing of this one'
            remedy = 'Give the points of one cheek, at angles greater than 0.'
            raise SceneError(str(path), f'line {line}, {HEADER[0]}', angle, problem, remedy)
        angles, arms = np.array([row[1:] for row in rows]).T
        largest = _LARGEST_SHARE * float(arms.max())
        if self.tolerance > largest:
            raise SceneError(
                'trochlea',
                'trochlea.cam.tolerance',
                self.tolerance,
                f'must be at most half of the longest lever arm, {largest:.6g} m',
                'Give the error of the measurement, in metres.',
            )
        try:
            return _cam(path, angles, arms, self.tolerance, setting.distance)
        except SceneError as error:
            raise self._refused(path, angles, arms, setting.distance, error) from None

    def files(self) -> Iterator[tuple[str, str]]:
        """Yield the file of the points."""
        yield 'trochlea.cam.path', self.path

    def _refused(
        self, path: Path, angles: FloatArray, arms: FloatArray, distance: float, error: SceneError
    ) -> SceneError:
        """Return the error for a tolerance without a cam; it names the smallest that works."""
        largest = _LARGEST_SHARE * float(arms.max())

        def works(tolerance: float) -> bool:
            if tolerance > largest:
                return False
            try:
                _cam(path, angles, arms, tolerance, distance)
            except SceneError:
                return False
            return True

        found = nearest_if_any(self.tolerance, 1.5, works)
        least = f'Use a tolerance of at least {found:.4g} m, or ' if found is not None else ''
        remedy = f'{least}measure those angles again.'
        return SceneError(
            'trochlea',
            'trochlea.cam.tolerance',
            self.tolerance,
            f'{path}: within it of all points, {error.problem} ({error.key} = {error.value!r})',
            remedy[0].upper() + remedy[1:],
        )


def _cam(
    path: Path, angles: FloatArray, arms: FloatArray, tolerance: float, distance: float
) -> Table:
    table = Table(path.name, smoothed(angles, arms, tolerance), distance)
    check_spline(path, table)
    return wrappable(path, table)


KIND = MeasuredCam
