"""Response amplitude operators of a ship: from a file with all headings to one heading.

Columns: `heading_deg` (0 following seas, 90 beam seas to port, 180 head seas), `omega_radps`,
`roll_re` and `roll_im` [rad per m of wave amplitude] and, where the ship's heave is known,
`heave_re` and `heave_im` [m/m], as factors of exp(i omega t) at the ship's origin, in the axes of
theory E1; other columns are ignored. All headings have the same frequencies.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

from pydantic import Field

from tauto_core.scene.csv_columns import Columns, read_columns
from tauto_core.scene.data import source_name
from tauto_core.scene.errors import SceneError
from tauto_core.scene.fields import Section, Text
from tauto_core.ship.sea_sections import Heading

HEADING, OMEGA, SPEED = 'heading_deg', 'omega_radps', 'speed_mps'
ROLL = ('roll_re', 'roll_im')
HEAVE = ('heave_re', 'heave_im')
_FORM = (
    f'Give a CSV file with the columns {HEADING}, {OMEGA}, {", ".join(ROLL)} and, for the heave, '
    f'{", ".join(HEAVE)}.'
)


class RaoFile(Section):
    """An operator from a file; the scene that runs contains its values at the heading."""

    path: Text = Field(description='CSV file of the operator')
    heading: Heading = Field(
        description='direction in which the waves run, from the bow to port [rad]: 0 following '
        'seas, 1.5708 beam seas, 3.1416 head seas'
    )


def read_operator(asked: RaoFile) -> dict[str, Any]:
    """Return the keys of `ship.rao`: the operator at one heading, linear between two of the file.

    A ship is symmetric: waves to starboard (heading > pi) are those to port mirrored, with the
    roll of the other sign.

    Args:
        asked: the file and the heading.

    Raises:
        SceneError: a file that cannot be read, an operator of a ship under way, frequencies that
            do not increase or differ between headings, a heading outside the file's; with the
            line.
    """
    optional = (*HEAVE, SPEED)
    table = read_columns(asked.path, (HEADING, OMEGA, *ROLL), optional, remedy=_FORM)
    _check_at_rest(table)
    blocks = _by_heading(table)
    mirrored = asked.heading > math.pi
    heading = math.degrees(math.tau - asked.heading if mirrored else asked.heading)
    below, above, share = _neighbours(asked, sorted(blocks), heading)
    sign = -1.0 if mirrored else 1.0
    columns = {'roll_real': ROLL[0], 'roll_imaginary': ROLL[1]}
    if all(column in table.values for column in HEAVE):
        columns |= {'heave_real': HEAVE[0], 'heave_imaginary': HEAVE[1]}
    keys: dict[str, Any] = {
        'source': source_name(asked.path),
        'heading': asked.heading,
        'angular_frequency': [table.values[OMEGA][row] for row in blocks[below]],
    }
    for key, column in columns.items():
        factor, values = sign if column in ROLL else 1.0, table.values[column]
        rows = zip(blocks[below], blocks[above], strict=True)
        keys[key] = [factor * ((1.0 - share) * values[i] + share * values[j]) for i, j in rows]
    return keys


def _check_at_rest(table: Columns) -> None:
    for line, speed in zip(table.lines, table.values.get(SPEED, []), strict=False):
        if speed != 0.0:
            problem = 'must be 0: the operator of a ship at rest is carried over to ship.speed'
            remedy = f'Keep the rows at rest, or drop the column {SPEED} if they are.'
            raise SceneError(table.name, f'line {line}, {SPEED}', speed, problem, remedy)


def _by_heading(table: Columns) -> dict[float, list[int]]:
    """Return the rows of each heading [deg]; all must have the same increasing frequencies."""
    blocks: dict[float, list[int]] = {}
    for row, heading in enumerate(table.values[HEADING]):
        blocks.setdefault(heading, []).append(row)
    omega = table.values[OMEGA]
    first = next(iter(blocks.values()))
    for where, value, problem in _wrong_frequencies(table, blocks, first):
        remedy = 'Give every heading the same frequencies, in rising order.'
        raise SceneError(table.name, f'{where}, {OMEGA}', value, problem, remedy)
    if len(first) < 2:
        problem = 'is not enough: an operator needs at least 2 frequencies'
        remedy = 'Give it at more frequencies.'
        raise SceneError(table.name, OMEGA, omega[first[0]], problem, remedy)
    return blocks


def _wrong_frequencies(
    table: Columns, blocks: dict[float, list[int]], first: list[int]
) -> Iterator[tuple[str, float, str]]:
    omega, lines = table.values[OMEGA], table.lines
    if not omega[first[0]] > 0.0:
        yield f'line {lines[first[0]]}', omega[first[0]], 'must be greater than 0 rad/s'
    for heading, rows in blocks.items():
        for before, row in pairwise(rows):
            if not omega[row] > omega[before]:
                problem = f'must be greater than the one before, {omega[before]!r} rad/s'
                yield f'line {lines[row]}', omega[row], problem
        if [omega[row] for row in rows] != [omega[row] for row in first]:
            problem = (
                f'begins a heading, {heading:g} deg, whose frequencies are not the first one’s'
            )
            yield f'line {lines[rows[0]]}', omega[rows[0]], problem


def _neighbours(
    asked: RaoFile, headings: list[float], heading: float
) -> tuple[float, float, float]:
    """Return the neighbouring headings of the file [deg], and the weight of the upper one."""
    # a heading in radians never equals 90 degrees to the last bit
    near = min(headings, key=lambda each: abs(each - heading))
    if abs(near - heading) < 1e-9:
        return near, near, 0.0
    if not headings[0] < heading < headings[-1]:
        problem = (
            f'is {heading:.6g} deg off following seas, but the operator {asked.path} covers '
            f'{headings[0]:g} to {headings[-1]:g} deg'
        )
        remedy = 'Choose a heading that it covers; extrapolating it would be a guess.'
        raise SceneError(asked.path, 'heading', asked.heading, problem, remedy)
    above = next(each for each in headings if each > heading)
    below = headings[headings.index(above) - 1]
    return below, above, (heading - below) / (above - below)
