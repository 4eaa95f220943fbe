"""The response of a ship to the waves that it meets: roll and heave (theory E5)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tauto_core.samples import FloatArray
from tauto_core.scene.errors import SceneError
from tauto_core.ship.cubic import akima
from tauto_core.ship.encounter import Course
from tauto_core.ship.sea_sections import Rao, Roll
from tauto_core.ship.waves import Harmonics

NEGLIGIBLE = 0.01
"""Share of the waves' energy that may lie outside a response operator; those waves are left out.
"""


@dataclass(frozen=True)
class Answer:
    """Roll [rad] and, where the operator has it, heave [m] of a ship; and what was left out.

    `left_out` is the share of the waves' energy outside the operator's frequencies.
    """

    roll: Harmonics
    heave: Harmonics | None
    left_out: float


def roll_answer(waves: Harmonics, roll: Roll, course: Course) -> Harmonics:
    """Return the steady roll of rho'' + 2 zeta w rho' + w^2 rho = w^2 kappa slope [rad].

    In beam seas waves run to port, elevation a cos(omega t - k y + eps). So in deep water the
    slope to port at the ship is (a omega^2/g) sin(mu) cos(omega_e t + eps - pi/2). A surface that
    rises to port turns the starboard side down, which is positive. The transfer function is
    H = w^2 kappa/(w^2 - omega_e^2 + 2 i zeta w omega_e), and roll = |H| slope at phase + arg H.

    Args:
        waves: elevation [m], with the frequencies omega of a ship at rest.
        roll: w = 2 pi/natural_period, zeta, kappa.
        course: speed, heading mu, gravity.
    """
    omega = waves.angular_frequency
    met = course.frequency(omega)
    natural = 2.0 * np.pi / roll.natural_period
    answer = (
        natural**2
        * roll.slope_coefficient
        / (natural**2 - met**2 + 2j * roll.damping_ratio * natural * met)
    )
    across = math.sin(course.heading)
    slope = waves.amplitude * omega**2 / course.gravity * abs(across)
    # waves to starboard heel the ship the other way
    lead = -0.5 * np.pi if across >= 0.0 else 0.5 * np.pi
    return course.answer(waves, slope * np.abs(answer), lead + np.angle(answer))


def operator_answer(
    scene_name: str, waves: Harmonics, rao: Rao, course: Course, *, heave: bool
) -> Answer:
    """Return roll and heave by the response operator of a ship at rest.

    Akima's interpolant joins the values of the operator. The roll responds to the wave slope at
    the encounter frequency, R(omega_e) (omega/omega_e)^2 for the operator R [rad/m], as in
    `roll_answer`; where the ship overtakes the waves it is minus the conjugate of that. The heave
    is that of the wave averaged over the hull, which depends on the wavelength, so its operator is
    read at omega.

    Args:
        scene_name: for errors.
        waves: elevation [m], with the frequencies omega of a ship at rest.
        rao: the operator at the heading of the course.
        course: speed, heading, gravity.
        heave: whether heave is asked for.

    Raises:
        SceneError: more than `NEGLIGIBLE` of the waves' energy lies outside the operator's
            frequencies. Waves outside are left out of the response, never extrapolated.
    """
    omega = waves.angular_frequency
    met = course.frequency(omega)
    low, high = rao.angular_frequency[0], rao.angular_frequency[-1]
    inside = (np.abs(met) >= low) & (np.abs(met) <= high)
    if heave:
        inside &= (omega >= low) & (omega <= high)
    energy = waves.amplitude**2
    left_out = float(np.sum(energy[~inside]) / np.sum(energy))
    if left_out > NEGLIGIBLE:
        raise _uncovered(scene_name, left_out, (omega, np.abs(met)), rao, course)
    kept = Harmonics(waves.amplitude[inside], waves.period[inside], waves.phase[inside])
    omega, met = omega[inside], met[inside]
    roll = _at(rao, rao.roll_real, rao.roll_imaginary, np.abs(met)) * (omega / met) ** 2
    # the factor -i of the slope belongs to the wave, the rest to the ship's response
    answered = [np.where(met < 0.0, -np.conj(roll), roll)]
    if heave and rao.heave_real is not None and rao.heave_imaginary is not None:
        answered.append(_at(rao, rao.heave_real, rao.heave_imaginary, omega))
    found = [
        course.answer(kept, kept.amplitude * np.abs(each), np.angle(each)) for each in answered
    ]
    return Answer(found[0], found[1] if len(found) > 1 else None, left_out)


def _at(
    rao: Rao, real: tuple[float, ...], imaginary: tuple[float, ...], omega: FloatArray
) -> NDArray[np.complex128]:
    frequency = np.array(rao.angular_frequency)
    parts = [akima(frequency, np.array(part), omega) for part in (real, imaginary)]
    return np.asarray(parts[0] + 1j * parts[1])


def _uncovered(
    name: str,
    share: float,
    of_waves: tuple[FloatArray, FloatArray],
    rao: Rao,
    course: Course,
) -> SceneError:
    omega, met = of_waves
    low, high = rao.angular_frequency[0], rao.angular_frequency[-1]
    encounter = (
        ''
        if course.speed == 0.0
        else f', met at {np.min(met):.4g} to {np.max(met):.4g} rad/s by a ship at '
        f'{course.speed:g} m/s'
    )
    return SceneError(
        name,
        'ship.rao.angular_frequency',
        [low, high],
        f'covers {low:.4g} to {high:.4g} rad/s, but the waves have {np.min(omega):.4g} to '
        f'{np.max(omega):.4g} rad/s{encounter}: {100.0 * share:.3g} % of their energy lies '
        f'outside, where at most {100.0 * NEGLIGIBLE:g} % may be left out',
        'Give an operator that reaches further, or another sea, heading or speed; it is not '
        'extrapolated.',
    )
