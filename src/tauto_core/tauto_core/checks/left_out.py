"""Effects that a scene leaves out, in words that a navigator understands, with their size."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from tauto_core.machines import AnyMachine, HangingMachine, InPlaceOfWheel, LeverMachine, Machine
from tauto_core.machines.axle_section import AxleRegulator
from tauto_core.machines.heat import NO_HEAT
from tauto_core.machines.sections import FluidTautochroneRegulator
from tauto_core.scene import Drag, Scene
from tauto_core.scene.times import DAY_S
from tauto_core.ship.motions.sea import SeaShip
from tauto_core.ship.passage import normal_gravity
from tauto_core.ship.sections import MOTIONS, SuspensionKind
from tauto_core.wording import printed

USUAL_MASS = 10.0
"""Mass of a case for which a figure gives the wheel's effect on it [kg]."""


class LeftOut(NamedTuple):
    """Something that a real clock, ship or sea has and the simulation of a scene has not.

    Attributes:
        what: its name.
        why: the assumption in its place, as a sentence.
        worth: its effect on a clock; None where no figure is known.
        key: key of the scene that brings it in; None where Tauto does not simulate it.
    """

    what: str
    why: str
    worth: str | None = None
    key: str | None = None


_STEEL, _BRASS = '−10.4 s/day/K with all of steel', '−0.8 s/day/K with wheel and cam of brass'
_OIL = '15.6 s/day by 3.5 % of the drag in the clock of portsmouth_jamaica'
_MGAL = '1 s/day for a weight by 22.7 mGal; some 30 mGal rms at sea, 100 to 300 near islands'
_THREAD = '0.3 s/day by a thread of 1 m, 90 by one of 16 m, in a roll of 0.1 rad and 9 s'

# Figures: heat from G2.7 and G2.8 of heat.md, hull from hull.md, cork from −⟨z̈²⟩/8g² in its sea
# up to 4 ω_p, gravity from gravity.md, thread and lever from threads.md, Euler's weight from
# wheel.md; the case's answer from G5.4 of suspension.md.
TABLE = tuple(
    LeftOut(*row)
    for row in (
        ('added mass', 'The body moves no fluid along.', None, 'regulator.added_mass'),
        ('viscosity of the fluid', 'The fluid resists by the square of the speed alone.'),
        ('friction of the support', 'The axle slides freely.', None, 'regulator.contact'),
        ('resistance of the air', 'Nothing damps a body on its axle but its contact.'),
        ('drag', 'Nothing slows the wheel, neither oil nor air.', None, 'drag'),
        ('viscous drag', 'No oil slows the wheel.', None, 'drag.viscous'),
        ('quadratic drag', 'No air slows the wheel.', None, 'drag.quadratic'),
        ('friction of the pivots', 'The pivots turn without dry friction.', None, 'drag.coulomb'),
        ('ageing of the oil', 'The oil stays fresh.', _OIL, 'drag.thickens_per_month'),
        ('escapement', 'Nothing keeps the wheel swinging.', None, 'escapement'),
        ('recoil', 'A resting tooth does not push back.', None, 'escapement.rest.recoil'),
        ('fall of the drive', 'All impulses are equally strong.', None, 'escapement.train'),
        ('balance of the wheel', 'The wheel is in perfect balance.', None, 'trochlea.imbalance'),
        ('inertia of the weight', 'The weight pulls and has no inertia.',
         "−428 s/day for Euler's own proposal at 1 rad", 'trochlea.power.massless'),
        ('swing of the thread', 'The thread always follows the apparent vertical.', _THREAD,
         'trochlea.thread'),
        ('damping of the thread', 'Nothing damps the swing of the thread.', None,
         'trochlea.thread.damping_ratio'),
        ('mass of the lever', 'The lever has no mass.', None, 'trochlea.thread.inertia'),
        ('thread fore and aft', 'The thread swings in one plane.'),
        ('mass and stretch of the thread', 'The thread has no mass and does not stretch.'),
        ('wear', 'Nothing wears.'),
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
        ('damping of the case', 'Nothing damps the swing of the case.', None, 'suspension'),
        ('outer ring of the gimbals', 'The outer ring never swings.'),
        ('motions of the ship', 'The ship lies still.', None, 'ship'),
        ('sideways half of the sea',
         'The ship is a cork: she heaves as the waves do, and nothing shakes her sideways.', None,
         'ship.hull'),
        ('short-crested sea', 'All waves of a sea run in one direction.'),
        ('shallow water', 'The water is deep.'),
        ('heel under sail', 'She sails upright.'),
        ('slamming and green water', 'The hull answers waves in proportion to their height.'),
        ('push of the waves under way', 'Waves push the hull as if she lay still.'),
        ('gravity by latitude', 'Gravity is the same everywhere.', None, 'gravity'),
        ('anomalies of gravity', 'Gravity depends on latitude and speed alone.', _MGAL),
        ('clock noise', 'The dial has no errors beside those of the mechanics.', None,
         'clock.white_fm'),
        ('voyage', 'The ship makes no passage.', None, 'voyage'),
    )
)  # fmt: skip
"""All that a scene may leave out, from the wheel outwards; `left_out` selects."""


