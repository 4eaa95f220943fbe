"""The error that the rate of a short run would cause on a voyage of the Act of 1714."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from tauto_core.machines import AnyMachine, FluidPendulum, HangingMachine
from tauto_core.machines.parts import Drag
from tauto_core.navigation.estimates import mean_rate
from tauto_core.navigation.kalman import ClockModel, Estimate, predict
from tauto_core.navigation.longitude import ARCMIN_PER_S
from tauto_core.navigation.rate_scatter import TOO_SHORT, RateError
from tauto_core.samples import SECONDS_PER_DAY
from tauto_core.scene import Scene
from tauto_core.wording import span

PROJECTED_DAYS = (42.0, 81.0)
"""Six weeks, about a passage to the West Indies, to which the Act sends the clock; and the days
that H4 went between its comparisons at Portsmouth and in Jamaica, 1761 to 1762.
"""

HALF_TURN_S = 0.5 * SECONDS_PER_DAY
"""Error of a clock that is half a turn of longitude; no place is farther off."""

FORGOTTEN = 10.0
"""Number of time constants of the swing after which a run no longer depends on its start: the
standard error is then too small by a factor of 1.5 at most, as for a rate of that memory.
"""

AMPLITUDE_SHARE = 0.1
"""Share by which waves may change the amplitude of a swing that nothing holds; in the shipped
scenes it is 0.05 after an hour.
"""

LEAST_EFFECT_S_PER_DAY = 0.01
"""Effect on the rate that no longitude shows: 0.2 nmi after 81 days."""

_CANNOT = 'cannot be projected: '
_WANDERS = 'so it keeps what the waves give it, and wanders for ever'


def forgets_its_start(
    scene: Scene, machine: AnyMachine | FluidPendulum, found: RateError
) -> RateError:
    """Return how well the mean rate is known, if the swing has forgotten how it began.

    What release and first waves gave to a swing that nothing damps stays for as long as the run,
    and the next: the rate scatters about a mean of its own, and the run alone does not show it.
    That matters where the rate depends on the amplitude by more than its standard error.

    Args:
        scene: the scene of the run.
        machine: its regulator.
        found: how well the run itself shows the mean rate.
    """
    if isinstance(machine, FluidPendulum):
        return found
    least = max(found.standard_error_s_per_day or 0.0, LEAST_EFFECT_S_PER_DAY)
    why = _kept(scene, machine, least, found.length_s)
    return RateError(None, found.length_s, why) if why else found


def _kept(scene: Scene, machine: AnyMachine, least_s_per_day: float, length_s: float) -> str:
    """Return what keeps the swing from forgetting its start, or ''.

    Args:
        scene: the scene of the run.
        machine: its regulator.
        least_s_per_day: least effect on the rate that counts [s/day].
        length_s: length of the run [s].
    """
    drag = None if machine.drag is None or machine.drag.is_zero else machine.drag
    if drag is not None and machine.escapement is None:
        return (
            f'{_CANNOT}the swing dies away, since there is drag and no escapement to make good '
            'for it. Give the clock an escapement'
        )
    if scene.lies_still:
        return ''
    if isinstance(machine, HangingMachine):
        return f'{_CANNOT}nothing holds the swing of the thread, {_WANDERS}'
    amplitude = abs(machine.release_angle)
    less, full = machine.period((1.0 - AMPLITUDE_SHARE) * amplitude), machine.period(amplitude)
    depends = abs(less / full - 1.0) * SECONDS_PER_DAY > least_s_per_day
    if depends and drag is None:
        return (
            f'{_CANNOT}nothing damps the wheel, on whose amplitude the rate depends, {_WANDERS}. '
            'Give the clock drag and an escapement'
        )
    if scene.suspension is not None and (depends or machine.feels_gravity):
        return (
            f'{_CANNOT}nothing damps the swing of the case, on which the rate depends, {_WANDERS}'
        )
    settled_s = 0.0
    if depends and drag is not None:
        greatest = machine.frequency * amplitude
        settled_s = FORGOTTEN * _time_constant_s(drag, machine.inertia, greatest)
    words = (
        f'{TOO_SHORT}its rate depends on the amplitude, which takes {span(settled_s, 2)} to '
        'settle. Sail longer'
    )
    return words if length_s < settled_s else ''


def _time_constant_s(drag: Drag, inertia: float, rate: float) -> float:
    """Return the time in which the energy of a harmonic swing comes e-fold nearer to the steady.

    J θ̇ₘ/P′ with P = c₁θ̇ₘ²/2 + 4c₂θ̇ₘ³/3π + 2c₀θ̇ₘ/π, the mean power of the drag.

    Args:
        drag: not all of it 0.
        inertia: J [kg m2].
        rate: θ̇ₘ, the greatest angular velocity of the swing [rad/s].
    """
    return inertia / (
        drag.viscous + 4.0 / math.pi * drag.quadratic * rate + 2.0 / math.pi * drag.coulomb / rate
    )


def projection(
    rate_s_per_day: float,
    error: RateError,
    estimate: Mapping[str, float],
    model: ClockModel,
    latitude_deg: float,
    random_walk_fm_per_s: float = 0.0,
) -> dict[str, Any]:
    """Return the error after `PROJECTED_DAYS` unchecked of a clock set right at departure.

    The dial gains y T, which puts the ship y T · ¼ arcmin/s · cos φ to the west. With the standard
    error s of y over a run of the length T₀ the gain has the variance s² T² + s² T₀ T: the rate of
    the run may differ from that of all runs, and that of the voyage too. Random-walk noise q of
    the dial adds q T₀ T²/3 + q T³/3. Correction by the estimated rate ŷ leaves (y − ŷ) T. Besides
    what the navigator does not know by his own model (`kalman.predict`, from an exact offset), its
    standard deviation has that of y, since he has rated the clock in this run alone.

    Nothing is projected where the standard error is not known, nor beyond half a turn.

    Args:
        rate_s_per_day: y, the mean rate of the dial over the run [s/day, fast is positive].
        error: how well y is known.
        estimate: the last estimate, with ŷ and its standard deviation (`estimates.mean_rate`). A
            rate that depends on the ship's motion assumes that the motion continues.
        model: the model of the clock, for the noise that accumulates under way; without
            coefficients.
        latitude_deg: φ of the landfall [degrees].
        random_walk_fm_per_s: q of the dial [1/s].

    Returns:
        `projection`, for each number of `days`: `raw_error_nmi` of the dial, `error_nmi` of the
        corrected clock, both positive to the east, and the standard deviations `raw_sigma_nmi`
        and `sigma_nmi`; None for what is beyond half a turn. `not_projected`, the reason why
        something is missing, or None.
    """
    if error.standard_error_s_per_day is None:
        return {'projection': [], 'not_projected': error.why_unknown}
    nmi_per_s = ARCMIN_PER_S * math.cos(math.radians(latitude_deg))
    scatter = (error.standard_error_s_per_day / SECONDS_PER_DAY) ** 2
    estimated, sigma = mean_rate(estimate)
    known = Estimate(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, (sigma / SECONDS_PER_DAY) ** 2, 0.0, 0.0)
    rows: list[dict[str, Any]] = []
    missing: dict[str, str] = {}
    for days in PROJECTED_DAYS:
        time_s = days * SECONDS_PER_DAY
        of_rate = scatter * (time_s + error.length_s) * time_s
        of_rate += random_walk_fm_per_s * error.length_s * time_s**2 / 3.0
        dial = of_rate + random_walk_fm_per_s * time_s**3 / 3.0
        corrected = of_rate + predict(known, time_s, model).xx
        row: dict[str, Any] = {'days': days}
        for clock, prefix, gained_s, variance in (
            ('the dial', 'raw_', rate_s_per_day * days, dial),
            ('the corrected clock', '', (rate_s_per_day - estimated) * days, corrected),
        ):
            sigma_s = math.sqrt(variance)
            uncertain, far = sigma_s > HALF_TURN_S, abs(gained_s) > HALF_TURN_S
            row[f'{prefix}error_nmi'] = None if uncertain or far else -gained_s * nmi_per_s
            row[f'{prefix}sigma_nmi'] = None if uncertain or far else sigma_s * nmi_per_s
            if uncertain:
                missing.setdefault(
                    clock, f'{TOO_SHORT}after {days:g} days its ± is {_turn(sigma_s)}'
                )
            elif far:
                missing.setdefault(
                    clock, f'{_CANNOT}after {days:g} days it is wrong by {_turn(gained_s)}'
                )
        rows.append(row)
    reasons = [f'{clock} {why}' for clock, why in missing.items()]
    return {'projection': rows, 'not_projected': '; '.join(reasons) or None}


def _turn(error_s: float) -> str:
    return f'{abs(error_s):,.0f} s, more than half a turn of longitude, {HALF_TURN_S:,.0f} s'
