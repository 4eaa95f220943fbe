"""In words: why a scene runs as it does, and what it leaves out and does not pay for."""

from __future__ import annotations

from tauto_core.machines import AnyMachine, LeverMachine, Machine
from tauto_core.scene import Drag, RecordedShip, Scene, StillShip, WeightPower


def reason(scene: Scene, machine: AnyMachine, propagator: str) -> str:
    """Return why a propagator was chosen.

    Args:
        scene: what runs.
        machine: of the scene.
        propagator: its name.
    """
    still = isinstance(scene.ship, StillShip)
    if not isinstance(machine, Machine):
        return _of_real_thread(machine, propagator, still=still)
    uneven = _uneven(machine)
    if propagator == 'harmonic':
        return 'a harmonic well on a ship that lies still: any instant in closed form'
    if propagator == 'action_angle':
        return (
            f'a well that is not harmonic ({uneven}), but undisturbed: any instant from its '
            'period, in closed form'
        )
    if propagator == 'forced_harmonic':
        shakers = _and(['the roll'] * (not still) + ['viscous drag'] * (machine.drag is not None))
        return f'{shakers} in a harmonic well: linear, so a sample is one exact step'
    return '; '.join(_disturbances(machine, uneven, still=still))


def _of_real_thread(machine: AnyMachine, propagator: str, *, still: bool) -> str:
    lever = isinstance(machine, LeverMachine)
    if propagator == 'action_angle':
        return (
            'the lever makes a well that is neither harmonic nor even, but undisturbed: any '
            'instant from its period, in closed form'
        )
    drag = machine.drag is not None
    found = {
        'the thread swings, a second degree of freedom': not lever,
        'the apparent gravity moves the lever': lever and not still,
        'the apparent gravity moves the weight': not lever and not still,
        'drag in a well that is not harmonic': lever and drag,
        'the escapement acts at an instant': machine.escapement is not None,
    }
    words = [each for each, present in found.items() if present]
    return '; '.join(words) or 'the thread goes slack in the swing'


def _uneven(machine: Machine) -> str:
    """Return what makes a well other than harmonic; empty if nothing does."""
    parts = {
        "the weight's inertia": machine.carried_mass > 0.0,
        "the spring's stiffness": machine.stiffness > 0.0,
        'the lever arm of the cam': machine.cam.linear_rate is None,
    }
    return _and([name for name, present in parts.items() if present])


def _disturbances(machine: Machine, uneven: str, *, still: bool) -> list[str]:
    drag = machine.drag or Drag()
    overdamped = drag.viscous >= 2.0 * machine.inertia * machine.frequency
    shakers = _and(['the roll'] * (not still) + ['viscous drag'] * (drag.viscous > 0.0))
    found = {
        'the apparent gravity moves the weight': not still and machine.pulling_mass > 0.0,
        f'{shakers} in a well that is not harmonic ({uneven})': bool(shakers and uneven),
        'viscous drag stops the wheel before it swings': overdamped and not uneven,
        'quadratic drag is not linear': drag.quadratic > 0.0,
        'friction turns round with the wheel': drag.coulomb > 0.0,
        'the escapement acts at an instant': machine.escapement is not None,
    }
    return [words for words, present in found.items() if present] or [
        'the thread goes slack in the swing'
        if machine.drag is None
        else 'drag is given, though all of it is zero: leave it out'
    ]


def _and(names: list[str]) -> str:
    return ' and '.join(names)


def left_out(scene: Scene, machine: AnyMachine) -> list[str]:
    """Return the terms that a scene does not contain; they are not in the code that runs."""
    ship, drag, power = scene.ship, scene.drag, scene.trochlea.power
    still = isinstance(ship, StillShip)
    if isinstance(ship, RecordedShip):
        heave = ship.recorded.heave_column is not None or ship.recorded.topic is not None
    else:
        heave = bool(getattr(ship, 'heave', None))
    absent = {
        'drag': drag is None,
        'viscous drag': drag is not None and not drag.viscous,
        'quadratic drag': drag is not None and not drag.quadratic,
        'friction': drag is not None and not drag.coulomb,
        'escapement': scene.escapement is None,
        'roll': still,
        'heave': not heave,
        'apparent gravity': not still and not machine.feels_gravity,
        'suspension': getattr(scene, 'suspension', None) is None,
        "the weight's inertia": isinstance(power, WeightPower) and power.massless,
        'voyage': scene.voyage is None,
    }
    return [name for name, out in absent.items() if out]
