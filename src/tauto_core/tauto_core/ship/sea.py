"""A long-crested sea: its spectrum, and the components that represent it (theory E5)."""

from __future__ import annotations

import math

import numpy as np

from tauto_core.samples import FloatArray
from tauto_core.ship.sea_sections import Sea, SpectrumTable
from tauto_core.ship.waves import Harmonics

LOWEST = 0.5
HIGHEST = 4.0
_STREAM = 1  # keeps the sea apart from observations, which use SeedSequence([seed, k])


def bretschneider(
    omega: FloatArray, significant_wave_height: float, peak_period: float
) -> FloatArray:
    """Return the Bretschneider spectrum S(omega) [m2 s/rad], shape of `omega`.

    S = 5/16 Hs^2 omega_p^4/omega^5 exp(-5/4 (omega_p/omega)^4), omega_p = 2 pi/Tp, whose integral
    is Hs^2/16 (ITTC 7.5-02-07-01.1, two-parameter form).

    Args:
        omega: angular frequency [rad/s], > 0.
        significant_wave_height: Hs [m].
        peak_period: Tp [s].
    """
    peak = 2.0 * np.pi / peak_period
    scale = 5.0 / 16.0 * significant_wave_height**2 * peak**4
    spectrum: FloatArray = scale / omega**5 * np.exp(-1.25 * (peak / omega) ** 4)
    return spectrum


def jonswap_shape(omega: FloatArray, peak_period: float, gamma: float) -> FloatArray:
    """Return the factor of JONSWAP on the Bretschneider shape (Hasselmann et al. 1973).

    gamma^exp(-(omega - omega_p)^2/(2 sigma^2 omega_p^2)), sigma = 0.07 up to the peak, 0.09
    beyond. The height of the spectrum is then set by Hs.

    Args:
        omega: angular frequency [rad/s], > 0.
        peak_period: Tp [s].
        gamma: peak enhancement factor, >= 1.
    """
    ratio = omega * peak_period / (2.0 * np.pi)
    sigma = np.where(ratio <= 1.0, 0.07, 0.09)
    shape: FloatArray = gamma ** np.exp(-((ratio - 1.0) ** 2) / (2.0 * sigma**2))
    return shape


def energy_below(spectrum: SpectrumTable, frequency: FloatArray) -> FloatArray:
    """Return the energy of a measured spectrum below a frequency, its exact integral [m2].

    Args:
        spectrum: linear between its rows, zero outside them.
        frequency: [Hz], within the rows, any shape.
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

    For a measured one Hs = 4 sqrt(m0), m0 its integral; Tp is that of the row with the most
    energy.
    """
    if isinstance(sea, Sea):
        return sea.significant_wave_height, sea.peak_period
    energy = energy_below(sea, np.array(sea.frequency[-1]))
    peak = sea.frequency[int(np.argmax(sea.energy_density))]
    return 4.0 * math.sqrt(float(energy)), 1.0 / peak


def band_hz(sea: Sea | SpectrumTable) -> tuple[float, float]:
    """Return the lowest and the highest frequency of the components [Hz].

    Half to four times the peak frequency (all but 0.5 % of a Bretschneider sea's energy); for a
    measured spectrum all rows between the outermost ones with energy.
    """
    if isinstance(sea, Sea):
        return LOWEST / sea.peak_period, HIGHEST / sea.peak_period
    waves = np.flatnonzero(sea.energy_density)
    first, last = max(int(waves[0]) - 1, 0), min(int(waves[-1]) + 1, len(sea.frequency) - 1)
    return sea.frequency[first], sea.frequency[last]


def elevation(sea: Sea | SpectrumTable, seed: int, stream: int = 0) -> Harmonics:
    """Return the wave elevation at a ship at rest, sum a_i cos(omega_i t + eps_i) [m].

    The band is divided into `components` bins of equal ratio. Each omega_i is drawn uniformly
    within its bin and eps_i uniformly over a turn, so no two frequencies are commensurate and the
    sea does not repeat. a_i = sqrt(2 S(omega_i) delta omega_i), times a common factor that makes 4
    sqrt(sum a_i^2/2) equal to Hs to rounding. For a measured spectrum a_i^2/2 is the energy of the
    bin itself.

    Args:
        sea: spectrum and number of components.
        seed: seed of the PCG64 generator.
        stream: number of the stream of random numbers from the seed, >= 0; seas of different
            streams are independent.
    """
    spawn_key = (_STREAM, stream) if stream else (_STREAM,)
    random = np.random.Generator(
        np.random.PCG64(np.random.SeedSequence(seed, spawn_key=spawn_key))
    )
    if isinstance(sea, SpectrumTable):
        edges_hz = np.geomspace(*band_hz(sea), sea.components + 1)
        edges = 2.0 * np.pi * edges_hz
    else:
        edges = 2.0 * np.pi / sea.peak_period * np.geomspace(LOWEST, HIGHEST, sea.components + 1)
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
