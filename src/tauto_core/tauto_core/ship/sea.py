"""A long-crested sea, its components, and the response of a ship to them (theory/sea.md)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tauto_core.curves.numerics import akima
from tauto_core.samples import FloatArray
from tauto_core.ship.motions import SixMotions
from tauto_core.ship.sections import ANGLES, ATHWART, Rao, Roll, Sea, SpectrumTable
from tauto_core.ship.waves import Encounter, Harmonics

if TYPE_CHECKING:
    from tauto_core.ship.hull import ClockPlace, Response


LOWEST = 0.5
_STREAM = 1  # keeps the sea apart from observations, which use SeedSequence([seed, k])


def bretschneider(
    omega: FloatArray, significant_wave_height: float, peak_period: float
) -> FloatArray:
    """Return the Bretschneider spectrum S(ω) [m2 s/rad], ω > 0 [rad/s].

    S = 5/16 Hs² ω_p⁴/ω⁵ exp(-5/4 (ω_p/ω)⁴), ω_p = 2π/Tp, with the integral Hs²/16 (ITTC
    7.5-02-07-01.1, two-parameter form).
    """
    peak = 2.0 * np.pi / peak_period
    scale = 5.0 / 16.0 * significant_wave_height**2 * peak**4
    spectrum: FloatArray = scale / omega**5 * np.exp(-1.25 * (peak / omega) ** 4)
    return spectrum


def jonswap_shape(omega: FloatArray, peak_period: float, gamma: float) -> FloatArray:
    """Return the JONSWAP factor on Bretschneider's shape (Hasselmann et al. 1973), γ ≥ 1.

    γ^exp(-(ω - ω_p)²/(2 σ² ω_p²)), σ = 0.07 up to the peak, 0.09 beyond. The caller scales the
    spectrum to Hs.
    """
    ratio = omega * peak_period / (2.0 * np.pi)
    sigma = np.where(ratio <= 1.0, 0.07, 0.09)
    shape: FloatArray = gamma ** np.exp(-((ratio - 1.0) ** 2) / (2.0 * sigma**2))
    return shape


def energy_below(spectrum: SpectrumTable, frequency: FloatArray) -> FloatArray:
    """Return the exact integral of a spectrum, linear between its rows, up to a frequency [m2].

    The frequency [Hz] is within the rows.
    """
    rows, density = np.array(spectrum.frequency), np.array(spectrum.energy_density)
    width = np.diff(rows)
    sums = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * width)])
    row = np.clip(np.searchsorted(rows, frequency, side='right') - 1, 0, len(rows) - 2)
    into = frequency - rows[row]
    bent = 0.5 * (np.diff(density) / width)[row]
    energy: FloatArray = sums[row] + into * (density[row] + bent * into)
    return energy


def height_and_period(sea: Sea | SpectrumTable) -> tuple[float, float]:
    """Return the significant wave height [m] and the peak period [s] of a spectrum.

    For a measured one Hs = 4 √m0, with m0 its integral, and Tp belongs to the row with the most
    energy.
    """
    if isinstance(sea, Sea):
        return sea.significant_wave_height, sea.peak_period
    energy = energy_below(sea, np.array(sea.frequency[-1]))
    peak = sea.frequency[int(np.argmax(sea.energy_density))]
    return 4.0 * math.sqrt(float(energy)), 1.0 / peak


def band_hz(sea: Sea | SpectrumTable) -> tuple[float, float]:
    """Return the lowest and the highest frequency of the components [Hz].

    For a standard spectrum half to `cutoff` times the peak frequency (with 4, all but 0.5 % of the
    energy). For a measured one the rows with energy and one more on either side.
    """
    if isinstance(sea, Sea):
        return LOWEST / sea.peak_period, sea.cutoff / sea.peak_period
    waves = np.flatnonzero(sea.energy_density)
    low, high = max(int(waves[0]) - 1, 0), min(int(waves[-1]) + 1, len(sea.frequency) - 1)
    return sea.frequency[low], sea.frequency[high]


def elevation(sea: Sea | SpectrumTable, seed: int, stream: int = 0) -> Harmonics:
    """Return the wave elevation at a ship at rest, sum a_i cos(ω_i t + ε_i) [m].

    The band is divided into `components` bins of equal ratio. PCG64 draws each ω_i uniformly
    within its bin and ε_i uniformly over a turn, so the frequencies are incommensurate and the sea
    does not repeat. a_i = √(2 S(ω_i) Δω_i), scaled by a common factor to 4 √(sum a_i²/2) = Hs. For
    a measured spectrum a_i²/2 is the energy of the bin. Different streams of one seed give
    independent seas.
    """
    spawn_key = (_STREAM, stream) if stream else (_STREAM,)
    random = np.random.Generator(
        np.random.PCG64(np.random.SeedSequence(seed, spawn_key=spawn_key))
    )
    if isinstance(sea, SpectrumTable):
        edges_hz = np.geomspace(*band_hz(sea), sea.components + 1)
        edges = 2.0 * np.pi * edges_hz
    else:
        edges = (
            2.0 * np.pi / sea.peak_period * np.geomspace(LOWEST, sea.cutoff, sea.components + 1)
        )
    width = np.diff(edges)
    omega = edges[:-1] + width * random.random(sea.components)
    phase = 2.0 * np.pi * random.random(sea.components)
    if isinstance(sea, SpectrumTable):
        # rounding may make an empty bin negative
        energy = np.maximum(np.diff(energy_below(sea, edges_hz)), 0.0)
        return Harmonics(np.sqrt(2.0 * energy), 2.0 * np.pi / omega, phase)
    spectrum = bretschneider(omega, sea.significant_wave_height, sea.peak_period)
    if sea.spectrum == 'jonswap':
        spectrum = spectrum * jonswap_shape(omega, sea.peak_period, sea.gamma)
    amplitude = np.sqrt(2.0 * spectrum * width)
    height = 4.0 * np.sqrt(0.5 * np.sum(amplitude**2))
    return Harmonics(
        amplitude * (sea.significant_wave_height / height), 2.0 * np.pi / omega, phase
    )


# -----------------------------------------------------------------------------
# The roll of a ship in the waves that it meets (theory/sea.md).


def roll_answer(waves: Harmonics, roll: Roll, course: Encounter) -> Harmonics:
    """Return the steady roll of ρ̈ + 2 ζ w ρ̇ + w² ρ = w² κ slope [rad], w = 2π/natural_period.

    Beam seas run to port, with elevation a cos(ω t - k y + ε). In deep water the slope to port at
    the ship is (a ω²/g) sin(μ) cos(ω_e t + ε - π/2). A surface that rises to port turns the
    starboard side down, which is positive. With H = w² κ/(w² - ω_e² + 2 i ζ w ω_e), roll = |H|
    slope at phase + arg H. `waves` have the frequencies ω at rest.
    """
    omega = waves.angular_frequency
    met = course.frequency(omega)
    natural = 2.0 * np.pi / roll.natural_period
    answer = (
        natural**2
        * (roll.slope_coefficient or 0.0)
        / (natural**2 - met**2 + 2j * roll.damping_ratio * natural * met)
    )
    across = math.sin(course.heading)
    slope = waves.amplitude * omega**2 / course.gravity * abs(across)
    # waves to starboard heel the ship the other way
    lead = -0.5 * np.pi if across >= 0.0 else 0.5 * np.pi
    return course.answer(waves, slope * np.abs(answer), lead + np.angle(answer))


# -----------------------------------------------------------------------------
# The motions of a ship by its response amplitude operator (theory/sea.md).


@dataclass(frozen=True)
class Answer:
    """The motions of a ship by an operator, per metre of wave amplitude.

    Attributes:
        waves: the waves that move the ship.
        motions: by name, factors of exp(iω_e t), (n,) each.
        above: share of the energy of waves beyond the operator's highest frequency.
        below: share of the energy of waves below its lowest.
    """

    waves: Harmonics
    motions: dict[str, NDArray[np.complex128]]
    above: float
    below: float


def operator_answer(waves: Harmonics, rao: Rao, course: Encounter, *, heave: bool) -> Answer:
    """Return a ship's motions by its response operator: all, or roll and, if set, heave.

    Values are linear between the operator's speeds and headings, and Akima's interpolant between
    its frequencies. An operator at rest is carried over to another speed as follows. Roll responds
    to the wave slope at ω_e: R(ω_e) (ω/ω_e)² for the operator R [rad/m], and minus the conjugate
    if the ship overtakes the waves. Heave and pitch follow the wave averaged over the hull, so
    they are read at ω. Surge, sway and yaw, restrained by inertia alone, keep their accelerations
    at rest: read at ω, times (ω/ω_e)². Below `LEAST_ENCOUNTER` ω helm and sails hold the ship
    (`hull.Hull.response`).

    Waves longer than the operator's longest move the ship as their surface does: displacements as
    at the lowest frequency, angles as ω². Shorter ones do not move it.

    Raises:
        HullError: a heading or speed that the operator does not cover.
    """
    from tauto_core.ship.hull import LEAST_ENCOUNTER  # only when needed

    check_operator(rao, course.heading, course.speed)
    omega = waves.angular_frequency
    met, at_rest = course.frequency(omega), rao.speeds is None
    names = rao.motions if heave or rao.turns_in_space else ('roll',)
    reads = {name: np.abs(met) if name == 'roll' and at_rest else omega for name in names}
    low, high = rao.angular_frequency[0], rao.angular_frequency[-1]
    shorter = np.max(list(reads.values()), axis=0) > high
    longer = ~shorter & (np.min(list(reads.values()), axis=0) < low)
    energy = waves.amplitude**2 / np.sum(waves.amplitude**2)
    mask = ~shorter
    mask[0] |= not mask.any()  # a sum has at least one wave
    components = Harmonics(waves.amplitude[mask], waves.period[mask], waves.phase[mask])
    omega, met = omega[mask], met[mask]
    answered = {}
    for name in names:
        read = reads[name][mask]
        at = np.clip(read, low, high)
        values = np.where(read > high, 0.0, _operator_values(rao, name, course, at))
        if name == 'roll' and at_rest:
            # the slope's factor -i belongs to the wave, the rest to the ship
            values = values * (omega / at) ** 2
            values = np.where(met < 0.0, -np.conj(values), values)
        elif name in ANGLES:
            values = values * (read / at) ** 2
        if at_rest and course.speed and name in ('surge', 'sway', 'yaw'):
            values = values * (omega / np.maximum(np.abs(met), LEAST_ENCOUNTER * omega)) ** 2
        answered[name] = values
    return Answer(components, answered, float(energy[shorter].sum()), float(energy[longer].sum()))


def check_operator(rao: Rao, heading: float, speed: float) -> None:
    """Refuse a heading [rad] or speed [m/s] that an operator does not cover.

    Raises:
        HullError: a heading or speed outside the operator's, or, at a known length, a Froude
            number above `MOST_FROUDE` for an operator at rest.
    """
    from tauto_core.ship.hull import HullError, check_froude  # only when needed

    to_port = min(heading, math.tau - heading)
    if rao.headings is not None and neighbours(rao.headings, to_port) is None:
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
    elif neighbours(rao.speeds, speed) is None:
        raise HullError(
            'speed',
            speed,
            f'must be in [{rao.speeds[0]:g}, {rao.speeds[-1]:g}] m/s, the speeds of the operator',
            'Sail within them, or use an operator that covers the speed.',
        )


def neighbours(rows: Sequence[float], at: float) -> tuple[int, int, float] | None:
    """Return the indices of the rows around a value and the weight of the upper one.

    `None` outside of the rows.
    """
    nearest = min(range(len(rows)), key=lambda row: abs(rows[row] - at))
    # degrees converted to radians are off by rounding
    if abs(rows[nearest] - at) < 1e-9:
        return nearest, nearest, 0.0
    if not rows[0] < at < rows[-1]:
        return None
    above = next(row for row, value in enumerate(rows) if value > at)
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
            low, high, share = (rows and neighbours(rows, at)) or (0, 0, 0.0)
            values = (
                values[low] if low == high else (1.0 - share) * values[low] + share * values[high]
            )
        parts.append(akima(np.array(frequency), values, omega))
    answer = np.asarray(parts[0] + 1j * parts[1])
    return -answer if mirrored and name in ATHWART else answer


# -----------------------------------------------------------------------------
# The motions of a hull at the place of the clock (hull.md).


def at_clock(
    waves: Harmonics, response: Response, place: ClockPlace, course: Encounter
) -> SixMotions[Harmonics]:
    """Return the motions at a place in a ship from its response in each of the waves, (n,).

    The waves are the elevation at the ship's origin [m], with the frequencies at rest.
    """
    factors = np.concatenate((response.displacement(place), response.motions[:, 3:]), axis=1)
    return SixMotions(
        *(
            course.answer(waves, waves.amplitude * np.abs(factor), np.angle(factor))
            for factor in factors.T
        )
    )
