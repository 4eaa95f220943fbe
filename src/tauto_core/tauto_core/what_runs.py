"""The choice of a scene's propagator, and the terms that it leaves out, in words."""

from __future__ import annotations

from typing import Any

from tauto_core.machines import (
    AnyMachine,
    FluidPendulum,
    HangingMachine,
    LeverMachine,
    Machine,
)
from tauto_core.scene import Drag, Scene


def reason(scene: Scene, machine: AnyMachine | FluidPendulum, propagator: str) -> str:
    """Return why a propagator was chosen.

    Args:
        scene: the scene.
        machine: the machine of the scene.
        propagator: its name.
    """
    if isinstance(machine, FluidPendulum):
        how = 'in closed form' if machine.is_euler else 'by quadrature'
        return (
            'the fluid takes a known part of the arc from each half swing: one after the other, '
            f'any instant in them {how}'
        )
    still = scene.lies_still
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
    tilts = 'the roll' if scene.suspension is None else 'the swing of the case'
    if propagator == 'forced_harmonic':
        shakers = _and([tilts] * (not still) + ['viscous drag'] * (machine.drag is not None))
        return f'{shakers} in a harmonic well: linear, so a sample is one exact step'
    return '; '.join(_disturbances(machine, uneven, '' if still else tilts))


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
        'recoil turns round at each impulse': bool(
            machine.escapement and machine.escapement.recoil
        ),
    }
    words = [each for each, present in found.items() if present]
    return '; '.join(words) or 'the thread goes slack in the swing'


def _uneven(machine: Machine) -> str:
    """Return what makes a potential well anharmonic; empty if it is harmonic."""
    if machine.is_linear:
        return ''
    parts = {
        "the weight's inertia": machine.carried_mass > 0.0,
        "the spring's stiffness": machine.stiffness > 0.0,
        'the lever arm of the cam': machine.cam.linear_rate is None,
    }
    return _and([name for name, present in parts.items() if present])


def _disturbances(machine: Machine, uneven: str, tilts: str) -> list[str]:
    drag = machine.drag or Drag()
    overdamped = drag.viscous >= 2.0 * machine.inertia * machine.frequency
    shakers = _and([tilts] * bool(tilts) + ['viscous drag'] * (drag.viscous > 0.0))
    found = {
        'the apparent gravity moves the weight': bool(tilts) and machine.pulling_mass > 0.0,
        f'{shakers} in a well that is not harmonic ({uneven})': bool(shakers and uneven),
        'viscous drag stops the wheel before it swings': overdamped and not uneven,
        'quadratic drag is not linear': drag.quadratic > 0.0,
        'friction turns round with the wheel': drag.coulomb > 0.0,
        'the escapement acts at an instant': machine.escapement is not None,
        'recoil turns round at each impulse': bool(
            machine.escapement and machine.escapement.recoil
        ),
    }
    return [words for words, present in found.items() if present] or [
        'the thread goes slack in the swing'
        if machine.drag is None
        else 'drag is given, though all of it is zero: leave it out'
    ]


def _and(names: list[str]) -> str:
    return ' and '.join(names)


def hangs(scene: Scene, machine: AnyMachine | FluidPendulum) -> dict[str, Any] | None:
    """Return the suspension of the case and its modes, None if it is fixed to the ship.

    Returns:
        The kind, b and b′ [m], the periods of both modes [s], whether the full equations run, the
        step of the motion that the clock feels [s], and the departure from the apparent vertical,
        both in rad and over the tilt of the apparent vertical (`following.Following`).
    """
    if scene.suspension is None or isinstance(machine, FluidPendulum):
        return None
    from tauto_core.following import case_following
    from tauto_core.ship.felt_step import case_modes, felt_step_ns

    own, found = case_modes(scene.suspension), case_following(scene, machine)
    assert found is not None
    return {
        'kind': scene.suspension.kind,
        'lengths_m': [own.b, own.b_prime],
        'periods_s': list(found.periods_s),
        'large_angles': scene.suspension.large_angles,
        'step_s': felt_step_ns(scene) * 1e-9,
        'departure_rad': found.departure_rad,
        'departure': found.departure,
    }


def thread(scene: Scene, machine: AnyMachine | FluidPendulum) -> dict[str, Any] | None:
    """Return how good a model an ideal vertical thread is; None if no thread hangs freely.

    Returns:
        Length [m], own period [s] and departure from the apparent vertical of a thread that
        swings,
        None for an ideal one; the two lengths [m] between which, far from both, the models agree.
    """
    from tauto_core.following import lengths_between, thread_following

    lengths = lengths_between(scene, machine)
    if lengths is None:
        return None
    found = thread_following(scene, machine) if isinstance(machine, HangingMachine) else None
    return {
        'length_m': machine.length if isinstance(machine, HangingMachine) else None,
        'swings_in_s': found.periods_s[0] if found is not None else None,
        'departure_rad': found.departure_rad if found is not None else None,
        'departure': found.departure if found is not None else None,
        'fair_lengths_m': list(lengths),
    }


def resonances(scene: Scene, machine: AnyMachine | FluidPendulum) -> list[str]:
    """Return warnings about a thread or a case in resonance with the wheel or the waves.

    Args:
        scene: the scene.
        machine: the machine of the scene.
    """
    if isinstance(machine, FluidPendulum):
        return []
    from tauto_core.following import case_following, thread_following

    found = {'suspension': case_following(scene, machine)}
    if isinstance(machine, HangingMachine):
        found['trochlea.thread.length'] = thread_following(scene, machine)
    said = []
    for key, each in found.items():
        if each is not None and each.resonates_with:
            own = _and([f'{period:.4g} s' for period in each.periods_s])
            with_whom = _and([f'the {name}' for name in each.resonates_with])
            said.append(
                f'{scene.name}: {key}: swings by itself in {own}, in resonance with {with_whom}. '
                'Change its dimensions'
            )
    return said


def way(scene: Scene) -> dict[str, Any] | None:
    """Return the route of the ship and its times, None without a voyage.

    Returns:
        The track, its length [m], speed [m/s], and the times from the start [s] of sailing,
        arrival
        and landfalls, including the arrival.
    """
    if scene.voyage is None:
        return None
    from tauto_core.ship import Passage

    passage = Passage(scene, scene.voyage)
    under_way_s = (passage.arrives_ns - passage.sails_ns) * 1e-9
    return {
        'track': scene.voyage.track or 'geodesic',
        'length_m': passage.length_m,
        'speed_m_s': passage.length_m / under_way_s,
        'sails_at_s': passage.sails_ns * 1e-9,
        'arrives_at_s': passage.arrives_ns * 1e-9,
        'landfalls_s': [time * 1e-9 for time in passage.landfalls_ns],
    }


def left_out(scene: Scene, machine: AnyMachine | FluidPendulum) -> list[str]:
    """Return the terms that a scene does not have; they are not in the code that runs."""
    drag, escapement, regulator = machine.drag, scene.escapement, scene.regulator
    gravity = scene.lies_still or machine.feels_gravity
    return [
        *(() if regulator is None else regulator.left_out()),
        *(drag.left_out() if drag is not None else ('drag',) * (regulator is None)),
        *(('escapement',) if escapement is None else escapement.left_out()),
        *scene.ship.left_out(),
        *(() if gravity else ('apparent gravity',)),
        *(('suspension',) if scene.suspension is None else ()),
        *(() if scene.trochlea is None else scene.trochlea.power.left_out()),
        *(() if scene.clock.is_noisy else ('clock noise',)),
        *(('voyage',) if scene.voyage is None else ()),
    ]
