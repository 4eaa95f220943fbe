"""The motions of a ship by her response amplitude operator (theory/sea.md, E5)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tauto_core.curves.numerics import akima
from tauto_core.samples import FloatArray
from tauto_core.ship.hull import LEAST_ENCOUNTER, HullError, check_froude
from tauto_core.ship.sections import ANGLES, ATHWART, Rao
from tauto_core.ship.waves import Encounter, Harmonics


@dataclass(frozen=True)
class Answer:
    """The motions of a ship by an operator, per metre of wave amplitude.

    Attributes:
        waves: the waves that move her.
        motions: by name, factors of exp(iω_e t), (n,) each.
        above: share of the energy of waves beyond the operator's highest frequency.
        below: the same under its lowest.
    """

    waves: Harmonics
    motions: dict[str, NDArray[np.complex128]]
    above: float
    below: float


def operator_answer(waves: Harmonics, rao: Rao, course: Encounter, *, heave: bool) -> Answer:
    """Return the motions of a ship by her response operator: all, or roll and, if set, heave.

    Linear between the speeds and headings of the operator; Akima's interpolant joins its values
    at the frequencies. An operator of a ship at rest is carried over to another speed. The roll
    responds to the wave slope at the encounter frequency, R(ω_e) (ω/ω_e)² for the operator R
    [rad/m], as in `roll_answer`; where the ship overtakes the waves it is minus the conjugate of
    that. Heave and pitch are those of the wave averaged over the hull, which depends on the
    wavelength, so their operators are read at ω. So are those of surge, sway and yaw, which
    nothing but inertia holds back, times (ω/ω_e)²: the acceleration is that at rest. Below
    `LEAST_ENCOUNTER` ω helm and sails hold her (`hull.Hull.response`).

    Waves longer than those of the operator move her as their surface does: displacements as at
    its lowest frequency, angles as ω². Shorter ones do not move her.

    Raises:
        HullError: a heading or speed that the operator does not cover.
    """
    check_operator(rao, course.heading, course.speed)
    omega = waves.angular_frequency
    met, at_rest = course.frequency(omega), rao.speeds is None
    asked = rao.motions if heave or rao.turns_in_space else ('roll',)
    reads = {name: np.abs(met) if name == 'roll' and at_rest else omega for name in asked}
    low, high = rao.angular_frequency[0], rao.angular_frequency[-1]
    shorter = np.max(list(reads.values()), axis=0) > high
    longer = ~shorter & (np.min(list(reads.values()), axis=0) < low)
    energy = waves.amplitude**2 / np.sum(waves.amplitude**2)
    inside = ~shorter
    inside[0] |= not inside.any()  # a sum has at least one wave
    kept = Harmonics(waves.amplitude[inside], waves.period[inside], waves.phase[inside])
    omega, met = omega[inside], met[inside]
    answered = {}
    for name in asked:
        read = reads[name][inside]
        at = np.clip(read, low, high)
        values = np.where(read > high, 0.0, _operator_values(rao, name, course, at))
        if name == 'roll' and at_rest:
            # the factor -i of the slope belongs to the wave, the rest to the ship's response
            values = values * (omega / at) ** 2
            values = np.where(met < 0.0, -np.conj(values), values)
        elif name in ANGLES:
            values = values * (read / at) ** 2
        if at_rest and course.speed and name in ('surge', 'sway', 'yaw'):
            values = values * (omega / np.maximum(np.abs(met), LEAST_ENCOUNTER * omega)) ** 2
        answered[name] = values
    return Answer(kept, answered, float(energy[shorter].sum()), float(energy[longer].sum()))


def check_operator(rao: Rao, heading: float, speed: float) -> None:
    """Refuse a heading [rad] or speed [m/s] that an operator does not cover.

    Raises:
        HullError: it lies outside its headings or speeds; or an operator at rest is carried over
            to a Froude number above `MOST_FROUDE`, where the length of the ship is known.
    """
    to_port = min(heading, math.tau - heading)
    if rao.headings is not None and _between(rao.headings, to_port) is None:
        low, high = rao.headings[0], rao.headings[-1]
        raise HullError(
            'heading',
            heading,
            f'is {math.degrees(to_port):.4g}° off following seas; the operator covers '
            f'{math.degrees(low):.4g}° to {math.degrees(high):.4g}°',
            'Give an operator that covers it, or one heading for all seas as ship.rao.heading.',
        )
    if rao.speeds is None:
        if rao.length is not None:
            check_froude(speed, rao.length)
    elif _between(rao.speeds, speed) is None:
        raise HullError(
            'speed',
            speed,
            f'must lie in [{rao.speeds[0]:g}, {rao.speeds[-1]:g}] m/s, the speeds of the operator',
            'Give an operator that covers it, or another speed.',
        )


def _between(rows: Sequence[float], at: float) -> tuple[int, int, float] | None:
    """Return the rows beside a value and the weight of the upper one; None outside of them."""
    nearest = min(range(len(rows)), key=lambda row: abs(rows[row] - at))
    # degrees turned into radians miss by rounding
    if abs(rows[nearest] - at) < 1e-9:
        return nearest, nearest, 0.0
    if not rows[0] < at < rows[-1]:
        return None
    above = next(row for row, each in enumerate(rows) if each > at)
    return above - 1, above, (at - rows[above - 1]) / (rows[above] - rows[above - 1])


def _operator_values(
    rao: Rao, name: str, course: Encounter, omega: FloatArray
) -> NDArray[np.complex128]:
    """Return a motion of an operator at frequencies within its own, for waves from any side."""
    frequency, headings, speeds = (
        rao.angular_frequency,
        rao.headings or (0.0,),
        rao.speeds or (0.0,),
    )
    mirrored = rao.headings is not None and course.heading > math.pi
    parts = []
    for part in ('real', 'imaginary'):
        values = np.reshape(
            getattr(rao, f'{name}_{part}'), (len(speeds), len(headings), len(frequency))
        )
        for rows, at in (
            (rao.speeds, course.speed),
            (rao.headings, min(course.heading, math.tau - course.heading)),
        ):
            low, high, share = (rows and _between(rows, at)) or (0, 0, 0.0)
            values = (
                values[low] if low == high else (1.0 - share) * values[low] + share * values[high]
            )
        parts.append(akima(np.array(frequency), values, omega))
    found = np.asarray(parts[0] + 1j * parts[1])
    return -found if mirrored and name in ATHWART else found
