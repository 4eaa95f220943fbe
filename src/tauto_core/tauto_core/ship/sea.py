"""A long-crested sea and the ship's linear answer to it (theory E5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tauto_core.samples import FloatArray
from tauto_core.scene import SceneError
from tauto_core.scene.models import Scene
from tauto_core.scene.ships import Roll, Sea, SeaShip
from tauto_core.ship.waves import Harmonics

LOWEST = 0.5
HIGHEST = 4.0
_STREAM = 1  # observations draw from SeedSequence([seed, k]); this keeps the sea apart


@dataclass(frozen=True)
class SeaMotion:
    """Wave elevation at the ship [m], upwards, and the roll it makes [rad]."""

    elevation: Harmonics
    roll: Harmonics


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
    """Return what JONSWAP multiplies the Bretschneider shape by (Hasselmann et al. 1973).

    gamma^exp(-(omega - omega_p)^2/(2 sigma^2 omega_p^2)), sigma = 0.07 up to the peak, 0.09
    beyond. The height of the spectrum is then set by Hs.

    Args:
        omega: angular frequency [rad/s], > 0.
        peak_period: Tp [s].
        gamma: peak enhancement, >= 1.
    """
    ratio = omega * peak_period / (2.0 * np.pi)
    sigma = np.where(ratio <= 1.0, 0.07, 0.09)
    shape: FloatArray = gamma ** np.exp(-((ratio - 1.0) ** 2) / (2.0 * sigma**2))
    return shape


def elevation(sea: Sea, seed: int) -> Harmonics:
    """Return the wave elevation at the ship, sum a_i cos(omega_i t + eps_i) [m].

    The band from half to four times the peak frequency (all but 0.5 % of a Bretschneider sea's
    energy) is cut into `components` bins of equal ratio. Each omega_i is drawn uniformly within
    its bin and eps_i uniformly over a turn, so that no two are commensurate and the sea does not
    repeat. a_i = sqrt(2 S(omega_i) delta omega_i), times one common factor that makes the
    significant height 4 sqrt(sum a_i^2/2) equal Hs to rounding.

    Args:
        sea: spectrum, Hs, Tp, number of components.
        seed: of the PCG64 generator.
    """
    edges = 2.0 * np.pi / sea.peak_period * np.geomspace(LOWEST, HIGHEST, sea.components + 1)
    random = np.random.Generator(
        np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(_STREAM,)))
    )
    width = np.diff(edges)
    omega = edges[:-1] + width * random.random(sea.components)
    phase = 2.0 * np.pi * random.random(sea.components)
    spectrum = bretschneider(omega, sea.significant_wave_height, sea.peak_period)
    if sea.spectrum == 'jonswap':
        spectrum = spectrum * jonswap_shape(omega, sea.peak_period, sea.gamma)
    amplitude = np.sqrt(2.0 * spectrum * width)
    height = 4.0 * np.sqrt(0.5 * np.sum(amplitude**2))
    return Harmonics(
        amplitude * (sea.significant_wave_height / height), 2.0 * np.pi / omega, phase
    )


def roll_answer(waves: Harmonics, roll: Roll, gravity: float) -> Harmonics:
    """Return the steady roll of rho'' + 2 zeta w rho' + w^2 rho = w^2 kappa slope [rad].

    Waves run to port, elevation a cos(omega t - k y + eps), so that at the ship the slope to port
    is (a omega^2/g) cos(omega t + eps - pi/2) in deep water; a surface that rises to port
    turns the starboard side down: positive. The transfer is
    H = w^2 kappa/(w^2 - omega^2 + 2 i zeta w omega), and roll = |H| slope at phase + arg H.

    Args:
        waves: elevation at the ship [m].
        roll: w = 2 pi/natural_period, zeta, kappa.
        gravity: g [m/s2].
    """
    omega = waves.angular_frequency
    natural = 2.0 * np.pi / roll.natural_period
    answer = (
        natural**2
        * roll.slope_coefficient
        / (natural**2 - omega**2 + 2j * roll.damping_ratio * natural * omega)
    )
    return Harmonics(
        waves.amplitude * omega**2 / gravity * np.abs(answer),
        waves.period,
        waves.phase - 0.5 * np.pi + np.angle(answer),
    )


def sea_motion(scene: Scene, ship: SeaShip) -> SeaMotion:
    """Return elevation and roll of a scene with a sea.

    Raises:
        SceneError: the waves are too short for `ship.rate`, or the roll exceeds what a ship does.
    """
    sea = ship.sea
    if HIGHEST / sea.peak_period >= 0.5 * ship.rate:
        raise SceneError(
            scene.name,
            'ship.sea.peak_period',
            sea.peak_period,
            f'the shortest waves have {HIGHEST / sea.peak_period:.6g} Hz, which must be below '
            f'half of ship.rate ({ship.rate!r} Hz)',
            f'Raise ship.rate above {2.0 * HIGHEST / sea.peak_period:.6g} Hz.',
        )
    waves = elevation(sea, scene.seed)
    return SeaMotion(waves, roll_answer(waves, ship.roll, scene.gravity))


def sea_metadata(scene: Scene, ship: SeaShip) -> dict[str, Any]:
    """Return what a sea was made from, for reports."""
    sea = ship.sea
    metadata = {
        'spectrum': sea.spectrum,
        'significant_wave_height_m': sea.significant_wave_height,
        'peak_period_s': sea.peak_period,
        'components': sea.components,
        'band_hz': [LOWEST / sea.peak_period, HIGHEST / sea.peak_period],
        'seed': scene.seed,
        'heave': ship.heave,
    }
    return metadata | ({'gamma': sea.gamma} if sea.spectrum == 'jonswap' else {})
