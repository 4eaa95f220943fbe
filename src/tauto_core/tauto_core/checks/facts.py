"""The facts of a scene before it sails: machine, propagator, omissions, cost and accuracy."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple, cast

import numpy as np

from tauto_core.checks.cost import (
    LONGEST_TRIAL_S,
    RESOLUTION_S,
    Waves,
    forecast,
    scene_waves,
    tolerance,
)
from tauto_core.checks.readiness import check_scene, plausibility_warnings
from tauto_core.clockwork.trochlea import at_departure, nominal_period_s
from tauto_core.machines import (
    AnyMachine,
    AxleClock,
    FluidPendulum,
    HangingMachine,
    LeverMachine,
    Machine,
    NoSteadySwing,
    OtherRegulator,
    rate_s_per_day,
    steady_swing,
)
from tauto_core.machines.axle_pendulum import AxleRegulator, answers
from tauto_core.machines.drags import Drag
from tauto_core.machines.heat import NO_HEAT
from tauto_core.machines.sections import FluidTautochroneRegulator
from tauto_core.motion import propagator_name
from tauto_core.navigation.covariates import coefficients, dial_model, fit, runs
from tauto_core.navigation.regressors import SHAKEN_BY
from tauto_core.samples import FloatArray
from tauto_core.scene import Scene
from tauto_core.scene.errors import TautoError
from tauto_core.scene.times import DAY_S
from tauto_core.ship import Passage
from tauto_core.ship.airs import BoxTemperature
from tauto_core.ship.buffer import sensed_step_ns
from tauto_core.ship.coast import ends_of
from tauto_core.ship.motions.sea import SeaShip
from tauto_core.ship.passage import normal_gravity
from tauto_core.ship.sections import MOTIONS
from tauto_core.ship.suspensions import SuspensionKind
from tauto_core.ship.waves import Harmonics, together
from tauto_core.wording import printed

# -----------------------------------------------------------------------------
# How well a thread or case that hangs on the ship follows the apparent vertical.
#
# A swinging thread and a case on its axle are both a link with a body (C in axle.md), and obey
# e θ̈ + c φ̈ + g θ = g τ, k² φ̈ + g c (φ − θ) = 0 for a tilt τ of the apparent vertical. In a wave
# of frequency Ω
#
#     θ/τ = g (g c − k² Ω²)/D,    φ/τ = g² c/D,    D = e k² (Ω² − ω²)(Ω² − ω′²),
#
# which is 1 for Ω far below the frequencies ω, ω′ of the modes, and unbounded at resonance.

LARGEST_DEPARTURE = 1.0
"""Departure over the tilt of the apparent vertical above which the link swings wider than that."""
LARGEST_STRETCH = 0.02
"""Largest relative change of the period of small swings by a swinging thread."""
NEAR_PERIOD = 0.05
"""Relative difference of two periods below which they are in resonance."""


@dataclass(frozen=True)
class Following:
    """The response of a link that hangs on the ship.

    Attributes:
        periods_s: periods of its modes, the slower first [s].
        departure_rad: rms of its departure from the apparent vertical [rad].
        departure: the same over the rms tilt of the apparent vertical. Both are `None` without a
            tilt, or with measured motion.
        resonates_with: `wheel`, `waves`, both or neither.
    """

    periods_s: tuple[float, ...]
    departure_rad: float | None
    departure: float | None
    resonates_with: tuple[str, ...]


def thread_following(scene: Scene, machine: HangingMachine) -> Following:
    """Return how the inclination θ of a swinging thread follows the apparent vertical."""
    k_squared = machine.inertia / machine.mass
    waves = scene_waves(scene)
    answer, _ = answers(
        machine.modes, machine.base_radius, k_squared, waves.frequency, scene.g, scene.duration
    )
    if machine.damping:
        # (threads.1) for small swings, the case at rest: a wave turns the thread by δ/τ, complex
        square, inertia, damping = waves.frequency**2, machine.inertia, machine.damping
        pull, per_s = machine.mass * scene.g * machine.base_radius, 1j * waves.frequency
        turned = (pull + per_s * damping * machine.base_radius / machine.length) / (
            pull - inertia * square
        )
        stiff = scene.g - (machine.length + machine.base_radius * turned) * square
        stiff = stiff + per_s * damping / (machine.mass * machine.length)
        answer = 1.0 + np.abs(scene.g / stiff - 1.0)
    stretch = machine.small_period * _ideal_frequency(machine) / math.tau - 1.0
    period = math.tau / machine.thread_frequency
    return _following(waves, answer, (period,), wheel=abs(stretch) > LARGEST_STRETCH)


def case_following(scene: Scene, machine: AnyMachine) -> Following | None:
    """Return how the tilt φ of a suspended case follows the apparent vertical, or `None`."""
    hung = scene.suspension
    if hung is None:
        return None
    waves = scene_waves(scene)
    answer = hung.answer(waves.frequency, scene.g, scene.duration)
    periods = tuple(math.tau / omega for omega in hung.frequencies(scene.g))
    wheel = any(abs(period / machine.small_period - 1.0) < NEAR_PERIOD for period in periods)
    return _following(waves, answer, periods, wheel=wheel)


def _following(
    waves: Waves, answer: FloatArray, periods: tuple[float, ...], *, wheel: bool
) -> Following:
    departure, size = _share(waves, answer - 1.0), float(np.linalg.norm(waves.sway))
    too_far = departure is not None and departure > LARGEST_DEPARTURE
    return Following(
        periods,
        None if departure is None else departure * size / math.sqrt(2.0),
        departure,
        ('wheel',) * wheel + ('waves',) * too_far,
    )


def _ideal_frequency(machine: Machine | HangingMachine) -> float:
    """Return the frequency of small swings on an ideal vertical thread [rad/s]."""
    if isinstance(machine, Machine):
        return machine.frequency
    pull = machine.mass * machine.gravity
    return math.sqrt(pull * machine.base_radius / machine.inertia)


def _share(waves: Waves, value: FloatArray) -> float | None:
    """Return the rms of a value over the waves, weighted by their tilts, or `None` without any."""
    size = float(np.linalg.norm(waves.sway))
    return float(np.linalg.norm(waves.sway * value)) / size if size else None


# -----------------------------------------------------------------------------
# Why a propagator was chosen.


def reason(scene: Scene, machine: AnyMachine | OtherRegulator, propagator: str) -> str:
    """Return why the propagator of this name was chosen."""
    if isinstance(machine, OtherRegulator):
        return machine.propagator_reason
    tilts = 'the roll' if scene.suspension is None else 'the swing of the case'
    tilts = '' if scene.lies_still else tilts
    plain = machine if isinstance(machine, Machine) else None
    lever, drag = isinstance(machine, LeverMachine), machine.drag or Drag()
    uneven = '' if plain is None else _uneven(plain)
    # a lever that is drawn by a force in the case moves only with the case
    shaken = [tilts] * bool(tilts and (plain or not machine.feels_gravity))
    is_dragged = drag.viscous > 0.0 if plain else machine.drag is not None
    shaken += [('viscous ' if plain else '') + 'drag'] * is_dragged
    shakers = ' and '.join(shaken)
    if propagator == 'harmonic':
        return 'a harmonic well on a still ship: any instant in closed form'
    if propagator == 'action_angle':
        well = f'a well that is not harmonic ({uneven})'
        lean = 'the lever makes a well that is neither harmonic nor even'
        return (
            f'{well if plain else lean}, but undisturbed: any instant from its period, in closed '
            'form'
        )
    if propagator == 'forced_harmonic':
        return f'{shakers} in a harmonic well: linear, so a sample is one exact step'
    unbalanced = plain is not None and plain.imbalance is not None
    weighs = machine.feels_gravity if lever else plain is None or plain.pulling_mass > 0.0
    causes = {
        'the thread swings, a second degree of freedom': not plain and not lever,
        f'the apparent gravity moves the {"lever" if lever else "weight"}': bool(tilts) and weighs,
        f'{shakers} in a well that is not harmonic{f" ({uneven})" if plain else ""}': bool(
            shakers and (lever or uneven)
        ),
        'the imbalance of the wheel makes a well that is not harmonic': unbalanced and not shakers,
    }
    if plain:
        overdamped = drag.viscous >= 2.0 * plain.inertia * plain.frequency
        causes |= {
            'viscous drag stops the wheel before it swings': overdamped and not uneven,
            'quadratic drag is not linear': drag.quadratic > 0.0,
            f'drag of kind {drag.kind} is not linear': drag.law(plain.inertia) is not None,
            'friction turns round with the wheel': drag.coulomb > 0.0,
        }
    causes |= {
        'the escapement acts at an instant': machine.escapement is not None,
        'recoil turns round at each impulse': bool(
            machine.escapement and machine.escapement.recoil
        ),
        'heat and age change its numbers on the way': machine.heat.acts,
    }
    words = [words for words, present in causes.items() if present]
    if plain and machine.drag is not None and not words:
        return 'drag is given, though all of it is zero: leave it out'
    return '; '.join(words) or 'the thread goes slack in the swing'


def _uneven(machine: Machine) -> str:
    """Return why a potential well is anharmonic, or an empty text."""
    parts = {
        "the weight's inertia": machine.carried_mass > 0.0,
        "the spring's stiffness": machine.stiffness > 0.0,
        'the lever arm of the cam': machine.cam.linear_rate is None,
        'the imbalance of the wheel': machine.imbalance is not None,
    }
    names = [name for name, present in parts.items() if present and not machine.is_linear]
    return ' and '.join(names)


def hangs(scene: Scene, machine: AnyMachine | OtherRegulator) -> dict[str, Any] | None:
    """Return the suspension of the case and its modes, `None` if it is fixed to the ship.

    `lengths_m` are of the simple pendulums with the periods of its modes (h and h′ of an axle),
    `large_angles` whether the full equations run, `step_s` the step of the clock's motion.
    `departure_rad` and `departure` are explained in `Following`.
    """
    if scene.suspension is None or isinstance(machine, OtherRegulator):
        return None
    case = case_following(scene, machine)
    assert case is not None
    return {
        'kind': scene.suspension.kind,
        'lengths_m': [scene.g / omega**2 for omega in scene.suspension.frequencies(scene.g)],
        'periods_s': list(case.periods_s),
        'large_angles': scene.suspension.large_angles,
        'step_s': sensed_step_ns(scene) * 1e-9,
        'departure_rad': case.departure_rad,
        'departure': case.departure,
    }


def thread(scene: Scene, machine: AnyMachine | OtherRegulator) -> dict[str, Any] | None:
    """Return how good a model an ideal vertical thread is, `None` if no thread hangs freely.

    Length [m], period [s] and departure from the apparent vertical belong to a swinging thread and
    are `None` for an ideal one. The models agree far from both `fair_lengths_m`, between them:
    g/ω² and g/Ω² [m], with ω of the wheel on an ideal thread, and the mean Ω⁴ over the waves,
    weighted by the tilt of the apparent vertical. The second is `None` like
    `Following.departure`.
    """
    if not isinstance(machine, Machine | HangingMachine) or not machine.follows_apparent_vertical:
        return None
    waves = scene_waves(scene)
    square = _share(waves, waves.frequency**2)
    swing = thread_following(scene, machine) if isinstance(machine, HangingMachine) else None
    return {
        'length_m': machine.length if isinstance(machine, HangingMachine) else None,
        'swings_in_s': swing and swing.periods_s[0],
        'departure_rad': swing and swing.departure_rad,
        'departure': swing and swing.departure,
        'fair_lengths_m': [
            scene.g / _ideal_frequency(machine) ** 2,
            scene.g / square if square else None,
        ],
    }


def slack_thread(scene: Scene) -> dict[str, float] | None:
    """Return how often a weight's thread is expected to go slack in the highest sea.

    The ship's vertical acceleration z̈ at the clock is nearly Gaussian. So g + z̈ falls below zero
    ν₀ exp(−g²/2σ²) times a second, ν₀ = σ′/2πσ, with the standard deviations σ of z̈ and σ′ of its
    derivative (Rice, Mathematical Analysis of Random Noise, 1945, section 3.3). Roll and swing are
    neglected: the estimate is for a clock that runs. A wheel without drag, which such a sea winds
    up, tautens and goes slack again within one fall (threads.md).

    Returns:
        `acceleration_m_s2`, σ, and `times_a_day`. `None` unless a weight alone hangs on a thread
        and a sea heaves the ship.
    """
    ship, trochlea = scene.ship, scene.trochlea
    if trochlea is None or not isinstance(ship, SeaShip):
        return None
    pull = trochlea.power.pull
    if not pull.pulling_mass or pull.force or pull.stiffness:
        return None
    seas = [ship]
    if ship.weather is not None:
        highest = max(ship.states(scene), key=lambda state: state.height)
        seas = [ship.in_state(state) for state in highest.alone if state.sea is not None]
    heaves = [sea.channels(scene).heave for sea in seas]
    waves = [wave for wave in heaves if isinstance(wave, Harmonics)]
    if not waves:
        return None
    met = together(waves)
    acceleration = met.amplitude * met.angular_frequency**2
    sigma, of_jerk = (
        float(np.linalg.norm(values)) / math.sqrt(2.0)
        for values in (acceleration, acceleration * met.angular_frequency)
    )
    if not sigma:  # an operator may have a heave of 0
        return None
    per_s = of_jerk / (math.tau * sigma) * math.exp(-0.5 * (scene.g / sigma) ** 2)
    return {'acceleration_m_s2': sigma, 'times_a_day': per_s * DAY_S}


def resonances(scene: Scene, machine: AnyMachine | OtherRegulator) -> list[str]:
    """Return warnings about a thread or a case in resonance with the wheel or the waves."""
    if isinstance(machine, OtherRegulator):
        return []
    bodies = {'suspension': case_following(scene, machine)}
    if isinstance(machine, HangingMachine):
        bodies['trochlea.thread.length'] = thread_following(scene, machine)
    texts = []
    for key, body in bodies.items():
        if body is not None and body.resonates_with:
            periods = ' and '.join([f'{period:.4g} s' for period in body.periods_s])
            with_whom = ' and '.join([f'the {name}' for name in body.resonates_with])
            texts.append(
                f'{scene.name}: {key}: swings by itself in {periods}, in resonance with '
                f'{with_whom}. Change its dimensions'
            )
    return texts


def way(scene: Scene) -> dict[str, Any] | None:
    """Return the route of the ship and its times, `None` without a voyage.

    Track, length [m], speed [m/s], and the times from the start [s] of sailing, arrival and
    landfalls, arrival included. `ends` describes a log that ends at sea, without a landfall.
    """
    if scene.voyage is None:
        return None
    passage = Passage(scene, scene.voyage)
    under_way_s = (passage.arrives_ns - passage.sails_ns) * 1e-9
    ends = ends_of(scene.voyage, scene.duration)
    landfalls_ns = passage.landfalls_ns[: -len(ends) or None]
    return {
        'track': scene.voyage.track or 'geodesic',
        'length_m': passage.length_m,
        'speed_m_s': passage.length_m / under_way_s,
        'sails_at_s': passage.sails_ns * 1e-9,
        'arrives_at_s': passage.arrives_ns * 1e-9,
        'landfalls_s': [time * 1e-9 for time in landfalls_ns],
        **ends,
    }


def sensed_air(scene: Scene) -> dict[str, float]:
    """Return the range of the temperature in the clock's box, from some 10,000 instants."""
    assert scene.air is not None
    logs = np.arange(0, scene.log_count, max(scene.log_count // 10_000, 1))
    celsius = BoxTemperature(scene).at(np.append(logs, scene.log_count - 1))
    return {
        'lowest_celsius': float(celsius.min()),
        'highest_celsius': float(celsius.max()),
        'box_hours': scene.air.box_hours,
    }


# -----------------------------------------------------------------------------
# The effects that a scene leaves out, in words that a navigator understands, with their size.

USUAL_MASS = 10.0
"""Mass of a case for the figure of the wheel's effect on it [kg]."""


class Omission(NamedTuple):
    """A property of a real clock, ship or sea that the simulation of a scene leaves out.

    Attributes:
        what: its name.
        why: the assumption that replaces it, as a sentence.
        worth: its effect on a clock, `None` if it is unknown.
        key: key of the scene that adds it, `None` if Tauto cannot simulate it.
    """

    what: str
    why: str
    worth: str | None = None
    key: str | None = None


_STEEL, _BRASS = '−10.4 s/day/K with all of steel', '−0.8 s/day/K with wheel and cam of brass'
_OIL = '15.6 s/day by 3.5 % of the drag in the clock of portsmouth_jamaica'
_MGAL = '1 s/day for a weight by 22.7 mGal; some 30 mGal rms at sea, 100 to 300 near islands'
_THREAD = '0.3 s/day by a thread of 1 m, 90 by one of 16 m, in a roll of 0.1 rad and 9 s'

# Figures: heat from (heat.4) and (heat.5), hull from hull.md, cork from −⟨z̈²⟩/8g² in its sea
# up to 4 ω_p, gravity from gravity.md, thread and lever from threads.md, Euler's weight from
# wheel.md; the case's answer from (suspension.5).
TABLE = tuple(
    Omission(*row)
    for row in (
        ('added mass', 'The body moves no fluid along.', None, 'regulator.added_mass'),
        ('viscosity of the fluid', 'The fluid resists by the square of the speed alone.'),
        ('friction of the support', 'The axle slides freely.', None, 'regulator.contact'),
        ('resistance of the air', 'Only its contact damps a body on its axle.'),
        ('drag', 'Neither oil nor air slows the wheel.', None, 'drag'),
        ('viscous drag', 'No oil slows the wheel.', None, 'drag.viscous'),
        ('quadratic drag', 'No air slows the wheel.', None, 'drag.quadratic'),
        ('friction of the pivots', 'The pivots turn without dry friction.', None, 'drag.coulomb'),
        ('ageing of the oil', 'The oil stays fresh.', _OIL, 'drag.thickens_per_month'),
        ('escapement', 'No escapement drives the wheel.', None, 'escapement'),
        ('recoil', 'A resting tooth does not push back.', None, 'escapement.rest.recoil'),
        ('fall of the drive', 'All impulses are equally strong.', None, 'escapement.train'),
        ('balance of the wheel', 'The wheel is in perfect balance.', None, 'trochlea.imbalance'),
        ('inertia of the weight', 'The weight pulls and has no inertia.',
         "−428 s/day for Euler's own proposal at 1 rad", 'trochlea.power.massless'),
        ('swing of the thread', 'The thread always follows the apparent vertical.', _THREAD,
         'trochlea.thread'),
        ('damping of the thread', 'The swing of the thread is undamped.', None,
         'trochlea.thread.damping_ratio'),
        ('mass of the lever', 'The lever has no mass.', None, 'trochlea.thread.inertia'),
        ('thread fore and aft', 'The thread swings in one plane.'),
        ('mass and stretch of the thread', 'The thread has no mass and does not stretch.'),
        ('wear', 'No part wears.'),
        ('heat', 'The clock stays at one temperature.', None, 'air'),
        ('heat in wheel and cam', 'Wheel and cam do not grow with heat.', _BRASS,
         'trochlea.material'),
        ('heat in the spring', 'The spring is as strong in heat as in cold.',
         '−9.9 s/day/K by a spring of steel', 'trochlea.power.material'),
        ('heat in the oil', 'The oil is as thick in cold as in heat.', f'{_OIL}, about 1 K',
         'drag.oil'),
        ('heat in the suspension', 'The case hangs alike in heat and cold.'),
        ('spells of warm and cold', 'The air follows place, date and hour alone.',
         'some kelvins for days', 'air'),
        ('suspension', 'The case is fixed to the ship.', None, 'suspension'),
        ("the case's answer to the wheel", 'The case is too heavy for the wheel to turn.'),
        ('damping of the case', 'The swing of the case is undamped.', None, 'suspension'),
        ('outer ring of the gimbals', 'The outer ring never swings.'),
        ('motions of the ship', 'The ship does not move.', None, 'ship'),
        ('sideways half of the sea',
         'The ship is a cork: it heaves as the waves do, and does not surge or sway.', None,
         'ship.hull'),
        ('short-crested sea', 'All waves of a sea run in one direction.'),
        ('shallow water', 'The water is deep.'),
        ('heel under sail', 'The ship sails upright.'),
        ('slamming and green water', 'The hull answers waves in proportion to their height.'),
        ('push of the waves under way', 'Waves push the hull as if the ship were still.'),
        ('gravity by latitude', 'Gravity is the same everywhere.', None, 'gravity'),
        ('anomalies of gravity', 'Gravity depends on latitude and speed alone.', _MGAL),
        ('clock noise', 'The dial adds no errors to the mechanics.', None,
         'clock.white_fm'),
        ('voyage', 'The ship makes no passage.', None, 'voyage'),
    )
)  # fmt: skip
"""All effects that a scene may leave out, from the wheel outwards. `left_out` selects."""


def left_out(scene: Scene, machine: AnyMachine | OtherRegulator) -> list[Omission]:
    """Return the effects that a scene leaves out, in the order of `TABLE`."""
    ship, hung, escapement, voyage = scene.ship, scene.suspension, scene.escapement, scene.voyage
    moves, feels, drag = not ship.lies_still, machine.feels_gravity, scene.drag or Drag()
    sea = ship if isinstance(ship, SeaShip) else None
    hull = sea is not None and sea.hull is not None
    cork = sea is not None and sea.heave and not hull and sea.rao is None
    motions = (*ship.motions, *(('surge', 'sway') if cork else ()))
    missing = [name for name in MOTIONS if name not in motions]
    body = scene.regulator
    in_fluid = body if isinstance(body, FluidTautochroneRegulator) else None
    wheel, plain = scene.trochlea is not None, isinstance(machine, Machine)
    heat = NO_HEAT if isinstance(machine, OtherRegulator) else machine.heat
    thread, pull = None, None
    if scene.trochlea is not None:
        thread, pull = scene.trochlea.thread, scene.trochlea.power.pull
    hot = scene.air is not None and heat.feels_temperature
    true = {
        'added mass': in_fluid is not None and not in_fluid.added_mass,
        'viscosity of the fluid': in_fluid is not None,
        'friction of the support': isinstance(body, AxleRegulator) and body.contact == 'smooth',
        'resistance of the air': isinstance(body, AxleRegulator),
        'drag': wheel and drag.is_zero,
        'viscous drag': not (drag.is_zero or drag.viscous),
        'quadratic drag': not (drag.is_zero or drag.quadratic),
        'friction of the pivots': wheel and not drag.coulomb,
        'ageing of the oil': drag.viscous > 0.0 and not drag.thickens_per_month,
        'escapement': wheel and escapement is None,
        'recoil': escapement is not None and not escapement.recoil,
        'fall of the drive': escapement is not None and escapement.ebb is None,
        'balance of the wheel': wheel and getattr(machine, 'imbalance', None) is None,
        'inertia of the weight': isinstance(machine, Machine)
        and machine.carried_mass < machine.pulling_mass,
        'swing of the thread': plain and machine.follows_apparent_vertical,
        'damping of the thread': isinstance(machine, HangingMachine) and not machine.damping,
        'mass of the lever': getattr(thread, 'inertia', None) == 0.0,
        'thread fore and aft': isinstance(machine, HangingMachine) and moves,
        'mass and stretch of the thread': wheel,
        'wear': wheel,
        'heat': wheel and not hot,
        'heat in wheel and cam': hot and not (heat.wheel or heat.cam),
        'heat in the spring': hot and bool(pull and (pull.force or pull.stiffness))
        and not heat.force,
        'heat in the oil': hot and drag.viscous > 0.0 and not heat.oil.rate,
        'heat in the suspension': hot and hung is not None,
        'spells of warm and cold': hot and getattr(scene.air, 'kind', '') != 'record',
        'suspension': wheel and moves and hung is None,
        "the case's answer to the wheel": hung is not None and not feels,
        'damping of the case': hung is not None and not hung.is_damped,
        'outer ring of the gimbals': hung is not None and hung.plane is not None and moves,
        'motions of the ship': bool(missing),
        'sideways half of the sea': cork,
        'short-crested sea': sea is not None,
        'shallow water': sea is not None,
        'heel under sail': sea is not None,
        'slamming and green water': hull,
        'push of the waves under way': hull and (voyage is not None or bool(sea and sea.speed)),
        'gravity by latitude': voyage is not None and scene.gravity != 'normal' and feels,
        'anomalies of gravity': scene.gravity == 'normal' and feels,
        'clock noise': not scene.clock.is_noisy,
        'voyage': voyage is None,
    }  # fmt: skip
    # figures that depend on the scene
    diff: dict[str, dict[str, Any]] = {'heat': {}}
    if plain and pull is not None:
        worth = [_BRASS] if pull.pulling_mass else [_STEEL]
        mixed = pull.pulling_mass and (pull.force or pull.stiffness)
        worth = worth * (not mixed) + [_OIL] * (drag.viscous > 0.0)
        diff['heat'] = {'worth': '; '.join(worth) or None}
    if scene.air is not None:
        diff['heat'] |= {'key': 'trochlea.material', 'why': 'Heat changes no part of the clock.'}
    # the equations of levers and swinging threads lack these
    names = ['balance of the wheel', *['fall of the drive'] * (not plain)]
    for what in names if not plain else ():
        diff[what] = diff.get(what, {}) | {'key': None}
    if moves:
        why = f'The ship has no {", no ".join(missing)}.'
        diff['motions of the ship'] = {'why': why, 'key': 'ship' if sea is None else 'ship.hull'}
    else:
        diff['swing of the thread'] = {'worth': None}
    if feels:
        diff['sideways half of the sea'] = {
            'worth': '−62 s/day for a weight on a cork in waves of 2.5 m and 9 s, '
            'in a hull of 44 m +1 to −91'
        }
    if isinstance(machine, LeverMachine) and hung is None:
        diff['heel under sail'] = {'worth': '−165 s/day for a level lever at 5°, −659 at 10°'}
    if voyage is not None:
        at_start, at_end = (
            float(normal_gravity(math.radians(place[0])))
            for place in (voyage.departure, voyage.arrival)
        )
        shift = printed((math.sqrt(at_end / at_start) - 1.0) * DAY_S, '+.1f')
        diff['gravity by latitude'] = {
            'worth': f'{shift} s/day for a weight from departure to arrival'
        }
    if isinstance(machine, Machine) and hung is not None:
        turned = frequency_in_light_case(hung, machine.inertia, machine.frequency, scene.g)
        shift = printed((turned / machine.frequency - 1.0) * DAY_S, '+,.0f')
        diff["the case's answer to the wheel"] = {
            'worth': f'{shift} s/day in a case of {USUAL_MASS:g} kg'
        }
    return [row._replace(**diff.get(row.what, {})) for row in TABLE if true[row.what]]


def frequency_in_light_case(
    hung: SuspensionKind, inertia: float, frequency: float, gravity: float
) -> float:
    """Return ω of small swings of a wheel that turns a case of `USUAL_MASS` [rad/s].

    In gimbals it is a root of (suspension.5). On an axle it follows from the equations with M and
    K of the links (suspension.1) in (θ, φ) and I/M for the wheel's ψ, as the mode that stores most
    of its potential energy in the thread. The case is undamped.
    """
    e, c, share = hung.link, hung.depth, inertia / USUAL_MASS
    stiffness = share * frequency**2
    masses = np.diag([e * e, c * c + hung.gyration_radius**2, share])
    masses[0, 1] = masses[1, 0] = e * c
    springs = np.diag([gravity * e, gravity * c + stiffness, stiffness])
    springs[1, 2] = springs[2, 1] = -stiffness
    free = slice(0 if e else 1, 3)
    root = np.linalg.inv(np.linalg.cholesky(masses[free, free]))
    squares, modes = np.linalg.eigh(root @ springs[free, free] @ root.T)
    modes = root.T @ modes
    in_thread = stiffness * (modes[-1] - modes[-2]) ** 2 / squares
    return math.sqrt(squares[np.argmax(in_thread)])


# -----------------------------------------------------------------------------
# The facts of a scene before it sails: its machine, propagator, cost and accuracy.

WALK_FACTOR = 5.0
"""Uncertainty factor of a random walk from six runs of three hours, which has few large changes:
for the built-in threads 25 and 2,500 s/day instead of 150 and 1,400 from many runs.
"""


def scene_facts(scene: Scene, progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """Return the facts of a scene, after every check that `tauto sail` makes before it starts.

    It is the object of `tauto scene check --json`. `expected` has the figures of `cost.Forecast`;
    `steps_a_swing` and `tolerance` are `None` if the propagator takes no steps. `slack` exists for
    a weight in a sea that heaves the ship (`slack_thread`). `progress` is called with the fraction
    done.

    Raises:
        SceneError: the scene cannot run.
        MotionDataError: measured motion cannot be used.
    """
    machine, motion = check_scene(scene)
    warnings = [
        *plausibility_warnings(scene, machine),
        *motion.warnings,
        *resonances(scene, machine),
        *_wandering(scene, machine),
    ]
    name = propagator_name(machine, still=scene.lies_still)
    expected = forecast(scene, machine, progress)
    stepping = expected.steps_a_swing is not None
    slack = slack_thread(scene)
    # small swings on cheeks that are rooted in the axle have no period
    grows = isinstance(machine, Machine) and not machine.has_small_swings
    return {
        'scene': scene.name,
        'duration_s': scene.duration,
        'propagator': name,
        'reason': reason(scene, machine, name),
        'left_out': [row._asdict() for row in left_out(scene, machine)],
        'expected': {
            **asdict(expected),
            'tolerance': tolerance(scene, machine) if stepping else None,
            'accuracy': scene.accuracy,
            'resolution_s': RESOLUTION_S,
            'longest_trial_s': LONGEST_TRIAL_S,
            'measured_on': 'this machine',
        },
        'ship': scene.ship.kind,
        **({scene.ship.reported_as: motion.metadata} if scene.ship.reported_as else {}),
        'motion_samples': motion.total,
        'motion_step_s': scene.step_ns * 1e-9,
        'suspension': hangs(scene, machine),
        'thread': thread(scene, machine),
        **({} if slack is None else {'slack': slack}),
        'voyage': way(scene),
        **({} if scene.air is None else {'air': sensed_air(scene)}),
        'motion_kept': scene.keeps_motion,
        'logged_samples': scene.log_count,
        'log_interval_s': scene.log_interval_ns * 1e-9,
        'small_period_s': None if grows else machine.small_period,
        'nominal_period_s': nominal_period_s(scene, machine),
        **_regulator_facts(scene, machine),
        'steady_swing': _steady_swing(scene, machine),
        **({'covariates': _covariates(scene)} if scene.drift.covariates else {}),
        **({'warnings': warnings} if warnings else {}),
    }


def _regulator_facts(scene: Scene, machine: AnyMachine | OtherRegulator) -> dict[str, Any]:
    """Return curve, range and release of the regulator. An unlimited range is `None`."""
    if isinstance(machine, AxleClock):
        regulator = cast(AxleRegulator, scene.regulator)
        return {
            'support': regulator.support,
            'contact': machine.contact,
            'lengths_m': list(machine.lengths),
            'release_tilt_rad': machine.tilt,
        }
    if isinstance(machine, FluidPendulum):
        ends = machine.curve.ascent_cusp, machine.curve.descent_cusp
        return {
            'curve': cast(FluidTautochroneRegulator, scene.regulator).curve,
            'curve_range_m': [None if math.isinf(end) else end for end in ends],
            'release_arc_m': machine.release_arc,
        }
    assert not isinstance(machine, OtherRegulator)
    edge = machine.range_rad
    return {
        'cam': None if scene.trochlea is None else scene.trochlea.cam.kind,
        'cam_range_rad': None if math.isinf(edge) else edge,
        'release_angle_rad': machine.release_angle,
    }


def _steady_swing(scene: Scene, machine: AnyMachine | OtherRegulator) -> dict[str, Any] | None:
    """Return the swing in which the clock settles on land, `None` if the machine has none.

    Amplitude [rad], period [s], its rate and the rate of free swings with that amplitude [s/day],
    and the time constant of the approach [s], `None` if the swing is steady from the start; or
    only the reason `why` there is no steady swing.
    """
    if not isinstance(machine, Machine | LeverMachine):
        return None
    swing = steady_swing(cast(Machine | LeverMachine, at_departure(scene, machine)))
    if isinstance(swing, NoSteadySwing):
        return {'why': swing.why}
    nominal = nominal_period_s(scene, machine)
    settling = swing.time_constant
    return {
        'amplitude_rad': swing.amplitude,
        'period_s': swing.period,
        'rate_s_per_day': rate_s_per_day(swing.period, nominal),
        'free_rate_s_per_day': rate_s_per_day(swing.free_period, nominal),
        'time_constant_s': settling if math.isfinite(settling) else None,
    }


def _wandering(scene: Scene, machine: AnyMachine | OtherRegulator) -> list[str]:
    """Return a warning if the sea makes the rate wander by more than the navigator expects."""
    if scene.lies_still or isinstance(machine, OtherRegulator):
        return []
    if not isinstance(machine, HangingMachine):
        expects = scene.drift.white_fm or scene.drift.random_walk_fm
        hung = scene.suspension
        if hung is None or hung.is_damped or not machine.feels_gravity or expects:
            return []
        return [
            f'{scene.name}: drift.white_fm: the swing of the case is undamped, and the rate of '
            'a weight wanders with it. The navigator expects only the noise of the dial, so after '
            'a day his errors will be larger than he states. Write drift.white_fm, in s a day, or '
            'drift.random_walk_fm'
        ]
    try:
        model = fit(scene, ())
    except TautoError as error:
        # the trial sea may be higher than the scene's, and too high
        return [
            f'{scene.name}: drift.random_walk_fm: whether the sea makes the rate walk at random '
            f'could not be tried: {error}'
        ]
    if model.is_expected(dial_model(scene), WALK_FACTOR):
        return []
    return [
        f'{scene.name}: drift.random_walk_fm: the sea swings the thread, and the rate of such a '
        f'clock walks at random, by at least about {model.advised:g} s/day in a day in trial '
        'runs. The navigator expects less, so his errors will be larger than he states. '
        f'Write drift.random_walk_fm: {model.advised:g}'
    ]


def _covariates(scene: Scene) -> dict[str, dict[str, Any]]:
    """Return `value` and `sigma` of the prior of each covariate's coefficient.

    `at_periods` has the coefficient at each wave period [s] of the trial runs, `at_changes` at
    each relative change of gravity, `at_kelvin` at each change of temperature [K]. They are `None`
    if the scene states the coefficient.
    """
    results = {run.name: run.at for run in runs(scene)}
    return {
        name: {
            'value': value,
            'sigma': sigma,
            'at_periods'
            if name in SHAKEN_BY
            else 'at_changes'
            if name == 'gravity'
            else 'at_kelvin': {str(period): k for period, k in results[name].items()}
            if name in results
            else None,
        }
        for name, value, sigma in coefficients(scene)
    }
