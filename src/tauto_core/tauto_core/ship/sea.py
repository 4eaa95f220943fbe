"""A long-crested sea, its components, and the response of a ship to them (theory/sea.md, E5)."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.samples import FloatArray
from tauto_core.ship.sections import Roll, Sea, SpectrumTable
from tauto_core.ship.waves import Encounter, Harmonics

LOWEST = 0.5
_STREAM = 1  # keeps the sea apart from observations, which use SeedSequence([seed, k])


def bretschneider(
    omega: FloatArray, significant_wave_height: float, peak_period: float
) -> FloatArray:
    """Return the Bretschneider spectrum S(ω) [m2 s/rad], ω > 0 [rad/s].

    S = 5/16 Hs² ω_p⁴/ω⁵ exp(-5/4 (ω_p/ω)⁴), ω_p = 2π/Tp, whose integral
    is Hs²/16 (ITTC 7.5-02-07-01.1, two-parameter form).
    """
    peak = 2.0 * np.pi / peak_period
    scale = 5.0 / 16.0 * significant_wave_height**2 * peak**4
    spectrum: FloatArray = scale / omega**5 * np.exp(-1.25 * (peak / omega) ** 4)
    return spectrum


def jonswap_shape(omega: FloatArray, peak_period: float, gamma: float) -> FloatArray:
    """Return the factor of JONSWAP on the Bretschneider shape (Hasselmann et al. 1973), γ ≥ 1.

    γ^exp(-(ω - ω_p)²/(2 σ² ω_p²)), σ = 0.07 up to the peak, 0.09
    beyond. The height of the spectrum is then set by Hs.
    """
    ratio = omega * peak_period / (2.0 * np.pi)
    sigma = np.where(ratio <= 1.0, 0.07, 0.09)
    shape: FloatArray = gamma ** np.exp(-((ratio - 1.0) ** 2) / (2.0 * sigma**2))
    return shape


def energy_below(spectrum: SpectrumTable, frequency: FloatArray) -> FloatArray:
    """Return the energy of a measured spectrum below a frequency [Hz], its exact integral [m2].

    The spectrum is linear between its rows, within which the frequency lies.
    """
    rows, density = np.array(spectrum.frequency), np.array(spectrum.energy_density)
    width = np.diff(rows)
    before = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * width)])
    row = np.clip(np.searchsorted(rows, frequency, side='right') - 1, 0, len(rows) - 2)
    into = frequency - rows[row]
    bent = 0.5 * (np.diff(density) / width)[row]
    energy: FloatArray = before[row] + into * (density[row] + bent * into)
    return energy


def height_and_period(sea: Sea | SpectrumTable) -> tuple[float, float]:
    """Return the significant wave height [m] and the peak period [s] of a spectrum.

    For a measured one Hs = 4 √(m0), m0 its integral; Tp is that of the row with the most
    energy.
    """
    if isinstance(sea, Sea):
        return sea.significant_wave_height, sea.peak_period
    energy = energy_below(sea, np.array(sea.frequency[-1]))
    peak = sea.frequency[int(np.argmax(sea.energy_density))]
    return 4.0 * math.sqrt(float(energy)), 1.0 / peak


def band_hz(sea: Sea | SpectrumTable) -> tuple[float, float]:
    """Return the lowest and the highest frequency of the components [Hz].

    Half to `cutoff` times the peak frequency (4: all but 0.5 % of a Bretschneider sea's energy);
    for a measured spectrum all rows between the outermost ones with energy.
    """
    if isinstance(sea, Sea):
        return LOWEST / sea.peak_period, sea.cutoff / sea.peak_period
    waves = np.flatnonzero(sea.energy_density)
    first, last = max(int(waves[0]) - 1, 0), min(int(waves[-1]) + 1, len(sea.frequency) - 1)
    return sea.frequency[first], sea.frequency[last]


def elevation(sea: Sea | SpectrumTable, seed: int, stream: int = 0) -> Harmonics:
    """Return the wave elevation at a ship at rest, sum a_i cos(ω_i t + ε_i) [m].

    The band is divided into `components` bins of equal ratio. Each ω_i is drawn uniformly
    within its bin and ε_i uniformly over a turn (PCG64), so no two frequencies are commensurate
    and the sea does not repeat. a_i = √(2 S(ω_i) Δω_i), times a common factor that makes 4
    √(sum a_i²/2) equal to Hs to rounding. For a measured spectrum a_i²/2 is the energy of the
    bin itself. Seas of different streams from one seed are independent.
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
# The roll of a ship in the waves that it meets (theory/sea.md, E5).


def roll_answer(waves: Harmonics, roll: Roll, course: Encounter) -> Harmonics:
    """Return the steady roll of ρ̈ + 2 ζ w ρ̇ + w² ρ = w² κ slope [rad], w = 2π/natural_period.

    In beam seas waves run to port, elevation a cos(ω t - k y + ε). So in deep water the
    slope to port at the ship is (a ω²/g) sin(μ) cos(ω_e t + ε - π/2). A surface that
    rises to port turns the starboard side down, which is positive. The transfer function is
    H = w² κ/(w² - ω_e² + 2 i ζ w ω_e), and roll = |H| slope at phase + arg H. The waves have the
    frequencies ω of a ship at rest.
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
