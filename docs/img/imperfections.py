"""What heat, gravity and the ship's motion do to each clock, one at a time and together.

    python docs/img/imperfections.py [--part P]

prints the table of docs/three_imperfections.md: on land, at the steady swing, per kelvin at the
departure and from the gravity of Portsmouth to that of Jamaica; and on the whole passage at sea,
with gravity and temperature of the departure, and with everything. It takes ten minutes.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import replace

from tauto_core.ensembles.comparison import CLOCKS
from tauto_core.machines import AnyMachine, LeverMachine, Machine, compile_trochlea
from tauto_core.machines.steady_swing import SteadySwing, steady_swing
from tauto_core.scene import load_scene
from tauto_core.scene.errors import ABSENT
from tauto_core.scene.times import DAY_S
from tauto_core.ship.passage import normal_gravity
from tauto_core.voyage import sail
from tauto_core.wording import figure

PASSAGE_S = 5_443_140.0


def period_s(machine: AnyMachine) -> float:
    """Return the period of the steady swing on land; of a swinging thread that of a free swing."""
    if not isinstance(machine, Machine | LeverMachine):
        return machine.period(machine.release_angle)
    swing = steady_swing(machine)
    assert isinstance(swing, SteadySwing)
    return swing.period


def per_kelvin(name: str) -> float | None:
    """Return the change of rate a kelvin at the departure [s/day]; None: no steady swing known."""
    machine, trochlea = compile_trochlea(load_scene(name)), load_scene(name).trochlea
    if not isinstance(machine, Machine | LeverMachine) or trochlea is None:
        return None
    colder, warmer = (period_s(machine.at_celsius(trochlea.at_celsius + k)) for k in (-1.0, 1.0))
    return 0.5 * DAY_S * (colder / warmer - 1.0)


def by_latitude(name: str) -> float:
    """Return the change of rate from the gravity of the departure to that of the arrival."""
    scene = load_scene(name)
    assert scene.voyage is not None
    machine = compile_trochlea(scene)
    jamaica = float(normal_gravity(math.radians(scene.voyage.arrival[0])))
    # the same cam, which is made for Portsmouth
    return DAY_S * (period_s(machine) / period_s(replace(machine, gravity=jamaica)) - 1.0)


def at_sea(name: str, part: float, **changes: object) -> float:
    """Return the mean rate on the passage, the case fixed to the ship [s/day]."""
    length = 60.0 * round(part * PASSAGE_S / 60.0)
    scene = load_scene(name, suspension=ABSENT, duration=length, **changes)
    rate: float = sail(scene, keep=False).result['clock']['rate_s_per_day']
    return rate


def told(rate: float | None) -> str:
    """Return a rate as a cell; a dash for what is not known."""
    return '–' if rate is None else figure(rate, 's/day', signed=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--part', type=float, default=1.0, help='of the passage that is sailed')
    part = parser.parse_args().part
    print('| clock | a kelvin | Portsmouth to Jamaica | the motion | all three |')
    print('|---|---|---|---|---|')
    for name in CLOCKS:
        scene = load_scene(name)
        cells = (
            told(per_kelvin(name)),
            told(by_latitude(name)),
            told(at_sea(name, part, gravity=scene.g, air=ABSENT)),
            told(at_sea(name, part)),
        )
        print(f'| `{name}` | {" | ".join(cells)} |', flush=True)


if __name__ == '__main__':
    main()