def left_out(scene: Scene, machine: AnyMachine | InPlaceOfWheel) -> list[LeftOut]:
    """Return the effects that a scene leaves out, in the order of `TABLE`."""
    ship, hung, escapement, voyage = scene.ship, scene.suspension, scene.escapement, scene.voyage
    moves, feels, drag = not ship.lies_still, machine.feels_gravity, scene.drag or Drag()
    sea = ship if isinstance(ship, SeaShip) else None
    hull = sea is not None and sea.hull is not None
    cork = sea is not None and sea.heave and not hull and sea.rao is None
    known = (*ship.motions, *(('surge', 'sway') if cork else ()))
    missing = [each for each in MOTIONS if each not in known]
    body = scene.regulator
    in_fluid = body if isinstance(body, FluidTautochroneRegulator) else None
    wheel, plain = scene.trochlea is not None, isinstance(machine, Machine)
    heat = NO_HEAT if isinstance(machine, InPlaceOfWheel) else machine.heat
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
    # figures that depend on numbers of the scene
    here: dict[str, dict[str, Any]] = {'heat': {}}
    if plain and pull is not None:
        worth = [_BRASS] if pull.pulling_mass else [_STEEL]
        mixed = pull.pulling_mass and (pull.force or pull.stiffness)
        worth = worth * (not mixed) + [_OIL] * (drag.viscous > 0.0)
        here['heat'] = {'worth': '; '.join(worth) or None}
    if scene.air is not None:
        here['heat'] |= {'key': 'trochlea.material', 'why': 'Heat changes no part of the clock.'}
    # the equations of levers and swinging threads are without these
    beyond = [
        'balance of the wheel',
        *['fall of the drive'] * (not plain),
    ]
    for what in beyond if not plain else ():
        here[what] = here.get(what, {}) | {'key': None}
    if moves:
        why = f'The ship has no {", no ".join(missing)}.'
        here['motions of the ship'] = {'why': why, 'key': 'ship' if sea is None else 'ship.hull'}
    else:
        here['swing of the thread'] = {'worth': None}
    if feels:
        here['sideways half of the sea'] = {
            'worth': '−62 s/day for a weight on a cork in waves of 2.5 m and 9 s, '
            'in a hull of 44 m +1 to −91'
        }
    if isinstance(machine, LeverMachine) and hung is None:
        here['heel under sail'] = {'worth': '−165 s/day for a level lever at 5°, −659 at 10°'}
    if voyage is not None:
        first, last = (
            float(normal_gravity(math.radians(place[0])))
            for place in (voyage.departure, voyage.arrival)
        )
        shift = printed((math.sqrt(last / first) - 1.0) * DAY_S, '+.1f')
        here['gravity by latitude'] = {
            'worth': f'{shift} s/day for a weight from departure to arrival'
        }
    if isinstance(machine, Machine) and hung is not None:
        turned = frequency_in_light_case(hung, machine.inertia, machine.frequency, scene.g)
        shift = printed((turned / machine.frequency - 1.0) * DAY_S, '+,.0f')
        here["the case's answer to the wheel"] = {
            'worth': f'{shift} s/day in a case of {USUAL_MASS:g} kg'
        }
    return [row._replace(**here.get(row.what, {})) for row in TABLE if true[row.what]]


def frequency_in_light_case(
    hung: SuspensionKind, inertia: float, frequency: float, gravity: float
) -> float:
    """Return ω of small swings of a wheel that turns a case of `USUAL_MASS` [rad/s].

    In gimbals it is a root of (G5.4) in suspension.md; on an axle, of the equations with M and K
    of the links (E3.1) in (θ, φ) and I/M for the wheel's ψ. Of the modes it is the one with most
    of the potential energy in the thread. Nothing damps the case.
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
